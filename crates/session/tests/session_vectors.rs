//! Sessions with displacement gauges along the base axes: what they keep, a crash at any moment, mishaps of one gauge of three.

use crate::support::{
    Fault, Rig, assert_cuts_lose_nothing, assert_held_up, compliance, records, short,
};
use proptest::prelude::*;
use stiffbench_gauges::Channel;
use stiffbench_measurement::procedure::Procedure;
use stiffbench_measurement::readings::read_readings;
use stiffbench_session::{Event, SessionEnd, SessionState, Task, integrity, read_journal, table};
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::Direction;

/// Loads against x and along an oblique direction, read along x, y and z.
fn of_vectors() -> Procedure {
    let oblique = LoadDirection::from_vector([0.0, 0.6, 0.8]).expect("a unit vector");
    Procedure {
        directions: vec![
            "-x".parse().expect("a direction"),
            oblique.named("diagonal"),
        ],
        displacement_axes: Direction::ALL.to_vec(),
        ..short(false)
    }
}

/// Checks every reading that counts against the compliance of the end.
fn assert_true_readings(state: &SessionState) {
    for kept in state
        .readings
        .iter()
        .filter(|kept| kept.superseded.is_none())
    {
        let taken = &kept.taken;
        let per_n = compliance(&taken.direction);
        for axis in Direction::ALL {
            // Counted from the zero under the preload of -1 N.
            let expected_m = per_n[axis.index()] * (taken.force_n + 1.0);
            let read_m = taken
                .displacement_of(Channel::along(axis))
                .expect("it was read");
            // The digits of both gauges, of reading and zero.
            let digits_m = 1.1e-6 + per_n[axis.index()].abs() * 0.1;
            assert!(
                (read_m - expected_m).abs() <= digits_m,
                "{} {axis}: {read_m} for {expected_m}",
                taken.direction
            );
        }
    }
}

#[test]
fn each_gauge_is_kept_with_its_bytes_whichever_way_it_counts() {
    let mut rig = Rig::start(&of_vectors());
    rig.bench.signs[Channel::DisplacementZ.index()] = -1.0;
    assert_eq!(rig.run(), Some(SessionEnd::Complete));
    let state = rig.machine.state().clone();
    assert_eq!(state.readings.len(), 2 * 2 * 3);
    assert_true_readings(&state);
    // A push toward -x against a load along -x: the axis counts, not the load.
    assert_eq!(
        state.signs,
        [Some(-1.0), None, Some(1.0), Some(1.0), Some(-1.0)]
    );
    // x with the force gauge, y and z by a push of their own.
    let pushes = rig.asked.iter().filter(|prompt| prompt.id == "sign-check");
    let keys: Vec<&str> = pushes.filter_map(|prompt| prompt.key.as_deref()).collect();
    assert_eq!(keys, ["P1.-x", "P1.y", "P1.z"]);
    let taken = &state.readings[2].taken;
    assert_eq!(taken.gauges.len(), 3);
    for gauge in &taken.gauges {
        let shown_mm: f64 = gauge
            .raw
            .trim_end_matches(" mm")
            .parse()
            .expect("its own text");
        let sign = state.signs[gauge.channel.index()].expect("it is known");
        let by_hand = sign * (shown_mm * 1e-3 - gauge.zero_m);
        assert!((by_hand - gauge.displacement_m).abs() < 1e-9, "{gauge:?}");
    }
    let bytes = rig.journal_bytes();
    assert_eq!(SessionState::fold(&records(&bytes)), state);
}

#[test]
fn a_hand_that_pushes_before_the_rest_was_seen_shows_no_wrong_sign() {
    let mut rig = Rig::start(&of_vectors());
    rig.bench.signs[Channel::DisplacementZ.index()] = -1.0;
    // Longer than the rest that is observed: what comes back as the hand lets go is no push.
    rig.bench.eager_s = 2.5;
    assert_eq!(rig.run(), Some(SessionEnd::Complete));
    let state = rig.machine.state();
    assert_true_readings(state);
    assert_eq!(
        state.signs,
        [Some(-1.0), None, Some(1.0), Some(1.0), Some(-1.0)]
    );
}

