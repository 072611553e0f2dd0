//! `stiffbench-validate prove`.

use std::fs;
use std::io::Read as _;
use std::path::Path;
use std::time::Instant;
use stiffbench::analysis::{Inputs, ReadError, laws, named_procedure, robot_source, usual_plan};

use serde_json::json;

use crate::prove::{
    Observer, PowerOptions, SealedAnswers, SealedSets, SessionTexts, Set, ValidationSession,
    beside_idealised, calibrate, calibration_plans, diagnose_all, power, score, unseal,
};
use crate::report::{
    CalibrationReport, ConcealedReport, PowerReport, ProveParts, ProveReport, blind_verdicts,
    calibration_text, doors_text, forced_text, idealised_text, power_figure, power_text,
};
use stiffbench::mismatch::SearchOptions;
use stiffbench::physics::{Effect, Law, TestObject, laws};
use stiffbench::readings::SessionHeader;
use stiffbench::robot::Robot;
use stiffbench::source_text::SourceText;

use super::doors::judge_doors;
use super::error::ValidationError;
use super::forced::{ForcedPlan, judge_forced};
use super::prove_args::{ProveArgs, ProvePart, SetChoice};
use stiffbench::cli::args::Global;
use stiffbench::cli::failure::Failure;
use stiffbench::cli::figure_files::{write_again, write_figure};
use stiffbench::cli::outcome::Outcome;
use stiffbench::cli::progress::progress;

/// Mechanisms whose standard errors are computed: one arm, and all chains.
const ERROR_MECHANISMS: [&str; 2] = ["A", "F"];

/// Sealed answers of the first two lists, and of the second proof list.
const ANSWERS: &str = "answers.sealed";
const SECOND_ANSWERS: &str = "answers-second.sealed";

/// Concealed sessions of each list under `--quick`.
const QUICK_SESSIONS: usize = 12;

/// Benches with nothing missing.
const TRIALS: usize = 1000;

/// The same under `--quick`.
const QUICK_TRIALS: usize = 60;

/// Each point of a power curve, and each law of a size that is stated, has the trials of the calibration over this many, and no fewer than the least.
const TRIALS_PER_POINT: usize = 25;
const LEAST_TRIALS: usize = 6;

/// Sizes of power curves, standard errors.
const SIZES: [f64; 4] = [3.0, 4.5, 6.0, 8.0];

/// Sizes of laws that are stated, standard errors.
const FORCED_SIZES: [f64; 3] = [6.0, 10.0, 20.0];

/// Laws under `--quick`: one of a joint that is smooth, one with a history, one of the structure, one of the gauge.
const QUICK_LAWS: [Law; 4] = [
    laws::JOINT_COMPLIANCE,
    laws::JOINT_FRICTION,
    laws::SETTING_IN,
    laws::GAUGE_PERIODIC,
];

/// What is measured on a robot that `--robot` names.
const ROBOT_PROCEDURES: [&str; 2] = ["load-unload", "load-hold-unload"];

/// A part of the proof, what runs it.
type ValidationPart = (
    ProvePart,
    fn(&ProveArgs, &Global, &mut Done) -> Result<(), Failure>,
);

/// The parts, in order.
const PARTS: [ValidationPart; 6] = [
    (ProvePart::Concealed, concealed),
    (ProvePart::Calibration, calibration),
    (ProvePart::Power, power_part),
    (ProvePart::Errors, errors),
    (ProvePart::Doors, doors),
    (ProvePart::Forced, forced),
];

/// Runs the parts of the proof and writes them to a folder, after each part what there is.
pub(crate) fn run(args: &ProveArgs, global: &Global) -> Result<Outcome, Failure> {
    let started = Instant::now();
    let mut done = Done {
        started,
        text: String::new(),
        parts: ProveParts::default(),
    };
    for (part, run_part) in PARTS {
        if args.only.is_empty() || args.only.contains(&part) {
            run_part(args, global, &mut done)?;
            done.save(args)?;
        }
    }
    let (text, data) = done.save(args)?;
    let text = format!("{text}\nWritten to {}\n", args.out.display());
    let doors = data.parts.doors.as_ref();
    let is_wrong = doors.is_some_and(|doors| !doors.disagreements.is_empty());
    Ok(Outcome::new("prove", text, data).with_strict_exit(u8::from(is_wrong)))
}

