//! A robot in its poses, as figures.

use crate::plot::{
    DrawnAxes, DrawnJoint, DrawnKind, DrawnMember, DrawnNode, Figure, RobotDrawing, robot_pose,
};
use crate::robot::{ElementClass, JointMotion, MechanismModel, Predictor, Robot};
use crate::structure::Attachment;

use super::axis_words::axis_name;

/// A robot that extends by more than this share of its size away from the plane of its side view is drawn from the front too.
const DEEP: f64 = 0.15;

/// The robot in a pose under a load at its end.
///
/// Call after [`Predictor::place`].
#[must_use]
pub fn robot_figure(predictor: &mut Predictor<'_>, pose: &str, force_n: [f64; 3]) -> Figure {
    let (solver, model) = predictor.parts();
    let structure = model.structure();
    let [fx, fy, fz] = force_n;
    let response = solver.respond(
        structure,
        &[(structure.end.clone(), [fx, fy, fz, 0.0, 0.0, 0.0])],
    );
    let rotation_at = |end: &Attachment| -> [f64; 3] {
        let [.., rx, ry, rz] = response.nodes[end.node];
        let hinges = end.hinges.iter();
        let turning = hinges.filter(|&&hinge| !structure.hinges[hinge].slides);
        turning.fold([rx, ry, rz], |rotation, &hinge| {
            let axis = structure.hinges[hinge].axis;
            std::array::from_fn(|i| rotation[i] + response.hinges_rad[hinge] * axis[i])
        })
    };
    let mut drawing = RobotDrawing {
        joints: Vec::new(),
        force_n: Some(force_n),
        ..pose_drawing(model, pose)
    };
    for (node, [ux, uy, uz, ..]) in drawing.nodes.iter_mut().zip(&response.nodes) {
        node.displacement_m = [*ux, *uy, *uz];
    }
    let elements = structure.elements.iter().map(|element| &element.ends);
    let rigid = structure.rigid_members.iter().map(|member| &member.ends);
    for (member, ends) in drawing.members.iter_mut().zip(elements.chain(rigid)) {
        member.rotations_rad = ends.each_ref().map(rotation_at);
    }
    robot_pose(&drawing)
}

/// The robot in a pose without a load, with its joints.
///
/// Call after [`MechanismModel::place`].
#[must_use]
pub fn pose_drawing(model: &MechanismModel<'_>, pose: &str) -> RobotDrawing {
    let (robot, structure) = (model.robot(), model.structure());
    let nodes = structure.nodes.iter().map(|node| DrawnNode {
        name: node.name.to_string(),
        position_m: node.position_m,
        displacement_m: [0.0; 3],
    });
    let elements = structure.elements.iter().zip(model.members());
    let members = elements.map(|(element, member)| DrawnMember {
        nodes: [element.ends[0].node, element.ends[1].node],
        rotations_rad: [[0.0; 3]; 2],
        chain: member.chain.clone(),
        kind: match member.class {
            ElementClass::Beam => DrawnKind::Beam,
            ElementClass::Link => DrawnKind::Link,
        },
    });
    // Those beyond the links of the mechanism hold the tool and a base that yields.
    let links = model.mechanism().rigid_links.iter();
    let links = links.map(|&link| Some(&robot.rigid_links[link]));
    let links = links.chain(std::iter::repeat(None));
    let rigid = structure.rigid_members.iter().zip(links);
    let rigid = rigid.map(|(member, link)| DrawnMember {
        nodes: [member.ends[0].node, member.ends[1].node],
        rotations_rad: [[0.0; 3]; 2],
        chain: link.map_or(&member.name[..], |link| &link.chain).to_owned(),
        kind: match link {
            // An arm without beams is rigid as a whole.
            Some(link) if link.is_added && !robot.members.is_empty() => DrawnKind::Added,
            _ => DrawnKind::Rigid,
        },
    });
    let place_of = |node: usize| {
        let name = &robot.nodes[node].name;
        structure.nodes.iter().position(|known| known.name == *name)
    };
    let joints = model.mechanism().joints(robot);
    let joints = joints.iter().filter_map(|&joint| {
        let node = place_of(robot.joints[joint].node)?;
        Some(DrawnJoint {
            node,
            slides: robot.joints[joint].motion == JointMotion::Slides,
        })
    });
    RobotDrawing {
        name: format!(
            "{}, mechanism {}, pose {pose}",
            robot.name,
            model.mechanism().name
        ),
        nodes: nodes.collect(),
        members: members.chain(rigid).collect(),
        supports: structure
            .supports
            .iter()
            .map(|support| support.node)
            .collect(),
        end: structure.end.node,
        joints: joints.collect(),
        axes: drawn_axes(robot),
        force_n: None,
    }
}

/// Draws all poses from the front too if one of them is deep: drawings of one robot have the same views.
pub fn with_equal_views(drawings: &mut [RobotDrawing]) {
    let is_deep = |drawing: &RobotDrawing| {
        let extent = |axis: usize| drawing.extent_m(axis);
        let [_, depth] = drawing.axes.across_and_depth();
        extent(depth) > DEEP * (0..3).map(extent).fold(0.0, f64::max)
    };
    let front = drawings.iter().any(is_deep);
    for drawing in drawings {
        drawing.axes.front = front;
    }
}

/// The axes of a robot with its own words for them.
pub(super) fn drawn_axes(robot: &Robot) -> DrawnAxes {
    let length = |axis: &usize| robot.vertical[*axis].abs();
    let up = (0..3).max_by(|a, b| length(a).total_cmp(&length(b)));
    DrawnAxes {
        names: [0, 1, 2].map(|axis| axis_name(robot, axis)),
        up: up.unwrap_or(1),
        front: false,
    }
}
