//! Why a calibration table could not be used.

use miette::Diagnostic;
use thiserror::Error;

use crate::table_files::{LinePlace, TableFileError};

/// Why a calibration table could not be used.
#[derive(Debug, Error, Diagnostic)]
pub enum CalibrationTableError {
    /// The file is no table that can be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Table(#[from] TableFileError),
    /// A column is missing.
    #[error("{at}: no column `{column}`")]
    #[diagnostic(
        code(stiffbench::calibration_table::missing_column),
        help(
            "a calibration table has the columns applied, indicated, U and k, with their units: applied_N, indicated_N, U_N, k"
        )
    )]
    MissingColumn {
        /// Line of the column names.
        at: LinePlace,
        /// The column.
        column: &'static str,
    },
    /// A column without a unit of the gauge.
    #[error("{at}, column `{column}`: no unit of a {quantity}")]
    #[diagnostic(
        code(stiffbench::calibration_table::unit),
        help("put the unit behind the name: known are {accepted}")
    )]
    Unit {
        /// Line of the column names.
        at: LinePlace,
        /// The column.
        column: String,
        /// `force` or `displacement`.
        quantity: &'static str,
        /// Units of that quantity.
        accepted: &'static str,
    },
    /// A row that lacks a value, or has one that cannot be.
    #[error("{at}: {problem}")]
    #[diagnostic(
        code(stiffbench::calibration_table::row),
        help("each row needs applied, indicated and U; k may be absent and is 2 then")
    )]
    Row {
        /// The line.
        at: LinePlace,
        /// What is wrong.
        problem: &'static str,
    },
    /// Indicated values that do not rise with the applied ones.
    #[error("{at}: the indicated value does not rise with the applied one")]
    #[diagnostic(
        code(stiffbench::calibration_table::not_rising),
        help("give one row for each applied value, for example the mean of the series up")
    )]
    NotRising {
        /// The line.
        at: LinePlace,
    },
    /// Too few points.
    #[error("{file}: fewer than two points")]
    #[diagnostic(
        code(stiffbench::calibration_table::too_few),
        help(
            "give at least two rows, or the uncertainty alone with --force-u or --displacement-u"
        )
    )]
    TooFew {
        /// The file.
        file: String,
    },
}
