//! `session undo`: the last decision of a session that has stopped is taken back by one more event.

use std::path::Path;

use jiff::Timestamp;

use stiffbench_document::Document;

use crate::analysis::{ArgumentError, Inputs};
use crate::cli::{Failure, Global, Outcome};
use crate::report::UndoReport;
use crate::session::{Event, SessionEnd, SessionFolder, SessionState, last_decision, read_folder};

use super::inspect::{event_text, undone_text};
use super::prepare::{day_of_last_event, overdue, plan_of, resume_command};

/// Takes back the last reading, skip or flag, and states which it was.
pub(super) fn run(folder: &Path, global: &Global) -> Result<Outcome, Failure> {
    let before = read_folder(folder)?;
    let (plan, header, _) = plan_of(&before)?;
    let warnings = overdue(&header.instruments, day_of_last_event(&before), global)?;
    let (held, mut journal, read, _) = SessionFolder::open(folder, Timestamp::now())?;
    let mut state = SessionState::fold(&read.records);
    let refused =
        |problem: &str, help: &str| ArgumentError::new(folder.display().to_string(), problem, help);
    let ended = state.ended.as_ref().map(|ended| ended.outcome);
    if ended == Some(SessionEnd::Complete) {
        return Err(refused(
            "the session is complete: nothing of it is taken back",
            "to leave a reading out of the analyses, set its status in readings.csv to rejected; the journal keeps it",
        )
        .into());
    }
    let Some(undone) = last_decision(&read.records, &state) else {
        return Err(refused(
            "there is no reading, skip or flag that could be taken back",
            "stiffbench session log shows what happened in the session",
        )
        .into());
    };
    let record = journal.append(
        Event::Undone(undone.clone()),
        Timestamp::now(),
        state.last_s,
    )?;
    state.apply(&record);
    held.rewrite_table(&state)?;
    let words = undone_text(&undone);
    let mut document = Document::of(format!("{}: {words}", folder.display()));
    let was = read.records.iter();
    for taken in was.filter(|one| undone.events.contains(&one.seq)) {
        document.item(format!("event {}: {}", taken.seq, event_text(&taken.event)));
    }
    document.paragraph(format!(
        "{} of {} readings; the journal keeps what was taken back, event {} takes it back",
        state.taken.len(),
        plan.len(),
        record.seq,
    ));
    document.next(resume_command(folder, &state));
    let report = UndoReport {
        folder: folder.to_owned(),
        event: record.seq,
        undone,
        text: words,
        planned: plan.len(),
        accepted: state.taken.len(),
        skipped: state.skipped.len(),
    };
    Ok(Outcome::new("session-undo", document, report)
        .with_inputs(Inputs::default().with_folder(folder, &header))
        .with_warnings(warnings))
}
