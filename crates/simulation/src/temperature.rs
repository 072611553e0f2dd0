//! The temperature beside the bench.

use std::f64::consts::TAU;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Seconds in a day.
const DAY_S: f64 = 86_400.0;

/// A slow temperature: a workshop that warms by day and cools by night, and a heating that switches.
///
/// T(t) = 20 °C + offset + 1.2 K sin(2π t/day + φ₁) + 0.15 K sin(2π t/period + φ₂); offset within 1 K, period between one and two hours, both
/// and the phases from the seed. It changes by at most 1.3 K in an hour, and commonly by 0.5 K.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct TemperatureTrack {
    mean_deg_c: f64,
    day_phase: f64,
    heating_period_s: f64,
    heating_phase: f64,
}

impl TemperatureTrack {
    /// The track of a session.
    pub(super) fn new(seed: u64) -> Self {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        rng.set_stream(super::STREAM_OF_TEMPERATURE);
        let mut share = || rng.random::<f64>();
        Self {
            mean_deg_c: 19.0 + 2.0 * share(),
            day_phase: TAU * share(),
            heating_period_s: 3600.0 * (1.0 + share()),
            heating_phase: TAU * share(),
        }
    }

    /// Temperature, °C.
    pub(super) fn at(&self, time_s: f64) -> f64 {
        let day = (TAU * time_s / DAY_S + self.day_phase).sin();
        let heating = (TAU * time_s / self.heating_period_s + self.heating_phase).sin();
        self.mean_deg_c + 1.2 * day + 0.15 * heating
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_slow_and_belongs_to_its_seed() {
        for seed in 0..50 {
            let track = TemperatureTrack::new(seed);
            assert_eq!(track, TemperatureTrack::new(seed));
            for minute in 0..600 {
                let time_s = 60.0 * f64::from(minute);
                let now = track.at(time_s);
                assert!((17.6..22.4).contains(&now), "{seed}: {now}");
                let per_hour = (track.at(time_s + 60.0) - now).abs() * 60.0;
                assert!(per_hour < 1.3, "{seed}: {per_hour} K/h");
            }
        }
        assert_ne!(
            TemperatureTrack::new(1).at(0.0),
            TemperatureTrack::new(2).at(0.0)
        );
    }
}
