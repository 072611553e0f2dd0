//! Writes `readings.csv`: all columns, always `,` and `.`.

use std::io::Write;

use super::column::Column;
use super::error::TableError;
use super::formula::keep_quote;
use super::joint_values::JointColumn;
use super::number::write_decimal;
use super::reading::{Reading, ReadingText};
use super::table::{ReadingTable, RunKey};
use super::vector_table::{BASE_AXES, DISPLACEMENTS, FORCES};
use stiffbench_units_and_text::test_point::Direction;

/// Which rows of a table are written, and in which form.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct WrittenRows {
    /// Forces and displacements along the base axes, a row for each load; else a row for each reading.
    pub of_vectors: bool,
    /// The last row alone, without the column names: what a session adds.
    pub only_last: bool,
}

/// Writes a whole table of readings along the load.
///
/// Reading it back gives the same readings, runs and zeros, as long as no number needs more than 15 significant digits, which no gauge
/// gives. (If no reading has a time but there is `utc`, the reader works the times out from that.)
///
/// # Errors
/// As [`write_rows`].
pub fn write_readings(table: &ReadingTable, output: impl Write) -> Result<(), TableError> {
    write_rows(table, WrittenRows::default(), output)
}

/// Writes rows of a table; its session and origin go into every row. Readings that were measured have no origin and no such column.
///
/// Numbers are written with up to 15 significant digits, the instruments' own texts as they were; a component without a gauge is empty.
///
/// # Errors
/// [`TableError`] for a number that is not finite, before anything of the row is written, and if the output fails.
pub fn write_rows(
    table: &ReadingTable,
    rows: WrittenRows,
    output: impl Write,
) -> Result<(), TableError> {
    let mut output = csv::WriterBuilder::new()
        .terminator(csv::Terminator::Any(b'\n'))
        // A first field that starts with `#` must not become a comment.
        .comment(Some(b'#'))
        .flexible(false)
        .from_writer(output);
    let mut row = RowWriter {
        table,
        joints: rows.of_vectors.then(|| joint_columns(table)),
        fields: csv::ByteRecord::new(),
        seq: 0,
        number: String::new(),
    };
    if !rows.only_last {
        row.names();
        output
            .write_record(&row.fields)
            .map_err(TableError::not_written)?;
    }
    let loads: Vec<&[Reading]> = if rows.of_vectors {
        table.loads().collect()
    } else {
        table.readings.chunks(1).collect()
    };
    let first = if rows.only_last {
        loads.len().saturating_sub(1)
    } else {
        0
    };
    for load in &loads[first..] {
        row.load(load)?;
        output
            .write_record(&row.fields)
            .map_err(TableError::not_written)?;
    }
    output
        .flush()
        .map_err(|error| TableError::not_written(error.into()))
}

/// The joint columns of all poses.
fn joint_columns(table: &ReadingTable) -> Vec<JointColumn> {
    let mut columns: Vec<JointColumn> = Vec::new();
    for (column, _) in table.pose_joints.iter().flat_map(|pose| &pose.values) {
        if !columns.contains(column) {
            columns.push(column.clone());
        }
    }
    columns
}

/// The fields of one row after another.
struct RowWriter<'t> {
    table: &'t ReadingTable,
    /// Columns of joint values of rows along the base axes; `None` of rows along the load.
    joints: Option<Vec<JointColumn>>,
    fields: csv::ByteRecord,
    /// Number of the reading.
    seq: u32,
    number: String,
}

