//! `session verify` and `session recover`.

use std::path::Path;

use jiff::Timestamp;
use serde_json::json;

use crate::cli::failure::Failure;
use crate::cli::outcome::Outcome;
use crate::session::{JournalEnd, ReadJournal, SessionState, read_folder, recover};

/// Exit code for data that are damaged and readable in part.
const PART: u8 = 30;

/// Exit code for data of which nothing can be read.
const NOTHING: u8 = 31;

/// Whether the journal of a session is whole.
pub(super) fn verify(folder: &Path) -> Result<Outcome, Failure> {
    let read = read_folder(folder)?;
    let state = SessionState::fold(&read.journal.records);
    let (found, exit) = finding(&read.journal);
    let next = if exit == 0 {
        String::new()
    } else {
        format!(
            "Next: stiffbench session recover {} --out NEW\n",
            folder.display()
        )
    };
    let text = format!(
        "{}: {} events, {} readings; {found}\n{next}",
        folder.display(),
        read.journal.records.len(),
        state.readings.len()
    );
    let data = report(&read.journal, &state, exit);
    Ok(Outcome::new("session-verify", text, data).with_exit(exit))
}

/// Keeps what is good in a new folder.
pub(super) fn recover_into(folder: &Path, out: &Path) -> Result<Outcome, Failure> {
    let journal = recover(folder, out, Timestamp::now())?;
    let state = SessionState::fold(&journal.records);
    let (found, exit) = finding(&journal);
    let text = format!(
        "{}: {} events and {} readings kept and read back; {found}\n{} is as it was\nNext: stiffbench session status {}\n",
        out.display(),
        journal.records.len(),
        state.readings.len(),
        folder.display(),
        out.display()
    );
    let data = report(&journal, &state, exit);
    Ok(Outcome::new("session-recover", text, data).with_exit(exit))
}

/// What is wrong with a journal, and the exit code for it.
fn finding(journal: &ReadJournal) -> (String, u8) {
    match &journal.end {
        JournalEnd::Clean => ("the journal is whole".to_owned(), 0),
        JournalEnd::Cut { bytes } => (
            format!(
                "behind them {bytes} bytes of a record that was never confirmed; nothing is lost"
            ),
            0,
        ),
        JournalEnd::Damaged {
            line,
            problem,
            lines,
        } => {
            let exit = if journal.records.is_empty() {
                NOTHING
            } else {
                PART
            };
            let found = format!(
                "line {line} is damaged: {problem}; {lines} line(s) from there on are lost"
            );
            (found, exit)
        }
    }
}

fn report(journal: &ReadJournal, state: &SessionState, exit: u8) -> serde_json::Value {
    let lines = match &journal.end {
        JournalEnd::Damaged { lines, .. } => *lines,
        _ => 0,
    };
    let (found, _) = finding(journal);
    json!({
        "whole": exit == 0,
        "events": journal.records.len(),
        "readings": state.readings.len(),
        "accepted": state.taken.len(),
        "lost_lines": lines,
        "finding": found,
    })
}
