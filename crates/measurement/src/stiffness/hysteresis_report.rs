//! The loop between loading and unloading as a result.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::hysteresis::{Hysteresis, LargestWidth, LoopWidth, NoHysteresis};
use stiffbench_numeric::reported::Reported;
use stiffbench_numeric::statistics::Estimate;
use stiffbench_units_and_text::quantity::METRES_PER_MICROMETRE;

/// Joules in a microjoule.
const JOULES_PER_MICROJOULE: f64 = 1e-6;

/// The loop between loading and unloading of a cell, along the load.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct HysteresisReport {
    /// Number of loops.
    pub n_loops: usize,
    /// Width at each load that was read in both branches: displacement while unloading less that while loading at the same measured force, positive
    /// where the displacement lags behind.
    pub widths: Vec<LoopWidthReport>,
    /// The largest of these widths.
    pub largest: LargestWidthReport,
    /// Displacement that remains without load, the width there; drift and creep are not taken off.
    pub residual_displacement: Reported,
    /// Distance of the middle of both branches between +3 and -3 % of the largest load.
    pub lost_motion: Reported,
    /// Inverse slope of displacement on force while loading.
    pub stiffness_loading: Reported,
    /// The same while unloading.
    pub stiffness_unloading: Reported,
    /// Energy lost in a loop, its area.
    pub energy: Reported,
    /// Forces between which a straight line closes the loop for its area; not there of one that ends where it began.
    #[serde(rename = "closing_line_N", skip_serializing_if = "Option::is_none")]
    pub closing_line_n: Option<[f64; 2]>,
}

/// Width of the loop at one load.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LoopWidthReport {
    /// Target force.
    #[serde(rename = "target_N")]
    pub target_n: f64,
    /// Force at which the branches are compared: the mean of those measured.
    #[serde(rename = "force_N")]
    pub force_n: f64,
    /// The width.
    pub width: Reported,
}

/// The largest width of the loop.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct LargestWidthReport {
    /// Target force at which it was found.
    #[serde(rename = "target_N")]
    pub target_n: f64,
    /// The width, with a 95 % interval that holds over all loads at once.
    pub width: Reported,
}

impl HysteresisReport {
    /// The report on a loop, with the stiffness of both branches in N/um.
    #[must_use]
    pub fn new(found: &Hysteresis, [loading, unloading]: [Reported; 2]) -> Self {
        let either = |value: Result<Estimate, NoHysteresis>| match value {
            Ok(estimate) => um(&estimate),
            Err(reason) => Reported::missing("um", reason.to_string()),
        };
        Self {
            n_loops: found.n_loops,
            widths: found.widths.iter().map(Into::into).collect(),
            largest: (&found.largest).into(),
            residual_displacement: either(found.residual_m),
            lost_motion: either(found.lost_motion_m),
            stiffness_loading: loading,
            stiffness_unloading: unloading,
            energy: Reported::from_estimate(&found.energy_j, JOULES_PER_MICROJOULE, "uJ"),
            closing_line_n: found.closing_line_n,
        }
    }
}

fn um(estimate: &Estimate) -> Reported {
    Reported::from_estimate(estimate, METRES_PER_MICROMETRE, "um")
}

impl From<&LoopWidth> for LoopWidthReport {
    fn from(width: &LoopWidth) -> Self {
        Self {
            target_n: width.target_n,
            force_n: width.force_n,
            width: um(&width.width_m),
        }
    }
}

impl From<&LargestWidth> for LargestWidthReport {
    fn from(largest: &LargestWidth) -> Self {
        let width = largest.width_m / METRES_PER_MICROMETRE;
        let interval = |ends: [f64; 2]| ends.map(|end| end / METRES_PER_MICROMETRE);
        Self {
            target_n: largest.target_n,
            width: match largest.interval_m {
                Some(ends) => Reported::with_interval(width, interval(ends), "um"),
                None => Reported {
                    reason: Some("no interval: a single loop".to_owned()),
                    ..Reported::exact(width, "um")
                },
            },
        }
    }
}
