//! The last digits of a gauge: whether it counts in coarser steps than its text has, or digits of it stand still.

use std::collections::VecDeque;

/// Values at rest that are remembered.
const REMEMBERED: usize = 64;

/// Values of any kind that are remembered, a few seconds of motion.
const REMEMBERED_ALL: usize = 256;

/// Steps of the last digit from which a common step of all values is coarser than the text.
const COARSE: i64 = 5;

/// Logarithm of the odds against chance beyond which it is none: 1 in 160 000.
const ODDS: f64 = 12.0;

/// A change at the rate of the one before, to within this share, carries no information on steps: a drive of constant speed leaves equal ones.
const SAME_RATE: f64 = 0.2;

/// Values of a gauge, as counts of the last digit sent. On the way a drive leaves a pattern of its own, in which some digits are rare; where it
/// stops, any last digit may come. That all values are multiples of one coarse step is no pattern of a drive, unless its speed is constant.
#[derive(Debug, Clone, Default)]
pub(super) struct LastDigits {
    /// Time and count at rest.
    rests: VecDeque<(f64, i64)>,
    /// Time and count whenever the text changed.
    all: VecDeque<(f64, i64)>,
}

/// A gauge that uses few last digits.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct FewDigits {
    /// Since when, s.
    pub(super) since_s: f64,
    /// The last digits that came.
    pub(super) digits: String,
    /// How many different values are needed.
    pub(super) values: usize,
    /// The step that all of them lie multiples of apart, in steps of the last digit.
    pub(super) step: i64,
}

impl LastDigits {
    /// Takes a value at rest and the step of its last digit.
    pub(super) fn rest(&mut self, at_s: f64, value: f64, digit: f64) {
        remember(&mut self.rests, REMEMBERED, at_s, counts_of(value, digit));
    }

    /// Takes a value at rest or on the way whose text is new.
    pub(super) fn change(&mut self, at_s: f64, value: f64, digit: f64) {
        remember(&mut self.all, REMEMBERED_ALL, at_s, counts_of(value, digit));
    }

    /// Evidence against chance, over the longest informative stretch up to now; `now` and its digit belong to it. Values where somebody wants the
    /// display to stand, as planned loads are, `is_wanted`: that they are round is no evidence.
    pub(super) fn coarse_steps(
        &self,
        now: f64,
        digit: f64,
        is_wanted: impl Fn(f64) -> bool,
    ) -> Option<FewDigits> {
        let latest = counts_of(now, digit)?;
        let is_wanted = |count: i64| is_wanted(count as f64 * digit);
        self.coarse_steps_at_rest(latest, is_wanted)
            .or_else(|| self.coarse(latest, is_wanted))
    }

    /// All values lie whole multiples of a coarse step apart. Of n values by chance in g^(1-n) of cases for a given step g, and g may be any of
    /// those that displays have.
    fn coarse(&self, latest: i64, is_wanted: impl Fn(i64) -> bool) -> Option<FewDigits> {
        let mut counts = vec![latest];
        let mut telling = 0;
        let mut apart = 0;
        let mut found = None;
        for (n, (_, count)) in self.all.iter().rev().enumerate() {
            if counts.contains(count) || is_wanted(*count) {
                continue;
            }
            counts.push(*count);
            apart = gcd(apart, (count - latest).abs());
            let step = display_step(apart);
            if step < COARSE {
                break;
            }
            telling += usize::from(!self.goes_on(self.all.len() - 1 - n));
            let odds = (telling as f64 - 1.0) * (step as f64).ln();
            if odds > ODDS {
                let certain = self.all.len().checked_sub(n + 2);
                found = Some(FewDigits {
                    since_s: certain.map_or(0.0, |at| self.all[at].0),
                    digits: last_digits(&counts),
                    values: counts.len(),
                    step,
                });
            }
        }
        found
    }

    /// Whether the change after the value at a place was as fast as the one before it.
    fn goes_on(&self, at: usize) -> bool {
        let rate = |from: usize| {
            let ((before_s, before), (after_s, after)) =
                (self.all.get(from)?, self.all.get(from + 1)?);
            Some((after - before) as f64 / (after_s - before_s))
        };
        let rates = at.checked_sub(1).and_then(rate).zip(rate(at));
        rates.is_some_and(|(before, after)| (after - before).abs() <= SAME_RATE * before.abs())
    }

    fn coarse_steps_at_rest(
        &self,
        latest: i64,
        is_wanted: impl Fn(i64) -> bool,
    ) -> Option<FewDigits> {
        let mut seen = [false; 10];
        seen[latest.rem_euclid(10) as usize] = true;
        // The same loads again and again, by weights, leave the same digits.
        let mut counts = vec![latest];
        let mut step = 0;
        let mut found = None;
        for (n, (_, count)) in self.rests.iter().rev().enumerate() {
            if counts.contains(count) || is_wanted(*count) {
                continue;
            }
            counts.push(*count);
            seen[count.rem_euclid(10) as usize] = true;
            step = gcd(step, (count - latest).abs());
            let m = seen.iter().filter(|seen| **seen).count();
            // Equal steps of load leave equal steps of displacement, and a pattern of digits, but not one without exception.
            let halves = (0..5).any(|digit| m == 2 && seen[digit] && seen[digit + 5]);
            if m > 1 && !halves {
                break;
            }
            let odds = (counts.len() - m) as f64 * (10.0 / m as f64).ln() - ln_choices(m);
            if odds > ODDS {
                // Certain was the value before these.
                let certain = self.rests.len().checked_sub(n + 2);
                found = Some(FewDigits {
                    since_s: certain.map_or(0.0, |at| self.rests[at].0),
                    digits: last_digits(&counts),
                    values: counts.len(),
                    step,
                });
            }
        }
        found
    }
}

