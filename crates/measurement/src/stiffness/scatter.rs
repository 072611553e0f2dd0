//! How much readings of the same test point differ from repeat to repeat, pooled over all cells.
//!
//! Five repeats of one cell carry little information on their own spread, so cells lend it to each other. They cannot lend it as it is:
//! on a soft direction the step and noise of the force gauge, times the compliance, are larger than everything else. The
//! variance is therefore split into a part of the displacement gauge and a part of the force gauge, s² = a + b c².

use super::curve::{CurvePoint, LoadCurve};
use super::line::{LineFit, StraightLine};

/// Fewest readings of a run through which a line of its own leaves something to see.
const FEWEST_READINGS_OF_A_LINE: usize = 3;

/// A reading with a force so far from all others of its run draws the line through its own displacement, where its error hides: the line is that
/// of the others.
const HIDES: f64 = 0.9;

/// Cells whose squared compliances spread by no more than the root of this share are cells of one compliance: a and b of s² = a + b c² cannot
/// be distinguished.
pub(super) const ONE_COMPLIANCE: f64 = 1e-6;

/// Scatter of single readings within runs, pooled over the cells of a table.
///
/// Zero, slope and curvature common to the repeats are taken out first. Readings flagged as outliers do not count here.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PooledScatter {
    /// Standard deviation of a displacement reading without load, m.
    pub displacement_sd_m: f64,
    /// Standard deviation of a force reading, N, as far as it shows in soft cells more than in stiff ones.
    pub force_sd_n: f64,
    /// Root mean square over the cells, m, weighted by their degrees of freedom: the plain pooled repeat standard deviation.
    pub mean_sd_m: f64,
    /// Degrees of freedom over all cells.
    pub dof: f64,
    /// From which distance, m, a single bad reading that has repeats is found in 80 % of cases, wherever it stands in its run: in the cell where
    /// least is enough, and where most is needed; `None` where some would not be found however far off.
    pub smallest_outliers_m: Option<[f64; 2]>,
}

impl PooledScatter {
    /// No readings were repeated at a common load, so that none was seen.
    pub const UNSEEN: Self = Self {
        displacement_sd_m: 0.0,
        force_sd_n: 0.0,
        mean_sd_m: 0.0,
        dof: 0.0,
        smallest_outliers_m: None,
    };

    /// Standard deviation of a reading in a cell of this compliance (m/N), m.
    #[must_use]
    pub fn sd_m(&self, compliance_m_per_n: f64) -> f64 {
        let force = self.force_sd_n * compliance_m_per_n;
        (self.displacement_sd_m.powi(2) + force * force).sqrt()
    }

    /// Scatter of the readings about the line of their cell, for cells without repeats; a bend of the line counts as scatter.
    ///
    /// `None` if every line goes through its readings by construction.
    #[must_use]
    pub fn about_lines<'a>(lines: impl Iterator<Item = &'a LineFit>) -> Option<Self> {
        let of_line = |line: &LineFit| {
            let dof = line.slope_by_residuals.as_ref()?.dof;
            Some(CellScatter {
                compliance_m_per_n: line.slope_m_per_n,
                deviations: Vec::new(),
                sum_of_squares_m2: dof * line.residual_sd_m?.powi(2),
                dof,
                lack_of_fit: (0.0, 0.0),
            })
        };
        let cells: Vec<CellScatter> = lines.filter_map(of_line).collect();
        Self::over(cells.iter())
    }

    /// Relative variance that reading noise gives the slope of a line, σ²/(c² Σ(F - F̄)²) with compliance c.
    #[must_use]
    pub fn slope_variance(&self, line: &LineFit) -> Option<f64> {
        let sd_m = self.sd_m(line.slope_m_per_n.abs());
        let root_sxx_n = line.runs.iter().map(|run| run.sxx_n2).sum::<f64>().sqrt();
        let variance = (sd_m / root_sxx_n / line.slope_m_per_n).powi(2);
        variance.is_finite().then_some(variance)
    }

    /// `None` if no cell has repeats to compare.
    pub(super) fn over<'a>(cells: impl Iterator<Item = &'a CellScatter>) -> Option<Self> {
        let cells: Vec<(f64, f64, f64)> = cells
            .filter(|cell| cell.dof > 0.0)
            .map(|cell| {
                let squared = cell.compliance_m_per_n * cell.compliance_m_per_n;
                (cell.dof, cell.sum_of_squares_m2 / cell.dof, squared)
            })
            .collect();
        let dof: f64 = cells.iter().map(|(dof, _, _)| dof).sum();
        if dof == 0.0 {
            return None;
        }
        let mean_variance = cells.iter().map(|(n, s2, _)| n * s2).sum::<f64>() / dof;
        let (a, b) = split_variance(&cells, mean_variance);
        Some(Self {
            displacement_sd_m: a.sqrt(),
            force_sd_n: b.sqrt(),
            mean_sd_m: mean_variance.sqrt(),
            dof,
            smallest_outliers_m: None,
        })
    }
}

