//! From the text of a robot file to a checked robot: every name found, every expression valued, nothing circular.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use indexmap::IndexMap;

use crate::source_text::{SourceText, Step, nearest};
use crate::structure::{Material, Section, ShearCoefficients};
use crate::test_point::PoseId;
use crate::vector::norm;

use super::error::{RobotError, RobotProblem};
use super::expression::{Expression, ExpressionError, in_range};
use super::file::{self, FORMAT, NodeEntry, PoseValue, Radius, RobotFile};
use super::kinematics;
use super::mechanism::Mechanism;
use super::model::{
    Angle, Body, BodyPlace, FittingFactors, Joint, Limit, Member, NamedPose, NodePlace, Plane,
    Pose, RadiusOf, RobotNode, Variable,
};
use super::parameters::{self, ParameterProblem};
use super::{RatedSection, Robot};
use Step::{Index, Key};

/// Shear coefficient of a rectangle (Timoshenko 1921), used when a section names none.
const DEFAULT_SHEAR_COEFFICIENT: f64 = 5.0 / 6.0;

/// Reads and checks a robot file.
pub(super) fn compile(source: &SourceText) -> Result<Robot, RobotError> {
    let (file, unknown) = deserialize(source)?;
    let compiler = Compiler::new(source, &file)?;
    let mut robot = compiler.robot()?;
    robot.warnings.extend(unknown);
    kinematics::check_order(&robot).map_err(|circular| compiler.circular(circular))?;
    Ok(robot)
}

/// The file's types from its text, and a warning for each key that belongs to none of them.
fn deserialize(source: &SourceText) -> Result<(RobotFile, Vec<String>), RobotError> {
    let syntax = |error: &toml::de::Error| {
        let span = error.span().unwrap_or(0..0);
        let problem = RobotProblem::Syntax(in_words_of_toml(error.message()));
        RobotError::at(source, span, problem, None)
    };
    let deserializer = toml::Deserializer::parse(&source.text).map_err(|error| syntax(&error))?;
    let spans = source.toml_spans();
    let mut warnings = Vec::new();
    let file = serde_ignored::deserialize(deserializer, |path| {
        let mut steps = Vec::new();
        collect_steps(&path, &mut steps);
        let start = spans.as_ref().map_or(0, |spans| spans.key(&steps).start);
        let (line, column) = source.line_and_column(start);
        let file = &source.name;
        let key = path.to_string();
        warnings.push(format!(
            "{file}:{line}:{column}: key `{key}` is not known and was not used"
        ));
    })
    .map_err(|error| syntax(&error))?;
    Ok((file, warnings))
}

/// The way to an ignored key.
fn collect_steps<'a>(path: &'a serde_ignored::Path<'_>, steps: &mut Vec<Step<'a>>) {
    use serde_ignored::Path;
    match path {
        Path::Root => {}
        Path::Seq { parent, index } => {
            collect_steps(parent, steps);
            steps.push(Index(*index));
        }
        Path::Map { parent, key } => {
            collect_steps(parent, steps);
            steps.push(Key(key));
        }
        Path::Some { parent }
        | Path::NewtypeStruct { parent }
        | Path::NewtypeVariant { parent } => collect_steps(parent, steps),
    }
}

