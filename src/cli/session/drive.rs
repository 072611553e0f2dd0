//! `session run` and `session resume`.

use std::io::IsTerminal;
use std::path::Path;

use jiff::Timestamp;

use stiffbench_document::Document;

use crate::analysis::{
    ArgumentError, ResolvedModel, add_poses, check_specimen, header_sha256, sha256,
    state_joint_values, stated_scatter_m,
};
use crate::cli::global::today;
use crate::cli::outcome::{Outcome as Printed, print_error};
use crate::cli::procedure::resolve_procedure;
use crate::cli::screen::Screen;
use crate::cli::{Failure, Global};
use crate::clock::Clock;
use crate::instrument::Channel;
use crate::procedure::Procedure;
use crate::readings::{InstrumentRecord, Instruments, SessionHeader};
use crate::report::{RunReport, SessionOutcome};
use crate::session::{
    Answers, Ended, Event, JOURNAL_SCHEMA, Journal, JournalFile, KeptAwake, Machine, Operator,
    RepeatCheck, Resumed, SessionEnd, SessionFolder, SessionInputs, SessionPlan, SessionState,
    Settings, Started, Warning, check_question, host, lag_s, read_folder, run as run_session,
};

use super::args::{BenchArgs, CaptureWord, ResumeArgs, RunArgs};
use super::diagnostics::{DiagnosticLog, LogLevel, LoggedOperator};
use super::emulation::{
    BenchOperator, check_effects, emulate, emulate_again, of_a_hand, origin, refuse_mixture, speed,
    with_hand,
};
use super::gauges::{ResolvedGauge, check_present, connect, resolve_gauges};
use super::inspect::event_text;
use super::line::LineOperator;
use super::operator::AtBench;
use super::prepare::{
    answers, check_place, gauge_terms, instrument_records, overdue, plan_of,
    refuse_keys_without_hands, resume_command, robot_of, run_out,
};
use super::repeats::BenchRepeats;

/// Program and version.
const SOFTWARE: &str = concat!("stiffbench ", env!("PROGRAM_VERSION"));

/// Exit code of a session that was interrupted and can be resumed.
const INTERRUPTED: u8 = 130;

/// A session that is about to run.
struct Ready {
    folder: SessionFolder,
    journal: Journal<JournalFile>,
    state: SessionState,
    plan: SessionPlan,
    instruments: Instruments,
    first: Event,
    resolved: Vec<ResolvedGauge>,
    answers: Answers,
    warnings: Vec<String>,
    clock: Clock,
    hand: Option<BenchOperator>,
    /// Who measures.
    operator_name: Option<String>,
    /// Robot and header, for a look at the readings of each cell; a robot that is not there any more looks at nothing.
    robot: Option<(ResolvedModel, SessionHeader)>,
}

/// A session that nothing speaks against, before any gauge is looked for.
pub(super) struct CheckedSession {
    pub(super) robot: ResolvedModel,
    pub(super) procedure: Procedure,
    pub(super) plan: SessionPlan,
    pub(super) instruments: Instruments,
    pub(super) answers: Answers,
    pub(super) warnings: Vec<String>,
}

/// What the arguments ask for, checked without touching a port or a folder.
///
/// # Errors
/// For whatever a session could not be begun with: robot, procedure, poses, records, answers, a calibration that ran out under `--strict`, a
/// folder that there is already.
pub(super) fn checked(args: &RunArgs, global: &Global) -> Result<CheckedSession, Failure> {
    let (procedure, mut warnings) = resolve_procedure(&args.procedure)?;
    let mut robot = args.model.resolve_in(&procedure)?;
    check_effects(&args.bench, &robot)?;
    let mut procedure = args.axes.applied(procedure)?;
    check_specimen(&procedure, args.specimen_id.as_deref())?;
    for (question, _) in &procedure.answer_within_s {
        check_question(&format!("{}: answer_within", procedure.name), question)?;
    }
    warnings.extend(robot.warnings.iter().cloned());
    warnings.extend(add_poses(&mut robot.robot, &procedure)?);
    // The poses are frozen with the procedure.
    let named = robot.robot.poses.iter();
    let poses = procedure
        .poses
        .get_or_insert_with(|| named.map(|named| named.id.clone()).collect());
    for pose in poses.iter() {
        robot.robot.pose(pose)?;
    }
    if !procedure.displacement_axes.is_empty() {
        state_joint_values(&robot.robot, &mut procedure)?;
    }
    let plan = SessionPlan::new(&procedure, &[])
        .with_axis_words([0, 1, 2].map(|axis| robot.robot.axis_word(axis)));
    let (instruments, notes) = instrument_records(args.instruments.as_deref())?;
    warnings.extend(notes);
    warnings.extend(overdue(&instruments, today(), global)?);
    SessionFolder::check_new(&args.out)?;
    check_place(&args.out)?;
    refuse_keys_without_hands(&args.bench, global)?;
    Ok(CheckedSession {
        answers: answers(&args.bench, &plan, &mut warnings, global)?,
        robot,
        procedure,
        plan,
        instruments,
        warnings,
    })
}