/// What the parts give.
#[derive(Debug)]
struct Done {
    started: Instant,
    text: String,
    parts: ProveParts,
}

impl Done {
    /// Writes what there is; returns it as text and for programs.
    fn save(&self, args: &ProveArgs) -> Result<(String, ProveReport), Failure> {
        let seconds = self.started.elapsed().as_secs_f64();
        let threads = rayon::current_num_threads();
        let data = ProveReport {
            quick: args.quick,
            seed: args.seed,
            earlier_sessions: args.earlier,
            seconds: seconds.round(),
            threads,
            parts: self.parts.clone(),
        };
        let text = format!(
            "stiffbench-validate {} prove{}, seed {}{}, {seconds:.0} s on {threads} threads\n\n{}",
            env!("CARGO_PKG_VERSION"),
            if args.quick { " --quick" } else { "" },
            args.seed,
            match args.earlier {
                0 => String::new(),
                count => format!(", noise estimated from {count} earlier sessions too"),
            },
            self.text
        );
        let mut stored = stiffbench::cli::outcome::envelope("prove", true);
        stored["data"] = json!(data);
        let stored = format!("{stored:#}\n");
        write_again(&args.out.join("prove.json"), stored.as_bytes())?;
        write_again(&args.out.join("tables.txt"), text.as_bytes())?;
        Ok((text, data))
    }
}

/// Blind verdicts first, in a file; then the answers.
fn concealed(args: &ProveArgs, global: &Global, done: &mut Done) -> Result<(), Failure> {
    let folder = args.data.join("concealed");
    let chosen = selected_sessions(args, &folder)?;
    let sessions: Vec<ValidationSession> = chosen
        .iter()
        .map(|chosen| ValidationSession::read(&session_texts(&folder, chosen)?))
        .collect::<Result<_, Failure>>()?;
    let bar = progress(global, "concealed sessions", sessions.len() as u64);
    let options = SearchOptions {
        seed: args.seed,
        ..SearchOptions::default()
    };
    let verdicts = diagnose_all(&sessions, &options, &|| bar.inc(1));
    bar.finish_and_clear();
    let written = format!("{:#}\n", blind_verdicts(&verdicts, args.seed));
    write_again(&args.out.join("verdicts.json"), written.as_bytes())?;

    let mut answers = unsealed(&folder.join(ANSWERS))?;
    if chosen.iter().any(|(_, set)| *set == Set::Second) {
        answers.add(unsealed(&folder.join(SECOND_ANSWERS))?);
    }
    let scores = verdicts
        .iter()
        .zip(sessions.iter().zip(&chosen))
        .map(|(verdict, (session, (id, set)))| {
            let answer = answers.get(id)?;
            let observer = Observer::new(session, answer)?;
            // What acts outside the library is named by no set.
            let between = |number: usize, member: &Effect| {
                let observer = observer.as_ref();
                observer.map_or(Ok(0.0), |observer| observer.between(number, member))
            };
            score(verdict, answer, *set, &between)
        })
        .collect::<Result<Vec<_>, Failure>>()?;
    let report = ConcealedReport::new(&scores);
    done.text.push_str(&report.text());
    done.parts.concealed = Some(report);
    Ok(())
}

/// Answers, opened.
fn unsealed(sealed: &Path) -> Result<SealedAnswers, Failure> {
    let plain = unseal(&read(sealed)?)?;
    Ok(SealedAnswers::parse(&sealed.display().to_string(), &plain)?)
}

/// Null benches on the plans of the concealed sessions.
fn calibration(args: &ProveArgs, global: &Global, done: &mut Done) -> Result<(), Failure> {
    let texts = plan_texts(args)?;
    let plans = calibration_plans(&texts, args.quick.then_some(1))?;
    let trials = trials(args);
    // So many trials for each of several plans and noises.
    let bar = progress(global, "benches with nothing missing", 0);
    let done_one = || bar.inc(1);
    let rows = calibrate(&plans, (trials, args.earlier), args.seed, &done_one)?;
    bar.finish_and_clear();
    done.text.push_str(&calibration_text(&rows));
    done.parts.calibration = Some(CalibrationReport::new(rows));
    Ok(())
}

