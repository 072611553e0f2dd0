//! What an import decided.

use std::fmt;

use super::runs::RunDoubt;
use crate::readings::Assumption;
use crate::table_files::FileLayout;
use stiffbench_units_and_text::count::counted;

/// Something that the file leaves open and the import decided.
#[derive(Debug, Clone, PartialEq)]
pub enum ImportNote {
    /// What in the file was taken for what.
    Layout(Box<FileLayout>),
    /// No column names poses.
    OnePose {
        /// The pose taken.
        pose: String,
    },
    /// Runs were found in the path of the load.
    RunsFound {
        /// How many.
        runs: usize,
        /// Share of the largest load below which a run may begin.
        share: f64,
    },
    /// What tells runs apart is no number; they were numbered.
    RunsNumbered {
        /// The column.
        column: String,
    },
    /// Unloading was found in the path of the load.
    BranchesFound {
        /// Readings while the load is taken off.
        unloading: usize,
    },
    /// Rows with the same joint values became a pose.
    PosesFromJoints {
        /// How many.
        poses: usize,
    },
    /// Joint values without a unit were taken as degrees.
    JointsInDegrees,
    /// Rows without force and displacement.
    BlankRows {
        /// How many.
        rows: usize,
        /// The first line.
        line: u32,
    },
    /// Readings of the force outside the times of the displacement.
    NotPaired {
        /// How many.
        rows: usize,
        /// The first line.
        line: u32,
    },
    /// Displacements were interpolated at the times of the forces.
    Paired {
        /// How many.
        rows: usize,
    },
    /// A column was not read, for an option states its value.
    OptionOverColumn {
        /// The option with its value.
        option: String,
        /// The column.
        column: String,
    },
    /// A unit was stated, and the file states another.
    UnitOverFile {
        /// The unit that holds.
        unit: String,
        /// The column.
        column: String,
        /// Its unit in the file.
        of_file: String,
    },
    /// Where the runs begin was guessed, and may be guessed wrongly.
    RunsUncertain {
        /// The column that numbers them; `None` where they were found in the path of the load.
        column: Option<String>,
        /// The first pose and direction with such runs.
        cell: String,
        /// Why.
        why: RunDoubt,
    },
    /// A column with a few words that recur is not used, and may name poses or directions.
    UnusedWords {
        /// The column.
        column: String,
        /// Its words.
        words: Vec<String>,
    },
    /// The sign of a quantity was turned.
    Flipped {
        /// `force` or `displacement`.
        what: &'static str,
    },
    /// The readings of a direction with a minus sign were turned.
    NegativeDirection,
    /// Displacements go against the forces throughout.
    AgainstForce,
    /// What the reader of readings assumed.
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

impl fmt::Display for ImportNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Layout(layout) => layout.fmt(f),
            Self::OnePose { pose } => {
                write!(f, "no column names poses: all readings are of {pose} (--pose NAME)")
            }
            Self::RunsFound { runs, share } => write!(
                f,
                "no column numbers runs: {} found; a run begins where the load is lowest between two loadings, below {:.0} % of the largest",
                counted(runs, "run"),
                100.0 * share
            ),
            Self::RunsNumbered { column } => {
                write!(f, "the texts in column `{column}` became repeats 1, 2, … in the order in which they appear")
            }
            Self::BranchesFound { unloading } => {
                write!(f, "unloading: {} after the largest load of a run", counted(unloading, "reading"))
            }
            Self::PosesFromJoints { poses } => {
                write!(f, "rows with the same joint values became a pose each: {}", counted(poses, "pose"))
            }
            Self::JointsInDegrees => f.write_str("joint values have no unit and exceed 2 pi: taken as degrees (--joint-unit)"),
            Self::BlankRows { rows, line } => {
                write!(f, "left out: {} without force and displacement, first in line {line}", counted(rows, "row"))
            }
            Self::NotPaired { rows, line } => write!(
                f,
                "{rows} forces lie outside the times of the displacements, or in a gap of them, and are left out, first in line {line}"
            ),
            Self::Paired { rows } => {
                write!(f, "{rows} displacements were interpolated at the times of the forces")
            }
            Self::OptionOverColumn { option, column } => {
                write!(f, "{option} holds for all readings: column `{column}` is not read")
            }
            Self::UnitOverFile {
                unit,
                column,
                of_file,
            } => write!(
                f,
                "the file states {of_file} for column `{column}`, and the options or the mapping {unit}: {unit} holds"
            ),
            Self::RunsUncertain { column: None, cell, why } => write!(
                f,
                "the runs are uncertain, first in {cell}: {why}; number them in a column and name it with --map repeat=COLUMN"
            ),
            Self::RunsUncertain { column: Some(column), cell, why } => write!(
                f,
                "the runs of column `{column}` are uncertain, first in {cell}: {why}; if poses or directions share their numbers, name those columns with --map pose=COLUMN,direction=COLUMN"
            ),
            Self::UnusedWords { column, words } => write!(
                f,
                "column `{column}` is not used and has the words {}: if it names poses or directions, readings of different ones are mixed now; name it with --map pose={column}",
                words.join(", ")
            ),
            Self::Flipped { what } => write!(f, "the sign of every {what} was turned"),
            Self::NegativeDirection => f.write_str(
                "a direction with a minus sign: force and displacement of its rows were turned to count along the positive axis",
            ),
            Self::AgainstForce => f.write_str(
                "the displacement goes against the force throughout; if one gauge counts the other way, import again with --flip displacement",
            ),
            Self::Assumed(assumption) => assumption.fmt(f),
        }
    }
}
