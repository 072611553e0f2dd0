//! Where bodies and nodes are in a pose: the paper's eqs. (6) to (10), for any robot of the file format.
//!
//! Eqs. (6) and (7) walk a chain from joint to joint; here the file says the same by bodies that turn on one another and loops that
//! close, and the order of evaluation is found once. Eq. (8) as printed, x = z cos θ1, is no rotation (at θ1 = 360° it gives
//! x = z); a body that turns about the vertical axis gives x = r sin θ1, z = r cos θ1.
//!
//! Written once over [`Number`]: for one pose, where an error names the item that cannot be placed, and for several poses in SIMD
//! registers, where it shows as a fault. The two agree but for rounding; where a loop folds flat, rounding grows to its square root
//! in both.

#![expect(
    clippy::inline_always,
    reason = "what is not inlined into a kernel is compiled for another instruction set, and calls its instructions one by one"
)]

mod order;

use stiffbench_numeric::simd::{
    Aligned, Number, cross, dot, multiply_add, multiply_subtract, scale, sin_cos_deg, subtract,
};

use super::Robot;
use super::error::RobotError;
use super::model::{Angle, BodyPlace, NodePlace, Pose, RadiusOf};

pub(super) use order::{Circular, Item, Order, check_order};

/// Two nodes lie in one plane if their distance leaves it by no more than this share: rounding of a chain of rotations is at
/// 1e-15, and a link of a metre whose length is wrong by half the square of this is right to any digit.
const OUT_OF_PLANE: f64 = 1e-9;

/// A loop that folds flat closes if it lacks no more than this share of its size: far below any length that can be made.
const OPEN_LOOP: f64 = 1e-12;

/// A unit vector fixed on a body of the robot.
#[derive(Debug, Clone, PartialEq)]
pub(in crate::robot) struct FixedDirection {
    /// The body; `None` for the world.
    pub(in crate::robot) body: Option<usize>,
    /// The vector in its axes.
    pub(in crate::robot) local: [f64; 3],
}

/// Origin and axes of a body.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct BodyAxes<T> {
    /// Origin, m.
    origin_m: [T; 3],
    /// Local x, y, z as global unit vectors.
    axes: [[T; 3]; 3],
}

/// Bodies and nodes of a robot by index; those an order does not lead to keep their last value.
#[derive(Debug, Clone)]
pub(super) struct Placement<T> {
    bodies: Vec<BodyAxes<T>>,
    nodes_m: Vec<Aligned<[T; 3]>>,
}

impl Order {
    /// Places everything in `pose`; allocates nothing.
    ///
    /// # Errors
    /// [`RobotError::Unreachable`] with the loop that does not close and by how much; [`RobotError::OutOfPlane`] and
    /// [`RobotError::NoDirection`] if two nodes do not lie as a plane or a body needs them.
    pub(super) fn place(
        &self,
        robot: &Robot,
        pose: &Pose,
        placement: &mut Placement<f64>,
    ) -> Result<(), RobotError> {
        for &item in &self.0 {
            if placement.place(robot, item, &pose.angles_deg) != 0.0 {
                return Err(placement.why_not(robot, item, pose));
            }
        }
        Ok(())
    }

    /// Places everything at the angles of the variables, degrees; what comes back is above zero where something has no place.
    #[inline(always)]
    pub(super) fn place_all<T: Number>(
        &self,
        robot: &Robot,
        angles_deg: &[T],
        nothing: T,
        placement: &mut Placement<T>,
    ) -> T {
        let mut faults = nothing.of(0.0);
        for &item in &self.0 {
            faults += placement.place(robot, item, angles_deg);
        }
        faults
    }
}

impl<T: Number> Placement<T> {
    /// Room for the bodies and nodes of a robot; `zero` is 0.
    pub(super) fn new(robot: &Robot, zero: T) -> Self {
        let one = zero.of(1.0);
        let ground = BodyAxes {
            origin_m: [zero; 3],
            axes: [[one, zero, zero], [zero, one, zero], [zero, zero, one]],
        };
        Self {
            bodies: vec![ground; robot.bodies.len()],
            nodes_m: vec![Aligned([zero; 3]); robot.nodes.len()],
        }
    }

    /// Position of a node, m.
    #[inline(always)]
    pub(super) fn node_m(&self, node: usize) -> [T; 3] {
        self.nodes_m[node].0
    }

    /// A direction fixed on a body, global.
    #[inline(always)]
    pub(super) fn direction(&self, direction: &FixedDirection) -> [T; 3] {
        match direction.body {
            Some(body) => to_global(&self.bodies[body].axes, &direction.local),
            None => direction
                .local
                .map(|entry| self.bodies[0].origin_m[0].of(entry)),
        }
    }

    /// A point of a body, m.
    #[inline(always)]
    pub(super) fn point_m(&self, body: usize, at_m: &[f64; 3]) -> [T; 3] {
        let body = &self.bodies[body];
        let mut point = to_global(&body.axes, at_m);
        for i in 0..3 {
            point[i] += body.origin_m[i];
        }
        point
    }

