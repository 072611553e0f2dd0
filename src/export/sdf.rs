//! A robot for Gazebo and others (SDF 1.11): links, joints with springs and friction, loops.

use crate::robot::JointMotion;
use crate::vector::subtract;

use super::inertia::Inertial;
use super::kinematics::{KinematicJoint, KinematicLink, KinematicTree};
use super::urdf::{along, upright};
use super::xml::{Xml, number, numbers};

/// The frame that the ground is fixed to.
const WORLD: &str = "world";

/// The limit that SDF gives an axis without one, rad or m.
const UNLIMITED: f64 = 1e16;

/// The file.
pub(super) fn sdf(
    name: &str,
    vertical: [f64; 3],
    tree: &KinematicTree,
    comments: &[String],
) -> String {
    let mut xml = Xml::new(comments);
    xml.open("sdf", &[("version", "1.11".to_owned())]);
    xml.open("world", &[("name", "robot".to_owned())]);
    xml.open("model", &[("name", name.to_owned())]);
    let [roll, pitch] = upright(vertical);
    xml.text("pose", numbers([0.0, 0.0, 0.0, roll, pitch, 0.0]));
    for (place, link) in tree.links.iter().enumerate() {
        write_link(&mut xml, &tree.link_name(place, &[WORLD]), link);
    }
    let on = &tree.links[tree.end];
    let link_of_end = tree.link_name(tree.end, &[WORLD]);
    let frame = [("name", "end".to_owned()), ("attached_to", link_of_end)];
    xml.open("frame", &frame);
    pose(&mut xml, subtract(tree.end_m, on.position_m), [0.0; 3]);
    xml.close();
    let joints = tree.links.iter().filter_map(|link| link.joint.as_ref());
    for joint in joints.chain(&tree.cut) {
        write_joint(&mut xml, tree, joint);
    }
    xml.close();
    // Outside the model, where PyBullet, which knows no parent of this name, passes it over.
    xml.open_joint("ground.fixed", "fixed");
    xml.text("parent", WORLD);
    xml.text("child", format!("{name}::{}", tree.link_name(0, &[WORLD])));
    xml.finish()
}

fn pose(xml: &mut Xml, xyz: [f64; 3], rpy: [f64; 3]) {
    xml.text("pose", numbers(xyz.into_iter().chain(rpy)));
}

fn write_link(xml: &mut Xml, name: &str, link: &KinematicLink) {
    xml.open("link", &[("name", name.to_owned())]);
    pose(xml, link.position_m, [0.0; 3]);
    let inertial = Inertial::stated(xml, &link.inertia, link.position_m);
    xml.open("inertial", &[]);
    pose(xml, inertial.centre_m, [0.0; 3]);
    xml.text("mass", number(inertial.mass_kg));
    xml.open("inertia", &[]);
    for (name, moment) in inertial.moments() {
        xml.text(name, number(moment));
    }
    xml.close();
    xml.close();
    for (place, rod) in link.rods.iter().enumerate() {
        let (rpy, middle_m, length_m) = along(rod.ends_m);
        xml.open("visual", &[("name", format!("rod{}", place + 1))]);
        pose(xml, subtract(middle_m, link.position_m), rpy);
        xml.open("geometry", &[]);
        xml.open("cylinder", &[]);
        xml.text("radius", number(rod.radius_m));
        xml.text("length", number(length_m));
        xml.close();
        xml.close();
        xml.close();
    }
    xml.close();
}

fn write_joint(xml: &mut Xml, tree: &KinematicTree, joint: &KinematicJoint) {
    let kind = match joint.motion {
        None => "fixed",
        Some(JointMotion::Turns) => "revolute",
        Some(JointMotion::Slides) => "prismatic",
    };
    xml.open_joint(&joint.name, kind);
    let [parent, child] = joint.links.map(|place| tree.link_name(place, &[WORLD]));
    xml.text("parent", parent);
    xml.text("child", child);
    pose(
        xml,
        subtract(joint.position_m, tree.links[joint.links[1]].position_m),
        [0.0; 3],
    );
    if joint.motion.is_some() {
        xml.open("axis", &[]);
        xml.text("xyz", numbers(joint.axis));
        // PyBullet takes no axis without limits.
        let [low, high] = joint.limits.unwrap_or([-UNLIMITED, UNLIMITED]);
        xml.open("limit", &[]);
        xml.text("lower", number(low));
        xml.text("upper", number(high));
        xml.close();
        xml.open("dynamics", &[]);
        xml.text("damping", 0);
        xml.text("friction", number(joint.friction));
        xml.text("spring_reference", 0);
        xml.text("spring_stiffness", number(joint.stiffness.unwrap_or(0.0)));
        xml.close();
        xml.close();
    }
    xml.close();
}
