//! Noise with what is known of it.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiffbench_numeric::statistics::normal_quantile;

use crate::mismatch::observed::ReadingNoise;

/// The noise with what is known of it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EstimatedNoise {
    /// The standard deviations.
    pub noise: ReadingNoise,
    /// Covariance of the logarithms of the three variances: reading, zero, run slope.
    pub covariance: [[f64; 3]; 3],
    /// Standard errors of the logarithm of the standard deviation that grows, and of the inverse hyperbolic tangent of the correlation; zero
    /// where the noise has no such part, or it was given.
    pub further_se: [f64; 2],
    /// Where it comes from.
    pub basis: NoiseBasis,
}

/// Where a noise comes from: the first that applies.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum NoiseBasis {
    /// It was stated, or recorded.
    Stated,
    /// Differences between repeats.
    Repeats,
    /// Differences between neighbours in long runs.
    Neighbours,
    /// What the fit leaves, of which a part may be physics that the model lacks.
    Fit,
}

/// What is stated of the scatter of single readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StatedScatter {
    /// Standard deviation of a reading, the step of its gauge included, m.
    pub displacement_sd_m: f64,
    /// Standard deviation of the force, beside its step, N; `None` as the readings show it.
    pub force_sd_n: Option<f64>,
}

impl EstimatedNoise {
    /// With what is stated of single readings; how zeros and slopes of runs scatter nobody states, so it stays as it was estimated, or as the
    /// fit leaves it where nothing is repeated.
    ///
    /// # Arguments
    /// - `has_series`: whether a run has several loads; of one load its slope is the scatter of the force.
    #[must_use]
    pub(crate) fn with_stated(self, stated: StatedScatter, has_series: bool) -> Self {
        let mut noise = self;
        // Rotations scatter as they are seen to.
        noise.noise.gauges.rotation_ratio *= self.noise.reading_sd_m / stated.displacement_sd_m;
        noise.noise.reading_sd_m = stated.displacement_sd_m;
        if let Some(force_sd_n) = stated.force_sd_n {
            noise.noise.gauges.force_sd_n = force_sd_n;
        }
        let is_from_fit = self.basis == NoiseBasis::Fit;
        if !has_series && (is_from_fit || stated.force_sd_n.is_some()) {
            // Without repeats the rest would be what the model lacks.
            return Self::known(ReadingNoise {
                run_slope_sd: 0.0,
                ..noise.noise
            });
        }
        // What is given has no uncertainty, and none in common with the rest.
        for other in 0..3 {
            noise.covariance[0][other] = 0.0;
            noise.covariance[other][0] = 0.0;
        }
        if !is_from_fit {
            noise.basis = NoiseBasis::Stated;
        }
        noise
    }

    /// Noise that is known.
    pub(crate) fn known(noise: ReadingNoise) -> Self {
        Self {
            noise,
            covariance: [[0.0; 3]; 3],
            further_se: [0.0; 2],
            basis: NoiseBasis::Stated,
        }
    }

    /// Noise of which the part of single readings was estimated, without repeats.
    ///
    /// # Arguments
    /// - `dof`: degrees of freedom of its variance.
    pub(crate) fn of_readings(noise: ReadingNoise, dof: f64) -> Self {
        let mut found = Self::known(noise);
        found.covariance[0][0] = 2.0 / dof.max(2.0);
        found.basis = NoiseBasis::Neighbours;
        found
    }

    /// Degrees of freedom of a variance with these shares of the three (Satterthwaite).
    #[must_use]
    pub fn degrees_of_freedom(&self, shares: [f64; 3]) -> f64 {
        let mut variance = 0.0;
        for i in 0..3 {
            for j in 0..3 {
                variance += shares[i] * self.covariance[i][j] * shares[j];
            }
        }
        // Below two degrees of freedom a quantile carries no information; above a million it is the normal one.
        (2.0 / variance.max(2e-6)).clamp(2.0, 1e6)
    }

    /// 95 % intervals of the growth with the displacement and of the correlation within a run; none of what the noise does not have.
    #[must_use]
    pub fn further_ci95(&self) -> [Option<[f64; 2]>; 2] {
        let [growth, correlation] = self.further_se.map(|se| normal_quantile(0.975) * se);
        let noise = &self.noise;
        let of_growth = [-growth, growth].map(|reach| noise.growth_sd * reach.exp());
        let of_correlation =
            [-correlation, correlation].map(|reach| (noise.correlation.atanh() + reach).tanh());
        [
            (noise.growth_sd > 0.0).then_some(of_growth),
            (noise.correlation != 0.0).then_some(of_correlation),
        ]
    }
}
