//! The step of a display that is unstated, read off its readings.

use crate::readings::Reading;

/// Fewest different readings. A coarse display shows few; that six are multiples of twice its step by chance, which makes the budget larger,
/// happens once in thirty times.
const FEWEST: usize = 6;

/// Readings written in full precision have steps too; one so small beside their range carries no information.
const SMALLEST_SHARE: f64 = 1e-5;

/// Rounding of a number that was written in one unit and is kept in another, as a share of the range.
const ROUNDING_SHARE: f64 = 1e-9;

/// The largest step of which all readings are whole multiples, if there are enough readings.
pub(super) fn step_of(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let range = values.last()? - values.first()?;
    let rounding = ROUNDING_SHARE * range;
    values.dedup_by(|a, b| (*a - *b).abs() <= rounding);
    if values.len() < FEWEST {
        return None;
    }
    let gaps = values.windows(2).map(|pair| pair[1] - pair[0]);
    let step = gaps.fold(0.0, |step, gap| common_step(step, gap, rounding));
    // The nearest to its exact size over the whole range.
    (step > SMALLEST_SHARE * range).then(|| range / (range / step).round())
}

/// The greatest common divisor of two lengths, by Euclid; what is left within `rounding` is nothing.
fn common_step(mut a: f64, mut b: f64, rounding: f64) -> f64 {
    while b > rounding {
        let rest = a % b;
        (a, b) = (b, rest.min((b - rest).abs()));
    }
    a
}

/// Forces that are the planned loads were not read at a gauge.
pub(super) fn are_planned(readings: &[Reading]) -> bool {
    readings
        .iter()
        .all(|reading| reading.force_n == reading.target_n)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn step_of_um(values: impl Iterator<Item = f64>) -> Option<f64> {
        step_of(values.map(|um| um * 1e-6)).map(|step| (step * 1e9).round() / 1e3)
    }

    #[test]
    fn a_step_is_read_off_readings_that_show_it() {
        let on =
            |step: f64| move |i: i32| (f64::from(i * i * 37 % 101) * 7.3 / step).round() * step;
        assert_eq!(step_of_um((0..40).map(on(10.0))), Some(10.0));
        assert_eq!(step_of_um((0..40).map(on(0.5))), Some(0.5));
        assert_eq!(
            step_of_um((0..40).map(on(12.7))),
            Some(12.7),
            "half a thousandth of an inch"
        );
        assert_eq!(step_of_um((0..5).map(on(10.0))), None, "too few");
        assert_eq!(
            step_of_um((0..40).map(|i| f64::from(i).sqrt() * 7.3)),
            None,
            "not rounded"
        );
        assert_eq!(step_of_um((0..40).map(|_| 3.0)), None);
        assert_eq!(step_of(std::iter::empty()), None);
    }
}
