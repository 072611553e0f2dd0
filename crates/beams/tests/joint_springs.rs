//! Arms of rigid links with springs in joints, base and tool: compliance, derivatives and sag.
//!
//! The numbers in `fixtures/virtual-joints` were made by its `generate.py`, with a Jacobian of its own.

use stiffbench_beams::physics::{ActingPhysics, Effect, LawSet, Mechanics};
use stiffbench_beams::robot::{
    Angle, Balancer, BalancerForce, Body, BodyPlace, BodyPoint, FittingFactors, GRAVITY_M_PER_S2,
    JointModel, JointMotion, JointSprings, Keep, MassPlace, MechanismModel, ModelParameter,
    MultiPosePredictor, NodePlace, PointMass, Pose, PoseSweep, Predictor, RigidLink, Robot,
    RobotNode, SpringAxis, Theory, Variable,
};
use stiffbench_beams::structure::{Compliance6, SolutionPath};
use stiffbench_numeric::vector::dot6;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::read_axis::ReadAxis;
use stiffbench_units_and_text::test_point::Direction;

use crate::support::arms::{self, ArmEnd, ArmJoint, spring};
use crate::support::robots::{assert_differences, at_values, displacements, predictor, swept};
use crate::support::rows::{Row, number, rows};

/// Every spring that a robot's file gives a compliance.
fn springs(robot: &Robot) -> Vec<ModelParameter> {
    robot.own_springs().map(|(spring, _)| spring).collect()
}

fn compliance_of(row: &Row) -> Compliance6 {
    let names = SpringAxis::ALL.map(SpringAxis::name);
    Compliance6(std::array::from_fn(|i| {
        std::array::from_fn(|j| number(row, &format!("c_{}_{}", names[i.min(j)], names[i.max(j)])))
    }))
}

#[test]
fn a_hundred_random_arms_have_the_compliance_of_their_jacobian() {
    let expected = rows("virtual-joints/compliance.csv");
    let mut largest = 0.0_f64;
    for ((robot, pose), row) in arms::all().iter().zip(&expected) {
        let expected = compliance_of(row);
        let single = predictor(robot, pose).compliance();
        largest = largest.max(single.relative_difference(&expected));
        let together = swept(robot, pose);
        largest = largest.max(together.relative_difference(&expected));
    }
    assert_eq!(expected.len(), 100);
    assert!(largest < 1e-10, "{largest:e}");
}

#[test]
fn arms_with_beams_and_springs_have_the_compliance_of_opensees() {
    let mut largest = 0.0_f64;
    for ((robot, pose), row) in arms::with_beams()
        .iter()
        .zip(rows("virtual-joints/mixed_compliance.csv"))
    {
        let expected = compliance_of(&row);
        let single = predictor(robot, pose).compliance();
        let together = swept(robot, pose);
        assert!(together.relative_difference(&single) < 1e-9);
        largest = largest.max(single.relative_difference(&expected));
    }
    // What stands for rigid in OpenSees leaves some six digits.
    assert!(largest < 5e-6, "{largest:e}");
}

#[test]
fn derivatives_of_arms_with_beams_are_differences() {
    for (robot, pose) in arms::with_beams() {
        let mechanism = robot.mechanism(None).unwrap();
        let parameters = ModelParameter::all(&robot, mechanism);
        let values = robot.with_own_springs(&FittingFactors::UNIT);
        let mut together = MultiPosePredictor::new(&robot, mechanism, &parameters, 1).unwrap();
        let whole = arms::derivatives(&mut together, &robot, &pose, &values, &parameters);
        let start = together.compliance(0).unwrap();
        let mut single = Predictor::new(&robot, mechanism, &values).unwrap();
        single.place(&pose).unwrap();
        let of_load = single.displacement_derivatives(
            &[(
                single.model().structure().end.clone(),
                [3.0, -2.0, 5.0, 0.3, 0.2, -0.7],
            )],
            &parameters,
        );
        assert_differences(&mut together, &values, &parameters, &whole, 1e-6);
        for (place, parameter) in parameters.iter().enumerate() {
            let in_units = match (parameter.is_factor(), values.get(parameter)) {
                (true, _) => 1.0,
                (false, 0.0) => 1e-8,
                (false, own) => own,
            };
            let expected = whole[place].times([3.0, -2.0, 5.0, 0.3, 0.2, -0.7]);
            for i in 0..6 {
                let scale = 10.0 * start.0[i][i].sqrt() * start.0[3][3].max(start.0[0][0]).sqrt();
                let error = (of_load.1[place][i] - expected[i]).abs() * in_units / scale;
                assert!(error < 1e-8, "{parameter} {i}: {error:e}");
            }
        }
    }
}

