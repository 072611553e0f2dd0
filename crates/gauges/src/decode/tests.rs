//! Unit tests of the decoder with the shipped descriptions.

use crate::sample::Sample;
use crate::shipped::shipped_instrument;

use super::*;

/// What comes of bytes in one piece, followed by silence.
fn decode(name: &str, unit: &str, bytes: &[u8]) -> Vec<Decoded> {
    let description = shipped_instrument(name).unwrap();
    let mut decoder = Decoder::new(&description, Some(unit)).unwrap();
    let mut out = Vec::new();
    decoder.push(bytes, 1.0, &mut out);
    decoder.idle(2.0, &mut out);
    out
}

fn samples(decoded: &[Decoded]) -> Vec<&Sample> {
    let samples = decoded.iter().filter_map(|decoded| match decoded {
        Decoded::Sample(sample) => Some(sample),
        _ => None,
    });
    samples.collect()
}

#[test]
fn a_makers_line_is_a_sample() {
    let decoded = decode("mark10-series5", "N", b"4.285 N\r\n");
    let [sample] = samples(&decoded)[..] else {
        panic!("{decoded:?}");
    };
    assert_eq!((sample.value, sample.value_si), (4.285, 4.285));
    assert_eq!(sample.resolution_si, 0.001);
    assert_eq!(&*sample.unit, "N");
    assert_eq!(&*sample.raw, "4.285 N");
}

/// A decoder with what has come out of it.
struct Line {
    decoder: Decoder,
    out: Vec<Decoded>,
}

impl Line {
    fn to(name: &str, unit: Option<&str>) -> Self {
        let description = shipped_instrument(name).unwrap();
        Self {
            decoder: Decoder::new(&description, unit).unwrap(),
            out: Vec::new(),
        }
    }

    /// Asks, and takes what comes.
    fn ask(&mut self, role: CommandRole, answer: &[u8]) -> &Decoded {
        self.decoder.asked(role);
        self.take(answer)
    }

    fn take(&mut self, bytes: &[u8]) -> &Decoded {
        self.decoder.push(bytes, 0.0, &mut self.out);
        self.out.last().unwrap()
    }

    fn meaning(&mut self, role: CommandRole, answer: &[u8]) -> Meaning {
        match self.ask(role, answer) {
            Decoded::Reply(reply) => reply.meaning.clone(),
            other => panic!("{other:?}"),
        }
    }

