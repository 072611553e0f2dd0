//! Sweeps over very many poses of every mechanism: time of a pose, of a whole study, and how both grow.
//!
//! Prints one JSON object, all times on this machine in this run:
//!
//! - `us_per_pose` of mechanism F with the paper's factors, best of many rounds: `solve` begins with node coordinates in
//!   memory, `place` ends with them, `both` is [`PoseSweep::run`]; `in space` keeps every part in three dimensions, `all cores` is the
//!   time in which all of them together have solved one pose more;
//! - `springs`: mechanisms of the shipped linkages without springs and with one in every joint, six in the base and six in the tool, solving
//!   and placing, best of several rounds by turns; and the shipped six-axis arm of rigid links, 6 x 6;
//! - `study`: seconds for 50,000 poses of each mechanism, three directions, minimum, maximum, mean and quantiles included;
//! - `exponents`: slopes of the logarithm of time against those of the number of poses and of elements, from the `points` listed;
//! - `peak_gflops`: fused products in registers, one core, and the share of it that the solver reaches.
//!
//! Options: `--seconds N`, work per figure (default 0.5); `--springs` prints that section alone; `--batch FILE ROBOT` prints only the seconds
//! in which `MapModel` solves the poses of a file (`python/bench.py` writes it and compares); other arguments are those that cargo passes,
//! and are not read.

#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a benchmark stops at the first thing that is not as it must be, and prints"
)]

use std::fmt::Write;
use std::hint::black_box;
use std::time::Instant;

use pulp::{Arch, Simd, WithSimd};
use serde_json::json;

use stiffbench::analysis::{ModelChoice, resolve};
use stiffbench::distribution::{MapModel, MatrixKind};
use stiffbench::physics::{ActingPhysics, Effect};
use stiffbench::robot::{
    FittingFactors, JointModel, Keep, ModelParameter, Pose, PoseSweep, Robot, Swept, Theory,
};
use stiffbench::shipped::shipped_robot;
use stiffbench::source_text::SourceText;
use stiffbench::structure::SolutionPath;

/// Poses placed at once to be solved again and again: few enough to stay in the second-level cache.
const POSES: usize = 64;

/// Poses inside the limits of the arm, on a lattice that repeats nowhere; the first and last variable stay.
fn poses(robot: &Robot, count: usize) -> Vec<Pose> {
    let lattice = (0_u32..).map(|i| {
        let mut pose = robot.nominal_pose();
        let variables = robot.variables.iter().zip(&mut pose.angles_deg);
        let inner = robot.variables.len().saturating_sub(2);
        for (j, (variable, angle)) in variables.enumerate().skip(1).take(inner) {
            let share = (f64::from(i) * 0.618_034 * j as f64).fract();
            *angle = variable.min_deg + share * (variable.max_deg - variable.min_deg);
        }
        pose
    });
    let inside = lattice.filter(|pose| robot.violated_limits(pose).is_empty());
    inside.take(count).collect()
}

/// Least time of a call, in seconds, over rounds of a millisecond or more.
fn best(seconds: f64, mut work: impl FnMut()) -> f64 {
    work();
    let mut calls = 1;
    let mut least = f64::INFINITY;
    let begin = Instant::now();
    while begin.elapsed().as_secs_f64() < seconds {
        let start = Instant::now();
        for _ in 0..calls {
            work();
        }
        let taken = start.elapsed().as_secs_f64();
        if taken < 1e-3 {
            calls *= 2;
        } else {
            least = least.min(taken / f64::from(calls));
        }
    }
    least
}

fn sweep<'a>(robot: &'a Robot, mechanism: &str, path: SolutionPath) -> PoseSweep<'a> {
    let factors = robot.default_factors().1;
    let mechanism = robot.mechanism(Some(mechanism)).unwrap();
    let (joints, theory) = (JointModel::Rigid, Theory::EulerBernoulli);
    PoseSweep::with(robot, mechanism, joints, theory, &factors, path).unwrap()
}

fn on_threads<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> R {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
    pool.build().unwrap().install(work)
}

/// Seconds of a pose: solving, placing.
fn apart(sweep: &PoseSweep, poses: &[Pose], seconds: f64) -> [f64; 2] {
    let mut bundles = sweep.bundles(poses.len()).unwrap();
    bundles.place(poses);
    let mut sum = 0.0;
    let solve = best(seconds, || {
        bundles.solve(|_, pose| sum += pose.unwrap().direct_m_per_n[0]);
    });
    black_box(sum);
    let place = best(seconds, || bundles.place(poses));
    [solve, place].map(|time| time / poses.len() as f64)
}

