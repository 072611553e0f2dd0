//! The checks of a table: each raises flags, none removes a reading.

use super::budget::Return;
use super::curve::{Branches, LoadCurve};
use super::estimate::NoStiffness;
use super::flags::{Flag, ZeroEvidence};
use super::gauges::GaugePair;
use super::line::{FEWEST_RUNS, LineFit, StraightLine};
use super::outliers::{flag_outliers, reading_sd_m};
use super::scatter::{CellScatter, PooledScatter};
use super::significance::{
    ReadingSeries, SeriesContrast, SeriesEffect, TestStatistic, student_limit, test_family,
};
use super::zeros::{UnloadedReadings, ZeroDrifts, time_of};
use crate::readings::Reading;
use stiffbench_numeric::statistics::student_t_quantile;
use stiffbench_units_and_text::test_point::{Branch, Cell};

/// Below this ratio of slope to standard uncertainty, 1/slope is more than 4 % off its linear uncertainty.
const SMALLEST_SLOPE_RATIO: f64 = 5.0;

/// Fewest loads with which anything besides the slope can be seen.
const FEWEST_LOADS: usize = 3;

/// Fewest readings of a run whose line is compared with that of other runs.
const FEWEST_READINGS: usize = 3;

/// One cell on its way to the table.
pub(super) struct CellWork {
    pub(super) curve: LoadCurve,
    pub(super) line: Result<LineFit, NoStiffness>,
    pub(super) unloaded: UnloadedReadings,
    pub(super) scatter: Option<CellScatter>,
    /// Readings flagged as outliers: left out of the pooled scatter, of nothing else.
    pub(super) excluded: Vec<(usize, usize)>,
    pub(super) flags: Vec<Flag>,
}

impl CellWork {
    /// What is known of the unloaded state after the loads.
    pub(super) fn back_to_zero(&self, has_scatter: bool, drifts: &ZeroDrifts) -> Return {
        let away = self.flags.iter().find_map(|flag| match flag {
            Flag::ReturnToZero { mean_m, .. } => Some(*mean_m),
            _ => None,
        });
        if let Some(mean_m) = away {
            return Return::Away(mean_m);
        }
        if has_scatter && !self.unloaded.returns_m.is_empty() {
            return Return::WithinNoise;
        }
        let change = drifts.get(&self.curve.cell);
        let drift_m = change.and_then(|change| change.displacement_m);
        drift_m.map_or(Return::NotMeasured, Return::Checked)
    }

    pub(super) fn new(cell: Cell, readings: &[&Reading], branches: Branches) -> Self {
        let curve = LoadCurve::new(cell, readings, branches);
        let line = LineFit::new(&curve);
        let scatter = line.as_ref().ok();
        let scatter = scatter.map(|line| CellScatter::new(&curve, line, &[]));
        Self {
            unloaded: UnloadedReadings::new(readings),
            curve,
            line,
            scatter,
            excluded: Vec::new(),
            flags: Vec::new(),
        }
    }

    fn compliance(&self) -> f64 {
        self.line.as_ref().map_or(0.0, |line| line.slope_m_per_n)
    }
}

/// Runs all checks over the cells and returns the scatter of readings pooled over them.
pub(super) fn check(works: &mut [CellWork], gauges: &GaugePair) -> Option<PooledScatter> {
    let pooled = flag_outliers(works, gauges);
    for work in works.iter_mut() {
        flag_loads(work, pooled.as_ref(), gauges);
        flag_slope(work);
    }
    if let Some(pooled) = &pooled {
        flag_repeat_trend(works, pooled, gauges);
        flag_zero_drift(works, pooled, gauges);
        flag_return_to_zero(works, pooled, gauges);
        flag_not_monotonic(works, pooled, gauges);
    }
    pooled
}

/// Signs and sizes of force and displacement at each load.
fn flag_loads(work: &mut CellWork, pooled: Option<&PooledScatter>, gauges: &GaugePair) {
    let curve = &work.curve;
    let mut opposite = vec![0; curve.loads.len()];
    for point in curve.points() {
        if point.force_n * curve.loads[point.load].target_n < 0.0 {
            opposite[point.load] += 1;
        }
    }
    let sd_m = pooled.map_or(0.0, |pooled| {
        reading_sd_m(pooled, gauges, work.compliance())
    });
    let half_step = 0.5 * gauges.displacement.resolution().unwrap_or(0.0);
    for index in curve.loaded() {
        let load = &curve.loads[index];
        let (target_n, n) = (load.target_n, load.n);
        let (force_n, displacement_m) = (load.force_n.mean, load.displacement_m.mean);
        if opposite[index] > 0 {
            work.flags.push(Flag::ForceSign {
                target_n,
                n_opposite: opposite[index],
                n,
            });
        }
        if force_n == 0.0 {
            work.flags.push(Flag::ZeroForce { target_n });
            continue;
        }
        // From three repeats on a load has its own scatter, the error of the zeros included.
        let own = load.displacement_m.sd.filter(|_| n >= FEWEST_RUNS);
        let dof = own.map_or(f64::INFINITY, |_| (n - 1) as f64);
        let t = student_t_quantile(0.975, dof).unwrap_or_default();
        let limit_m = (t * own.unwrap_or(sd_m) / (n as f64).sqrt()).max(half_step);
        if displacement_m * force_n < 0.0 {
            work.flags.push(Flag::DisplacementSign {
                target_n,
                force_n,
                displacement_m,
            });
        } else if displacement_m.abs() <= limit_m {
            work.flags.push(Flag::DisplacementNotResolved {
                target_n,
                displacement_m,
                limit_m,
            });
        }
    }
}

