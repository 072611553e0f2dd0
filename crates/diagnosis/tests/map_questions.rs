//! What a map is asked beside the stiffness: loads, own weight, design. Against closed forms, differences and the solver of single poses.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stiffbench_beams::physics::ActingPhysics;
use stiffbench_beams::robot::{FittingFactors, GRAVITY_M_PER_S2, Predictor, Robot};
use stiffbench_diagnosis::distribution::{
    DesignCost, DesignGoal, Lift, LiftedDesign, MapColumn, MapModel, NoDesign, NoMap, PosePlan,
    PoseSet, Sampling, Shard, ShiftMap, StiffnessMap, design_sensitivity, largest_load, lift,
};
use stiffbench_test_files::shipped_robot;
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

fn hp_robot() -> Robot {
    Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap()
}

fn acting(robot: &Robot, effects: &[&str]) -> ActingPhysics {
    let effects = effects.iter().map(|text| text.parse().unwrap()).collect();
    ActingPhysics::new(robot, robot.mechanism(None).unwrap(), effects).unwrap()
}

fn poses(robot: &Robot, count: usize) -> PoseSet {
    let plan = PosePlan {
        sampling: Sampling::MonteCarlo,
        poses: count,
        seed: 5,
        held: Vec::new(),
    };
    PoseSet::draw(robot, &plan, Shard::WHOLE).unwrap()
}

fn axis_map(model: &MapModel<'_>, poses: &PoseSet, axis: usize) -> StiffnessMap {
    StiffnessMap::over(model, poses, &MapColumn::axes()[axis..=axis]).unwrap()
}

fn least_and_mean(map: &StiffnessMap) -> [f64; 2] {
    let least = map.column(0).fold(f64::INFINITY, f64::min);
    [least, map.column(0).sum::<f64>() / map.len() as f64]
}

