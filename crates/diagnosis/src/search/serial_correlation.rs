//! Errors of which a part remembers the row before.
//!
//! The filter of Kalman in its steady form for one state (Box, Jenkins, Reinsel & Ljung, Time Series Analysis, 5th edition, section 5.5): a
//! first-order autoregressive process that is seen beside errors without memory. It gives each row without what the rows before let expect, in
//! one pass.

use std::ops::Range;

/// How a row remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowMemory {
    /// Correlation of the part that remembers with that of the row before, between -1 and 1; zero in the first row of each series.
    pub correlation: f64,
    /// Share of that part in the variance of the row.
    pub share: f64,
}

/// Share of a row that no later row is the richer for (1): far below rounding. Numerics.
const FORGOTTEN: f64 = 1e-20;

/// A lower triangular F with Fᵀ F = R⁻¹, for rows of standard deviation one with the correlations R; the identity without rows.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct SerialFilter {
    steps: Vec<FilterStep>,
    /// ln det R.
    pub(super) log_determinant: f64,
}

/// Innovation = `direct` y - `expected` m, where m is what the rows before let expect of the part that remembers; m then grows by `gain` times it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct FilterStep {
    correlation: f64,
    direct: f64,
    expected: f64,
    gain: f64,
}

impl SerialFilter {
    pub(super) fn new(memory: &[RowMemory]) -> Self {
        let mut log_determinant = 0.0;
        let mut variance = 1.0;
        let steps = memory
            .iter()
            .map(|row| {
                let correlation = row.correlation;
                variance = 1.0 - correlation * correlation * (1.0 - variance);
                let root = row.share.sqrt();
                let seen: f64 = row.share * variance + (1.0 - row.share);
                log_determinant += seen.ln();
                let direct = seen.sqrt().recip();
                let gain = root * variance * direct;
                variance -= gain * gain;
                FilterStep {
                    correlation,
                    direct,
                    expected: root * direct,
                    gain,
                }
            })
            .collect();
        Self {
            steps,
            log_determinant,
        }
    }

    pub(super) fn is_identity(&self) -> bool {
        self.steps.is_empty()
    }

    /// F times the rows of a range, in place; a series begins with the range.
    pub(super) fn innovations(&self, range: &Range<usize>, rows: &mut [f64]) {
        let mut expected = 0.0;
        for (value, step) in rows.iter_mut().zip(self.steps_of(range)) {
            expected *= step.correlation;
            *value = step.direct * *value - step.expected * expected;
            expected += step.gain * *value;
        }
    }

    /// F itself, row by row: calls `action` with each row of a range, the first column that it is not zero in, and its entries from there up to the
    /// diagonal.
    pub(super) fn for_each_row(
        &self,
        range: &Range<usize>,
        mut action: impl FnMut(usize, usize, &[f64]),
    ) {
        // What each column lets expect, and the entries of the row.
        let (mut expected, mut entries) = (Vec::new(), Vec::new());
        let mut first = 0;
        for (row, step) in self.steps_of(range).enumerate() {
            expected.push(0.0);
            entries.clear();
            for (column, expected) in (first..).zip(&mut expected) {
                *expected *= step.correlation;
                let seen = if column == row { step.direct } else { 0.0 };
                let entry = seen - step.expected * *expected;
                *expected += step.gain * entry;
                entries.push(entry);
            }
            action(row, first, &entries);
            let is_forgotten = |expected: &&f64| expected.abs() < FORGOTTEN;
            let forgotten = expected.iter().take_while(is_forgotten).count();
            expected.drain(..forgotten);
            first += forgotten;
        }
    }

    /// Fᵀ times them.
    pub(super) fn innovations_transposed(&self, range: &Range<usize>, rows: &mut [f64]) {
        let mut later = 0.0;
        for (value, step) in rows.iter_mut().zip(self.steps_of(range)).rev() {
            let innovation = *value + step.gain * later;
            *value = step.direct * innovation;
            later = step.correlation * (later - step.expected * innovation);
        }
    }

    /// F⁻¹ times them.
    pub(super) fn remembered(&self, range: &Range<usize>, rows: &mut [f64]) {
        let mut expected = 0.0;
        for (value, step) in rows.iter_mut().zip(self.steps_of(range)) {
            expected *= step.correlation;
            let innovation = *value;
            *value = (innovation + step.expected * expected) / step.direct;
            expected += step.gain * innovation;
        }
    }

    /// F⁻ᵀ times them.
    pub(super) fn remembered_transposed(&self, range: &Range<usize>, rows: &mut [f64]) {
        let mut later = 0.0;
        for (value, step) in rows.iter_mut().zip(self.steps_of(range)).rev() {
            let row = *value / step.direct;
            *value = row + step.gain * later;
            later = step.correlation * (later + step.expected * row);
        }
    }

    /// Scalar product of F times two weighted vectors that are zero outside a range.
    pub(super) fn product(
        &self,
        [first, second]: [&[f64]; 2],
        weights: &[f64],
        range: &Range<usize>,
    ) -> f64 {
        let mut sum = 0.0;
        let mut expected = [0.0; 2];
        for row in range.start..self.steps.len() {
            let step = &self.steps[row];
            // What a series remembers goes on to its end.
            if row >= range.end && step.correlation == 0.0 {
                break;
            }
            let values = [first[row], second[row]];
            let innovations: [f64; 2] = std::array::from_fn(|i| {
                expected[i] *= step.correlation;
                let innovation =
                    step.direct * weights[row] * values[i] - step.expected * expected[i];
                expected[i] += step.gain * innovation;
                innovation
            });
            sum += innovations[0] * innovations[1];
        }
        sum
    }

    fn steps_of(
        &self,
        range: &Range<usize>,
    ) -> impl DoubleEndedIterator<Item = &FilterStep> + ExactSizeIterator {
        self.steps.get(range.clone()).unwrap_or_default().iter()
    }
}
