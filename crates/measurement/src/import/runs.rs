//! Runs in the path of the load: where it comes back near zero, or to the smallest load, another begins.

use thiserror::Error;

use crate::readings::are_one_load;

/// A run may begin where the load is below this share of the largest.
pub(super) const NEAR_ZERO: f64 = 0.15;

/// Between two runs the load must have been above this share of the largest.
const LOADED: f64 = 0.5;

/// Loads near zero are the same within this share of the largest: noise does not decide which of them begins a run.
const SAME: f64 = 0.02;

/// Loads that never come near zero begin their runs at the smallest, if that is below this share of the largest.
const SMALLEST: f64 = 0.6;

/// The run of each load of a cell, from 1, in the order of measurement.
///
/// Of the loads near zero between two loadings the last of the smallest begins the next run; a single one is where the next run begins.
pub(super) fn runs_of(loads: &[f64]) -> Vec<u32> {
    let (base, range) = base_and_range(loads.iter().copied());
    let mut starts = Vec::new();
    let mut was_loaded = false;
    // The smallest load since the last loading, and where the next run would begin.
    let mut lowest: Option<(f64, usize)> = None;
    for (index, load) in loads.iter().enumerate() {
        let size = load.abs() - base;
        if size >= LOADED * range {
            if let Some((_, start)) = lowest.filter(|_| was_loaded) {
                starts.push(start);
            }
            (was_loaded, lowest) = (true, None);
        } else if size <= NEAR_ZERO * range {
            let least = lowest.map_or(size, |(least, _)| least.min(size));
            let begins = size <= least + SAME * range;
            let start = lowest.filter(|_| !begins).map_or(index, |(_, start)| start);
            lowest = Some((least, start));
        }
    }
    let mut run = 1;
    let mut next = starts.into_iter().peekable();
    let of = |index| {
        if next.next_if_eq(&index).is_some() {
            run += 1;
        }
        run
    };
    (0..loads.len()).map(of).collect()
}

/// The size of the load from which runs begin, and how far it goes from there.
fn base_and_range(loads: impl Iterator<Item = f64>) -> (f64, f64) {
    let (mut smallest, mut largest) = (f64::INFINITY, 0.0_f64);
    for size in loads.map(f64::abs) {
        (smallest, largest) = (smallest.min(size), largest.max(size));
    }
    let is_apart = smallest > NEAR_ZERO * largest && smallest <= SMALLEST * largest;
    let base = if is_apart { smallest } else { 0.0 };
    (base, largest - base)
}

/// Why runs that were found in the path of the load may be others.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum RunDoubt {
    /// Loads begin at the largest.
    #[error("the loads begin at the largest")]
    Descending,
    /// Within a run the load goes up and down more than once.
    #[error("within one of them the load goes up and down more than once")]
    SeveralTurns,
    /// The runs do not reach the same load.
    #[error(
        "they do not reach the same load, as after preloading or with a return to zero after each load"
    )]
    UnequalLoads,
}

/// Why the runs of a cell may be others than those found.
pub(super) fn doubt_of(loads: &[f64], runs: &[u32]) -> Option<RunDoubt> {
    /// Runs that are meant alike reach this share of the largest load.
    const ALIKE: f64 = 0.8;
    let largest = largest_size(loads);
    let of_runs = runs.chunk_by(|a, b| a == b).scan(0, |begin, run| {
        let here = &loads[*begin..*begin + run.len()];
        *begin += run.len();
        Some(here)
    });
    let of_runs: Vec<&[f64]> = of_runs.collect();
    let first = of_runs.first()?;
    let is_one_load = are_one_load(first.iter().copied());
    if !is_one_load && first[0].abs() > ALIKE * largest {
        return Some(RunDoubt::Descending);
    }
    if of_runs
        .iter()
        .any(|run| turns(run, NEAR_ZERO * largest) > 1)
    {
        return Some(RunDoubt::SeveralTurns);
    }
    let unequal = of_runs
        .iter()
        .any(|run| largest_size(run) < ALIKE * largest);
    unequal.then_some(RunDoubt::UnequalLoads)
}

