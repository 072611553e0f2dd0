//! Bad runs: those whose displacement per force the other repeats of their cell contradict, and cells that yield against their load.
//!
//! Against the mean of its repeats, step by step, a run may differ by a zero and a slope. Slopes of runs scatter; one that is far outside
//! the scatter of all others is a run read with another sign, another decimal point, another scale or another set-up. What repeats in every run cannot enter,
//! and neither does a jump or a single reading of the run that explains more. A cell is judged by itself: a structure yields along its load.

use std::collections::BTreeSet;

use stiffbench_numeric::statistics::{mean, normal_upper_tail, root_mean_square};

use super::reading_screen::ReadingScreen;
use super::screened::{BadRun, ScreenedRuns};
use super::usual_factor::misread_factor;
use super::wrong_cells::wrong_cells;
use crate::mismatch::baselines::Baseline;
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::{Beside, KnownNoise, Tails, chance_if_normal};
use crate::mismatch::observed::{Observations, ReadingNoise};
use crate::search::constants::{
    AFTER_A_JUMP, BAD_READING_LEVEL, CLEARLY_GOOD, ENOUGH_REPEATS, MOST_BAD_READINGS, ROUNDING,
};
use crate::search::{FittedRows, RowVector, chance_of_any};

/// Looks for bad runs, and lays out the others.
///
/// # Errors
/// [`MismatchError`] if the structure cannot be solved at the start of the fit.
pub(crate) fn screen_runs(
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
    let most = (MOST_BAD_READINGS * rest.runs.len() as f64).ceil() as usize;
    let (mut known, wrong) = loop {
        let screen = ReadingScreen::new(baseline, &rest, noise)?;
        let of_rest = screen.noise_of_all();
        let worst = if bad.len() < most {
            worst_run(&rest, &screen, &of_rest)
        } else {
            None
        };
        let Some((worst, worst_bad)) = worst else {
            let mut wrong = wrong_cells(baseline, &rest, &screen, &of_rest)?;
            let against = cells_against_their_load(&rest, &screen, &of_rest).into_iter();
            let is_new = |(cell, _): &(usize, BadRun)| wrong.iter().all(|(other, _)| other != cell);
            let against: Vec<(usize, BadRun)> = against.filter(is_new).collect();
            wrong.extend(against);
            break (Some(of_rest), wrong);
        };
        let run = rest.runs[worst].readings.clone();
        bad.push(worst_bad);
        rest = rest.filtered(&rest.mask(|one| !run.contains(&one)));
    };
    if !wrong.is_empty() {
        let is_other = |one: usize| wrong.iter().all(|(cell, _)| *cell != rest.cell_of(one));
        rest = rest.filtered(&rest.mask(is_other));
        bad.extend(wrong.into_iter().map(|(_, bad)| bad));
        known = None;
    }
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
    let others = |slopes: &[RunSlope]| -> Vec<f64> {
        let others = slopes.iter().filter(|one| one.run != suspect.run);
        others.map(|one| one.ratio).collect()
    };
    let scatter = root_mean_square(others(&slopes))?;
    let as_far = chance_if_normal(suspect.ratio, scatter, Beside::NOTHING, slopes.len());
    if as_far > CLEARLY_GOOD * BAD_READING_LEVEL {
        return None;
    }
    // What it does to the noise, and to its neighbours, must not speak for it.
    let readings = observations.runs[suspect.run].readings.clone();
    let kept = observations.mask(|one| !readings.contains(&one));
    let found = screen.noise_of(&kept, None);
    let slopes = run_slopes(observations, screen, &found, Some(suspect.run));
    let own = slopes.iter().find(|one| one.run == suspect.run)?;
    let ratios = others(&slopes);
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
    let factor = misread_factor(compliance, expected, u);
    let values = [compliance, expected, u];
    let bad = BadRun::new(observations, place, values, p_family, factor);
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
    let whitening = screen.whitening(noise);
    let weights = whitening.covariance.weights();
    let all = 0..observations.runs.len();
    let slopes = all.filter_map(|run| {
        let cell = &observations.cells[observations.runs[run].cell];
        let mut others: Vec<usize> = cell.runs.clone().collect();
        others.retain(|other| *other != run && Some(*other) != suspect);
        // Across the load a compliance may be nothing, and a share of it tells nothing.
        let is_compared = cell.is_along_load() && others.len() + 1 >= ENOUGH_REPEATS;
        let slope = || run_slope(observations, (run, &others), screen, (weights, noise));
        is_compared.then(slope).flatten()
    });
    slopes.collect()
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
    let (mut rows, mut columns) = (Vec::new(), <[Vec<f64>; 3]>::default());
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
        let values = [more_m, screen.compliance[reading] * more_n, repeats_m];
        for (column, value) in columns.iter_mut().zip(values) {
            column.push(value);
        }
        rows.push(reading);
    }
    let zero_of = |place: usize| observations.readings[rows[place]].zero;
    let column = |of: &dyn Fn(usize) -> f64| {
        let rows = rows.iter().enumerate();
        let rows = rows.map(|(place, row)| weights[*row] * of(place));
        RowVector::from(rows.collect::<Vec<f64>>())
    };
    let count = rows.len();
    let zeros: BTreeSet<u32> = (0..count).map(zero_of).collect();
    let about_zeros = |of: &dyn Fn(usize) -> f64| {
        let mut fitted = FittedRows::new(column(of).values);
        for zero in &zeros {
            fitted.set_free(
                column(&|place| f64::from(u8::from(zero_of(place) == *zero))),
                0.0,
            );
        }
        fitted
    };
    let [more_m, by_force_m, repeats_m] = columns;
    let slope_of = |fitted: &FittedRows| fitted.shift(column(&|place| repeats_m[place]));
    // What a difference of the forces moves has the scale of the run too.
    let [of_more, of_force] = [&more_m, &by_force_m].map(|values| {
        let slope = slope_of(&about_zeros(&|place| values[place]));
        slope.is_seen(ROUNDING).then(|| slope.size())
    });
    let scale = 1.0 + of_more? - of_force?;
    let fitted = about_zeros(&|place| more_m[place] - scale * by_force_m[place]);
    let slope = slope_of(&fitted);
    // The repeats scatter as well.
    let as_many = 1.0 + 1.0 / others.len() as f64;
    let u = (as_many * (noise.run_slope_sd.powi(2) + slope.square.recip())).sqrt();
    let fall = |is_moved: &dyn Fn(usize) -> bool| {
        let shift = fitted.shift(column(&|place| f64::from(u8::from(is_moved(place)))));
        Some(shift.fall()).filter(|_| shift.is_seen(ROUNDING))
    };
    let jumps = (1..count.saturating_sub(AFTER_A_JUMP)).map(|from| fall(&|place| place >= from));
    let singles = (0..count).map(|one| fall(&|place| place == one));
    let most = jumps.chain(singles).flatten().fold(0.0, f64::max);
    Some(RunSlope {
        run,
        compliance: screen.compliance[observations.runs[run].readings.start],
        off: slope.size(),
        u,
        ratio: slope.size() / u,
        is_explained_otherwise: most > slope.fall(),
    })
}

