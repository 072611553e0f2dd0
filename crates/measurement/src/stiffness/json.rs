//! The form in which a stiffness table goes to JSON: units of files and print, `null` with a reason for what is missing.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Serialize, Serializer};

use super::budget::StiffnessEstimate;
use super::budget_row::{BudgetRow, Distribution, EvaluationType, RowUse, UncertaintySource};
use super::curve::{Branches, LoadMean};
use super::estimate::ScatterBasis;
use super::flags::Flag;
use super::line::{LineFit, NoStiffness};
use super::table::{CellStiffness, StiffnessTable};
use stiffbench_numeric::reported::Reported;
use stiffbench_numeric::statistics::Estimate;
use stiffbench_units_and_text::quantity::{
    METRES_PER_MICROMETRE, NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE,
};
use stiffbench_units_and_text::test_point::{Branch, Direction};

#[derive(Serialize, JsonSchema)]
struct TableForm<'a> {
    branches: Branches,
    cells: Vec<CellForm<'a>>,
    pooled_repeat_sd: Option<PooledForm>,
    skipped: Vec<SkippedForm<'a>>,
    left_out: LeftOutForm<'a>,
}

#[derive(Serialize, JsonSchema)]
struct PooledForm {
    mean_um: f64,
    displacement_um: f64,
    #[serde(rename = "force_N")]
    force_n: f64,
    dof: f64,
    /// From which distance a single bad reading that has repeats is found in 80 % of cases, wherever it stands in its run, in the best cell and in the worst; `null` where some would not be found however far off.
    outlier_found_from_um: Option<[f64; 2]>,
}

#[derive(Serialize, JsonSchema)]
struct SkippedForm<'a> {
    pose: &'a str,
    direction: Direction,
    reason: String,
}

#[derive(Serialize, JsonSchema)]
struct LeftOutForm<'a> {
    superseded: usize,
    rejected: usize,
    later_in_step: usize,
    other_branch: usize,
    not_finite_seq: &'a [u32],
}

#[derive(Serialize, JsonSchema)]
struct CellForm<'a> {
    pose: &'a str,
    direction: Direction,
    n_runs: usize,
    n_zeros: usize,
    loads: Vec<LoadForm>,
    stiffness_paper: Reported,
    stiffness_regression: Reported,
    compliance: Reported,
    zero_offset_um: Option<f64>,
    zero_offset: Reported,
    uncertainty_paper: Option<UncertaintyForm>,
    uncertainty_regression: Option<UncertaintyForm>,
    flags: Vec<FlagForm>,
}

#[derive(Serialize, JsonSchema)]
struct LoadForm {
    branch: Branch,
    #[serde(rename = "target_N")]
    target_n: f64,
    mean_um: f64,
    sd_um: Option<f64>,
    n: usize,
    #[serde(rename = "mean_force_N")]
    mean_force_n: f64,
    #[serde(rename = "sd_force_N")]
    sd_force_n: Option<f64>,
}

#[derive(Serialize, JsonSchema)]
struct UncertaintyForm {
    basis: ScatterBasis,
    #[serde(rename = "type_a_N_per_um")]
    type_a: Option<f64>,
    type_a_dof: Option<f64>,
    #[serde(rename = "type_b_N_per_um")]
    type_b: f64,
    ln_independent: Option<f64>,
    ln_force_calibration: f64,
    ln_displacement_calibration: f64,
    budget: Vec<RowForm>,
}

#[derive(Serialize, JsonSchema)]
struct RowForm {
    source: UncertaintySource,
    #[serde(rename = "type")]
    evaluation: EvaluationType,
    distribution: Distribution,
    standing: RowUse,
    standard_uncertainty: Option<f64>,
    unit: &'static str,
    sensitivity: f64,
    sensitivity_unit: &'static str,
    #[serde(rename = "contribution_N_per_um")]
    contribution: f64,
    dof: Option<f64>,
    share_percent: f64,
    note: &'static str,
}

#[derive(Serialize, JsonSchema)]
struct FlagForm {
    rule: &'static str,
    message: String,
    statistic: Option<f64>,
    limit: Option<f64>,
    n_tested: Option<usize>,
    seq: Option<u32>,
}

