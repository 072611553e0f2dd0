//! What connects the points of each body: beams where the file names a section, rigid links elsewhere.

use std::sync::Arc;

use stiffbench_numeric::vector::{cross, norm, scale, subtract};
use stiffbench_units_and_text::toml_text::DocumentStep::{self, Index, Key};

use crate::robot::error::{RobotError, RobotProblem};
use crate::robot::model::{BodyPlace, Joint, Member, NodePlace, RigidLink};
use crate::robot::model_parameter::ElementClass;
use crate::robot::spring_axis::JointMotion;

use super::builder::{MOUNT, RobotBuilder, TOOL};
use super::file::LinkRow;

/// Points of a body nearer to one another than this, m, are one place: a beam between them has no direction.
const SAME_PLACE_M: f64 = 1e-9;

/// Sine of the angle to a beam below which a direction does not say how its section is turned.
const PARALLEL: f64 = 0.02;

/// Connections of the points of one body.
struct ConnectedPoints {
    points: Vec<usize>,
    /// For each point one that it is connected to; the first of a group is connected to itself.
    roots: Vec<usize>,
}

impl ConnectedPoints {
    fn new(points: Vec<usize>) -> Self {
        Self {
            roots: (0..points.len()).collect(),
            points,
        }
    }

    fn root(&self, node: usize) -> Option<usize> {
        let mut place = self.points.iter().position(|point| *point == node)?;
        while self.roots[place] != place {
            place = self.roots[place];
        }
        Some(place)
    }

    fn join(&mut self, [first, second]: [usize; 2]) {
        if let (Some(first), Some(second)) = (self.root(first), self.root(second)) {
            let (low, high) = (first.min(second), first.max(second));
            self.roots[high] = low;
        }
    }

    /// Points that nothing connects to the first, one of each group.
    fn apart(&self) -> impl Iterator<Item = usize> + '_ {
        let groups = self.roots.iter().enumerate().skip(1);
        groups
            .filter(|(place, root)| place == *root)
            .map(|(place, _)| self.points[place])
    }
}

