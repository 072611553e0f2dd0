//! What a procedure would show, for people and for programs.

use std::fmt::Write;

use schemars::JsonSchema;
use serde::Serialize;

use crate::mismatch::{DesignReport, LawDesign, NearRival, Suspect};
use crate::physics::{Effect, Law, ParameterSpec, Place, title};

use super::text::AlignedTable;
use crate::count::counted;

/// Rows of the printed tables.
const ROWS: usize = 40;

/// What a procedure would show, for programs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct DesignSummary {
    /// Name of the procedure.
    pub procedure: String,
    /// Readings it plans.
    pub readings: usize,
    /// Minutes it takes, setting up included.
    pub minutes: f64,
    /// Each law at each place.
    pub laws: Vec<LawDetection>,
    /// Laws and places of which none can be distinguished from the others at any plausible size.
    pub inseparable: Vec<Vec<LawAtPlace>>,
    /// Laws and places that the readings do not show at any plausible size.
    pub unseen: Vec<UnseenLaw>,
}

/// A law at a place.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct LawAtPlace {
    /// The law.
    pub physics: Law,
    /// The place.
    pub place: Place,
}

/// From which size on a law is found at a place.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct LawDetection {
    /// The law and its place.
    #[serde(flatten)]
    pub law: LawAtPlace,
    /// Size found in 80 % of sessions, in `unit`; `null` for a law without size.
    pub size_80: Option<f64>,
    /// Unit of the sizes.
    pub unit: Option<&'static str>,
    /// The same as the largest change of a reading, µm.
    pub end_effect_80_um: f64,
    /// The laws that are hardest to tell from it, the hardest first.
    pub nearest: Vec<NearLaw>,
}

/// A law that is hard to tell from another.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct NearLaw {
    /// The law and its place.
    #[serde(flatten)]
    pub law: LawAtPlace,
    /// Cosine of the angle between the two effects on the readings.
    pub cosine: f64,
    /// Size from which the expected log-likelihood ratio is 3; `null` if no plausible size reaches it.
    pub size_3: Option<f64>,
    /// The same for 5.
    pub size_5: Option<f64>,
    /// Whether no plausible size separates them.
    pub never: bool,
}

/// A law that a procedure does not show at a place.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct UnseenLaw {
    /// The law and its place.
    #[serde(flatten)]
    pub law: LawAtPlace,
    /// Size that would be found in 80 % of sessions, more than is plausible; `null` if none would.
    pub size_needed: Option<f64>,
}

impl LawAtPlace {
    /// The law and its place in words.
    #[must_use]
    pub fn title(&self) -> String {
        title(self.physics, &self.place)
    }
}

impl From<&Suspect> for LawAtPlace {
    fn from(suspect: &Suspect) -> Self {
        Self {
            physics: suspect.law,
            place: suspect.place.clone(),
        }
    }
}

impl From<&Effect> for LawAtPlace {
    fn from(effect: &Effect) -> Self {
        Self {
            physics: effect.law,
            place: effect.place.clone(),
        }
    }
}

impl From<&NearRival> for NearLaw {
    fn from(near: &NearRival) -> Self {
        Self {
            law: (&near.rival).into(),
            cosine: near.cosine,
            size_3: near.size_3,
            size_5: near.size_5,
            never: near.never,
        }
    }
}

impl From<&LawDesign> for LawDetection {
    fn from(found: &LawDesign) -> Self {
        let parameter = found.suspect.law.parameters.first();
        Self {
            law: (&found.suspect).into(),
            size_80: found.size_80,
            unit: parameter.map(ParameterSpec::unit),
            end_effect_80_um: found.end_effect_80_m * 1e6,
            nearest: found.nearest.iter().map(Into::into).collect(),
        }
    }
}

impl From<&DesignReport> for DesignSummary {
    fn from(report: &DesignReport) -> Self {
        let group = |group: &Vec<Suspect>| group.iter().map(Into::into).collect();
        Self {
            procedure: report.procedure.clone(),
            readings: report.readings,
            minutes: report.minutes,
            laws: report.laws.iter().map(Into::into).collect(),
            inseparable: report.inseparable.iter().map(group).collect(),
            unseen: report
                .unseen
                .iter()
                .map(|unseen| UnseenLaw {
                    law: (&unseen.suspect).into(),
                    size_needed: unseen.size_needed,
                })
                .collect(),
        }
    }
}

/// What a procedure can and cannot show, as tables.
#[must_use]
pub fn design_text(report: &DesignReport) -> String {
    let mut text = format!(
        "Procedure {}: {}, about {:.0} minutes. What it would show, with a dial gauge of 10 um read to 6 um:\n\n",
        report.procedure,
        counted(report.readings, "reading"),
        report.minutes
    );
    let mut table = AlignedTable::new(&[
        "law and place",
        "found in 80 % from, um at the end",
        "hardest to distinguish from",
        "distinguished from, um at the end",
    ]);
    for law in report.laws.iter().take(ROWS) {
        let nearest = law.nearest.first();
        let name = nearest.map_or_else(|| "-".to_owned(), |n| title(n.rival.law, &n.rival.place));
        let from = match nearest {
            None => "-".to_owned(),
            Some(rival) if rival.never => "never".to_owned(),
            // What is not found is not distinguished either.
            Some(rival) => rival.end_effect_5_m.map_or_else(
                || "-".to_owned(),
                |m| format!("{:.1}", m.max(law.end_effect_80_m) * 1e6),
            ),
        };
        table.row([
            title(law.suspect.law, &law.suspect.place),
            format!("{:.1}", law.end_effect_80_m * 1e6),
            name,
            from,
        ]);
    }
    text.push_str(&table.text());
    if report.laws.len() > ROWS {
        let _ = writeln!(
            text,
            "… and {} more: --json has all.",
            report.laws.len() - ROWS
        );
    }
    if !report.inseparable.is_empty() {
        text.push_str("\nIndistinguishable at any plausible size:\n");
        for group in &report.inseparable {
            let names: Vec<String> = group.iter().map(ToString::to_string).collect();
            let _ = writeln!(text, "- {}", names.join(" = "));
        }
    }
    if !report.unseen.is_empty() {
        let names: Vec<String> = report
            .unseen
            .iter()
            .map(|u| u.suspect.to_string())
            .collect();
        let _ = writeln!(
            text,
            "\nNot shown at any plausible size: {}.",
            names.join(", ")
        );
    }
    text
}