/// a and b of s² = a + b c², both at least zero, from (dof, s², c²) of the cells.
///
/// Weighted least squares; the variance of s² is 2σ⁴/dof, so weights follow the fitted value. Ten rounds settle them far
/// beyond need.
fn split_variance(cells: &[(f64, f64, f64)], mean_variance: f64) -> (f64, f64) {
    let mut fitted = (mean_variance, 0.0);
    for _ in 0..10 {
        let mut sums = [0.0; 5];
        for &(dof, s2, c2) in cells {
            let expected = fitted.0 + fitted.1 * c2;
            if expected <= 0.0 {
                continue;
            }
            let weight = dof / (expected * expected);
            let terms = [1.0, c2, c2 * c2, s2, c2 * s2];
            for (sum, term) in sums.iter_mut().zip(terms) {
                *sum += weight * term;
            }
        }
        let [w, wc, wcc, ws, wcs] = sums;
        let determinant = w * wcc - wc * wc;
        if w == 0.0 {
            return fitted;
        }
        // With cells of one compliance the two are indistinguishable; all is then attributed to the displacement.
        if determinant <= ONE_COMPLIANCE * w * wcc {
            return (ws / w, 0.0);
        }
        let a = (wcc * ws - wc * wcs) / determinant;
        let b = (w * wcs - wc * ws) / determinant;
        fitted = if a < 0.0 {
            (0.0, wcs / wcc)
        } else if b < 0.0 {
            (ws / w, 0.0)
        } else {
            (a, b)
        };
    }
    fitted
}

/// A reading's distance from its repeats.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Deviation {
    /// Place of the reading: index of the run in its curve, index of the point in the run.
    pub(super) place: (usize, usize),
    /// Distance, m.
    pub(super) distance_m: f64,
    /// Its variance in units of the variance of a reading.
    pub(super) variance_share: f64,
}

/// Distances of all readings of a cell from their repeats.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CellScatter {
    pub(super) compliance_m_per_n: f64,
    pub(super) deviations: Vec<Deviation>,
    pub(super) sum_of_squares_m2: f64,
    pub(super) dof: f64,
    /// Squares of the step means about the lines of the runs, m², and their degrees of freedom.
    pub(super) lack_of_fit: (f64, f64),
}

impl CellScatter {
    /// Takes the line of each run off its readings, then the mean of each load; what remains is scatter.
    ///
    /// With R runs and L loads N - 2R - (L - 2) degrees of freedom remain. Runs of fewer than three readings have no line worth
    /// its name; if the cell has no others, the cell's slope is taken off instead and N - L remain. `excluded` places are
    /// left out of everything.
    pub(super) fn new(curve: &LoadCurve, fit: &LineFit, excluded: &[(usize, usize)]) -> Self {
        let kept = |run: usize| {
            let points = curve.runs[run].points.iter().enumerate();
            points.filter(move |(i, _)| !excluded.contains(&(run, *i)))
        };
        let lines: Vec<Option<StraightLine>> = (0..curve.runs.len())
            .map(|run| {
                let points = || kept(run).map(|(_, point)| point);
                let all = StraightLine::through(points())?;
                let others = StraightLine::through(points().filter(|p| all.leverage(p) < HIDES));
                let enough = |line: &StraightLine| line.n >= FEWEST_READINGS_OF_A_LINE;
                others.filter(enough).or(Some(all)).filter(enough)
            })
            .collect();
        let by_run = lines.iter().flatten().count() >= 2;
        let residual = |run: usize, p: &CurvePoint| match lines[run] {
            Some(line) if by_run => Some(match (line.residual_m(p), line.leverage(p)) {
                // No point of its own line: in units of the uncertainty of where the line would be.
                (off_m, leverage) if leverage > 1.0 => (off_m / (1.0 + leverage).sqrt(), 1.0),
                (off_m, leverage) => (off_m, 1.0 - leverage),
            }),
            _ if by_run => None,
            _ => Some((p.displacement_m - fit.slope_m_per_n * p.force_n, 1.0)),
        };
        let mut residuals = Vec::with_capacity(curve.n_points());
        for run in 0..curve.runs.len() {
            residuals.extend(kept(run).filter_map(|(index, point)| {
                let (value_m, share) = residual(run, point)?;
                Some(Residual {
                    place: (run, index),
                    load: point.load,
                    value_m,
                    share,
                })
            }));
        }
        let (mut deviations, n_loads, squares_m2) = from_load_means(&residuals, curve.loads.len());
        let unknowns = if by_run {
            (2 * lines.iter().flatten().count() + n_loads).saturating_sub(2)
        } else {
            n_loads
        };
        let mut dof = residuals.len().saturating_sub(unknowns) as f64;
        if curve.runs.len() == 1 && go_on(&residuals, &deviations) {
            (deviations, dof) = (Vec::new(), 0.0);
        }
        Self {
            compliance_m_per_n: fit.slope_m_per_n.abs(),
            sum_of_squares_m2: deviations.iter().map(|d| d.distance_m.powi(2)).sum(),
            dof,
            lack_of_fit: match n_loads.checked_sub(2) {
                Some(dof) if by_run => (squares_m2, dof as f64),
                _ => (0.0, 0.0),
            },
            deviations,
        }
    }
}

