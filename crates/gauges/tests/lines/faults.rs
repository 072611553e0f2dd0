//! What goes wrong on a bench.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use stiffbench_gauges::Ask;
use stiffbench_gauges::trace::What;

use super::*;

fn one(desk: &Desk) -> LiveGauges {
    start(vec![gauge(
        description(Channel::Force),
        &desk.path("force"),
    )])
}

#[test]
fn a_cable_that_is_pulled_and_put_back_is_a_line_lost_and_found() {
    let desk = Desk::new();
    let device = Device::counting(&desk.name("force"), "trial 1", "N");
    let mut gauges = one(&desk);
    until(&mut gauges, is_sample);
    drop(device);
    let events = until_link(&mut gauges, |state| {
        matches!(state, LinkState::Reconnecting { attempt: 3 })
    });
    let lost = events.iter().filter(|event| is_link(event, is_lost));
    assert_eq!(lost.count(), 1, "it is said once: {events:#?}");
    let _device = Device::counting(&desk.name("force"), "trial 1", "N");
    let events = until(&mut gauges, is_sample);
    assert!(events.iter().any(is_connected));
}

#[test]
fn another_gauge_on_the_same_name_is_refused_and_the_right_one_taken() {
    let desk = Desk::new();
    let device = Device::counting(&desk.name("force"), "trial 1", "N");
    let mut gauges = one(&desk);
    until(&mut gauges, is_sample);
    drop(device);
    until_link(&mut gauges, is_lost);
    let other = Device::counting(&desk.name("force"), "trial 2", "N");
    let events = until_link(&mut gauges, |state| {
        matches!(state, LinkState::WrongDevice { .. })
    });
    let reason = reason_of(events.last());
    assert!(
        reason.contains("trial 1") && reason.contains("trial 2"),
        "{reason}"
    );
    drop(other);
    let _device = Device::counting(&desk.name("force"), "trial 1", "N");
    let events = until(&mut gauges, is_connected);
    assert_eq!(samples(&events).len(), 0, "nothing of the other is a value");
    until(&mut gauges, is_sample);
}

#[test]
fn retries_for_an_absent_gauge_are_bounded() {
    let desk = Desk::new();
    let retry_policy = RetryPolicy {
        first_s: 0.001,
        longest_s: 0.002,
        tries: 3,
    };
    let gauge = gauge(description(Channel::Force), &desk.path("force"));
    let mut gauges = LiveGauges::start(
        vec![gauge],
        Clock::default(),
        PortTimeouts::without_waiting(),
        retry_policy,
    )
    .unwrap();
    let events = until_link(&mut gauges, |state| *state == LinkState::GivenUp);
    let tries = events
        .iter()
        .filter(|event| is_link(event, is_reconnecting));
    assert_eq!(tries.count(), 3);
    let reason = reason_of(events.first());
    assert!(
        reason.contains("does not exist") && reason.contains("stiffbench gauge ports"),
        "{reason}"
    );
    assert_eq!(
        gauges.next(Duration::from_millis(50)),
        None,
        "it is left alone"
    );
    // Asked for, it is searched for again.
    let _device = Device::counting(&desk.name("force"), "trial 1", "N");
    gauges.ask(Channel::Force, Ask::Zero);
    let events = until(&mut gauges, is_sample);
    assert!(
        matches!(&events[0], GaugeEvent::Answered { answer: Err(_), .. }),
        "{events:#?}"
    );
}

#[test]
fn a_port_that_another_program_has_is_busy() {
    let desk = Desk::new();
    let _device = Device::counting(&desk.name("force"), "trial 1", "N");
    let other = serialport::new(desk.path("force"), 9600)
        .open_native()
        .unwrap();
    let mut gauges = one(&desk);
    let events = until_link(&mut gauges, is_lost);
    let reason = reason_of(events.last());
    assert!(reason.contains("in use"), "{reason}");
    drop(other);
    until(&mut gauges, is_sample);
}

#[test]
fn silence_and_return_of_a_gauge_are_both_reported() {
    let desk = Desk::new();
    let asleep = Arc::new(AtomicBool::new(false));
    let is_asleep = Arc::clone(&asleep);
    let _device = Device::at(&desk.name("force"), move |_| {
        if is_asleep.load(Ordering::Relaxed) {
            Vec::new()
        } else {
            vec![b"+1 N\r".to_vec()]
        }
    });
    let text = GAUGE
        .lines()
        .filter(|line| !line.starts_with("identify ="))
        .collect::<Vec<_>>()
        .join("\n");
    let (description, _) = InstrumentDescription::parse(&text, "trial").unwrap();
    let mut gauges = start(vec![gauge(description, &desk.path("force"))]);
    until(&mut gauges, is_sample);
    asleep.store(true, Ordering::Relaxed);
    let events = until_link(&mut gauges, |state| *state == LinkState::Silent);
    let notes = events
        .iter()
        .filter(|event| matches!(event, GaugeEvent::Note { .. }));
    assert_eq!(notes.count(), 2, "each retry is noted");
    asleep.store(false, Ordering::Relaxed);
    let events = until(&mut gauges, is_sample);
    assert!(events.iter().any(is_connected));
}

#[test]
fn a_late_reply_never_answers_the_next_request() {
    let desk = Desk::new();
    let mut count = 0;
    // The n-th answer is n; every seventh comes after its deadline, every fourteenth after the drain too.
    let _device = Device::at(&desk.name("force"), move |command| {
        if command == "ID" {
            return vec![b"trial 1\r".to_vec()];
        }
        count += 1;
        if count % 7 == 0 {
            std::thread::sleep(Duration::from_millis(if count % 14 == 0 {
                290
            } else {
                265
            }));
        }
        vec![format!("+{count} N\r").into_bytes()]
    });
    let trace = Memory::default();
    let mut live = gauge(description(Channel::Force), &desk.path("force"));
    live.trace = Some(Box::new(trace.clone()));
    let mut gauges = start(vec![live]);
    let mut values = 0;
    let events = until(&mut gauges, |event| {
        values += u32::from(is_sample(event));
        values == 40
    });
    let entries = trace.0.lock().unwrap();
    for sample in samples(&events) {
        let asked = entries
            .iter()
            .filter(|entry| entry.at_s <= sample.at_s)
            .filter(|entry| matches!(&entry.what, What::Sent { bytes, .. } if bytes == b"R\r"));
        assert_eq!(
            asked.count() as f64,
            sample.value,
            "the answer to an older request was taken"
        );
    }
    let notes = events
        .iter()
        .filter(|event| matches!(event, GaugeEvent::Note { .. }));
    assert!(notes.count() >= 5, "{events:#?}");
}

#[test]
fn a_busy_port_is_reported_once() {
    let desk = Desk::new();
    let _device = Device::counting(&desk.name("force"), "trial 1", "N");
    let _other = serialport::new(desk.path("force"), 9600)
        .open_native()
        .unwrap();
    let mut gauges = one(&desk);
    let events = until_link(&mut gauges, |state| {
        matches!(state, LinkState::Reconnecting { attempt: 10 })
    });
    let told = events
        .iter()
        .filter(|event| !is_link(event, is_reconnecting));
    assert_eq!(told.count(), 1, "{events:#?}");
}