impl Serialize for StiffnessTable {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        TableForm {
            branches: self.branches,
            cells: self.cells.iter().map(cell_form).collect(),
            pooled_repeat_sd: self.pooled_scatter.map(|pooled| PooledForm {
                mean_um: um(pooled.mean_sd_m),
                displacement_um: um(pooled.displacement_sd_m),
                force_n: pooled.force_sd_n,
                dof: pooled.dof,
                outlier_found_from_um: pooled.smallest_outliers_m.map(|ends| ends.map(um)),
            }),
            skipped: self
                .skipped
                .iter()
                .map(|skipped| SkippedForm {
                    pose: skipped.cell.pose.as_str(),
                    direction: skipped.cell.direction,
                    reason: skipped.reason.to_string(),
                })
                .collect(),
            left_out: LeftOutForm {
                superseded: self.left_out.superseded,
                rejected: self.left_out.rejected,
                later_in_step: self.left_out.later_in_step,
                other_branch: self.left_out.other_branch,
                not_finite_seq: &self.left_out.not_finite,
            },
        }
        .serialize(serializer)
    }
}

impl JsonSchema for StiffnessTable {
    fn schema_name() -> Cow<'static, str> {
        "StiffnessTable".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        TableForm::json_schema(generator)
    }
}

fn um(metres: f64) -> f64 {
    metres / METRES_PER_MICROMETRE
}

fn n_per_um(stiffness_n_per_m: f64) -> f64 {
    stiffness_n_per_m / NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE
}

fn cell_form(row: &CellStiffness) -> CellForm<'_> {
    let of_line = |unit: &'static str, found: fn(&LineFit) -> Estimate| match &row.line {
        Ok(line) => Reported::from_estimate(&found(line), METRES_PER_MICROMETRE, unit),
        Err(reason) => Reported::missing(unit, reason.to_string()),
    };
    CellForm {
        pose: row.cell.pose.as_str(),
        direction: row.cell.direction,
        n_runs: row.n_runs,
        n_zeros: row.n_zeros,
        loads: row.loads.iter().map(load_form).collect(),
        stiffness_paper: reported_stiffness(&row.paper),
        stiffness_regression: reported_stiffness(&row.regression),
        compliance: of_line("um/N", |line| {
            let without = Estimate::without_uncertainty(line.slope_m_per_n);
            line.type_a().map_or(without, |type_a| Estimate {
                standard_uncertainty: type_a.standard_uncertainty,
                dof: type_a.dof,
                ..without
            })
        }),
        zero_offset_um: row.zero_offset_m().map(|offset| um(offset.value)),
        zero_offset: of_line("um", |line| line.zero_offset_m),
        uncertainty_paper: row.paper.as_ref().ok().map(uncertainty_form),
        uncertainty_regression: row.regression.as_ref().ok().map(uncertainty_form),
        flags: row.flags.iter().map(flag_form).collect(),
    }
}

fn load_form(load: &LoadMean) -> LoadForm {
    LoadForm {
        branch: load.branch,
        target_n: load.target_n,
        mean_um: um(load.displacement_m.mean),
        sd_um: load.displacement_m.sd.map(um),
        n: load.n,
        mean_force_n: load.force_n.mean,
        sd_force_n: load.force_n.sd,
    }
}

/// The stiffness in N/µm; where its uncertainty is missing the reason states what the readings lack.
fn reported_stiffness(found: &Result<StiffnessEstimate, NoStiffness>) -> Reported {
    let estimate = match found {
        Ok(estimate) => estimate,
        Err(reason) => return Reported::missing("N/um", reason.to_string()),
    };
    let unit = NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE;
    let mut reported = Reported::from_estimate(&estimate.estimate, unit, "N/um");
    if reported.value.is_some() && reported.expanded_uncertainty.is_none() {
        reported.reason = Some(format!("no uncertainty: {}", estimate.basis));
    }
    reported
}

fn uncertainty_form(estimate: &StiffnessEstimate) -> UncertaintyForm {
    UncertaintyForm {
        basis: estimate.basis,
        type_a: estimate.type_a.map(|a| n_per_um(a.standard_uncertainty)),
        type_a_dof: estimate.type_a.map(|a| a.dof),
        type_b: n_per_um(estimate.type_b_n_per_m),
        ln_independent: estimate.ln_parts.independent,
        ln_force_calibration: estimate.ln_parts.force_calibration,
        ln_displacement_calibration: estimate.ln_parts.displacement_calibration,
        budget: estimate.budget.rows.iter().map(row_form).collect(),
    }
}

fn row_form(row: &BudgetRow) -> RowForm {
    let (factor, unit, sensitivity_unit) = match row.unit {
        "m" => (METRES_PER_MICROMETRE, "um", "(N/um)/um"),
        "m/N" => (METRES_PER_MICROMETRE, "um/N", "(N/um)/(um/N)"),
        "N/m" => (NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE, "N/um", "1"),
        other => (1.0, other, "(N/um)/N"),
    };
    RowForm {
        source: row.source,
        evaluation: row.evaluation,
        distribution: row.distribution,
        standing: row.standing,
        standard_uncertainty: row.standard_uncertainty.map(|u| u / factor),
        unit,
        sensitivity: n_per_um(row.sensitivity * factor),
        sensitivity_unit,
        contribution: n_per_um(row.contribution_n_per_m),
        dof: row.dof.is_finite().then_some(row.dof),
        share_percent: row.share_percent,
        note: row.note,
    }
}

