//! Derivative-free search for the minimum: a check that least squares did not stop in a side valley.
//!
//! A particle swarm looks everywhere within the bounds, a Nelder-Mead simplex refines the best it found, least squares finishes.

use std::cell::RefCell;

use argmin::core::{CostFunction, Error as ArgminError, Executor};
use argmin::solver::neldermead::NelderMead;
use argmin::solver::particleswarm::ParticleSwarm;
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::SeedableRng;

use super::error::LeastSquaresError;
use super::minimise::{LeastSquaresFit, LeastSquaresSettings, minimise};
use super::parameter::ParameterSet;
use super::residual_function::ResidualFunction;

/// Size of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SearchSettings {
    /// Seed; the same seed gives the same search.
    pub seed: u64,
    /// Particles of the swarm.
    pub particles: usize,
    /// Moves of the swarm.
    pub swarm_iterations: u64,
    /// Moves of the simplex.
    pub simplex_iterations: u64,
}

impl Default for SearchSettings {
    /// 40 particles is the size recommended for up to about ten parameters (Standard PSO 2011); 100 moves bring them together,
    /// 400 moves of the simplex give a few digits in as many parameters. About 5000 evaluations in all.
    fn default() -> Self {
        Self {
            seed: 0,
            particles: 40,
            swarm_iterations: 100,
            simplex_iterations: 400,
        }
    }
}

/// A fit counts as lower if its ‖r‖² is smaller by more than this share: beyond what two converged fits of one minimum differ by.
const CLEARLY_LOWER: f64 = 1e-6;

/// Looks for a lower minimum than `found` within the bounds of all free parameters, which must be finite.
///
/// # Returns
/// The better fit; `None` if none was found: not a proof, but a search that could have found one.
///
/// # Errors
/// `NoRange` for a parameter without such bounds; `NoValueAnywhere`; `SearchFailed`.
pub fn search_for_lower_minimum(
    problem: &mut dyn ResidualFunction,
    set: &ParameterSet,
    found: &LeastSquaresFit,
    settings: &SearchSettings,
) -> Result<Option<LeastSquaresFit>, LeastSquaresError> {
    let names = set.free_indices().iter();
    let names = names.map(|&index| set.parameters()[index].name.clone());
    let area = SearchArea::new(&set.free_bounds(), names.collect())?;
    let mut full = vec![0.0; set.parameters().len()];
    let mut residuals = vec![0.0; problem.residual_count()];
    let mut objective = |free: &[f64]| {
        set.fill(free, &mut full);
        problem.evaluate(&full, &mut residuals, None).ok()?;
        Some(residuals.iter().map(|r| r * r).sum())
    };
    let swarm = swarm_within(&mut objective, &area, settings)?;
    let simplex = simplex_within(&mut objective, &area, &swarm, settings)?;
    let settings = LeastSquaresSettings::default();
    let fit = minimise(problem, &set.with_start(&simplex)?, &settings)?;
    let is_lower = fit.sum_of_squares() < (1.0 - CLEARLY_LOWER) * found.sum_of_squares();
    Ok(is_lower.then_some(fit))
}

/// Best point of a particle swarm in an area.
///
/// # Source
/// Zambrano-Bigiarini, Clerc and Rojas, Standard Particle Swarm Optimisation 2011 at CEC-2013, as implemented in argmin.
fn swarm_within(
    objective: &mut dyn FnMut(&[f64]) -> Option<f64>,
    area: &SearchArea,
    settings: &SearchSettings,
) -> Result<Vec<f64>, LeastSquaresError> {
    let tally = Tally::new(objective, area);
    let solver = ParticleSwarm::new(
        (area.lower.clone(), area.upper.clone()),
        settings.particles.max(1),
    )
    .with_rng_generator(Xoshiro256PlusPlus::seed_from_u64(settings.seed));
    Executor::new(Cost(&tally), solver)
        .configure(|state| state.max_iters(settings.swarm_iterations))
        .timer(false)
        .run()
        .map_err(search_failed)?;
    tally.into_inner().minimum()
}

