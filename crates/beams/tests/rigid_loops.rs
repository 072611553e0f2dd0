//! Loops of rigid links with springs in their joints: against virtual work, stiff beams and differences.

use stiffbench_beams::robot::{
    FittingFactors, Keep, ModelParameter, MultiPosePredictor, PoseSweep, Predictor, Robot,
    RobotError,
};
use stiffbench_beams::structure::{
    Compliance6, RigidMember, Solver, Structure, StructureError, Support,
};
use stiffbench_units_and_text::source_text::SourceText;

use crate::support::arms::{derivatives, spring};
use crate::support::robots::{assert_differences, at_values};
use crate::support::{behind, hinge, node};

/// Spring constants about the four joints of a four-bar linkage, N·m/rad; `None` is a pin.
type Springs = [Option<f64>; 4];

/// A four-bar linkage about x: ground points A and D, crank to B, rocker to C; the tool is on the coupler. The links are of a section, or
/// rigid.
fn four_bar(springs: Springs, section: Option<&str>) -> Robot {
    let [a, b, c, d] = springs.map(|spring| match spring {
        Some(k) => format!("spring = \"free\", stiffness_Nm_per_rad = {k}"),
        None => "spring = \"pinned\"".to_owned(),
    });
    let links = section.map_or(String::new(), |section| {
        let pairs = [
            ["base", "A"],
            ["A", "B"],
            ["D", "C"],
            ["B", "C"],
            ["B", "tool"],
            ["C", "tool"],
        ];
        let line = |(place, [from, to]): (usize, &[&str; 2])| {
            format!("l{place} = {{ between = [\"{from}\", \"{to}\"], section = \"{section}\" }}\n")
        };
        let lines: String = pairs.iter().enumerate().map(line).collect();
        format!("[links]\n{lines}")
    });
    let text = format!(
        "schema = \"stiffbench/robot/2\"\nname = \"four-bar\"\nup = \"z\"\n\
         [planes.side]\nnormal = \"x\"\n\
         [joints]\n\
         A = {{ body = \"crank\", at_mm = [0, 0, 200], axis = \"x\", min_deg = 0, max_deg = 360, nominal_deg = 60, {a} }}\n\
         JB = {{ point = \"B\", on = \"crank\", body = \"coupler\", plane = \"side\", {b} }}\n\
         JC = {{ point = \"C\", on = \"coupler\", body = \"rocker\", plane = \"side\", {c} }}\n\
         JD = {{ point = \"D\", on = \"base\", body = \"rocker\", plane = \"side\", {d} }}\n\
         [points]\n\
         B = {{ on = \"crank\", at_mm = [0, 120, 0] }}\n\
         D = {{ on = \"base\", at_mm = [0, 350, 200] }}\n\
         C = {{ centres = [\"B\", \"D\"], radii_mm = [350, 250], plane = \"side\", side = 1 }}\n\
         [bodies]\n\
         coupler = {{ along = [\"B\", \"C\"], plane = \"side\" }}\n\
         rocker = {{ along = [\"D\", \"C\"], plane = \"side\" }}\n\
         {links}[base]\nfixed = [\"base\", \"D\"]\n\
         [tool]\non = \"coupler\"\nat_mm = [0, -100, 175]\n"
    );
    Robot::parse(&SourceText::new("four-bar.toml", &text)).unwrap()
}

fn compliance(robot: &Robot, degrees: f64) -> Result<Compliance6, RobotError> {
    let mechanism = robot.mechanism(None).unwrap();
    let mut predictor = Predictor::new(robot, mechanism, &FittingFactors::UNIT)?;
    predictor.place(&at_values(&[degrees]))?;
    Ok(predictor.compliance())
}