impl RowWriter<'_> {
    fn names(&mut self) {
        let along_load = Column::Force..=Column::DisplacementZero;
        for column in Column::ALL {
            if column == Column::Force
                && let Some(joints) = &self.joints
            {
                for joint in joints {
                    self.fields.push_field(joint.name().as_bytes());
                }
                let force = ["axes"].into_iter().chain(FORCES);
                let force = force.chain(["force_raw", "force_zero_N"]);
                for name in force.chain(DISPLACEMENTS.into_iter().flatten()) {
                    self.fields.push_field(name.as_bytes());
                }
            }
            let is_left_out = self.joints.is_some() && along_load.contains(&column)
                || self.table.origin.is_none() && column == Column::Origin;
            if !is_left_out {
                self.fields.push_field(column.name().as_bytes());
            }
        }
    }

    /// The row of one reading, or of those of one load.
    fn load(&mut self, load: &[Reading]) -> Result<(), TableError> {
        let Some(first) = load.first() else {
            return Ok(());
        };
        let table = self.table;
        let none = ReadingText::default();
        let text = first.text.as_deref().unwrap_or(&none);
        self.fields.clear();
        self.seq = first.seq;
        self.text(table.session.as_deref().unwrap_or_default());
        self.text(&first.seq.to_string());
        self.text(&text.utc);
        self.optional(Column::Time.name(), first.time_s, 0)?;
        self.text(first.pose.as_str());
        if self.joints.is_some() {
            self.text(&table.load_direction(first).to_string());
        } else {
            self.text(&first.direction.to_string());
        }
        self.text(&first.branch.to_string());
        self.text(&first.step.to_string());
        self.decimal(Column::Target.name(), first.target_n, 0)?;
        self.text(&first.repeat.to_string());
        self.text(&first.attempt.to_string());
        self.label(table.runs.get(first.run as usize));
        self.label(table.zeros.get(first.zero as usize));
        if let Some(joints) = self.joints.take() {
            let along = self.along_axes(&joints, first, load);
            self.joints = Some(joints);
            along?;
        } else {
            self.decimal(Column::Force.name(), first.force_n, 0)?;
            self.text(&text.force_raw);
            self.optional(Column::ForceZero.name(), text.zero_si[0], 0)?;
            let names = [
                Column::Displacement,
                Column::DisplacementRaw,
                Column::DisplacementZero,
            ];
            self.displacement(names.map(Column::name), Some(first))?;
        }
        self.optional(Column::Hold.name(), first.hold_s, 0)?;
        self.optional(Column::Temperature.name(), first.temperature_deg_c, 0)?;
        self.text(&first.status.to_string());
        self.text(&text.flag);
        self.text(&text.note);
        if let Some(origin) = &table.origin {
            self.text(origin);
        }
        Ok(())
    }

    /// Joint values, force and displacements of a load along the base axes.
    fn along_axes(
        &mut self,
        joints: &[JointColumn],
        first: &Reading,
        load: &[Reading],
    ) -> Result<(), TableError> {
        let stated = self.table.pose_joints.iter();
        let stated = stated.filter(|stated| stated.pose == first.pose);
        let stated: Vec<&(JointColumn, f64)> = stated.flat_map(|stated| &stated.values).collect();
        for joint in joints {
            let value = stated.iter().find(|(of, _)| of == joint);
            let value = value.map(|(_, value)| self.finite("joint", *value));
            let value = value.transpose()?;
            self.text(&value.map_or_else(String::new, |value| joint.unit.written(value)));
        }
        self.text(BASE_AXES);
        let unit = self.table.load_direction(first).unit_vector();
        for (name, part) in FORCES.into_iter().zip(unit) {
            self.decimal(name, part * first.force_n, 0)?;
        }
        let text = first.text.as_deref();
        self.text(text.map_or("", |text| &text.force_raw));
        let zero_n = text.and_then(|text| text.zero_si[0]);
        self.optional(Column::ForceZero.name(), zero_n, 0)?;
        for (axis, names) in Direction::ALL.into_iter().zip(DISPLACEMENTS) {
            let mut gauges = load.iter();
            self.displacement(names, gauges.find(|reading| reading.direction == axis))?;
        }
        Ok(())
    }

    /// Displacement, text and zero of a gauge; empty without it.
    fn displacement(
        &mut self,
        names: [&'static str; 3],
        of: Option<&Reading>,
    ) -> Result<(), TableError> {
        let text = of.and_then(|of| of.text.as_deref());
        self.optional(names[0], of.map(|of| of.displacement_m), 6)?;
        self.text(text.map_or("", |text| &text.displacement_raw));
        self.optional(names[2], text.and_then(|text| text.zero_si[1]), 6)
    }

    /// The name of a run or zero; along the base axes one without a name has its repeat for it.
    fn label(&mut self, key: Option<&RunKey>) {
        let of_repeat = key.filter(|_| self.joints.is_some());
        let of_repeat = of_repeat.map_or_else(String::new, |key| key.repeat.to_string());
        let label = key.and_then(|key| key.label.as_deref());
        self.text(label.unwrap_or(&of_repeat));
    }

    fn text(&mut self, text: &str) {
        self.fields.push_field(keep_quote(text).as_bytes());
    }

    /// The number with its decimal point `shift` places further right.
    fn decimal(&mut self, column: &'static str, value: f64, shift: i32) -> Result<(), TableError> {
        write_decimal(self.finite(column, value)?, shift, &mut self.number);
        self.fields.push_field(self.number.as_bytes());
        Ok(())
    }

    fn optional(
        &mut self,
        column: &'static str,
        value: Option<f64>,
        shift: i32,
    ) -> Result<(), TableError> {
        if let Some(value) = value {
            return self.decimal(column, value, shift);
        }
        self.text("");
        Ok(())
    }

    fn finite(&self, column: &'static str, value: f64) -> Result<f64, TableError> {
        let not_writable = || {
            let seq = self.seq;
            TableError::new(
                "stiffbench::readings::not_writable",
                format!("reading {seq}: {column} is {value}, which a table cannot hold"),
                "readings are finite numbers; leave out optional values that are not known",
            )
        };
        value.is_finite().then_some(value).ok_or_else(not_writable)
    }
}
