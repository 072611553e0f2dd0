//! What the reader decided, and what it left out.

use std::fmt;
use stiffbench_units_and_text::count::counted;

use thiserror::Error;

use super::response::ResponseVariable;
use crate::readings::left_out;
use crate::table_files::FileLayout;

/// Something that the file leaves open and the reader decided.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum SpecimenAssumption {
    /// What in the file was taken for what.
    #[error("{0}")]
    Layout(Box<FileLayout>),
    /// No force column: the load is the same throughout, and all forces are 0.
    #[error("no force column: the load is the same throughout")]
    ConstantLoad,
    /// The quantity that is a ramp or a sine of time was set; the other is the response.
    #[error(
        "the {} is a ramp or a sine of time, or of the order of the readings: it was set, and the {} is the response", .response.set_and_answer()[0], .response.set_and_answer()[1]
    )]
    ResponseByClock {
        /// The quantity that answers.
        response: ResponseVariable,
    },
    /// One quantity scatters more than the other; it is the response.
    #[error(
        "the {} scatters more than the {}, so it is taken for the response: the clock does not show what was set; state otherwise with \
         --response {}", .response.set_and_answer()[1], .response.set_and_answer()[0], .response.set_and_answer()[0]
    )]
    ResponseByScatter {
        /// The quantity that answers.
        response: ResponseVariable,
    },
    /// Nothing shows which quantity was set.
    #[error(
        "loads were set and displacements measured: the table does not show which; state otherwise with --response force"
    )]
    LoadsWereSet,
    /// A unit was taken from the end of a column's name.
    #[error("column `{column}` is in {unit}, by its name")]
    UnitFromName {
        /// The column.
        column: String,
        /// The unit.
        unit: String,
    },
    /// A unit was taken from a row of units, or from the lines above the table.
    #[error("column `{column}` is in {unit}, by the file")]
    UnitFromFile {
        /// The column.
        column: String,
        /// The unit.
        unit: String,
    },
    /// A column holds dates or times of day; they were turned into seconds since the first.
    #[error("column `{column}` holds times: they became seconds since the first")]
    TimeStamps {
        /// The column.
        column: String,
    },
    /// The temperatures have no unit and were taken as °C; their differences are the same in kelvin.
    #[error("temperatures without a unit are °C")]
    TemperatureInCelsius,
    /// No column names specimens or configurations.
    #[error("all readings are of one specimen")]
    OneConfiguration,
    /// No column names runs, so each file, sheet or column of repeats is one.
    #[error("each {column} is a run, with a zero of its own")]
    EachIsARun {
        /// `file`, `sheet` or `series`.
        column: String,
    },
    /// No column names runs, so each configuration is one run.
    #[error("all readings of a specimen are one run, with one zero")]
    OneRunEach,
    /// A column has no value in some rows; they were kept without it.
    #[error(
        "no value of `{column}` in {}, first in line {line}; kept without it", counted(.rows, "row")
    )]
    ValuesAbsent {
        /// The column.
        column: String,
        /// How many rows.
        rows: u32,
        /// The first of their lines.
        line: u32,
    },
    /// Rows were put in the order of the order column.
    #[error("rows were sorted by the order column")]
    Sorted,
    /// Numbers of the order column occur more than once, so the order of the file was kept and numbered.
    #[error(
        "the number in the order column of line {line} occurs before: rows are numbered in the order of the file"
    )]
    OrderNotUsed {
        /// The first line with a number that occurred before.
        line: u32,
    },
    /// The order column starts again in each run; rows were sorted within their runs.
    #[error("the order column starts again in each run: rows were sorted within their runs")]
    SortedWithinRuns,
    /// Within a run, time goes back from one reading to the next; the order was kept.
    #[error(
        "in {} time goes back, first in line {line}; the order of the readings was kept", counted(.runs, "run")
    )]
    TimeGoesBack {
        /// In how many runs.
        runs: u32,
        /// The first line with an earlier time than the one before.
        line: u32,
    },
    /// Branches were derived from the path of the load (or of the displacement, if the force answers).
    #[error(
        "branches are derived from the path: {} and {}, where a turn is a return by more than {} % of the run's range",
        counted(.cycles, "cycle"), counted(.turns, "turn"), (.turn_share * 1e4).round() / 100.0
    )]
    BranchesFromPath {
        /// Share of a run's range by which the path had to come back.
        turn_share: f64,
        /// How many turns were found.
        turns: u32,
        /// How many cycles that makes, each once away and back, over all runs.
        cycles: u32,
    },
    /// The path turns in more than a third of the readings of some runs: taken as shuffled, all of it loading.
    #[error(
        "in {}, the first from line {line}, the path turns in more than a third of the readings: taken as loads in shuffled \
         order, all loading; add a branch column to change this", counted(.runs, "run")
    )]
    Shuffled {
        /// How many runs.
        runs: u32,
        /// Line of the first reading of the first of them.
        line: u32,
    },
    /// A long recording was thinned.
    #[error(
        "{used} of {readings} readings were used: every {every}th of each run, and its turning points; a bad reading between them is not seen"
    )]
    Thinned {
        /// Every how many readings one was used.
        every: u32,
        /// How many were used, turning points among them.
        used: u32,
        /// Of how many.
        readings: u32,
    },
}

/// A row without a value that it must have.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Incomplete {
    /// Its line.
    pub line: u32,
    /// The first column without a value.
    pub column: String,
}

/// Lines that gave no reading: nothing is dropped silently.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ExcludedLines {
    /// Rows without a value that they must have.
    pub incomplete: Vec<Incomplete>,
    /// Lines without any value.
    pub blank: Vec<u32>,
    /// Comment lines.
    pub comments: Vec<u32>,
}

impl fmt::Display for ExcludedLines {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let incomplete = self.incomplete.first().map(|row| row.line);
        let groups = [
            ("incomplete", self.incomplete.len(), incomplete),
            ("blank", self.blank.len(), self.blank.first().copied()),
            (
                "comments",
                self.comments.len(),
                self.comments.first().copied(),
            ),
        ];
        f.write_str(&left_out(&groups))
    }
}
