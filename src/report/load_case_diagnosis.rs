//! A diagnosis of load cases for people and for programs.

use std::fmt::Write;

use schemars::JsonSchema;
use serde::Serialize;

use crate::elastostatics::{
    BadLoadCaseValue, ImplausibleSize, LoadCaseDiagnosis, LoadCaseFinding, LoadCaseUnexplained,
    TableMistake,
};
use crate::mismatch::{Verdict, VerdictGrade};

use super::bad_load_case_values::{bad_load_case_value_words, table_mistake_words};
use super::load_case_fit::LoadCaseFitReport;
use super::text::{
    AlignedTable, digits, micro, share_of_tables, significant, table_of, unit_behind,
};
use crate::count::counted;

/// A diagnosis of load cases.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct LoadCaseDiagnosisReport {
    /// The verdict.
    pub verdict: Verdict,
    /// How far it may be relied on.
    pub grade: VerdictGrade,
    /// The verdict in a sentence.
    pub headline: String,
    /// Values that contradict others, and were left out.
    pub bad_values: Vec<BadLoadCaseValue>,
    /// Readings that seem to have another unit or sign; `null` for none.
    #[serde(rename = "wrong_factor")]
    pub table_mistake: Option<TableMistake>,
    /// What the load cases lack, where they cannot decide.
    pub lacking: Vec<String>,
    /// Names of the laws that were not tested: load cases do not show them.
    pub not_tested: Vec<&'static str>,
    /// What is missing; with the verdict `unknown` what explains part of it.
    pub findings: Vec<LoadCaseFinding>,
    /// Chance that noise alone gives any candidate as much as the first finding, or as the best candidate if there is none.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub p_family: f64,
    /// What the final model leaves; `null` where the load cases cannot decide.
    #[serde(rename = "left_over")]
    pub unexplained: Option<LoadCaseUnexplained>,
    /// Share of the misfit that the findings explain; `null` where too little misfit is visible.
    pub share_of_misfit: Option<f64>,
    /// The same in poses left out in turn.
    pub share_unseen: Option<f64>,
    /// Root mean squares of the residual displacements.
    pub rms: DiagnosisErrors,
    /// Values of the free parameters beside the findings, in the unit of the baseline.
    pub parameters_after: Vec<ParameterAfter>,
    /// How many candidates were tried.
    pub candidates: usize,
    /// `repeats` or `residuals`.
    pub scatter_from: &'static str,
    /// The fit without the findings.
    pub baseline: LoadCaseFitReport,
    /// Seed of the simulated noise.
    pub seed: u64,
    /// Version of the program.
    pub version: &'static str,
}

/// A parameter with its value beside the findings.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ParameterAfter {
    /// Its name.
    pub name: String,
    /// Its value.
    pub value: f64,
}

/// Root mean squares of the residual displacements, µm.
#[derive(Debug, Clone, Copy, Serialize, JsonSchema)]
pub struct DiagnosisErrors {
    /// Of the baseline.
    pub before_um: Option<f64>,
    /// Of the final model.
    pub after_um: f64,
    /// Of the baseline in poses left out in turn.
    pub before_unseen_um: Option<f64>,
    /// Of the final model in poses left out in turn.
    pub after_unseen_um: Option<f64>,
}

impl LoadCaseDiagnosisReport {
    /// The diagnosis as it is printed and written.
    #[must_use]
    pub fn new(diagnosis: &LoadCaseDiagnosis, seed: u64) -> Self {
        Self {
            verdict: diagnosis.verdict,
            grade: diagnosis.grade,
            headline: headline(diagnosis),
            bad_values: diagnosis.bad_values.clone(),
            table_mistake: diagnosis.table_mistake.clone(),
            lacking: diagnosis.lacking.clone(),
            not_tested: diagnosis.not_tested.clone(),
            findings: diagnosis.findings.clone(),
            p_family: diagnosis.p_family,
            unexplained: diagnosis.unexplained.clone(),
            share_of_misfit: diagnosis.share_of_misfit,
            share_unseen: diagnosis.share_unseen,
            rms: DiagnosisErrors {
                before_um: diagnosis.baseline.rms_m()[1].map(micro),
                after_um: micro(diagnosis.after_m),
                before_unseen_um: diagnosis.before_unseen_m.map(micro),
                after_unseen_um: diagnosis.after_unseen_m.map(micro),
            },
            parameters_after: diagnosis
                .parameters_after
                .iter()
                .map(|(name, value)| ParameterAfter {
                    name: name.clone(),
                    value: *value,
                })
                .collect(),
            candidates: diagnosis.candidates,
            scatter_from: if diagnosis.from_repeats {
                "repeats"
            } else {
                "residuals"
            },
            baseline: LoadCaseFitReport::new(&diagnosis.baseline, Vec::new()),
            seed,
            version: env!("CARGO_PKG_VERSION"),
        }
    }

