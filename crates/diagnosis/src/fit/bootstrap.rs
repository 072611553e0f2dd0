//! Intervals of the factors from resampled runs or whole cells: no distribution assumed.

use stiffbench_beams::robot::FittingFactors;
use stiffbench_measurement::stiffness::{RunSums, StiffnessTable};
use stiffbench_numeric::least_squares::{BootstrapSettings, ReplicateFailure, cluster_bootstrap};

use super::error::FitError;
use super::measured::{MeasuredCell, MeasuredStiffness};
use super::parameters::FitParameters;
use super::problem::FitProblem;
use super::refit::Refitter;
use crate::parameters::ParameterChoice;

/// Share of the range of a parameter within which a value is on its bound.
const AT_BOUND: f64 = 1e-6;

/// Percentile intervals of the factors from refits to resampled runs.
#[derive(Debug, Clone, PartialEq)]
pub struct BootstrapIntervals {
    /// 95 % interval of each parameter of the fit; `None` for one that it does not move.
    pub intervals_95: Vec<Option<[f64; 2]>>,
    /// Replicates that ended on a bound of each parameter.
    pub at_bound: Vec<usize>,
    /// Replicates that gave a result.
    pub succeeded: usize,
    /// Replicates whose fit failed or did not converge.
    pub failed: usize,
    /// Seed.
    pub seed: u64,
}

/// What the bootstrap resamples.
#[derive(Debug, Clone, Copy)]
pub enum ResampledUnit<'a> {
    /// Applications of the load sequence within their cell: the scatter from run to run, each run with its own zero and slope.
    Runs(&'a StiffnessTable),
    /// Whole cells (pose and direction) with all their readings: also what the model leaves from cell to cell.
    Cells,
}

/// Runs of the training cells, and how far a replicate of ln K must be stretched.
struct ResampledCells {
    runs: Vec<Vec<RunSums>>,
    /// ln K by the runs as they were measured.
    ln_of_runs: Vec<f64>,
}

/// Why a replicate has no factors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum NoRefit {
    NotSetUp,
    NotConverged,
}

/// Draws runs or cells anew and refits, on all threads; the result does not depend on their number.
///
/// Runs are drawn within their cell, so that every cell stays in every replicate. A mean over G resampled runs varies by (G - 1)/G of
/// its variance; deviations are stretched by √(G/(G - 1)) to undo that (Davison and Hinkley, 1997, section 3.2).
///
/// # Arguments
/// - `problem`: the training cells, with the regression stiffness of the table whose runs are drawn; its start puts the bounds.
/// - `fitted`: the fitted factors, from which each refit begins.
/// - `refitted`: called after each refit, for progress.
///
/// # Errors
/// [`FitError::LeastSquares`] if a cell has a single run, or too few replicates have a result.
pub fn bootstrap_cells(
    problem: &FitProblem<'_>,
    fitted: &FittingFactors,
    unit: ResampledUnit<'_>,
    choice: &ParameterChoice,
    settings: &BootstrapSettings,
    refitted: &(dyn Fn() + Sync),
) -> Result<BootstrapIntervals, FitError> {
    let parameters = FitParameters::new(problem, choice)?;
    let set = parameters.set()?;
    let values = |of: &FittingFactors| -> Vec<f64> {
        let parameters = parameters.parameters().iter();
        parameters.map(|parameter| of.get(parameter)).collect()
    };
    let ln_stiffness = problem.measured.cells.iter();
    let ln_stiffness: Vec<f64> = ln_stiffness
        .map(|cell| cell.stiffness_n_per_m.ln())
        .collect();
    let runs = match unit {
        ResampledUnit::Runs(table) => Some(ResampledCells::new(table, problem.measured)),
        ResampledUnit::Cells => None,
    };
    let strata = runs.as_ref().map_or_else(
        || vec![ln_stiffness.len()],
        |cells| cells.runs.iter().map(Vec::len).collect(),
    );
    let bootstrap = cluster_bootstrap(
        &strata,
        &values(fitted),
        settings,
        || {
            (
                Refitter::new(problem, choice)
                    .and_then(|refitter| refitter.beginning_at(fitted))
                    .ok(),
                ln_stiffness.clone(),
            )
        },
        |multiplicities, (refitter, drawn)| {
            let refitter = refitter.as_mut().ok_or(NoRefit::NotSetUp)?;
            match &runs {
                Some(cells) => cells.draw(multiplicities, &ln_stiffness, drawn),
                None => refitter.count_cells(multiplicities),
            }
            refitted();
            let refit = refitter.refit(drawn);
            let refit = refit.map_err(|_| NoRefit::NotConverged)?;
            if !refit.termination.is_converged() {
                return Err(NoRefit::NotConverged);
            }
            Ok(values(&refit.factors))
        },
    )?;
    debug_assert!(
        bootstrap
            .failed
            .iter()
            .all(|failed| failed.failure != ReplicateFailure::Refit(NoRefit::NotSetUp))
    );
    let mut intervals_95 = vec![None; set.parameters().len()];
    let mut at_bound = vec![0; set.parameters().len()];
    for &free in set.free_indices() {
        intervals_95[free] = Some(bootstrap.percentile_interval(free, 0.95)?);
        let [lower, upper] = parameters.bounds(free);
        let is_at_bound = |replicate: &&Vec<f64>| {
            let coordinate = parameters.coordinate(free, replicate[free]);
            f64::min(coordinate - lower, upper - coordinate) < AT_BOUND * (upper - lower)
        };
        at_bound[free] = bootstrap.replicates.iter().filter(is_at_bound).count();
    }
    Ok(BootstrapIntervals {
        intervals_95,
        at_bound,
        succeeded: bootstrap.replicates.len(),
        failed: bootstrap.failed.len(),
        seed: settings.seed,
    })
}

