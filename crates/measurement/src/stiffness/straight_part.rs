//! The stiffness of a part of the loads.

use std::fmt;

use super::rounding::{RoundedValue, format_value_uncertainty};
use stiffbench_numeric::statistics::Estimate;
use stiffbench_units_and_text::digits::significant;

/// Loads that lie on a line where all of them do not: a seated part behind a toe or a preload, or what comes before a yield.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StraightPart {
    /// The first and the last of the loads, N.
    pub ends_n: [f64; 2],
    /// Stiffness there, N/m, with the uncertainty that these loads give it.
    pub stiffness: Estimate,
}

impl fmt::Display for StraightPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let n_per_um = self.stiffness.value / 1e6;
        let expanded = self.stiffness.expanded_95();
        let rounded = expanded.and_then(|u| format_value_uncertainty(n_per_um, u / 1e6));
        let k = match rounded {
            Some(RoundedValue { value, uncertainty }) => format!("({value} ± {uncertainty}) N/µm"),
            None => format!("{} N/µm", significant(n_per_um, 4)),
        };
        let [from, to] = self.ends_n;
        write!(
            f,
            "The loads from {from} to {to} N do lie on one, a range chosen after the curve was seen: K = {k} there"
        )
    }
}
