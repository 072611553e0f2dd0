//! Where in the residuals structure sits.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_units_and_text::quantity::micro;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

/// A row of the decomposition of the residuals.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord, Serialize, Deserialize, JsonSchema,
)]
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

/// A place where the baseline fails.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Location {
    /// What fails.
    pub stratum: Stratum,
    /// In which pose, if in one.
    pub pose: Option<PoseId>,
    /// In which direction, if in one.
    pub direction: Option<Direction>,
    /// Chance that noise alone shows as much anywhere.
    #[schemars(range(min = 0.0, max = 1.0))]
    pub p_family: f64,
    /// Whether that is the smallest chance that the draws for a coarse gauge can show.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub p_at_floor: bool,
    /// Period of a swing of the clock, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub period_s: Option<f64>,
    /// Largest change of a reading by the pattern, m; in files µm.
    #[serde(
        rename = "size_um",
        serialize_with = "micro::serialize",
        deserialize_with = "micro::deserialize"
    )]
    pub size_m: f64,
}
