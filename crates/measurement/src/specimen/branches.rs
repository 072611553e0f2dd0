//! Loading and unloading, derived from the path of what was set.

use stiffbench_numeric::statistics::{Differences, NORMAL_MEDIAN_DEVIATION};
use stiffbench_units_and_text::test_point::Branch;

/// Branches and turns of the path of one run.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Path {
    /// A branch for each value.
    pub(crate) branches: Vec<Branch>,
    /// Where the path turns.
    pub(super) turns: Vec<usize>,
    /// Whether it turns too often to have branches.
    pub(super) shuffled: bool,
    /// Share of its range by which it had to come back for a turn.
    pub(super) turn_share: f64,
    /// Share of its range within which values count as held.
    held_share: f64,
}

impl Path {
    /// The first place from `start` on whose value is that of `end`: from there on it is held.
    pub(super) fn reached(&self, values: &[f64], start: usize, end: usize) -> usize {
        let ends = values.iter().copied();
        let [low, high] = [
            ends.clone().fold(f64::INFINITY, f64::min),
            ends.fold(f64::NEG_INFINITY, f64::max),
        ];
        let least = self.held_share * (high - low);
        let is_there = |place: &usize| (values[*place] - values[end]).abs() <= least;
        (start..end).find(is_there).unwrap_or(end)
    }

    /// Number of cycles, each once away and back.
    pub(super) fn cycles(&self) -> u32 {
        (self.turns.len() as u32).div_ceil(2)
    }
}

/// A turn is a return by more than this many standard deviations of the noise of what was set.
const NOISE: f64 = 6.0;

/// Fewest fourth differences that show a scatter. By judgement.
pub(super) const FEWEST_DIFFERENCES: usize = 20;

/// Noise beyond this share of the range is none: then the values come in shuffled order.
const LARGEST_NOISE: f64 = 0.25;

/// The branches of the values of one run, in order of measurement.
///
/// A turn counts when the path comes back from its extreme by more than `turn_share` of its range and by more than noise would; the extreme itself, and
/// what is held there, still belongs to what went before. Away from `origin` is loading, towards it unloading, so that a cycle through both signs has two of each. With a
/// turn in more than a third of the values the loads came in shuffled order and everything is loading: a branch needs three readings
/// to be one.
pub(crate) fn follow(values: &[f64], origin: f64, turn_share: f64) -> Path {
    let noise_share = share_of_noise(values);
    let turn_share = turn_share.max(noise_share);
    let held_share = noise_share / 2.0;
    let turns = turning_points(values, turn_share, held_share);
    if turns.len() * 3 > values.len() {
        return Path {
            branches: vec![Branch::Loading; values.len()],
            turns: Vec::new(),
            shuffled: true,
            turn_share,
            held_share,
        };
    }
    let mut rising = starts_rising(values, turns.first().copied(), origin);
    let mut next_turn = turns.iter().copied().peekable();
    let mut branch = Branch::Loading;
    let branches = (0..values.len()).map(|index| {
        if next_turn.peek().is_some_and(|turn| index > *turn) {
            next_turn.next();
            rising = !rising;
        }
        // At the origin itself a path that comes in is still unloading.
        if values[index] != origin {
            let away = rising == (values[index] > origin);
            branch = if away {
                Branch::Loading
            } else {
                Branch::Unloading
            };
        }
        branch
    });
    Path {
        branches: branches.collect(),
        turns,
        shuffled: false,
        turn_share,
        held_share,
    }
}

/// Share of the range of values that noise alone may come back by; 0 where they are too few, or no noise shows.
fn share_of_noise(values: &[f64]) -> f64 {
    let share = NOISE * scatter(values);
    if share <= LARGEST_NOISE { share } else { 0.0 }
}

