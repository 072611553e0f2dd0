//! Failures as `stiffbench.StiffbenchError`.

use pyo3::prelude::*;

use stiffbench::cli::failure::Failure;

/// The exception of a failure, given as the object that the program prints with `--json`.
pub(crate) fn exception(py: Python<'_>, object: &impl std::fmt::Display) -> PyErr {
    let raised = py
        .import("stiffbench._error")
        .and_then(|module| module.call_method1("from_json", (object.to_string(),)));
    match raised {
        Ok(exception) => PyErr::from_value(exception),
        Err(error) => error,
    }
}

/// The exception of an error of the library.
pub(crate) fn exception_of(py: Python<'_>, error: impl Into<Failure>) -> PyErr {
    exception(py, &error.into().to_json())
}
