//! From files to results: opens sessions, resolves models, fits and diagnoses. The commands of the program call the same functions.
//!
//! ```no_run
//! use std::path::Path;
//! use stiffbench::analysis::{
//!     Data, DiagnoseSettings, DiagnosisData, FitData, FitSettings, LoadedSession, ModelChoice, OpenSettings,
//! };
//! use stiffbench::stiffness::{Branches, Method};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let session = LoadedSession::open(Path::new("my-session"), &OpenSettings::default())?;
//! let table = session.stiffness(Branches::LoadingOnly)?;
//! let data = Data::Readings(vec![session]);
//! let mut readings = DiagnosisData::new(&data, &ModelChoice::default())?;
//! let diagnosis = readings.diagnose(DiagnoseSettings::default(), &|| ())?;
//! let stiffness = FitData::new(data, &ModelChoice::default(), Method::Regression)?;
//! let fit = stiffness.fit(&FitSettings::default(), &|| ())?;
//! # Ok(())
//! # }
//! ```

mod calibration;
mod data;
mod data_check;
mod derived;
mod design;
mod diagnose;
mod earlier;
mod error;
mod files;
mod fit;
mod hash;
mod history;
mod inputs;
mod integrity;
mod listed_stiffness;
mod marked;
mod model;
mod new_robot;
mod part_model;
mod plausible;
mod pose_plan;
mod posed;
mod procedure;
mod residuals;
mod robot_check;
mod session_table;
mod stored;
mod subject;
mod together;
mod unknown_springs;
mod vector_stiffness;

pub use calibration::{GaugeCalibration, GivenCalibration, StatedError};
pub use data::{
    CalibrationCheck, Data, LoadedLoadCases, LoadedSession, OpenSettings, gauges_text,
    session_header,
};
pub use data_check::{check_data, stated_scatter_m};
pub use derived::{DerivedQuantity, derive};
pub use design::{design, usual_plan};
pub use diagnose::{
    DiagnoseSettings, DiagnosisData, DiagnosisReport, NoiseOrigin, NoiseSource, diagnose_part,
};
pub use earlier::{EarlierSession, MeasuredNoise, noise_of};
pub use error::{AnalysisError, ArgumentError, Failure};
pub use files::{
    ReadError, forget_inputs, is_dash, is_input, read_bytes, read_text, session_file, shown,
};
pub use fit::{
    BootstrapOver, FitData, FitSettings, FittedSession, PaperFitSettings, PlannedFit, fixed_physics,
};
pub use hash::sha256;
pub use history::SessionHistory;
pub use inputs::Inputs;
pub use integrity::{
    JournalCheck, ReportDifferences, TableCheck, compare_with_journal, header_sha256, shortened,
};
pub use marked::ReadingMark;
pub use model::{ConfiguredRobot, ModelChoice, ResolvedModel, laws, resolve, robot_source};
pub use new_robot::{
    Controller, DhSettings, ImportError, ImportProblem, NewRobot, StatedPosition, TEMPLATES,
    UrdfSettings, check_positions, robot_from_dh, robot_from_urdf, template,
};
pub use part_model::{PartModelError, PartModelFile, check_predictable};
pub use plausible::{doubts_about_fit, doubts_about_load_case_fit, doubts_about_stiffness};
pub use pose_plan::choose_poses;
pub use posed::{PosedData, refuse_unseen_laws};
pub use procedure::{add_poses, check_specimen, joints_of, named_procedure, state_joint_values};
pub use residuals::{ReadingResidual, ResidualOrder, RunsTest};
pub use robot_check::{CheckedPose, RobotCheck, check_robot};
pub use session_table::SessionTable;
pub use stored::StoredResult;
pub use subject::{RobotSubject, Subject};
pub use together::{MarkedReading, OpenBefore, SessionShare};
pub use unknown_springs::{UnknownSprings, stiffness_words};
pub use vector_stiffness::{AxisValues, VectorStiffnessCell};
