//! Errors of which a part remembers the row before, or is common to rows that come together.
//!
//! The filter of Kalman (Box, Jenkins, Reinsel & Ljung, Time Series Analysis, 5th edition, section 5.5): a first-order autoregressive process
//! that is seen beside errors without correlation. It gives each row without what the rows before let expect, in one pass. Several series that
//! come together have an error in common, which lasts as long as they do, and each its own correlation: states of the same filter.

use std::ops::Range;

/// How a row remembers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowCorrelation {
    /// Correlation of the part that remembers with that of the row before, between -1 and 1; zero in the first row of each series.
    pub correlation: f64,
    /// Share of that part in the variance of the row.
    pub share: f64,
}

/// What rows have in common with the rows that came before them.
#[derive(Debug, Clone, PartialEq)]
pub enum RowErrors {
    /// Each row remembers the one before it; empty where none does.
    Correlated(Vec<RowCorrelation>),
    /// Rows of several series that come together, in the order in which they come.
    Common(Vec<RowStates<MOST_STATES>>),
}

/// Share of a row that no later row is the richer for (1): far below rounding. Numerics.
const FORGOTTEN: f64 = 1e-20;

/// Errors that a row has a part of: states of the filter, each of standard deviation one.
///
/// The rows of several series lie series by series, their errors come together: `row` says which row is the next to come.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RowStates<const STATES: usize> {
    /// The row.
    pub row: usize,
    /// Correlation of each state with what it was at the row before; zero where it begins anew.
    pub correlation: [f64; STATES],
    /// How much of each state the row has, as a share of its standard deviation; what is left is its own.
    pub has: [f64; STATES],
}

/// Most errors that rows have in common: those of three series, each with a correlation, and one that is common to them.
pub const MOST_STATES: usize = 4;

/// A triangular F with Fᵀ F = R⁻¹, for rows of standard deviation one with the correlations R; the identity without rows.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct SerialFilter {
    steps: FilterSteps,
    /// ln det R.
    pub(super) log_determinant: f64,
}

#[derive(Debug, Clone, PartialEq)]
enum FilterSteps {
    /// Each row remembers the one before it.
    Single(Vec<FilterStep<1>>),
    /// Rows have several errors in common, and come in an order of their own.
    Several {
        steps: Vec<FilterStep<MOST_STATES>>,
        rows: Vec<usize>,
    },
}

impl Default for FilterSteps {
    fn default() -> Self {
        Self::Single(Vec::new())
    }
}

/// Innovation = `direct` y - `expected` · m, where m is what the rows before let expect of the states; m then grows by `gain` times it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct FilterStep<const STATES: usize> {
    correlation: [f64; STATES],
    direct: f64,
    expected: [f64; STATES],
    gain: [f64; STATES],
}

impl<const STATES: usize> FilterStep<STATES> {
    /// Whether nothing before it is remembered.
    fn begins(&self) -> bool {
        self.correlation == [0.0; STATES]
    }

    #[inline]
    /// # Arguments
    /// - `direct`: the value, times what is `direct` in it.
    fn innovation(&self, direct: f64, expected: &mut [f64; STATES]) -> f64 {
        let mut innovation = direct;
        for (state, expected) in expected.iter_mut().enumerate() {
            *expected *= self.correlation[state];
            innovation -= self.expected[state] * *expected;
        }
        for (state, expected) in expected.iter_mut().enumerate() {
            *expected += self.gain[state] * innovation;
        }
        innovation
    }

    #[inline]
    fn innovation_transposed(&self, value: f64, later: &mut [f64; STATES]) -> f64 {
        let mut innovation = value;
        for (gain, later) in self.gain.iter().zip(later.iter()) {
            innovation += gain * later;
        }
        for (state, later) in later.iter_mut().enumerate() {
            *later = self.correlation[state] * (*later - self.expected[state] * innovation);
        }
        self.direct * innovation
    }

    #[inline]
    fn remembered(&self, innovation: f64, expected: &mut [f64; STATES]) -> f64 {
        let mut value = innovation;
        for (state, expected) in expected.iter_mut().enumerate() {
            *expected *= self.correlation[state];
            value += self.expected[state] * *expected;
        }
        for (state, expected) in expected.iter_mut().enumerate() {
            *expected += self.gain[state] * innovation;
        }
        value / self.direct
    }

