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
}
