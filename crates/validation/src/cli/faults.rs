//! `stiffbench-validate faults`: every fault of a line or gauge in every phase of a session, and what became of the readings.

use std::fmt::Write;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use stiffbench::analysis::{ArgumentError, ModelChoice, ResolvedModel, resolve};
use stiffbench::bench::EmulatedSetup;
use stiffbench::cli::args::Global;
use stiffbench::cli::emulated::Emulation;
use stiffbench::cli::failure::Failure;
use stiffbench::cli::gauge::ProtocolsArgs;
use stiffbench::cli::outcome::Outcome;
use stiffbench::cli::progress::progress;
use stiffbench::clock::Clock;
use stiffbench::instrument::Channel;
use stiffbench::instrument::emulator::{FaultScript, ScriptedFault};
use stiffbench::procedure::{Procedure, Settle};
use stiffbench::quantity::METRES_PER_MICROMETRE;
use stiffbench::readings::{Reading, RepeatOrder, ZeroScope};
use stiffbench::report::Table;
use stiffbench::source_text::SourceText;
use stiffbench::test_point::{Branch, Direction, PoseId};

use crate::report::{FaultEffect, FaultReport, FaultTrialReport};

use super::rehearsal::{Rehearsal, Rehearsed};
use stiffbench::cli::rehearsal::PHASES;

/// Arguments of `faults`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  stiffbench-validate faults                     every fault in every phase, some minutes\n  stiffbench-validate faults --phase settle\n  stiffbench-validate faults --fault unplug --fault swap"
)]
pub(crate) struct FaultsArgs {
    /// Only this fault; more than once for more
    #[arg(long = "fault", value_name = "NAME")]
    faults: Vec<String>,
    /// Only this phase; more than once for more
    #[arg(long = "phase", value_name = "NAME")]
    phases: Vec<String>,
    /// Description of the force gauge
    #[arg(long, default_value = "mark10-series5", value_name = "NAME")]
    force_instrument: String,
    /// Description of the displacement gauge
    #[arg(long, default_value = "mahr-dk-u1", value_name = "NAME")]
    displacement_instrument: String,
    /// Sessions at a time; they wait most of their time
    #[arg(long, default_value_t = 8, value_parser = clap::value_parser!(u16).range(1..=64))]
    at_a_time: u16,
    /// Seed of the bench
    #[arg(long, default_value_t = 0)]
    seed: u64,
}

/// A fault with its entry in a fault script, without its moment; and what mends it where it does not end by itself.
struct FaultCase {
    name: &'static str,
    entry: &'static str,
    mend: &'static str,
}

const fn case(name: &'static str, entry: &'static str) -> FaultCase {
    FaultCase {
        name,
        entry,
        mend: "",
    }
}

