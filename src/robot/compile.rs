//! From the text of a robot file to a checked robot: every name found, every expression valued, nothing circular.

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use indexmap::IndexMap;

use crate::source_text::{SourceText, Step, nearest};
use crate::structure::{Material, Section, ShearCoefficients};
use crate::test_point::PoseId;

use super::error::{RobotError, RobotProblem};
use super::expression::Expression;
use super::file::{self, FORMAT, NodeEntry, PoseValue, Radius, RobotFile};
use super::kinematics;
use super::mechanism::Mechanism;
use super::model::{
    Angle, Body, BodyPlace, FittingFactors, Joint, Limit, Member, NamedPose, NodePlace, Plane,
    Pose, RadiusOf, RobotNode, Variable,
};
use super::{RatedSection, Robot};
use Step::{Index, Key};

/// Shear coefficient of a rectangle (Timoshenko 1921), used when a section names none.
const DEFAULT_SHEAR_COEFFICIENT: f64 = 5.0 / 6.0;

/// Reads and checks a robot file.
pub(super) fn compile(source: &SourceText) -> Result<Robot, RobotError> {
    let (file, unknown_keys) = deserialize(source)?;
    let compiler = Compiler::new(source, &file)?;
    let mut robot = compiler.robot()?;
    robot.warnings.extend(
        unknown_keys
            .into_iter()
            .map(|key| format!("{}: key `{key}` is not known and was not used", source.name)),
    );
    kinematics::check_order(&robot).map_err(|circular| compiler.circular(circular))?;
    Ok(robot)
}

/// The file's types from its text, and the keys that belong to none of them.
fn deserialize(source: &SourceText) -> Result<(RobotFile, Vec<String>), RobotError> {
    let syntax = |error: &toml::de::Error| {
        let span = error.span().unwrap_or(0..0);
        RobotError::at(
            source,
            span,
            RobotProblem::Syntax(error.message().to_owned()),
            None,
        )
    };
    let deserializer = toml::Deserializer::parse(&source.text).map_err(|error| syntax(&error))?;
    let mut unknown = Vec::new();
    let file = serde_ignored::deserialize(deserializer, |path| unknown.push(path.to_string()))
        .map_err(|error| syntax(&error))?;
    Ok((file, unknown))
}

/// The file with its names indexed.
struct Compiler<'a> {
    source: &'a SourceText,
    file: &'a RobotFile,
    bodies: HashMap<&'a str, usize>,
    joints: HashMap<&'a str, usize>,
    elements: HashMap<&'a str, usize>,
}

