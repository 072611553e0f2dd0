//! Whether the repeats of a cell refute the straight line whose slope its stiffness is, and which of its loads lie on one.

use super::checks::CellWork;
use super::curve::{Branches, LoadCurve};
use super::flags::{Flag, half};
use super::gauges::GaugePair;
use super::line::StraightLine;
use super::outliers::{ROUNDING, step_variance_m2};
use super::straight_part::StraightPart;
use crate::readings::Reading;
use stiffbench_numeric::statistics::f_upper_tail;

/// Repeats refute a line that they would miss as far with less than this chance.
const LEVEL: f64 = 0.01;

/// Fewest readings of a run whose neighbours tell its scatter.
const MANY: usize = 18;

/// Without repeats a bend below this share of K is not worth a flag: nothing but noise is known of such a run.
const VISIBLE: f64 = 0.05;

/// A part of the loads counts as straight unless its line misses it as far with less than this chance (1): what a test at [`LEVEL`] lets pass may
/// still bend by more than U. By judgement.
const STRAIGHT: f64 = 0.1;

/// Fewest loads that show by themselves that they lie on a line, and share of all loads (1). By judgement.
const FEWEST_STRAIGHT: usize = 4;
/// See [`FEWEST_STRAIGHT`].
const LEAST_SHARE: f64 = 0.3;

/// Most lengths of a part that are tried. It bounds the work of recordings in which each force is a load of its own.
const MOST_LENGTHS: usize = 24;

/// The readings of the longest part of the loads, from the largest or from the smallest on, that the repeats do not refute to be straight, and the
/// ends of its loads, N; a further step of loads is left out where it would be refuted. `None` of loads of both signs or branches.
pub(super) fn straight_readings<'a>(
    readings: &[&'a Reading],
    branches: Branches,
    gauges: &GaugePair,
) -> Option<(Vec<&'a Reading>, [f64; 2])> {
    let used = readings.iter().filter(|one| branches.include(one.branch));
    let mut targets: Vec<f64> = used.map(|reading| reading.target_n).collect();
    targets.sort_by(|a, b| a.abs().total_cmp(&b.abs()));
    targets.dedup();
    let one_way = targets.iter().all(|n| *n >= 0.0) || targets.iter().all(|n| *n <= 0.0);
    if branches == Branches::Both || !one_way {
        return None;
    }
    let count = targets.len();
    let fewest = FEWEST_STRAIGHT.max((LEAST_SHARE * count as f64).ceil() as usize);
    let within = |ends: [f64; 2]| -> Vec<&Reading> {
        let sizes = ends[0].abs()..=ends[1].abs();
        let inside = readings.iter().copied();
        inside
            .filter(|one| sizes.contains(&one.target_n.abs()))
            .collect()
    };
    let chance = |first: usize, last: usize| {
        let inside = within([targets[first], targets[last]]);
        let work = CellWork::new(inside.first()?.cell(), &inside, branches);
        let LackOfFit { f, dof, .. } = work.lack_by_repeats(gauges)?;
        f_upper_tail(f, dof[0], dof[1])
    };
    let step = count.div_ceil(MOST_LENGTHS);
    // One step more is left out than the test asks for.
    let mut lengths = (fewest + step..count).rev().step_by(step);
    lengths.find_map(|length| {
        let parts = [[count - length, count - 1], [0, length - 1]];
        let chances = parts.map(|[first, last]| chance(first, last).unwrap_or(0.0));
        let [[first, last], shorter] = if chances[0] >= chances[1] {
            [parts[0], [step, 0]]
        } else {
            [parts[1], [0, step]]
        };
        let ends = [targets[first + shorter[0]], targets[last - shorter[1]]];
        (chances[0].max(chances[1]) >= STRAIGHT).then(|| (within(ends), ends))
    })
}

/// Lack of fit of a line: its F, and the degrees of freedom of both variances.
struct LackOfFit {
    f: f64,
    dof: [f64; 2],
    by_repeats: bool,
}

impl CellWork {
    /// Flags a cell whose step means are off the line by more than its repeats explain, and whose halves differ by more than U.
    ///
    /// F of the step means against step times run, zero and slope of each run taken out and loads corrected to their mean, with (n - 2) and
    /// (n - 2)(r - 1) degrees of freedom. A display rounds all repeats of a load alike, so its steps count once for each repeat. Without
    /// repeats the second differences of a run of many readings stand in for them.
    ///
    /// # Arguments
    /// - `expanded_n_per_m`: U of the stiffness; `None` without repeats.
    /// - `part`: the loads that lie on a line, where repeats refute that all do.
    pub(super) fn not_straight(
        &self,
        gauges: &GaugePair,
        expanded_n_per_m: Option<f64>,
        part: impl FnOnce() -> Option<StraightPart>,
    ) -> Option<Flag> {
        let lack = self
            .lack_by_repeats(gauges)
            .or_else(|| self.lack_by_neighbours(gauges))?;
        let LackOfFit { f, dof, by_repeats } = lack;
        // Displacements that are too large to be squared tell nothing.
        f_upper_tail(f, dof[0], dof[1]).filter(|p| (f * dof[0]).is_finite() && *p < LEVEL)?;
        let apart = |halves: &[([f64; 2], f64); 2]| (halves[0].1 - halves[1].1).abs();
        // Loads of both signs may bend at zero, or alike on either side of it.
        let halves = [|target_n| target_n, f64::abs].map(|order| halves(&self.curve, order));
        let halves = halves.into_iter().flatten();
        let halves = halves.max_by(|a, b| apart(a).total_cmp(&apart(b)))?;
        let slope = self.line.as_ref().ok()?.slope_m_per_n;
        let least = if by_repeats {
            expanded_n_per_m.unwrap_or_default()
        } else {
            VISIBLE / slope.abs()
        };
        let [departure_m, range_m] = self.departure_and_range();
        (apart(&halves) > least).then(|| {
            let straight_part = by_repeats.then(part).flatten();
            let message = format!(
                "the loads do not lie on a straight line: K is {} and {} (lack of fit against the {}, F({:.0}, {:.0}) = {f:.1}, p < 0.01; the largest departure is {:.1} µm, {:.1} % of the range). U applies to the line and does not include the curvature: state K with a range of loads (stiffbench stiffness --from-load N --to-load N){}",
                half(&halves[0]),
                half(&halves[1]),
                if by_repeats { "repeats" } else { "scatter of neighbours" },
                dof[0],
                dof[1],
                1e6 * departure_m,
                100.0 * (departure_m / range_m),
                straight_part.map_or_else(String::new, |part| format!(". {part}"))
            );
            Flag {
                straight_part,
                ..Flag::new("not-straight", f, message)
            }
        })
    }

