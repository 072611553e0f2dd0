//! Intervals of the factors from runs drawn again: no distribution assumed, each run with its own zero and slope.

use stiffbench_beams::robot::FittingFactors;
use stiffbench_measurement::stiffness::{CellStiffness, RunSums, StiffnessTable};
use stiffbench_numeric::least_squares::{BootstrapSettings, ReplicateFailure, cluster_bootstrap};
use stiffbench_units_and_text::test_point::Cell;

use super::error::FitError;
use super::measured::MeasuredStiffness;
use super::parameters::FitParameters;
use super::problem::FitProblem;
use super::refit::Refitter;
use crate::parameters::ParameterChoice;

/// Percentile intervals of the factors from refits to resampled runs.
#[derive(Debug, Clone, PartialEq)]
pub struct BootstrapIntervals {
    /// 95 % interval of each parameter of the fit; `None` for one that it does not move.
    pub intervals_95: Vec<Option<[f64; 2]>>,
    /// Replicates that gave a result.
    pub succeeded: usize,
    /// Replicates whose fit failed or did not converge.
    pub failed: usize,
    /// Seed.
    pub seed: u64,
}

/// Runs of the training cells, and how far a replicate of ln K must be stretched.
struct ResampledCells {
    runs: Vec<Vec<RunSums>>,
    ln_stiffness: Vec<f64>,
}

/// Why a replicate has no factors.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum NoRefit {
    NotSetUp,
    NotConverged,
}

/// Draws the runs of every cell anew and refits, on all threads; the result does not depend on their number.
///
/// Runs are drawn within their cell, so that every cell stays in every replicate. A mean over G runs drawn again varies by (G - 1)/G of
/// its variance; deviations are stretched by √(G/(G - 1)) to undo that (Davison and Hinkley, 1997, section 3.2).
///
/// # Arguments
/// - `problem`: the training cells with the regression stiffness of `table`; its start puts the bounds.
/// - `fitted`: the fitted factors, from which each refit begins.
/// - `refitted`: called after each refit, for progress.
///
/// # Errors
/// [`FitError::LeastSquares`] if a cell has a single run.
pub fn bootstrap_cells(
    problem: &FitProblem<'_>,
    fitted: &FittingFactors,
    table: &StiffnessTable,
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
    let resampled = ResampledCells::new(table, problem.measured);
    let strata: Vec<usize> = resampled.runs.iter().map(Vec::len).collect();
    let bootstrap = cluster_bootstrap(
        &strata,
        &values(fitted),
        settings,
        || {
            (
                Refitter::new(problem, choice)
                    .and_then(|refitter| refitter.beginning_at(fitted))
                    .ok(),
                resampled.ln_stiffness.clone(),
            )
        },
        |multiplicities, (refitter, ln_stiffness)| {
            let refitter = refitter.as_mut().ok_or(NoRefit::NotSetUp)?;
            resampled.draw(multiplicities, ln_stiffness);
            refitted();
            let refit = refitter.refit(ln_stiffness);
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
    for &free in set.free_indices() {
        intervals_95[free] = Some(bootstrap.percentile_interval(free, 0.95)?);
    }
    Ok(BootstrapIntervals {
        intervals_95,
        succeeded: bootstrap.replicates.len(),
        failed: bootstrap.failed.len(),
        seed: settings.seed,
    })
}

impl ResampledCells {
    fn new(table: &StiffnessTable, measured: &MeasuredStiffness) -> Self {
        let runs_of = |cell: &Cell| -> Vec<RunSums> {
            let line = table
                .cell(cell)
                .and_then(|row: &CellStiffness| row.line.as_ref().ok());
            line.map_or_else(Vec::new, |line| line.runs.clone())
        };
        Self {
            runs: measured
                .cells
                .iter()
                .map(|cell| runs_of(&cell.cell))
                .collect(),
            ln_stiffness: measured
                .cells
                .iter()
                .map(|cell| cell.stiffness_n_per_m.ln())
                .collect(),
        }
    }

    /// ln K of every cell from its runs, each as often as it was drawn.
    fn draw(&self, multiplicities: &[u32], ln_stiffness: &mut [f64]) {
        let mut rest = multiplicities;
        for ((runs, original), value) in self.runs.iter().zip(&self.ln_stiffness).zip(ln_stiffness)
        {
            let (of_cell, after) = rest.split_at(runs.len());
            rest = after;
            let weighted = |of: &dyn Fn(&RunSums) -> f64| -> f64 {
                runs.iter()
                    .zip(of_cell)
                    .map(|(run, times)| f64::from(*times) * of(run))
                    .sum()
            };
            let stiffness = weighted(&|run| run.sxx_n2) / weighted(&|run| run.sxy_n_m);
            let stretch = (runs.len() as f64 / (runs.len() as f64 - 1.0)).sqrt();
            *value = original + stretch * (stiffness.ln() - original);
        }
    }
}
