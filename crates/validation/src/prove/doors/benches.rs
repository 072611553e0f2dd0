//! Benches of which every reading goes through every door, and a sample of each law of the library on each.

use std::collections::HashMap;

use serde::Deserialize;

use stiffbench_beams::physics::{Effect, Law, TestObject};
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::toml_text::read_types;

use crate::prove::error::ProveError;

use super::ledger::DoorJudge;

const SCHEMA: &str = "stiffbench/door-benches/1";

/// The benches.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DoorBenches {
    schema: String,
    /// Seed of the noise of every session.
    pub seed: u64,
    /// The procedure of every session.
    pub procedure: String,
    /// The benches.
    pub bench: Vec<DoorBench>,
}

/// A bench and what is missing on it, session by session.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DoorBench {
    /// Its name.
    pub name: String,
    /// The robot, as `--robot` takes it.
    pub robot: String,
    /// The mechanism, if not the robot's last.
    pub mechanism: Option<String>,
    /// A sample of each law, as `--effect` takes it.
    pub effects: Vec<String>,
    /// Effects for one judge, under whose loads and gauges those of the same law have another size or place.
    #[serde(default)]
    pub instead: HashMap<DoorJudge, Vec<String>>,
    /// Laws without a sample.
    pub unsampled: Vec<Unsampled>,
}

/// A law that cannot be simulated or seen on a bench.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unsampled {
    /// Its name in tables.
    pub law: String,
    /// The judge under whose loads and gauges it cannot; all if absent.
    pub judge: Option<DoorJudge>,
    /// Why.
    pub reason: String,
}

impl DoorBenches {
    /// Reads the file of the benches.
    ///
    /// # Errors
    /// [`ProveError::Form`] for another form, an effect that is none, and a law of the library with neither sample nor reason.
    pub fn parse(file: &str, text: &str) -> Result<Self, ProveError> {
        let form = |problem: String| ProveError::Form {
            file: file.to_owned(),
            problem,
        };
        let benches: Self = read_types(&SourceText::new(file, text))?;
        if benches.schema != SCHEMA {
            return Err(form(format!("its schema is {}", benches.schema)));
        }
        for bench in &benches.bench {
            let read = |texts: &[String]| {
                let effects = texts.iter().map(|text| {
                    let effect = text.parse::<Effect>();
                    effect.map_err(|error| form(format!("bench {}: {text}: {error}", bench.name)))
                });
                effects.collect::<Result<Vec<Effect>, _>>()
            };
            let effects = read(&bench.effects)?;
            for others in bench.instead.values() {
                read(others)?;
            }
            let everywhere = || bench.unsampled.iter().filter(|one| one.judge.is_none());
            let has_reason = |law: &Law| everywhere().any(|one| one.law == law.row);
            let missing = Law::searched_on(TestObject::Robot)
                .find(|law| !has_reason(law) && effects.iter().all(|one| one.law != *law));
            if let Some(law) = missing {
                let problem = format!("bench {} has no sample of {}", bench.name, law.row);
                return Err(form(problem));
            }
        }
        Ok(benches)
    }
}

impl DoorBench {
    /// The effects that a judge takes.
    #[must_use]
    pub fn effects_for(&self, judge: DoorJudge) -> Vec<&str> {
        let own = self.instead.get(&judge).map_or(&[][..], Vec::as_slice);
        let law = |text: &str| text.parse::<Effect>().ok().map(|effect| effect.law);
        let is_replaced = |text: &&String| own.iter().any(|other| law(other) == law(text));
        let unsampled = || self.unsampled.iter().filter(|one| one.judge == Some(judge));
        let is_unsampled =
            |text: &str| law(text).is_some_and(|law| unsampled().any(|one| one.law == law.row));
        let kept = self.effects.iter().filter(|text| !is_replaced(text));
        let all = kept.chain(own).map(String::as_str);
        all.filter(|text| !is_unsampled(text)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bench_without_a_sample_of_a_law_is_refused() {
        let text = include_str!("../../../../../data/doors/benches.toml");
        assert!(DoorBenches::parse("benches.toml", text).is_ok());
        let lines = text
            .lines()
            .filter(|line| !line.contains("\"creep@structure"));
        let without: Vec<&str> = lines.collect();
        let error = DoorBenches::parse("benches.toml", &without.join("\n")).unwrap_err();
        assert!(error.to_string().contains("creep"), "{error}");
    }
}
