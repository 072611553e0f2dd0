//! What can be wrong with load cases once a robot stands behind them.

use miette::Diagnostic;
use thiserror::Error;

use stiffbench_beams::robot::RobotError;
use stiffbench_numeric::least_squares::LeastSquaresError;

use crate::fit::FitError;

/// Why load cases cannot be used with a robot, or not be fitted.
#[derive(Debug, Error, Diagnostic)]
pub enum LoadCaseFitError {
    /// A joint column whose variable the robot does not have.
    #[error("{file}: column `joint_{variable}` names no variable of {robot}, which has {known}")]
    #[diagnostic(code(stiffbench::load_cases::unknown_variable))]
    UnknownVariable {
        /// The file.
        file: String,
        /// Name of the robot.
        robot: String,
        /// The variable of the column.
        variable: String,
        /// The variables that there are.
        known: String,
        /// What could be meant.
        #[help]
        advice: String,
    },
    /// A column with the name of a variable, but not that of a joint column.
    #[error("{file}: column `{column}` has the name of a joint of {robot}, and is not read")]
    #[diagnostic(
        code(stiffbench::load_cases::bare_variable),
        help("write `{expected}`")
    )]
    BareVariable {
        /// The file.
        file: String,
        /// Name of the robot.
        robot: String,
        /// The column, as named in the file.
        column: String,
        /// The column that is meant.
        expected: String,
    },
    /// A joint column with a unit that its variable does not have.
    #[error(
        "{file}: column `joint_{variable}` has the unit of {found}, and the variable is {expected}"
    )]
    #[diagnostic(
        code(stiffbench::load_cases::joint_unit),
        help("a joint that turns has _deg or _rad behind its name, one that slides _mm or _m")
    )]
    JointUnit {
        /// The file.
        file: String,
        /// The variable of the column.
        variable: String,
        /// What the unit measures.
        found: &'static str,
        /// What the variable is.
        expected: &'static str,
    },
    /// A pose without joint values that the robot does not have.
    #[error(
        "{file}, line {line}: `{pose}` is no pose of {robot}, and the table has no columns of joint values"
    )]
    #[diagnostic(
        code(stiffbench::load_cases::unknown_pose),
        help(
            "add one column for each joint, for example {example} (`stiffbench robot check` prints them all), or name a pose of the robot file: `stiffbench robot show` lists them"
        )
    )]
    UnknownPose {
        /// The file.
        file: String,
        /// The line.
        line: u32,
        /// The pose.
        pose: String,
        /// Name of the robot.
        robot: String,
        /// A column of joint values.
        example: String,
    },
    /// Axes of a body that the robot does not have.
    #[error(
        "{file}, line {line}, column `axes`: `{axes}` is neither base nor tool nor a body of {robot}, which has {known}"
    )]
    #[diagnostic(code(stiffbench::load_cases::unknown_axes))]
    UnknownAxes {
        /// The file.
        file: String,
        /// The line.
        line: u32,
        /// The name found.
        axes: String,
        /// Name of the robot.
        robot: String,
        /// The bodies that there are.
        known: String,
        /// What could be meant.
        #[help]
        advice: String,
    },
    /// A pose that the robot cannot take.
    #[error("{file}, line {line}, pose {pose}")]
    #[diagnostic(
        code(stiffbench::load_cases::pose),
        help("correct the joint values, or mark the row `rejected` under `status`")
    )]
    Pose {
        /// The file.
        file: String,
        /// The line.
        line: u32,
        /// The pose.
        pose: String,
        /// Why.
        #[source]
        source: RobotError,
    },
    /// Fewer components than free parameters.
    #[error("components that were read: {components}; free parameters: {free}")]
    #[diagnostic(
        code(stiffbench::load_cases::too_few),
        help("read more components or poses, or keep parameters with --fix")
    )]
    TooFew {
        /// Components of displacement and rotation.
        components: usize,
        /// Free parameters.
        free: usize,
    },
    /// Too few whole positions to find the base frame from.
    #[error(
        "{whole} poses have a position with x, y and z, and {needed} are needed to find where the tracker stands"
    )]
    #[diagnostic(
        code(stiffbench::load_cases::too_few_positions),
        help(
            "measure all three components in more poses; poses in which one is missing count once the frames are found"
        )
    )]
    TooFewPositions {
        /// Poses with a whole position.
        whole: usize,
        /// How many are needed.
        needed: usize,
    },
    /// Scatter from repeats was asked for, and there are none.
    #[error("no load was applied twice in a pose: nothing shows the scatter of repeats")]
    #[diagnostic(
        code(stiffbench::load_cases::no_repeats),
        help("use --sigma estimated, which takes the scatter from the residuals over the poses")
    )]
    NoRepeats,
    /// Free parameters whose columns contain each other.
    #[error("the free parameters cannot be distinguished in these poses")]
    #[diagnostic(
        code(stiffbench::load_cases::dependent),
        help(
            "`stiffbench fit` names the combinations that the poses do not determine; keep one parameter of each with --fix"
        )
    )]
    Dependent,
    /// The parameters, the robot or the fit itself.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Fit(#[from] FitError),
}

impl From<RobotError> for LoadCaseFitError {
    fn from(error: RobotError) -> Self {
        Self::Fit(error.into())
    }
}

impl From<LeastSquaresError> for LoadCaseFitError {
    fn from(error: LeastSquaresError) -> Self {
        Self::Fit(error.into())
    }
}
