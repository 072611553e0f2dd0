//! Lines to records: delimiter, quotes, comments, blank lines, each with the right line number.

use std::fmt;
use std::io::Read;

use csv_core::ReadRecordResult;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::column::{NamedColumn, understand};
use super::encoding::{Encoding, Utf8Source};
use super::error::{TableError, line_of};

/// What delimits the fields of a text.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum FieldDelimiter {
    /// A tab.
    Tab,
    /// `;`
    Semicolon,
    /// `,`
    Comma,
    /// One or more blanks or tabs.
    Blanks,
}

impl FieldDelimiter {
    /// All, in the order in which a table of another program is tried with them.
    pub(crate) const ALL: [Self; 4] = [Self::Tab, Self::Semicolon, Self::Comma, Self::Blanks];

    /// Those a header of readings is tried with, in order of preference.
    const OF_READINGS: [Self; 3] = [Self::Comma, Self::Semicolon, Self::Tab];

    /// The sign between two fields; `None` for blanks, of which there may be several.
    pub(crate) fn sign(self) -> Option<char> {
        match self {
            Self::Tab => Some('\t'),
            Self::Semicolon => Some(';'),
            Self::Comma => Some(','),
            Self::Blanks => None,
        }
    }

    /// The delimiter under which most names of a header are understood; with none understood, the one that splits it most.
    fn of_header(header: &str) -> Self {
        let score = |delimiter: &Self| {
            let names = header.split(delimiter.sign().unwrap_or(','));
            let understood = names
                .clone()
                .filter(|name| understand(name.trim().trim_matches('"')) != NamedColumn::Unknown);
            (understood.count(), names.count())
        };
        // The last maximum wins in max_by_key, hence the reversal: with equal scores the comma is taken.
        Self::OF_READINGS
            .into_iter()
            .rev()
            .max_by_key(score)
            .unwrap_or(Self::Comma)
    }
}

impl fmt::Display for FieldDelimiter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// Reads one record after another from text in any of the accepted encodings.
///
/// Lines are taken one by one and handed to the CSV automaton of `csv-core`, so that the line number of a record is exact after quoted
/// line breaks, blank lines, comments and `\r\n`, and a quote that never closes is noticed.
pub(super) struct Rows<'a> {
    file: String,
    input: Utf8Source<'a>,
    parser: csv_core::Reader,
    delimiter: FieldDelimiter,
    /// The line being worked on, with its line end.
    line: Vec<u8>,
    lines_taken: u32,
    header_pending: bool,
    fields: Vec<u8>,
    ends: Vec<usize>,
    count: usize,
    trim_last: bool,
    /// Lines that hold nothing but blanks and delimiters.
    pub(super) blank: Vec<u32>,
    /// Lines that start with `#`, and the `sep=` line of a spreadsheet.
    pub(super) comments: Vec<u32>,
}

impl<'a> Rows<'a> {
    /// Finds the header and how its fields are delimited.
    pub(super) fn open(file: &str, input: impl Read + 'a) -> Result<Self, TableError> {
        let input = Utf8Source::new(input).map_err(|error| input_error(file, 0, error))?;
        if input.is_spreadsheet {
            return Err(TableError::new(
                "stiffbench::readings::spreadsheet",
                format!(
                    "{file}: the file is a spreadsheet or an archive, and this command reads text"
                ),
                "stiffbench import FILE --out FOLDER makes a session of a spreadsheet; or save the sheet as CSV",
            ));
        }
        let mut rows = Self {
            file: file.to_owned(),
            input,
            parser: csv_core::Reader::new(),
            delimiter: FieldDelimiter::Comma,
            line: Vec::new(),
            lines_taken: 0,
            header_pending: false,
            fields: Vec::new(),
            ends: vec![0; 32],
            count: 0,
            trim_last: false,
            blank: Vec::new(),
            comments: Vec::new(),
        };
        rows.find_header()?;
        let sign = rows.delimiter.sign();
        let sign = sign.and_then(|sign| u8::try_from(sign).ok());
        rows.parser = csv_core::ReaderBuilder::new()
            .delimiter(sign.unwrap_or(b','))
            .terminator(csv_core::Terminator::Any(b'\n'))
            .build();
        Ok(rows)
    }

    fn find_header(&mut self) -> Result<(), TableError> {
        let mut told = None;
        while self.take_line()? {
            if self.line.contains(&0) {
                return Err(self.not_text());
            }
            if self.is_passed_over() {
                continue;
            }
            let header = text_of(&self.line).0;
            // Spreadsheets understand a first line `sep=;`.
            if let Some(sign) = header.trim_ascii().strip_prefix("sep=") {
                let named = FieldDelimiter::OF_READINGS
                    .into_iter()
                    .find(|known| known.sign().is_some_and(|known| sign == known.to_string()));
                if named.is_some() || sign.is_empty() {
                    // A tab is trimmed away with the blanks around the line.
                    told = told.or(named).or(Some(FieldDelimiter::Tab));
                    self.comments.push(self.lines_taken);
                    continue;
                }
            }
            self.delimiter = told.unwrap_or_else(|| FieldDelimiter::of_header(&header));
            self.header_pending = true;
            return Ok(());
        }
        Err(self.empty())
    }

