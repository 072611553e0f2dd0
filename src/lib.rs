//! From two gauges on a robot bench to a stiffness model that can be trusted.

pub mod bench;
pub mod cli;
pub mod distribution;
pub mod fit;
pub mod least_squares;
pub mod plot;
pub mod quantity;
pub mod readings;
pub mod report;
pub mod robot;
pub mod source_text;
pub mod statistics;
pub mod stiffness;
pub mod structure;
pub mod test_point;
pub mod vector;
