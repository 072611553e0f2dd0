//! The fitting factors as one vector.

use stiffbench_beams::robot::FittingFactors;

/// Number of fitting factors: four of beams, four of links.
pub const FACTORS: usize = 8;

/// Names of the factors in the order of [`factor_vector`].
pub const FACTOR_NAMES: [&str; FACTORS] = [
    "beam.A", "beam.Iy", "beam.Iz", "beam.J", "link.A", "link.Iy", "link.Iz", "link.J",
];

/// The factors as one vector: beams A, Iy, Iz, J, then links.
#[must_use]
pub fn factor_vector(factors: &FittingFactors) -> [f64; FACTORS] {
    std::array::from_fn(|i| {
        if i < 4 {
            factors.beam[i]
        } else {
            factors.link[i - 4]
        }
    })
}

/// Factors from a vector in the order of [`factor_vector`].
#[must_use]
pub fn factors_from_vector(vector: &[f64; FACTORS]) -> FittingFactors {
    FittingFactors {
        beam: std::array::from_fn(|i| vector[i]),
        link: std::array::from_fn(|i| vector[4 + i]),
    }
}

/// Shares of one cell's compliance that the factors own: u ᵀ a_i K_i u / C, order of [`factor_vector`]; they add up to one.
///
/// The share of a factor is also ∂ ln K / ∂ ln a: K is the stiffness at the end, a homogeneous function of the factors.
pub type Shares = [f64; FACTORS];
