//! The one loop on a clock that runs fast, with a folder on the disk: locks, refusals, answers that are missing, resuming.

use std::cell::RefCell;
use std::collections::VecDeque;
use std::path::Path;
use std::rc::Rc;
use std::time::Duration;

use crate::support::{MockBench, csv_without_times, plan, resumed, short, started};
use jiff::Timestamp;
use stiffbench_gauges::{Ask, Channel, GaugeEvent, Gauges};
use stiffbench_measurement::procedure::Procedure;
use stiffbench_measurement::readings::read_readings;
use stiffbench_session::{
    Answers, Bell, Event, FolderError, FolderHolder, JournalEnd, Machine, Noted, Operator,
    OperatorEvent, Prompt, RunError, SessionEnd, SessionFolder, SessionInputs, SessionState,
    SessionView, Settings, folder_holder, read_folder, read_journal, recover, run,
};
use stiffbench_units_and_text::clock::Clock;

/// Head of a session, and when it begins.
const HEADER: &str = "schema = \"stiffbench/session/1\"\n";
const NOW: Timestamp = Timestamp::UNIX_EPOCH;

/// Session seconds in a real one.
const SPEED: f64 = 400.0;

/// What the gauges and the operator of a mock bench share.
struct Shared {
    bench: MockBench,
    clock: Clock,
    coming: VecDeque<GaugeEvent>,
}

struct MockGauges(Rc<RefCell<Shared>>);

impl Gauges for MockGauges {
    fn next(&mut self, _wait: Duration) -> Option<GaugeEvent> {
        let mut shared = self.0.borrow_mut();
        if let Some(event) = shared.coming.pop_front() {
            return Some(event);
        }
        let now_s = shared.clock.now_s();
        if now_s - shared.bench.now_s < 0.1 {
            return None;
        }
        shared.bench.now_s = now_s;
        shared.bench.turn();
        let samples: Vec<GaugeEvent> = Channel::ALL
            .iter()
            .filter_map(|channel| shared.bench.sample(*channel))
            .collect();
        shared.coming.extend(samples);
        shared.coming.pop_front()
    }

    fn ask(&mut self, channel: Channel, ask: Ask) {
        let mut shared = self.0.borrow_mut();
        let answered = shared.bench.asked(channel, ask);
        shared.coming.push_back(answered);
    }
}

/// Does what the view says, and keeps what was said.
struct Follower {
    shared: Rc<RefCell<Shared>>,
    said: Vec<String>,
    /// Stops after so many readings.
    stop_after: Option<usize>,
    stopped: bool,
}

impl Operator for Follower {
    fn show(&mut self, view: &SessionView) {
        self.shared.borrow_mut().bench.follow(view);
        self.stopped |= self.stop_after.is_some_and(|n| view.progress.accepted >= n);
    }

    fn prompt(&mut self, prompt: &Prompt) {
        // Nobody is there to answer.
        self.said.push(format!("asked {}", prompt.id));
    }

    fn poll(&mut self, _wait: Duration) -> Option<OperatorEvent> {
        std::mem::take(&mut self.stopped).then_some(OperatorEvent::Abort)
    }

    fn bell(&mut self, _bell: Bell) {}

    fn notify(&mut self, line: &str) {
        self.said.push(line.to_owned());
    }
}

fn answers(lines: &[&str]) -> Answers {
    let mut answers = Answers {
        no_input: true,
        ..Answers::default()
    };
    for line in lines {
        answers.take_argument(line).unwrap();
    }
    answers
}

const ALL: [&str; 4] = [
    "ready=true",
    "setup=true",
    "sign-check=minus",
    "temperature=21",
];

/// Runs the session in a folder, new or begun; with the bench as it was left.
fn session(
    folder: &Path,
    answers: &Answers,
    stop_after: Option<usize>,
    bench: &mut MockBench,
) -> Result<SessionEnd, RunError> {
    session_of(&short(false), folder, answers, stop_after, bench).0
}

/// The same by a procedure, with what was said.
fn session_of(
    procedure: &Procedure,
    folder: &Path,
    answers: &Answers,
    stop_after: Option<usize>,
    bench: &mut MockBench,
) -> (Result<SessionEnd, RunError>, Vec<String>) {
    let (folder, mut journal, state) = if folder.exists() {
        let (folder, journal, read, _) = SessionFolder::open(folder, NOW).unwrap();
        (folder, journal, SessionState::fold(&read.records))
    } else {
        let (folder, journal) = SessionFolder::create(folder, HEADER, None, NOW).unwrap();
        (folder, journal, SessionState::default())
    };
    let clock = Clock::starting_at(state.last_s, SPEED);
    let first = match state.started {
        None => started(procedure),
        Some(_) => resumed(),
    };
    let mut machine = Machine::new(plan(procedure), Settings::default(), state);
    let record = journal.append(first, clock.utc(), clock.now_s()).unwrap();
    machine.recorded(&record);
    bench.now_s = clock.now_s();
    let shared = Rc::new(RefCell::new(Shared {
        bench: bench.clone(),
        clock,
        coming: VecDeque::new(),
    }));
    let mut operator = Follower {
        shared: Rc::clone(&shared),
        said: Vec::new(),
        stop_after,
        stopped: false,
    };
    let ended = run(
        &mut machine,
        SessionInputs {
            gauges: &mut MockGauges(Rc::clone(&shared)),
            operator: &mut operator,
            clock: &clock,
            journal: &mut journal,
            table: Some(&folder),
            answers,
            repeats: None,
        },
    );
    *bench = shared.borrow().bench.clone();
    (ended, operator.said)
}

