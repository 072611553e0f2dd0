//! What a door says of readings, and how two answers differ.

use serde_json::Value;

use stiffbench_beams::physics::{Law, PlaceScale};

use crate::prove::cases::UNKNOWN_SCALE;

/// How far values and ends of intervals of two doors may lie apart, in widths of the interval.
const TOLERANCE: f64 = 1e-3;

/// How far a number of a headline may lie from the value that it rounds, in decades.
const ROUNDED: f64 = 0.003;

/// What `diagnose` and `fit` give by one door.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DoorAnswer {
    /// The verdict; of a refusal its code.
    pub verdict: String,
    /// Its grade.
    pub grade: String,
    /// Law and place of each finding, in order, as `joint-backlash@A3`.
    pub findings: Vec<String>,
    /// Parameters of the findings, as `joint-backlash@A3:play`.
    pub sizes: Vec<DoorEstimate>,
    /// Free factors and springs of `diagnose`, beside what was found, and the values of laws that were stated, as `creep@structure:k`.
    pub parameters: Vec<DoorEstimate>,
    /// Free factors and springs of `fit`.
    pub fitted: Vec<DoorEstimate>,
    /// Sizes that the headline states though the readings do not determine them.
    pub undetermined: Vec<String>,
}

/// A value with its 95 % interval.
#[derive(Debug, Clone, PartialEq)]
pub struct DoorEstimate {
    /// Its name.
    pub name: String,
    /// The value.
    pub value: f64,
    /// The interval.
    pub ci95: Option<[f64; 2]>,
    /// Whether an end is the bound of what is plausible: what is printed has no end there.
    pub is_open: [bool; 2],
}

impl DoorEstimate {
    /// Reads an object with `value` and `ci95`; an open end is infinite.
    fn read(name: String, object: &Value) -> Option<Self> {
        let end = |place: usize, open: f64| object["ci95"][place].as_f64().unwrap_or(open);
        let ends = [end(0, f64::NEG_INFINITY), end(1, f64::INFINITY)];
        Some(Self {
            name,
            value: object["value"].as_f64()?,
            ci95: object["ci95"].is_array().then_some(ends),
            is_open: ["lower", "upper"]
                .map(|end| items(&object["open_ends"]).any(|one| one == end)),
        })
    }

    /// Whether the interval holds a value; `None` without an interval.
    #[must_use]
    pub fn holds(&self, truth: f64) -> Option<bool> {
        let [below, above] = self.is_open;
        self.ci95
            .map(|[low, high]| (below || low <= truth) && (above || truth <= high))
    }

    /// Whether another door gives the same.
    fn agrees(&self, other: &Self) -> bool {
        let near = |a: f64, b: f64, unit: f64| a == b || (a - b).abs() <= TOLERANCE * unit;
        match (self.ci95, other.ci95) {
            (None, None) => near(self.value, other.value, self.value.abs()),
            (Some([low, high]), Some([other_low, other_high])) => {
                let width = high - low;
                near(self.value, other.value, width)
                    && near(low, other_low, width)
                    && near(high, other_high, width)
            }
            _ => false,
        }
    }
}