#[test]
fn the_table_has_components_along_the_base_axes_and_is_held_against_the_journal() {
    let mut procedure = of_vectors();
    procedure.displacement_axes = vec![Direction::X, Direction::Z];
    let mut rig = Rig::start(&procedure);
    assert_eq!(rig.run(), Some(SessionEnd::Complete));
    let state = rig.machine.state().clone();
    let mut csv = Vec::new();
    table(&state, &mut csv).expect("every number is finite");
    let text = String::from_utf8(csv).expect("it is text");
    let read = read_readings("readings.csv", text.as_bytes()).expect("it was written");
    let last = read.readings.last().expect("there are readings");
    let force_n = state
        .readings
        .last()
        .expect("there are readings")
        .taken
        .force_n;
    let load = read.load_direction(last);
    assert_eq!(load.to_string(), "diagonal");
    for (part, share) in load.unit_vector().iter().zip([0.0, 0.6, 0.8]) {
        assert!((part * last.force_n - share * force_n).abs() < 1e-12);
    }
    let gauges = read.loads().last().expect("there are readings").iter();
    let gauges: Vec<Direction> = gauges.map(|reading| reading.direction).collect();
    assert_eq!(gauges, [Direction::X, Direction::Z]);
    let journal = read_journal(&rig.journal_bytes());
    let same = integrity(&journal, &read).expect("it is a table");
    assert!(same.changed.is_empty() && same.marks.is_empty(), "{same:?}");
    let raw = &state.readings[2].taken.gauges[1].raw;
    let changed = text.replacen(raw.as_str(), "0.999 mm", 1);
    let read = read_readings("readings.csv", changed.as_bytes()).expect("it is a table");
    let found = integrity(&journal, &read).expect("it is a table");
    assert_eq!(found.changed.len(), 1, "{found:?}");
    assert_eq!(found.changed[0].column, "displacement_z_raw");
}

#[test]
fn cut_anywhere_and_resumed_nothing_is_lost_or_doubled() {
    assert_cuts_lose_nothing(&of_vectors(), 1009);
}

/// Runs into the second load of the first run, does something to the gauges, and waits.
fn in_the_second_load(rig: &mut Rig) {
    rig.until(100_000, |rig| {
        let view = rig.machine.view();
        view.progress.accepted == 2 && matches!(view.task, Task::Load { .. })
    });
}

#[test]
fn a_fault_of_one_gauge_of_three_holds_the_session_up_and_nothing_false_is_taken() {
    let silent = [
        Channel::DisplacementX,
        Channel::DisplacementY,
        Channel::DisplacementZ,
    ];
    let silent = silent.map(|channel| {
        let said = format!("nothing comes from the {channel} gauge");
        (Fault::Silent(channel), said)
    });
    let said = "the displacement-y gauge sends in and was in mm";
    for (fault, said) in silent.into_iter().chain([(Fault::Unit, said.to_owned())]) {
        let mut rig = Rig::start(&of_vectors());
        in_the_second_load(&mut rig);
        let rig = assert_held_up(rig, fault, &said);
        assert_true_readings(rig.machine.state());
    }
}

#[test]
fn an_unplugged_gauge_comes_back_and_the_zeros_are_checked_before_the_next_reading() {
    let mut rig = Rig::start(&of_vectors());
    in_the_second_load(&mut rig);
    let channel = Channel::DisplacementZ;
    rig.unplug(channel);
    rig.bench.fault = Some(Fault::Silent(channel));
    rig.wait(50);
    rig.bench.fault = None;
    rig.plug_in(channel);
    assert_eq!(rig.run(), Some(SessionEnd::Complete));
    assert_true_readings(rig.machine.state());
    let bytes = rig.journal_bytes();
    let records = records(&bytes);
    let lost = records.iter().position(|record| {
        matches!(&record.event, Event::Link(change) if change.channel == channel && change.lost)
    });
    let after = &records[lost.expect("it is in the journal")..];
    let next = after
        .iter()
        .find(|record| matches!(record.event, Event::Zero(_) | Event::Reading(_)));
    let Some(Event::Zero(checked)) = next.map(|record| &record.event) else {
        panic!("a reading without a look at the zero");
    };
    assert!(
        checked.gauges.iter().all(|gauge| gauge.drift_m.is_some()),
        "{checked:?}"
    );
}