/// Sign and size of the slope, and the loads it rests on.
fn flag_slope(work: &mut CellWork) {
    let mut targets: Vec<f64> = work
        .curve
        .loaded()
        .map(|l| work.curve.loads[l].target_n)
        .collect();
    targets.sort_by(f64::total_cmp);
    targets.dedup();
    if targets.len() < FEWEST_LOADS {
        work.flags.push(Flag::TooFewLoads { n: targets.len() });
    }
    let Ok(line) = &work.line else { return };
    if line.slope_m_per_n < 0.0 {
        work.flags.push(Flag::NegativeStiffness {
            stiffness_n_per_m: 1.0 / line.slope_m_per_n,
        });
    }
    if let Some(type_a) = line.type_a() {
        let ratio = line.slope_m_per_n.abs() / type_a.standard_uncertainty;
        // Without any scatter the ratio is infinite or, for a flat line, not a number; both are resolved or flagged elsewhere.
        if ratio < SMALLEST_SLOPE_RATIO {
            work.flags.push(Flag::SlopeNotResolved { ratio });
        }
    }
}

/// Lines of the runs with at least three readings, with their place.
fn run_lines(curve: &LoadCurve) -> impl Iterator<Item = (usize, StraightLine)> + '_ {
    curve.runs.iter().enumerate().filter_map(|(index, run)| {
        let line = StraightLine::through(run.points.iter())?;
        (line.n >= FEWEST_READINGS).then_some((index, line))
    })
}

/// Flags every effect of a family that is found.
fn flag_found(
    works: &mut [CellWork],
    of_work: &[usize],
    effects: Vec<Option<SeriesEffect>>,
    flag: impl Fn(&CellWork, usize, SeriesEffect) -> Flag,
) {
    for (index, effect) in effects.into_iter().enumerate() {
        if let Some(effect) = effect.filter(|e| e.significance.is_found()) {
            let work = &mut works[of_work[index]];
            let flag = flag(work, index, effect);
            work.flags.push(flag);
        }
    }
}

/// Slope of the stiffness of a run on its repeat number, relative.
fn flag_repeat_trend(works: &mut [CellWork], pooled: &PooledScatter, gauges: &GaugePair) {
    let (mut series, mut of_work) = (Vec::new(), Vec::new());
    for (index, work) in works.iter().enumerate() {
        let compliance = work.compliance();
        let lines: Vec<(usize, StraightLine)> = run_lines(&work.curve).collect();
        if compliance == 0.0 || lines.len() < FEWEST_RUNS {
            continue;
        }
        let sd_m = reading_sd_m(pooled, gauges, compliance) / compliance;
        let variances = lines.iter().map(|(_, line)| sd_m * sd_m / line.sxx_n2);
        series.push(ReadingSeries {
            x: lines
                .iter()
                .map(|(run, _)| f64::from(work.curve.runs[*run].repeat))
                .collect(),
            known_variance: variances.sum::<f64>() / lines.len() as f64,
            // To first order a relative change of stiffness is minus that of the slope.
            y: lines
                .iter()
                .map(|(_, line)| -line.slope_m_per_n / compliance)
                .collect(),
        });
        of_work.push(index);
    }
    let effects = test_family(&series, SeriesContrast::Slope, pooled.dof);
    flag_found(works, &of_work, effects, |_, _, effect| Flag::RepeatTrend {
        per_repeat: effect.effect,
        test: effect.significance,
    });
}

/// Change of the zero over the time of one gauge zero, from unloaded readings or else from the intercepts of runs.
fn flag_zero_drift(works: &mut [CellWork], pooled: &PooledScatter, gauges: &GaugePair) {
    let (mut series, mut of_work, mut evidence) = (Vec::new(), Vec::new(), Vec::new());
    for (index, work) in works.iter().enumerate() {
        let sd_m = reading_sd_m(pooled, gauges, 0.0);
        let unloaded = work.unloaded.by_zero.iter();
        let unloaded: Vec<_> = unloaded
            .filter(|readings| readings.len() >= 2)
            .map(|readings| (readings.clone(), sd_m * sd_m))
            .collect();
        let seen_in = if unloaded.is_empty() {
            ZeroEvidence::Intercepts
        } else {
            ZeroEvidence::UnloadedReadings
        };
        let found = if unloaded.is_empty() {
            intercepts_by_zero(work, reading_sd_m(pooled, gauges, work.compliance()))
        } else {
            unloaded
        };
        for (readings, known_variance) in found {
            let times: Vec<f64> = readings.iter().map(|(time, _)| *time).collect();
            let first = times.iter().copied().fold(f64::INFINITY, f64::min);
            let last = times.iter().copied().fold(f64::NEG_INFINITY, f64::max);
            if last <= first {
                continue;
            }
            // Time runs from 0 to 1, so that the slope is the change from first to last.
            series.push(ReadingSeries {
                x: times
                    .iter()
                    .map(|time| (time - first) / (last - first))
                    .collect(),
                y: readings
                    .iter()
                    .map(|(_, displacement)| *displacement)
                    .collect(),
                known_variance,
            });
            of_work.push(index);
            evidence.push(seen_in);
        }
    }
    let effects = test_family(&series, SeriesContrast::Slope, pooled.dof);
    flag_found(works, &of_work, effects, |_, place, effect| {
        Flag::ZeroDrift {
            change_m: effect.effect,
            evidence: evidence[place],
            test: effect.significance,
        }
    });
}

