//! The noise of a part's recording, and how much of what a model leaves of it speaks for itself.
//!
//! Nothing is repeated in a recording, so that only the scatter of neighbouring readings counts as noise. What a model leaves beyond that is
//! physics that it does not hold: it goes on from reading to reading, and comes back in every cycle. So many readings say less than so many
//! independent ones would, and evidence is counted by the independent ones.

use super::estimated_noise::EstimatedNoise;
use crate::mismatch::observed::{Observations, OnPath, ReadingNoise};
use crate::search::constants::ENOUGH_OF_A_LINE;
use crate::search::largest;
use stiffbench_beams::physics::TestObject;
use stiffbench_numeric::statistics::{Differences, mean, root_mean_square};

/// Readings of a part from which on they are a recording, of which neighbours show the scatter (1): of fewer the scatter is what a model leaves. By
/// judgement.
const ENOUGH_OF_A_RECORDING: usize = 100;

/// Share of the smallest deviations of neighbours that are used (1): turning points and jumps are among the others.
const USED: f64 = 0.8;

/// Mean square of the smallest [`USED`] of normal deviates: 1 - 2 z φ(z)/0.8 with z = 1.2816.
const MEAN_SQUARE_OF_USED: f64 = 0.4377;

/// Independent values per overlapping second difference of white noise: 18/35.
const PER_DIFFERENCE: f64 = 18.0 / 35.0;

/// Variance of a mean of products of fourth differences of white noise, over that of independent ones (1): 1 + 2 Σ ρ² with ρ = 56/70, 28/70, 8/70, 1/70.
const PER_FOURTH_DIFFERENCE: f64 = 2.63;

/// Times the median size of differences beyond which they are steps and turning points of the path (1): four standard deviations.
const OF_THE_PATH: f64 = 6.0;

/// Standard errors by which the answer must fail to follow what was set (1). By judgement.
const SEEN: f64 = 2.0;

/// How many readings before and after one tell where on the path it is, the most telling first: at both sides along a slope, at one of a step.
const BESIDE: [(usize, usize); 8] = [
    (4, 4),
    (3, 3),
    (2, 2),
    (1, 1),
    (0, 4),
    (4, 0),
    (0, 2),
    (2, 0),
];

/// Deviations by errors of what was set beyond which a reading is not moved to the path (1): that between its neighbours differs from it by 1.22 times
/// as much as its own error. By judgement.
const OFF_PATH: f64 = 4.0;

/// Errors of what was set beyond this share of all that it moves are no errors of a gauge (1): readings that follow no path look like it. By judgement.
const LARGEST_ERRORS: f64 = 0.02;

/// Smallest standard deviation, as a share of the largest answer (1): six digits.
const SIX_DIGITS: f64 = 1e-6;

/// Fewest blocks of which the scatter of means is found.
const FEWEST_BLOCKS: usize = 8;

/// Places of a cycle at which it is compared with the next one.
const PLACES: usize = 32;

impl Observations {
    /// Whether these readings are the recording of a part, long enough to show its own scatter.
    pub(crate) fn is_recording(&self) -> bool {
        self.object != TestObject::Robot
            && self.len() >= ENOUGH_OF_A_RECORDING
            && self.has_long_runs()
    }