#[test]
fn a_stand_that_moves_along_one_axis_is_noticed_by_that_gauge() {
    let mut rig = Rig::start(&of_vectors());
    rig.answer(&[("implausible", "accept")]);
    in_the_second_load(&mut rig);
    rig.bench.tare(Channel::DisplacementY);
    rig.bench.shift(Channel::DisplacementY, 60e-6);
    rig.run();
    let noticed = rig.said.iter().any(|line| line.contains("displacement-y"));
    let asked = rig
        .asked
        .iter()
        .any(|prompt| prompt.text.contains("displacement-y"));
    assert!(noticed || asked, "{:?}", rig.said);
    let state = rig.machine.state();
    let doubtful = state.readings.iter().filter(|kept| !kept.flag().is_empty());
    assert!(doubtful.count() > 0);
}

/// A session in which things befall the gauges: after so many ticks, what, and to which gauge.
fn with_mishaps(mishaps: &[(u16, u8, usize)]) -> Rig {
    let procedure = of_vectors();
    let mut rig = Rig::start(&procedure);
    let channels = [
        Channel::Force,
        Channel::DisplacementX,
        Channel::DisplacementY,
        Channel::DisplacementZ,
    ];
    for &(ticks, what, which) in mishaps {
        rig.wait(ticks.into());
        let channel = channels[which];
        match what {
            0 => rig.bench.fault = Some(Fault::Silent(channel)),
            1 => {
                rig.unplug(channel);
                rig.plug_in(channel);
            }
            2 => {
                let before = rig.machine.state().clone();
                let (bench, bytes) = (rig.bench.clone(), rig.journal_bytes());
                assert_eq!(SessionState::fold(&read_journal(&bytes).records), before);
                rig = Rig::resume(&procedure, &bytes, bench);
            }
            _ => rig.bench.fault = Some(Fault::Unit),
        }
        rig.wait(20);
        rig.bench.fault = None;
    }
    // The first reading fixes the unit of a gauge: one that was in inches then is set back to them, as the operator is told.
    let along_y = &rig.machine.state().instruments[Channel::DisplacementY.index()];
    let began = along_y.as_ref().map(|known| &*known.unit);
    if began == Some("in") && !rig.machine.state().readings.is_empty() {
        rig.bench.fault = Some(Fault::Unit);
    }
    rig
}

fn assert_whole_and_true(mut rig: Rig) {
    assert_eq!(rig.run(), Some(SessionEnd::Complete));
    assert_true_readings(rig.machine.state());
    let state = rig.machine.state().clone();
    assert_eq!(state.taken.len(), 12);
    assert_eq!(SessionState::fold(&records(&rig.journal_bytes())), state);
}

#[test]
fn a_gauge_in_another_unit_at_the_first_reading_stays_in_it() {
    let is_in_inches = |rig: &Rig| {
        let first = rig.machine.state().readings.first();
        first.is_some_and(|kept| kept.taken.gauges[1].raw.ends_with(" in"))
    };
    let mut rigs = (1..200).map(|after| with_mishaps(&[(21, 1, 0), (after, 3, 0)]));
    let mut rig = rigs.find(is_in_inches).expect("it is in inches at once");
    let inches = rig.bench.fault.take();
    rig.wait(300);
    let view = rig.machine.view();
    assert_eq!(view.progress.accepted, 1);
    let asked = "the displacement-y gauge sends mm and was in in: set it back to in at its panel";
    assert!(view.held_up.iter().any(|line| line == asked), "{view:?}");
    rig.bench.fault = inches;
    assert_whole_and_true(rig);
}

/// The gauge is checked again while somebody pushes: what it shows then is no rest to count a push from.
#[test]
fn a_push_that_is_interrupted_counts_from_a_rest() {
    assert_whole_and_true(with_mishaps(&[(20, 3, 0)]));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Whatever becomes of one gauge, and whenever the program is killed: the journal holds what was acknowledged, and nothing false.
    #[test]
    fn mishaps_of_any_gauge_leave_only_true_readings(
        mishaps in prop::collection::vec((1..160_u16, 0..4_u8, 0..4_usize), 0..8)
    ) {
        assert_whole_and_true(with_mishaps(&mishaps));
    }
}
