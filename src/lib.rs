#![doc = include_str!("../README.md")]
//!
//! # Map of the code
//!
//! In the order in which data flow; what each module may import is held by `tests/architecture.rs`.
//!
//! - [`quantity`], [`statistics`], [`source_text`], [`nearest`], [`vector`], [`clock`]: leaves. Units at the edges, estimates with uncertainty,
//!   places in texts, the name that was meant, vectors of three, time.
//! - `lanes`: one number for several poses at once, in the registers of the machine at hand. Leaf.
//! - [`test_point`]: where in the experiment a number belongs: pose, direction, branch.
//! - [`readings`]: what was measured, as stored. The waist: acquisition ends by writing a session folder, analysis begins by reading one.
//!   Nothing is dropped silently.
//! - [`specimen`]: force against displacement of anything, without a robot. Knows only the columns that the caller names.
//! - [`instrument`]: bytes on a serial line to samples, and emulated gauges that send them. Has never heard of poses.
//! - [`session`]: what the operator does next, and the journal that loses nothing. Ends by writing a session folder.
//! - [`stiffness`]: readings to measured stiffness. Knows no model.
//! - [`structure`]: three-dimensional beams. Has never heard of robots.
//! - [`mod@reference`]: the same structure as solids, for a program of others to hold the beams against. Runs nothing.
//! - [`robot`]: a robot file, its kinematics, mobility, and the structure it is in a pose. Names come from the file.
//! - [`physics`]: the laws that a beam model leaves out, solved with the structure.
//! - [`procedure`]: which loads are applied where and in which order, as data. Guided sessions and the virtual bench follow the same steps.
//! - [`mod@bench`]: the virtual bench: it follows a procedure, or stands there for emulated gauges to measure. The noise that makes data lives here, never the noise an analysis assumes.
//! - [`least_squares`]: parameters, minima and what they are worth. Has never heard of stiffness.
//! - [`fit`]: fitting factors from measured or reference stiffness, jointly or by the paper's steps.
//! - [`mismatch`]: what the fitted structure cannot explain, and which physics would.
//! - [`prove`]: whether a diagnosis can be trusted: blind verdicts scored against sealed answers, error rates, recordings by others.
//! - [`distribution`]: what a robot does over its workspace.
//! - [`plot`]: plain numbers to SVG and PNG. Opens no files.
//! - [`report`]: results as tables, JSON and inputs of figures.
//! - [`cli`]: arguments, files, terminal. Only it prints, opens files and reads the clock.

pub mod bench;
pub mod cli;
pub mod clock;
pub mod distribution;
pub mod fit;
pub mod instrument;
mod lanes;
pub mod least_squares;
pub mod mismatch;
pub mod nearest;
pub mod physics;
pub mod plot;
pub mod procedure;
pub mod prove;
pub mod quantity;
pub mod readings;
pub mod reference;
pub mod report;
pub mod robot;
pub mod session;
pub mod source_text;
pub mod specimen;
pub mod statistics;
pub mod stiffness;
pub mod structure;
pub mod test_point;
pub mod vector;
