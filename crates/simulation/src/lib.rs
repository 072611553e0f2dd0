//! The virtual bench: beam model, physics beside it, jack, two gauges, noise, clock and thermometer, in software.
//!
//! It follows a [`stiffbench_measurement::procedure::Procedure`] and makes sessions whose truth is known ([`VirtualBench`]), or stands there to be loaded and
//! read, as emulated gauges do ([`EmulatedBench`]). The noise that makes the data is set here and
//! nowhere else; an analysis assumes its own.

mod emulated_bench;
mod jack;
mod load_cases;
mod mechanics;
mod noise;
mod positions;
mod recorder;
mod temperature;
mod virtual_bench;

pub use emulated_bench::{EmulatedBench, EmulatedSetup};
pub use jack::Jack;
pub use load_cases::{LoadCasePlan, simulate_load_cases};
pub use noise::{NoiseModel, NoiseShape};
pub use positions::{PositionPlan, SimulatedPositions, simulate_positions};
pub use virtual_bench::{BenchError, VirtualBench};

/// Streams of the random numbers of one seed: forces and errors come from stream 0, so that they stay the same when times change.
const STREAM_OF_TIMES: u64 = 1;

/// See [`STREAM_OF_TIMES`].
const STREAM_OF_TEMPERATURE: u64 = 2;
