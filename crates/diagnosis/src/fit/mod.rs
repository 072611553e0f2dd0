//! Fitting factors from measured or reference stiffness.
//!
//! - [`CellModel`]: stiffness of pose and direction as a function of the parameters, with exact derivatives;
//! - [`FixedPhysics`]: what acts beside the beams while they are fitted;
//! - [`robot significance`]: which factor matters where (the paper's Table III, and exact shares);
//! - [`fit_in_sequence`], [`combine`], [`follow_paper`]: the paper's nine steps;
//! - [`MeasuredStiffness`], [`FitProblem`], [`fit_cells`]: the joint least-squares fit, its intervals, its judgement on poses it did not see;
//! - [`PosedLoadCases`], [`fit_load_cases`]: a table of load cases in the poses and axes of a robot, and the same fit of all its components;
//! - [`bad_load_case_values`], [`table_mistake`]: what is wrong with such a table;
//! - [`plan_load_cases`], [`plan_beside_cells`], [`best_poses`]: which further pose and load would determine what is open, which poses are best before anything was measured;
//! - [`PoseRules`], [`ProposedWithin`]: which poses may be proposed;
//! - [`usual_parameters`], [`usual_choice`]: which parameters are free unless the user says;
//! - [`Refitter`]: the same fit to other values, by the thousand.

mod best_poses;
mod between_runs;
mod bootstrap;
mod cell_model;
mod choice;
mod combine;
mod error;
mod fit_cells;
mod fixed_physics;
mod intervals;
mod joint;
mod load_cases;
mod measured;
mod mistakes;
mod monte_carlo;
mod outcome;
mod parameters;
mod plan;
mod problem;
mod procedure;
mod proposed_poses;
mod refit;
mod shares;
mod significance;
mod weighed_problem;

pub use best_poses::{BestPoses, best_poses};
pub use bootstrap::{BootstrapIntervals, ResampledUnit, bootstrap_cells};
pub use cell_model::CellModel;
pub use choice::{spring_choice, usual_choice, usual_parameters};
pub use combine::combine;
pub use error::FitError;
pub use fit_cells::{FitOptions, find_lower_minimum, fit_cells};
pub use fixed_physics::FixedPhysics;
pub use load_cases::fit::fit_load_cases;
pub use load_cases::posed::{PosedLoad, PosedLoadCases, ReadComponent};
pub use load_cases::problem::LoadCaseModel;
pub use measured::{
    LnUncertainty, MeasuredCell, MeasuredCompliance, MeasuredStiffness, WeightBasis,
};
pub use mistakes::{ExchangedWith, TableMistake, bad_load_case_values, table_mistake};
pub use monte_carlo::{MonteCarloFit, MonteCarloSettings, MonteCarloStep, fit_in_sequence};
pub use outcome::{
    BootstrapDraws, FactorCorrelations, FactorEstimate, FactorStatus, FitAgreement, FitMethod,
    FitOutcome, FittedCell, FittedCompliance, FittedComponent, FittedFrames, FrameParameter,
    PoseError, StatusWord,
};
pub use plan::{
    NextStandardError, PlannedLoadCase, PlannedLoadCases, plan_beside_cells, plan_load_cases,
};
pub use problem::FitProblem;
pub use procedure::{
    PaperFit, PaperOptions, PaperSource, PoseFit, fit_single_source, follow_paper,
};
pub use proposed_poses::{PoseRules, ProposedWithin};
pub use refit::{Refit, Refitter};
pub use shares::Shares;
pub use significance::{
    PAPER_FACTOR, ParameterSignificance, Scope, SectionSignificance, SequenceStep, significance,
};