/// Seconds of a pose, of all cores together: each solves poses of its own, a thousand times between two looks at the clock.
fn solve_on_all(sweep: &PoseSweep, poses: &[Pose], cores: usize, seconds: f64) -> f64 {
    const CALLS: usize = 1000;
    let mut bundles: Vec<_> = (0..cores)
        .map(|_| {
            let mut bundles = sweep.bundles(poses.len()).unwrap();
            bundles.place(poses);
            bundles
        })
        .collect();
    let all = best(seconds, || {
        std::thread::scope(|scope| {
            for bundles in &mut bundles {
                scope.spawn(move || {
                    let mut sum = 0.0;
                    for _ in 0..CALLS {
                        bundles.solve(|_, pose| sum += pose.unwrap().direct_m_per_n[0]);
                    }
                    black_box(sum);
                });
            }
        });
    });
    all / (CALLS * cores * poses.len()) as f64
}

/// Minimum, maximum, mean, and the quantiles 5, 50 and 95 % of the stiffness in three directions.
fn statistics(swept: &Swept) -> [[f64; 6]; 3] {
    [0, 1, 2].map(|axis| {
        let solved = swept.poses.iter().flatten();
        let mut stiffness: Vec<f64> = solved
            .map(|pose| 1e-6 / pose.direct_m_per_n[axis])
            .collect();
        let count = stiffness.len();
        let mean = stiffness.iter().sum::<f64>() / count as f64;
        let mut rest = &mut stiffness[..];
        // From the largest quantile down, each in what is left below it.
        let mut quantiles = [0.0; 3];
        for (quantile, share) in quantiles.iter_mut().zip([0.95, 0.5, 0.05]) {
            let place = (share * (count - 1) as f64) as usize;
            let (below, value, _) = rest.select_nth_unstable_by(place, f64::total_cmp);
            *quantile = *value;
            rest = below;
        }
        let [q95, q50, q05] = quantiles;
        let extremes = solved_extremes(swept, axis);
        [extremes[0], q05, q50, q95, extremes[1], mean]
    })
}

fn solved_extremes(swept: &Swept, axis: usize) -> [f64; 2] {
    let mut extremes = [f64::INFINITY, 0.0_f64];
    for pose in swept.poses.iter().flatten() {
        let stiffness = 1e-6 / pose.direct_m_per_n[axis];
        extremes = [extremes[0].min(stiffness), extremes[1].max(stiffness)];
    }
    extremes
}

/// Seconds for the paper's study: all mechanisms, `poses` each, with statistics.
fn study(sweeps: &[PoseSweep], poses: &[Pose], seconds: f64) -> f64 {
    best(seconds, || {
        for sweep in sweeps {
            let swept = sweep.run(poses, Keep::Diagonal);
            assert_eq!(swept.alone, 0);
            black_box(statistics(&swept));
        }
    })
}

/// Springs in every joint of a mechanism about its axis, and in base and tool.
fn sprung(robot: &Robot, mechanism: &str) -> FittingFactors {
    let mechanism = robot.mechanism(Some(mechanism)).unwrap();
    let mut factors = robot.default_factors().1;
    for parameter in ModelParameter::all(robot, mechanism) {
        if parameter.is_factor() {
            continue;
        }
        let along = ["base.x", "base.y", "base.z", "tool.x", "tool.y", "tool.z"];
        let slides = along.contains(&parameter.to_string().as_str());
        if matches!(parameter, ModelParameter::JointAbout(..)) {
            continue;
        }
        factors.set(&parameter, if slides { 1e-9 } else { 1e-7 });
    }
    factors
}

