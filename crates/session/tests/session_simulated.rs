//! Whole sessions in simulated time: all shipped procedures, everything an operator may do, faults, and a crash at any moment.

use crate::support::{
    Fault, MockBench, Rig, assert_cuts_lose_nothing, assert_held_up, csv_without_times, plan,
    records, shipped, short,
};
use proptest::prelude::*;
use stiffbench_gauges::Channel;
use stiffbench_measurement::readings::{RepeatOrder, ZeroScope};
use stiffbench_session::{
    Event, Input, Journal, KeptReading, Machine, Noted, OperatorEvent, Purpose, SessionEnd,
    SessionPlan, SessionState, Settings, SkipScope, Task, read_journal, write_line,
};
use stiffbench_test_files::shipped_procedures;
use stiffbench_units_and_text::test_point::Direction;

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
        assert_eq!(rig.run(), Some(SessionEnd::Complete), "{name}");
        let state = rig.machine.state().clone();
        assert_eq!(state.readings.len(), planned, "{name}");
        assert!(state.readings.iter().all(|kept| {
            (kept.taken.force_n - kept.taken.target_n).abs() <= 0.5 && kept.superseded.is_none()
        }));
        let kinds: Vec<&str> = rig.asked.iter().map(|prompt| prompt.id.as_str()).collect();
        let usual = [
            "ready",
            "temperature",
            "humidity",
            "bench-note",
            "setup",
            "sign-check",
            "temperature-end",
            "humidity-end",
            "bench-note-end",
        ];
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
    assert_cuts_lose_nothing(&short(false), 1);
}

/// What may happen at a tick of a session.
#[derive(Debug, Clone, Copy)]
enum ScriptedAction {
    Crash,
    Redo,
    SkipReading,
    SkipCell,
    Note,
    PauseAndGoOn,
    Goto(usize),
    Capture,
    Rejected,
    Lost,
    Unplugged,
    Gap,
    Drift,
    PressHard,
}

fn actions() -> impl Strategy<Value = Vec<(u16, ScriptedAction)>> {
    let action = prop_oneof![
        3 => Just(ScriptedAction::Crash),
        2 => Just(ScriptedAction::Redo),
        1 => Just(ScriptedAction::SkipReading),
        1 => Just(ScriptedAction::SkipCell),
        1 => Just(ScriptedAction::Note),
        1 => Just(ScriptedAction::PauseAndGoOn),
        1 => (0..3_usize).prop_map(ScriptedAction::Goto),
        2 => Just(ScriptedAction::Capture),
        1 => Just(ScriptedAction::Rejected),
        1 => Just(ScriptedAction::Lost),
        1 => Just(ScriptedAction::Unplugged),
        1 => Just(ScriptedAction::Gap),
        1 => Just(ScriptedAction::Drift),
        1 => Just(ScriptedAction::PressHard),
    ];
    prop::collection::vec((0..120_u16, action), 0..12)
}

fn happen(rig: &mut Rig, action: ScriptedAction) {
    match action {
        ScriptedAction::Crash => {}
        ScriptedAction::Redo => rig.operator(OperatorEvent::Redo),
        ScriptedAction::SkipReading | ScriptedAction::SkipCell => {
            let what = match action {
                ScriptedAction::SkipCell => SkipScope::Cell,
                _ => SkipScope::Reading,
            };
            let reason = None;
            rig.operator(OperatorEvent::Skip { what, reason });
        }
        ScriptedAction::Note => rig.operator(OperatorEvent::Note { text: None }),
        ScriptedAction::PauseAndGoOn => {
            rig.operator(OperatorEvent::Pause);
            rig.operator(OperatorEvent::Pause);
        }
        ScriptedAction::Goto(cell) => rig.operator(OperatorEvent::Goto { cell }),
        ScriptedAction::Capture => rig.operator(OperatorEvent::Capture),
        ScriptedAction::Rejected => rig.reject(Channel::Displacement, "ERR1"),
        ScriptedAction::Lost => rig.unplug(Channel::Force),
        ScriptedAction::Unplugged => {
            rig.unplug(Channel::Force);
            rig.plug_in(Channel::Force);
        }
        ScriptedAction::Gap => rig.input(Input::Gap),
        ScriptedAction::Drift => rig.bench.drift_m += 15e-6,
        ScriptedAction::PressHard => rig.bench.force_n -= 30.0,
    }
}

