//! Maps of the stiffness over the workspace against one pose at a time, against closed forms, and against themselves in shares.

use proptest::prelude::*;

use crate::support::{acting, hp_robot, robot};
use stiffbench_beams::physics::ActingPhysics;
use stiffbench_beams::robot::{FittingFactors, ModelParameter, Pose, Predictor, Robot, Theory};
use stiffbench_beams::structure::Compliance6;
use stiffbench_diagnosis::distribution::{
    ColumnStatistics, Extreme, FittedCovariance, Level, MapColumn, MapModel, MapPlane, MatrixKind,
    MechanismStudy, NoMap, PosePlan, PoseSample, Sampling, Shard, StiffnessMap, StudyPoses,
    column_statistics, variables_beside_the_plane,
};
use stiffbench_test_files::shipped_robot;

const SAMPLINGS: [Sampling; 3] = [
    Sampling::MonteCarlo,
    Sampling::Grid,
    Sampling::LowDiscrepancy,
];

/// That robot with another text in one place of its file.
fn hp_robot_with(own: &str, other: &str) -> Robot {
    let mut source = shipped_robot("hp-robot").unwrap();
    source.text = source.text.replace(own, other);
    Robot::parse(&source).unwrap()
}

fn plan(sampling: Sampling, poses: usize, seed: u64) -> PosePlan {
    PosePlan {
        sampling,
        poses,
        seed,
        held: vec!["theta1".to_owned(), "theta4".to_owned()],
    }
}

fn draw(robot: &Robot, plan: &PosePlan) -> PoseSample {
    PoseSample::draw(robot, plan, Shard::WHOLE).unwrap()
}

/// Poses of a study, over the upright plane.
fn study_poses(robot: &Robot, sampling: Sampling, poses: usize, seed: u64) -> StudyPoses {
    let set = draw(robot, &plan(sampling, poses, seed));
    StudyPoses::new(set, sampling, MapPlane::upright(robot.vertical))
}

fn physics(robot: &Robot, mechanism: &str, effects: &[&str]) -> ActingPhysics {
    acting(robot, Some(mechanism), effects)
}

fn factors(robot: &Robot) -> FittingFactors {
    robot.factor_set("m_fsd").unwrap()
}

/// Axes and principal stiffnesses.
fn all_columns() -> Vec<MapColumn> {
    let mut columns = MapColumn::axes();
    columns.extend(MapColumn::along("oblique", [1.0, -2.0, 0.5]));
    columns.extend(MapColumn::principal());
    columns
}

/// Largest relative difference of all columns to a compliance computed pose by pose.
fn largest_difference(
    map: &StiffnessMap,
    poses: &PoseSample,
    mut compliance: impl FnMut(usize) -> [[f64; 3]; 3],
) -> f64 {
    let mut largest = 0.0_f64;
    for row in 0..map.len() {
        let c = compliance(map.places[row] as usize);
        let axes = [0, 1, 2].map(|i| 1.0 / c[i][i]);
        let n = [1.0, -2.0, 0.5].map(|x: f64| x / 5.25_f64.sqrt());
        let along: f64 = (0..9).map(|i| n[i / 3] * c[i / 3][i % 3] * n[i % 3]).sum();
        for (column, expected) in axes.into_iter().chain([1.0 / along]).enumerate() {
            let found = map.stiffness_n_per_m(row, column);
            largest = largest.max((found / expected - 1.0).abs());
        }
        // Invariants: the trace, and C w = w / k for the weakest direction.
        let principal = [4, 5, 6].map(|column| map.stiffness_n_per_m(row, column));
        assert!(principal[0] <= principal[1] && principal[1] <= principal[2]);
        let trace: f64 = principal.iter().map(|k| 1.0 / k).sum();
        largest = largest.max((trace / (c[0][0] + c[1][1] + c[2][2]) - 1.0).abs());
        let weakest = map.weakest_direction(row).unwrap();
        for i in 0..3 {
            let moved: f64 = (0..3).map(|j| c[i][j] * weakest[j]).sum();
            largest = largest.max((moved * principal[0] - weakest[i]).abs());
        }
    }
    assert_eq!(map.len() + map.failed.len(), poses.len());
    largest
}

