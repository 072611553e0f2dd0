//! `session replay`: the traces of a recorded session through the decoder and the machine of a live one.

use std::fs;
use std::thread;

use jiff::Timestamp;
use stiffbench_document::Document;

use crate::analysis::{ArgumentError, Inputs, ReadError, header_sha256, read_text, session_file};
use crate::cli::gauge::descriptions::find_description;
use crate::cli::gauge::trace::Speed;
use crate::cli::outcome::print_error;
use crate::cli::{Failure, Global, Outcome};
use crate::clock::Clock;
use crate::instrument::GaugeEvent;
use crate::instrument::trace::{GaugeTrace, events_of};
use crate::report::SessionReplayReport;
use crate::session::{
    Event, Machine, RecordedSession, ReplayWatch, SessionFolder, SessionState, Settings, inside,
    lag_s, read_folder, read_inside, replay_session,
};

use super::args::SessionReplayArgs;
use super::drive::session_id;
use super::inspect::event_text;
use super::prepare::{day_of_last_event, gauge_terms, overdue, plan_of};
use crate::count::counted;

/// Share of a dwell by which a replay may be behind the session that it replays, at most.
const LAG_SHARE: f64 = 0.1;

/// What the traces of a session hold.
#[derive(Default)]
struct SessionTraces {
    events: Vec<(f64, GaugeEvent)>,
    /// What is known of the gauges.
    known: Settings,
    /// Seconds of the session in a real one.
    speed: f64,
    warnings: Vec<String>,
}

/// Replays a session into a new folder, and compares the readings.
pub(super) fn run(args: &SessionReplayArgs, global: &Global) -> Result<Outcome, Failure> {
    let read = read_folder(&args.folder)?;
    let (mut plan, mut header, _) = plan_of(&read)?;
    let mut traces = session_traces(args)?;
    traces.warnings.extend(overdue(
        &header.instruments,
        day_of_last_event(&read),
        global,
    )?);
    let recorded = SessionState::fold(&read.journal.records);
    let now = Timestamp::now();
    let replayed_id = header.id.replace(session_id(&args.out, now));
    header.origin = Some(format!("replay of {}", replayed_id.unwrap_or_default()));
    let mut records = read.journal.records;
    for record in &mut records {
        if let Event::Started(started) = &mut record.event {
            started.session = header.id.clone().unwrap_or_default();
            started.origin.clone_from(&header.origin);
            [started.header_sha256, started.instruments_sha256] = header_sha256(&header.to_toml());
        }
    }
    let robot = session_file(&args.folder, "robot.toml")?;
    let robot = robot.map(|robot| read_text(&robot)).transpose()?;
    let (folder, mut journal) =
        SessionFolder::create(&args.out, &header.to_toml(), robot.as_deref(), now)?;
    let settings = Settings {
        lag_s: lag_s(traces.speed),
        gauges: gauge_terms(&header.instruments)?,
        ..traces.known
    };
    let settle = &mut plan.procedure.settle;
    let behind_s = lag_s(traces.speed).min(LAG_SHARE * settle.dwell_s);
    settle.dwell_s -= behind_s;
    let machine = |state| Machine::new(plan.clone(), settings.clone(), state);
    let clock = match args.speed {
        Speed::Times(times) => Some(Clock::starting_at(0.0, times)),
        Speed::Fastest => None,
    };
    let mut watch = |at_s: f64, kept: Option<&crate::session::Record>| {
        if let Some(clock) = clock {
            thread::sleep(clock.real(at_s - clock.now_s()));
        }
        if let Some(record) = kept.filter(|_| !global.quiet) {
            print_error(&format!("{at_s:9.1} s  {}", event_text(&record.event)));
        }
    };
    let watch: &mut ReplayWatch<'_> = &mut watch;
    let played = RecordedSession {
        records: &records,
        events: traces.events,
        lag_s: behind_s,
    };
    let state = replay_session(&machine, played, &mut journal, watch)?;
    folder.rewrite_table(&state)?;
    let report = compare(args, &recorded, &state);
    let mut document = Document::of(format!(
        "{}: {} of {} recorded readings came again; largest differences {:.3} N, {:.2} µm",
        args.out.display(),
        report.replayed,
        report.recorded,
        report.largest_difference_n,
        report.largest_difference_um,
    ));
    document.next(format!("session log {}", args.out.display()));
    Ok(Outcome::new("session-replay", document, report)
        .with_inputs(Inputs::default().with_folder(&args.out, &header))
        .with_warnings(traces.warnings))
}

