//! Parallelograms that are folded over themselves.

use stiffbench_numeric::vector::{cross, dot, norm, subtract};

use super::Robot;
use super::error::RobotError;
use super::kinematics::{Item, Order, Placement};
use super::model::{BodyPlace, NodePlace, Pose};

/// Relative difference of opposite sides below which four bars are a parallelogram.
const PARALLELOGRAM: f64 = 0.01;

impl Robot {
    /// Points of loops that close a parallelogram with two of its sides crossed, in a pose.
    ///
    /// The branch of a loop never changes, so one that starts crossed stays so.
    ///
    /// # Errors
    /// [`RobotError::Unreachable`] if a loop does not close.
    pub fn crossed_loops(&self, pose: &Pose) -> Result<Vec<String>, RobotError> {
        let nodes = (0..self.nodes.len()).map(Item::Node);
        let order = Order::of(self, nodes).expect("a checked robot has no circular dependency");
        let mut placement = Placement::new(self, 0.0);
        order.place(self, pose, &mut placement)?;
        let crossed = self.nodes.iter().enumerate().filter(|(place, node)| {
            let NodePlace::Loop { centres, plane, .. } = &node.place else {
                return false;
            };
            let pivots = centres.map(|centre| self.pivot_of(centre));
            let [b, c, d] = [centres[0], *place, centres[1]].map(|node| placement.node_m(node));
            // The side opposite to a coupler runs from a pivot of the crank to the far centre.
            let normal = placement.plane_normal(self, *plane);
            let opposite = [(pivots[0], b, d), (pivots[1], d, b)];
            opposite.into_iter().any(|(pivot, near, far)| {
                let Some(pivot) = pivot.map(|pivot| placement.node_m(pivot)) else {
                    return false;
                };
                let sides = [(pivot, near), (near, c), (c, far), (far, pivot)];
                let [ab, bc, cd, da] = sides.map(|(from, to)| norm(subtract(to, from)));
                let alike = |x: f64, y: f64| (x - y).abs() < PARALLELOGRAM * x.max(y);
                alike(ab, cd)
                    && alike(bc, da)
                    && (meet([pivot, near], [c, far], normal)
                        || meet([near, c], [far, pivot], normal))
            })
        });
        Ok(crossed.map(|(_, node)| node.name.to_string()).collect())
    }

    /// The node about which the body of a node turns.
    fn pivot_of(&self, node: usize) -> Option<usize> {
        let NodePlace::Fixed { body, .. } = self.nodes[node].place else {
            return None;
        };
        match self.bodies[body].place {
            BodyPlace::Turned { origin, .. } if origin != node => Some(origin),
            _ => None,
        }
    }
}

/// Whether two segments of one plane cross each other between their ends.
fn meet(first: [[f64; 3]; 2], second: [[f64; 3]; 2], normal: [f64; 3]) -> bool {
    let side = |from: [f64; 3], to: [f64; 3], point: [f64; 3]| {
        dot(cross(subtract(to, from), subtract(point, from)), normal)
    };
    let [a, b] = first;
    let [c, d] = second;
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}