/// Every reading that counts is one of the plan, taken at its target, once.
fn check(state: &SessionState, plan: &SessionPlan) {
    let mut counted = 0;
    for kept in state
        .readings
        .iter()
        .filter(|kept| kept.superseded.is_none())
    {
        let taken = &kept.taken;
        let planned = &plan.cells[taken.cell].readings[taken.index];
        assert_eq!(taken.target_n, planned.target_n);
        assert!((taken.force_n - taken.target_n).abs() <= 0.5 || !taken.flag.is_empty());
        assert_eq!(
            state.taken[&(taken.cell, taken.index)],
            counted_place(state, kept)
        );
        counted += 1;
    }
    assert_eq!(counted, state.taken.len());
    let numbers: Vec<u32> = state
        .readings
        .iter()
        .map(|kept| kept.taken.number)
        .collect();
    assert_eq!(numbers, (1..=numbers.len() as u32).collect::<Vec<_>>());
    assert!(state.taken.keys().all(|at| !state.skipped.contains_key(at)));
}

fn counted_place(state: &SessionState, kept: &KeptReading) -> usize {
    state
        .readings
        .iter()
        .position(|other| other == kept)
        .unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 150, ..ProptestConfig::default() })]

    #[test]
    fn whatever_happens_the_live_state_is_the_fold_of_the_journal(
        happenings in actions(),
        unloading in any::<bool>(),
        at_load in any::<bool>(),
        by_gauge in any::<bool>(),
    ) {
        let mut procedure = short(unloading && !at_load);
        procedure.directions.push(Direction::Z.into());
        if at_load {
            procedure.repeat_order = RepeatOrder::AtLoad;
            procedure.zero = ZeroScope::Cell;
        }
        let plan = plan(&procedure);
        let mut rig = Rig::start(&procedure);
        rig.bench.has_zero[1] = by_gauge;
        let mut superseded_before = 0;
        for (ticks, action) in happenings {
            rig.wait(ticks.into());
            happen(&mut rig, action);
            let live = rig.machine.state().clone();
            let bench = rig.bench.clone();
            let bytes = rig.journal_bytes();
            prop_assert_eq!(&SessionState::fold(&records(&bytes)), &live);
            check(&live, &plan);
            // Nothing that was kept is ever taken away.
            prop_assert!(live.readings.len() >= superseded_before);
            superseded_before = live.readings.len();
            rig = Rig::resume(&procedure, &bytes, bench);
        }
        prop_assert_eq!(rig.run(), Some(SessionEnd::Complete));
        let state = rig.machine.state();
        check(state, &plan);
        prop_assert_eq!(state.taken.len() + state.skipped.len(), plan.len());
    }
}

#[test]
fn what_happens_without_a_crash_leaves_a_whole_plan() {
    for action in [
        ScriptedAction::Redo,
        ScriptedAction::SkipReading,
        ScriptedAction::SkipCell,
        ScriptedAction::Note,
        ScriptedAction::PauseAndGoOn,
        ScriptedAction::Goto(1),
        ScriptedAction::Capture,
        ScriptedAction::Rejected,
        ScriptedAction::Unplugged,
        ScriptedAction::Gap,
        ScriptedAction::Drift,
        ScriptedAction::PressHard,
    ] {
        for ticks in (5..260).step_by(12) {
            let mut procedure = short(true);
            procedure.directions.push(Direction::Z.into());
            let plan = plan(&procedure);
            let mut rig = Rig::start(&procedure);
            rig.wait(ticks);
            happen(&mut rig, action);
            assert_eq!(
                rig.run(),
                Some(SessionEnd::Complete),
                "{action:?} at {ticks}"
            );
            let state = rig.machine.state();
            check(state, &plan);
            assert_eq!(state.taken.len() + state.skipped.len(), plan.len());
        }
    }
}

#[test]
fn a_redone_reading_stays_and_another_takes_its_place() {
    let mut rig = Rig::up_to(2);
    rig.operator(OperatorEvent::Redo);
    assert_eq!(rig.run(), Some(SessionEnd::Complete));
    let state = rig.machine.state();
    assert_eq!(state.readings.len(), 7);
    assert_eq!(
        state.readings[1].superseded.as_deref(),
        Some("taken once more")
    );
    let again = &state.readings[2].taken;
    assert_eq!((again.index, again.attempt, again.number), (1, 2, 3));
    let csv = csv_without_times(state);
    assert_eq!(
        csv.matches("superseded").count(),
        2,
        "status and flag of one row:\n{csv}"
    );
}

