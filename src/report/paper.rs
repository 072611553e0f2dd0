//! Printed cells of the paper's tables. They live in `data/paper/tables.csv`.

use crate::test_point::Direction;

/// The transcribed tables.
const TABLES: &str = include_str!("../../data/paper/tables.csv");

/// One transcribed row.
#[derive(Debug, serde::Deserialize)]
pub struct Printed {
    /// Number of the table.
    pub table: String,
    /// Mechanism or model of the column.
    pub mechanism_or_model: String,
    /// Direction in the paper's words.
    pub physical_direction: String,
    /// Pose.
    pub pose: String,
    /// What is printed.
    pub quantity: String,
    /// Its unit.
    pub unit: String,
    /// Its value.
    pub value: f64,
}

/// All transcribed rows.
#[must_use]
pub fn printed_rows() -> Vec<Printed> {
    csv::Reader::from_reader(TABLES.as_bytes())
        .deserialize()
        .collect::<Result<_, _>>()
        .expect("the shipped transcription is a table of this form, which a test holds")
}

/// Global axis of a word of the tables.
#[must_use]
pub fn direction(word: &str) -> Option<Direction> {
    match word {
        "lateral" => Some(Direction::X),
        "vertical" => Some(Direction::Y),
        "radial" => Some(Direction::Z),
        _ => None,
    }
}
