//! What can be wrong with a table.

use std::fmt;

use miette::Diagnostic;
use thiserror::Error;

use crate::readings::FileCell;

/// A line of a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LinePlace {
    /// The file, as the caller named it.
    pub file: String,
    /// The line, from 1; the row of a sheet.
    pub line: u32,
}

impl LinePlace {
    pub(crate) fn new(file: &str, line: u32) -> Self {
        let file = file.to_owned();
        Self { file, line }
    }
}

impl fmt::Display for LinePlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, line {}", self.file, self.line)
    }
}

/// Why a table could not be read.
#[derive(Debug, Error, Diagnostic)]
pub enum TableFileError {
    /// Nothing in the file but blank lines and comments.
    #[error("{file}: the file is empty, expected a line with column names and rows of numbers")]
    #[diagnostic(
        code(stiffbench::table::empty),
        help("export the measured values as text, CSV or XLSX")
    )]
    Empty {
        /// The file.
        file: String,
    },
    /// No row has a number in it.
    #[error("{file}: no row of numbers was found")]
    #[diagnostic(
        code(stiffbench::table::no_numbers),
        help(
            "export the measured values as text, CSV or XLSX, one reading a row; a delimiter other than tab, semicolon, comma and blanks is \
             not known"
        )
    )]
    NoNumbers {
        /// The file.
        file: String,
    },
    /// Bytes that are no text.
    #[error("{at}: not text")]
    #[diagnostic(
        code(stiffbench::table::not_text),
        help(
            "export the measured values as text, CSV or XLSX; state the encoding of a text with --encoding"
        )
    )]
    NotText {
        /// The line.
        at: LinePlace,
    },
    /// A quote that opens and does not close.
    #[error("{at}: a quote opens and never ends")]
    #[diagnostic(
        code(stiffbench::table::unclosed_quote),
        help("close the quote, or remove it")
    )]
    UnclosedQuote {
        /// The line on which it opens.
        at: LinePlace,
    },
    /// A row with more fields than there are names.
    #[error("{at}: {found} fields, expected {expected}")]
    #[diagnostic(
        code(stiffbench::table::field_count),
        help(
            "are there decimal commas in a table delimited by commas? Then put the numbers in quotes or use another delimiter. Else give \
             every column a name"
        )
    )]
    FieldCount {
        /// The line.
        at: LinePlace,
        /// Number of names.
        expected: usize,
        /// Number of fields.
        found: usize,
    },
    /// Whole numbers between commas, in more fields than there are names, or without names in pairs.
    #[error(
        "{at}: the commas in `{row}` may delimit fields or be decimal signs, and nothing shows which"
    )]
    #[diagnostic(
        code(stiffbench::table::comma_or_decimal),
        help(
            "export with semicolons or tabs between the fields, or with decimal points, or put each number in quotes. If the numbers are whole, \
             give every column a name"
        )
    )]
    CommaOrDecimal {
        /// The line.
        at: LinePlace,
        /// The row.
        row: String,
    },
    /// A column that is named and is not there.
    #[error("{at}: no column `{column}` for the {role}; the columns are {found}")]
    #[diagnostic(code(stiffbench::table::unknown_column))]
    UnknownColumn {
        /// Line of the column names.
        at: LinePlace,
        /// The column.
        column: String,
        /// What it should be.
        role: String,
        /// The columns, each in backquotes.
        found: String,
        /// What could be meant.
        #[help]
        advice: String,
    },
    /// Two columns with one name, of which one is needed.
    #[error("{at}: columns {first} and {second} are both called `{column}`")]
    #[diagnostic(
        code(stiffbench::table::duplicate_column),
        help("name the intended column by its number: --map {role}={first}")
    )]
    DuplicateColumn {
        /// Line of the column names.
        at: LinePlace,
        /// The name.
        column: String,
        /// What it should be.
        role: String,
        /// Number of the first, from 1.
        first: usize,
        /// Number of the second.
        second: usize,
    },
    /// One column for two things.
    #[error("{file}: column `{column}` is named for the {first} and for the {second}")]
    #[diagnostic(
        code(stiffbench::table::same_column),
        help("name another column with --map {second}=COLUMN")
    )]
    SameColumn {
        /// The file.
        file: String,
        /// The column.
        column: String,
        /// What it should be.
        first: String,
        /// What it should be too.
        second: String,
    },
    /// Files that are to be read as one table have other columns.
    #[error("{at}: the columns are {found}, and those of {first} {expected}")]
    #[diagnostic(
        code(stiffbench::table::other_columns),
        help(
            "several files are the repeats of one table: read files with other columns by themselves"
        )
    )]
    OtherColumns {
        /// Line of the column names.
        at: LinePlace,
        /// Its columns, each in backquotes.
        found: String,
        /// The first file.
        first: String,
        /// The columns of that.
        expected: String,
    },
    /// A cell that should hold a number.
    #[error("{cell}: `{}`, expected a number", .cell.value)]
    #[diagnostic(
        code(stiffbench::table::bad_number),
        help("correct the value, or take the row out of a copy of the file")
    )]
    BadNumber {
        /// The field, with the text found.
        cell: FileCell,
    },
    /// A number that is not finite, or an instrument's mark for none.
    #[error("{cell}: `{}` is no value: it is not finite, or the mark of an instrument for a value beyond its range", .cell.value)]
    #[diagnostic(
        code(stiffbench::table::not_finite),
        help("correct the value, or take the row out of a copy of the file")
    )]
    NotFinite {
        /// The field, with the text found.
        cell: FileCell,
    },
    /// Numbers with a decimal comma and others with a decimal point.
    #[error("{cell}: `{}` has another decimal sign than line {first_line}", .cell.value)]
    #[diagnostic(
        code(stiffbench::table::mixed_decimals),
        help("write all numbers with the same decimal sign")
    )]
    MixedDecimals {
        /// The field, with the text found.
        cell: FileCell,
        /// A line with the other sign.
        first_line: u32,
    },
    /// Numbers whose mark may be that of decimals or of thousands.
    #[error("{cell}: the mark in `{}` may be a decimal sign or stand between thousands", .cell.value)]
    #[diagnostic(
        code(stiffbench::table::either_decimal),
        help(
            "state it with --decimal comma or --decimal point; stiffbench import takes --thousands too"
        )
    )]
    EitherDecimal {
        /// The field, with the text found.
        cell: FileCell,
    },
    /// Cells of a column with different units.
    #[error("{cell}: the unit is {}, and {expected} before", .cell.value)]
    #[diagnostic(
        code(stiffbench::table::mixed_units),
        help("write all values of a column in one unit")
    )]
    MixedUnits {
        /// The field, with the unit found.
        cell: FileCell,
        /// The unit of the lines before, or of the column's name.
        expected: String,
    },
    /// A cell among times that is none.
    #[error("{cell}: `{}`, expected a time like the others", .cell.value)]
    #[diagnostic(
        code(stiffbench::table::bad_time),
        help(
            "known are 2024-01-31T10:05:00.25, 31.01.2024 10:05:00, 1/31/2024 10:05:00 AM and 10:05:00.25; or leave the field empty"
        )
    )]
    BadTime {
        /// The field, with the text found.
        cell: FileCell,
    },
    /// Dates in which day and month cannot be distinguished.
    #[error("{cell}: is `{}` a day and a month, or a month and a day?", .cell.value)]
    #[diagnostic(
        code(stiffbench::table::day_or_month),
        help("write dates as 2024-01-31")
    )]
    DayOrMonth {
        /// The field, with the text found.
        cell: FileCell,
    },
    /// A spreadsheet that cannot be opened.
    #[error("{file}: the spreadsheet cannot be read: {problem}")]
    #[diagnostic(
        code(stiffbench::table::spreadsheet),
        help(
            "open it in the spreadsheet program and save it as XLSX without a password, or as CSV"
        )
    )]
    Spreadsheet {
        /// The file.
        file: String,
        /// What the reader of spreadsheets states.
        problem: String,
    },
    /// A sheet that is not there.
    #[error("{file}: no sheet `{sheet}` among {found}")]
    #[diagnostic(
        code(stiffbench::table::no_sheet),
        help("name one of these with --sheet")
    )]
    NoSheet {
        /// The file.
        file: String,
        /// The sheet asked for.
        sheet: String,
        /// The sheets, each in backquotes.
        found: String,
    },
    /// Several sheets hold numbers, in other columns.
    #[error("{file}: several sheets hold rows of numbers in other columns: {found}")]
    #[diagnostic(
        code(stiffbench::table::several_sheets),
        help("name one of these with --sheet")
    )]
    SeveralSheets {
        /// The file.
        file: String,
        /// The sheets with numbers, each in backquotes.
        found: String,
    },
    /// A sheet was named, and the file is no spreadsheet.
    #[error("{file}: the file is text and has no sheet `{sheet}`")]
    #[diagnostic(code(stiffbench::table::text_has_no_sheets), help("leave out --sheet"))]
    NoSpreadsheet {
        /// The file.
        file: String,
        /// The sheet asked for.
        sheet: String,
    },
    /// More lines than can be numbered.
    #[error("{file}: more than four thousand million lines")]
    #[diagnostic(code(stiffbench::table::too_long), help("divide the file"))]
    TooLong {
        /// The file.
        file: String,
    },
}
