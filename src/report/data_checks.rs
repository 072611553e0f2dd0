//! What is doubtful about load cases and a fit to them, in words.

use crate::fit::{ExchangedWith, TableMistake};
use crate::mismatch::{BadReading, OtherJointValue, ReadQuantity};

use super::diagnosis::DataFindingKind;

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
        "line {}, pose {}: position {axes} is {read} mm, but the fit to all other values predicts {expected} mm{joint}: possibly {what}; measure it again \
         (noise alone moves a position this far in {} of such tables)",
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
    let hint = bad.factor.map_or_else(String::new, |factor| {
        format!("; {} it would agree", factor_words(factor))
    });
    let lines: Vec<String> = bad.repeats.iter().map(ToString::to_string).collect();
    let who = match &lines[..] {
        [] => "the fit to all other values predicts".to_owned(),
        [line] => format!("its repeat (line {line}), which the fit supports, predicts"),
        _ => format!("its repeats (lines {}) predict", lines.join(", ")),
    };
    let what = if lines.is_empty() {
        "possibly a bad value, which has no repeat; measure it again"
    } else {
        "a bad value"
    };
    format!(
        "line {}, pose {}: {} {} is {}, but {who} {}{hint}: {what} (noise alone moves a value this far in {} of such tables)",
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
    if mistake.mirrored {
        let or = mistake.joint.as_ref().map_or_else(String::new, |joint| {
            format!(" The other sign of joint {joint} would explain them as well.")
        });
        return format!(
            "all positions agree with the robot only if they are mirrored: are two coordinates exchanged, or has one the other sign (left-handed axes)?{or}"
        );
    }
    if let Some(joint) = &mistake.joint {
        return format!(
            "all readings agree with the robot only if the values of joint {joint} have the other sign: does the controller count it the other way?"
        );
    }
    let component = mistake.component.as_deref().unwrap_or("what was read");
    let pose = mistake.pose.as_ref();
    let of_pose = pose.map_or_else(String::new, |pose| format!(" of pose {pose}"));
    let both = match &mistake.exchanged_with {
        Some(ExchangedWith::Component(other)) => {
            Some(format!("{component} and {other}{of_pose} agree"))
        }
        Some(ExchangedWith::Pose(other)) => {
            Some(format!("{component}{of_pose} and of pose {other} agree"))
        }
        None => None,
    };
    if let Some(both) = both {
        return format!(
            "{both} with all other readings only if they are exchanged: are their names swapped?"
        );
    }
    let what = match (pose, &mistake.component) {
        (Some(pose), None) => format!("the readings of pose {pose} agree with the other poses"),
        (None, Some(component)) => format!("{component} agrees with the other components"),
        (None, None) => "all positions agree with the robot".to_owned(),
        _ => format!("{component}{of_pose} agrees with all other readings"),
    };
    let factor = mistake.factor.unwrap_or(1.0);
    // Positions are stated in mm, displacements in µm.
    let of = mistake.component.as_deref();
    let is_of_positions = pose.is_none() && of.is_none_or(|of| of.starts_with("position"));
    let unit = match usual_unit(factor) {
        Some(_) if is_of_positions && factor > 10.0 && factor < 100.0 => {
            Some("are they in inches where mm are stated")
        }
        Some(_) if is_of_positions => None,
        unit => unit,
    };
    let guess = match unit {
        _ if factor < 0.0 => "is an axis or a gauge turned?".to_owned(),
        Some(unit) => format!("{unit}?"),
        None => "are units and decimal points right?".to_owned(),
    };
    let how = match (pose, of) {
        (None, None) => format!("if multiplied by {}", significant(factor, 4)),
        _ => factor_words(factor),
    };
    format!("{what} only {how}: {guess}")
}

/// How a value is put right by a factor.
#[must_use]
pub(super) fn factor_words(factor: f64) -> String {
    let times = significant(factor, 4);
    match DataFindingKind::of_factor(factor) {
        DataFindingKind::Sign => "with the other sign".to_owned(),
        DataFindingKind::DecimalPoint => format!("with its decimal point moved (times {times})"),
        _ => format!("if multiplied by {times}"),
    }
}

/// The unit that explains a factor by which displacements under loads must be multiplied.
#[must_use]
pub(super) fn usual_unit(factor: f64) -> Option<&'static str> {
    let is = |other: f64| (factor / other - 1.0).abs() < 1e-3;
    let known = [
        (1e3, "are they mm where µm are stated"),
        (
            25.4,
            "are they in inches where mm are stated, or mil (0.001 in) where µm are",
        ),
        (
            1.0 / 4.448_221_6,
            "are the forces in lbf where N are stated",
        ),
        (1.0 / 9.806_65, "are the forces in kgf where N are stated"),
    ];
    let known = known.into_iter().find(|(other, _)| is(*other));
    known.map(|(_, words)| words)
}