impl DoorAnswer {
    /// Reads what `diagnose` and `fit` print as JSON, or the objects of their failures.
    ///
    /// # Arguments
    /// - `largest_n`: largest load, N: some laws have a range that depends on it.
    #[must_use]
    pub fn read(
        diagnosis: &Result<Value, Value>,
        fit: &Result<Value, Value>,
        largest_n: f64,
    ) -> Self {
        let fitted = match fit {
            Ok(fit) => free_parameters(&fit["data"]["parameters"]),
            Err(_) => Vec::new(),
        };
        let data = match diagnosis {
            Ok(diagnosis) => &diagnosis["data"],
            Err(failure) => {
                return Self {
                    verdict: format!("refused: {}", text(&failure["error"]["code"])),
                    fitted,
                    ..Self::default()
                };
            }
        };
        let found = items(&data["findings"]).map(|finding| {
            let name = format!("{}@{}", text(&finding["physics"]), place(&finding["place"]));
            (name, finding)
        });
        let found: Vec<(String, &Value)> = found.collect();
        let sizes = found
            .iter()
            .flat_map(|(name, finding)| sizes(name, finding));
        let headline = text(&data["headline"]);
        let undetermined = found.iter().filter_map(|(name, finding)| {
            let law = law_of(finding)?;
            stated_undetermined(law, name, finding, &headline, largest_n)
        });
        Self {
            verdict: text(&data["verdict"]),
            grade: text(&data["grade"]),
            sizes: sizes.collect(),
            undetermined: undetermined.collect(),
            parameters: match &data["factors"] {
                Value::Array(factors) => {
                    let after = |name, object: &Value| DoorEstimate::read(name, &object["after"]);
                    let factors = factors
                        .iter()
                        .filter_map(|factor| after(text(&factor["name"]), factor));
                    let known = items(&data["known_effects"]).flat_map(|known| {
                        let law = format!("{}@{}", text(&known["physics"]), place(&known["place"]));
                        let values = ["parameters", "combination"].map(|key| &known[key]);
                        let values = values.into_iter().filter_map(Value::as_object).flatten();
                        values
                            .filter_map(|(name, value)| after(format!("{law}:{name}"), value))
                            .collect::<Vec<_>>()
                    });
                    factors.chain(known).collect()
                }
                _ => free_parameters(&data["baseline"]["parameters"]),
            },
            fitted,
            findings: found.into_iter().map(|(name, _)| name).collect(),
        }
    }

    /// The answer in words, without numbers.
    #[must_use]
    pub fn words(&self) -> String {
        let findings = self.findings.join(" + ");
        let parts = [self.verdict.as_str(), &self.grade, &findings];
        let parts: Vec<&str> = parts.into_iter().filter(|part| !part.is_empty()).collect();
        parts.join(", ")
    }
}

/// In what two doors differ, in the order of importance; nothing if they agree. Sizes are compared where the same is found.
#[must_use]
pub fn differences(session: &DoorAnswer, table: &DoorAnswer) -> Vec<String> {
    let mut differences: Vec<String> = [
        ("verdict", session.verdict != table.verdict),
        ("grade", session.grade != table.grade),
        ("findings", session.findings != table.findings),
    ]
    .into_iter()
    .filter(|(_, differs)| *differs)
    .map(|(what, _)| what.to_owned())
    .collect();
    let mut compare = |what: &str, ours: &[DoorEstimate], theirs: &[DoorEstimate]| {
        let agrees = |one: &&DoorEstimate| {
            let other = theirs.iter().find(|other| other.name == one.name);
            other.is_some_and(|other| one.agrees(other))
        };
        let apart = ours.iter().filter(|one| !agrees(one));
        differences.extend(apart.map(|one| format!("{what} {}", one.name)));
    };
    if session.findings == table.findings {
        compare("size", &session.sizes, &table.sizes);
        compare("diagnose", &session.parameters, &table.parameters);
    }
    compare("fit", &session.fitted, &table.fitted);
    for (door, answer) in [("session", session), ("table", table)] {
        let stated = answer.undetermined.iter();
        differences
            .extend(stated.map(|size| format!("undetermined in the headline, {door}: {size}")));
    }
    differences
}

/// Whether an answer names an effect, for example `joint-backlash@A3`; of one of several gauges the place is longer than of the only one, and load
/// cases have it in words.
#[must_use]
pub fn is_named(answer: &DoorAnswer, law_and_place: &str) -> bool {
    let (law, place) = law_and_place.split_once('@').unwrap_or((law_and_place, ""));
    answer
        .findings
        .iter()
        .any(|found| match found.split_once('@') {
            Some((found_law, found)) if found_law == law => {
                let longer = found
                    .strip_prefix(place)
                    .is_some_and(|rest| rest.starts_with('.'));
                let in_words = found
                    .strip_suffix(place)
                    .is_some_and(|words| words.ends_with(' '));
                found == place || longer || in_words
            }
            _ => false,
        })
}

fn items(value: &Value) -> impl Iterator<Item = &Value> {
    value.as_array().into_iter().flatten()
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_owned()
}

