//! How a session begins and ends: the surroundings, by whom it was ended, and what a resumed one does once more.

use crate::support::{MockBench, Rig, records, short};
use stiffbench_session::{
    Answer, Event, Occasion, OperatorEvent, SessionEnd, SessionState, Settings,
};

fn text(text: &str) -> Answer {
    Answer::Text(text.to_owned())
}

#[test]
fn temperature_humidity_and_notes_are_asked_at_the_start_after_a_resume_and_at_the_end() {
    let procedure = short(false);
    let mut rig = Rig::start(&procedure);
    rig.answers = vec![
        ("humidity", Answer::Number(45.0)),
        ("temperature-end", Answer::Number(23.0)),
        ("bench-note-end", text("the fan was on")),
    ];
    rig.until(20_000, |rig| rig.machine.state().taken.len() == 1);
    rig.operator(OperatorEvent::Abort);
    let stopped = rig.journal_bytes();
    let mut rig = Rig::resume(&procedure, &stopped, MockBench::default());
    rig.answers = vec![
        ("humidity", Answer::Number(50.0)),
        ("temperature-end", Answer::Number(23.0)),
        ("bench-note-end", text("the fan was on")),
    ];
    assert_eq!(rig.run(), Some(SessionEnd::Complete));
    let state = rig.machine.state();
    let entered: Vec<_> = state.surroundings.iter().map(ToString::to_string).collect();
    assert_eq!(
        entered,
        [
            "20 degC, 45 % relative humidity at the start",
            "20 degC, 50 % relative humidity at the start",
            "23 degC at the end",
        ]
    );
    assert_eq!(state.surroundings[2].occasion, Some(Occasion::End));
    let notes: Vec<&str> = state
        .notes
        .iter()
        .map(|(_, note)| note.text.as_str())
        .collect();
    assert_eq!(notes, ["bench at the end: the fan was on"]);
}

#[test]
fn stopping_at_the_questions_of_the_end_completes_the_session() {
    let mut rig = Rig::start(&short(false));
    rig.leaves_open = "temperature-end";
    rig.until(40_000, |rig| {
        let prompt = rig.machine.view().prompt;
        prompt.is_some_and(|prompt| prompt.id == "temperature-end")
    });
    rig.operator(OperatorEvent::Interrupt);
    assert_eq!(rig.machine.outcome(), Some(SessionEnd::Complete));
}

#[test]
fn the_end_states_by_whom() {
    let procedure = short(false);
    let ended = |rig: Rig| {
        let all = records(&rig.journal_bytes());
        let Some(Event::Ended(ended)) = all.last().map(|last| last.event.clone()) else {
            panic!("it has not ended");
        };
        (ended.outcome, ended.by.unwrap())
    };
    let mut rig = Rig::start(&procedure);
    rig.run();
    assert_eq!(ended(rig), (SessionEnd::Complete, "program".to_owned()));
    let mut rig = Rig::start(&procedure);
    rig.operator(OperatorEvent::Abort);
    assert_eq!(ended(rig), (SessionEnd::Aborted, "operator".to_owned()));
    let settings = Settings {
        operator: Some("A. Jones".to_owned()),
        ..Settings::default()
    };
    let mut rig = Rig::with_settings(&procedure, settings);
    rig.operator(OperatorEvent::Abort);
    assert_eq!(ended(rig), (SessionEnd::Aborted, "A. Jones".to_owned()));
}

#[test]
fn what_a_resumed_session_repeats_is_stated_when_it_pauses_or_stops() {
    let procedure = short(false);
    let mut rig = Rig::up_to(2);
    rig.until(1000, |rig| rig.machine.view().band.is_some());
    rig.said.clear();
    rig.operator(OperatorEvent::Pause);
    let said = rig.said.join("\n");
    for part in [
        "the gauges settle again for the reading at -20 N, repeat 1",
        "setting up P1 x",
        "the check of zero 1",
        "the loads 0, -10 N, not recorded",
    ] {
        assert!(said.contains(part), "{part}: {said}");
    }
    rig.said.clear();
    rig.operator(OperatorEvent::Interrupt);
    assert!(rig.said.join("\n").contains("session resume repeats"));
    // With everything measured there is nothing to repeat.
    let mut rig = Rig::start(&procedure);
    rig.run();
    assert!(rig.machine.repeated_on_resume().is_empty());
    let state = SessionState::fold(&records(&rig.journal_bytes()));
    assert!(state.ended.is_some());
}