    /// Axes of a body, global.
    #[inline(always)]
    pub(super) fn axes(&self, body: usize) -> [[T; 3]; 3] {
        self.bodies[body].axes
    }

    /// Unit normal of a plane, global.
    #[inline(always)]
    pub(super) fn plane_normal(&self, robot: &Robot, plane: usize) -> [T; 3] {
        let plane = &robot.planes[plane];
        to_global(&self.bodies[plane.body].axes, &plane.normal)
    }

    /// Places a body or a node; what comes back is above zero where it has no place.
    #[inline(always)]
    fn place(&mut self, robot: &Robot, item: Item, angles_deg: &[T]) -> T {
        match item {
            Item::Body(body) => {
                let (axes, fault) = self.body_axes(robot, body, angles_deg);
                self.bodies[body] = axes;
                fault
            }
            Item::Node(node) => {
                let (position_m, fault) = self.node_position(robot, node);
                self.nodes_m[node].0 = position_m;
                fault
            }
        }
    }

    #[inline(always)]
    fn body_axes(&self, robot: &Robot, body: usize, angles_deg: &[T]) -> (BodyAxes<T>, T) {
        let ground = self.bodies[body];
        let nothing = ground.origin_m[0].of(0.0);
        match &robot.bodies[body].place {
            BodyPlace::Ground => (ground, nothing),
            BodyPlace::Turned {
                parent,
                origin,
                axis,
                angle,
            } => {
                let (sin, cos) = sin_cos_deg(sum(angle, angles_deg, nothing));
                let axes = BodyAxes {
                    origin_m: self.node_m(*origin),
                    axes: turned(&self.bodies[*parent].axes, axis, sin, cos),
                };
                (axes, nothing)
            }
            BodyPlace::Slid {
                parent,
                origin,
                axis,
                distance,
            } => {
                let parent = &self.bodies[*parent].axes;
                let along = to_global(parent, axis);
                let distance_m = sum(distance, angles_deg, nothing);
                let mut origin_m = self.node_m(*origin);
                for i in 0..3 {
                    origin_m[i] = multiply_add(distance_m, along[i], origin_m[i]);
                }
                let axes = BodyAxes {
                    origin_m,
                    axes: *parent,
                };
                (axes, nothing)
            }
            BodyPlace::Along {
                nodes: [first, second],
                plane,
                turn_deg,
            } => {
                let start = self.node_m(*first);
                let x = self.plane_normal(robot, *plane);
                let span = subtract(&self.node_m(*second), &start);
                let z = scale(&span, dot(&span, &span).sqrt().inverse());
                let y = cross(&z, &x);
                let (sin, cos) = turn_deg.to_radians().sin_cos();
                let (sin, cos) = (nothing.of(sin), nothing.of(cos));
                let mut axes = [x, y, z];
                for i in 0..3 {
                    axes[1][i] = multiply_subtract(sin, z[i], cos * y[i]);
                    axes[2][i] = multiply_add(sin, y[i], cos * z[i]);
                }
                let axes = BodyAxes {
                    origin_m: start,
                    axes,
                };
                (axes, leaves_plane(&span, &x))
            }
        }
    }

    #[inline(always)]
    fn node_position(&self, robot: &Robot, node: usize) -> ([T; 3], T) {
        match &robot.nodes[node].place {
            NodePlace::Fixed { body, at_m } => {
                let position = self.point_m(*body, at_m);
                (position, position[0].of(0.0))
            }
            NodePlace::Loop {
                centres,
                radii,
                plane,
                branch,
            } => {
                let normal = self.plane_normal(robot, *plane);
                let radii = [self.radius(radii[0]), self.radius(radii[1])];
                let centres = [self.node_m(centres[0]), self.node_m(centres[1])];
                intersection(&centres, radii, &normal, *branch)
            }
        }
    }

    #[inline(always)]
    fn radius(&self, radius: RadiusOf) -> T {
        match radius {
            RadiusOf::Length(length_m) => self.nodes_m[0].0[0].of(length_m),
            RadiusOf::Distance([a, b]) => {
                let span = subtract(&self.node_m(b), &self.node_m(a));
                dot(&span, &span).sqrt()
            }
        }
    }
}

