//! Whether `stiffbench` can be trusted: the program `stiffbench-validate`, which users of `stiffbench` do not need.
//!
//! - [`prove`]: blind verdicts scored against sealed answers, error rates, recordings by others.
//! - [`mod@reference`]: a robot as solids, for another program to compare the beams with.
//! - [`report`]: their results as tables, JSON and figures.
//! - [`cli`]: arguments, files, terminal.

pub mod cli;
pub mod prove;
pub mod reference;
pub mod report;
