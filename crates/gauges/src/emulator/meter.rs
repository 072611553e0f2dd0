//! The measuring part of an emulated gauge: zero, unit, peaks, hold, and what can go wrong with them.

use crate::Channel;

use super::truth::SharedTruth;

/// A unit of a gauge.
#[derive(Debug, Clone)]
pub(super) struct Unit {
    /// Its usual name.
    pub(super) name: String,
    /// N or m in one of it.
    pub(super) si: f64,
    /// Digits behind the point.
    pub(super) decimals: u8,
}

/// What a gauge is made for.
#[derive(Debug, Clone)]
pub(super) struct Range {
    /// Which of the two gauges it can be.
    pub(super) channel: Channel,
    /// Its units; the first is the one after switching on.
    pub(super) units: Vec<Unit>,
    /// Largest value, N or m.
    pub(super) capacity_si: f64,
    /// Whether its plus is the truth's: force in tension, displacement as it counts.
    pub(super) plus_as_truth: bool,
}

/// A gauge shows overload above this share of its capacity, according to the makers.
const OVERLOAD_SHARE: f64 = 1.1;

/// Value of a gauge that is set to be overloaded, as a share of its capacity.
const FORCED_OVERLOAD_SHARE: f64 = 1.15;

/// The state of a measuring part.
#[expect(
    clippy::struct_excessive_bools,
    reason = "each is a switch of its own, and any may be on with any other"
)]
pub(super) struct Meter {
    truth: SharedTruth,
    pub(super) range: Range,
    zero_si: f64,
    unit: usize,
    inverted: bool,
    /// Value that the display keeps, own sign; a hold that the protocol has.
    held_si: Option<f64>,
    /// Value at which the gauge hangs, own sign; invisible to the gauge.
    frozen_si: Option<f64>,
    forced_overload: bool,
    /// Largest and smallest value since the peaks were cleared, own sign.
    peaks_si: [f64; 2],
    pub(super) peak_mode: bool,
    pub(super) battery_low: bool,
    /// Nothing is plugged into the adapter, or the probe is off.
    pub(super) tool_off: bool,
}

impl Meter {
    pub(super) fn new(range: Range, truth: SharedTruth) -> Self {
        Self {
            truth,
            range,
            zero_si: 0.0,
            unit: 0,
            inverted: false,
            held_si: None,
            frozen_si: None,
            forced_overload: false,
            peaks_si: [0.0; 2],
            peak_mode: false,
            battery_low: false,
            tool_off: false,
        }
    }

    /// The value now, own sign, N or m, in any mode and hold.
    pub(super) fn live_si(&mut self) -> f64 {
        if let Some(frozen_si) = self.frozen_si {
            return frozen_si;
        }
        let mut value_si = self.truth.value_si() - self.zero_si;
        if self.range.plus_as_truth == self.inverted {
            value_si = -value_si;
        }
        if self.forced_overload {
            value_si = (FORCED_OVERLOAD_SHARE * self.range.capacity_si).copysign(value_si);
        }
        self.peaks_si = [
            self.peaks_si[0].max(value_si),
            self.peaks_si[1].min(value_si),
        ];
        value_si
    }

    /// The value on the display, own sign, N or m.
    pub(super) fn displayed_si(&mut self) -> f64 {
        let live_si = self.live_si();
        if let Some(held_si) = self.held_si {
            return held_si;
        }
        if self.peak_mode {
            self.larger_peak_si()
        } else {
            live_si
        }
    }

    fn larger_peak_si(&self) -> f64 {
        let [highest, lowest] = self.peaks_si;
        if highest >= -lowest { highest } else { lowest }
    }

    /// A value in the unit that is set, as the display rounds it.
    pub(super) fn rounded(&self, value_si: f64) -> f64 {
        let unit = self.unit();
        let scale = 10_f64.powi(i32::from(unit.decimals));
        // A display has no negative zero.
        (value_si / unit.si * scale).round() / scale + 0.0
    }

    /// Whether a value is beyond what the gauge can take.
    pub(super) fn overloaded(&self, value_si: f64) -> bool {
        self.forced_overload || value_si.abs() > OVERLOAD_SHARE * self.range.capacity_si
    }

    /// Sets the zero here and clears the peaks.
    pub(super) fn zero(&mut self) {
        self.zero_si = self.truth.value_si();
        self.clear_peaks();
    }

    pub(super) fn clear_peaks(&mut self) {
        self.peaks_si = [0.0; 2];
    }

    /// Keeps the display as it is, or lets it go.
    pub(super) fn hold(&mut self, on: bool) {
        self.held_si = if on { Some(self.displayed_si()) } else { None };
    }

    pub(super) fn is_held(&self) -> bool {
        self.held_si.is_some()
    }

    /// Hangs at the value of now, or goes on.
    pub(super) fn freeze(&mut self, on: bool) {
        self.frozen_si = if on { Some(self.live_si()) } else { None };
    }

    pub(super) fn invert(&mut self, on: bool) {
        self.inverted = on;
        self.clear_peaks();
    }

    pub(super) fn force_overload(&mut self, on: bool) {
        self.forced_overload = on;
        self.clear_peaks();
    }

    pub(super) fn unit(&self) -> &Unit {
        &self.range.units[self.unit]
    }

    /// Changes the unit; `false` if the gauge does not have it.
    pub(super) fn set_unit(&mut self, name: &str) -> bool {
        let mut units = self.range.units.iter();
        let place = units.position(|unit| unit.name == name);
        self.unit = place.unwrap_or(self.unit);
        place.is_some()
    }

    /// Place of the unit among the units of the range.
    pub(super) fn unit_place(&self) -> usize {
        self.unit
    }
}
