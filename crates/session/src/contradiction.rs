//! Whoever can compare the readings of a session with their repeats.

pub use stiffbench_measurement::run_check::Contradiction;

use super::state::SessionState;

/// Holds the readings of a session against their repeats: the session itself knows no statistics.
pub trait RepeatCheck {
    /// The readings of a cell that their repeats contradict, the worst first.
    ///
    /// # Arguments
    /// - `cell`: place of the cell in the plan, from 0; all its readings are taken or left out.
    fn contradictions(&self, state: &SessionState, cell: usize) -> Vec<Contradiction>;
}
