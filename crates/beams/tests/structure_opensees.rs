//! End compliance, node positions, forces and reactions against OpenSees, on the shipped robots.
//!
//! The numbers in `fixtures/opensees` were made by `fixtures/opensees/generate.py`, those of random robots by `tests/opensees/check.py`. Both
//! read the robot files with their own reader, their own kinematics and OpenSees' elements.

#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test stops at the first thing that is not as it must be"
)]

use std::collections::BTreeMap;

use stiffbench_beams::robot::{
    FittingFactors, JointModel, MultiPosePredictor, Predictor, Robot, Theory,
};
use stiffbench_numeric::vector::norm;
use stiffbench_test_files::text;

use crate::support::robots;
use crate::support::rows::{Row, compliance_of, number, numbers, pose_of, rows};
use stiffbench_units_and_text::source_text::SourceText;

/// The shipped robots under the names the fixtures use.
const ROBOTS: [(&str, &str); 2] = [("host-parasite", "hp-robot"), ("serial-arm", "serial-arm")];

/// Largest relative difference of our compliance to a row's, one pose at a time and several together, by mechanism; asserts each row
/// against its bound.
fn compare(
    file: &str,
    theory: Theory,
    joints: impl Fn(&Row, &Robot) -> JointModel,
    bound: impl Fn(&Row) -> f64,
) -> usize {
    let robots: BTreeMap<String, Robot> = ROBOTS
        .into_iter()
        .map(|(fixture, shipped)| (fixture.to_owned(), robots::shipped(shipped)))
        .collect();
    let mut worst: BTreeMap<String, f64> = BTreeMap::new();
    let rows = rows(file);
    for row in &rows {
        let robot = &robots[&row["robot"]];
        let mechanism = robot.mechanism(Some(&row["mechanism"])).unwrap();
        let factors = robot
            .factor_set(&row["factors"])
            .or_else(|_| robots["host-parasite"].factor_set(&row["factors"]))
            .unwrap();
        let mut predictor =
            Predictor::with(robot, mechanism, &joints(row, robot), theory, &factors).unwrap();
        predictor.place(&pose_of(row, robot)).unwrap();
        let mut together =
            MultiPosePredictor::with(robot, mechanism, &joints(row, robot), theory, &[], 1)
                .unwrap();
        together.place(0, &pose_of(row, robot)).unwrap();
        together.solve(&factors, false).unwrap();
        let expected = compliance_of(row);
        let difference = predictor.compliance().relative_difference(&expected).max(
            together
                .compliance(0)
                .unwrap()
                .relative_difference(&expected),
        );
        let key = format!("{} {} {}", row["robot"], row["mechanism"], row["factors"]);
        let entry = worst.entry(key).or_default();
        *entry = entry.max(difference);
        assert!(
            difference < bound(row),
            "{} {} {}: {difference:e}",
            row["mechanism"],
            row["factors"],
            row["pose"]
        );
    }
    println!(
        "{file}: {} rows, largest relative difference {worst:#?}",
        rows.len()
    );
    rows.len()
}

#[test]
fn end_compliance_of_all_mechanisms() {
    // 1e-8 of the root of the product of the diagonal entries: OpenSees itself keeps 2.3e-10 here (agreement.csv).
    let count = compare(
        "opensees/compliance.csv",
        Theory::EulerBernoulli,
        |_, _| JointModel::Rigid,
        |_| 1e-8,
    );
    assert!(count >= 6 * 12, "{count} rows");
}

#[test]
fn timoshenko_beams() {
    let count = compare(
        "opensees/timoshenko.csv",
        Theory::Timoshenko,
        |_, _| JointModel::Rigid,
        |_| 1e-8,
    );
    assert!(count >= 18, "{count} rows");
}

/// Hinges, slides, rows of Denavit and Hartenberg, beams and rigid links, with springs everywhere.
#[test]
fn random_robots() {
    let rows = rows("opensees/random_robots.csv");
    for row in &rows {
        let file = format!("fixtures/cases/random-robots/{}.toml", row["robot"]);
        let robot = Robot::parse(&SourceText::new(&*file, text(&file))).unwrap();
        let theory = match row["theory"].as_str() {
            "timoshenko" => Theory::Timoshenko,
            _ => Theory::EulerBernoulli,
        };
        let (mechanism, unit) = (robot.mechanism(None).unwrap(), FittingFactors::UNIT);
        let mut predictor =
            Predictor::with(&robot, mechanism, &JointModel::Rigid, theory, &unit).unwrap();
        predictor.place(&robot.poses[0].pose).unwrap();
        // Rigid joints of OpenSees are stiff springs here: they leave 3e-8 (tests/opensees/check.py).
        let difference = predictor
            .compliance()
            .relative_difference(&compliance_of(row));
        assert!(difference < 1e-6, "{file}: compliance {difference:e}");
        let (solver, model) = predictor.parts();
        let mass = model.mass_kg() / number(row, "mass_kg");
        assert!((mass - 1.0).abs() < 1e-12, "{file}: {mass}");
        // The sag there is that of beams without shear.
        if theory == Theory::EulerBernoulli {
            let found = solver.end_displacement(&model.weight());
            for keys in [["ux", "uy", "uz"], ["rx", "ry", "rz"]] {
                let first = usize::from(keys[0] == "rx") * 3;
                let expected = keys.map(|key| number(row, &format!("sag_{key}")));
                let apart = norm([0, 1, 2].map(|i| found[first + i] - expected[i]));
                assert!(apart < 1e-6 * norm(expected), "{file}: sag {found:?}");
            }
        }
    }
    assert_eq!(rows.len(), 6);
}

