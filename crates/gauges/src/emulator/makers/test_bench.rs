//! A value that tests set, and a gauge that measures it.

use std::sync::Arc;
use std::sync::Mutex;

use crate::emulator::gauge::{EmulatedGauge, Maker, Panel};
use crate::emulator::meter::Range;

/// An emulated gauge on a truth that can be set.
pub(super) struct TestBench {
    truth: Arc<Mutex<f64>>,
    pub(super) gauge: EmulatedGauge,
}

impl TestBench {
    pub(super) fn new(range: Range, maker: Box<dyn Maker>) -> Self {
        let truth = Arc::new(Mutex::new(0.0));
        let shared = Arc::clone(&truth);
        let truth_of_gauge = Arc::new(move || *shared.lock().unwrap());
        Self {
            truth,
            gauge: EmulatedGauge::made("test", range, maker, truth_of_gauge),
        }
    }

    pub(super) fn of(make: &super::Make) -> Self {
        Self::new((make.range)(), (make.maker)())
    }

    /// The same gauge with another unit table.
    pub(super) fn with_units(make: &super::Make, units: Vec<super::Unit>) -> Self {
        Self::new(
            Range {
                units,
                ..(make.range)()
            },
            (make.maker)(),
        )
    }

    /// Sets the truth, N (positive in tension) or m.
    pub(super) fn set(&mut self, value_si: f64) -> &mut Self {
        *self.truth.lock().unwrap() = value_si;
        self
    }

    /// What the gauge answers, at time 0.
    pub(super) fn ask(&mut self, command: &str) -> String {
        self.ask_bytes(command.as_bytes())
    }

    pub(super) fn ask_bytes(&mut self, command: &[u8]) -> String {
        String::from_utf8_lossy(&self.gauge.receive(command, 0.0)).into_owned()
    }

    pub(super) fn press(&mut self, panel: &Panel) -> String {
        let packets = self.gauge.press(panel, 0.0).unwrap();
        String::from_utf8_lossy(&packets.concat()).into_owned()
    }

    /// How many packets come by themselves in a time that is served each millisecond.
    pub(super) fn packets_in_s(&mut self, from_s: f64, for_s: f64) -> usize {
        let milliseconds = (for_s * 1000.0) as u32;
        let times = (1..=milliseconds).map(|ms| from_s + f64::from(ms) / 1000.0);
        times.map(|s| self.gauge.tick_packets(s).len()).sum()
    }
}