impl Placement<f64> {
    /// Why an item has no place where all that it needs is placed.
    fn why_not(&self, robot: &Robot, item: Item, pose: &Pose) -> RobotError {
        let name = |node: usize| robot.nodes[node].name.to_string();
        let pose = describe(robot, pose);
        let (nodes, plane) = match item {
            Item::Body(body) => match &robot.bodies[body].place {
                BodyPlace::Along { nodes, plane, .. } => (*nodes, *plane),
                _ => unreachable!("a body that turns has a place in every pose"),
            },
            Item::Node(node) => match &robot.nodes[node].place {
                NodePlace::Loop { centres, plane, .. } => (*centres, *plane),
                NodePlace::Fixed { .. } => unreachable!("a node fixed on a body has a place"),
            },
        };
        let [first, second] = nodes.map(name);
        let span = subtract(&self.node_m(nodes[1]), &self.node_m(nodes[0]));
        let distance_m = dot(&span, &span).sqrt();
        let normal = self.plane_normal(robot, plane);
        if distance_m != 0.0 && leaves_plane(&span, &normal) != 0.0 {
            return RobotError::OutOfPlane {
                pose,
                plane: robot.planes[plane].name.clone(),
                first,
                second,
                offset_m: dot(&span, &normal).abs(),
            };
        }
        match item {
            Item::Body(body) => RobotError::NoDirection {
                pose,
                body: robot.bodies[body].name.clone(),
                first,
                second,
            },
            Item::Node(node) => {
                let [first_radius_m, second_radius_m] = match &robot.nodes[node].place {
                    NodePlace::Loop { radii, .. } => radii.map(|radius| self.radius(radius)),
                    NodePlace::Fixed { .. } => [0.0; 2],
                };
                RobotError::Unreachable {
                    pose,
                    node: name(node),
                    first,
                    second,
                    distance_m,
                    first_radius_m,
                    second_radius_m,
                    gap_m: gap(distance_m, first_radius_m, second_radius_m),
                }
            }
        }
    }
}

/// offset + Σ coefficient × variable.
#[inline(always)]
fn sum<T: Number>(angle: &Angle, variables: &[T], nothing: T) -> T {
    let mut sum = nothing.of(angle.offset_deg);
    for &(variable, coefficient) in &angle.terms {
        sum = multiply_add(variables[variable], nothing.of(coefficient), sum);
    }
    sum
}

/// Σ local × axes; a component of zero costs nothing.
#[inline(always)]
fn to_global<T: Number>(axes: &[[T; 3]; 3], local: &[f64; 3]) -> [T; 3] {
    let mut sum = [axes[0][0].of(0.0); 3];
    for k in 0..3 {
        if local[k] != 0.0 {
            let factor = sum[0].of(local[k]);
            for i in 0..3 {
                sum[i] = multiply_add(factor, axes[k][i], sum[i]);
            }
        }
    }
    sum
}

/// Axes turned about a unit axis given in them (Rodrigues): P cos + a × P sin + a (a · P)(1 - cos) for each P.
#[inline(always)]
fn turned<T: Number>(parent: &[[T; 3]; 3], axis: &[f64; 3], sin: T, cos: T) -> [[T; 3]; 3] {
    let global = to_global(parent, axis);
    let versine = sin.of(1.0) - cos;
    let mut axes = *parent;
    for k in 0..3 {
        let around = cross(&global, &parent[k]);
        let along = versine * sin.of(axis[k]);
        for i in 0..3 {
            let across = multiply_add(around[i], sin, parent[k][i] * cos);
            axes[k][i] = multiply_add(along, global[i], across);
        }
    }
    axes
}

/// 1 where two nodes coincide or do not lie in one plane of this normal.
#[inline(always)]
fn leaves_plane<T: Number>(span: &[T; 3], normal: &[T; 3]) -> T {
    let offset = dot(span, normal);
    let limit = dot(span, span) * offset.of(OUT_OF_PLANE * OUT_OF_PLANE);
    (offset * offset).fault_unless_below(limit)
}

/// By how much two circles miss each other, m; negative where they meet.
#[inline(always)]
fn gap<T: Number>(distance: T, r1: T, r2: T) -> T {
    (distance - (r1 + r2)).max((r1 - r2).abs() - distance)
}

/// Where two circles in a plane meet, on the side `branch` of n × u with u from the first centre to the second; and 1 where they do
/// not.
#[inline(always)]
fn intersection<T: Number>(
    [c1, c2]: &[[T; 3]; 2],
    [r1, r2]: [T; 2],
    normal: &[T; 3],
    branch: f64,
) -> ([T; 3], T) {
    let between = subtract(c2, c1);
    let distance = dot(&between, &between).sqrt();
    let inverse = distance.inverse();
    let (sum, difference) = (r1 + r2, r1 - r2);
    let open = gap(distance, r1, r2).fault_unless_below(sum * r1.of(OPEN_LOOP));
    let u = scale(&between, inverse);
    let along = r1.of(0.5) * multiply_add(difference * sum, inverse, distance);
    let squared = ((r1 - along) * (r1 + along)).max(r1.of(0.0));
    let height = squared.sqrt() * r1.of(branch);
    let side = cross(normal, &u);
    let mut position = *c1;
    for i in 0..3 {
        let foot = multiply_add(along, u[i], c1[i]);
        position[i] = multiply_add(height, side[i], foot);
    }
    (position, leaves_plane(&between, normal) + open)
}

/// A pose in words, for messages.
fn describe(robot: &Robot, pose: &Pose) -> String {
    let angles = robot.variables.iter().zip(&pose.angles_deg);
    angles
        .map(|(variable, angle)| format!("{} = {angle}", variable.name))
        .collect::<Vec<_>>()
        .join(", ")
}
