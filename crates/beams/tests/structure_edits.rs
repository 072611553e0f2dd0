//! Mistakes of a robot file, put right by an effect: the same structure as from a file that is right.

use stiffbench_beams::physics::{Effect, FileSuspects, Mechanics, Place, StructureEdit, laws};
use stiffbench_beams::robot::{FittingFactors, Pose, Robot};
use stiffbench_beams::structure::Compliance6;
use stiffbench_test_files::shipped_robot;
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::test_point::PoseId;

use crate::support::robots::{named_poses, shipped};

/// Compliances of the end in the named poses of a robot, m/N.
fn compliances(robot: &Robot, factors: &FittingFactors, poses: &[Pose]) -> Vec<[[f64; 3]; 3]> {
    let mechanism = robot.mechanism(None).unwrap();
    let mechanics = Mechanics::rigid(robot, mechanism, factors, poses).unwrap();
    (0..poses.len())
        .map(|pose| Compliance6(mechanics.pose(pose).influence.compliance).translation())
        .collect()
}

/// Largest difference between an effect and the text of a robot file with a number replaced, relative to the largest compliance.
fn difference(name: &str, effect: &str, from: &str, to: &str) -> f64 {
    let source = shipped_robot(name).unwrap();
    let robot = Robot::parse(&source).unwrap();
    assert_eq!(source.text.matches(from).count(), 1, "{from}");
    let changed = SourceText::new("changed", source.text.replace(from, to));
    let right = Robot::parse(&changed).unwrap();
    let mechanism = robot.mechanism(None).unwrap();
    let ids: Vec<PoseId> = robot.poses.iter().map(|named| named.id.clone()).collect();
    let suspects = FileSuspects::new(&robot, mechanism, &ids, &[]);
    let effect: Effect = effect.parse().unwrap();
    assert!(
        suspects
            .places()
            .contains(&(effect.law, effect.place.clone())),
        "{effect} is not among {:?}",
        suspects.places()
    );
    let edit = StructureEdit::new(&robot, mechanism, &suspects, &[effect]).unwrap();
    let poses: Vec<Pose> = robot
        .poses
        .iter()
        .map(|named| edit.pose(&robot, &named.id, &named.pose))
        .collect();
    let (_, factors) = robot.default_factors();
    let (_, right_factors) = right.default_factors();
    let found = compliances(&edit.robot(&robot), &edit.factors(&factors), &poses);
    let expected = compliances(&right, &right_factors, &named_poses(&right));
    let before = compliances(&robot, &factors, &named_poses(&robot));
    let all = |poses: &[[[f64; 3]; 3]]| {
        poses
            .iter()
            .flatten()
            .flatten()
            .copied()
            .collect::<Vec<_>>()
    };
    let (found, expected, before) = (all(&found), all(&expected), all(&before));
    let most = |a: &[f64], b: &[f64]| {
        let pairs = a.iter().zip(b);
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    };
    let largest = expected.iter().copied().fold(0.0, f64::max);
    // The number matters.
    assert!(most(&before, &expected) > 1e-4 * largest, "{from} -> {to}");
    most(&found, &expected) / largest
}

/// Rounding of lengths that were found by a difference of one millimetre.
const ROUNDING: f64 = 1e-9;

#[test]
fn an_effect_on_the_file_is_the_file_with_another_number() {
    #[rustfmt::skip]
    let cases = [
        ("hp-robot", "link-length@upper_arm.l_A3A4:length=15mm", "l_A3A4 = 0.776", "l_A3A4 = 0.791"),
        ("hp-robot", "link-length@waist.l_A2A3:length=-20mm", "l_A2A3 = 0.585", "l_A2A3 = 0.565"),
        ("hp-robot", "link-length@crank_C.l_C:length=8mm", "l_C = 0.153", "l_C = 0.161"),
        ("serial-arm", "link-length@arm2.l2:length=12mm", "l2 = 0.48", "l2 = 0.492"),
        ("four-bar", "link-length@crank.points.B.at_mm.1:length=5mm", "[0, 120, 0]", "[0, 125, 0]"),
        ("fanuc-r2000ic", "link-length@J2.joints.J3.a_mm:length=10mm", "a_mm = 1075", "a_mm = 1085"),
        // A quarter of a section is no mistake of the whole section: all four constants change.
        ("serial-arm", "section-error@E78:share=30%", "A = 4.0e-4\nIy = 1.75e-08\nIz = 1.75e-08\nJ = 3.15e-08", "A = 5.2e-4\nIy = 2.275e-08\nIz = 2.275e-08\nJ = 4.095e-08"),
        ("serial-arm", "joint-offset@S3/P1:angle=1deg", "theta3 = -30.000", "theta3 = -29.000"),
        ("serial-arm", "factor-group@beam.Iy:share=50%", "Iy = 0.7,", "Iy = 1.05,"),
    ];
    for (robot, effect, from, to) in cases {
        let found = difference(robot, effect, from, to);
        assert!(found < ROUNDING, "{effect}: {found:e}");
    }
}

#[test]
fn an_offset_of_a_joint_is_the_same_in_all_poses() {
    let robot = shipped("serial-arm");
    let mechanism = robot.mechanism(None).unwrap();
    let suspects = FileSuspects::new(&robot, mechanism, &[], &[]);
    let effect: Effect = "joint-offset@S3:angle=2deg".parse().unwrap();
    let edit = StructureEdit::new(&robot, mechanism, &suspects, &[effect]).unwrap();
    let turned = edit.robot(&robot);
    let (_, factors) = robot.default_factors();
    let theta3 = robot
        .variables
        .iter()
        .position(|v| v.name == "theta3")
        .unwrap();
    for named in &robot.poses {
        let mut pose = named.pose.clone();
        pose.angles_deg[theta3] += 2.0;
        let found = compliances(&turned, &factors, std::slice::from_ref(&named.pose));
        let expected = compliances(&robot, &factors, &[pose]);
        for (found, expected) in found
            .iter()
            .flatten()
            .flatten()
            .zip(expected.iter().flatten().flatten())
        {
            assert!((found - expected).abs() < 1e-15, "{found:e} {expected:e}");
        }
    }
}

#[test]
fn what_is_not_in_the_file_is_refused() {
    let robot = shipped("serial-arm");
    let mechanism = robot.mechanism(None).unwrap();
    let suspects = FileSuspects::new(&robot, mechanism, &[], &[]);
    for effect in [
        "link-length@arm1.l9:length=1mm",
        "joint-offset@S9:angle=1deg",
        "section-error@E99:share=10%",
    ] {
        let effect: Effect = effect.parse().unwrap();
        let refused = StructureEdit::new(&robot, mechanism, &suspects, &[effect]);
        assert!(refused.is_err(), "{refused:?}");
    }
    let lengths = suspects
        .places()
        .iter()
        .filter(|(law, _)| *law == laws::LINK_LENGTH);
    let bodies: Vec<&str> = lengths
        .filter_map(|(_, place)| match place {
            Place::Length { body, .. } => Some(body.as_str()),
            _ => None,
        })
        .collect();
    for body in ["post", "arm1", "arm2", "hand"] {
        assert!(bodies.contains(&body), "{bodies:?}");
    }
}
