//! What a reader took for granted, left out, or noticed.

use std::fmt;

use super::column::Column;
use super::number::DecimalSign;
use super::rows::Delimiter;
use stiffbench_units_and_text::count::counted;
use stiffbench_units_and_text::test_point::Cell;

/// Something that the file leaves open and the reader decided.
#[derive(Debug, Clone, PartialEq)]
pub enum Assumption {
    /// A UTF-8 byte order mark was taken off.
    ByteOrderMark,
    /// The text is UTF-16.
    Utf16,
    /// Lines end with a carriage return alone.
    LoneCarriageReturn,
    /// Some text is not UTF-8; its bytes were taken as ISO 8859-1.
    NotUtf8 {
        /// First line with such text.
        line: u32,
    },
    /// Fields are not delimited by a comma.
    Delimiter(Delimiter),
    /// Numbers have a decimal comma.
    DecimalComma {
        /// First line with one; 0 if the caller stated it.
        line: u32,
    },
    /// A column has another unit than the one it is written in.
    UnitConverted {
        /// The column.
        column: Column,
        /// Its name in the file.
        found: String,
    },
    /// A column is absent or empty, so its default was taken.
    ColumnAbsent(Column),
    /// The forces lie near the multiples of a load step, which were taken as targets.
    TargetsAreMultiples {
        /// The load step, N.
        load_step_n: f64,
        /// Readings that lie near none; their own force is their target.
        off_grid: u32,
    },
    /// The forces have no common load step; the target of a reading is its own force.
    TargetsAreForces,
    /// Forces without a common load step that are one load have their mean for a target.
    TargetsAreMeans,
    /// Loads that go down again were taken as unloading.
    DescendingIsUnloading {
        /// How many readings.
        readings: u32,
        /// First of their lines.
        line: u32,
    },
    /// In some runs the load goes up again after it went down; what goes down was taken as unloading all the same.
    LoadGoesUpAgain {
        /// How many runs.
        runs: u32,
    },
    /// Rows stand in another order than their sequence numbers; the numbers were followed.
    SortedBySequence,
    /// Sequence numbers occur more than once, so the rows were numbered in the order of the file.
    SequenceNotUsed,
    /// Times were computed from UTC, from the first reading on.
    TimeFromUtc,
    /// A row repeats an earlier one of its run word for word; without a `step` column both are taken as readings.
    RepeatedRow {
        /// The later line.
        line: u32,
        /// The earlier line.
        first_line: u32,
    },
}

impl fmt::Display for Assumption {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::ByteOrderMark => f.write_str("a byte order mark was taken off"),
            Self::Utf16 => f.write_str("the text is UTF-16"),
            Self::LoneCarriageReturn => f.write_str("lines end with a carriage return"),
            Self::NotUtf8 { line } => {
                write!(f, "text that is not UTF-8 was taken as ISO 8859-1, first in line {line}")
            }
            Self::Delimiter(delimiter) => write!(f, "fields are delimited by a {}", delimiter.word()),
            Self::DecimalComma { line: 0 } => f.write_str("numbers have a decimal comma"),
            Self::DecimalComma { line } => write!(f, "numbers have a decimal comma, as in line {line}"),
            Self::UnitConverted { column, found } => write!(f, "column `{found}` was converted to {}", column.unit()),
            Self::ColumnAbsent(column) => write!(f, "no values of `{column}`: {}", default_of(*column)),
            Self::TargetsAreMultiples { load_step_n, off_grid: 0 } => {
                write!(f, "target loads are the multiples of {load_step_n} N nearest to the forces")
            }
            Self::TargetsAreMultiples { load_step_n, off_grid } => write!(
                f,
                "target loads are the multiples of {load_step_n} N nearest to the forces; near no multiple, so that the force is the target: {}",
                counted(off_grid, "reading")
            ),
            Self::TargetsAreForces => f.write_str(
                "the forces have no common load step: each force is its own target",
            ),
            Self::TargetsAreMeans => f.write_str(
                "where all forces of a pose and direction, or of a run, differ by no more than 5 %, they are one load, and its target is their mean",
            ),
            Self::DescendingIsUnloading { readings, line } => {
                let readings = counted(readings, "reading");
                write!(f, "loads that go down again are taken as unloading: {readings}, first in line {line}")
            }
            Self::LoadGoesUpAgain { runs } => write!(
                f,
                "in {} the load goes up again after it went down: if the loads were shuffled, add a column `branch`",
                counted(runs, "run")
            ),
            Self::SortedBySequence => f.write_str("rows were sorted by `seq`"),
            Self::SequenceNotUsed => {
                f.write_str("numbers under `seq` occur more than once; rows are numbered in the order of the file")
            }
            Self::TimeFromUtc => f.write_str("times are seconds since the first `utc`"),
            Self::RepeatedRow { line, first_line } => write!(
                f,
                "line {line} repeats line {first_line} word for word; both are kept as separate readings"
            ),
        }
    }
}