/// Power and right names on the plans of the concealed sessions.
fn power_part(args: &ProveArgs, global: &Global, done: &mut Done) -> Result<(), Failure> {
    let sessions: Vec<ValidationSession> = match &args.robot {
        Some(robot) => robot_plans(robot)?,
        None => plan_texts(args)?
            .iter()
            .map(ValidationSession::read)
            .collect::<Result<_, Failure>>()?,
    };
    let options = PowerOptions {
        laws: match (args.laws.as_slice(), args.quick) {
            ([], true) => QUICK_LAWS.to_vec(),
            ([], false) => Law::searched_on(TestObject::Robot).collect(),
            (names, _) => laws(names)?,
        },
        sizes: sizes(args, &SIZES),
        trials: trials_of_a_point(args),
        closed_benches: if args.quick { 1 } else { 2 },
        earlier: args.earlier,
        pairs: !args.quick && args.laws.is_empty(),
        seed: args.seed,
    };
    // The number of places is known only when they have been tried: the bar counts trials.
    let bar = progress(global, "power", 0);
    let step = || bar.inc(1);
    let before = done.text.clone();
    // What is done is kept, if the rest is not waited for.
    power(&sessions, &options, &step, &mut |cases| {
        done.text.clone_from(&before);
        done.text.push_str(&power_text(cases));
        done.parts.power = Some(PowerReport::new(cases));
        done.save(args)?;
        let figure = args.out.join("figures").join("power");
        write_figure(&figure, &power_figure(cases), &Inputs::default())?;
        Ok::<(), Failure>(())
    })?;
    bar.finish_and_clear();
    Ok(())
}

/// What the paper's plan, with unloading, can show on the shipped robot.
fn errors(args: &ProveArgs, global: &Global, done: &mut Done) -> Result<(), Failure> {
    let robot = Robot::parse(&robot_source("hp-robot", None)?)?;
    let bar = progress(global, "standard errors", ERROR_MECHANISMS.len() as u64);
    let mut plans = Vec::new();
    for mechanism in ERROR_MECHANISMS {
        let plan = usual_plan(&robot, mechanism, "load-unload", args.seed)?;
        plans.push((format!("mechanism {mechanism}"), plan));
        bar.inc(1);
    }
    bar.finish_and_clear();
    let rows = beside_idealised(&plans);
    done.text.push_str(&idealised_text(&plans, &rows));
    done.parts.errors = Some(rows);
    Ok(())
}

/// The same readings as a session and as a table of vectors.
fn doors(args: &ProveArgs, global: &Global, done: &mut Done) -> Result<(), Failure> {
    let uncounted = args.quick && args.trials.is_none();
    let report = judge_doors(args, global, if uncounted { 0 } else { trials(args) })?;
    done.text.push_str(&doors_text(&report));
    done.parts.doors = Some(report);
    Ok(())
}

/// Laws that are stated and not searched.
fn forced(args: &ProveArgs, global: &Global, done: &mut Done) -> Result<(), Failure> {
    let plan = ForcedPlan {
        laws: match (args.laws.as_slice(), args.quick) {
            ([], true) => QUICK_LAWS.to_vec(),
            ([], false) => Law::ALL.to_vec(),
            (names, _) => laws(names)?,
        },
        sizes: sizes(args, &FORCED_SIZES),
        trials: trials_of_a_point(args),
    };
    let points = judge_forced(args, global, &plan)?;
    done.text.push_str(&forced_text(&points));
    done.parts.forced = Some(points);
    Ok(())
}

/// Sizes that are asked for, else the usual ones.
fn sizes(args: &ProveArgs, usual: &[f64]) -> Vec<f64> {
    match (args.sizes.as_slice(), args.quick) {
        ([], true) => vec![6.0],
        ([], false) => usual.to_vec(),
        (sizes, _) => sizes.to_vec(),
    }
}

