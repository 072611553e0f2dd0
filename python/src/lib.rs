//! The compiled part of the Python package `stiffbench`. What a user sees is in `python/package/stiffbench/__init__.py`.

mod commands;
mod failure;
mod robot;

use pyo3::prelude::*;

/// The compiled part of stiffbench.
#[pymodule]
mod _native {
    #[pymodule_export]
    use super::commands::{command, tables};
    #[pymodule_export]
    use super::robot::Robot;

    /// Version of the package, that of the program.
    #[pymodule_export]
    #[expect(non_upper_case_globals, reason = "the name that Python expects")]
    const __version__: &str = env!("CARGO_PKG_VERSION");
}
