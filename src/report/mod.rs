//! Results as text tables, JSON and inputs of figures.
//!
//! A result is a struct: JSON is its fields, and its schema is in [`schemas()`].

mod axis_words;
mod compare;
mod demo;
mod design;
mod diagnosis;
mod diagnosis_figures;
mod figures;
mod fit;
mod fit_report;
mod instrument;
mod map;
pub mod paper;
mod program;
mod robot;
mod schemas;
mod session;
mod significance;
mod simulation;
mod specimen;
mod stiffness;
mod text;

pub use axis_words::plane_column_heads;
pub use compare::{
    CellDifference, CellNotCompared, ComparisonReport, ComparisonVerdict, MeasuredDifference,
    OverallDifference,
};
pub use demo::{DemoReport, DemoTableVi};
pub use design::{DesignSummary, LawAtPlace, LawDetection, NearLaw, UnseenLaw, design_text};
pub use diagnosis::{
    ComponentShares, DetectionLimitReport, Determination, DiagnosisResult, DiagnosisSummary,
    EarlierReport, FactorChangeReport, FindingReport, FittedParameter, LawLevel, NoiseDeviation,
    NoiseDeviations, NoiseReport, QualityReport, RejectedLaw, RivalReport, SearchLevels, SeenLimit,
    Strata, UnexplainedReport, UnseenReason, UntestedContrast, diagnosis_appendix, diagnosis_page,
};
pub use diagnosis_figures::diagnosis_figures;
pub use figures::{
    FitFigures, correlation_figure, fit_figures, load_displacement_figure, residuals_figure,
    robot_figure, workspace_figure,
};
pub use fit_report::{
    ClassFactors, FactorReport, FitReport, FittedCellReport, PaperSteps, ParameterReport,
    PoseFitReport, TrialReport,
};
pub use instrument::*;
#[cfg(feature = "parquet")]
pub use map::points_parquet;
pub use map::{
    DirectionMap, EndMatrix, ExtremeStiffness, FailedPose, FittedStiffness, JointDerivatives,
    LoadAtEnd, MapAnswers, MapReport, MapResult, MapSummary, MechanismMap, MechanismShift,
    MechanismWeight, MeshField, MeshPoints, RefinedExtremeJson, RefinedPose, RegionPlace,
    SampledStiffness, SectionDerivatives, Sensitivities, SensitivityReport, ShiftCause,
    ShiftReport, ShiftStatistics, ShiftSummary, StiffnessQuantile, StiffnessRegion, WorstPose,
    mesh_of, points_csv, sensitivity_text, vtu,
};
pub use paper::{PaperCell, PaperCellSummary, PaperReport, PaperSummary, paper_report};
pub use program::{CompletionScript, ManualPage};
pub use robot::{
    CheckedPose, ComplianceReport, MechanismRank, MechanismReport, MobilityReport, OutermostPoint,
    PoseReport, RobotCheck, RobotReport, VariableReport, WorkspaceReport,
};
pub use schemas::{schema_of, schemas};
pub use session::*;
pub use significance::{ByDirection, FurtherSignificance, SignificanceReport};
pub use simulation::*;
pub use specimen::{
    SpecimenFinding, SpecimenNoise, SpecimenQuality, SpecimenSlope, SpecimenSummary,
    SpecimenUnexplained,
};
pub use stiffness::stiffness_text;
pub use text::{AlignedTable, significant};
