//! Tables as test machines, loggers, spreadsheets and people write them.
//!
//! One reader for exports of testing machines (a block of lines above the names, a row of units), LabVIEW measurement files, text with any
//! usual delimiter and decimal sign, and spreadsheets. It finds where the table begins and ends, what its columns are called and in
//! which units they are, and states what it took for what ([`FileLayout`]). What the columns mean is decided by those who read from it.

mod cell;
mod columns;
mod decode;
mod find;
mod joined;
pub(crate) mod keywords;
mod labview;
mod layout;
mod marks;
mod names;
mod options;
mod read;
mod records;
mod sheet;
mod sheet_size;
mod table;
mod times;
mod unit_cells;

/// Columns that tell apart what is read as one table: its segments, files or sheets, and columns that stand below each other.
pub(crate) const OWN_COLUMNS: [&str; 4] = ["segment", "file", "sheet", "series"];

pub use crate::readings::FieldDelimiter;
pub use columns::{FileColumn, StatedUnit};
pub use layout::{FileLayout, TextEncoding};
pub use options::{TableFileOptions, ThreeDigits};
pub use read::{read_table_file, read_table_files};
pub use table::{FileRow, MachineTable};
pub use times::StampKind;