    /// The diagnosis that it states, for people.
    #[must_use]
    pub fn text(&self, diagnosis: &LoadCaseDiagnosis) -> String {
        let mut text = format!("{}\n", self.headline);
        for lack in &self.lacking {
            let _ = writeln!(text, "- lacking: {lack}");
        }
        if !self.findings.is_empty() {
            let _ = write!(text, "\n{}", self.findings_table());
            let sets: String = self.findings.iter().map(sets).collect();
            if !sets.is_empty() {
                let _ = write!(text, "\n{sets}");
            }
        }
        let um = |value| digits(value, 4);
        let rms = &self.rms;
        let mut errors = AlignedTable::new(&[
            "residual displacement, rms",
            "fitted, um",
            "poses left out, um",
        ]);
        errors.row([
            "free parameters alone".to_owned(),
            um(rms.before_um),
            um(rms.before_unseen_um),
        ]);
        if !self.findings.is_empty() {
            errors.row([
                "with what is named".to_owned(),
                um(Some(rms.after_um)),
                um(rms.after_unseen_um),
            ]);
        }
        let _ = write!(text, "\n{}", errors.text());
        let percent = |share: Option<f64>| share.map(|share| format!("{:.0} %", 100.0 * share));
        let share = percent(self.share_of_misfit).filter(|_| !self.findings.is_empty());
        if let Some(share) = share {
            let unseen = percent(self.share_unseen).map_or_else(String::new, |unseen| {
                format!(", {unseen} of it in poses left out")
            });
            let _ = writeln!(
                text,
                "\nWhat is named explains {share} of the misfit{unseen}."
            );
        }
        if let Some(left) = &self.unexplained {
            let _ = writeln!(
                text,
                "Noise alone leaves as much structure in {} of such tables (test: {}).\nLargest residual: pose {}, {}: {} {} ({:.1} standard errors).",
                share_of_tables(left.p),
                left.test,
                left.pose,
                left.component,
                significant(micro(left.size), 3),
                left.unit,
                left.standard_errors
            );
        }
        let implausible = diagnosis.implausible.iter();
        let implausible: Vec<String> = implausible.map(implausible_words).collect();
        if !implausible.is_empty() {
            let _ = writeln!(
                text,
                "No explanation, because the size would be implausible: {}.",
                implausible.join(", ")
            );
        }
        if diagnosis.taken_back > 0 && !self.findings.is_empty() {
            let _ = writeln!(
                text,
                "Not named: {} that fit a part, but lower the error in poses left out no further or are more than three.",
                counted(diagnosis.taken_back, "further candidate")
            );
        }
        let _ = writeln!(
            text,
            "\n{} candidates were tried beside the free parameters; the scatter is that of the {}.\nLaws not tested: {}.",
            self.candidates,
            self.scatter_from,
            self.not_tested.join(", ")
        );
        text
    }

    fn findings_table(&self) -> String {
        let end = |value: f64| {
            if value.is_finite() {
                significant(value, 3)
            } else {
                "infinite".to_owned()
            }
        };
        table_of(
            &self.findings,
            &[
                ("finding", &|one| one.name.clone()),
                ("law", &|one| one.law.to_owned()),
                ("size", &|one| significant(one.value, 3)),
                ("95 % interval", &|one| {
                    one.interval_95.map(end).join(" to ")
                }),
                ("unit", &|one| one.unit.to_owned()),
                ("largest effect, um", &|one| {
                    significant(micro(one.end_effect_m), 3)
                }),
                ("standard errors", &|one| {
                    format!("{:.1}", one.standard_errors)
                }),
                ("log Bayes factor", &|one| format!("{:.1}", one.log_bayes)),
            ],
        )
    }
}

