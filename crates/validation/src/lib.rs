//! What checks the tool.
//!
//! - [`prove`]: whether a diagnosis can be trusted: blind verdicts scored against sealed answers, error rates, recordings by others.
//! - [`mod@reference`]: a robot as solids, for a program of others to hold the beams against.

pub mod prove;
pub mod reference;