#[test]
fn an_earlier_step_is_reached_again_through_the_loads_before_it() {
    let procedure = short(false);
    let rig = Rig::up_to(3);
    let bench = rig.bench.clone();
    let bytes = rig.journal_bytes();
    let all = records(&bytes);
    // Cut before the second reading: the way to its load leads over the first.
    let second = all
        .iter()
        .position(|r| matches!(&r.event, Event::Reading(t) if t.number == 2));
    let kept: Vec<u8> = all[..second.unwrap()]
        .iter()
        .flat_map(|r| write_line(r).unwrap())
        .collect();
    let mut rig = Rig::resume(&procedure, &kept, bench);
    assert_eq!(rig.run(), Some(SessionEnd::Complete));
    assert!(
        rig.said
            .iter()
            .any(|line| line.contains("apply 0 N again; it is not recorded"))
    );
    assert_eq!(rig.machine.state().readings.len(), 6);
}

#[test]
fn a_gauge_that_counts_the_other_way_is_noticed_wherever_it_was_turned() {
    let procedure = short(false);
    let mut rig = Rig::start(&procedure);
    rig.answer(&[("displacement-sign", "flip")]);
    rig.until(2000, |rig| rig.machine.state().zero.is_some());
    // Turned at the panel after the sign check.
    rig.bench.signs[1] = -1.0;
    assert_eq!(rig.run(), Some(SessionEnd::Complete));
    assert!(rig.was_asked("displacement-sign"));
    let state = rig.machine.state();
    assert!(
        state
            .readings
            .iter()
            .all(|kept| { kept.taken.force_n * kept.taken.displacement_m >= 0.0 })
    );
    // The force gauge turned instead: the wanted force never comes.
    let mut rig = Rig::start(&procedure);
    rig.answer(&[("force-sign", "flip")]);
    rig.until(2000, |rig| rig.machine.state().zero.is_some());
    rig.bench.signs[0] = 1.0;
    rig.until(4000, |rig| rig.was_asked("force-sign"));
    assert_eq!(rig.run(), Some(SessionEnd::Complete));
}

#[test]
fn faults_of_a_gauge_give_no_reading() {
    let [force, displacement] = [Channel::Force, Channel::Displacement].map(Fault::Silent);
    for (fault, said) in [
        (displacement, "nothing comes from the displacement gauge"),
        (force, "nothing comes from the force gauge"),
        (Fault::Unit, "sends in and was in mm"),
    ] {
        let rig = assert_held_up(Rig::up_to(2), fault, said);
        assert_eq!(rig.machine.state().readings.len(), 6);
    }
}

#[test]
fn a_frozen_displacement_is_asked_about() {
    let mut rig = Rig::up_to(1);
    rig.answer(&[
        ("frozen", "accept"),
        ("implausible", "accept"),
        ("displacement-sign", "accept"),
    ]);
    rig.bench.fault = Some(Fault::Frozen);
    rig.until(4000, |rig| rig.machine.state().readings.len() == 3);
    let third = &rig.machine.state().readings[2].taken;
    assert!(
        third.flag.contains("frozen: accepted by the operator"),
        "{}",
        third.flag
    );
}

#[test]
fn a_zero_that_is_not_displayed_is_confirmed_or_repeated() {
    let procedure = short(false);
    let mut whole = Rig::start(&procedure);
    whole.run();
    let mut rig = Rig::start(&procedure);
    rig.until(2000, |rig| {
        rig.machine.state().signs[..2].iter().all(Option::is_some)
    });
    rig.bench.fault = Some(Fault::Frozen);
    rig.until(4000, |rig| rig.was_asked("zero-not-shown"));
    assert!(
        rig.machine.state().zero.is_none(),
        "a zero was set at a display that stands still"
    );
    rig.bench.fault = None;
    assert_eq!(rig.run(), Some(SessionEnd::Complete));
    let displacements = |rig: &Rig| {
        let kept = rig.machine.state().readings.iter();
        kept.map(|kept| kept.taken.displacement_m)
            .collect::<Vec<_>>()
    };
    assert_eq!(displacements(&rig), displacements(&whole));
}