impl RobotBuilder<'_> {
    /// Makes the beams, and rigid links between the points of each body that no beam connects.
    pub(super) fn connect(&mut self, supports: &[usize]) -> Result<(), RobotError> {
        let mut beams: Vec<(usize, [usize; 2])> = Vec::new();
        let file = self.file;
        for (name, row) in &file.links {
            beams.push(self.link(name, row)?);
        }
        let used = self.used_nodes(supports, &beams);
        for body in 0..self.bodies.len() {
            let points = self.points_of(body, &used, supports);
            let mut connected = ConnectedPoints::new(points.clone());
            for (_, nodes) in beams.iter().filter(|(of, _)| *of == body) {
                connected.join(*nodes);
            }
            // The ground connects what is held.
            for held in supports {
                connected.join([supports[0], *held]);
            }
            for (place, &node) in points.iter().enumerate() {
                let is_apart = |other: &usize| connected.root(*other) != connected.root(node);
                let there = |other: &&usize| self.is_one_place([**other, node], body);
                let other = points[..place].iter().find(there);
                if let Some(&other) = other.filter(|other| is_apart(other)) {
                    let nodes = [other, node];
                    self.link_rigidly(self.name_of_link(nodes), nodes, body);
                    connected.join(nodes);
                }
            }
            self.link_of_joint(body, &points, &mut connected)?;
            let has_beams = self.members.iter().any(|member| member.body == body);
            let apart: Vec<usize> = connected.apart().collect();
            for node in apart {
                let nodes = [points[0], node];
                let name = self.name_of_link(nodes);
                if has_beams {
                    self.warnings.push(format!(
                        "rigid link `{name}`: no beam of the body `{}` leads there: describe it in [links], with a section if it yields",
                        self.body_names.get_index(body).map_or("", |(name, _)| name)
                    ));
                }
                self.link_rigidly(name, nodes, body);
            }
        }
        Ok(())
    }

    fn link_rigidly(&mut self, name: String, nodes: [usize; 2], body: usize) {
        self.rigid_links.push(RigidLink {
            is_added: !(self.file.links.contains_key(&name) || self.is_one_place(nodes, body)),
            name,
            nodes,
            chain: Self::chain(),
            body,
        });
    }

    fn name_of_link(&self, nodes: [usize; 2]) -> String {
        let name = |node: usize| self.nodes.get_index(node).map_or("", |(name, _)| name);
        nodes.map(name).join("-")
    }

    /// A link of the file: its body and its points. It becomes a beam if it has a section, else what is rigid.
    fn link(&mut self, name: &str, row: &LinkRow) -> Result<(usize, [usize; 2]), RobotError> {
        let path = [Key("links"), Key(name)];
        let at = |key| [Key("links"), Key(name), Key(key)];
        let node = |place: usize| {
            let path = [&at("between")[..], &[Index(place)]].concat();
            // The springs of a tool stand between the end of its link and its centre.
            let mount = self.nodes.get_index_of(MOUNT);
            match mount.filter(|_| row.between[place] == TOOL) {
                Some(mount) => Ok(mount),
                None => self.point(&row.between[place], &path),
            }
        };
        let nodes = [node(0)?, node(1)?];
        if nodes[0] == nodes[1] {
            let message = "a link runs between two different points";
            return Err(self.error(&at("between"), RobotProblem::Shape(message)));
        }
        let body = match &row.on {
            Some(on) => self.body(on, &at("on"))?,
            None => self.common_body(nodes, &path)?,
        };
        for node in nodes {
            if !self.bodies_of_node[node].contains(&body) {
                self.bodies_of_node[node].push(body);
            }
        }
        let Some(section) = &row.section else {
            self.link_rigidly(name.to_owned(), nodes, body);
            return Ok((body, nodes));
        };
        let section = self.section(section, &at("section"))?;
        let plane = match (&row.width, &row.plane) {
            (Some(_), Some(_)) => {
                let message = "the width of a link is given by `width` or by `plane`, not by both";
                return Err(self.error(&path, RobotProblem::Shape(message)));
            }
            (Some(width), None) => {
                let width = self.axis(width, &at("width"))?;
                let width = self.frames[body].direction(width);
                self.check_width(nodes, body, width, &at("width"))?;
                self.plane_of(format!("width of {name}"), body, width)
            }
            (None, Some(plane)) => self.plane(plane, &at("plane"))?,
            (None, None) => self.plane_across(nodes, body, section, name, &path),
        };
        self.add_beam(name.to_owned(), nodes, [body, section, plane], &row.groups);
        Ok((body, nodes))
    }

    /// A beam of a body with a section, both by their places, its width along the normal of a plane.
    fn add_beam(
        &mut self,
        name: String,
        nodes: [usize; 2],
        [body, section, plane]: [usize; 3],
        groups: &[String],
    ) {
        let groups = groups.iter().map(|name| Arc::from(name.as_str()));
        self.members.push(Member {
            name,
            nodes,
            chain: Self::chain(),
            class: ElementClass::Beam,
            section,
            body,
            plane,
            groups: groups.collect(),
        });
    }

    /// The one body that two points lie on.
    fn common_body(
        &self,
        nodes: [usize; 2],
        path: &[DocumentStep<'_>],
    ) -> Result<usize, RobotError> {
        let [first, second] = nodes.map(|node| &self.bodies_of_node[node]);
        let common: Vec<usize> = first
            .iter()
            .copied()
            .filter(|body| second.contains(body))
            .collect();
        if let [body] = common[..] {
            return Ok(body);
        }
        let bodies = self.body_names.keys().map(String::as_str);
        let bodies = bodies.collect::<Vec<_>>().join(", ");
        let message = if common.is_empty() {
            "the two points of this link lie on no common body"
        } else {
            "the two points of this link lie on more than one common body"
        };
        let help = format!("name its body with `on`; there are {bodies}");
        Err(self.error_with(path, RobotProblem::Shape(message), help))
    }

    /// Refuses a width along the beam itself.
    fn check_width(
        &self,
        nodes: [usize; 2],
        body: usize,
        width: [f64; 3],
        path: &[DocumentStep<'_>],
    ) -> Result<(), RobotError> {
        match self.direction(nodes, body) {
            Some(along) if norm(cross(along, width)) < PARALLEL => {
                let message = "the width of a section cannot lie along its beam";
                Err(self.error(path, RobotProblem::Shape(message)))
            }
            _ => Ok(()),
        }
    }

    /// Nodes that a structure needs.
    fn used_nodes(&self, supports: &[usize], beams: &[(usize, [usize; 2])]) -> Vec<bool> {
        let mut used = vec![false; self.nodes.len()];
        let joints = self.joints.iter().map(|joint| joint.node);
        let beams = beams.iter().flat_map(|(_, nodes)| *nodes);
        // Springs stand between the mount of the tool and its centre: nothing else may lead to the centre.
        let index = |name| self.nodes.get_index_of(name);
        let tool = index(MOUNT).or_else(|| index(TOOL));
        let held = supports.iter().copied();
        for node in joints.chain(beams).chain(tool).chain(held) {
            used[node] = true;
        }
        used
    }

    /// Points of a body that a structure needs, first the joint that it moves on, or the points in which it is held.
    fn points_of(&self, body: usize, used: &[bool], supports: &[usize]) -> Vec<usize> {
        let mut points: Vec<usize> = (0..self.nodes.len())
            .filter(|&node| used[node] && self.bodies_of_node[node].contains(&body))
            .collect();
        let entry = self.entry(body).map(|joint| self.joints[joint].node);
        points.sort_by_key(|node| entry.map_or(!supports.contains(node), |entry| *node != entry));
        points
    }

    /// The joint that places a body.
    fn entry(&self, body: usize) -> Option<usize> {
        let placing = self
            .joints
            .iter()
            .position(|joint| joint.bodies[1] == body)?;
        let placed = self.bodies[body].as_ref()?;
        let by_joint = matches!(
            placed.place,
            BodyPlace::Turned { .. } | BodyPlace::Slid { .. }
        );
        by_joint.then_some(placing)
    }

    /// Beams for the `link` of the joint that places a body: from the joint to each further point of the body.
    fn link_of_joint(
        &mut self,
        body: usize,
        points: &[usize],
        connected: &mut ConnectedPoints,
    ) -> Result<(), RobotError> {
        let Some(entry) = self.entry(body) else {
            return Ok(());
        };
        let name = self.joints[entry].name.clone();
        let row = &self.file.joints[name.as_str()];
        let Some(text) = row.link.as_deref().filter(|text| *text != "rigid") else {
            return Ok(());
        };
        let path = [Key("joints"), Key(&name), Key("link")];
        let section = self.section(text, &path)?;
        for &node in points.iter().skip(1) {
            let nodes = [points[0], node];
            // What another beam connects already, and what lies in the same place, needs none.
            let is_apart = connected.root(node) != Some(0);
            let somewhere_else = self.direction(nodes, body).is_some();
            if !is_apart || !somewhere_else {
                continue;
            }
            let link = self.name_of_link(nodes);
            let plane = self.plane_across(nodes, body, section, &link, &path);
            self.add_beam(link, nodes, [body, section, plane], &row.groups);
            connected.join(nodes);
        }
        Ok(())
    }

    /// Where a node lies in the axes of a body, m, as far as that does not depend on the pose; of a bearing that moves on the body only
    /// roughly, a metre along its way: enough for the direction of a beam.
    fn in_body(&self, node: usize, body: usize) -> Option<[f64; 3]> {
        let fixed = |node: usize| match self.nodes.get_index(node)?.1 {
            NodePlace::Fixed { body: on, at_m } if *on == body => Some(*at_m),
            _ => None,
        };
        let of_joint = self.joints.iter().find(|joint| {
            joint.node == node
                && joint.bodies.contains(&body)
                && self.entry(joint.bodies[1]).is_some()
        });
        let Some(joint) = of_joint else {
            return fixed(node);
        };
        let axis = self.planes[joint.plane].normal;
        match (joint.motion, joint.bodies[1] == body) {
            (JointMotion::Turns, true) => Some([0.0; 3]),
            (JointMotion::Turns, false) => fixed(node),
            (JointMotion::Slides, true) => fixed(node).or(Some(scale(axis, -1.0))),
            (JointMotion::Slides, false) => fixed(node).or_else(|| {
                let start = self.nodes.get_index_of(&format!("{}.start", joint.name))?;
                let at = fixed(start)?;
                Some(std::array::from_fn(|i| at[i] + axis[i]))
            }),
        }
    }

    /// Whether two nodes lie in one place of a body in every pose.
    fn is_one_place(&self, nodes: [usize; 2], body: usize) -> bool {
        let slides = |joint: &Joint| {
            let is_here = nodes.contains(&joint.node) && joint.bodies.contains(&body);
            is_here && joint.motion == JointMotion::Slides
        };
        let [first, second] = nodes.map(|node| self.in_body(node, body));
        let apart_m = first.zip(second).map(|(a, b)| norm(subtract(b, a)));
        apart_m.is_some_and(|apart_m| apart_m <= SAME_PLACE_M) && !self.joints.iter().any(slides)
    }

    /// Unit vector from one node to another in the axes of a body; `None` where they lie in one place or depend on the pose.
    fn direction(&self, [first, second]: [usize; 2], body: usize) -> Option<[f64; 3]> {
        let span = subtract(self.in_body(second, body)?, self.in_body(first, body)?);
        let length = norm(span);
        (length > SAME_PLACE_M).then(|| scale(span, 1.0 / length))
    }

    /// The plane whose normal is the width of a beam for which the file gives none: across it, along the axis of its body's joint if that is.
    fn plane_across(
        &mut self,
        nodes: [usize; 2],
        body: usize,
        section: usize,
        name: &str,
        path: &[DocumentStep<'_>],
    ) -> usize {
        if let Some(BodyPlace::Along { plane, .. }) =
            self.bodies[body].as_ref().map(|body| &body.place)
        {
            return *plane;
        }
        let along = self.direction(nodes, body);
        let is_across =
            |axis: [f64; 3]| along.is_none_or(|along| norm(cross(along, axis)) > PARALLEL);
        let entry = self
            .entry(body)
            .map(|joint| self.planes[self.joints[joint].plane].normal);
        let carried = self.joints.iter().filter(|joint| {
            joint.bodies[0] == body
                && nodes.contains(&joint.node)
                && self.planes[joint.plane].body == body
        });
        let carried = carried.map(|joint| self.planes[joint.plane].normal);
        let of_joints: Vec<[f64; 3]> = entry.into_iter().chain(carried).collect();
        if let Some(normal) = of_joints.iter().copied().find(|axis| is_across(*axis)) {
            return self.plane_of(format!("width of {name}"), body, normal);
        }
        let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let normal = axes.into_iter().find(|axis| is_across(*axis));
        let normal = normal.unwrap_or(axes[0]);
        let constants = self.sections[section].section;
        if constants.iy_m4 != constants.iz_m4 {
            let line = self.line(path);
            let word = ["x", "y", "z"][axes.iter().position(|axis| *axis == normal).unwrap_or(0)];
            self.warnings.push(format!(
                "line {line}: link `{name}` has no plane: no joint axis lies across it, so the width of its section was laid along {word} \
                 of the base where all joints are at zero: describe it in [links] with `width`"
            ));
        }
        self.plane_of(format!("width of {name}"), body, normal)
    }
}
