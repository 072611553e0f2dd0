//! Tables of other programs to readings: which column is what, in which unit, and where runs begin.
//!
//! [`ImportDraft::read`] reads a table, guesses its columns from their names in six languages and from their units, and lists what is
//! missing. [`ImportDraft::finish`] makes readings of it. Whatever is guessed can be stated instead ([`ImportMapping`]), and what was
//! guessed is given back as such a mapping, for the next file of the same form.

mod build;
mod columns;
mod draft;
mod guess;
mod joint_unit;
mod joints;
mod keywords;
mod mapping;
mod measured;
mod note;
mod pairs;
mod runs;
mod values;
mod vector_role;
mod vectors;

pub use build::ImportedReadings;
pub use columns::{ColumnGuess, GuessedFrom, ImportedQuantity, MissingPart};
pub use draft::ImportDraft;
pub use mapping::{ImportMapping, MAPPING_SCHEMA, MappedColumns, MappedUnits, MarkWord};
pub use note::ImportNotes;
pub use runs::{CounterDoubt, RunDoubt};
pub use vectors::VectorText;
