//! What the clock shows of a table: which quantity was set, for a machine moves its crosshead, or its force, along ramps or sines of time; and
//! whether time and load ever part.
//!
//! Without times the order of the readings is the clock: machines read at equal intervals.

use stiffbench_numeric::statistics::{Differences, LeastSquaresLine, root_mean_square};

use super::branches::{FEWEST_DIFFERENCES, follow, scatter};
use super::options::TURN_SHARE;
use super::response::ResponseVariable;
use super::table::{SpecimenReading, SpecimenTable};

/// Fewest readings from one turning point to the next that show whether it is a ramp.
const FEWEST: usize = 5;

/// What a controlled axis is off its ramp or sine, as a share of its range (1). By judgement.
const FOLLOWS: f64 = 0.01;

/// By how much the other quantity is further off, as a ratio of root mean squares (1). By judgement.
const CLEARLY: f64 = 2.0;

/// Share by which rates may differ that are one (1). By judgement.
const ONE_RATE: f64 = 0.05;

impl ResponseVariable {
    /// The value of what was set.
    fn of_driver(self, reading: &SpecimenReading) -> f64 {
        match self {
            Self::Displacement => reading.force,
            Self::Force => reading.displacement,
        }
    }

    fn other(self) -> Self {
        match self {
            Self::Displacement => Self::Force,
            Self::Force => Self::Displacement,
        }
    }
}

/// The response of a table that the clock shows: one quantity is a ramp or a sine of time between its turning points, and the other clearly is not.
/// What was set does not scatter more than what was read, each in its own range: steps that are chosen so that the answer rises evenly make no ramp of it.
///
/// # Arguments
/// - `turn_share`: share of a run's range by which the path must come back before a turn counts.
pub(super) fn response_by_clock(
    table: &SpecimenTable,
    turn_share: f64,
) -> Option<ResponseVariable> {
    let both = [ResponseVariable::Displacement, ResponseVariable::Force];
    let mut shown = both.into_iter().filter(|response| {
        let off = off_the_clock(table, *response, turn_share);
        off.is_some_and(|[set, answer]| set < FOLLOWS && CLEARLY * set < answer)
            && scatter_of_driver(table, *response) <= scatter_of_driver(table, response.other())
    });
    let first = shown.next();
    first.filter(|_| shown.next().is_none())
}

/// The response of a table in which one quantity clearly scatters more than the other, each in its own range: a machine follows what it sets
/// closely, and what answers has the noise of the part and of its gauge.
///
/// # Arguments
/// - `turn_share`: as for [`response_by_clock`]; of readings that follow no path neighbours show no scatter.
pub(super) fn response_by_scatter(
    table: &SpecimenTable,
    turn_share: f64,
) -> Option<ResponseVariable> {
    let both = [ResponseVariable::Displacement, ResponseVariable::Force];
    let follows_path = |response: &ResponseVariable| {
        let mut runs = of_runs(table, *response).into_iter();
        runs.all(|driver| !follow(&driver, response.origin(&driver), turn_share).shuffled)
    };
    if !both.iter().all(follows_path) {
        return None;
    }
    both.into_iter().find(|response| {
        let [set, answer] = [*response, response.other()].map(|one| own_scatter(table, one));
        set < FOLLOWS && CLEARLY * set < answer
    })
}

/// What was set in each run.
fn of_runs(table: &SpecimenTable, response: ResponseVariable) -> Vec<Vec<f64>> {
    let mut runs = vec![Vec::new(); table.runs.len()];
    for one in &table.readings {
        runs[one.run as usize].push(response.of_driver(one));
    }
    runs
}

/// Scatter of what was set by its fourth differences where those of the other quantity are small, as a share of its range: what moves both is no
/// scatter, in ramps or in steps.
fn own_scatter(table: &SpecimenTable, response: ResponseVariable) -> f64 {
    let [own, other] = [response, response.other()].map(|quantity| -> Vec<f64> {
        let runs = of_runs(table, quantity);
        let fourth = runs
            .iter()
            .flat_map(|values| Differences::FOURTH.of(values));
        fourth.collect()
    });
    let mut both: Vec<(f64, f64)> = own.into_iter().zip(other).collect();
    if both.len() < FEWEST_DIFFERENCES {
        return 0.0;
    }
    both.sort_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let used = both[..both.len() / 2].iter().map(|(own, _)| *own);
    let fourth = root_mean_square(used).unwrap_or(0.0);
    fourth / Differences::FOURTH.variance.sqrt() / range(table, response)
}

/// Scatter of neighbouring readings of what was set, as a share of its range.
fn scatter_of_driver(table: &SpecimenTable, response: ResponseVariable) -> f64 {
    let values = table.readings.iter().map(|one| response.of_driver(one));
    scatter(&values.collect::<Vec<f64>>())
}

