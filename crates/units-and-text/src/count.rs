//! Counts in words.

use std::fmt::Display;

/// A number with what is counted: `1 pose`, `3 poses`; of several words the one before `of` has the plural: `2 degrees of freedom`.
///
/// # Arguments
/// - `count`: as it is printed, so that a rounded number has the form of its digits.
/// - `what`: one of them.
#[must_use]
pub fn counted(count: impl Display, what: &str) -> String {
    let count = count.to_string();
    if count == "1" {
        return format!("1 {what}");
    }
    match what.split_once(" of ") {
        Some((head, of)) => format!("{count} {head}s of {of}"),
        None => format!("{count} {what}s"),
    }
}

/// A duration in hours and minutes, of two hours and more rounded to ten minutes: `45 min`, `6 h 50 min`.
#[must_use]
pub fn hours_and_minutes(minutes: f64) -> String {
    let step = if minutes < 120.0 { 1.0 } else { 10.0 };
    let minutes = (minutes / step).round() * step;
    match ((minutes / 60.0).floor(), minutes % 60.0) {
        (hours, 0.0) if hours > 0.0 => format!("{hours} h"),
        (hours, rest) if hours > 0.0 => format!("{hours} h {rest} min"),
        (_, rest) => format!("{rest} min"),
    }
}

/// Degrees of freedom, to whole ones: `1 degree of freedom`.
#[must_use]
pub fn degrees_of_freedom(dof: f64) -> String {
    counted(format_args!("{dof:.0}"), "degree of freedom")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_is_singular_and_nothing_else_is() {
        assert_eq!(counted(1, "pose"), "1 pose");
        assert_eq!(counted(0, "pose"), "0 poses");
        assert_eq!(counted(11, "accepted reading"), "11 accepted readings");
        assert_eq!(degrees_of_freedom(1.2), "1 degree of freedom");
        assert_eq!(degrees_of_freedom(1.7), "2 degrees of freedom");
    }

    #[test]
    fn long_durations_have_hours() {
        assert_eq!(hours_and_minutes(0.4), "0 min");
        assert_eq!(hours_and_minutes(44.6), "45 min");
        assert_eq!(hours_and_minutes(60.0), "1 h");
        assert_eq!(hours_and_minutes(118.0), "1 h 58 min");
        assert_eq!(hours_and_minutes(178.0), "3 h");
        assert_eq!(hours_and_minutes(409.0), "6 h 50 min");
    }
}