/// The same to a mechanism without further effects, solved for one pose at a time.
fn from_single_poses(
    robot: &Robot,
    physics: &ActingPhysics,
    map: &StiffnessMap,
    poses: &PoseSample,
) -> f64 {
    let mut single = Predictor::new(robot, &physics.mechanism, &factors(robot)).unwrap();
    largest_difference(map, poses, |place| {
        single.place(&poses.pose(place)).unwrap();
        single.translation_compliance()
    })
}

/// The compliance of one pose, with joints as they are under a force, and the base.
fn under_force(
    robot: &Robot,
    physics: &ActingPhysics,
    pose: &Pose,
    force_n: [f64; 3],
) -> Compliance6 {
    let factors = factors(robot);
    let joints = physics
        .joints_under(robot, &factors, pose, force_n)
        .unwrap();
    let theory = Theory::EulerBernoulli;
    let mut single = Predictor::with(robot, &physics.mechanism, &joints, theory, &factors).unwrap();
    single.place(pose).unwrap();
    physics.with_base(&single.compliance(), single.model())
}

/// What a fit of the eight factors knows of them: their covariance, zero but for some entries.
fn covariance(entries: &[(usize, usize, f64)], dof: Option<f64>) -> FittedCovariance {
    let mut matrix = vec![vec![0.0; 8]; 8];
    for (row, column, entry) in entries {
        (matrix[*row][*column], matrix[*column][*row]) = (*entry, *entry);
    }
    FittedCovariance {
        parameters: ModelParameter::CLASSES.to_vec(),
        matrix,
        dof,
    }
}

/// The lanes lose as much as one solver does: 1e-9 of the diagonal in `crates/beams/tests/pose_sweep.rs`; directions are sums of such entries.
const AGREES: f64 = 5e-9;

#[test]
fn every_mechanism_as_one_pose_at_a_time() {
    let robot = hp_robot();
    let poses = draw(&robot, &plan(Sampling::MonteCarlo, 150, 3));
    for mechanism in robot.mechanisms.keys() {
        let physics = physics(&robot, mechanism, &[]);
        let model = MapModel::new(&robot, &physics, &factors(&robot), None).unwrap();
        let map = StiffnessMap::over(&model, &poses, &all_columns()).unwrap();
        let difference = from_single_poses(&robot, &physics, &map, &poses);
        assert!(difference < AGREES, "mechanism {mechanism}: {difference:e}");
        assert!(map.failed.is_empty());
        assert!(
            model.method()[0].contains("elements"),
            "{:?}",
            model.method()
        );
    }
}

#[test]
fn linear_physics_is_exact_and_its_method_said() {
    let robot = hp_robot();
    let poses = draw(&robot, &plan(Sampling::LowDiscrepancy, 40, 1));
    for (effects, word) in [
        (
            vec![
                "base-compliance@x:c=0.2urad/(N*m)",
                "base-compliance@z:c=0.1urad/(N*m)",
            ],
            "elements",
        ),
        (
            vec![
                "joint-compliance@A3:c=0.3urad/(N*m)",
                "joint-compliance@A3:c=0.2urad/(N*m)",
                "base-compliance@x:c=0.2urad/(N*m)",
            ],
            "a joint that yields",
        ),
        (
            vec![
                "joint-compliance@A5F:c=2urad/(N*m)",
                "joint-compliance@E6:c=3urad/(N*m)",
                "base-compliance@x:c=0.2urad/(N*m)",
            ],
            "a joint that yields",
        ),
        (vec!["loose-member@B1B2"], "elements"),
    ] {
        let physics = physics(&robot, "F", &effects);
        let model = MapModel::new(&robot, &physics, &factors(&robot), None).unwrap();
        let method = model.method();
        assert!(method.iter().any(|part| part.contains(word)), "{method:?}");
        let map = StiffnessMap::over(&model, &poses, &all_columns()).unwrap();
        let difference = largest_difference(&map, &poses, |place| {
            under_force(&robot, &physics, &poses.pose(place), [0.0; 3]).translation()
        });
        assert!(difference < AGREES, "{effects:?}: {difference:e}");
    }
}

