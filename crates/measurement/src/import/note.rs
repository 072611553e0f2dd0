//! What an import decided.

use thiserror::Error;

use super::columns::ImportedQuantity;
use super::runs::{CounterDoubt, RunDoubt};
use crate::readings::Assumption;
use crate::table_files::FileLayout;
use stiffbench_units_and_text::count::counted;

/// Something that the file leaves open and the import decided.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ImportNote {
    /// What in the file was taken for what.
    #[error("{0}")]
    Layout(Box<FileLayout>),
    /// No column names poses.
    #[error("no column for the pose: all readings are of {pose} (--pose NAME)")]
    OnePose {
        /// The pose taken.
        pose: String,
    },
    /// Runs were found in the path of the load.
    #[error(
        "no column for the run number: {} found; a run begins where the load is lowest between two loadings, below {:.0} % of the largest",
        counted(.runs, "run"), 100.0 * .share
    )]
    RunsFound {
        /// How many.
        runs: usize,
        /// Share of the largest load below which a run may begin.
        share: f64,
    },
    /// A column that could number the runs or the poses does not.
    #[error(
        "column `{column}` is not used as the {role}: {why}; --map \"{role}={column}\" takes it"
    )]
    NoCounter {
        /// What it could be.
        role: String,
        /// The column.
        column: String,
        /// Why.
        why: CounterDoubt,
    },
    /// Columns of one name that could be used.
    #[error("columns {} and {} are both called `{column}` and are not used: --map {role}={} takes the first", .places[0], .places[1], .places[0])]
    Ambiguous {
        /// Their name.
        column: String,
        /// What they could be.
        role: String,
        /// Their numbers.
        places: [usize; 2],
    },
    /// A column of displacements that is not used.
    #[error(
        "column `{column}` is in {unit} too and is not used: --map displacement={column} takes it instead"
    )]
    UnusedDisplacement {
        /// The column.
        column: String,
        /// Its unit.
        unit: String,
    },
    /// What tells runs apart is no number; they were numbered.
    #[error("the texts in column `{column}` became repeats 1, 2, … in order of appearance")]
    RunsNumbered {
        /// The column.
        column: String,
    },
    /// Unloading was found in the path of the load.
    #[error("unloading: {} after the largest load of a run", counted(.unloading, "reading"))]
    BranchesFound {
        /// Readings while the load is taken off.
        unloading: usize,
    },
    /// Rows with the same joint values became a pose.
    #[error("each set of joint values became a pose: {}", counted(.poses, "pose"))]
    PosesFromJoints {
        /// How many.
        poses: usize,
    },
    /// Joint values without a unit were taken as degrees.
    #[error("joint values have no unit and exceed 2 pi: taken as degrees (--joint-unit)")]
    JointsInDegrees,
    /// Rows without force and displacement.
    #[error("left out: {} without force and displacement, first in line {line}", counted(.rows, "row"))]
    BlankRows {
        /// How many.
        rows: usize,
        /// The first line.
        line: u32,
    },
    /// Readings of the force outside the times of the displacement.
    #[error(
        "left out: {} outside the times of the displacements or in a gap of them, first in line {line}", counted(.rows, "force")
    )]
    NotPaired {
        /// How many.
        rows: usize,
        /// The first line.
        line: u32,
    },
    /// Displacements were interpolated at the times of the forces.
    #[error("displacements were interpolated at the times of the forces: {}", counted(.rows, "value"))]
    Paired {
        /// How many.
        rows: usize,
    },
    /// A column was not read, for an option states its value.
    #[error("{option} applies to all readings: column `{column}` is not read")]
    OptionOverColumn {
        /// The option with its value.
        option: String,
        /// The column.
        column: String,
    },
    /// A unit was stated, and the file states another.
    #[error(
        "the file states {of_file} for column `{column}`, and the options or the mapping {unit}: {unit} is used"
    )]
    UnitOverFile {
        /// The unit that holds.
        unit: String,
        /// The column.
        column: String,
        /// Its unit in the file.
        of_file: String,
    },
    /// Where the runs begin was guessed, and may be guessed wrongly.
    #[error("the runs{}", uncertain(.column.as_deref(), .cell, *.why))]
    RunsUncertain {
        /// The column that numbers them; `None` where they were found in the path of the load.
        column: Option<String>,
        /// The first pose and direction with such runs.
        cell: String,
        /// Why.
        why: RunDoubt,
    },
    /// A column with a few words that recur is not used, and may name poses or directions.
    #[error(
        "column `{column}` is not used and has the words {}: if it names poses or directions, readings of different poses or directions are mixed now; name it with --map pose={column}",
        .words.join(", ")
    )]
    UnusedWords {
        /// The column.
        column: String,
        /// Its words.
        words: Vec<String>,
    },
    /// The sign of a quantity was turned.
    #[error("the sign of every {0} was reversed")]
    Flipped(ImportedQuantity),
    /// The readings of a direction with a minus sign were turned.
    #[error(
        "a direction with a minus sign: force and displacement of its rows were reversed to count along the positive axis"
    )]
    NegativeDirection,
    /// Displacements go against the forces throughout.
    #[error("the displacement goes against the force throughout: its sign was reversed")]
    AgainstForce,
    /// What the reader of readings assumed.
    #[error("{0}")]
    Assumed(Assumption),
}

impl ImportNote {
    /// Whether it puts the result in doubt.
    #[must_use]
    pub fn is_doubt(&self) -> bool {
        matches!(
            self,
            Self::UnitOverFile { .. }
                | Self::RunsUncertain { .. }
                | Self::UnusedWords { .. }
                | Self::AgainstForce
        )
    }
}

/// Of which runs it is uncertain where they begin, and what to do.
fn uncertain(column: Option<&str>, cell: &str, why: RunDoubt) -> String {
    match column {
        None => format!(
            " are uncertain, first in {cell}: {why}; number them in a column and name it with --map repeat=COLUMN"
        ),
        Some(column) => format!(
            " of column `{column}` are uncertain, first in {cell}: {why}; if poses or directions share their numbers, name those columns with --map pose=COLUMN,direction=COLUMN"
        ),
    }
}
