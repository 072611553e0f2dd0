//! Readings far from their repeats.
//!
//! With five repeats a cell cannot test itself: Grubbs' statistic never exceeds 1.789 and its 5 % limit is 1.715. So the
//! standard deviation is pooled over all cells, and the limit is set for all readings of the table together.

use super::checks::CellWork;
use super::flags::{Flag, ReadingPlace, signed_um, um};
use super::gauges::GaugePair;
use super::scatter::{CellScatter, ONE_COMPLIANCE, PooledScatter};
use super::significance::{TestStatistic, deviation_limit};

/// Most readings flagged as outliers in one cell; a cell with more has another fault, which more flags would not make plainer.
const MOST_PER_CELL: usize = 10;

/// Variance shares below this belong to readings that their own line or load mean follows completely.
const SMALLEST_SHARE: f64 = 1e-6;

/// Scatter below this share of the largest displacement is that of arithmetic: readings computed without noise have no outliers.
pub(super) const ROUNDING: f64 = 1e-9;

/// Flags outliers one by one and returns the scatter without them.
///
/// A large outlier moves the line of its run and the mean of its load, and with them its neighbours. So per round only the
/// farthest reading of each cell is flagged, the cell is computed again without it, and the rest is tested again.
pub(super) fn flag_outliers(works: &mut [CellWork], gauges: &GaugePair) -> Option<PooledScatter> {
    let mut pooled = PooledScatter::over(works.iter().filter_map(|w| w.scatter.as_ref()))?;
    let deviations = |w: &CellWork| w.scatter.as_ref().map_or(0, |s| s.deviations.len());
    let n_tested: usize = works.iter().map(deviations).sum();
    for _ in 0..MOST_PER_CELL {
        let Some(limit) = deviation_limit(pooled.dof, n_tested) else {
            break;
        };
        let mut found = false;
        for work in works.iter_mut() {
            found |= flag_farthest(work, &pooled, gauges, limit, n_tested);
        }
        if !found {
            break;
        }
        pooled = PooledScatter::over(works.iter().filter_map(|w| w.scatter.as_ref()))?;
    }
    pooled.smallest_outliers_m = smallest_outliers_m(works, &pooled, gauges);
    Some(pooled)
}

/// See [`PooledScatter::smallest_outliers_m`].
///
/// A bad reading raises the scatter that it is compared with. A reading that is z of its standard deviations σ off makes s² = σ² (1 + q (z² - 1))
/// of its cell, with q from [`VarianceSplit::pull`]; it is found if z² σ² is above the limit L² s², which is z² > L² (1 - q)/(1 - L² q).
fn smallest_outliers_m(
    works: &[CellWork],
    pooled: &PooledScatter,
    gauges: &GaugePair,
) -> Option<[f64; 2]> {
    let cells = || {
        let tested = works.iter().filter_map(|work| {
            let scatter = work.scatter.as_ref()?;
            Some((
                work,
                scatter,
                reading_sd_m(pooled, gauges, scatter.compliance_m_per_n),
            ))
        });
        tested.filter(|(_, scatter, _)| !scatter.deviations.is_empty())
    };
    let n_tested = cells()
        .map(|(_, scatter, _)| scatter.deviations.len())
        .sum();
    let squared_limit = deviation_limit(pooled.dof, n_tested)?.powi(2);
    let split = VarianceSplit::of(cells().map(|(_, scatter, sd_m)| (scatter, sd_m)));
    let found = cells().map(|(work, scatter, sd_m)| {
        let shares = scatter.deviations.iter().map(|d| d.variance_share);
        let share = shares.min_by(f64::total_cmp)?;
        let pull = split.pull(scatter.compliance_m_per_n, sd_m);
        let reachable = squared_limit * pull < 1.0;
        let scatters = sd_m > ROUNDING * work.curve.largest_displacement_m();
        let limit = (squared_limit * (1.0 - pull) / (1.0 - squared_limit * pull)).sqrt();
        (share > SMALLEST_SHARE && reachable && scatters)
            .then(|| TestStatistic::new(0.0, limit, n_tested, sd_m / share.sqrt()).detectable)
    });
    let found: Vec<f64> = found.collect::<Option<_>>()?;
    let least = found.iter().copied().min_by(f64::total_cmp)?;
    let most = found.iter().copied().max_by(f64::total_cmp)?;
    Some([least, most])
}

