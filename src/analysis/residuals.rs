//! Residuals of the readings behind a fit, and tests of what they still show.

use std::collections::{HashMap, HashSet};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::fit::FitOutcome;
use crate::readings::Reading;
use crate::robot::ModelParameter;
use crate::statistics::{mean, normal_upper_tail};
use crate::test_point::Cell;

use super::error::Failure;
use super::fit::FitData;

/// What the fitted model leaves of a reading.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadingResidual<'a> {
    /// Place of the reading in its session, from 0.
    pub sequence: usize,
    /// The reading.
    pub reading: &'a Reading,
    /// Displacement that the model predicts, m.
    pub predicted_m: f64,
    /// Measured less predicted displacement, less the mean of the readings with the same gauge zero, m.
    pub residual_m: f64,
}

/// Whether the signs of residuals alternate as often as those of independent errors.
///
/// # Source
/// Wald and Wolfowitz, Annals of Mathematical Statistics 11 (1940), 147: number of runs, its mean and variance given how many residuals are
/// positive and negative; normal approximation.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct RunsTest {
    /// Order of the residuals.
    pub against: ResidualOrder,
    /// Stretches of residuals of one sign.
    pub runs: usize,
    /// How many independent residuals have on average.
    pub expected: f64,
    /// Probability that independent residuals have as few.
    pub p: f64,
}

/// In which order residuals are looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ResidualOrder {
    /// Of single readings by force, within each application of the load sequence, whose own zero and slope are taken off.
    Load,
    /// Of the slopes of the applications of the load sequence, in the order of the session.
    Order,
}

impl RunsTest {
    /// The test over sequences, each with its own signs; `None` where no sequence has residuals of both signs.
    fn of<'s>(
        against: ResidualOrder,
        sequences: impl IntoIterator<Item = &'s [f64]>,
    ) -> Option<Self> {
        let (mut runs, mut expected, mut variance) = (0, 0.0, 0.0);
        for residuals in sequences {
            let signs: Vec<bool> = residuals
                .iter()
                .filter(|residual| **residual != 0.0)
                .map(|residual| *residual > 0.0)
                .collect();
            let positive = signs.iter().filter(|sign| **sign).count() as f64;
            let all = signs.len() as f64;
            let product = 2.0 * positive * (all - positive);
            if product == 0.0 {
                continue;
            }
            runs += signs.chunk_by(|a, b| a == b).count();
            expected += product / all + 1.0;
            variance += product * (product - all) / (all * all * (all - 1.0));
        }
        // Half a run is the correction for continuity.
        let more = expected - runs as f64 - 0.5;
        (variance > 0.0).then(|| Self {
            against,
            runs,
            expected,
            p: normal_upper_tail(more / variance.sqrt()),
        })
    }
}

/// Residuals of a run as a line in the predicted displacement, and what the line leaves.
struct RunLine {
    /// Its first place in the session.
    begins: usize,
    slope: f64,
    left_m: Vec<f64>,
}

