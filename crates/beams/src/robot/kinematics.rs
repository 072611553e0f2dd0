//! Where bodies and nodes are in a pose: the paper's eqs. (6) to (10), for any robot of the file format.
//!
//! Eqs. (6) and (7) walk a chain from joint to joint; here the file says the same by bodies that turn on one another and loops that
//! close, and the order of evaluation is found once. Eq. (8) as printed, x = z cos θ1, is no rotation (at θ1 = 360° it gives
//! x = z); a body that turns about the vertical axis gives x = r sin θ1, z = r cos θ1.

use stiffbench_numeric::vector::{cross, dot, norm, rotation, scale, subtract};

use super::Robot;
use super::error::RobotError;
use super::model::{BodyPlace, NodePlace, Pose, RadiusOf};

/// Two nodes lie in one plane if their distance leaves it by no more than this share: rounding of a chain of rotations is at
/// 1e-15, and a link of a metre whose length is wrong by half the square of this is right to any digit.
pub(super) const OUT_OF_PLANE: f64 = 1e-9;

/// Origin and axes of a body; `axes[i]` is its i-th axis in global components.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyAxes {
    /// Origin, m.
    pub origin_m: [f64; 3],
    /// Local x, y, z as global unit vectors.
    pub axes: [[f64; 3]; 3],
}

impl BodyAxes {
    const GROUND: Self = Self {
        origin_m: [0.0; 3],
        axes: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    };

    /// A local vector in global components.
    #[must_use]
    pub fn to_global(&self, local: [f64; 3]) -> [f64; 3] {
        std::array::from_fn(|i| (0..3).map(|axis| local[axis] * self.axes[axis][i]).sum())
    }
}

/// Bodies and nodes of a robot in one pose, by index; those a mechanism does not need keep their last value.
#[derive(Debug, Clone, PartialEq)]
pub struct Placement {
    /// Axes of each body.
    pub bodies: Vec<BodyAxes>,
    /// Position of each node, m.
    pub nodes_m: Vec<[f64; 3]>,
}

impl Placement {
    /// Room for the bodies and nodes of a robot.
    #[must_use]
    pub fn new(robot: &Robot) -> Self {
        Self {
            bodies: vec![BodyAxes::GROUND; robot.bodies.len()],
            nodes_m: vec![[0.0; 3]; robot.nodes.len()],
        }
    }

    /// Unit normal of a plane, global.
    #[must_use]
    pub fn plane_normal(&self, robot: &Robot, plane: usize) -> [f64; 3] {
        let plane = &robot.planes[plane];
        self.bodies[plane.body].to_global(plane.normal)
    }
}

/// A body or a node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Item {
    Body(usize),
    Node(usize),
}

/// Something that needs itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Circular {
    pub(super) kind: &'static str,
    pub(super) name: String,
    pub(super) chain: String,
}

/// The order in which bodies and nodes follow from one another.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Order(pub(super) Vec<Item>);

/// Finds whether every body and node of a robot can be placed.
pub(super) fn check_order(robot: &Robot) -> Result<(), Circular> {
    let bodies = (0..robot.bodies.len()).map(Item::Body);
    let nodes = (0..robot.nodes.len()).map(Item::Node);
    Order::of(robot, bodies.chain(nodes)).map(|_| ())
}

impl Order {
    /// The order that leads to the wanted items and to nothing else.
    pub(super) fn of(robot: &Robot, wanted: impl Iterator<Item = Item>) -> Result<Self, Circular> {
        let mut search = Search {
            robot,
            body_state: vec![State::New; robot.bodies.len()],
            node_state: vec![State::New; robot.nodes.len()],
            path: Vec::new(),
            order: Vec::new(),
        };
        for item in wanted {
            search.visit(item)?;
        }
        Ok(Self(search.order))
    }

    /// Places everything in `pose`; allocates nothing.
    ///
    /// # Errors
    /// [`RobotError::Unreachable`] with the loop that does not close and by how much; [`RobotError::OutOfPlane`] and
    /// [`RobotError::NoDirection`] if two nodes do not lie as a plane or a body needs them.
    pub(super) fn place(
        &self,
        robot: &Robot,
        pose: &Pose,
        placement: &mut Placement,
    ) -> Result<(), RobotError> {
        for &item in &self.0 {
            match item {
                Item::Body(body) => {
                    placement.bodies[body] = body_axes(robot, body, pose, placement)?;
                }
                Item::Node(node) => {
                    placement.nodes_m[node] = node_position(robot, node, pose, placement)?;
                }
            }
        }
        Ok(())
    }
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum State {
    New,
    Open,
    Done,
}

/// Depth-first search for the order.
struct Search<'a> {
    robot: &'a Robot,
    body_state: Vec<State>,
    node_state: Vec<State>,
    path: Vec<Item>,
    order: Vec<Item>,
}

