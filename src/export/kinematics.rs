//! The bodies and joints of a robot as a tree, as URDF needs it and SDF begins.

use std::collections::VecDeque;

use crate::robot::{BodyPlace, JointMotion, Mechanism, PlacedRobot, Pose, Robot, RobotError};
use crate::vector::{cross, dot, subtract};

use super::inertia::{Inertia, Rod};
use super::xml::numbers;

/// Step of the variables by which it is found how joints follow them, degrees or m.
const STEP: f64 = 1e-3;

/// Difference from a whole turn a variable below which a joint follows it one to one.
const ONE_TO_ONE: f64 = 1e-6;

/// A compliance up to which a joint is as good as rigid, rad/(N·m) or m/N.
pub(super) const STIFFEST: f64 = 1e-18;

/// Bodies and joints of a robot where it stands in a pose; joints are at zero there.
#[derive(Debug, Clone, PartialEq)]
pub struct KinematicTree {
    /// The bodies that the mechanism has, each after its parent; the first is the ground.
    pub links: Vec<KinematicLink>,
    /// Joints that close loops.
    pub cut: Vec<KinematicJoint>,
    /// Link that the end of the robot is on.
    pub end: usize,
    /// Position of the end, m.
    pub end_m: [f64; 3],
}

/// A body.
#[derive(Debug, Clone, PartialEq)]
pub struct KinematicLink {
    /// Its name.
    pub name: String,
    /// The joint that it hangs on; `None` of the ground.
    pub joint: Option<KinematicJoint>,
    /// Its origin, which is a point of the joint, m; its axes are those of the world.
    pub position_m: [f64; 3],
    /// What it weighs.
    pub inertia: Inertia,
    /// Its beams and rigid links.
    pub rods: Vec<Rod>,
}

/// A joint between two bodies.
#[derive(Debug, Clone, PartialEq)]
pub struct KinematicJoint {
    /// Its name.
    pub name: String,
    /// The body that it moves on, and the body that it moves, by their place among the links.
    pub links: [usize; 2],
    /// A point of its axis, m.
    pub position_m: [f64; 3],
    /// Unit vector of the axis.
    pub axis: [f64; 3],
    /// Whether it turns or slides; `None` if it does not move.
    pub motion: Option<JointMotion>,
    /// Stiffness of its spring, at rest where it stands, N·m/rad or N/m; `None` of one that does not yield.
    pub stiffness: Option<f64>,
    /// Moment or force that its friction holds, N·m or N.
    pub friction: f64,
    /// How far it can move from where it stands, rad or m; `None` where several variables move it.
    pub limits: Option<[f64; 2]>,
    /// The variables that move it together or in a ratio; empty where one moves it one to one.
    pub moved_by: Vec<String>,
}

/// What is known of a joint besides its place.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct SpringOfJoint {
    /// Its name.
    pub(super) joint: String,
    /// Compliance of its own motion, rad/(N·m) or m/N.
    pub(super) compliance: f64,
    /// Moment or force that its friction holds, N·m or N.
    pub(super) friction: f64,
}

impl KinematicTree {
    /// The bodies of a mechanism in a pose.
    ///
    /// # Arguments
    /// - `springs`: of joints that yield or have friction; of several of one name the first.
    /// - `masses`: that are not those of members: body, kg, centre, m.
    ///
    /// # Errors
    /// [`RobotError`] if the pose cannot be reached.
    pub(super) fn new(
        robot: &Robot,
        mechanism: &Mechanism,
        pose: &Pose,
        springs: &[SpringOfJoint],
        masses: &[(usize, f64, [f64; 3])],
    ) -> Result<Self, RobotError> {
        let placed = PlacedRobot::new(robot, mechanism, pose)?;
        let members = mechanism.members.iter();
        let mut bodies: Vec<usize> = members.map(|&member| robot.members[member].body).collect();
        let links = mechanism.rigid_links.iter();
        bodies.extend(links.map(|&link| robot.rigid_links[link].body));
        bodies.extend(placed.joints().iter().flat_map(|&j| robot.joints[j].bodies));
        bodies.sort_unstable();
        bodies.dedup();
        let mut builder = TreeBuilder {
            robot,
            pose,
            mechanism,
            springs,
            placed,
            link_of: vec![None; robot.bodies.len()],
            found: Self {
                links: Vec::new(),
                cut: Vec::new(),
                end: 0,
                end_m: [0.0; 3],
            },
        };
        builder.build(&bodies);
        builder.weigh(masses);
        Ok(builder.found)
    }

    /// What no file holds of joints that move together.
    pub(super) fn coupled(&self) -> Option<String> {
        let joints = self.links.iter().filter_map(|link| link.joint.as_ref());
        let coupled = joints.filter(|joint| !joint.moved_by.is_empty());
        let words = coupled.map(|joint| format!("{} ({})", joint.name, joint.moved_by.join(", ")));
        let words = words.collect::<Vec<_>>().join(", ");
        (!words.is_empty()).then(|| format!("joints that several variables move, or one in a ratio: {words}; each is a joint of its own here, without limits"))
    }