/// Whether readings of one run at one load move on from one to the next, as on a plateau or in creep, and so repeat nothing.
///
/// Of repeats the squares of the differences between successive readings are twice those of the deviations (von Neumann's ratio), within
/// its standard deviation of about one over the root of the number of differences; the limit is that of 1 %.
fn go_on(residuals: &[Residual], deviations: &[Deviation]) -> bool {
    const LIMIT: f64 = 2.33;
    let pairs = residuals
        .windows(2)
        .filter(|two| two[0].load == two[1].load);
    let (differences, pairs) = pairs.fold((0.0, 0.0), |(sum, n), two| {
        (sum + (two[1].value_m - two[0].value_m).powi(2), n + 1.0)
    });
    let squares: f64 = deviations.iter().map(|one| one.distance_m.powi(2)).sum();
    differences / (2.0 * squares) < 1.0 - LIMIT / f64::sqrt(pairs)
}

/// A reading without the line of its run.
struct Residual {
    place: (usize, usize),
    load: usize,
    value_m: f64,
    share: f64,
}

/// Takes the mean of its load off each residual; loads with a single one carry no information. Besides: number of loads met, and
/// the squares of what was taken off, m².
fn from_load_means(residuals: &[Residual], n_loads: usize) -> (Vec<Deviation>, usize, f64) {
    let mut sums = vec![(0.0, 0_usize); n_loads];
    for residual in residuals {
        let sum = &mut sums[residual.load];
        *sum = (sum.0 + residual.value_m, sum.1 + 1);
    }
    let deviations = residuals
        .iter()
        .filter(|residual| sums[residual.load].1 >= 2)
        .map(|residual| {
            let (sum, n) = sums[residual.load];
            Deviation {
                place: residual.place,
                distance_m: residual.value_m - sum / n as f64,
                variance_share: residual.share * (1.0 - 1.0 / n as f64),
            }
        })
        .collect();
    let met = sums.iter().filter(|(_, n)| *n > 0);
    let squares_m2 = met.clone().map(|(sum, n)| sum * sum / *n as f64).sum();
    (deviations, met.count(), squares_m2)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::readings::Reading;
    use crate::stiffness::curve::Branches;
    use crate::stiffness::sample::{SimulatedBench, cell};

    fn scatters(bench: &SimulatedBench) -> Vec<CellScatter> {
        let readings = bench.readings();
        let size = readings.len() / bench.compliances_m_per_n.len();
        readings
            .chunks(size)
            .map(|readings| {
                let refs: Vec<&Reading> = readings.iter().collect();
                let curve = LoadCurve::new(cell(), &refs, Branches::LoadingOnly);
                let fit = LineFit::new(&curve).unwrap();
                CellScatter::new(&curve, &fit, &[])
            })
            .collect()
    }

    #[test]
    fn the_scatter_is_that_of_readings_and_not_of_zeros_and_slopes() {
        let bench = SimulatedBench {
            zero_sd_m: 50e-6,
            relative_slope_sd: 0.05,
            ..SimulatedBench::paper(200, 11)
        };
        let pooled = PooledScatter::over(scatters(&bench).iter()).unwrap();
        // Five runs of eight loads: 40 - 10 - 6 a cell.
        assert_eq!(pooled.dof, 200.0 * 24.0);
        // 4800 degrees of freedom: the standard deviation is known to 1 %.
        assert!((pooled.mean_sd_m / 6e-6 - 1.0).abs() < 0.04, "{pooled:?}");
    }

    #[test]
    fn soft_cells_show_the_force_gauge_and_stiff_ones_the_displacement_gauge() {
        let bench = SimulatedBench {
            compliances_m_per_n: (0..300)
                .map(|i| if i % 2 == 0 { 3e-6 } else { 130e-6 })
                .collect(),
            reading_sd_m: 2e-6,
            force_step_n: 0.1,
            ..SimulatedBench::paper(1, 5)
        };
        let pooled = PooledScatter::over(scatters(&bench).iter()).unwrap();
        assert!(
            (pooled.displacement_sd_m / 2e-6 - 1.0).abs() < 0.05,
            "{pooled:?}"
        );
        // The step of 0.1 N as a standard deviation, a little less since the unloaded reading has none.
        let expected = 0.1 / 12_f64.sqrt();
        assert!(
            (pooled.force_sd_n / expected - 0.93).abs() < 0.05,
            "{pooled:?}"
        );
    }

    #[test]
    fn one_run_has_nothing_to_compare() {
        let bench = SimulatedBench {
            repeats: 1,
            ..SimulatedBench::paper(3, 1)
        };
        assert_eq!(PooledScatter::over(scatters(&bench).iter()), None);
    }
}
