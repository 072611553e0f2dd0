//! Which fitting factors a fit may move.

use super::factors::{FACTOR_NAMES, FACTORS};
use stiffbench_numeric::least_squares::{LeastSquaresError, Parameter, ParameterSet};

/// What a fit does with one factor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum FactorRole {
    /// Moves it between 0.1 and 10 times its start (or the bounds of the choice).
    Free,
    /// Keeps it at its start.
    Fixed,
    /// Keeps its ratio to another factor, by place in [`FACTOR_NAMES`].
    TiedTo(usize),
}

/// The role of each factor, and how far free ones may go.
#[derive(Debug, Clone, PartialEq)]
pub struct FactorChoice {
    /// Role by place in [`FACTOR_NAMES`].
    pub roles: [FactorRole; FACTORS],
    /// Bounds as multiples of the start.
    pub range: [f64; 2],
}

impl Default for FactorChoice {
    /// Factors of beams free, those of links fixed, bounds 0.1 and 10 times the start: a poorly determined factor let loose would
    /// take up effects that are not its own, at absurd values.
    fn default() -> Self {
        let mut roles = [FactorRole::Fixed; FACTORS];
        roles[..4].fill(FactorRole::Free);
        Self {
            roles,
            range: [0.1, 10.0],
        }
    }
}

/// A choice that names a factor or role that does not exist.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("`{text}` is not a fitting factor; they are {}", FACTOR_NAMES.join(", "))]
#[diagnostic(
    code(stiffbench::fit::factor_name),
    help("write for example beam.Iy or link.A")
)]
pub struct NotAFactor {
    /// The text.
    pub text: String,
}

/// Place of a factor in [`FACTOR_NAMES`].
///
/// # Errors
/// [`NotAFactor`].
pub fn factor_index(name: &str) -> Result<usize, NotAFactor> {
    FACTOR_NAMES
        .iter()
        .position(|known| *known == name)
        .ok_or_else(|| NotAFactor {
            text: name.to_owned(),
        })
}

impl FactorChoice {
    /// The logarithms of the factors, relative to their start, as parameters of a fit.
    ///
    /// Logarithms, because a factor is a ratio: twice and half are equally far from one, and none can become negative.
    ///
    /// # Errors
    /// [`LeastSquaresError`] if ties go in a circle or no factor is free.
    pub(super) fn parameters(&self) -> Result<ParameterSet, LeastSquaresError> {
        self.set(0.0, self.range.map(f64::ln))
    }

    /// The factors relative to their start as parameters of a search.
    ///
    /// # Errors
    /// As [`FactorChoice::parameters`].
    pub(super) fn ratios(&self) -> Result<ParameterSet, LeastSquaresError> {
        self.set(1.0, self.range)
    }

    fn set(&self, start: f64, [lower, upper]: [f64; 2]) -> Result<ParameterSet, LeastSquaresError> {
        let parameter = |(i, role): (usize, &FactorRole)| match *role {
            FactorRole::Free => Parameter::free(FACTOR_NAMES[i], start, lower, upper),
            FactorRole::Fixed => Parameter::fixed(FACTOR_NAMES[i], start),
            FactorRole::TiedTo(other) => Parameter::tied(FACTOR_NAMES[i], other, 1.0),
        };
        ParameterSet::new(self.roles.iter().enumerate().map(parameter).collect())
    }
}