/// Makes a session and runs it; with another operator than the arguments say, if one is given.
pub(super) fn run(
    args: &RunArgs,
    global: &Global,
    other: Option<Box<dyn Operator>>,
) -> Result<Printed, Failure> {
    let CheckedSession {
        robot,
        procedure,
        plan,
        mut instruments,
        answers,
        mut warnings,
    } = checked(args, global)?;
    let clock = Clock::starting_at(0.0, speed(&args.bench));
    let mut bench = args.bench.clone();
    let (begun_with, state) = (Instruments::default(), SessionState::default());
    let hand = emulate(&mut bench, &robot, &procedure, &begun_with, clock)?;
    let (resolved, notes) = resolve_gauges(&bench, &plan.channels(), &begun_with, &state)?;
    warnings.extend(notes);
    if global.no_input {
        check_present(&resolved)?;
    }
    state_gauges(&mut instruments, &resolved);
    let now = Timestamp::now();
    let header = SessionHeader {
        id: Some(session_id(&args.out, now)),
        robot: Some("robot.toml".to_owned()),
        robot_sha256: Some(sha256(&robot.source.text)),
        mechanism: Some(robot.mechanism.clone()),
        factors: robot
            .robot
            .factors
            .contains_key(&robot.factors_name)
            .then(|| robot.factors_name.clone()),
        origin: origin(&args.bench, &robot.physics),
        operator: args.operator.clone(),
        specimen: args.specimen_id.clone(),
        place: args.place.clone(),
        software: Some(SOFTWARE.to_owned()),
        procedure: Some(procedure.to_record()),
        instruments: instruments.clone(),
        ..SessionHeader::default()
    };
    let text = &robot.source.text;
    let (folder, journal) = SessionFolder::create(&args.out, &header.to_toml(), Some(text), now)?;
    let first = started(&header, &procedure, sha256(procedure.to_toml()));
    let ready = Ready {
        folder,
        journal,
        state,
        plan,
        instruments,
        first,
        resolved,
        answers,
        warnings,
        clock,
        hand,
        operator_name: args.operator.clone(),
        robot: Some((robot, header)),
    };
    let operator = other.unwrap_or_else(|| operator(&args.bench, global));
    drive(ready, &args.bench, operator, global)
}

/// Goes on with a session.
pub(super) fn resume(args: &ResumeArgs, global: &Global) -> Result<Printed, Failure> {
    // A damaged or foreign folder is refused before anything is opened.
    let (plan, header, hash) = plan_of(&read_folder(&args.folder)?)?;
    refuse_mixture(&args.bench, &header)?;
    refuse_keys_without_hands(&args.bench, global)?;
    let now = Timestamp::now();
    let (folder, journal, read, cut_bytes) = SessionFolder::open(&args.folder, now)?;
    let state = SessionState::fold(&read.records);
    let began_with = state
        .started
        .as_ref()
        .map(|started| started.procedure_sha256.as_str());
    if began_with.is_some_and(|began_with| began_with != hash) {
        return ArgumentError::refuse(
            args.folder.display().to_string(),
            "the procedure in session.toml is not the one that the session began with",
            "put session.toml back as it was; the journal holds the SHA-256 of its procedure",
        );
    }
    let is_complete = |ended: &Ended| ended.outcome == SessionEnd::Complete;
    let nothing_open = plan.next_open(&state, 0).is_none();
    if nothing_open && state.ended.as_ref().is_some_and(is_complete) {
        let complete = SessionEnd::Complete;
        return Ok(report(&args.folder, complete, &state, &[], plan.len()));
    }
    let mut warnings = Vec::new();
    if cut_bytes > 0 {
        warnings.push(format!(
            "{cut_bytes} bytes of a record that was never confirmed were cut off the journal"
        ));
    }
    let clock = Clock::starting_at(state.last_s, speed(&args.bench));
    let mut bench = args.bench.clone();
    let hand = emulate_again(&mut bench, &header, &args.folder, &plan, clock)?;
    // Readings can be taken without it.
    let robot = robot_of(&header, &args.folder, &plan).ok();
    let plan = match &robot {
        Some(robot) => plan.with_axis_words([0, 1, 2].map(|axis| robot.robot.axis_word(axis))),
        None => plan,
    };
    let robot = robot.map(|robot| (robot, header.clone()));
    let (resolved, notes) = resolve_gauges(&bench, &plan.channels(), &header.instruments, &state)?;
    warnings.extend(notes);
    warnings.extend(overdue(&header.instruments, today(), global)?);
    let answers = answers(&args.bench, &plan, &mut warnings, global)?;
    let first = if state.started.is_some() {
        Event::Resumed(Resumed {
            software: SOFTWARE.to_owned(),
            pid: std::process::id(),
            host: host(),
            cut_bytes,
        })
    } else {
        // It stopped before its first event was on the disk.
        started(&header, &plan.procedure, hash)
    };
    let ready = Ready {
        folder,
        journal,
        state,
        plan,
        instruments: header.instruments,
        operator_name: header.operator,
        first,
        resolved,
        answers,
        warnings,
        clock,
        hand,
        robot,
    };
    let operator = operator(&args.bench, global);
    drive(ready, &args.bench, operator, global)
}

