//! One record of a table to one reading.

use std::borrow::Cow;
use std::collections::HashMap;
use std::io::Read;

use super::column::Column;
use super::error::ReadingsError;
use super::header::Header;
use super::number::{DecimalSign, NumberFault, NumberReader, read_count};
use super::reading::{Reading, ReadingText, Status};
use super::rows::{Rows, text_of};
use super::table::RunNumbers;
use stiffbench_units_and_text::test_point::{Branch, Direction, PoseId};

/// First line on which a column that is there has no value, by column.
pub(super) type FirstMissing = [Option<u32>; Column::ALL.len()];

/// Turns records into readings.
pub(super) struct RowReader<'a> {
    file: &'a str,
    header: &'a Header,
    pub(super) numbers: NumberReader,
    pub(super) readings: Vec<Reading>,
    poses: PoseNames,
    pub(super) runs: RunNumbers,
    pub(super) zeros: RunNumbers,
    pub(super) session: Option<(String, u32)>,
    /// The first that is given.
    pub(super) origin: Option<String>,
    pub(super) present: [bool; Column::ALL.len()],
    pub(super) first_missing: FirstMissing,
    pub(super) other_encoding: Option<u32>,
}

impl<'a> RowReader<'a> {
    pub(super) fn new(file: &'a str, header: &'a Header, decimal: Option<DecimalSign>) -> Self {
        Self {
            file,
            header,
            numbers: NumberReader::new(decimal),
            readings: Vec::new(),
            poses: PoseNames::default(),
            runs: RunNumbers::default(),
            zeros: RunNumbers::default(),
            session: None,
            origin: None,
            present: [false; Column::ALL.len()],
            first_missing: [None; Column::ALL.len()],
            other_encoding: None,
        }
    }

    /// Adds the reading of the current record.
    pub(super) fn take<R: Read>(&mut self, rows: &Rows<R>, line: u32) -> Result<(), ReadingsError> {
        self.check_width(rows, line)?;
        self.check_session(rows, line)?;
        if self.origin.is_none() {
            let origin = self.text(rows, line, Column::Origin);
            self.origin = origin.filter(|origin| !origin.is_empty());
        }
        let pose = self.pose(rows, line)?;
        let direction = self.direction(rows, line)?;
        let repeat = self.repeat(rows, line)?;
        let run = self.text(rows, line, Column::Run);
        let zero = self.text(rows, line, Column::Zero);
        let run = self.runs.number(&pose, direction, repeat, run.as_deref());
        let zero = self.zeros.number(&pose, direction, repeat, zero.as_deref());
        let seq = self.count(rows, line, Column::Seq)?;
        let step = self.count(rows, line, Column::Step)?;
        let attempt = self.count(rows, line, Column::Attempt)?;
        let reading = Reading {
            line,
            seq: seq.unwrap_or(self.readings.len() as u32 + 1),
            pose,
            direction,
            branch: self.branch(rows, line)?,
            step: step.unwrap_or(0),
            repeat,
            attempt: attempt.unwrap_or(1),
            run,
            zero,
            status: self.status(rows, line)?,
            target_n: self.number(rows, line, Column::Target)?.unwrap_or(0.0),
            force_n: self.required_number(rows, line, Column::Force)?,
            displacement_m: self.required_number(rows, line, Column::Displacement)?,
            time_s: self.number(rows, line, Column::Time)?,
            hold_s: self.number(rows, line, Column::Hold)?,
            temperature_deg_c: self.number(rows, line, Column::Temperature)?,
            text: None,
        };
        let text = self.texts(rows, line)?;
        let reading = Reading { text, ..reading };
        self.readings.push(reading);
        Ok(())
    }

    /// More fields than names are fine as long as they are empty, as spreadsheets leave them.
    fn check_width<R: Read>(&self, rows: &Rows<R>, line: u32) -> Result<(), ReadingsError> {
        let (expected, found) = (self.header.width(), rows.len());
        let empty = |index: usize| rows.field(index).trim_ascii().is_empty();
        if found == expected || found > expected && (expected..found).all(empty) {
            return Ok(());
        }
        Err(ReadingsError::FieldCount {
            file: self.file.to_owned(),
            line,
            expected,
            found,
        })
    }