/// Time and intercept of the runs on each gauge zero that has at least two, and the variance of an intercept.
fn intercepts_by_zero(work: &CellWork, sd_m: f64) -> Vec<(Vec<(f64, f64)>, f64)> {
    let curve = &work.curve;
    let has_clock = curve.points().all(|p| p.time_s.is_some());
    let mut by_zero = vec![(Vec::new(), 0.0); curve.n_zeros];
    for (run, line) in run_lines(curve) {
        let first = &curve.runs[run].points[0];
        let time = time_of(first.time_s.filter(|_| has_clock), first.seq);
        let (intercepts, variance) = &mut by_zero[first.zero];
        intercepts.push((time, line.intercept_m));
        let share = 1.0 / line.n as f64 + line.mean_force_n.powi(2) / line.sxx_n2;
        *variance += sd_m * sd_m * share;
    }
    by_zero
        .into_iter()
        .filter(|(intercepts, _)| intercepts.len() >= 2)
        .map(|(intercepts, variance)| {
            let n = intercepts.len() as f64;
            (intercepts, variance / n)
        })
        .collect()
}

/// Unloaded readings after the loads against those before them.
fn flag_return_to_zero(works: &mut [CellWork], pooled: &PooledScatter, gauges: &GaugePair) {
    let sd_m = reading_sd_m(pooled, gauges, 0.0);
    let (mut series, mut of_work) = (Vec::new(), Vec::new());
    for (index, work) in works.iter().enumerate() {
        let returns = &work.unloaded.returns_m;
        if !returns.is_empty() {
            series.push(ReadingSeries {
                x: vec![0.0; returns.len()],
                y: returns.clone(),
                known_variance: 2.0 * sd_m * sd_m,
            });
            of_work.push(index);
        }
    }
    let effects = test_family(&series, SeriesContrast::Mean, pooled.dof);
    flag_found(works, &of_work, effects, |work, _, effect| {
        Flag::ReturnToZero {
            mean_m: effect.effect,
            n_runs: work.unloaded.returns_m.len(),
            test: effect.significance,
        }
    });
}

/// Neighbouring loads of one sign on the loading branch whose displacements stand in the wrong order.
fn flag_not_monotonic(works: &mut [CellWork], pooled: &PooledScatter, gauges: &GaugePair) {
    let pairs: Vec<Vec<(usize, usize)>> = works.iter().map(|w| load_pairs(&w.curve)).collect();
    let n_tested: usize = pairs.iter().map(Vec::len).sum();
    let limit = student_limit(pooled.dof, n_tested);
    for (work, pairs) in works.iter_mut().zip(pairs) {
        let sd_m = reading_sd_m(pooled, gauges, work.compliance());
        for (small, large) in pairs {
            let (small, large) = (&work.curve.loads[small], &work.curve.loads[large]);
            let along = large.target_n.signum() * work.compliance().signum();
            let drop_m = along * (small.displacement_m.mean - large.displacement_m.mean);
            // Loads need not have the same runs, so the scatter of the zeros counts too.
            let variance = |load: &super::curve::LoadMean| {
                load.displacement_m.sd.unwrap_or(0.0).max(sd_m).powi(2) / load.n as f64
            };
            let error = (variance(small) + variance(large)).sqrt();
            let test = TestStatistic::new(drop_m / error, limit, n_tested, error);
            if error > 0.0 && test.is_found() {
                work.flags.push(Flag::NotMonotonic {
                    from_target_n: small.target_n,
                    to_target_n: large.target_n,
                    drop_m,
                    test,
                });
            }
        }
    }
}

/// Pairs of neighbouring loads on the loading branch, from the smaller to the larger, for each sign.
fn load_pairs(curve: &LoadCurve) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    for sign in [-1.0, 1.0] {
        let of_sign: Vec<usize> = (0..curve.loads.len())
            .filter(|&l| curve.loads[l].branch == Branch::Loading)
            .filter(|&l| curve.loads[l].target_n * sign >= 0.0)
            .collect();
        pairs.extend(of_sign.windows(2).map(|pair| (pair[0], pair[1])));
    }
    pairs
}
