//! Reads `readings.csv` of sessions with displacement gauges along the base axes.

use std::io::Read;

use super::column::split_unit;
use super::csv::ReadOptions;
use super::error::ReadingsError;
use super::joint_values::{JointColumn, JointUnit, PlacedJointColumn};
use super::number::{Conversion, read_count};
use super::reading::ReadingStatus;
use super::text_table::RecordTable;
use super::vector_reading::{BASE_AXES, VectorReading};
use stiffbench_units_and_text::quantity::Kind;
use stiffbench_units_and_text::test_point::{Branch, PoseId};

/// Columns without which a table is none of a session with gauges along the base axes.
const NEEDED: [&str; 11] = [
    "seq",
    "pose",
    "direction",
    "branch",
    "step",
    "repeat",
    "run",
    "zero_id",
    "force_x_N",
    "force_y_N",
    "force_z_N",
];

/// Displacement columns, of which at least one has values.
const DISPLACEMENTS: [&str; 3] = [
    "displacement_x_um",
    "displacement_y_um",
    "displacement_z_um",
];

/// A table of readings of vectors, with its fields as they stand in the file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct VectorTable {
    /// The file, as the caller named it.
    pub source: String,
    /// How the readings came about if they were not measured.
    pub origin: Option<String>,
    /// Column names.
    pub names: Vec<String>,
    /// The columns of joint values.
    pub joints: Vec<JointColumn>,
    /// The fields of each reading, in the order of `readings`.
    pub rows: Vec<Vec<String>>,
    /// The readings.
    pub readings: Vec<VectorReading>,
}

impl VectorTable {
    /// The readings that count.
    pub fn accepted(&self) -> impl Iterator<Item = &VectorReading> {
        let readings = self.readings.iter();
        readings.filter(|reading| reading.status == ReadingStatus::Accepted)
    }
}

/// Whether a table has the columns of a session with gauges along the base axes; a text that is no table has not.
#[must_use]
pub fn is_vector_table(bytes: &[u8]) -> bool {
    let names = RecordTable::names_of(bytes);
    let mut needed = NEEDED.iter();
    needed.all(|needed| names.iter().any(|name| name == needed))
}

/// Reads the table that [`super::VectorReadingsWriter`] writes.
///
/// # Errors
/// [`ReadingsError`] with line, column, value and what was expected, for the first thing that is wrong.
pub fn read_vector_readings(source: &str, input: impl Read) -> Result<VectorTable, ReadingsError> {
    let mut text = RecordTable::open(source, input, ReadOptions::default())?;
    if !text.next_header()? {
        return Err(ReadingsError::Empty {
            file: source.to_owned(),
        });
    }
    let mut table = VectorTable {
        source: source.to_owned(),
        names: text.names.clone(),
        ..VectorTable::default()
    };
    for column in NEEDED {
        if !table.names.iter().any(|name| name == column) {
            return Err(ReadingsError::MissingColumn {
                file: source.to_owned(),
                line: text.header_line,
                column,
                others: String::new(),
                found: table.names.join(", "),
                advice:
                    "take the readings.csv of a session with displacement gauges along base axes"
                        .to_owned(),
            });
        }
    }
    let joints = joint_columns(&text)?;
    table.joints = joints.iter().map(|joint| joint.column.clone()).collect();
    while text.next_record()? {
        let mut row = VectorRow {
            text: &mut text,
            joints: &joints,
        };
        let reading = row.reading()?;
        table.origin = table
            .origin
            .or_else(|| Some(row.text_of("origin")).filter(|of| !of.is_empty()));
        let fields = (0..table.names.len()).map(|at| text.text(text.field(at)).into_owned());
        table.rows.push(fields.collect());
        table.readings.push(reading);
    }
    if table.readings.is_empty() {
        return Err(ReadingsError::NoReadings {
            file: source.to_owned(),
            line: text.header_line,
        });
    }
    Ok(table)
}

/// The columns `joint_VARIABLE_UNIT`.
fn joint_columns(text: &RecordTable<'_>) -> Result<Vec<PlacedJointColumn>, ReadingsError> {
    let mut columns = Vec::new();
    for (index, name) in text.names.iter().enumerate() {
        let Some(named) = name.strip_prefix("joint_") else {
            continue;
        };
        let (variable, unit) = split_unit(named).unwrap_or((named, ""));
        let Some(known) = JointUnit::of(unit).filter(|_| !variable.is_empty()) else {
            return Err(ReadingsError::WrongUnit {
                file: text.file(),
                line: text.header_line,
                column: name.clone(),
                unit: format!("`{unit}`"),
                accepted: "deg, rad; of a sliding joint mm, m",
            });
        };
        PlacedJointColumn::add(&mut columns, text, index, variable, known)?;
    }
    Ok(columns)
}

/// The current record.
struct VectorRow<'t, 'a> {
    text: &'t mut RecordTable<'a>,
    joints: &'t [PlacedJointColumn],
}

