//! Writes `readings.csv`: all columns, always `,` and `.`.

use std::io::Write;

use super::column::Column;
use super::error::ReadingsError;
use super::formula::keep_quote;
use super::number::write_decimal;
use super::reading::{Reading, ReadingText};
use super::table::{ReadingTable, RunKey};
use super::vector_reading::VectorReadingsWriter;
use super::vector_table::VectorTable;

/// Writes readings one by one, so that a session can add each as it is made.
///
/// Numbers are written with up to 15 significant digits, the instruments' own texts as they were.
pub struct ReadingsWriter<W: Write> {
    output: csv::Writer<W>,
    session: String,
    origin: String,
    number: String,
}

impl<W: Write> ReadingsWriter<W> {
    /// Writes the header; `session` and `origin` go into every row. Readings that were measured have no origin and no such column.
    ///
    /// # Errors
    /// [`ReadingsError::Write`] if the output fails.
    pub fn new(
        output: W,
        session: Option<&str>,
        origin: Option<&str>,
    ) -> Result<Self, ReadingsError> {
        let mut writer = Self::continuing(output, session, origin);
        let marked = origin.is_some();
        let columns = Column::ALL.into_iter();
        let columns = columns.filter(|column| marked || *column != Column::Origin);
        writer
            .output
            .write_record(columns.map(Column::name))
            .map_err(failed)?;
        Ok(writer)
    }

    /// The same behind rows that are there already: no header is written.
    #[must_use]
    pub fn continuing(output: W, session: Option<&str>, origin: Option<&str>) -> Self {
        Self {
            output: csv_writer(output),
            session: session.unwrap_or_default().to_owned(),
            origin: origin.unwrap_or_default().to_owned(),
            number: String::new(),
        }
    }

    /// Writes one reading, of the given run and gauge zero.
    ///
    /// # Errors
    /// [`ReadingsError::NotWritable`] for a number that is not finite, before anything of the row is written;
    /// [`ReadingsError::Write`] if the output fails.
    pub fn write(
        &mut self,
        reading: &Reading,
        run: &RunKey,
        zero: &RunKey,
    ) -> Result<(), ReadingsError> {
        check_finite(reading)?;
        let none = ReadingText::default();
        let text = reading.text.as_deref().unwrap_or(&none);
        self.output.write_field(&self.session).map_err(failed)?;
        self.count(reading.seq)?;
        self.text(&text.utc)?;
        self.optional(reading.time_s, 0)?;
        self.text(reading.pose.as_str())?;
        self.text(&reading.direction.to_string())?;
        self.text(&reading.branch.to_string())?;
        self.count(reading.step)?;
        self.decimal(reading.target_n, 0)?;
        self.count(reading.repeat)?;
        self.count(reading.attempt)?;
        self.text(run.label.as_deref().unwrap_or_default())?;
        self.text(zero.label.as_deref().unwrap_or_default())?;
        self.decimal(reading.force_n, 0)?;
        self.text(&text.force_raw)?;
        self.optional(text.zero_si[0], 0)?;
        self.decimal(reading.displacement_m, 6)?;
        self.text(&text.displacement_raw)?;
        self.optional(text.zero_si[1], 6)?;
        self.optional(reading.hold_s, 0)?;
        self.optional(reading.temperature_deg_c, 0)?;
        self.text(&reading.status.to_string())?;
        self.text(&text.flag)?;
        self.text(&text.note)?;
        if !self.origin.is_empty() {
            self.output.write_field(&self.origin).map_err(failed)?;
        }
        self.output.write_record(None::<&[u8]>).map_err(failed)
    }

    /// Hands everything written so far to the output.
    ///
    /// # Errors
    /// [`ReadingsError::Write`] if the output fails.
    pub fn flush(&mut self) -> Result<(), ReadingsError> {
        self.output.flush().map_err(|error| failed(error.into()))
    }