    /// What a file without loops leaves out, one each.
    pub(super) fn loops(&self) -> impl Iterator<Item = String> {
        self.cut.iter().map(|joint| {
            let [first, second] = joint.links.map(|link| self.links[link].name.as_str());
            format!(
                "URDF holds no loops: joint {} between {first} and {second} is left out; it is at {} about {}",
                joint.name,
                numbers(joint.position_m),
                numbers(joint.axis)
            )
        })
    }

    /// Name of a link, another one than those that the file itself needs.
    pub(super) fn link_name(&self, link: usize, taken: &[&str]) -> String {
        let name = &self.links[link].name;
        let is_taken = taken.contains(&name.as_str());
        if is_taken {
            format!("{name}.body")
        } else {
            name.clone()
        }
    }
}

struct TreeBuilder<'a> {
    robot: &'a Robot,
    pose: &'a Pose,
    mechanism: &'a Mechanism,
    springs: &'a [SpringOfJoint],
    placed: PlacedRobot<'a>,
    /// The link of each body.
    link_of: Vec<Option<usize>>,
    found: KinematicTree,
}

impl TreeBuilder<'_> {
    fn build(&mut self, bodies: &[usize]) {
        let is_ground =
            |body: &&usize| matches!(self.robot.bodies[**body].place, BodyPlace::Ground);
        let ground = bodies.iter().find(is_ground).copied();
        // Without one the body of the first support stands for it.
        let Some(ground) = ground.or_else(|| bodies.first().copied()) else {
            return;
        };
        self.add(ground, None, [0.0; 3]);
        let mut used = vec![false; self.robot.joints.len()];
        let mut next = VecDeque::from([ground]);
        loop {
            while let Some(body) = next.pop_front() {
                for number in self.placed.joints().to_vec() {
                    let ends = self.robot.joints[number].bodies;
                    if !ends.contains(&body) || std::mem::replace(&mut used[number], true) {
                        continue;
                    }
                    let other = ends[usize::from(ends[0] == body)];
                    if self.link_of[other].is_some() {
                        let joint = self.joint(number, body, self.link(other));
                        self.found.cut.push(joint);
                    } else {
                        let joint = self.joint(number, body, self.found.links.len());
                        let position_m = joint.position_m;
                        self.add(other, Some(joint), position_m);
                        next.push_back(other);
                    }
                }
            }
            // A body without a joint is fixed on the one that it is placed on.
            let left = bodies.iter().find(|body| self.link_of[**body].is_none());
            let Some(&body) = left else {
                break;
            };
            let parent = self.carrier(body).unwrap_or(ground);
            let position_m = self.found.links[self.link(parent)].position_m;
            let joint = KinematicJoint {
                name: format!("{}.fixed", self.robot.bodies[body].name),
                links: [self.link(parent), self.found.links.len()],
                position_m,
                axis: [1.0, 0.0, 0.0],
                motion: None,
                stiffness: None,
                friction: 0.0,
                limits: None,
                moved_by: Vec::new(),
            };
            self.add(body, Some(joint), position_m);
            next.push_back(body);
        }
    }

    fn add(&mut self, body: usize, joint: Option<KinematicJoint>, position_m: [f64; 3]) {
        self.link_of[body] = Some(self.found.links.len());
        self.found.links.push(KinematicLink {
            name: self.robot.bodies[body].name.clone(),
            joint,
            position_m,
            inertia: Inertia::default(),
            rods: Vec::new(),
        });
    }

    fn link(&self, body: usize) -> usize {
        self.link_of[body].unwrap_or(0)
    }

    /// The nearest body below that is a link already.
    fn carrier(&self, body: usize) -> Option<usize> {
        let mut at = body;
        // No chain is longer than there are bodies.
        for _ in 0..self.robot.bodies.len() {
            at = match &self.robot.bodies[at].place {
                BodyPlace::Ground => return None,
                BodyPlace::Turned { parent, .. } | BodyPlace::Slid { parent, .. } => *parent,
                BodyPlace::Along { plane, .. } => self.robot.planes[*plane].body,
            };
            if self.link_of[at].is_some() {
                return Some(at);
            }
        }
        None
    }

    /// A joint from a body that is a link to the link that will be, or is, the other.
    fn joint(&self, number: usize, from: usize, to: usize) -> KinematicJoint {
        let joint = &self.robot.joints[number];
        // The tree may reach the second body first: then the first turns on it, the other way round.
        let forward = joint.bodies[0] == from;
        let axis = self.placed.axis(number);
        let axis = if forward { axis } else { axis.map(|x| -x) };
        let spring = self
            .springs
            .iter()
            .find(|spring| spring.joint == joint.name);
        let compliance = spring.map_or(0.0, |spring| spring.compliance);
        let (limits, moved_by) = self.movers(number, forward);
        KinematicJoint {
            name: joint.name.clone(),
            links: [self.link(from), to],
            position_m: self.placed.node_m(joint.node),
            axis,
            motion: Some(joint.motion),
            stiffness: (compliance > STIFFEST).then(|| 1.0 / compliance),
            friction: spring.map_or(0.0, |spring| spring.friction),
            limits,
            moved_by,
        }
    }

    /// Limits of the one variable that moves a joint, from where it stands, or the variables that move it otherwise.
    fn movers(&self, number: usize, forward: bool) -> (Option<[f64; 2]>, Vec<String>) {
        let joint = &self.robot.joints[number];
        let mut movers = Vec::new();
        for (place, variable) in self.robot.variables.iter().enumerate() {
            let mut moved = self.pose.clone();
            moved.angles_deg[place] += STEP;
            // A loop that does not close a step further is at its limit.
            let Ok(moved) = PlacedRobot::new(self.robot, self.mechanism, &moved) else {
                return (None, Vec::new());
            };
            let rate = match joint.motion {
                JointMotion::Turns => self.turn_rad(&moved, number) / STEP.to_radians(),
                JointMotion::Slides => self.slide_m(&moved, number) / STEP,
            };
            if rate.abs() >= ONE_TO_ONE {
                let now = self.pose.angles_deg[place];
                let ends = [variable.min_deg, variable.max_deg].map(|end| end - now);
                movers.push((variable.name.clone(), rate, ends));
            }
        }
        match movers[..] {
            [(_, rate, [low, high])] if (rate.abs() - 1.0).abs() <= ONE_TO_ONE => {
                let unit = match joint.motion {
                    JointMotion::Turns => 1.0_f64.to_radians(),
                    JointMotion::Slides => 1.0,
                };
                let unit = if forward { unit } else { -unit } * rate.signum();
                let (low, high) = (unit * low, unit * high);
                let limits = [low.min(high), low.max(high)];
                (Some(limits).filter(|[low, high]| low < high), Vec::new())
            }
            _ => (None, movers.into_iter().map(|(name, ..)| name).collect()),
        }
    }

    /// How far the second body of a joint has turned on the first about its axis, rad; for small turns.
    fn turn_rad(&self, moved: &PlacedRobot<'_>, number: usize) -> f64 {
        let joint = &self.robot.joints[number];
        let axis = self.placed.axis(number);
        // Half the sum of before × after over the axes of a body is its turn.
        let turn = |body: usize| {
            let (before, after) = (self.placed.body_axes(body), moved.body_axes(body));
            let pairs = before.into_iter().zip(after);
            pairs
                .map(|(before, after)| 0.5 * dot(axis, cross(before, after)))
                .sum::<f64>()
        };
        turn(joint.bodies[1]) - turn(joint.bodies[0])
    }

    /// How far the second body of a joint has slid on the first along its axis, which turns with them, m.
    fn slide_m(&self, moved: &PlacedRobot<'_>, number: usize) -> f64 {
        let distance_m = |placed: &PlacedRobot<'_>| {
            let origins_m = self.robot.joints[number]
                .bodies
                .map(|body| placed.body_origin_m(body));
            dot(placed.axis(number), subtract(origins_m[1], origins_m[0]))
        };
        distance_m(moved) - distance_m(&self.placed)
    }

    /// Gives each link its beams and masses, and finds the end.
    fn weigh(&mut self, masses: &[(usize, f64, [f64; 3])]) {
        self.found.end_m = self.placed.node_m(self.robot.end);
        for &link in &self.mechanism.rigid_links {
            let link = &self.robot.rigid_links[link];
            let place = self.link(link.body);
            if link.nodes.contains(&self.robot.end) {
                self.found.end = place;
            }
            let ends_m = link.nodes.map(|node| self.placed.node_m(node));
            self.found.links[place].rods.extend(Rod::rigid(ends_m));
        }
        for &(body, mass_kg, centre_m) in masses {
            let body = self.link_of[body].or_else(|| Some(self.link(self.carrier(body)?)));
            let link = &mut self.found.links[body.unwrap_or(0)];
            link.inertia = link.inertia.with(Inertia::point(mass_kg, centre_m));
        }
        for &member in &self.mechanism.members {
            let member = &self.robot.members[member];
            let section = &self.robot.sections[member.section];
            let ends_m = member.nodes.map(|node| self.placed.node_m(node));
            let rod = Rod::beam(ends_m, section.section.area_m2);
            let weight = Inertia::rod(section.mass_kg_per_m.unwrap_or(0.0), rod);
            let link = self.link(member.body);
            if member.nodes.contains(&self.robot.end) {
                self.found.end = link;
            }
            let link = &mut self.found.links[link];
            link.inertia = link.inertia.with(weight);
            link.rods.push(rod);
        }
    }
}
