//! The step of a display that is unstated, read off its readings.

use indexmap::IndexMap;

use crate::readings::Reading;

/// Fewest different readings. A coarse display shows few; that six are multiples of twice its step by chance, which makes the budget larger,
/// happens once in thirty times.
const FEWEST: usize = 6;

/// Readings written in full precision have steps too; one so small beside their range carries no information.
const SMALLEST_SHARE: f64 = 1e-5;

/// Rounding of a number that was written in one unit and is kept in another, as a share of the range.
const ROUNDING_SHARE: f64 = 1e-9;

/// The largest step of which all readings are whole multiples, if there are enough readings.
#[must_use]
pub fn step_of(values: impl Iterator<Item = f64>) -> Option<f64> {
    let mut values: Vec<f64> = values.filter(|value| value.is_finite()).collect();
    values.sort_by(f64::total_cmp);
    let range = values.last()? - values.first()?;
    let rounding = ROUNDING_SHARE * range;
    let values = distinct(values, rounding);
    if values.len() < FEWEST {
        return None;
    }
    let gaps = values.windows(2).map(|pair| pair[1] - pair[0]);
    let step = gaps.fold(0.0, |step, gap| common_step(step, gap, rounding));
    // The nearest to its exact size over the whole range.
    (step > SMALLEST_SHARE * range).then(|| range / (range / step).round())
}

/// The values in order, those within `rounding` of each other once.
fn distinct(mut values: Vec<f64>, rounding: f64) -> Vec<f64> {
    values.sort_by(f64::total_cmp);
    values.dedup_by(|a, b| (*a - *b).abs() <= rounding);
    values
}

/// The greatest common divisor of two lengths, by Euclid; what is left within `rounding` is nothing.
fn common_step(mut a: f64, mut b: f64, rounding: f64) -> f64 {
    while b > rounding {
        let rest = a % b;
        (a, b) = (b, rest.min((b - rest).abs()));
    }
    a
}

/// Whether the forces were set rather than read at a gauge: they are the planned loads, or the same values in every run, such as weights.
/// The distances between them are steps of the load then, and none of a display.
pub(super) fn are_set(readings: &[Reading]) -> bool {
    let is_planned = |reading: &Reading| reading.force_n == reading.target_n;
    readings.iter().all(is_planned) || recur(readings)
}

/// Whether every run of a cell has the same forces, as far as it has them; single runs must have them in equal steps.
fn recur(readings: &[Reading]) -> bool {
    let mut cells: IndexMap<_, IndexMap<u32, Vec<f64>>> = IndexMap::new();
    for reading in readings {
        let runs = cells.entry((&reading.pose, reading.direction)).or_default();
        runs.entry(reading.repeat)
            .or_default()
            .push(reading.force_n);
    }
    let largest = readings.iter().map(|reading| reading.force_n.abs());
    let rounding = ROUNDING_SHARE * largest.fold(0.0, f64::max);
    let is_repeated = cells.values().any(|runs| runs.len() > 1);
    cells.values().all(|runs| {
        let together = distinct(runs.values().flatten().copied().collect(), rounding);
        let lengths = runs
            .values()
            .map(|forces| distinct(forces.clone(), rounding).len());
        let longest = lengths.max();
        let mut gaps = together.windows(2).map(|pair| pair[1] - pair[0]);
        let first = gaps.next().unwrap_or(0.0);
        longest == Some(together.len())
            && (is_repeated || gaps.all(|gap| (gap - first).abs() <= 2.0 * rounding))
    })
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