/// Keeps a count, the oldest making room for it.
fn remember(counts: &mut VecDeque<(f64, i64)>, most: usize, at_s: f64, count: Option<i64>) {
    let Some(count) = count else { return };
    if counts.len() == most {
        counts.pop_front();
    }
    counts.push_back((at_s, count));
}

/// A value in steps of its last digit.
fn counts_of(value: f64, digit: f64) -> Option<i64> {
    let count = (value / digit).round();
    (digit > 0.0 && count.abs() <= 1e15).then_some(count as i64)
}

/// The last digits of values, each once, in order.
fn last_digits(counts: &[i64]) -> String {
    let has = |digit: &i64| counts.iter().any(|count| count.rem_euclid(10) == *digit);
    (0..10).filter(has).map(|digit| digit.to_string()).collect()
}

/// The largest step of a display (1, 2 or 5 and zeros) that divides a number of counts.
fn display_step(counts: i64) -> i64 {
    let tens = std::iter::successors(Some(1_i64), |ten| ten.checked_mul(10));
    tens.take_while(|ten| counts % ten == 0 && *ten <= counts)
        .flat_map(|ten| [1, 2, 5].map(|digit| digit * ten))
        .filter(|step| counts % step == 0)
        .max()
        .unwrap_or(1)
}

fn gcd(a: i64, b: i64) -> i64 {
    if b == 0 { a } else { gcd(b, a % b) }
}

/// Logarithm of the number of ways to choose m of ten digits.
fn ln_choices(m: usize) -> f64 {
    (0..m)
        .map(|i| ((10 - i) as f64 / (i + 1) as f64).ln())
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Values without a pattern, rounded to a step; they are those of a multiplicative generator.
    fn values(step: f64) -> Vec<f64> {
        let mut seed = 12_345_u64;
        let next = |_| {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (((seed >> 40) % 2000) as f64 / step).round() * step
        };
        (0..60).map(next).collect()
    }

    fn detected(values: &[f64]) -> Option<FewDigits> {
        let mut digits = LastDigits::default();
        for (at_s, value) in values.iter().enumerate() {
            digits.rest(at_s as f64, *value, 1.0);
        }
        digits.coarse_steps(values[values.len() - 1], 1.0, |_| false)
    }

    #[test]
    fn coarse_steps_are_detected_and_fine_ones_are_not() {
        for n in 2..60 {
            assert_eq!(detected(&values(1.0)[..n]), None, "{n}");
        }
        for (step, digits) in [(10.0, "0"), (50.0, "0"), (5.0, "05")] {
            let coarse_steps = detected(&values(step)).expect("told");
            assert_eq!(
                (coarse_steps.digits.as_str(), coarse_steps.step),
                (digits, step as i64)
            );
        }
        assert!(detected(&values(10.0)[..8]).is_some());
    }

    #[test]
    fn moving_values_reveal_a_coarse_step_before_eight_rests() {
        let detected = |step: f64| {
            let mut digits = LastDigits::default();
            for (at_s, value) in values(step)[..10].iter().enumerate() {
                digits.change(at_s as f64, *value, 1.0);
            }
            digits
                .coarse_steps(values(step)[9], 1.0, |_| false)
                .map(|coarse_steps| coarse_steps.step)
        };
        assert_eq!(detected(100.0), Some(100));
        assert_eq!(detected(50.0), Some(50));
        assert_eq!(detected(1.0), None);
    }

    #[test]
    fn a_constant_drive_speed_is_not_taken_for_coarse_steps() {
        for step in [49.0, 50.0, 100.0] {
            let mut digits = LastDigits::default();
            for at_s in 0..20 {
                digits.change(f64::from(at_s), step * f64::from(at_s), 1.0);
            }
            let coarse_steps = digits.coarse_steps(step * 19.0, 1.0, |_| false);
            assert_eq!(coarse_steps, None, "{step}");
        }
    }

    #[test]
    fn planned_loads_are_no_evidence_of_a_coarse_step() {
        // Between loads of 0, 10 and 20 N, five values that happen to be whole newtons.
        let counts = [200.0, 20.0, 100.0, 70.0, 0.0, 180.0, 200.0, 90.0, 10.0];
        let mut digits = LastDigits::default();
        for (at_s, count) in (0_u8..).zip(counts) {
            digits.change(f64::from(at_s).powi(2), count, 1.0);
        }
        let coarse_steps =
            |is_wanted: fn(f64) -> bool| digits.coarse_steps(counts[8], 1.0, is_wanted);
        assert!(coarse_steps(|_| false).is_some());
        assert_eq!(coarse_steps(|count| count % 100.0 == 0.0), None);
    }

    #[test]
    fn steps_are_those_of_displays() {
        for (counts, step) in [
            (49, 1),
            (60, 20),
            (150, 50),
            (700, 100),
            (0, 1),
            (1, 1),
            (1024, 2),
        ] {
            assert_eq!(display_step(counts), step, "{counts}");
        }
    }

    #[test]
    fn repeated_equal_loads_are_not_taken_for_coarse_steps() {
        let loads: Vec<f64> = (0..60).map(|i| f64::from(i % 7) * 100.0).collect();
        assert_eq!(detected(&loads), None);
    }

    #[test]
    fn another_last_digit_ends_it() {
        let mut values = values(10.0);
        values.truncate(12);
        assert!(detected(&values).is_some());
        values.extend([1013.0, 1026.0, 1039.0]);
        assert_eq!(detected(&values[10..]), None);
    }
}
