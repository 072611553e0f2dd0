//! Fitting factors from measured or reference stiffness.
//!
//! - [`CellModel`]: stiffness of pose and direction as a function of the parameters, with exact derivatives;
//! - [`FixedPhysics`]: what acts beside the beams while they are fitted;
//! - [`significance`]: which factor matters where (the paper's Table III, and exact shares);
//! - [`fit_in_sequence`], [`combine`], [`follow_paper`]: the paper's nine steps;
//! - [`MeasuredStiffness`], [`FitProblem`], [`fit_cells`]: the joint least-squares fit, its intervals, its judgement on poses it did not see;
//! - [`Refitter`]: the same fit to other values, by the thousand.

mod between_runs;
mod bootstrap;
mod cell_model;
mod combine;
mod error;
mod fit_cells;
mod fixed_physics;
mod intervals;
mod joint;
mod measured;
mod monte_carlo;
mod outcome;
mod parameters;
mod physics_model;
mod problem;
mod procedure;
mod refit;
mod shares;
mod significance;
mod stiffness_list;

pub use bootstrap::{BootstrapIntervals, ResampledUnit, bootstrap_cells};
pub use cell_model::CellModel;
pub use combine::combine;
pub use error::FitError;
pub use fit_cells::{FitOptions, find_lower_minimum, fit_cells};
pub use fixed_physics::FixedPhysics;
pub(crate) use intervals::{covariance_if_any, open_words};
pub use measured::{
    LnUncertainty, MeasuredCell, MeasuredCompliance, MeasuredStiffness, WeightBasis,
};
pub use monte_carlo::{MonteCarloFit, MonteCarloSettings, MonteCarloStep, fit_in_sequence};
pub use outcome::{
    BootstrapDraws, FactorCorrelations, FactorEstimate, FactorStatus, FitAgreement, FitMethod,
    FitOutcome, FittedCell, FittedCompliance,
};
pub(crate) use parameters::FitParameters;
pub use problem::FitProblem;
pub use procedure::{
    PaperFit, PaperOptions, PaperSource, PoseFit, fit_single_source, follow_paper,
};
pub use refit::{Refit, Refitter};
pub use shares::Shares;
pub use significance::{
    PAPER_FACTOR, ParameterSignificance, Scope, SectionSignificance, SequenceStep, significance,
};
pub use stiffness_list::{StiffnessListError, is_stiffness_list, read_stiffness_list};
