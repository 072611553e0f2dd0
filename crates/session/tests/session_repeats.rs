//! A cell that is complete is compared with its repeats: what they contradict is taken once more, or kept with a flag, as the operator decides.

use crate::support::{Rig, records, short};
use stiffbench_measurement::procedure::Procedure;
use stiffbench_session::{Answer, KeptReading, Prompt, SessionEnd, SessionState};

/// One cell, three repeats.
fn procedure() -> Procedure {
    let mut procedure = short(false);
    procedure.repeats = 3;
    procedure
}

/// The number of the last reading of the second repeat of the cell.
fn in_the_second_repeat() -> u32 {
    let plan = crate::support::plan(&procedure());
    let readings = &plan.cells[0].readings;
    let before = readings.iter().filter(|reading| reading.repeat <= 2);
    before.count() as u32
}

fn run(answer: &str, spike_m: f64) -> (SessionState, Vec<Prompt>) {
    let mut rig = Rig::start(&procedure());
    rig.spike = Some((in_the_second_repeat(), spike_m));
    // The next run is compared with the spiked one while it is measured.
    rig.answer(&[("bad-reading", answer), ("implausible", "accept")]);
    assert_eq!(rig.run(), Some(SessionEnd::Complete));
    let state = rig.machine.state().clone();
    let asked = std::mem::take(&mut rig.asked).into_iter();
    let asked = asked.filter(|prompt| prompt.id == "bad-reading").collect();
    assert_eq!(SessionState::fold(&records(&rig.journal_bytes())), state);
    (state, asked)
}

fn of_run(state: &SessionState, superseded: bool) -> Vec<&KeptReading> {
    let all = state.readings.iter();
    all.filter(|kept| (kept.taken.cell, kept.taken.repeat) == (0, 2))
        .filter(|kept| kept.superseded.is_some() == superseded)
        .collect()
}

#[test]
fn the_run_of_a_contradicted_reading_is_taken_once_more_and_the_first_one_stays() {
    let (state, asked) = run("redo", 60e-6);
    let [prompt] = &asked[..] else {
        panic!("{asked:?}");
    };
    assert!(prompt.text.contains("Repeat 2 of P1 x"), "{}", prompt.text);
    assert_eq!(prompt.default, Some(Answer::Text("keep".to_owned())));
    let (old, new) = (of_run(&state, true), of_run(&state, false));
    let steps =
        |kept: &[&KeptReading]| -> Vec<u32> { kept.iter().map(|kept| kept.taken.step).collect() };
    assert_eq!(steps(&old), steps(&new));
    assert!(old.len() > 1);
    let spiked = in_the_second_repeat();
    assert!(old.iter().any(|kept| kept.taken.number == spiked));
    assert!(new.iter().all(|kept| kept.taken.attempt == 2));
    // Every other run was taken once.
    assert_eq!(
        state.readings.len(),
        crate::support::plan(&procedure()).len() + new.len()
    );
}

#[test]
fn a_contradicted_reading_that_is_kept_bears_a_flag_and_is_asked_about_once() {
    let (state, asked) = run("keep", -60e-6);
    assert_eq!(asked.len(), 1);
    assert_eq!(of_run(&state, true), Vec::<&KeptReading>::new());
    for kept in &state.readings {
        let flagged = kept.flag().contains("its repeats contradict it");
        assert_eq!(flagged, kept.taken.repeat == 2);
    }
}

#[test]
fn readings_that_agree_ask_nothing() {
    let (state, asked) = run("redo", 2e-6);
    assert_eq!((asked.len(), of_run(&state, true).len()), (0, 0));
}
