//! Measured stiffness as a result: units of files and print, `null` with a reason for what is missing.

use std::borrow::Cow;

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Deserialize, Serialize, Serializer};

use super::budget::StiffnessEstimate;
use super::budget_row::{BudgetRow, Distribution, EvaluationType, RowUse, UncertaintySource};
use super::curve::{Branches, LoadMean};
use super::estimate::ScatterBasis;
use super::flags::Flag;
use super::hysteresis_report::HysteresisReport;
use super::line::{LineFit, NoStiffness};
use super::straight_part::StraightPart;
use super::table::{CellStiffness, StiffnessTable};
use stiffbench_numeric::reported::Reported;
use stiffbench_numeric::statistics::Estimate;
use stiffbench_units_and_text::quantity::{
    METRES_PER_MICROMETRE, NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE,
};
use stiffbench_units_and_text::test_point::{Branch, Direction, PoseId};

/// Measured stiffness as results state it, in units of files and print.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StiffnessReport {
    /// The branches used.
    pub branches: Branches,
    /// Cells in the order in which they first appear.
    pub cells: Vec<StiffnessCellReport>,
    /// Scatter of single readings over all cells; `null` without repeats.
    pub pooled_repeat_sd: Option<PooledScatterReport>,
    /// Cells without stiffness.
    pub skipped: Vec<SkippedCellReport>,
    /// Readings left out.
    pub left_out: LeftOutReport,
}

/// Scatter of single readings over all cells.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PooledScatterReport {
    /// Standard deviation of the mean of a run.
    pub mean_um: f64,
    /// Standard deviation of a displacement.
    pub displacement_um: f64,
    /// Standard deviation of a force.
    #[serde(rename = "force_N")]
    pub force_n: f64,
    /// Their degrees of freedom.
    pub dof: f64,
    /// From which distance a single bad reading that has repeats is found in 80 % of cases, wherever it stands in its run, in the best cell and in the worst; `null` where some would not be found however far off.
    pub outlier_found_from_um: Option<[f64; 2]>,
}

/// A cell without stiffness.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SkippedCellReport {
    /// The pose.
    pub pose: PoseId,
    /// The direction.
    pub direction: Direction,
    /// Why.
    pub reason: String,
}

/// Numbers of readings left out.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct LeftOutReport {
    /// Replaced by a later one.
    pub superseded: usize,
    /// Rejected by the operator.
    pub rejected: usize,
    /// Later ones of one load step.
    pub later_in_step: usize,
    /// Of another branch.
    pub other_branch: usize,
    /// Sequence numbers of those that are no finite numbers.
    pub not_finite_seq: Vec<u32>,
}

/// Stiffness of one cell.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StiffnessCellReport {
    /// The pose.
    pub pose: PoseId,
    /// The direction.
    pub direction: Direction,
    /// Number of runs.
    pub n_runs: usize,
    /// Number of gauge zeros.
    pub n_zeros: usize,
    /// Mean readings by load.
    pub loads: Vec<LoadMeanReport>,
    /// Mean of force over displacement.
    pub stiffness_paper: Reported,
    /// Inverse slope of displacement on force.
    pub stiffness_regression: Reported,
    /// Slope of displacement on force.
    pub compliance: Reported,
    /// Displacement of the line without load.
    pub zero_offset_um: Option<f64>,
    /// The same with its uncertainty.
    pub zero_offset: Reported,
    /// Where the uncertainty of `stiffness_paper` comes from.
    pub uncertainty_paper: Option<UncertaintyReport>,
    /// Where the uncertainty of `stiffness_regression` comes from.
    pub uncertainty_regression: Option<UncertaintyReport>,
    /// What looks wrong.
    pub flags: Vec<FlagReport>,
    /// The loads that lie on a straight line, where repeats show that not all of them do.
    pub straight_part: Option<StraightPartReport>,
    /// The loop between loading and unloading; not there where no load was read in both branches.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hysteresis: Option<HysteresisReport>,
}

/// Stiffness of a part of the loads, chosen after the curve was seen.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct StraightPartReport {
    /// The smallest of its loads.
    #[serde(rename = "from_N")]
    pub from_n: f64,
    /// The largest.
    #[serde(rename = "to_N")]
    pub to_n: f64,
    /// Inverse slope of displacement on force over these loads.
    pub stiffness: Reported,
}

/// Mean readings of one load.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LoadMeanReport {
    /// The branch.
    pub branch: Branch,
    /// Target force.
    #[serde(rename = "target_N")]
    pub target_n: f64,
    /// Mean displacement.
    pub mean_um: f64,
    /// Its standard deviation.
    pub sd_um: Option<f64>,
    /// Number of readings.
    pub n: usize,
    /// Mean force.
    #[serde(rename = "mean_force_N")]
    pub mean_force_n: f64,
    /// Its standard deviation.
    #[serde(rename = "sd_force_N")]
    pub sd_force_n: Option<f64>,
}

