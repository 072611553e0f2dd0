//! What the reader took for what.

use std::borrow::Cow;
use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::columns::FileColumn;
use crate::readings::FieldDelimiter;

/// How the text of a file is encoded.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub enum TextEncoding {
    /// UTF-8, or its ASCII part.
    #[serde(rename = "UTF-8")]
    Utf8,
    /// UTF-8 behind a byte order mark.
    #[serde(rename = "UTF-8 with byte order mark")]
    Utf8Marked,
    /// UTF-16, with a byte order mark or without.
    #[serde(rename = "UTF-16")]
    Utf16,
    /// The code page of Windows for western Europe.
    #[serde(rename = "windows-1252")]
    Windows1252,
    /// The code page of Windows for central Europe.
    #[serde(rename = "windows-1250")]
    Windows1250,
    /// The code page of Windows for Cyrillic.
    #[serde(rename = "windows-1251")]
    Windows1251,
    /// The code page of Windows for Turkish.
    #[serde(rename = "windows-1254")]
    Windows1254,
    /// Chinese.
    #[serde(rename = "GB18030")]
    Gb18030,
    /// Japanese.
    #[serde(rename = "Shift-JIS")]
    ShiftJis,
    /// A spreadsheet.
    #[serde(rename = "spreadsheet")]
    Spreadsheet,
}

impl fmt::Display for TextEncoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// What the reader of a table took for what.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FileLayout {
    /// The program that wrote the file, where its marks are in it.
    pub program: Option<Cow<'static, str>>,
    /// Encoding of the text.
    pub encoding: TextEncoding,
    /// The sheet, of a spreadsheet.
    pub sheet: Option<String>,
    /// What delimits fields; `null` of a spreadsheet.
    pub delimiter: Option<FieldDelimiter>,
    /// The decimal sign, `.` or `,`.
    pub decimal: char,
    /// The sign between thousands, where numbers have one.
    pub thousands: Option<char>,
    /// Line of the column names (row of a sheet), from 1; `null` if there are none and columns are called `column 1`, `column 2`, ….
    pub header_line: Option<u32>,
    /// Line of the units, where they have a row of their own.
    pub units_line: Option<u32>,
    /// Lines above the table that hold something else.
    pub lines_above: u32,
    /// First line with a row.
    pub first_line: u32,
    /// Last line with a row.
    pub last_line: u32,
    /// Number of rows.
    pub rows: usize,
    /// How often the table begins again with its names; 1 if it does not.
    pub segments: u32,
    /// Lines below the table, or between its segments, that hold something else.
    pub other_lines: Vec<u32>,
    /// The columns.
    pub columns: Vec<FileColumn>,
}

/// One line.
impl fmt::Display for FileLayout {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lines = if self.sheet.is_some() { "row" } else { "line" };
        f.write_str("table taken as ")?;
        if let Some(program) = &self.program {
            write!(f, "{program}, ")?;
        }
        self.encoding.fmt(f)?;
        if let Some(sheet) = &self.sheet {
            write!(f, " (sheet `{sheet}`)")?;
        }
        if let Some(delimiter) = self.delimiter {
            let decimal = if self.decimal == ',' {
                "comma"
            } else {
                "point"
            };
            write!(f, ", delimiter {delimiter}, decimal {decimal}")?;
        }
        match self.thousands {
            Some(sign) if sign.is_whitespace() => f.write_str(", thousands by blanks")?,
            Some(sign) => write!(f, ", thousands by `{sign}`")?,
            None => {}
        }
        match self.header_line {
            Some(line) => write!(f, "; names in {lines} {line}")?,
            None => f.write_str("; no names, columns are called `column 1`, `column 2`, …")?,
        }
        if let Some(line) = self.units_line {
            write!(f, ", units in {lines} {line}")?;
        }
        write!(
            f,
            "; {} rows in {lines}s {} to {}",
            self.rows, self.first_line, self.last_line
        )?;
        if self.segments > 1 {
            write!(f, " in {} segments (column `segment`)", self.segments)?;
        }
        if self.lines_above > 0 {
            write!(f, "; {} {lines}s above are no part of it", self.lines_above)?;
        }
        if let Some(first) = self.other_lines.first() {
            let n = self.other_lines.len();
            write!(f, "; {n} {lines}s from {first} on are no rows of it")?;
        }
        let units = self.columns.iter().filter_map(|column| {
            let unit = column.unit.as_ref()?;
            Some(format!("`{}` in {unit}", column.name))
        });
        let units: Vec<String> = units.collect();
        if !units.is_empty() {
            write!(f, "; {}", units.join(", "))?;
        }
        Ok(())
    }
}
