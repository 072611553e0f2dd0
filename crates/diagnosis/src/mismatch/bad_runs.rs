//! Bad runs: those whose displacement per force the other repeats of their cell contradict, and cells that yield against their load.
//!
//! Against the mean of its repeats, step by step, a run may differ by a zero and a slope. Slopes of runs scatter; one that is far outside
//! the scatter of all others is a run read with another sign, another decimal point, another scale or another set-up. What repeats in every run cannot enter,
//! and neither does a jump or a single reading of the run that explains more. A cell is judged by itself: a structure yields along its load.

use stiffbench_numeric::statistics::{mean, normal_upper_tail, root_mean_square};
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::bad_readings::{BadReadingKind, slip};
use super::baseline::Baseline;
use super::error::MismatchError;
use super::known_noise::KnownNoise;
use super::noise::{NoiseCovariance, ReadingNoise};
use super::observations::Observations;
use super::reading_screen::ReadingScreen;
use super::tails::{Beside, Tails, chance_if_normal};
use super::wrong_cells::wrong_cells;
use crate::search::constants::{
    AFTER_A_JUMP, BAD_READING_LEVEL, CLEARLY_GOOD, ENOUGH_REPEATS, MOST_BAD_READINGS,
};

/// A run, or all runs of a cell, with a displacement per force that cannot be.
#[derive(Debug, Clone, PartialEq)]
pub struct BadRun {
    /// Lines in their file.
    pub lines: Vec<u32>,
    /// Its pose.
    pub pose: PoseId,
    /// Its direction.
    pub direction: Direction,
    /// Its repeat; none if the cell is meant.
    pub repeat: Option<u32>,
    /// The cell under whose name it was recorded, and the other way round.
    pub exchanged_with: Option<(PoseId, Direction)>,
    /// Displacement per force, m/N.
    pub compliance: f64,
    /// What the other repeats let expect, m/N; of a cell that yields against its load the same with the sign that it must have, of one
    /// that is exchanged or has a wrong decimal point what the other cells let expect.
    pub expected: f64,
    /// Standard error of the difference, m/N.
    pub u: f64,
    /// Chance that the worst of all good runs is as far off.
    pub p_family: f64,
    /// What may have happened.
    pub kind: BadReadingKind,
}

/// Readings without bad runs.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ScreenedRuns {
    /// The others.
    pub(super) observations: Observations,
    /// The bad ones, the worst first.
    pub(super) bad: Vec<BadRun>,
    /// The noise of the others, where it was estimated.
    pub(super) noise: Option<ReadingNoise>,
}

impl BadRun {
    /// # Arguments
    /// - `run`: the run; none if the whole cell is meant.
    /// - `compliance`, `expected`, `u`: m/N.
    pub(super) fn new(
        observations: &Observations,
        (cell, run): (usize, Option<usize>),
        [compliance, expected, u]: [f64; 3],
        p_family: f64,
        kind: BadReadingKind,
    ) -> Self {
        let (own, run) = (
            &observations.cells[cell],
            run.map(|run| &observations.runs[run]),
        );
        let readings = run.map_or(&own.readings, |run| &run.readings).clone();
        let (pose, direction) = observations.name_of(cell);
        Self {
            lines: readings
                .map(|one| observations.readings[one].line)
                .collect(),
            pose,
            direction,
            repeat: run.map(|run| run.repeat),
            exchanged_with: None,
            compliance,
            expected,
            u,
            p_family,
            kind,
        }
    }
}

/// Looks for bad runs, and lays out the others.
///
/// # Errors
/// [`MismatchError`] if the structure cannot be solved at the start of the fit.
pub(super) fn screen_runs(
    baseline: &dyn Baseline,
    observations: &Observations,
    noise: &KnownNoise,
) -> Result<ScreenedRuns, MismatchError> {
    let mut bad = Vec::new();
    let mut rest = observations.clone();
    if rest.is_empty() || rest.free_zeros {
        return Ok(ScreenedRuns {
            observations: rest,
            bad,
            noise: None,
        });
    }
    let mut found = None;
    let most = (MOST_BAD_READINGS * rest.runs.len() as f64).ceil() as usize;
    for _ in 0..most {
        let screen = ReadingScreen::new(baseline, &rest, noise)?;
        let noise_of_all = screen.noise_of(&vec![true; rest.len()], None);
        let Some((worst, worst_bad)) = worst_run(&rest, &screen, &noise_of_all) else {
            found = Some(noise_of_all);
            break;
        };
        let run = rest.runs[worst].readings.clone();
        bad.push(worst_bad);
        rest = rest.filtered(&rest.mask(|one| !run.contains(&one)));
    }
    let screen = ReadingScreen::new(baseline, &rest, noise)?;
    let of_rest = found.unwrap_or_else(|| screen.noise_of(&vec![true; rest.len()], None));
    let against = cells_against_their_load(&rest, &screen, &of_rest);
    let mut known = Some(of_rest);
    let mut take = |rest: &mut Observations, cells: Vec<(usize, BadRun)>| {
        if !cells.is_empty() {
            let is_other = |one: usize| cells.iter().all(|(cell, _)| *cell != rest.cell_of(one));
            *rest = rest.filtered(&rest.mask(is_other));
            bad.extend(cells.into_iter().map(|(_, bad)| bad));
            known = None;
        }
    };
    take(&mut rest, against);
    let wrong = wrong_cells(baseline, &rest, noise)?;
    take(&mut rest, wrong);
    bad.sort_by(|a, b| a.p_family.total_cmp(&b.p_family));
    Ok(ScreenedRuns {
        observations: rest,
        bad,
        noise: known,
    })
}