#[test]
fn released_joints() {
    let joints = |row: &Row, robot: &Robot| {
        let index = |name: &str| {
            robot
                .joints
                .iter()
                .position(|joint| joint.name == name)
                .unwrap()
        };
        JointModel::Hinged(
            row["released"]
                .split(' ')
                .map(|name| (index(name), 0.0))
                .collect(),
        )
    };
    // With every passive joint released the structure hangs on its soft members alone and double precision itself keeps only
    // 7e-8, its own solvers scattering to 1.6e-7 (README.md there): the bound is three times that.
    let bound = |row: &Row| {
        if row["released"].split(' ').count() > 2 {
            2e-7
        } else {
            1e-8
        }
    };
    let count = compare("opensees/pinned.csv", Theory::EulerBernoulli, joints, bound);
    assert!(count >= 30, "{count} rows");
}

#[test]
fn node_positions() {
    let mut checked = 0;
    for (fixture, shipped) in ROBOTS {
        let robot = robots::shipped(shipped);
        let mechanism = robot.mechanism(None).unwrap();
        let mut predictor = Predictor::new(&robot, mechanism, &robot.default_factors().1).unwrap();
        for row in rows("opensees/nodes.csv")
            .iter()
            .filter(|row| row["robot"] == fixture)
        {
            predictor.place(&pose_of(row, &robot)).unwrap();
            let node = predictor
                .model()
                .structure()
                .nodes
                .iter()
                .find(|node| *node.name == row["node"]);
            let Some(node) = node else { continue };
            for (found, key) in node.position_m.into_iter().zip(["x_m", "y_m", "z_m"]) {
                assert!(
                    (found - number(row, key)).abs() < 1e-12,
                    "{} {} {key}",
                    row["pose"],
                    row["node"]
                );
            }
            checked += 1;
        }
    }
    assert!(checked > 500, "{checked} nodes");
}

#[test]
fn reactions_and_end_forces() {
    let robot = robots::shipped("hp-robot");
    let mechanism = robot.mechanism(Some("F")).unwrap();
    let mut predictor =
        Predictor::new(&robot, mechanism, &robot.factor_set("m_fsd").unwrap()).unwrap();
    let mut checked = 0;
    for row in rows("opensees/forces.csv") {
        predictor.place(&pose_of(&row, &robot)).unwrap();
        let mut load = [0.0; 6];
        load[["Fx", "Fy", "Fz"]
            .iter()
            .position(|l| *l == row["load"])
            .unwrap()] = 1.0;
        let (solver, model) = predictor.parts();
        let structure = model.structure();
        let loads = [(structure.end.clone(), load)];
        let response = solver.respond(structure, &loads);
        let keys = ["Fx", "Fy", "Fz", "Mx", "My", "Mz"];
        let expected = numbers(&row, keys);
        let found = match (row["kind"].as_str(), row["axes"].as_str()) {
            ("reaction", _) => {
                let place = structure
                    .supports
                    .iter()
                    .position(|s| *structure.nodes[s.node].name == row["node"])
                    .unwrap();
                response.reactions[place]
            }
            ("element_end", "local") => {
                let place = model
                    .members()
                    .position(|member| member.name == row["id"])
                    .unwrap();
                let forces = response.elements[place];
                let first = robot.nodes[mechanism_node(&robot, &row["id"], 0)]
                    .name
                    .as_ref()
                    == row["node"];
                if first { forces.first } else { forces.second }
            }
            _ => continue,
        };
        for (a, b) in found.iter().zip(expected) {
            // A unit load and lever arms of metres: forces and moments are of order one; OpenSees balances to 1e-9.
            assert!((a - b).abs() < 1e-7, "{row:?}: {found:?}");
        }
        checked += 1;
    }
    assert!(checked > 200, "{checked} rows");
}

fn mechanism_node(robot: &Robot, element: &str, end: usize) -> usize {
    robot
        .members
        .iter()
        .find(|member| member.name == element)
        .unwrap()
        .nodes[end]
}
