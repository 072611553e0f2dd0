//! Tidy tables of measurements and results: one observation a row, one quantity with one unit a column.
//!
//! A [`TidyTable`] holds the fields as they are written. [`csv()`], [`xlsx()`] and `parquet` are three forms of the same tables.
//! [`data_package`] describes their files in the form of the Frictionless Data Package standard, [`ro_crate()`] in that of RO-Crate.

mod package;
#[cfg(feature = "parquet")]
mod parquet_file;
mod readings;
mod ro_crate;
mod spreadsheet;
mod stiffness;
mod table;

pub use package::{PackageResource, TableProvenance, data_package};
#[cfg(feature = "parquet")]
pub use parquet_file::parquet;
#[cfg(feature = "parquet")]
pub(crate) use parquet_file::write_parquet;
pub use readings::{load_case_table, reading_table};
pub use ro_crate::ro_crate;
pub use spreadsheet::{SpreadsheetError, xlsx};
pub use stiffness::{stiffness_tables, vector_stiffness_tables};
pub use table::{FieldKind, TidyColumn, TidyTable, csv, csv_of};
