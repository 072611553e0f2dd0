//! Fits and diagnoses at the border of the program: tables go in, the JSON of a command comes out. What lies between may change.

mod arm;
mod bad_load_case_values;
mod bad_readings;
mod bad_runs;
mod elastic_calibration;
mod growth;
mod joined_sessions;
mod load_case_diagnosis;
mod load_case_fit;
mod load_cases;
mod mismatch_verdicts;
mod noise_of_what_was_set;
mod position_coverage;
mod robots;
mod six_springs;
mod vector_coverage;
mod without_repeats;
mod wrong_cells;
