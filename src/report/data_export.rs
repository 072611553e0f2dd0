//! Tables that were written for other programs.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use crate::export::tidy::TidyTable;

use stiffbench_document::{Document, Table};

/// Tables that were written for other programs.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct DataExportReport {
    /// The format of the tables.
    pub format: TableFormat,
    /// The folder.
    pub folder: PathBuf,
    /// The tables.
    pub tables: Vec<ExportedTable>,
    /// The files, in the order in which they were written.
    pub files: Vec<ExportedFile>,
}

/// Format of tables for other programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum TableFormat {
    /// One file per table, with units and hashes in datapackage.json.
    Csv,
    /// Also one spreadsheet with one sheet per table, and units and provenance on the sheet about.
    Xlsx,
    /// Also one Parquet file per table; needs the build feature parquet.
    Parquet,
}

/// One table.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ExportedTable {
    /// Its name.
    pub name: String,
    /// What a row is.
    pub row: String,
    /// Number of rows.
    pub rows: usize,
    /// Names of the columns, each with its unit.
    pub columns: Vec<String>,
}

/// One file.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ExportedFile {
    /// Its path.
    pub path: PathBuf,
    /// Its size, bytes.
    pub bytes: usize,
    /// SHA-256 of its bytes, in hexadecimal.
    pub sha256: String,
}

impl From<&TidyTable> for ExportedTable {
    fn from(table: &TidyTable) -> Self {
        let columns = table.columns.iter().map(|column| column.name.clone());
        Self {
            name: table.name.to_owned(),
            row: table.title.to_owned(),
            rows: table.rows.len(),
            columns: columns.collect(),
        }
    }
}

impl DataExportReport {
    /// What was written, in words.
    #[must_use]
    pub fn document(&self) -> Document {
        let mut document = Document::new();
        document.table(
            Table::of(&self.tables)
                .words("table", |table| &table.name)
                .numbers("rows", |table| table.rows)
                .numbers("columns", |table| table.columns.len())
                .words("a row is", |table| &table.row),
        );
        document.paragraph("Written:");
        for file in &self.files {
            document.lines(format!("  {}", file.path.display()));
        }
        document.paragraph("datapackage.json holds units, hashes and sources. It names no licence: add `licenses` before you publish the data.");
        document.paragraph("In Python:");
        for line in self.python_lines() {
            document.lines(format!("  {line}"));
        }
        document
    }

    /// Lines of Python that read the tables into data frames.
    fn python_lines(&self) -> Vec<String> {
        let folder = self.folder.display().to_string().replace('\\', "/");
        let mut lines = vec!["import pandas as pd".to_owned()];
        for table in &self.tables {
            let name = &table.name;
            let call = match self.format {
                TableFormat::Csv => format!("read_csv(\"{folder}/{name}.csv\")"),
                TableFormat::Parquet => format!("read_parquet(\"{folder}/{name}.parquet\")"),
                TableFormat::Xlsx => {
                    format!("read_excel(\"{folder}/tables.xlsx\", sheet_name=\"{name}\")")
                }
            };
            let variable = name.replace('-', "_");
            let has_status = table.columns.iter().any(|column| column == "status");
            let accepted = if has_status {
                ".query(\"status == 'accepted'\")"
            } else {
                ""
            };
            lines.push(format!("{variable} = pd.{call}{accepted}"));
        }
        lines
    }
}