#[test]
fn a_disk_that_is_full_confirms_nothing_it_has_not_kept() {
    let procedure = short(false);
    let mut whole = Rig::start(&procedure);
    whole.run();
    let expected = csv_without_times(whole.machine.state());
    let length = whole.journal_bytes().len();
    for room in (0..length).step_by(37) {
        let mut rig = Rig::start(&short(false));
        let mut bytes_so_far = rig.journal.into_store();
        bytes_so_far.room = room.max(bytes_so_far.bytes.len());
        let bytes = bytes_so_far.bytes.clone();
        rig = Rig::resume(&procedure, &bytes, MockBench::default());
        rig.journal = Journal::behind(bytes_so_far, 1);
        rig.machine = Machine::new(
            plan(&procedure),
            Settings::default(),
            SessionState::fold(&records(&bytes)),
        );
        rig.run();
        assert!(rig.failed || room >= length);
        let live = rig.machine.state().clone();
        let bench = rig.bench.clone();
        assert!(
            !rig.record(Event::Note(Noted {
                cell: None,
                text: String::new()
            })),
            "closed after a failure"
        );
        let left = rig.journal_bytes();
        let read = read_journal(&left);
        assert_eq!(SessionState::fold(&read.records), live);
        let mut rig = Rig::resume(&procedure, &left, bench);
        rig.run();
        assert_eq!(rig.machine.state().readings.len(), 6);
        if live.zero.is_some() {
            assert_eq!(
                csv_without_times(rig.machine.state()),
                expected,
                "room {room}"
            );
        }
    }
}

#[test]
fn an_interrupt_ends_at_a_safe_point_and_a_second_at_once() {
    let procedure = short(false);
    let mut rig = Rig::start(&procedure);
    rig.until(3000, |rig| {
        rig.machine.view().settle.is_some_and(|s| s.dwell_s > 0.05)
            && matches!(
                rig.machine.view().task,
                Task::Load {
                    purpose: Purpose::Reading,
                    ..
                }
            )
    });
    rig.operator(OperatorEvent::Interrupt);
    assert_eq!(rig.machine.outcome(), None);
    let before = rig.machine.state().readings.len();
    assert_eq!(rig.run(), Some(SessionEnd::Partial));
    assert_eq!(rig.machine.state().readings.len(), before + 1);
    let mut rig = Rig::start(&procedure);
    rig.tick();
    rig.operator(OperatorEvent::Abort);
    assert_eq!(rig.machine.outcome(), Some(SessionEnd::Aborted));
    assert_eq!(
        rig.machine.state().ended.as_ref().unwrap().outcome,
        SessionEnd::Aborted
    );
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, ..ProptestConfig::default() })]

    /// The checksum keeps changed bytes out; here they get one, as from a program that writes nonsense.
    #[test]
    fn nonsense_with_a_right_checksum_is_refused_or_gives_a_state(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..4),
        line in any::<prop::sample::Index>(),
    ) {
        static JOURNAL: std::sync::LazyLock<Vec<u8>> = std::sync::LazyLock::new(|| {
            let mut rig = Rig::start(&short(true));
            rig.run();
            rig.journal_bytes()
        });
        let mut lines: Vec<Vec<u8>> = JOURNAL.split(|byte| *byte == b'\n').map(<[u8]>::to_vec).collect();
        lines.pop();
        let chosen = line.index(lines.len());
        let body_length = lines[chosen].len() - 18;
        let body = &mut lines[chosen][..body_length];
        for (place, byte) in changes {
            body[place.index(body_length)] = byte.max(0x20);
        }
        let seal = format!(",\"crc\":\"{:08x}\"}}", crc32c::crc32c(body));
        lines[chosen][body_length..].copy_from_slice(seal.as_bytes());
        let bytes: Vec<u8> = lines.iter().flat_map(|line| [&line[..], b"\n"].concat()).collect();
        let read = read_journal(&bytes);
        prop_assert!(read.records.len() >= chosen);
        let state = SessionState::fold(&read.records);
        csv_without_times(&state);
        let mut machine = Machine::new(plan(&short(true)), Settings::default(), state);
        machine.input(Input::Tick, 0.0);
        prop_assert_eq!(machine.view().progress.planned, plan(&short(true)).len());
        for record in &read.records {
            prop_assert!(write_line(record).is_ok());
        }
    }
}