    #[inline]
    fn remembered_transposed(&self, value: f64, later: &mut [f64; STATES]) -> f64 {
        let row = value / self.direct;
        let mut out = row;
        for (gain, later) in self.gain.iter().zip(later.iter()) {
            out += gain * later;
        }
        for (state, later) in later.iter_mut().enumerate() {
            *later = self.correlation[state] * (*later + self.expected[state] * row);
        }
        out
    }
}

/// The filter of states that come row by row; and ln det R.
fn filter_steps<const STATES: usize>(rows: &[RowStates<STATES>]) -> (Vec<FilterStep<STATES>>, f64) {
    let mut log_determinant = 0.0;
    let mut covariance = [[0.0; STATES]; STATES];
    let steps = rows.iter().map(|row| {
        for i in 0..STATES {
            for j in 0..STATES {
                covariance[i][j] *= row.correlation[i] * row.correlation[j];
            }
            covariance[i][i] += 1.0 - row.correlation[i] * row.correlation[i];
        }
        let has = row.has;
        let moved: [f64; STATES] =
            std::array::from_fn(|i| (0..STATES).map(|j| covariance[i][j] * has[j]).sum());
        let own = 1.0 - has.iter().map(|share| share * share).sum::<f64>();
        let seen: f64 = has.iter().zip(&moved).map(|(a, b)| a * b).sum::<f64>() + own;
        log_determinant += seen.ln();
        let direct = seen.sqrt().recip();
        let gain = moved.map(|value| value * direct);
        for i in 0..STATES {
            for j in 0..STATES {
                covariance[i][j] -= gain[i] * gain[j];
            }
        }
        FilterStep {
            correlation: row.correlation,
            direct,
            expected: has.map(|share| share * direct),
            gain,
        }
    });
    (steps.collect(), log_determinant)
}

/// Calls a closure with the steps of a range and, for each, the place of its row within the range.
macro_rules! with_steps {
    ($filter:expr, $range:expr, |$steps:ident, $row:ident| $body:expr) => {
        match &$filter.steps {
            FilterSteps::Single(all) => {
                let $steps = all.get($range.clone()).unwrap_or_default();
                let $row = |place: usize| place;
                $body
            }
            FilterSteps::Several { steps, rows } => {
                let $steps = steps.get($range.clone()).unwrap_or_default();
                let rows = rows.get($range.clone()).unwrap_or_default();
                let $row = |place: usize| rows[place] - $range.start;
                $body
            }
        }
    };
}

impl SerialFilter {
    pub(super) fn new(errors: &RowErrors) -> Self {
        match errors {
            RowErrors::Correlated(rows) => {
                let mut log_determinant = 0.0;
                let mut variance = 1.0;
                let steps = rows.iter().map(|row| {
                    let correlation = row.correlation;
                    variance = 1.0 - correlation * correlation * (1.0 - variance);
                    let root = row.share.sqrt();
                    let seen: f64 = row.share * variance + (1.0 - row.share);
                    log_determinant += seen.ln();
                    let direct = seen.sqrt().recip();
                    let gain = root * variance * direct;
                    variance -= gain * gain;
                    FilterStep {
                        correlation: [correlation],
                        direct,
                        expected: [root * direct],
                        gain: [gain],
                    }
                });
                Self {
                    steps: FilterSteps::Single(steps.collect()),
                    log_determinant,
                }
            }
            RowErrors::Common(states) => {
                let (steps, log_determinant) = filter_steps(states);
                let rows = states.iter().map(|state| state.row).collect();
                Self {
                    steps: FilterSteps::Several { steps, rows },
                    log_determinant,
                }
            }
        }
    }

    pub(super) fn is_identity(&self) -> bool {
        matches!(&self.steps, FilterSteps::Single(steps) if steps.is_empty())
    }

    /// F times the rows of a range, in place; a series begins with the range.
    pub(super) fn innovations(&self, range: &Range<usize>, rows: &mut [f64]) {
        with_steps!(self, range, |steps, row| forwards(
            steps,
            row,
            rows,
            |step, value, expected| step.innovation(step.direct * value, expected)
        ));
    }

    /// F itself, row by row as they come: calls `action` with the place of each row of a range, the places of the rows that came before it and
    /// are not forgotten, with it, and its entries for these.
    pub(super) fn for_each_row(
        &self,
        range: &Range<usize>,
        action: impl FnMut(usize, &[usize], &[f64]),
    ) {
        with_steps!(self, range, |steps, row| each_row(steps, row, action));
    }

