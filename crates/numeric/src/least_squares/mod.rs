//! Fitting by least squares, and what the fitted numbers are worth.
//!
//! The general core handles residuals and parameters and is independent of robots:
//!
//! - [`Parameter`] and [`ParameterSet`]: what is free, fixed or tied, between which bounds;
//! - [`ResidualFunction`]: the problem, weights included, and how its failures are named;
//! - [`minimise`]: the minimum and why the search ended there;
//! - [`covariance`]: standard errors, correlations, and which parameters the data cannot see;
//! - [`profile`]: the interval of one parameter without assuming that the minimum is a parabola;
//! - [`minima`], [`Likelihood`]: the same where several minima fit about as well;
//! - [`cluster_bootstrap`]: the spread when whole groups of readings are resampled;
//! - [`search_for_lower_minimum`]: derivative-free search for a lower minimum than the one found.
//!
//! # Decision: an own bounded Levenberg-Marquardt
//!
//! *Context.* The crate `levenberg-marquardt` is a port of MINPACK's LMDER and has neither bounds nor fixed or tied parameters. Bounds
//! can be put in front of it by a transform, as MINUIT does with an arcsine. The derivative of such a transform is zero on the bound: a
//! start there never moves, a solution there is approached but not reached, and the covariance in the transformed variables is singular
//! just where the answer should say "at its bound". The other way, to let the crate step outside and bring it back, evaluates models where
//! they have no meaning (a negative area).
//!
//! *Choice.* [`minimise`] keeps the trust region of Moré (1978), which is what makes LMDER reliable from far starts, and solves each
//! step inside the box: a parameter that would cross its bound stops exactly on it and the rest is solved again; a parameter on a bound
//! whose gradient points outward is held there until it points inward. "At a bound" is then an exact statement, the covariance is that of
//! the parameters that are still free, and the model is never asked for a value outside its bounds. A point without a value (NaN, a model
//! failure) shortens the step instead of ending the fit.
//!
//! *Price.* About 300 lines of our own. They are held to NIST's 27 certified problems, and to the crate as an oracle, in `crates/numeric/tests/nist_strd/`.
//! There is one path: the same code runs a single careful fit and a thousand refits.

mod bootstrap;
mod covariance;
mod error;
mod identification;
mod likelihood_set;
mod minima;
mod minimise;
mod optimise;
mod parameter;
mod point;
mod profile;
mod residual_function;
#[cfg(test)]
mod rows;
mod search;
mod singular_values;
mod trust_region;

pub use bootstrap::{
    Bootstrap, BootstrapSettings, FailedReplicate, ReplicateFailure, cluster_bootstrap,
};
pub use covariance::{
    CovarianceSettings, ParameterCovariance, ParameterEstimate, ParameterStatus,
    STRONG_CORRELATION, SigmaMode, StrongPair, covariance,
};
pub use error::LeastSquaresError;
pub use identification::{DirectionComponent, UnidentifiedDirection, WhyNotIdentified};
pub use likelihood_set::{Likelihood, LikelihoodSet, LikelihoodSetSettings};
pub use minima::{minima, spread};
pub use minimise::{Convergence, LeastSquaresFit, LeastSquaresSettings, Termination, minimise};
pub use optimise::{SearchSettings, search_for_lower_minimum};
pub use parameter::{Bound, Parameter, ParameterRole, ParameterSet};
pub use profile::{
    LowerMinimum, ProfileEnd, ProfileInterval, ProfileSettings, profile, rise_at_95,
};
pub use residual_function::{
    DerivativeCheck, EvaluationFailure, JacobianView, ResidualFunction, check_derivatives,
};