/// Trials of a law of a size.
fn trials_of_a_point(args: &ProveArgs) -> usize {
    (trials(args) / TRIALS_PER_POINT).max(LEAST_TRIALS)
}

fn trials(args: &ProveArgs) -> usize {
    let usual = if args.quick { QUICK_TRIALS } else { TRIALS };
    args.trials.unwrap_or(usual)
}

/// Plans of a robot, without and with holds.
fn robot_plans(robot: &str) -> Result<Vec<ValidationSession>, Failure> {
    let source = robot_source(robot, None)?;
    let mut plans = Vec::new();
    for name in ROBOT_PROCEDURES {
        let (procedure, _) = named_procedure(name)?;
        plans.push(ValidationSession::planned(&source, None, &procedure)?);
    }
    Ok(plans)
}

/// The concealed sessions of the first two lists, for their plans.
fn plan_texts(args: &ProveArgs) -> Result<Vec<SessionTexts>, Failure> {
    let folder = args.data.join("concealed");
    let file = folder.join("sets.toml");
    let sets = SealedSets::parse(&file.display().to_string(), &read(&file)?)?;
    sets.chosen(None)
        .iter()
        .filter(|(_, set)| *set != Set::Second)
        .map(|chosen| session_texts(&folder, chosen))
        .collect()
}

/// The sessions that are asked for, by name, with their lists.
fn selected_sessions(args: &ProveArgs, folder: &Path) -> Result<Vec<(String, Set)>, Failure> {
    let file = folder.join("sets.toml");
    let sets = SealedSets::parse(&file.display().to_string(), &read(&file)?)?;
    let most = args.sessions.or(args.quick.then_some(QUICK_SESSIONS));
    let mut chosen = sets.chosen(most);
    chosen.retain(|(_, set)| match args.set {
        SetChoice::All => true,
        SetChoice::Development => *set == Set::Development,
        SetChoice::Proof => *set == Set::Proof,
        SetChoice::Second => *set == Set::Second,
    });
    Ok(chosen)
}

/// The sessions of the proof lists, below the same names as those of the development list beside it.
const ARCHIVE: &str = "proof-sessions.zip";

/// The texts of a concealed session.
fn session_texts(folder: &Path, (id, set): &(String, Set)) -> Result<SessionTexts, Failure> {
    let text = |file: &str| {
        let name = format!("sessions/{id}/{file}");
        let path = folder.join(&name);
        let text = match set {
            Set::Development => read(&path)?,
            Set::Proof | Set::Second => packed(&folder.join(ARCHIVE), &name)?,
        };
        Ok::<_, Failure>(SourceText::new(path.display().to_string(), text))
    };
    let header = text("session.toml")?;
    let named = SessionHeader::from_toml(&header.name, &header.text)?.header;
    let robot = named.robot.as_deref().unwrap_or("hp-robot");
    // A session is two folders below the archive, and need not lie there unpacked.
    let robot = robot.strip_prefix("../../").unwrap_or(robot);
    Ok(SessionTexts {
        id: id.clone(),
        readings: text("readings.csv")?.text,
        header,
        robot: robot_source(robot, Some(&folder.join(ARCHIVE)))?,
    })
}

/// A file of an archive.
fn packed(archive: &Path, name: &str) -> Result<String, Failure> {
    let is_none = |_| ValidationError::ProofData {
        path: archive.join(name),
    };
    let file = fs::File::open(archive).map_err(ReadError::of(archive))?;
    let mut files = zip::ZipArchive::new(file).map_err(is_none)?;
    let mut packed = files.by_name(name).map_err(is_none)?;
    let mut text = String::new();
    packed
        .read_to_string(&mut text)
        .map_err(ReadError::of(archive))?;
    Ok(text)
}

/// A file of the proof's data.
pub(super) fn read(path: &Path) -> Result<String, Failure> {
    fs::read_to_string(path).map_err(|source| match source.kind() {
        std::io::ErrorKind::NotFound => ValidationError::ProofData {
            path: path.to_owned(),
        }
        .into(),
        _ => ReadError::of(path)(source).into(),
    })
}
