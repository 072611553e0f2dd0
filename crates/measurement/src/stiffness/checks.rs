//! The checks of a table: each raises flags, none removes a reading.

use super::budget_row::Return;
use super::curve::{Branches, LoadCurve};
use super::flags::{Flag, percent, signed_percent, signed_um, um};
use super::gauges::GaugePair;
use super::line::{FEWEST_RUNS, LineFit, NoStiffness, StraightLine};
use super::outliers::{flag_outliers, reading_sd_m};
use super::scatter::{CellScatter, PooledScatter};
use super::significance::{
    ReadingSeries, SeriesContrast, TestStatistic, student_limit, test_family,
};
use super::zeros::{UnloadedReadings, ZeroDrifts, time_of};
use crate::readings::Reading;
use stiffbench_numeric::statistics::student_t_quantile;
use stiffbench_units_and_text::count::counted;
use stiffbench_units_and_text::digits::significant;
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
        let mut flags = self.flags.iter();
        if let Some(away) = flags.find(|flag| flag.rule == "return-to-zero") {
            return Return::Away(away.size);
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
            let other = opposite[index];
            work.flags.push(Flag::new(
                "force-sign",
                f64::from(other),
                format!(
                    "{other} of {n} forces at {target_n} N have the other sign: check the polarity of the force gauge"
                ),
            ));
        }
        if force_n == 0.0 {
            work.flags.push(Flag::new(
                "zero-force",
                0.0,
                format!("the mean force measured at {target_n} N is zero"),
            ));
            continue;
        }
        // From three repeats on a load has its own scatter, the error of the zeros included.
        let own = load.displacement_m.sd.filter(|_| n >= FEWEST_RUNS);
        let dof = own.map_or(f64::INFINITY, |_| (n - 1) as f64);
        let t = student_t_quantile(0.975, dof).unwrap_or_default();
        let limit_m = (t * own.unwrap_or(sd_m) / (n as f64).sqrt()).max(half_step);
        if displacement_m * force_n < 0.0 {
            work.flags.push(Flag::new(
                "displacement-sign",
                displacement_m,
                format!(
                    "at {target_n} N the mean force is {force_n:.2} N and the mean displacement {}: opposite signs, F/δ has no meaning there",
                    um(displacement_m)
                ),
            ));
        } else if displacement_m.abs() <= limit_m {
            work.flags.push(Flag::new(
                "displacement-not-resolved",
                displacement_m,
                format!(
                    "at {target_n} N the mean displacement {} is within {} of zero (95 % of its scatter, at least half a step): F/δ there is mostly noise",
                    um(displacement_m),
                    um(limit_m)
                ),
            ));
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
        work.flags.push(Flag::new(
            "too-few-loads",
            targets.len() as f64,
            format!(
                "{} under force (limit 3): an offset or curvature cannot be distinguished from the slope",
                counted(targets.len(), "load")
            ),
        ));
    }
    let Ok(line) = &work.line else { return };
    if line.slope_m_per_n < 0.0 {
        let stiffness_n_per_m = 1.0 / line.slope_m_per_n;
        work.flags.push(Flag::new(
            "negative-stiffness",
            stiffness_n_per_m,
            format!(
                "the slope gives {} N/µm: force and displacement move against each other, check the polarity of the gauges",
                significant(stiffness_n_per_m / 1e6, 4)
            ),
        ));
    }
    if let Some(type_a) = line.type_a() {
        let ratio = line.slope_m_per_n.abs() / type_a.standard_uncertainty;
        // Without any scatter the ratio is infinite or, for a flat line, not a number; both are resolved or flagged elsewhere.
        if ratio < SMALLEST_SLOPE_RATIO {
            work.flags.push(Flag::new(
                "slope-not-resolved",
                ratio,
                format!(
                    "the slope is only {ratio:.1} times its standard uncertainty (limit 5): do not trust the interval of its inverse"
                ),
            ));
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

/// Tests series together, each with the place of its cell, and flags every effect that is found.
fn flag_family(
    works: &mut [CellWork],
    family: Vec<(usize, ReadingSeries)>,
    contrast: SeriesContrast,
    pooled: &PooledScatter,
    flag: impl Fn(&CellWork, f64, TestStatistic) -> Flag,
) {
    let (of_work, series): (Vec<usize>, Vec<ReadingSeries>) = family.into_iter().unzip();
    let effects = test_family(&series, contrast, pooled.dof);
    for (index, effect) in of_work.into_iter().zip(effects) {
        if let Some(found) = effect.filter(|e| e.significance.is_found()) {
            let flag = flag(&works[index], found.effect, found.significance);
            works[index].flags.push(flag);
        }
    }
}

/// Slope of the stiffness of a run on its repeat number, relative.
fn flag_repeat_trend(works: &mut [CellWork], pooled: &PooledScatter, gauges: &GaugePair) {
    let series = |work: &CellWork| {
        let compliance = work.compliance();
        let lines: Vec<(usize, StraightLine)> = run_lines(&work.curve).collect();
        if compliance == 0.0 || lines.len() < FEWEST_RUNS {
            return None;
        }
        let sd_m = reading_sd_m(pooled, gauges, compliance) / compliance;
        let variances = lines.iter().map(|(_, line)| sd_m * sd_m / line.sxx_n2);
        let known_variance = variances.sum::<f64>() / lines.len() as f64;
        // To first order a relative change of stiffness is minus that of the slope.
        let points = lines.iter().map(|(run, line)| {
            let repeat = f64::from(work.curve.runs[*run].repeat);
            (repeat, -line.slope_m_per_n / compliance)
        });
        Some(ReadingSeries::new(points, known_variance))
    };
    let works_now = works.iter().enumerate();
    let family: Vec<_> = works_now
        .filter_map(|(index, work)| Some((index, series(work)?)))
        .collect();
    flag_family(
        works,
        family,
        SeriesContrast::Slope,
        pooled,
        |_, per_repeat, test| {
            let found = format!(
                "the stiffness of the runs changes by {} per repeat",
                signed_percent(per_repeat)
            );
            Flag::tested("repeat-trend", per_repeat, &found, test, percent)
        },
    );
}

/// Change of the zero over the time of one gauge zero, from unloaded readings or else from the intercepts of runs.
fn flag_zero_drift(works: &mut [CellWork], pooled: &PooledScatter, gauges: &GaugePair) {
    let sd_m = reading_sd_m(pooled, gauges, 0.0);
    let unloaded = |work: &CellWork| -> Vec<(Vec<(f64, f64)>, f64)> {
        let of_zeros = work.unloaded.by_zero.iter();
        let enough = of_zeros.filter(|readings| readings.len() >= 2);
        enough
            .map(|readings| (readings.clone(), sd_m * sd_m))
            .collect()
    };
    let mut family = Vec::new();
    for (index, work) in works.iter().enumerate() {
        let mut found = unloaded(work);
        if found.is_empty() {
            found = intercepts_by_zero(work, reading_sd_m(pooled, gauges, work.compliance()));
        }
        for (readings, known_variance) in found {
            let times = || readings.iter().map(|(time, _)| *time);
            let first = times().fold(f64::INFINITY, f64::min);
            let last = times().fold(f64::NEG_INFINITY, f64::max);
            if last <= first {
                continue;
            }
            // Time runs from 0 to 1, so that the slope is the change from first to last.
            let points = readings
                .iter()
                .map(|(time, zero_m)| ((time - first) / (last - first), *zero_m));
            family.push((index, ReadingSeries::new(points, known_variance)));
        }
    }
    flag_family(
        works,
        family,
        SeriesContrast::Slope,
        pooled,
        |work, change_m, test| {
            let evidence = if unloaded(work).is_empty() {
                "intercepts of the runs"
            } else {
                "unloaded readings"
            };
            let change = signed_um(change_m);
            let found =
                format!("the {evidence} on one gauge zero move by {change} from first to last");
            Flag::tested("zero-drift", change_m, &found, test, um)
        },
    );
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
    let with_returns = works
        .iter()
        .enumerate()
        .filter(|(_, work)| !work.unloaded.returns_m.is_empty());
    let family: Vec<_> = with_returns
        .map(|(index, work)| {
            let points = work
                .unloaded
                .returns_m
                .iter()
                .map(|return_m| (0.0, *return_m));
            (index, ReadingSeries::new(points, 2.0 * sd_m * sd_m))
        })
        .collect();
    flag_family(
        works,
        family,
        SeriesContrast::Mean,
        pooled,
        |work, mean_m, test| {
            let found = format!(
                "after unloading, the gauge shows {} from its start (mean of {})",
                signed_um(mean_m),
                counted(work.unloaded.returns_m.len(), "run")
            );
            Flag::tested("return-to-zero", mean_m, &found, test, um)
        },
    );
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
                let found = format!(
                    "the displacement falls back by {} from {} N to {} N",
                    um(drop_m),
                    small.target_n,
                    large.target_n
                );
                work.flags
                    .push(Flag::tested("not-monotonic", drop_m, &found, test, um));
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
