//! Load cases: a force and a moment at the end of a robot in one pose, and the displacement and rotation that were read as vectors.
//!
//! A load case is one load application: no series of loads, no gauge zero, repeats only where the table has them. Its components stand
//! along the axes that the table states; the robot that gives those axes a place is not known here.

mod columns;
mod read;
mod table;
mod write;

pub use crate::readings::{JointColumn, JointUnit};
pub use columns::is_load_case_table;
pub(crate) use columns::vector_columns;
pub use read::read_load_cases;
pub use table::{LoadAxes, LoadCase, LoadCaseTable, VectorQuantity};
pub use write::write_load_cases;