    /// The error for a file with nothing but blank lines and comments.
    pub(super) fn empty(&self) -> TableError {
        TableError::new(
            "stiffbench::readings::empty",
            format!(
                "{}: the file is empty, expected a header line with column names",
                self.file
            ),
            "the smallest table has the columns pose,direction,repeat,force_N,displacement_um",
        )
    }

    pub(super) fn file(&self) -> &str {
        &self.file
    }

    fn not_text(&self) -> TableError {
        TableError::new(
            "stiffbench::readings::not_text",
            format!(
                "{}: the bytes here are not text",
                line_of(&self.file, self.lines_taken)
            ),
            "save the table as UTF-8 text; UTF-16 needs its byte order mark",
        )
    }

    pub(super) fn delimiter(&self) -> FieldDelimiter {
        self.delimiter
    }

    pub(super) fn encoding(&self) -> Encoding {
        self.input.encoding
    }

    pub(super) fn lone_carriage_return(&self) -> bool {
        self.input.lone_carriage_return
    }

    /// Moves to the next record and gives the line it starts on; `None` at the end.
    pub(super) fn next_record(&mut self) -> Result<Option<u32>, TableError> {
        loop {
            if !std::mem::take(&mut self.header_pending) {
                if !self.take_line()? {
                    return Ok(None);
                }
                if self.is_passed_over() {
                    continue;
                }
            }
            let start = self.lines_taken;
            self.split_record(start)?;
            if (0..self.count).all(|index| self.field(index).trim_ascii().is_empty()) {
                self.blank.push(start);
                continue;
            }
            return Ok(Some(start));
        }
    }

    /// Number of fields of the current record.
    pub(super) fn len(&self) -> usize {
        self.count
    }

    /// Field `index` of the current record as it stands in the file, without quotes; empty beyond the last.
    pub(super) fn field(&self, index: usize) -> &[u8] {
        if index >= self.count {
            return &[];
        }
        let start = if index == 0 { 0 } else { self.ends[index - 1] };
        let field = &self.fields[start..self.ends[index]];
        match field {
            [rest @ .., b'\r'] if self.trim_last && index + 1 == self.count => rest,
            _ => field,
        }
    }

    fn take_line(&mut self) -> Result<bool, TableError> {
        self.line.clear();
        let taken = self
            .input
            .read_line(&mut self.line)
            .map_err(|error| input_error(&self.file, self.lines_taken, error))?;
        if taken == 0 {
            return Ok(false);
        }
        self.lines_taken = self.lines_taken.checked_add(1).ok_or_else(|| {
            TableError::new(
                "stiffbench::readings::too_long",
                format!("{}: more than 4294967295 lines", self.file),
                "split the file by session",
            )
        })?;
        let replaced = |text: &[u8]| text.windows(3).any(|bytes| bytes == "\u{fffd}".as_bytes());
        if self.encoding() == Encoding::Utf16 && replaced(&self.line) {
            return Err(self.not_text());
        }
        // A last line without an end is as good as one with it.
        if self.line.last() != Some(&b'\n') {
            self.line.push(b'\n');
        }
        Ok(true)
    }

    /// Whether the line is blank or a comment; if so it is put on its list.
    fn is_passed_over(&mut self) -> bool {
        if self.line.first() == Some(&b'#') {
            self.comments.push(self.lines_taken);
            true
        } else if self.line.trim_ascii().is_empty() {
            self.blank.push(self.lines_taken);
            true
        } else {
            false
        }
    }

    /// Splits the line, and those after it as long as a quote is open, into fields.
    fn split_record(&mut self, start: u32) -> Result<(), TableError> {
        let (mut written, mut count, mut read) = (0, 0, 0);
        loop {
            let needed = written + self.line.len() - read + 1;
            if self.fields.len() < needed {
                self.fields.resize(needed, 0);
            }
            let (result, taken, put, ended) = self.parser.read_record(
                &self.line[read..],
                &mut self.fields[written..],
                &mut self.ends[count..],
            );
            read += taken;
            written += put;
            count += ended;
            match result {
                ReadRecordResult::OutputEndsFull => self.ends.resize(self.ends.len() * 2, 0),
                ReadRecordResult::OutputFull => self.fields.resize(self.fields.len() * 2, 0),
                ReadRecordResult::Record | ReadRecordResult::End => break,
                ReadRecordResult::InputEmpty => {
                    read = 0;
                    if !self.take_line()? {
                        return Err(TableError::new(
                            "stiffbench::readings::unclosed_quote",
                            format!(
                                "{}: a quoted field that starts here never ends",
                                line_of(&self.file, start)
                            ),
                            "close the quotation mark, or double it if it belongs to the text",
                        ));
                    }
                }
            }
        }
        self.count = count;
        self.trim_last = self.line.ends_with(b"\r\n");
        Ok(())
    }
}

