//! Every figure comes out: the SVG is the same twice, becomes a PNG, stays small enough for a report, and no text touches another or
//! leaves the sheet, as resvg measures it with the embedded font.
//!
//! The figures are written to `target/figures-check/` as SVG and PNG, to be checked. The robot, its poses are
//! the shipped ones; measured stiffness is Table VI; readings, residuals and correlations are made up with seeded noise.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use stiffbench_beams::robot::{ElementClass, JointModel, Predictor, Robot, Theory};
use stiffbench_beams::structure::Attachment;
use stiffbench_figures::{
    Bar, ComparedCell, Correlation, DisplacementPoint, DrawnAxes, DrawnFactor, DrawnJoint,
    DrawnKind, DrawnMember, DrawnNode, FactorFate, FactorIntervals, FittedLine, LoadCurvePoints,
    LoadDisplacement, Quantities, ResidualMeasure, ResidualPoint, Residuals, RobotDrawing,
    SessionCurves, StiffnessComparison, correlation, factor_intervals, load_displacement,
    residuals, robot_pose, stiffness_comparison,
};
use stiffbench_test_files::shipped_robot;
use stiffbench_units_and_text::test_point::{Branch, Cell, Direction, PoseId};

use crate::support::{check, noise};

/// Table VI, M-FSD rows after experiment rows, N/µm, poses P1 to P4. The table's x is radial, its z lateral.
const TABLE_VI: [(Direction, [f64; 4], [f64; 4]); 3] = [
    (
        Direction::X,
        [0.00902, 0.01324, 0.01485, 0.01457],
        [0.00948, 0.01037, 0.01284, 0.01802],
    ),
    (
        Direction::Y,
        [0.02698, 0.02365, 0.02191, 0.02187],
        [0.02676, 0.02644, 0.02538, 0.02542],
    ),
    (
        Direction::Z,
        [0.29181, 0.33622, 0.23271, 0.22576],
        [0.26727, 0.29190, 0.25730, 0.26038],
    ),
];
const POSES: [&str; 4] = ["P1", "P2", "P3", "P4"];

fn session(name: &str, seed: u64, softer: f64, unloading: bool) -> SessionCurves {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut curves = Vec::new();
    for (place, pose) in POSES.into_iter().enumerate() {
        for (direction, measured, _) in TABLE_VI {
            let compliance = softer * 1e-6 / measured[place];
            let sd_m = 0.6e-6 + 0.02 * 10.0 * compliance;
            let point = |step: u32, branch, random: &mut ChaCha8Rng| {
                let force_n = -10.0 * f64::from(step) + 0.1 * noise(random);
                let loop_m = if branch == Branch::Unloading {
                    4.0 * compliance
                } else {
                    0.0
                };
                DisplacementPoint {
                    force_n,
                    displacement_m: force_n * compliance - loop_m + sd_m * noise(random),
                    bar_m: Some(sd_m),
                    n: 5,
                    branch,
                    flagged: place == 2 && direction == Direction::Y && step == 4,
                }
            };
            let mut points: Vec<DisplacementPoint> = (0..8)
                .map(|step| point(step, Branch::Loading, &mut random))
                .collect();
            if unloading {
                points.extend(
                    (0..7)
                        .rev()
                        .map(|s| point(s, Branch::Unloading, &mut random)),
                );
            }
            curves.push(LoadCurvePoints {
                pose: pose.into(),
                direction,
                points,
                line: (!unloading).then_some(FittedLine {
                    compliance_m_per_n: compliance,
                    intercept_m: -sd_m,
                }),
            });
        }
    }
    SessionCurves {
        name: name.to_owned(),
        curves,
    }
}

#[test]
fn load_against_displacement() {
    let one = LoadDisplacement {
        bar: Bar::StandardDeviation,
        marked: None,
        sessions: vec![session("mean of the repeats", 1, 1.0, false)],
    };
    check("load-displacement", &load_displacement(&one));
    let two = LoadDisplacement {
        bar: Bar::Interval95,
        marked: None,
        sessions: vec![
            session("2026-11-03 hp-robot", 1, 1.0, true),
            session("2026-11-17 hp-robot", 2, 1.15, true),
        ],
    };
    check("load-displacement-two-sessions", &load_displacement(&two));
}

