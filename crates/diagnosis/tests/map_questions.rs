//! What a map is asked beside the stiffness: loads, own weight, design. Against closed forms, differences and the solver of single poses.

use crate::support::{acting, hp_robot};
use stiffbench_beams::robot::{FittingFactors, GRAVITY_M_PER_S2, Predictor, Robot};
use stiffbench_diagnosis::distribution::{
    MapColumn, MapModel, NoMap, PosePlan, PoseSample, Sampling, Shard, ShiftMap, StiffnessMap,
    design_sensitivity, largest_load,
};
use stiffbench_units_and_text::source_text::SourceText;

/// An arm of two members in line, 0.9 m and 0.6 m, that hardly leaves the level: displacements along y are those of bending alone.
const ARM: &str = r#"
format = "planar-linkage-robot/1"
name = "level arm"
elements = [
  { id = "OM", nodes = ["O", "M"], chain = "a", class = "beam", section = "root", body = "arm", plane = "upright" },
  { id = "MT", nodes = ["M", "T"], chain = "a", class = "beam", section = "tip", body = "arm", plane = "upright" },
]
bodies = [{ id = "ground" }, { id = "arm", parent = "ground", origin = "O", axis = [-1.0, 0.0, 0.0], angle = { lift = 1.0 } }]
[variables.lift]
min = -0.0001
max = 0.0001
nominal = 0.0
[planes.upright]
body = "ground"
normal = [1.0, 0.0, 0.0]
[nodes]
O = { on = "ground", at = [0.0, 0.0, 0.0] }
M = { on = "arm", at = [0.0, 0.0, 0.9] }
T = { on = "arm", at = [0.0, 0.0, 1.5] }
[support]
fixed = ["O"]
[end]
node = "T"
[materials.steel]
E = 210.0e9
G = 81.0e9
[sections.root]
material = "steel"
A = 2.0e-3
Iy = 9.0e-7
Iz = 9.0e-7
J = 1.8e-6
mass_per_m = 16.0
[sections.tip]
material = "steel"
A = 1.0e-3
Iy = 2.0e-7
Iz = 2.0e-7
J = 4.0e-7
mass_per_m = 8.0
[mechanisms.A]
chains = ["a"]
"#;

fn arm() -> Robot {
    Robot::parse(&SourceText::new("arm.toml", ARM.to_owned())).unwrap()
}

fn poses(robot: &Robot, count: usize) -> PoseSample {
    let plan = PosePlan {
        sampling: Sampling::MonteCarlo,
        poses: count,
        seed: 5,
        held: Vec::new(),
    };
    PoseSample::draw(robot, &plan, Shard::WHOLE).unwrap()
}

fn axis_map(model: &MapModel<'_>, poses: &PoseSample, axis: usize) -> StiffnessMap {
    StiffnessMap::over(model, poses, &MapColumn::axes()[axis..=axis]).unwrap()
}

fn least_and_mean(map: &StiffnessMap) -> [f64; 2] {
    let least = map.column(0).fold(f64::INFINITY, f64::min);
    [least, map.column(0).sum::<f64>() / map.len() as f64]
}

#[test]
fn a_load_moves_the_end_as_the_single_pose_solver_predicts() {
    let robot = hp_robot();
    let physics = acting(&robot, None, &[]);
    let factors = robot.default_factors().1;
    let model = MapModel::new(&robot, &physics, &factors, None).unwrap();
    let set = poses(&robot, 50);
    let load = [12.0, -50.0, 7.0, 3.0, -2.0, 5.0];
    let map = ShiftMap::under_load(&model, &set, load).unwrap();
    let mut predictor = Predictor::new(&robot, &physics.mechanism, &factors).unwrap();
    assert_eq!((map.shifts.len(), map.failed.len()), (50, 0));
    for (place, shift) in map.shifts.iter().enumerate() {
        predictor.place(&set.pose(place)).unwrap();
        let (solver, placed) = predictor.parts();
        let structure = placed.structure();
        let expected = solver.end_displacement(&[(structure.end.clone(), load)]);
        let found = [shift.displacement_m, shift.rotation_rad].concat();
        for (half, length) in [(0..3, shift.distance_m()), (3..6, shift.angle_rad())] {
            for i in half {
                // Lanes and general solver agree to 1e-9 of the diagonal; components far below the whole keep fewer digits.
                assert!(
                    (found[i] - expected[i]).abs() < 1e-7 * length,
                    "{found:?} {expected:?}"
                );
            }
        }
        let force = largest_load(shift, load, 1e-3).unwrap();
        let multiple = force / f64::from(12 * 12 + 50 * 50 + 7 * 7).sqrt();
        assert!((multiple * shift.distance_m() / 1e-3 - 1.0).abs() < 1e-12);
    }
}

#[test]
fn loads_and_weight_refuse_laws_that_are_not_linear() {
    let robot = hp_robot();
    let physics = acting(
        &robot,
        None,
        &["joint-backlash@A3:play=1e-4rad,seat_moment=1N*m"],
    );
    let model = MapModel::new(&robot, &physics, &robot.default_factors().1, Some(50.0)).unwrap();
    let set = poses(&robot, 3);
    let refused = |found: Result<ShiftMap, NoMap>| matches!(found, Err(NoMap::LinearOnly { .. }));
    assert!(refused(ShiftMap::under_load(
        &model,
        &set,
        [0.0, -1.0, 0.0, 0.0, 0.0, 0.0]
    )));
    assert!(refused(ShiftMap::under_weight(&model, &set)));
}

