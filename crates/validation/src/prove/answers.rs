//! The answers to concealed sessions, and the lists of sessions.

use std::collections::BTreeMap;
use std::fmt;
use std::fmt::Write as _;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use stiffbench_beams::physics::{Effect, Law, MODEL_SCHEMA, ModelFile, ParameterSpec};
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::toml_text::read_types;

use super::error::ProveError;

const ANSWERS_SCHEMA: &str = "stiffbench/concealed-answers/1";
const SETS_SCHEMA: &str = "stiffbench/concealed-sets/1";

/// What the right verdict on a session is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Expected {
    /// Nothing is there to find.
    NothingMissing,
    /// The truth alone.
    Named,
    /// The truth, also right with others beside it that are hard to distinguish.
    NamedOrAmbiguous,
    /// The truth together with all that cannot be distinguished from it.
    Ambiguous,
    /// Structure that no law of the library explains.
    Unknown,
}

impl fmt::Display for Expected {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// A parameter of a true effect.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct TrueParameter {
    /// Its value, SI.
    pub value: f64,
    /// Its unit.
    pub unit: String,
}

/// Another name or place that could stand for a true effect.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct KnownRival {
    /// Its physics.
    pub physics: String,
    /// Its place, as in files.
    pub place: Value,
    /// What it leaves of the effect after the best fit, in standard errors.
    pub standard_errors_between: f64,
}

/// An effect that is in a session.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct TrueEffect {
    /// Its physics; outside the library a name that no law has.
    pub physics: String,
    /// Its place, as in files.
    pub place: Value,
    /// Its parameters.
    pub parameters: BTreeMap<String, TrueParameter>,
    /// Its length in standard errors, the factors projected out.
    pub standard_errors: f64,
    /// The same with the sizes of the other effects free.
    pub standard_errors_beside_the_others: f64,
    /// Largest change of a reading, µm.
    pub end_effect_um: f64,
    /// Share that the factors absorb.
    pub absorbed_share: f64,
    /// What could be mistaken for it, the nearest first, at most eight.
    pub rivals: Vec<KnownRival>,
}

impl TrueEffect {
    /// Whether this is an effect's law and place; the unit tells the two drifts apart.
    #[must_use]
    pub fn is(&self, effect: &Effect) -> bool {
        let size = effect.law.parameters.first();
        self.physics == effect.law.name
            && size.is_none_or(|size| self.has_size(size))
            && self.place == json!(effect.place)
    }

    /// The effect itself, of a law of the library.
    ///
    /// # Errors
    /// [`ProveError::Form`] if no law has such a place or such parameters.
    pub fn effect(&self) -> Result<Effect, ProveError> {
        let wrong = |problem: String| ProveError::Form {
            file: format!("the answer {}", self.title()),
            problem,
        };
        let mut text = format!(
            "schema = \"{MODEL_SCHEMA}\"\n[[effects]]\nphysics = {}\nplace = {}\n",
            json!(self.physics),
            in_toml(&self.place)
        );
        for (name, TrueParameter { value, unit }) in &self.parameters {
            let unit = json!(unit);
            let _ = writeln!(
                text,
                "parameters.{name} = {{ value = {value:?}, unit = {unit} }}"
            );
        }
        let model = ModelFile::parse(&SourceText::new("answer", text));
        let model = model.map_err(|error| wrong(error.to_string()))?;
        let effect = model.acting().pop();
        effect.ok_or_else(|| wrong("it acts on nothing".to_owned()))
    }

    /// Its law; `None` outside the library.
    #[must_use]
    pub fn law(&self) -> Option<Law> {
        let size = |law: &Law| law.parameters.first();
        Law::named(&self.physics).find(|law| size(law).is_none_or(|size| self.has_size(size)))
    }

    fn has_size(&self, size: &ParameterSpec) -> bool {
        let given = self.parameters.get(size.name);
        given.is_some_and(|given| given.unit == size.unit())
    }

    /// Its value of a parameter, SI.
    #[must_use]
    pub fn value(&self, parameter: &str) -> Option<f64> {
        self.parameters.get(parameter).map(|p| p.value)
    }

    /// In words.
    #[must_use]
    pub fn title(&self) -> String {
        format!("{} at {}", self.physics, place_words(&self.place))
    }
}