/// Whether what was set went one way in every run, at one rate: then whatever time does, a curve does too.
pub(super) fn is_one_sweep(table: &SpecimenTable) -> bool {
    let clock = clock_of(table);
    let mut rates = Vec::new();
    for run in 0..table.runs.len() {
        let own = (table.readings.iter().enumerate()).filter(|(_, one)| one.run as usize == run);
        let points: Vec<(f64, f64)> = own
            .map(|(place, one)| (clock[place], table.driver(one)))
            .collect();
        let driver: Vec<f64> = points.iter().map(|(_, driver)| *driver).collect();
        let turns = follow(&driver, table.response.origin(&driver), TURN_SHARE).turns;
        let Some(line) = LeastSquaresLine::through(points.iter().copied()) else {
            return false;
        };
        let off = (line.residual_squares / points.len() as f64).sqrt();
        let range = line.slope.abs() * (points[points.len() - 1].0 - points[0].0);
        if !turns.is_empty() || points.len() < FEWEST || off > FOLLOWS * range {
            return false;
        }
        rates.push(line.slope);
    }
    rates
        .iter()
        .all(|rate| (rate / rates[0] - 1.0).abs() < ONE_RATE)
}

/// Times of all readings, s; without them their places in the order of measurement.
fn clock_of(table: &SpecimenTable) -> Vec<f64> {
    let readings = table.readings.iter();
    let times: Option<Vec<f64>> = readings.clone().map(|one| one.time_s).collect();
    times.unwrap_or_else(|| readings.map(|one| f64::from(one.order)).collect())
}

/// How far what was set and what answered are off the ramps, or the sines, of time between the turning points of what was set, whichever is
/// nearer, as shares of their ranges.
fn off_the_clock(
    table: &SpecimenTable,
    response: ResponseVariable,
    turn_share: f64,
) -> Option<[f64; 2]> {
    let (mut ramps, mut half_waves) = (Vec::new(), Vec::new());
    for run in 0..table.runs.len() {
        let of_run = |place: &usize| table.readings[*place].run as usize == run;
        let readings: Vec<usize> = (0..table.readings.len()).filter(of_run).collect();
        let value = |place: &usize| response.of_driver(&table.readings[*place]);
        let driver: Vec<f64> = readings.iter().map(value).collect();
        let path = follow(&driver, response.origin(&driver), turn_share);
        let turns = &path.turns;
        let ends: Vec<usize> = [&[0], &turns[..], &[driver.len().saturating_sub(1)]].concat();
        let parts = ends.windows(2).enumerate();
        for (place, ends) in parts.filter(|(_, ends)| ends[1] >= ends[0] + FEWEST) {
            if place > 0 && place < turns.len() {
                half_waves.push(readings[ends[0]..=ends[1]].to_vec());
            }
            // A ramp ends where its end is reached: what is held there is none.
            let reached = path.reached(&driver, ends[0], ends[1]);
            if reached >= ends[0] + FEWEST {
                ramps.push(readings[ends[0]..=reached].to_vec());
            }
        }
    }
    let clock = clock_of(table);
    let times = |part: &[usize]| -> Vec<f64> { part.iter().map(|place| clock[*place]).collect() };
    let phases = |part: &[usize]| {
        let times = times(part);
        let (first, length) = (times[0], times[times.len() - 1] - times[0]);
        let phase = |time: &f64| (std::f64::consts::PI * (time - first) / length).cos();
        times.iter().map(phase).collect()
    };
    let both = [response, response.other()];
    let off_ramps = off_lines(table, &ramps, both, times);
    let off_waves = off_lines(table, &half_waves, both, phases);
    let nearer = [off_ramps, off_waves].into_iter().flatten();
    nearer.min_by(|a, b| a[0].total_cmp(&b[0]))
}

/// How far quantities are off straight lines of something, each part of the readings on its own.
fn off_lines(
    table: &SpecimenTable,
    parts: &[Vec<usize>],
    quantities: [ResponseVariable; 2],
    of: impl Fn(&[usize]) -> Vec<f64>,
) -> Option<[f64; 2]> {
    let mut squares = [0.0; 2];
    for part in parts {
        let abscissa = of(part);
        for (sum, quantity) in squares.iter_mut().zip(quantities) {
            let value = |place: &usize| quantity.of_driver(&table.readings[*place]);
            let values = part.iter().map(value);
            let line = LeastSquaresLine::through(abscissa.iter().copied().zip(values))?;
            *sum += line.residual_squares;
        }
    }
    let readings: usize = parts.iter().map(Vec::len).sum();
    let off =
        |place: usize| (squares[place] / readings as f64).sqrt() / range(table, quantities[place]);
    Some([off(0), off(1)]).filter(|off| off.iter().all(|off| off.is_finite()))
}

fn range(table: &SpecimenTable, quantity: ResponseVariable) -> f64 {
    let values = table.readings.iter().map(|one| quantity.of_driver(one));
    let ends = values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        (low.min(value), high.max(value))
    });
    ends.1 - ends.0
}