impl<'a> Compiler<'a> {
    fn new(source: &'a SourceText, file: &'a RobotFile) -> Result<Self, RobotError> {
        let mut compiler = Self {
            source,
            file,
            bodies: HashMap::new(),
            joints: HashMap::new(),
            elements: HashMap::new(),
        };
        compiler.check_format()?;
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
        place.ok_or_else(|| {
            let known: Vec<&str> = known.collect();
            let help = match nearest(name, known.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("the file has: {}", known.join(", ")),
            };
            let problem = RobotProblem::UnknownName {
                kind,
                name: name.to_owned(),
            };
            RobotError::at(
                self.source,
                self.source.toml_span(path),
                problem,
                Some(help),
            )
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

    fn variable(&self, name: &str, path: &[Step<'_>]) -> Result<usize, RobotError> {
        let variables = &self.file.variables;
        self.found(
            variables.get_index_of(name),
            path,
            "variable",
            name,
            variables.keys().map(String::as_str),
        )
    }

    /// Value of an expression; parameters may use one another.
    fn value(&self, expression: &Expression, path: &[Step<'_>]) -> Result<f64, RobotError> {
        fn parameter(file: &RobotFile, name: &str, depth: usize) -> Option<f64> {
            // A chain longer than the list of parameters comes back to itself.
            if depth > file.parameters.len() {
                return None;
            }
            file.parameters
                .get(name)?
                .value(&|inner| parameter(file, inner, depth + 1))
                .ok()
        }
        expression
            .value(&|name| parameter(self.file, name, 0))
            .map_err(|problem| self.error(path, problem.into()))
    }

    /// A number that must be finite and above zero (`strict`) or not below it.
    fn positive(
        &self,
        value: f64,
        strict: bool,
        path: &[Step<'_>],
        what: String,
    ) -> Result<f64, RobotError> {
        if value.is_finite() && (value > 0.0 || (!strict && value == 0.0)) {
            return Ok(value);
        }
        let must = if strict {
            "it must be above zero"
        } else {
            "it must not be below zero"
        };
        Err(self.error(path, RobotProblem::Impossible { what, value, must }))
    }

    /// A direction, scaled to length one.
    fn unit_vector(&self, vector: [f64; 3], path: &[Step<'_>]) -> Result<[f64; 3], RobotError> {
        let length = vector.iter().map(|c| c * c).sum::<f64>().sqrt();
        if length.is_finite() && length > 0.0 {
            return Ok(vector.map(|c| c / length));
        }
        let what = "the length of this vector".to_owned();
        Err(self.error(
            path,
            RobotProblem::Impossible {
                what,
                value: length,
                must: "a direction needs a length above zero",
            },
        ))
    }

    fn robot(&self) -> Result<Robot, RobotError> {
        let file = self.file;
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
            supports: self.names(
                &file.support.fixed,
                &[Key("support"), Key("fixed")],
                Self::node,
            )?,
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
                    Ok((
                        self.variable(name, &[&at[..], &[Key("terms"), Key(name)]].concat())?,
                        *c,
                    ))
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
            (None, None) => Ok(BodyPlace::Ground),
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
                Ok(BodyPlace::Along {
                    nodes: [self.node(first, &along(0))?, self.node(second, &along(1))?],
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
                if branch.abs() != 1 {
                    let problem = RobotProblem::Impossible {
                        what: format!("the branch of {name}"),
                        value: f64::from(*branch),
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
                Ok(NodePlace::Loop {
                    centres: [first.0, second.0],
                    radii: [first.1, second.1],
                    plane: self.plane(plane, &at("plane"))?,
                    branch: f64::from(*branch),
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
                self.positive(value, true, path, "the radius".to_owned())
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
            Ok(Member {
                name: entry.id.clone(),
                nodes: [node(0)?, node(1)?],
                chain: entry.chain.clone(),
                class: entry.class,
                section: self.found(section, &at("section"), "section", &entry.section, known)?,
                body: self.body(&entry.body, &at("body"))?,
                plane: self.plane(&entry.plane, &at("plane"))?,
            })
        };
        self.file.elements.iter().enumerate().map(member).collect()
    }

    fn sections(&self) -> Result<IndexMap<String, RatedSection>, RobotError> {
        let mut sections = IndexMap::new();
        for (name, entry) in &self.file.sections {
            let at = |key| [Key("sections"), Key(name), Key(key)];
            let materials = &self.file.materials;
            let known = materials.keys().map(String::as_str);
            let place = materials.get_index_of(&entry.material);
            let place = self.found(place, &at("material"), "material", &entry.material, known)?;
            let material_path = |key| [Key("materials"), Key(&entry.material), Key(key)];
            let constant = |value, key| {
                self.positive(value, true, &at(key), format!("{key} of section {name}"))
            };
            let modulus = |value, key| {
                self.positive(
                    value,
                    true,
                    &material_path(key),
                    format!("{key} of material {}", entry.material),
                )
            };
            let material = &materials[place];
            let mut shear = [DEFAULT_SHEAR_COEFFICIENT; 2];
            for (value, given) in shear.iter_mut().zip(entry.shear.iter().flatten()) {
                *value = self.positive(
                    *given,
                    true,
                    &at("shear"),
                    format!("a shear coefficient of section {name}"),
                )?;
            }
            let rated = RatedSection {
                section: Section {
                    area_m2: constant(entry.area, "A")?,
                    iy_m4: constant(entry.iy, "Iy")?,
                    iz_m4: constant(entry.iz, "Iz")?,
                    j_m4: constant(entry.j, "J")?,
                },
                material: Material {
                    youngs_modulus_pa: modulus(material.youngs_modulus, "E")?,
                    shear_modulus_pa: modulus(material.shear_modulus, "G")?,
                },
                shear: ShearCoefficients {
                    along_y: shear[0],
                    along_z: shear[1],
                },
            };
            sections.insert(name.clone(), rated);
        }
        Ok(sections)
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
                    self.positive(
                        value,
                        true,
                        &path,
                        format!("factor {key} of {class} in {name}"),
                    )
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
