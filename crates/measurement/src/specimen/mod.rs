//! A table of force against displacement, or of any two quantities, with no robot behind it.
//!
//! The reader takes what the caller names: which columns, in which units, what distinguishes runs and specimens. It decides nothing about
//! a unit; what it does decide (branches from the path of the load, an order of readings) is listed with the table, as is every row it
//! leaves out. What the numbers mean, and which law they follow, is decided elsewhere.

mod branches;
mod clock;
mod columns;
mod excluded;
mod options;
mod order;
mod read;
mod response;
mod row;
mod table;
mod thin;

pub use excluded::{ExcludedLines, Incomplete};
pub use options::{SpecimenOptions, TURN_SHARE};
pub use read::read_specimen;
pub use response::{ResponseDoubt, ResponseVariable};
// The path of a load, for other readers of tables.
pub(crate) use branches::follow;
pub use table::{ColumnUnit, SpecimenReading, SpecimenRun, SpecimenTable};
