//! What was measured, as stored.
//!
//! The waist of the program: acquisition ends by writing a session folder, analysis begins by reading one. A reading keeps the
//! instrument's own text; one that is not used is marked and counted, never dropped.

mod reading;

pub use reading::{Reading, ReadingText, Status};
