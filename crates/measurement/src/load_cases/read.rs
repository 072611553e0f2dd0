//! Reads a table of load cases.

use std::collections::HashMap;
use std::io::Read;

use super::columns::{LoadCaseColumns, NumberColumn};
use super::table::{LoadAxes, LoadCase, LoadCaseTable, VectorQuantity};
use crate::readings::{ReadingStatus, RecordTable, TableError};
use stiffbench_units_and_text::count::counted;
use stiffbench_units_and_text::test_point::PoseId;

/// Load cases from a table.
///
/// Delimiters, decimal signs, encodings and units are those of every table of this program. An empty field is a component that was not
/// read; of a load it is an error, for a load that is not known loads nothing.
///
/// # Arguments
/// - `source`: the name of the input, for messages.
/// - `input`: its bytes; read once, in pieces.
///
/// # Errors
/// [`TableError`] with line, column, value and what was expected, for the first thing that is wrong.
pub fn read_load_cases(source: &str, input: impl Read) -> Result<LoadCaseTable, TableError> {
    let mut text = RecordTable::open(source, input)?;
    let columns = LoadCaseColumns::read(&text)?;
    let mut reader = LoadCaseReader::default();
    while text.next_record()? {
        reader.take(&mut text, &columns)?;
    }
    if reader.cases.is_empty() {
        return Err(text.no_readings());
    }
    let has_load = columns.has(VectorQuantity::Force) || columns.has(VectorQuantity::Moment);
    let of_text = text.assumptions().into_iter();
    let of_text = of_text.map(|one| format!("assumed: {one}"));
    let mut notes: Vec<String> = of_text.chain(columns.notes).collect();
    if columns.axes.is_none() && has_load {
        let said = "assumed: no column `axes`: components stand along the axes of the base";
        notes.push(said.to_owned());
    }
    if columns.pose.is_none() {
        let said =
            "assumed: no column `pose`: poses are numbered in the order of their joint values";
        notes.push(said.to_owned());
    }
    if !reader.rejected.is_empty() {
        let lines: Vec<String> = reader.rejected.iter().map(u32::to_string).collect();
        notes.push(format!(
            "not used, because of its `status`: {}, line {}",
            counted(lines.len(), "row"),
            lines.join(", ")
        ));
    }
    notes.extend(reader.repeated);
    let joints = columns.joints.into_iter().map(|joint| joint.column);
    Ok(LoadCaseTable {
        source: source.to_owned(),
        origin: reader.origin,
        joints: joints.collect(),
        cases: reader.cases,
        notes,
        unused_columns: columns.unused,
    })
}

/// Collects load cases.
#[derive(Debug, Default)]
struct LoadCaseReader {
    cases: Vec<LoadCase>,
    origin: Option<String>,
    rejected: Vec<u32>,
    repeated: Vec<String>,
    /// First line of every record, by its bytes.
    seen: HashMap<Vec<u8>, u32>,
    /// Number of each set of joint values, by their bits.
    poses: HashMap<Vec<u64>, usize>,
}

