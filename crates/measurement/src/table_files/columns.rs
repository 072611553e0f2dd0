//! Columns of a table.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Where the unit of a column stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum StatedUnit {
    /// In the column's name.
    Name,
    /// In a row of units below the names.
    Row,
    /// In the lines above the table.
    Header,
    /// Behind each number.
    Cells,
}

/// A column of a table.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct FileColumn {
    /// Its name as it stands in the file.
    pub name: String,
    /// The same without the unit.
    pub stem: String,
    /// Its unit as it stands in the file.
    pub unit: Option<String>,
    /// Where that unit stands.
    pub unit_from: Option<StatedUnit>,
    /// Whether its cells are numbers or times.
    pub is_numeric: bool,
}

impl FileColumn {
    /// A column of words without a unit.
    pub(super) fn named(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            stem: name.to_owned(),
            unit: None,
            unit_from: None,
            is_numeric: false,
        }
    }
}
