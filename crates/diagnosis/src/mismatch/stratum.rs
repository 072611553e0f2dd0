//! Where in the residuals structure sits.

use std::fmt;

use schemars::JsonSchema;
use serde::Serialize;

/// A row of the decomposition of the residuals.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Stratum {
    /// One set of factors does not serve all cells.
    CellSlope,
    /// Curvature, dead zone, steps over the load.
    LoadStep,
    /// Loading and unloading differ.
    Branch,
    /// Trend over repeats or the clock.
    RepeatTime,
    /// Positive and negative loads differ.
    Sign,
    /// Size of the noise, outliers, functions of the reading.
    Rest,
}

/// Its name in files.
impl fmt::Display for Stratum {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

impl Stratum {
    /// All strata, in the order of the method.
    pub const ALL: [Self; 6] = [
        Self::CellSlope,
        Self::LoadStep,
        Self::Branch,
        Self::RepeatTime,
        Self::Sign,
        Self::Rest,
    ];
}
