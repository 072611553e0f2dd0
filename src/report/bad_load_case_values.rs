//! Bad values of load cases in words.

use schemars::JsonSchema;
use serde::Serialize;

use crate::elastostatics::{BadLoadCaseValue, ValueWitness, WrongFactor};
use crate::quantity::METRES_PER_MICROMETRE;
use crate::test_point::PoseId;

use super::text::{share_of_tables, significant};

/// A value that contradicts others.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct BadLoadCaseValueReport {
    /// Line of the table.
    pub line: u32,
    /// The pose.
    pub pose: PoseId,
    /// Its name, for example `displacement x`.
    pub component: &'static str,
    /// `um` or `urad`: the unit of what follows.
    pub unit: &'static str,
    /// What was read.
    pub value: f64,
    /// What the others let expect.
    pub expected: f64,
    /// Standard error of the difference between both.
    pub standard_error: f64,
    /// Lines of its repeats; none where only the fit contradicts it.
    pub repeats: Vec<u32>,
    /// Chance that noise takes any value of such a table as far.
    pub p_family: f64,
}

/// Readings that would agree with all others if they were multiplied.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct WrongFactorReport {
    /// The pose; `null` for all poses.
    pub pose: Option<PoseId>,
    /// The component; `null` for all components.
    pub component: Option<&'static str>,
    /// By what (1).
    pub factor: f64,
}

impl From<&BadLoadCaseValue> for BadLoadCaseValueReport {
    fn from(bad: &BadLoadCaseValue) -> Self {
        let micro = |value: f64| value / METRES_PER_MICROMETRE;
        Self {
            line: bad.line,
            pose: bad.pose.clone(),
            component: bad.component,
            unit: unit(bad),
            value: micro(bad.value),
            expected: micro(bad.expected),
            standard_error: micro(bad.standard_error),
            repeats: match &bad.witness {
                ValueWitness::Repeats(lines) => lines.clone(),
                ValueWitness::Fit => Vec::new(),
            },
            p_family: bad.p_family,
        }
    }
}

impl From<&WrongFactor> for WrongFactorReport {
    fn from(wrong: &WrongFactor) -> Self {
        Self {
            pose: wrong.pose.clone(),
            component: wrong.component,
            factor: wrong.factor,
        }
    }
}

fn unit(bad: &BadLoadCaseValue) -> &'static str {
    if bad.is_rotation { "urad" } else { "um" }
}

/// What is bad about a value, what it would have to be, and how sure that is; without a full stop.
#[must_use]
pub fn bad_load_case_value_words(bad: &BadLoadCaseValue) -> String {
    let unit = unit(bad);
    let micro = |value: f64| format!("{} {unit}", significant(value / METRES_PER_MICROMETRE, 4));
    let hint = match bad.decimal_places() {
        _ if bad.is_turned() => "; with the other sign it would agree",
        Some(_) => "; with its decimal point moved it would agree",
        None => "",
    };
    let (who, what) = match &bad.witness {
        ValueWitness::Repeats(lines) => {
            let lines: Vec<String> = lines.iter().map(ToString::to_string).collect();
            let who = match &lines[..] {
                [line] => format!("its repeat (line {line}), which the fit supports, lets expect"),
                _ => format!("its repeats (lines {}) let expect", lines.join(", ")),
            };
            (who, "a bad value")
        }
        ValueWitness::Fit => (
            "the fit to all others lets expect".to_owned(),
            "possibly a bad value: it has no repeat, measure it again",
        ),
    };
    format!(
        "line {}, pose {}: {} is {}, and {who} {}{hint}: {what} (noise alone takes a value as far in {} of such tables)",
        bad.line,
        bad.pose,
        bad.component,
        micro(bad.value),
        micro(bad.expected),
        share_of_tables(bad.p_family)
    )
}

/// Which readings would agree with all others if they were multiplied, and what that may be: a question.
#[must_use]
pub fn wrong_factor_words(wrong: &WrongFactor) -> String {
    let what = match (&wrong.pose, wrong.component) {
        (Some(pose), None) => format!("the readings of pose {pose} agree with the other poses"),
        (None, Some(component)) => format!("{component} agrees with the other components"),
        (pose, component) => {
            let pose = pose.as_ref().map_or_else(String::new, ToString::to_string);
            let component = component.unwrap_or("what was read");
            format!("{component} of pose {pose} agrees with all other readings")
        }
    };
    if wrong.factor < 0.0 {
        return format!("{what} only with the other sign: is an axis or a gauge turned?");
    }
    let is = |factor: f64| (wrong.factor / factor - 1.0).abs() < 1e-3;
    let guess = if is(1e3) {
        "is the unit another one, such as mm under a column for um?"
    } else if is(25.4) {
        "is the unit another one, such as mil (0.001 in) under a column for um?"
    } else if is(1.0 / 4.448_221_6) {
        "are the forces in lbf under a column for N?"
    } else if is(1.0 / 9.806_65) {
        "are the forces in kgf under a column for N?"
    } else {
        "are units and decimal points right?"
    };
    format!(
        "{what} only if multiplied by {}: {guess}",
        significant(wrong.factor, 4)
    )
}