/// Where the uncertainty of a stiffness comes from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct UncertaintyReport {
    /// The scatter behind type A.
    pub basis: ScatterBasis,
    /// Type A part of the standard uncertainty.
    #[serde(rename = "type_a_N_per_um")]
    pub type_a: Option<f64>,
    /// Its degrees of freedom.
    pub type_a_dof: Option<f64>,
    /// Type B part of the standard uncertainty.
    #[serde(rename = "type_b_N_per_um")]
    pub type_b: f64,
    /// Part of the uncertainty of ln K that is the cell's own.
    pub ln_independent: Option<f64>,
    /// Part that all cells share through the force gauge.
    pub ln_force_calibration: f64,
    /// Part that all cells share through the displacement gauge.
    pub ln_displacement_calibration: f64,
    /// Every source.
    pub budget: Vec<BudgetRowReport>,
}

/// A source of uncertainty.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct BudgetRowReport {
    /// The source.
    pub source: UncertaintySource,
    /// Type A or B.
    #[serde(rename = "type")]
    pub evaluation: EvaluationType,
    /// Its distribution.
    pub distribution: Distribution,
    /// Whether it counts, and why not.
    pub standing: RowUse,
    /// Standard uncertainty in `unit`.
    pub standard_uncertainty: Option<f64>,
    /// Its unit.
    pub unit: Cow<'static, str>,
    /// Change of the stiffness with the quantity, in `sensitivity_unit`.
    pub sensitivity: f64,
    /// Its unit.
    pub sensitivity_unit: Cow<'static, str>,
    /// Contribution to the standard uncertainty of the stiffness.
    #[serde(rename = "contribution_N_per_um")]
    pub contribution: f64,
    /// Degrees of freedom; `null` where they have no limit.
    pub dof: Option<f64>,
    /// Share of the variance.
    pub share_percent: f64,
    /// What is to be known of it.
    pub note: Cow<'static, str>,
}

/// Something that looks wrong.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FlagReport {
    /// The rule that the readings break.
    pub rule: Cow<'static, str>,
    /// What was found.
    pub message: String,
    /// The test statistic.
    pub statistic: Option<f64>,
    /// Its critical value.
    pub limit: Option<f64>,
    /// Number of values tested.
    pub n_tested: Option<usize>,
    /// Sequence number of the reading.
    pub seq: Option<u32>,
}

impl From<&StiffnessTable> for StiffnessReport {
    fn from(table: &StiffnessTable) -> Self {
        let skipped = table.skipped.iter().map(|skipped| SkippedCellReport {
            pose: skipped.cell.pose.clone(),
            direction: skipped.cell.direction,
            reason: skipped.reason.to_string(),
        });
        Self {
            branches: table.branches,
            cells: table.cells.iter().map(Into::into).collect(),
            pooled_repeat_sd: table.pooled_scatter.map(|pooled| PooledScatterReport {
                mean_um: um(pooled.mean_sd_m),
                displacement_um: um(pooled.displacement_sd_m),
                force_n: pooled.force_sd_n,
                dof: pooled.dof,
                outlier_found_from_um: pooled.smallest_outliers_m.map(|ends| ends.map(um)),
            }),
            skipped: skipped.collect(),
            left_out: LeftOutReport {
                superseded: table.left_out.superseded,
                rejected: table.left_out.rejected,
                later_in_step: table.left_out.later_in_step,
                other_branch: table.left_out.other_branch,
                not_finite_seq: table.left_out.not_finite.clone(),
            },
        }
    }
}

/// As its report.
impl Serialize for StiffnessTable {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        StiffnessReport::from(self).serialize(serializer)
    }
}

impl JsonSchema for StiffnessTable {
    fn schema_name() -> Cow<'static, str> {
        StiffnessReport::schema_name()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        StiffnessReport::json_schema(generator)
    }
}

fn um(metres: f64) -> f64 {
    metres / METRES_PER_MICROMETRE
}

fn n_per_um(stiffness_n_per_m: f64) -> f64 {
    stiffness_n_per_m / NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE
}

