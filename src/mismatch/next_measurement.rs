//! What to measure next.

/// A plan that would separate what these readings leave open.
#[derive(Debug, Clone, PartialEq)]
pub struct NextMeasurement {
    /// What to do, in one sentence.
    pub plan: String,
    /// The two explanations that it separates, as [`crate::physics::title`] names them.
    pub separates: [String; 2],
    /// Expected natural logarithm of the likelihood ratio between them; below 3 the plan does not settle it.
    pub expected_log_lr: f64,
    /// Time at the bench, minutes.
    pub minutes: f64,
    /// Procedure file of the plan, where one was written.
    pub file: Option<String>,
}
