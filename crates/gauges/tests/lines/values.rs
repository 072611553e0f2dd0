//! Values as they come.

use stiffbench_gauges::{Channel, GaugeEvent};
use stiffbench_units_and_text::quantity::Kind;

use super::*;

#[test]
fn two_gauges_are_read_at_once_and_do_not_mix() {
    let desk = Desk::new();
    let _force = Device::counting(&desk.name("force"), "force 1", "N");
    let _length = Device::counting(&desk.name("length"), "length 1", "mm");
    let mut gauges = start(vec![
        gauge(description(Channel::Force), &desk.path("force")),
        gauge(description(Channel::Displacement), &desk.path("length")),
    ]);
    let mut counts = [0, 0];
    let events = until(&mut gauges, |event| {
        if let GaugeEvent::Sample { channel, .. } = event {
            counts[channel.index()] += 1;
        }
        counts.iter().all(|count| *count >= 50)
    });
    for channel in Channel::ALL {
        let of_channel: Vec<&Sample> = events
            .iter()
            .filter_map(|event| match event {
                GaugeEvent::Sample {
                    channel: of,
                    sample,
                } if *of == channel => Some(sample),
                _ => None,
            })
            .collect();
        for (i, sample) in of_channel.iter().enumerate() {
            assert_eq!(
                sample.value,
                (i + 1) as f64,
                "none is lost, none comes twice"
            );
            assert_eq!(sample.kind, channel.kind());
            assert_eq!(
                &*sample.unit,
                if channel.kind() == Kind::Force {
                    "N"
                } else {
                    "mm"
                }
            );
        }
        assert!(
            of_channel
                .windows(2)
                .all(|pair| pair[0].at_s <= pair[1].at_s)
        );
    }
    assert_eq!(events.iter().filter(|event| is_connected(event)).count(), 2);
}

#[test]
fn packets_in_pieces_and_merged_and_behind_noise_are_read() {
    let desk = Desk::new();
    let mut count = 0;
    let _device = Device::at(&desk.name("force"), move |command| {
        if command == "ID" {
            return vec![b"trial 1\r".to_vec()];
        }
        count += 1;
        let packet = format!("+{count}.25 N\r").into_bytes();
        match count % 3 {
            // Byte by byte, cut at another place each time, after a NUL.
            0 => packet.iter().map(|byte| vec![*byte]).collect(),
            1 => {
                let (head, tail) = packet.split_at(count / 3 % packet.len());
                vec![head.to_vec(), tail.to_vec()]
            }
            _ => vec![[b"\0".as_slice(), &packet].concat()],
        }
    });
    let mut gauges = start(vec![gauge(
        description(Channel::Force),
        &desk.path("force"),
    )]);
    let mut values = 0;
    let events = until(&mut gauges, |event| {
        values += u32::from(is_sample(event));
        values == 40
    });
    for sample in samples(&events) {
        assert_eq!(sample.value.fract(), 0.25, "{sample:?}");
    }
}

#[test]
fn a_streaming_gauge_is_read_without_requests() {
    let desk = Desk::new();
    let text = GAUGE
        .lines()
        .filter(|line| !line.starts_with("read =") && !line.starts_with("identify ="))
        .collect::<Vec<_>>()
        .join("\n")
        .replace("terminator = \"\\r\"", "terminator = \"\\r\"\nstream_start = { send = \"ON\", expects = \"nothing\", effect = \"sets\" }\nstream_stop = { send = \"OFF\", expects = \"nothing\", effect = \"sets\" }");
    let (description, _) = InstrumentDescription::parse(&text, "trial").unwrap();
    assert_eq!(Acquisition::surest(&description), Acquisition::Stream);
    let (told, commands) = std::sync::mpsc::channel();
    let device = Device::at(&desk.name("force"), move |command| {
        told.send(command.to_owned()).unwrap();
        match command {
            "ON" => (1..=30).map(|i| format!("+{i} N\r").into_bytes()).collect(),
            _ => Vec::new(),
        }
    });
    let mut live = gauge(description, &desk.path("force"));
    live.acquisition = Acquisition::Stream;
    let mut gauges = start(vec![live]);
    let mut values = 0;
    let events = until(&mut gauges, |event| {
        values += usize::from(is_sample(event));
        values == 30
    });
    let values: Vec<f64> = samples(&events).iter().map(|sample| sample.value).collect();
    assert_eq!(values, (1..=30).map(f64::from).collect::<Vec<_>>());
    // It is left as it was found: not sending.
    drop(gauges);
    let clock = Clock::default();
    let mut commands_seen: Vec<String> = Vec::new();
    while commands_seen.len() < 3 && clock.now_s() < 5.0 {
        commands_seen.extend(commands.recv_timeout(Duration::from_millis(100)));
    }
    drop(device);
    assert_eq!(commands_seen, ["OFF", "ON", "OFF"]);
}