#[test]
fn arms_sag_under_their_own_weight_as_virtual_work_says() {
    let mut largest = 0.0_f64;
    for ((robot, pose), row) in arms::all().iter().zip(rows("virtual-joints/weight.csv")) {
        let (found, _) = predictor(robot, pose).weight_displacement(&[]);
        let expected = SpringAxis::ALL.map(|axis| number(&row, &format!("u_{axis}")));
        let size = expected.iter().fold(0.0_f64, |size, u| size.max(u.abs()));
        for (found, expected) in found.iter().zip(expected) {
            largest = largest.max((found - expected).abs() / size);
        }
    }
    assert!(largest < 1e-10, "{largest:e}");
}

#[test]
fn derivatives_of_compliance_and_sag_are_differences() {
    let mut seen = 0;
    for (robot, pose) in arms::all().iter().take(20) {
        let mechanism = robot.mechanism(None).unwrap();
        let parameters = springs(robot);
        let values = robot.with_own_springs(&FittingFactors::UNIT);
        let mut together = MultiPosePredictor::new(robot, mechanism, &parameters, 1).unwrap();
        let whole = arms::derivatives(&mut together, robot, pose, &values, &parameters);
        let compliance = together.compliance(0).unwrap();
        let mut single = predictor(robot, pose);
        assert!(single.compliance().relative_difference(&compliance) < 1e-12);
        let (sag, of_sag) = single.weight_displacement(&parameters);
        for (place, parameter) in parameters.iter().enumerate() {
            // Compliance is linear in every spring: a step of the spring's own size is exact but for rounding.
            let value = values.get(parameter);
            let mut doubled = values.clone();
            doubled.set(parameter, 2.0 * value);
            together.solve(&doubled, false).unwrap();
            let more = together.compliance(0).unwrap();
            single.set_factors(&doubled).unwrap();
            let (more_sag, _) = single.weight_displacement(&[]);
            single.set_factors(&values).unwrap();
            for i in 0..6 {
                let difference = (more_sag[i] - sag[i] - value * of_sag[place][i]).abs();
                assert!(difference < 1e-10 * sag.iter().fold(0.0_f64, |a, b| a.max(b.abs())));
                for j in 0..6 {
                    let slope = (more.0[i][j] - compliance.0[i][j]) / value;
                    let scale = (compliance.0[i][i] * compliance.0[j][j]).sqrt() / value;
                    let error = (whole[place].0[i][j] - slope).abs() / scale;
                    assert!(error < 1e-10, "{parameter} {i} {j}: {error:e}");
                }
            }
            seen += 1;
        }
    }
    assert!(seen > 100, "{seen} springs");
}

/// A six-axis arm of industrial proportions.
fn six_axes() -> Robot {
    let joint = |axis: [f64; 3], at_m: [f64; 3], c: f64| ArmJoint {
        motion: JointMotion::Turns,
        axis,
        at_m,
        springs: JointSprings {
            own: spring(c),
            ..JointSprings::default()
        },
        mass: None,
        link: None,
    };
    let joints = [
        joint([0.0, 0.0, 1.0], [0.0, 0.0, 0.3], 1.2e-6),
        joint([0.0, 1.0, 0.0], [0.3, 0.0, 0.37], 0.4e-6),
        joint([0.0, 1.0, 0.0], [0.0, 0.0, 1.075], 0.5e-6),
        joint([1.0, 0.0, 0.0], [0.3, 0.0, 0.225], 3.7e-6),
        joint([0.0, 1.0, 0.0], [0.98, 0.0, 0.0], 2.4e-6),
        joint([1.0, 0.0, 0.0], [0.1, 0.0, 0.0], 4.9e-6),
    ];
    let end = ArmEnd {
        flange_m: [0.115, 0.0, 0.0],
        tool_m: [0.4, 0.0, 0.1],
        ..ArmEnd::default()
    };
    arms::arm(&joints, &end)
}

