//! Mistakes in a table of load cases: single values, units, signs, components under the name of each other.

mod bad_positions;
mod bad_values;
mod moved_columns;
mod table_mistake;
mod tested_values;

pub use bad_values::bad_load_case_values;
pub use table_mistake::{ExchangedWith, TableMistake, table_mistake};