/// A place as `--effect` takes it; words stay words.
pub(super) fn place(value: &Value) -> String {
    let Value::Object(fields) = value else {
        return text(value);
    };
    let separator = if fields.contains_key("toward") {
        ">"
    } else {
        "."
    };
    let parts: Vec<String> = fields
        .iter()
        .filter(|(_, field)| !field.is_null())
        .map(|(name, field)| match field {
            Value::String(name) => name.clone(),
            Value::Object(_) => place(field),
            Value::Bool(_) => name.clone(),
            number => number.to_string(),
        })
        .collect();
    parts.join(separator)
}

fn free_parameters(list: &Value) -> Vec<DoorEstimate> {
    items(list)
        .filter(|one| one["status"] != "fixed" && one["status"] != "tied")
        .filter_map(|one| DoorEstimate::read(text(&one["name"]), one))
        .collect()
}

/// The parameters of a finding; load cases have the size alone.
fn sizes(name: &str, finding: &Value) -> Vec<DoorEstimate> {
    let size =
        |parameter: &str, object: &Value| DoorEstimate::read(format!("{name}:{parameter}"), object);
    if let Value::Object(parameters) = &finding["parameters"] {
        let sizes = parameters.iter();
        return sizes
            .filter_map(|(name, object)| size(name, object))
            .collect();
    }
    let first = law_of(finding).and_then(|law| law.parameters.first());
    let first = first.map_or("size", |parameter| parameter.name);
    size(first, finding).into_iter().collect()
}

/// The law of a finding: of those of one name, that with these parameters in these units.
fn law_of(finding: &Value) -> Option<Law> {
    let name = text(&finding["physics"]);
    let parameters = finding["parameters"].as_object();
    Law::named(&name).find(|law| {
        let as_many = parameters.is_none_or(|given| given.len() == law.parameters.len());
        as_many
            && law.parameters.iter().all(|parameter| {
                let unit = match parameters {
                    None => &finding["unit"],
                    Some(_) => &finding["parameters"][parameter.name]["unit"],
                };
                *unit == parameter.unit()
            })
    })
}

/// A size that a headline states though its interval reaches both ends of the law's range.
///
/// Ranges that depend on the robot are not known here, and not judged.
fn stated_undetermined(
    law: Law,
    name: &str,
    finding: &Value,
    headline: &str,
    largest_n: f64,
) -> Option<String> {
    let scale = PlaceScale {
        force_n: largest_n,
        force_range_n: [-largest_n, largest_n],
        ..UNKNOWN_SCALE
    };
    let estimates = sizes(name, finding);
    let values: Vec<f64> = estimates.iter().map(|size| size.value).collect();
    if values.len() != law.parameters.len() {
        return None;
    }
    // The name of a number made of the values has numbers of its own.
    let made = law
        .combination
        .map_or("", |combination| combination.spec.word);
    let headline = &headline.replace(made, "");
    let of_law = law.parameters.iter().zip(&estimates);
    of_law
        .filter(|(parameter, _)| !parameter.is_ratio())
        .find(|(parameter, size)| {
            let [least, most] = (parameter.plausible.bounds)(&scale, &values);
            let margin = TOLERANCE * (most - least);
            let reaches = |[low, high]: [f64; 2]| low <= least + margin && high >= most - margin;
            size.ci95.is_some_and(reaches) && states(headline, size.value)
        })
        .map(|(_, size)| size.name.clone())
}

/// Whether a sentence has a value in it, in whatever multiple of its unit or in degrees.
fn states(sentence: &str, value: f64) -> bool {
    let numbers = sentence.split(|c: char| !(c.is_ascii_digit() || ".eE-+".contains(c)));
    let mut numbers = numbers.filter_map(|number| number.trim_end_matches('.').parse::<f64>().ok());
    numbers.any(|number| {
        [1.0, 1f64.to_degrees()].into_iter().any(|unit| {
            let decades = (number / (value * unit)).abs().log10();
            (decades - decades.round()).abs() < ROUNDED
        })
    })
}

#[cfg(test)]
mod tests {
    use serde_json::json;
    use stiffbench_beams::physics::laws;

    use super::*;