/// Best point of a Nelder-Mead simplex from `start` in an area.
///
/// # Source
/// Nelder and Mead, The Computer Journal 7 (1965) 308, as implemented in argmin.
fn simplex_within(
    objective: &mut dyn FnMut(&[f64]) -> Option<f64>,
    area: &SearchArea,
    start: &[f64],
    settings: &SearchSettings,
) -> Result<Vec<f64>, LeastSquaresError> {
    let tally = Tally::new(objective, area);
    let solver = NelderMead::new(area.simplex(start));
    Executor::new(Cost(&tally), solver)
        .configure(|state| state.max_iters(settings.simplex_iterations))
        .timer(false)
        .run()
        .map_err(search_failed)?;
    tally.into_inner().minimum()
}

fn search_failed(source: ArgminError) -> LeastSquaresError {
    LeastSquaresError::SearchFailed {
        source: source.into(),
    }
}

/// Between which points are searched for.
struct SearchArea {
    lower: Vec<f64>,
    upper: Vec<f64>,
}

impl SearchArea {
    fn new(bounds: &[(f64, f64)], names: Vec<String>) -> Result<Self, LeastSquaresError> {
        for (&(lower, upper), name) in bounds.iter().zip(names) {
            if !(lower.is_finite() && lower < upper && upper.is_finite()) {
                return Err(LeastSquaresError::NoRange { name, lower, upper });
            }
        }
        if bounds.is_empty() {
            return Err(LeastSquaresError::NoFreeParameter { count: 0 });
        }
        let (lower, upper) = bounds.iter().copied().unzip();
        Ok(Self { lower, upper })
    }

    /// Corners a tenth of the range apart, turned inward where the start is close to the upper bound.
    fn simplex(&self, start: &[f64]) -> Vec<Vec<f64>> {
        let centre: Vec<f64> = (0..start.len())
            .map(|j| start[j].clamp(self.lower[j], self.upper[j]))
            .collect();
        let mut corners = vec![centre.clone()];
        for j in 0..centre.len() {
            let step = 0.1 * (self.upper[j] - self.lower[j]);
            let mut corner = centre.clone();
            corner[j] += if centre[j] + step <= self.upper[j] {
                step
            } else {
                -step
            };
            corners.push(corner);
        }
        corners
    }
}

/// Counts evaluations and remembers the best point, whatever the optimiser keeps.
struct Tally<'a> {
    objective: &'a mut dyn FnMut(&[f64]) -> Option<f64>,
    area: &'a SearchArea,
    best: Option<(Vec<f64>, f64)>,
    evaluations: usize,
}

impl<'a> Tally<'a> {
    fn new(
        objective: &'a mut dyn FnMut(&[f64]) -> Option<f64>,
        area: &'a SearchArea,
    ) -> RefCell<Self> {
        RefCell::new(Self {
            objective,
            area,
            best: None,
            evaluations: 0,
        })
    }

    /// The objective, infinite outside the bounds and where the model has no value, as the optimisers want it.
    fn cost(&mut self, point: &[f64]) -> f64 {
        let mut limits = point
            .iter()
            .zip(self.area.lower.iter().zip(&self.area.upper));
        if limits.any(|(x, (lower, upper))| x < lower || x > upper) {
            return f64::INFINITY;
        }
        self.evaluations += 1;
        let Some(value) = (self.objective)(point).filter(|value| value.is_finite()) else {
            return f64::INFINITY;
        };
        if self.best.as_ref().is_none_or(|(_, best)| value < *best) {
            self.best = Some((point.to_vec(), value));
        }
        value
    }

    fn minimum(self) -> Result<Vec<f64>, LeastSquaresError> {
        let (point, _) = self.best.ok_or(LeastSquaresError::NoValueAnywhere {
            evaluations: self.evaluations,
        })?;
        Ok(point)
    }
}

struct Cost<'a, 'b>(&'a RefCell<Tally<'b>>);

impl CostFunction for Cost<'_, '_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, point: &Self::Param) -> Result<f64, ArgminError> {
        Ok(self.0.borrow_mut().cost(point))
    }
}

#[cfg(test)]
mod tests;
