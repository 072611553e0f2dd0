//! What a reader took for granted of absent columns, and what it left out.

use std::fmt;

use super::column::Column;
use super::table::ReadingTable;
use stiffbench_units_and_text::count::counted;

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

/// The columns whose absence is worth a word, because a default takes their place or a test falls away.
const MISSED: [Column; 12] = [
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

/// That a column is absent or empty, so that its default was taken.
pub(super) fn absent(column: Column) -> String {
    format!("no values of `{column}`: {}", default_of(column))
}

/// The same of all columns without a value that are worth a word.
pub(crate) fn absent_columns(table: &ReadingTable) -> Vec<String> {
    let missed = MISSED.into_iter().filter(|column| !table.has(*column));
    missed.map(absent).collect()
}

/// A note on some readings: what they are, how many, and the line of the first.
pub(super) fn first_in_line(what: &str, lines: &[u32]) -> Option<String> {
    let line = lines.first()?;
    let readings = counted(lines.len(), "reading");
    Some(format!("{what}: {readings}, first in line {line}"))
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
