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
    /// Fewer cells than free factors.
    #[error("{} cannot be fitted to {}", counted(.free, "free factor"), counted(.cells, "cell"))]
    #[diagnostic(
        code(stiffbench::fit::too_few_cells),
        help("train on more poses or fix some factors, for example --fix beam.J")
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
            "give --bounds NAME=LOW..HIGH with LOW below HIGH; a spring on which no load of these cells acts has no bounds of its own"
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
        help(
            "a factor is tied to a factor and a spring to a spring, both named by --free, --fix or --tie"
        )
    )]
    Tie {
        /// The tied parameter.
        one: String,
        /// What it was tied to.
        other: String,
    },
    /// Weights of a combination that cannot be used.
    #[error("the weights of the poses must not be negative and must not all be zero")]
    #[diagnostic(code(stiffbench::fit::weights))]
    Weights,
}