/// The traces of a folder, decoded as the live lines were.
fn session_traces(args: &SessionReplayArgs) -> Result<SessionTraces, Failure> {
    let raw = args.folder.join("raw");
    let entries = inside(&args.folder, "raw").and_then(fs::read_dir);
    let entries = entries.map_err(ReadError::of(&raw))?;
    let files = entries.flatten().map(|entry| entry.path());
    let mut files: Vec<_> = files
        .filter(|path| path.extension().is_some_and(|ext| ext == "trace"))
        .collect();
    files.sort();
    let mut all = SessionTraces {
        speed: 1.0,
        ..SessionTraces::default()
    };
    for file in &files {
        let name = file.display().to_string();
        let named = file.file_name().unwrap_or_default();
        let trace = GaugeTrace::parse(
            &read_inside(&raw, named).map_err(ReadError::of(file))?,
            &name,
        )?;
        let refused = |problem: &str| {
            ArgumentError::new(
                name.clone(),
                problem,
                "traces that a session wrote name gauge and instrument in their first lines",
            )
        };
        let channel = trace.header.channel;
        let channel = channel.ok_or_else(|| refused("it does not name its gauge"))?;
        let instrument = trace.header.instrument.clone();
        let instrument = instrument.ok_or_else(|| refused("it does not name its instrument"))?;
        let found = find_description(&instrument, &args.protocols)?;
        all.warnings.extend(found.warnings);
        if !trace.damage.is_empty() {
            let lines = counted(trace.damage.len(), "damaged line");
            all.warnings.push(format!("{name}: left out: {lines}"));
        }
        let mut description = found.description;
        description.channel = channel;
        all.known.take(&description, trace.header.unit.as_deref());
        all.speed = trace.header.speed.unwrap_or(all.speed);
        all.events.extend(events_of(&trace, &description, None)?);
    }
    if all.events.is_empty() {
        return ArgumentError::refuse(
            raw.display().to_string(),
            "there is no trace in it",
            "sessions keep the bytes of their gauges in raw/*.trace; without them nothing can be replayed",
        );
    }
    // Events of one line keep their order.
    all.events.sort_by(|(a_s, _), (b_s, _)| a_s.total_cmp(b_s));
    Ok(all)
}

/// The readings that count in both.
fn compare(
    args: &SessionReplayArgs,
    recorded: &SessionState,
    replayed: &SessionState,
) -> SessionReplayReport {
    let pairs = recorded.taken.iter().filter_map(|(at, place)| {
        let again = replayed.readings.get(*replayed.taken.get(at)?)?;
        Some((&recorded.readings.get(*place)?.taken, &again.taken))
    });
    let mut report = SessionReplayReport {
        folder: args.out.clone(),
        recorded: recorded.taken.len(),
        replayed: 0,
        largest_difference_n: 0.0,
        largest_difference_um: 0.0,
    };
    for (first, again) in pairs {
        let (n, m) = (
            (again.force_n - first.force_n).abs(),
            (again.displacement_m - first.displacement_m).abs(),
        );
        report.replayed += 1;
        report.largest_difference_n = report.largest_difference_n.max(n);
        report.largest_difference_um = report.largest_difference_um.max(m * 1e6);
    }
    report
}
