//! What can keep a diagnosis from being made.

use stiffbench_beams::physics::EffectError;
use stiffbench_beams::robot::RobotError;
use stiffbench_measurement::procedure::ProcedureProblem;

/// Why there is no diagnosis.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum MismatchError {
    /// A pose or structure cannot be solved.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Robot(#[from] RobotError),
    /// An effect of a model is none of this robot.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Effect(#[from] EffectError),
    /// A procedure that is not of one displacement gauge along the load.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Procedure(#[from] ProcedureProblem),
    /// A model parameter that a search cannot free.
    #[error("parameter {name} cannot be free here: {problem}")]
    #[diagnostic(
        code(stiffbench::mismatch::parameter),
        help("leave it out, or fix it with --parameter NAME=fixed")
    )]
    Parameter {
        /// The parameter.
        name: String,
        /// Why not.
        problem: &'static str,
    },
    /// No reading counts.
    #[error("no reading counts")]
    #[diagnostic(
        code(stiffbench::mismatch::empty),
        help("all readings are superseded or rejected: look at the column `status`")
    )]
    Empty,
    /// A planned pose for which the structure was not solved.
    #[error("the procedure measures pose {pose}, which is not among the given poses")]
    #[diagnostic(
        code(stiffbench::mismatch::unknown_pose),
        help("the poses are: {}", known.join(", "))
    )]
    UnknownPose {
        /// The pose.
        pose: String,
        /// The poses at hand.
        known: Vec<String>,
    },
    /// A law that does not exist was to be left out.
    #[error("there is no law `{name}`")]
    #[diagnostic(code(stiffbench::mismatch::unknown_law), help("the laws are: {known}"))]
    UnknownLaw {
        /// The name given.
        name: String,
        /// The laws.
        known: String,
    },
}
