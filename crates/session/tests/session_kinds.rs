//! Kinds of faults of gauges, stands and operators: no value that is false passes without a flag, and sessions without a fault are complete.
//!
//! A reading is false if it counts, has no flag, and its force is off by more than 0.35 N or its displacement by more than 6 um.

use crate::support::{Display, MockBench, Rig, RunDeviation, short, uniform};
use stiffbench_gauges::Channel;
use stiffbench_measurement::procedure::Procedure;
use stiffbench_measurement::readings::{RepeatOrder, ZeroScope};
use stiffbench_session::{Input, OperatorEvent, SessionEnd};
use stiffbench_units_and_text::test_point::Direction;

const MOST_OFF: [f64; 2] = [0.35, 6e-6];

/// Enough for five sessions like these.
const MOST_TICKS: usize = 20_000;

/// What is done to a session, and what it has to come to.
struct Fault {
    name: &'static str,
    /// Whether nothing is wrong: then it is complete, and no reading is flagged.
    control: bool,
    procedure: fn(&mut Procedure),
    begin: fn(&mut Rig),
    displays: [Option<Display>; 2],
    /// A run that differs.
    run: Option<(u32, RunDeviation)>,
    /// At every tick.
    happens: Happening,
}

type Happening = fn(&mut Rig);

const NOTHING: Fault = Fault {
    name: "",
    control: false,
    procedure: |_| (),
    begin: |_| (),
    displays: [None; 2],
    run: None,
    happens: |_| (),
};

fn happens(name: &'static str, happens: Happening) -> Fault {
    Fault {
        name,
        happens,
        ..NOTHING
    }
}

fn begins(name: &'static str, begin: fn(&mut Rig)) -> Fault {
    Fault {
        name,
        begin,
        ..NOTHING
    }
}

/// Displays that are right, though late: of such ones a simulated hand makes an oscillator.
fn fine(name: &'static str, force: Display, dial: Display) -> Fault {
    Fault {
        control: true,
        displays: [Some(force), Some(dial)],
        ..begins(name, |rig| rig.bench.by_display = false)
    }
}

fn run(bench: &MockBench) -> u32 {
    bench.at.0.1
}

/// The value of so many ticks ago, by the force then.
fn late(bench: &MockBench, value: f64, ticks: usize, per_n: f64) -> f64 {
    let past = bench.past_n.iter().rev().nth(ticks);
    value + per_n * (past.copied().unwrap_or(bench.force_n) - bench.force_n)
}

/// The mean of so many ticks.
fn averaged(bench: &MockBench, value: f64, ticks: usize, per_n: f64) -> f64 {
    let past = bench.past_n.iter().rev().take(ticks);
    let mean = past.sum::<f64>() / bench.past_n.len().clamp(1, ticks) as f64;
    value + per_n * (mean - bench.force_n)
}

/// Displacement of the bench per force, m/N.
const PER_N: f64 = 5e-6;

fn every(bench: &MockBench, ticks: i64) -> bool {
    (bench.now_s * 10.0).round() as i64 % ticks == 0
}

/// One of two values.
fn either(first: bool, one: f64, other: f64) -> f64 {
    if first { one } else { other }
}

#[rustfmt::skip]
fn of_dials() -> Vec<Fault> {
    let kinds: [(&str, Display); 18] = [
        ("it ends its travel at 300 um", |_, v| v.max(-300e-6)),
        ("it ends its travel in run 2", |b, v| v.max(either(run(b) == 2, -250e-6, v))),
        ("it is 40 um off from reading 8 on", |b, v| v + either(b.taken.0 >= 7, 40e-6, 0.0)),
        ("it is 40 um off for two loads", |b, v| v + either((7..9).contains(&b.taken.0), 40e-6, 0.0)),
        ("every seventh value is 200 um off", |b, v| v + either(every(b, 7), 200e-6, 0.0)),
        ("it flickers by 8 um", |b, v| v + either(every(b, 2), 8e-6, 0.0)),
        ("it is 1 s late", |b, v| late(b, v, 10, PER_N)),
        ("it is 3 s late", |b, v| late(b, v, 30, PER_N)),
        ("it averages over 1 s", |b, v| averaged(b, v, 10, PER_N)),
        ("it averages over 2 s", |b, v| averaged(b, v, 20, PER_N)),
        ("it counts the other way from reading 5 on", |b, v| v * either(b.taken.0 >= 4, -1.0, 1.0)),
        ("it shows inches from reading 5 on", |b, v| v / either(b.taken.0 >= 4, 25.4, 1.0)),
        ("it shows a tenth in run 2", |b, v| v / either(run(b) == 2, 10.0, 1.0)),
        ("it drifts by 0.3 um/s", |b, v| v + 0.3e-6 * b.now_s),
        ("it creeps by 4 um/s under load", |b, v| v - either(b.loaded, 4e-6 * (b.now_s - b.taken.1), 0.0)),
        ("every other value is zero", |b, v| either(every(b, 2), 0.0, v)),
        ("it stays before the fourth load of run 2", |b, v| either(b.taken.0 == 8 && b.force_n < -31.0, -155e-6, v)),
        ("it has steps of 10 um from run 2 on", |b, v| either(run(b) > 1, (v / 10e-6).round() * 10e-6, v)),
    ];
    let fault = |(name, dial)| Fault { displays: [None, Some(dial)], name, ..NOTHING };
    kinds.map(fault).into()
}

