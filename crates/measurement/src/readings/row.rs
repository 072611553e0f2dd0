//! One record of a table to one reading.

use std::collections::HashMap;

use super::column::Column;
use super::error::TableError;
use super::header::ColumnHeader;
use super::reading::{Reading, ReadingStatus, ReadingText};
use super::rows::text_of;
use super::table::RunNumbers;
use super::text_table::RecordTable;
use stiffbench_units_and_text::test_point::{Branch, Direction, PoseId};

/// First line on which a column that is there has no value, by column.
pub(super) type FirstMissing = [Option<u32>; Column::ALL.len()];

/// Turns records into readings.
pub(super) struct RowReader<'a> {
    header: &'a ColumnHeader,
    pub(super) readings: Vec<Reading>,
    poses: PoseNames,
    pub(super) runs: RunNumbers,
    pub(super) zeros: RunNumbers,
    pub(super) session: Option<(String, u32)>,
    /// The first that is given.
    pub(super) origin: Option<String>,
    pub(super) present: [bool; Column::ALL.len()],
    pub(super) first_missing: FirstMissing,
}

impl<'a> RowReader<'a> {
    pub(super) fn new(header: &'a ColumnHeader) -> Self {
        Self {
            header,
            readings: Vec::new(),
            poses: PoseNames::default(),
            runs: RunNumbers::default(),
            zeros: RunNumbers::default(),
            session: None,
            origin: None,
            present: [false; Column::ALL.len()],
            first_missing: [None; Column::ALL.len()],
        }
    }

    /// Adds the reading of the current record.
    pub(super) fn take(&mut self, table: &mut RecordTable<'_>) -> Result<(), TableError> {
        self.check_session(table)?;
        let pose = self.pose(table)?;
        let direction = self.direction(table)?;
        let repeat = self.repeat(table)?;
        let run = self.text(table, Column::Run);
        let zero = self.text(table, Column::Zero);
        let run = self.runs.number(&pose, direction, repeat, run.as_deref());
        let zero = self.zeros.number(&pose, direction, repeat, zero.as_deref());
        let reading = Reading {
            direction,
            run,
            zero,
            force_n: self.required_number(table, Column::Force)?,
            displacement_m: self.required_number(table, Column::Displacement)?,
            ..self.common(table, pose, repeat)?
        };
        let text = self.texts(table)?;
        let reading = Reading { text, ..reading };
        self.readings.push(reading);
        Ok(())
    }

    /// What the readings of the current record have in common: all but direction, run, zero, force, displacement and texts.
    pub(super) fn common(
        &mut self,
        table: &mut RecordTable<'_>,
        pose: PoseId,
        repeat: u32,
    ) -> Result<Reading, TableError> {
        if self.origin.is_none() {
            let origin = self.text(table, Column::Origin);
            self.origin = origin.filter(|origin| !origin.is_empty());
        }
        let seq = self.count(table, Column::Seq)?;
        let step = self.count(table, Column::Step)?;
        let attempt = self.count(table, Column::Attempt)?;
        Ok(Reading {
            line: table.line,
            seq: seq.unwrap_or(self.readings.len() as u32 + 1),
            pose,
            direction: Direction::X,
            load: None,
            branch: self.branch(table)?,
            step: step.unwrap_or(0),
            repeat,
            attempt: attempt.unwrap_or(1),
            run: 0,
            zero: 0,
            status: self.status(table)?,
            target_n: self.number(table, Column::Target)?.unwrap_or(0.0),
            force_n: 0.0,
            displacement_m: 0.0,
            time_s: self.number(table, Column::Time)?,
            hold_s: self.number(table, Column::Hold)?,
            temperature_deg_c: self.number(table, Column::Temperature)?,
            text: None,
        })
    }

    fn check_session(&mut self, table: &RecordTable<'_>) -> Result<(), TableError> {
        if !self.header.has(Column::Session) {
            return Ok(());
        }
        let field = self.field(table, Column::Session).unwrap_or_default();
        match &self.session {
            Some((first, _)) if first.as_bytes() == field => Ok(()),
            None => {
                let session = self.text(table, Column::Session).unwrap_or_default();
                self.session = Some((session, table.line));
                Ok(())
            }
            Some((first, first_line)) => {
                let second = text_of(field).0;
                // Text in another encoding was converted before it was kept.
                if *first == second {
                    return Ok(());
                }
                Err(TableError::new(
                    "stiffbench::readings::several_sessions",
                    format!(
                        "{}: session `{second}`, but line {first_line} has session `{first}`",
                        table.at(table.line)
                    ),
                    "times and gauge zeros of different sessions do not compare; write each session into its own file",
                ))
            }
        }
    }

    /// The field of a column without blanks around it; `None` if the column is absent or the field empty.
    fn field<'r>(&self, table: &'r RecordTable<'_>, column: Column) -> Option<&'r [u8]> {
        let (index, _) = self.header.place(column)?;
        let field = table.field(index);
        (!field.is_empty()).then_some(field)
    }

    /// The same, noting whether the column ever has a value and where it first has none.
    fn noted<'r>(&mut self, table: &'r RecordTable<'_>, column: Column) -> Option<&'r [u8]> {
        let field = self.field(table, column);
        if field.is_some() {
            self.present[column as usize] = true;
        } else if self.first_missing[column as usize].is_none() {
            self.first_missing[column as usize] = Some(table.line);
        }
        field
    }