/// Sweeps with springs: every mechanism of the shipped linkages against itself without them, and the shipped six-axis arm.
fn springs(seconds: f64) -> serde_json::Value {
    let run = |sweep: &PoseSweep, poses: &[Pose], threads: usize, keep: Keep| {
        let mut alone = 0;
        let time = on_threads(threads, || {
            best(seconds, || {
                let swept = sweep.run(poses, keep);
                alone = swept.alone;
                black_box(swept);
            })
        });
        (time, alone)
    };
    let mut by_mechanism = serde_json::Map::new();
    for name in ["hp-robot", "hp-robot-host-dominant", "serial-arm"] {
        let robot = Robot::parse(&shipped_robot(name).unwrap()).unwrap();
        let poses = poses(&robot, 10_000);
        for (title, mechanism) in &robot.mechanisms {
            let beams = sweep(&robot, title, SolutionPath::Fastest);
            let factors = sprung(&robot, title);
            let sprung = PoseSweep::new(&robot, mechanism, &factors).unwrap();
            let keep = Keep::Diagonal;
            // By turns, so that what else the machine does slows both.
            let mut least = [f64::INFINITY; 2];
            let mut one_at_a_time = 0;
            for _ in 0..5 {
                for (least, sweep) in least.iter_mut().zip([&beams, &sprung]) {
                    let (time, alone) = run(sweep, &poses, 1, keep);
                    *least = least.min(time);
                    one_at_a_time += alone;
                }
            }
            let [without, with] = least.map(|time| 1e6 * time / poses.len() as f64);
            let operations =
                |sweep: &PoseSweep| sweep.methods().iter().map(|m| m.operations).sum::<u64>();
            let yielding = sprung.methods().iter().map(|part| part.yielding_joints);
            by_mechanism.insert(
                format!("{name} {title}"),
                json!({
                    "springs": yielding.sum::<usize>(),
                    "us_per_pose": [without, with],
                    "operations": [operations(&beams), operations(&sprung)],
                    "ratio": with / without,
                    "one at a time": one_at_a_time,
                }),
            );
        }
    }
    let arm = Robot::parse(&shipped_robot("fanuc-r2000ic").unwrap()).unwrap();
    let mechanism = arm.mechanism(None).unwrap();
    let arm_sweep = PoseSweep::new(&arm, mechanism, &FittingFactors::UNIT).unwrap();
    let share = |i: u32, j: usize| (f64::from(i) * 0.618_034 * j as f64).fract();
    let of_arm: Vec<Pose> = (0..50_000)
        .map(|i| Pose {
            angles_deg: (1..=arm.variables.len())
                .map(|j| 360.0 * share(i, j) - 180.0)
                .collect(),
        })
        .collect();
    let (of_arm_s, of_arm_alone) = run(&arm_sweep, &of_arm, 2, Keep::Full);
    json!({
        "one core, without and with springs in all joints, base and tool": by_mechanism,
        "six springs, 50000 poses, 6 x 6, two cores, s": of_arm_s,
        "poses of the arm solved one at a time": of_arm_alone,
    })
}

/// Least seconds for the poses of a file of 64-bit numbers, from a slice to a vector as Python asks for them.
fn batch(file: &str, robot: &str, seconds: f64) -> serde_json::Value {
    let bytes = std::fs::read(file).unwrap();
    let numbers = bytes.chunks_exact(8);
    let values: Vec<f64> = numbers
        .map(|number| f64::from_le_bytes(number.try_into().unwrap()))
        .collect();
    let choice = ModelChoice {
        robot: Some(robot.to_owned()),
        ..ModelChoice::default()
    };
    let resolved = resolve(&choice, None).unwrap();
    let springs = Effect::of_springs(&resolved.factors);
    let mechanism = resolved.mechanism().unwrap();
    let physics = ActingPhysics::new(&resolved.robot, mechanism, springs).unwrap();
    let factors = resolved.factors.without_springs();
    let model = MapModel::new(&resolved.robot, &physics, &factors, None).unwrap();
    let time = |kind| {
        best(seconds, || {
            black_box(model.matrices(&values, kind).unwrap());
        })
    };
    let of_poses = {
        let sweep = PoseSweep::new(&resolved.robot, mechanism, &resolved.factors).unwrap();
        let poses: Vec<Pose> = values
            .chunks_exact(resolved.robot.variables.len())
            .map(|row| Pose {
                angles_deg: row.to_vec(),
            })
            .collect();
        best(seconds, || {
            black_box(sweep.run(&poses, Keep::Full));
        })
    };
    json!({
        "compliance": time(MatrixKind::Compliance),
        "stiffness": time(MatrixKind::Stiffness),
        "PoseSweep::run": of_poses,
    })
}

/// Slope of ln y against ln x by least squares.
fn exponent(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let logarithms = points.iter().map(|(x, y)| (x.ln(), y.ln()));
    let (mut x, mut y) = (0.0, 0.0);
    for (ln_x, ln_y) in logarithms.clone() {
        (x, y) = (x + ln_x / count, y + ln_y / count);
    }
    let (mut xx, mut xy) = (0.0, 0.0);
    for (ln_x, ln_y) in logarithms {
        (xx, xy) = (xx + (ln_x - x).powi(2), xy + (ln_x - x) * (ln_y - y));
    }
    xy / xx
}

