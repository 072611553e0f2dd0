//! Joints and points: the bodies they move and where everything is.

use stiffbench_units_and_text::toml_text::DocumentStep::{Index, Key};

use crate::robot::error::{RobotError, RobotProblem};
use crate::robot::model::{Angle, Body, BodyPlace, Joint, NodePlace};
use crate::robot::spring_axis::JointMotion;

use super::builder::{BASE, RobotBuilder, TOOL};
use super::file::{Bearing, DhConvention, JointKind, JointRow};
use super::frames::{FileFrame, IDENTITY, Rotation, about, apply, product, roll_pitch_yaw};

/// Where a joint sits on the body that carries it, and what the file's axes of the moving body are.
struct JointPlace {
    at_m: [f64; 3],
    /// Axes of the joint in those of the body that carries it.
    turn: Rotation,
    axis: [f64; 3],
    /// Angle, degrees, or travel, m, where the variables are zero.
    offset: f64,
    /// From the joint's axes to those of the file for the body that moves, behind the motion.
    exit_turn: Rotation,
    exit_m: [f64; 3],
}

/// Structures are solved with dense matrices: more joints take minutes and gigabytes.
const MOST_JOINTS: usize = 1000;

impl RobotBuilder<'_> {
    /// Names all points, and places the base and the bodies of the joints.
    pub(super) fn place_joints(&mut self) -> Result<(), RobotError> {
        let nowhere = || NodePlace::Fixed {
            body: 0,
            at_m: [0.0; 3],
        };
        self.add_node(BASE.to_owned(), nowhere(), vec![0]);
        let file = self.file;
        let placing = || file.joints.iter().filter(|(_, row)| row.point.is_none());
        let joints = placing().map(|(name, _)| name);
        for name in joints.chain(file.points.keys()) {
            self.add_node(name.clone(), nowhere(), Vec::new());
        }
        self.add_node(TOOL.to_owned(), nowhere(), Vec::new());
        self.bodies = self.body_names.iter().map(|_| None).collect();
        self.frames = vec![FileFrame::SAME; self.bodies.len()];
        self.bodies[0] = Some(Body {
            name: BASE.to_owned(),
            chain: None,
            place: BodyPlace::Ground,
        });
        let first_along = self.bodies.len() - file.bodies.len();
        let mut carriers = vec![0];
        let mut waiting = Vec::new();
        for (name, row) in placing() {
            let before = *carriers.last().unwrap_or(&0);
            let path = [Key("joints"), Key(name.as_str()), Key("on")];
            let on = row
                .on
                .as_ref()
                .map_or(Ok(before), |on| self.body(on, &path))?;
            let body = self.body_names[row.body.as_ref().unwrap_or(name).as_str()];
            carriers.push(body);
            waiting.push((name, row, on, body));
        }
        if waiting.is_empty() {
            let message = "a robot needs at least one joint in [joints]";
            return Err(self.error(&[Key("joints")], RobotProblem::Shape(message)));
        }
        if waiting.len() > MOST_JOINTS {
            let message =
                "a robot has more than 1000 joints in [joints]: leave out those that do not move";
            return Err(self.error(&[Key("joints")], RobotProblem::Shape(message)));
        }
        while !waiting.is_empty() {
            let known = |on: usize| self.bodies[on].is_some() || on >= first_along;
            let Some(next) = waiting.iter().position(|(_, _, on, _)| known(*on)) else {
                let (name, ..) = waiting[0];
                let chain = waiting.iter().map(|(name, ..)| name.as_str());
                let problem = RobotProblem::Circular {
                    kind: "joint",
                    name: name.clone(),
                    chain: chain.collect::<Vec<_>>().join(", "),
                };
                return Err(self.error(&[Key("joints"), Key(name), Key("on")], problem));
            };
            let (name, row, on, body) = waiting.remove(next);
            self.place_joint(name, row, on, body)?;
        }
        for name in file.bodies.keys() {
            self.place_along(name)?;
        }
        Ok(())
    }

    fn place_joint(
        &mut self,
        name: &str,
        row: &JointRow,
        on: usize,
        body: usize,
    ) -> Result<(), RobotError> {
        let place = self.joint_place(name, row)?;
        let motion = self.motion_of(name, row, place.offset)?;
        let frame = self.frames[on];
        let turn = product(&frame.turn, &place.turn);
        let axis = apply(&turn, place.axis);
        let at = NodePlace::Fixed {
            body: on,
            at_m: frame.point(place.at_m),
        };
        let node = self.point(name, &[Key("joints"), Key(name)])?;
        self.bodies_of_node[node] = vec![on, body];
        let slides = row.kind == JointKind::Sliding;
        if row.bearing.is_some() && !slides {
            let message = "`bearing` belongs to a sliding joint";
            let path = [Key("joints"), Key(name), Key("bearing")];
            return Err(self.error(&path, RobotProblem::Shape(message)));
        }
        let place_of_body = if slides {
            let mut origin = node;
            self.nodes[node] = at.clone();
            if row.bearing == Some(Bearing::Moving) {
                let start = format!("{name}.start");
                if self.nodes.contains_key(&start) {
                    let problem = RobotProblem::Duplicate {
                        kind: "point",
                        name: start.clone(),
                    };
                    return Err(self.error(&[Key("points"), Key(&start)], problem));
                }
                origin = self.add_node(start, at, Vec::new());
                self.nodes[node] = NodePlace::Fixed {
                    body,
                    at_m: [0.0; 3],
                };
            }
            BodyPlace::Slid {
                parent: on,
                origin,
                axis,
                distance: motion,
            }
        } else {
            self.nodes[node] = at;
            BodyPlace::Turned {
                parent: on,
                origin: node,
                axis,
                angle: motion,
            }
        };
        self.frames[body] = FileFrame {
            turn: product(&turn, &place.exit_turn),
            origin_m: apply(&turn, place.exit_m),
        };
        self.bodies[body] = Some(Body {
            name: row.body.as_deref().unwrap_or(name).to_owned(),
            chain: None,
            place: place_of_body,
        });
        let plane = self.plane_of(format!("axis of {name}"), on, axis);
        self.joints.push(Joint {
            name: name.to_owned(),
            node,
            bodies: [on, body],
            chain: None,
            plane,
            motion: if slides {
                JointMotion::Slides
            } else {
                JointMotion::Turns
            },
            springs: self.joint_springs(name, row)?,
        });
        Ok(())
    }

    /// The angle or travel of a joint.
    fn motion_of(&self, name: &str, row: &JointRow, offset: f64) -> Result<Angle, RobotError> {
        let mut motion = Angle {
            offset_deg: offset,
            terms: Vec::new(),
        };
        let Some(terms) = &row.angle else {
            motion
                .terms
                .push((self.variable(name, &[Key("joints"), Key(name)])?, 1.0));
            return Ok(motion);
        };
        for (variable, coefficient) in terms {
            let path = [Key("joints"), Key(name), Key("angle"), Key(variable)];
            if variable == "offset" {
                motion.offset_deg +=
                    self.travel(coefficient, row.kind == JointKind::Sliding, &path)?;
                continue;
            }
            if coefficient.kind.is_some() {
                let message = "a coefficient is a number without unit";
                return Err(self.error(&path, RobotProblem::Shape(message)));
            }
            let coefficient = self.value(coefficient, &path)?;
            motion
                .terms
                .push((self.variable(variable, &path)?, coefficient));
        }
        Ok(motion)
    }

    fn joint_place(&self, name: &str, row: &JointRow) -> Result<JointPlace, RobotError> {
        let at = |key| [Key("joints"), Key(name), Key(key)];
        let shape =
            |message| Err(self.error(&[Key("joints"), Key(name)], RobotProblem::Shape(message)));
        if row.plane.is_some() {
            return shape("`plane` belongs to a joint with `point`");
        }
        let is_dh =
            row.alpha.is_some() || row.a.is_some() || row.theta.is_some() || row.d.is_some();
        if !is_dh {
            let turn = self.three(row.turn.as_ref(), &at("turn"))?;
            let axis = row.axis.as_ref();
            let axis = axis.map_or(Ok([0.0, 0.0, 1.0]), |axis| self.axis(axis, &at("axis")))?;
            return Ok(JointPlace {
                at_m: self.three(row.at.as_ref(), &at("at"))?,
                turn: roll_pitch_yaw(turn),
                axis,
                offset: 0.0,
                exit_turn: IDENTITY,
                exit_m: [0.0; 3],
            });
        }
        if row.at.is_some() || row.turn.is_some() || row.axis.is_some() {
            return shape(
                "a joint is placed by `alpha`, `a`, `theta`, `d` or by `at`, `turn`, `axis`, not by both",
            );
        }
        let Some(convention) = self.file.dh else {
            return shape(
                "a joint with `alpha`, `a`, `theta` or `d` needs `dh = \"standard\"` or `dh = \"modified\"` at the top of the file",
            );
        };
        let angle = |measured: &Option<_>, key| {
            measured
                .as_ref()
                .map_or(Ok(0.0), |m| self.value(m, &at(key)))
        };
        let length = |measured: &Option<_>, key| {
            measured
                .as_ref()
                .map_or(Ok(0.0), |m| self.value(m, &at(key)))
        };
        let (alpha, theta) = (angle(&row.alpha, "alpha")?, angle(&row.theta, "theta")?);
        let (a, d) = (length(&row.a, "a")?, length(&row.d, "d")?);
        let slides = row.kind == JointKind::Sliding;
        // The part of the row about and along z that does not move: of a sliding joint the angle, of another the offset.
        let (turn_z, along_z) = if slides {
            (about(2, theta), 0.0)
        } else {
            (IDENTITY, d)
        };
        let offset = if slides { d } else { theta };
        let twist = about(0, alpha);
        let axis = [0.0, 0.0, 1.0];
        Ok(match convention {
            DhConvention::Modified => {
                let up = apply(&twist, [0.0, 0.0, along_z]);
                JointPlace {
                    at_m: [a + up[0], up[1], up[2]],
                    turn: product(&twist, &turn_z),
                    axis,
                    offset,
                    exit_turn: IDENTITY,
                    exit_m: [0.0; 3],
                }
            }
            DhConvention::Standard => JointPlace {
                at_m: [0.0; 3],
                turn: turn_z,
                axis,
                offset,
                exit_turn: twist,
                exit_m: [a, 0.0, along_z],
            },
        })
    }

    fn place_along(&mut self, name: &str) -> Result<(), RobotError> {
        let row = &self.file.bodies[name];
        let at = |key| [Key("bodies"), Key(name), Key(key)];
        let node = |place: usize| {
            let path = [&at("along")[..], &[Index(place)]].concat();
            self.point(&row.along[place], &path)
        };
        let nodes = [node(0)?, node(1)?];
        if nodes[0] == nodes[1] {
            let message = "a body lies along two different points";
            return Err(self.error(&at("along"), RobotProblem::Shape(message)));
        }
        let plane = self.plane(&row.plane, &at("plane"))?;
        let body = self.body_names[name];
        self.bodies[body] = Some(Body {
            name: name.to_owned(),
            chain: None,
            place: BodyPlace::Along {
                nodes,
                plane,
                turn_deg: 0.0,
            },
        });
        for node in nodes {
            self.bodies_of_node[node].push(body);
        }
        Ok(())
    }
}
