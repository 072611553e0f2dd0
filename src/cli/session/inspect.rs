//! `session status` and `session log`: a session is checked, never touched.

use std::path::Path;

use stiffbench_document::{Document, Table};

use crate::analysis::Inputs;
use crate::cli::{Failure, Global, Outcome};
use crate::count::hours_and_minutes;
use crate::procedure::Pace;
use crate::report::{NextReading, SessionLog, SessionOutcome, StatusReport};
use crate::session::{
    Event, FolderHolder, OmittedReadings, SessionState, Undone, UndoneAction, ZeroOccasion, Zeroed,
    folder_holder, read_folder,
};

use super::prepare::{day_of_last_event, overdue, plan_of, resume_command};

/// Prints the progress of a session.
pub(super) fn status(folder: &Path, global: &Global) -> Result<Outcome, Failure> {
    let read = read_folder(folder)?;
    let (plan, header, _) = plan_of(&read)?;
    let state = SessionState::fold(&read.journal.records);
    let ended = state.ended.as_ref();
    let holder = folder_holder(folder);
    // Where no event states that it ended and no process has it, it was cut off.
    let outcome = match (&holder, ended) {
        (FolderHolder::Process(_), _) => SessionOutcome::Running,
        (_, Some(ended)) => ended.outcome.into(),
        (FolderHolder::Nobody, None) => SessionOutcome::Crashed,
        (FolderHolder::Unknown, None) => SessionOutcome::RunningOrCrashed,
    };
    let word = match &holder {
        FolderHolder::Process(process) => format!("running, {process}"),
        _ => outcome.words().to_owned(),
    };
    let open = plan.next_open(&state, 0);
    let left_s = plan.seconds_left(&state, &Pace::default());
    let superseded = state.readings.len() - state.taken.len();
    let mut document = Document::new();
    document.lines(format!(
        "{}: {word}\n{} of {} readings, {} skipped, {superseded} superseded or undone",
        folder.display(),
        state.taken.len(),
        plan.len(),
        state.skipped.len(),
    ));
    let left_out = OmittedReadings::of(state.skipped.values());
    for one in &left_out {
        document.item(one.to_string());
    }
    if let Some(ended) = ended {
        let by = by_text(ended.by.as_deref());
        document.item(format!("ended: {}{by}", ended.reason));
    }
    let repeats = plan.repeated_on_resume(&state, state.undecided.as_deref());
    if !repeats.is_empty() && outcome != SessionOutcome::Running {
        document.item(format!("resuming repeats: {}", repeats.join("; ")));
    }
    let next = open.map(|(cell, index)| NextReading {
        pose: plan.cells[cell].pose.clone(),
        direction: plan.cells[cell].direction.clone(),
        target_n: plan.cells[cell].readings[index].target_n,
        repeat: plan.cells[cell].readings[index].repeat,
    });
    if let Some(next) = &next {
        let left = match (left_s / 60.0).round() {
            0.0 => "less than a minute".to_owned(),
            minutes => format!("about {}", hours_and_minutes(minutes)),
        };
        document.item(format!(
            "next: {} {}, {} N, repeat {}; {left} left",
            next.pose, next.direction, next.target_n, next.repeat,
        ));
    }
    let goes_on = next.is_some() || state.undecided.is_some();
    if outcome != SessionOutcome::Running {
        document.next(if goes_on {
            resume_command(folder, &state)
        } else {
            format!("stiffness {}", folder.display())
        });
    }
    let mut warnings = overdue(&header.instruments, day_of_last_event(&read), global)?;
    warnings.extend(read.journal.end.warning());
    let report = StatusReport {
        folder: folder.to_owned(),
        session: header.id.clone(),
        outcome,
        planned: plan.len(),
        accepted: state.taken.len(),
        skipped: state.skipped.len(),
        left_out,
        superseded,
        minutes_left: (left_s / 60.0).round(),
        ended_by: ended.and_then(|ended| ended.by.clone()),
        reason: ended.map(|ended| ended.reason.clone()),
        repeats,
        next,
    };
    Ok(Outcome::new("session-status", document, report)
        .with_inputs(Inputs::default().with_folder(folder, &header))
        .with_warnings(warnings))
}

/// What happened, line by line.
pub(super) fn log(folder: &Path, global: &Global) -> Result<Outcome, Failure> {
    let read = read_folder(folder)?;
    let (_, header, _) = plan_of(&read)?;
    let mut document = Document::new();
    document.table(
        Table::of(&read.journal.records)
            .numbers("event", |record| record.seq)
            .words("UTC", |record| record.utc.strftime("%Y-%m-%d %H:%M:%SZ"))
            .numbers("t, s", |record| format!("{:.1}", record.t_s))
            .words("what happened", |record| event_text(&record.event)),
    );
    let mut warnings = overdue(&header.instruments, day_of_last_event(&read), global)?;
    warnings.extend(read.journal.end.warning());
    let report = SessionLog {
        events: read.journal.records,
    };
    Ok(Outcome::new("session-log", document, report).with_warnings(warnings))
}

