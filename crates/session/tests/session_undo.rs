//! What an undo takes back: the last decision that still holds, as a fold of the journal sees it.

use crate::support::{Rig, records};
use jiff::Timestamp;
use stiffbench_session::{
    Event, Flagged, OperatorEvent, Record, SessionState, SkipScope, UndoneAction, last_decision,
};

/// The journal with one more event.
fn with(records: &[Record], event: Event) -> Vec<Record> {
    let mut all = records.to_vec();
    let seq = all.len() as u64 + 1;
    all.push(Record {
        seq,
        utc: Timestamp::UNIX_EPOCH,
        t_s: all.last().map_or(0.0, |last| last.t_s),
        event,
    });
    all
}

#[test]
fn a_skip_of_a_cell_is_taken_back_whole_and_then_the_reading_before_it() {
    let mut rig = Rig::up_to(2);
    rig.operator(OperatorEvent::Skip {
        what: SkipScope::Cell,
        reason: Some("a cable in the way".to_owned()),
    });
    assert_eq!(rig.machine.state().skipped.len(), 4);
    let stopped = records(&rig.journal_bytes());
    let state = SessionState::fold(&stopped);
    let undone = last_decision(&stopped, &state).unwrap();
    assert_eq!(undone.events.len(), 4);
    let UndoneAction::Skip { cell, indices, .. } = &undone.action else {
        panic!("{undone:?}");
    };
    assert_eq!((*cell, indices.as_slice()), (0, &[2, 3, 4, 5][..]));
    let stopped = with(&stopped, Event::Undone(undone));
    let state = SessionState::fold(&stopped);
    assert!(state.skipped.is_empty());
    let undone = last_decision(&stopped, &state).unwrap();
    assert_eq!(undone.action, UndoneAction::Reading { number: 2 });
    let state = SessionState::fold(&with(&stopped, Event::Undone(undone)));
    assert_eq!(state.taken.len(), 1);
    assert_eq!(state.readings[1].superseded.as_deref(), Some("undone"));
}

#[test]
fn only_flags_of_the_operator_are_taken_back() {
    let rig = Rig::up_to(1);
    let begun = records(&rig.journal_bytes());
    let flagged = |by_operator| {
        Event::Flagged(Flagged {
            numbers: vec![1],
            flag: "doubtful".to_owned(),
            by_operator,
        })
    };
    let by_program = with(&begun, flagged(false));
    let undone = last_decision(&by_program, &SessionState::fold(&by_program)).unwrap();
    assert_eq!(undone.action, UndoneAction::Reading { number: 1 });
    let by_operator = with(&begun, flagged(true));
    let undone = last_decision(&by_operator, &SessionState::fold(&by_operator)).unwrap();
    assert!(matches!(undone.action, UndoneAction::Flag { .. }));
    let state = SessionState::fold(&with(&by_operator, Event::Undone(undone)));
    assert!(state.readings[0].flags.is_empty() && state.counts(1));
}
