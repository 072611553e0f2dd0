//! From the keys of a file to a checked robot.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use indexmap::IndexMap;

use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::toml_text::DocumentStep::{self, Index, Key};
use stiffbench_units_and_text::toml_text::TomlDocument;

use crate::robot::error::{RobotError, RobotProblem};
use crate::robot::expression::Expression;
use crate::robot::model::{
    Body, Joint, Limit, Mechanism, Member, NodePlace, Plane, RigidLink, RobotNode, Variable,
};
use crate::robot::springs::Tool;
use crate::robot::{RatedSection, Robot, kinematics, parameters, plausible};

use super::file::{AxisValue, RobotFile2, UpAxis};
use super::frames::FileFrame;
use super::measure::{InUnit, LengthOf, MeasuredKind};

/// Name of the body that stands still, and of its point at the origin.
pub(super) const BASE: &str = "base";

/// Name of the tool centre.
pub(super) const TOOL: &str = "tool";

/// The node where a tool with springs is mounted.
pub(super) const MOUNT: &str = "tool.mount";

/// Name of the one mechanism and of its one chain.
const ALL: &str = "robot";

/// A robot under construction.
pub(super) struct RobotBuilder<'a> {
    pub(super) source: &'a SourceText,
    document: &'a TomlDocument<'a>,
    pub(super) file: &'a RobotFile2,
    pub(super) parameters: HashMap<String, f64>,
    /// Bodies by name: the base, those of joints, those along points.
    pub(super) body_names: IndexMap<String, usize>,
    /// Places of bodies, as they become known.
    pub(super) bodies: Vec<Option<Body>>,
    /// Axes that the file uses for them.
    pub(super) frames: Vec<FileFrame>,
    pub(super) nodes: IndexMap<String, NodePlace>,
    /// Bodies that each node lies on.
    pub(super) bodies_of_node: Vec<Vec<usize>>,
    pub(super) variables: IndexMap<String, Variable>,
    pub(super) planes: Vec<Plane>,
    pub(super) joints: Vec<Joint>,
    pub(super) members: Vec<Member>,
    pub(super) rigid_links: Vec<RigidLink>,
    pub(super) sections: IndexMap<String, RatedSection>,
    pub(super) warnings: Vec<String>,
}

impl<'a> RobotBuilder<'a> {
    pub(super) fn new(
        source: &'a SourceText,
        document: &'a TomlDocument<'a>,
        file: &'a RobotFile2,
    ) -> Result<Self, RobotError> {
        let mut builder = Self {
            source,
            document,
            file,
            parameters: HashMap::new(),
            body_names: IndexMap::new(),
            bodies: Vec::new(),
            frames: Vec::new(),
            nodes: IndexMap::new(),
            bodies_of_node: Vec::new(),
            variables: IndexMap::new(),
            planes: Vec::new(),
            joints: Vec::new(),
            members: Vec::new(),
            rigid_links: Vec::new(),
            sections: IndexMap::new(),
            warnings: Vec::new(),
        };
        builder.parameters = builder.values_of_parameters()?;
        builder.check_names()?;
        builder.name_bodies()?;
        Ok(builder)
    }

    /// The robot.
    pub(super) fn robot(mut self) -> Result<Robot, RobotError> {
        self.sections_of_file()?;
        self.place_variables()?;
        self.place_joints()?;
        self.place_points()?;
        let (tool, end) = self.place_tool()?;
        self.close_loops()?;
        let supports = self.supports()?;
        self.connect(&supports)?;
        let robot = self.put_together(tool, end, supports)?;
        self.check(robot)
    }

    fn put_together(
        &mut self,
        tool: Tool,
        end: usize,
        supports: Vec<usize>,
    ) -> Result<Robot, RobotError> {
        let limits = self.limits()?;
        let base = self.base_springs()?;
        let masses = self.masses()?;
        let balancers = self.balancers()?;
        let factors = self.file.factors.iter();
        let factors = factors.map(|(name, entry)| {
            let values = entry.values().map_err(|error| {
                let path = [Key("factors"), Key(name), Key("springs")];
                self.error(&path, RobotProblem::Syntax(error.to_string()))
            });
            Ok((name.clone(), values?))
        });
        let factors = factors.collect::<Result<_, RobotError>>()?;
        let poses = self.poses()?;
        let stated = self.file.base.clone().unwrap_or_default();
        let length = |stated: Option<InUnit<LengthOf>>, key| {
            stated.map(|length| self.value(&length, &[Key("base"), Key(key)]))
        };
        let floor_m = length(stated.floor, "floor").transpose()?;
        let base_radius_m = length(stated.radius, "radius").transpose()?;
        let up = usize::from(self.file.up == UpAxis::Z) + 1;
        let mut axis_words = [const { None }; 3];
        axis_words[up] = Some("up".to_owned());
        let mut vertical = [0.0; 3];
        vertical[up] = 1.0;
        let driven = self.file.joints.values().filter(|row| row.point.is_none());
        let mechanism = Mechanism {
            name: ALL.to_owned(),
            chains: vec![ALL.to_owned()],
            members: (0..self.members.len()).collect(),
            rigid_links: (0..self.rigid_links.len()).collect(),
            locked: (0..driven.count()).collect(),
        };
        let nodes = std::mem::take(&mut self.nodes).into_iter();
        let bodies = std::mem::take(&mut self.bodies).into_iter();
        Ok(Robot {
            source: Arc::new(self.source.clone()),
            name: self.file.name.clone(),
            variables: std::mem::take(&mut self.variables).into_values().collect(),
            limits,
            planes: std::mem::take(&mut self.planes),
            bodies: bodies.flatten().collect(),
            joints: std::mem::take(&mut self.joints),
            nodes: nodes
                .map(|(name, place)| RobotNode {
                    name: Arc::from(name),
                    place,
                })
                .collect(),
            members: std::mem::take(&mut self.members),
            rigid_links: std::mem::take(&mut self.rigid_links),
            supports,
            end,
            tool,
            base,
            sections: std::mem::take(&mut self.sections),
            vertical,
            axis_words,
            masses,
            balancers,
            mechanisms: [(ALL.to_owned(), mechanism)].into_iter().collect(),
            factors,
            poses,
            floor_m,
            base_radius_m,
            warnings: std::mem::take(&mut self.warnings),
        })
    }