/// Compliance of the tool by virtual work: t tᵀ / Σ k (dq/dθ)², θ the turn of the crank and t the motion of the tool per unit of it.
fn by_virtual_work(springs: Springs, degrees: f64) -> Compliance6 {
    // y and z; a turn ω about x moves (y, z) by ω (-z, y).
    let minus = |p: [f64; 2], q: [f64; 2]| [p[0] - q[0], p[1] - q[1]];
    let turned = |w: f64, p: [f64; 2]| [-w * p[1], w * p[0]];
    let (sin, cos) = degrees.to_radians().sin_cos();
    let (a, d) = ([0.0, 0.2], [0.35, 0.2]);
    let b = [a[0] + 0.12 * cos, a[1] + 0.12 * sin];
    let across = minus(d, b);
    let distance = across[0].hypot(across[1]);
    let along = (0.35_f64.powi(2) - 0.25_f64.powi(2) + distance.powi(2)) / (2.0 * distance);
    let up = (0.35_f64.powi(2) - along.powi(2)).sqrt();
    let unit = across.map(|entry| entry / distance);
    let c = [
        b[0] + along * unit[0] - up * unit[1],
        b[1] + along * unit[1] + up * unit[0],
    ];
    // Velocity of C: of B and the coupler, and of the rocker.
    let (of_b, bc, dc) = (turned(1.0, minus(b, a)), minus(c, b), minus(c, d));
    let (p, q) = (turned(1.0, bc), turned(1.0, dc));
    let determinant = -p[0] * q[1] + p[1] * q[0];
    let coupler = (of_b[0] * q[1] - of_b[1] * q[0]) / determinant;
    let rocker = (of_b[0] * p[1] - of_b[1] * p[0]) / determinant;
    let turns = [1.0, coupler - 1.0, rocker - coupler, rocker];
    let stiffness: f64 = turns
        .iter()
        .zip(springs)
        .map(|(q, k)| q * q * k.unwrap_or(0.0))
        .sum();
    // The coupler's axes: z from B to C, x the normal, y = z × x.
    let z = bc.map(|entry| entry / 0.35);
    let y = [z[1], -z[0]];
    let tool = [0, 1].map(|i| b[i] - 0.1 * y[i] + 0.175 * z[i]);
    let of_tool = turned(coupler, minus(tool, b));
    let motion = [
        0.0,
        of_b[0] + of_tool[0],
        of_b[1] + of_tool[1],
        coupler,
        0.0,
        0.0,
    ];
    Compliance6(motion.map(|row| motion.map(|column| row * column / stiffness)))
}

fn difference(found: &Compliance6, expected: &Compliance6) -> f64 {
    let mut largest = 0.0_f64;
    for i in 0..6 {
        for j in 0..6 {
            let scale = if i < 3 { 1.0 } else { 0.3 } * if j < 3 { 1.0 } else { 0.3 };
            let most = expected.0[1][1].max(expected.0[2][2]);
            largest = largest.max((found.0[i][j] - expected.0[i][j]).abs() * scale / most);
        }
    }
    largest
}

const POSES: [f64; 6] = [20.0, 60.0, 130.0, 200.0, 275.0, 320.0];

#[test]
fn a_four_bar_linkage_yields_as_virtual_work_says() {
    let cases: [Springs; 5] = [
        [Some(8e3), None, None, None],
        [Some(8e3), Some(500.0), Some(1200.0), Some(2e4)],
        [None, Some(900.0), None, None],
        [None, None, Some(3e5), Some(10.0)],
        [Some(1e9), Some(1.0), None, None],
    ];
    for springs in cases {
        let robot = four_bar(springs, None);
        for degrees in POSES {
            let found = compliance(&robot, degrees).unwrap();
            let expected = by_virtual_work(springs, degrees);
            let error = difference(&found, &expected);
            assert!(error < 1e-10, "{springs:?} at {degrees}: {error:e}");
            let mechanism = robot.mechanism(None).unwrap();
            let sweep = PoseSweep::new(&robot, mechanism, &FittingFactors::UNIT).unwrap();
            let swept = sweep.run(&[at_values(&[degrees])], Keep::Full);
            assert_eq!(swept.compliances[0], Some(found));
        }
    }
}

