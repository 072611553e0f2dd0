//! The virtual bench: beam model, jack, two gauges, noise and clock, in software.
//!
//! It makes sessions whose truth is known. The noise that makes the data is set here and nowhere else; an analysis assumes its own.

mod jack;
mod noise;
mod virtual_bench;

pub use jack::Jack;
pub use noise::NoiseModel;
pub use virtual_bench::{BenchError, BenchPlan, VirtualBench};