fn flag_form(flag: &Flag) -> FlagForm {
    let test = flag.test();
    FlagForm {
        rule: flag.rule(),
        message: flag.to_string(),
        statistic: test.map(|test| test.statistic),
        limit: test.map(|test| test.limit),
        n_tested: test.map(|test| test.n_tested),
        seq: match flag {
            Flag::Outlier { place, .. } => Some(place.seq),
            _ => None,
        },
    }
}

#[cfg(test)]
mod tests {
    use crate::readings::Reading;
    use crate::stiffness::sample::{SimulatedBench, reading};
    use crate::stiffness::{GaugePair, GaugeTerms, StiffnessOptions, stiffness_table};
    use serde_json::Value;

    fn json(readings: &[Reading]) -> Value {
        let gauges = GaugePair {
            force: GaugeTerms::new(Some(0.1), Some(0.15), Some(2.0)).unwrap(),
            ..GaugePair::default()
        };
        let table = stiffness_table(readings, &gauges, StiffnessOptions::default());
        serde_json::to_value(&table).unwrap()
    }

    #[test]
    fn a_cell_has_the_keys_and_units_of_the_contract() {
        let found = json(&SimulatedBench::paper(2, 1).readings());
        let row = &found["cells"][0];
        assert_eq!(
            (&row["pose"], &row["direction"]),
            (&"P1".into(), &"x".into())
        );
        assert_eq!(row["n_runs"], 5);
        let load = &row["loads"][3];
        assert_eq!(
            (&load["target_N"], &load["n"]),
            (&(-30.0).into(), &5.into())
        );
        assert!((load["mean_um"].as_f64().unwrap() + 600.0).abs() < 30.0);
        assert!(load["sd_um"].as_f64().unwrap() > 0.0);
        for key in ["stiffness_paper", "stiffness_regression"] {
            let stiffness = &row[key];
            assert!((stiffness["value"].as_f64().unwrap() - 0.05).abs() < 0.002);
            assert_eq!(stiffness["unit"], "N/um");
            for key in ["u", "k", "dof"] {
                assert!(stiffness[key].as_f64().unwrap() > 0.0, "{key}");
            }
        }
        assert!(row["zero_offset_um"].as_f64().unwrap().abs() < 20.0);
        assert_eq!(row["zero_offset"]["unit"], "um");
        assert!((row["compliance"]["value"].as_f64().unwrap() - 20.0).abs() < 0.5);
        let budget = row["uncertainty_regression"]["budget"].as_array().unwrap();
        assert_eq!(budget[0]["source"], "repeatability");
        for row in budget.iter().filter(|row| row["standing"] == "counted") {
            // Contribution = sensitivity times standard uncertainty, in the units printed.
            let number = |key: &str| row[key].as_f64().unwrap();
            let product = number("sensitivity") * number("standard_uncertainty");
            assert!((product / number("contribution_N_per_um") - 1.0).abs() < 1e-9);
        }
        assert_eq!(budget[4]["note"], "calibration not stated");
    }

    #[test]
    fn what_is_missing_is_null_with_its_reason() {
        let found = json(&[reading(1, 0, -10.0, -10.0, 0.0)]);
        let row = &found["cells"][0];
        assert_eq!(row["stiffness_paper"]["value"], Value::Null);
        let reason = row["stiffness_paper"]["reason"].as_str().unwrap();
        assert!(reason.contains("-10 N"), "{reason}");
        let reason = row["stiffness_regression"]["reason"].as_str().unwrap();
        assert!(reason.contains("at one load"), "{reason}");
        assert_eq!(row["zero_offset_um"], Value::Null);
        assert_eq!(row["loads"][0]["sd_um"], Value::Null);
        assert_eq!(found["pooled_repeat_sd"], Value::Null);

        let found = json(&[
            reading(1, 0, 0.0, 0.0, 0.0),
            reading(1, 1, -10.0, -10.0, -2e-4),
        ]);
        let stiffness = &found["cells"][0]["stiffness_regression"];
        assert!((stiffness["value"].as_f64().unwrap() - 0.05).abs() < 1e-12);
        assert!(
            stiffness["reason"]
                .as_str()
                .unwrap()
                .contains("repeatability unknown")
        );
    }
}
