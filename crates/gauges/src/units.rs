//! Units of a gauge: what stands on the wire, and what it means.

use stiffbench_units_and_text::quantity::Kind;

use super::description::UnitSource;

/// Where the unit of a value comes from, and how it is spelled.
#[derive(Debug, Clone)]
pub(super) struct Units {
    /// Where it comes from.
    pub(super) source: UnitSource,
    /// The unit of a gauge that has only one.
    pub(super) fixed: Option<String>,
    /// What stands on the wire and the unit it means, in the order of the file: the first of a unit is what an emulated gauge sends.
    pub(super) codes: Vec<(String, String)>,
    /// Units that may be configured.
    pub(super) choices: Vec<String>,
}

impl Units {
    /// Units that values can have.
    pub(super) fn all(&self) -> Vec<String> {
        match (self.source, &self.fixed) {
            (UnitSource::Fixed, Some(fixed)) => vec![fixed.clone()],
            _ => self.choices.clone(),
        }
    }

    /// The unit that an answer of the gauge names.
    pub(super) fn named_by(&self, answer: &str) -> Option<&str> {
        let answer = answer.trim();
        let mut codes = self.codes.iter();
        codes
            .find(|(code, _)| code.trim().eq_ignore_ascii_case(answer))
            .map(|(_, unit)| unit.as_str())
    }
}

/// Spellings that gauges use, for descriptions that list none.
pub(super) fn usual_codes(kind: Kind) -> &'static [(&'static str, &'static str)] {
    match kind {
        Kind::Force => &[
            ("N", "N"),
            ("mN", "mN"),
            ("kN", "kN"),
            ("KN", "kN"),
            ("kgf", "kgf"),
            ("kgF", "kgf"),
            ("kg", "kgf"),
            ("gf", "gf"),
            ("gF", "gf"),
            ("g", "gf"),
            ("lbf", "lbf"),
            ("lbF", "lbf"),
            ("lb", "lbf"),
            ("LB", "lbf"),
            ("ozf", "ozf"),
            ("ozF", "ozf"),
            ("oz", "ozf"),
        ],
        Kind::Displacement => &[
            ("mm", "mm"),
            ("MM", "mm"),
            ("um", "um"),
            ("in", "in"),
            ("IN", "in"),
            ("inch", "in"),
        ],
        Kind::Time
        | Kind::Temperature
        | Kind::Torque
        | Kind::Angle
        | Kind::Stress
        | Kind::Strain => &[],
    }
}