impl Search<'_> {
    fn state(&mut self, item: Item) -> &mut State {
        match item {
            Item::Body(body) => &mut self.body_state[body],
            Item::Node(node) => &mut self.node_state[node],
        }
    }

    /// Puts what an item needs, and then the item, into the order.
    ///
    /// The path is kept here and not in recursive calls: a chain of bodies may be longer than the thread's stack is deep.
    fn visit(&mut self, item: Item) -> Result<(), Circular> {
        let mut waiting = vec![vec![item]];
        while let Some(level) = waiting.last_mut() {
            let Some(next) = level.pop() else {
                // Everything the last item of the path needs is in the order.
                waiting.pop();
                if let Some(done) = self.path.pop() {
                    *self.state(done) = State::Done;
                    self.order.push(done);
                }
                continue;
            };
            match *self.state(next) {
                State::Done => {}
                State::Open => return Err(self.circular(next)),
                State::New => {
                    *self.state(next) = State::Open;
                    self.path.push(next);
                    let mut needed = needs(self.robot, next);
                    needed.reverse();
                    waiting.push(needed);
                }
            }
        }
        Ok(())
    }

    fn circular(&self, item: Item) -> Circular {
        let start = self
            .path
            .iter()
            .position(|on_path| *on_path == item)
            .unwrap_or(0);
        let around = self.path[start..].iter().chain(std::iter::once(&item));
        let chain = around
            .map(|i| name(self.robot, *i))
            .collect::<Vec<_>>()
            .join(" needs ");
        let kind = match item {
            Item::Body(_) => "body",
            Item::Node(_) => "node",
        };
        Circular {
            kind,
            name: name(self.robot, item),
            chain,
        }
    }
}

fn name(robot: &Robot, item: Item) -> String {
    match item {
        Item::Body(body) => robot.bodies[body].name.clone(),
        Item::Node(node) => robot.nodes[node].name.to_string(),
    }
}

/// What must be placed before an item.
fn needs(robot: &Robot, item: Item) -> Vec<Item> {
    let plane_body = |plane: usize| Item::Body(robot.planes[plane].body);
    match item {
        Item::Body(body) => match &robot.bodies[body].place {
            BodyPlace::Ground => Vec::new(),
            BodyPlace::Turned { parent, origin, .. } => {
                vec![Item::Body(*parent), Item::Node(*origin)]
            }
            BodyPlace::Along {
                nodes: [first, second],
                plane,
                ..
            } => {
                vec![Item::Node(*first), Item::Node(*second), plane_body(*plane)]
            }
        },
        Item::Node(node) => match &robot.nodes[node].place {
            NodePlace::Fixed { body, .. } => vec![Item::Body(*body)],
            NodePlace::Loop {
                centres,
                radii,
                plane,
                ..
            } => {
                let mut items = vec![
                    Item::Node(centres[0]),
                    Item::Node(centres[1]),
                    plane_body(*plane),
                ];
                for radius in radii {
                    if let RadiusOf::Distance([first, second]) = radius {
                        items.extend([Item::Node(*first), Item::Node(*second)]);
                    }
                }
                items
            }
        },
    }
}

fn body_axes(
    robot: &Robot,
    body: usize,
    pose: &Pose,
    placement: &Placement,
) -> Result<BodyAxes, RobotError> {
    Ok(match &robot.bodies[body].place {
        BodyPlace::Ground => BodyAxes::GROUND,
        BodyPlace::Turned {
            parent,
            origin,
            axis,
            angle,
        } => {
            let parent = &placement.bodies[*parent];
            let turn = rotation(*axis, angle.value_deg(pose).to_radians());
            BodyAxes {
                origin_m: placement.nodes_m[*origin],
                axes: std::array::from_fn(|column| parent.to_global(turn.map(|row| row[column]))),
            }
        }
        BodyPlace::Along {
            nodes: [first, second],
            plane,
            turn_deg,
        } => {
            let (start, stop) = (placement.nodes_m[*first], placement.nodes_m[*second]);
            let x = placement.plane_normal(robot, *plane);
            let span = subtract(stop, start);
            if norm(span) == 0.0 {
                return Err(RobotError::NoDirection {
                    pose: describe(robot, pose),
                    body: robot.bodies[body].name.clone(),
                    first: robot.nodes[*first].name.to_string(),
                    second: robot.nodes[*second].name.to_string(),
                });
            }
            check_in_plane(robot, pose, [*first, *second], *plane, span, x)?;
            let z = scale(span, 1.0 / norm(span));
            let y = cross(z, x);
            let (sin, cos) = turn_deg.to_radians().sin_cos();
            BodyAxes {
                origin_m: start,
                axes: [
                    x,
                    std::array::from_fn(|i| cos * y[i] - sin * z[i]),
                    std::array::from_fn(|i| cos * z[i] + sin * y[i]),
                ],
            }
        }
    })
}

