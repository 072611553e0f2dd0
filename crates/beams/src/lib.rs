//! A robot as beams: its file, its kinematics, its compliance, and the physics that beams leave out.
//!
//! - [`structure`]: three-dimensional beams. Has never heard of robots.
//! - [`robot`]: a robot file, its kinematics, mobility, and the structure it is in a pose. Names come from the file.
//! - [`physics`]: the laws that a beam model leaves out, solved with the structure.

pub mod physics;
pub mod robot;
pub mod structure;
