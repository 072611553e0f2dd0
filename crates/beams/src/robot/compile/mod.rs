//! From the text of a robot file to a checked robot: every name found, every expression valued, nothing circular.

mod bodies;
mod members;
mod names;
mod nodes;
mod poses;
mod values;

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::toml_text::DocumentStep::{self, Index, Key};
use stiffbench_units_and_text::toml_text::read;

use super::Robot;
use super::error::{RobotError, RobotProblem};
use super::expression::Expression;
use super::file::{FORMAT, RobotFile};
use super::kinematics;
use super::plausible;
use super::springs::Tool;

/// Reads and checks a robot file.
pub(super) fn compile(source: &SourceText) -> Result<Robot, RobotError> {
    let (file, unknown) = read(source).map_err(|error| RobotError::File(error.into()))?;
    let compiler = Compiler::new(source, &file)?;
    let mut robot = compiler.robot()?;
    let unknown = unknown.iter().map(|key| key.warning(&source.name));
    robot.warnings.extend(unknown);
    robot.warnings.extend(plausible::oddities(&robot));
    kinematics::check_order(&robot).map_err(|circular| compiler.circular(circular))?;
    Ok(robot)
}

/// The file with its names indexed.
struct Compiler<'a> {
    source: &'a SourceText,
    file: &'a RobotFile,
    bodies: HashMap<&'a str, usize>,
    joints: HashMap<&'a str, usize>,
    elements: HashMap<&'a str, usize>,
    parameters: HashMap<&'a str, f64>,
}

impl<'a> Compiler<'a> {
    fn new(source: &'a SourceText, file: &'a RobotFile) -> Result<Self, RobotError> {
        let mut compiler = Self {
            source,
            file,
            bodies: HashMap::new(),
            joints: HashMap::new(),
            elements: HashMap::new(),
            parameters: HashMap::new(),
        };
        compiler.check_format()?;
        compiler.parameters = compiler.parameters()?;
        compiler.bodies =
            compiler.index("bodies", "body", file.bodies.iter().map(|b| b.id.as_str()))?;
        compiler.joints =
            compiler.index("joints", "joint", file.joints.iter().map(|j| j.id.as_str()))?;
        compiler.elements = compiler.index(
            "elements",
            "element",
            file.elements.iter().map(|e| e.id.as_str()),
        )?;
        Ok(compiler)
    }

    /// An error at a place of the file.
    fn error(&self, path: &[DocumentStep<'_>], problem: RobotProblem) -> RobotError {
        RobotError::at(self.source, self.source.toml_span(path), problem, None)
    }

    fn check_format(&self) -> Result<(), RobotError> {
        let unsupported = |path: &[DocumentStep<'_>], what, found: &str, expected| {
            self.error(
                path,
                RobotProblem::Unsupported {
                    what,
                    found: found.to_owned(),
                    expected,
                },
            )
        };
        if self.file.format != FORMAT {
            return Err(unsupported(
                &[Key("format")],
                "the format",
                &self.file.format,
                FORMAT,
            ));
        }
        let Some(units) = &self.file.units else {
            return Ok(());
        };
        for (key, found, expected) in [
            ("length", &units.length, "m"),
            ("angle", &units.angle, "deg"),
            ("area", &units.area, "m2"),
            ("second_moment", &units.second_moment, "m4"),
            ("modulus", &units.modulus, "Pa"),
            ("mass", &units.mass, "kg"),
        ] {
            if let Some(found) = found.as_deref().filter(|found| *found != expected) {
                return Err(unsupported(
                    &[Key("units"), Key(key)],
                    "a unit",
                    found,
                    expected,
                ));
            }
        }
        Ok(())
    }

    fn robot(&self) -> Result<Robot, RobotError> {
        let file = self.file;
        let sections = self.sections()?;
        let length = |stated: Option<&Expression>, key| {
            stated.map(|length| self.value(length, &[Key("support"), Key(key)]))
        };
        let robot = Robot {
            source: Arc::new(self.source.clone()),
            name: file.name.clone(),
            variables: self.variables()?,
            limits: self.limits()?,
            planes: self.planes()?,
            bodies: self.bodies_of_robot()?,
            joints: self.joints_of_robot()?,
            nodes: self.nodes()?,
            members: self.members(&sections)?,
            rigid_links: Vec::new(),
            supports: self.supports()?,
            end: self.node(&file.end.node, &[Key("end"), Key("node")])?,
            tool: Tool::default(),
            base: Default::default(),
            vertical: self.vertical()?,
            axis_words: self.axis_words(),
            masses: self.masses()?,
            balancers: Vec::new(),
            sections,
            mechanisms: self.mechanisms()?,
            factors: self.factors()?,
            poses: self.poses()?,
            floor_m: length(file.support.floor_m.as_ref(), "floor_m").transpose()?,
            base_radius_m: length(file.support.radius_m.as_ref(), "radius_m").transpose()?,
            warnings: Vec::new(),
        };
        if robot.mechanisms.is_empty() {
            return Err(self.error(
                &[Key("mechanisms")],
                RobotProblem::Shape("a robot needs at least one mechanism"),
            ));
        }
        Ok(robot)
    }

    fn axis_words(&self) -> [Option<String>; 3] {
        let frame = self.file.frame.as_ref();
        frame.map_or_else(Default::default, |frame| {
            [frame.x.clone(), frame.y.clone(), frame.z.clone()]
        })
    }

    /// The vertical; the other words for the axes take no part in computation, but a number in them must still be one.
    fn vertical(&self) -> Result<[f64; 3], RobotError> {
        let mut vertical = [0.0, 1.0, 0.0];
        let Some(frame) = &self.file.frame else {
            return Ok(vertical);
        };
        let vectors = [
            ("lateral", frame.lateral),
            ("vertical", frame.vertical),
            ("radial", frame.radial),
        ];
        for (key, vector) in vectors {
            if let Some(vector) = vector {
                let unit = self.unit_vector(vector, &[Key("frame"), Key(key)])?;
                if key == "vertical" {
                    vertical = unit;
                }
            }
        }
        Ok(vertical)
    }

    /// The error for a body or node that needs itself.
    fn circular(&self, circular: kinematics::Circular) -> RobotError {
        let span: Range<usize> = match circular.kind {
            "body" => self
                .bodies
                .get(circular.name.as_str())
                .map_or(0..0, |place| {
                    self.source
                        .toml_span(&[Key("bodies"), Index(*place), Key("id")])
                }),
            _ => self.source.toml_span(&[Key("nodes"), Key(&circular.name)]),
        };
        let kinematics::Circular { kind, name, chain } = circular;
        RobotError::at(
            self.source,
            span,
            RobotProblem::Circular { kind, name, chain },
            None,
        )
    }
}