/// A ladder of `cells` squares with both diagonals in every square, standing on one side and loaded on the other: no two elements
/// are in series or side by side, so that every node must be eliminated.
fn ladder(cells: usize) -> Robot {
    let mut nodes = String::new();
    let mut elements = String::new();
    let mut element = |a: String, b: String| {
        let _ = writeln!(
            elements,
            "  {{ id = \"{a}{b}\", nodes = [\"{a}\", \"{b}\"], chain = \"A\", class = \"beam\", section = \"s\", body = \"ground\", plane = \"arm\" }},"
        );
    };
    for i in 0..=cells {
        let _ = writeln!(nodes, "N{i} = {{ on = \"arm\", at = [0.0, 0.0, {i}.0] }}");
        let _ = writeln!(nodes, "M{i} = {{ on = \"arm\", at = [0.0, 0.8, {i}.0] }}");
        if i > 0 {
            element(format!("N{i}"), format!("M{i}"));
            element(format!("N{}", i - 1), format!("N{i}"));
            element(format!("M{}", i - 1), format!("M{i}"));
            element(format!("N{}", i - 1), format!("M{i}"));
            element(format!("M{}", i - 1), format!("N{i}"));
        }
    }
    let text = format!(
        "format = \"planar-linkage-robot/1\"\nname = \"ladder\"\njoints = []\nelements = [\n{elements}]\n\
         [frame]\nx = \"x\"\ny = \"y\"\nz = \"z\"\nlateral = [1.0, 0.0, 0.0]\nvertical = [0.0, 1.0, 0.0]\nradial = [0.0, 0.0, 1.0]\n\
         [units]\nlength = \"m\"\nangle = \"deg\"\narea = \"m2\"\nsecond_moment = \"m4\"\nmodulus = \"Pa\"\n\
         [variables.turn]\nmin = 0.0\nmax = 90.0\nnominal = 0.0\n[parameters]\n\
         [planes.arm]\nbody = \"ground\"\nnormal = [1.0, 0.0, 0.0]\n\
         [[bodies]]\nid = \"ground\"\nchain = \"A\"\n\
         [[bodies]]\nid = \"arm\"\nchain = \"A\"\nparent = \"ground\"\norigin = \"O\"\naxis = [1.0, 0.0, 0.0]\nangle = {{ turn = 1.0 }}\n\
         [nodes]\nO = {{ on = \"ground\", at = [0.0, 0.0, 0.0] }}\n{nodes}\
         [support]\nfixed = [\"N0\", \"M0\"]\n[end]\nnode = \"N{cells}\"\n\
         [materials.m]\nE = 70.0e9\nG = 26.5e9\n\
         [sections.s]\nmaterial = \"m\"\nA = 0.001\nIy = 1e-7\nIz = 2e-7\nJ = 1e-7\n\
         [mechanisms.A]\nchains = [\"A\"]\n"
    );
    Robot::parse(&SourceText::new("ladder.toml", text)).unwrap()
}

/// Time of a pose by number of elements.
fn by_elements(seconds: f64) -> Vec<(f64, f64)> {
    let sizes = [2, 4, 8, 16, 32];
    let points = sizes.into_iter().map(|cells| {
        let robot = ladder(cells);
        let factors = FittingFactors::UNIT;
        let sweep = PoseSweep::new(&robot, robot.mechanism(None).unwrap(), &factors).unwrap();
        let angles = (0..POSES).map(|i| Pose {
            angles_deg: vec![i as f64],
        });
        let poses: Vec<Pose> = angles.collect();
        ((5 * cells) as f64, apart(&sweep, &poses, seconds)[0])
    });
    points.collect()
}

/// Fused products in registers, sixteen sums at a time: 10⁹ floating-point operations per second.
struct Peak(u64);

impl WithSimd for Peak {
    type Output = f64;

    #[inline(always)]
    #[expect(
        clippy::inline_always,
        reason = "compiled for the instruction set at hand"
    )]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let factor = black_box(simd.splat_f64s(1.0 - 1e-9));
        let mut sums = [black_box(simd.splat_f64s(1.0)); 16];
        let start = Instant::now();
        for _ in 0..self.0 {
            for sum in &mut sums {
                *sum = simd.mul_add_e_f64s(*sum, factor, factor);
            }
        }
        let taken = start.elapsed().as_secs_f64();
        black_box(sums);
        (self.0 * 16 * 2 * S::F64_LANES as u64) as f64 / taken / 1e9
    }
}