/// Every fault, on one gauge or the other.
const CASES: [FaultCase; 22] = [
    case(
        "partial packets",
        "gauge = \"force\"\nwhat = \"partial-packet\"\nby_s = 0.2\nfor_s = 4.0",
    ),
    case(
        "cut packets",
        "gauge = \"displacement\"\nwhat = \"cut-packet\"\nfor_packets = 3",
    ),
    case(
        "merged packets",
        "gauge = \"force\"\nwhat = \"merged-packets\"\npackets = 3\nfor_s = 4.0",
    ),
    case(
        "garbage",
        "gauge = \"displacement\"\nwhat = \"garbage\"\nfor_packets = 5",
    ),
    case(
        "NUL before a packet",
        "gauge = \"displacement\"\nwhat = \"nul\"\nfor_packets = 5",
    ),
    FaultCase {
        name: "unit switched, force",
        entry: "gauge = \"force\"\nwhat = \"unit\"\nunit = \"lbF\"",
        mend: "force unit unit=N",
    },
    FaultCase {
        name: "unit switched, displacement",
        entry: "gauge = \"displacement\"\nwhat = \"unit\"\nunit = \"inch\"",
        mend: "displacement unit unit=mm",
    },
    case(
        "sign inverted, force",
        "gauge = \"force\"\nwhat = \"sign-inverted\"\nfor_s = 8.0",
    ),
    case(
        "sign inverted, displacement",
        "gauge = \"displacement\"\nwhat = \"sign-inverted\"\nfor_s = 8.0",
    ),
    case(
        "peak mode",
        "gauge = \"force\"\nwhat = \"peak-mode\"\nfor_s = 8.0",
    ),
    case(
        "hold",
        "gauge = \"displacement\"\nwhat = \"hold\"\nfor_s = 8.0",
    ),
    case(
        "overload",
        "gauge = \"force\"\nwhat = \"overload\"\nfor_s = 6.0",
    ),
    case(
        "low battery",
        "gauge = \"force\"\nwhat = \"low-battery\"\nfor_s = 6.0",
    ),
    case(
        "frozen value, force",
        "gauge = \"force\"\nwhat = \"frozen\"\nfor_s = 8.0",
    ),
    case(
        "frozen value, displacement",
        "gauge = \"displacement\"\nwhat = \"frozen\"\nfor_s = 8.0",
    ),
    case(
        "echo",
        "gauge = \"displacement\"\nwhat = \"echo\"\nfor_s = 6.0",
    ),
    case(
        "late reply",
        "gauge = \"force\"\nwhat = \"late-reply\"\nby_s = 5.0\nfor_packets = 2",
    ),
    case(
        "silence",
        "gauge = \"displacement\"\nwhat = \"silence\"\nfor_s = 8.0",
    ),
    case(
        "key at the gauge",
        "gauge = \"displacement\"\nwhat = \"data-key\"",
    ),
    case(
        "unplugged",
        "gauge = \"displacement\"\nwhat = \"unplug\"\nfor_s = 3.0",
    ),
    FaultCase {
        name: "adapters swapped",
        entry: "what = \"swap\"\nfor_s = 1.2",
        mend: "both swap for_s=1.2",
    },
    case("machine suspended", "what = \"suspend\"\nfor_s = 6.0"),
];

/// How much faster than real a rehearsal is, its lines too; times in the scripts are of the line.
const SPEED: f64 = 4.0;

/// Largest difference of an accepted reading from the one without a fault: what a settled reading and its zero may move by, and two steps of the
/// force gauge.
const SAME_M: f64 = 4e-6;
const SAME_N: f64 = 0.21;

/// A fault in a phase.
struct FaultTrial {
    case: usize,
    phase: &'static str,
}

/// Rehearses all that is asked for, and prints what became of it.
pub(crate) fn run(args: &FaultsArgs, global: &Global) -> Result<Outcome, Failure> {
    let cases = chosen_of(&args.faults, CASES.iter().map(|case| case.name), "--fault")?;
    let phases = chosen_of(&args.phases, phases(), "--phase")?;
    let phases: Vec<&str> = phases
        .into_iter()
        .filter_map(|at| self::phases().nth(at))
        .collect();
    let choice = ModelChoice {
        robot: Some("hp-robot".to_owned()),
        ..ModelChoice::default()
    };
    let resolved = resolve(&choice, None)?;
    let trials: Vec<FaultTrial> = cases
        .iter()
        .flat_map(|&case| phases.iter().map(move |&phase| FaultTrial { case, phase }))
        .collect();
    let bar = progress(global, "faults", trials.len() as u64);
    let truths = [false, true].map(|at_load| rehearse(args, &resolved, at_load, None));
    let [sweep, at_load] = truths;
    let truths = [sweep?, at_load?];
    let next = AtomicUsize::new(0);
    let done = Mutex::new(Vec::new());
    std::thread::scope(|scope| {
        for _ in 0..args.at_a_time {
            scope.spawn(|| {
                while let Some(trial) = trials.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let rehearsed =
                        rehearse(args, &resolved, trial.phase == "release", Some(trial));
                    let mut done = done
                        .lock()
                        .unwrap_or_else(std::sync::PoisonError::into_inner);
                    done.push((trial, rehearsed));
                    bar.inc(1);
                }
            });
        }
    });
    bar.finish_and_clear();
    let mut results = Vec::new();
    for (trial, rehearsed) in done.into_inner().unwrap_or_default() {
        let mut rehearsed = rehearsed?;
        let truth = &truths[usize::from(trial.phase == "release")];
        results.push((trial, effect(&mut rehearsed, truth), rehearsed));
    }
    Ok(report(&cases, &phases, &results))
}

