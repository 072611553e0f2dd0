//! Results as text tables, JSON and inputs of figures.
//!
//! Each result has one function for people and one for programs, side by side, so that the two cannot drift apart.

mod compare;
mod design;
mod diagnosis;
mod diagnosis_figures;
mod figures;
mod fit;
mod map;
pub mod paper;
mod robot;
mod significance;
mod specimen;
mod stiffness;
mod text;

pub use compare::{comparison_json, comparison_text};
pub use design::{design_json, design_text};
pub use diagnosis::{diagnosis_appendix, diagnosis_json, diagnosis_page};
pub use diagnosis_figures::diagnosis_figures;
pub use figures::{
    FitFigures, correlation_figure, fit_figures, load_displacement_figure, residuals_figure,
    robot_figure, workspace_figure,
};
pub use fit::{fit_json, fit_text, paper_steps_json, paper_steps_text};
#[cfg(feature = "parquet")]
pub use map::points_parquet;
pub use map::{
    Field, MapReport, MeshPoints, ShiftCause, ShiftReport, mesh_of, points_csv, sensitivity_json,
    sensitivity_text, vtu,
};
pub use paper::{PaperCell, PaperReport, paper_report};
pub use robot::{
    compliance_json, compliance_text, mobility_json, mobility_text, robot_json, robot_text,
};
pub use significance::{significance_json, significance_with_sequence};
pub use specimen::{SpecimenReport, specimen_json, specimen_text};
pub use stiffness::stiffness_text;
pub use text::{TextTable, significant};
