//! What can be wrong with files, models and options before a result.

use std::path::PathBuf;

use crate::fit::FitError;
use crate::mismatch::MismatchError;
use crate::physics::{EffectError, ModelFileError};
use crate::procedure::ProcedureError;
use crate::readings::{SessionFileError, TableError};
use crate::robot::RobotError;
use crate::stiffness::StiffnessError;

use super::files::ReadError;

/// An option with a value that cannot be. It bears the name of the command line.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error, miette::Diagnostic)]
#[error("{argument}: {problem}")]
#[diagnostic(code(stiffbench::usage::argument))]
pub struct ArgumentError {
    /// The option and its value.
    pub argument: String,
    /// What is wrong with it.
    pub problem: String,
    /// What to write instead.
    #[help]
    pub help: Option<String>,
}

impl ArgumentError {
    /// An error with what to write instead.
    #[must_use]
    pub fn new(
        argument: impl Into<String>,
        problem: impl Into<String>,
        help: impl Into<String>,
    ) -> Self {
        Self {
            argument: argument.into(),
            problem: problem.into(),
            help: Some(help.into()),
        }
    }

    /// The same as the failure of whatever asked.
    ///
    /// # Errors
    /// Always.
    pub fn refuse<T, E: From<Self>>(
        argument: impl Into<String>,
        problem: impl Into<String>,
        help: impl Into<String>,
    ) -> Result<T, E> {
        Err(Self::new(argument, problem, help).into())
    }
}