#[rustfmt::skip]
fn of_force_gauges() -> Vec<Fault> {
    let kinds: [(&str, Display); 17] = [
        ("it ends its range at 40 N", |_, v| v.min(40.0)),
        ("it shows kgf from reading 4 on", |b, v| v / either(b.taken.0 >= 3, 9.806_65, 1.0)),
        ("it shows lbf from reading 4 on", |b, v| v / either(b.taken.0 >= 3, 4.448_222, 1.0)),
        ("it is 2 N off in run 2 under load", |b, v| v + either(run(b) == 2 && b.loaded, 2.0, 0.0)),
        ("it is 1 N off from reading 9 on", |b, v| v + either(b.taken.0 >= 8, 1.0, 0.0)),
        ("it shows 5 % more in run 2", |b, v| v * either(run(b) == 2, 1.05, 1.0)),
        ("it is 1 s late", |b, v| late(b, v, 10, -1.0)),
        ("it is 3 s late", |b, v| late(b, v, 30, -1.0)),
        ("it averages over 2 s", |b, v| averaged(b, v, 20, -1.0)),
        ("it counts the other way from reading 5 on", |b, v| v * either(b.taken.0 >= 4, -1.0, 1.0)),
        ("it drifts by 0.02 N/s", |b, v| v + 0.02 * b.now_s),
        ("it has steps of 1 N from run 2 on", |b, v| either(run(b) > 1, v.round(), v)),
        ("it swings by 2 N in 1 s", |b, v| v + 2.0 * (b.now_s * std::f64::consts::TAU).sin()),
        ("every ninth value is 20 N off", |b, v| v + either(every(b, 9), 20.0, 0.0)),
        ("every other value is zero", |b, v| either(every(b, 2), 0.0, v)),
        ("it shows tenfold at the third load of run 2", |b, v| v * either(b.taken.0 == 7, 10.0, 1.0)),
        ("it stays at 25 N in run 3", |b, v| either(run(b) == 3, v.min(25.0), v)),
    ];
    let fault = |(name, force)| Fault { displays: [Some(force), None], name, ..NOTHING };
    let mut kinds: Vec<Fault> = kinds.map(fault).into();
    kinds.push(Fault {
        name: "both gauges have other scales in run 3",
        displays: [
            Some(|b, v| v * either(run(b) == 3, 0.8, 1.0)),
            Some(|b, v| v * either(run(b) == 3, 0.5, 1.0)),
        ],
        ..NOTHING
    });
    kinds.extend([
        fine("the dial sends every third value only", |_, v| v, |b, v| either(every(b, 3), v, f64::NAN)),
        fine("the force gauge pauses for 2 s of 12", |b, v| either(b.now_s % 12.0 > 2.0, v, f64::NAN), |_, v| v),
        fine("each force comes twice", |b, v| late(b, v, usize::from(every(b, 2)), -1.0), |_, v| v),
        fine("both gauges are 0.5 s late", |b, v| late(b, v, 5, -1.0), |b, v| late(b, v, 5, PER_N)),
    ]);
    kinds
}

