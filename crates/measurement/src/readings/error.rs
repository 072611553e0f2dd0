//! What can be wrong with a table of readings.

use std::fmt;

use miette::Diagnostic;
use thiserror::Error;

/// A field of a table, as messages name it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct FileCell {
    /// The file.
    pub file: String,
    /// The line.
    pub line: u32,
    /// The column, as named in the file.
    pub column: String,
    /// The text found.
    pub value: String,
}

impl fmt::Display for FileCell {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self {
            file, line, column, ..
        } = self;
        write!(f, "{file}, line {line}, column `{column}`")
    }
}

/// Why a table of readings could not be read or written.
///
/// Every variant that concerns a place in a file names the file and the line; [`ReadingsError::line`] gives the latter.
#[derive(Debug, Error, Diagnostic)]
pub enum ReadingsError {
    /// The input stopped.
    #[error("{file}: reading stopped after line {line}")]
    #[diagnostic(
        code(stiffbench::readings::io),
        help("the file or stream could not be read to its end; see the cause")
    )]
    Io {
        /// The file, as the caller named it.
        file: String,
        /// Last complete line, from 1; 0 if there was none.
        line: u32,
        /// The error of the input.
        #[source]
        error: std::io::Error,
    },
    /// The bytes are not text, or a UTF-16 text breaks off.
    #[error("{file}, line {line}: the bytes here are not text")]
    #[diagnostic(
        code(stiffbench::readings::not_text),
        help("save the table as UTF-8 text; UTF-16 needs its byte order mark")
    )]
    NotText {
        /// The file.
        file: String,
        /// The line.
        line: u32,
    },
    /// The file is a spreadsheet, or another archive that begins like one.
    #[error("{file}: the file is a spreadsheet or an archive, and this command reads text")]
    #[diagnostic(
        code(stiffbench::readings::spreadsheet),
        help(
            "stiffbench import FILE --out FOLDER makes a session of a spreadsheet; or save the sheet as CSV"
        )
    )]
    Spreadsheet {
        /// The file.
        file: String,
    },
    /// Nothing in the file but blank lines and comments.
    #[error("{file}: the file is empty, expected a header line with column names")]
    #[diagnostic(
        code(stiffbench::readings::empty),
        help("the smallest table has the columns pose,direction,repeat,force_N,displacement_um")
    )]
    Empty {
        /// The file.
        file: String,
    },
    /// A header and nothing below it.
    #[error("{file}, line {line}: no reading follows the header")]
    #[diagnostic(
        code(stiffbench::readings::no_readings),
        help("one line per reading must follow the column names")
    )]
    NoReadings {
        /// The file.
        file: String,
        /// Line of the header.
        line: u32,
    },
    /// More lines than can be counted.
    #[error("{file}: more than 4294967295 lines")]
    #[diagnostic(
        code(stiffbench::readings::too_long),
        help("split the file by session")
    )]
    TooLong {
        /// The file.
        file: String,
    },
    /// A quoted field does not end.
    #[error("{file}, line {line}: a quoted field that starts here never ends")]
    #[diagnostic(
        code(stiffbench::readings::unclosed_quote),
        help("close the quotation mark, or double it if it belongs to the text")
    )]
    UnclosedQuote {
        /// The file.
        file: String,
        /// Line on which the record starts.
        line: u32,
    },
    /// A column that must be there is not.
    #[error("{file}, line {line}: no column `{column}`{others} among {found}")]
    #[diagnostic(code(stiffbench::readings::missing_column))]
    MissingColumn {
        /// The file.
        file: String,
        /// Line of the header.
        line: u32,
        /// The column's name.
        column: &'static str,
        /// Further columns that are missing, as they follow in the sentence.
        others: String,
        /// The names found, each in backquotes.
        found: String,
        /// What to do, with the nearest name if there is one.
        #[help]
        advice: String,
    },
    /// Two columns mean the same.
    #[error("{file}, line {line}: `{first}` and `{second}` both give {column}")]
    #[diagnostic(
        code(stiffbench::readings::duplicate_column),
        help("remove one of the two columns, or rename it")
    )]
    DuplicateColumn {
        /// The file.
        file: String,
        /// Line of the header.
        line: u32,
        /// The column's name.
        column: &'static str,
        /// The column taken first, as named in the file.
        first: String,
        /// The other one.
        second: String,
    },
    /// The unit in a column's name is missing, unknown, or of another kind.
    #[error(
        "{file}, line {line}: column `{column}` has {unit} for its unit, expected one of {accepted}"
    )]
    #[diagnostic(
        code(stiffbench::readings::wrong_unit),
        help(
            "write the unit after an underscore: force_N, force_lbf, displacement_mm, temp_degC, force_x_N, joint_J1_deg"
        )
    )]
    WrongUnit {
        /// The file.
        file: String,
        /// Line of the header.
        line: u32,
        /// The column, as named in the file.
        column: String,
        /// The unit in backquotes, or `none`.
        unit: String,
        /// The units of this kind.
        accepted: &'static str,
    },
    /// A line has more or fewer fields than the header.
    #[error("{file}, line {line}: {found} fields, expected {expected} as in the header")]
    #[diagnostic(
        code(stiffbench::readings::field_count),
        help(
            "if numbers have a decimal comma, the delimiter must be `;` or a tab, or the numbers must be quoted"
        )
    )]
    FieldCount {
        /// The file.
        file: String,
        /// The line.
        line: u32,
        /// Fields of the header.
        expected: usize,
        /// Fields of this line.
        found: usize,
    },
    /// A field that must hold something is empty.
    #[error("{cell}: nothing, expected {expected}")]
    #[diagnostic(
        code(stiffbench::readings::missing_value),
        help("fill the field, or leave the line out")
    )]
    MissingValue {
        /// The field.
        cell: FileCell,
        /// What belongs there.
        expected: &'static str,
    },
    /// A field holds something else than what belongs there.
    #[error("{cell}: `{}`, expected {expected}", .cell.value)]
    #[diagnostic(
        code(stiffbench::readings::bad_value),
        help(
            "correct the value; a reading that does not count is marked `rejected` under `status`"
        )
    )]
    BadValue {
        /// The field, with the text found.
        cell: FileCell,
        /// What belongs there.
        expected: &'static str,
    },
    /// NaN, infinity, or a number too large to hold.
    #[error("{cell}: `{}` is not a finite number", .cell.value)]
    #[diagnostic(
        code(stiffbench::readings::not_finite),
        help("leave out the line, or the value if the column is optional")
    )]
    NotFinite {
        /// The field, with the text found.
        cell: FileCell,
    },
    /// The decimal sign changes within the file, or a number has both.
    #[error("{cell}: `{}` does not have the decimal {sign} of line {first_line}", .cell.value)]
    #[diagnostic(
        code(stiffbench::readings::mixed_decimals),
        help("use one decimal sign throughout and no grouping of thousands")
    )]
    MixedDecimals {
        /// The field, with the text found.
        cell: FileCell,
        /// `point` or `comma`.
        sign: &'static str,
        /// The line that settled the sign.
        first_line: u32,
    },
    /// Two accepted readings claim the same place.
    #[error("{file}, line {line}: the same reading as line {first_line} ({place}), both accepted")]
    #[diagnostic(
        code(stiffbench::readings::duplicate_reading),
        help(
            "mark one of them `superseded` under `status`, or distinguish them by `attempt` or `hold_s`"
        )
    )]
    DuplicateReading {
        /// The file.
        file: String,
        /// The later line.
        line: u32,
        /// The earlier line.
        first_line: u32,
        /// Pose, direction, branch, step, repeat, attempt.
        place: String,
    },
    /// Readings of more than one session in one file.
    #[error("{file}, line {line}: session `{second}`, but line {first_line} has session `{first}`")]
    #[diagnostic(
        code(stiffbench::readings::several_sessions),
        help(
            "times and gauge zeros of different sessions do not compare; write each session into its own file"
        )
    )]
    SeveralSessions {
        /// The file.
        file: String,
        /// First line of the other session.
        line: u32,
        /// The session the file starts with.
        first: String,
        /// Its first line.
        first_line: u32,
        /// The other session.
        second: String,
    },
    /// A pose that the robot or procedure does not have.
    #[error("{file}, line {line}, column `pose`: `{pose}` is not one of the known poses {known}")]
    #[diagnostic(code(stiffbench::readings::unknown_pose))]
    UnknownPose {
        /// The file.
        file: String,
        /// First line with this pose.
        line: u32,
        /// The name found.
        pose: String,
        /// The known names.
        known: String,
        /// What to do, with the nearest name if there is one.
        #[help]
        advice: String,
    },
    /// A number that a file cannot hold.
    #[error("reading {seq}: {column} is {value}, which a table cannot hold")]
    #[diagnostic(
        code(stiffbench::readings::not_writable),
        help("readings are finite numbers; leave out optional values that are not known")
    )]
    NotWritable {
        /// Sequence number of the reading.
        seq: u32,
        /// The column.
        column: &'static str,
        /// The value, SI.
        value: f64,
    },
    /// The output stopped.
    #[error("the table of readings could not be written")]
    #[diagnostic(
        code(stiffbench::readings::write),
        help("see the cause; what was flushed before is complete")
    )]
    Write {
        /// The error of the output.
        #[source]
        error: csv::Error,
    },
}

impl ReadingsError {
    /// The line the error is about, from 1; `None` if it concerns no single line.
    #[must_use]
    pub fn line(&self) -> Option<u32> {
        match self {
            Self::Io { line, .. }
            | Self::NotText { line, .. }
            | Self::NoReadings { line, .. }
            | Self::UnclosedQuote { line, .. }
            | Self::MissingColumn { line, .. }
            | Self::DuplicateColumn { line, .. }
            | Self::WrongUnit { line, .. }
            | Self::FieldCount { line, .. }
            | Self::DuplicateReading { line, .. }
            | Self::SeveralSessions { line, .. }
            | Self::UnknownPose { line, .. } => Some(*line),
            Self::MissingValue { cell, .. }
            | Self::BadValue { cell, .. }
            | Self::NotFinite { cell }
            | Self::MixedDecimals { cell, .. } => Some(cell.line),
            Self::Empty { .. }
            | Self::Spreadsheet { .. }
            | Self::TooLong { .. }
            | Self::NotWritable { .. }
            | Self::Write { .. } => None,
        }
    }
}
