//! Runs are compared with those before them: clean sessions are seldom asked about, and what differs is.

use crate::support::{Rig, RunDeviation, normal, short, uniform};
use stiffbench_measurement::procedure::Procedure;
use stiffbench_measurement::readings::{RepeatOrder, ZeroScope};
use stiffbench_session::{KeptReading, Purpose, SessionEnd, Task};
use stiffbench_units_and_text::test_point::{Direction, PoseId};

const SESSIONS: u64 = 200;

/// By how much six predictive standard deviations are more than what is asked about: of Student's t with 6 to 10 degrees of freedom.
const SIX: f64 = 1.45;

/// Four cells, three repeats of five loads.
fn procedure() -> Procedure {
    let mut procedure = Procedure {
        loads_n: vec![0.0, -30.0, -60.0, -90.0, -120.0],
        directions: vec![Direction::X.into(), Direction::Z.into()],
        poses: Some(vec![PoseId::new("P1"), PoseId::new("P2")]),
        repeats: 3,
        ..short(false)
    };
    procedure.zero = ZeroScope::Run;
    procedure
}

/// One cell of three loads, four of five with one zero each, and six whose loads are each repeated before the next.
fn other_procedures() -> [Procedure; 3] {
    let (one, mut four, mut six) = (short(false), procedure(), procedure());
    four.zero = ZeroScope::Cell;
    six.directions = Direction::ALL.map(Into::into).into();
    six.repeats = 5;
    six.repeat_order = RepeatOrder::AtLoad;
    six.zero = ZeroScope::Cell;
    let one = Procedure {
        repeats: 3,
        zero: ZeroScope::Run,
        ..one
    };
    [one, four, six]
}

/// Another seed for each run of the tests that asks for it: `STIFFBENCH_SEED`, of the hash of a commit for what is reported.
fn seed_of(number: u64) -> u64 {
    let asked = std::env::var("STIFFBENCH_SEED").unwrap_or_default();
    let base = u64::from_str_radix(&asked, 16).unwrap_or_default();
    base.wrapping_mul(10_000).wrapping_add(number)
}

/// A bench whose runs scatter in their slopes, with normal tails or those of Student's t with four degrees of freedom.
fn bench(procedure: &Procedure, number: u64, slope_sd: f64, heavy: bool) -> Rig {
    let seed = seed_of(number);
    let mut rig = Rig::start(procedure);
    rig.bench.seed = seed;
    rig.answer(&[("implausible", "accept"), ("displacement-sign", "accept")]);
    rig.bench.noise_si = [0.02, 0.4e-6];
    rig.bench.preload_off_n = 0.15;
    for cell in 0..8 {
        for repeat in 1..=5 {
            let key = |i: u32| (seed, cell, repeat, i);
            let chi: f64 = (1..5).map(|i| normal(key(i)).powi(2)).sum();
            // Both have a variance of 1.
            let divisor = if heavy { (chi / 2.0).sqrt() } else { 1.0 };
            let slope = slope_sd * normal(key(0)) / divisor;
            let run = RunDeviation {
                slope,
                ..RunDeviation::default()
            };
            rig.bench.runs.insert((cell, repeat), run);
        }
    }
    rig
}

/// The first question of each session that has one beside the usual ones.
fn questions(session: impl Fn(u64) -> Rig) -> Vec<String> {
    let unusual = [
        "bad-reading",
        "implausible",
        "drift",
        "frozen",
        "displacement-sign",
    ];
    let mut asked = Vec::new();
    for seed in 0..SESSIONS {
        let mut rig = session(seed);
        assert_eq!(rig.run(), Some(SessionEnd::Complete));
        let mut prompts = rig.asked.into_iter();
        let first = prompts.find(|prompt| unusual.contains(&prompt.id.as_str()));
        asked.extend(first.map(|prompt| prompt.text));
    }
    asked
}

#[test]
#[ignore = "a minute; `just nightly` runs it"]
fn clean_sessions_are_seldom_asked_about() {
    for (slope_sd, heavy) in [
        (0.0, false),
        (0.004, false),
        (0.004, true),
        (0.008, false),
        (0.008, true),
    ] {
        let asked = questions(|seed| bench(&procedure(), seed, slope_sd, heavy));
        println!("{slope_sd} {heavy}: {} asked, {asked:#?}", asked.len());
        assert!(asked.len() <= SESSIONS as usize / 10, "{}", asked.len());
    }
}