    fn creep(ci95: [f64; 2]) -> Value {
        json!({ "data": {
            "verdict": "explained", "grade": "is", "headline": "The model leaves out creep under a constant load (6.64 % per decade).",
            "findings": [{
                "physics": "creep", "place": { "structure": true },
                "parameters": {
                    "k": { "value": 0.0664, "unit": "1/decade", "ci95": ci95 },
                    "t0": { "value": 1.0, "unit": "s", "ci95": null },
                },
            }],
            "factors": [{ "name": "beam.A", "after": { "value": 0.003, "ci95": [0.0029, 0.0031] } }],
        } })
    }

    fn answer(ci95: [f64; 2]) -> DoorAnswer {
        DoorAnswer::read(&Ok(creep(ci95)), &Ok(Value::Null), 70.0)
    }

    #[test]
    fn answers_agree_within_a_thousandth_of_the_interval() {
        let session = answer([0.06, 0.07]);
        assert_eq!(session.words(), "explained, is, creep@structure");
        assert!(differences(&session, &answer([0.060_009, 0.07])).is_empty());
        let apart = differences(&session, &answer([0.060_011, 0.07]));
        assert_eq!(apart, ["size creep@structure:k"]);
        assert!(is_named(&session, "creep@structure") && !is_named(&session, "creep@struct"));
    }

    #[test]
    fn another_shape_of_the_same_answer_is_read() {
        let table = json!({ "data": {
            "verdict": "explained", "grade": "is", "headline": "",
            "findings": [{ "physics": "joint-compliance", "place": "joint A3", "value": 2e-6, "unit": "rad/(N*m)", "ci95": [1e-6, null] }],
            "baseline": { "parameters": [
                { "name": "beam.A", "status": "free", "value": 0.003, "ci95": [0.0029, 0.0031] },
                { "name": "link.A", "status": "fixed", "value": 1.0, "ci95": null },
            ] },
        } });
        let table = DoorAnswer::read(&Ok(table), &Err(Value::Null), 70.0);
        assert_eq!(table.sizes[0].name, "joint-compliance@joint A3:c");
        assert!(is_named(&table, "joint-compliance@A3"));
        assert_eq!(table.sizes[0].ci95, Some([1e-6, f64::INFINITY]));
        assert_eq!(table.parameters, answer([0.06, 0.07]).parameters);
        assert_eq!(table.parameters[0].holds(0.0032), Some(false));
        let refused = json!({ "error": { "code": "stiffbench::usage" } });
        let refused = DoorAnswer::read(&Err(refused), &Err(Value::Null), 70.0);
        assert_eq!(refused.words(), "refused: stiffbench::usage");
    }

    #[test]
    fn a_size_that_reaches_both_ends_of_its_range_must_not_be_stated() {
        assert_eq!(answer([0.0, 0.3]).undetermined, ["creep@structure:k"]);
        assert!(answer([0.001, 0.3]).undetermined.is_empty());
        assert!(states("play in joint A3 (28.8 urad)", 2.879e-5));
        assert!(!states("play in joint A3", 2.879e-5));
        let creep = json!({ "physics": "creep", "parameters": {
            "k": { "value": 0.07, "unit": "1/decade", "ci95": [0.0, 0.3] },
            "t0": { "value": 0.6, "unit": "s", "ci95": [0.0, 40.0] },
        } });
        let stated = |headline| stated_undetermined(laws::CREEP, "creep", &creep, headline, 70.0);
        assert_eq!(
            stated("creep (growth from 5 to 60 s under load 4.2 %)"),
            None
        );
        assert_eq!(stated("creep (t0 0.6 s)"), Some("creep:t0".to_owned()));
    }

    #[test]
    fn places_are_those_of_the_command_line() {
        for (object, expected) in [
            (json!({ "direction": "z", "toward": "y" }), "z>y"),
            (
                json!({ "run": { "pose": "P1", "direction": "x", "repeat": 2 }, "step": 1 }),
                "P1.x.2.1",
            ),
            (
                json!({ "gauge": "displacement", "direction": "x" }),
                "displacement.x",
            ),
            (json!({ "clock": true }), "clock"),
        ] {
            assert_eq!(place(&object), expected);
        }
    }
}
