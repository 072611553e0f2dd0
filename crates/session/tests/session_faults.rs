//! Faults of gauges, zeros and operators during a session: no false value stands as an accepted reading without a flag.

use stiffbench_gauges::Channel;
use stiffbench_session::{Input, OperatorEvent, PromptKind, SessionEnd, SessionState, Task};

use super::support::{Rig, records, short};

/// Compliance of the bench along x, m/N, and the preload that its zero is set under, N.
const COMPLIANCE: f64 = 5e-6;
const PRELOAD_N: f64 = -1.0;

/// Fails if a reading that counts and has no flag is off the bench by more than three steps of its last digits.
fn nothing_false(state: &SessionState, what: &str) {
    for kept in state
        .readings
        .iter()
        .filter(|kept| kept.superseded.is_none())
    {
        let taken = &kept.taken;
        let true_m = COMPLIANCE * (taken.force_n - PRELOAD_N);
        let off_m = (taken.displacement_m - true_m).abs();
        assert!(
            off_m <= 3e-6 || !kept.flag().is_empty(),
            "{what}: reading {} is {:.1} um at {:.2} N, true {:.1}",
            taken.number,
            taken.displacement_m * 1e6,
            taken.force_n,
            true_m * 1e6
        );
    }
}

#[test]
fn the_rest_after_zeroing_is_subtracted_and_recorded() {
    let mut rig = Rig::start(&short(false));
    rig.bench.has_zero = [true; Channel::COUNT];
    (rig.bench.leaves_si[0], rig.bench.leaves_si[1]) = (0.8, 4e-6);
    assert_eq!(rig.run(), Some(SessionEnd::Complete));
    let state = rig.machine.state();
    nothing_false(state, "a near zero");
    for kept in &state.readings {
        let raw = kept.taken.force_raw.trim_end_matches(" N").parse::<f64>();
        let raw = raw.expect("the text of the mock");
        let [zero_n, zero_m] = kept.taken.zero_si.expect("recorded");
        assert!((zero_n - 0.8).abs() < 1e-9 && (zero_m - 4e-6).abs() < 1e-9);
        // The force gauge of the bench counts against the axis.
        assert!((kept.taken.force_n + (raw - zero_n)).abs() < 1e-9);
    }
    let again = SessionState::fold(&records(&rig.journal_bytes()));
    assert!(again.table().readings.iter().all(|reading| {
        let text = reading.text.as_ref().expect("texts");
        text.zero_si.iter().all(Option::is_some) && text.flag.is_empty()
    }));
}

#[test]
fn a_display_that_stood_still_on_the_way_gives_no_reading() {
    for channel in Channel::ALL {
        let mut rig = Rig::up_to(2);
        rig.answer(&[("frozen", "skip"), ("implausible", "skip")]);
        rig.until(4000, |rig| rig.bench.force_n < -17.0);
        rig.bench.hold(channel);
        if channel == Channel::Force {
            // Held just inside the band; the jack goes on.
            rig.bench.held_si[0] = Some(19.8);
        }
        rig.wait(200);
        rig.bench.held_si = [None; Channel::COUNT];
        rig.run();
        nothing_false(rig.machine.state(), "held");
    }
}

#[test]
fn readings_since_a_frozen_display_are_flagged() {
    // Put right after the answer, or while the question is open and so withdrawn.
    for left_open in ["", "frozen"] {
        let mut rig = Rig::up_to(1);
        rig.leaves_open = left_open;
        rig.answer(&[("frozen", "again")]);
        rig.bench.hold(Channel::Displacement);
        rig.wait(400);
        rig.bench.held_si = [None; Channel::COUNT];
        rig.run();
        let state = rig.machine.state();
        nothing_false(state, "held since the first reading");
        assert_eq!(
            state.readings[0].flag(),
            "the displacement gauge stood still"
        );
        let withdrawn = rig.said.iter().any(|line| line.contains("withdrawn: "));
        assert_eq!(withdrawn, !left_open.is_empty());
    }
}

#[test]
fn a_self_tare_under_load_records_no_false_reading() {
    for channel in Channel::ALL {
        for readings in [1, 2, 3, 5] {
            let mut rig = Rig::up_to(readings);
            rig.bench.tare(channel);
            rig.bench.by_display = true;
            assert_eq!(rig.run(), Some(SessionEnd::Complete));
            nothing_false(rig.machine.state(), "tared");
        }
    }
}