#[test]
fn measured_against_predicted() {
    let mut cells = Vec::new();
    for (direction, measured, predicted) in TABLE_VI {
        for (place, pose) in POSES.into_iter().enumerate() {
            let share = [0.03, 0.05, 0.08, 0.04][place];
            let measured_n_per_m = 1e6 * measured[place];
            cells.push(ComparedCell {
                cell: Cell::new(pose.into(), direction),
                measured_n_per_m,
                measured_ci95_n_per_m: Some([
                    measured_n_per_m / (1.0 + share),
                    measured_n_per_m * (1.0 + share),
                ]),
                n_runs: 5,
                flagged: place == 2 && direction == Direction::Y,
                predicted_n_per_m: 1e6 * predicted[place],
                held_out: place % 2 == 1,
            });
        }
    }
    let figure = stiffness_comparison(&StiffnessComparison {
        pooled: false,
        prediction: "predicted, fitted on P1 and P3".to_owned(),
        cells,
    });
    check("stiffness-comparison", &figure);
}

#[test]
fn residuals_four_ways() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut points = Vec::new();
    for (place, pose) in POSES.into_iter().enumerate() {
        for (direction, measured, _) in TABLE_VI {
            for step in 0..8 {
                for repeat in 0..5 {
                    let sequence = points.len();
                    let u = 1.5e-6 + 0.03e-6 / measured[place];
                    points.push(ResidualPoint {
                        cell: Cell::new(pose.into(), direction),
                        force_n: -10.0 * f64::from(step),
                        residual_m: u * noise(&mut random) - 0.1 * u * f64::from(step),
                        standard_uncertainty_m: Some(u),
                        sequence,
                        time_s: Some(27.0 * sequence as f64 + f64::from(repeat)),
                        flagged: sequence % 97 == 13,
                    });
                }
            }
        }
    }
    let mut input = Residuals {
        quantities: Quantities::default(),
        prediction: "fitted beam structure".to_owned(),
        measure: ResidualMeasure::Micrometres,
        points,
    };
    check("residuals", &residuals(&input));
    input.measure = ResidualMeasure::StandardUncertainties;
    check("residuals-standardised", &residuals(&input));
}

#[test]
fn correlation_table() {
    let names = [
        "beam A", "beam Iy", "beam Iz", "beam J", "c(A3)", "play(A3)",
    ];
    let matrix = (0..6)
        .map(|row: i32| {
            (0..6)
                .map(|column: i32| {
                    let apart = f64::from((row - column).abs());
                    let sign = if (row - column) % 2 == 0 { 1.0 } else { -1.0 };
                    sign * (-0.08 * apart * apart * apart).exp()
                })
                .collect()
        })
        .collect();
    let input = Correlation {
        names: names.map(str::to_owned).to_vec(),
        matrix,
    };
    check("correlation", &correlation(&input));
}

#[test]
fn fitting_factors() {
    let factor = |name: &str, value: f64, half: Option<f64>, bounds: bool, fate| DrawnFactor {
        name: name.to_owned(),
        value,
        ci95: Vec::from_iter(half.map(|half| [value / half, value * half])),
        bounds: bounds.then_some([0.1 * value, 10.0 * value]),
        fate,
    };
    let figure = factor_intervals(&FactorIntervals {
        factors: vec![
            factor("beam A", 0.003, Some(1.1), true, FactorFate::Free),
            factor("beam Iy", 0.00486, Some(1.6), true, FactorFate::Free),
            factor("beam Iz", 0.964, Some(1.03), true, FactorFate::AtBound),
            factor("beam J", 1.0, None, true, FactorFate::NotIdentified),
            factor("link A", 0.00608, None, false, FactorFate::Fixed),
            factor("link Iy", 100.0, None, false, FactorFate::Fixed),
            factor("link Iz", 2.025, None, false, FactorFate::Tied),
        ],
    });
    check("factors", &figure);
}

/// The drawing of a robot under a force at its end.
fn drawing(
    robot: &Robot,
    mechanism: &str,
    pose: &str,
    joints: &JointModel,
    force_n: [f64; 3],
) -> RobotDrawing {
    let mechanism = robot.mechanism(Some(mechanism)).expect("the robot has it");
    let factors = robot.default_factors().1;
    let mut predictor = Predictor::with(robot, mechanism, joints, Theory::EulerBernoulli, &factors)
        .expect("the mechanism is complete");
    let placed = robot.pose(&PoseId::new(pose)).expect("the robot has it");
    predictor.place(placed).expect("its loops close");
    let (solver, model) = predictor.parts();
    let structure = model.structure();
    let [fx, fy, fz] = force_n;
    let load = (structure.end.clone(), [fx, fy, fz, 0.0, 0.0, 0.0]);
    let response = solver.respond(structure, &[load]);
    let rotation_at = |end: &Attachment| -> [f64; 3] {
        let [_, _, _, rx, ry, rz] = response.nodes[end.node];
        end.hinges
            .iter()
            .fold([rx, ry, rz], |mut rotation, &hinge| {
                let axis = structure.hinges[hinge].axis;
                for (component, along) in rotation.iter_mut().zip(axis) {
                    *component += response.hinges_rad[hinge] * along;
                }
                rotation
            })
    };
    RobotDrawing {
        name: format!("{}, mechanism {}, pose {pose}", robot.name, mechanism.name),
        nodes: structure
            .nodes
            .iter()
            .zip(&response.nodes)
            .map(|(node, [ux, uy, uz, ..])| DrawnNode {
                name: node.name.to_string(),
                position_m: node.position_m,
                displacement_m: [*ux, *uy, *uz],
            })
            .collect(),
        members: structure
            .elements
            .iter()
            .zip(model.members())
            .map(|(element, member)| DrawnMember {
                nodes: [element.ends[0].node, element.ends[1].node],
                rotations_rad: [rotation_at(&element.ends[0]), rotation_at(&element.ends[1])],
                chain: member.chain.clone(),
                kind: match member.class {
                    ElementClass::Beam => DrawnKind::Beam,
                    ElementClass::Link => DrawnKind::Link,
                },
            })
            .collect(),
        supports: structure.supports.iter().map(|s| s.node).collect(),
        end: structure.end.node,
        joints: Vec::new(),
        axes: DrawnAxes::default(),
        force_n: Some(force_n),
    }
}