/// Refuses two nodes whose distance has a part along the normal of the plane they should lie in.
fn check_in_plane(
    robot: &Robot,
    pose: &Pose,
    nodes: [usize; 2],
    plane: usize,
    span: [f64; 3],
    normal: [f64; 3],
) -> Result<(), RobotError> {
    let offset_m = dot(span, normal).abs();
    if offset_m <= OUT_OF_PLANE * norm(span) {
        return Ok(());
    }
    let [first, second] = nodes.map(|node| robot.nodes[node].name.to_string());
    Err(RobotError::OutOfPlane {
        pose: describe(robot, pose),
        plane: robot.planes[plane].name.clone(),
        first,
        second,
        offset_m,
    })
}

fn node_position(
    robot: &Robot,
    node: usize,
    pose: &Pose,
    placement: &Placement,
) -> Result<[f64; 3], RobotError> {
    match &robot.nodes[node].place {
        NodePlace::Fixed { body, at_m } => {
            let axes = &placement.bodies[*body];
            let offset = axes.to_global(*at_m);
            Ok(std::array::from_fn(|i| axes.origin_m[i] + offset[i]))
        }
        NodePlace::Loop {
            centres,
            radii,
            plane,
            branch,
        } => {
            let [c1, c2] = centres.map(|centre| placement.nodes_m[centre]);
            let [r1, r2] = radii.map(|radius| match radius {
                RadiusOf::Length(length_m) => length_m,
                RadiusOf::Distance([a, b]) => {
                    norm(subtract(placement.nodes_m[b], placement.nodes_m[a]))
                }
            });
            let normal = placement.plane_normal(robot, *plane);
            check_in_plane(robot, pose, *centres, *plane, subtract(c2, c1), normal)?;
            intersection(c1, c2, r1, r2, normal, *branch).map_err(|gap_m| RobotError::Unreachable {
                pose: describe(robot, pose),
                node: robot.nodes[node].name.to_string(),
                first: robot.nodes[centres[0]].name.to_string(),
                second: robot.nodes[centres[1]].name.to_string(),
                distance_m: norm(subtract(c2, c1)),
                first_radius_m: r1,
                second_radius_m: r2,
                gap_m,
            })
        }
    }
}

/// Where two circles in a plane meet, on the side `branch` of n × u with u from the first centre to the second.
///
/// # Errors
/// The gap, m, by which the circles miss each other.
fn intersection(
    c1: [f64; 3],
    c2: [f64; 3],
    r1: f64,
    r2: f64,
    normal: [f64; 3],
    branch: f64,
) -> Result<[f64; 3], f64> {
    let between = subtract(c2, c1);
    let distance = norm(between);
    let gap = (distance - (r1 + r2)).max((r1 - r2).abs() - distance);
    // A loop that folds flat closes within rounding: 1e-12 of its size is far below any length that can be made.
    if gap.is_nan() || gap > 1e-12 * (r1 + r2) || distance == 0.0 {
        return Err(gap);
    }
    let u = between.map(|c| c / distance);
    let along = (distance * distance + (r1 - r2) * (r1 + r2)) / (2.0 * distance);
    let height = ((r1 - along) * (r1 + along)).max(0.0).sqrt();
    let side = cross(normal, u);
    Ok(std::array::from_fn(|i| {
        c1[i] + along * u[i] + branch * height * side[i]
    }))
}

/// A pose in words, for messages.
fn describe(robot: &Robot, pose: &Pose) -> String {
    let angles = robot.variables.iter().zip(&pose.angles_deg);
    angles
        .map(|(variable, angle)| format!("{} = {angle}", variable.name))
        .collect::<Vec<_>>()
        .join(", ")
}
