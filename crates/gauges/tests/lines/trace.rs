//! What is recorded gives on replay what was lived through.

use stiffbench_gauges::trace::{
    GaugeTrace, Replay, ReplayPace, TraceHeader, TraceSink, TraceWriter, events_of,
};

use super::*;

/// Bytes that are written to and looked at.
#[derive(Clone, Default)]
struct Shared(std::sync::Arc<std::sync::Mutex<Vec<u8>>>);

impl std::io::Write for Shared {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.0.lock().unwrap().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

/// A live run with everything that can be wrong with packets, by a clock of some speed; its samples and its trace.
fn lived(speed: f64) -> (Vec<Sample>, Vec<u8>) {
    let desk = Desk::new();
    let mut count = 0;
    let device = Device::at(&desk.name("force"), move |command| {
        if command == "ID" {
            return vec![b"trial 1\r".to_vec()];
        }
        count += 1;
        match count % 9 {
            2 => vec![b"rubbish\r".to_vec()],
            4 => vec![format!("+{count} N\r+{count}.5 N\r").into_bytes()],
            5 => {
                std::thread::sleep(Duration::from_millis(260));
                vec![format!("+{count} N\r").into_bytes()]
            }
            6 => vec![b"\x00\xff".to_vec(), format!("+{count} N\r").into_bytes()],
            7 => vec![
                format!("+{count} ").into_bytes(),
                b"N".to_vec(),
                b"\r".to_vec(),
            ],
            8 => vec![format!("+{count} kN\r").into_bytes()],
            _ => vec![format!("-{count} N\r").into_bytes()],
        }
    });
    let file = Shared::default();
    let header = TraceHeader {
        instrument: Some("trial".to_owned()),
        speed: Some(speed),
        ..TraceHeader::default()
    };
    let writer = TraceWriter::begin(file.clone(), &header).unwrap();
    let mut live = gauge(description(Channel::Force), &desk.path("force"));
    live.trace = Some(Box::new(TraceSink::start(writer, |error| {
        panic!("{error}")
    })));
    let mut gauges = start_by(Clock::starting_at(0.0, speed), vec![live]);
    let mut values = 0;
    let mut events = until(&mut gauges, |event| {
        values += u32::from(is_sample(event));
        values == 50
    });
    drop(device);
    events.extend(until_link(&mut gauges, is_lost));
    let _device = Device::counting(&desk.name("force"), "trial 1", "N");
    events.extend(until(&mut gauges, is_sample));
    // What has come by now and was not looked at is in the trace too.
    std::thread::sleep(Duration::from_millis(20));
    let rest = std::iter::from_fn(|| gauges.next(Duration::ZERO));
    events.extend(rest);
    drop(gauges);
    let bytes = file.0.lock().unwrap().clone();
    (samples(&events).into_iter().cloned().collect(), bytes)
}

#[test]
fn a_replay_gives_the_samples_of_the_live_run() {
    replays(1.0);
}

#[test]
fn a_session_in_fast_forward_is_replayed_as_well() {
    replays(200.0);
}

/// Whether the replay of a run gives its samples.
fn replays(speed: f64) {
    let (mut samples, bytes) = lived(speed);
    let trace = GaugeTrace::parse(&bytes, "t").unwrap();
    assert!(
        trace.complete && trace.damage.is_empty(),
        "{:?}",
        trace.damage
    );
    let events = events_of(&trace, &description(Channel::Force), None).unwrap();
    let mut replay = Replay::new(vec![events], ReplayPace::Fastest);
    let mut replayed = Vec::new();
    loop {
        match replay.next(Duration::ZERO) {
            Some(GaugeEvent::Sample { sample, .. }) => replayed.push(sample),
            Some(GaugeEvent::Ended) => break,
            Some(_) => {}
            None => panic!("a trace at the fastest pace makes nobody wait"),
        }
    }
    // Between the last look at the queue and the end of the line more may have come.
    assert!(replayed.len() >= samples.len() && samples.len() > 50);
    replayed.truncate(samples.len());
    for sample in samples.iter_mut().chain(&mut replayed) {
        // The trace keeps microseconds.
        sample.at_s = (sample.at_s * 1e5).round() / 1e5;
    }
    for (live, again) in samples.iter().zip(&replayed) {
        assert_eq!(
            (&live.raw, live.value_si, &live.marks),
            (&again.raw, again.value_si, &again.marks)
        );
        assert!((live.at_s - again.at_s).abs() < 2e-5);
    }
}

#[test]
fn a_trace_without_marks_is_decoded_by_its_bytes_alone() {
    let text = "# stiffbench/trace/1\n# note by hand\n0.0 > other 2 R\\r\n0.1 < 3 +1.\n0.2 < 5 5 N\\r+\n0.25 < 4 2 N\\r\n9.0 < 4 +3 N\n";
    let trace = GaugeTrace::parse(text.as_bytes(), "t").unwrap();
    assert_eq!(trace.damage, []);
    let events = events_of(&trace, &description(Channel::Force), None).unwrap();
    let values: Vec<f64> = events
        .iter()
        .filter_map(|(_, event)| match event {
            GaugeEvent::Sample { sample, .. } => Some(sample.value),
            _ => None,
        })
        .collect();
    assert_eq!(values, [1.5, 2.0]);
    assert!(
        matches!(events.last(), Some((_, GaugeEvent::Rejected { .. }))),
        "{events:?}"
    );
}

#[test]
fn the_documented_example_is_a_trace() {
    let text = stiffbench_test_files::example("docs/trace-file.md", "text");
    let trace = GaugeTrace::parse(text.as_bytes(), "docs/trace-file.md").unwrap();
    assert!(
        trace.complete && trace.damage.is_empty(),
        "{:?}",
        trace.damage
    );
    let description = crate::support::shipped_instrument("mark10-series5");
    let events = events_of(&trace, &description, None).unwrap();
    let events: Vec<GaugeEvent> = events.into_iter().map(|(_, event)| event).collect();
    let values = samples(&events);
    assert_eq!(values.len(), 1, "one of the two is not used: {events:#?}");
    assert_eq!((values[0].value, values[0].at_s), (-0.02, 0.261_488));
}

#[test]
fn the_documented_bindings_are_bindings() {
    let text = stiffbench_test_files::example("docs/bindings-file.md", "toml");
    let source =
        stiffbench_units_and_text::source_text::SourceText::new("docs/bindings-file.md", text);
    let (bindings, warnings) = stiffbench_gauges::port::Bindings::parse(&source).unwrap();
    assert_eq!(warnings, [""; 0]);
    assert!(bindings.force.is_some() && bindings.displacement.is_some());
}
