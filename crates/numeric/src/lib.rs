//! Numerics that know nothing of benches or robots.
//!
//! - [`statistics`]: estimates with uncertainty, and the distributions behind them;
//! - [`reported`]: a number as it goes to JSON;
//! - [`vector`]: vectors of three;
//! - [`simd`]: one number for several poses at once, in the registers of the machine at hand;
//! - [`least_squares`]: parameters, minima and what they are worth.

pub mod least_squares;
pub mod reported;
pub mod simd;
pub mod statistics;
pub mod vector;
