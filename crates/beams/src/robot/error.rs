//! What can be wrong with a robot file, a pose or a choice of mechanism.

use std::fmt::Display;

use miette::Diagnostic;

use stiffbench_units_and_text::nearest::nearest;
use stiffbench_units_and_text::source_text::{PlacedError, SourceText};
use stiffbench_units_and_text::toml_text::TomlProblem;

use super::model_parameter::NotAParameter;

/// Errors of the robot stage.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum RobotError {
    /// The text of a robot file is wrong at one place.
    #[error(transparent)]
    #[diagnostic(transparent)]
    File(PlacedError<RobotProblem>),
    /// A loop of the linkage cannot close in a pose.
    #[error(
        "pose {pose} cannot be reached: the loop that places node {node} does not close; its centres {first} and {second} are \
         {distance_m:.6} m apart and the circles around them (radii {first_radius_m:.6} m and {second_radius_m:.6} m) miss by \
         {gap_m:.3e} m"
    )]
    #[diagnostic(
        code(stiffbench::robot::unreachable),
        help("change the angles of the pose, or the lengths of the loop in the robot file")
    )]
    Unreachable {
        /// The pose.
        pose: String,
        /// Node that the loop should place.
        node: String,
        /// First centre.
        first: String,
        /// Second centre.
        second: String,
        /// Distance of the centres, m.
        distance_m: f64,
        /// Radius of the circle around the first centre, m.
        first_radius_m: f64,
        /// Radius of the circle around the second centre, m.
        second_radius_m: f64,
        /// How far the circles are from touching, m.
        gap_m: f64,
    },
    /// Two nodes of a loop or of a body do not lie in the plane named for them.
    #[error(
        "pose {pose}: nodes {first} and {second} do not lie in one plane parallel to {plane}, they are {offset_m:.3e} m apart across it"
    )]
    #[diagnostic(
        code(stiffbench::robot::out_of_plane),
        help(
            "a loop and an aligned body need both nodes in the same plane: name another plane or move a node"
        )
    )]
    OutOfPlane {
        /// The pose.
        pose: String,
        /// The plane.
        plane: String,
        /// First node.
        first: String,
        /// Second node.
        second: String,
        /// Distance along the plane's normal, m.
        offset_m: f64,
    },
    /// A body is aligned with two nodes that coincide.
    #[error("pose {pose}: body {body} has no direction, its nodes {first} and {second} coincide")]
    #[diagnostic(
        code(stiffbench::robot::no_direction),
        help("align the body with two nodes that lie apart in every pose")
    )]
    NoDirection {
        /// The pose.
        pose: String,
        /// The body.
        body: String,
        /// First node.
        first: String,
        /// Second node.
        second: String,
    },
    /// A name that the robot does not have.
    #[error("{robot} has no {kind} `{name}`; it has {known}")]
    #[diagnostic(code(stiffbench::robot::unknown_name))]
    UnknownName {
        /// Name of the robot.
        robot: String,
        /// Kind of thing asked for.
        kind: &'static str,
        /// The name asked for.
        name: String,
        /// The names that exist.
        known: String,
        /// A suggestion.
        #[help]
        help: Option<String>,
    },
    /// A text that names no parameter of a model.
    #[error(transparent)]
    #[diagnostic(transparent)]
    NotAParameter(#[from] NotAParameter),
    /// A factor that is not above zero, a compliance below zero, or no number.
    #[error("parameter {parameter} cannot be {value}")]
    #[diagnostic(
        code(stiffbench::robot::impossible_parameter),
        help(
            "factors are above zero; compliances of joints and base, in rad/(N*m), are zero or above"
        )
    )]
    ImpossibleParameter {
        /// The parameter.
        parameter: String,
        /// Its value.
        value: f64,
    },
    /// The structure of a mechanism cannot be solved.
    #[error("mechanism {mechanism} cannot be computed")]
    #[diagnostic(code(stiffbench::robot::structure))]
    Structure {
        /// The mechanism.
        mechanism: String,
        /// What the solver says.
        #[source]
        #[diagnostic_source]
        source: crate::structure::StructureError,
    },
    /// A mechanism has no element, or none that reaches the end node or a support.
    #[error("mechanism {mechanism} has no element at {what}")]
    #[diagnostic(
        code(stiffbench::robot::incomplete_mechanism),
        help("add the chain or the single element that reaches it to [mechanisms.{mechanism}]")
    )]
    IncompleteMechanism {
        /// The mechanism.
        mechanism: String,
        /// What no element reaches.
        what: String,
    },
}

/// What is wrong at one place of a robot file.
#[derive(Debug, thiserror::Error)]
pub enum RobotProblem {
    /// Not TOML, or not of the format's shape.
    #[error("{0}")]
    Syntax(String),
    /// A format or unit this version does not know.
    #[error("{what} is `{found}`, this version reads `{expected}`")]
    Unsupported {
        /// Format or unit.
        what: &'static str,
        /// The content of the file.
        found: String,
        /// What is known.
        expected: &'static str,
    },
    /// A reference to something that does not exist.
    #[error("there is no {kind} `{name}`")]
    UnknownName {
        /// Kind of thing.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// A name given twice.
    #[error("{kind} `{name}` is defined twice")]
    Duplicate {
        /// Kind of thing.
        kind: &'static str,
        /// The name.
        name: String,
    },
    /// A body or node that needs itself.
    #[error("{kind} `{name}` depends on itself: {chain}")]
    Circular {
        /// Kind of thing.
        kind: &'static str,
        /// The name.
        name: String,
        /// The way back to it.
        chain: String,
    },
    /// An expression without value.
    #[error(transparent)]
    Expression(#[from] super::expression::ExpressionError),
    /// A number outside what is possible.
    #[error("{what} is {value}: {must}")]
    Impossible {
        /// What the number is.
        what: String,
        /// The number.
        value: f64,
        /// What it must be.
        must: &'static str,
    },
    /// Keys that exclude or need one another.
    #[error("{0}")]
    Shape(&'static str),
}

impl RobotError {
    /// An error at a byte range of a file.
    pub(super) fn at(
        source: &SourceText,
        span: std::ops::Range<usize>,
        problem: RobotProblem,
        help: Option<String>,
    ) -> Self {
        Self::File(PlacedError::new(source, span, problem).with_help(help))
    }

    /// A name that is not among those known, with the nearest of them.
    pub(super) fn unknown_name<'k>(
        source: &SourceText,
        span: std::ops::Range<usize>,
        (kind, name): (&'static str, &str),
        known: impl Iterator<Item = &'k str>,
    ) -> Self {
        let known: Vec<&str> = known.collect();
        let help = match nearest(name, known.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None if known.is_empty() => "the file has none".to_owned(),
            None => format!("the file has: {}", known.join(", ")),
        };
        let name = name.to_owned();
        let problem = RobotProblem::UnknownName { kind, name };
        Self::at(source, span, problem, Some(help))
    }
}

impl Diagnostic for RobotProblem {
    fn code<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        Some(Box::new("stiffbench::robot::file"))
    }
}

impl From<TomlProblem> for RobotProblem {
    fn from(problem: TomlProblem) -> Self {
        Self::Syntax(problem.to_string())
    }
}
