//! From arguments or a session folder to plan, header, settings and answers.

use std::io;
use std::path::Path;

use jiff::civil::Date;
use jiff::tz::TimeZone;

use crate::analysis::{AnalysisError, ArgumentError, ResolvedModel, add_poses, read_text, sha256};
use crate::cli::args::ModelArgs;
use crate::cli::global::today;
use crate::cli::{Failure, Global};
use crate::procedure::Procedure;
use crate::readings::{InstrumentRecord, Instruments, SessionHeader};
use crate::session::{Answers, FolderError, ReadFolder, SessionPlan, SessionState};
use crate::stiffness::{GaugePair, GaugeTerms};

use super::args::{BenchArgs, CaptureWord};
use super::emulation::emulated_before;

/// The plan of a session folder, its header, and the hash of its procedure.
pub(super) fn plan_of(read: &ReadFolder) -> Result<(SessionPlan, SessionHeader, String), Failure> {
    let header = SessionHeader::from_toml(&read.header_name, &read.header)?.header;
    let record = header.procedure.clone().unwrap_or_default();
    let procedure = Procedure::from_record(&record)?;
    let hash = sha256(procedure.to_toml());
    Ok((SessionPlan::new(&procedure, &[]), header, hash))
}

/// The robot of a session that goes on, with the poses of its procedure.
pub(super) fn robot_of(
    header: &SessionHeader,
    folder: &Path,
    plan: &SessionPlan,
) -> Result<ResolvedModel, Failure> {
    let robot = header.robot.as_ref().map(|robot| folder.join(robot));
    let emulated = header.origin.as_deref().and_then(emulated_before);
    let model = ModelArgs {
        effects: emulated.map(|(_, effects)| effects).unwrap_or_default(),
        robot: robot.map(|robot| robot.display().to_string()),
        mechanism: header.mechanism.clone(),
        factors: header.factors.clone(),
        ..ModelArgs::default()
    };
    let mut model = model.resolve()?;
    add_poses(&mut model.robot, &plan.procedure)?;
    Ok(model)
}

/// Instrument records from a file, and what a user should know of it.
pub(in crate::cli) fn instrument_records(
    path: Option<&Path>,
) -> Result<(Instruments, Vec<String>), Failure> {
    let Some(path) = path else {
        return Ok((Instruments::default(), Vec::new()));
    };
    let name = path.display().to_string();
    let read = SessionHeader::from_toml(&name, &read_text(path)?)?;
    let warnings = read.unknown_keys.iter().map(|key| key.warning(&name));
    Ok((read.header.instruments, warnings.collect()))
}

/// The command that goes on with a session; one on an emulated bench goes on there.
pub(super) fn resume_command(folder: &Path, state: &SessionState) -> String {
    let started = state.started.as_ref();
    let origin = started.and_then(|started| started.origin.as_deref());
    let emulated = origin.is_some_and(|origin| origin.starts_with("emulated"));
    let option = if emulated { " --emulated" } else { "" };
    format!("session resume {}{option}", folder.display())
}

/// The day of the last event of a session, UTC; today if it has none.
pub(super) fn day_of_last_event(read: &ReadFolder) -> Date {
    let last = read.journal.records.last();
    last.map_or_else(today, |last| last.utc.to_zoned(TimeZone::UTC).date())
}

/// Calibrations that had run out on a day.
pub(super) fn run_out(instruments: &Instruments, day: Date) -> Vec<String> {
    let overdue = instruments.overdue(day).into_iter();
    let words =
        overdue.map(|one| format!("calibration of the {} ran out on {}", one.gauge, one.due));
    words.collect()
}

/// Warns of calibrations that had run out on a day, or refuses them under `--strict`.
pub(super) fn overdue(
    instruments: &Instruments,
    day: Date,
    global: &Global,
) -> Result<Vec<String>, Failure> {
    let warnings = run_out(instruments, day);
    if global.strict && !warnings.is_empty() {
        return Err(AnalysisError::CalibrationOverdue {
            instruments: warnings.join("; "),
        }
        .into());
    }
    Ok(warnings)
}

/// Resolution and calibration of the gauges, as far as they are stated.
pub(super) fn gauge_terms(instruments: &Instruments) -> Result<GaugePair, Failure> {
    Ok(GaugePair {
        force: GaugeTerms::of(instruments.force.as_ref())?,
        // The view of a cell has one displacement, along the load: the coarsest gauge has most to say about it.
        displacement: GaugeTerms::of(coarsest(instruments).or(instruments.displacement.as_ref()))?,
    })
}

/// The record of the gauge along a base axis with the largest step.
fn coarsest(instruments: &Instruments) -> Option<&InstrumentRecord> {
    let step = |record: &InstrumentRecord| record.resolution.unwrap_or(0.0);
    let records = instruments.displacement_along.iter().flatten();
    records.max_by(|a, b| step(a).total_cmp(&step(b)))
}

/// The answers that are known beforehand: those of the command line go before those of the file. Those that nothing in the plan asks for are
/// named in a warning.
pub(super) fn answers(
    args: &BenchArgs,
    plan: &SessionPlan,
    warnings: &mut Vec<String>,
    global: &Global,
) -> Result<Answers, Failure> {
    let mut answers = match &args.answers {
        Some(path) => Answers::parse(&path.display().to_string(), &read_text(path)?)?,
        None => Answers::default(),
    };
    for answer in &args.answer {
        answers.take_argument(answer)?;
    }
    answers.no_input = global.no_input;
    let never_asked = answers.never_asked(plan).into_iter();
    warnings.extend(never_asked.map(|name| {
        format!("the answer {name} is never asked for: the plan has no such pose, direction or gauge; stiffbench session plan lists them")
    }));
    Ok(answers)
}

/// Whether a folder can be made at a place.
pub(super) fn check_place(folder: &Path) -> Result<(), FolderError> {
    let mut above = folder.ancestors().skip(1);
    let there = above.find(|path| path.symlink_metadata().is_ok());
    let there = there.unwrap_or(Path::new("."));
    let refused = if !there.is_dir() {
        io::ErrorKind::NotADirectory.into()
    } else if let Err(refused) = may_write(there) {
        refused
    } else {
        return Ok(());
    };
    Err(FolderError::System {
        path: there.to_owned(),
        source: refused,
    })
}

#[cfg(unix)]
fn may_write(folder: &Path) -> io::Result<()> {
    use rustix::fs::{Access, access};
    Ok(access(folder, Access::WRITE_OK | Access::EXEC_OK)?)
}

#[cfg(not(unix))]
fn may_write(_folder: &Path) -> io::Result<()> {
    Ok(())
}

/// Refuses to wait for keys that nobody presses.
pub(super) fn refuse_keys_without_hands(
    args: &BenchArgs,
    global: &Global,
) -> Result<(), ArgumentError> {
    if args.capture == CaptureWord::Key && global.no_input {
        return Err(ArgumentError::new(
            "--capture key",
            "with --no-input nobody presses a key",
            "leave out one of them",
        ));
    }
    Ok(())
}