impl ResampledCells {
    fn new(table: &StiffnessTable, measured: &MeasuredStiffness) -> Self {
        let runs_of = |cell: &MeasuredCell| {
            let line = table.cell(&cell.cell)?.line.as_ref();
            Some(line.ok()?.runs.clone())
        };
        let runs = measured.cells.iter();
        let runs: Vec<Vec<RunSums>> = runs.map(|cell| runs_of(cell).unwrap_or_default()).collect();
        Self {
            ln_of_runs: (runs.iter())
                .map(|runs| ln_stiffness(runs, &vec![1; runs.len()]))
                .collect(),
            runs,
        }
    }

    /// ln K of every cell from its runs, each as often as it was drawn.
    fn draw(&self, multiplicities: &[u32], measured: &[f64], drawn: &mut [f64]) {
        let mut rest = multiplicities;
        for (place, (runs, value)) in self.runs.iter().zip(drawn).enumerate() {
            let (of_cell, after) = rest.split_at(runs.len());
            rest = after;
            let off = ln_stiffness(runs, of_cell) - self.ln_of_runs[place];
            let stretch = (runs.len() as f64 / (runs.len() as f64 - 1.0)).sqrt();
            *value = measured[place] + stretch * off;
        }
    }
}

/// ln K of runs, each as often as it counts.
fn ln_stiffness(runs: &[RunSums], times: &[u32]) -> f64 {
    let weighted = |of: &dyn Fn(&RunSums) -> f64| -> f64 {
        let runs = runs.iter().zip(times);
        runs.map(|(run, times)| f64::from(*times) * of(run)).sum()
    };
    (weighted(&|run| run.sxx_n2) / weighted(&|run| run.sxy_n_m)).ln()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::CellModel;
    use crate::fit::refit::tests::{cells_of, measured};
    use crate::parameters::FitRole;
    use crate::tests::hp_robot;
    use stiffbench_beams::robot::ModelParameter;

    #[test]
    fn cells_drawn_again_give_the_standard_error_that_allows_for_unequal_scatter() {
        let robot = hp_robot();
        let mechanism = robot.mechanism(Some("F")).unwrap();
        let start = robot.factor_set("m_fsd").unwrap();
        let cells = cells_of(&robot);
        let mut model =
            CellModel::new(&robot, mechanism, &ModelParameter::CLASSES, &cells).unwrap();
        let truth = model.stiffness(&start).unwrap();
        let off = |place: usize| 0.01 * ((7 * place) % 5) as f64 - 0.02;
        let read = truth.iter().enumerate();
        let measured = measured(&cells, read.map(|(place, k)| k * f64::exp(off(place))));
        let problem = FitProblem {
            robot: &robot,
            mechanism,
            measured: &measured,
            start: &start,
            physics: None,
        };
        let mut choice = ParameterChoice::default();
        for place in [0, 2, 3] {
            choice.set(&ModelParameter::BEAMS[place], FitRole::Fixed);
        }
        let ln_measured: Vec<f64> = measured
            .cells
            .iter()
            .map(|cell| cell.stiffness_n_per_m.ln())
            .collect();
        let mut refitter = Refitter::new(&problem, &choice).unwrap();
        let fitted = refitter.refit(&ln_measured).unwrap().factors;

        // HC0 (White, Econometrica 48 (1980), 817): sum (J r)^2 / (sum J^2)^2 of one parameter.
        let (mut stiffness, mut shares) = (vec![0.0; cells.len()], vec![Vec::new(); cells.len()]);
        model
            .evaluate(&fitted, &mut stiffness, Some(&mut shares))
            .unwrap();
        let (mut within, mut curvature) = (0.0, 0.0);
        for ((k, ln_k), shares) in stiffness.iter().zip(&ln_measured).zip(&shares) {
            let slope = shares[1];
            within += (slope * (k.ln() - ln_k)).powi(2);
            curvature += slope * slope;
        }
        let expected = within.sqrt() / curvature;

        let settings = BootstrapSettings {
            replicates: 2000,
            seed: 3,
        };
        let again = || {
            let unit = ResampledUnit::Cells;
            bootstrap_cells(&problem, &fitted, unit, &choice, &settings, &|| ()).unwrap()
        };
        let found = again();
        assert_eq!(found.failed, 0);
        let [low, high] = found.intervals_95[1].unwrap();
        let error = (high / low).ln() / 3.92;
        assert!((error / expected - 1.0).abs() < 0.15, "{error} {expected}");
        assert_eq!(found, again());
    }
}
