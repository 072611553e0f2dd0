//! What every fit needs to know.

use crate::robot::{FittingFactors, Mechanism, Robot};

use super::measured::MeasuredStiffness;

/// A mechanism, the stiffness it was measured to have, and the factors to start from.
#[derive(Debug, Clone, Copy)]
pub struct FitProblem<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// The mechanism that was measured.
    pub mechanism: &'a Mechanism,
    /// Stiffness of the cells.
    pub measured: &'a MeasuredStiffness,
    /// Where the search starts; factors that do not move keep these values.
    pub start: &'a FittingFactors,
}
