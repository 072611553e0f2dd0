//! Degrees of freedom: the paper's Table I, and the rank of the closure conditions as an independent count.

use stiffbench_beams::robot::{ChainMobility, Mobility, Robot, chain_mobility, mobility};
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::test_point::PoseId;

use crate::support::robots::shipped;

/// Cell of Table I of the paper.
fn table_i(chain: &str, quantity: &str) -> i64 {
    let path = stiffbench_test_files::repository().join("data/paper/tables.csv");
    let mut reader = csv::Reader::from_path(path).unwrap();
    let name = format!("chain {chain}");
    let row = reader
        .records()
        .map(Result::unwrap)
        .find(|row| &row[0] == "I" && row[1] == name && &row[5] == quantity);
    row.unwrap_or_else(|| panic!("{chain} {quantity}"))[7]
        .parse()
        .unwrap()
}

#[test]
fn table_i_of_the_paper() {
    for name in ["hp-robot", "hp-robot-host-dominant"] {
        let robot = shipped(name);
        let chains = chain_mobility(&robot, &robot.nominal_pose()).unwrap();
        let names: Vec<&str> = chains.iter().map(|chain| chain.chain.as_str()).collect();
        assert_eq!(names, ["A", "B", "C", "D", "E", "G", "F"]);
        for chain in &chains {
            let cell = |quantity| table_i(&chain.chain, quantity);
            let found = [
                chain.components as i64,
                chain.joints as i64,
                chain.overconstraints,
                chain.redundant_constraints as i64,
                chain.general_constraints as i64,
                chain.freedoms,
            ];
            let printed = [
                cell("n_components"),
                cell("g_joints"),
                cell("mu_overconstraints"),
                cell("nu_redundant_constraints"),
                cell("lambda_general_constraints"),
                cell("F_dof"),
            ];
            assert_eq!(found, printed, "{name}, chain {}", chain.chain);
            assert_eq!(chain.host, chain.chain == "A");
        }
        // Eq. (1): 3 + 0 + 0 + 0 + 0 + 1 + 0.
        assert_eq!(chains.iter().map(|chain| chain.freedoms).sum::<i64>(), 4);
    }
}

/// Rank of 6 equations a loop: all loops are planar, so each takes three freedoms.
///
/// The joints are those of the chains of a mechanism. In A to E the end link is held by a brake (A) or by chain B: three freedoms,
/// the fourth axis turns the gripper beyond F8 and is no joint of the file.
#[test]
fn rank_of_the_closure_conditions() {
    let robot = shipped("hp-robot");
    for (name, joints, loops, rank, freedoms) in [
        ("A", 3, 0, 0, 3),
        ("B", 9, 2, 6, 3),
        ("C", 12, 3, 9, 3),
        ("D", 15, 4, 12, 3),
        ("E", 24, 7, 21, 3),
        ("F", 37, 11, 33, 4),
    ] {
        let expected = Mobility {
            joints,
            loops,
            rank,
            freedoms,
        };
        let mechanism = robot.mechanism(Some(name)).unwrap();
        for pose in ["P1", "P2", "P3", "P4"] {
            let pose = robot.pose(&PoseId::new(pose)).unwrap();
            assert_eq!(
                mobility(&robot, mechanism, pose).unwrap(),
                expected,
                "{name}"
            );
        }
        assert_eq!(
            mobility(&robot, mechanism, &robot.nominal_pose()).unwrap(),
            expected
        );
    }
}

#[test]
fn a_serial_arm_has_a_freedom_a_joint() {
    let robot = shipped("serial-arm");
    let found = mobility(
        &robot,
        robot.mechanism(None).unwrap(),
        &robot.nominal_pose(),
    )
    .unwrap();
    assert_eq!((found.joints, found.loops, found.freedoms), (4, 0, 4));
}

/// Place and axis of a joint.
type PlacedJoint = ([f64; 3], [f64; 3]);

/// A ring of revolute joints with the given places and axes, as a robot file: body i between joint i and the next.
fn ring(joints: &[PlacedJoint]) -> Robot {
    let vector = |v: [f64; 3]| format!("[{:.17}, {:.17}, {:.17}]", v[0], v[1], v[2]);
    let mut lines =
        vec!["format = \"planar-linkage-robot/1\"\nname = \"ring\"\njoints = [".to_owned()];
    let count = joints.len();
    for i in 0..count {
        let before = (i + count - 1) % count;
        lines.push(format!(
            "  {{ id = \"J{i}\", node = \"N{i}\", bodies = [\"L{before}\", \"L{i}\"], chain = \"ring\", axis = \"X{i}\" }},"
        ));
    }
    lines.push("]\nelements = [{ id = \"E\", nodes = [\"N0\", \"N1\"], chain = \"ring\", class = \"beam\", section = \"s\", body = \"L0\", plane = \"X0\" }]".to_owned());
    for (i, (_, axis)) in joints.iter().enumerate() {
        lines.push(format!(
            "[planes.X{i}]\nbody = \"L0\"\nnormal = {}",
            vector(*axis)
        ));
        lines.push(format!("[[bodies]]\nid = \"L{i}\"\nchain = \"ring\""));
    }
    lines.push("[nodes]".to_owned());
    for (i, (place, _)) in joints.iter().enumerate() {
        lines.push(format!("N{i} = {{ on = \"L0\", at = {} }}", vector(*place)));
    }
    lines.push("[support]\nfixed = [\"N0\"]\n[end]\nnode = \"N1\"\n[materials.m]\nE = 1.0\nG = 1.0\n[sections.s]\nmaterial = \"m\"\nA = 1.0\nIy = 1.0\nIz = 1.0\nJ = 1.0\n[mechanisms.all]\nchains = [\"ring\"]".to_owned());
    Robot::parse(&SourceText::new("ring.toml", lines.join("\n"))).unwrap()
}

