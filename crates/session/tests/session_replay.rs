//! A replay passes recorded values to the machine of a live session, and gives the readings that were taken.

use std::cell::RefCell;

use crate::support::{Rig, plan, records, short};
use stiffbench_gauges::GaugeEvent;
use stiffbench_session::{
    Journal, Machine, OperatorEvent, RecordedSession, SessionEnd, SessionState, Settings,
    replay_session,
};

#[test]
fn the_values_of_a_session_give_its_readings_notes_and_repeats_again() {
    let procedure = short(false);
    let mut rig = Rig::start(&procedure);
    // What the gauges sent, as traces keep it.
    rig.until(20_000, |rig| rig.machine.state().taken.len() == 2);
    let text = Some("the lamp was switched on".to_owned());
    rig.operator(OperatorEvent::Note { text });
    rig.operator(OperatorEvent::Redo);
    assert_eq!(rig.run(), Some(SessionEnd::Complete));
    let events: Vec<(f64, GaugeEvent)> = std::mem::take(&mut rig.sent);
    let recorded = records(&rig.journal_bytes());
    let before = SessionState::fold(&recorded);
    // With the shorter dwell that lets a replay keep up with a loaded computer, the same.
    for behind_s in [0.0, 0.1] {
        let mut replayed = plan(&procedure);
        replayed.procedure.settle.dwell_s -= behind_s;
        let machine = |state| Machine::new(replayed.clone(), Settings::default(), state);
        let mut journal = Journal::behind(Vec::new(), 0);
        let seen = RefCell::new(0);
        let mut watch = |at_s: f64, kept: Option<&stiffbench_session::Record>| {
            assert!(at_s.is_finite());
            *seen.borrow_mut() += usize::from(kept.is_some());
        };
        let recording = RecordedSession {
            records: &recorded,
            events: events.clone(),
            lag_s: behind_s,
        };
        let after = replay_session(&machine, recording, &mut journal, &mut watch).unwrap();
        let bytes = journal.into_store();
        assert_eq!(SessionState::fold(&records(&bytes)), after);
        assert_eq!(records(&bytes).len(), seen.into_inner());
        let ended = after.ended.as_ref().unwrap();
        assert_eq!(ended.outcome, SessionEnd::Complete, "{}", ended.reason);
        assert_eq!(
            after.taken.keys().collect::<Vec<_>>(),
            before.taken.keys().collect::<Vec<_>>()
        );
        assert_eq!(after.notes[0].1.text, "the lamp was switched on");
        for (at, place) in &before.taken {
            let (first, again) = (&before.readings[*place], &after.readings[after.taken[at]]);
            let moved_m = (first.taken.displacement_m - again.taken.displacement_m).abs();
            assert!(moved_m < 5e-6, "{at:?}: {first:?} {again:?}");
        }
    }
}
