//! Scatter of a force that the displacement does not follow: that of its gauge.
//!
//! Loads that are set by hand differ from repeat to repeat, and the displacement follows them along the local slope of the curve; an error of the
//! force gauge it does not follow. So the slope within steps, over that between them, is the share of the scatter that is setting (attenuation:
//! Fuller, Measurement Error Models, 1987, section 1.1).

use std::collections::{BTreeMap, HashMap, HashSet};

use crate::mismatch::observed::{Observations, ObservedCell, ReadingNoise, about_means};
use crate::search::constants::LEAST_INDEPENDENT;
use crate::search::{Covariance, largest, push_orthonormal, take_out};
use stiffbench_numeric::statistics::root_mean_square;
use stiffbench_units_and_text::test_point::Branch;

/// Standard errors by which the share of the gauge must exceed zero, and the least share that matters (1): below it the scatter is setting. By
/// judgement.
const CLEAR: f64 = 4.0;
/// See [`CLEAR`].
const LEAST_SHARE: f64 = 0.2;

/// Readings of a run of which the zero and the slope are known apart from the rest. By judgement.
const LEAST_OF_A_LINE: usize = 4;

/// Standard deviation of the error of the force gauge, N; `None` where the displacement follows the force within steps, as far as these show.
///
/// ```text
///   share = 1 - sum of (slope x force within step) (displacement within step) / sum of (slope x force within step)^2
/// ```
///
/// Both without the zero and the slope of their run, which scatter too, where it has readings enough.
pub(super) fn force_scatter(observations: &Observations) -> Option<f64> {
    let mut runs: BTreeMap<usize, Vec<OffStep>> = BTreeMap::new();
    let (mut squares_n, mut dof) = (0.0, 0.0);
    for cell in &observations.cells {
        let mut branches: BTreeMap<bool, BTreeMap<u32, Vec<usize>>> = BTreeMap::new();
        for reading in cell.readings.clone() {
            let steps = branches.entry(unloads(observations, reading)).or_default();
            let step = steps.entry(observations.loads[reading].step).or_default();
            step.push(reading);
        }
        for steps in branches.values() {
            let steps: Vec<&[usize]> = steps.values().map(Vec::as_slice).collect();
            for three in steps.windows(3) {
                let means = [three[0], three[1], three[2]].map(|step| mean(observations, step));
                let [before, step, after] = means;
                let slope = (after.1 - before.1) / (after.0 - before.0);
                if three[1].len() < 2 || !slope.is_finite() {
                    continue;
                }
                for &reading in three[1] {
                    let force_n = observations.loads[reading].force_n - step.0;
                    let run = runs.entry(observations.readings[reading].run).or_default();
                    run.push(OffStep {
                        at_n: step.0,
                        expected_m: slope * force_n,
                        moved_m: observations.displacement_m[reading] - step.1,
                    });
                    squares_n += force_n * force_n;
                }
                dof += three[1].len() as f64 - 1.0;
            }
        }
    }
    let (mut followed, mut whole, mut error) = (0.0, 0.0, 0.0);
    for run in runs.values() {
        let at_n: Vec<f64> = run.iter().map(|off| off.at_n).collect();
        let expected_m = without_line(&at_n, run.iter().map(|off| off.expected_m));
        let moved_m = without_line(&at_n, run.iter().map(|off| off.moved_m));
        for (expected_m, moved_m) in expected_m.iter().zip(moved_m) {
            followed += expected_m * moved_m;
            whole += expected_m * expected_m;
            error += (expected_m * moved_m).powi(2);
        }
    }
    // Robust to what else scatters: the standard error of a sum of products by their own squares.
    let share = 1.0 - followed / whole;
    let standard_error = error.sqrt() / whole;
    let is_clear = share > LEAST_SHARE && share > CLEAR * standard_error;
    (is_clear && dof > 0.0).then(|| (share.min(1.0) * squares_n / dof).sqrt())
}

/// A reading about the mean of its step.
struct OffStep {
    /// Mean force of the step, N.
    at_n: f64,
    /// What its displacement is moved by if it follows the force, and what it is moved by, m.
    expected_m: f64,
    moved_m: f64,
}

/// Values without the straight line through them; as they are where a line would leave next to nothing.
fn without_line(at: &[f64], values: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut values: Vec<f64> = values.collect();
    let mut units = Vec::new();
    if values.len() < LEAST_OF_A_LINE {
        return values;
    }
    for column in [vec![1.0; at.len()], at.to_vec()] {
        push_orthonormal(&mut units, column, LEAST_INDEPENDENT, 0.0);
    }
    take_out(&units, &mut values);
    values
}