    fn reason(&mut self, bytes: &[u8]) -> String {
        match self.take(bytes) {
            Decoded::Rejected(rejected) => rejected.reason.to_string(),
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn an_answer_is_read_by_what_was_asked() {
    let mut gauge = Line::to("aikoh-rx", None);
    assert_eq!(
        gauge.meaning(CommandRole::Zero, b"OK\r\n"),
        Meaning::Acknowledged
    );
    assert!(
        matches!(gauge.meaning(CommandRole::Zero, b"NG\r\n"), Meaning::Refused(why) if why.contains("understand"))
    );
    assert_eq!(
        gauge.meaning(CommandRole::Identify, b"Ver 1.02\r\n"),
        Meaning::Identity("Ver 1.02".to_owned())
    );
    // Refused instead of a value: no sample, and nothing is expected any more.
    assert!(matches!(
        gauge.ask(CommandRole::Read, b"NO\r\n"),
        Decoded::Rejected(_)
    ));
    assert!(
        matches!(gauge.take(b" +1.00 N\r\n"), Decoded::Sample(sample) if sample.marks.len() == 1)
    );
}

#[test]
fn a_serial_number_of_digits_is_no_value_and_a_value_with_unit_no_serial_number() {
    let mut gauge = Line::to("mark10-series5", Some("N"));
    assert_eq!(
        gauge.meaning(CommandRole::Identify, b"3791204\r\n"),
        Meaning::Identity("3791204".to_owned())
    );
    assert!(matches!(
        gauge.ask(CommandRole::Identify, b"4.285 N\r\n"),
        Decoded::Sample(_)
    ));
    assert_eq!(
        gauge.meaning(CommandRole::Identify, b"3791204\r\n"),
        Meaning::Identity("3791204".to_owned())
    );
}

#[test]
fn a_command_sent_back_is_no_value() {
    let mut gauge = Line::to("mahr-dk-u1", None);
    assert_eq!(
        gauge.meaning(CommandRole::SetUnit, b"MM\r"),
        Meaning::Acknowledged
    );
    assert!(matches!(
        gauge.meaning(CommandRole::Read, b"?\r"),
        Meaning::Text(_)
    ));
    assert!(
        matches!(gauge.take(b"-000.415 mm\r"), Decoded::Sample(sample) if sample.marks.is_empty())
    );
}

#[test]
fn values_are_rejected_while_the_gauge_reports_peak_mode() {
    let mut gauge = Line::to("mark10-series5", None);
    let list = |mode| format!("V1.00;N;{mode};FLTC8;FLTP1;AOUT00;AOFF5;FULL;MIT;POL;B0\r\n");
    assert!(matches!(
        gauge.meaning(CommandRole::QueryMode, list("PC").as_bytes()),
        Meaning::State(_)
    ));
    assert!(gauge.reason(b"4.285 N\r\n").contains("peak mode"));
    gauge.meaning(CommandRole::QueryMode, list("CUR").as_bytes());
    assert!(matches!(gauge.take(b"4.285 N\r\n"), Decoded::Sample(_)));
}

#[test]
fn the_unit_that_the_gauge_names_holds_against_the_configured_one() {
    let mut gauge = Line::to("sylvac-opto-rs", Some("mm"));
    assert_eq!(
        gauge.meaning(CommandRole::QueryUnit, b"MM\r"),
        Meaning::Unit("mm".to_owned())
    );
    assert!(matches!(
        gauge.ask(CommandRole::Read, b"+012.345\r"),
        Decoded::Sample(_)
    ));
    assert_eq!(
        gauge.meaning(CommandRole::QueryUnit, b"IN\r"),
        Meaning::Unit("in".to_owned())
    );
    assert!(gauge.reason(b"+0.12345\r").contains("wrong unit"));
    let mut asked_only = Line::to("sylvac-opto-rs", None);
    assert!(asked_only.reason(b"+012.345\r").contains("no unit"));
    asked_only.meaning(CommandRole::QueryUnit, b"MM\r");
    assert!(matches!(asked_only.take(b"+012.345\r"), Decoded::Sample(_)));
}

#[test]
fn a_drained_line_restarts_decoding() {
    let mut gauge = Line::to("mark10-series5", None);
    gauge.decoder.push(b"4.28", 0.0, &mut gauge.out);
    gauge.decoder.idle(1.0, &mut gauge.out);
    assert!(gauge.reason(b"5 N\r\n").contains("beginning is lost"));
    gauge.decoder.push(b"4.28", 0.0, &mut gauge.out);
    gauge.decoder.reset();
    assert!(matches!(gauge.take(b"5 N\r\n"), Decoded::Sample(_)));
}

#[test]
fn bytes_lost_from_packets_known_by_count_make_no_value() {
    for burst in [&b"x1021.15"[..], b"1021.11021.15", b"11021.15", b"1021.151"] {
        let decoded = decode("sauter-fh", "N", burst);
        assert!(samples(&decoded).is_empty(), "{decoded:?}");
    }
    // After the silence it is in step again.
    let mut gauge = Line::to("sauter-fh", Some("N"));
    gauge.decoder.push(b"x1021.15", 0.0, &mut gauge.out);
    gauge.decoder.idle(1.0, &mut gauge.out);
    gauge.decoder.push(b"1021.15", 2.0, &mut gauge.out);
    gauge.decoder.idle(3.0, &mut gauge.out);
    assert_eq!(samples(&gauge.out).len(), 1);
    assert_eq!(samples(&gauge.out)[0].at_s, 2.0);
}

#[test]
fn a_long_recording_of_packets_known_by_count_is_read_whole() {
    let decoded = decode("sauter-fh", "N", &b"1021.15".repeat(1000));
    assert_eq!(samples(&decoded).len(), 1000);
}

#[test]
fn a_packet_hides_behind_a_false_start() {
    // An STX in the noise claims the first bytes of the packet behind it.
    let decoded = decode("lutron-fg", "N", b"\x02\x02abc\x0241590200001234\r");
    assert_eq!(samples(&decoded)[0].value, 12.34);
    let decoded = decode(
        "shahe-modbus",
        "mm",
        &[1, 3, 4, 1, 3, 4, 0, 0, 0x30, 0x39, 0x2E, 0x21],
    );
    assert_eq!(samples(&decoded)[0].value, 12.345);
}

#[test]
fn a_unit_that_cannot_be_is_refused_with_those_that_can() {
    let gauge = |name| shipped_instrument(name).unwrap();
    let error = Decoder::new(&gauge("mitutoyo-01a"), None).unwrap_err();
    assert!(matches!(error, DecoderError::UnitNeeded { .. }));
    for (name, unit) in [
        ("mitutoyo-01a", "um"),
        ("mitutoyo-01a", "N"),
        ("mark10-series5", "mm"),
        ("sauter-fh", "gf"),
    ] {
        let error = Decoder::new(&gauge(name), Some(unit)).unwrap_err();
        assert!(
            matches!(error, DecoderError::UnitUnknown { .. }),
            "{name} {unit}"
        );
    }
}