fn main() {
    let mut arguments = std::env::args().skip_while(|argument| argument != "--seconds");
    let seconds: f64 = arguments.nth(1).map_or(0.5, |text| text.parse().unwrap());
    let mut arguments = std::env::args().skip_while(|argument| argument != "--batch");
    if let (Some(file), Some(robot)) = (arguments.nth(1), arguments.next()) {
        println!("{}", batch(&file, &robot, seconds));
        return;
    }
    if std::env::args().any(|argument| argument == "--springs") {
        println!("{:#}", json!({ "springs": springs(seconds / 5.0) }));
        return;
    }
    let robot = Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap();
    let few = poses(&robot, POSES);
    let many = poses(&robot, 50_000);

    let (fastest, spatial) = (
        sweep(&robot, "F", SolutionPath::Fastest),
        sweep(&robot, "F", SolutionPath::Spatial),
    );
    let peak = (0..20).map(|_| Arch::new().dispatch(Peak(1_000_000)));
    let peak_gflops = peak.fold(0.0, f64::max);
    let [solve, place] = apart(&fastest, &few, seconds);
    let [solve_spatial, _] = apart(&spatial, &few, seconds);
    // The waist stands, so what lies below it is computed once: the last part is what each pose costs.
    let operations = |sweep: &PoseSweep| sweep.methods().last().unwrap().operations as f64;
    let share = |time: f64, sweep: &PoseSweep| operations(sweep) / time / 1e9 / peak_gflops;

    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let run = |sweep: &PoseSweep, threads: usize| {
        on_threads(threads, || {
            best(seconds, || {
                black_box(sweep.run(&many, Keep::Diagonal));
            })
        })
    };
    let (one, all) = (run(&fastest, 1), run(&fastest, cores));
    let (one_spatial, all_spatial) = (run(&spatial, 1), run(&spatial, cores));
    let [solve_all, solve_spatial_all] =
        [&fastest, &spatial].map(|sweep| solve_on_all(sweep, &few, cores, seconds));
    let names: Vec<&String> = robot.mechanisms.keys().collect();
    let sweeps: Vec<PoseSweep> = names
        .iter()
        .map(|name| sweep(&robot, name, SolutionPath::Fastest))
        .collect();
    let by_poses: Vec<(f64, f64)> = [1_000, 3_000, 10_000, 30_000, 50_000]
        .into_iter()
        .map(|count: usize| {
            let poses = &many[..count];
            let work = || {
                black_box(fastest.run(poses, Keep::Diagonal));
            };
            (count as f64, on_threads(1, || best(seconds, work)))
        })
        .collect();
    let by_elements = by_elements(seconds / 5.0);
    let (instructions, lanes) = fastest.instructions();
    let report = json!({
        "instructions": instructions,
        "lanes": lanes,
        "how": fastest.methods().iter().map(ToString::to_string).collect::<Vec<_>>(),
        "us_per_pose": {
            "solve": 1e6 * solve,
            "solve, all cores": 1e6 * solve_all,
            "solve in space": 1e6 * solve_spatial,
            "solve in space, all cores": 1e6 * solve_spatial_all,
            "place": 1e6 * place,
            "both, one core": 1e6 * one / many.len() as f64,
            "both, all cores": 1e6 * all / many.len() as f64,
            "both in space, one core": 1e6 * one_spatial / many.len() as f64,
            "both in space, all cores": 1e6 * all_spatial / many.len() as f64,
        },
        "springs": springs(seconds / 5.0),
        "cores": cores,
        "speed-up": one / all,
        "study": {
            "one core, s": on_threads(1, || study(&sweeps, &many, seconds)),
            "all cores, s": on_threads(cores, || study(&sweeps, &many, seconds)),
        },
        "operations": { "solve": operations(&fastest), "solve in space": operations(&spatial) },
        "peak_gflops": peak_gflops,
        "share of peak": { "solve": share(solve, &fastest), "solve in space": share(solve_spatial, &spatial) },
        "exponents": { "poses": exponent(&by_poses), "elements": exponent(&by_elements) },
        "points": { "poses, s": by_poses, "elements, s per pose": by_elements },
    });
    println!("{report:#}");
}