    /// The readings of a recording on the path of what was set, each moved there along the slope of the part; `None` where what was set was read
    /// without errors that show.
    ///
    /// By the value that was read itself, errors of what was set look like a function of it. The neighbours of a reading do not share its error; and
    /// what their answers show of their own errors is taken out of them, so that what is left of these is independent of what the part leaves.
    ///
    /// # Arguments
    /// - `residual_m`: what the linear part leaves.
    /// - `compliance`: what an error of what was set moves, by the linear part.
    pub(crate) fn on_its_path(&self, residual_m: &[f64], compliance: &[f64]) -> Option<Self> {
        let moved_m = self.moved_by_errors_of_the_set(residual_m, compliance)?;
        let error_n = moved_m / root_mean_square(compliance.iter().copied())?;
        let mut out = self.clone();
        out.on_path = Some(OnPath {
            error_n,
            resolution_m: self.resolution(),
        });
        // The best linear prediction of an error from what is left at its reading; of physics that is left there it takes next to nothing.
        let share = (moved_m / self.scatter_about_zeros(residual_m))
            .powi(2)
            .min(1.0);
        for run in &self.runs {
            let all = run.readings.clone();
            let zero_m = mean(&residual_m[all.clone()]).unwrap_or(0.0);
            let acted = |row: usize| {
                let error_n = share * (residual_m[row] - zero_m) / compliance[row];
                self.loads[row].force_n + error_n
            };
            for reading in all.clone() {
                let beside = BESIDE.into_iter().filter_map(|(before, after)| {
                    let first = reading.checked_sub(before)?;
                    let last = reading + after;
                    let is_inside = all.start <= first && last < all.end;
                    let sum = || {
                        let rows = (first..reading).chain(reading + 1..=last);
                        rows.map(acted).sum::<f64>()
                    };
                    is_inside.then(|| sum() / (before + after) as f64)
                });
                let mut off_n = beside.map(|force_n| self.loads[reading].force_n - force_n);
                // Further off are steps of the path and its turning points.
                if let Some(off_n) =
                    off_n.find(|off| (compliance[reading] * off).abs() < OFF_PATH * moved_m)
                {
                    out.loads[reading].force_n -= off_n;
                    out.displacement_m[reading] -= compliance[reading] * off_n;
                }
            }
        }
        Some(out)
    }

    /// The noise of a recording: white, from neighbouring readings, or what a model leaves if that is less.
    ///
    /// # Arguments
    /// - `residual_m`: what the model leaves.
    pub(crate) fn noise_of_neighbours(&self, residual_m: &[f64]) -> EstimatedNoise {
        let largest = largest(&self.displacement_m);
        let (of_neighbours, dof) = self.scatter_of_neighbours();
        let floor_m = (self.resolution() / 12.0_f64.sqrt()).max(SIX_DIGITS * largest);
        let left = self.scatter_about_zeros(residual_m);
        let reading_sd_m = of_neighbours.min(left).max(floor_m);
        let noise = ReadingNoise {
            reading_sd_m,
            zero_sd_m: 10.0 * largest,
            ..ReadingNoise::default()
        };
        EstimatedNoise::of_readings(noise, dof)
    }

    /// Standard deviation of a reading about the line between its neighbours, and its degrees of freedom.
    fn scatter_of_neighbours(&self) -> (f64, f64) {
        // Where the path stands still, what is left of errors of the set is related to those of the answer.
        let held = self
            .on_path
            .map_or(0.0, |on_path| OFF_PATH * on_path.error_n);
        let mut squares = Vec::new();
        for run in &self.runs {
            for middle in run.readings.clone().skip(1) {
                if middle + 1 >= run.readings.end {
                    break;
                }
                let driver = |reading: usize| self.loads[reading].force_n;
                let [to, from] = [(middle - 1, middle), (middle, middle + 1)]
                    .map(|(first, second)| driver(second) - driver(first))
                    .map(|moved| if moved.abs() < held { 0.0 } else { moved });
                if to * from < 0.0 {
                    continue;
                }
                let share = if to + from == 0.0 {
                    0.5
                } else {
                    to / (to + from)
                };
                let answer = &self.displacement_m;
                let line = (1.0 - share) * answer[middle - 1] + share * answer[middle + 1];
                let variance = 1.0 + share * share + (1.0 - share) * (1.0 - share);
                squares.push((answer[middle] - line).powi(2) / variance);
            }
        }
        if squares.len() < ENOUGH_OF_A_LINE {
            return (f64::INFINITY, self.len() as f64);
        }
        squares.sort_by(f64::total_cmp);
        let used = (USED * squares.len() as f64) as usize;
        let mean = squares[..used].iter().sum::<f64>() / used as f64;
        (
            (mean / MEAN_SQUARE_OF_USED).sqrt(),
            PER_DIFFERENCE * squares.len() as f64,
        )
    }