/// Cells that yield against their load, where most yield along it: a passive structure yields along every load.
fn cells_against_their_load(
    observations: &Observations,
    screen: &ReadingScreen<'_>,
    found: &ReadingNoise,
) -> Vec<(usize, BadRun)> {
    let uncertainties = screen.relative_uncertainties(found);
    let cells = observations.cells.iter().zip(uncertainties).enumerate();
    let against = cells.filter_map(|(number, (cell, u_relative))| {
        let compliance = screen.compliance[cell.readings.start];
        let p = 2.0 * normal_upper_tail(u_relative.recip());
        let p_family = chance_of_any(p, observations.cells.len() as f64);
        let is_against = compliance < 0.0 && cell.is_along_load();
        (is_against && p_family <= BAD_READING_LEVEL).then(|| {
            let values = [compliance, -compliance, u_relative * compliance.abs()];
            let (place, factor) = ((number, None), Some(-1.0));
            let bad = BadRun::new(observations, place, values, p_family, factor);
            (number, bad)
        })
    });
    let against: Vec<(usize, BadRun)> = against.collect();
    // Where most do, the sign of force or displacement is a convention of the session.
    let along = observations.cells.iter();
    let along = along.filter(|cell| cell.is_along_load()).count();
    if 2 * against.len() >= along {
        return Vec::new();
    }
    against
}