#[test]
fn laws_that_are_not_linear_have_their_secant_at_the_load() {
    let robot = hp_robot();
    let poses = draw(&robot, &plan(Sampling::Grid, 12, 0));
    let physics = physics(
        &robot,
        "A",
        &[
            "joint-friction@A3:c=80urad/(N*m),friction_moment=26N*m",
            "base-compliance@x:c=0.2urad/(N*m)",
        ],
    );
    let factors = factors(&robot);
    let none = MapModel::new(&robot, &physics, &factors, None).unwrap_err();
    assert!(matches!(none, NoMap::NoLoad { .. }), "{none}");
    let model = MapModel::new(&robot, &physics, &factors, Some(60.0)).unwrap();
    assert!(model.method()[0].contains("60 N"), "{:?}", model.method());
    let principal = StiffnessMap::over(&model, &poses, &all_columns()).unwrap_err();
    assert!(matches!(principal, NoMap::AxesOnly { .. }), "{principal}");
    let map = StiffnessMap::over(&model, &poses, &MapColumn::axes()).unwrap();
    let mut changed = false;
    let rigid =
        ActingPhysics::new(&robot, &physics.mechanism, physics.effects[1..].to_vec()).unwrap();
    let firm = MapModel::new(&robot, &rigid, &factors, None).unwrap();
    let firm = StiffnessMap::over(&firm, &poses, &MapColumn::axes()).unwrap();
    for row in 0..map.len() {
        for axis in 0..3 {
            let mut force_n = [0.0; 3];
            force_n[axis] = -60.0;
            let expected = under_force(&robot, &physics, &poses.pose(row), force_n).direct(axis);
            // A secant goes through the joint's twist and back: 1e-7, as in the tests of the laws.
            let found = map.stiffness_n_per_m(row, axis);
            assert!((found * expected - 1.0).abs() < 1e-7, "{row} {axis}");
            changed |= found < 0.99 * firm.stiffness_n_per_m(row, axis);
        }
    }
    assert!(changed, "the law never slips: the test shows nothing");
}

#[test]
fn low_discrepancy_is_more_even_than_chance() {
    // Mean of theta2 over the poses: by chance its standard error is 1e-2 degrees at 1e6 poses; the exact mean over the box without its
    // corner is worked from areas. Box 44.93 × 51.97 from (352.51, 290); the legs of the corner, at small theta2 and large theta3, are 41.63.
    let (width, height, leg) = (44.93, 51.97, 41.63);
    let (whole, corner) = (width * height, 0.5 * leg * leg);
    let mean = 352.51 + (whole * 0.5 * width - corner * leg / 3.0) / (whole - corner);
    let robot = hp_robot();
    for (sampling, bound) in [
        (Sampling::LowDiscrepancy, 0.01),
        (Sampling::Grid, 0.02),
        (Sampling::MonteCarlo, 0.4),
    ] {
        let poses = draw(&robot, &plan(sampling, 20_000, 5));
        let sum: f64 = (0..poses.len())
            .map(|place| poses.free_angles_deg(place)[0])
            .sum();
        let error = sum / poses.len() as f64 - mean;
        assert!(error.abs() < bound, "{sampling:?}: {error}");
        for place in 0..poses.len() {
            assert!(robot.violated_limits(&poses.pose(place)).is_empty());
        }
    }
}

#[test]
fn a_grid_has_at_least_the_poses_asked_for_and_no_more_than_it_must() {
    let robot = hp_robot();
    for wanted in [1, 2, 7, 100, 5_000] {
        let poses = draw(&robot, &plan(Sampling::Grid, wanted, 0));
        assert!(poses.len() >= wanted);
        // One finer grid has (n + 1)² points for n².
        let cells = (poses.drawn as f64).sqrt();
        assert!(
            cells <= 1.0
                || (poses.len() as f64) < wanted as f64 * ((cells + 1.0) / cells).powi(3) + 3.0,
            "{wanted}: {}",
            poses.len()
        );
    }
}

#[test]
fn variables_that_leave_the_plane_alone_are_known() {
    let robot = hp_robot();
    let held = variables_beside_the_plane(
        &robot,
        robot.mechanism(None).unwrap(),
        &MapPlane::upright(robot.vertical),
    )
    .unwrap();
    assert_eq!(held, ["theta1", "theta4"]);
}

#[test]
fn variables_of_another_plane() {
    let robot = robot("serial-arm");
    let mechanism = robot.mechanism(None).unwrap();
    let held = |axes: [&str; 2]| {
        let axes = axes.map(|axis| axis.parse().unwrap());
        let plane = MapPlane::new(axes, robot.vertical);
        variables_beside_the_plane(&robot, mechanism, &plane).unwrap()
    };
    assert_eq!(held(["r", "y"]), ["theta1"]);
    assert_eq!(held(["z", "y"]), [""; 0], "the waist moves the end along z");
    assert_eq!(held(["x", "z"]), [""; 0]);
}