    fn lack_by_repeats(&self, gauges: &GaugePair) -> Option<LackOfFit> {
        let scatter = self.scatter.as_ref()?;
        let (squares_m2, dof) = scatter.lack_of_fit;
        let steps_m2 = step_variance_m2(gauges, scatter.compliance_m_per_n);
        let rounding_m = ROUNDING * self.curve.largest_displacement_m();
        let variance_m2 = scatter.sum_of_squares_m2 / scatter.dof
            + steps_m2 * self.curve.runs.len() as f64
            + rounding_m * rounding_m;
        (dof > 0.0 && scatter.dof > 0.0).then(|| LackOfFit {
            f: squares_m2 / dof / variance_m2,
            dof: [dof, scatter.dof],
            by_repeats: true,
        })
    }

    /// Second differences of the residuals of n readings have (n - 2) 18/35 degrees of freedom: their correlations are -2/3 and 1/6.
    fn lack_by_neighbours(&self, gauges: &GaugePair) -> Option<LackOfFit> {
        let [run] = &self.curve.runs[..] else {
            return None;
        };
        if run.points.len() < MANY {
            return None;
        }
        let line = StraightLine::through(run.points.iter())?;
        let off: Vec<f64> = run
            .points
            .iter()
            .map(|point| line.residual_m(point))
            .collect();
        let dof = off.len() as f64 - 2.0;
        let squares: f64 = off.iter().map(|off| off * off).sum();
        let seconds = off.windows(3).map(|w| (w[0] - 2.0 * w[1] + w[2]).powi(2));
        let rounding_m = ROUNDING * self.curve.largest_displacement_m();
        let variance_m2 = seconds.sum::<f64>() / 6.0 / dof
            + step_variance_m2(gauges, line.slope_m_per_n.abs())
            + rounding_m * rounding_m;
        Some(LackOfFit {
            f: squares / dof / variance_m2,
            dof: [dof, dof * 18.0 / 35.0],
            by_repeats: false,
        })
    }

    /// The largest distance of the mean of a load from the lines of the runs, and the range of displacements, m.
    fn departure_and_range(&self) -> [f64; 2] {
        let mut sums = vec![(0.0, 0_usize); self.curve.loads.len()];
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for run in &self.curve.runs {
            let Some(line) = StraightLine::through(run.points.iter()) else {
                continue;
            };
            for point in &run.points {
                let sum = &mut sums[point.load];
                *sum = (sum.0 + line.residual_m(point), sum.1 + 1);
                (low, high) = (
                    low.min(point.displacement_m),
                    high.max(point.displacement_m),
                );
            }
        }
        let means = sums.iter().filter(|(_, n)| *n > 0);
        let largest = means.fold(0.0_f64, |largest, (sum, n)| {
            largest.max((sum / *n as f64).abs())
        });
        [largest, high - low]
    }
}

/// Two halves of the loads in an order: their ends, N, and the stiffness of each, N/m, with a zero for every run.
fn halves(curve: &LoadCurve, order: fn(f64) -> f64) -> Option<[([f64; 2], f64); 2]> {
    let mut loads: Vec<usize> = (0..curve.loads.len()).collect();
    let place = |load: &usize| order(curve.loads[*load].target_n);
    loads.sort_by(|a, b| place(a).total_cmp(&place(b)));
    let half = |loads: &[usize]| {
        let here = |run: &super::curve::Run| {
            StraightLine::through(
                run.points
                    .iter()
                    .filter(|point| loads.contains(&point.load)),
            )
        };
        let lines: Vec<StraightLine> = curve.runs.iter().filter_map(here).collect();
        let sxx: f64 = lines.iter().map(|line| line.sxx_n2).sum();
        let sxy: f64 = lines
            .iter()
            .map(|line| line.sxx_n2 * line.slope_m_per_n)
            .sum();
        let ends = [loads.first()?, loads.last()?].map(|load| curve.loads[*load].target_n);
        (sxy != 0.0).then_some((ends, sxx / sxy))
    };
    Some([
        half(&loads[..loads.len().div_ceil(2)])?,
        half(&loads[loads.len() / 2..])?,
    ])
}