    /// Standard deviation by which errors of what was set would move readings if the part followed them, m; `None` where it follows what was read.
    ///
    /// The answer follows every true change along the slope of the part, and no error: what is left of it moves against these errors (attenuation:
    /// Fuller, Measurement Error Models, 1987, section 1.1). Differences of neighbours take the path itself away, but for its steps and turning points.
    fn moved_by_errors_of_the_set(&self, residual_m: &[f64], compliance: &[f64]) -> Option<f64> {
        let of_order = |order: Differences| {
            let mut both: Vec<(f64, f64)> = Vec::new();
            for run in &self.runs {
                let expected_m = |row: usize| compliance[row] * self.loads[row].force_n;
                let expected_m: Vec<f64> = run.readings.clone().map(expected_m).collect();
                let left_m = &residual_m[run.readings.clone()];
                both.extend(order.of(&expected_m).zip(order.of(left_m)));
            }
            both.sort_by(|a, b| a.0.abs().total_cmp(&b.0.abs()));
            let median = both
                .get(both.len() / 2)
                .map_or(0.0, |middle| middle.0.abs());
            both.retain(|(expected_m, _)| expected_m.abs() <= OF_THE_PATH * median);
            (median / order.variance.sqrt(), both, order)
        };
        // In short holds each fourth difference has a step in it, along a sine each second one a curve.
        let [second, fourth] = [Differences::SECOND, Differences::FOURTH].map(of_order);
        let (_, both, order) = if second.0 < fourth.0 { second } else { fourth };
        let (mut against, mut whole, mut error) = (0.0, 0.0, 0.0);
        for (expected_m, left_m) in &both {
            against -= expected_m * left_m;
            whole += expected_m * expected_m;
            error += (expected_m * left_m).powi(2);
        }
        let share = against / whole;
        let standard_error = (PER_FOURTH_DIFFERENCE * error).sqrt() / whole;
        let variance = whole / (both.len() as f64 * order.variance);
        let moved_m = (share.min(1.0) * variance).sqrt();
        let moves = self.loads.iter().zip(compliance);
        let largest_m = largest(
            &moves
                .map(|(load, c)| c * load.force_n)
                .collect::<Vec<f64>>(),
        );
        // On its path a recording says the same, so that a false alarm costs nothing.
        let is_seen = share > SEEN * standard_error && moved_m < LARGEST_ERRORS * largest_m;
        is_seen.then_some(moved_m)
    }

    /// Smallest difference between two answers that were read.
    fn resolution(&self) -> f64 {
        if let Some(on_path) = self.on_path {
            return on_path.resolution_m;
        }
        let mut sorted = self.displacement_m.clone();
        sorted.sort_by(f64::total_cmp);
        let gaps = sorted.windows(2).map(|pair| pair[1] - pair[0]);
        let least = gaps.filter(|gap| *gap > 0.0).fold(f64::INFINITY, f64::min);
        if least.is_finite() { least } else { 0.0 }
    }

    /// Standard deviation about the mean of each zero.
    fn scatter_about_zeros(&self, residual_m: &[f64]) -> f64 {
        let (mut squares, mut dof) = (0.0, 0.0);
        for run in &self.runs {
            let own = &residual_m[run.readings.clone()];
            let mean = own.iter().sum::<f64>() / own.len() as f64;
            squares += own.iter().map(|x| (x - mean).powi(2)).sum::<f64>();
            dof += own.len() as f64 - 1.0;
        }
        (squares / dof.max(1.0)).sqrt()
    }