/// Runs what is ready, and states how it went.
fn drive(
    mut ready: Ready,
    args: &BenchArgs,
    mut operator: Box<dyn Operator>,
    global: &Global,
) -> Result<Printed, Failure> {
    let mut log = DiagnosticLog::open(ready.folder.path(), global);
    for gauge in &ready.resolved {
        log.line(LogLevel::Info, &gauge.words());
    }
    for warning in &ready.warnings {
        log.line(LogLevel::Warn, warning);
    }
    let clock = ready.clock;
    let connected = connect(ready.resolved, &ready.folder.raw()?, clock);
    let (mut gauges, known) = connected.inspect_err(|failure| {
        log.line(LogLevel::Error, &failure.message());
    })?;
    let awake = ready.hand.is_none().then(KeptAwake::start);
    ready.warnings.extend(
        awake
            .iter()
            .filter_map(|awake| awake.as_ref().err().cloned()),
    );
    let answers = match ready.hand {
        Some(_) => ready.answers.or(of_a_hand(&ready.plan)?),
        None => ready.answers,
    };
    let lag_s = lag_s(clock.speed());
    // Faster than gauges are compared with each other, no time is taken for the readings either.
    let repeats = ready.robot.filter(|_| lag_s.is_finite());
    let repeats = repeats.map(|(model, header)| BenchRepeats { model, header });
    let settings = Settings {
        auto_capture: args.capture == CaptureWord::Settled,
        checks_repeats: repeats.is_some(),
        scatter_m: ready.hand.as_ref().map(|_| stated_scatter_m()),
        lag_s,
        gauges: gauge_terms(&ready.instruments)?,
        warnings: ready.warnings.clone(),
        operator: ready.operator_name,
        ..known
    };
    let planned = ready.plan.len();
    // In fast-forward UTC runs ahead of the system's clock.
    let behind = ready.state.clock_gone_back(clock.utc());
    let behind = behind.filter(|_| clock.speed() <= 1.0);
    let mut machine = Machine::new(ready.plan, settings, ready.state);
    let first = first_events(ready.first, &ready.instruments, operator.as_mut());
    for event in first.into_iter().chain(behind) {
        let record = ready.journal.append(event, clock.utc(), clock.now_s())?;
        machine.recorded(&record);
        log.line(
            LogLevel::Info,
            &format!("event {}: {}", record.seq, event_text(&record.event)),
        );
    }
    // After an interruption the last row of the table may be cut or missing.
    ready.folder.rewrite_table(machine.state())?;
    let mut at_bench = AtBench::new(operator);
    let ended = with_hand(&mut at_bench, ready.hand.as_ref(), |operator| {
        let mut operator = LoggedOperator::new(operator, &mut log);
        let bench = SessionInputs {
            gauges: gauges.as_mut(),
            operator: &mut operator,
            clock: &clock,
            journal: &mut ready.journal,
            table: Some(&ready.folder),
            answers: &answers,
            repeats: repeats.as_ref().map(|check| check as &dyn RepeatCheck),
        };
        run_session(&mut machine, bench)
    });
    // The terminal is put back and the ports are closed before anything else is said.
    drop(at_bench);
    drop(gauges);
    drop(awake);
    if let Err(error) = &ended {
        log.line(LogLevel::Error, &error.to_string());
    }
    let outcome = ended?;
    ready.folder.rewrite_table(machine.state())?;
    let repeats = machine.repeated_on_resume();
    let report = report(
        ready.folder.path(),
        outcome,
        machine.state(),
        &repeats,
        planned,
    );
    Ok(report.with_warnings(ready.warnings))
}

