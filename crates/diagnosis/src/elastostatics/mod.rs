//! Parameters of a robot from load cases: forces and displacements as vectors, one load application a pose, repeats only where there are any.
//!
//! With joint springs as parameters and rigid links this is the virtual joint method (Salisbury 1980; Dumas, Caro, Chérif, Garnier & Furet,
//! Robotica 30, 2012); beams and springs are fitted together in the same way.
//!
//! Absolute positions by a tracker are load cases too (elastic calibration): own weight acts, and base frame and tool point are fitted beside.
//!
//! - [`PosedLoadCases`]: a table of load cases in the poses and axes of a robot;
//! - [`fit_load_cases`]: least squares over all components, scatter from repeats or from the residuals;
//! - [`bad_load_case_values`], [`table_mistake`]: what is wrong with a table;
//! - [`plan_load_cases`]: which further pose and load would determine what is open;
//! - [`best_poses`]: which poses determine parameters best before anything was measured;
//! - [`usual_parameters`], [`usual_choice`]: which parameters are free unless the user says.

mod best_poses;
mod choice;
mod error;
mod fit;
mod frames;
mod held_out;
mod intervals;
mod mistakes;
mod outcome;
mod plan;
mod posed;
mod positions;
mod prediction;
mod problem;
mod scatter;
mod series;

pub use best_poses::{BestPoses, PoseReadings, best_poses};
pub use choice::{spring_choice, usual_choice, usual_parameters};
pub use error::LoadCaseFitError;
pub use fit::{LoadCaseFitOptions, fit_load_cases};
pub use mistakes::{TableMistake, bad_load_case_values, table_mistake};
pub use outcome::{
    FittedComponent, FittedFrames, FrameParameter, LoadCaseAgreement, LoadCaseFit, PoseError,
    ScatterSource,
};
pub use plan::{FitKnowledge, NextStandardError, PlannedLoadCase, plan_load_cases, planned_table};
pub use posed::{PosedLoad, PosedLoadCases, ReadComponent};
pub use problem::LoadCaseModel;
pub use series::TrackedPoses;
