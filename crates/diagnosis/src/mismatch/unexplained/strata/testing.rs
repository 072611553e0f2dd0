//! The tests: each contrast against its error term, the family by Holm, and where in a contrast it sits.

use crate::mismatch::noise::{EstimatedNoise, LEAST_COUNTED, RoundedNoise};
use crate::mismatch::observed::Observations;
use crate::mismatch::unexplained::patterns::PatternGroup;

use super::contrasts::ErrorTerm;
use super::decomposition::{Decomposition, FitContrast, squares};
use super::extremes::Period;
use super::results::{Contrast, Spot, StratumTest, Untested};
use super::tails::{holm, tail};
use crate::search::constants::STRATUM_LEVEL;
use crate::search::largest;

impl Decomposition<'_> {
    /// All tests of a white residual.
    ///
    /// # Arguments
    /// - `periods`: of the gauge, in the displacements of the model.
    /// - `known`: the noise, if it was known beforehand.
    /// - `rounded`: the noise, if the step of the gauge is what scatters.
    pub(super) fn tests(
        &self,
        white: &[f64],
        periods: &[Period],
        known: Option<&EstimatedNoise>,
        rounded: Option<&RoundedNoise<'_>>,
    ) -> (Vec<StratumTest>, Vec<Untested>) {
        let mut tests = self.ratio_tests(white, periods, rounded);
        let single = [self.noise_size(white, known), self.outlier(white)];
        tests.extend(single.into_iter().flatten());
        let mut untested = self.untested.clone();
        let rest = [Contrast::NoiseSize, Contrast::Outlier, Contrast::Period];
        let is_absent = |one: &Contrast| tests.iter().all(|test| test.contrast != *one);
        untested.extend(rest.into_iter().filter(is_absent).map(|contrast| Untested {
            contrast,
            why: contrast.when_absent(self.observations).to_owned(),
        }));
        let family = holm(&tests.iter().map(|test| test.p).collect::<Vec<_>>());
        let beyond = |test: &StratumTest| {
            if test.p > STRATUM_LEVEL {
                return 0.0;
            }
            (test.statistic - 1.0).max(0.0) * test.dof[0]
        };
        let all: f64 = tests.iter().map(beyond).sum();
        for (test, p_family) in tests.iter_mut().zip(family) {
            test.p_family = p_family;
            test.spots.retain(|_| p_family <= STRATUM_LEVEL);
            for spot in &mut test.spots {
                spot.p_family = p_family;
            }
            test.share = if all > 0.0 { beyond(test) / all } else { 0.0 };
        }
        for comparison in &self.comparisons {
            let place = tests
                .iter()
                .position(|test| test.contrast == comparison.plan.contrast);
            if let Some(place) = place.filter(|&place| tests[place].p_family <= STRATUM_LEVEL) {
                tests[place].spots = self.spots(comparison, &tests[place], white);
            }
        }
        tests.sort_by_key(|test| (test.stratum, test.contrast));
        (tests, untested)
    }

    /// Tests of the comparisons and of periods; where the gauge is coarse, their chances are counted among drawn and rounded readings.
    pub(super) fn ratio_tests(
        &self,
        white: &[f64],
        periods: &[Period],
        rounded: Option<&RoundedNoise<'_>>,
    ) -> Vec<StratumTest> {
        let comparisons = self.comparisons.iter();
        let mut tests: Vec<StratumTest> = comparisons.map(|one| self.test(one, white)).collect();
        let error = self.error(ErrorTerm::Pure, white);
        tests.extend(Self::period(white, error, periods));
        if let Some(rounded) = rounded {
            let chances = |white: &[f64]| -> Vec<f64> {
                let (ratios, error) = self.ratios(white);
                let ratios = ratios.into_iter().map(|[f, d1, d2]| tail(f, d1, d2));
                let period = Self::period(white, error, periods);
                ratios.chain(period.map(|test| test.p)).collect()
            };
            let drawn = rounded.chances(&chances(white), chances);
            for (test, p) in tests.iter_mut().zip(drawn) {
                test.p = p;
                test.p_at_floor = p <= LEAST_COUNTED;
            }
        }
        tests
    }

    pub(super) fn test(&self, comparison: &FitContrast, white: &[f64]) -> StratumTest {
        let (pattern, d1) = self.pattern(comparison, white);
        let (error, d2) = self.error(comparison.plan.error, white);
        let statistic = (squares(&pattern) / d1) / (error / d2);
        let (contrast, p) = (comparison.plan.contrast, tail(statistic, d1, d2));
        StratumTest::new(contrast, statistic, [d1, d2], p, self.size_m(pattern))
    }

    /// Largest departure of a reading in a white pattern, m.
    pub(super) fn size_m(&self, mut pattern: Vec<f64>) -> f64 {
        self.whitening.covariance.unwhiten(&mut pattern);
        if self.observations.free_zeros {
            // A zero that may be anything is no departure.
            pattern = self.observations.about_zeros(pattern);
        }
        largest(&pattern)
    }

    /// Each pose, direction and cell alone.
    fn spots(&self, comparison: &FitContrast, test: &StratumTest, white: &[f64]) -> Vec<Spot> {
        let (error, d2) = self.error(comparison.plan.error, white);
        let whole = squares(&self.pattern(comparison, white).0);
        let mut spots: Vec<(Spot, f64)> = groups(self.observations)
            .into_iter()
            .filter_map(|group| {
                let inside = |cell: usize| group.holds(&self.observations.cells[cell]);
                let (pattern, d1) = self.pattern_in(comparison, white, &inside);
                if d1 == 0.0 {
                    return None;
                }
                let explained = squares(&pattern);
                let statistic = (explained / d1) / (error / d2);
                let spot = Spot {
                    pose: (group.pose).map(|pose| self.observations.poses[pose].clone()),
                    direction: group.direction,
                    repeat: None,
                    step: None,
                    p_family: 1.0,
                    size_m: self.size_m(pattern),
                    // A part that is let go takes along what it shares with other contrasts.
                    share: (explained / whole).min(1.0),
                };
                Some((spot, tail(statistic, d1, d2)))
            })
            .collect();
        let family = holm(&spots.iter().map(|(_, p)| *p).collect::<Vec<_>>());
        for ((spot, _), p) in spots.iter_mut().zip(family) {
            spot.p_family = p.max(test.p_family);
        }
        let mut spots: Vec<Spot> = spots
            .into_iter()
            .map(|(spot, _)| spot)
            .filter(|spot| spot.p_family <= STRATUM_LEVEL)
            .collect();
        spots.sort_by(|a, b| b.share.total_cmp(&a.share));
        spots
    }
}

/// Poses, directions and cells, where there are several.
fn groups(observations: &Observations) -> Vec<PatternGroup> {
    let mut groups: Vec<PatternGroup> = PatternGroup::of_poses(observations).collect();
    let several_poses = !groups.is_empty();
    let directions: Vec<PatternGroup> = PatternGroup::of_directions(observations).collect();
    if directions.len() > 1 {
        groups.extend(directions);
        groups.extend(PatternGroup::of_cells(observations).filter(|_| several_poses));
    }
    groups
}