/// What cannot be distinguished from a finding, as a sentence.
fn sets(finding: &LoadCaseFinding) -> String {
    if finding.alternatives.is_empty() {
        return String::new();
    }
    let alternatives = finding.alternatives.iter();
    let names: Vec<String> = alternatives
        .map(|rival| format!("{} ({})", rival.name, rival.place))
        .collect();
    format!(
        "These poses do not distinguish {} from {}.\n",
        finding.name,
        names.join(", ")
    )
}

/// What a rejected candidate would have to be, and what is plausible.
fn implausible_words(one: &ImplausibleSize) -> String {
    let [lowest, highest] = one.bounds.map(|end| significant(end, 2));
    let unit = unit_behind(one.unit);
    format!(
        "{} {}{unit} (plausible: {lowest} to {highest})",
        one.name,
        significant(one.value, 3)
    )
}

/// The verdict in a sentence, after the values that are to be clarified first.
fn headline(diagnosis: &LoadCaseDiagnosis) -> String {
    let bad = &diagnosis.bad_values;
    let mut words: Vec<String> = bad.iter().map(bad_load_case_value_words).collect();
    words.extend(diagnosis.table_mistake.as_ref().map(table_mistake_words));
    if words.is_empty() {
        return verdict_words(diagnosis);
    }
    let without = match bad.len() {
        0 => "As the table stands",
        1 => "Without this value",
        _ => "Without these values",
    };
    let words = words.join("; ");
    let end = if words.ends_with('?') { "" } else { "." };
    format!(
        "To be clarified first: {words}{end} {without}: {}",
        verdict_words(diagnosis)
    )
}

/// The verdict, what its scatter rests on, and what was not tested.
fn verdict_words(diagnosis: &LoadCaseDiagnosis) -> String {
    let found = found_words(diagnosis);
    if diagnosis.candidates == 0 {
        return found;
    }
    let scatter = if diagnosis.from_repeats {
        String::new()
    } else {
        format!(
            " Scatter {} um, from the fit itself; if your gauge repeats better, something is missing.",
            significant(micro(diagnosis.after_m), 3)
        )
    };
    let untested = if diagnosis.findings.is_empty() {
        " Not tested: laws with a history (creep, setting-in, drift, hysteresis) and local laws (slip), because a load case has neither order nor time."
    } else {
        ""
    };
    format!("{found}{scatter}{untested}")
}

fn found_words(diagnosis: &LoadCaseDiagnosis) -> String {
    let names: Vec<String> = diagnosis
        .findings
        .iter()
        .map(|finding| format!("{} at {}", finding.law.replace('-', " "), finding.place))
        .collect();
    let names = names.join(", and ");
    let left = diagnosis
        .unexplained
        .as_ref()
        .map_or_else(String::new, |left| {
            format!(
                "largest residual in pose {}, {}: {} {}",
                left.pose,
                left.component,
                significant(micro(left.size).abs(), 3),
                left.unit
            )
        });
    match diagnosis.grade {
        VerdictGrade::Is => format!("The free parameters are not enough: {names}."),
        VerdictGrade::Mostly => {
            format!(
                "The free parameters are not enough: mostly {names}. Something is left: {left}."
            )
        }
        VerdictGrade::Weak => format!("Weak evidence that something is missing: {names}."),
        VerdictGrade::Unknown if diagnosis.findings.is_empty() && diagnosis.taken_back > 0 => {
            format!(
                "Something is missing that no candidate explains: {left}. {} a part of it, but not in poses left out.",
                match diagnosis.taken_back {
                    1 => "One candidate fits".to_owned(),
                    more => format!("{more} candidates fit"),
                }
            )
        }
        VerdictGrade::Unknown if diagnosis.findings.is_empty() => {
            format!("Something is missing that no candidate explains: {left}.")
        }
        VerdictGrade::Unknown => format!(
            "Something is missing that no candidate explains as a whole: {left}. A part of it looks like {names}."
        ),
        VerdictGrade::Undecided if diagnosis.candidates == 0 => {
            "These load cases cannot decide.".to_owned()
        }
        VerdictGrade::Nothing | VerdictGrade::Undecided => format!(
            "No missing physics was detected among {} candidates.",
            diagnosis.candidates
        ),
    }
}