/// The matrix of each pose times the compliance of a predictor of its own is one; stiffness about an axis is of the same compliance.
#[test]
fn the_cartesian_stiffness_is_the_inverse_of_the_compliance() {
    for (name, held, count) in [
        ("serial-arm", &[][..], 60),
        ("hp-robot", &["theta1"][..], 20),
    ] {
        let robot = robot(name);
        let physics = acting(&robot, None, &[]);
        let factors = robot.default_factors().1;
        let plan = PosePlan {
            held: held.iter().map(|name| (*name).to_owned()).collect(),
            ..plan(Sampling::LowDiscrepancy, count, 4)
        };
        let poses = draw(&robot, &plan);
        let model = MapModel::new(&robot, &physics, &factors, None).unwrap();
        let mut columns = MapColumn::axes_of_rotation();
        columns.extend(MapColumn::principal_of_rotation());
        let matrix = Some(MatrixKind::Stiffness);
        let map = StiffnessMap::with_matrix(&model, &poses, &columns, matrix).unwrap();
        assert_eq!((map.len(), poses.free.len()), (count, 4 - held.len()));
        let mut predictor = Predictor::new(&robot, &physics.mechanism, &factors).unwrap();
        for row in 0..map.len() {
            predictor.place(&poses.pose(row)).unwrap();
            let compliance = predictor.compliance().0;
            let stiffness = map.matrix(row).unwrap();
            for (i, j) in (0..36).map(|entry| (entry / 6, entry % 6)) {
                let product: f64 = (0..6)
                    .map(|k| stiffness[6 * i + k] * compliance[k][j])
                    .sum();
                let size = (stiffness[7 * i] * compliance[j][j]).sqrt();
                let error = (product - f64::from(u8::from(i == j))).abs();
                assert!(error < 1e-8 * size, "{name} {row} {i} {j}: {error:e}");
            }
            for axis in 0..3 {
                let about = map.stiffness_n_per_m(row, axis) * compliance[3 + axis][3 + axis];
                assert!((about - 1.0).abs() < 1e-8, "{about}");
            }
            let principal = [3, 4, 5].map(|column| 1.0 / map.stiffness_n_per_m(row, column));
            let trace: f64 = (3..6).map(|i| compliance[i][i]).sum();
            assert!((principal.iter().sum::<f64>() / trace - 1.0).abs() < 1e-8);
            assert!(principal[0] >= principal[1] && principal[1] >= principal[2]);
        }
    }
}

#[test]
fn a_batch_has_the_numbers_of_the_map() {
    let robot = hp_robot();
    let poses = draw(&robot, &plan(Sampling::MonteCarlo, 300, 2));
    // A joint that yields and a base that rocks.
    let physics = physics(
        &robot,
        "C",
        &[
            "joint-compliance@A3:c=20urad/(N*m)",
            "base-compliance@x:c=1urad/(N*m)",
        ],
    );
    let model = MapModel::new(&robot, &physics, &factors(&robot), None).unwrap();
    let values: Vec<f64> = (0..poses.len())
        .flat_map(|place| poses.pose(place).angles_deg)
        .collect();
    let ends = model.end_positions(&values).unwrap();
    assert!(ends.failed.is_empty());
    for kind in [MatrixKind::Compliance, MatrixKind::Stiffness] {
        let map = StiffnessMap::with_matrix(&model, &poses, &[], Some(kind)).unwrap();
        let batch = model.matrices(&values, kind).unwrap();
        assert_eq!((map.len(), batch.results.len()), (300, 300));
        for (row, matrix) in batch.results.iter().enumerate() {
            assert_eq!(map.matrix(row).unwrap()[..], *matrix.as_flattened());
            assert_eq!(map.end_m(row), ends.results[row]);
        }
    }
}