    /// What can only be checked of a whole robot.
    fn check(&self, mut robot: Robot) -> Result<Robot, RobotError> {
        kinematics::check_order(&robot).map_err(|circular| {
            let table = match circular.kind {
                "body" => "joints",
                _ => "points",
            };
            let kinematics::Circular { kind, name, chain } = circular;
            let problem = RobotProblem::Circular {
                kind,
                name: name.clone(),
                chain,
            };
            self.error(&[Key(table), Key(&name)], problem)
        })?;
        for (name, values) in &robot.factors {
            robot.check_parameters(values).map_err(|error| {
                let problem = RobotProblem::Syntax(error.to_string());
                self.error(&[Key("factors"), Key(name)], problem)
            })?;
        }
        self.tie(&mut robot)?;
        let odd = plausible::oddities(&robot);
        robot.warnings.extend(odd);
        Ok(robot)
    }

    /// Bytes of the value at a path, of its key where there is no value.
    pub(super) fn span(&self, path: &[DocumentStep<'_>]) -> Range<usize> {
        self.document.value_span(path)
    }

    /// Bytes of the key that a path ends in.
    pub(super) fn key_span(&self, path: &[DocumentStep<'_>]) -> Range<usize> {
        self.document.key_span(path)
    }

    /// Line of the value at a path.
    pub(super) fn line(&self, path: &[DocumentStep<'_>]) -> usize {
        self.source
            .line_and_column(self.document.key_span(path).start)
            .0
    }

    /// An error at a place of the file.
    pub(super) fn error(&self, path: &[DocumentStep<'_>], problem: RobotProblem) -> RobotError {
        RobotError::at(self.source, self.span(path), problem, None)
    }

    /// The same with what to do about it.
    pub(super) fn error_with(
        &self,
        path: &[DocumentStep<'_>],
        problem: RobotProblem,
        help: impl Into<String>,
    ) -> RobotError {
        RobotError::at(self.source, self.span(path), problem, Some(help.into()))
    }

    /// A body, node or plane that a file names on its own account.
    pub(super) fn add_node(&mut self, name: String, place: NodePlace, bodies: Vec<usize>) -> usize {
        self.bodies_of_node.push(bodies);
        self.nodes.insert_full(name, place).0
    }

    /// The plane of a unit normal in the axes of the model for a body; one that is there is used again.
    pub(super) fn plane_of(&mut self, name: String, body: usize, normal: [f64; 3]) -> usize {
        let same = |plane: &Plane| plane.body == body && plane.normal == normal;
        self.planes.iter().position(same).unwrap_or_else(|| {
            self.planes.push(Plane { name, body, normal });
            self.planes.len() - 1
        })
    }

    /// Name of the one chain.
    pub(super) fn chain() -> String {
        ALL.to_owned()
    }

    fn values_of_parameters(&self) -> Result<HashMap<String, f64>, RobotError> {
        let rows = self.file.parameters.iter();
        let expressions: IndexMap<String, Expression> = rows
            .map(|(name, measured)| (name.clone(), measured.value.clone()))
            .collect();
        let values = parameters::values(&expressions).map_err(|(name, problem)| {
            let path = [Key("parameters"), Key(name)];
            match problem {
                parameters::ParameterProblem::Expression(problem) => {
                    self.error(&path, problem.into())
                }
                parameters::ParameterProblem::Circular(around) => {
                    let (kind, name) = ("parameter", name.to_owned());
                    let chain = around.join(" needs ");
                    self.error(&path, RobotProblem::Circular { kind, name, chain })
                }
            }
        })?;
        let values = values.into_iter();
        Ok(values
            .map(|(name, value)| (name.to_owned(), value))
            .collect())
    }

    /// Value of a length, m, or angle, degrees.
    pub(super) fn value<K>(
        &self,
        measured: &InUnit<K>,
        path: &[DocumentStep<'_>],
    ) -> Result<f64, RobotError> {
        let lookup = |name: &str| self.parameters.get(name).copied();
        measured.value.value(&lookup).map_err(|problem| {
            let help = self.help_for_parameter(&problem);
            RobotError::at(self.source, self.span(path), problem.into(), help)
        })
    }

    /// Value that is a length of a joint that slides, an angle of one that turns.
    pub(super) fn travel<K>(
        &self,
        measured: &InUnit<K>,
        slides: bool,
        path: &[DocumentStep<'_>],
    ) -> Result<f64, RobotError> {
        let wrong = match measured.kind {
            Some(MeasuredKind::Length) => !slides,
            Some(MeasuredKind::Angle) => slides,
            _ => false,
        };
        if wrong {
            let problem = if slides {
                "an angle where a joint slides: the key may end in m, mm, cm or um"
            } else {
                "a length where a joint turns: the key may end in deg or rad"
            };
            return Err(self.error(path, RobotProblem::Shape(problem)));
        }
        self.value(measured, path)
    }

    /// Three lengths or angles; zero where they are not given.
    pub(super) fn three<K>(
        &self,
        given: Option<&[InUnit<K>; 3]>,
        path: &[DocumentStep<'_>],
    ) -> Result<[f64; 3], RobotError> {
        let mut values = [0.0; 3];
        for (place, measured) in given.into_iter().flatten().enumerate() {
            values[place] = self.value(measured, &[path, &[Index(place)]].concat())?;
        }
        Ok(values)
    }

    /// A number that must be finite and above zero.
    pub(super) fn positive<K>(
        &self,
        measured: &InUnit<K>,
        path: &[DocumentStep<'_>],
        what: impl Into<String>,
    ) -> Result<f64, RobotError> {
        self.positive_value(measured.number(), path, what)
    }

    /// A value that must be finite and above zero.
    pub(super) fn positive_value(
        &self,
        value: f64,
        path: &[DocumentStep<'_>],
        what: impl Into<String>,
    ) -> Result<f64, RobotError> {
        if value.is_finite() && value > 0.0 {
            return Ok(value);
        }
        let problem = RobotProblem::Impossible {
            what: what.into(),
            value,
            must: "it must be finite and above zero",
        };
        Err(self.error(path, problem))
    }

    /// A unit vector from a word or a vector.
    pub(super) fn axis(
        &self,
        axis: &AxisValue,
        path: &[DocumentStep<'_>],
    ) -> Result<[f64; 3], RobotError> {
        let vector = match axis {
            AxisValue::Word(word) => {
                let unsigned = word.strip_prefix(['-', '+']).unwrap_or(word);
                let Some(place) = ["x", "y", "z"].iter().position(|name| *name == unsigned) else {
                    let message =
                        "an axis is `x`, `y`, `z`, one of them with a minus sign, or a vector";
                    return Err(self.error(path, RobotProblem::Shape(message)));
                };
                let mut vector = [0.0; 3];
                vector[place] = if word.starts_with('-') { -1.0 } else { 1.0 };
                return Ok(vector);
            }
            AxisValue::Vector(vector) => *vector,
        };
        // Scaled by the largest component first: squares of very large or small numbers leave the range of an f64.
        let largest = vector.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let scaled = vector.map(|c| c / largest);
        let length = stiffbench_numeric::vector::norm(scaled);
        if length.is_finite() {
            return Ok(scaled.map(|c| c / length));
        }
        let problem = RobotProblem::Impossible {
            what: "the length of this vector".to_owned(),
            value: largest,
            must: "a direction needs a finite length above zero",
        };
        Err(self.error(path, problem))
    }

    /// Coupled limits; an upper one is a lower one with the opposite signs.
    fn limits(&self) -> Result<Vec<Limit>, RobotError> {
        let mut limits = Vec::new();
        for (place, row) in self.file.limits.iter().enumerate() {
            let at = |key| [Key("limits"), Index(place), Key(key)];
            let mut terms = Vec::new();
            for (name, coefficient) in &row.terms {
                let path = [&at("terms")[..], &[Key(name)]].concat();
                terms.push((self.variable(name, &path)?, *coefficient));
            }
            let slides = terms
                .first()
                .is_some_and(|(variable, _)| self.slides(*variable));
            let bounds = [
                (&row.at_least, "at_least", 1.0),
                (&row.at_most, "at_most", -1.0),
            ];
            if bounds.iter().all(|(bound, ..)| bound.is_none()) {
                let problem = RobotProblem::Shape("a limit needs `at_least` or `at_most`");
                return Err(self.error(&[Key("limits"), Index(place)], problem));
            }
            for (bound, key, sign) in bounds {
                if let Some(bound) = bound {
                    let terms = terms.iter().map(|(variable, c)| (*variable, sign * c));
                    limits.push(Limit {
                        terms: terms.collect(),
                        at_least_deg: sign * self.travel(bound, slides, &at(key))?,
                    });
                }
            }
        }
        Ok(limits)
    }
}