/// The force of the readings of each cell about the mean of their step, N, where its gauge scatters; else none. What repeats show of a load by being
/// repeats tells its errors: along these columns every law that knows a load by another way than its reading would explain them.
pub(crate) fn force_within_steps(
    observations: &Observations,
    noise: &ReadingNoise,
) -> Vec<Vec<f64>> {
    let is_one_gauge = observations.gauges.is_empty() && observations.has_series();
    if noise.gauges.force_sd_n == 0.0 || !is_one_gauge {
        return Vec::new();
    }
    let forces = observations.loads.iter().map(|load| load.force_n);
    let within = about_steps(observations, forces.collect());
    let of_cell = |cell: &ObservedCell| {
        let mut column = vec![0.0; observations.len()];
        column[cell.readings.clone()].copy_from_slice(&within[cell.readings.clone()]);
        column
    };
    observations.cells.iter().map(of_cell).collect()
}

/// Where a gauge stood, in the mean over the repeats of each load where nobody knows how the force scatters: its errors move the position at which a
/// gauge is taken to stand, and a period of the gauge would explain them. As it is elsewhere, and where loads were not repeated.
pub(crate) fn positions_of_repeats(observations: &Observations, positions_m: Vec<f64>) -> Vec<f64> {
    if !has_positions_of_repeats(observations) {
        return positions_m;
    }
    let off_m = about_steps(observations, positions_m.clone());
    let both = positions_m.iter().zip(off_m);
    both.map(|(position, off)| position - off).collect()
}

fn has_positions_of_repeats(observations: &Observations) -> bool {
    let is_unknown = observations.is_recording()
        || observations.steps.force_n.is_none() && observations.has_series();
    let forces = observations.loads.iter().map(|load| load.force_n);
    let off_n = about_steps(observations, forces.collect());
    let is_repeated = largest(&off_n) < SAME_LOAD * observations.largest_load();
    is_unknown && is_repeated && 2 * step_count(observations) <= observations.len()
}

fn step_count(observations: &Observations) -> usize {
    let steps: HashSet<usize> = steps(observations).into_iter().collect();
    steps.len()
}

/// Share of its length below which a column over the loads is one of their scatter (1): to what they were set to, order and time follow, and beside the
/// loads as read all that is left of these are the errors of the loads, which a fit takes for a cause.
pub(crate) fn loads_off(observations: &Observations) -> f64 {
    let forces: Vec<f64> = observations.loads.iter().map(|load| load.force_n).collect();
    let off_n = about_steps(observations, forces.clone());
    if largest(&off_n) > SAME_LOAD * observations.largest_load() {
        return 0.0;
    }
    let share = root_mean_square(off_n).zip(root_mean_square(forces));
    share.map_or(0.0, |(off_n, force_n)| {
        BY_SCATTER * off_n / force_n.max(f64::MIN_POSITIVE)
    })
}

/// The same of a period over positions that are means of repeats, m: where the loads of all steps are a whole number of periods apart, what is left
/// of it is the error of these means. Multiplied by the turns of the period per metre it is the share.
///
/// # Arguments
/// - `covariance`: of the readings, whose own errors are those of the positions.
pub(crate) fn positions_off(observations: &Observations, covariance: &Covariance) -> f64 {
    if !has_positions_of_repeats(observations) {
        return 0.0;
    }
    let repeats = observations.len() as f64 / step_count(observations) as f64;
    let own_m = covariance.weights().iter().map(|weight| weight.recip());
    let of_means_m = root_mean_square(own_m).unwrap_or(0.0) / repeats.sqrt();
    std::f64::consts::TAU * BY_SCATTER * of_means_m
}

/// Times by which a column exceeds the length that scatter is expected to give it (1): that of a dozen loads does in one case of a hundred (chi
/// squared).
const BY_SCATTER: f64 = 1.5;

/// Share of the largest load by which loads of one step may differ to be repeats (1). By judgement.
const SAME_LOAD: f64 = 0.05;

/// Times by which the smallest difference between loads exceeds the largest of one load that comes back (1). By judgement.
const APART: f64 = 5.0;

/// For each reading the number of its cell, branch and step; in a recording of one run, whose steps no repeat has, of a load that comes back.
fn steps(observations: &Observations) -> Vec<usize> {
    let mut numbers = HashMap::new();
    let all = 0..observations.len();
    let number = all.map(|reading| {
        let step = observations.loads[reading].step;
        let next = numbers.len();
        let key = (
            observations.cell_of(reading),
            unloads(observations, reading),
            step,
        );
        *numbers.entry(key).or_insert(next)
    });
    let number: Vec<usize> = number.collect();
    if numbers.len() < observations.len() {
        return number;
    }
    loads_that_come_back(observations).unwrap_or(number)
}

fn unloads(observations: &Observations, reading: usize) -> bool {
    observations.readings[reading].branch == Branch::Unloading
}

