//! What to measure next.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiffbench_measurement::procedure::Procedure;

/// A plan that would separate what these readings leave open.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct NextMeasurement {
    /// What to do, in one sentence.
    pub plan: String,
    /// The two explanations that it separates, as [`stiffbench_beams::physics::title`] names them, or in words where they are no laws.
    pub separates: [String; 2],
    /// Expected natural logarithm of the likelihood ratio between them, below 3 if the plan does not settle it; `None` for a check
    /// without loads, which decides by itself, and where one of the two is no law.
    pub expected_log_lr: Option<f64>,
    /// Time at the bench, minutes.
    pub minutes: f64,
    /// Procedure file of the plan, where one was written.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// The plan as a procedure; `None` for a check without loads.
    #[serde(skip)]
    pub procedure: Option<Procedure>,
}

impl NextMeasurement {
    /// A check without loads.
    pub(super) fn check(plan: String, minutes: f64, separates: [String; 2]) -> Self {
        Self {
            plan,
            separates,
            expected_log_lr: None,
            minutes,
            file: None,
            procedure: None,
        }
    }
}