#[rustfmt::skip]
fn of_runs() -> Vec<Fault> {
    let sweep: fn(&mut Procedure) = |_| ();
    let one_zero: fn(&mut Procedure) = |p| p.zero = ZeroScope::Cell;
    let unloading: fn(&mut Procedure) = |p| p.unloading = true;
    let at_load: fn(&mut Procedure) = |p| {
        p.zero = ZeroScope::Cell;
        p.repeat_order = RepeatOrder::AtLoad;
    };
    let no = RunDeviation::default();
    let slope = |slope| RunDeviation { slope, ..no };
    let offset = |um: f64| RunDeviation { offset_m: um * 1e-6, ..no };
    let load = |step, um: f64| RunDeviation { load: Some((step, um * 1e-6)), ..no };
    let kinds = [
        ("5 % softer", sweep, 2, slope(0.05)),
        ("5 % stiffer", sweep, 3, slope(-0.05)),
        ("10 um off", sweep, 2, offset(10.0)),
        ("15 um off", sweep, 3, offset(-15.0)),
        ("one load 15 um off", sweep, 2, load(2, 15.0)),
        ("last load 15 um off", sweep, 3, load(4, -15.0)),
        ("one zero: 5 % softer", one_zero, 2, slope(0.05)),
        ("one zero: 10 um off", one_zero, 2, offset(10.0)),
        ("one zero: one load 15 um off", one_zero, 2, load(2, 15.0)),
        ("unloading: 5 % softer", unloading, 2, slope(0.05)),
        ("unloading: one load 15 um off", unloading, 2, load(2, 15.0)),
        ("at load: one repeat 15 um off", at_load, 2, load(2, 15.0)),
        ("at load: the second repeats 10 um off", at_load, 2, offset(10.0)),
    ];
    let fault = |(name, procedure, repeat, run)| Fault {
        name,
        procedure,
        run: Some((repeat, run)),
        ..NOTHING
    };
    kinds.map(fault).into()
}

fn rejects(rig: &mut Rig, ticks: i64, raw: &str) {
    if every(&rig.bench, ticks) {
        rig.reject(Channel::Force, raw);
    }
}

/// At so many readings, once under a load.
fn once(rig: &mut Rig, taken: usize, below_n: f64, change: fn(&mut MockBench)) {
    if rig.bench.taken.0 == taken && rig.bench.force_n < below_n && rig.bench.left_on_n == 0.0 {
        rig.bench.left_on_n = 1e-9;
        change(&mut rig.bench);
    }
}

fn replugged(rig: &mut Rig, channel: Channel, shift: f64) {
    if rig.bench.taken.0 == 7 && rig.bench.left_on_n == 0.0 {
        // Once.
        rig.bench.left_on_n = 1e-9;
        rig.unplug(channel);
        rig.plug_in(channel);
        rig.bench.shift(channel, shift);
    }
}

#[rustfmt::skip]
fn of_operators() -> Vec<Fault> {
    let kinds: [(&str, Happening); 11] = [
        ("the dial is zeroed under load", |rig| once(rig, 7, -25.0, |b| b.tare(Channel::Displacement))),
        ("the force gauge is zeroed under load", |rig| once(rig, 7, -25.0, |b| b.tare(Channel::Force))),
        ("both gauges are zeroed under load", |rig| once(rig, 7, -25.0, |b| {
            b.tare(Channel::Force);
            b.tare(Channel::Displacement);
        })),
        ("the stand is pushed by 30 um", |rig| once(rig, 8, -25.0, |b| b.shift(Channel::Displacement, 30e-6))),
        ("the dial is held from reading 9 on", |rig| once(rig, 8, -25.0, |b| b.hold(Channel::Displacement))),
        ("the force gauge is held from reading 9 on", |rig| once(rig, 8, -40.0, |b| b.hold(Channel::Force))),
        ("the dial comes back with another zero", |rig| replugged(rig, Channel::Displacement, 25e-6)),
        ("the force gauge comes back with another zero", |rig| replugged(rig, Channel::Force, 2.0)),
        ("5 N are left on while run 2 is zeroed", |rig| rig.bench.left_on_n = either(rig.bench.taken.0 == 5, -5.0, 0.0)),
        ("keys are pressed before it settles", |rig| {
            if every(&rig.bench, 3) {
                rig.operator(OperatorEvent::Capture);
            }
        }),
        ("an error comes every 4 s", |rig| rejects(rig, 40, "ERR1")),
    ];
    let mut kinds: Vec<Fault> = kinds.map(|(name, of)| happens(name, of)).into();
    kinds.push(begins("the dial keeps 12 um when it is zeroed", |rig| rig.bench.leaves_si[1] = 12e-6));
    let clean = [
        begins("nothing", |_| ()),
        begins("a fine dial", |rig| {
            (rig.bench.step_m, rig.bench.decimals, rig.bench.noise_si) = (0.1e-6, 4, [0.05, 0.2e-6]);
        }),
        begins("a noisy force gauge", |rig| rig.bench.noise_si = [0.1, 0.4e-6]),
        begins("no gauge has a command for its zero", |rig| rig.bench.has_zero = [false; Channel::COUNT]),
        begins("runs that scatter by 0.3 %", |rig| for repeat in 1..=3 {
            let slope = 0.006 * (uniform((rig.bench.seed, repeat)) - 0.5);
            rig.bench.runs.insert((0, repeat), RunDeviation { slope, ..RunDeviation::default() });
        }),
        happens("a warning of the battery comes twice a second", |rig| rejects(rig, 5, "LOW BATT")),
        happens("time is lost", |rig| {
            if every(&rig.bench, 150) {
                rig.input(Input::Gap);
            }
        }),
        happens("pauses", |rig| {
            if every(&rig.bench, 200) {
                rig.operator(OperatorEvent::Pause);
                rig.operator(OperatorEvent::Pause);
            }
        }),
    ];
    kinds.extend(clean.map(|fault| Fault { control: true, ..fault }));
    kinds
}

