//! The `stiffbench` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    stiffbench::cli::main(std::env::args_os())
}
