//! The stiffness of mechanism F in one pose: element matrices, factorisation, three loads; one core.
//!
//! `given` begins with node coordinates, as the Python peers do; `placed` begins with the angles of the pose.

#![expect(
    clippy::unwrap_used,
    reason = "a benchmark stops at the first thing that is not as it must be"
)]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};

use stiffbench::robot::{
    FittingFactors, JointModel, MechanismModel, ModelParameter, MultiPosePredictor, Pose,
    Predictor, Robot, Theory,
};
use stiffbench::shipped::shipped_robot;
use stiffbench::structure::{Solver, Structure};

/// Poses solved together: enough that no lane stays empty, few enough to stay in the second-level cache.
const POSES: usize = 64;

/// Poses inside the limits of the arm, on a lattice that repeats nowhere.
fn poses(robot: &Robot) -> Vec<Pose> {
    let lattice = (0_u32..).map(|i| {
        let mut pose = robot.nominal_pose();
        let variables = robot.variables.iter().zip(&mut pose.angles_deg);
        let inner = robot.variables.len() - 2;
        for (j, (variable, angle)) in variables.enumerate().skip(1).take(inner) {
            let share = (f64::from(i) * 0.618_034 * j as f64).fract();
            *angle = variable.min_deg + share * (variable.max_deg - variable.min_deg);
        }
        pose
    });
    lattice
        .filter(|pose| robot.violated_limits(pose).is_empty())
        .take(POSES)
        .collect()
}

fn pose_solve(criterion: &mut Criterion) {
    let robot = Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap();
    let mechanism = robot.mechanism(Some("F")).unwrap();
    let factors = robot.factor_set("m_fsd").unwrap();
    let poses = poses(&robot);
    let structures = |factors: &FittingFactors| -> Vec<Structure> {
        let (rigid, theory) = (JointModel::Rigid, Theory::EulerBernoulli);
        let mut model = MechanismModel::new(&robot, mechanism, &rigid, theory, factors).unwrap();
        let placed = poses.iter().map(|pose| {
            model.place(pose).unwrap();
            model.structure().clone()
        });
        placed.collect()
    };

    let mut group = criterion.benchmark_group("pose_solve");
    group.throughput(Throughput::Elements(POSES as u64));

    let rated = structures(&factors);
    let mut solver = Solver::new(&rated[0]).unwrap();
    group.bench_function("single/given", |bencher| {
        bencher.iter(|| {
            for structure in &rated {
                solver.update(structure).unwrap();
                black_box(solver.end_translation_compliance());
            }
        });
    });

    let mut single = Predictor::new(&robot, mechanism, &factors).unwrap();
    group.bench_function("single/placed", |bencher| {
        bencher.iter(|| {
            for pose in &poses {
                single.place(pose).unwrap();
                black_box(single.translation_compliance());
            }
        });
    });

    let mut together =
        MultiPosePredictor::new(&robot, mechanism, &ModelParameter::CLASSES, POSES).unwrap();
    for (place, pose) in poses.iter().enumerate() {
        together.place(place, pose).unwrap();
    }
    group.bench_function("together/given", |bencher| {
        bencher.iter(|| {
            together.solve(&factors, false).unwrap();
            black_box(together.compliance(POSES - 1));
        });
    });
    group.bench_function("together/derivatives", |bencher| {
        bencher.iter(|| {
            together.solve(&factors, true).unwrap();
            black_box(together.gradient(POSES - 1, 2));
        });
    });
    group.bench_function("together/placed", |bencher| {
        bencher.iter(|| {
            for (place, pose) in poses.iter().enumerate() {
                together.place(place, pose).unwrap();
            }
            together.solve(&factors, false).unwrap();
            black_box(together.compliance(POSES - 1));
        });
    });
    group.finish();
}

criterion_group!(benches, pose_solve);
criterion_main!(benches);
