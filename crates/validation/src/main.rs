//! The `stiffbench-validate` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    stiffbench_validation::cli::main(std::env::args_os())
}
