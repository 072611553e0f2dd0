//! What makes a fit impossible to start, as opposed to a fit that stopped early (`Termination`).

use std::error::Error;

use miette::Diagnostic;
use thiserror::Error as ThisError;

use super::residual_function::EvaluationFailure;

/// Why a fit, or a statement about a fit, could not be made at all.
#[derive(Debug, ThisError, Diagnostic)]
pub enum LeastSquaresError {
    /// A start, bound, value or ratio is NaN or infinite where it may not be.
    #[error("parameter `{name}`: {what} is {value}")]
    #[diagnostic(
        code(stiffbench::least_squares::not_finite),
        help("give a finite number; only bounds may be infinite, and only away from the start")
    )]
    NotFinite {
        /// The parameter.
        name: String,
        /// Which of its numbers.
        what: &'static str,
        /// The number.
        value: f64,
    },
    /// The lower bound is not below the upper one.
    #[error("parameter `{name}`: the bounds {lower} to {upper} leave nothing to choose")]
    #[diagnostic(
        code(stiffbench::least_squares::empty_range),
        help("put the lower bound below the upper one, or fix the parameter")
    )]
    EmptyRange {
        /// The parameter.
        name: String,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// The start is not within the bounds.
    #[error("parameter `{name}` starts at {start}, outside its bounds {lower} to {upper}")]
    #[diagnostic(
        code(stiffbench::least_squares::start_outside_bounds),
        help("move the start inside or widen the bounds")
    )]
    StartOutsideBounds {
        /// The parameter.
        name: String,
        /// Start value.
        start: f64,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// A tie names a parameter that is not there.
    #[error(
        "parameter `{name}` is tied to parameter number {index}, but there are {count}, counted from 0"
    )]
    #[diagnostic(
        code(stiffbench::least_squares::unknown_tie),
        help("tie it to one of the parameters of the same set")
    )]
    UnknownTie {
        /// The tied parameter.
        name: String,
        /// The index it names.
        index: usize,
        /// Number of parameters.
        count: usize,
    },
    /// Ties that lead back to their beginning.
    #[error("the ties form a cycle: {}", names.join(" -> "))]
    #[diagnostic(
        code(stiffbench::least_squares::tie_cycle),
        help("make one of these parameters free or fixed")
    )]
    TieCycle {
        /// The parameters, in the order of the ties, first and last the same.
        names: Vec<String>,
    },
    /// Two parameters of one name.
    #[error("two parameters are called `{name}`")]
    #[diagnostic(
        code(stiffbench::least_squares::duplicate_name),
        help("names identify parameters in results; rename one")
    )]
    DuplicateName {
        /// The name.
        name: String,
    },
    /// Nothing to fit.
    #[error("none of the {count} parameters is free")]
    #[diagnostic(
        code(stiffbench::least_squares::no_free_parameter),
        help(
            "free at least one, for example with --parameter joint.NAME=free; `stiffbench diagnose` needs no free parameter"
        )
    )]
    NoFreeParameter {
        /// Number of parameters.
        count: usize,
    },
    /// Nothing to fit to.
    #[error("there are no residuals to minimise")]
    #[diagnostic(
        code(stiffbench::least_squares::no_residuals),
        help("check that the selection of readings is not empty")
    )]
    NoResiduals,
    /// An index beyond the parameters.
    #[error("there is no parameter number {index}; there are {count}, counted from 0")]
    #[diagnostic(
        code(stiffbench::least_squares::unknown_parameter),
        help("use the index of a parameter of this set")
    )]
    UnknownParameter {
        /// The index asked for.
        index: usize,
        /// Number of parameters.
        count: usize,
    },
    /// A statement that only a free parameter can have.
    #[error("parameter `{name}` is {role}, so it has no interval of its own")]
    #[diagnostic(
        code(stiffbench::least_squares::not_free),
        help("free the parameter, or ask for the one it is tied to")
    )]
    NotFree {
        /// The parameter.
        name: String,
        /// What it is instead.
        role: &'static str,
    },
    /// The spread of the residuals is to be estimated, but none are left over.
    #[error(
        "{residuals} residuals and {estimated} estimated parameters leave no degree of freedom"
    )]
    #[diagnostic(
        code(stiffbench::least_squares::no_degrees_of_freedom),
        help(
            "take more readings, fix a parameter, or give the standard deviations and use the mode `known`"
        )
    )]
    NoDegreesOfFreedom {
        /// Number of residuals.
        residuals: usize,
        /// Number of parameters the data determine.
        estimated: usize,
    },
    /// The problem cannot be evaluated where the fit is to begin.
    #[error("the model has no value at the start of the fit")]
    #[diagnostic(
        code(stiffbench::least_squares::start_has_no_value),
        help("start elsewhere, or leave out the reading that is named below")
    )]
    StartHasNoValue {
        /// What failed.
        #[source]
        source: EvaluationFailure,
    },
    /// Too few groups to draw from.
    #[error("{clusters} clusters cannot show a spread between clusters")]
    #[diagnostic(
        code(stiffbench::least_squares::too_few_clusters),
        help("at least 2 are needed; with fewer than about 10 the interval is too short")
    )]
    TooFewClusters {
        /// Number of clusters.
        clusters: usize,
    },
    /// Too few replicates to reach the tail that was asked for.
    #[error(
        "{succeeded} of {requested} replicates succeeded; {needed} are needed for this interval"
    )]
    #[diagnostic(
        code(stiffbench::least_squares::too_few_replicates),
        help("draw more replicates, or find out why the refits fail")
    )]
    TooFewReplicates {
        /// Replicates with a result.
        succeeded: usize,
        /// Replicates drawn.
        requested: usize,
        /// Replicates needed for the ends of the interval to lie inside the sample.
        needed: usize,
    },
    /// The coverage of an interval is not a probability.
    #[error("an interval cannot cover {coverage}")]
    #[diagnostic(
        code(stiffbench::least_squares::coverage_not_a_probability),
        help("give a number between 0 and 1, for example 0.95")
    )]
    CoverageNotAProbability {
        /// The number given.
        coverage: f64,
    },
    /// A search needs finite bounds.
    #[error("parameter `{name}` ranges from {lower} to {upper}; a search needs finite bounds")]
    #[diagnostic(
        code(stiffbench::least_squares::no_range),
        help("bound the parameter on both sides")
    )]
    NoRange {
        /// The parameter.
        name: String,
        /// Lower bound.
        lower: f64,
        /// Upper bound.
        upper: f64,
    },
    /// The number of bounds, or of start values, is not the number of parameters.
    #[error("expected {expected} numbers for the {what}, got {found}")]
    #[diagnostic(
        code(stiffbench::least_squares::wrong_length),
        help("give one number for each free parameter")
    )]
    WrongLength {
        /// What the numbers are.
        what: &'static str,
        /// How many there should be.
        expected: usize,
        /// How many there are.
        found: usize,
    },
    /// A derivative-free search without a single value.
    #[error("the objective had no finite value at any of {evaluations} points")]
    #[diagnostic(
        code(stiffbench::least_squares::no_value_anywhere),
        help("narrow the bounds to where the model is defined")
    )]
    NoValueAnywhere {
        /// Points tried.
        evaluations: usize,
    },
    /// The optimiser refused its input or failed inside.
    #[error("the derivative-free search failed")]
    #[diagnostic(
        code(stiffbench::least_squares::search_failed),
        help(
            "the cause is given below; smaller settings (particles, iterations) are valid from 1 on"
        )
    )]
    SearchFailed {
        /// The optimiser's own error.
        #[source]
        source: Box<dyn Error + Send + Sync>,
    },
}
