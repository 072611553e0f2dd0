//! What the reader decided, and what it left out.

use std::fmt;

use crate::readings::left_out;
use crate::table_files::FileLayout;

/// Something that the file leaves open and the reader decided.
#[derive(Debug, Clone, PartialEq)]
pub enum SpecimenAssumption {
    /// What in the file was taken for what.
    Layout(Box<FileLayout>),
    /// No force column: the load is the same throughout, and all forces are 0.
    ConstantLoad,
    /// A unit was taken from the end of a column's name.
    UnitFromName {
        /// The column.
        column: String,
        /// The unit.
        unit: String,
    },
    /// A unit was taken from a row of units, or from the lines above the table.
    UnitFromFile {
        /// The column.
        column: String,
        /// The unit.
        unit: String,
    },
    /// A column holds dates or times of day; they were turned into seconds since the first.
    TimeStamps {
        /// The column.
        column: String,
    },
    /// The temperatures have no unit and were taken as °C; their differences are the same in kelvin.
    TemperatureInCelsius,
    /// No column names specimens or configurations.
    OneConfiguration,
    /// No column names runs, so each configuration is one run.
    OneRunEach,
    /// A column has no value in some rows; they were kept without it.
    ValuesAbsent {
        /// The column.
        column: String,
        /// How many rows.
        rows: u32,
        /// The first of their lines.
        line: u32,
    },
    /// Rows were put in the order of the order column.
    Sorted,
    /// Numbers of the order column occur more than once, so the order of the file was kept and numbered.
    OrderNotUsed {
        /// The first line with a number that occurred before.
        line: u32,
    },
    /// The order column starts again in each run; rows were sorted within their runs.
    SortedWithinRuns,
    /// Within a run, time goes back from one reading to the next; the order was kept.
    TimeGoesBack {
        /// In how many runs.
        runs: u32,
        /// The first line with an earlier time than the one before.
        line: u32,
    },
    /// Branches were derived from the path of the load (or of the displacement, if the force answers).
    BranchesFromPath {
        /// Share of a run's range by which the path had to come back.
        turn_share: f64,
        /// How many turns were found.
        turns: u32,
        /// How many cycles that makes, each once away and back, over all runs.
        cycles: u32,
    },
    /// The path turns in more than a third of the readings of some runs: taken as shuffled, all of it loading.
    Shuffled {
        /// How many runs.
        runs: u32,
        /// Line of the first reading of the first of them.
        line: u32,
    },
    /// A long recording was thinned.
    Thinned {
        /// Every how many readings one was used.
        every: u32,
        /// How many were used, turning points among them.
        used: u32,
        /// Of how many.
        readings: u32,
    },
}

impl fmt::Display for SpecimenAssumption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Layout(layout) => layout.fmt(f),
            Self::ConstantLoad => f.write_str("no force column: the load is the same throughout"),
            Self::UnitFromName { column, unit } => write!(f, "column `{column}` is in {unit}, by its name"),
            Self::UnitFromFile { column, unit } => write!(f, "column `{column}` is in {unit}, by the file"),
            Self::TimeStamps { column } => {
                write!(f, "column `{column}` holds times: they became seconds since the first")
            }
            Self::TemperatureInCelsius => f.write_str("temperatures without a unit are °C"),
            Self::OneConfiguration => f.write_str("all readings are of one specimen"),
            Self::OneRunEach => f.write_str("all readings of a specimen are one run, with one zero"),
            Self::ValuesAbsent { column, rows, line } => {
                write!(f, "no value of `{column}` in {rows} rows, first in line {line}; they are kept without it")
            }
            Self::Sorted => f.write_str("rows were put in the order of the order column"),
            Self::OrderNotUsed { line } => write!(
                f,
                "the number in the order column of line {line} occurs before: rows are numbered in the order of the file"
            ),
            Self::SortedWithinRuns => {
                f.write_str("the order column starts again in each run: rows were put in order within their runs")
            }
            Self::TimeGoesBack { runs, line } => {
                write!(f, "in {runs} runs time goes back, first in line {line}; the order of the readings was kept")
            }
            Self::BranchesFromPath { turn_share, turns, cycles } => write!(
                f,
                "branches are derived from the path: it has {cycles} cycles, {turns} turns, a turn being a return by more than {} % of the run's range",
                (turn_share * 1e4).round() / 100.0
            ),
            Self::Shuffled { runs, line } => write!(
                f,
                "in {runs} runs, the first from line {line}, the path turns in more than a third of the readings: taken as loads in shuffled \
                 order, all loading; add a branch column to change this"
            ),
            Self::Thinned { every, used, readings } => write!(
                f,
                "{used} of {readings} readings were used: every {every}th of each run, and its turning points; a bad reading between them is not seen"
            ),
        }
    }
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
