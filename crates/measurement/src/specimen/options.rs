//! What the caller states about a table.

use serde::{Deserialize, Serialize};

use super::response::ResponseVariable;
use crate::table_files::TableFileOptions;

/// Share of a run's range by which the path must come back before a turn counts.
///
/// More than the scatter of any gauge that resolves twenty load steps, less than the smallest step of a plan with ten of them.
pub const TURN_SHARE: f64 = 0.05;

/// Columns and units of a table, under the names that the command line and `recordings.toml` use (`force-column`, ...).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub struct SpecimenOptions {
    /// Column of the force; without one, the load is taken to be the same throughout.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_column: Option<String>,
    /// Column of the displacement.
    pub displacement_column: String,
    /// Columns of the displacement of further runs under the loads of the first, one a run.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub repeat_columns: Vec<String>,
    /// Column of the time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_column: Option<String>,
    /// Column of the date, where that of the time holds the time of day.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub date_column: Option<String>,
    /// Columns that together name a run, readings with one zero and one history; else a file, a sheet or a column of repeats is one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub run_column: Vec<String>,
    /// Columns that together name a specimen or configuration, each with a line of its own.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub configuration_column: Vec<String>,
    /// Column of the temperature.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_column: Option<String>,
    /// Column of the time under the load.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub hold_column: Option<String>,
    /// Column with the order of measurement, whole numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub order_column: Option<String>,
    /// Column with `loading` and `unloading`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub branch_column: Option<String>,
    /// Unit of the force, or `1` for numbers without one; else taken from the column name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub force_unit: Option<String>,
    /// Unit of the displacement, or `1`; else taken from the column name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub displacement_unit: Option<String>,
    /// Unit of time and hold; else taken from the column name.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time_unit: Option<String>,
    /// Unit of the temperature; else the end of the column's name, else °C.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperature_unit: Option<String>,
    /// Which quantity answers; else what the clock shows, else the displacement.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub response: Option<ResponseVariable>,
    /// Share of a run's range by which the path must come back before a turn counts, between 0 and 1; [`TURN_SHARE`] unless given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub turn_share: Option<f64>,
    /// Sheet, delimiter and decimal sign, where the caller knows them.
    #[serde(skip)]
    pub file: TableFileOptions,
    /// Whether the column of the quantity that answers may be absent.
    #[serde(skip)]
    pub is_response_optional: bool,
}

impl SpecimenOptions {
    /// Whether the column of a quantity may be absent.
    pub(super) fn may_lack(&self, quantity: ResponseVariable) -> bool {
        self.is_response_optional && self.response == Some(quantity)
    }

    /// How the file is read: the names of all columns that are asked for lead to the header.
    pub(super) fn of_file(&self) -> TableFileOptions {
        let single = [
            self.force_column.as_ref(),
            Some(&self.displacement_column),
            self.time_column.as_ref(),
            self.date_column.as_ref(),
            self.temperature_column.as_ref(),
            self.hold_column.as_ref(),
            self.order_column.as_ref(),
            self.branch_column.as_ref(),
        ];
        let several = self.run_column.iter().chain(&self.configuration_column);
        let several = several.chain(&self.repeat_columns);
        let names = single.into_iter().flatten().chain(several);
        TableFileOptions {
            columns: names.map(|name| name.trim().to_owned()).collect(),
            ..self.file.clone()
        }
    }
}
