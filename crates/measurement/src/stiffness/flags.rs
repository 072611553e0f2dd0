//! What looks wrong in a cell. A flag is raised, nothing is taken away.

use thiserror::Error;

use super::significance::TestStatistic;
use super::straight_part::StraightPart;
use stiffbench_units_and_text::count::counted;
use stiffbench_units_and_text::digits::significant;

/// An outlier as many times as far off as its limit puts the stiffness in doubt: it moves the slope of five runs of eight readings by 1.2 standard
/// errors, where U is 2.8.
const FAR: f64 = 2.0;

/// A reading, by the numbers that find it again.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ReadingPlace {
    /// Sequence number in the session.
    pub seq: u32,
    /// Line of the file; 0 if none.
    pub line: u32,
}

/// Something about the readings of a cell that its stiffness does not show, in a sentence.
#[derive(Debug, Clone, PartialEq, Error)]
#[error("{message}")]
pub struct Flag {
    /// Stable name of the rule.
    pub rule: &'static str,
    /// What was found.
    pub message: String,
    /// Size of what was found, in the unit of the rule, SI.
    pub size: f64,
    /// The test behind the flag, if it is a question of scatter.
    pub test: Option<TestStatistic>,
    /// The reading that is flagged; `None` of a flag on several.
    pub reading: Option<ReadingPlace>,
    /// The loads that lie on a line, where a flag says that not all do.
    pub straight_part: Option<StraightPart>,
}

impl Flag {
    pub(super) fn new(rule: &'static str, size: f64, message: String) -> Self {
        Self {
            rule,
            message,
            size,
            test: None,
            reading: None,
            straight_part: None,
        }
    }

    /// A flag behind a test, with threshold and power.
    ///
    /// # Arguments
    /// - `detectable`: prints [`TestStatistic::detectable`].
    pub(super) fn tested(
        rule: &'static str,
        size: f64,
        found: &str,
        test: TestStatistic,
        detectable: fn(f64) -> String,
    ) -> Self {
        let message = format!(
            "{found}: {:.2} standard errors, limit {:.2} for 5 % over {}; 80 % of cases of {} would be found",
            test.statistic,
            test.limit,
            counted(test.n_tested, "comparison"),
            detectable(test.detectable)
        );
        let test = Some(test);
        Self {
            test,
            ..Self::new(rule, size, message)
        }
    }

    /// Whether the stiffness itself is in doubt. An outlier at its limit moves the slope of a cell by less than its U.
    #[must_use]
    pub fn spoils_stiffness(&self) -> bool {
        match (self.rule, self.test) {
            ("outlier", Some(test)) => test.statistic > FAR * test.limit,
            ("negative-stiffness" | "slope-not-resolved" | "not-straight", _) => true,
            _ => false,
        }
    }
}

/// A length in micrometres, to hundredths.
pub(super) fn um(metres: f64) -> String {
    format!("{:.2} µm", metres * 1e6)
}

/// The same of a change, with its sign.
pub(super) fn signed_um(metres: f64) -> String {
    format!("{:+.2} µm", metres * 1e6)
}

pub(super) fn percent(share: f64) -> String {
    format!("{} % per repeat", significant(100.0 * share, 3))
}

/// A change in percent, with its sign.
pub(super) fn signed_percent(share: f64) -> String {
    let sign = if share < 0.0 { "-" } else { "+" };
    format!("{sign}{} %", significant(100.0 * share.abs(), 3))
}

/// The stiffness of a half of the loads.
pub(super) fn half(([from, to], stiffness_n_per_m): &([f64; 2], f64)) -> String {
    format!(
        "{} N/µm from {from} to {to} N",
        significant(stiffness_n_per_m / 1e6, 4)
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_tested_flag_states_threshold_and_power() {
        let test = TestStatistic::new(5.8, 4.02, 480, 6.7e-6);
        assert_eq!(
            Flag::tested("outlier", -31e-6, "it is off", test, um).to_string(),
            "it is off: 5.80 standard errors, limit 4.02 for 5 % over 480 comparisons; 80 % of cases of 32.57 µm would be found"
        );
    }
}
