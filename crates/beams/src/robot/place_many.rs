//! Where bodies and nodes are in as many poses as a lane holds: [`kinematics`](super::kinematics) in lanes.
//!
//! What a pose cannot take shows as a fault; [`Order::place`] says what it is. The two agree but for rounding; where a loop folds
//! flat, rounding grows to its square root in both.

#![expect(
    clippy::inline_always,
    reason = "what is not inlined into a kernel is compiled for another instruction set, and calls its instructions one by one"
)]

use pulp::Simd;

use crate::structure::Placed;
use stiffbench_numeric::lanes::{
    Aligned, Kernel, Lane, cross, dot, multiply_add, multiply_subtract, scale, sin_cos_deg,
    subtract,
};

use super::Robot;
use super::kinematics::{Item, OUT_OF_PLANE, Order};
use super::model::{BodyPlace, NodePlace, RadiusOf};

/// Origin and axes of a body.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct Axes<S: Simd> {
    origin_m: [Lane<S>; 3],
    axes: [[Lane<S>; 3]; 3],
}

/// Bodies and nodes of a robot by index.
#[derive(Debug)]
pub(super) struct Placer<S: Simd> {
    bodies: Vec<Axes<S>>,
    nodes_m: Vec<Aligned<[Lane<S>; 3]>>,
    /// Angle of each variable, degrees.
    pub(super) angles_deg: Vec<Lane<S>>,
}

impl<S: Simd> Placer<S> {
    pub(super) fn new(simd: S, robot: &Robot) -> Self {
        let (zero, one) = (Lane::zero(simd), Lane::one(simd));
        let ground = Axes {
            origin_m: [zero; 3],
            axes: [[one, zero, zero], [zero, one, zero], [zero, zero, one]],
        };
        Self {
            bodies: vec![ground; robot.bodies.len()],
            nodes_m: vec![Aligned([zero; 3]); robot.nodes.len()],
            angles_deg: vec![zero; robot.variables.len()],
        }
    }
}

/// Places everything an order leads to, in the poses of [`Placer::angles_deg`].
pub(super) struct PlaceMany<'a, S: Simd> {
    pub(super) robot: &'a Robot,
    pub(super) order: &'a Order,
    /// Robot node of each node wanted.
    pub(super) wanted: &'a [usize],
    /// Planes whose normals are wanted.
    pub(super) planes: &'a [usize],
    pub(super) placer: &'a mut Placer<S>,
    /// Nodes as in `wanted`, normals by plane.
    pub(super) placed: &'a mut Placed<S>,
}

impl<S: Simd> Kernel for PlaceMany<'_, S> {
    #[inline(always)]
    fn run(self) {
        let Self {
            robot,
            placer,
            placed,
            ..
        } = self;
        let mut faults = placed.faults.of(0.0);
        for &item in &self.order.0 {
            match item {
                Item::Body(body) => {
                    placer.bodies[body] = body_axes(robot, body, placer, &mut faults);
                }
                Item::Node(node) => {
                    placer.nodes_m[node].0 = node_position(robot, node, placer, &mut faults);
                }
            }
        }
        for (target, &node) in placed.nodes_m.iter_mut().zip(self.wanted) {
            target.0 = placer.nodes_m[node].0;
        }
        for &plane in self.planes {
            placed.normals[plane].0 = plane_normal(robot, plane, &placer.bodies);
        }
        placed.faults = faults;
    }
}