/// The arm hangs at its root: each member's own weight, and the tip's weight and moment on the root. The base adds compliance times the
/// moment of the whole weight times the reach.
#[test]
fn own_weight_bends_the_arm_and_rocks_its_base() {
    let robot = arm();
    let set = poses(&robot, 4);
    let [e, i1, i2, l1, l2] = [210e9, 9e-7, 2e-7, 0.9, 0.6_f64];
    let [w1, w2] = [16.0, 8.0].map(|mass: f64| mass * GRAVITY_M_PER_S2);
    let (force, moment) = (w2 * l2, 0.5 * w2 * l2 * l2);
    // Displacement and turn of the middle node (Roark 8.1: 2a, 1a, 3a), then the tip's own.
    let v1 = w1 * l1.powi(4) / (8.0 * e * i1)
        + force * l1.powi(3) / (3.0 * e * i1)
        + moment * l1.powi(2) / (2.0 * e * i1);
    let turn1 = w1 * l1.powi(3) / (6.0 * e * i1)
        + force * l1.powi(2) / (2.0 * e * i1)
        + moment * l1 / (e * i1);
    let sag = v1 + turn1 * l2 + w2 * l2.powi(4) / (8.0 * e * i2);
    let c = 3e-6;
    let base = c * (0.5 * w1 * l1 * l1 + w2 * l2 * (l1 + 0.5 * l2)) * (l1 + l2);
    for (effects, expected) in [
        (&[][..], sag),
        (&["base-compliance@x:c=3e-6rad/(N*m)"][..], sag + base),
    ] {
        let physics = acting(&robot, None, effects);
        let model = MapModel::new(&robot, &physics, &FittingFactors::UNIT, None).unwrap();
        let map = ShiftMap::under_weight(&model, &set).unwrap();
        for shift in &map.shifts {
            // The arm leaves the level by less than 2e-6 rad.
            assert!(
                (shift.displacement_m[1] / -expected - 1.0).abs() < 1e-9,
                "{shift:?} {expected}"
            );
        }
    }
}

/// Exact derivatives against differences of the whole map, section by section and joint by joint.
#[test]
fn sensitivities_are_those_of_differences() {
    let robot = hp_robot();
    let physics = acting(&robot, None, &[]);
    let factors = robot.default_factors().1;
    let set = poses(&robot, 150);
    let model = MapModel::new(&robot, &physics, &factors, None).unwrap();
    let axis = 1;
    let map = axis_map(&model, &set, axis);
    let found = design_sensitivity(&model, &map, &set, axis)
        .unwrap()
        .unwrap();
    assert_eq!(found.poses_of_mean, 150);
    let start = least_and_mean(&map);
    assert_eq!([found.smallest_n_per_m, found.mean_n_per_m], start);
    // All constants scaled together scale the stiffness.
    let sums = [0, 1].map(|which| {
        let sections = found.sections.iter();
        sections
            .map(|s| [s.smallest, s.mean][which].iter().sum::<f64>())
            .sum::<f64>()
    });
    assert!(sums.iter().all(|sum| (sum - 1.0).abs() < 1e-7), "{sums:?}");
    // Central differences: truncation near the square of the step, rounding near 1e-9 over it.
    let step = 1e-3_f64;
    for section in &found.sections {
        for constant in 0..4 {
            let at = |sign: f64| {
                let mut changed = robot.clone();
                let mut by = [1.0; 4];
                by[constant] = (sign * step).exp();
                let section = changed.sections.get_mut(&section.section).unwrap();
                section.section = section.section.scaled(by);
                let model = MapModel::new(&changed, &physics, &factors, None).unwrap();
                least_and_mean(&axis_map(&model, &set, axis)).map(f64::ln)
            };
            let (up, down) = (at(1.0), at(-1.0));
            for which in 0..2 {
                let difference = (up[which] - down[which]) / (2.0 * step);
                let exact = [section.smallest, section.mean][which][constant];
                assert!(
                    (difference - exact).abs() < 2e-5,
                    "{} {constant}: {exact} {difference}",
                    section.section
                );
            }
        }
    }
    // Small enough that the loop around a joint does not take over from it, large enough to be seen above rounding.
    let c = 2e-8;
    let mut seen = 0;
    for joint in &found.joints {
        let largest = joint.smallest.abs().max(joint.mean.abs());
        if largest * c < 2e-6 {
            continue;
        }
        seen += 1;
        let effect = format!("joint-compliance@{}:c={c:e}rad/(N*m)", joint.joint);
        let physics = acting(&robot, None, &[&effect]);
        let model = MapModel::new(&robot, &physics, &factors, None).unwrap();
        let with = least_and_mean(&axis_map(&model, &set, axis));
        for (which, exact) in [joint.smallest, joint.mean].into_iter().enumerate() {
            let difference = (with[which] / start[which]).ln() / c;
            assert!(
                (difference - exact).abs() < 0.01 * largest,
                "{}: {exact} {difference}",
                joint.joint
            );
        }
    }
    assert!(seen >= 3, "{seen}");
}
