//! Bad values of load cases in words.

use crate::elastostatics::{BadLoadCaseValue, WrongFactor};

use super::text::{micro, share_of_tables, significant};

/// What is bad about a value, what it would have to be, and how sure that is; without a full stop.
#[must_use]
pub fn bad_load_case_value_words(bad: &BadLoadCaseValue) -> String {
    let in_unit = |value: f64| {
        let value = significant(micro(value), 4);
        format!("{value} {}", bad.unit)
    };
    let hint = match bad.decimal_places() {
        _ if bad.is_turned() => "; with the other sign it would agree",
        Some(_) => "; with its decimal point moved it would agree",
        None => "",
    };
    let lines: Vec<String> = bad.repeats.iter().map(ToString::to_string).collect();
    let who = match &lines[..] {
        [] => "the fit to all others lets expect".to_owned(),
        [line] => format!("its repeat (line {line}), which the fit supports, lets expect"),
        _ => format!("its repeats (lines {}) let expect", lines.join(", ")),
    };
    let what = if lines.is_empty() {
        "possibly a bad value: it has no repeat, measure it again"
    } else {
        "a bad value"
    };
    format!(
        "line {}, pose {}: {} is {}, and {who} {}{hint}: {what} (noise alone takes a value as far in {} of such tables)",
        bad.line,
        bad.pose,
        bad.component,
        in_unit(bad.value),
        in_unit(bad.expected),
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
