//! What was measured, as stored.
//!
//! The waist of the program: acquisition ends by writing a session folder, analysis begins by reading one. A reading keeps the
//! instrument's own text; one that is not used is marked and counted, never dropped. Everything a reader decides that the file does not
//! say is listed with the table, in sentences, as is everything it left out ([`Excluded`]).

mod assumption;
mod column;
mod csv;
mod defaults;
mod encoding;
mod error;
mod formula;
mod header;
mod joint_values;
mod number;
mod order;
mod procedure_toml;
mod reading;
mod row;
mod rows;
mod session_file;
mod session_toml;
mod since_zero;
mod table;
mod targets;
mod text_table;
mod toml_values;
mod vector_table;
mod write;

pub use assumption::Excluded;
pub use column::Column;
pub use csv::read_readings;
pub use error::TableError;
pub use formula::{escape_formula, unescape_formula};
pub use joint_values::{JointColumn, JointUnit, PoseJoints};
pub use number::DecimalSign;
pub use procedure_toml::PROCEDURE_SCHEMA;
pub use reading::{Reading, ReadingStatus, ReadingText};
pub use rows::FieldDelimiter;
pub use session_file::{
    Environment, ImportRecord, InstrumentRecord, Instruments, LOAD_CASE_SESSION_SCHEMA, LoadOrder,
    OverdueGauge, ProcedureRecord, ReadSession, ReadingLimits, RepeatOrder, SESSION_SCHEMA,
    SessionFileError, SessionFileProblem, SessionHeader, SettleRecord, ZeroScope,
};
pub use since_zero::SinceZero;
pub use table::{FieldRow, FileFields, ReadingTable, RunKey, RunNumbers, check_poses};
pub use vector_table::{is_readings_header, is_vector_table};
pub use write::{WrittenRows, write_readings, write_rows};

// What reads any table of numbers, for readers of other tables.
pub(crate) use assumption::{absent_columns, left_out};
pub(crate) use column::split_unit;
pub(crate) use encoding::is_spreadsheet;
pub(crate) use error::{FileCell, line_of};
pub(crate) use joint_values::PlacedJointColumn;
pub(crate) use number::{
    Conversion, NumberFault, NumberReader, decimal, read_count, write_decimal,
};
pub(crate) use reading::{BRANCH_WORDS, meaning_of};
pub(crate) use targets::are_one_load;
pub(crate) use text_table::RecordTable;
