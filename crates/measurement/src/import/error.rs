//! Why a table could not be imported.

use std::fmt;

use miette::Diagnostic;
use thiserror::Error;

use super::columns::MissingPart;
use crate::readings::{FileCell, ReadingsError};
use crate::table_files::{LinePlace, TableFileError};

/// All that is missing, for one message.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MissingParts(pub Vec<MissingPart>);

impl fmt::Display for MissingParts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let words: Vec<String> = self.0.iter().map(ToString::to_string).collect();
        f.write_str(&words.join("; "))
    }
}

/// Why a table could not be imported.
#[derive(Debug, Error, Diagnostic)]
pub enum TableImportError {
    /// The file is no table that can be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Table(#[from] TableFileError),
    /// What was made of the table is refused as readings.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Readings(#[from] ReadingsError),
    /// Something is missing that the file does not state.
    #[error("{at}: missing are {missing}; the columns are {found}")]
    #[diagnostic(code(stiffbench::import::missing))]
    Missing {
        /// Line of the column names.
        at: LinePlace,
        /// All that is missing.
        missing: MissingParts,
        /// The columns, each in backquotes.
        found: String,
        /// The options that state it.
        #[help]
        help: String,
    },
    /// A name that no column can have as its meaning.
    #[error("--map {role}: this is not a quantity of a reading")]
    #[diagnostic(
        code(stiffbench::import::unknown_role),
        help(
            "known are force, displacement, pose, direction, repeat, branch, date, time, temperature, and joint.NAME for joint values; of vectors force_x, \
             moment_x, displacement_x, rotation_x and position_x, and the same along y and z"
        )
    )]
    UnknownRole {
        /// The name.
        role: String,
    },
    /// A unit of another quantity, or no unit.
    #[error("`{unit}` is not a unit of a {quantity}")]
    #[diagnostic(code(stiffbench::import::unit), help("known are {accepted}"))]
    Unit {
        /// The unit.
        unit: String,
        /// The quantity.
        quantity: &'static str,
        /// Units of that quantity.
        accepted: &'static str,
    },
    /// A column without a unit that its quantity has.
    #[error("{at}: column `{column}`, taken as {role}, has no unit of it")]
    #[diagnostic(
        code(stiffbench::import::no_unit),
        help("put the unit behind the name, for example `{column} [UNIT]`: known are {accepted}")
    )]
    NoUnit {
        /// Line of the column names.
        at: LinePlace,
        /// The column.
        column: String,
        /// What it was taken for.
        role: String,
        /// Units of that.
        accepted: &'static str,
    },
    /// A row that lacks one of its values.
    #[error("{cell}: no value{found}")]
    #[diagnostic(
        code(stiffbench::import::no_value),
        help(
            "complete the row, or delete it: rows without any value are left out, incomplete rows are refused"
        )
    )]
    NoValue {
        /// The field.
        cell: FileCell,
        /// What stands there, in words; empty of an empty cell.
        found: String,
    },
    /// A cell that holds something else.
    #[error("{cell}: `{}`, expected {expected}", .cell.value)]
    #[diagnostic(
        code(stiffbench::import::bad_value),
        help("correct the cell, or name another column with --map")
    )]
    BadValue {
        /// The cell, with what stands there.
        cell: FileCell,
        /// What should.
        expected: &'static str,
    },
    /// A column without any value other than zero.
    #[error("{file}, lines {first} to {last}, column `{column}`: all values are 0")]
    #[diagnostic(
        code(stiffbench::import::all_zero),
        help("the gauge was not recorded: name another column with --map {role}=COLUMN")
    )]
    AllZero {
        /// The file.
        file: String,
        /// Its first row.
        first: u32,
        /// Its last row.
        last: u32,
        /// The column.
        column: String,
        /// What it was taken for.
        role: String,
    },
    /// Nothing to import.
    #[error("{at}: no row has a force and a displacement")]
    #[diagnostic(
        code(stiffbench::import::no_rows),
        help("rows of numbers must follow the names of the columns")
    )]
    NoRows {
        /// Line of the column names.
        at: LinePlace,
    },
    /// A mapping file that is none.
    #[error("{file}, line {line}: no mapping: {problem}")]
    #[diagnostic(
        code(stiffbench::import::mapping),
        help("mapping.toml in the folder of an import is one; docs/import.md describes it")
    )]
    Mapping {
        /// The file.
        file: String,
        /// The line.
        line: usize,
        /// What is wrong.
        problem: String,
    },
    /// Two logs without common times.
    #[error("{first} and {second} cannot be paired: {problem}")]
    #[diagnostic(
        code(stiffbench::import::pairs),
        help("both logs need a column of times of the same clock; name it with --map time=COLUMN")
    )]
    Pairs {
        /// The log of the force.
        first: String,
        /// The log of the displacement.
        second: String,
        /// What is wrong.
        problem: &'static str,
    },
}