/// Why a column that could number runs or poses does not.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum CounterDoubt {
    /// Each reading has a number of its own.
    #[error("each reading has its own")]
    EachReading,
    /// Each number stands at one load.
    #[error("each of its numbers stands at a load of its own")]
    OneLoadEach,
    /// Numbers change under load, as those of half cycles and of blocks that a recorder saves.
    #[error("it changes under load, where the readings go on")]
    GoesOn,
}

/// Why numbers that change from one of these stretches of a cell to the next are none of runs.
pub(super) fn counts_no_runs(stretches: &[&[f64]]) -> Option<CounterDoubt> {
    /// Loads go on where the next is no further than this many of the largest steps between them.
    const NEXT: f64 = 1.5;
    let all = || stretches.iter().copied().flatten();
    if stretches.len() < 2 || are_one_load(all().copied()) {
        return None;
    }
    if stretches.iter().all(|stretch| stretch.len() == 1) {
        return Some(CounterDoubt::EachReading);
    }
    if stretches
        .iter()
        .any(|stretch| turns_more_than_once(stretch))
    {
        return None;
    }
    let (base, range) = base_and_range(all().copied());
    let within = stretches.iter().flat_map(|stretch| stretch.windows(2));
    let step = within.fold(0.0_f64, |step, two| step.max((two[1] - two[0]).abs()));
    let ends = stretches
        .windows(2)
        .filter_map(|two| Some([*two[0].last()?, *two[1].first()?]));
    let ends: Vec<[f64; 2]> = ends.collect();
    let go_on = ends
        .iter()
        .all(|[last, first]| (first - last).abs() <= NEXT * step);
    let under_load = |end: &f64| end.abs() - base > NEAR_ZERO * range;
    let is_loaded = ends.iter().any(|ends| ends.iter().all(under_load));
    (go_on && is_loaded).then_some(CounterDoubt::GoesOn)
}

/// Whether the load of a run goes up and down more than once.
pub(super) fn turns_more_than_once(loads: &[f64]) -> bool {
    turns(loads, NEAR_ZERO * largest_size(loads)) > 1
}

/// The size of the largest load.
fn largest_size(loads: &[f64]) -> f64 {
    loads
        .iter()
        .fold(0.0_f64, |size, load| size.max(load.abs()))
}