/// An event in words.
pub(super) fn event_text(event: &Event) -> String {
    match event {
        Event::Started(started) => format!(
            "session {} began, procedure {}",
            started.session, started.procedure
        ),
        Event::Resumed(resumed) => match resumed.cut_bytes {
            0 => "resumed".to_owned(),
            bytes => {
                format!("resumed; {bytes} bytes of a record that was never confirmed were cut off")
            }
        },
        Event::Instrument(seen) => format!(
            "{} gauge: {} on {} in {}",
            seen.channel, seen.identity, seen.port, seen.unit
        ),
        Event::SignCheck(check) => format!(
            "{} gauge counts {} the axis ({})",
            check.channel,
            along(check.sign),
            check.basis
        ),
        Event::PoseSet(set) => format!("pose {}, direction {}", set.pose, set.direction),
        Event::Zero(zero) => zero_text(zero),
        Event::Reading(taken) => format!(
            "reading {}: {} {} step {} repeat {}: {:.2} N, {}{}",
            taken.number,
            taken.pose,
            taken.direction,
            taken.step,
            taken.repeat,
            taken.force_n,
            taken.displacement_text(),
            if taken.flag.is_empty() {
                String::new()
            } else {
                format!(" [{}]", taken.flag)
            }
        ),
        Event::Superseded(superseded) => format!(
            "reading {} no longer counts: {}",
            superseded.number, superseded.reason
        ),
        Event::Flagged(flagged) => {
            let numbers = listed(&flagged.numbers);
            format!("readings {numbers} are doubtful: {}", flagged.flag)
        }
        Event::Skipped(skipped) => format!(
            "{} reading {} left out: {}",
            skipped.cell_text(),
            skipped.index + 1,
            skipped.words()
        ),
        Event::Undone(undone) => undone_text(undone),
        Event::Note(noted) => format!("note: {}", noted.text),
        Event::Environment(surroundings) => surroundings.to_string(),
        Event::Link(link) => format!("{} gauge: {}", link.channel, link.text),
        Event::Gap(gap) => format!("nothing ran for {:.0} s", gap.seconds),
        Event::ClockJump(jump) => format!("the clock jumped by {:.0} s", jump.seconds),
        Event::Paused(paused) => format!("paused {}", paused.reason),
        Event::CalibrationWarning(warning) => format!("warning: {}", warning.text),
        Event::Ended(ended) => format!(
            "ended: {}{} ({} of {} readings)",
            ended.reason,
            by_text(ended.by.as_deref()),
            ended.accepted,
            ended.planned
        ),
    }
}

/// What was taken back, in words.
pub(super) fn undone_text(undone: &Undone) -> String {
    match &undone.action {
        UndoneAction::Reading { number } => format!("undone: reading {number} no longer counts"),
        UndoneAction::Skip {
            cell,
            indices,
            reason,
        } => {
            let places: Vec<u32> = indices.iter().map(|index| *index as u32 + 1).collect();
            format!(
                "undone: cell {} readings {} are open again; they had been left out: {reason}",
                cell + 1,
                listed(&places)
            )
        }
        UndoneAction::Flag { numbers: of, flag } => format!(
            "undone: readings {} are no longer flagged: {flag}",
            listed(of)
        ),
    }
}

fn listed(numbers: &[u32]) -> String {
    let numbers: Vec<String> = numbers.iter().map(u32::to_string).collect();
    numbers.join(", ")
}

/// By whom a session was ended, behind the reason.
fn by_text(by: Option<&str>) -> String {
    by.map_or_else(String::new, |by| format!(" (by: {by})"))
}

/// A gauge zero in words.
fn zero_text(zero: &Zeroed) -> String {
    let drifts: Vec<f64> = if zero.gauges.is_empty() {
        zero.drift_m.into_iter().collect()
    } else {
        zero.gauges
            .iter()
            .filter_map(|gauge| gauge.drift_m)
            .collect()
    };
    let drifts: Vec<String> = drifts
        .iter()
        .map(|m| format!("{:.1} um", m * 1e6))
        .collect();
    let drift = match drifts.join(", ") {
        none if none.is_empty() => none,
        drifts => format!(", moved by {drifts}"),
    };
    let force = zero.force_drift_n;
    let drift = drift + &force.map_or_else(String::new, |n| format!(" and {n:.2} N"));
    let word = |by_gauge: bool| if by_gauge { "gauge" } else { "subtracted" };
    let how = zero.by_gauge.map(word);
    match zero.moment {
        ZeroOccasion::Before if zero.gauges.is_empty() => format!(
            "zero {} set (force {}, displacement {})",
            zero.label, how[0], how[1]
        ),
        ZeroOccasion::Before => {
            let gauges = zero.gauges.iter();
            let gauges =
                gauges.map(|gauge| format!(", {} {}", gauge.channel, word(gauge.by_gauge)));
            let gauges: String = gauges.collect();
            format!("zero {} set (force {}{gauges})", zero.label, how[0])
        }
        ZeroOccasion::After => format!("zero {} checked{drift}", zero.label),
        ZeroOccasion::Kept if zero.flag.is_empty() => {
            format!("zero {} still holds{drift}", zero.label)
        }
        ZeroOccasion::Kept => format!("zero {} no longer holds{drift}", zero.label),
    }
}

fn along(sign: f64) -> &'static str {
    if sign > 0.0 { "along" } else { "against" }
}
