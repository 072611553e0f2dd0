//! Zeros of a cell: its unloaded readings before and after the loads, and what a session's checks of the zeros found.

use std::collections::BTreeMap;

use crate::readings::Reading;
use stiffbench_units_and_text::test_point::{Branch, Cell};

/// By how far the zeros of the gauges had moved where a session checked them: the largest of the checks of a cell.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ZeroChange {
    /// Of the displacement gauge, m, without sign; `None` if it was not checked.
    pub displacement_m: Option<f64>,
    /// Of the force gauge, N, without sign; `None` if it was not checked.
    pub force_n: Option<f64>,
}

impl ZeroChange {
    /// Takes one more check; what is not a number counts as not checked.
    pub fn take(&mut self, displacement_m: Option<f64>, force_n: Option<f64>) {
        let larger = |known: &mut Option<f64>, found: Option<f64>| {
            if let Some(found) = found.map(f64::abs).filter(|found| found.is_finite()) {
                *known = Some(known.unwrap_or_default().max(found));
            }
        };
        larger(&mut self.displacement_m, displacement_m);
        larger(&mut self.force_n, force_n);
    }
}

/// What the checks of the zeros found, cell by cell.
pub type ZeroDrifts = BTreeMap<Cell, ZeroChange>;

/// Unloaded readings, from all accepted readings of a cell whichever branches its stiffness uses.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct UnloadedReadings {
    /// Per run with both: last unloaded reading after the loads minus first before them, m.
    pub(super) returns_m: Vec<f64>,
    /// Per gauge zero, in the order of reading: time and displacement (m) of the first unloaded reading of each repeat.
    pub(super) by_zero: Vec<Vec<(f64, f64)>>,
}

/// Time of a reading: its clock if all readings have one, else its sequence number.
pub(super) fn time_of(reading_time_s: Option<f64>, seq: u32) -> f64 {
    reading_time_s.unwrap_or(f64::from(seq))
}

impl UnloadedReadings {
    pub(super) fn new(readings: &[&Reading]) -> Self {
        let has_clock = readings.iter().all(|r| r.time_s.is_some());
        let mut unloaded: Vec<&Reading> = readings
            .iter()
            .copied()
            .filter(|r| r.target_n == 0.0)
            .collect();
        unloaded.sort_by_key(|r| (r.run, r.repeat, r.branch, r.step, r.seq));
        let mut returns_m = Vec::new();
        let mut by_zero: BTreeMap<u32, Vec<(f64, f64)>> = BTreeMap::new();
        for repeat in unloaded.chunk_by(|a, b| (a.run, a.repeat) == (b.run, b.repeat)) {
            let Some(before) = repeat.first().filter(|r| r.branch == Branch::Loading) else {
                continue;
            };
            let time = time_of(before.time_s.filter(|_| has_clock), before.seq);
            by_zero
                .entry(before.zero)
                .or_default()
                .push((time, before.displacement_m));
            if let Some(after) = repeat.last().filter(|r| r.branch == Branch::Unloading) {
                returns_m.push(after.displacement_m - before.displacement_m);
            }
        }
        let mut by_zero: Vec<_> = by_zero.into_values().collect();
        for readings in &mut by_zero {
            readings.sort_by(|a, b| a.0.total_cmp(&b.0));
        }
        Self { returns_m, by_zero }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stiffness::sample::reading;

    #[test]
    fn before_and_after_are_paired_within_a_run() {
        let mut readings = [
            reading(1, 0, 0.0, 0.0, 1e-6),
            reading(1, 1, -10.0, -10.0, -2e-4),
            reading(1, 2, 0.0, 0.0, -5e-6),
            reading(2, 0, 0.0, 0.0, 2e-6),
        ];
        readings[2].branch = Branch::Unloading;
        for r in &mut readings {
            r.zero = 0;
        }
        let refs: Vec<&Reading> = readings.iter().collect();
        let found = UnloadedReadings::new(&refs);
        assert_eq!(found.returns_m.len(), 1);
        assert!((found.returns_m[0] + 6e-6).abs() < 1e-18);
        // Without a clock the sequence number stands for time.
        assert_eq!(found.by_zero, [vec![(100.0, 1e-6), (200.0, 2e-6)]]);
    }
}