/// A message of the reader in words that the author of a TOML file knows.
fn in_words_of_toml(message: &str) -> String {
    let message = match message.split_once("expected struct ") {
        Some((before, _)) => format!("{before}expected a table"),
        None => message.to_owned(),
    };
    [
        ("missing field", "missing key"),
        ("unknown variant", "unknown word"),
        ("expected f64", "expected a number"),
        ("expected i64", "expected a whole number"),
        ("a sequence", "an array"),
        ("a map", "a table"),
    ]
    .into_iter()
    .fold(message, |text, (from, to)| text.replace(from, to))
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
    fn error(&self, path: &[Step<'_>], problem: RobotProblem) -> RobotError {
        RobotError::at(self.source, self.source.toml_span(path), problem, None)
    }

    fn check_format(&self) -> Result<(), RobotError> {
        let unsupported = |path: &[Step<'_>], what, found: &str, expected| {
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

    /// Places of the entries of an array of tables by their `id`.
    fn index(
        &self,
        array: &str,
        kind: &'static str,
        ids: impl Iterator<Item = &'a str>,
    ) -> Result<HashMap<&'a str, usize>, RobotError> {
        let mut places = HashMap::new();
        for (place, id) in ids.enumerate() {
            if places.insert(id, place).is_some() {
                let problem = RobotProblem::Duplicate {
                    kind,
                    name: id.to_owned(),
                };
                return Err(self.error(&[Key(array), Index(place), Key("id")], problem));
            }
        }
        Ok(places)
    }

    /// Turns a found place into itself and a missing one into an error at `path`, with the nearest name as help.
    fn found<'k>(
        &self,
        place: Option<usize>,
        path: &[Step<'_>],
        kind: &'static str,
        name: &str,
        known: impl Iterator<Item = &'k str>,
    ) -> Result<usize, RobotError> {
        self.found_at(place, || self.source.toml_span(path), kind, name, known)
    }

    /// The same with the bytes to point at.
    fn found_at<'k>(
        &self,
        place: Option<usize>,
        span: impl FnOnce() -> Range<usize>,
        kind: &'static str,
        name: &str,
        known: impl Iterator<Item = &'k str>,
    ) -> Result<usize, RobotError> {
        place.ok_or_else(|| {
            let known: Vec<&str> = known.collect();
            let help = match nearest(name, known.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None if known.is_empty() => "the file has none".to_owned(),
                None => format!("the file has: {}", known.join(", ")),
            };
            let problem = RobotProblem::UnknownName {
                kind,
                name: name.to_owned(),
            };
            RobotError::at(self.source, span(), problem, Some(help))
        })
    }

    fn node(&self, name: &str, path: &[Step<'_>]) -> Result<usize, RobotError> {
        let nodes = &self.file.nodes;
        self.found(
            nodes.get_index_of(name),
            path,
            "node",
            name,
            nodes.keys().map(String::as_str),
        )
    }

    fn body(&self, name: &str, path: &[Step<'_>]) -> Result<usize, RobotError> {
        let known = self.file.bodies.iter().map(|b| b.id.as_str());
        self.found(self.bodies.get(name).copied(), path, "body", name, known)
    }

    fn joint(&self, name: &str, path: &[Step<'_>]) -> Result<usize, RobotError> {
        let known = self.file.joints.iter().map(|j| j.id.as_str());
        self.found(self.joints.get(name).copied(), path, "joint", name, known)
    }

    fn plane(&self, name: &str, path: &[Step<'_>]) -> Result<usize, RobotError> {
        let planes = &self.file.planes;
        self.found(
            planes.get_index_of(name),
            path,
            "plane",
            name,
            planes.keys().map(String::as_str),
        )
    }

    /// Place of a variable that a file names as the last key of `path`.
    fn variable(&self, name: &str, path: &[Step<'_>]) -> Result<usize, RobotError> {
        let variables = &self.file.variables;
        let known = variables.keys().map(String::as_str);
        let span = || self.source.toml_key_span(path);
        self.found_at(variables.get_index_of(name), span, "variable", name, known)
    }

    /// Values of the parameters.
    fn parameters(&self) -> Result<HashMap<&'a str, f64>, RobotError> {
        parameters::values(&self.file.parameters).map_err(|(name, problem)| {
            let path = [Key("parameters"), Key(name)];
            match problem {
                ParameterProblem::Expression(problem) => self.no_value(problem, &path),
                ParameterProblem::Circular(around) => self.error(
                    &path,
                    RobotProblem::Circular {
                        kind: "parameter",
                        name: name.to_owned(),
                        chain: around.join(" needs "),
                    },
                ),
            }
        })
    }

    /// Value of an expression, m or degrees.
    fn value(&self, expression: &Expression, path: &[Step<'_>]) -> Result<f64, RobotError> {
        expression
            .value(&|name| self.parameters.get(name).copied())
            .map_err(|problem| self.no_value(problem, path))
    }

    /// The error for an expression without value, with the nearest parameter as help.
    fn no_value(&self, problem: ExpressionError, path: &[Step<'_>]) -> RobotError {
        let help = match &problem {
            ExpressionError::UnknownName { name } => {
                let known = self.file.parameters.keys().map(String::as_str);
                nearest(name, known).map(|near| format!("did you mean `{near}`?"))
            }
            _ => None,
        };
        RobotError::at(
            self.source,
            self.source.toml_span(path),
            problem.into(),
            help,
        )
    }

    /// A coefficient or coordinate that is a plain number.
    fn number(&self, value: f64, path: &[Step<'_>]) -> Result<f64, RobotError> {
        in_range(value).map_err(|problem| self.error(path, problem.into()))
    }

    /// A number that must be finite and above zero.
    fn positive(&self, value: f64, path: &[Step<'_>], what: String) -> Result<f64, RobotError> {
        if value.is_finite() && value > 0.0 {
            return Ok(value);
        }
        let must = "it must be finite and above zero";
        Err(self.error(path, RobotProblem::Impossible { what, value, must }))
    }

    /// A direction, scaled to length one.
    fn unit_vector(&self, vector: [f64; 3], path: &[Step<'_>]) -> Result<[f64; 3], RobotError> {
        // Scaled by the largest component first: squares of very large or small numbers leave the range of an f64.
        let largest = vector.iter().fold(0.0_f64, |m, c| m.max(c.abs()));
        let scaled = vector.map(|c| c / largest);
        let scaled_length = norm(scaled);
        if scaled_length.is_finite() {
            return Ok(scaled.map(|c| c / scaled_length));
        }
        let length = norm(vector);
        let what = "the length of this vector".to_owned();
        Err(self.error(
            path,
            RobotProblem::Impossible {
                what,
                value: length,
                must: "a direction needs a finite length above zero",
            },
        ))
    }

    fn robot(&self) -> Result<Robot, RobotError> {
        let file = self.file;
        self.check_frame()?;
        let sections = self.sections()?;
        let robot = Robot {
            name: file.name.clone(),
            variables: self.variables()?,
            limits: self.limits()?,
            planes: self.planes()?,
            bodies: self.bodies_of_robot()?,
            joints: self.joints_of_robot()?,
            nodes: self.nodes()?,
            members: self.members(&sections)?,
            supports: self.supports()?,
            end: self.node(&file.end.node, &[Key("end"), Key("node")])?,
            sections,
            mechanisms: self.mechanisms()?,
            factors: self.factors()?,
            poses: self.poses()?,
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

    fn supports(&self) -> Result<Vec<usize>, RobotError> {
        let fixed = &self.file.support.fixed;
        let path = [Key("support"), Key("fixed")];
        let nodes = self.names(fixed, &path, Self::node)?;
        for (place, node) in nodes.iter().enumerate() {
            if nodes[..place].contains(node) {
                let problem = RobotProblem::Duplicate {
                    kind: "support",
                    name: fixed[place].clone(),
                };
                return Err(self.error(&[&path[..], &[Index(place)]].concat(), problem));
            }
        }
        Ok(nodes)
    }

    /// The words for the axes take no part in computation, but a number in them must still be one.
    fn check_frame(&self) -> Result<(), RobotError> {
        let Some(frame) = &self.file.frame else {
            return Ok(());
        };
        let vectors = [
            ("lateral", frame.lateral),
            ("vertical", frame.vertical),
            ("radial", frame.radial),
        ];
        for (key, vector) in vectors {
            if let Some(vector) = vector {
                self.unit_vector(vector, &[Key("frame"), Key(key)])?;
            }
        }
        Ok(())
    }

    /// Places of a list of names.
    fn names(
        &self,
        names: &[String],
        path: &[Step<'_>],
        find: impl Fn(&Self, &str, &[Step<'_>]) -> Result<usize, RobotError>,
    ) -> Result<Vec<usize>, RobotError> {
        names
            .iter()
            .enumerate()
            .map(|(place, name)| find(self, name, &[path, &[Index(place)]].concat()))
            .collect()
    }

    fn variables(&self) -> Result<Vec<Variable>, RobotError> {
        let mut variables = Vec::new();
        for (name, entry) in &self.file.variables {
            let at = |key| [Key("variables"), Key(name), Key(key)];
            let variable = Variable {
                name: name.clone(),
                min_deg: self.value(&entry.min, &at("min"))?,
                max_deg: self.value(&entry.max, &at("max"))?,
                nominal_deg: self.value(&entry.nominal, &at("nominal"))?,
            };
            if variable.min_deg > variable.max_deg {
                let problem = RobotProblem::Impossible {
                    what: format!("the smallest value of {name}"),
                    value: variable.min_deg,
                    must: "it must not be above the largest",
                };
                return Err(self.error(&at("min"), problem));
            }
            variables.push(variable);
        }
        Ok(variables)
    }

    fn limits(&self) -> Result<Vec<Limit>, RobotError> {
        let limit = |(place, entry): (usize, &file::LimitEntry)| {
            let at = [Key("limits"), Index(place)];
            let terms = entry
                .terms
                .iter()
                .map(|(name, c)| {
                    let path = [&at[..], &[Key("terms"), Key(name)]].concat();
                    Ok((self.variable(name, &path)?, self.number(*c, &path)?))
                })
                .collect::<Result<_, RobotError>>()?;
            let at_least_deg =
                self.value(&entry.at_least, &[&at[..], &[Key("at_least")]].concat())?;
            Ok(Limit {
                terms,
                at_least_deg,
            })
        };
        self.file.limits.iter().enumerate().map(limit).collect()
    }

    fn planes(&self) -> Result<Vec<Plane>, RobotError> {
        let plane = |(name, entry): (&String, &file::PlaneEntry)| {
            let at = |key| [Key("planes"), Key(name), Key(key)];
            Ok(Plane {
                name: name.clone(),
                body: self.body(&entry.body, &at("body"))?,
                normal: self.unit_vector(entry.normal, &at("normal"))?,
            })
        };
        self.file.planes.iter().map(plane).collect()
    }

    fn bodies_of_robot(&self) -> Result<Vec<Body>, RobotError> {
        let body = |(place, entry): (usize, &file::BodyEntry)| {
            Ok(Body {
                name: entry.id.clone(),
                chain: entry.chain.clone(),
                place: self.body_place(place, entry)?,
            })
        };
        self.file.bodies.iter().enumerate().map(body).collect()
    }

    fn body_place(&self, place: usize, entry: &file::BodyEntry) -> Result<BodyPlace, RobotError> {
        let at = |key| [Key("bodies"), Index(place), Key(key)];
        let shape =
            |message| Err(self.error(&[Key("bodies"), Index(place)], RobotProblem::Shape(message)));
        match (&entry.parent, &entry.along) {
            (None, None)
                if entry.has_turn() || entry.plane.is_some() || entry.turn_deg.is_some() =>
            {
                shape(
                    "a body with `origin`, `axis` or `angle` needs `parent`; one with `plane` or `turn_deg` needs `along`",
                )
            }
            (None, None) => Ok(BodyPlace::Ground),
            (Some(_), None) if entry.plane.is_some() || entry.turn_deg.is_some() => {
                shape("`plane` and `turn_deg` belong to a body with `along`, this one has `parent`")
            }
            (None, Some(_)) if entry.has_turn() => shape(
                "`origin`, `axis` and `angle` belong to a body with `parent`, this one has `along`",
            ),
            (Some(_), Some(_)) => shape("a body has either `parent` or `along`, not both"),
            (Some(parent), None) => {
                let (Some(origin), Some(axis)) = (&entry.origin, entry.axis) else {
                    return shape("a body with `parent` needs `origin` and `axis`");
                };
                let mut angle = Angle::default();
                for (name, expression) in entry.angle.iter().flatten() {
                    let path = [Key("bodies"), Index(place), Key("angle"), Key(name)];
                    let value = self.value(expression, &path)?;
                    if name == "offset_deg" {
                        angle.offset_deg = value;
                    } else {
                        angle.terms.push((self.variable(name, &path)?, value));
                    }
                }
                Ok(BodyPlace::Turned {
                    parent: self.body(parent, &at("parent"))?,
                    origin: self.node(origin, &at("origin"))?,
                    axis: self.unit_vector(axis, &at("axis"))?,
                    angle,
                })
            }
            (None, Some([first, second])) => {
                let Some(plane) = &entry.plane else {
                    return shape("a body with `along` needs `plane`");
                };
                let along = |index| [Key("bodies"), Index(place), Key("along"), Index(index)];
                let nodes = [self.node(first, &along(0))?, self.node(second, &along(1))?];
                self.apart(
                    nodes,
                    &at("along"),
                    "a body with `along` needs two different nodes",
                )?;
                Ok(BodyPlace::Along {
                    nodes,
                    plane: self.plane(plane, &at("plane"))?,
                    turn_deg: entry
                        .turn_deg
                        .as_ref()
                        .map_or(Ok(0.0), |turn| self.value(turn, &at("turn_deg")))?,
                })
            }
        }
    }

    fn joints_of_robot(&self) -> Result<Vec<Joint>, RobotError> {
        let joint = |(place, entry): (usize, &file::JointEntry)| {
            let at = |key| [Key("joints"), Index(place), Key(key)];
            let body = |index: usize| {
                self.body(
                    entry.bodies[index].as_str(),
                    &[&at("bodies")[..], &[Index(index)]].concat(),
                )
            };
            Ok(Joint {
                name: entry.id.clone(),
                node: self.node(&entry.node, &at("node"))?,
                bodies: [body(0)?, body(1)?],
                chain: entry.chain.clone(),
                plane: self.plane(&entry.axis, &at("axis"))?,
            })
        };
        self.file.joints.iter().enumerate().map(joint).collect()
    }

    /// Refuses one node where two are needed.
    fn apart(
        &self,
        [first, second]: [usize; 2],
        path: &[Step<'_>],
        message: &'static str,
    ) -> Result<(), RobotError> {
        if first == second {
            return Err(self.error(path, RobotProblem::Shape(message)));
        }
        Ok(())
    }

    fn nodes(&self) -> Result<Vec<RobotNode>, RobotError> {
        let node = |(name, entry): (&String, &NodeEntry)| {
            Ok(RobotNode {
                name: Arc::from(name.as_str()),
                place: self.node_place(name, entry)?,
            })
        };
        self.file.nodes.iter().map(node).collect()
    }

    fn node_place(&self, name: &str, entry: &NodeEntry) -> Result<NodePlace, RobotError> {
        let at = |key| [Key("nodes"), Key(name), Key(key)];
        match entry {
            NodeEntry::Fixed {
                on,
                at: coordinates,
            } => {
                let mut at_m = [0.0; 3];
                for (place, (value, expression)) in at_m.iter_mut().zip(coordinates).enumerate() {
                    *value = self.value(expression, &[&at("at")[..], &[Index(place)]].concat())?;
                }
                Ok(NodePlace::Fixed {
                    body: self.body(on, &at("on"))?,
                    at_m,
                })
            }
            NodeEntry::Loop {
                circles,
                plane,
                branch,
            } => {
                if ![1, -1].contains(branch) {
                    let problem = RobotProblem::Impossible {
                        what: format!("the branch of {name}"),
                        value: *branch as f64,
                        must: "it must be 1 or -1",
                    };
                    return Err(self.error(&at("branch"), problem));
                }
                let circle = |place: usize| {
                    let path = |inner| {
                        [
                            Key("nodes"),
                            Key(name),
                            Key("loop"),
                            Index(place),
                            Index(inner),
                        ]
                    };
                    let (centre, radius) = &circles[place];
                    Ok((self.node(centre, &path(0))?, self.radius(radius, &path(1))?))
                };
                let [first, second] = [circle(0)?, circle(1)?];
                self.apart(
                    [first.0, second.0],
                    &at("loop"),
                    "a loop needs two different centres",
                )?;
                Ok(NodePlace::Loop {
                    centres: [first.0, second.0],
                    radii: [first.1, second.1],
                    plane: self.plane(plane, &at("plane"))?,
                    branch: *branch as f64,
                })
            }
        }
    }

    fn radius(&self, radius: &Radius, path: &[Step<'_>]) -> Result<RadiusOf, RobotError> {
        match radius {
            Radius::Distance { dist } => {
                let node = |place: usize| {
                    self.node(&dist[place], &[path, &[Key("dist"), Index(place)]].concat())
                };
                Ok(RadiusOf::Distance([node(0)?, node(1)?]))
            }
            Radius::Length(expression) => {
                let value = self.value(expression, path)?;
                self.positive(value, path, "the radius".to_owned())
                    .map(RadiusOf::Length)
            }
        }
    }

    fn members(
        &self,
        sections: &IndexMap<String, RatedSection>,
    ) -> Result<Vec<Member>, RobotError> {
        let member = |(place, entry): (usize, &file::ElementEntry)| {
            let at = |key| [Key("elements"), Index(place), Key(key)];
            let node = |index: usize| {
                self.node(
                    entry.nodes[index].as_str(),
                    &[&at("nodes")[..], &[Index(index)]].concat(),
                )
            };
            let known = sections.keys().map(String::as_str);
            let section = sections.get_index_of(&entry.section);
            let nodes = [node(0)?, node(1)?];
            self.apart(nodes, &at("nodes"), "an element needs two different nodes")?;
            Ok(Member {
                name: entry.id.clone(),
                nodes,
                chain: entry.chain.clone(),
                class: entry.class,
                section: self.found(section, &at("section"), "section", &entry.section, known)?,
                body: self.body(&entry.body, &at("body"))?,
                plane: self.plane(&entry.plane, &at("plane"))?,
            })
        };
        self.file.elements.iter().enumerate().map(member).collect()
    }

    fn materials(&self) -> Result<Vec<Material>, RobotError> {
        let material = |(name, entry): (&String, &file::MaterialEntry)| {
            let modulus = |value, key| {
                let path = [Key("materials"), Key(name), Key(key)];
                self.positive(value, &path, format!("{key} of material {name}"))
            };
            Ok(Material {
                youngs_modulus_pa: modulus(entry.youngs_modulus, "E")?,
                shear_modulus_pa: modulus(entry.shear_modulus, "G")?,
            })
        };
        self.file.materials.iter().map(material).collect()
    }

    fn sections(&self) -> Result<IndexMap<String, RatedSection>, RobotError> {
        let materials = self.materials()?;
        let names = &self.file.materials;
        let section = |(name, entry): (&String, &file::SectionEntry)| {
            let at = |key| [Key("sections"), Key(name), Key(key)];
            let known = names.keys().map(String::as_str);
            let place = names.get_index_of(&entry.material);
            let place = self.found(place, &at("material"), "material", &entry.material, known)?;
            let constant =
                |value, key| self.positive(value, &at(key), format!("{key} of section {name}"));
            let mut shear = [DEFAULT_SHEAR_COEFFICIENT; 2];
            for (value, given) in shear.iter_mut().zip(entry.shear.iter().flatten()) {
                let what = format!("a shear coefficient of section {name}");
                *value = self.positive(*given, &at("shear"), what)?;
            }
            let rated = RatedSection {
                section: Section {
                    area_m2: constant(entry.area, "A")?,
                    iy_m4: constant(entry.iy, "Iy")?,
                    iz_m4: constant(entry.iz, "Iz")?,
                    j_m4: constant(entry.j, "J")?,
                },
                material: materials[place],
                shear: ShearCoefficients {
                    along_y: shear[0],
                    along_z: shear[1],
                },
            };
            Ok((name.clone(), rated))
        };
        self.file.sections.iter().map(section).collect()
    }

    fn mechanisms(&self) -> Result<IndexMap<String, Mechanism>, RobotError> {
        let mut mechanisms = IndexMap::new();
        for (name, entry) in &self.file.mechanisms {
            let at = |key| [Key("mechanisms"), Key(name), Key(key)];
            for (place, chain) in entry.chains.iter().enumerate() {
                let mut chains = self.file.elements.iter().map(|e| e.chain.as_str());
                let exists = chains.any(|c| c == chain).then_some(0);
                let known = self.file.elements.iter().map(|e| e.chain.as_str());
                self.found(
                    exists,
                    &[&at("chains")[..], &[Index(place)]].concat(),
                    "chain",
                    chain,
                    known,
                )?;
            }
            let element = |compiler: &Self, name: &str, path: &[Step<'_>]| {
                let known = compiler.file.elements.iter().map(|e| e.id.as_str());
                compiler.found(
                    compiler.elements.get(name).copied(),
                    path,
                    "element",
                    name,
                    known,
                )
            };
            let single = self.names(&entry.elements, &at("elements"), element)?;
            let mut locked = self.names(&entry.locked, &at("locked"), Self::joint)?;
            for (motor, joint) in &entry.drives {
                locked.push(self.joint(joint, &[&at("drives")[..], &[Key(motor)]].concat())?);
            }
            let members = (0..self.file.elements.len())
                .filter(|place| {
                    entry.chains.contains(&self.file.elements[*place].chain)
                        || single.contains(place)
                })
                .collect();
            mechanisms.insert(
                name.clone(),
                Mechanism {
                    name: name.clone(),
                    chains: entry.chains.clone(),
                    members,
                    locked,
                },
            );
        }
        Ok(mechanisms)
    }

    fn factors(&self) -> Result<IndexMap<String, FittingFactors>, RobotError> {
        let mut sets = IndexMap::new();
        for (name, entry) in &self.file.factors {
            let class = |class: &str, factors: file::FactorEntry| -> Result<[f64; 4], RobotError> {
                let factor = |value, key| {
                    let path = [Key("factors"), Key(name), Key(class), Key(key)];
                    self.positive(value, &path, format!("factor {key} of {class} in {name}"))
                };
                Ok([
                    factor(factors.area, "A")?,
                    factor(factors.iy, "Iy")?,
                    factor(factors.iz, "Iz")?,
                    factor(factors.j, "J")?,
                ])
            };
            let set = FittingFactors {
                beam: class("beam", entry.beam)?,
                link: class("link", entry.link)?,
            };
            sets.insert(name.clone(), set);
        }
        Ok(sets)
    }

    fn poses(&self) -> Result<Vec<NamedPose>, RobotError> {
        let nominal: Vec<f64> = self
            .variables()?
            .iter()
            .map(|variable| variable.nominal_deg)
            .collect();
        let mut poses = Vec::new();
        for (name, entry) in &self.file.poses {
            let mut pose = NamedPose {
                id: PoseId::new(name),
                pose: Pose {
                    angles_deg: nominal.clone(),
                },
                stated_zy_m: None,
            };
            for (key, value) in entry {
                let path = [Key("poses"), Key(name), Key(key)];
                match value {
                    PoseValue::Point(point) if key == "paper_z_y" => {
                        for (place, value) in point.iter().enumerate() {
                            self.number(*value, &[&path[..], &[Index(place)]].concat())?;
                        }
                        pose.stated_zy_m = Some(*point);
                    }
                    PoseValue::Angle(expression) => {
                        let variable = self.variable(key, &path)?;
                        pose.pose.angles_deg[variable] = self.value(expression, &path)?;
                    }
                    PoseValue::Point(_) => {
                        return Err(self.error(
                            &path,
                            RobotProblem::Shape("only `paper_z_y` may be a point"),
                        ));
                    }
                }
            }
            poses.push(pose);
        }
        Ok(poses)
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