/// Standard deviation of the noise of values as a share of their range; 0 where they are too few.
///
/// Fourth differences take any slow change away; the median of their sizes is that of noise even where a few are corners of the path.
pub(super) fn scatter(values: &[f64]) -> f64 {
    let mut sizes: Vec<f64> = Differences::FOURTH
        .of(values)
        .map(f64::abs)
        .filter(|size| size.is_finite())
        .collect();
    if sizes.len() < FEWEST_DIFFERENCES {
        return 0.0;
    }
    let middle = sizes.len() / 2;
    let median = *sizes.select_nth_unstable_by(middle, f64::total_cmp).1;
    let sd = median / (Differences::FOURTH.variance.sqrt() * NORMAL_MEDIAN_DEVIATION);
    let low = values.iter().copied().fold(f64::INFINITY, f64::min);
    let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    sd / (high - low)
}

/// Whether the path goes up to its first turn, or to its end; one that goes nowhere goes away from the origin.
fn starts_rising(values: &[f64], first_turn: Option<usize>, origin: f64) -> bool {
    let end = first_turn.or_else(|| values.len().checked_sub(1));
    match (values.first(), end) {
        (Some(first), Some(end)) if values[end] != *first => values[end] > *first,
        (Some(first), _) => *first >= origin,
        _ => true,
    }
}