#[test]
fn very_stiff_beams_come_close_to_rigid_links() {
    let springs = [Some(2.0), Some(0.5), Some(1.2), Some(4.0)];
    // Springs so soft that the beams of solid steel hardly bend beside them.
    let (rigid, beams) = (
        four_bar(springs, None),
        four_bar(springs, Some("bar 120x120")),
    );
    for degrees in POSES {
        let found = compliance(&rigid, degrees).unwrap();
        let expected = compliance(&beams, degrees).unwrap();
        let error = difference(&found, &expected);
        assert!(error < 1e-5, "at {degrees}: {error:e}");
        assert!(error > 1e-12, "the beams bend a little: {error:e}");
    }
}

#[test]
fn derivatives_of_a_loop_are_differences() {
    let mut robot = four_bar([Some(8e3), Some(500.0), Some(1200.0), Some(2e4)], None);
    for (place, axis) in [(0, 1e-6), (5, 2e-5)] {
        robot.base[place] = spring(axis);
        robot.tool.springs[place] = spring(axis);
    }
    let mechanism = robot.mechanism(None).unwrap();
    let values = robot.with_own_springs(&FittingFactors::UNIT);
    let parameters: Vec<ModelParameter> = values.springs().collect();
    assert_eq!(parameters.len(), 8);
    let mut together = MultiPosePredictor::new(&robot, mechanism, &parameters, 1).unwrap();
    for degrees in POSES {
        let whole = derivatives(
            &mut together,
            &robot,
            &at_values(&[degrees]),
            &values,
            &parameters,
        );
        assert_differences(&mut together, &values, &parameters, &whole, 1e-6);
    }
}

#[test]
fn a_loop_that_nothing_holds_is_named() {
    let robot = four_bar([None; 4], None);
    let error = compliance(&robot, 60.0).unwrap_err().to_string();
    let RobotError::Structure { source, .. } = compliance(&robot, 60.0).unwrap_err() else {
        panic!("{error}")
    };
    assert!(
        matches!(source, StructureError::Mechanism { .. }),
        "{source}"
    );
}

/// Rigid links through points in the plane of x and y, each joint about z; the first and the last stand on the ground.
fn loop_through(points: &[[f64; 2]]) -> Structure {
    let last = points.len() - 1;
    // Link i runs from joint i to the joint after it; the last one hangs on the ground by its own joint.
    let link = |place: usize| RigidMember {
        name: format!("link {place}").as_str().into(),
        ends: [
            behind(place, place),
            if place + 1 == last {
                behind(last, last)
            } else {
                (place + 1).into()
            },
        ],
    };
    let joint = |place: usize| hinge(&format!("J{place}"), [0.0, 0.0, 1.0], 100.0);
    Structure {
        nodes: points
            .iter()
            .map(|[x, y]| node("P", [*x, *y, 0.0]))
            .collect(),
        rigid_members: (0..last).map(link).collect(),
        hinges: (0..points.len()).map(joint).collect(),
        supports: vec![Support::clamped(0), Support::clamped(last)],
        end: 1.into(),
        ..Structure::default()
    }
}

#[test]
fn a_loop_in_one_line_is_singular() {
    let bent = loop_through(&[[0.0, 0.0], [0.3, 0.2], [0.6, 0.1], [1.0, 0.0]]);
    let mut solver = Solver::new(&bent).unwrap();
    solver.update(&bent).unwrap();
    assert!(solver.end_compliance().direct(1) > 0.0);
    let straight = loop_through(&[[0.0, 0.0], [0.3, 0.0], [0.6, 0.0], [1.0, 0.0]]);
    let error = solver.update(&straight).unwrap_err();
    let StructureError::SingularLoop { joints } = &error else {
        panic!("{error}")
    };
    let joints: Vec<&str> = joints.iter().map(|joint| &**joint).collect();
    assert_eq!(joints, ["J0", "J1", "J2", "J3"]);
}
