//! A gauge that sends its value by itself, so many times a second, and knows no commands.

use crate::emulator::gauge::Maker;
use crate::emulator::meter::Meter;
use crate::emulator::wire::{Packets, Stream};

/// What such a gauge sends and how often.
#[derive(Debug)]
pub(super) struct Unasked {
    stream: Stream,
    per_second: f64,
    value: fn(&mut Meter) -> Vec<u8>,
}

impl Unasked {
    /// Packets of `value`, `per_second` of them.
    pub(super) fn boxed(per_second: f64, value: fn(&mut Meter) -> Vec<u8>) -> Box<dyn Maker> {
        Box::new(Self {
            stream: Stream::default(),
            per_second,
            value,
        })
    }
}

impl Maker for Unasked {
    fn receive(&mut self, _: &mut Meter, _: &[u8], _: f64, _: &mut Packets) {}

    fn tick(&mut self, meter: &mut Meter, now_s: f64, out: &mut Packets) {
        if !self.stream.is_on() {
            self.stream.start(self.per_second, now_s);
        }
        for _ in 0..self.stream.due(now_s) {
            out.push((self.value)(meter));
        }
    }

    fn next_due_s(&self) -> Option<f64> {
        Some(self.stream.next_due_s().unwrap_or(0.0))
    }
}