/// Errors of the way from files to results.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum AnalysisError {
    /// Neither a file nor a folder nor a shipped name.
    #[error("{path}: there is no such file or folder")]
    #[diagnostic(code(stiffbench::input::not_found))]
    NotFound {
        /// What the user named.
        path: PathBuf,
        /// What could be meant.
        #[help]
        help: String,
    },
    /// Readings of several displacement gauges where one along the load is needed.
    #[error(
        "{path} has forces and displacements along the base axes, which this command does not read"
    )]
    #[diagnostic(
        code(stiffbench::input::vectors),
        help(
            "stiffbench stiffness, fit and diagnose read them; for this command measure with one displacement gauge along the load, \
             without displacement_axes"
        )
    )]
    Vectors {
        /// The table.
        path: PathBuf,
    },
    /// A result that depends on springs without a value.
    #[error("{robot}: {problem}")]
    #[diagnostic(code(stiffbench::robot::no_stiffness))]
    NoStiffness {
        /// The robot.
        robot: String,
        /// Which springs.
        problem: String,
        /// What gives them a value.
        #[help]
        help: &'static str,
    },
    /// A folder that is no session.
    #[error("{path} holds no readings.csv")]
    #[diagnostic(
        code(stiffbench::input::no_session),
        help(
            "a session is a folder with readings.csv in it; a readings file may also be named itself"
        )
    )]
    NoSession {
        /// The folder.
        path: PathBuf,
    },
    /// A table that no longer holds what the journal holds.
    #[error("{path} was changed after the session: {changes}")]
    #[diagnostic(
        code(stiffbench::input::changed),
        help(
            "stiffbench session recover FOLDER --out NEW rebuilds the table from the journal; records of the gauges that came later are named \
             with --instrument-records FILE; --trust-csv uses the folder as it is, and every result states it"
        )
    )]
    Changed {
        /// The table.
        path: PathBuf,
        /// What was changed.
        changes: String,
    },
    /// Data that need a model, and no robot is named.
    #[error("no robot: neither --robot nor a session.toml beside the data names one")]
    #[diagnostic(code(stiffbench::usage::no_robot))]
    NoRobot {
        /// What to add.
        #[help]
        help: String,
    },
    /// A robot file that is not the session's.
    #[error("{robot} is not the robot file the session was measured with: its SHA-256 differs")]
    #[diagnostic(
        code(stiffbench::robot::other_file),
        help("put the file of the session back, or name the robot that is meant with --robot")
    )]
    OtherRobot {
        /// The file.
        robot: String,
    },
    /// A model of another mechanism than the session's.
    #[error(
        "{model} is of mechanism {of_model}, and the session was measured in mechanism {of_session}"
    )]
    #[diagnostic(
        code(stiffbench::robot::other_mechanism),
        help("name the mechanism that is meant with --mechanism")
    )]
    OtherMechanism {
        /// The file of the model.
        model: String,
        /// Its mechanism.
        of_model: String,
        /// That of the session.
        of_session: String,
    },
    /// A session or model that names a robot which is not there.
    #[error(
        "{file} names the robot {robot}, and there is no such file beside it and no shipped robot of that name"
    )]
    #[diagnostic(
        code(stiffbench::session_file::robot),
        help("put the robot file beside it, or name another with --robot")
    )]
    NamedRobot {
        /// The session's header, or the model.
        file: PathBuf,
        /// The robot as it stands there.
        robot: String,
    },
    /// A factor file that is not one.
    #[error("{file} is not a factor set: {problem}")]
    #[diagnostic(
        code(stiffbench::robot::factor_file),
        help(
            "write it as `fit --save-factors` does: beam = {{ A = 1.0, Iy = 1.0, Iz = 1.0, J = 1.0 }}, the same for link, and springs = {{ \"joint.J1\" = 2e-5 }}; what is absent is 1 or has no value"
        )
    )]
    Factors {
        /// The file.
        file: String,
        /// What is wrong with it.
        problem: String,
    },
    /// Data without readings where readings are needed.
    #[error("{data} holds stiffness values, not readings: {needs} needs readings")]
    #[diagnostic(
        code(stiffbench::usage::needs_readings),
        help("give a session folder or a readings file")
    )]
    NeedsReadings {
        /// The data.
        data: String,
        /// What needs readings.
        needs: &'static str,
    },
    /// Load cases where series of loads are needed.
    #[error(
        "{data} holds load cases (loads and displacements as vectors): {needs} needs readings of one direction over several loads"
    )]
    #[diagnostic(
        code(stiffbench::usage::needs_runs),
        help("stiffbench fit and stiffbench diagnose take load cases")
    )]
    NeedsRuns {
        /// The data.
        data: String,
        /// What needs them.
        needs: &'static str,
    },
    /// Records that do not say what the noise of a reading is.
    #[error(
        "{data}: --noise records needs the step of the displacement gauge, and no record states it"
    )]
    #[diagnostic(
        code(stiffbench::session_file::no_resolution),
        help(
            "put resolution_um under [instruments.displacement] of session.toml, or take the noise from the readings (--noise estimated)"
        )
    )]
    NoResolution {
        /// The data.
        data: String,
    },
    /// Overdue calibration under --strict.
    #[error("calibration overdue: {instruments}")]
    #[diagnostic(
        code(stiffbench::calibration::overdue),
        help("have the gauge calibrated, or leave out --strict and accept a warning")
    )]
    CalibrationOverdue {
        /// Which gauges, since when.
        instruments: String,
    },
    /// An option with a value that cannot be.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Argument(#[from] ArgumentError),
    /// A file that cannot be read.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Read(#[from] ReadError),
    /// A table.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Table(#[from] TableError),
    /// A `session.toml`.
    #[error(transparent)]
    #[diagnostic(transparent)]
    SessionFile(#[from] SessionFileError),
    /// A record of a gauge.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Gauges(#[from] StiffnessError),
    /// A robot, mechanism or pose.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Robot(#[from] RobotError),
    /// A model file.
    #[error(transparent)]
    #[diagnostic(transparent)]
    ModelFile(#[from] ModelFileError),
    /// An effect beside the beams.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Effect(#[from] EffectError),
    /// A procedure.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Procedure(#[from] ProcedureError),
    /// A fit.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Fit(#[from] FitError),
    /// A diagnosis.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Mismatch(#[from] MismatchError),
}
