//! The program killed at any moment of a session, and gone on with: no reading that it had confirmed is lost, none is there twice.
//!
//! `STIFFBENCH_KILLS` states how often it is killed; the default is short enough for every test run.

#![cfg(unix)]
use std::collections::BTreeMap;
use std::fs::{self, File};
use std::path::Path;
use std::process::{Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stiffbench::session::{JournalEnd, SessionState, read_folder};

/// Two poses of little work each; sweeps, so that going on means applying loads again.
const PLAN: &str =
    "--procedure sweeps --poses P1,P2 --directions x --loads-n 0,-20,-40 --repeats 3";

/// An emulated bench without an operator.
const BENCH: &str = "--emulated --speed 20 --no-input --answer implausible=accept --answer frozen=accept --answer drift=keep";

/// Longest that one go may take, s.
const PATIENCE: Duration = Duration::from_secs(120);

/// Starts the program on a session, new or begun, and kills it after so long; whether it came to its end before.
fn go(desk: &Path, log: &Path, kill_after: Option<Duration>) -> bool {
    let arguments = if desk.join("s/session.toml").exists() {
        format!("session resume s {BENCH}")
    } else {
        // Killed while the folder was being made: there is nothing to go on with.
        let _ = fs::remove_dir_all(desk.join("s"));
        format!("session run s {PLAN} {BENCH}")
    };
    let mut child = Command::new(env!("CARGO_BIN_EXE_stiffbench"))
        .current_dir(desk)
        .args(arguments.split_whitespace())
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(File::create(log).unwrap())
        .spawn()
        .unwrap();
    let began = Instant::now();
    loop {
        if let Some(status) = child.try_wait().unwrap() {
            assert!(status.success(), "{}", fs::read_to_string(log).unwrap());
            return true;
        }
        if kill_after.is_some_and(|after| began.elapsed() >= after) {
            child.kill().unwrap();
            child.wait().unwrap();
            return false;
        }
        assert!(
            began.elapsed() < PATIENCE,
            "{}",
            fs::read_to_string(log).unwrap()
        );
        sleep(Duration::from_millis(2));
    }
}

/// The readings that were confirmed on the screen: number, and the line.
fn confirmed(log: &Path) -> BTreeMap<u32, String> {
    let text = fs::read_to_string(log).unwrap();
    let whole = text.rfind('\n').map_or("", |end| &text[..end]);
    let lines = whole.lines().filter_map(|line| {
        let (number, values) = line.strip_prefix("reading ")?.split_once(": ")?;
        Some((number.parse().ok()?, values.to_owned()))
    });
    lines.collect()
}

/// Sessions at a time where many kills are wanted: they wait most of their time.
const AT_A_TIME: u32 = 12;

#[test]
fn what_was_confirmed_before_a_kill_is_there_once() {
    let kills: u32 = std::env::var("STIFFBENCH_KILLS").map_or(6, |n| n.parse().unwrap());
    let threads = AT_A_TIME.min(kills.div_ceil(6));
    std::thread::scope(|scope| {
        for thread in 0..threads {
            let share = kills / threads + u32::from(thread < kills % threads);
            scope.spawn(move || kill_and_resume(share, u64::from(thread)));
        }
    });
}

/// The same session without a kill.
fn uninterrupted() -> SessionState {
    let desk = tempfile::tempdir().unwrap();
    assert!(go(desk.path(), &desk.path().join("log"), None));
    let read = read_folder(&desk.path().join("s")).unwrap();
    SessionState::fold(&read.journal.records)
}

/// The readings that count are those of the session without a kill: the bench shows the same at rest, and a zero and a reading may each lie
/// anywhere in the two micrometres that count as settled.
fn assert_same(state: &SessionState, whole: &SessionState) {
    for (planned, place) in &state.taken {
        let (taken, other) = (
            &state.readings[*place].taken,
            &whole.readings[whole.taken[planned]].taken,
        );
        let apart_m = (taken.displacement_m - other.displacement_m).abs();
        let apart_n = (taken.force_n - other.force_n).abs();
        assert!(
            apart_m <= 4.1e-6 && apart_n <= 0.21,
            "{taken:?} is not {other:?}"
        );
    }
}

/// Kills sessions so many times and goes on with each, to the end of the last.
fn kill_and_resume(kills: u32, seed: u64) {
    let whole = uninterrupted();
    let mut rng = ChaCha8Rng::seed_from_u64(20_261_120 + seed);
    let mut killed = 0;
    while killed < kills {
        let desk = tempfile::tempdir().unwrap();
        let log = desk.path().join("log");
        let mut seen: BTreeMap<u32, String> = BTreeMap::new();
        loop {
            let after = (killed < kills).then(|| Duration::from_millis(rng.random_range(20..6000)));
            let ended = go(desk.path(), &log, after);
            killed += u32::from(!ended);
            for (number, values) in confirmed(&log) {
                let before = seen.insert(number, values.clone());
                assert!(before.is_none(), "reading {number} was taken twice");
            }
            if ended {
                break;
            }
        }
        let read = read_folder(&desk.path().join("s")).unwrap();
        assert_eq!(read.journal.end, JournalEnd::Clean);
        let state = SessionState::fold(&read.journal.records);
        let counting = state
            .readings
            .iter()
            .filter(|kept| kept.superseded.is_none());
        assert_eq!((counting.count(), state.taken.len()), (18, 18));
        for (number, values) in &seen {
            let taken = &state.readings[*number as usize - 1].taken;
            let kept = format!(
                "{:.2} N, {:.1} um",
                taken.force_n,
                taken.displacement_m * 1e6
            );
            assert_eq!(
                (taken.number, &kept),
                (*number, values),
                "confirmed and lost"
            );
        }
        assert_same(&state, &whole);
        let mut rows = Vec::new();
        stiffbench::session::table(&state, &mut rows).unwrap();
        let live = fs::read(desk.path().join("s/readings.csv")).unwrap();
        assert!(live == rows, "readings.csv is that of the journal");
    }
}
