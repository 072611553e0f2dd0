//! The search for what is missing in a full session of mechanism F: four poses, three directions, five repeats, loading and unloading,
//! every law at every place.
//!
//! *The search alone* has its limits from an earlier session of the same plan; *with its limits* works them out from ten thousand
//! simulated sessions of noise. Once with nothing missing, once with play in a joint, where all further steps follow; and once for a
//! recorded session of six poses, also with play in a joint.

#![expect(
    clippy::unwrap_used,
    reason = "a benchmark stops at the first thing that is not as it must be"
)]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};

use stiffbench::bench::{Jack, NoiseModel, VirtualBench};
use stiffbench::mismatch::{Observations, RobotBaseline, SearchOptions, Verdict, diagnose};
use stiffbench::parameters::ParameterChoice;
use stiffbench::physics::{ActingPhysics, Effect};
use stiffbench::procedure::Procedure;
use stiffbench::readings::{SessionHeader, read_readings};
use stiffbench::robot::{Pose, Robot};
use stiffbench::shipped::shipped_procedure;
use stiffbench::shipped::shipped_robot;
use stiffbench::source_text::SourceText;

fn search(criterion: &mut Criterion) {
    let robot = Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap();
    let mechanism = robot.mechanism(Some("F")).unwrap();
    let factors = robot.factor_set("m_fsd").unwrap();
    let (mut procedure, _) = Procedure::parse(&shipped_procedure("load-unload").unwrap()).unwrap();
    procedure.poses = Some(robot.poses.iter().map(|named| named.id.clone()).collect());
    let poses: Vec<Pose> = robot.poses.iter().map(|named| named.pose.clone()).collect();
    let baseline = RobotBaseline::new(
        &robot,
        mechanism,
        factors.clone(),
        poses,
        &ParameterChoice::default(),
        0.0,
    )
    .unwrap();
    let session = |effects: Vec<Effect>| {
        let physics = ActingPhysics::new(&robot, mechanism, effects).unwrap();
        let noise = NoiseModel::default();
        let bench = VirtualBench::new(&robot, &physics, &factors, noise, Jack::default()).unwrap();
        Observations::new(&bench.run(&procedure, "bench", 7).unwrap(), None)
    };
    let play = "joint-backlash@A3:play=30urad,seat_moment=9N*m";
    let nothing = session(Vec::new());
    let play = session(vec![play.parse().unwrap()]);
    let options = SearchOptions::default();
    let (_, critical) = diagnose(&baseline, &nothing, &options, None).unwrap();
    let (found, _) = diagnose(&baseline, &play, &options, Some(&critical)).unwrap();
    assert_eq!(found.verdict, Verdict::Explained);

    let mut group = criterion.benchmark_group("diagnose");
    group.sample_size(10);
    for (name, observations) in [("nothing missing", &nothing), ("play in a joint", &play)] {
        group.bench_function(format!("{name}, the search alone"), |bencher| {
            bencher
                .iter(|| black_box(diagnose(&baseline, observations, &options, Some(&critical))));
        });
        group.bench_function(format!("{name}, with its limits"), |bencher| {
            bencher.iter(|| black_box(diagnose(&baseline, observations, &options, None)));
        });
    }
    group.finish();
}

/// A session of mechanism F with 1350 readings, and what is in it: a compliant joint A3.
const RECORDED: &str = "data/concealed/sessions/eefec182";

fn recorded(criterion: &mut Criterion) {
    let folder = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join(RECORDED);
    let text = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap();
    let header = SessionHeader::from_toml("session.toml", &text("session.toml"));
    let header = header.unwrap().header;
    let name = header.robot.clone().unwrap();
    let robot = Robot::parse(&SourceText::new(name.clone(), text(&name))).unwrap();
    let mechanism = robot.mechanism(header.mechanism.as_deref()).unwrap();
    let factors = robot
        .factor_set(header.factors.as_deref().unwrap())
        .unwrap();
    let readings = text("readings.csv");
    let table = read_readings("readings.csv", readings.as_bytes());
    let observations = Observations::new(&table.unwrap(), Some(&header));
    let pose = |id| robot.pose(id).unwrap().clone();
    let poses: Vec<Pose> = observations.poses.iter().map(pose).collect();
    let baseline = RobotBaseline::new(
        &robot,
        mechanism,
        factors,
        poses,
        &ParameterChoice::default(),
        0.0,
    )
    .unwrap();
    let options = SearchOptions::default();
    let (found, critical) = diagnose(&baseline, &observations, &options, None).unwrap();
    assert_eq!(found.verdict, Verdict::Explained);

    let mut group = criterion.benchmark_group("diagnose");
    group.sample_size(10);
    group.bench_function("recorded session, the search alone", |bencher| {
        bencher.iter(|| {
            black_box(diagnose(
                &baseline,
                &observations,
                &options,
                Some(&critical),
            ))
        });
    });
    group.bench_function("recorded session, with its limits", |bencher| {
        bencher.iter(|| black_box(diagnose(&baseline, &observations, &options, None)));
    });
    group.finish();
}

criterion_group!(benches, search, recorded);
criterion_main!(benches);
