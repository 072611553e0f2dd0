//! What the strata leave: the size of the noise, the largest single departure, a period in the reading.

use crate::mismatch::noise::{Beside, EstimatedNoise, Tails, positions_off};
use crate::search::constants::{COLUMN_LEFT, UNSEEN_READING};
use crate::search::{dot, largest};
use stiffbench_beams::physics::laws::NOMINAL_PERIODS_M;

use super::bases::GlobalColumn;
use super::contrasts::ErrorTerm;
use super::decomposition::{Decomposition, LEAST_ERROR, squares};
use super::results::{Contrast, Spot, StratumTest};
use super::tails::tail;

/// Degrees of freedom above which a variance counts as known (1). Numerics.
const KNOWN_VARIANCE: f64 = 1e5;

/// A period longer than this share of the displacement is a curve over the load (1). By judgement (f10797f).
const LONGEST_PERIOD: f64 = 0.5;

impl Decomposition<'_> {
    /// The scatter within runs and levels against a noise that was known beforehand; both too much and too little count.
    pub(super) fn noise_size(
        &self,
        white: &[f64],
        known: Option<&EstimatedNoise>,
    ) -> Option<StratumTest> {
        let known = known?;
        let (error, dof) = self.error(ErrorTerm::Pure, white);
        if dof < 1.0 {
            return None;
        }
        let of_known = known.degrees_of_freedom([1.0, 0.0, 0.0]);
        let d2 = if of_known > KNOWN_VARIANCE {
            f64::INFINITY
        } else {
            of_known
        };
        let statistic = error / dof;
        let more = tail(statistic, dof, d2);
        let p = (2.0 * more.min(1.0 - more)).min(1.0);
        let size_m = known.noise.reading_sd_m * (statistic.sqrt() - 1.0).abs();
        let contrast = Contrast::NoiseSize;
        Some(StratumTest::new(contrast, statistic, [dof, d2], p, size_m))
    }

    /// The largest departure of one reading, each against the scatter without itself: t², with tails as long as those of the others.
    pub(super) fn outlier(&self, white: &[f64]) -> Option<StratumTest> {
        let left = self.pure(white);
        let (error, dof) = self.error(ErrorTerm::Pure, white);
        if dof < 2.0 {
            return None;
        }
        let shares = self.leverage_left();
        let seen = || (0..left.len()).filter(|&place| shares[place] >= UNSEEN_READING);
        let own = |place: usize| left[place] * left[place] / shares[place];
        let place = seen().max_by(|a, b| own(*a).total_cmp(&own(*b)))?;
        // What the others leave beside a shift of this one.
        let mut unit = vec![0.0; white.len()];
        unit[place] = left[place] / shares[place];
        let shift = self.pure(&unit);
        let others = seen().filter(|&other| other != place);
        let others: Vec<f64> = others
            .map(|other| (left[other] - shift[other]) / shares[other].sqrt())
            .collect();
        let mean_square = (error - own(place)).max(0.0) / (dof - 1.0);
        let statistic = own(place) / mean_square;
        // Where the others leave nothing there is no scatter to compare with.
        if !statistic.is_finite() || statistic < 0.0 {
            return None;
        }
        let p = Tails::of(&others, 1).p_of_largest(
            own(place).sqrt(),
            Beside::NOTHING,
            others.len() + 1,
        );
        let size_m = self.size_m(unit);
        let reading = &self.observations.readings[place];
        let run = &self.observations.runs[reading.run];
        let (pose, direction) = self.observations.name_of(run.cell);
        let spot = Spot {
            pose: Some(pose),
            direction: Some(direction),
            repeat: Some(run.repeat),
            step: Some(self.observations.loads[place].step),
            p_family: p,
            size_m,
            share: 1.0,
        };
        let dof = [1.0, dof - 1.0];
        Some(StratumTest {
            spots: vec![spot],
            ..StratumTest::new(Contrast::Outlier, statistic, dof, p, size_m)
        })
    }

    /// Sines and cosines of the displacement with the usual periods of gauges, beyond smooth curves over the load.
    ///
    /// # Arguments
    /// - `positions_m`: where the gauge stood, not what it showed: else the columns would move with the noise they are tested against.
    pub(super) fn periods(&self, positions_m: &[f64]) -> Vec<Period> {
        let range_m = largest(positions_m);
        let off_m = positions_off(self.observations, &self.whitening.covariance);
        NOMINAL_PERIODS_M
            .into_iter()
            .filter(|period| *period < LONGEST_PERIOD * range_m)
            .map(|period| {
                let columns = [0.0, std::f64::consts::FRAC_PI_2].map(|phase| {
                    let turns = |d: &f64| std::f64::consts::TAU * d / period + phase;
                    let values: Vec<f64> = positions_m.iter().map(|d| turns(d).sin()).collect();
                    let covariance = &self.whitening.covariance;
                    let own = covariance.own_length(&values, &(0..values.len()));
                    GlobalColumn {
                        white: self.white(&values),
                        least_share: COLUMN_LEFT,
                        least: own * off_m / period,
                    }
                });
                let [tested, spanned] = self.beyond_curves(&columns);
                Period {
                    tested,
                    spanned,
                    length: squares(&columns[0].white).sqrt(),
                }
            })
            .collect()
    }

    /// The largest period, at most as likely as the number of periods times its tail.
    ///
    /// # Arguments
    /// - `error`, `dof`: weighted squares and degrees of freedom of [`ErrorTerm::Pure`].
    pub(super) fn period(
        white: &[f64],
        (error, dof): (f64, f64),
        periods: &[Period],
    ) -> Option<StratumTest> {
        let along = |columns: &[Vec<f64>]| -> f64 {
            columns.iter().map(|unit| dot(unit, white).powi(2)).sum()
        };
        let mut count = 0.0;
        let mut best: Option<(f64, f64, [f64; 2], f64)> = None;
        for period in periods {
            let explained = along(&period.tested);
            let d1 = period.tested.len() as f64;
            let d2 = dof - period.spanned.len() as f64;
            if d1 < 1.0 || d2 < 1.0 {
                continue;
            }
            count += 1.0;
            let rest = (error - along(&period.spanned)).max(LEAST_ERROR * d2);
            let statistic = (explained / d1) / (rest / d2);
            let p = tail(statistic, d1, d2);
            let better = best
                .as_ref()
                .is_none_or(|(least, most, ..)| (p, -statistic) < (*least, -*most));
            if better {
                let amplitude_m = explained.sqrt() / period.length;
                best = Some((p, statistic, [d1, d2], amplitude_m));
            }
        }
        let (p, statistic, dof, size_m) = best?;
        let p = (count * p).min(1.0);
        Some(StratumTest::new(
            Contrast::Period,
            statistic,
            dof,
            p,
            size_m,
        ))
    }
}

/// One period of the gauge.
pub(super) struct Period {
    /// Orthonormal columns beyond smooth curves.
    tested: Vec<Vec<f64>>,
    /// Orthonormal columns beyond everything that repeats itself.
    spanned: Vec<Vec<f64>>,
    /// White length of a sine of one metre.
    length: f64,
}