    fn check_session<R: Read>(&mut self, rows: &Rows<R>, line: u32) -> Result<(), ReadingsError> {
        if !self.header.has(Column::Session) {
            return Ok(());
        }
        let field = self.field(rows, Column::Session).unwrap_or_default();
        match &self.session {
            Some((first, _)) if first.as_bytes() == field => Ok(()),
            None => {
                let session = self.text(rows, line, Column::Session).unwrap_or_default();
                self.session = Some((session, line));
                Ok(())
            }
            Some((first, first_line)) => {
                let second = text_of(field).0;
                // Text in another encoding was converted before it was kept.
                if *first == second {
                    return Ok(());
                }
                Err(ReadingsError::SeveralSessions {
                    file: self.file.to_owned(),
                    line,
                    first: first.clone(),
                    first_line: *first_line,
                    second: second.into_owned(),
                })
            }
        }
    }

    /// The field of a column without blanks around it; `None` if the column is absent or the field empty.
    fn field<'r, R: Read>(&self, rows: &'r Rows<R>, column: Column) -> Option<&'r [u8]> {
        let (index, _) = self.header.place(column)?;
        let field = rows.field(index).trim_ascii();
        (!field.is_empty()).then_some(field)
    }

    /// The same, noting whether the column ever has a value and where it first has none.
    fn noted<'r, R: Read>(
        &mut self,
        rows: &'r Rows<R>,
        line: u32,
        column: Column,
    ) -> Option<&'r [u8]> {
        let field = self.field(rows, column);
        if field.is_some() {
            self.present[column as usize] = true;
        } else if self.first_missing[column as usize].is_none() {
            self.first_missing[column as usize] = Some(line);
        }
        field
    }

    fn text<R: Read>(&mut self, rows: &Rows<R>, line: u32, column: Column) -> Option<String> {
        let field = self.noted(rows, line, column)?;
        Some(self.decoded(field, line).into_owned())
    }

    fn decoded<'t>(&mut self, bytes: &'t [u8], line: u32) -> Cow<'t, str> {
        let (text, other_encoding) = text_of(bytes);
        if other_encoding {
            self.other_encoding.get_or_insert(line);
        }
        text
    }

    fn pose<R: Read>(&mut self, rows: &Rows<R>, line: u32) -> Result<PoseId, ReadingsError> {
        let Some(name) = self.noted(rows, line, Column::Pose) else {
            return Err(self.missing(line, Column::Pose, "the name of a pose"));
        };
        if let Some(pose) = self.poses.known(name) {
            return Ok(pose);
        }
        let pose = PoseId::new(&self.decoded(name, line));
        self.poses.add(name, pose.clone());
        Ok(pose)
    }

    fn direction<R: Read>(
        &mut self,
        rows: &Rows<R>,
        line: u32,
    ) -> Result<Direction, ReadingsError> {
        const EXPECTED: &str = "x, y or z";
        match self.noted(rows, line, Column::Direction) {
            Some(b"x" | b"X") => Ok(Direction::X),
            Some(b"y" | b"Y") => Ok(Direction::Y),
            Some(b"z" | b"Z") => Ok(Direction::Z),
            Some(other) => Err(self.bad(line, Column::Direction, other, EXPECTED)),
            None => Err(self.missing(line, Column::Direction, EXPECTED)),
        }
    }

    fn branch<R: Read>(&mut self, rows: &Rows<R>, line: u32) -> Result<Branch, ReadingsError> {
        let Some(word) = self.noted(rows, line, Column::Branch) else {
            return Ok(Branch::Loading);
        };
        if word.eq_ignore_ascii_case(b"loading") || word.eq_ignore_ascii_case(b"load") {
            Ok(Branch::Loading)
        } else if word.eq_ignore_ascii_case(b"unloading") || word.eq_ignore_ascii_case(b"unload") {
            Ok(Branch::Unloading)
        } else {
            Err(self.bad(line, Column::Branch, word, "loading or unloading"))
        }
    }

    fn status<R: Read>(&mut self, rows: &Rows<R>, line: u32) -> Result<Status, ReadingsError> {
        let Some(word) = self.noted(rows, line, Column::Status) else {
            return Ok(Status::Accepted);
        };
        if word.eq_ignore_ascii_case(b"accepted") {
            Ok(Status::Accepted)
        } else if word.eq_ignore_ascii_case(b"superseded") {
            Ok(Status::Superseded)
        } else if word.eq_ignore_ascii_case(b"rejected") {
            Ok(Status::Rejected)
        } else {
            Err(self.bad(
                line,
                Column::Status,
                word,
                "accepted, superseded or rejected",
            ))
        }
    }

    fn repeat<R: Read>(&mut self, rows: &Rows<R>, line: u32) -> Result<u32, ReadingsError> {
        const EXPECTED: &str = "a whole number from 1";
        match self.noted(rows, line, Column::Repeat) {
            None => Err(self.missing(line, Column::Repeat, EXPECTED)),
            Some(field) => read_count(field)
                .filter(|repeat| *repeat > 0)
                .ok_or_else(|| self.bad(line, Column::Repeat, field, EXPECTED)),
        }
    }

    fn count<R: Read>(
        &mut self,
        rows: &Rows<R>,
        line: u32,
        column: Column,
    ) -> Result<Option<u32>, ReadingsError> {
        let Some(field) = self.noted(rows, line, column) else {
            return Ok(None);
        };
        let least = u32::from(column == Column::Attempt);
        match read_count(field) {
            Some(count) if count >= least => Ok(Some(count)),
            _ => {
                let expected = if least == 0 {
                    "a whole number from 0"
                } else {
                    "a whole number from 1"
                };
                Err(self.bad(line, column, field, expected))
            }
        }
    }

    fn number<R: Read>(
        &mut self,
        rows: &Rows<R>,
        line: u32,
        column: Column,
    ) -> Result<Option<f64>, ReadingsError> {
        let Some(field) = self.noted(rows, line, column) else {
            return Ok(None);
        };
        let Some((_, conversion)) = self.header.place(column) else {
            return Ok(None);
        };
        match self.numbers.read(field, conversion, line) {
            Ok(number) => Ok(Some(number)),
            Err(fault) => Err(number_error(
                self.file,
                line,
                self.header.name(column),
                field,
                fault,
            )),
        }
    }

    fn required_number<R: Read>(
        &mut self,
        rows: &Rows<R>,
        line: u32,
        column: Column,
    ) -> Result<f64, ReadingsError> {
        match self.number(rows, line, column)? {
            Some(number) => Ok(number),
            None => Err(self.missing(line, column, "a number")),
        }
    }

    /// The texts of a reading, if there are any; the instruments' own are kept with the blanks around them.
    fn texts<R: Read>(
        &mut self,
        rows: &Rows<R>,
        line: u32,
    ) -> Result<Option<Box<ReadingText>>, ReadingsError> {
        let zero_si = [
            self.number(rows, line, Column::ForceZero)?,
            self.number(rows, line, Column::DisplacementZero)?,
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
                (Some((index, _)), Column::Utc) => rows.field(index).trim_ascii(),
                (Some((index, _)), _) => rows.field(index),
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
            fields.map(|field| Box::from(&*self.decoded(field, line)));
        Ok(Some(Box::new(ReadingText {
            utc,
            force_raw,
            displacement_raw,
            zero_si,
            flag,
            note,
        })))
    }

    fn missing(&self, line: u32, column: Column, expected: &'static str) -> ReadingsError {
        ReadingsError::MissingValue {
            file: self.file.to_owned(),
            line,
            column: self.header.name(column),
            expected,
        }
    }

    fn bad(
        &self,
        line: u32,
        column: Column,
        value: &[u8],
        expected: &'static str,
    ) -> ReadingsError {
        ReadingsError::BadValue {
            file: self.file.to_owned(),
            line,
            column: self.header.name(column),
            value: text_of(value).0.into_owned(),
            expected,
        }
    }
}

/// The error for a field that is not a number.
pub(crate) fn number_error(
    file: &str,
    line: u32,
    column: String,
    field: &[u8],
    fault: NumberFault,
) -> ReadingsError {
    let file = file.to_owned();
    let value = text_of(field).0.into_owned();
    match fault {
        NumberFault::NotANumber => ReadingsError::BadValue {
            file,
            line,
            column,
            value,
            expected: "a number",
        },
        NumberFault::NotFinite => ReadingsError::NotFinite {
            file,
            line,
            column,
            value,
        },
        NumberFault::OtherDecimalSign(sign, first_line) => ReadingsError::MixedDecimals {
            file,
            line,
            column,
            value,
            sign: sign.word(),
            first_line,
        },
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
