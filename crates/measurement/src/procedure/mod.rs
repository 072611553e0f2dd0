//! Procedures: which loads are applied where, in which order, and when the gauge is zeroed.
//!
//! A procedure is data: a TOML file of schema `stiffbench/procedure/1`, shipped with the program or the user's own. [`Procedure`]
//! is the plan that has been checked and has all defaults filled in; [`crate::readings::ProcedureRecord`] is what a session's header
//! keeps of it. Guided sessions and the virtual bench both follow [`Procedure::steps`], so a plan means the same on either.

mod pace;
mod parse;
mod plan;
mod problem;
mod reading_limits;
mod shuffle;
mod steps;
mod write;

pub use pace::Pace;
pub use plan::{Procedure, Settle};
pub use problem::{ProcedureError, ProcedureProblem};
pub use reading_limits::LimitVerdict;
pub use shuffle::shuffled;
pub use steps::PlannedReading;
