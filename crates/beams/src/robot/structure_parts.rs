//! Nodes, hinges, rigid members and supports of the structure of a mechanism.

use stiffbench_numeric::vector::{norm, subtract};

use super::carried_masses::joint_below;
use crate::structure::{Attachment, Node, RigidMember, Structure, Support};

use super::Robot;
use super::error::RobotError;
use super::fitting_factors::FittingFactors;
use super::hinges::{HingePlace, ModelHinge};
use super::loads::BodyPoint;
use super::model::{BodyPlace, Mechanism, NodePlace};

/// Nodes, hinges and rigid members of a structure.
pub(super) struct StructureParts<'a> {
    robot: &'a Robot,
    mechanism: &'a Mechanism,
    hinges: &'a [ModelHinge],
    /// Robot node of each structure node; the ground under a base that yields stands last, at the first support.
    pub(super) nodes: Vec<usize>,
    /// Robot nodes that are held and there.
    supports: Vec<usize>,
    /// Robot node on which the tool is mounted.
    mount: usize,
}

impl<'a> StructureParts<'a> {
    pub(super) fn new(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        hinges: &'a [ModelHinge],
    ) -> Result<Self, RobotError> {
        let mut nodes: Vec<usize> = Vec::new();
        for node in mechanism
            .bodies_and_nodes(robot)
            .flat_map(|(_, nodes)| nodes)
        {
            if !nodes.contains(&node) {
                nodes.push(node);
            }
        }
        let incomplete = |what: &str| RobotError::IncompleteMechanism {
            mechanism: mechanism.name.clone(),
            what: what.to_owned(),
        };
        let mount = robot.tool.mount.unwrap_or(robot.end);
        if !nodes.contains(&mount) {
            return Err(incomplete(&format!(
                "its end node {}",
                robot.nodes[mount].name
            )));
        }
        if !nodes.contains(&robot.end) {
            nodes.push(robot.end);
        }
        let there = robot.supports.iter().copied();
        let supports: Vec<usize> = there.filter(|node| nodes.contains(node)).collect();
        let Some(&first) = supports.first() else {
            return Err(incomplete("any support"));
        };
        if hinges.iter().any(|hinge| hinge.place == HingePlace::Base) {
            nodes.push(first);
        }
        Ok(Self {
            robot,
            mechanism,
            hinges,
            nodes,
            supports,
            mount,
        })
    }

    fn place_of(&self, node: usize) -> usize {
        let place = self.nodes.iter().position(|known| *known == node);
        place.expect("every node of a member was collected")
    }

    /// Numbers of the hinges at a place.
    fn numbers(&self, is_there: impl Fn(HingePlace) -> bool) -> Vec<usize> {
        let places = self.hinges.iter().enumerate();
        let there = places.filter(|(_, hinge)| is_there(hinge.place));
        there.map(|(number, _)| number).collect()
    }

    /// Where the end of a member of a body hangs at a node.
    ///
    /// A compliant joint splits its node: the member ends of its second body go to the new node, all others stay. Where several joints
    /// share a node, each second body turns against the node itself, not against the body before it.
    pub(super) fn attachment(&self, node: usize, body: Option<usize>) -> Attachment {
        let stands_between = |joint: usize| {
            let joint = &self.robot.joints[joint];
            joint.node == node && Some(joint.bodies[1]) == body
        };
        let hinges = self.numbers(|place| match place {
            HingePlace::Joint(joint) | HingePlace::JointAcross(joint) => stands_between(joint),
            HingePlace::Base | HingePlace::Tool => false,
        });
        Attachment {
            node: self.place_of(node),
            hinges,
        }
    }

    /// Where what is fixed at a point of a body hangs: on the nearest node of its members, else, where its joint is, on the next body below;
    /// `None` on the ground. A node that moves along the body is taken only if there is no other.
    pub(super) fn hangs(&self, point: &BodyPoint) -> Option<Attachment> {
        let BodyPoint { body, at_m } = *point;
        let joint = joint_below(self.robot, body);
        let turns = !matches!(self.robot.bodies[body].place, BodyPlace::Slid { .. });
        let distance_m = |node: &usize| match &self.robot.nodes[*node].place {
            NodePlace::Fixed { body: on, at_m: m } if *on == body => norm(subtract(*m, at_m)),
            _ if turns && joint.is_some_and(|(own, _)| own == *node) => norm(at_m),
            _ => f64::INFINITY,
        };
        let members = self.mechanism.bodies_and_nodes(self.robot);
        let own = members.filter(|(known, _)| *known == body);
        let nearest = own
            .flat_map(|(_, nodes)| nodes)
            .min_by(|a, b| distance_m(a).total_cmp(&distance_m(b)));
        match nearest {
            Some(node) => Some(self.attachment(node, Some(body))),
            None => self.hangs(&joint?.1),
        }
    }

    /// The body on which the tool is mounted: the one behind the most hinges at its node.
    fn last_body(&self) -> Option<usize> {
        let joints = self.robot.joints.iter();
        let at_mount = joints.filter(|joint| joint.node == self.mount);
        at_mount
            .map(|joint| joint.bodies[1])
            .max_by_key(|&body| self.attachment(self.mount, Some(body)).hinges.len())
    }

    /// The structure but for its elements.
    pub(super) fn structure(&self, factors: &FittingFactors) -> Structure {
        let robot = self.robot;
        let links = self.mechanism.rigid_links.iter();
        let links = links.map(|&link| &robot.rigid_links[link]);
        let mut rigid_members: Vec<RigidMember> = links
            .map(|link| RigidMember {
                name: link.name.as_str().into(),
                ends: link
                    .nodes
                    .map(|node| self.attachment(node, Some(link.body))),
            })
            .collect();
        let base = self.numbers(|place| place == HingePlace::Base);
        let supports = if base.is_empty() {
            let held = self.supports.iter().map(|&node| self.place_of(node));
            held.map(Support::clamped).collect()
        } else {
            let ground = Attachment {
                node: self.nodes.len() - 1,
                hinges: base,
            };
            let held = self.supports.iter().map(|&node| self.place_of(node));
            rigid_members.extend(held.map(|node| RigidMember {
                name: "base".into(),
                ends: [ground.clone(), node.into()],
            }));
            vec![Support::clamped(ground.node)]
        };
        let mut end = self.attachment(self.mount, self.last_body());
        end.hinges
            .extend(self.numbers(|place| place == HingePlace::Tool));
        if robot.end != self.mount {
            let centre: Attachment = self.place_of(robot.end).into();
            rigid_members.push(RigidMember {
                name: "tool".into(),
                ends: [end, centre.clone()],
            });
            end = centre;
        }
        Structure {
            nodes: self
                .nodes
                .iter()
                .map(|&node| Node {
                    name: robot.nodes[node].name.clone(),
                    position_m: [0.0; 3],
                })
                .collect(),
            elements: Vec::new(),
            struts: Vec::new(),
            rigid_members,
            hinges: self
                .hinges
                .iter()
                .map(|hinge| hinge.hinge(robot, factors))
                .collect(),
            supports,
            end,
        }
    }
}
