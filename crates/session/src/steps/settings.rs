//! What a session is run with, besides its procedure.

use stiffbench_gauges::description::UnitSource;
use stiffbench_gauges::{Channel, InstrumentDescription};
use stiffbench_measurement::procedure::Pace;
use stiffbench_measurement::stiffness::GaugePair as GaugeTerms;

/// How far one gauge may be behind the other, s.
const LAG_S: f64 = 0.1;

/// How many times as fast as real a session may run for one gauge to be compared with the other: lines and scheduler stay as they are.
const FASTEST_JUDGED: f64 = 20.0;

/// How far one gauge may be behind the other in a session that runs `speed` times as fast as real, s.
#[must_use]
pub fn lag_s(speed: f64) -> f64 {
    if speed > FASTEST_JUDGED {
        f64::INFINITY
    } else {
        LAG_S * speed.max(1.0)
    }
}

/// What a session is run with, besides its procedure.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// Whether a reading is taken as soon as everything has settled; else a key takes it.
    pub auto_capture: bool,
    /// What the force gauge sends under compression, if its description states it: 1 for a value above zero, -1 below.
    pub compression_sign: Option<f64>,
    /// Whether the readings of each cell are compared with their repeats once it is complete.
    pub checks_repeats: bool,
    /// Scatter of readings from repeat to repeat, m, where the bench states it: one that is emulated.
    pub scatter_m: Option<f64>,
    /// Drift of the zero beyond which is asked, m.
    pub drift_limit_m: f64,
    /// Shortest time without a value after which a gauge counts as stale, s; longer for gauges that send seldom.
    pub least_stale_s: f64,
    /// How far one gauge may be behind the other, s: conversion, filter, request. Without limit, neither is compared with the other.
    pub lag_s: f64,
    /// The unit that was configured for a gauge that cannot report its own: the operator compares it with the display.
    pub units_by_eye: [Option<String>; Channel::COUNT],
    /// Resolution and calibration of the gauges.
    pub gauges: GaugeTerms,
    /// How fast the operator works, for the time left.
    pub pace: Pace,
    /// Name of the operator, where it is known.
    pub operator: Option<String>,
    /// What stays true for the whole session.
    pub warnings: Vec<String>,
    /// Names of the gauges.
    pub names: [String; Channel::COUNT],
    /// Files in the folder `raw` that keep the bytes of the gauges; empty where none is kept.
    pub traces: [String; Channel::COUNT],
}

impl Settings {
    /// What the description of a gauge states, and the unit that it was configured with.
    pub fn take(&mut self, description: &InstrumentDescription, unit: Option<&str>) {
        if description.channel == Channel::Force {
            self.compression_sign = description.sign.compression.sign();
        }
        if description.unit_source() != UnitSource::Query {
            self.units_by_eye[description.channel.index()] = unit.map(str::to_owned);
        }
    }
}

impl Default for Settings {
    /// Automatic capture; 10 µm of drift, five times the spread a reading may have; half a second, some 25 periods of a slow stream.
    fn default() -> Self {
        Self {
            auto_capture: true,
            compression_sign: None,
            checks_repeats: false,
            scatter_m: None,
            drift_limit_m: 10e-6,
            least_stale_s: 0.5,
            lag_s: lag_s(1.0),
            units_by_eye: <[Option<String>; Channel::COUNT]>::default(),
            gauges: GaugeTerms::default(),
            pace: Pace::default(),
            operator: None,
            warnings: Vec::new(),
            names: Channel::EVERY.map(|channel| format!("{channel} gauge")),
            traces: <[String; Channel::COUNT]>::default(),
        }
    }
}
