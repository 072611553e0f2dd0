//! A diagnosis of a table without a robot, in the units of the table.

use std::fmt::Write;

use serde_json::{Value, json};

use crate::mismatch::{Diagnosis, Finding, Quality, SpecimenScale, Verdict};
use crate::physics::{Dimension, Law, ParameterSpec};
use crate::specimen::{ColumnScale, SpecimenTable};

use super::text::AlignedTable;

/// Chance below which something is left over: the level of the omnibus test.
const LEFT_OVER: f64 = 0.01;

/// What is said of a table.
#[derive(Debug, Clone, Copy)]
pub struct SpecimenReport<'a> {
    /// The table.
    pub table: &'a SpecimenTable,
    /// What the scaled units of the diagnosis are in the table.
    pub scale: &'a SpecimenScale,
    /// The diagnosis.
    pub diagnosis: &'a Diagnosis,
    /// Seed of the limits' draws.
    pub seed: u64,
}

impl SpecimenReport<'_> {
    /// Unit of loads and of answers.
    fn units(&self) -> (&'static str, &'static str) {
        let unit =
            |scale: ColumnScale, si: &'static str| if scale == ColumnScale::Si { si } else { "1" };
        let force = unit(self.table.force_scale, "N");
        let displacement = unit(self.table.displacement_scale, "m");
        match self.table.response {
            crate::specimen::ResponseVariable::Displacement => (force, displacement),
            crate::specimen::ResponseVariable::Force => (displacement, force),
        }
    }

    /// Factor from the diagnosis to the table, and unit, of each parameter of a law.
    fn parameters(&self, law: Law) -> Vec<(&'static str, f64, String)> {
        let (load, answer) = (self.scale.load, self.scale.answer);
        let (load_unit, answer_unit) = self.units();
        let time = if self.scale.order_is_clock {
            "reading"
        } else {
            "s"
        };
        let parameter = |parameter: &ParameterSpec| {
            let Some([of_answer, of_load, of_time]) = parameter.dimension.powers() else {
                return (parameter.name, 1.0, parameter.unit().to_owned());
            };
            let factor = answer.powi(of_answer.into()) * load.powi(of_load.into());
            let unit = match (of_answer, of_load, of_time) {
                (1, 0, 0) if parameter.dimension == Dimension::LengthPerTemperature => {
                    format!("{answer_unit}/K")
                }
                (1, 0, 0) => answer_unit.to_owned(),
                (0, 1, 0) => load_unit.to_owned(),
                (0, -1, 0) => format!("1/{load_unit}"),
                (1, -1, 0) => format!("{answer_unit}/{load_unit}"),
                (1, _, 0) => format!("{answer_unit}/({load_unit})^{}", -of_load),
                _ => format!("{answer_unit}/{time}"),
            };
            (parameter.name, factor, unit)
        };
        law.parameters.iter().map(parameter).collect()
    }
}

/// The diagnosis of a table as JSON.
#[must_use]
pub fn specimen_json(report: &SpecimenReport<'_>) -> Value {
    let diagnosis = report.diagnosis;
    let (load_unit, answer_unit) = report.units();
    let rms = |value: f64| json!({ "value": value * report.scale.answer, "unit": answer_unit });
    let quality = |quality: &Quality| json!({ "rms": rms(quality.rms_m), "reduced_chi2": quality.reduced_chi2 });
    json!({
        "verdict": diagnosis.verdict.name(),
        "lacking": diagnosis.lacking,
        "findings": diagnosis.findings.iter().map(|finding| finding_json(report, finding)).collect::<Vec<_>>(),
        "left_over": { "stratum": diagnosis.unexplained.stratum.name(), "p": diagnosis.unexplained.p_family },
        "before": quality(&diagnosis.before),
        "after": quality(&diagnosis.after),
        "slopes": diagnosis.factors.iter().map(|slope| json!({
            "name": slope.name,
            "before": slope.before.value * report.scale.answer / report.scale.load,
            "after": slope.after.value * report.scale.answer / report.scale.load,
            "unit": format!("{answer_unit}/{load_unit}"),
        })).collect::<Vec<_>>(),
        "noise": {
            "reading_sd": rms(diagnosis.noise.reading_sd_m),
            "run_slope_sd": diagnosis.noise.run_slope_sd,
        },
        "next_measurement": [],
        "readings": report.table.readings.len(),
        "order_is_clock": report.scale.order_is_clock,
        "seed": report.seed,
        "version": env!("CARGO_PKG_VERSION"),
    })
}

