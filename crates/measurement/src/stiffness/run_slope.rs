//! How much the slope differs from run to run beyond what reading noise gives, pooled over all cells.
//!
//! What makes the slope of a run differ from the next one's (seating, friction in the jack) is relative and common to all cells; what
//! reading noise adds is known from the readings. A cell of one or two runs cannot see the first by itself: it borrows it from the
//! others, or has no uncertainty.

use super::curve::LoadCurve;
use super::line::{LineFit, TypeA};
use super::scatter::PooledScatter;
use stiffbench_numeric::statistics::{chi_squared_upper_tail, welch_satterthwaite};

/// Scatter of the slope from run to run beyond reading noise, relative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PooledRunSlope {
    /// Variance of the slope of a run, relative.
    pub variance: f64,
    /// Degrees of freedom over all cells with two runs or more.
    pub dof: f64,
    /// Chance of a scatter between runs as uneven over the cells as this one, were it the same in all; `None` without two cells of three runs.
    pub evenness_p: Option<f64>,
    /// Variance of the gauge zero from zero to zero, m², with its degrees of freedom; `None` if no cell has two zeros.
    pub zero_variance_m2: Option<(f64, f64)>,
}

/// The contribution of a cell to it.
#[derive(Debug, Clone, Copy)]
struct CellRuns {
    runs: f64,
    /// Variance of the mean slope as the runs show it, relative.
    shown: f64,
    dof: f64,
    reading_variance: f64,
}

impl PooledRunSlope {
    /// Weighted mean of n (u² - reading part) over the cells, weights from the variance of u², 2u⁴/dof, at the fitted value; ten rounds
    /// settle it. Never below zero. Where the scatter of readings was not seen, all that runs differ by is theirs. `None` if no cell has two
    /// runs.
    pub(super) fn over<'a>(
        cells: impl Iterator<Item = (&'a LoadCurve, &'a LineFit)> + Clone,
        scatter: &PooledScatter,
    ) -> Option<Self> {
        let runs: Vec<CellRuns> = cells
            .clone()
            .filter_map(|(_, line)| {
                let by_runs = line.slope_by_any_runs?;
                let reading_variance = scatter.slope_variance(line)?;
                Some(CellRuns {
                    runs: line.runs.len() as f64,
                    shown: (by_runs.standard_uncertainty / line.slope_m_per_n).powi(2),
                    dof: by_runs.dof,
                    reading_variance,
                })
            })
            .collect();
        let dof: f64 = runs.iter().map(|cell| cell.dof).sum();
        if runs.is_empty() {
            return None;
        }
        let mut variance = 0.0;
        if *scatter == PooledScatter::UNSEEN {
            let shown = runs.iter().map(|cell| cell.dof * cell.runs * cell.shown);
            variance = shown.sum::<f64>() / dof;
        } else {
            for _ in 0..10 {
                let (mut weights, mut sum) = (0.0, 0.0);
                for cell in &runs {
                    let expected = cell.reading_variance + variance / cell.runs;
                    let weight = cell.dof / (cell.runs * expected).powi(2);
                    weights += weight;
                    sum += weight * cell.runs * (cell.shown - cell.reading_variance);
                }
                variance = (sum / weights).max(0.0);
            }
        }
        if !variance.is_finite() {
            return None;
        }
        Some(Self {
            variance,
            dof,
            evenness_p: evenness(&runs, variance),
            zero_variance_m2: pooled_zero(cells, variance, scatter),
        })
    }

    /// Relative variance of the slope of a cell: u² = s²/n + σ²/(c² Σ(F - F̄)²), with n runs and compliance c.
    #[must_use]
    pub fn of_cell(&self, line: &LineFit, scatter: &PooledScatter) -> Option<f64> {
        Some(self.variance / line.runs.len() as f64 + scatter.slope_variance(line)?)
    }

    /// The type A uncertainty of the mean of F/δ, N/m, which the zero of each run enters beside its slope and its readings.
    pub(super) fn type_a_of_mean(
        &self,
        curve: &LoadCurve,
        scatter: &PooledScatter,
        value_n_per_m: f64,
        per_displacement: &[f64],
    ) -> TypeA {
        let runs = curve.runs.len() as f64;
        let sd_m = scatter.sd_m(1.0 / value_n_per_m.abs());
        let of_readings: f64 = curve
            .loaded()
            .map(|load| per_displacement[load].powi(2) / curve.loads[load].n as f64)
            .sum();
        let mut parts = vec![
            (
                value_n_per_m.abs() * (self.variance / runs).sqrt(),
                self.dof,
            ),
            (sd_m * of_readings.sqrt(), scatter.dof),
        ];
        // A zero that several runs share has its own row in the budget.
        if let Some((variance, dof)) = self.zero_variance_m2
            && curve.n_zeros >= curve.runs.len()
        {
            let per_zero: f64 = per_displacement.iter().sum();
            parts.push((
                per_zero.abs() * (variance / curve.n_zeros as f64).sqrt(),
                dof,
            ));
        }
        parts.retain(|(u, _)| *u > 0.0);
        let squares: f64 = parts.iter().map(|(u, _)| u * u).sum();
        TypeA {
            standard_uncertainty: squares.sqrt(),
            dof: welch_satterthwaite(&parts),
        }
    }

    /// The type A uncertainty of a stiffness from the slope, N/m.
    pub(super) fn type_a(
        &self,
        line: &LineFit,
        scatter: &PooledScatter,
        value_n_per_m: f64,
    ) -> Option<TypeA> {
        let relative = self.of_cell(line, scatter)?.sqrt();
        Some(TypeA {
            standard_uncertainty: relative * value_n_per_m.abs(),
            dof: self.dof,
        })
    }
}

