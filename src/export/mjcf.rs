//! A robot in a pose for MuJoCo (MJCF): rigid bodies, springs, friction and play.

use crate::vector::subtract;

use super::inertia::Inertial;
use super::lumped::{LumpedBody, LumpedJoint, LumpedModel};
use super::xml::{Xml, number, numbers};

/// Time step, s.
const TIMESTEP_S: f64 = 1e-3;

/// Time in which every spring comes to rest by itself, s: ten steps. Each has an armature of its stiffness times the square of this, and the
/// damping that is critical with it. So the stiffest beam moves no faster than the time step can follow, and welds hold against all of it.
const RELAXATION_S: f64 = 10.0 * TIMESTEP_S;

/// Time constant of constraints, s: the shortest that MuJoCo takes is two steps.
const CONSTRAINT_S: f64 = 2.0 * TIMESTEP_S;

/// Impedance of constraints: the largest that MuJoCo takes.
const IMPEDANCE: &str = "0.9999 0.9999 0.001";

/// Armature of a joint without a spring, kg·m² or kg: no body that hangs on it need weigh anything.
const ARMATURE_OF_PIN: f64 = 1e-2;

/// Armature of a hinge that moves freely in its play, kg·m² or kg: the stop holds the better the more it is.
const ARMATURE_OF_PLAY: f64 = 1.0;

/// Time in which a play is crossed under its friction moment and as much again, s: a stop that is hit fast would knock other joints loose.
const CROSSING_S: f64 = 0.5;

/// The same where the play has no friction, N·m.
const LEAST_CROSSING_NM: f64 = 1.0;

/// The file.
///
/// # Arguments
/// - `gravity_m_per_s2`: acceleration of free fall.
/// - `comments`: at the beginning.
pub(super) fn mjcf(
    name: &str,
    gravity_m_per_s2: [f64; 3],
    model: &LumpedModel,
    comments: &[String],
) -> String {
    let mut xml = Xml::new(comments);
    xml.open("mujoco", &[("model", name.to_owned())]);
    let words = [("angle", "radian"), ("autolimits", "true")];
    xml.empty("compiler", &words.map(|(key, word)| (key, word.to_owned())));
    xml.empty(
        "option",
        &[
            ("timestep", number(TIMESTEP_S)),
            ("integrator", "implicitfast".to_owned()),
            ("gravity", numbers(gravity_m_per_s2)),
        ],
    );
    let constraint = numbers([CONSTRAINT_S, 1.0]);
    xml.open("default", &[]);
    xml.empty(
        "joint",
        &[
            ("solreflimit", constraint.clone()),
            ("solimplimit", IMPEDANCE.to_owned()),
            ("solreffriction", constraint.clone()),
            ("solimpfriction", IMPEDANCE.to_owned()),
        ],
    );
    let none = ["contype", "conaffinity", "mass"].map(|key| (key, "0".to_owned()));
    xml.empty("geom", &none);
    let weld = [("solref", constraint), ("solimp", IMPEDANCE.to_owned())];
    xml.empty("equality", &weld);
    xml.close();
    xml.open("worldbody", &[]);
    write_bodies(&mut xml, model);
    xml.close();
    if !model.welds.is_empty() {
        xml.open("equality", &[]);
        for weld in &model.welds {
            let [first, second] = weld.bodies.map(|body| model.bodies[body].name.clone());
            xml.empty(
                "weld",
                &[
                    ("name", format!("weld.{}", weld.member)),
                    ("body1", first),
                    ("body2", second),
                ],
            );
        }
        xml.close();
    }
    xml.finish()
}

/// The bodies, each inside the one it hangs on.
fn write_bodies(xml: &mut Xml, model: &LumpedModel) {
    let mut children = vec![Vec::new(); model.bodies.len()];
    let mut next = Vec::new();
    for (number, body) in model.bodies.iter().enumerate().rev() {
        let with_it = body
            .parent
            .map_or(&mut next, |parent| &mut children[parent]);
        with_it.push(Some(number));
    }
    // `None` ends a body.
    while let Some(step) = next.pop() {
        let Some(number) = step else {
            xml.close();
            continue;
        };
        begin_body(xml, model, number);
        next.push(None);
        next.append(&mut children[number]);
    }
}

fn begin_body(xml: &mut Xml, model: &LumpedModel, place: usize) {
    let body = &model.bodies[place];
    let origin = body
        .parent
        .map_or([0.0; 3], |parent| model.bodies[parent].position_m);
    xml.open(
        "body",
        &[
            ("name", body.name.clone()),
            ("pos", numbers(subtract(body.position_m, origin))),
        ],
    );
    write_inertia(xml, body);
    for joint in &body.joints {
        write_joint(xml, body, joint);
    }
    for rod in &body.rods {
        let ends = rod.ends_m.map(|end| subtract(end, body.position_m));
        xml.empty(
            "geom",
            &[
                ("type", "capsule".to_owned()),
                ("fromto", numbers(ends.concat())),
                ("size", number(rod.radius_m)),
            ],
        );
    }
    if model.end == place {
        let at = subtract(model.end_m, body.position_m);
        xml.empty("site", &[("name", "end".to_owned()), ("pos", numbers(at))]);
    }
}

fn write_inertia(xml: &mut Xml, body: &LumpedBody) {
    let inertial = Inertial::stated(xml, &body.inertia, body.position_m);
    let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = inertial.about_kg_m2;
    xml.empty(
        "inertial",
        &[
            ("pos", numbers(inertial.centre_m)),
            ("mass", number(inertial.mass_kg)),
            ("fullinertia", numbers([xx, yy, zz, xy, xz, yz])),
        ],
    );
}

fn write_joint(xml: &mut Xml, body: &LumpedBody, joint: &LumpedJoint) {
    let kind = if joint.slides { "slide" } else { "hinge" };
    let mut attributes = vec![
        ("name", joint.name.clone()),
        ("type", kind.to_owned()),
        ("pos", numbers(subtract(joint.position_m, body.position_m))),
        ("axis", numbers(joint.axis)),
    ];
    if let Some(stiffness) = joint.stiffness {
        attributes.push(("stiffness", number(stiffness)));
        attributes.push(("damping", number(2.0 * RELAXATION_S * stiffness)));
        attributes.push(("armature", number(RELAXATION_S.powi(2) * stiffness)));
    }
    if joint.friction > 0.0 {
        attributes.push(("frictionloss", number(joint.friction)));
    }
    if let Some(play) = joint.play {
        attributes.push(("range", numbers([-play, play])));
        // MuJoCo's chapter on modelling, "Backlash": what moves without a spring needs some inertia of its own.
        attributes.push(("armature", number(ARMATURE_OF_PLAY)));
        let crossing_nm = joint.friction.max(LEAST_CROSSING_NM);
        attributes.push(("damping", number(CROSSING_S * crossing_nm / play)));
    } else if joint.stiffness.is_none() {
        attributes.push(("armature", number(ARMATURE_OF_PIN)));
    }
    xml.empty("joint", &attributes);
}