#[test]
fn a_batch_marks_what_cannot_be_taken() {
    // With a rod of 0.500 m, loop F closes only where theta4 is large.
    let robot = hp_robot_with(r#"[["F7", "l_A5F8"]"#, r#"[["F7", 0.500]"#);
    let physics = physics(&robot, "F", &[]);
    let model = MapModel::new(&robot, &physics, &factors(&robot), None).unwrap();
    let mut values = robot.nominal_pose().angles_deg.repeat(3);
    for (place, theta4) in [(3, 95.0), (7, 50.0), (11, 95.0)] {
        values[place] = theta4;
    }
    let batch = model.matrices(&values, MatrixKind::Compliance).unwrap();
    assert_eq!(batch.failed.len(), 1);
    assert_eq!(batch.failed[0].0, 1);
    assert!(batch.results[1].as_flattened().iter().all(|c| c.is_nan()));
    assert_eq!(batch.results[0], batch.results[2]);

    let backlash = ["joint-backlash@A3:play=30urad,seat_moment=9N*m"];
    let physics = self::physics(&robot, "F", &backlash);
    let model = MapModel::new(&robot, &physics, &factors(&robot), Some(50.0)).unwrap();
    let refused = model.matrices(&values, MatrixKind::Compliance);
    assert!(matches!(refused, Err(NoMap::LinearOnly { .. })));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(30))]

    #[test]
    fn shares_are_the_whole_however_it_is_split(
        count in 1_usize..9, poses in 1_usize..300, seed in any::<u64>(), sampling in 0_usize..3,
    ) {
        let robot = hp_robot();
        let plan = plan(SAMPLINGS[sampling], poses, seed);
        let whole = draw(&robot, &plan);
        let mut found: Vec<(u64, Vec<f64>)> = Vec::new();
        for index in 0..count {
            let share = PoseSample::draw(&robot, &plan, Shard { index, count }).unwrap();
            prop_assert_eq!((share.whole, share.drawn), (whole.whole, whole.drawn));
            for (place, &id) in share.ids.iter().enumerate() {
                found.push((id, share.pose(place).angles_deg));
            }
        }
        found.sort_by_key(|(id, _)| *id);
        let expected: Vec<(u64, Vec<f64>)> =
            whole.ids.iter().enumerate().map(|(place, &id)| (id, whole.pose(place).angles_deg)).collect();
        prop_assert_eq!(found, expected);
    }
}

#[test]
fn more_poses_of_a_seed_begin_with_the_same() {
    let robot = hp_robot();
    for sampling in [Sampling::MonteCarlo, Sampling::LowDiscrepancy] {
        let few = draw(&robot, &plan(sampling, 500, 4));
        let many = draw(&robot, &plan(sampling, 600, 4));
        assert_eq!(many.ids[..500], few.ids);
        assert!((0..500).all(|place| many.pose(place) == few.pose(place)));
        let other = draw(&robot, &plan(sampling, 500, 5));
        assert!((0..500).all(|place| other.pose(place) != few.pose(place)));
    }
}

/// A map of made-up values.
fn made_up(values: &[f64]) -> StiffnessMap {
    StiffnessMap {
        mechanism: "none".to_owned(),
        columns: MapColumn::axes()[..1].to_vec(),
        places: (0..values.len() as u32).collect(),
        matrix: None,
        failed: Vec::new(),
        values: values
            .iter()
            .flat_map(|&value| [0.0, 0.0, 0.0, value])
            .collect(),
    }
}

fn statistics(values: &[f64], sampling: Sampling) -> ColumnStatistics {
    let robot = hp_robot();
    let poses = draw(&robot, &plan(sampling, values.len(), 0));
    column_statistics(&made_up(values), &poses, sampling, 0).unwrap()
}

#[test]
fn statistics_are_those_of_numpy() {
    // NumPy 2: v = 2 + np.sin(np.arange(1000)**2); v.mean(), v.std(ddof=1), np.quantile(v, [.05, .25, .5, .75, .95]), argmin, argmax.
    let values: Vec<f64> = (0..1000).map(|i| 2.0 + f64::from(i * i).sin()).collect();
    let found = statistics(&values, Sampling::MonteCarlo);
    let close = |found: f64, expected: f64| {
        assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
    };
    close(found.mean.value, NUMPY_MEAN);
    close(found.standard_deviation_n_per_m.unwrap(), NUMPY_DEVIATION);
    close(
        found.mean.standard_uncertainty,
        NUMPY_DEVIATION / 1000.0_f64.sqrt(),
    );
    assert_eq!(found.mean.dof, 999.0);
    for (quantile, expected) in found.quantiles.iter().zip(NUMPY_QUANTILES) {
        close(quantile.stiffness_n_per_m, expected);
        let [low, high] = quantile.interval_95.unwrap();
        assert!(low < expected && expected < high);
    }
    assert_eq!([found.smallest.row, found.largest.row], NUMPY_EXTREMES);
    close(found.share_beyond_95.unwrap(), 1.0 - 0.05_f64.powf(1e-3));
}

