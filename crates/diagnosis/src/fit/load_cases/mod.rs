//! Load cases: forces and displacements as vectors, one load application a pose, repeats only where there are any.
//!
//! With joint springs as parameters and rigid links the fit is the virtual joint method (Salisbury 1980; Dumas, Caro, Chérif, Garnier & Furet,
//! Robotica 30, 2012); beams and springs are fitted together in the same way.
//!
//! Absolute positions by a tracker are load cases too (elastic calibration): own weight acts, and base frame and tool point are fitted beside.

pub(super) mod fit;
pub(super) mod frames;
pub(super) mod posed;
pub(super) mod positions;
pub(super) mod prediction;
pub(super) mod problem;
pub(super) mod scatter;
pub(super) mod series;
