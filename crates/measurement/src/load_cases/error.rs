//! What can be wrong with a table of load cases.

use miette::Diagnostic;
use thiserror::Error;

use crate::readings::ReadingsError;
use crate::table_files::LinePlace;

/// Why a table of load cases could not be read.
#[derive(Debug, Error, Diagnostic)]
pub enum LoadCaseError {
    /// The text, its records or its numbers.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Text(#[from] ReadingsError),
    /// A kind of column that must be there is not.
    #[error("{at}: no column of {what} among {found}")]
    #[diagnostic(code(stiffbench::load_cases::missing_column))]
    MissingColumn {
        /// Line of the header.
        at: LinePlace,
        /// What is missing.
        what: &'static str,
        /// The names found, each in backquotes.
        found: String,
        /// What to add.
        #[help]
        advice: &'static str,
    },
    /// A column that only a series of readings has.
    #[error(
        "{at}: column `{column}` beside columns of vectors such as `{vector}`: the file mixes two forms"
    )]
    #[diagnostic(
        code(stiffbench::load_cases::mixed),
        help(
            "a load case has its load and what was read as vectors: write force_x_N and displacement_x_um (or y, z) for force_N and displacement_um, and leave direction out"
        )
    )]
    Mixed {
        /// Line of the header.
        at: LinePlace,
        /// The column of a series of readings.
        column: String,
        /// A column of vectors.
        vector: String,
    },
    /// Columns of positions beside those of displacements.
    #[error(
        "{at}: column `{position}` beside column `{displacement}`: absolute positions and displacements under a load are two tables"
    )]
    #[diagnostic(
        code(stiffbench::load_cases::positions_and_displacements),
        help("put the positions, with their loads, into a separate table")
    )]
    PositionsAndDisplacements {
        /// Line of the header.
        at: LinePlace,
        /// A column of positions.
        position: String,
        /// A column of displacements or rotations.
        displacement: String,
    },
    /// A load case without a load.
    #[error("{at}: force and moment are zero")]
    #[diagnostic(
        code(stiffbench::load_cases::no_load),
        help(
            "a load case is the change from the unloaded state: leave out the row, or mark it `rejected` under `status`"
        )
    )]
    NoLoad {
        /// The line.
        at: LinePlace,
    },
    /// A load case of which nothing was read.
    #[error("{at}: no component of displacement, rotation or position")]
    #[diagnostic(
        code(stiffbench::load_cases::nothing_read),
        help("fill at least one component, or mark the row `rejected` under `status`")
    )]
    NothingRead {
        /// The line.
        at: LinePlace,
    },
}
