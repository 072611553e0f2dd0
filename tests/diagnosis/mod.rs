//! Fits and diagnoses at the border of the program: tables go in, the JSON of a command comes out. What lies between may change.

mod arm;
mod bad_readings;
mod bad_runs;
mod growth;
mod joined_sessions;
mod mismatch_verdicts;
mod robots;
mod tables;
mod vector_coverage;
mod wrong_cells;