/// Sums of the weighted least squares that split the variances of the cells into s² = a + b c², at the weights ν/s⁴ that they end with.
#[derive(Debug, Default)]
struct VarianceSplit {
    weight: f64,
    weight_c2: f64,
    weight_c4: f64,
}

impl VarianceSplit {
    /// From the cells, each with the standard deviation of its readings, m.
    fn of<'a>(cells: impl Iterator<Item = (&'a CellScatter, f64)>) -> Self {
        cells.fold(Self::default(), |sums, (cell, sd_m)| {
            let c2 = cell.compliance_m_per_n * cell.compliance_m_per_n;
            let weight = cell.dof / sd_m.powi(4);
            Self {
                weight: sums.weight + weight,
                weight_c2: sums.weight_c2 + weight * c2,
                weight_c4: sums.weight_c4 + weight * c2 * c2,
            }
        })
    }

    /// By how much one square in the sum of a cell raises the s² of that cell: its leverage over its degrees of freedom. Both parts are taken
    /// as free, which is the most that it can be.
    fn pull(&self, compliance_m_per_n: f64, sd_m: f64) -> f64 {
        let c2 = compliance_m_per_n * compliance_m_per_n;
        let Self {
            weight,
            weight_c2,
            weight_c4,
        } = self;
        let determinant = weight * weight_c4 - weight_c2 * weight_c2;
        let leverage = if determinant <= ONE_COMPLIANCE * weight * weight_c4 {
            1.0 / weight
        } else {
            (weight_c4 - 2.0 * weight_c2 * c2 + weight * c2 * c2) / determinant
        };
        leverage / sd_m.powi(4)
    }
}

/// Variance that the display steps of both gauges give a reading, m².
pub(super) fn step_variance_m2(gauges: &GaugePair, compliance: f64) -> f64 {
    let step = gauges.displacement.resolution().unwrap_or(0.0);
    let force_step = gauges.force.resolution().unwrap_or(0.0) * compliance;
    (step * step + force_step * force_step) / 12.0
}

/// Standard deviation of a reading, m, and not less than the display steps alone would give.
pub(super) fn reading_sd_m(pooled: &PooledScatter, gauges: &GaugePair, compliance: f64) -> f64 {
    let steps = step_variance_m2(gauges, compliance).sqrt();
    pooled.sd_m(compliance).max(steps)
}

fn flag_farthest(
    work: &mut CellWork,
    pooled: &PooledScatter,
    gauges: &GaugePair,
    limit: f64,
    n_tested: usize,
) -> bool {
    let (Some(scatter), Ok(line)) = (&work.scatter, &work.line) else {
        return false;
    };
    let sd_m = reading_sd_m(pooled, gauges, scatter.compliance_m_per_n);
    if sd_m <= ROUNDING * work.curve.largest_displacement_m() {
        return false;
    }
    let statistic =
        |d: &super::scatter::Deviation| d.distance_m.abs() / (sd_m * d.variance_share.sqrt());
    let farthest = scatter
        .deviations
        .iter()
        .filter(|d| d.variance_share > SMALLEST_SHARE)
        .max_by(|a, b| statistic(a).total_cmp(&statistic(b)));
    let Some(farthest) = farthest.filter(|d| statistic(d) > limit) else {
        return false;
    };
    let (run, index) = farthest.place;
    let point = &work.curve.runs[run].points[index];
    // A reading that is off by x shows x times its variance share, since it pulls its line and its load mean; in units of the root of
    // that share.
    let error = sd_m / farthest.variance_share.sqrt();
    let deviation_m = farthest.distance_m / farthest.variance_share;
    let found = format!(
        "reading {} (repeat {}, {} N) is {} from what the other readings predict, pooled standard deviation {}",
        point.seq,
        point.repeat,
        work.curve.loads[point.load].target_n,
        signed_um(deviation_m),
        um(sd_m)
    );
    let test = TestStatistic::new(statistic(farthest), limit, n_tested, error);
    work.flags.push(Flag {
        reading: Some(ReadingPlace {
            seq: point.seq,
            line: point.line,
        }),
        ..Flag::tested("outlier", deviation_m, &found, test, um)
    });
    work.excluded.push((run, index));
    work.scatter = Some(CellScatter::new(&work.curve, line, &work.excluded));
    true
}