    /// Fᵀ times them.
    pub(super) fn innovations_transposed(&self, range: &Range<usize>, rows: &mut [f64]) {
        with_steps!(self, range, |steps, row| backwards(
            steps,
            row,
            rows,
            FilterStep::innovation_transposed
        ));
    }

    /// F⁻¹ times them.
    pub(super) fn remembered(&self, range: &Range<usize>, rows: &mut [f64]) {
        with_steps!(self, range, |steps, row| forwards(
            steps,
            row,
            rows,
            FilterStep::remembered
        ));
    }

    /// F⁻ᵀ times them.
    pub(super) fn remembered_transposed(&self, range: &Range<usize>, rows: &mut [f64]) {
        with_steps!(self, range, |steps, row| backwards(
            steps,
            row,
            rows,
            FilterStep::remembered_transposed
        ));
    }

    /// Scalar product of F times two weighted vectors that are zero outside a range, of rows in an order of their own outside whole series.
    pub(super) fn product(
        &self,
        vectors: [&[f64]; 2],
        weights: &[f64],
        range: &Range<usize>,
    ) -> f64 {
        match &self.steps {
            FilterSteps::Single(steps) => product(steps, |row| row, vectors, weights, range),
            FilterSteps::Several { steps, rows } => {
                product(steps, |place| rows[place], vectors, weights, range)
            }
        }
    }
}

#[inline]
fn forwards<const STATES: usize>(
    steps: &[FilterStep<STATES>],
    row: impl Fn(usize) -> usize,
    rows: &mut [f64],
    of_step: impl Fn(&FilterStep<STATES>, f64, &mut [f64; STATES]) -> f64,
) {
    let mut expected = [0.0; STATES];
    for (place, step) in steps.iter().enumerate() {
        let at = row(place);
        rows[at] = of_step(step, rows[at], &mut expected);
    }
}

#[inline]
fn backwards<const STATES: usize>(
    steps: &[FilterStep<STATES>],
    row: impl Fn(usize) -> usize,
    rows: &mut [f64],
    of_step: impl Fn(&FilterStep<STATES>, f64, &mut [f64; STATES]) -> f64,
) {
    let mut later = [0.0; STATES];
    for (place, step) in steps.iter().enumerate().rev() {
        let at = row(place);
        rows[at] = of_step(step, rows[at], &mut later);
    }
}

fn each_row<const STATES: usize>(
    steps: &[FilterStep<STATES>],
    row: impl Fn(usize) -> usize,
    mut action: impl FnMut(usize, &[usize], &[f64]),
) {
    // What each column lets expect, and the entries of the row.
    let (mut expected, mut entries) = (Vec::<[f64; STATES]>::new(), Vec::new());
    let mut columns = Vec::new();
    for (place, step) in steps.iter().enumerate() {
        expected.push([0.0; STATES]);
        columns.push(row(place));
        entries.clear();
        let own = columns.len() - 1;
        for (column, expected) in expected.iter_mut().enumerate() {
            let seen = if column == own { step.direct } else { 0.0 };
            entries.push(step.innovation(seen, expected));
        }
        action(columns[own], &columns, &entries);
        let is_forgotten =
            |expected: &&[f64; STATES]| expected.iter().all(|expected| expected.abs() < FORGOTTEN);
        let forgotten = expected.iter().take_while(is_forgotten).count();
        expected.drain(..forgotten);
        columns.drain(..forgotten);
    }
}

/// # Arguments
/// - `range`: places among the steps.
fn product<const STATES: usize>(
    steps: &[FilterStep<STATES>],
    row: impl Fn(usize) -> usize,
    [first, second]: [&[f64]; 2],
    weights: &[f64],
    range: &Range<usize>,
) -> f64 {
    let mut sum = 0.0;
    let mut expected = [[0.0; STATES]; 2];
    for (place, step) in steps.iter().enumerate().skip(range.start) {
        // What a series remembers goes on to its end.
        if place >= range.end && step.begins() {
            break;
        }
        let row = row(place);
        let [a, b] = &mut expected;
        sum += step.innovation(step.direct * weights[row] * first[row], a)
            * step.innovation(step.direct * weights[row] * second[row], b);
    }
    sum
}