/// Phases that a first session has; another load is only applied again after an interruption.
fn phases() -> impl Iterator<Item = &'static str> {
    PHASES.into_iter().filter(|phase| *phase != "again")
}

/// Places of the names that were given, or all.
fn chosen_of<'a>(
    given: &[String],
    known: impl Iterator<Item = &'a str>,
    argument: &str,
) -> Result<Vec<usize>, ArgumentError> {
    let known: Vec<&str> = known.collect();
    if given.is_empty() {
        return Ok((0..known.len()).collect());
    }
    let mut places = Vec::new();
    for name in given {
        let matching: Vec<usize> = (0..known.len())
            .filter(|&at| known[at].contains(name.as_str()))
            .collect();
        if matching.is_empty() {
            return Err(ArgumentError::new(
                format!("{argument} {name}"),
                "there is none of that name",
                known.join(", "),
            ));
        }
        places.extend(matching);
    }
    Ok(places)
}

/// A short session of all phases: one pose and direction, two runs up and down with a hold, or each load twice with a release in between.
fn procedure(at_load: bool) -> Procedure {
    let holds_s = if at_load { vec![] } else { vec![3.0] };
    Procedure {
        name: "rehearsal".to_owned(),
        poses: Some(vec![PoseId::new("P1")]),
        directions: vec![Direction::Y.into()],
        loads_n: vec![0.0, -20.0, -40.0],
        unloading: !at_load,
        repeats: 2,
        repeat_order: if at_load {
            RepeatOrder::AtLoad
        } else {
            RepeatOrder::Sweep
        },
        zero: if at_load {
            ZeroScope::Cell
        } else {
            ZeroScope::Run
        },
        holds_s,
        settle: Settle {
            dwell_s: 1.5,
            ..Settle::default()
        },
        ..Procedure::default()
    }
}

fn rehearse(
    args: &FaultsArgs,
    resolved: &ResolvedModel,
    at_load: bool,
    trial: Option<&FaultTrial>,
) -> Result<Rehearsed, Failure> {
    let (faults, mend) = match trial {
        Some(trial) => script(&CASES[trial.case], trial.phase)?,
        None => (FaultScript::default(), Vec::new()),
    };
    let procedure = procedure(at_load);
    Rehearsal {
        emulation: Emulation {
            resolved,
            procedure: &procedure,
            gauges: vec![
                (Channel::Force, args.force_instrument.clone()),
                (Channel::Displacement, args.displacement_instrument.clone()),
            ],
            protocols: &ProtocolsArgs::default(),
            setup: EmulatedSetup {
                seed: args.seed,
                ..EmulatedSetup::default()
            },
            session: Clock::starting_at(0.0, SPEED),
            faults,
            links: None,
        },
        mend,
    }
    .run()
}

/// The script of a fault in a phase, and what mends it.
fn script(case: &FaultCase, phase: &str) -> Result<(FaultScript, Vec<ScriptedFault>), Failure> {
    let text = format!(
        "schema = \"stiffbench/faults/1\"\n[[fault]]\n{}\nphase = {phase:?}\n",
        case.entry
    );
    let script = FaultScript::parse(&SourceText::new("rehearsal", text))?;
    let mend = match case.mend {
        "" => Vec::new(),
        line => vec![FaultScript::parse_line(line)?],
    };
    Ok((script, mend))
}

/// Compares what was accepted with what the same bench gives without a fault; readings that differ are said.
fn effect(rehearsed: &mut Rehearsed, truth: &Rehearsed) -> FaultEffect {
    let right = places(&truth.readings);
    let same = |place: &ReadingKey| right.iter().find(|(known, _)| known == place);
    let differs = |(place, reading): &&(ReadingKey, &Reading)| {
        same(place).is_none_or(|(_, same)| {
            (same.force_n - reading.force_n).abs() > SAME_N
                || (same.displacement_m - reading.displacement_m).abs() > SAME_M
        })
    };
    let mut taken = places(&rehearsed.readings);
    // A flag states that a reading is doubtful.
    taken.retain(|(_, reading)| !is_flagged(reading));
    let wrong = taken.iter().filter(differs).map(|(place, reading)| {
        let (step, repeat, branch) = (reading.step, reading.repeat, reading.branch);
        let right = same(place).map_or("no such reading".to_owned(), |(_, right)| shown(right));
        let reading = shown(reading);
        format!("FALSE: step {step}, repeat {repeat}, {branch}: {reading}, not {right}")
    });
    let wrong: Vec<String> = wrong.collect();
    // Messages of a session without a fault are no effect of the fault.
    rehearsed.said.retain(|line| !truth.said.contains(line));
    if !wrong.is_empty() {
        rehearsed.said.splice(0..0, wrong);
        FaultEffect::FalseReading
    } else if rehearsed.readings.len() < rehearsed.planned {
        FaultEffect::Stuck
    } else if rehearsed.resumes > 0 {
        FaultEffect::Resumed
    } else {
        FaultEffect::Survived
    }
}