/// Newton's third derivation: (1 - C_θ K_C) dθ = C_θ Jᵀ dw, with K_C by differences of the torques of another formula.
#[test]
fn the_stiffness_under_a_load_is_that_of_chen_and_kao() {
    let load = [900.0, -700.0, 1200.0, 150.0, -90.0, 60.0];
    let mut largest = 0.0_f64;
    for (robot, pose) in arms::of_own_springs() {
        let slopes = arms::slopes(&robot, &pose, |pose| {
            let motions = arms::motions(&predictor(&robot, pose));
            motions.iter().map(|motion| dot6(*motion, load)).collect()
        });
        let predictor = predictor(&robot, &pose);
        let structure = predictor.model().structure();
        let found = structure.compliance_under_load(load).unwrap().unwrap();
        let free = structure.compliance_under_load([0.0; 6]).unwrap().unwrap();
        let expected = arms::by_repetition(&predictor, &slopes);
        largest = largest.max(arms::largest_difference(&found, &expected, &free));
        assert!(free.relative_difference(&found) > 1e-6, "the load is seen");
    }
    assert!(largest < 1e-10, "{largest:e}");
}

#[test]
fn parameters_that_start_rigid_are_freed_one_by_one() {
    let robot = six_axes();
    let mechanism = robot.mechanism(None).unwrap();
    let parameters: Vec<ModelParameter> =
        ["joint.J2", "joint.J2.y", "base.z", "base.ry", "tool.rx"]
            .into_iter()
            .map(|name| ModelParameter::find(&robot, mechanism, name).unwrap())
            .collect();
    let pose = at_values(&[10.0, -30.0, 50.0, 5.0, 70.0, 20.0]);
    let mut together = MultiPosePredictor::new(&robot, mechanism, &parameters, 1).unwrap();
    let rigid = FittingFactors::UNIT;
    let whole = arms::derivatives(&mut together, &robot, &pose, &rigid, &parameters);
    let start = together.compliance(0).unwrap();
    let single = predictor(&robot, &pose).compliance();
    assert!(start.relative_difference(&single) < 1e-12);
    for (parameter, derivative) in parameters.iter().zip(whole) {
        let own = robot.with_own_springs(&rigid).get(parameter);
        let mut freed = rigid.clone();
        freed.set(parameter, own + 1e-7);
        together.solve(&freed, false).unwrap();
        let found = together.compliance(0).unwrap();
        for i in 0..6 {
            for j in 0..6 {
                let expected = start.0[i][j] + 1e-7 * derivative.0[i][j];
                let scale = (found.0[i][i] * found.0[j][j]).sqrt();
                assert!(
                    (found.0[i][j] - expected).abs() < 1e-12 * scale,
                    "{parameter}"
                );
            }
        }
    }
}

#[test]
fn names_of_parameters_find_what_they_name() {
    let robot = six_axes();
    let mechanism = robot.mechanism(None).unwrap();
    let find = |name: &str| ModelParameter::find(&robot, mechanism, name);
    assert_eq!(find("joint.J2.x").unwrap(), find("joint.J2").unwrap());
    assert_eq!(find("joint.J2.z").unwrap().unit(), "rad/(N*m)");
    assert_eq!(find("base.x").unwrap().unit(), "m/N");
    assert_eq!(find("base.rx").unwrap().unit(), "rad/(N*m)");
    assert_eq!(find("tool.y").unwrap().unit(), "m/N");
    for name in [
        "joint.J7",
        "joint.J2.w",
        "joint.J7.y",
        "base.w",
        "tool",
        "group.arm.Iy",
    ] {
        assert!(find(name).is_err(), "{name}");
    }
}