/// The run that deviates most, with its place, if it is bad.
///
/// # Arguments
/// - `noise_of_all`: the noise of all runs.
fn worst_run(
    observations: &Observations,
    screen: &ReadingScreen<'_>,
    noise_of_all: &ReadingNoise,
) -> Option<(usize, BadRun)> {
    let slopes = run_slopes(observations, screen, noise_of_all, None);
    let ratio = |one: &RunSlope| one.ratio.abs();
    let suspect = slopes.iter().max_by(|a, b| ratio(a).total_cmp(&ratio(b)))?;
    let others = slopes.iter().filter(|one| one.run != suspect.run);
    let others = root_mean_square(others.map(|one| one.ratio))?;
    let as_far = chance_if_normal(suspect.ratio, others, Beside::NOTHING, slopes.len());
    if as_far > CLEARLY_GOOD * BAD_READING_LEVEL {
        return None;
    }
    // What it does to the noise, and to its neighbours, must not speak for it.
    let readings = observations.runs[suspect.run].readings.clone();
    let others = observations.mask(|one| !readings.contains(&one));
    let found = screen.noise_of(&others, None);
    let slopes = run_slopes(observations, screen, &found, Some(suspect.run));
    let own = slopes.iter().find(|one| one.run == suspect.run)?;
    let ratios: Vec<f64> = slopes
        .iter()
        .filter(|one| one.run != own.run)
        .map(|one| one.ratio)
        .collect();
    if ratios.is_empty() || own.is_explained_otherwise {
        return None;
    }
    let tails = Tails::of(&ratios, 1);
    let p_family = tails.p_of_largest(own.ratio, Beside::NOTHING, slopes.len());
    if p_family > BAD_READING_LEVEL {
        return None;
    }
    let expected = own.compliance;
    let u = tails.scale(Beside::NOTHING) * own.u * expected.abs();
    let compliance = expected * (1.0 + own.off);
    let place = (observations.runs[own.run].cell, Some(own.run));
    let kind = slip(compliance, expected, u);
    let values = [compliance, expected, u];
    let bad = BadRun::new(observations, place, values, p_family, kind);
    Some((own.run, bad))
}

/// The slope of a run against its repeats.
struct RunSlope {
    run: usize,
    /// Displacement per force of the repeats, m/N.
    compliance: f64,
    /// Relative difference of its own.
    off: f64,
    /// Standard error of that.
    u: f64,
    ratio: f64,
    /// Whether a jump or one reading of the run explains more.
    is_explained_otherwise: bool,
}

/// Slopes of all runs with two repeats or more beside them.
///
/// # Arguments
/// - `suspect`: no other run is compared with it.
fn run_slopes(
    observations: &Observations,
    screen: &ReadingScreen<'_>,
    noise: &ReadingNoise,
    suspect: Option<usize>,
) -> Vec<RunSlope> {
    let whitening =
        NoiseCovariance::new(observations, noise, &screen.slope_m, &screen.compliance[..]);
    let weights = whitening.covariance.weights();
    let mut out = Vec::new();
    for run in 0..observations.runs.len() {
        let cell = &observations.cells[observations.runs[run].cell];
        // Across the load a compliance may be nothing, and a share of it tells nothing.
        if !cell.is_along_load() {
            continue;
        }
        let others = cell
            .runs
            .clone()
            .filter(|other| *other != run && Some(*other) != suspect);
        let others: Vec<usize> = others.collect();
        if others.len() + 1 < ENOUGH_REPEATS {
            continue;
        }
        out.extend(run_slope(
            observations,
            (run, &others),
            screen,
            (weights, noise),
        ));
    }
    out
}

