//! Intervals of the factors from runs drawn again: no distribution assumed, each run with its own zero and slope.

use stiffbench_beams::robot::FittingFactors;
use stiffbench_measurement::stiffness::{CellStiffness, RunSums, StiffnessTable};
use stiffbench_numeric::least_squares::{BootstrapSettings, ReplicateFailure, cluster_bootstrap};
use stiffbench_units_and_text::test_point::Cell;

use super::choice::FactorChoice;
use super::error::FitError;
use super::factors::{FACTOR_NAMES, FACTORS, factor_vector};
use super::measured::MeasuredStiffness;
use super::problem::FitProblem;
use super::refit::Refitter;

/// Percentile intervals of the factors from refits to resampled runs.
#[derive(Debug, Clone, PartialEq)]
pub struct BootstrapIntervals {
    /// 95 % interval of each factor, order of [`FACTOR_NAMES`]; `None` for one that the fit does not move.
    pub intervals_95: [Option<[f64; 2]>; FACTORS],
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
    choice: &FactorChoice,
    settings: &BootstrapSettings,
    refitted: &(dyn Fn() + Sync),
) -> Result<BootstrapIntervals, FitError> {
    let set = choice.parameters()?;
    let resampled = ResampledCells::new(table, problem.measured);
    let strata: Vec<usize> = resampled.runs.iter().map(Vec::len).collect();
    let bootstrap = cluster_bootstrap(
        &strata,
        &factor_vector(fitted),
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
            Ok(factor_vector(&refit.factors).to_vec())
        },
    )?;
    debug_assert!(
        bootstrap
            .failed
            .iter()
            .all(|failed| failed.failure != ReplicateFailure::Refit(NoRefit::NotSetUp))
    );
    let mut intervals_95 = [None; FACTORS];
    for (place, interval) in intervals_95.iter_mut().enumerate() {
        if set
            .index_of(FACTOR_NAMES[place])
            .is_some_and(|index| set.free_indices().contains(&index))
        {
            *interval = Some(bootstrap.percentile_interval(place, 0.95)?);
        }
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