/// Places of the extremes from which the path comes back by more than `turn_share` of its range; of an extreme that is held the last, where values
/// within `held_share` of the range count as held.
fn turning_points(values: &[f64], turn_share: f64, held_share: f64) -> Vec<usize> {
    let Some(first) = values.first() else {
        return Vec::new();
    };
    let low = values.iter().copied().fold(*first, f64::min);
    let high = values.iter().copied().fold(*first, f64::max);
    // Halves, because the range of two finite numbers need not be finite.
    let half_range = 0.5 * high - 0.5 * low;
    let by_more = |share: f64, from: f64, to: f64| (0.5 * to - 0.5 * from) > share * half_range;
    let beyond = |from: f64, to: f64| by_more(turn_share, from, to);
    let last_held = |extreme: usize, back: usize| {
        let is_held = |index: &usize| {
            let [value, extreme] = [values[*index], values[extreme]];
            !by_more(held_share, value, extreme) && !by_more(held_share, extreme, value)
        };
        (extreme..back).rev().find(is_held).unwrap_or(extreme)
    };
    let mut turns = Vec::new();
    // The highest and the lowest value since the last turn; their order gives the direction.
    let (mut lowest, mut highest) = (0, 0);
    let mut rising = None;
    for (index, value) in values.iter().copied().enumerate() {
        if value > values[highest] {
            highest = index;
        }
        if value < values[lowest] {
            lowest = index;
        }
        match rising {
            None if beyond(values[lowest], value) => rising = Some(true),
            None if beyond(value, values[highest]) => rising = Some(false),
            Some(true) if beyond(value, values[highest]) => {
                turns.push(last_held(highest, index));
                rising = Some(false);
                lowest = index;
            }
            Some(false) if beyond(values[lowest], value) => {
                turns.push(last_held(lowest, index));
                rising = Some(true);
                highest = index;
            }
            _ => {}
        }
    }
    turns
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `l` and `u` for each value.
    fn letters(values: &[f64], origin: f64, share: f64) -> String {
        let path = follow(values, origin, share);
        let letter = |branch: &Branch| match branch {
            Branch::Loading => 'l',
            Branch::Unloading => 'u',
        };
        path.branches.iter().map(letter).collect()
    }

    #[test]
    fn up_and_down_is_loading_and_unloading() {
        assert_eq!(letters(&[0.0, 10.0, 20.0, 10.0, 0.0], 0.0, 0.05), "llluu");
        // A push has negative forces.
        assert_eq!(
            letters(&[-1.0, -10.0, -20.0, -10.0, 0.0], 0.0, 0.05),
            "llluu"
        );
        assert_eq!(letters(&[], 0.0, 0.05), "");
        assert_eq!(letters(&[3.0, 3.0], 0.0, 0.05), "ll");
        assert_eq!(letters(&[-3.0], 0.0, 0.05), "l");
    }

    #[test]
    fn a_held_extreme_is_loading_to_its_last_reading() {
        assert_eq!(
            letters(&[0.0, 10.0, 20.0, 20.0, 20.0, 10.0, 0.0], 0.0, 0.05),
            "llllluu"
        );
        // Held with the noise of the gauge.
        let noise = |k: usize| 0.05 * (k as f64 * 2.399).sin();
        let ramp = (0..20).map(f64::from);
        let hold = std::iter::repeat_n(20.0, 30);
        let cycle = ramp.clone().chain(hold).chain(ramp.rev());
        let noisy: Vec<f64> = cycle
            .enumerate()
            .map(|(k, value)| value + noise(k))
            .collect();
        let turns = follow(&noisy, 0.0, 0.05).turns;
        assert!(matches!(turns[..], [46..=49]), "{turns:?}");
    }

    #[test]
    fn a_cycle_through_both_signs_has_two_of_each() {
        let quarter = [2.0, 4.0, 6.0];
        let mut cycle = vec![0.0];
        cycle.extend(quarter);
        cycle.extend([4.0, 2.0, 0.0, -2.0, -4.0, -6.0, -4.0, -2.0, 0.0]);
        assert_eq!(letters(&cycle, 0.0, 0.05), "lllluuullluuu");
        assert_eq!(follow(&cycle, 0.0, 0.05).turns.len(), 2);
    }

    #[test]
    fn scatter_below_the_threshold_is_no_turn() {
        let noisy = [0.0, 10.0, 9.6, 20.0, 30.0, 29.7, 40.0];
        assert_eq!(follow(&noisy, 0.0, 0.05).turns.len(), 0);
        // The same scatter with a threshold of a half percent: 0.4 and 0.3 are more than 0.2.
        let fine = follow(&noisy, 0.0, 0.005);
        assert!(fine.shuffled, "four turns in seven readings");
    }

    #[test]
    fn noise_of_what_was_set_makes_no_turn() {
        // Three cycles with a noise of 2 % of the range, by a fixed sequence.
        let mut state = 1_u64;
        let mut noise = || {
            state = state
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1);
            (state >> 33) as f64 / f64::from(1_u32 << 31) - 0.5
        };
        let cycle = |step: i32| f64::from(if step < 40 { step } else { 80 - step });
        let steps = (0..3).flat_map(|_| 0..80);
        let values: Vec<f64> = steps.map(|step| cycle(step) + 2.8 * noise()).collect();
        let path = follow(&values, 0.0, 0.05);
        assert_eq!(
            (path.turns.len(), path.cycles()),
            (5, 3),
            "{}",
            path.turn_share
        );
        assert!(path.turn_share > 0.05);
    }

    #[test]
    fn an_inner_loop_is_found() {
        let path = [
            0.0, 35.0, 70.0, 60.0, 50.0, 30.0, 40.0, 50.0, 70.0, 40.0, 20.0, 0.0,
        ];
        assert_eq!(letters(&path, 0.0, 0.05), "llluuullluuu");
        assert_eq!(turning_points(&path, 0.05, 0.0), [2, 5, 8]);
    }

    #[test]
    fn shuffled_loads_have_no_branches() {
        let path = follow(&[0.0, 300.0, 50.0, 200.0, 10.0, 350.0], 0.0, 0.05);
        assert!(path.shuffled);
        assert_eq!(path.turns.len(), 0);
        assert!(path.branches.iter().all(|b| *b == Branch::Loading));
    }

    #[test]
    fn the_largest_numbers_have_a_range() {
        let path = follow(&[-f64::MAX, 0.0, f64::MAX, 0.0, -f64::MAX], 0.0, 0.05);
        assert_eq!(path.turns.len(), 1);
    }
}
