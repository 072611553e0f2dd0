//! Points, the tool, and joints where loops close.

use stiffbench_units_and_text::toml_text::DocumentStep::{self, Index, Key};

use crate::robot::error::{RobotError, RobotProblem};
use crate::robot::model::{Joint, NodePlace, RadiusOf};
use crate::robot::spring_axis::JointMotion;
use crate::robot::springs::{Payload, SpringDefault, Tool};

use super::builder::{MOUNT, RobotBuilder, TOOL};
use super::file::{JointKind, JointRow, PointRow};
use super::frames::{columns, product, roll_pitch_yaw};

impl RobotBuilder<'_> {
    /// The points of the file.
    pub(super) fn place_points(&mut self) -> Result<(), RobotError> {
        for (name, row) in &self.file.points {
            let node = self.point(name, &[Key("points"), Key(name)])?;
            let place = self.point_place(name, row)?;
            if let NodePlace::Fixed { body, .. } = place {
                self.bodies_of_node[node].insert(0, body);
            }
            self.nodes[node] = place;
        }
        Ok(())
    }

    fn point_place(&mut self, name: &str, row: &PointRow) -> Result<NodePlace, RobotError> {
        let at = |key| [Key("points"), Key(name), Key(key)];
        let path = [Key("points"), Key(name)];
        match row {
            PointRow {
                on,
                at: coordinates,
                centres: None,
                radii: None,
                plane: None,
                side: None,
            } => {
                let body = on.as_ref().map_or(Ok(0), |on| self.body(on, &at("on")))?;
                let at_m = self.three(coordinates.as_ref(), &at("at"))?;
                Ok(NodePlace::Fixed {
                    body,
                    at_m: self.frames[body].point(at_m),
                })
            }
            PointRow {
                on: None,
                at: None,
                centres: Some(centres),
                radii: Some(radii),
                plane: Some(plane),
                side: Some(side),
            } => {
                if ![1, -1].contains(side) {
                    let problem = RobotProblem::Impossible {
                        what: format!("the side of {name}"),
                        value: *side as f64,
                        must: "it must be 1 or -1",
                    };
                    return Err(self.error(&at("side"), problem));
                }
                let entry = |key, place: usize| [&at(key)[..], &[Index(place)]].concat();
                let centre = |place: usize| self.point(&centres[place], &entry("centres", place));
                let centres = [centre(0)?, centre(1)?];
                let radius = |place: usize| {
                    let path = entry("radii", place);
                    let value = self.value(&radii[place], &path)?;
                    self.positive_value(value, &path, "the radius")
                        .map(RadiusOf::Length)
                };
                let radii = [radius(0)?, radius(1)?];
                if centres[0] == centres[1] {
                    let message = "two circles that meet in a point have different centres";
                    return Err(self.error(&at("centres"), RobotProblem::Shape(message)));
                }
                Ok(NodePlace::Loop {
                    centres,
                    radii,
                    plane: self.plane(plane, &at("plane"))?,
                    branch: *side as f64,
                })
            }
            _ => {
                let message =
                    "a point has either `on` and `at`, or `centres`, `radii`, `plane` and `side`";
                Err(self.error(&path, RobotProblem::Shape(message)))
            }
        }
    }

    /// The tool and its centre.
    pub(super) fn place_tool(&mut self) -> Result<(Tool, usize), RobotError> {
        let at = |key| [Key("tool"), Key(key)];
        let file = self.file;
        let row = file.tool.clone().unwrap_or_default();
        let last = self.joints.last().map_or(0, |joint| joint.bodies[1]);
        let body = row
            .on
            .as_ref()
            .map_or(Ok(last), |on| self.body(on, &at("on")))?;
        let frame = self.frames[body];
        let centre_m = self.three(row.at.as_ref(), &at("at"))?;
        let end = self.point(TOOL, &at("at"))?;
        self.nodes[end] = NodePlace::Fixed {
            body,
            at_m: frame.point(centre_m),
        };
        self.bodies_of_node[end].push(body);
        let turn = roll_pitch_yaw(self.three(row.turn.as_ref(), &at("turn"))?);
        let springs = self.six_springs(&row.springs, &at("springs"))?;
        let mut carrying = self.joints.iter().filter(|one| one.bodies[1] == body);
        let link = carrying.find_map(|one| file.joints[one.name.as_str()].link.as_deref());
        let mount = (springs != <[SpringDefault; 6]>::default()).then(|| {
            // Behind the beam of its body, or the link that leads to the tool, if there is one.
            let mut links = file.links.values().flat_map(|row| &row.between);
            let is_behind = link.is_some_and(|text| text != "rigid") || links.any(|to| to == TOOL);
            let at_m = frame.point(if is_behind { centre_m } else { [0.0; 3] });
            let flange = NodePlace::Fixed { body, at_m };
            self.add_node(MOUNT.to_owned(), flange, vec![body])
        });
        let payload = match &row.payload {
            None => None,
            Some(payload) => {
                let within = |key| [Key("tool"), Key("payload"), Key(key)];
                Some(Payload {
                    mass_kg: self.positive(&payload.mass, &within("mass"), "the payload")?,
                    at_m: self.three(payload.at.as_ref(), &within("at"))?,
                })
            }
        };
        let tool = Tool {
            mount,
            body: Some(body),
            axes: Some(columns(&product(&frame.turn, &turn))),
            springs,
            payload,
        };
        Ok((tool, end))
    }

    /// The joints where bodies meet that others place.
    pub(super) fn close_loops(&mut self) -> Result<(), RobotError> {
        for (name, row) in &self.file.joints {
            let Some(point) = &row.point else { continue };
            let at = |key| [Key("joints"), Key(name.as_str()), Key(key)];
            let path: &[DocumentStep<'_>] = &[Key("joints"), Key(name)];
            let JointRow {
                on: Some(on),
                body: Some(body),
                plane: Some(plane),
                kind: JointKind::Revolute,
                at: None,
                turn: None,
                axis: None,
                alpha: None,
                a: None,
                theta: None,
                d: None,
                angle: None,
                min: None,
                max: None,
                nominal: None,
                link: None,
                ..
            } = row
            else {
                let message = "a joint with `point` turns, has `on`, `body` and `plane`, and no key of a joint that places a body";
                return Err(self.error(path, RobotProblem::Shape(message)));
            };
            let bodies = [self.body(on, &at("on"))?, self.body(body, &at("body"))?];
            let node = self.point(point, &at("point"))?;
            for body in bodies {
                if !self.bodies_of_node[node].contains(&body) {
                    self.bodies_of_node[node].push(body);
                }
            }
            let plane = self.plane(plane, &at("plane"))?;
            let springs = self.joint_springs(name, row)?;
            self.joints.push(Joint {
                name: name.clone(),
                node,
                bodies,
                chain: None,
                plane,
                motion: JointMotion::Turns,
                springs,
            });
        }
        Ok(())
    }

    /// Points that are held.
    pub(super) fn supports(&self) -> Result<Vec<usize>, RobotError> {
        let Some(fixed) = self.file.base.as_ref().and_then(|base| base.fixed.as_ref()) else {
            return Ok(vec![0]);
        };
        let path = [Key("base"), Key("fixed")];
        let mut held = Vec::new();
        for (place, name) in fixed.iter().enumerate() {
            let path = [&path[..], &[Index(place)]].concat();
            let node = self.point(name, &path)?;
            if held.contains(&node) {
                let (kind, name) = ("support", name.clone());
                return Err(self.error(&path, RobotProblem::Duplicate { kind, name }));
            }
            held.push(node);
        }
        if held.is_empty() {
            let message = "a robot is held in at least one point";
            return Err(self.error(&path, RobotProblem::Shape(message)));
        }
        Ok(held)
    }
}
