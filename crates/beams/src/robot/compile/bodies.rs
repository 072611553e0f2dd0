//! Variables with their limits, planes, bodies and joints.

use crate::robot::error::{RobotError, RobotProblem};
use crate::robot::file;
use crate::robot::model::{Angle, Body, BodyPlace, Joint, Limit, Plane, Variable};
use crate::robot::spring_axis::JointMotion;
use crate::robot::springs::JointSprings;
use stiffbench_units_and_text::toml_text::DocumentStep::{Index, Key};

use super::Compiler;

impl Compiler<'_> {
    pub(super) fn variables(&self) -> Result<Vec<Variable>, RobotError> {
        let mut variables = Vec::new();
        for (name, entry) in &self.file.variables {
            let at = |key| [Key("variables"), Key(name), Key(key)];
            let variable = Variable {
                name: name.clone(),
                motion: JointMotion::Turns,
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

    pub(super) fn limits(&self) -> Result<Vec<Limit>, RobotError> {
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

    pub(super) fn planes(&self) -> Result<Vec<Plane>, RobotError> {
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

    pub(super) fn bodies_of_robot(&self) -> Result<Vec<Body>, RobotError> {
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

    pub(super) fn joints_of_robot(&self) -> Result<Vec<Joint>, RobotError> {
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
                motion: JointMotion::Turns,
                springs: JointSprings::default(),
            })
        };
        self.file.joints.iter().enumerate().map(joint).collect()
    }
}
