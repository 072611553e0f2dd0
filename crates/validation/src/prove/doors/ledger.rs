//! The ledger of the doors: every difference of today, so that none comes or goes unseen.

use std::fmt::Write;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::toml_text::{quoted, read_types};

use crate::prove::error::ProveError;

const SCHEMA: &str = "stiffbench/door-ledger/1";

/// What is asked of the doors.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Deserialize, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DoorJudge {
    /// A session and the same readings as a table of vectors get the same answer.
    Pair,
    /// Three gauges find what one of them shows.
    ThreeGauges,
    /// A joint is named where loads go along (1, 1, 0)/√2.
    Oblique,
    /// A joint is named where the only gauge stands across the load.
    Across,
    /// Load cases, drawn anew, find what a session shows.
    LoadCases,
    /// Absolute positions by a tracker, half of them under a force, find what they show.
    Positions,
}

impl DoorJudge {
    /// All, in their order.
    pub const ALL: [Self; 6] = [
        Self::Pair,
        Self::ThreeGauges,
        Self::Oblique,
        Self::Across,
        Self::LoadCases,
        Self::Positions,
    ];

    /// Its name in the ledger.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Pair => "pair",
            Self::ThreeGauges => "three-gauges",
            Self::Oblique => "oblique",
            Self::Across => "across",
            Self::LoadCases => "load-cases",
            Self::Positions => "positions",
        }
    }

    /// Whether each load is applied by itself, by no procedure.
    #[must_use]
    pub fn is_of_single_loads(self) -> bool {
        matches!(self, Self::LoadCases | Self::Positions)
    }

    /// What `simulate` gets beside robot, effect and seed.
    #[must_use]
    pub fn simulation(self) -> &'static [&'static str] {
        match self {
            Self::Pair => &[],
            Self::ThreeGauges => &["--displacement-axes", "x,y,z"],
            Self::Oblique => &[
                "--directions",
                "0.7071068,0.7071068,0",
                "--displacement-axes",
                "x,y,z",
            ],
            Self::Across => &["--directions", "z", "--displacement-axes", "y"],
            Self::LoadCases => &["--load-cases", "60"],
            Self::Positions => &["--positions", "60", "--loads-n=-1000"],
        }
    }
}

/// A case and what became of it.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize, Serialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct JudgedCase {
    /// What was asked.
    pub judge: DoorJudge,
    /// The bench.
    pub bench: String,
    /// What is missing there; empty for nothing.
    pub effect: String,
    /// What the session was answered, or what was to be named.
    pub session: String,
    /// What the table of vectors was answered.
    pub table: String,
    /// In what they differ; empty if all is right.
    pub differs: Vec<String>,
}

impl JudgedCase {
    fn is_same_case(&self, other: &Self) -> bool {
        (self.judge, &self.bench, &self.effect) == (other.judge, &other.bench, &other.effect)
    }

    fn title(&self) -> String {
        let effect = if self.effect.is_empty() {
            "nothing missing"
        } else {
            &self.effect
        };
        format!("{} {}: {effect}", self.judge.name(), self.bench)
    }

    fn answers(&self) -> String {
        let Self {
            session,
            table,
            differs,
            ..
        } = self;
        format!(
            "session \"{session}\", table \"{table}\", in {}",
            differs.join("; ")
        )
    }
}

/// The cases that are not right.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DoorLedger {
    schema: String,
    /// The cases.
    #[serde(default)]
    pub case: Vec<JudgedCase>,
}

impl DoorLedger {
    /// The ledger of what was judged.
    #[must_use]
    pub fn new(judged: &[JudgedCase]) -> Self {
        let wrong = judged.iter().filter(|case| !case.differs.is_empty());
        Self {
            schema: SCHEMA.to_owned(),
            case: wrong.cloned().collect(),
        }
    }

