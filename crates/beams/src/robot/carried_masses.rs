//! Masses that hang on a structure beside those of its sections, and where.

use crate::structure::Attachment;

use super::loads::{BodyPoint, MassPlace};
use super::model::{BodyPlace, Mechanism, NodePlace, Robot};

/// A mass with where it hangs.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct CarriedMass {
    pub(super) mass_kg: f64,
    pub(super) at: Attachment,
    pub(super) body: usize,
    pub(super) point: MassPoint,
}

/// Where the centre of a mass is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum MassPoint {
    /// At a node of the structure.
    Node(usize),
    OfBody(BodyPoint),
    /// From the tool centre, in the axes of the tool, m.
    OfTool([f64; 3]),
}

/// Bodies whose places only masses and balancers need.
pub(super) fn bodies_of_loads(robot: &Robot) -> Vec<usize> {
    let masses = robot.masses.iter().filter_map(|mass| match mass.place {
        MassPlace::Node(_) => None,
        MassPlace::Point(point) => Some(point.body),
    });
    let pivots = robot.balancers.iter().flat_map(|balancer| balancer.pivots);
    masses.chain(pivots.map(|pivot| pivot.body)).collect()
}

/// The masses that a structure carries, beside those of its sections.
///
/// A mass on a body that is no part of the mechanism hangs rigidly on the next body below it that is. One on a chain that has members, none
/// of them here, is not there.
///
/// # Arguments
/// - `hangs`: where what is fixed at a point of a body hangs on the structure.
/// - `place_of`: number of a robot node in the structure.
/// - `end`: where the end hangs.
pub(super) fn carried_masses(
    robot: &Robot,
    mechanism: &Mechanism,
    hangs: impl Fn(&BodyPoint) -> Option<Attachment>,
    place_of: impl Fn(usize) -> Option<usize>,
    end: &Attachment,
) -> Vec<CarriedMass> {
    let is_there = |body: usize| {
        let Some(chain) = &robot.bodies[body].chain else {
            return true;
        };
        let beams = robot.members.iter().map(|member| &member.chain);
        let mut all = beams.chain(robot.rigid_links.iter().map(|link| &link.chain));
        mechanism.chains.contains(chain) || all.all(|known| known != chain)
    };
    let masses = robot.masses.iter().filter_map(|mass| {
        let (at, body, point) = match mass.place {
            MassPlace::Node(node) => {
                let place = place_of(node)?;
                let mut members = mechanism.bodies_and_nodes(robot);
                let (body, _) = members.find(|(_, nodes)| nodes.contains(&node))?;
                (place.into(), body, MassPoint::Node(place))
            }
            MassPlace::Point(point) if is_there(point.body) => {
                (hangs(&point)?, point.body, MassPoint::OfBody(point))
            }
            MassPlace::Point(_) => return None,
        };
        Some(CarriedMass {
            mass_kg: mass.mass_kg,
            at,
            body,
            point,
        })
    });
    let payload = robot.tool.payload.map(|payload| CarriedMass {
        mass_kg: payload.mass_kg,
        at: end.clone(),
        body: robot.tool.body.unwrap_or_default(),
        point: MassPoint::OfTool(payload.at_m),
    });
    masses.chain(payload).collect()
}

/// The node of the joint on which a body moves, and the point of the body below in which it is.
pub(super) fn joint_below(robot: &Robot, body: usize) -> Option<(usize, BodyPoint)> {
    let node = match robot.bodies[body].place {
        BodyPlace::Turned { origin, .. } | BodyPlace::Slid { origin, .. } => origin,
        BodyPlace::Along { nodes, .. } => nodes[0],
        BodyPlace::Ground => return None,
    };
    match robot.nodes[node].place {
        NodePlace::Fixed { body, at_m } => Some((node, BodyPoint { body, at_m })),
        NodePlace::Loop { .. } => None,
    }
}
