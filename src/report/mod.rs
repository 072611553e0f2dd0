//! Results as text tables, JSON and inputs of figures.
//!
//! A result is a struct: JSON is its fields, and its schema is in [`schemas()`].

mod axis_words;
mod compare;
mod component_figures;
mod config;
mod correlation;
mod data_checks;
mod data_export;
mod demo;
mod design;
mod diagnosis;
mod diagnosis_figures;
mod doctor;
mod explain;
mod figures;
mod fit;
mod fit_report;
mod fitted;
mod hysteresis;
mod import;
mod instrument;
mod map;
mod model_comparison;
mod model_export;
pub mod page;
pub mod paper;
mod paper_steps;
mod prediction;
mod program;
mod robot;
mod robot_pose;
mod schemas;
mod session;
mod significance;
mod simulation;
mod stiffness;
mod text;
mod vector_stiffness;

pub use crate::analysis::VectorStiffnessCell;
pub use axis_words::plane_column_heads;
pub use compare::{
    CellDifference, CellNotCompared, ComparisonReport, LoopDifference, MeasuredDifference,
};
pub use config::{ConfigFileReport, ConfigReport, SettingOrigin, SettingReport};
use data_checks::{factor_words, table_mistake_words, usual_unit};
pub use data_export::{DataExportReport, ExportedFile, ExportedTable, TableFormat};
pub use demo::{DemoConcealed, DemoFinding, DemoReport, DemoTableVi};
pub use design::design_document;
pub use diagnosis::{
    ComponentShares, DetectionLimitReport, Determination, DiagnosisDetail, DiagnosisSummary,
    EarlierReport, FactorChangeReport, FindingReport, FittedParameter, IntervalEnd,
    KnownEffectReport, KnownParameter, LawLevel, NoiseDeviation, NoiseDeviations, NoiseReport,
    QualityReport, RejectedLaw, RivalReport, SearchLevels, SeenLimit, SiValue, SlopeReport, Strata,
    TableValue, UnexplainedReport, UnseenReason, UntestedContrast, diagnosis_document,
};
pub use diagnosis_figures::diagnosis_figures;
pub use doctor::{CheckReport, CheckState, DoctorReport};
pub use explain::{ExplainResult, LawForm, TopicKind, TopicList, TopicReport};
pub use figures::load_displacement_figure;
pub use fit_report::{
    ClassFactors, ComponentErrors, ComponentReport, FactorReport, FitReport, FittedCellReport,
    PaperSteps, ParameterReport, PoseFitReport,
};
pub use fitted::Fitted;
pub use import::{ImportReport, columns_document};
pub use instrument::*;
#[cfg(feature = "parquet")]
pub use map::points_parquet;
pub use map::{
    DirectionMap, EndMatrix, ExtremeStiffness, FailedPose, FittedStiffness, JointDerivatives,
    LoadAtEnd, MapAnswers, MapReport, MapResult, MapSummary, MechanismMap, MechanismShift,
    MechanismWeight, PaperCell, RefinedExtremeJson, RefinedPose, RegionPlace, SampledStiffness,
    SectionDerivatives, Sensitivities, SensitivityReport, ShiftCause, ShiftReport, ShiftStatistics,
    ShiftSummary, StiffnessQuantile, StiffnessRegion, WorstPose, points_csv, sensitivity_document,
};
pub use model_comparison::{ComparedFit, ComparedModel, ModelComparison, NestedTest};
pub use model_export::{ExportFormat, ModelExportReport};
pub use prediction::{PredictedRow, PredictedRun, PredictionReport};
pub use program::{COMMIT, CompletedWords, CompletionScript, ErrorReport, ManualPage, VERSION};
pub use robot::{
    BESIDE_BEAMS, ComplianceReport, MechanismRank, MechanismReport, MobilityReport, NewRobotReport,
    RobotReport, physics_document, robot_check_document,
};
pub use robot_pose::{pose_drawing, robot_figure, with_equal_views};
pub use schemas::{schema_of, schemas};
pub use session::*;
pub use significance::{ByDirection, FurtherSignificance, SignificanceReport};
pub use simulation::*;
pub use stiffbench_document::{Document, DocumentBlock, Table};
pub use stiffness::stiffness_document;
pub use text::significant;
pub(crate) use text::{micro, reading_shown};
pub use vector_stiffness::{StaticComplianceRow, VectorStiffnessReport};