impl LoadCaseReader {
    fn take(
        &mut self,
        text: &mut RecordTable<'_>,
        columns: &LoadCaseColumns,
    ) -> Result<(), TableError> {
        let line = text.line;
        if let Some(index) = columns.status
            && text.status(index)? != ReadingStatus::Accepted
        {
            self.rejected.push(line);
            return Ok(());
        }
        if let (Some(index), None) = (columns.origin, &self.origin) {
            let origin = text.text(text.field(index)).into_owned();
            self.origin = Some(origin).filter(|origin| !origin.is_empty());
        }
        let mut joints = Vec::with_capacity(columns.joints.len());
        for joint in &columns.joints {
            let column = NumberColumn {
                index: joint.index,
                conversion: joint.conversion,
            };
            joints.push(required(
                text,
                column,
                "the value of the joint in this pose",
            )?);
        }
        let case = LoadCase {
            line,
            pose: self.pose(text, columns.pose, &joints)?,
            joints,
            repeat: match columns.repeat {
                Some(index) => text.count(index, 1)?.unwrap_or(1),
                None => 1,
            },
            axes: axes(text, columns.axes),
            force_n: load(text, columns.of(VectorQuantity::Force))?,
            moment_nm: load(text, columns.of(VectorQuantity::Moment))?,
            displacement_m: read(text, columns.of(VectorQuantity::Displacement))?,
            rotation_rad: read(text, columns.of(VectorQuantity::Rotation))?,
            position_m: read(text, columns.of(VectorQuantity::Position))?,
        };
        let is_loaded = case.force_n != [0.0; 3] || case.moment_nm != [0.0; 3];
        if !(is_loaded || columns.has(VectorQuantity::Position)) {
            return Err(TableError::new(
                "stiffbench::load_cases::no_load",
                format!("{}: force and moment are zero", text.at(line)),
                "a load case is the change from the unloaded state: leave out the row, or mark it `rejected` under `status`",
            ));
        }
        if case.component_count() == 0 {
            return Err(TableError::new(
                "stiffbench::load_cases::nothing_read",
                format!(
                    "{}: no component of displacement, rotation or position",
                    text.at(line)
                ),
                "fill at least one component, or mark the row `rejected` under `status`",
            ));
        }
        self.cases.push(case);
        self.note_repeated(text);
        Ok(())
    }

    fn pose(
        &mut self,
        text: &RecordTable<'_>,
        column: Option<usize>,
        joints: &[f64],
    ) -> Result<PoseId, TableError> {
        let Some(index) = column else {
            let bits = joints.iter().map(|value| value.to_bits()).collect();
            let next = self.poses.len() + 1;
            let number = *self.poses.entry(bits).or_insert(next);
            return Ok(PoseId::new(&number.to_string()));
        };
        let name = text.text(text.field(index)).into_owned();
        if name.is_empty() {
            let expected = "the name of a pose";
            return Err(text.missing(&text.names[index], expected));
        }
        Ok(PoseId::new(&name))
    }

    fn note_repeated(&mut self, text: &RecordTable<'_>) {
        let mut bytes = Vec::new();
        for index in 0..text.names.len() {
            bytes.extend_from_slice(text.field(index));
            bytes.push(0);
        }
        let line = text.line;
        if let Some(&first_line) = self.seen.get(&bytes) {
            self.repeated.push(format!(
                "line {line} repeats line {first_line} word for word; both are kept"
            ));
        } else {
            self.seen.insert(bytes, line);
        }
    }
}

fn axes(text: &RecordTable<'_>, column: Option<usize>) -> LoadAxes {
    let Some(index) = column else {
        return LoadAxes::Base;
    };
    let name = text.text(text.field(index)).into_owned();
    match name.to_lowercase().as_str() {
        "" | "base" => LoadAxes::Base,
        "tool" => LoadAxes::Tool,
        _ => LoadAxes::Body(name),
    }
}

/// The components of a load; those without a column are zero.
fn load(
    text: &mut RecordTable<'_>,
    columns: &[Option<NumberColumn>; 3],
) -> Result<[f64; 3], TableError> {
    let mut values = [0.0; 3];
    for (value, column) in values.iter_mut().zip(columns) {
        if let Some(column) = column {
            *value = required(text, *column, "a component of the load, 0 if there is none")?;
        }
    }
    Ok(values)
}

/// The components that were read.
fn read(
    text: &mut RecordTable<'_>,
    columns: &[Option<NumberColumn>; 3],
) -> Result<[Option<f64>; 3], TableError> {
    let mut values = [None; 3];
    for (value, column) in values.iter_mut().zip(columns) {
        if let Some(column) = column {
            *value = text.number(column.index, column.conversion)?;
        }
    }
    Ok(values)
}

fn required(
    text: &mut RecordTable<'_>,
    column: NumberColumn,
    expected: &'static str,
) -> Result<f64, TableError> {
    let NumberColumn { index, conversion } = column;
    let number = text.number(index, conversion)?;
    number.ok_or_else(|| text.missing(&text.names[index], expected))
}