/// What the journal begins with; the operator hears of calibrations that ran out.
fn first_events(
    first: Event,
    instruments: &Instruments,
    operator: &mut dyn Operator,
) -> Vec<Event> {
    let mut events = vec![first];
    for text in run_out(instruments, today()) {
        operator.notify(&format!("warning: {text}"));
        events.push(Event::CalibrationWarning(Warning { text }));
    }
    events
}

/// Whoever is there: on the whole of a terminal where there is one, else in lines.
fn operator(args: &BenchArgs, global: &Global) -> Box<dyn Operator> {
    let terminal = std::io::stdin().is_terminal() && std::io::stdout().is_terminal();
    if terminal && !args.line && !global.no_input && !global.json {
        match Screen::open() {
            Ok(screen) => return Box::new(screen),
            Err(error) => print_error(&format!("note: no full-screen view: {error}")),
        }
    }
    Box::new(LineOperator::new(global.quiet, global.no_input))
}

/// How it went.
fn report(
    folder: &Path,
    outcome: SessionEnd,
    state: &SessionState,
    repeats: &[String],
    planned: usize,
) -> Printed {
    let (accepted, skipped) = (state.taken.len(), state.skipped.len());
    let (next, exit) = match outcome {
        SessionEnd::Complete => (format!("stiffness {}", folder.display()), 0),
        SessionEnd::Partial | SessionEnd::Aborted => (resume_command(folder, state), INTERRUPTED),
    };
    let outcome = SessionOutcome::from(outcome);
    let word = outcome.words();
    let mut document = Document::new();
    document.lines(format!(
        "{}: {word}, {accepted} of {planned} readings, {skipped} skipped",
        folder.display()
    ));
    if !repeats.is_empty() {
        document.item(format!("Resuming repeats: {}", repeats.join("; ")));
    }
    document.next(next);
    let report = RunReport {
        folder: folder.to_owned(),
        outcome,
        planned,
        accepted,
        skipped,
        superseded: state.readings.len() - accepted,
    };
    Printed::new("session-run", document, report).with_exit(exit)
}

/// The records name the descriptions that the gauges are read by, and the steps of their displays where these state one.
fn state_gauges(instruments: &mut Instruments, resolved: &[ResolvedGauge]) {
    for gauge in resolved {
        let channel = gauge.description.channel;
        let record = match (channel, channel.axis()) {
            (_, Some(axis)) => &mut instruments.displacement_along[axis.index()],
            (Channel::Force, _) => &mut instruments.force,
            _ => &mut instruments.displacement,
        };
        let record = record.get_or_insert_with(InstrumentRecord::default);
        let name = &gauge.description.name;
        record.model.get_or_insert_with(|| name.clone());
        record.description = Some(name.clone());
        record.resolution = record.resolution.or_else(|| gauge.resolution_si());
    }
}

/// The first event of a session.
fn started(header: &SessionHeader, procedure: &Procedure, procedure_sha256: String) -> Event {
    let [header_sha256, instruments_sha256] = header_sha256(&header.to_toml());
    Event::Started(Started {
        schema: Some(JOURNAL_SCHEMA.to_owned()),
        session: header.id.clone().unwrap_or_default(),
        procedure: procedure.name.clone(),
        procedure_sha256,
        software: SOFTWARE.to_owned(),
        pid: std::process::id(),
        host: host(),
        robot_sha256: header.robot_sha256.clone(),
        header_sha256,
        instruments_sha256,
        mechanism: header.mechanism.clone(),
        origin: header.origin.clone(),
        displacement_axes: procedure.displacement_axes.clone(),
    })
}

/// Name of the folder and day.
pub(super) fn session_id(folder: &Path, now: Timestamp) -> String {
    let name = folder
        .file_name()
        .map_or("session".into(), |name| name.to_string_lossy());
    format!("{name}-{}", now.strftime("%Y%m%dT%H%M%SZ"))
}