fn finding_json(report: &SpecimenReport<'_>, finding: &Finding) -> Value {
    let mut parameters = serde_json::Map::new();
    for ((name, factor, unit), value) in report
        .parameters(finding.effect.law)
        .into_iter()
        .zip(&finding.values)
    {
        let interval = value
            .interval_95()
            .map(|ends| ends.map(|end| end * factor))
            .filter(|ends| ends.iter().all(|end| end.is_finite()));
        parameters.insert(
            name.to_owned(),
            json!({ "value": value.value * factor, "unit": unit, "ci95": interval }),
        );
    }
    json!({
        "physics": finding.effect.law.name,
        "place": finding.effect.place.to_json(),
        "parameters": parameters,
        "alternative_group": finding.alternative_group,
        "end_effect": finding.end_effect_m * report.scale.answer,
        "absorbed_share": finding.absorbed_share,
        "log_bayes_factor": finding.log_bayes,
        "p_family": finding.p_family,
        "rivals": finding.rivals.iter().map(|rival| json!({
            "physics": rival.effect.law.name,
            "place": rival.effect.place.to_json(),
            "log_bayes_factor_to_winner": rival.log_bayes_to_winner,
            "cosine": rival.cosine,
        })).collect::<Vec<_>>(),
    })
}

/// The diagnosis of a table in words.
#[must_use]
pub fn specimen_text(report: &SpecimenReport<'_>) -> String {
    let diagnosis = report.diagnosis;
    let mut text = format!("{}\n", headline(report));
    for lack in &diagnosis.lacking {
        let _ = writeln!(text, "- lacking: {lack}");
    }
    if !diagnosis.findings.is_empty() {
        text.push('\n');
        text.push_str(&findings_table(report));
    }
    let about_line = |quality: &Quality| {
        let unit = match report.units().1 {
            "1" => String::new(),
            unit => format!(" {unit}"),
        };
        // Where something is left over, the noise was estimated from it too, and is no unit for it.
        let in_noise = if diagnosis.unexplained.p_family < LEFT_OVER {
            String::new()
        } else {
            format!(", {:.2} in units of the noise", quality.reduced_chi2.sqrt())
        };
        format!(
            "{:.4e}{unit}{in_noise}",
            quality.rms_m * report.scale.answer
        )
    };
    let _ = writeln!(
        text,
        "\nRoot mean square about the line: {}.",
        about_line(&diagnosis.before)
    );
    if !diagnosis.findings.is_empty() {
        let _ = writeln!(
            text,
            "With what is named: {}.",
            about_line(&diagnosis.after)
        );
    }
    let _ = writeln!(
        text,
        "What is left would be seen in {} of tables with noise alone (largest in {}).",
        share_of_tables(diagnosis.unexplained.p_family),
        diagnosis.unexplained.stratum.name()
    );
    if report.scale.order_is_clock {
        text.push_str("There is no time column: the order of the readings is used as time.\n");
    }
    text
}

/// A share with two decimals, or its bound where these would be zero.
fn share_of_tables(share: f64) -> String {
    if share < 1e-4 {
        "fewer than 0.01 %".to_owned()
    } else {
        format!("{:.2} %", 100.0 * share)
    }
}

fn headline(report: &SpecimenReport<'_>) -> String {
    let diagnosis = report.diagnosis;
    let titles = || {
        let all: Vec<String> = diagnosis
            .findings
            .iter()
            .map(|finding| finding.effect.title())
            .collect();
        all.join(", ")
    };
    match diagnosis.verdict {
        Verdict::Explained => format!("A straight line is not enough: {}.", titles()),
        Verdict::Ambiguous => format!(
            "A straight line is not enough, and these cannot all be distinguished: {}.",
            titles()
        ),
        Verdict::Unknown if diagnosis.findings.is_empty() => {
            "Something is missing that no law of the library explains.".to_owned()
        }
        Verdict::Unknown => format!(
            "Something is missing that no law of the library explains; a part of it looks like: {}.",
            titles()
        ),
        Verdict::NothingMissing => {
            "Nothing is missing: a straight line a configuration serves.".to_owned()
        }
        Verdict::InsufficientData => "These readings cannot decide.".to_owned(),
    }
}

fn findings_table(report: &SpecimenReport<'_>) -> String {
    let mut table = AlignedTable::new(&[
        "law",
        "parameter",
        "value",
        "95 % interval",
        "unit",
        "log Bayes factor",
    ]);
    for finding in &report.diagnosis.findings {
        let rows = report
            .parameters(finding.effect.law)
            .into_iter()
            .zip(&finding.values);
        for ((name, factor, unit), value) in rows {
            let interval = value.interval_95().map_or_else(String::new, |[low, high]| {
                format!("{:.4e} to {:.4e}", low * factor, high * factor)
            });
            table.row(vec![
                finding.effect.title(),
                name.to_owned(),
                format!("{:.5e}", value.value * factor),
                interval,
                unit,
                format!("{:.1}", finding.log_bayes),
            ]);
        }
    }
    table.text()
}