#[test]
fn a_pinned_drive_is_held_by_its_spring() {
    let robot = six_axes();
    let mechanism = robot.mechanism(None).unwrap();
    let pose = at_values(&[10.0, -30.0, 50.0, 5.0, 70.0, 20.0]);
    let rigid = predictor(&robot, &pose).compliance();
    let theory = Theory::EulerBernoulli;
    let unit = FittingFactors::UNIT;
    let mut pinned =
        Predictor::with(&robot, mechanism, &JointModel::Pinned, theory, &unit).unwrap();
    pinned.place(&pose).unwrap();
    assert_eq!(pinned.compliance(), rigid);
    let sweep = PoseSweep::with(
        &robot,
        mechanism,
        JointModel::Pinned,
        theory,
        &unit,
        SolutionPath::Spatial,
    )
    .unwrap();
    assert_eq!(sweep.run(&[pose], Keep::Diagonal).alone, 0);
}

/// An arm of one joint about y at the origin, whose link reaches along x to the tool.
fn one_joint(reach_m: f64, compliance: f64) -> Robot {
    let joint = ArmJoint {
        motion: JointMotion::Turns,
        axis: [0.0, 1.0, 0.0],
        at_m: [0.0; 3],
        springs: JointSprings {
            own: spring(compliance),
            ..JointSprings::default()
        },
        mass: None,
        link: None,
    };
    let end = ArmEnd {
        flange_m: [0.5 * reach_m, 0.0, 0.0],
        tool_m: [reach_m, 0.0, 0.0],
        ..ArmEnd::default()
    };
    arms::arm(&[joint], &end)
}

/// Displacement along the force of a run to some loads, under an effect.
fn under_law(robot: &Robot, pose: &Pose, effect: &str, direction: Direction, force_n: f64) -> f64 {
    let mechanism = robot.mechanism(None).unwrap();
    let effects = vec![effect.parse::<Effect>().unwrap()];
    let physics = ActingPhysics::new(robot, mechanism, effects).unwrap();
    let poses = std::slice::from_ref(pose);
    let mechanics = Mechanics::new(robot, mechanism, &FittingFactors::UNIT, poses).unwrap();
    let run = (LoadDirection::of_axis(direction), direction.into());
    displacements(
        &physics.laws,
        &"P1".into(),
        mechanics.pose(0),
        run,
        &[force_n],
    )[0]
}

#[test]
fn every_law_of_a_joint_acts_beside_the_spring_of_the_joint() {
    let robot = six_axes();
    let pose = at_values(&[10.0, -30.0, 50.0, 5.0, 70.0, 20.0]);
    let laws = [
        "joint-compliance@J:c=2urad/(N*m)",
        "joint-backlash@J:play=0.12mrad,seat_moment=5N*m",
        "joint-friction@J:c=0.19mrad/(N*m),friction_moment=3N*m",
        "joint-nonlinearity@J:c=0.2urad/(N*m),q=0.003urad/(N*m)^2",
    ];
    let mut predictor = predictor(&robot, &pose);
    let compliance = predictor.compliance();
    let mut seen = 0;
    for joint in ["J1", "J2", "J3", "J5"] {
        let parameter = ModelParameter::Joint(joint.into());
        let derivative = predictor.compliance_derivatives(&[parameter])[0];
        for direction in Direction::ALL {
            let axis = direction.index();
            let force_n = -250.0;
            let lever = derivative.0[axis][axis].sqrt();
            if lever < 1e-3 {
                continue;
            }
            for law in laws {
                let at = |joint: &str| law.replace("@J", &format!("@{joint}"));
                let found = under_law(&robot, &pose, &at(joint), direction, force_n);
                // The same moment on the one joint of another arm, whose lever along z is its reach.
                let other = one_joint(lever, 1e-12);
                let flat = at_values(&[0.0]);
                let alone = under_law(&other, &flat, &at("J1"), Direction::Z, force_n);
                let rigid = 1e-12 * lever * lever * force_n;
                let expected = compliance.direct(axis) * force_n + alone - rigid;
                let error = (found - expected).abs() / expected.abs();
                assert!(
                    error < 1e-9,
                    "{law} in {joint} along {direction}: {error:e}"
                );
                assert!((found / (compliance.direct(axis) * force_n) - 1.0).abs() > 1e-6);
                seen += 1;
            }
        }
    }
    assert!(seen > 30, "{seen}");
}