#[test]
fn after_a_lost_connection_the_zero_is_checked_first() {
    for tared in [false, true] {
        let mut rig = Rig::up_to(2);
        rig.unplug(Channel::Displacement);
        if tared {
            rig.bench.tare(Channel::Displacement);
        }
        rig.plug_in(Channel::Displacement);
        let zeros = rig.machine.state().zeros.values().sum::<u32>();
        assert_eq!(rig.run(), Some(SessionEnd::Complete));
        let state = rig.machine.state();
        nothing_false(state, "lost");
        let flagged = state.readings.iter().filter(|kept| !kept.flag().is_empty());
        assert_eq!(flagged.count(), if tared { 2 } else { 0 });
        // One zero more than the one of the second repeat only if the first was lost.
        let more = state.zeros.values().sum::<u32>() - zeros;
        assert_eq!(more, if tared { 2 } else { 1 });
    }
}

#[test]
fn a_gauge_that_is_lost_or_falls_silent_rings_once() {
    let mut rig = Rig::up_to(2);
    let before = rig.rings;
    rig.bench.now_s += 30.0;
    for _ in 0..3 {
        rig.input(Input::Tick);
    }
    assert_eq!(rig.rings - before, Channel::ALL.len());
    let mut rig = Rig::up_to(2);
    let before = rig.rings;
    rig.unplug(Channel::Force);
    assert_eq!(rig.rings - before, 1);
}

#[test]
fn another_number_of_decimals_holds_the_session_up() {
    let mut rig = Rig::up_to(2);
    rig.bench.decimals = 4;
    rig.wait(300);
    assert_eq!(rig.machine.state().readings.len(), 2);
    let held_up = rig.machine.view().held_up.join("; ");
    assert!(held_up.contains("another number of decimals"), "{held_up}");
    rig.bench.decimals = 3;
    assert_eq!(rig.run(), Some(SessionEnd::Complete));
    nothing_false(rig.machine.state(), "decimals");
}

#[test]
fn readings_with_an_unchecked_zero_are_marked_until_it_is_checked() {
    let mut rig = Rig::up_to(2);
    rig.operator(OperatorEvent::Interrupt);
    rig.run();
    let state = rig.machine.state();
    assert!(
        state
            .readings
            .iter()
            .all(|kept| kept.flag().contains("was not looked at"))
    );
    let bench = rig.bench.clone();
    let mut rig = Rig::resume(&short(false), &rig.journal_bytes(), bench);
    assert_eq!(rig.run(), Some(SessionEnd::Complete));
    assert!(
        rig.machine
            .state()
            .readings
            .iter()
            .all(|kept| kept.flag().is_empty())
    );
}

#[test]
fn a_repeated_load_is_compared_with_its_earlier_reading() {
    let rig = Rig::up_to(2);
    let mut bench = rig.bench.clone();
    bench.sensitivity = 0.5;
    bench.force_n = 0.0;
    let mut rig = Rig::resume(&short(false), &rig.journal_bytes(), bench);
    // The zero of such a gauge is right under the preload.
    rig.bench.tare(Channel::Displacement);
    rig.answer(&[("changed", "flag"), ("implausible", "skip")]);
    rig.run();
    nothing_false(rig.machine.state(), "half as sensitive");
}

#[test]
fn coarse_steps_behind_fine_decimals_are_asked_about() {
    let mut procedure = short(false);
    procedure.loads_n = (0..12).map(|n| -6.5 * f64::from(n)).collect();
    let mut rig = Rig::start(&procedure);
    rig.bench.step_m = 10e-6;
    rig.answer(&[("displacement-steps", "skip"), ("implausible", "skip")]);
    rig.run();
    assert!(rig.was_asked("displacement-steps"));
    nothing_false(rig.machine.state(), "coarse");
}

#[test]
fn a_question_goes_when_its_cause_is_gone() {
    let mut rig = Rig::up_to(1);
    rig.until(4000, |rig| {
        matches!(rig.machine.view().task, Task::Load { target_n, .. } if target_n == -10.0)
            && rig.bench.force_n < -5.0
    });
    let actions = rig
        .machine
        .input(Input::Operator(OperatorEvent::Capture), rig.bench.now_s);
    assert!(!actions.is_empty());
    let prompt = rig.machine.view().prompt.expect("it is asked");
    assert_eq!(prompt.id, "not-settled");
    assert!(matches!(prompt.kind, PromptKind::Choice(_)));
    rig.until(200, |rig| rig.machine.state().readings.len() == 2);
    assert!(rig.machine.state().readings[1].taken.flag.is_empty());
    assert!(rig.said.iter().any(|line| line.starts_with("withdrawn")));
}