/// For each reading the number of its cell, branch and load, where loads come back: then differences between sorted loads are either those of a setting
/// or those between loads, and nothing lies between. `None` of loads that are spread evenly, or equal to the last digit.
fn loads_that_come_back(observations: &Observations) -> Option<Vec<usize>> {
    let mut order: Vec<usize> = (0..observations.len()).collect();
    let key = |reading: usize| {
        (
            observations.cell_of(reading),
            unloads(observations, reading),
        )
    };
    let force_n = |reading: usize| observations.loads[reading].force_n;
    order.sort_by(|&a, &b| {
        let place = key(a).cmp(&key(b));
        place.then(force_n(a).total_cmp(&force_n(b)))
    });
    let pairs = || order.windows(2).filter(|pair| key(pair[0]) == key(pair[1]));
    let mut gaps: Vec<f64> = pairs()
        .map(|pair| force_n(pair[1]) - force_n(pair[0]))
        .collect();
    gaps.sort_by(f64::total_cmp);
    // Half of all gaps at least are within loads where each comes back twice.
    let upper = gaps.get(gaps.len() / 2..)?.windows(2);
    let [within, between] = upper
        .map(|pair| [pair[0], pair[1]])
        .filter(|[within, _]| *within > 0.0)
        .max_by(|a, b| (a[1] / a[0]).total_cmp(&(b[1] / b[0])))?;
    if between < APART * within {
        return None;
    }
    let mut number = vec![0; observations.len()];
    let mut last = 0;
    for pair in order.windows(2) {
        let is_same = key(pair[0]) == key(pair[1]) && force_n(pair[1]) - force_n(pair[0]) <= within;
        last += usize::from(!is_same);
        number[pair[1]] = last;
    }
    Some(number)
}

/// Values without the means of their steps.
fn about_steps(observations: &Observations, values: Vec<f64>) -> Vec<f64> {
    let steps = steps(observations);
    let count = steps.iter().max().map_or(0, |last| last + 1);
    about_means(values, steps.into_iter(), count)
}

/// Mean force and displacement of readings.
fn mean(observations: &Observations, readings: &[usize]) -> (f64, f64) {
    let count = readings.len() as f64;
    let sum = readings.iter().fold((0.0, 0.0), |sum, &reading| {
        let force_n = observations.loads[reading].force_n;
        (
            sum.0 + force_n,
            sum.1 + observations.displacement_m[reading],
        )
    });
    (sum.0 / count, sum.1 / count)
}

#[cfg(test)]
mod tests {
    use std::fmt::Write as _;

    use rand::SeedableRng;
    use rand_chacha::ChaCha8Rng;
    use rand_distr::{Distribution, StandardNormal};
    use stiffbench_measurement::readings::read_readings;

    use crate::mismatch::noise::{ForceReading, estimate_noise};
    use crate::mismatch::observed::Observations;

    /// Compliances of cells, um/N.
    const CELLS: [f64; 6] = [3.0, 5.0, 30.0, 40.0, 70.0, 95.0];

    /// The scatter of the force that is found where it is 0.1 N; dial and zero scatter by 3 um, slopes by 0.2 %.
    fn found_n(by_hand: bool, seed: u64) -> f64 {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let mut normal = |sd: f64| -> f64 {
            let value: f64 = StandardNormal.sample(&mut rng);
            sd * value
        };
        let mut table = "pose,direction,step,target_N,repeat,force_N,displacement_um\n".to_owned();
        for (cell, compliance) in CELLS.into_iter().enumerate() {
            for repeat in 1..=5 {
                let (zero, slope) = (normal(3.0), 1.0 + normal(0.002));
                for step in 0..8 {
                    let target = -10.0 * f64::from(step);
                    let force = target + if by_hand { normal(0.3) } else { 0.0 };
                    let read = force + normal(0.1);
                    let moved = compliance * slope * force + zero + normal(3.0);
                    writeln!(
                        table,
                        "P{cell},x,{step},{target},{repeat},{read:.4},{moved:.3}"
                    )
                    .unwrap();
                }
            }
        }
        let table = read_readings("t.csv", table.as_bytes()).unwrap();
        let observations = Observations::new(&table, None);
        let rows = 0..observations.len();
        let compliance: Vec<f64> = rows
            .map(|row| 1e-6 * CELLS[observations.cell_of(row)])
            .collect();
        let loads = observations.loads.iter().zip(&compliance);
        let slope_m: Vec<f64> = loads.map(|(load, c)| c * load.force_n).collect();
        let both = observations.displacement_m.iter().zip(&slope_m);
        let residual_m: Vec<f64> = both.map(|(read, slope)| read - slope).collect();
        let force = ForceReading::AlongLoad(&compliance);
        let found = estimate_noise(
            &observations,
            &residual_m,
            (&slope_m, force),
            None,
            None,
            None,
        );
        found.noise.gauges.force_sd_n
    }

    #[test]
    fn the_scatter_of_a_force_is_found_with_dead_weights_and_with_loads_set_by_hand() {
        for by_hand in [false, true] {
            for seed in 0..5 {
                let found_n = found_n(by_hand, seed);
                // About 100 degrees of freedom in the soft cells: 7 % of the standard deviation, three of them.
                assert!(
                    (found_n - 0.1).abs() < 0.02,
                    "{by_hand} {seed}: {found_n} N"
                );
            }
        }
    }
}
