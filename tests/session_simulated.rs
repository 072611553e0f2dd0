//! Whole sessions in simulated time: all shipped procedures, everything an operator may do, faults, and a crash at any moment.

#![expect(
    clippy::unwrap_used,
    reason = "a test stops at what is not as it must be"
)]

#[path = "support/session_bench.rs"]
mod session_bench;

use session_bench::{Rig, csv_without_times, plan, records, shipped, short};
use stiffbench::procedure::shipped_procedures;
use stiffbench::session::{Outcome, SessionState};

#[test]
fn all_shipped_procedures_run_to_their_end() {
    for name in shipped_procedures() {
        let mut procedure = shipped(name);
        if name != "paper" {
            procedure.directions.truncate(2);
            procedure.repeats = 2;
        }
        let planned = plan(&procedure).len();
        let mut rig = Rig::start(&procedure);
        assert_eq!(rig.run(), Some(Outcome::Complete), "{name}");
        let state = rig.machine.state().clone();
        assert_eq!(state.readings.len(), planned, "{name}");
        assert!(state.readings.iter().all(|kept| {
            (kept.taken.force_n - kept.taken.target_n).abs() <= 0.5 && kept.superseded.is_none()
        }));
        let kinds: Vec<&str> = rig.asked.iter().map(|prompt| prompt.id.as_str()).collect();
        let usual = ["ready", "temperature", "setup", "sign-check"];
        assert!(
            kinds.iter().all(|id| usual.contains(id)),
            "{name}: {kinds:?}"
        );
        let bytes = rig.journal_bytes();
        assert_eq!(SessionState::fold(&records(&bytes)), state, "{name}");
    }
}

#[test]
fn cut_at_every_byte_and_resumed_nothing_is_lost_or_doubled() {
    let procedure = short(false);
    let mut whole = Rig::start(&procedure);
    assert_eq!(whole.run(), Some(Outcome::Complete));
    let expected = csv_without_times(whole.machine.state());
    let snapshots = std::mem::take(&mut whole.snapshots);
    let bytes = whole.journal_bytes();
    for cut in 0..bytes.len() {
        let read = stiffbench::session::read_journal(&bytes[..cut]);
        let acknowledged = SessionState::fold(&read.records).readings;
        let n = read.records.len();
        if n == 0 {
            assert!(acknowledged.is_empty());
            continue;
        }
        let mut rig = Rig::resume(&procedure, &bytes[..cut], snapshots[n - 1].clone());
        assert_eq!(rig.run(), Some(Outcome::Complete), "cut at {cut}");
        let state = rig.machine.state();
        assert_eq!(
            state.readings[..acknowledged.len()],
            acknowledged,
            "cut at {cut}"
        );
        assert_eq!(csv_without_times(state), expected, "cut at {cut}");
    }
}