#[test]
fn a_load_moves_the_end_as_the_solver_of_single_poses_says() {
    let robot = hp_robot();
    let physics = acting(&robot, &[]);
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
        let expected = solver.end_displacement(structure, &[(structure.end.clone(), load)]);
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
    let physics = acting(&robot, &["joint-backlash@A3:play=1e-4rad,seat_moment=1N*m"]);
    let model = MapModel::new(&robot, &physics, &robot.default_factors().1, Some(50.0)).unwrap();
    let set = poses(&robot, 3);
    let refused = |found: Result<ShiftMap, NoMap>| matches!(found, Err(NoMap::LinearOnly { .. }));
    assert!(refused(ShiftMap::under_load(
        &model,
        &set,
        [0.0, -1.0, 0.0, 0.0, 0.0, 0.0]
    )));
    assert!(refused(ShiftMap::under_weight(&model, &set)));
    let wanted = Lift {
        goal: DesignGoal::Mean,
        axis: 1,
        by: 0.1,
    };
    assert!(matches!(
        lift(&model, &set, wanted, DesignCost::Change),
        Err(NoDesign::NotLinear)
    ));
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
        let physics = acting(&robot, effects);
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
    let physics = acting(&robot, &[]);
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
        let physics = acting(&robot, &[&effect]);
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

/// Stiffness of the arm along y with factors on the second moments: 1/K = (L³ - l³)/3EI₁ + l³/3EI₂, all of bending.
fn arm_compliance(f1: f64, f2: f64) -> f64 {
    let [e, i1, i2, l, l2] = [210e9, 9e-7 * f1, 2e-7 * f2, 1.5_f64, 0.6_f64];
    (l.powi(3) - l2.powi(3)) / (3.0 * e * i1) + l2.powi(3) / (3.0 * e * i2)
}

/// The least cost over f1, with f2 what the lift then needs: found by trying.
fn by_trying(target: f64, cost: impl Fn(f64, f64) -> f64) -> (f64, f64) {
    let mut best = (f64::INFINITY, 1.0);
    for i in 0..200_000 {
        let f1 = 0.9 + 1.5 * f64::from(i) / 200_000.0;
        let rest = target - arm_compliance(f1, f64::INFINITY);
        if rest > 0.0 {
            let f2 = arm_compliance(f64::INFINITY, 1.0) / rest;
            let cost = cost(f1, f2);
            if cost < best.0 {
                best = (cost, f1);
            }
        }
    }
    best
}

fn of(design: &LiftedDesign, section: &str) -> [f64; 4] {
    design
        .changes
        .iter()
        .find(|change| change.section == section)
        .unwrap()
        .factors
}

#[test]
fn the_cheapest_change_of_two_members_is_the_one_found_by_trying() {
    let robot = arm();
    let physics = acting(&robot, &[]);
    let model = MapModel::new(&robot, &physics, &FittingFactors::UNIT, None).unwrap();
    let set = poses(&robot, 6);
    let target = arm_compliance(1.0, 1.0) / 1.2;
    for goal in [DesignGoal::Smallest, DesignGoal::Mean] {
        let wanted = Lift {
            goal,
            axis: 1,
            by: 0.2,
        };
        let design = lift(&model, &set, wanted, DesignCost::Change).unwrap();
        let (cost, f1) = by_trying(target, |f1, f2| 0.5 * (f1.ln().powi(2) + f2.ln().powi(2)));
        assert!(
            (design.cost_value / cost - 1.0).abs() < 1e-4,
            "{} {cost}",
            design.cost_value
        );
        // The cost is flat at its least.
        assert!(
            (of(&design, "root")[1] - f1).abs() < 1e-3,
            "{design:?} {f1}"
        );
        let [area, _, iz, j] = of(&design, "tip");
        assert!(
            [area, iz, j].iter().all(|f| (f - 1.0).abs() < 1e-6),
            "{design:?}"
        );

        let design = lift(&model, &set, wanted, DesignCost::Mass).unwrap();
        // Iy grows with the square of the area, so the mass with its root.
        let mass =
            |f1: f64, f2: f64| 16.0 * 0.9 * (f1.sqrt() - 1.0) + 8.0 * 0.6 * (f2.sqrt() - 1.0);
        let barred = |f1: f64, f2: f64| {
            if f1 < 1.0 || f2 < 1.0 {
                f64::INFINITY
            } else {
                mass(f1, f2)
            }
        };
        let (cost, _) = by_trying(target, barred);
        assert!(
            (design.cost_value / cost - 1.0).abs() < 1e-4,
            "{} {cost}",
            design.cost_value
        );
        let [area, iy, ..] = of(&design, "root");
        assert!((area * area / iy - 1.0).abs() < 1e-12);
        // It weighs what it costs.
        let added: f64 = [("root", 0.9), ("tip", 0.6)]
            .map(|(name, length)| {
                length
                    * (design.robot.sections[name].mass_kg_per_m.unwrap()
                        - robot.sections[name].mass_kg_per_m.unwrap())
            })
            .iter()
            .sum();
        assert!((added - design.cost_value).abs() < 1e-12);
    }
}

/// On the whole robot: what is found lifts by what was wanted, no more, and whatever would be cheaper lifts by less.
#[test]
fn a_lift_of_the_robot_is_reached_and_nothing_near_is_cheaper() {
    let robot = hp_robot();
    let physics = acting(&robot, &[]);
    let factors = robot.default_factors().1;
    let model = MapModel::new(&robot, &physics, &factors, None).unwrap();
    let set = poses(&robot, 400);
    for (which, goal) in [DesignGoal::Smallest, DesignGoal::Mean]
        .into_iter()
        .enumerate()
    {
        let wanted = Lift {
            goal,
            axis: 1,
            by: 0.2,
        };
        let design = lift(&model, &set, wanted, DesignCost::Change).unwrap();
        let target = design.before_n_per_m * 1.2;
        assert!(
            design.after_n_per_m >= target && design.after_n_per_m < target * (1.0 + 1e-5),
            "{design:?}"
        );
        // To first order, twenty percent are nearly what the derivatives say.
        let error = design.predicted_n_per_m / design.after_n_per_m - 1.0;
        assert!(error.abs() < 0.05, "{error}");
        let solved = |robot: &Robot| {
            let model = MapModel::new(robot, &physics, &factors, None).unwrap();
            least_and_mean(&axis_map(&model, &set, 1))[which]
        };
        assert_eq!(solved(&design.robot), design.after_n_per_m);
        let mut random = ChaCha8Rng::seed_from_u64(3);
        let x: Vec<f64> = design
            .changes
            .iter()
            .flat_map(|c| c.factors.map(f64::ln))
            .collect();
        let length = x.iter().map(|x| x * x).sum::<f64>().sqrt();
        for _ in 0..20 {
            // A step that makes the change cheaper by about a percent, any way else.
            let noise: Vec<f64> = x.iter().map(|_| random.random_range(-1.0..1.0)).collect();
            let along: f64 =
                noise.iter().zip(&x).map(|(n, x)| n * x).sum::<f64>() / (length * length);
            let step: Vec<f64> = noise
                .iter()
                .zip(&x)
                .map(|(n, x)| 0.01 * (0.2 * (n - along * x) * length - 0.5 * x))
                .collect();
            let mut cheaper = design.robot.clone();
            for (change, step) in design.changes.iter().zip(step.chunks(4)) {
                let section = cheaper.sections.get_mut(&change.section).unwrap();
                section.section = section
                    .section
                    .scaled(std::array::from_fn(|i| step[i].exp()));
            }
            assert!(solved(&cheaper) < target, "{goal:?}");
        }
    }
}

#[test]
fn what_cannot_be_designed_is_refused() {
    let robot = hp_robot();
    let physics = acting(&robot, &[]);
    let model = MapModel::new(&robot, &physics, &robot.default_factors().1, None).unwrap();
    let set = poses(&robot, 20);
    let wanted = |by| Lift {
        goal: DesignGoal::Smallest,
        axis: 1,
        by,
    };
    let found = lift(&model, &set, wanted(0.1), DesignCost::Mass);
    assert!(matches!(found, Err(NoDesign::NoMass { .. })), "{found:?}");
    // All constants ten times as large lift by ten.
    let found = lift(&model, &set, wanted(20.0), DesignCost::Change);
    assert!(
        matches!(found, Err(NoDesign::OutOfReach { .. })),
        "{found:?}"
    );
}
