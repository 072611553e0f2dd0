//! What can be wrong with a table of a specimen.

use miette::Diagnostic;
use stiffbench_units_and_text::count::counted;
use thiserror::Error;

use crate::readings::FileCell;
use crate::table_files::{LinePlace, TableFileError};

/// Why a table of a specimen could not be read.
#[derive(Debug, Error, Diagnostic)]
pub enum SpecimenError {
    /// The table itself: encoding, quotes, number of fields, numbers.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Table(#[from] TableFileError),
    /// A header without a complete row below it.
    #[error("{at}: no complete reading follows the header ({} without a value)", counted(.incomplete, "row"))]
    #[diagnostic(
        code(stiffbench::specimen::no_readings),
        help(
            "a reading needs a value in every named column but those of time, hold and temperature"
        )
    )]
    NoReadings {
        /// Line of the header.
        at: LinePlace,
        /// Rows that were left out.
        incomplete: usize,
    },
    /// Nothing states what unit a column is in.
    #[error("{at}: column `{column}` has no unit, expected one of {accepted}")]
    #[diagnostic(
        code(stiffbench::specimen::no_unit),
        help(
            "name it with --{option}, or at the end of the column's name (force_N, travel_mm, t_s); force and displacement may have --{option} 1, \
             numbers without a unit"
        )
    )]
    NoUnit {
        /// Line of the header.
        at: LinePlace,
        /// The column.
        column: String,
        /// The option that names the unit.
        option: &'static str,
        /// The units of this kind.
        accepted: String,
    },
    /// A unit that is not one of its kind.
    #[error("`{unit}` is not a unit for --{option}, expected one of {accepted}")]
    #[diagnostic(
        code(stiffbench::specimen::wrong_unit),
        help(
            "force and displacement may also have the unit 1: numbers kept as they are in the file"
        )
    )]
    WrongUnit {
        /// The unit that was given.
        unit: String,
        /// The option that names it.
        option: &'static str,
        /// The units of this kind.
        accepted: String,
    },
    /// The unit that the file gives a column is not one of its kind.
    #[error("{at}: column `{column}` is in `{unit}`, expected one of {accepted}")]
    #[diagnostic(
        code(stiffbench::specimen::wrong_column_unit),
        help(
            "is it another column that is meant? Else state the unit with --{option}; force and displacement may have --{option} 1, numbers kept \
             as they are in the file"
        )
    )]
    WrongColumnUnit {
        /// Line of the header.
        at: LinePlace,
        /// The column.
        column: String,
        /// Its unit in the file.
        unit: String,
        /// The option that names the unit.
        option: &'static str,
        /// The units of this kind.
        accepted: String,
    },
    /// The share of the range that makes a turn is not between 0 and 1.
    #[error("a turn share of {share} is not between 0 and 1")]
    #[diagnostic(
        code(stiffbench::specimen::bad_turn_share),
        help(
            "--turn-share is the part of a run's range by which the path must come back, 0.05 unless given"
        )
    )]
    BadTurnShare {
        /// The share that was given.
        share: f64,
    },
    /// A field holds something else than what belongs there.
    #[error("{cell}: `{}`, expected {expected}", .cell.value)]
    #[diagnostic(
        code(stiffbench::specimen::bad_value),
        help("correct the value, or leave the field empty: the row is then left out and listed")
    )]
    BadValue {
        /// The field, with the text found.
        cell: FileCell,
        /// What belongs there.
        expected: &'static str,
    },
}
