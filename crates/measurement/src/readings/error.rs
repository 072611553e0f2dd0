//! What can be wrong with a table.

use std::borrow::Cow;
use std::error::Error;
use std::fmt::{self, Display};

use miette::Diagnostic;

/// A line of a file, as messages name it.
pub(crate) fn line_of(file: &str, line: u32) -> String {
    format!("{file}, line {line}")
}

/// A field of a table, as messages name it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct FileCell {
    /// The file.
    pub(crate) file: String,
    /// The line, or the row of a sheet, from 1.
    pub(crate) line: u32,
    /// The column, as named in the file.
    pub(crate) column: String,
    /// The text found.
    pub(crate) value: String,
}

impl Display for FileCell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            file, line, column, ..
        } = self;
        write!(f, "{file}, line {line}, column `{column}`")
    }
}

impl FileCell {
    /// The error for a field that holds something else than what belongs there.
    pub(crate) fn refused(
        &self,
        code: &'static str,
        expected: &str,
        help: &'static str,
    ) -> TableError {
        let message = format!("{self}: `{}`, expected {expected}", self.value);
        TableError::new(code, message, help)
    }
}

/// Why a table could not be read or written: of readings, of load cases, of a part, of a calibration, or of another program.
///
/// Its message names the file, and the line and the column if it concerns one.
#[derive(Debug, thiserror::Error)]
#[error("{message}")]
pub struct TableError {
    /// Its name in results, for example `stiffbench::readings::bad_value`.
    pub code: &'static str,
    /// Names of columns that are not there and must be; empty of any other error.
    pub missing: Vec<String>,
    message: String,
    help: Cow<'static, str>,
    #[source]
    cause: Option<Box<dyn Error + Send + Sync>>,
}

impl TableError {
    pub(crate) fn new(
        code: &'static str,
        message: impl Into<String>,
        help: impl Into<Cow<'static, str>>,
    ) -> Self {
        Self {
            code,
            missing: Vec::new(),
            message: message.into(),
            help: help.into(),
            cause: None,
        }
    }

    /// The same about columns that are not there.
    pub(crate) fn about(self, missing: Vec<String>) -> Self {
        Self { missing, ..self }
    }

    /// The same with the error that led to it.
    pub(crate) fn caused_by(self, cause: impl Error + Send + Sync + 'static) -> Self {
        let cause: Option<Box<dyn Error + Send + Sync>> = Some(Box::new(cause));
        Self { cause, ..self }
    }

    /// The same with other words on what to do.
    #[must_use]
    pub fn with_help(self, help: String) -> Self {
        let help = help.into();
        Self { help, ..self }
    }

    /// The error for an output that stopped.
    pub(crate) fn not_written(cause: csv::Error) -> Self {
        TableError::new(
            "stiffbench::readings::write",
            "the table of readings could not be written",
            "see the cause; what was flushed before is complete",
        )
        .caused_by(cause)
    }
}

impl Diagnostic for TableError {
    fn code<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        Some(Box::new(self.code))
    }

    fn help<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        Some(Box::new(&self.help))
    }
}
