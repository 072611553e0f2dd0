//! The columns of a force gauge's log, and what stands above them.

use super::assumption::{Assumption, AssumptionNote};
use super::column::{Column, NamedColumn, understand};
use super::error::ReadingsError;
use super::number::Conversion;
use super::reading::{Reading, ReadingStatus, ReadingText};
use super::text_table::{ReadOptions, RecordTable};
use stiffbench_units_and_text::quantity::Kind;
use stiffbench_units_and_text::test_point::{Branch, Direction, PoseId};

/// Whether fields are the column names of a gauge's log.
pub(super) fn is_log_header(names: &[String]) -> bool {
    let (mut reading, mut load) = (false, false);
    for name in names.iter().flat_map(|name| name.split('\t')) {
        let name = name.trim().to_lowercase();
        reading |= name == "reading";
        load |= name.starts_with("load");
    }
    reading && load
}

/// Along which sense of the direction the load acted.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LoadSign {
    /// Along the positive axis.
    Positive,
    /// Against it: a push along -x has a negative force.
    Negative,
}

/// What a gauge log leaves open.
#[derive(Debug, Clone, PartialEq)]
pub struct GaugeLogOptions {
    /// The pose held.
    pub pose: PoseId,
    /// The direction of load and displacement.
    pub direction: Direction,
    /// Which application of the load sequence it was, from 1.
    pub repeat: u32,
    /// The sense of the load; gauges disagree about the sign of a push.
    pub sign: LoadSign,
    /// Delimiter (a tab unless stated otherwise) and decimal sign.
    pub text: ReadOptions,
}

/// What stands above the table of a log.
pub(super) struct Preamble {
    load_unit: Option<String>,
    travel_unit: Option<String>,
    pub(super) notes: Vec<AssumptionNote>,
}

impl Preamble {
    /// Reads up to and including the line of column names, which stays the current record.
    pub(super) fn read(text: &mut RecordTable<'_>) -> Result<Self, ReadingsError> {
        let mut preamble = Self {
            load_unit: None,
            travel_unit: None,
            notes: Vec::new(),
        };
        while text.next_header()? {
            if is_log_header(&text.names) {
                return Ok(preamble);
            }
            preamble.take(text.names.join(" ").trim());
        }
        let file = text.file();
        Err(ReadingsError::NotAGaugeLog { file })
    }

    fn take(&mut self, line: &str) {
        let (key, value) = line.split_once(':').unwrap_or((line, ""));
        match key.trim().to_lowercase().as_str() {
            "units" | "unit" | "load unit" | "load units" => {
                self.load_unit = Some(value.trim().to_owned());
            }
            "travel unit" | "travel units" | "distance unit" | "distance units" => {
                self.travel_unit = Some(value.trim().to_owned());
            }
            _ if line.starts_with(|c: char| c.is_ascii_digit()) => {
                self.notes.push(AssumptionNote::LocalTime(line.to_owned()));
            }
            _ => self.notes.push(AssumptionNote::LogLine(line.to_owned())),
        }
    }
}

/// A column of the log: place, conversion to SI, name.
struct LogColumn {
    index: usize,
    conversion: Conversion,
    name: String,
}

/// Where load, travel and time stand in a log, and in which units.
pub(super) struct LogColumns {
    load: LogColumn,
    travel: LogColumn,
    time: Option<LogColumn>,
    time_has_unit: bool,
}

impl LogColumns {
    /// Finds the columns in the current record, the line of names.
    pub(super) fn find(text: &RecordTable<'_>, preamble: &Preamble) -> Result<Self, ReadingsError> {
        let column = |wanted: Column, unit: Option<&str>| find_column(text, wanted, unit);
        let missing = |column: Column| ReadingsError::MissingColumn {
            file: text.file(),
            line: text.header_line,
            column: column.name(),
            others: String::new(),
            found: text.names.join(", "),
            advice: "a log has the columns Reading, Load, Travel (or Distance), Time".to_owned(),
        };
        let load = column(Column::Force, preamble.load_unit.as_deref())?
            .ok_or_else(|| missing(Column::Force))?;
        let travel = column(Column::Displacement, preamble.travel_unit.as_deref())?
            .ok_or_else(|| missing(Column::Displacement))?;
        let time = column(Column::Time, Some("s"))?;
        let time_has_unit = time
            .as_ref()
            .is_some_and(|time| matches!(understand(&time.name), NamedColumn::Column(..)));
        Ok(Self {
            load,
            travel,
            time,
            time_has_unit,
        })
    }