/// A place as a model file writes it.
fn in_toml(place: &Value) -> String {
    let Value::Object(keys) = place else {
        return place.to_string();
    };
    let keys = keys.iter();
    let keys: Vec<String> = keys
        .map(|(key, value)| format!("{key} = {}", in_toml(value)))
        .collect();
    format!("{{ {} }}", keys.join(", "))
}

/// A place of a file in words: the values of its keys.
pub(super) fn place_words(place: &Value) -> String {
    match place {
        Value::Object(keys) => keys
            .iter()
            .map(|(key, value)| match value {
                Value::Bool(_) => format!("the {key}"),
                Value::Object(_) => place_words(value),
                other => format!("{key} {}", place_words(other)),
            })
            .collect::<Vec<_>>()
            .join(" "),
        Value::Array(values) => values.iter().map(place_words).collect::<Vec<_>>().join("-"),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// The noise that the readings of a session were drawn with.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
pub struct TrueNoise {
    /// Standard deviation of a reading beside the step of its gauge, µm.
    pub sigma: f64,
    /// Of the zero of a run, µm.
    pub sigma0: f64,
    /// Of the slope of a run (1).
    pub slope: f64,
    /// Step of the displacement gauge, µm.
    pub res_um: f64,
    /// Display step of the force gauge, N.
    #[serde(rename = "force_resolution_N")]
    pub force_resolution_n: f64,
}

/// The answer to a session.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct SealedAnswer {
    /// Mode of concealment, `a` to `i`, or `law`.
    pub mode: String,
    /// The right verdict.
    pub expected: Expected,
    /// Whether finding nothing is no error.
    pub may_be_missed: bool,
    /// What is there.
    pub truth: Vec<TrueEffect>,
    /// What the best three effects of the library leave, in standard errors; outside the library only.
    #[serde(default)]
    pub left_by_library: Option<f64>,
    /// Whether the published validation passes within 3 %; `None` with one pose.
    pub published_validation_passes: Option<bool>,
    /// Root mean square that the true model itself leaves, µm.
    pub floor_rms_um: f64,
    /// True factors of the beams by property.
    pub beam_factors: BTreeMap<String, f64>,
    /// Its noise.
    pub noise: TrueNoise,
}

/// Answers of a folder of concealed sessions.
#[derive(Debug, Clone, PartialEq, Deserialize)]
pub struct SealedAnswers {
    /// Form of the file.
    schema: String,
    /// Answers by session.
    benches: BTreeMap<String, SealedAnswer>,
}

impl SealedAnswers {
    /// Reads answers that were opened.
    ///
    /// # Errors
    /// [`ProveError::Form`].
    pub fn parse(file: &str, text: &str) -> Result<Self, ProveError> {
        let wrong = |problem: String| ProveError::Form {
            file: file.to_owned(),
            problem,
        };
        let answers: Self = serde_json::from_str(text).map_err(|error| wrong(error.to_string()))?;
        if answers.schema != ANSWERS_SCHEMA {
            return Err(wrong(format!("its schema is {}", answers.schema)));
        }
        Ok(answers)
    }

    /// Takes in the answers of further sessions.
    pub fn add(&mut self, others: Self) {
        self.benches.extend(others.benches);
    }

    /// The answer to a session.
    ///
    /// # Errors
    /// [`ProveError::NoAnswer`].
    pub fn get(&self, session: &str) -> Result<&SealedAnswer, ProveError> {
        self.benches
            .get(session)
            .ok_or_else(|| ProveError::NoAnswer {
                session: session.to_owned(),
            })
    }

    /// All answers by session.
    pub fn iter(&self) -> impl Iterator<Item = (&String, &SealedAnswer)> {
        self.benches.iter()
    }
}

/// The lists of sessions.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
pub struct SealedSets {
    schema: String,
    /// Sessions that the tool may be developed on.
    pub development: Vec<String>,
    /// Sessions that are checked by the scorer only.
    pub proof: Vec<String>,
    /// The same, made after the proof list had been scored.
    #[serde(default)]
    pub second: Vec<String>,
}

/// Which list a session is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Set {
    /// The open one.
    Development,
    /// The sealed one.
    Proof,
    /// The sealed one that was made after the first had been scored.
    Second,
}

