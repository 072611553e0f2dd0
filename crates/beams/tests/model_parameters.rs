//! Factors of sections and springs of joints and base, as parameters of the model and as effects beside it.

use stiffbench_beams::physics::{ActingPhysics, Effect, LawSet, Mechanics};
use stiffbench_beams::robot::{
    FittingFactors, Mechanism, ModelParameter, MultiPosePredictor, Predictor, Robot, RobotError,
    Theory,
};
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::Direction;

use crate::support::robots::{displacements, shipped};

/// Factors of m_fsd with a section of its own, two joints that yield and a base that rocks.
fn values(robot: &Robot, mechanism: &Mechanism) -> (Vec<ModelParameter>, FittingFactors) {
    let named = [
        ("section.rod.Iy", 0.7),
        ("joint.A3", 4e-6),
        ("joint.B3", 2e-6),
        ("base.rx", 2e-7),
        ("base.rz", 1e-7),
    ];
    let mut factors = robot.factor_set("m_fsd").unwrap();
    let mut parameters = ModelParameter::CLASSES.to_vec();
    for (name, value) in named {
        let section = robot.sections.keys().next().unwrap();
        let name = name.replace("rod", section);
        let parameter = ModelParameter::find(robot, mechanism, &name).unwrap();
        assert_eq!(parameter.to_string(), name);
        factors.set(&parameter, value);
        assert_eq!(factors.get(&parameter), value);
        parameters.push(parameter);
    }
    (parameters, factors)
}

#[test]
fn springs_are_the_effects_of_the_same_size() {
    let robot = shipped("hp-robot");
    let mechanism = robot.mechanism(Some("F")).unwrap();
    let (parameters, factors) = values(&robot, mechanism);
    let effects = [
        "joint-compliance@A3:c=4urad/(N*m)",
        "joint-compliance@B3:c=2urad/(N*m)",
        "base-compliance@x:c=0.2urad/(N*m)",
        "base-compliance@z:c=0.1urad/(N*m)",
    ];
    let effects: Vec<Effect> = effects.iter().map(|text| text.parse().unwrap()).collect();
    let physics = ActingPhysics::new(&robot, mechanism, effects).unwrap();
    let rigid = factors.without_springs();
    let mut together =
        MultiPosePredictor::new(&robot, mechanism, &parameters, robot.poses.len()).unwrap();
    for (index, named) in robot.poses.iter().enumerate() {
        together.place(index, &named.pose).unwrap();
    }
    together.solve(&factors, true).unwrap();
    for (index, named) in robot.poses.iter().enumerate() {
        let force_n = [0.0, -60.0, 0.0];
        let joints = physics.joints_under(&robot, &rigid, &named.pose, force_n);
        let joints = joints.unwrap();
        let theory = Theory::EulerBernoulli;
        let mut hinged = Predictor::with(&robot, mechanism, &joints, theory, &rigid).unwrap();
        hinged.place(&named.pose).unwrap();
        let expected = physics.with_base(&hinged.compliance(), hinged.model());
        let found = together.compliance(index).unwrap();
        let difference = found.relative_difference(&expected);
        assert!(difference < 1e-8, "{}: {difference:e}", named.id);
        let mut single = Predictor::new(&robot, mechanism, &factors).unwrap();
        single.place(&named.pose).unwrap();
        assert!(single.compliance().relative_difference(&expected) < 1e-8);
    }
}

#[test]
fn derivatives_are_those_of_differences() {
    let robot = shipped("hp-robot");
    let mechanism = robot.mechanism(Some("F")).unwrap();
    let (parameters, factors) = values(&robot, mechanism);
    let mut together = MultiPosePredictor::new(&robot, mechanism, &parameters, 1).unwrap();
    together.place(0, &robot.poses[1].pose).unwrap();
    together.solve(&factors, true).unwrap();
    for axis in 0..3 {
        let whole = together.direct_compliance(0, axis).unwrap();
        let gradient = together.gradient(0, axis).unwrap().to_vec();
        for (parameter, derivative) in parameters.iter().zip(gradient) {
            let value = factors.get(parameter);
            let mut at = |share: f64| {
                let mut moved = factors.clone();
                moved.set(parameter, value * (1.0 + share));
                together.solve(&moved, false).unwrap();
                together.direct_compliance(0, axis).unwrap()
            };
            // Central differences of 1e-3: truncation 1e-6 of the compliance, rounding 1e-9 over 1e-3 of it.
            let slope = (at(1e-3) - at(-1e-3)) / 2e-3;
            let derivative = if parameter.is_factor() {
                derivative
            } else {
                derivative * value
            };
            let error = (derivative - slope).abs() / whole;
            assert!(error < 3e-6, "{parameter} {axis}: {error:e}");
        }
        together.solve(&factors, true).unwrap();
    }
}

#[test]
fn a_spring_without_compliance_is_a_rigid_joint() {
    let robot = shipped("hp-robot");
    let mechanism = robot.mechanism(Some("F")).unwrap();
    let (parameters, factors) = values(&robot, mechanism);
    let rigid = factors.without_springs();
    let mut springs = MultiPosePredictor::new(&robot, mechanism, &parameters, 1).unwrap();
    let mut plain =
        MultiPosePredictor::new(&robot, mechanism, &ModelParameter::CLASSES, 1).unwrap();
    for predictor in [&mut springs, &mut plain] {
        predictor.place(0, &robot.poses[0].pose).unwrap();
        predictor.solve(&rigid, true).unwrap();
    }
    let [found, expected] = [&springs, &plain].map(|p| p.compliance(0).unwrap());
    assert!(found.relative_difference(&expected) < 1e-8);
    // A spring that begins to yield moves the end, though it is rigid yet.
    let of_joint = springs.gradient(0, 1).unwrap()[9];
    assert!(of_joint > 0.0, "{of_joint}");
}