const NUMPY_MEAN: f64 = 1.997_580_027_579_626;
const NUMPY_DEVIATION: f64 = 0.708_990_450_321_674_4;
const NUMPY_QUANTILES: [f64; 5] = [
    1.015_187_934_307_030_5,
    1.284_578_025_487_159_3,
    1.997_331_080_941_772,
    2.710_004_523_981_077,
    2.985_174_234_714_526_3,
];
const NUMPY_EXTREMES: [usize; 2] = [242, 996];

#[test]
fn rank_intervals_have_their_stated_coverage() {
    // Evenly distributed values, whose quantiles are their shares; 400 samples, so that 95 % has a standard error of 1.1 %.
    let robot = hp_robot();
    let poses = draw(&robot, &plan(Sampling::MonteCarlo, 300, 0));
    let mut hits = [0; 5];
    let samples = 400;
    for seed in 0..samples {
        let plan = PosePlan {
            held: vec![
                "theta1".to_owned(),
                "theta2".to_owned(),
                "theta3".to_owned(),
            ],
            ..plan(Sampling::MonteCarlo, 300, seed)
        };
        let random = draw(&robot, &plan);
        let values: Vec<f64> = (0..300)
            .map(|place| (random.free_angles_deg(place)[0] - 45.0) / 55.0)
            .collect();
        let found = column_statistics(&made_up(&values), &poses, Sampling::MonteCarlo, 0).unwrap();
        for (hits, quantile) in hits.iter_mut().zip(&found.quantiles) {
            let [low, high] = quantile.interval_95.unwrap();
            *hits += usize::from(low <= quantile.share && quantile.share <= high);
        }
    }
    for hits in hits {
        let coverage = hits as f64 / samples as f64;
        // Whole ranks make it wider by up to two: a little above 95 %.
        assert!((0.915..=0.995).contains(&coverage), "{coverage}");
    }
}

#[test]
fn the_stated_uncertainty_of_a_low_discrepancy_mean_holds() {
    // Means of 60 seeds about that of very many poses, in units of their own standard uncertainty: 15 degrees of freedom.
    let robot = hp_robot();
    let physics = physics(&robot, "F", &[]);
    let model = MapModel::new(&robot, &physics, &factors(&robot), None).unwrap();
    let mean = |poses: usize, seed: u64| {
        let poses = draw(&robot, &plan(Sampling::LowDiscrepancy, poses, seed));
        let map = StiffnessMap::over(&model, &poses, &MapColumn::axes()).unwrap();
        column_statistics(&map, &poses, Sampling::LowDiscrepancy, 2).unwrap()
    };
    let truth = mean(200_000, 0).mean.value;
    let mut within = 0;
    for seed in 1..=60 {
        let found = mean(1_000, seed);
        let [low, high] = found.mean.interval_95().unwrap();
        within += usize::from(low <= truth && truth <= high);
        // By chance the standard error would be this; evenness gains a factor of some.
        let by_chance = found.standard_deviation_n_per_m.unwrap() / 1_000.0_f64.sqrt();
        assert!(found.mean.standard_uncertainty < 0.7 * by_chance);
    }
    // 95 % of 60 is 57; fewer than 51 has a probability below 1e-3.
    assert!(within >= 51, "{within} of 60");
}