impl Set {
    /// Name in files and tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Development => "development",
            Self::Proof => "proof",
            Self::Second => "second proof",
        }
    }
}

impl SealedSets {
    /// Reads the lists.
    ///
    /// # Errors
    /// [`ProveError::Form`].
    pub fn parse(file: &str, text: &str) -> Result<Self, ProveError> {
        let sets: Self = read_types(&SourceText::new(file, text))?;
        if sets.schema != SETS_SCHEMA {
            return Err(ProveError::Form {
                file: file.to_owned(),
                problem: format!("its schema is {}", sets.schema),
            });
        }
        Ok(sets)
    }

    /// Sessions of all lists in the order of their names, at most so many of each list.
    ///
    /// A list is thinned evenly, so that its names are still a random choice.
    #[must_use]
    pub fn chosen(&self, most_of_each: Option<usize>) -> Vec<(String, Set)> {
        let mut chosen: Vec<(String, Set)> = Vec::new();
        for (list, set) in [
            (&self.development, Set::Development),
            (&self.proof, Set::Proof),
            (&self.second, Set::Second),
        ] {
            let mut names = list.clone();
            names.sort();
            let most = most_of_each.unwrap_or(names.len()).min(names.len());
            chosen.extend((0..most).map(|place| (names[place * names.len() / most].clone(), set)));
        }
        chosen.sort();
        chosen
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;
    use stiffbench_beams::physics::{Place, laws};

    #[test]
    fn lists_are_thinned_evenly_and_ordered_by_name() {
        let text = "schema = \"stiffbench/concealed-sets/1\"\ndevelopment = [\"d\", \"a\"]\nproof = [\"c\", \"b\", \"f\", \"e\"]\n";
        let sets = SealedSets::parse("sets.toml", text).unwrap();
        let names = |most| -> Vec<String> {
            let chosen = sets.chosen(most).into_iter();
            chosen
                .map(|(name, set)| format!("{name} {}", set.name()))
                .collect()
        };
        assert_eq!(
            names(Some(2)),
            ["a development", "b proof", "d development", "e proof"]
        );
        assert_eq!(names(None).len(), 6);
        let other = text.replace("sets/1", "sets/9");
        assert!(matches!(
            SealedSets::parse("s", &other),
            Err(ProveError::Form { .. })
        ));
        assert!(matches!(
            SealedSets::parse("s", "x"),
            Err(ProveError::Form { .. })
        ));
    }

    #[test]
    fn the_unit_distinguishes_the_drifts() {
        let drift = |unit: &str| -> TrueEffect {
            serde_json::from_value(json!({
                "physics": "thermal-drift", "place": { "clock": true },
                "parameters": { "rate": { "value": 1e-8, "unit": unit } },
                "standard_errors": 6.0, "standard_errors_beside_the_others": 6.0,
                "end_effect_um": 3.0, "absorbed_share": 0.1, "rivals": []
            }))
            .unwrap()
        };
        let per_second =
            Effect::new(laws::DRIFT_PER_SECOND, Place::Clock(None), vec![1e-8]).unwrap();
        assert!(drift("m/s").is(&per_second));
        assert!(!drift("m/K").is(&per_second));
        assert_eq!(drift("m/K").law(), Some(laws::DRIFT_PER_KELVIN));
        assert_eq!(drift("m/s").title(), "thermal-drift at the clock");
        let slip = json!({ "run": { "pose": "P1", "direction": "x", "repeat": 2 }, "step": 3 });
        assert_eq!(place_words(&slip), "pose P1 direction x repeat 2 step 3");
    }

    #[test]
    fn answers_of_another_form_are_refused() {
        for text in ["", "{}", "{\"schema\": \"other\", \"benches\": {}}"] {
            assert!(matches!(
                SealedAnswers::parse("a", text),
                Err(ProveError::Form { .. })
            ));
        }
        let none = "{\"schema\": \"stiffbench/concealed-answers/1\", \"benches\": {}}";
        let answers = SealedAnswers::parse("a", none).unwrap();
        assert!(matches!(answers.get("x"), Err(ProveError::NoAnswer { .. })));
    }
}