fn of_ring(joints: &[PlacedJoint]) -> (Mobility, ChainMobility) {
    let robot = ring(joints);
    let pose = robot.nominal_pose();
    let by_rank = mobility(&robot, robot.mechanism(None).unwrap(), &pose).unwrap();
    let mut by_count = chain_mobility(&robot, &pose).unwrap();
    assert_eq!(by_count.len(), 1);
    (by_rank, by_count.remove(0))
}

/// A planar four-bar: one freedom, three general constraints (Grübler: 3 (4 - 1) - 2·4 = 1).
#[test]
fn four_bar() {
    let z = [0.0, 0.0, 1.0];
    let joints = [[0.0, 0.0], [0.1, 0.3], [0.7, 0.5], [0.9, 0.0]].map(|[x, y]| ([x, y, 0.0], z));
    let (by_rank, by_count) = of_ring(&joints);
    assert_eq!((by_rank.loops, by_rank.rank, by_rank.freedoms), (1, 3, 1));
    assert_eq!((by_count.components, by_count.joints), (4, 4));
    assert_eq!(
        (by_count.general_constraints, by_count.overconstraints),
        (3, 3)
    );
    assert_eq!(by_count.freedoms, 1);
}

/// Axes of a Bennett ring at the crank angle `theta`, by Denavit and Hartenberg's steps Rz(θ) Tx(a) Rx(α); also the distance by
/// which the ring fails to close.
fn bennett(theta: f64) -> ([PlacedJoint; 4], f64) {
    // a/sin α = b/sin β, and tan(θ1/2) tan(θ2/2) = sin((β + α)/2)/sin((β - α)/2), θ3 = -θ1, θ4 = -θ2 (Bennett 1903).
    let (alpha, beta) = (0.5_f64, 1.1_f64);
    let (a, b) = (0.4, 0.4 * beta.sin() / alpha.sin());
    let ratio = (0.5 * (beta + alpha)).sin() / (0.5 * (beta - alpha)).sin();
    let second = 2.0 * (ratio / (0.5 * theta).tan()).atan();
    let steps = [
        (theta, a, alpha),
        (second, b, beta),
        (-theta, a, alpha),
        (-second, b, beta),
    ];
    let mut origin = [0.0; 3];
    let mut axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let mut joints = [([0.0; 3], [0.0; 3]); 4];
    let mix = |u: [f64; 3], v: [f64; 3], angle: f64| -> ([f64; 3], [f64; 3]) {
        let (sin, cos) = angle.sin_cos();
        (
            std::array::from_fn(|i| cos * u[i] + sin * v[i]),
            std::array::from_fn(|i| cos * v[i] - sin * u[i]),
        )
    };
    for (joint, (angle, length, twist)) in joints.iter_mut().zip(steps) {
        *joint = (origin, axes[2]);
        (axes[0], axes[1]) = mix(axes[0], axes[1], angle);
        origin = std::array::from_fn(|i| origin[i] + length * axes[0][i]);
        (axes[1], axes[2]) = mix(axes[1], axes[2], twist);
    }
    let open = origin
        .iter()
        .map(|c| c.abs())
        .fold((axes[2][2] - 1.0).abs(), f64::max);
    (joints, open)
}

/// Bennett's ring of four skew joints moves, though counting gives it -2 freedoms; any other ring of four does not.
#[test]
fn bennett_ring() {
    for theta in [0.6, 1.3, 2.2] {
        let (mut joints, open) = bennett(theta);
        assert!(
            open < 1e-12,
            "the ring of the test does not close: {open:e}"
        );
        let (by_rank, by_count) = of_ring(&joints);
        assert_eq!((by_rank.rank, by_rank.freedoms), (3, 1));
        assert_eq!((by_count.general_constraints, by_count.freedoms), (3, 1));
        joints[2].0[1] += 0.01;
        let (by_rank, _) = of_ring(&joints);
        assert_eq!((by_rank.rank, by_rank.freedoms), (4, 0));
    }
}

/// Rings in general position: six joints hold, seven move with one freedom.
#[test]
fn general_rings() {
    // Places and axes on a twisted curve, no two alike.
    let joint = |i: usize| {
        let t = 0.9 * i as f64;
        let place = [t.cos(), t.sin(), 0.3 * (2.3 * t).sin()];
        let axis = [
            (1.7 * t).sin(),
            0.4 + (0.8 * t).cos(),
            (2.9 * t + 1.0).cos(),
        ];
        (place, axis)
    };
    for (count, freedoms) in [(4, 0), (5, 0), (6, 0), (7, 1), (8, 2)] {
        let joints: Vec<_> = (0..count).map(joint).collect();
        let (by_rank, by_count) = of_ring(&joints);
        assert_eq!(by_rank.freedoms, freedoms, "{count} joints");
        if count >= 6 {
            assert_eq!(by_count.freedoms, freedoms as i64, "{count} joints");
        }
    }
}

/// Sarrus: two sets of three parallel joints, one freedom, rank five.
#[test]
fn sarrus_linkage() {
    let (x, y) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let joints = [
        ([0.0, 0.5, 0.0], x),
        ([0.0, 0.8, 0.4], x),
        ([0.0, 0.5, 0.8], x),
        ([0.5, 0.0, 0.8], y),
        ([0.8, 0.0, 0.4], y),
        ([0.5, 0.0, 0.0], y),
    ];
    let (by_rank, by_count) = of_ring(&joints);
    assert_eq!((by_rank.rank, by_rank.freedoms), (5, 1));
    assert_eq!((by_count.general_constraints, by_count.freedoms), (1, 1));
}