/// UTF-8 if it is, else each byte as the character of that number (ISO 8859-1); whether the latter was needed.
pub(crate) fn text_of(bytes: &[u8]) -> (std::borrow::Cow<'_, str>, bool) {
    if let Ok(text) = std::str::from_utf8(bytes) {
        return (text.into(), false);
    }
    let text: String = bytes.iter().copied().map(char::from).collect();
    (text.into(), true)
}

fn input_error(file: &str, line: u32, error: std::io::Error) -> TableError {
    TableError::new(
        "stiffbench::readings::io",
        format!("{file}: reading stopped after line {line}"),
        "the file or stream could not be read to its end; see the cause",
    )
    .caused_by(error)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn records(text: &str) -> Result<Vec<(u32, Vec<String>)>, TableError> {
        let mut rows = Rows::open("t.csv", text.as_bytes())?;
        let mut records = Vec::new();
        while let Some(line) = rows.next_record()? {
            let fields = (0..rows.len()).map(|i| text_of(rows.field(i)).0.into_owned());
            records.push((line, fields.collect()));
        }
        Ok(records)
    }

    #[test]
    fn line_numbers_are_those_of_an_editor() {
        let text =
            "# made by hand\r\n\r\npose,note\r\nP1,\"two\r\nlines\"\r\n\r\n# aside\r\nP2,b\r\nP3,";
        let found = records(text).unwrap();
        let lines: Vec<u32> = found.iter().map(|(line, _)| *line).collect();
        assert_eq!(lines, [3, 4, 8, 9]);
        assert_eq!(found[1].1, ["P1", "two\r\nlines"]);
        assert_eq!(found[2].1, ["P2", "b"]);
        assert_eq!(found[3].1, ["P3", ""]);
    }

    #[test]
    fn what_is_passed_over_is_listed() {
        let mut rows = Rows::open("t.csv", &b"pose;note\n#x\n;;\n\nP1;a\n"[..]).unwrap();
        while rows.next_record().unwrap().is_some() {}
        assert_eq!((rows.blank, rows.comments), (vec![3, 4], vec![2]));
    }

    #[test]
    fn delimiters_are_recognised() {
        let delimiter = |text: &str| Rows::open("t", text.as_bytes()).unwrap().delimiter();
        assert_eq!(delimiter("pose,direction"), FieldDelimiter::Comma);
        assert_eq!(
            delimiter("pose;direction;force_N"),
            FieldDelimiter::Semicolon
        );
        assert_eq!(delimiter("pose\tdirection"), FieldDelimiter::Tab);
        assert_eq!(delimiter("sep=;\na,b"), FieldDelimiter::Semicolon);
        assert_eq!(delimiter("pose"), FieldDelimiter::Comma);
        // The comma stands in a name here; the names are understood only when split at the semicolon.
        assert_eq!(
            delimiter("pose;force_N;note, free, text"),
            FieldDelimiter::Semicolon
        );
    }

    #[test]
    fn quotes_at_the_start_of_a_record_protect_a_hash() {
        let found = records("pose\n\"#1\"\n").unwrap();
        assert_eq!(found[1].1, ["#1"]);
    }

    #[test]
    fn an_open_quote_is_reported_where_it_starts() {
        let error = records("pose,note\nP1,\"a\nP2,b\n").unwrap_err();
        assert_eq!(
            error.to_string(),
            "t.csv, line 2: a quoted field that starts here never ends"
        );
    }

    #[test]
    fn empty_and_binary_input_are_distinguished() {
        let error = |text: &str| records(text).unwrap_err();
        assert_eq!(error("").code, "stiffbench::readings::empty");
        assert_eq!(error("\n# nothing\n").code, "stiffbench::readings::empty");
        let zeros = error("p\0o\0s\0e\0").to_string();
        assert_eq!(zeros, "t.csv, line 1: the bytes here are not text");
    }

    #[test]
    fn broken_utf16_is_no_text() {
        for broken in [&b"\xFF\xFEa\0\n\0b"[..], b"\xFF\xFEa\0\n\0\x00\xD8b\0"] {
            let error = Rows::open("t.csv", broken).and_then(|mut rows| {
                rows.next_record()?;
                rows.next_record()
            });
            let error = error.unwrap_err().to_string();
            assert_eq!(error, "t.csv, line 2: the bytes here are not text");
        }
    }

    #[test]
    fn spreadsheets_are_named() {
        for bytes in [&b"PK\x03\x04\x14\0"[..], b"\xD0\xCF\x11\xE0\xA1\xB1"] {
            let Err(error) = Rows::open("t.xlsx", bytes) else {
                panic!("{bytes:?}");
            };
            assert_eq!(error.code, "stiffbench::readings::spreadsheet");
            let help = miette::Diagnostic::help(&error).unwrap().to_string();
            assert!(help.contains("stiffbench import FILE"), "{help}");
        }
        assert!(Rows::open("t.csv", &b"PK,b\n1,2\n"[..]).is_ok());
    }

    #[test]
    fn many_fields_and_long_fields_fit() {
        let wide = vec!["a"; 100].join(",");
        let long = "b".repeat(100_000);
        let found = records(&format!("{wide}\n{long}\n")).unwrap();
        assert_eq!(found[0].1.len(), 100);
        assert_eq!(found[1].1, [long]);
    }
}
