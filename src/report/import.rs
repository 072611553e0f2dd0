//! An import: what the columns of a file were taken for, and what became of them.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use crate::import::{ColumnGuess, GuessedFrom};
use crate::stiffness::StiffnessTable;

use super::stiffness::stiffness_document;
use crate::count::counted;
use stiffbench_document::{Document, Table};

/// A table that became a session folder.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ImportReport {
    /// The session folder.
    pub folder: PathBuf,
    /// The file that was imported.
    pub source: String,
    /// Its SHA-256, in hexadecimal.
    pub source_sha256: String,
    /// SHA-256 of the mapping of its columns, in hexadecimal.
    pub mapping_sha256: String,
    /// The columns of the file and what they were taken for.
    pub columns: Vec<ColumnGuess>,
    /// Number of readings.
    pub readings: usize,
    /// Number of runs.
    pub runs: usize,
    /// Poses, in the order in which they appear.
    pub poses: Vec<String>,
    /// Stiffness of the readings.
    pub stiffness: StiffnessTable,
}

impl ImportReport {
    /// The import in words.
    #[must_use]
    pub fn document(&self) -> Document {
        let folder = self.folder.display();
        let mut document = columns_document(&self.columns);
        if self.stiffness.cells.is_empty() && self.stiffness.skipped.is_empty() {
            document.paragraph(format!(
                "{} of vectors in {}, poses {}, written to {folder}.",
                counted(self.readings, "reading"),
                counted(self.poses.len(), "pose"),
                self.poses.join(", "),
            ));
            document.next(format!(
                "fit {folder} --robot FILE, and stiffbench diagnose {folder} --robot FILE."
            ));
            return document;
        }
        document.paragraph(format!(
            "{} in {}, poses {}, written to {folder}.",
            counted(self.readings, "reading"),
            counted(self.runs, "run"),
            self.poses.join(", "),
        ));
        document.append(stiffness_document(&self.stiffness, false));
        document.next(format!(
            "stiffness {folder}, and with a robot (--robot FILE) stiffbench fit {folder} and stiffbench diagnose {folder}."
        ));
        document.lines(format!(
            "The next file with the same columns: stiffbench import FILE --out FOLDER --mapping {folder}/mapping.toml"
        ));
        document
    }
}

/// So many columns that are not used are shown.
const MOST_UNUSED: usize = 40;

/// The first rows of a file, and what its columns were taken for.
#[must_use]
pub fn columns_document(columns: &[ColumnGuess]) -> Document {
    let mut unused = 0;
    let is_shown = |column: &&ColumnGuess| {
        unused += usize::from(column.role.is_none());
        column.role.is_some() || unused <= MOST_UNUSED
    };
    let shown: Vec<&ColumnGuess> = columns.iter().filter(is_shown).collect();
    let by = |column: &&ColumnGuess| match column.from {
        Some(GuessedFrom::Stated) => "option or mapping",
        Some(GuessedFrom::Name) => "its name",
        Some(GuessedFrom::Unit) => "its unit",
        None => "",
    };
    let mut document = Document::new();
    document.table(
        Table::of(shown)
            .words("column", |column| &column.name)
            .words("first values", |column| column.first_values.join("  "))
            .words("taken as", |column| {
                column.role.as_deref().unwrap_or("not used")
            })
            .words("unit", |column| column.unit.as_deref().unwrap_or_default())
            .words("by", by),
    );
    if unused > MOST_UNUSED {
        let further = unused - MOST_UNUSED;
        document.paragraph(format!("Not used: {}.", counted(further, "further column")));
    }
    document
}