impl VectorRow<'_, '_> {
    fn reading(&mut self) -> Result<VectorReading, ReadingsError> {
        let mut force_n = [0.0; 3];
        for (part, column) in force_n
            .iter_mut()
            .zip(["force_x_N", "force_y_N", "force_z_N"])
        {
            *part = self
                .number(column, Conversion::NONE)?
                .ok_or_else(|| self.missing(column, "a number"))?;
        }
        let axes = self.text_of("axes");
        if !matches!(axes.as_str(), "" | BASE_AXES) {
            return Err(self.bad("axes", "`base`"));
        }
        let displacement_m = self.micrometres(DISPLACEMENTS)?;
        if displacement_m == [None; 3] {
            return Err(self.missing(DISPLACEMENTS[0], "a displacement along x, y or z"));
        }
        let raw = [
            "displacement_x_raw",
            "displacement_y_raw",
            "displacement_z_raw",
        ];
        let zeros = [
            "displacement_x_zero_um",
            "displacement_y_zero_um",
            "displacement_z_zero_um",
        ];
        let displacement_zero_m = self.micrometres(zeros)?;
        let mut joints = Vec::with_capacity(self.joints.len());
        for joint in self.joints {
            let value = self.number_at(joint.index, joint.conversion)?;
            joints.push(value);
        }
        let pose = self.text_of("pose");
        if pose.is_empty() {
            return Err(self.missing("pose", "the name of a pose"));
        }
        Ok(VectorReading {
            line: self.text.line,
            seq: self.count("seq")?,
            pose: PoseId::new(&pose),
            direction: self.text_of("direction"),
            branch: match self.text_of("branch").as_str() {
                "" | "loading" => Branch::Loading,
                "unloading" => Branch::Unloading,
                _ => return Err(self.bad("branch", "`loading` or `unloading`")),
            },
            step: self.count("step")?,
            repeat: self.count("repeat")?,
            attempt: self.count("attempt")?,
            status: match self.text_of("status").as_str() {
                "" | "accepted" => ReadingStatus::Accepted,
                "superseded" => ReadingStatus::Superseded,
                "rejected" => ReadingStatus::Rejected,
                _ => return Err(self.bad("status", "`accepted`, `superseded` or `rejected`")),
            },
            target_n: self.number("target_N", Conversion::NONE)?.unwrap_or(0.0),
            joints,
            force_n,
            displacement_m,
            run: self.text_of("run"),
            zero: self.text_of("zero_id"),
            time_s: self.number("t_s", Conversion::NONE)?,
            hold_s: self.number("hold_s", Conversion::NONE)?,
            temperature_deg_c: self.number("temp_degC", Conversion::NONE)?,
            utc: self.text_of("utc"),
            force_raw: self.text_of("force_raw"),
            force_zero_n: self.number("force_zero_N", Conversion::NONE)?,
            displacement_raw: raw.map(|column| self.text_of(column)),
            displacement_zero_m,
            flag: self.text_of("flag"),
            note: self.text_of("note"),
        })
    }

    /// Displacements in SI, one of each column.
    fn micrometres(&mut self, columns: [&str; 3]) -> Result<[Option<f64>; 3], ReadingsError> {
        let um = Conversion::from_unit(Kind::Displacement, "um").unwrap_or(Conversion::NONE);
        let mut parts = [None; 3];
        for (part, column) in parts.iter_mut().zip(columns) {
            *part = self.number(column, um)?;
        }
        Ok(parts)
    }

    fn index(&self, column: &str) -> Option<usize> {
        self.text.names.iter().position(|name| name == column)
    }

    /// A field without blanks around it; empty without the column.
    fn text_of(&self, column: &str) -> String {
        let index = self.index(column);
        index.map_or_else(String::new, |at| {
            self.text.text(self.text.field(at)).into_owned()
        })
    }

    fn number(
        &mut self,
        column: &str,
        conversion: Conversion,
    ) -> Result<Option<f64>, ReadingsError> {
        let index = self.index(column);
        index.map_or(Ok(None), |index| self.number_at(index, conversion))
    }

    fn number_at(
        &mut self,
        index: usize,
        conversion: Conversion,
    ) -> Result<Option<f64>, ReadingsError> {
        if self.text.field(index).is_empty() {
            return Ok(None);
        }
        let read = self.text.number(index, conversion);
        read.map(Some).map_err(|fault| {
            let column = self.text.names[index].clone();
            self.text.number_error(index, column, fault)
        })
    }

    /// A whole number; 1 without a column or value, as one reading of a table by hand is the first of its kind.
    fn count(&self, column: &str) -> Result<u32, ReadingsError> {
        let text = self.text_of(column);
        if text.is_empty() {
            return Ok(1);
        }
        read_count(text.as_bytes()).ok_or_else(|| self.bad(column, "a whole number from 0"))
    }

    fn missing(&self, column: &str, expected: &'static str) -> ReadingsError {
        let cell = self.text.cell(column.to_owned(), b"");
        ReadingsError::MissingValue { cell, expected }
    }

    fn bad(&self, column: &str, expected: &'static str) -> ReadingsError {
        let value = self.text_of(column);
        let cell = self.text.cell(column.to_owned(), value.as_bytes());
        ReadingsError::BadValue { cell, expected }
    }
}
