//! How a display at rest flickers, learnt from its rests, and how likely it is that it stops by itself.

/// Steps of the last digit over which a display flickers in a rest, on average, from which its noise is clear: 20 values of normal noise of 0.4
/// digits range over 1.5. Below it the share of values that differ depends on where between two digits the value lies; from it on that share
/// lies between 0.36 and 0.51 at least.
const CLEAR_DIGITS: f64 = 1.5;

/// Values of a rest from which its flicker is learnt, and rests before that is believed: fewer where noise is clear.
const LEAST_OF_A_REST: usize = 5;
const LEAST_RESTS: u32 = 3;
const CLEAR_RESTS: u32 = 2;

/// The share that is believed lies so many standard deviations below the mean: 1 share in 40 is lower.
const DEVIATIONS: f64 = 2.0;

/// What the rests of a display have shown: in how many of its values the text differed from the one before.
#[derive(Debug, Clone)]
pub(super) struct Flicker {
    rests: u32,
    /// Sums over rests of values, changes, values squared, and changes squared over values.
    values: f64,
    changes: f64,
    values_squared: f64,
    changes_squared: f64,
    /// The smallest share of a rest.
    least: f64,
    /// The sum of the ranges of the rests, steps of the last digit.
    digits: f64,
}

impl Default for Flicker {
    fn default() -> Self {
        Self {
            rests: 0,
            values: 0.0,
            changes: 0.0,
            values_squared: 0.0,
            changes_squared: 0.0,
            least: 1.0,
            digits: 0.0,
        }
    }
}

impl Flicker {
    /// Learns from a rest of so many values, of which `changes` differ from the one before and which range over so many steps of the last digit.
    pub(super) fn learn(&mut self, values: usize, changes: usize, digits: f64) {
        if values < LEAST_OF_A_REST {
            return;
        }
        let (values, changes) = (values as f64, changes as f64);
        self.rests += 1;
        self.values += values;
        self.changes += changes;
        self.values_squared += values * values;
        self.changes_squared += changes * changes / values;
        self.least = self.least.min(succession(values, changes));
        self.digits += digits;
    }

    fn is_clear(&self) -> bool {
        self.digits > CLEAR_DIGITS * f64::from(self.rests)
    }

    /// The share of values that differ in a rest to come, a low one. Where noise is clear that is one share for all rests, apart from what they
    /// differ by beyond what chance leaves (method of moments: Searle, Casella, McCulloch, Variance Components, 1992, chapter 3); otherwise the
    /// smallest seen, for it depends on where between two digits the display stands.
    fn share(&self) -> f64 {
        if !self.is_clear() {
            return self.least;
        }
        let share = succession(self.values, self.changes);
        let of_one = share * (1.0 - share);
        let between = self.changes_squared - self.changes * self.changes / self.values;
        // Chi-square has twice its degrees of freedom as variance.
        let free = f64::from(self.rests - 1);
        let by_chance = of_one * (free + DEVIATIONS * (2.0 * free).sqrt());
        let weight = self.values - self.values_squared / self.values;
        let excess = (between - by_chance).max(0.0) / weight;
        let deviation = (excess + of_one / self.values).sqrt();
        (share - DEVIATIONS * deviation).max(0.0)
    }

    /// How likely it is that no more of so many values at rest differ from the one before, or none of the last `still`; 1 where that is not known.
    /// A display in peak mode goes on from peak to peak, one that is held or repeated shows no change from then on.
    pub(super) fn chance(&self, values: usize, changes: usize, still: usize) -> f64 {
        let is_clear = self.is_clear();
        let needed = if is_clear { CLEAR_RESTS } else { LEAST_RESTS };
        if self.rests < needed || (changes > 0 && !is_clear) {
            return 1.0;
        }
        let share = self.share().min(1.0 - f64::EPSILON);
        let chance_of_no_change = (1.0 - share).powi(still as i32);
        // The lower tail of the binomial distribution.
        let mut term = (1.0 - share).powi(values as i32);
        let mut lower_tail = term;
        for k in 0..changes {
            term *= (values as f64 - k as f64) / (k as f64 + 1.0) * share / (1.0 - share);
            lower_tail += term;
        }
        // The smaller of two chances (Bonferroni).
        (2.0 * lower_tail.min(chance_of_no_change)).min(1.0)
    }
}

/// That all of a few values differ does not mean that all of many will (rule of succession).
fn succession(values: f64, changes: f64) -> f64 {
    (changes / values).min((changes + 1.0) / (values + 2.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_quiet_rest_of_clear_noise_hides_nothing() {
        let mut flicker = Flicker::default();
        for changes in [12, 5, 11, 13] {
            flicker.learn(20, changes, 3.0);
        }
        // 41 of 80: a share of 0.51, and 20 values without a change are none of it.
        assert!(flicker.chance(20, 0, 20) < 1e-4);
        assert!(flicker.chance(20, 10, 2) > 0.2);
        // Nor does one rest in which it ranged over one digit only.
        flicker.learn(20, 9, 1.0);
        assert!(flicker.chance(20, 2, 18) < 1e-3);
    }

    #[test]
    fn without_clear_noise_a_display_may_stand_on_a_digit_or_between_two() {
        let mut flicker = Flicker::default();
        for changes in [12, 5, 11, 13] {
            flicker.learn(20, changes, 1.0);
        }
        assert!(flicker.chance(20, 0, 20) > 1e-3);
        assert_eq!(flicker.chance(20, 1, 19), 1.0);
    }

    #[test]
    fn rests_that_differ_beyond_chance_make_a_low_share_likely() {
        let mut flicker = Flicker::default();
        for changes in [19, 2, 18, 3, 17, 2] {
            flicker.learn(20, changes, 3.0);
        }
        assert!(flicker.chance(20, 0, 20) > 0.9);
    }

    #[test]
    fn nothing_is_known_from_one_rest_or_from_few_values() {
        let mut flicker = Flicker::default();
        flicker.learn(40, 30, 4.0);
        assert_eq!(flicker.chance(40, 0, 40), 1.0);
        flicker.learn(4, 4, 4.0);
        assert_eq!(flicker.chance(40, 0, 40), 1.0);
    }
}
