//! The paper's study as `stiffbench robot map` does it: 50 000 random poses of each of the six mechanisms, along x, y and z.
//!
//! - `study`: poses drawn, maps, minimum, maximum, mean and quantiles with their sampling uncertainty;
//! - `study, all`: principal stiffnesses, extremes refined to the limits, and regions besides;
//! - `poses`, `maps`, `statistics`, `surface`: its parts; `points, csv`: the table of one mechanism as text.
//!
//! `one core` and `all cores` stand beside each other.

#![expect(
    clippy::unwrap_used,
    reason = "a benchmark stops at the first thing that is not as it must be"
)]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use rayon::prelude::*;

use stiffbench::distribution::{
    ColumnStatistics, MapColumn, MapModel, MapPlane, MechanismStudy, PosePlan, PoseSample,
    Sampling, Shard, StiffnessMap, StudyPoses, Surface, column_statistics,
};
use stiffbench::physics::ActingPhysics;
use stiffbench::report::points_csv;
use stiffbench::robot::Robot;
use stiffbench::shipped::shipped_robot;

const POSES: usize = 50_000;

fn draw(robot: &Robot) -> PoseSample {
    let plan = PosePlan {
        sampling: Sampling::MonteCarlo,
        poses: POSES,
        seed: 0,
        held: vec!["theta1".to_owned(), "theta4".to_owned()],
    };
    PoseSample::draw(robot, &plan, Shard::WHOLE).unwrap()
}

fn maps(models: &[MapModel], poses: &PoseSample, columns: &[MapColumn]) -> Vec<StiffnessMap> {
    let maps = models
        .iter()
        .map(|model| StiffnessMap::over(model, poses, columns).unwrap());
    maps.collect()
}

fn statistics(maps: &[StiffnessMap], poses: &PoseSample) -> Vec<ColumnStatistics> {
    let columns: Vec<(usize, usize)> = (0..maps.len())
        .flat_map(|map| (0..3).map(move |column| (map, column)))
        .collect();
    let found = columns.into_par_iter().map(|(map, column)| {
        column_statistics(&maps[map], poses, Sampling::MonteCarlo, column).unwrap()
    });
    found.collect()
}

fn everything(models: &[MapModel], robot: &Robot, columns: &[MapColumn]) -> Vec<MechanismStudy> {
    let poses = StudyPoses::new(
        draw(robot),
        Sampling::MonteCarlo,
        MapPlane::upright(robot.vertical),
    );
    let maps = maps(models, &poses.set, columns).into_iter();
    let studies = models.iter().zip(maps);
    studies
        .map(|(model, map)| MechanismStudy::of(model, map, &poses, None).unwrap())
        .collect()
}

fn study(criterion: &mut Criterion) {
    let robot = Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap();
    let factors = robot.factor_set("m_fsd").unwrap();
    let mechanisms = robot.mechanisms.values();
    let physics: Vec<ActingPhysics> = mechanisms
        .map(|mechanism| ActingPhysics::new(&robot, mechanism, Vec::new()).unwrap())
        .collect();
    let models: Vec<MapModel> = physics
        .iter()
        .map(|physics| MapModel::new(&robot, physics, &factors, None).unwrap())
        .collect();
    let axes = MapColumn::axes();
    let mut all = axes.clone();
    all.extend(MapColumn::principal());
    let poses = draw(&robot);
    let found = maps(&models, &poses, &axes);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    for (name, threads) in [("one core", 1), ("all cores", cores)] {
        let pool = rayon::ThreadPoolBuilder::new()
            .num_threads(threads)
            .build()
            .unwrap();
        let mut group = criterion.benchmark_group(name);
        group.sample_size(20);
        let mut add = |what: &str, mut work: Box<dyn FnMut() + Send + '_>| {
            group.bench_function(what, |bencher| pool.install(|| bencher.iter(&mut work)));
        };
        add(
            "study",
            Box::new(|| {
                let poses = draw(&robot);
                let maps = maps(&models, &poses, &axes);
                black_box(statistics(&maps, &poses));
            }),
        );
        add(
            "study, all",
            Box::new(|| {
                black_box(everything(&models, &robot, &all));
            }),
        );
        add(
            "poses",
            Box::new(|| {
                black_box(draw(&robot));
            }),
        );
        add(
            "maps",
            Box::new(|| {
                black_box(maps(&models, &poses, &axes));
            }),
        );
        add(
            "maps, principal",
            Box::new(|| {
                black_box(maps(&models, &poses, &all));
            }),
        );
        add(
            "statistics",
            Box::new(|| {
                black_box(statistics(&found, &poses));
            }),
        );
        add(
            "surface",
            Box::new(|| {
                black_box(Surface::over(&poses));
            }),
        );
        add(
            "points, csv",
            Box::new(|| {
                black_box(points_csv(&robot, &poses, &found[5]));
            }),
        );
    }
}

criterion_group!(benches, study);
criterion_main!(benches);
