//! Whoever can compare the readings of a session with their repeats.

use super::state::SessionState;

/// Readings of a run that its repeats contradict.
#[derive(Debug, Clone, PartialEq)]
pub struct Contradiction {
    /// Numbers of the readings, all of one run.
    pub numbers: Vec<u32>,
    /// Which they are, what was read and what would have been expected: one sentence for the operator.
    pub text: String,
}

/// Holds the readings of a session against their repeats: the session itself knows no statistics.
pub trait RepeatCheck {
    /// The readings of a cell that their repeats contradict, the worst first.
    ///
    /// # Arguments
    /// - `cell`: place of the cell in the plan, from 0; all its readings are taken or left out.
    fn contradictions(&self, state: &SessionState, cell: usize) -> Vec<Contradiction>;
}
