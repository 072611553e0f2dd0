//! What can be wrong with a fit before it begins.

use stiffbench_beams::robot::RobotError;
use stiffbench_measurement::stiffness::NoStiffness;
use stiffbench_numeric::least_squares::LeastSquaresError;
use stiffbench_units_and_text::count::counted;
use stiffbench_units_and_text::test_point::{Cell, Direction, PoseId};

/// Errors of the fit stage.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum FitError {
    /// A pose, mechanism or structure of the robot.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Robot(#[from] RobotError),
    /// The least-squares core.
    #[error(transparent)]
    #[diagnostic(transparent)]
    LeastSquares(#[from] LeastSquaresError),
    /// No cell to fit.
    #[error("of {}, none belongs to the training poses ({train})", counted(.cells, "measured cell"))]
    #[diagnostic(
        code(stiffbench::fit::no_training_cells),
        help("--train takes pose names of the data, for example P1,P3")
    )]
    NoTrainingCells {
        /// Number of usable measured cells.
        cells: usize,
        /// The training poses asked for.
        train: String,
    },
    /// No pose may be proposed.
    #[error("no pose can be proposed that keeps {rules}")]
    #[diagnostic(
        code(stiffbench::fit::no_pose),
        help(
            "lower --floor-mm, --base-radius-mm or --limit-margin-percent, or forbid fewer poses"
        )
    )]
    NoPose {
        /// What poses are to keep.
        rules: String,
    },
    /// Fewer cells than free factors.
    #[error("{} cannot be fitted to {}", counted(.free, "free factor"), counted(.cells, "cell"))]
    #[diagnostic(
        code(stiffbench::fit::too_few_cells),
        help("train on more poses or fix some factors, for example --parameter beam.J=fixed")
    )]
    TooFewCells {
        /// Free factors.
        free: usize,
        /// Training cells.
        cells: usize,
    },
    /// The paper's procedure needs all three directions of a pose.
    #[error(
        "pose {pose} has no stiffness along {missing}; the paper's procedure fits one factor to each direction"
    )]
    #[diagnostic(
        code(stiffbench::fit::missing_direction),
        help("measure it, train on other poses, or use --method least-squares")
    )]
    MissingDirection {
        /// The pose.
        pose: PoseId,
        /// The direction.
        missing: Direction,
    },
    /// A model with physics predicts readings that have no stiffness.
    #[error("{cell}: the readings that the model predicts have no stiffness: {reason}")]
    #[diagnostic(
        code(stiffbench::fit::no_prediction),
        help("check the effects of the model: one of them outweighs the beams")
    )]
    NoPrediction {
        /// Pose and direction.
        cell: Cell,
        /// Why there is none.
        reason: NoStiffness,
    },
    /// A model with physics predicts readings that no structure shows.
    #[error("{cell}: the model predicts a stiffness of {stiffness_n_per_m:.3e} N/m")]
    #[diagnostic(
        code(stiffbench::fit::negative_prediction),
        help("check the effects of the model: one of them outweighs the beams")
    )]
    NegativePrediction {
        /// Pose and direction.
        cell: Cell,
        /// The stiffness, N/m.
        stiffness_n_per_m: f64,
    },
    /// A model with physics has no displacement at a reading.
    #[error(
        "the model returned {value} at pose {pose}, F = {force_n} N along {direction}, repeat {repeat}"
    )]
    #[diagnostic(
        code(stiffbench::fit::not_finite),
        help("check the effects of the model and the times of this reading")
    )]
    NotFinite {
        /// The pose.
        pose: PoseId,
        /// The direction.
        direction: Direction,
        /// The force, N.
        force_n: f64,
        /// n-th run of the cell.
        repeat: u32,
        /// What the model returned.
        value: f64,
    },
    /// Bounds between which nothing lies.
    #[error("parameter {name} cannot be fitted between {} and {}", bounds[0], bounds[1])]
    #[diagnostic(
        code(stiffbench::fit::bounds),
        help(
            "give --parameter NAME=LOW..HIGH with LOW below HIGH; a spring on which no load of these cells acts has no bounds of its own"
        )
    )]
    Bounds {
        /// The parameter.
        name: String,
        /// The bounds.
        bounds: [f64; 2],
    },
    /// A tie to a parameter of another kind, or to one that takes no part.
    #[error("parameter {one} cannot be tied to {other}")]
    #[diagnostic(
        code(stiffbench::fit::tie),
        help("a factor is tied to a factor and a spring to a spring, both named by --parameter")
    )]
    Tie {
        /// The tied parameter.
        one: String,
        /// What it was tied to.
        other: String,
    },
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
        "{file}, line {line}: `{pose}` is not a pose of {robot}, and the table has no columns of joint values"
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
        help("read more components or poses, or keep parameters with --parameter NAME=fixed")
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
    #[error("no choice of these poses determines all free parameters: {free}")]
    #[diagnostic(
        code(stiffbench::load_cases::dependent),
        help(
            "free fewer with --parameter, for example --parameter {first}=free, or add directions or poses"
        )
    )]
    Dependent {
        /// What is free.
        free: String,
        /// The first of them.
        first: String,
    },
    /// Weights of a combination that cannot be used.
    #[error("the weights of the poses must not be negative and must not all be zero")]
    #[diagnostic(code(stiffbench::fit::weights))]
    Weights,
}
