//! What is doubtful about load cases and a fit to them, in words.

use crate::fit::TableMistake;
use crate::mismatch::{BadReading, BadReadingKind, OtherJointValue, ReadQuantity};

use super::text::{reading_shown, share_of_tables, significant};

/// What is bad about values, what they would have to be, and how sure that is; without a full stop. Coordinates of one position stand together.
pub(super) fn bad_value_words(all: &[BadReading]) -> Vec<String> {
    let is_position = |bad: &BadReading| bad.quantity == ReadQuantity::Position;
    let together = all.chunk_by(|a, b| is_position(a) && a.line == b.line);
    let words = together.map(|bad| match bad {
        [one] if !is_position(one) => value_words(one),
        coordinates => position_words(coordinates),
    });
    words.collect()
}

/// Coordinates of one position.
fn position_words(bad: &[BadReading]) -> String {
    let Some(first) = bad.first() else {
        return String::new();
    };
    let list = |of: &dyn Fn(&BadReading) -> String| -> String {
        let all: Vec<String> = bad.iter().map(of).collect();
        all.join(", ")
    };
    let mm = |metres: f64| reading_shown(metres, ReadQuantity::Position, 4).0;
    let axes = list(&|one| one.direction.to_string());
    let read = list(&|one| mm(one.value_m));
    let expected = list(&|one| mm(one.expected_m));
    let joint = first.joint.as_ref().map_or_else(String::new, |joint| {
        let OtherJointValue {
            variable,
            stated,
            agrees,
            unit,
        } = joint;
        format!("; it agrees with {variable} = {agrees:.4} {unit} in place of {stated:.4} {unit}")
    });
    let what = if bad.len() > 1 {
        "a bad position, or another pose than the table has"
    } else {
        "a bad value"
    };
    format!(
        "line {}, pose {}: position {axes} is {read} mm, and the fit to all others lets expect {expected} mm{joint}: possibly {what}, measure it again \
         (noise alone takes positions as far in {} of such tables)",
        first.line,
        first.pose,
        share_of_tables(first.p_family)
    )
}

fn value_words(bad: &BadReading) -> String {
    let in_unit = |value: f64| {
        let (value, unit) = reading_shown(value, bad.quantity, 4);
        format!("{value} {unit}")
    };
    let hint = match bad.kind {
        BadReadingKind::Sign => "; with the other sign it would agree",
        BadReadingKind::DecimalPoint(_) => "; with its decimal point moved it would agree",
        BadReadingKind::Any => "",
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
        "line {}, pose {}: {} {} is {}, and {who} {}{hint}: {what} (noise alone takes a value as far in {} of such tables)",
        bad.line,
        bad.pose,
        bad.quantity,
        bad.direction,
        in_unit(bad.value_m),
        in_unit(bad.expected_m),
        share_of_tables(bad.p_family)
    )
}

/// What would agree with all others if the table were put right, and what that may be: a question.
#[must_use]
pub(super) fn table_mistake_words(mistake: &TableMistake) -> String {
    if let Some(joint) = &mistake.joint {
        return format!(
            "all readings agree with the robot only if the values of joint {joint} have the other sign: does the controller count it the other way?"
        );
    }
    let component = mistake.component.unwrap_or("what was read");
    if let Some(other) = mistake.exchanged_with {
        let place = mistake
            .pose
            .as_ref()
            .map_or_else(String::new, |pose| format!(" of pose {pose}"));
        return format!(
            "{component} and {other}{place} agree with all other readings only if they are exchanged: is one under the name of the other?"
        );
    }
    let what = match (&mistake.pose, mistake.component) {
        (Some(pose), None) => format!("the readings of pose {pose} agree with the other poses"),
        (None, Some(component)) => format!("{component} agrees with the other components"),
        (pose, _) => {
            let pose = pose.as_ref().map_or_else(String::new, ToString::to_string);
            format!("{component} of pose {pose} agrees with all other readings")
        }
    };
    let own = mistake.factor.unwrap_or(1.0);
    if own < 0.0 {
        return format!("{what} only with the other sign: is an axis or a gauge turned?");
    }
    let is = |factor: f64| (own / factor - 1.0).abs() < 1e-3;
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
        significant(own, 4)
    )
}