fn kinds() -> Vec<Fault> {
    let kinds = of_dials().into_iter().chain(of_force_gauges());
    kinds.chain(of_runs()).chain(of_operators()).collect()
}

/// The answers of somebody who wants it right, and of somebody who wants it done.
const ANSWERS: [(&str, [&str; 2]); 13] = [
    ("frozen", ["skip", "accept"]),
    ("implausible", ["skip", "accept"]),
    ("displacement-sign", ["skip", "accept"]),
    ("zero-not-shown", ["again", "subtract"]),
    ("changed", ["again", "flag"]),
    ("force-steps", ["skip", "accept"]),
    ("displacement-steps", ["skip", "accept"]),
    ("drift", ["redo", "keep"]),
    ("bad-reading", ["redo", "keep"]),
    ("not-settled", ["wait", "take"]),
    ("force-offset", ["wait", "zero"]),
    ("force-sign", ["wait", "flip"]),
    ("limit", ["skip", "accept"]),
];

/// How a session ended, the readings that are false, and how many have a flag.
fn session(kind: &Fault, seed: u64, operator: usize) -> (Option<SessionEnd>, Vec<String>, usize) {
    let mut procedure = Procedure {
        loads_n: vec![0.0, -15.0, -30.0, -45.0, -60.0],
        directions: vec![Direction::X.into()],
        repeats: 3,
        ..short(false)
    };
    procedure.zero = ZeroScope::Run;
    procedure.settle.dwell_s = 0.8;
    (kind.procedure)(&mut procedure);
    let mut rig = Rig::start(&procedure);
    rig.bench.seed = seed;
    rig.bench.noise_si = [0.02, 0.4e-6];
    rig.bench.preload_off_n = 0.15;
    rig.bench.by_display = true;
    rig.answer(&ANSWERS.map(|(id, words)| (id, words[operator])));
    (kind.begin)(&mut rig);
    if let Some((repeat, run)) = kind.run {
        rig.bench.runs.insert((0, repeat), run);
    }
    // The sign is learnt from gauges that are right.
    for _ in 0..MOST_TICKS {
        if rig.machine.outcome().is_some() {
            break;
        }
        if rig.machine.state().zero.is_some() {
            rig.bench.displays = kind.displays;
            (kind.happens)(&mut rig);
        }
        rig.tick();
    }
    let state = rig.machine.state();
    let readings = state.readings.iter().zip(&rig.truth);
    let plain = readings.filter(|(kept, _)| kept.superseded.is_none() && kept.flag().is_empty());
    let off = plain.filter(|(kept, [force_n, moved_m])| {
        let off_n = (kept.taken.force_n - force_n).abs();
        let off_m = (kept.taken.displacement_m - moved_m).abs();
        off_n > MOST_OFF[0] || off_m > MOST_OFF[1]
    });
    let off = off.map(|(kept, [force_n, moved_m])| {
        format!(
            "{}: {:.2} N for {force_n:.2}, {:.1} um for {:.1}",
            kept.taken.number,
            kept.taken.force_n,
            kept.taken.displacement_m * 1e6,
            moved_m * 1e6
        )
    });
    let off = off.collect();
    let flagged = state.accepted().filter(|kept| !kept.flag().is_empty());
    (rig.machine.outcome(), off, flagged.count())
}

#[test]
fn no_kind_of_fault_puts_a_false_value_in_and_no_clean_session_is_held_up() {
    let kinds = kinds();
    assert!(kinds.len() >= 60, "{}", kinds.len());
    let mut bad = Vec::new();
    for kind in &kinds {
        for operator in 0..2 {
            for seed in 0..3 {
                let (ended, off, flagged) = session(kind, seed, operator);
                let is_clean = ended == Some(SessionEnd::Complete) && flagged == 0;
                if !off.is_empty() || (kind.control && !is_clean) {
                    bad.push(format!(
                        "{} ({operator}, {seed}): {ended:?}, {flagged} flagged, {off:?}",
                        kind.name
                    ));
                }
            }
        }
    }
    assert!(
        bad.is_empty(),
        "{} of {}: {bad:#?}",
        bad.len(),
        6 * kinds.len()
    );
}