#[test]
fn extremes_are_refined_to_the_limits() {
    let robot = hp_robot();
    let poses = study_poses(&robot, Sampling::MonteCarlo, 2_000, 0);
    for mechanism in ["A", "F"] {
        let physics = physics(&robot, mechanism, &[]);
        let model = MapModel::new(&robot, &physics, &factors(&robot), None).unwrap();
        let map = StiffnessMap::over(&model, &poses.set, &all_columns()).unwrap();
        let study = MechanismStudy::of(&model, map, &poses, None).unwrap();
        // The edges and corners of the limits and the inside: where an edge has its extreme between two points, they miss it by less
        // than 1e-4.
        let steps = (0..=120).map(|i| 352.51 + 44.93 * f64::from(i) / 120.0);
        // Where the coupled limit meets the largest theta3.
        let corner = 52.17 + 341.97;
        let mut single = Predictor::new(&robot, &physics.mechanism, &factors(&robot)).unwrap();
        let mut best = [[f64::INFINITY, 0.0]; 3];
        for theta2 in steps.chain([corner]) {
            for j in 0..=120 {
                let mut pose = robot.nominal_pose();
                pose.angles_deg[1] = theta2;
                let most = (theta2 - 52.17).min(341.97);
                pose.angles_deg[2] = 290.0 + (most - 290.0) * f64::from(j) / 120.0;
                single.place(&pose).unwrap();
                let c = single.translation_compliance();
                for axis in 0..3 {
                    let k = 1.0 / c[axis][axis];
                    best[axis] = [best[axis][0].min(k), best[axis][1].max(k)];
                }
            }
        }
        for axis in 0..3 {
            let found = study.axis(axis).unwrap();
            let [low, high] = [0, 1].map(|i| found.refined[i].clone().unwrap());
            let statistics = &found.statistics;
            // Never inside the sample's, never inside the grid's, and beyond the grid's by what its steps leave at most.
            assert!(low.stiffness_n_per_m <= statistics.smallest.stiffness_n_per_m);
            assert!(high.stiffness_n_per_m >= statistics.largest.stiffness_n_per_m);
            let beyond = [
                best[axis][0] / low.stiffness_n_per_m,
                high.stiffness_n_per_m / best[axis][1],
            ];
            for beyond in beyond {
                assert!(
                    (1.0 - 1e-9..1.0 + 1e-4).contains(&beyond),
                    "{mechanism} {axis}: {beyond}"
                );
            }
            for refined in [low, high] {
                assert!(refined.slope_per_deg < 1e-7, "{refined:?}");
                assert!(robot.violated_limits(&refined.pose).is_empty());
                single.place(&refined.pose).unwrap();
                let k = 1.0 / single.translation_compliance()[axis][axis];
                assert!((k / refined.stiffness_n_per_m - 1.0).abs() < AGREES);
            }
        }
    }
}

#[test]
fn regions_share_poses_and_area() {
    let robot = hp_robot();
    let poses = study_poses(&robot, Sampling::LowDiscrepancy, 20_000, 0);
    let physics = physics(&robot, "A", &[]);
    let model = MapModel::new(&robot, &physics, &factors(&robot), None).unwrap();
    let map = StiffnessMap::over(&model, &poses.set, &MapColumn::axes()).unwrap();
    let study = MechanismStudy::of(&model, map, &poses, None).unwrap();
    for found in &study.columns {
        let statistics = &found.statistics;
        let (low, high) = (
            statistics.smallest.stiffness_n_per_m,
            statistics.largest.stiffness_n_per_m,
        );
        // A pose stands for an area in the plane of the end in proportion to |sin(theta2 - theta3)|, the two links' lengths aside.
        let mut areas = [0.0; 3];
        let mut counts = [0; 3];
        for (row, k) in found_column(&study, found).into_iter().enumerate() {
            let level = ((3.0 * (k - low) / (high - low)) as usize).min(2);
            let [theta2, theta3] = *poses.set.free_angles_deg(row) else {
                panic!()
            };
            areas[level] += (theta2 - theta3).to_radians().sin().abs();
            counts[level] += 1;
        }
        let all: f64 = areas.iter().sum();
        for (i, region) in found.regions.iter().enumerate() {
            assert_eq!(region.level, [Level::Low, Level::Medium, Level::High][i]);
            let poses = f64::from(counts[i]) / 20_000.0;
            assert!((region.share_of_poses - poses).abs() < 1e-4);
            // Triangles stand for their corners' mean, and a seam at the edge lacks: under one percent of the area.
            let area = region.share_of_area.unwrap();
            let expected = areas[i] / all;
            assert!((area - expected).abs() < 8e-3, "{area} {expected}");
        }
    }
    // The lateral stiffness is highest where the arm is nearest, as the paper finds (Section V-B), and lowest where it is furthest.
    let x = &study.columns[0].regions;
    assert!(
        x[2].holds.contains(&Extreme::Nearest) && x[0].holds.contains(&Extreme::Furthest),
        "{x:?}"
    );
}

fn found_column(
    study: &MechanismStudy,
    found: &stiffbench_diagnosis::distribution::ColumnStudy,
) -> Vec<f64> {
    let column = study
        .map
        .columns
        .iter()
        .position(|column| *column == found.column)
        .unwrap();
    study.map.column(column).collect()
}

/// A number of the statistics of a column.
type Characteristic = fn(&ColumnStatistics) -> f64;

