//! A robot for ROS and others (URDF): links, joints, friction.

use crate::robot::JointMotion;
use crate::vector::subtract;

use super::inertia::{Inertia, Inertial};
use super::kinematics::{KinematicJoint, KinematicLink, KinematicTree};
use super::xml::{Xml, number, numbers};

/// Link that the ground stands on, its z axis up.
const WORLD: &str = "world";

/// Link at the end of the robot.
const END: &str = "end";

/// Limit of a sliding joint of which none is known, m.
const SLIDE_M: f64 = 1.0;

/// The file.
pub(super) fn urdf(
    name: &str,
    vertical: [f64; 3],
    tree: &KinematicTree,
    comments: &[String],
) -> String {
    let mut xml = Xml::new(comments);
    xml.open("robot", &[("name", name.to_owned())]);
    xml.empty("link", &[("name", WORLD.to_owned())]);
    for (place, link) in tree.links.iter().enumerate() {
        write_link(&mut xml, &tree.link_name(place, &[WORLD, END]), link);
    }
    xml.open("link", &[("name", END.to_owned())]);
    write_inertial(&mut xml, &Inertia::default(), [0.0; 3]);
    xml.close();
    let [roll, pitch] = upright(vertical);
    fixed(
        &mut xml,
        "up",
        [WORLD, &tree.link_name(0, &[WORLD, END])],
        [0.0; 3],
        [roll, pitch, 0.0],
    );
    for link in &tree.links {
        if let Some(joint) = &link.joint {
            write_joint(&mut xml, tree, joint, link);
        }
    }
    let on = &tree.links[tree.end];
    let at = subtract(tree.end_m, on.position_m);
    fixed(
        &mut xml,
        "end",
        [&tree.link_name(tree.end, &[WORLD, END]), END],
        at,
        [0.0; 3],
    );
    xml.finish()
}

/// Roll and pitch, rad, that turn a unit vector to z.
pub(super) fn upright([x, y, z]: [f64; 3]) -> [f64; 2] {
    [y.atan2(z), (-x).atan2(y.hypot(z))]
}

/// Roll, pitch and yaw, rad, that turn z to the direction of a rod; its middle, m, and length, m.
pub(super) fn along([a, b]: [[f64; 3]; 2]) -> ([f64; 3], [f64; 3], f64) {
    let [x, y, z] = subtract(b, a);
    let across = x.hypot(y);
    let middle = [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]));
    ([0.0, across.atan2(z), y.atan2(x)], middle, across.hypot(z))
}

fn origin(xml: &mut Xml, xyz: [f64; 3], rpy: [f64; 3]) {
    xml.empty("origin", &[("xyz", numbers(xyz)), ("rpy", numbers(rpy))]);
}

fn fixed(xml: &mut Xml, name: &str, [parent, child]: [&str; 2], at: [f64; 3], rpy: [f64; 3]) {
    xml.open_joint(&format!("{name}.fixed"), "fixed");
    xml.empty("parent", &[("link", parent.to_owned())]);
    xml.empty("child", &[("link", child.to_owned())]);
    origin(xml, at, rpy);
    xml.close();
}

fn write_link(xml: &mut Xml, name: &str, link: &KinematicLink) {
    xml.open("link", &[("name", name.to_owned())]);
    write_inertial(xml, &link.inertia, link.position_m);
    for rod in &link.rods {
        let (rpy, middle_m, length_m) = along(rod.ends_m);
        xml.open("visual", &[]);
        origin(xml, subtract(middle_m, link.position_m), rpy);
        xml.open("geometry", &[]);
        xml.empty(
            "cylinder",
            &[
                ("length", number(length_m)),
                ("radius", number(rod.radius_m)),
            ],
        );
        xml.close();
        xml.close();
    }
    xml.close();
}

fn write_inertial(xml: &mut Xml, inertia: &Inertia, origin_m: [f64; 3]) {
    let inertial = Inertial::stated(xml, inertia, origin_m);
    xml.open("inertial", &[]);
    origin(xml, inertial.centre_m, [0.0; 3]);
    xml.empty("mass", &[("value", number(inertial.mass_kg))]);
    let moments = inertial.moments();
    xml.empty(
        "inertia",
        &moments.map(|(name, moment)| (name, number(moment))),
    );
    xml.close();
}

fn write_joint(xml: &mut Xml, tree: &KinematicTree, joint: &KinematicJoint, link: &KinematicLink) {
    let [parent, child] = joint.links;
    let at = subtract(link.position_m, tree.links[parent].position_m);
    let names = [parent, child].map(|place| tree.link_name(place, &[WORLD, END]));
    let Some(motion) = joint.motion else {
        return fixed(xml, &joint.name, [&names[0], &names[1]], at, [0.0; 3]);
    };
    let (kind, limits) = match (motion, joint.limits) {
        (JointMotion::Turns, None) => ("continuous", None),
        (JointMotion::Turns, Some(limits)) => ("revolute", Some(limits)),
        (JointMotion::Slides, limits) => ("prismatic", Some(limits.unwrap_or([-SLIDE_M, SLIDE_M]))),
    };
    xml.open_joint(&joint.name, kind);
    if let Some(stiffness) = joint.stiffness {
        let unit = if motion == JointMotion::Turns {
            "N*m/rad"
        } else {
            "N/m"
        };
        xml.comment(&format!("stiffness {} {unit}", number(stiffness)));
    }
    xml.empty("parent", &[("link", names[0].clone())]);
    xml.empty("child", &[("link", names[1].clone())]);
    origin(xml, at, [0.0; 3]);
    xml.empty("axis", &[("xyz", numbers(joint.axis))]);
    if let Some([low, high]) = limits {
        let none = || number(0.0);
        let ends = [("lower", number(low)), ("upper", number(high))];
        xml.empty(
            "limit",
            &[&ends[..], &[("effort", none()), ("velocity", none())]].concat(),
        );
    }
    if joint.friction > 0.0 {
        xml.empty("dynamics", &[("friction", number(joint.friction))]);
    }
    xml.close();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::norm;

    /// The matrix of roll, pitch and yaw, as URDF defines it.
    fn matrix([r, p, y]: [f64; 3]) -> [[f64; 3]; 3] {
        let [(sr, cr), (sp, cp), (sy, cy)] = [r.sin_cos(), p.sin_cos(), y.sin_cos()];
        [
            [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
            [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
            [-sp, cp * sr, cp * cr],
        ]
    }

    fn times(m: [[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
        m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
    }

    #[test]
    fn any_vertical_is_turned_to_z_and_any_rod_is_reached() {
        for v in [
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [1.0, 0.0, 0.0],
            [-0.6, 0.0, 0.8],
            [0.48, -0.6, 0.64],
            [0.0, 0.0, -1.0],
        ] {
            let [roll, pitch] = upright(v);
            let up = times(matrix([roll, pitch, 0.0]), v);
            assert!(norm(subtract(up, [0.0, 0.0, 1.0])) < 1e-15, "{v:?} {up:?}");
            let (rpy, _, length) = along([[0.0; 3], v]);
            let rod = times(matrix(rpy), [0.0, 0.0, length]);
            assert!(norm(subtract(rod, v)) < 1e-15, "{v:?} {rod:?}");
        }
    }
}
