//! What every command prints and writes, against what is kept in `fixtures/goldens-validate`.

#![cfg(unix)]

use stiffbench_test_files::goldens::Goldens;

#[test]
fn every_command_reproduces_its_golden() {
    Goldens {
        program: env!("CARGO_BIN_EXE_stiffbench-validate"),
        name: "stiffbench-validate",
        folder: "fixtures/goldens-validate",
        commit: "",
    }
    .check();
}