impl From<&CellStiffness> for StiffnessCellReport {
    fn from(row: &CellStiffness) -> Self {
        let of_line = |unit: &'static str, found: fn(&LineFit) -> Estimate| match &row.line {
            Ok(line) => Reported::from_estimate(&found(line), METRES_PER_MICROMETRE, unit),
            Err(reason) => Reported::missing(unit, reason.to_string()),
        };
        Self {
            pose: row.cell.pose.clone(),
            direction: row.cell.direction,
            n_runs: row.n_runs,
            n_zeros: row.n_zeros,
            loads: row.loads.iter().map(Into::into).collect(),
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
            uncertainty_paper: row.paper.as_ref().ok().map(Into::into),
            uncertainty_regression: row.regression.as_ref().ok().map(Into::into),
            flags: row.flags.iter().map(Into::into).collect(),
            straight_part: row
                .flags
                .iter()
                .find_map(|flag| flag.straight_part.as_ref())
                .map(Into::into),
            hysteresis: row.hysteresis_report(),
        }
    }
}

impl CellStiffness {
    /// The loop between loading and unloading in units of files and print; `None` if no load was read in both.
    #[must_use]
    pub fn hysteresis_report(&self) -> Option<HysteresisReport> {
        let branches = self.branches.each_ref().map(reported_stiffness);
        let found = self.hysteresis.as_ref()?;
        Some(HysteresisReport::new(found, branches))
    }
}

impl From<&StraightPart> for StraightPartReport {
    fn from(part: &StraightPart) -> Self {
        let unit = NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE;
        Self {
            from_n: part.ends_n[0],
            to_n: part.ends_n[1],
            stiffness: Reported::from_estimate(&part.stiffness, unit, "N/um"),
        }
    }
}

impl From<&LoadMean> for LoadMeanReport {
    fn from(load: &LoadMean) -> Self {
        Self {
            branch: load.branch,
            target_n: load.target_n,
            mean_um: um(load.displacement_m.mean),
            sd_um: load.displacement_m.sd.map(um),
            n: load.n,
            mean_force_n: load.force_n.mean,
            sd_force_n: load.force_n.sd,
        }
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

impl From<&StiffnessEstimate> for UncertaintyReport {
    fn from(estimate: &StiffnessEstimate) -> Self {
        Self {
            basis: estimate.basis,
            type_a: estimate.type_a.map(|a| n_per_um(a.standard_uncertainty)),
            type_a_dof: estimate.type_a.map(|a| a.dof),
            type_b: n_per_um(estimate.type_b_n_per_m),
            ln_independent: estimate.ln_parts.independent,
            ln_force_calibration: estimate.ln_parts.force_calibration,
            ln_displacement_calibration: estimate.ln_parts.displacement_calibration,
            budget: estimate.budget.rows.iter().map(Into::into).collect(),
        }
    }
}

impl From<&BudgetRow> for BudgetRowReport {
    fn from(row: &BudgetRow) -> Self {
        let (factor, unit, sensitivity_unit) = match row.unit {
            "m" => (METRES_PER_MICROMETRE, "um", "(N/um)/um"),
            "m/N" => (METRES_PER_MICROMETRE, "um/N", "(N/um)/(um/N)"),
            "N/m" => (NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE, "N/um", "1"),
            other => (1.0, other, "(N/um)/N"),
        };
        Self {
            source: row.source,
            evaluation: row.evaluation,
            distribution: row.distribution,
            standing: row.standing,
            standard_uncertainty: row.standard_uncertainty.map(|u| u / factor),
            unit: unit.into(),
            sensitivity: n_per_um(row.sensitivity * factor),
            sensitivity_unit: sensitivity_unit.into(),
            contribution: n_per_um(row.contribution_n_per_m),
            dof: row.dof.is_finite().then_some(row.dof),
            share_percent: row.share_percent,
            note: row.note.into(),
        }
    }
}

impl From<&Flag> for FlagReport {
    fn from(flag: &Flag) -> Self {
        let test = flag.test;
        Self {
            rule: flag.rule.into(),
            message: flag.message.clone(),
            statistic: test.map(|test| test.statistic),
            limit: test.map(|test| test.limit),
            n_tested: test.map(|test| test.n_tested),
            seq: flag.reading.map(|reading| reading.seq),
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::readings::Reading;
    use crate::stiffness::sample::{SimulatedBench, reading};
    use crate::stiffness::{
        GaugePair, GaugeTerms, StiffnessOptions, StiffnessReport, stiffness_table,
    };
    use serde_json::Value;

    fn json(readings: &[Reading]) -> Value {
        let gauges = GaugePair {
            force: GaugeTerms::new(Some(0.1), Some(0.15), Some(2.0)).unwrap(),
            ..GaugePair::default()
        };
        let table = stiffness_table(readings, &gauges, StiffnessOptions::default());
        serde_json::to_value(StiffnessReport::from(&table)).unwrap()
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
