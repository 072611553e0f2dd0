//! The same readings must get the same answer by every door.
//!
//! A door is a way into the program: a session folder, or the table of forces and displacements as vectors. Each is judged at the border, by tables
//! in and JSON out, so that what stands between may change.
//!
//! - [`benches`]: a sample of each law of the library, on each bench.
//! - [`vector_table`]: the readings of a session as a table of vectors.
//! - [`answer`]: what a door says, and how two answers differ.
//! - [`coverage`]: how often intervals hold the truth, by door.
//! - [`forced`]: the same of laws that are stated and not searched.
//! - [`part`]: recordings of a part for them.
//! - [`ledger`]: the differences of today.

mod answer;
mod benches;
mod coverage;
mod forced;
mod ledger;
mod part;
mod vector_table;

pub use answer::{DoorAnswer, differences, is_named};
pub use benches::{DoorBench, DoorBenches};
pub use coverage::{CoverageRow, coverage};
pub use forced::{ForcedPoint, stated_values};
pub use ledger::{DoorJudge, DoorLedger, JudgedCase, disagreements};
pub use part::PartBench;
pub use vector_table::vector_table;