#[test]
fn a_side_branch_weighs_where_its_own_joint_puts_it() {
    let robot = six_axes();
    let mut pose = at_values(&[10.0, -30.0, 50.0, 5.0, 70.0, 20.0]);
    let sag = |robot: &Robot, pose: &Pose| predictor(robot, pose).weight_displacement(&[]).0;
    assert_eq!(sag(&robot, &pose), [0.0; 6]);
    // Another arm of 30 kg on body 2, at (0.1, 0.3, 0.2) and turned about its x by 40 degrees, its centre 0.5 m along its z.
    let mut branched = robot.clone();
    let origin = branched.nodes.len();
    branched.nodes.push(RobotNode {
        name: "shoulder".into(),
        place: NodePlace::Fixed {
            body: 2,
            at_m: [0.1, 0.3, 0.2],
        },
    });
    let variable = branched.variables.len();
    branched.variables.push(Variable {
        name: "branch".to_owned(),
        motion: JointMotion::Turns,
        min_deg: -180.0,
        max_deg: 180.0,
        nominal_deg: 0.0,
    });
    let branch = branched.bodies.len();
    branched.bodies.push(Body {
        name: "branch".to_owned(),
        chain: Some("other arm".to_owned()),
        place: BodyPlace::Turned {
            parent: 2,
            origin,
            axis: [1.0, 0.0, 0.0],
            angle: Angle {
                offset_deg: 0.0,
                terms: vec![(variable, 1.0)],
            },
        },
    });
    let mass = |body: usize, at_m: [f64; 3]| PointMass {
        name: "branch".to_owned(),
        mass_kg: 30.0,
        place: MassPlace::Point(BodyPoint { body, at_m }),
    };
    branched.masses.push(mass(branch, [0.0, 0.0, 0.5]));
    let mut fixed = robot.clone();
    let (sin, cos) = 40.0_f64.to_radians().sin_cos();
    let at_m = [0.1, 0.3 - 0.5 * sin, 0.2 + 0.5 * cos];
    fixed.masses.push(mass(2, at_m));
    let expected = sag(&fixed, &pose);
    pose.angles_deg.push(40.0);
    let found = sag(&branched, &pose);
    for (found, expected) in found.iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12 * expected.abs() + 1e-20);
    }
    assert!(expected[2].abs() > 1e-6, "{expected:?}");
    let mechanism = branched.mechanism(None).unwrap();
    let masses = stiffbench_beams::robot::Masses::of(&branched, mechanism);
    assert_eq!(masses.at_nodes, [("branch".to_owned(), 30.0)]);
}

#[test]
fn a_balancer_carries_its_share_of_the_moment() {
    let mut robot = one_joint(1.0, 2e-6);
    robot.masses.push(PointMass {
        name: "link".to_owned(),
        mass_kg: 40.0,
        place: MassPlace::Point(BodyPoint {
            body: 1,
            at_m: [0.4, 0.0, 0.0],
        }),
    });
    let flat = at_values(&[0.0]);
    let sag = |robot: &Robot| predictor(robot, &flat).weight_displacement(&[]).0;
    let weight_nm = 40.0 * GRAVITY_M_PER_S2 * 0.4;
    // A turn about y moves a point on +x down.
    let down = |moment_nm: f64| -2e-6 * moment_nm;
    assert!((sag(&robot)[2] / down(weight_nm) - 1.0).abs() < 1e-12);
    // From 0.3 m above the joint to 0.4 m along the link: 0.5 m long, and 0.24 m from the joint.
    robot.balancers.push(Balancer {
        name: "spring".to_owned(),
        pivots: [
            BodyPoint {
                body: 0,
                at_m: [0.0, 0.0, 0.3],
            },
            BodyPoint {
                body: 1,
                at_m: [0.4, 0.0, 0.0],
            },
        ],
        force: BalancerForce::Spring {
            stiffness_n_per_m: 1500.0,
            preload_n: 200.0,
            length_m: 0.45,
        },
    });
    let pull_n = 200.0 + 1500.0 * 0.05;
    // L² = 0.25 + 0.24 sin q: the torque F L' has the slope k L'² + F L'' with L' = 0.24, L'' = -L'²/L.
    let slope_nm_per_rad = (1500.0 - pull_n / 0.5) * 0.24 * 0.24;
    let expected = down(weight_nm - pull_n * 0.24) / (1.0 + 2e-6 * slope_nm_per_rad);
    assert!((sag(&robot)[2] / expected - 1.0).abs() < 1e-12);
}