    /// How many independent values are as much evidence as these residuals: fewer than readings where they go on from one to the next, or come
    /// back in each cycle.
    ///
    /// # Arguments
    /// - `white`: of noise alone independent.
    pub(crate) fn independent_values(&self, white: &[f64]) -> f64 {
        let count = white.len() as f64;
        let square = white.iter().map(|x| x * x).sum::<f64>() / count;
        if square == 0.0 {
            return count;
        }
        // Flyvbjerg & Petersen, Journal of Chemical Physics 91, 1989, p. 461: scatter of means of blocks, of the length that shows most.
        let mut per_value = 1.0_f64;
        let mut means = white.to_vec();
        let mut length = 1.0;
        while means.len() >= FEWEST_BLOCKS {
            let mean_square = means.iter().map(|x| x * x).sum::<f64>() / means.len() as f64;
            per_value = per_value.max(length * mean_square / square);
            means = means
                .chunks_exact(2)
                .map(|pair| 0.5 * (pair[0] + pair[1]))
                .collect();
            length *= 2.0;
        }
        (count / per_value / self.cycles_alike(white)).max(1.0)
    }

    /// How many cycles say no more than one: 1 where none is like the next.
    fn cycles_alike(&self, white: &[f64]) -> f64 {
        let cycles = self.cycles();
        let (mut product, mut square, mut count) = (0.0, 0.0, 0.0);
        for history in &self.histories {
            let mut before: Option<Vec<f64>> = None;
            let readings: Vec<usize> = history.kept_readings().collect();
            let of = |reading: &usize| (self.readings[*reading].run, cycles[*reading]);
            for cycle in readings.chunk_by(|a, b| of(a) == of(b)) {
                let own = &white[cycle[0]..cycle[0] + cycle.len()];
                if own.len() < 2 * PLACES {
                    before = None;
                    continue;
                }
                let place = |k: usize| own[k * (own.len() - 1) / (PLACES - 1)];
                let cycle: Vec<f64> = (0..PLACES).map(place).collect();
                if let Some(before) = &before {
                    count += 1.0;
                    for (a, b) in before.iter().zip(&cycle) {
                        product += a * b;
                        square += 0.5 * (a * a + b * b);
                    }
                }
                before = Some(cycle);
            }
        }
        if square == 0.0 {
            return 1.0;
        }
        1.0 + count * (product / square).max(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mismatch::observed::{
        GaugeSteps, ObservedCell, ObservedReading, ObservedRun, Recorded,
    };
    use crate::tests::normal;
    use stiffbench_beams::physics::LoadPoint;
    use stiffbench_units_and_text::test_point::{Branch, Direction};

    /// One run of a part along a path.
    fn along(path: &[f64], answers: Vec<f64>) -> Observations {
        let recorded = Recorded {
            time: true,
            ..Recorded::default()
        };
        let mut out = Observations::without_readings(GaugeSteps::default(), recorded);
        out.object = TestObject::DisplacementDriven;
        out.runs = vec![ObservedRun {
            cell: 0,
            repeat: 1,
            session_run: 0,
            readings: 0..path.len(),
            goes_on: false,
        }];
        for (place, driver) in path.iter().enumerate() {
            let falls = place > 0 && *driver < path[place - 1];
            out.readings.push(ObservedReading {
                run: 0,
                seq: 0,
                zero: 0,
                branch: if falls {
                    Branch::Unloading
                } else {
                    Branch::Loading
                },
                hold_number: 0,
                time_s: Some(place as f64),
                line: 0,
                target_n: 0.0,
                flagged: false,
            });
            out.loads.push(LoadPoint {
                force_n: *driver,
                step: place as u32,
                ..LoadPoint::default()
            });
        }
        out.displacement_m = answers;
        out.cells = vec![ObservedCell {
            pose: 0,
            load: Direction::X.into(),
            read: Direction::X.into(),
            runs: 0..1,
            readings: 0..path.len(),
        }];
        let object = out.object;
        out.of_part(object)
    }

    /// A triangle of `cycles` cycles with 200 readings each.
    fn triangle(cycles: usize) -> Vec<f64> {
        let of_cycle = |place: usize| (100.0 - (place % 200) as f64).abs() - 100.0;
        (0..200 * cycles).map(of_cycle).collect()
    }

    #[test]
    fn neighbours_show_the_scatter_about_a_curve() {
        let path = triangle(5);
        let errors = normal(path.len(), 1);
        let curve = path.iter().map(|x| 1e-6 * x * x * x);
        let answers: Vec<f64> = curve.zip(&errors).map(|(y, e)| y + 1e-3 * e).collect();
        let table = along(&path, answers.clone());
        let noise = table.noise_of_neighbours(&answers);
        // 514 degrees of freedom of which four fifths are used: the standard error is 4 %.
        let ratio = noise.noise.reading_sd_m / 1e-3;
        assert!((ratio - 1.0).abs() < 0.12, "{ratio}");
    }

    #[test]
    fn errors_of_what_was_set_are_told_from_its_path() {
        // What is read of the path errs by 0.5, the answer by as much: along triangles, and in holds of five readings.
        let holds = triangle(5)
            .iter()
            .map(|x| (x / 20.0).round() * 20.0)
            .collect();
        for path in [triangle(5), holds] {
            let errors = normal(path.len(), 4);
            let read: Vec<f64> = path.iter().zip(&errors).map(|(x, e)| x + 0.5 * e).collect();
            let own = normal(path.len(), 5);
            let answers: Vec<f64> = path
                .iter()
                .zip(&own)
                .map(|(x, e)| 3.0 * x + 1.5 * e)
                .collect();
            let compliance = vec![3.0; path.len()];
            let residual = |table: &Observations| -> Vec<f64> {
                let both = table.displacement_m.iter().zip(&table.loads);
                both.map(|(answer, load)| answer - 3.0 * load.force_n)
                    .collect()
            };
            let table = along(&read, answers.clone());
            let moved = table.on_its_path(&residual(&table), &compliance).unwrap();
            // Each is moved along the slope, so that a line leaves what it left.
            for (before, after) in residual(&table).iter().zip(residual(&moved)) {
                assert!((before - after).abs() < 1e-9);
            }
            let off = |table: &Observations| {
                let both = table.loads.iter().zip(&path);
                root_mean_square(both.map(|(load, path)| load.force_n - path)).unwrap()
            };
            // The mean of eight neighbours errs by a third as much; near turning points and steps it is off them.
            assert!(
                off(&moved) < 0.8 * off(&table),
                "{} {}",
                off(&moved),
                off(&table)
            );
            // The same errors in what acted move the answer too: then nothing is an error of reading.
            let followed: Vec<f64> = read
                .iter()
                .zip(&own)
                .map(|(x, e)| 3.0 * x + 1.5 * e)
                .collect();
            let table = along(&read, followed);
            assert!(table.on_its_path(&residual(&table), &compliance).is_none());
        }
    }

    #[test]
    fn what_goes_on_from_reading_to_reading_counts_less() {
        let path: Vec<f64> = (0..4000).map(f64::from).collect();
        let white = normal(path.len(), 2);
        let table = along(&path, white.clone());
        let count = table.independent_values(&white);
        // Means of 8 blocks scatter by half; white noise is taken for at most twice as correlated.
        assert!(count > 0.4 * 4000.0, "{count}");
        // An autoregressive series is worth n (1 - r)/(1 + r) independent values.
        let mut series = white.clone();
        for place in 1..series.len() {
            series[place] += 0.9 * series[place - 1];
        }
        let count = table.independent_values(&series);
        let expected = 4000.0 * 0.1 / 1.9;
        assert!((0.4..1.6).contains(&(count / expected)), "{count}");
    }

    #[test]
    fn a_cycle_that_comes_back_counts_once() {
        let path = triangle(8);
        let same: Vec<f64> = normal(200, 3).repeat(8);
        let table = along(&path, same.clone());
        let once = along(&path[..200], same[..200].to_vec()).independent_values(&same[..200]);
        let count = table.independent_values(&same);
        assert!((count / once - 1.0).abs() < 0.35, "{count} {once}");
    }
}
