//! The standard deviations that make readings scatter.

use stiffbench_units_and_text::read_axis::ReadAxis;

/// The noise of readings.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ReadingNoise {
    /// Standard deviation of a reading, the step of its gauge included, m.
    pub reading_sd_m: f64,
    /// Of a gauge zero, m.
    pub zero_sd_m: f64,
    /// Of the slope of a run, relative (1).
    pub run_slope_sd: f64,
    /// Standard deviation of a reading that grows with the displacement, as a share of it (1).
    pub growth_sd: f64,
    /// Correlation of the error of a reading with that of the reading before it in its run (1): a first-order autoregressive process.
    pub correlation: f64,
    /// What several gauges that are read at once have apart and in common.
    pub gauges: GaugeNoise,
}

/// How the noise of several gauges that are read at once differs, and what it has in common; of one gauge nothing.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaugeNoise {
    /// Standard deviation of a reading of the gauge along x, y, z over that of all (1); their geometric mean is one.
    pub reading_ratios: [f64; 3],
    /// Standard deviation of a rotation over that of a displacement, rad/m.
    pub rotation_ratio: f64,
    /// Standard deviation of the slope that a run has in one gauge alone, relative (1).
    pub own_slope_sd: f64,
    /// Standard deviation of the force of a reading beside the step of its gauge, N.
    pub force_sd_n: f64,
}

impl GaugeNoise {
    /// Of one gauge, or of several that are alike.
    pub const ALIKE: Self = Self {
        reading_ratios: [1.0; 3],
        rotation_ratio: 1.0,
        own_slope_sd: 0.0,
        force_sd_n: 0.0,
    };
}

impl Default for GaugeNoise {
    fn default() -> Self {
        Self::ALIKE
    }
}

impl ReadingNoise {
    /// Variance of a reading by itself, without the error of the force, m².
    ///
    /// # Arguments
    /// - `read`: what was read.
    /// - `slope_m`: its displacement by the baseline.
    pub(crate) fn own_variance(&self, read: &ReadAxis, slope_m: f64) -> f64 {
        let ratio = if read.is_rotation() {
            self.gauges.rotation_ratio
        } else {
            self.gauges.reading_ratios[read.axis().index()]
        };
        (ratio * self.reading_sd_m).powi(2) + (self.growth_sd * slope_m).powi(2)
    }

    /// How much larger than in another noise the variance is that exceeds it most; not below 1.
    pub(crate) fn largest_variance_ratio(&self, other: &Self) -> f64 {
        let ratios = [
            self.reading_sd_m / other.reading_sd_m,
            self.zero_sd_m / other.zero_sd_m,
            self.run_slope_sd / other.run_slope_sd,
            if other.growth_sd > 0.0 {
                self.growth_sd / other.growth_sd
            } else {
                1.0
            },
        ];
        ratios.into_iter().fold(1.0, f64::max).powi(2)
    }

    /// This noise, by how much one of its kind differs from another.
    pub(crate) fn in_proportion(&self, now: &Self, then: &Self) -> Self {
        let scaled = |own: f64, now: f64, then: f64| {
            let ratio = now / then;
            if ratio.is_finite() { own * ratio } else { own }
        };
        let reading_sd_m = scaled(self.reading_sd_m, now.reading_sd_m, then.reading_sd_m);
        Self {
            reading_sd_m,
            zero_sd_m: scaled(self.zero_sd_m, now.zero_sd_m, then.zero_sd_m),
            run_slope_sd: scaled(self.run_slope_sd, now.run_slope_sd, then.run_slope_sd),
            growth_sd: scaled(self.growth_sd, now.reading_sd_m, then.reading_sd_m),
            correlation: self.correlation,
            gauges: self.gauges,
        }
    }
}