/// The default of an absent column, and what cannot be tested without it.
fn default_of(column: Column) -> &'static str {
    match column {
        Column::Seq => "readings are numbered in the order of the file",
        Column::Branch => "loads that do not go down are loading",
        Column::Step => "a reading's step is its place within its run",
        Column::Target => "the target load is derived from the force",
        Column::Attempt => "every reading is the first attempt",
        Column::Status => "every reading is accepted",
        Column::Run => "each pose, direction and repeat is a separate run",
        Column::Zero => "the gauge was zeroed for each pose, direction and repeat",
        Column::ForceZero => {
            "it is not known whether the force is corrected for the unloaded indication"
        }
        Column::Time => "drift with time cannot be tested",
        Column::Hold => "creep cannot be tested",
        Column::Temperature => "drift with temperature cannot be tested",
        _ => "left empty",
    }
}

impl Assumption {
    /// The columns whose absence is worth a word, because a default takes their place or a test falls away.
    pub(super) const MISSED: [Column; 12] = [
        Column::Seq,
        Column::Branch,
        Column::Step,
        Column::Target,
        Column::Attempt,
        Column::Run,
        Column::Zero,
        Column::ForceZero,
        Column::Time,
        Column::Hold,
        Column::Temperature,
        Column::Status,
    ];

    pub(crate) fn decimal_comma(sign: Option<DecimalSign>, line: Option<u32>) -> Option<Self> {
        match (sign, line) {
            (Some(DecimalSign::Comma), _) => Some(Self::DecimalComma { line: 0 }),
            (_, Some(line)) => Some(Self::DecimalComma { line }),
            _ => None,
        }
    }
}

/// Something about a table that an analysis should know.
#[derive(Debug, Clone, PartialEq)]
pub enum AssumptionNote {
    /// A column that means nothing here; its values are not in the table.
    UnusedColumn(String),
    /// A cell measured once, so that the scatter between repeats cannot be determined.
    OneRepeat(Cell),
    /// A cell without a force other than zero, which has no stiffness.
    NoLoad(Cell),
    /// Readings with exactly zero force where a load was aimed at.
    ZeroForceAtTarget {
        /// How many.
        readings: u32,
        /// First of their lines.
        line: u32,
    },
    /// Readings that stand in the table more than once.
    DuplicateRows {
        /// How many repeat an earlier one.
        readings: u32,
        /// First of their lines.
        line: u32,
    },
}

impl fmt::Display for AssumptionNote {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnusedColumn(name) => write!(f, "column `{name}` is not used"),
            Self::OneRepeat(cell) => write!(
                f,
                "{cell} has one repeat: the scatter between repeats is unknown"
            ),
            Self::NoLoad(cell) => write!(
                f,
                "{cell} has no force other than zero, so it has no stiffness"
            ),
            Self::ZeroForceAtTarget { readings, line } => write!(
                f,
                "zero force at a target load other than zero: {}, first in line {line}",
                counted(readings, "reading")
            ),
            Self::DuplicateRows { readings, line } => write!(
                f,
                "identical in every number to an earlier row of the same run: {}, first in line {line}; was part of the file pasted twice?",
                counted(readings, "reading")
            ),
        }
    }
}

/// What a table holds that does not count, by line: nothing is dropped silently.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Excluded {
    /// Readings taken again later.
    pub superseded: Vec<u32>,
    /// Readings refused by the operator or a rule.
    pub rejected: Vec<u32>,
    /// Lines without a value.
    pub blank: Vec<u32>,
    /// Comment lines.
    pub comments: Vec<u32>,
}

impl fmt::Display for Excluded {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let groups = [
            ("superseded", &self.superseded),
            ("rejected", &self.rejected),
            ("blank", &self.blank),
            ("comments", &self.comments),
        ];
        let groups = groups.map(|(word, lines)| (word, lines.len(), lines.first().copied()));
        f.write_str(&left_out(&groups))
    }
}

/// Groups of lines that gave no reading: a word, how many, and the first.
pub(crate) fn left_out(groups: &[(&str, usize, Option<u32>)]) -> String {
    let said = groups.iter().filter_map(|(word, count, first)| {
        Some(format!("{word}: {count} (first in line {})", (*first)?))
    });
    let said: Vec<String> = said.collect();
    if said.is_empty() {
        return "every line was read".to_owned();
    }
    said.join("; ")
}