/// How often the size of the load turns by more than `least`.
fn turns(loads: &[f64], least: f64) -> usize {
    let Some(first) = loads.first().map(|load| load.abs()) else {
        return 0;
    };
    let (mut extreme, mut rising, mut turns) = (first, true, 0);
    for size in loads.iter().map(|load| load.abs()) {
        let further = (size > extreme) == rising;
        if further || size == extreme {
            extreme = size;
        } else if (size - extreme).abs() > least {
            (extreme, rising) = (size, !rising);
            turns += 1;
        }
    }
    turns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orders_of_loads_that_are_not_one_way_up_and_down_are_doubted() {
        let doubt = |loads: &[f64]| doubt_of(loads, &runs_of(loads));
        let up_and_down = [0.0, 10.0, 20.0, 10.0, 0.0, 0.0, 10.0, 20.0, 10.0, 0.0];
        assert_eq!(doubt(&up_and_down), None);
        assert_eq!(doubt(&[-0.3, -10.0, -20.0, -0.3, -10.0, -20.0]), None);
        assert_eq!(doubt(&[5.0]), None);
        // Repeats at one load, falling by noise.
        assert_eq!(doubt(&[50.11, 50.05, 50.01]), None);
        assert_eq!(doubt(&[]), None);
        let back_to_zero = [0.0, 10.0, 0.0, 20.0, 0.0, 30.0, 0.0, 40.0];
        assert_eq!(doubt(&back_to_zero), Some(RunDoubt::SeveralTurns));
        let shuffled = [10.0, 40.0, 20.0, 30.0, 15.0];
        assert_eq!(doubt(&shuffled), Some(RunDoubt::SeveralTurns));
        let down = [40.0, 20.0, 0.0, 40.0, 20.0, 0.0];
        assert_eq!(doubt(&down), Some(RunDoubt::Descending));
        let preload = [0.0, 25.0, 0.0, 20.0, 40.0, 0.0, 20.0, 40.0];
        assert_eq!(doubt(&preload), Some(RunDoubt::UnequalLoads));
    }

    #[test]
    fn numbers_of_half_cycles_and_of_readings_are_none_of_runs() {
        let (up, down) = ([0.0, 10.0, 20.0, 30.0], [30.0, 20.0, 10.0, 0.0]);
        assert_eq!(
            counts_no_runs(&[&up, &down, &up, &down]),
            Some(CounterDoubt::GoesOn)
        );
        // Blocks of one sweep.
        let blocks: [&[f64]; 3] = [&[0.0, 5.0, 10.0], &[15.0, 20.0, 18.0], &[14.0, 8.0, 1.0]];
        assert_eq!(counts_no_runs(&blocks), Some(CounterDoubt::GoesOn));
        let each: [&[f64]; 3] = [&[0.0], &[10.0], &[20.0]];
        assert_eq!(counts_no_runs(&each), Some(CounterDoubt::EachReading));
        // Whole cycles, sweeps up, and shuffled loads are runs.
        let cycle = [0.0, 10.0, 20.0, 10.0, 0.0];
        assert_eq!(counts_no_runs(&[&cycle, &cycle]), None);
        assert_eq!(counts_no_runs(&[&up, &up]), None);
        let from_preload = [10.0, 20.0, 30.0, 20.0, 10.0];
        assert_eq!(counts_no_runs(&[&from_preload, &from_preload]), None);
        let shuffled = [10.0, 30.0, 0.0, 20.0, 5.0];
        assert_eq!(counts_no_runs(&[&shuffled, &shuffled]), None);
        // Repeats at one load.
        assert_eq!(counts_no_runs(&[&[50.0], &[50.01]]), None);
    }

    #[test]
    fn steps_up_and_down() {
        let loads = [0.0, 10.0, 20.0, 10.0, 0.0, 0.0, 10.0, 20.0, 10.0, 0.0];
        assert_eq!(runs_of(&loads), [1, 1, 1, 1, 1, 2, 2, 2, 2, 2]);
    }

    #[test]
    fn noise_does_not_decide_which_of_two_zeros_begins_a_run() {
        for [back, again] in [[0.01, -0.04], [0.04, 0.01], [0.0, 0.0]] {
            let loads = [0.0, 25.0, 50.0, 25.0, back, again, 25.0, 50.0, 25.0, 0.02];
            assert_eq!(runs_of(&loads), [1, 1, 1, 1, 1, 2, 2, 2, 2, 2]);
        }
    }

    #[test]
    fn loads_that_jump_back_to_the_smallest_begin_a_run() {
        let weights = [1.0, 2.0, 3.0, 4.0, 5.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        assert_eq!(runs_of(&weights), [1, 1, 1, 1, 1, 2, 2, 2, 2, 2]);
        assert_eq!(
            runs_of(&[-30.0, -40.0, -50.0, -30.0, -40.0, -50.0]),
            [1, 1, 1, 2, 2, 2]
        );
        // A load that is held is one run, whatever its noise.
        assert_eq!(runs_of(&[19.9, 20.1, 19.9, 20.1]), [1, 1, 1, 1]);
    }

    #[test]
    fn steps_up_only_and_a_shared_zero() {
        assert_eq!(
            runs_of(&[1.0, 10.0, 20.0, 1.0, 10.0, 20.0]),
            [1, 1, 1, 2, 2, 2]
        );
        assert_eq!(runs_of(&[0.0, 20.0, 0.0, 20.0, 0.0]), [1, 1, 2, 2, 2]);
        assert_eq!(runs_of(&[-1.0, -20.0, -1.0, -20.0]), [1, 1, 2, 2]);
    }

    #[test]
    fn a_sign_that_changes_and_nothing_at_all() {
        // Without a load near zero in between, both signs are one run.
        assert_eq!(runs_of(&[20.0, -20.0]), [1, 1]);
        assert_eq!(runs_of(&[0.0, 0.0]), [1, 1]);
        assert_eq!(runs_of(&[]), [] as [u32; 0]);
    }
}