impl RunLine {
    /// `None` for a run with too few readings, or of one load.
    fn of(run: &[ReadingResidual<'_>]) -> Option<Self> {
        let values =
            |of: &dyn Fn(&ReadingResidual<'_>) -> f64| -> Vec<f64> { run.iter().map(of).collect() };
        let (x, y) = (
            values(&|one| one.predicted_m),
            values(&|one| one.residual_m),
        );
        let (x_mean, y_mean) = (mean(&x)?, mean(&y)?);
        let sums = x.iter().zip(&y).fold((0.0, 0.0), |(sxx, sxy), (x, y)| {
            let dx = x - x_mean;
            (sxx + dx * dx, sxy + dx * (y - y_mean))
        });
        let slope = sums.1 / sums.0;
        let left = x
            .iter()
            .zip(&y)
            .map(|(x, y)| y - y_mean - slope * (x - x_mean));
        (run.len() > 2 && slope.is_finite()).then(|| Self {
            begins: run.iter().map(|one| one.sequence).min().unwrap_or_default(),
            slope,
            left_m: left.collect(),
        })
    }
}

impl FitData {
    /// Residuals of the readings of a fitted session, in its order; empty without readings.
    ///
    /// # Errors
    /// For a model that cannot be solved.
    pub fn residuals(&self, outcome: &FitOutcome) -> Result<Vec<ReadingResidual<'_>>, Failure> {
        let Some((session, _)) = &self.session else {
            return Ok(Vec::new());
        };
        let readings = &session.table;
        let cells: Vec<_> = outcome.cells.iter().map(|cell| cell.cell.clone()).collect();
        let mut model = self
            .problem()?
            .cell_model(&ModelParameter::CLASSES, &cells)?;
        let stiffness = model.stiffness(&outcome.factors)?;
        let with_physics: HashMap<u32, f64> = model
            .displacements_m(&outcome.factors)?
            .into_iter()
            .collect();
        let mut residuals = Vec::new();
        for (sequence, reading) in readings.readings.iter().enumerate() {
            let cell = reading.cell();
            let place = cells.iter().position(|known| *known == cell);
            let Some(place) = place.filter(|_| reading.is_accepted()) else {
                continue;
            };
            let predicted_m = with_physics.get(&reading.seq).copied();
            let predicted_m = predicted_m.unwrap_or_else(|| reading.force_n / stiffness[place]);
            residuals.push(ReadingResidual {
                sequence,
                reading,
                predicted_m,
                residual_m: reading.displacement_m - predicted_m,
            });
        }
        // A gauge's zero is not the model's business.
        let mut zeros = vec![(0.0, 0.0); readings.zeros.len()];
        for one in &residuals {
            let zero = &mut zeros[one.reading.zero as usize];
            *zero = (zero.0 + one.residual_m, zero.1 + 1.0);
        }
        for one in &mut residuals {
            let (sum, count) = zeros[one.reading.zero as usize];
            one.residual_m -= sum / count;
        }
        Ok(residuals)
    }

    /// Runs tests of the residuals of the cells of the fit against load and order; empty without readings. Held-out cells also miss by what
    /// the fit did not see of them.
    ///
    /// # Errors
    /// As [`residuals`](Self::residuals).
    pub fn runs_tests(&self, outcome: &FitOutcome) -> Result<Vec<RunsTest>, Failure> {
        let cells = outcome.cells.iter().filter(|cell| !cell.held_out);
        let of_the_fit: HashSet<&Cell> = cells.map(|cell| &cell.cell).collect();
        let mut residuals = self.residuals(outcome)?;
        residuals.retain(|one| of_the_fit.contains(&one.reading.cell()));
        residuals.sort_by(|a, b| {
            let (a, b) = (a.reading, b.reading);
            a.run.cmp(&b.run).then(a.force_n.total_cmp(&b.force_n))
        });
        // Whole slopes scatter from run to run: within a run only its shape is tested.
        let lines = residuals.chunk_by(|a, b| a.reading.run == b.reading.run);
        let mut lines: Vec<RunLine> = lines.filter_map(RunLine::of).collect();
        lines.sort_by_key(|line| line.begins);
        let slopes: Vec<f64> = lines.iter().map(|line| line.slope).collect();
        let by_load = lines.iter().map(|line| line.left_m.as_slice());
        let tests = [
            RunsTest::of(ResidualOrder::Load, by_load),
            RunsTest::of(ResidualOrder::Order, [slopes.as_slice()]),
        ];
        Ok(tests.into_iter().flatten().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mean_and_tail_are_those_of_all_orders_of_the_signs() {
        // All orders of six positive among eleven residuals, counted one by one.
        let count = 11;
        let orders: Vec<usize> = (0_u32..1 << count)
            .filter(|bits| bits.count_ones() == 6)
            .map(|bits| {
                let signs: Vec<bool> = (0..count).map(|place| bits >> place & 1 == 1).collect();
                signs.chunk_by(|a, b| a == b).count()
            })
            .collect();
        let mean = orders.iter().sum::<usize>() as f64 / orders.len() as f64;
        let clustered = [1.0, 2.0, 1.0, 0.5, 3.0, -1.0, -2.0, -1.0, 1.0, -1.0, -1.0];
        let found = RunsTest::of(ResidualOrder::Order, [&clustered[..]]).unwrap();
        assert_eq!(found.runs, 4);
        assert!((found.expected - mean).abs() < 1e-12, "{mean}");
        let as_few = orders.iter().filter(|runs| **runs <= 4).count();
        let exact = as_few as f64 / orders.len() as f64;
        assert!((found.p - exact).abs() < 0.01, "{} {exact}", found.p);
    }

    #[test]
    fn sequences_of_one_sign_show_nothing() {
        assert_eq!(
            RunsTest::of(ResidualOrder::Load, [&[1.0, 2.0][..], &[-1.0]]),
            None
        );
    }
}