    /// The reading of the current record, still with the signs of the log.
    pub(super) fn reading(
        &self,
        text: &mut RecordTable<'_>,
        options: &GaugeLogOptions,
        seq: u32,
    ) -> Result<Reading, ReadingsError> {
        let raw = |column: &LogColumn| Box::from(&*text.text(text.raw(column.index)));
        let own_text = ReadingText {
            force_raw: raw(&self.load),
            displacement_raw: raw(&self.travel),
            ..ReadingText::default()
        };
        let mut number = |column: &LogColumn| {
            let number = text.number(column.index, column.conversion)?;
            number.ok_or_else(|| text.missing(&column.name, "a number"))
        };
        Ok(Reading {
            seq,
            pose: options.pose.clone(),
            direction: options.direction,
            load: None,
            branch: Branch::Loading,
            step: seq - 1,
            repeat: options.repeat,
            attempt: 1,
            run: 0,
            zero: 0,
            status: ReadingStatus::Accepted,
            target_n: 0.0,
            force_n: number(&self.load)?,
            displacement_m: number(&self.travel)?,
            time_s: self.time.as_ref().map(&mut number).transpose()?,
            hold_s: None,
            temperature_deg_c: None,
            text: Some(Box::new(own_text)),
            line: text.line,
        })
    }

    /// The columns of a table that the log fills, those the caller gave included.
    pub(super) fn present(&self) -> Vec<Column> {
        let time = self.time.is_some().then_some(Column::Time);
        let filled = [
            Column::Pose,
            Column::Direction,
            Column::Repeat,
            Column::Force,
            Column::ForceRaw,
            Column::Displacement,
            Column::DisplacementRaw,
        ];
        let mut columns: Vec<Column> = time.into_iter().chain(filled).collect();
        columns.sort_unstable();
        columns
    }

    pub(super) fn assumptions(&self) -> Vec<Assumption> {
        let converted = |column: Column, log: &LogColumn| {
            let written = column
                .kind()
                .and_then(|kind| Conversion::from_unit(kind, column.unit()));
            (written != Some(log.conversion)).then(|| Assumption::UnitConverted {
                column,
                found: log.name.clone(),
            })
        };
        let mut assumptions: Vec<Assumption> = converted(Column::Force, &self.load)
            .into_iter()
            .chain(converted(Column::Displacement, &self.travel))
            .collect();
        if self.time.is_some() && !self.time_has_unit {
            assumptions.push(Assumption::TimeInSeconds);
        }
        assumptions
    }
}

/// The log's column for `wanted`, its unit from its name or else `unit`.
fn find_column(
    text: &RecordTable<'_>,
    wanted: Column,
    unit: Option<&str>,
) -> Result<Option<LogColumn>, ReadingsError> {
    let accepted = wanted.kind().map_or("", Kind::units);
    for (index, name) in text.names.iter().enumerate() {
        let conversion = match understand(name) {
            NamedColumn::Column(column, conversion) if column == wanted => conversion,
            NamedColumn::WrongUnit(column, found) if column == wanted => {
                return Err(text.wrong_unit(index, Some(found), accepted));
            }
            NamedColumn::NoUnit(column) if column == wanted => wanted
                .kind()
                .zip(unit)
                .and_then(|(kind, unit)| Conversion::from_unit(kind, unit))
                .ok_or_else(|| text.wrong_unit(index, unit, accepted))?,
            _ => continue,
        };
        let name = name.clone();
        return Ok(Some(LogColumn {
            index,
            conversion,
            name,
        }));
    }
    Ok(None)
}