fn is_flagged(reading: &Reading) -> bool {
    let text = reading.text.as_ref();
    text.is_some_and(|text| !text.flag.is_empty())
}

/// Both values of a reading.
fn shown(reading: &Reading) -> String {
    let um = reading.displacement_m / METRES_PER_MICROMETRE;
    format!("{:.1} N and {um:.1} um", reading.force_n)
}

/// Which planned reading it is: step, repeat, branch, and which of those that share them, as holds do.
type ReadingKey = (u32, u32, Branch, usize);

fn places(readings: &[Reading]) -> Vec<(ReadingKey, &Reading)> {
    let mut places: Vec<(ReadingKey, &Reading)> = Vec::new();
    for reading in readings {
        let of = (reading.step, reading.repeat, reading.branch);
        let same = places
            .iter()
            .filter(|(place, _)| (place.0, place.1, place.2) == of);
        let nth = same.count();
        places.push(((of.0, of.1, of.2, nth), reading));
    }
    places
}

fn report(
    cases: &[usize],
    phases: &[&str],
    results: &[(&FaultTrial, FaultEffect, Rehearsed)],
) -> Outcome {
    let of = |case: usize, phase: &str| {
        results
            .iter()
            .find(|(trial, ..)| trial.case == case && trial.phase == phase)
    };
    let mut text = String::from("Every fault in every phase, and what became of the session\n\n");
    let mut table = Table::of(cases).words("fault", |case| CASES[**case].name);
    for phase in phases {
        table = table.words(*phase, |case| {
            let effect = of(**case, phase).map(|(_, effect, _)| effect.to_string());
            effect.unwrap_or_default()
        });
    }
    text.push_str(&table.text());
    text.push_str("\nWhat was said\n");
    for &case in cases {
        let _ = writeln!(text, "\n  {}", CASES[case].name);
        let mut said: Vec<&str> = Vec::new();
        for (_, _, rehearsed) in results.iter().filter(|(trial, ..)| trial.case == case) {
            for line in &rehearsed.said {
                if !said.contains(&line.as_str()) {
                    said.push(line);
                }
            }
        }
        if said.is_empty() {
            text.push_str("    nothing\n");
        }
        for line in said.iter().take(6) {
            let _ = writeln!(text, "    {line}");
        }
    }
    let count = |wanted: FaultEffect| {
        results
            .iter()
            .filter(|(_, effect, _)| *effect == wanted)
            .count()
    };
    let [survived, resumed, stuck, wrong] = [
        FaultEffect::Survived,
        FaultEffect::Resumed,
        FaultEffect::Stuck,
        FaultEffect::FalseReading,
    ]
    .map(count);
    let _ = writeln!(
        text,
        "\n{} sessions: {survived} went on by themselves, {resumed} stopped and were resumed, {stuck} stuck, {wrong} with a false reading",
        results.len()
    );
    let trial =
        |(trial, effect, rehearsed): &(&FaultTrial, FaultEffect, Rehearsed)| FaultTrialReport {
            fault: CASES[trial.case].name,
            phase: trial.phase,
            effect: *effect,
            resumes: rehearsed.resumes,
            said: rehearsed.said.clone(),
        };
    let data = FaultReport {
        sessions: results.len(),
        went_on: survived,
        resumed,
        stuck,
        false_readings: wrong,
        trials: results.iter().map(trial).collect(),
    };
    let exit = u8::from(stuck + wrong > 0);
    Outcome::new("session-faults", text, data).with_exit(exit)
}
