//! Benches of which every reading goes through every door, and a sample of each law of the library on each.

use serde::Deserialize;

use stiffbench_beams::physics::{Effect, Law, TestObject};
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::toml_text::read_types;

use crate::prove::error::ProveError;

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
    /// Laws without a sample.
    pub unsampled: Vec<Unsampled>,
}

/// A law that cannot be simulated or seen on a bench.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unsampled {
    /// Its name in tables.
    pub law: String,
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
            let effects = bench.effects.iter().map(|text| {
                let effect = text.parse::<Effect>();
                effect.map_err(|error| form(format!("bench {}: {text}: {error}", bench.name)))
            });
            let effects: Vec<Effect> = effects.collect::<Result<_, _>>()?;
            let has_reason = |law: &Law| bench.unsampled.iter().any(|one| one.law == law.row);
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_bench_without_a_sample_of_a_law_is_refused() {
        let text = include_str!("../../../../../data/doors/benches.toml");
        assert!(DoorBenches::parse("benches.toml", text).is_ok());
        let lines = text.lines().filter(|line| !line.contains("\"creep@structure"));
        let without: Vec<&str> = lines.collect();
        let error = DoorBenches::parse("benches.toml", &without.join("\n")).unwrap_err();
        assert!(error.to_string().contains("creep"), "{error}");
    }
}