/// Benches whose readings and zeros scatter as those that the program emulates: a dial read by eye.
#[test]
#[ignore = "a minute; `just nightly` runs it"]
fn clean_sessions_at_a_noisy_bench_are_seldom_asked_about() {
    for procedure in other_procedures() {
        for resumed in [false, true] {
            for scatter_m in [[1e-6, 1e-6], [3e-6, 2.5e-6]] {
                let asked = questions(|seed| {
                    let mut rig = bench(&procedure, 5000 + seed, 0.004, false);
                    rig = rig.scatters(&procedure, scatter_m[0]);
                    for ((cell, repeat), run) in &mut rig.bench.runs {
                        // A zero for each run, or one for all.
                        let run_of_zero = match procedure.zero {
                            ZeroScope::Cell => 1,
                            ZeroScope::Run => *repeat,
                        };
                        run.offset_m = scatter_m[1] * normal((seed_of(seed), *cell, run_of_zero));
                    }
                    if resumed {
                        let third = procedure.loads_n.len() * procedure.repeats as usize / 3;
                        rig.until(100_000, |rig| rig.bench.taken.0 > third);
                        let (bench, answers) = (rig.bench.clone(), rig.answers.clone());
                        rig = Rig::resume(&procedure, &rig.journal_bytes(), bench);
                        rig.answers = answers;
                    }
                    rig
                });
                let cells = procedure.directions.len();
                println!(
                    "{cells} {resumed} {scatter_m:?}: {} asked, {asked:#?}",
                    asked.len()
                );
                assert!(asked.len() <= SESSIONS as usize / 10, "{}", asked.len());
            }
        }
    }
}

#[test]
#[ignore = "a minute; `just nightly` runs it"]
fn six_predictive_standard_deviations_are_asked_about() {
    for slope_sd in [0.0, 0.004, 0.008] {
        for kind in 0..3 {
            let mut asked = 0;
            for seed in 0..SESSIONS {
                let mut rig = bench(&procedure(), 1000 + seed, slope_sd, false);
                let cell = (4.0 * uniform((seed, kind, 1))) as usize;
                let repeat = 2 + (2.0 * uniform((seed, kind, 2))) as u32;
                rig.until(100_000, |rig| {
                    let view = rig.machine.view();
                    let purpose = Purpose::Reading;
                    matches!(view.task, Task::Load { purpose: of, .. } if of == purpose)
                        && view
                            .place
                            .is_some_and(|at| (at.cell, at.repeat) == (cell, repeat))
                });
                let from = rig.said.iter().rev().find_map(|line| {
                    let numbers = line.strip_prefix("the next run is asked about from ")?;
                    let words = numbers
                        .split(' ')
                        .filter_map(|word| word.parse::<f64>().ok());
                    Some(words.collect::<Vec<f64>>())
                });
                let from = from.expect("it is said");
                let sense = if uniform((seed, 3)) < 0.5 { -1.0 } else { 1.0 };
                let run = rig.bench.runs.get_mut(&(cell, repeat)).unwrap();
                match kind {
                    // The program assumes less at first than these runs scatter.
                    0 => {
                        let six = 6.0 * slope_sd * (1.0 + 1.0 / f64::from(repeat - 1)).sqrt();
                        run.slope += sense * six.max(SIX * from[0] / 100.0);
                    }
                    1 => run.offset_m = sense * SIX * from[1] * 1e-6,
                    _ => run.load = Some((1 + seed as u32 % 4, sense * SIX * from[2] * 1e-6)),
                }
                assert_eq!(rig.run(), Some(SessionEnd::Complete));
                let at_it = |kept: &KeptReading| {
                    (kept.taken.cell, kept.taken.repeat) == (cell, repeat)
                        && !kept.flag().is_empty()
                };
                asked += usize::from(rig.machine.state().readings.iter().any(at_it));
            }
            println!("{slope_sd} {kind}: {asked} of {SESSIONS}");
            assert!(
                asked >= SESSIONS as usize * 9 / 10,
                "{slope_sd} {kind}: {asked}"
            );
        }
    }
}

#[test]
fn no_display_of_a_clean_session_is_taken_for_held() {
    let mut asked = Vec::new();
    for seed in 0..SESSIONS {
        let mut procedure = procedure();
        procedure.settle.dwell_s = [0.3, 0.8, 2.0][seed as usize % 3];
        procedure.settle.spread_m = 20e-6;
        let mut rig = bench(&procedure, 2000 + seed, 0.002, false);
        // Decimals of a millimetre, and noise in steps of the last.
        let (decimals, noise) = [
            (4, 0.1),
            (4, 5.0),
            (3, 0.1),
            (3, 0.4),
            (3, 2.0),
            (2, 0.05),
            (2, 0.3),
        ][seed as usize % 7];
        let step_m = 10_f64.powi(-3 - decimals as i32);
        (rig.bench.decimals, rig.bench.step_m) = (decimals, step_m);
        rig.bench.noise_si = [0.3 * uniform((seed, 9)), noise * step_m];
        assert_eq!(rig.run(), Some(SessionEnd::Complete), "{seed}");
        let frozen = rig.asked.iter().filter(|prompt| prompt.id == "frozen");
        asked.extend(frozen.map(|prompt| format!("{seed}: {}", prompt.text)));
    }
    assert!(asked.is_empty(), "{asked:#?}");
}