fn run_slope(
    observations: &Observations,
    (run, others): (usize, &[usize]),
    screen: &ReadingScreen<'_>,
    (weights, noise): (&[f64], &ReadingNoise),
) -> Option<RunSlope> {
    let key = |reading: usize| observations.load_key(reading);
    let force_n = |reading: usize| observations.loads[reading].force_n;
    // Displacement of this run at the forces of its repeats, less theirs; theirs is what the scale of a run multiplies.
    let mut rows: Vec<Row> = Vec::new();
    for reading in observations.runs[run].readings.clone() {
        let repeats = others
            .iter()
            .flat_map(|other| observations.runs[*other].readings.clone());
        let repeats: Vec<usize> = repeats.filter(|one| key(*one) == key(reading)).collect();
        if repeats.len() + 1 < ENOUGH_REPEATS {
            continue;
        }
        let of = |value: &dyn Fn(usize) -> f64| {
            let values: Vec<f64> = repeats.iter().map(|one| value(*one)).collect();
            mean(&values)
        };
        let more_n = force_n(reading) - of(&force_n)?;
        let repeats_m = of(&|one| observations.displacement_m[one])?;
        let more_m = observations.displacement_m[reading] - repeats_m;
        rows.push(Row {
            zero: observations.readings[reading].zero,
            weight: weights[reading] * weights[reading],
            more_m,
            by_force_m: screen.compliance[reading] * more_n,
            slope_m: repeats_m,
        });
    }
    // What a difference of the forces moves has the scale of the run too.
    let uncentred = rows.clone();
    let (mut product, mut square, mut scale) = (0.0, 0.0, 1.0);
    for _ in 0..2 {
        rows.clone_from(&uncentred);
        for row in &mut rows {
            row.more_m -= scale * row.by_force_m;
        }
        centre(&mut rows);
        (product, square) = projection(&rows);
        if square <= 0.0 {
            return None;
        }
        scale = 1.0 + product / square;
    }
    // The repeats scatter as well.
    let as_many = 1.0 + 1.0 / others.len() as f64;
    let off = product / square;
    let u = (as_many * (noise.run_slope_sd.powi(2) + square.recip())).sqrt();
    let fall = |rows: &[Row], moved: &dyn Fn(usize) -> bool| {
        let mut column: Vec<Row> = rows.to_vec();
        for (place, row) in column.iter_mut().enumerate() {
            row.slope_m = f64::from(u8::from(moved(place)));
        }
        centre(&mut column);
        let (product, square) = projection(&column);
        if square > 0.0 {
            product * product / square
        } else {
            0.0
        }
    };
    let count = rows.len();
    let jumps =
        (1..count.saturating_sub(AFTER_A_JUMP)).map(|from| fall(&rows, &|place| place >= from));
    let singles = (0..count).map(|one| fall(&rows, &|place| place == one));
    let most = jumps.chain(singles).fold(0.0, f64::max);
    Some(RunSlope {
        run,
        compliance: screen.compliance[observations.runs[run].readings.start],
        off,
        u,
        ratio: off / u,
        is_explained_otherwise: most > product * product / square,
    })
}

#[derive(Clone)]
struct Row {
    zero: u32,
    weight: f64,
    more_m: f64,
    /// What its force has beyond that of its repeats, times the compliance.
    by_force_m: f64,
    slope_m: f64,
}

/// Takes the zeros out: the weighted means of the rows of each.
fn centre(rows: &mut [Row]) {
    let zeros: std::collections::BTreeSet<u32> = rows.iter().map(|row| row.zero).collect();
    for zero in zeros {
        let of_zero = || rows.iter().filter(|row| row.zero == zero);
        let whole: f64 = of_zero().map(|row| row.weight).sum();
        let more_m = of_zero().map(|row| row.weight * row.more_m).sum::<f64>() / whole;
        let slope_m = of_zero().map(|row| row.weight * row.slope_m).sum::<f64>() / whole;
        for row in rows.iter_mut().filter(|row| row.zero == zero) {
            row.more_m -= more_m;
            row.slope_m -= slope_m;
        }
    }
}

/// Weighted product of the differences with the slopes, and the square of the slopes.
fn projection(rows: &[Row]) -> (f64, f64) {
    let (mut product, mut square) = (0.0, 0.0);
    for row in rows {
        product += row.weight * row.slope_m * row.more_m;
        square += row.weight * row.slope_m * row.slope_m;
    }
    (product, square)
}

/// Cells that yield against their load, where most yield along it: a passive structure yields along every load.
fn cells_against_their_load(
    observations: &Observations,
    screen: &ReadingScreen<'_>,
    found: &ReadingNoise,
) -> Vec<(usize, BadRun)> {
    let uncertainties = screen.relative_uncertainties(found);
    let mut out = Vec::new();
    for (number, (cell, u_relative)) in observations.cells.iter().zip(uncertainties).enumerate() {
        let compliance = screen.compliance[cell.readings.start];
        if compliance >= 0.0 || !cell.is_along_load() {
            continue;
        }
        let p = 2.0 * normal_upper_tail(u_relative.recip());
        let p_family = -(observations.cells.len() as f64 * (-p).ln_1p()).exp_m1();
        if p_family <= BAD_READING_LEVEL {
            let values = [compliance, -compliance, u_relative * compliance.abs()];
            let (place, kind) = ((number, None), BadReadingKind::Sign);
            out.push((
                number,
                BadRun::new(observations, place, values, p_family, kind),
            ));
        }
    }
    // Where most do, the sign of force or displacement is a convention of the session.
    let along = observations
        .cells
        .iter()
        .filter(|cell| cell.is_along_load());
    let is_convention = 2 * out.len() >= along.count();
    if is_convention { Vec::new() } else { out }
}
