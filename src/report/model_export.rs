//! A model that was written for another program.

use std::path::PathBuf;

use schemars::JsonSchema;
use serde::Serialize;

use crate::export::ExportTable;

/// A model that was written for another program.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ModelExportReport {
    /// The format.
    pub format: ExportFormat,
    /// The file; `null` if the text is in `text`.
    pub file: Option<PathBuf>,
    /// The text of the file; `null` if it was written.
    pub text: Option<String>,
    /// The parameters, and the compliance in each pose.
    pub table: ExportTable,
}

/// Format of a model for other programs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
#[serde(rename_all = "lowercase")]
pub enum ExportFormat {
    /// MuJoCo: bodies, springs of joints and beams, friction, play.
    Mjcf,
    /// Gazebo: bodies, joints with springs and friction.
    Sdf,
    /// ROS: bodies, joints with friction; the rest as comments.
    Urdf,
    /// Parameters with units and intervals, and the compliance in each pose, one value per row.
    Csv,
    /// The same as JSON.
    Json,
}