fn state_of(folder: &Path) -> SessionState {
    let read = read_folder(folder).unwrap();
    assert_eq!(read.journal.end, JournalEnd::Clean);
    SessionState::fold(&read.journal.records)
}

#[test]
fn a_session_stopped_and_resumed_gives_the_table_of_one_that_was_not() {
    let desk = tempfile::tempdir().unwrap();
    let (whole, parted) = (desk.path().join("whole"), desk.path().join("parted"));
    let all = answers(&ALL);
    let outcome = session(&whole, &all, None, &mut MockBench::default()).unwrap();
    assert_eq!(outcome, SessionEnd::Complete);
    let mut bench = MockBench::default();
    for (stop_after, expected) in [(Some(2), SessionEnd::Aborted), (None, SessionEnd::Complete)] {
        let ended = session(&parted, &all, stop_after, &mut bench).unwrap();
        assert_eq!(ended, expected);
    }
    let (whole_state, parted_state) = (state_of(&whole), state_of(&parted));
    assert_eq!(
        csv_without_times(&whole_state),
        csv_without_times(&parted_state)
    );
    // The live table is that of the journal, and an analysis reads it.
    let live = std::fs::read(parted.join("readings.csv")).unwrap();
    let mut rebuilt = Vec::new();
    stiffbench_session::table(&parted_state, &mut rebuilt).unwrap();
    assert_eq!(
        String::from_utf8(live.clone()).unwrap(),
        String::from_utf8(rebuilt).unwrap()
    );
    let table = read_readings("readings.csv", &live[..]).unwrap();
    assert_eq!(
        (
            table.accepted().count(),
            table.runs.len(),
            table.zeros.len()
        ),
        (6, 2, 2)
    );
}

#[test]
fn a_question_without_an_answer_ends_the_session_and_names_the_flag() {
    let desk = tempfile::tempdir().unwrap();
    let folder = desk.path().join("s");
    let error = session(
        &folder,
        &answers(&ALL[..2]),
        None,
        &mut MockBench::default(),
    )
    .unwrap_err();
    let RunError::NeedsInput { help, .. } = error else {
        panic!("{error}");
    };
    assert!(help.contains("--answer sign-check.P1.x=VALUE"), "{help}");
    assert_eq!(
        state_of(&folder).ended.unwrap().outcome,
        SessionEnd::Partial
    );
    // A list that is not ticked is no answer either.
    let wrong = answers(&["ready=false", "setup=true"]);
    let error = session(&folder, &wrong, None, &mut MockBench::default()).unwrap_err();
    assert!(
        matches!(&error, RunError::NeedsInput { help, .. } if help.contains("every item of the list"))
    );
    let all = answers(&ALL);
    assert_eq!(
        session(&folder, &all, None, &mut MockBench::default()).unwrap(),
        SessionEnd::Complete
    );
}

#[test]
fn a_second_process_gets_the_holder_of_the_session() {
    let desk = tempfile::tempdir().unwrap();
    let path = desk.path().join("s");
    let (_, held) = SessionFolder::create(&path, HEADER, None, NOW).unwrap();
    let error = SessionFolder::open(&path, NOW).unwrap_err();
    let FolderError::InUse { holder, .. } = error else {
        panic!("{error}");
    };
    assert!(
        holder.contains(&format!("process {}", std::process::id())),
        "{holder}"
    );
    assert!(holder.contains("1970-01-01 00:00:00 UTC"), "{holder}");
    // The lock is on the journal: without the file that names the holder it still holds.
    std::fs::remove_file(path.join("session.lock")).unwrap();
    let error = SessionFolder::open(&path, NOW).unwrap_err();
    assert!(matches!(&error, FolderError::InUse { holder, .. } if holder == "another process"));
    let holder = folder_holder(&path);
    assert!(matches!(holder, FolderHolder::Process(_)), "{holder:?}");
    drop(held);
    assert!(SessionFolder::open(&path, NOW).is_ok());
    let error = SessionFolder::create(&path, "", None, NOW).unwrap_err();
    assert!(matches!(error, FolderError::Exists { .. }));
}

