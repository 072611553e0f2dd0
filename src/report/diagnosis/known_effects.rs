//! Physics that was known before a diagnosis, and what the readings make of its values.

use std::borrow::Cow;

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiffbench_document::{Document, Table};

use crate::analysis::DiagnosisReport;
use crate::mismatch::{KnownEffect, LawAtPlace};
use crate::report::significant;
use crate::report::text::{digits, with_unit};

use super::summary::FittedParameter;

/// Physics that was given with `--effect` or `--model`.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct KnownEffectReport {
    /// The law and its place.
    #[serde(flatten)]
    pub law: LawAtPlace,
    /// Its parameters by name.
    pub parameters: IndexMap<Cow<'static, str>, KnownParameter>,
    /// What readings determine where they do not tell the parameters apart, by name; nothing of most laws.
    pub combination: IndexMap<Cow<'static, str>, KnownCombination>,
}

/// A number that readings make of the parameters of a law.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct KnownCombination {
    /// Without what was found.
    pub before: FittedParameter,
    /// With what was found.
    pub after: FittedParameter,
}

/// A value that was given, fitted again.
#[derive(Debug, Clone, Serialize, Deserialize, JsonSchema)]
pub struct KnownParameter {
    /// As given, in the unit of the fitted value.
    pub given: f64,
    /// Without what was found.
    pub before: FittedParameter,
    /// With what was found.
    pub after: FittedParameter,
}

impl From<&KnownEffect> for KnownEffectReport {
    fn from(known: &KnownEffect) -> Self {
        let parameters = known.given.parameters().enumerate();
        let parameters = parameters.map(|(place, (spec, given))| {
            let parameter = KnownParameter {
                given,
                before: FittedParameter::of_law(&spec, &known.before[place]),
                after: FittedParameter::of_law(&spec, &known.after[place]),
            };
            (spec.name.into(), parameter)
        });
        let law = known.given.law;
        let made = law.combination.as_ref().zip(known.combination.as_ref());
        let made = made.map(|(combination, [before, after])| {
            let spec = combination.spec.at(&known.given.place);
            let [before, after] = [before, after].map(|one| FittedParameter::of_law(&spec, one));
            (spec.name.into(), KnownCombination { before, after })
        });
        Self {
            law: (&known.given).into(),
            parameters: parameters.collect(),
            combination: made.into_iter().collect(),
        }
    }
}

/// The section of the page; empty where nothing was known.
pub(super) fn known_effects(report: &DiagnosisReport) -> Document {
    let known = &report.diagnosis.known_effects;
    if known.is_empty() {
        return Document::new();
    }
    let mut section = Document::under("Physics known beforehand");
    section.paragraph("These effects are part of the model from the start and not candidates of the search. Their values were fitted again.");
    let known: Vec<KnownEffectReport> = known.iter().map(Into::into).collect();
    let rows = known.iter().flat_map(|one| {
        let parameters = one.parameters.iter();
        let parameters = parameters.map(|(name, value)| (name, Some(value.given), &value.after));
        let made = one.combination.iter();
        let made = made.map(|(name, value)| (name, None, &value.after));
        parameters.chain(made).map(move |value| (&one.law, value))
    });
    section.table(
        Table::of(rows)
            .words("effect", |(one, _)| {
                format!("{} at {}", one.law.name, one.place)
            })
            .words("value", |(_, (name, _, after))| {
                with_unit(name, &after.unit)
            })
            .numbers("given", |(_, (_, given, _))| digits(*given, 4))
            .numbers("fitted", |(.., (.., after))| significant(after.value, 4))
            .numbers("95 % interval", |(.., (.., after))| {
                after.interval_in_words(3)
            }),
    );
    section
}
