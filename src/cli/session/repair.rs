//! `session verify` and `session recover`.

use std::fs;
use std::path::Path;

use jiff::Timestamp;
use stiffbench_document::Document;

use crate::analysis::{
    Inputs, JournalCheck, ReadError, TableCheck, compare_with_journal, session_file, sha256,
    shortened,
};
use crate::cli::{Failure, Global, Outcome};
use crate::readings::{SessionHeader, TableError, read_readings};
use crate::report::{JournalReport, VerifiedJournal, VerifyReport};
use crate::session::{
    FolderHolder, JournalEnd, RawCheck, ReadFolder, ReadJournal, SessionState, check_raw_bytes,
    folder_holder, read_folder, read_inside, recover,
};

use super::prepare::{day_of_last_event, overdue, plan_of, run_out};
use crate::count::counted;

/// Exit code for data that are damaged and readable in part.
const PART: u8 = 30;

/// Exit code for data of which nothing can be read.
const NOTHING: u8 = 31;

/// Verifies that the journal of a session is intact and that its files agree with it.
pub(super) fn verify(folder: &Path) -> Result<Outcome, Failure> {
    let has_journal = session_file(folder, "journal.jsonl")?.is_some();
    let file = session_file(folder, "readings.csv")?;
    if !has_journal && file.is_some() {
        let mut document = Document::new();
        document.lines(format!(
            "{}: not protected: there is no journal to compare the readings with",
            folder.display()
        ));
        let report = VerifyReport {
            journal: VerifiedJournal::None { whole: true },
            table: TableCheck::NotProtected,
            robot_changed: false,
            not_verified: Vec::new(),
            raw: None,
        };
        return Ok(Outcome::new("session-verify", document, report));
    }
    let read = read_folder(folder)?;
    let state = SessionState::fold(&read.journal.records);
    let (found, exit) = (read.journal.end.finding(), exit_for(&read.journal));
    let (table, table_found, table_exit) = verify_table(folder, file.as_deref(), &read)?;
    let (robot_changed, not_verified) = verify_files(folder, &read, &state);
    let (raw, raw_found, raw_exit) = verify_raw(folder, &state);
    let mut exit = exit.max(table_exit).max(raw_exit);
    let mut document = Document::new();
    document.item(format!(
        "{}: {}, {}; {found}",
        folder.display(),
        counted(read.journal.records.len(), "event"),
        counted(state.readings.len(), "reading"),
    ));
    let file = folder.join("readings.csv");
    document.item(format!("{}: {table_found}", file.display()));
    if robot_changed {
        exit = exit.max(PART);
        document.item("changed after the session: robot.toml");
    }
    if let Some(last) = last_logged(folder).filter(|last| *last > state.events) {
        exit = exit.max(PART);
        document.item(format!(
            "session.log names event {last}: the journal was cut behind event {}",
            state.events
        ));
    } else if state.ended.is_none() && folder_holder(folder) == FolderHolder::Nobody {
        document.item("no end of the session: it was interrupted, or the journal was cut");
    }
    if !not_verified.is_empty() {
        let names = not_verified.join("; ");
        document.item(format!(
            "not verified, because the journal has no hash of it: {names}"
        ));
    }
    if let Some(found) = raw_found {
        document.item(found);
    }
    if exit == PART && read.journal.records.is_empty() {
        exit = NOTHING;
    }
    if exit != 0 {
        document.next(format!("session recover {} --out NEW", folder.display()));
    }
    let data = VerifyReport {
        journal: VerifiedJournal::Read(report(&read.journal, &state, exit)),
        table,
        robot_changed,
        not_verified: not_verified.into_iter().map(Into::into).collect(),
        raw,
    };
    let mut outcome = Outcome::new("session-verify", document, data).with_exit(exit);
    // Of a damaged journal not even the header may be left.
    if let Ok((_, header, _)) = plan_of(&read) {
        outcome = outcome
            .with_inputs(Inputs::default().with_folder(folder, &header))
            .with_overdue(run_out(&header.instruments, day_of_last_event(&read)));
    }
    Ok(outcome)
}

/// The last event that `session.log` names; it is written after the journal.
fn last_logged(folder: &Path) -> Option<u64> {
    let log = read_inside(folder, "session.log").ok()?;
    let log = String::from_utf8_lossy(&log);
    let named = log.lines().filter_map(|line| {
        let (_, text) = line.split_once("\"message\":\"event ")?;
        text.split(':').next()?.parse().ok()
    });
    named.max()
}

/// The readings beside the bytes of the gauges: for JSON, in words, and the exit code for it.
fn verify_raw(folder: &Path, state: &SessionState) -> (Option<RawCheck>, Option<String>, u8) {
    let mut readings = state.readings.iter();
    if readings.all(|kept| kept.taken.raw_bytes.is_empty()) {
        return (None, None, 0);
    }
    let check = check_raw_bytes(folder, state);
    let behind = match check.behind.len() {
        0 => String::new(),
        count => format!(
            "; not on the disk yet when the session stopped: those of the last {}",
            counted(count, "reading")
        ),
    };
    let (wrong, exit) = match check.wrong.first() {
        None => (String::new(), 0),
        Some(first) => {
            let others = check.wrong.len() - 1;
            let more = if others > 0 {
                format!(", and {others} more")
            } else {
                String::new()
            };
            let text = format!(
                "; reading {}, {} gauge: {}{more}",
                first.number, first.channel, first.problem
            );
            (text, PART)
        }
    };
    let text = format!(
        "{}: the bytes of {} are in the traces{behind}{wrong}",
        folder.join("raw").display(),
        counted(check.found, "value")
    );
    (Some(check), Some(text), exit)
}

