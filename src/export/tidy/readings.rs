//! Readings and load cases as tidy tables: the columns of the files that hold measurements.

use crate::load_cases::{LoadCaseTable, write_load_cases};
use crate::readings::{Column, ReadingTable, TableError, unescape_formula, write_readings};

use super::table::{FieldKind, TidyColumn, TidyTable};

/// Units at the end of a column's name.
const UNITS: [&str; 14] = [
    "N", "kN", "Nm", "Nmm", "um", "mm", "m", "urad", "mrad", "rad", "deg", "s", "degC", "min",
];

/// The readings of a session; those along the base axes as they stand in their file.
///
/// # Arguments
/// - `origin`: how the readings came about if they were not measured; it stands in every row.
///
/// # Errors
/// [`TableError`] for a number that is not finite.
pub fn reading_table(table: &ReadingTable, origin: Option<&str>) -> Result<TidyTable, TableError> {
    let (names, rows) = if table.is_of_vectors() {
        let rows = table.fields.rows.iter();
        let rows = rows.map(|row| row.fields.clone()).collect();
        (table.fields.names.clone(), rows)
    } else {
        along_load(table, origin)?
    };
    Ok(TidyTable::new(
        "readings",
        "One reading of the gauges under one load",
        names.into_iter().map(named_column).collect(),
        rows,
    ))
}

/// Heads and rows of readings along the load.
fn along_load(
    table: &ReadingTable,
    origin: Option<&str>,
) -> Result<(Vec<String>, Vec<Vec<String>>), TableError> {
    let mut marked = table.clone();
    marked.origin = origin.map(str::to_owned);
    for key in marked.runs.iter_mut().chain(&mut marked.zeros) {
        let repeat = key.repeat;
        key.label.get_or_insert_with(|| repeat.to_string().into());
    }
    let mut text = Vec::new();
    write_readings(&marked, &mut text)?;
    Ok(fields(&text))
}

/// Load cases.
#[must_use]
pub fn load_case_table(table: &LoadCaseTable) -> TidyTable {
    let (names, rows) = fields(write_load_cases(table).as_bytes());
    TidyTable::new(
        "load-cases",
        "One load application in one pose",
        names.into_iter().map(named_column).collect(),
        rows,
    )
}

/// Heads and rows of a table that this program wrote.
fn fields(text: &[u8]) -> (Vec<String>, Vec<Vec<String>>) {
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .comment(Some(b'#'))
        .from_reader(text);
    let owned = |record: csv::StringRecord| {
        let texts = record.iter().map(unescape_formula);
        texts.map(str::to_owned).collect()
    };
    let mut records = reader.records().flatten().map(owned);
    let heads = records.next().unwrap_or_default();
    (heads, records.collect())
}

/// A column, its kind, unit and meaning by its name.
fn named_column(name: String) -> TidyColumn {
    let end = name.rsplit_once('_').map_or("", |(_, unit)| unit);
    let unit = UNITS.into_iter().find(|unit| *unit == end).unwrap_or("");
    let kind = match name.as_str() {
        "seq" | "step" | "repeat" | "attempt" => FieldKind::Integer,
        "utc" => FieldKind::DateTime,
        _ if unit.is_empty() => FieldKind::Text,
        _ => FieldKind::Number,
    };
    TidyColumn {
        unit: unit.to_owned(),
        kind,
        meaning: vector_meaning(&name),
        name,
    }
}

/// What a column of `readings.csv` means.
fn meaning_of(column: Column) -> &'static str {
    match column {
        Column::Session => "Session",
        Column::Seq => "Sequence number of the reading",
        Column::Utc => "Time of the reading, UTC",
        Column::Time => "Time since the session began",
        Column::Pose => "Pose of the robot",
        Column::Direction => "Direction of the load: x, y or z of the robot's base",
        Column::Branch => "Loading or unloading",
        Column::Step => "Place in the load sequence, from 0",
        Column::Target => "Target force",
        Column::Repeat => "Application of the same load or sequence, from 1",
        Column::Attempt => "Attempt at this reading, from 1",
        Column::Run => "Run within its pose and direction: readings with one history",
        Column::Zero => "Gauge zero within its pose and direction",
        Column::Force => "Force on the end, along the positive axis",
        Column::ForceRaw => "Raw text of the force gauge",
        Column::ForceZero => "Value of the force gauge without load; it is subtracted",
        Column::Displacement => "Displacement of the end, along the positive axis",
        Column::DisplacementRaw => "Raw text of the displacement gauge",
        Column::DisplacementZero => {
            "Value of the displacement gauge under the preload; it is subtracted"
        }
        Column::Hold => "Time under this load before the reading",
        Column::Temperature => "Temperature",
        Column::Status => "accepted, superseded or rejected; only accepted readings are analysed",
        Column::Flag => "Rule that the reading breaks, and the reason",
        Column::Note => "Note of the operator",
        Column::Origin => "How the reading came about; it was not measured",
    }
}

/// What a column of vectors means.
fn vector_meaning(name: &str) -> String {
    let known = Column::ALL.into_iter().find(|column| column.name() == name);
    if let Some(column) = known {
        return meaning_of(column).to_owned();
    }
    if let Some(joint) = name.strip_prefix("joint_") {
        let variable = joint
            .rsplit_once('_')
            .map_or(joint, |(variable, _)| variable);
        return format!("Value of the joint variable {variable}");
    }
    let mut words = name.split('_');
    let (quantity, axis) = (words.next().unwrap_or(name), words.next().unwrap_or(""));
    let more = if name.ends_with("_raw") {
        ", text of the gauge"
    } else if name.contains("_zero") {
        ", value that is subtracted"
    } else {
        ""
    };
    match (quantity, axis) {
        ("force" | "moment" | "displacement" | "rotation" | "position", "x" | "y" | "z") => {
            format!("Component of the {quantity} along {axis}{more}")
        }
        ("axes", _) => "Axes of the components".to_owned(),
        _ => name.replace('_', " "),
    }
}
