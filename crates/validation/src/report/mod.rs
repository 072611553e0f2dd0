//! Results of validation as text tables, JSON and figures.

mod prove;
mod reference;
mod table_iv;

pub use prove::{
    calibration_json, calibration_text, concealed_json, concealed_text, idealised_json,
    idealised_text, power_figure, power_json, power_text, recordings_json, recordings_text,
    twelve_values_json, twelve_values_text, verdicts_json,
};
pub use reference::{ReferencePose, ReferenceReport, ReferenceRow, reference_report};
