#![doc = include_str!("../README.md")]
//!
//! # Map of the code
//!
//! The program is this crate; the parts it is made of are crates of their own in `crates/`, named here in the order in which data flow.
//! Cargo holds which part may know which; `tests/architecture.rs` holds what Cargo cannot see.
//!
//! - `units-and-text`: [`quantity`], [`test_point`], [`source_text`], [`toml_text`], [`nearest`], [`clock`]. Units at the edges, pose and direction, places in
//!   texts, the name that was meant, time.
//! - `numeric`: [`vector`], [`statistics`], [`reported`], [`least_squares`]. Parameters, minima and what they are worth.
//! - `gauges`: [`instrument`]. Bytes on a serial line to samples, and emulated gauges that send them. Has never heard of poses.
//! - `measurement`: [`readings`], [`load_cases`], [`specimen`], [`table_files`], [`procedure`], [`stiffness`]. What was measured, as stored, and the stiffness that follows.
//!   Acquisition ends by writing a session folder, analysis begins by reading one. Nothing is dropped silently. Contains no model.
//! - `session`: [`session`]. What the operator does next, and the journal that loses nothing. Ends by writing a session folder.
//! - `beams`: [`structure`], [`robot`], [`physics`]. Three-dimensional beams, a robot as beams in a pose, and the laws that beams leave out.
//! - `simulation`: [`mod@bench`]. The virtual bench. The noise that makes data lives here, never the noise an analysis assumes.
//! - `diagnosis`: [`parameters`], [`fit`], [`search`], [`mismatch`], [`distribution`]. Model and measurement together, and the stiffness over the workspace.
//! - `figures`: [`plot`]. Plain numbers to SVG and PNG. Opens no files.
//!
//! What checks the tool is another program, `stiffbench-validate` in `crates/validation`, built on this one.
//!
//! Here:
//!
//! - [`shipped`]: robots, procedures and instrument descriptions that come with the program.
//! - [`analysis`]: from files to results: sessions, models, fits, diagnoses. What the commands call, for other programs too.
//! - [`export`]: a model for other programs: MJCF, SDF, URDF, tables.
//! - [`report`]: results as tables, JSON and inputs of figures.
//! - [`cli`]: arguments, output files, terminal. Only it prints, writes files and reads the clock.

pub mod analysis;
#[cfg(feature = "cli")]
pub mod cli;
pub mod export;
pub mod report;
pub mod shipped;

pub use stiffbench_beams::{physics, robot, structure};
pub use stiffbench_diagnosis::{distribution, fit, mismatch, parameters, search};
pub use stiffbench_figures as plot;
pub use stiffbench_gauges as instrument;
pub use stiffbench_measurement::{
    calibration, import, load_cases, procedure, readings, run_check, specimen, stiffness,
    stiffness_list, table_files,
};
pub use stiffbench_numeric::{least_squares, reported, statistics, vector};
pub use stiffbench_session as session;
pub use stiffbench_simulation as bench;
pub use stiffbench_units_and_text::{
    clock, count, digits, load_direction, nearest, quantity, source_text, test_point, toml_text,
};