    /// The place of a column with a value in this record.
    fn place(&mut self, table: &RecordTable<'_>, column: Column) -> Option<usize> {
        self.noted(table, column)?;
        self.header.place(column).map(|(index, _)| index)
    }

    pub(super) fn text(&mut self, table: &RecordTable<'_>, column: Column) -> Option<String> {
        let field = self.noted(table, column)?;
        Some(table.text(field).into_owned())
    }

    pub(super) fn pose(&mut self, table: &RecordTable<'_>) -> Result<PoseId, TableError> {
        let Some(name) = self.noted(table, Column::Pose) else {
            return Err(self.missing(table, Column::Pose, "the name of a pose"));
        };
        if let Some(pose) = self.poses.known(name) {
            return Ok(pose);
        }
        let pose = PoseId::new(&table.text(name));
        self.poses.add(name, pose.clone());
        Ok(pose)
    }

    fn direction(&mut self, table: &RecordTable<'_>) -> Result<Direction, TableError> {
        const EXPECTED: &str = "x, y or z";
        match self.noted(table, Column::Direction) {
            Some(b"x" | b"X") => Ok(Direction::X),
            Some(b"y" | b"Y") => Ok(Direction::Y),
            Some(b"z" | b"Z") => Ok(Direction::Z),
            Some(other) => Err(table.bad(&self.header.name(Column::Direction), other, EXPECTED)),
            None => Err(self.missing(table, Column::Direction, EXPECTED)),
        }
    }

    fn branch(&mut self, table: &RecordTable<'_>) -> Result<Branch, TableError> {
        let index = self.place(table, Column::Branch);
        index.map_or(Ok(Branch::Loading), |index| table.branch(index))
    }

    fn status(&mut self, table: &RecordTable<'_>) -> Result<ReadingStatus, TableError> {
        let index = self.place(table, Column::Status);
        index.map_or(Ok(ReadingStatus::Accepted), |index| table.status(index))
    }

    fn repeat(&mut self, table: &RecordTable<'_>) -> Result<u32, TableError> {
        let repeat = self.count(table, Column::Repeat)?;
        repeat.ok_or_else(|| self.missing(table, Column::Repeat, "a whole number from 1"))
    }

    pub(super) fn count(
        &mut self,
        table: &RecordTable<'_>,
        column: Column,
    ) -> Result<Option<u32>, TableError> {
        let least = u32::from(matches!(column, Column::Attempt | Column::Repeat));
        let index = self.place(table, column);
        index.map_or(Ok(None), |index| table.count(index, least))
    }

    fn number(
        &mut self,
        table: &mut RecordTable<'_>,
        column: Column,
    ) -> Result<Option<f64>, TableError> {
        if self.noted(table, column).is_none() {
            return Ok(None);
        }
        let place = self.header.place(column);
        place.map_or(Ok(None), |(index, conversion)| {
            table.number(index, conversion)
        })
    }

    fn required_number(
        &mut self,
        table: &mut RecordTable<'_>,
        column: Column,
    ) -> Result<f64, TableError> {
        let number = self.number(table, column)?;
        number.ok_or_else(|| self.missing(table, column, "a number"))
    }

    /// The texts of a reading, if there are any; the instruments' own are kept with the blanks around them.
    pub(super) fn texts(
        &mut self,
        table: &mut RecordTable<'_>,
    ) -> Result<Option<Box<ReadingText>>, TableError> {
        let zero_si = [
            self.number(table, Column::ForceZero)?,
            self.number(table, Column::DisplacementZero)?,
        ];
        let columns = [
            Column::Utc,
            Column::ForceRaw,
            Column::DisplacementRaw,
            Column::Flag,
            Column::Note,
        ];
        let mut any = zero_si.iter().any(Option::is_some);
        let fields = columns.map(|column| {
            let field: &[u8] = match (self.header.place(column), column) {
                (None, _) => &[],
                (Some((index, _)), Column::Utc) => table.field(index),
                (Some((index, _)), _) => table.raw(index),
            };
            if !field.is_empty() {
                any = true;
                self.present[column as usize] = true;
            }
            field
        });
        if !any {
            return Ok(None);
        }
        let [utc, force_raw, displacement_raw, flag, note] =
            fields.map(|field| Box::from(&*table.text(field)));
        Ok(Some(Box::new(ReadingText {
            utc,
            force_raw,
            displacement_raw,
            zero_si,
            flag,
            note,
        })))
    }

    fn missing(
        &self,
        table: &RecordTable<'_>,
        column: Column,
        expected: &'static str,
    ) -> TableError {
        table.missing(&self.header.name(column), expected)
    }
}

/// Each pose name once.
#[derive(Default)]
struct PoseNames {
    by_name: HashMap<Box<[u8]>, PoseId>,
    last: Option<(Box<[u8]>, PoseId)>,
}

impl PoseNames {
    fn known(&mut self, name: &[u8]) -> Option<PoseId> {
        // Most readings have the pose of the reading before.
        if let Some((last, pose)) = &self.last
            && **last == *name
        {
            return Some(pose.clone());
        }
        let pose = self.by_name.get(name)?.clone();
        self.last = Some((name.into(), pose.clone()));
        Some(pose)
    }

    fn add(&mut self, name: &[u8], pose: PoseId) {
        self.by_name.insert(name.into(), pose);
    }
}