#[test]
fn a_law_in_a_joint_acts_upon_the_springs_of_the_others() {
    let robot = shipped("hp-robot");
    let mechanism = robot.mechanism(Some("F")).unwrap();
    let (parameters, factors) = values(&robot, mechanism);
    let poses = [robot.poses[1].pose.clone()];
    let moved = |effects: &[&str], parameters: &[ModelParameter], factors: &FittingFactors| {
        let effects: Vec<Effect> = effects.iter().map(|text| text.parse().unwrap()).collect();
        let physics = ActingPhysics::new(&robot, mechanism, effects).unwrap();
        let mut mechanics =
            Mechanics::rigid_with(&robot, mechanism, parameters, factors, &poses).unwrap();
        mechanics.solve_joints(|_| true).unwrap();
        Direction::ALL.map(|direction| {
            let run = (LoadDirection::of_axis(direction), direction.into());
            let id = &robot.poses[1].id;
            let forces_n = [-20.0, -70.0, -30.0];
            displacements(&physics.laws, id, mechanics.pose(0), run, &forces_n)
        })
    };
    // Friction in a joint that itself yields, and play in another.
    let laws = [
        "joint-friction@A3:c=3urad/(N*m),friction_moment=2N*m",
        "joint-backlash@A4B:play=0.12mrad,seat_moment=1N*m",
    ];
    let springs = [
        "joint-compliance@A3:c=4urad/(N*m)",
        "joint-compliance@B3:c=2urad/(N*m)",
        "base-compliance@x:c=0.2urad/(N*m)",
        "base-compliance@z:c=0.1urad/(N*m)",
    ];
    let as_parameters = moved(&laws, &parameters, &factors);
    let all: Vec<&str> = laws.into_iter().chain(springs).collect();
    let as_effects = moved(&all, &ModelParameter::BEAMS, &factors.without_springs());
    for (found, expected) in as_parameters
        .iter()
        .flatten()
        .zip(as_effects.iter().flatten())
    {
        // Several laws in a loop are solved by iteration, to 1e-6 of the displacement.
        assert!(
            (found / expected - 1.0).abs() < 1e-5,
            "{found:e} {expected:e}"
        );
    }
}

#[test]
fn a_parameter_that_is_not_there_is_refused_with_those_that_are() {
    let robot = shipped("hp-robot");
    let mechanism = robot.mechanism(Some("F")).unwrap();
    for name in ["beam.Ix", "base", "base.w", "section.A", ""] {
        let error = ModelParameter::find(&robot, mechanism, name).unwrap_err();
        assert!(matches!(error, RobotError::NotAParameter(_)), "{name}");
    }
    for (name, known) in [("joint.Z9", "A3"), ("section.none.A", "rod")] {
        let error = ModelParameter::find(&robot, mechanism, name).unwrap_err();
        assert!(matches!(error, RobotError::UnknownName { .. }), "{name}");
        let known = if known == "rod" {
            robot.sections.keys().next().unwrap()
        } else {
            known
        };
        assert!(error.to_string().contains(known), "{error}");
    }
}

/// A load that is the sum of others moves each gauge by the sum of what these do; and the derivatives across the load are those of differences.
#[test]
fn gauges_across_the_load_read_the_row_of_the_compliance() {
    let robot = shipped("hp-robot");
    let mechanism = robot.mechanism(Some("F")).unwrap();
    let (parameters, factors) = values(&robot, mechanism);
    let poses = [robot.poses[1].pose.clone()];
    let mut mechanics =
        Mechanics::rigid_with(&robot, mechanism, &parameters, &factors, &poses).unwrap();
    mechanics.differentiate_whole().unwrap();
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let oblique = LoadDirection::from_vector([half, half, 0.0]).unwrap();
    let laws = LawSet::default();
    let compliance = mechanics.pose(0).influence.compliance;
    let size = compliance
        .iter()
        .flatten()
        .fold(0.0_f64, |most, one| most.max(one.abs()));
    for read in Direction::ALL {
        let id = &robot.poses[1].id;
        let run = (&oblique, read.into());
        let moved = displacements(&laws, id, mechanics.pose(0), run, &[-50.0]);
        let row = compliance[read.index()];
        let expected = -50.0 * half * (row[0] + row[1]);
        assert!((moved[0] / expected - 1.0).abs() < 1e-12, "{read}");
    }
    // Central differences over 1e-4, a factor in its logarithm and a spring in its value: of the ten digits of a compliance six are left.
    for (place, parameter) in parameters.iter().enumerate() {
        let value = factors.get(parameter);
        let step = 1e-4 * value;
        let mut at = |value: f64| {
            let mut moved = factors.clone();
            moved.set(parameter, value);
            mechanics.set_factors_rigid(&moved).unwrap();
            let pose = mechanics.pose(0).clone();
            Direction::ALL.map(|read| pose.compliance(&read.into(), &oblique))
        };
        let (up, down) = (at(value + step), at(value - step));
        at(value);
        let [scale, unit] = if parameter.is_factor() {
            [value, 1.0]
        } else {
            [1.0, value]
        };
        let largest =
            Direction::ALL.map(|read| mechanics.pose(0).gradient(place, &read.into(), &oblique));
        let largest = largest
            .iter()
            .fold(0.0_f64, |most, one| most.max(one.abs()));
        for read in Direction::ALL {
            let expected = scale * (up[read.index()] - down[read.index()]) / (2.0 * step);
            let found = mechanics.pose(0).gradient(place, &read.into(), &oblique);
            assert!(
                (found - expected).abs() <= 1e-5 * largest + 1e-6 * size / unit,
                "{parameter} along {read}: {found:e} {expected:e}"
            );
        }
    }
}