#[cfg(unix)]
#[test]
fn a_journal_that_is_cut_deleted_or_replaced_while_it_is_open_loses_nothing() {
    let desk = tempfile::tempdir().unwrap();
    let path = desk.path().join("s");
    let journal = path.join("journal.jsonl");
    let (_, mut held) = SessionFolder::create(&path, HEADER, None, NOW).unwrap();
    let victim = desk.path().join("victim");
    std::fs::write(&victim, "mine").unwrap();
    let harms: [&dyn Fn(); 5] = [
        &|| std::fs::write(&journal, "").unwrap(),
        &|| std::fs::remove_file(&journal).unwrap(),
        &|| std::fs::write(&journal, "a longer text".repeat(99)).unwrap(),
        &|| {
            let copy = path.join("copy");
            std::fs::copy(&journal, &copy).unwrap();
            std::fs::rename(&copy, &journal).unwrap();
        },
        &|| {
            std::fs::remove_file(&journal).unwrap();
            std::os::unix::fs::symlink(&victim, &journal).unwrap();
        },
    ];
    for (number, harm) in (1..).zip(harms) {
        let note = |text: String| Event::Note(Noted { cell: None, text });
        held.append(note(format!("a {number}")), NOW, 0.0).unwrap();
        harm();
        held.append(note(format!("b {number}")), NOW, 0.0).unwrap();
        let read = read_journal(&std::fs::read(&journal).unwrap());
        assert_eq!(read.records.len(), 2 * number, "{number}");
        assert_eq!(read.end, JournalEnd::Clean, "{number}");
        let error = SessionFolder::open(&path, NOW).unwrap_err();
        assert!(matches!(error, FolderError::InUse { .. }), "{number}");
    }
    assert_eq!(std::fs::read(&victim).unwrap(), b"mine");
}

#[test]
fn a_torn_line_is_taken_off_and_a_damaged_one_is_left_to_recover() {
    let desk = tempfile::tempdir().unwrap();
    let path = desk.path().join("s");
    session(&path, &answers(&ALL), None, &mut MockBench::default()).unwrap();
    let journal = path.join("journal.jsonl");
    let whole = std::fs::read(&journal).unwrap();
    std::fs::write(&journal, &whole[..whole.len() - 5]).unwrap();
    let (folder, _, read, cut) = SessionFolder::open(&path, NOW).unwrap();
    assert!(cut > 0);
    assert_eq!(std::fs::read(&journal).unwrap().len(), read.good_bytes);
    drop(folder);
    // A byte in the middle turned over: what stands before it is kept, in a folder of its own.
    let mut damaged = whole.clone();
    let middle = whole.len() / 2;
    damaged[middle] ^= 0x01;
    std::fs::write(&journal, &damaged).unwrap();
    let error = SessionFolder::open(&path, NOW).unwrap_err();
    assert!(matches!(error, FolderError::Damaged { .. }), "{error}");
    let to = desk.path().join("recovered");
    let read = recover(&path, &to, NOW).unwrap();
    assert!(matches!(read.end, JournalEnd::Damaged { .. }));
    assert_eq!(
        std::fs::read(&journal).unwrap(),
        damaged,
        "the original is untouched"
    );
    assert_eq!(
        state_of(&to).readings.len(),
        SessionState::fold(&read.records).readings.len()
    );
    assert!(session(&to, &answers(&ALL), None, &mut MockBench::default()).is_ok());
    assert_eq!(state_of(&to).taken.len(), 6);
}

#[cfg(unix)]
#[test]
fn an_unwritable_folder_is_an_error() {
    let desk = tempfile::tempdir().unwrap();
    // A file where a folder has to be: no user may write there, root included.
    let file = desk.path().join("file");
    std::fs::write(&file, "").unwrap();
    let error = SessionFolder::create(&file.join("s"), "", None, NOW).unwrap_err();
    let FolderError::System { path, .. } = &error else {
        panic!("{error}");
    };
    assert!(path.starts_with(&file));
    let error = SessionFolder::open(desk.path(), NOW).unwrap_err();
    assert!(matches!(
        error,
        FolderError::NoSession {
            file: "session.toml",
            ..
        }
    ));
    assert!(!desk.path().join("session.lock").exists());
}

#[test]
fn a_question_waits_without_limit_unless_the_procedure_gives_it_a_time() {
    let desk = tempfile::tempdir().unwrap();
    let folder = desk.path().join("s");
    let mut procedure = short(false);
    procedure.answer_within_s = vec![("temperature".to_owned(), 20.0), ("setup".to_owned(), 30.0)];
    let mut known = answers(&["ready=true", "humidity=40", "bench-note="]);
    known.no_input = false;
    let (ended, said) = session_of(&procedure, &folder, &known, None, &mut MockBench::default());
    // The temperature may be left blank; a pose may not.
    assert_eq!(ended.unwrap(), SessionEnd::Partial);
    let said = said.join("\n");
    assert!(
        said.contains("no answer to temperature within 20 s: nothing counts"),
        "{said}"
    );
    assert!(said.contains("asked setup"), "{said}");
    let ended = state_of(&folder).ended.unwrap();
    assert_eq!(ended.reason, "no answer to setup within 30 s");
    assert!(state_of(&folder).last_s >= 50.0);
}
