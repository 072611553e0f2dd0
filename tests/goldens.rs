//! What every command prints and writes on shipped and simulated data, against what is kept in `fixtures/goldens`.

#![cfg(unix)]

use stiffbench_test_files::goldens::Goldens;

#[test]
fn every_command_reproduces_its_golden() {
    Goldens {
        program: env!("CARGO_BIN_EXE_stiffbench"),
        name: "stiffbench",
        folder: "fixtures/goldens",
        commit: env!("PROGRAM_COMMIT"),
    }
    .check();
}