/// The table beside its journal: for JSON, in words, and the exit code for it.
fn verify_table(
    folder: &Path,
    file: Option<&Path>,
    read: &ReadFolder,
) -> Result<(TableCheck, String, u8), Failure> {
    let Some(file) = file else {
        let found = "it does not exist; it can be rebuilt from the journal".to_owned();
        return Ok((TableCheck::Missing, found, PART));
    };
    let not_protected = || {
        let found = "no intact part of the journal is left to compare it with".to_owned();
        (TableCheck::NotProtected, found, 0)
    };
    let is_damaged = matches!(read.journal.end, JournalEnd::Damaged { .. });
    if is_damaged && read.journal.records.is_empty() {
        return Ok(not_protected());
    }
    let open = fs::File::open(file).map_err(ReadError::of(file))?;
    let name = file.display().to_string();
    let header = SessionHeader::from_toml(&read.header_name, &read.header)?.header;
    let of_vectors = header.is_of_vectors();
    let table = read_readings(&name, open);
    let is_begun = |error: &TableError| match error.code {
        "stiffbench::readings::empty" => true,
        "stiffbench::readings::no_readings" => of_vectors,
        _ => false,
    };
    match table {
        // A session that has just begun.
        Err(error) if is_begun(&error) => Ok((TableCheck::Empty, "no reading yet".to_owned(), 0)),
        Err(error) => {
            let found = format!("it cannot be read: {error}");
            let reason = error.to_string();
            Ok((TableCheck::Unreadable { reason }, found, PART))
        }
        Ok(table) => {
            let check = compare_with_journal(folder, &table, Some(&header))?;
            let judge = |check| judged(&check, file, &read.journal.end);
            Ok(check.map_or_else(not_protected, judge))
        }
    }
}

/// Whether `robot.toml` is another than the journal has, and what the journal has no hash of.
fn verify_files(
    folder: &Path,
    read: &ReadFolder,
    state: &SessionState,
) -> (bool, Vec<&'static str>) {
    let started = state.started.as_ref();
    let robot = started.and_then(|started| started.robot_sha256.as_ref());
    let is_that =
        |hash: &String| read_inside(folder, "robot.toml").is_ok_and(|it| sha256(it) == *hash);
    let mut unknown = Vec::new();
    if robot.is_none() {
        unknown.push("robot.toml");
    }
    if started.is_none_or(|started| started.header_sha256.is_none()) {
        unknown.push("session.toml (operator, specimen, place, factors)");
        // Another program may have written the same procedure in other words.
        let procedure = plan_of(read).map(|(_, _, hash)| hash).unwrap_or_default();
        if started.is_none_or(|started| started.procedure_sha256 != procedure) {
            unknown.push("session.toml (procedure)");
        }
    }
    if started.is_none_or(|started| started.instruments_sha256.is_none()) {
        unknown.push("session.toml (instruments)");
    }
    (robot.is_some_and(|hash| !is_that(hash)), unknown)
}

fn judged(check: &JournalCheck, file: &Path, end: &JournalEnd) -> (TableCheck, String, u8) {
    let changes = check.changes(file);
    let json = check.report(file);
    if changes.is_empty() {
        let found = match end {
            JournalEnd::Damaged { .. } => "no number differs from the intact part of the journal",
            _ => "every number matches the journal",
        };
        (json, found.to_owned(), 0)
    } else {
        (
            json,
            format!("changed after the session: {}", shortened(&changes)),
            PART,
        )
    }
}

/// Keeps what is good in a new folder; an overdue calibration is refused under `--strict` before it is made.
pub(super) fn recover_into(folder: &Path, out: &Path, global: &Global) -> Result<Outcome, Failure> {
    // Of a damaged session not even the header may be left.
    let read = read_folder(folder).ok();
    let planned = read.as_ref();
    let planned = planned.and_then(|read| Some((plan_of(read).ok()?.1, day_of_last_event(read))));
    let warnings = match planned {
        Some((header, day)) => overdue(&header.instruments, day, global)?,
        None => Vec::new(),
    };
    let journal = recover(folder, out, Timestamp::now())?;
    let state = SessionState::fold(&journal.records);
    let (found, exit) = (journal.end.finding(), exit_for(&journal));
    let mut document = Document::new();
    document.item(format!(
        "{}: {} and {} kept and read back; {found}",
        out.display(),
        counted(journal.records.len(), "event"),
        counted(state.readings.len(), "reading"),
    ));
    // A journal without its end is as intact as one of a session that was broken off; the table may know more.
    if let (Some(read), Some(file)) = (read, session_file(folder, "readings.csv")?)
        && let Ok((TableCheck::Changed(_), changed, _)) = verify_table(folder, Some(&file), &read)
    {
        document.item(format!("not taken over from {}: {changed}", file.display()));
    }
    document.item(format!("{} is as it was", folder.display()));
    document.next(format!("session status {}", out.display()));
    let data = report(&journal, &state, exit);
    Ok(Outcome::new("session-recover", document, data)
        .with_warnings(warnings)
        .with_exit(exit))
}

/// The exit code for what is wrong with a journal.
fn exit_for(journal: &ReadJournal) -> u8 {
    match journal.end {
        JournalEnd::Damaged { .. } if journal.records.is_empty() => NOTHING,
        JournalEnd::Damaged { .. } => PART,
        JournalEnd::Clean | JournalEnd::Cut { .. } => 0,
    }
}

fn report(journal: &ReadJournal, state: &SessionState, exit: u8) -> JournalReport {
    let lines = match &journal.end {
        JournalEnd::Damaged { lines, .. } => *lines,
        _ => 0,
    };
    JournalReport {
        whole: exit == 0,
        events: journal.records.len(),
        readings: state.readings.len(),
        accepted: state.taken.len(),
        lost_lines: lines,
        finding: journal.end.finding(),
    }
}