#[test]
fn a_rigid_strut_beside_an_arm_leaves_it_nothing_that_yields() {
    let mut robot = six_axes();
    robot.rigid_links.push(RigidLink {
        name: "strut".to_owned(),
        nodes: [0, robot.end - 1],
        chain: "arm".to_owned(),
        body: 0,
        is_added: false,
    });
    let links = robot.rigid_links.len();
    robot.mechanisms[0].rigid_links = (0..links).collect();
    let pose = at_values(&[10.0, -20.0, 30.0, 40.0, 50.0, 60.0]);
    let held = predictor(&robot, &pose).compliance();
    assert_eq!(held, Compliance6([[0.0; 6]; 6]));
    robot.tool.springs[0] = spring(1e-6);
    let held = predictor(&robot, &pose).compliance();
    let along: f64 = (0..3).map(|i| held.0[i][i]).sum();
    assert!((along / 1e-6 - 1.0).abs() < 1e-12, "{along:e}");
}

/// A law in a joint, and one of the base, sag as a spring of the structure there does: own weight turns both.
#[test]
fn laws_sag_under_own_weight_as_springs_do() {
    let mut seen = 0;
    for (robot, pose) in arms::all().iter().take(20) {
        let mechanism = robot.mechanism(None).unwrap();
        let values = robot.with_own_springs(&FittingFactors::UNIT);
        let poses = std::slice::from_ref(pose);
        let mut mechanics = Mechanics::rigid_with(robot, mechanism, &[], &values, poses).unwrap();
        mechanics.weigh(&[]).unwrap();
        mechanics.solve_joints(|_| true).unwrap();
        let mut single = predictor(robot, pose);
        let (sag, _) = single.weight_displacement(&[]);
        let size = sag.iter().fold(0.0_f64, |a, b| a.max(b.abs()));
        let joints = mechanism.joints(robot).into_iter();
        let joints = joints.map(|joint| &robot.joints[joint]);
        let springs = joints.filter(|joint| joint.motion == JointMotion::Turns);
        let springs = springs.map(|joint| ModelParameter::Joint(joint.name.as_str().into()));
        let of_base = [SpringAxis::Rx, SpringAxis::Rz].map(ModelParameter::Base);
        for spring in springs.chain(of_base) {
            let effect = Effect::of_spring(&spring, 3e-6).unwrap();
            let laws = LawSet::new(robot, mechanism, &[effect]).unwrap();
            let mut sprung = values.clone();
            sprung.set(&spring, values.get(&spring) + 3e-6);
            let all: Vec<ModelParameter> = sprung.springs().collect();
            let (rigid, theory) = (JointModel::Rigid, Theory::EulerBernoulli);
            let model =
                MechanismModel::with_parameters(robot, mechanism, &rigid, theory, &sprung, &all);
            let mut softer = Predictor::of(model.unwrap()).unwrap();
            softer.place(pose).unwrap();
            let (softer, _) = softer.weight_displacement(&[]);
            for (axis, expected) in softer.into_iter().enumerate() {
                let mut unit = [0.0; 6];
                unit[axis] = 1.0;
                let read = ReadAxis::new(Direction::ALL[axis % 3], axis > 2, unit);
                let run = (LoadDirection::of_axis(Direction::Z), read);
                let moved = displacements(&laws, &"P".into(), mechanics.pose(0), run, &[0.0]);
                let error = (moved[0] - expected).abs() / size;
                assert!(error < 1e-9, "{spring}, {axis}: {} {expected}", moved[0]);
            }
            seen += 1;
        }
    }
    assert!(seen > 60, "{seen}");
}