    /// Reads the ledger.
    ///
    /// # Errors
    /// [`ProveError::Form`].
    pub fn parse(file: &str, text: &str) -> Result<Self, ProveError> {
        let ledger: Self = read_types(&SourceText::new(file, text))?;
        if ledger.schema != SCHEMA {
            return Err(ProveError::Form {
                file: file.to_owned(),
                problem: format!("its schema is {}", ledger.schema),
            });
        }
        Ok(ledger)
    }

    /// The file.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = format!(
            "# What the doors answer differently today; README.md says how it is judged and written anew.\nschema = {}\ncase = [\n",
            quoted(&self.schema)
        );
        for case in &self.case {
            let [bench, effect, session, table] =
                [&case.bench, &case.effect, &case.session, &case.table].map(|text| quoted(text));
            let differs: Vec<String> = case.differs.iter().map(|text| quoted(text)).collect();
            let _ = writeln!(
                text,
                "    {{ judge = {}, bench = {bench}, effect = {effect}, session = {session}, table = {table}, differs = [{}] }},",
                quoted(case.judge.name()),
                differs.join(", ")
            );
        }
        text + "]\n"
    }
}

/// Where the ledger is not what was judged: a difference that is not listed, one that is listed otherwise, one that is listed and gone.
///
/// # Arguments
/// - `is_whole`: whether every case was judged, so that a listed one must be among them.
#[must_use]
pub fn disagreements(ledger: &DoorLedger, judged: &[JudgedCase], is_whole: bool) -> Vec<String> {
    let mut disagreements = Vec::new();
    for case in judged {
        let listed = ledger.case.iter().find(|listed| listed.is_same_case(case));
        let problem = match listed {
            None if case.differs.is_empty() => continue,
            Some(listed) if listed == case => continue,
            None => format!("is not listed: {}", case.answers()),
            Some(_) if case.differs.is_empty() => "agrees, and is still listed".to_owned(),
            Some(listed) => format!(
                "differs otherwise than listed: {}; listed: {}",
                case.answers(),
                listed.answers()
            ),
        };
        disagreements.push(format!("{}: {problem}", case.title()));
    }
    let gone = ledger
        .case
        .iter()
        .filter(|listed| is_whole && !judged.iter().any(|case| case.is_same_case(listed)));
    disagreements.extend(
        gone.map(|listed| format!("{}: is listed, and there is no such case", listed.title())),
    );
    disagreements
}

#[cfg(test)]
mod tests {
    use super::*;

    fn case(effect: &str, table: &str) -> JudgedCase {
        let differs = (table != "explained").then(|| "verdict".to_owned());
        JudgedCase {
            judge: DoorJudge::Pair,
            bench: "A".to_owned(),
            effect: effect.to_owned(),
            session: "explained".to_owned(),
            table: table.to_owned(),
            differs: differs.into_iter().collect(),
        }
    }

    #[test]
    fn a_ledger_fails_when_it_is_not_what_was_judged() {
        let judged = [
            case("a", "unknown"),
            case("b", "explained"),
            case("c", "unknown"),
        ];
        let ledger = DoorLedger::new(&judged);
        assert_eq!(DoorLedger::parse("", &ledger.to_toml()).unwrap(), ledger);
        assert_eq!(ledger.case.len(), 2);
        assert!(disagreements(&ledger, &judged, true).is_empty());
        assert!(disagreements(&ledger, &judged[..1], false).is_empty());
        for (now, whole, expected) in [
            (
                vec![case("a", "explained")],
                false,
                "pair A: a: agrees, and is still listed",
            ),
            (
                vec![case("b", "unknown")],
                false,
                "pair A: b: is not listed",
            ),
            (
                vec![case("a", "ambiguous")],
                false,
                "pair A: a: differs otherwise than listed",
            ),
            (
                judged[..2].to_vec(),
                true,
                "pair A: c: is listed, and there is no such case",
            ),
        ] {
            let found = disagreements(&ledger, &now, whole);
            assert!(
                found.len() == 1 && found[0].starts_with(expected),
                "{found:?}"
            );
        }
    }
}