#[test]
fn fit_uncertainty_is_that_of_changed_factors() {
    let robot = hp_robot();
    let base = factors(&robot);
    let physics = physics(&robot, "F", &["base-compliance@x:c=0.2urad/(N*m)"]);
    let poses = study_poses(&robot, Sampling::Grid, 300, 0);
    // Axes, an oblique direction, the principal ones: three that fill a solution and others that do not.
    let mut columns = MapColumn::axes();
    columns.extend(MapColumn::along("0,1,1", [0.0, 1.0, 1.0]));
    columns.extend(MapColumn::principal());
    let study = |factors: &FittingFactors, covariance: Option<&FittedCovariance>| {
        let model = MapModel::new(&robot, &physics, factors, None).unwrap();
        let map = StiffnessMap::over(&model, &poses.set, &columns).unwrap();
        MechanismStudy::of(&model, map, &poses, covariance).unwrap()
    };
    // ln A and ln Iy of the beams known to 3 and 5 %, correlated by -0.6: differences of both by one standard uncertainty make the truth.
    let [a, iy] = [0.03_f64, 0.05];
    let entries = [(0, 0, a * a), (1, 1, iy * iy), (0, 1, -0.6 * a * iy)];
    let found = study(&base, Some(&covariance(&entries, Some(7.0))));
    let slope = |factor: usize| {
        // Central differences of 1e-3: truncation 1e-6 of the slope, rounding 1e-6 of it.
        let at = |sign: f64| {
            let mut factors = base.clone();
            factors.beam[factor] *= (sign * 1e-3_f64).exp();
            study(&factors, None)
        };
        let (up, down) = (at(1.0), at(-1.0));
        move |column: usize, what: Characteristic| {
            let value = |study: &MechanismStudy| what(&study.columns[column].statistics);
            (value(&up) - value(&down)) / 2e-3
        }
    };
    let (area, bending) = (slope(0), slope(1));
    for (column, study) in found.columns.iter().enumerate() {
        let fit = study.fit.unwrap();
        let whats: [(Characteristic, _); 3] = [
            (|s| s.smallest.stiffness_n_per_m, fit.smallest),
            (|s| s.largest.stiffness_n_per_m, fit.largest),
            (|s| s.mean.value, fit.mean),
        ];
        for (what, estimate) in whats {
            let (a, b) = (a * area(column, what), iy * bending(column, what));
            let expected = (a * a + b * b - 1.2 * a * b).sqrt();
            let ratio = estimate.standard_uncertainty / expected;
            assert!((ratio - 1.0).abs() < 1e-4, "{column}: {ratio}");
            assert_eq!(estimate.dof, 7.0);
        }
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let robot = hp_robot();
    let physics = physics(&robot, "F", &[]);
    let study = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        pool.install(|| {
            let poses = study_poses(&robot, Sampling::MonteCarlo, 5_000, 0);
            let model = MapModel::new(&robot, &physics, &factors(&robot), None).unwrap();
            let map = StiffnessMap::over(&model, &poses.set, &all_columns()).unwrap();
            let covariance = covariance(&[(1, 1, 0.01)], None);
            let study = MechanismStudy::of(&model, map, &poses, Some(&covariance)).unwrap();
            (study.map, study.columns)
        })
    };
    let one = study(1);
    for threads in [2, 3, 7] {
        assert!(study(threads) == one, "{threads} threads");
    }
}

#[test]
fn poses_that_cannot_be_taken_are_listed_with_the_reason() {
    // A forearm rod of less than half its length: chain F closes in part of the workspace only.
    let robot = hp_robot_with(r#"[["F6", "l_A4A5"]"#, r#"[["F6", 0.200]"#);
    let poses = study_poses(&robot, Sampling::MonteCarlo, 400, 2);
    let physics = physics(&robot, "F", &[]);
    let model = MapModel::new(&robot, &physics, &factors(&robot), None).unwrap();
    let map = StiffnessMap::over(&model, &poses.set, &all_columns()).unwrap();
    assert!(!map.failed.is_empty() && !map.is_empty());
    assert!(
        map.failed
            .iter()
            .all(|(_, reason)| reason.contains("does not close"))
    );
    let difference = from_single_poses(&robot, &physics, &map, &poses.set);
    // Loops near folding flat lose more.
    assert!(difference < 1e-6, "{difference:e}");
    let study = MechanismStudy::of(&model, map, &poses, None).unwrap();
    assert!(study.triangles.unwrap().len() < poses.surface.unwrap().triangles.len());
    assert_eq!(study.columns[0].statistics.poses, study.map.len());
}