/// Σ local × axes; a component of zero costs nothing.
#[inline(always)]
fn to_global<S: Simd>(axes: &[[Lane<S>; 3]; 3], local: &[f64; 3]) -> [Lane<S>; 3] {
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

#[inline(always)]
fn plane_normal<S: Simd>(robot: &Robot, plane: usize, bodies: &[Axes<S>]) -> [Lane<S>; 3] {
    let plane = &robot.planes[plane];
    to_global(&bodies[plane.body].axes, &plane.normal)
}

#[inline(always)]
fn body_axes<S: Simd>(
    robot: &Robot,
    body: usize,
    placer: &Placer<S>,
    faults: &mut Lane<S>,
) -> Axes<S> {
    match &robot.bodies[body].place {
        BodyPlace::Ground => placer.bodies[body],
        BodyPlace::Turned {
            parent,
            origin,
            axis,
            angle,
        } => {
            let mut turn_deg = faults.of(angle.offset_deg);
            for &(variable, coefficient) in &angle.terms {
                let of_variable = placer.angles_deg[variable];
                turn_deg = multiply_add(of_variable, faults.of(coefficient), turn_deg);
            }
            let (sin, cos) = sin_cos_deg(turn_deg);
            let parent = &placer.bodies[*parent];
            Axes {
                origin_m: placer.nodes_m[*origin].0,
                axes: turned(&parent.axes, axis, sin, cos),
            }
        }
        BodyPlace::Along {
            nodes: [first, second],
            plane,
            turn_deg,
        } => {
            let start = placer.nodes_m[*first].0;
            let x = plane_normal(robot, *plane, &placer.bodies);
            let span = subtract(&placer.nodes_m[*second].0, &start);
            *faults += leaves_plane(&span, &x);
            let z = scale(&span, dot(&span, &span).sqrt().inverse());
            let y = cross(&z, &x);
            let (sin, cos) = turn_deg.to_radians().sin_cos();
            let (sin, cos) = (faults.of(sin), faults.of(cos));
            let mut axes = [x, y, z];
            for i in 0..3 {
                axes[1][i] = multiply_subtract(sin, z[i], cos * y[i]);
                axes[2][i] = multiply_add(sin, y[i], cos * z[i]);
            }
            Axes {
                origin_m: start,
                axes,
            }
        }
    }
}

/// Axes turned about a unit axis given in them (Rodrigues): P cos + a × P sin + a (a · P)(1 - cos) for each P.
#[inline(always)]
fn turned<S: Simd>(
    parent: &[[Lane<S>; 3]; 3],
    axis: &[f64; 3],
    sin: Lane<S>,
    cos: Lane<S>,
) -> [[Lane<S>; 3]; 3] {
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
fn leaves_plane<S: Simd>(span: &[Lane<S>; 3], normal: &[Lane<S>; 3]) -> Lane<S> {
    let offset = dot(span, normal);
    let limit = dot(span, span) * offset.of(OUT_OF_PLANE * OUT_OF_PLANE);
    (offset * offset).fault_unless_below(limit)
}

#[inline(always)]
fn node_position<S: Simd>(
    robot: &Robot,
    node: usize,
    placer: &Placer<S>,
    faults: &mut Lane<S>,
) -> [Lane<S>; 3] {
    match &robot.nodes[node].place {
        NodePlace::Fixed { body, at_m } => {
            let axes = &placer.bodies[*body];
            let mut position = to_global(&axes.axes, at_m);
            for i in 0..3 {
                position[i] += axes.origin_m[i];
            }
            position
        }
        NodePlace::Loop {
            centres,
            radii,
            plane,
            branch,
        } => {
            let normal = plane_normal(robot, *plane, &placer.bodies);
            let radii = [
                radius(radii[0], placer, faults),
                radius(radii[1], placer, faults),
            ];
            let centres = [&placer.nodes_m[centres[0]].0, &placer.nodes_m[centres[1]].0];
            intersection(centres, radii, &normal, *branch, faults)
        }
    }
}

#[inline(always)]
fn radius<S: Simd>(radius: RadiusOf, placer: &Placer<S>, like: &Lane<S>) -> Lane<S> {
    match radius {
        RadiusOf::Length(length_m) => like.of(length_m),
        RadiusOf::Distance([a, b]) => {
            let span = subtract(&placer.nodes_m[b].0, &placer.nodes_m[a].0);
            dot(&span, &span).sqrt()
        }
    }
}

/// Where two circles in a plane meet, on the side `branch` of n × u with u from the first centre to the second.
#[inline(always)]
fn intersection<S: Simd>(
    [c1, c2]: [&[Lane<S>; 3]; 2],
    [r1, r2]: [Lane<S>; 2],
    normal: &[Lane<S>; 3],
    branch: f64,
    faults: &mut Lane<S>,
) -> [Lane<S>; 3] {
    let between = subtract(c2, c1);
    *faults += leaves_plane(&between, normal);
    let distance = dot(&between, &between).sqrt();
    let inverse = distance.inverse();
    let (sum, difference) = (r1 + r2, r1 - r2);
    let gap = (distance - sum).max(difference.abs() - distance);
    *faults += gap.fault_unless_below(sum * r1.of(1e-12));
    let u = scale(&between, inverse);
    let half = r1.of(0.5);
    let along = half * multiply_add(difference * sum, inverse, distance);
    let squared = ((r1 - along) * (r1 + along)).max(r1.of(0.0));
    let height = squared.sqrt() * r1.of(branch);
    let side = cross(normal, &u);
    let mut position = *c1;
    for i in 0..3 {
        let foot = multiply_add(along, u[i], c1[i]);
        position[i] = multiply_add(height, side[i], foot);
    }
    position
}
