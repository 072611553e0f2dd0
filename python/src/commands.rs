//! Commands of the program, as they are typed.

use std::ffi::OsString;

use pyo3::prelude::*;

use stiffbench::cli;

use crate::failure::exception;

/// A table: name, title, and the columns as name, kind, unit, meaning and fields.
type Table = (
    &'static str,
    &'static str,
    Vec<(String, &'static str, String, String, Vec<String>)>,
);

/// Runs a command of stiffbench; returns the JSON text of its result.
#[pyfunction]
pub(crate) fn command(py: Python<'_>, words: Vec<OsString>) -> PyResult<String> {
    let answer = py.detach(|| Ok(cli::json_of(words)?.to_string()));
    answer.map_err(|object: serde_json::Value| exception(py, &object))
}

/// The tables that `stiffbench export` writes, with their fields as text.
#[pyfunction]
pub(crate) fn tables(py: Python<'_>, words: Vec<OsString>) -> PyResult<Vec<Table>> {
    let tables = py.detach(|| cli::tables_of(words));
    let tables = tables.map_err(|object| exception(py, &object))?;
    let table = |table: stiffbench::export::tidy::TidyTable| {
        let columns = table.columns.into_iter().enumerate();
        let rows = &table.rows;
        let columns = columns.map(|(place, column)| {
            let fields = rows.iter().map(|row| row[place].clone()).collect();
            (
                column.name,
                column.kind.name(),
                column.unit,
                column.meaning,
                fields,
            )
        });
        (table.name, table.title, columns.collect())
    };
    Ok(tables.into_iter().map(table).collect())
}
