//! The rows of an uncertainty budget, and what they are worked out from.

use std::fmt;

use serde::{Deserialize, Serialize};

use super::curve::LoadCurve;
use super::gauges::GaugePair;
use super::line::LineFit;
use super::scatter::PooledScatter;

/// What an uncertainty comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum UncertaintySource {
    /// Scatter of the readings.
    Repeatability,
    /// Display step of the force gauge.
    ForceResolution,
    /// Display step of the displacement gauge.
    DisplacementResolution,
    /// Certificate of the force gauge.
    ForceCalibration,
    /// Certificate of the displacement gauge.
    DisplacementCalibration,
    /// Error of a gauge zero that several runs share.
    ZeroSetting,
    /// Difference of the unloaded readings before and after, and what checks of the zeros found.
    ZeroDrift,
}

impl fmt::Display for UncertaintySource {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(match self {
            Self::Repeatability => "repeatability",
            Self::ForceResolution => "resolution of the force gauge",
            Self::DisplacementResolution => "resolution of the displacement gauge",
            Self::ForceCalibration => "calibration of the force gauge",
            Self::DisplacementCalibration => "calibration of the displacement gauge",
            Self::ZeroSetting => "zero setting",
            Self::ZeroDrift => "zero drift",
        })
    }
}

/// Whether a component comes from observed scatter or from other knowledge (GUM 2.3.2, 2.3.3).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
pub enum EvaluationType {
    /// From the scatter of these readings.
    A,
    /// From anything else.
    B,
}

/// Shape of the distribution assumed for a component.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Distribution {
    /// Normal.
    Normal,
    /// Even within its limits.
    Rectangular,
}

/// Whether and why a row counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, schemars::JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum RowUse {
    /// Part of the combined uncertainty.
    Counted,
    /// Shows in the scatter, counted there.
    InRepeatability,
    /// Nothing known of it: not in the combined uncertainty.
    NotStated,
    /// Does not act on this quantity.
    NoEffect,
}

/// One row of the budget.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BudgetRow {
    /// Where it comes from.
    pub source: UncertaintySource,
    /// Type A or B.
    pub evaluation: EvaluationType,
    /// Assumed shape.
    pub distribution: Distribution,
    /// Whether it counts.
    pub standing: RowUse,
    /// Standard uncertainty of the input, in `unit`; `None` if nothing is known.
    pub standard_uncertainty: Option<f64>,
    /// SI unit of `standard_uncertainty`.
    pub unit: &'static str,
    /// Size of the sensitivity coefficient, N/m per `unit`.
    pub sensitivity: f64,
    /// Contribution to the combined standard uncertainty, N/m; zero unless it is counted.
    pub contribution_n_per_m: f64,
    /// Degrees of freedom; infinite for what is taken as known.
    pub dof: f64,
    /// Share of the combined variance, %.
    pub share_percent: f64,
    /// Further remarks.
    pub note: &'static str,
}

/// Known properties of the unloaded state before and after the loads.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Return {
    /// No unloaded reading after the loads.
    NotMeasured,
    /// The mean difference is within its noise.
    WithinNoise,
    /// The mean difference, m.
    Away(f64),
    /// The largest change that checks of the zero found, m, without sign.
    Checked(f64),
}

/// Everything the budget of one cell draws on.
pub(super) struct BudgetInputs<'a> {
    pub(super) curve: &'a LoadCurve,
    pub(super) line: Option<&'a LineFit>,
    pub(super) gauges: &'a GaugePair,
    pub(super) pooled: Option<&'a PooledScatter>,
    pub(super) back_to_zero: Return,
    /// The largest change that checks of the force zero found, N, without sign; zero where there was none.
    pub(super) force_drift_n: f64,
}
