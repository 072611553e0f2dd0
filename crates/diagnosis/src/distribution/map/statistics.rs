//! What a column of a map amounts to, and how well so many poses tell it.

use stiffbench_numeric::statistics::{Estimate, normal_quantile};

use super::stiffness_map::StiffnessMap;
use crate::distribution::pose_set::{PoseSample, SHIFTS, Sampling};

/// Shares of the poses whose quantiles are told: the middle, its half, and nine tenths.
const SHARES: [f64; 5] = [0.05, 0.25, 0.5, 0.75, 0.95];

/// An extreme pose of a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SampledExtreme {
    /// Its row.
    pub row: usize,
    /// Stiffness, N/m.
    pub stiffness_n_per_m: f64,
}

/// The stiffness below which a share of the workspace lies.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Quantile {
    /// The share of poses.
    pub share: f64,
    /// Between the two nearest poses in proportion (Hyndman and Fan's seventh definition), N/m.
    pub stiffness_n_per_m: f64,
    /// 95 % interval for that of all poses, from the ranks between which it lies (Conover, Practical Nonparametric Statistics, 3rd ed., section
    /// 3.2): no assumption on the distribution. Too wide for points more even than chance; `None` for a grid, or where so few
    /// poses lie beyond that there is no rank.
    pub interval_95: Option<[f64; 2]>,
}

/// Statistics of a column, N/m.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnStatistics {
    /// Number of poses in which something yields: all numbers are of these.
    pub poses: usize,
    /// Number of the others, in which the stiffness is infinite.
    pub rigid: usize,
    /// The least stiff pose.
    pub smallest: SampledExtreme,
    /// The stiffest pose.
    pub largest: SampledExtreme,
    /// Mean with its sampling uncertainty: random poses by their scatter, low-discrepancy points by the scatter of their shifts; a grid
    /// has none.
    pub mean: Estimate,
    /// Standard deviation over the poses; `None` for one pose.
    pub standard_deviation_n_per_m: Option<f64>,
    /// Quantiles, from the smallest share on.
    pub quantiles: Vec<Quantile>,
    /// Share of the workspace that lies beyond each sampled extreme at most, with 95 % confidence: 1 - 0.05^(1/n). `None` for a grid.
    pub share_beyond_95: Option<f64>,
}

/// Statistics of a column; `None` if nothing yields in any row.
#[must_use]
pub fn column_statistics(
    map: &StiffnessMap,
    poses: &PoseSample,
    sampling: Sampling,
    column: usize,
) -> Option<ColumnStatistics> {
    let all: Vec<f64> = map.column(column).collect();
    let (smallest, largest) = extremes(&all)?;
    let values: Vec<f64> = all.iter().copied().filter(|k| k.is_finite()).collect();
    let count = values.len();
    let mean = values.iter().sum::<f64>() / count as f64;
    let squares: f64 = values
        .iter()
        .map(|value| (value - mean) * (value - mean))
        .sum();
    let standard_deviation = (count > 1).then(|| (squares / (count - 1) as f64).sqrt());
    let by_chance = sampling != Sampling::Grid;
    let mean = match (sampling, standard_deviation) {
        (Sampling::MonteCarlo, Some(deviation)) => Estimate {
            value: mean,
            standard_uncertainty: deviation / (count as f64).sqrt(),
            dof: (count - 1) as f64,
        },
        (Sampling::LowDiscrepancy, _) => mean_of_shifts(map, poses, &all, mean),
        _ => Estimate::without_uncertainty(mean),
    };
    let mut sorted = values;
    sorted.sort_unstable_by(f64::total_cmp);
    Some(ColumnStatistics {
        poses: count,
        rigid: all.len() - count,
        smallest,
        largest,
        mean,
        standard_deviation_n_per_m: standard_deviation,
        quantiles: SHARES
            .map(|share| Quantile {
                share,
                stiffness_n_per_m: quantile(&sorted, share),
                interval_95: by_chance.then(|| rank_interval(&sorted, share)).flatten(),
            })
            .to_vec(),
        share_beyond_95: by_chance.then(|| 1.0 - 0.05_f64.powf(1.0 / count as f64)),
    })
}

/// The first of the smallest and the first of the largest, of those that are finite.
fn extremes(values: &[f64]) -> Option<(SampledExtreme, SampledExtreme)> {
    let all = values.iter().enumerate().map(|(row, &k)| SampledExtreme {
        row,
        stiffness_n_per_m: k,
    });
    let mut finite = all.filter(|here| here.stiffness_n_per_m.is_finite());
    let first = finite.next()?;
    let (mut smallest, mut largest) = (first, first);
    for here in finite {
        let stiffness_n_per_m = here.stiffness_n_per_m;
        if stiffness_n_per_m < smallest.stiffness_n_per_m {
            smallest = here;
        }
        if stiffness_n_per_m > largest.stiffness_n_per_m {
            largest = here;
        }
    }
    Some((smallest, largest))
}

/// The mean, with the uncertainty that the means of the shifts show.
fn mean_of_shifts(map: &StiffnessMap, poses: &PoseSample, values: &[f64], mean: f64) -> Estimate {
    let mut sums = [(0.0, 0_usize); SHIFTS as usize];
    let rows = map.places.iter().zip(values);
    for (&place, value) in rows.filter(|(_, value)| value.is_finite()) {
        let shift = poses.ids[place as usize] % SHIFTS;
        let (sum, count) = &mut sums[shift as usize];
        *sum += value;
        *count += 1;
    }
    if sums.iter().any(|(_, count)| *count == 0) {
        return Estimate::without_uncertainty(mean);
    }
    let means = sums.map(|(sum, count)| sum / count as f64);
    let shifts = SHIFTS as f64;
    let centre = means.iter().sum::<f64>() / shifts;
    let squares: f64 = means.iter().map(|m| (m - centre) * (m - centre)).sum();
    Estimate {
        value: mean,
        standard_uncertainty: (squares / (shifts * (shifts - 1.0))).sqrt(),
        dof: shifts - 1.0,
    }
}

/// The value below which a share of sorted values lies, between its neighbours by the straight line.
pub(super) fn quantile(sorted: &[f64], share: f64) -> f64 {
    let place = share * (sorted.len() - 1) as f64;
    let below = place.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    let part = place - below as f64;
    sorted[below] + part * (sorted[above] - sorted[below])
}

/// The values at the ranks between which the quantile lies with 95 %, by the normal approximation of the binomial distribution.
fn rank_interval(sorted: &[f64], share: f64) -> Option<[f64; 2]> {
    let count = sorted.len() as f64;
    let spread = normal_quantile(0.975) * (count * share * (1.0 - share)).sqrt();
    let lower = (count * share - spread).floor();
    let upper = (count * share + spread).ceil() + 1.0;
    let value = |rank: f64| (rank >= 1.0 && rank <= count).then(|| sorted[rank as usize - 1]);
    Some([value(lower)?, value(upper)?])
}