/// Bartlett's test of equal variances on what the runs of each cell show over what they should, given their common variance.
///
/// # Source
/// M. S. Bartlett, Proc. R. Soc. A 160 (1937) 268; NIST/SEMATECH e-Handbook of Statistical Methods, 1.3.5.7.
fn evenness(cells: &[CellRuns], variance: f64) -> Option<f64> {
    // Of one degree of freedom the approximation by chi-squared is poor.
    let cells = cells.iter().filter(|cell| cell.dof >= 2.0);
    let ratios: Vec<(f64, f64)> = cells
        .map(|cell| {
            let expected = cell.reading_variance + variance / cell.runs;
            (cell.dof, cell.shown / expected)
        })
        .filter(|(_, ratio)| ratio.is_finite() && *ratio > 0.0)
        .collect();
    if ratios.len() < 2 {
        return None;
    }
    let others = (ratios.len() - 1) as f64;
    let dof: f64 = ratios.iter().map(|(dof, _)| dof).sum();
    let pooled = ratios.iter().map(|(n, ratio)| n * ratio).sum::<f64>() / dof;
    let logs: f64 = ratios
        .iter()
        .map(|(n, ratio)| n * (ratio / pooled).ln())
        .sum();
    let inverse: f64 = ratios.iter().map(|(n, _)| 1.0 / n).sum();
    let correction = 1.0 + (inverse - 1.0 / dof) / (3.0 * others);
    chi_squared_upper_tail(-logs / correction, others)
}

/// Variance of a gauge zero: that of the intercepts of a cell about their mean, over all cells, less what slopes and readings add to it.
///
/// With the slope common to the runs, the intercept of a zero with n readings at the mean force F̄ varies by σ_z² + (s c F̄)² + σ²/n. Never
/// below zero.
fn pooled_zero<'a>(
    cells: impl Iterator<Item = (&'a LoadCurve, &'a LineFit)>,
    run_variance: f64,
    scatter: &PooledScatter,
) -> Option<(f64, f64)> {
    let (mut sum, mut expected, mut dof) = (0.0, 0.0, 0.0);
    for (curve, line) in cells {
        let zeros = &line.intercepts_m;
        let share = 1.0 - 1.0 / zeros.len() as f64;
        let mean = zeros.iter().sum::<f64>() / zeros.len() as f64;
        sum += zeros.iter().map(|zero| (zero - mean).powi(2)).sum::<f64>();
        dof += zeros.len() as f64 - 1.0;
        for points in curve.points_by_zero() {
            let (n, force) = (
                points.len() as f64,
                points.iter().map(|p| p.force_n).sum::<f64>(),
            );
            let of_slope = run_variance * (line.slope_m_per_n * force / n).powi(2);
            let sd_m = scatter.sd_m(line.slope_m_per_n.abs());
            expected += share * (of_slope + sd_m * sd_m / n);
        }
    }
    let found = (sum - expected).max(0.0) / dof;
    found.is_finite().then_some((found, dof))
}