    fn text(&mut self, text: &str) -> Result<(), ReadingsError> {
        let text = keep_quote(text);
        self.output.write_field(text.as_bytes()).map_err(failed)
    }

    fn count(&mut self, count: u32) -> Result<(), ReadingsError> {
        self.text(&count.to_string())
    }

    /// The number with its decimal point `shift` places further right.
    fn decimal(&mut self, value: f64, shift: i32) -> Result<(), ReadingsError> {
        write_decimal(value, shift, &mut self.number);
        self.output.write_field(&self.number).map_err(failed)
    }

    fn optional(&mut self, value: Option<f64>, shift: i32) -> Result<(), ReadingsError> {
        match value {
            Some(value) => self.decimal(value, shift),
            None => self.text(""),
        }
    }
}

/// A table with `,`, every row as long as the first.
pub(super) fn csv_writer<W: Write>(output: W) -> csv::Writer<W> {
    csv::WriterBuilder::new()
        .terminator(csv::Terminator::Any(b'\n'))
        // A first field that starts with `#` must not become a comment.
        .comment(Some(b'#'))
        .flexible(false)
        .from_writer(output)
}

pub(super) fn failed(error: csv::Error) -> ReadingsError {
    ReadingsError::Write { error }
}

/// Refuses the first number of a reading that is not finite, with its column.
pub(super) fn refuse_not_finite(
    seq: u32,
    numbers: impl IntoIterator<Item = (&'static str, Option<f64>)>,
) -> Result<(), ReadingsError> {
    let mut numbers = numbers.into_iter();
    let odd = numbers.find_map(|(column, value)| {
        let value = value.filter(|value| !value.is_finite())?;
        Some((column, value))
    });
    odd.map_or(Ok(()), |(column, value)| {
        Err(ReadingsError::NotWritable { seq, column, value })
    })
}

fn check_finite(reading: &Reading) -> Result<(), ReadingsError> {
    let zeros = reading.text.as_ref().map_or([None; 2], |text| text.zero_si);
    let numbers = [
        (Column::ForceZero, zeros[0]),
        (Column::DisplacementZero, zeros[1]),
        (Column::Target, Some(reading.target_n)),
        (Column::Force, Some(reading.force_n)),
        (Column::Displacement, Some(reading.displacement_m)),
        (Column::Time, reading.time_s),
        (Column::Hold, reading.hold_s),
        (Column::Temperature, reading.temperature_deg_c),
    ];
    let named = numbers.map(|(column, value)| (column.name(), value));
    refuse_not_finite(reading.seq, named)
}

/// Writes a whole table.
///
/// Reading it back gives the same readings, runs and zeros, as long as no number needs more than 15 significant digits, which no gauge
/// gives. (If no reading has a time but there is `utc`, the reader works the times out from that.)
///
/// # Errors
/// As [`ReadingsWriter::write`].
///
/// # Panics
/// If a reading's run or zero is not in the table's lists.
pub fn write_readings(table: &ReadingTable, output: impl Write) -> Result<(), ReadingsError> {
    let mut writer =
        ReadingsWriter::new(output, table.session.as_deref(), table.origin.as_deref())?;
    for reading in &table.readings {
        let run = &table.runs[reading.run as usize];
        let zero = &table.zeros[reading.zero as usize];
        writer.write(reading, run, zero)?;
    }
    writer.flush()
}

/// Writes a whole table as forces and displacements along the base axes, a row for each load.
///
/// # Errors
/// As [`VectorReadingsWriter::write`].
///
/// # Panics
/// If a reading's run or zero is not in the table's lists.
pub fn write_vector_readings(
    table: &ReadingTable,
    output: impl Write,
) -> Result<(), ReadingsError> {
    let (session, origin) = (table.session.as_deref(), table.origin.as_deref());
    let vectors = VectorTable::of_components(table);
    let mut writer = VectorReadingsWriter::new(output, session, origin, &vectors.joints)?;
    for reading in &vectors.readings {
        writer.write(reading)?;
    }
    writer.flush()
}