#[test]
fn robot_in_a_pose() {
    let robot = Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap();
    let rigid = JointModel::Rigid;
    for (name, mechanism, pose, force_n) in [
        ("robot-f-p1-y", "F", "P1", [0.0, -50.0, 0.0]),
        ("robot-f-p3-x", "F", "P3", [-50.0, 0.0, 0.0]),
        ("robot-a-p4-y", "A", "P4", [0.0, -50.0, 0.0]),
        ("robot-f-p2-z", "F", "P2", [0.0, 0.0, -50.0]),
    ] {
        let drawing = drawing(&robot, mechanism, pose, &rigid, force_n);
        let moved = drawing.nodes[drawing.end].displacement_m;
        let along = force_n.iter().position(|f| *f != 0.0).unwrap();
        assert!(moved[along] < 0.0, "{name}: the end moves with the force");
        check(name, &robot_pose(&drawing));
    }
    let pinned = drawing(&robot, "F", "P1", &JointModel::Pinned, [0.0, -50.0, 0.0]);
    check("robot-f-p1-y-pinned", &robot_pose(&pinned));
}

/// Without a load: the end and the joints are marked, from three sides.
#[test]
fn robot_from_three_sides() {
    let robot = Robot::parse(&shipped_robot("serial-arm").unwrap()).unwrap();
    let mut input = drawing(&robot, "A", "P1", &JointModel::Rigid, [0.0; 3]);
    input.force_n = None;
    input.axes.front = true;
    let joint = |node| DrawnJoint {
        node,
        slides: node == 4,
    };
    input.joints = [1, 2, 4].map(joint).to_vec();
    input.members[0].kind = DrawnKind::Rigid;
    let figure = robot_pose(&input);
    assert_eq!((figure.panels.len(), figure.columns), (3, 2));
    check("robot-three-sides", &figure);
}

#[test]
fn crowded_figures_stay_readable() {
    let names: Vec<String> = (1..=16)
        .map(|i| format!("joint-compliance of joint A{i}"))
        .collect();
    let matrix = (0..16_i32)
        .map(|row| {
            (0..16)
                .map(|column| {
                    if row == column {
                        1.0
                    } else {
                        -0.95 / f64::from(1 + row + column)
                    }
                })
                .collect()
        })
        .collect();
    check(
        "correlation-crowded",
        &correlation(&Correlation { names, matrix }),
    );

    let mut cells = Vec::new();
    for direction in Direction::ALL {
        for pose in 1..=14 {
            let measured_n_per_m =
                1e4 * [1.0, 3.0, 9.0][direction.index()] + 500.0 * f64::from(pose);
            cells.push(ComparedCell {
                cell: Cell::new(PoseId::new(&format!("extended reach {pose}")), direction),
                measured_n_per_m,
                measured_ci95_n_per_m: None,
                n_runs: 3,
                flagged: false,
                predicted_n_per_m: 1.05 * measured_n_per_m,
                held_out: false,
            });
        }
    }
    let prediction =
        "predicted by the structure fitted on the session of 3 November, joints compliant"
            .to_owned();
    check(
        "stiffness-comparison-crowded",
        &stiffness_comparison(&StiffnessComparison {
            prediction,
            pooled: true,
            cells,
        }),
    );

    let mut one = session("mean", 5, 1.0, false);
    one.curves.truncate(1);
    let single = LoadDisplacement {
        bar: Bar::StandardUncertainty,
        marked: None,
        sessions: vec![one],
    };
    check("load-displacement-single", &load_displacement(&single));
}
