//! Every shipped instrument against traffic whose meaning was computed by hand: whole, cut at every byte, merged, garbled, behind noise, with
//! silence; and any bytes at all.

use std::collections::BTreeMap;

use proptest::prelude::*;
use serde::Deserialize;
use stiffbench_gauges::{
    CommandRole, Decoded, Decoder, DescriptionStatus, InstrumentDescription, Mark, Meaning, Sample,
};
use stiffbench_test_files::shipped_instruments;

use crate::support::{samples, shipped_instrument};
use stiffbench_units_and_text::quantity::Kind;

/// What every instrument's traffic shows, or states why it cannot.
const CLASSES: [&str; 9] = [
    "good",
    "error",
    "no-data",
    "overload",
    "fault",
    "mode",
    "status",
    "wrong-unit",
    "acknowledgement",
];

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Traffic {
    unit: String,
    absent: BTreeMap<String, String>,
    packet: Vec<Packet>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Packet {
    class: String,
    source: String,
    bytes: Option<String>,
    hex: Option<String>,
    value: Option<f64>,
    unit: Option<String>,
    resolution: Option<f64>,
    si: Option<f64>,
    #[serde(default)]
    marks: Vec<String>,
    second: Option<Second>,
    rejected: Option<String>,
    reply: Option<String>,
}

#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
struct Second {
    value: f64,
    unit: String,
}

impl Packet {
    fn bytes(&self) -> Vec<u8> {
        match (&self.bytes, &self.hex) {
            (Some(text), None) => text.clone().into_bytes(),
            (None, Some(hex)) => {
                let bytes = hex
                    .split(' ')
                    .map(|byte| u8::from_str_radix(byte, 16).unwrap());
                bytes.collect()
            }
            _ => panic!("bytes or hex: {self:?}"),
        }
    }

    fn is_good(&self) -> bool {
        self.value.is_some()
    }
}

/// A gauge with its traffic.
struct Gauge {
    name: &'static str,
    description: InstrumentDescription,
    traffic: Traffic,
}

impl Gauge {
    fn all() -> impl Iterator<Item = Self> {
        shipped_instruments()
            .iter()
            .map(|shipped| Self::named(shipped.name))
    }

    fn named(name: &'static str) -> Self {
        let path = stiffbench_test_files::repository()
            .join("fixtures/instruments")
            .join(name)
            .join("packets.toml");
        let text = std::fs::read_to_string(&path)
            .unwrap_or_else(|error| panic!("{}: {error}", path.display()));
        Self {
            name,
            description: shipped_instrument(name),
            traffic: toml::from_str(&text)
                .unwrap_or_else(|error| panic!("{}: {error}", path.display())),
        }
    }

    fn decoder(&self) -> Decoder {
        Decoder::new(&self.description, Some(&self.traffic.unit)).unwrap()
    }

    /// What comes of pieces that arrive one after the other, and of silence behind them.
    fn decode(&self, pieces: &[&[u8]]) -> Vec<Decoded> {
        let mut decoder = self.decoder();
        let mut out = Vec::new();
        for piece in pieces {
            decoder.push(piece, 0.0, &mut out);
        }
        decoder.idle(0.0, &mut out);
        out
    }

    fn good(&self) -> impl Iterator<Item = &Packet> {
        self.traffic.packet.iter().filter(|packet| packet.is_good())
    }

    /// Whether packets are known by their count and silence alone.
    fn counts_only(&self) -> bool {
        self.name == "sauter-fh"
    }

    /// Whether every packet has a check sum.
    fn has_check_sum(&self) -> bool {
        self.name.ends_with("modbus")
    }

    /// All packets in one piece, in the order of the file.
    fn merged(&self) -> Vec<u8> {
        self.traffic.packet.iter().flat_map(Packet::bytes).collect()
    }
}

/// Nothing was asked in these tests, so every value of a gauge that waits to be asked is marked so; the other marks by name.
fn marks(sample: &Sample) -> Vec<String> {
    let marks = sample
        .marks
        .iter()
        .filter(|mark| **mark != Mark::Unrequested);
    marks
        .map(|mark| {
            serde_json::to_value(mark)
                .unwrap()
                .as_str()
                .unwrap()
                .to_owned()
        })
        .collect()
}

fn assert_close(found: f64, expected: f64, what: &str) {
    assert!(
        (found - expected).abs() <= 1e-12 * expected.abs(),
        "{what}: {found} is not {expected}"
    );
}

fn assert_is(packet: &Packet, decoded: &[Decoded], place: &str) {
    if let Some(value) = packet.value {
        let unit = packet.unit.as_deref().unwrap();
        let found = samples(decoded);
        assert_eq!(found.len(), decoded.len(), "{place}: {decoded:?}");
        assert_eq!(
            found.len(),
            1 + usize::from(packet.second.is_some()),
            "{place}: {decoded:?}"
        );
        assert_eq!(found[0].value, value, "{place}");
        assert_eq!(&*found[0].unit, unit, "{place}");
        assert_eq!(marks(found[0]), packet.marks, "{place}");
        let factor = found[0].kind.si_factor(unit).unwrap();
        assert_close(
            found[0].value_si,
            packet.si.unwrap_or(value * factor),
            place,
        );
        if let Some(resolution) = packet.resolution {
            assert_close(found[0].resolution_si, resolution * factor, place);
        }
        if let Some(second) = &packet.second {
            assert_eq!(
                (found[1].value, &*found[1].unit),
                (second.value, second.unit.as_str())
            );
            assert_eq!(found[1].kind, Kind::Displacement);
        }
        return;
    }
    let [one] = decoded else {
        panic!("{place}: {decoded:?}");
    };
    match (one, &packet.rejected, &packet.reply) {
        (Decoded::Rejected(rejected), Some(words), None) => {
            assert!(
                rejected.reason.contains(words.as_str()),
                "{place}: {}",
                rejected.reason
            );
        }
        (Decoded::Reply(reply), None, Some(expected)) => {
            let meaning = match reply.meaning {
                Meaning::Acknowledged => "acknowledged",
                Meaning::Identity(_) => "identity",
                Meaning::State(_) => "state",
                Meaning::Text(_) => "text",
                Meaning::Unit(_) => "unit",
                Meaning::Refused(_) => "refused",
            };
            assert_eq!(meaning, expected, "{place}");
        }
        _ => panic!("{place}: {one:?}"),
    }
}

#[test]
fn every_class_of_traffic_is_there_or_argued_away() {
    for gauge in Gauge::all() {
        for class in CLASSES {
            let there = gauge
                .traffic
                .packet
                .iter()
                .any(|packet| packet.class == class);
            let absent = gauge.traffic.absent.contains_key(class);
            assert!(there != absent, "{}: {class}", gauge.name);
        }
        for packet in &gauge.traffic.packet {
            assert!(
                ["maker", "program", "grammar"].contains(&packet.source.as_str()),
                "{packet:?}"
            );
            let outcomes = [
                packet.value.is_some(),
                packet.rejected.is_some(),
                packet.reply.is_some(),
            ];
            assert_eq!(
                outcomes.iter().filter(|there| **there).count(),
                1,
                "{packet:?}"
            );
        }
    }
}

#[test]
fn every_packet_decodes_to_the_value_worked_out_by_hand() {
    for gauge in Gauge::all() {
        for packet in &gauge.traffic.packet {
            let place = format!(
                "{} {:?}",
                gauge.name,
                packet.bytes.as_ref().or(packet.hex.as_ref())
            );
            assert_is(packet, &gauge.decode(&[&packet.bytes()]), &place);
        }
    }
}

#[test]
fn the_same_comes_out_however_bytes_are_cut() {
    for gauge in Gauge::all() {
        let merged = gauge.merged();
        let whole = gauge.decode(&[&merged]);
        for cut in 0..=merged.len() {
            let (first, second) = merged.split_at(cut);
            assert_eq!(
                gauge.decode(&[first, second]),
                whole,
                "{} cut at {cut}",
                gauge.name
            );
        }
        let bytes: Vec<&[u8]> = merged.chunks(1).collect();
        assert_eq!(gauge.decode(&bytes), whole, "{} byte by byte", gauge.name);
    }
}

/// What was decoded, as it is where so many bytes stand before it.
fn behind(bytes: usize, decoded: Vec<Decoded>) -> Vec<Decoded> {
    let moved = |one| match one {
        Decoded::Sample(sample) => Decoded::Sample(Sample {
            bytes: sample.bytes.map(|place| place + bytes as u64),
            ..sample
        }),
        other => other,
    };
    decoded.into_iter().map(moved).collect()
}

#[test]
fn merged_packets_are_separated() {
    for gauge in Gauge::all() {
        let merged = gauge.decode(&[&gauge.merged()]);
        let mut before = 0;
        let mut alone = Vec::new();
        for packet in &gauge.traffic.packet {
            let bytes = packet.bytes();
            alone.extend(behind(before, gauge.decode(&[&bytes])));
            before += bytes.len();
        }
        assert_eq!(merged, alone, "{}", gauge.name);
    }
}

#[test]
fn a_packet_with_a_flipped_top_bit_or_a_nul_is_no_value_and_spoils_no_other() {
    for gauge in Gauge::all() {
        for packet in gauge.good() {
            let good = packet.bytes();
            let expected = gauge.decode(&[&good]);
            for place in 0..good.len() {
                // What is complete before the damage counts: a gauge with several end marks.
                if !samples(&gauge.decode(&[&good[..place]])).is_empty() {
                    continue;
                }
                for damaged in [good[place] ^ 0x80, 0] {
                    if damaged == good[place] {
                        continue;
                    }
                    let mut bytes = good.clone();
                    bytes[place] = damaged;
                    let context = format!("{} byte {place} as {damaged:#04x}", gauge.name);
                    assert_eq!(samples(&gauge.decode(&[&bytes])).len(), 0, "{context}");
                    // Two good packets behind it: the first may be lost with an end mark that was damaged, the second never is.
                    let after = gauge.decode(&[&bytes, &good, &good]);
                    let expected = behind(2 * good.len(), expected.clone());
                    assert_eq!(after.last(), expected.last(), "{context}");
                }
            }
        }
    }
}

#[test]
fn packets_cut_short_are_no_values() {
    for gauge in Gauge::all() {
        for packet in gauge.good() {
            let good = packet.bytes();
            for length in 1..good.len() {
                let decoded = gauge.decode(&[&good[..length]]);
                // A line whose last end mark is one of two is complete.
                let complete = gauge.name.starts_with("generic")
                    && length + 1 == good.len()
                    && good.ends_with(b"\r\n")
                    || gauge.name == "magnescale-lt20a" && length + 1 == good.len();
                assert_eq!(
                    !samples(&decoded).is_empty(),
                    complete,
                    "{} {length}: {decoded:?}",
                    gauge.name
                );
            }
        }
    }
}

#[test]
fn after_a_packet_that_stopped_its_late_rest_is_no_value() {
    for gauge in Gauge::all().filter(|gauge| !gauge.counts_only()) {
        for packet in gauge.good() {
            let good = packet.bytes();
            for cut in 1..good.len() - 1 {
                let mut decoder = gauge.decoder();
                let mut out = Vec::new();
                decoder.push(&good[..cut], 0.0, &mut out);
                decoder.idle(1.0, &mut out);
                decoder.push(&good[cut..], 2.0, &mut out);
                decoder.idle(3.0, &mut out);
                let complete = samples(&gauge.decode(&[&good[..cut]])).len();
                assert_eq!(
                    samples(&out).len(),
                    complete,
                    "{} cut at {cut}: {out:?}",
                    gauge.name
                );
            }
        }
    }
}

#[test]
fn a_damaged_byte_never_passes_a_check_sum() {
    for gauge in Gauge::all().filter(Gauge::has_check_sum) {
        for packet in gauge.good() {
            let good = packet.bytes();
            for place in 0..good.len() {
                for damage in 1..=255 {
                    let mut bytes = good.clone();
                    bytes[place] ^= damage;
                    assert_eq!(
                        samples(&gauge.decode(&[&bytes])).len(),
                        0,
                        "{} {place}",
                        gauge.name
                    );
                }
            }
        }
    }
}

#[test]
fn silence_is_nothing() {
    for gauge in Gauge::all() {
        assert_eq!(gauge.decode(&[]), []);
        let mut decoder = gauge.decoder();
        let mut out = Vec::new();
        for role in CommandRole::ALL {
            decoder.asked(role);
            decoder.idle(1.0, &mut out);
        }
        assert_eq!(out, []);
    }
}

#[test]
fn text_with_parity_read_as_eight_bits_is_recognised() {
    for gauge in Gauge::all().filter(|gauge| !gauge.has_check_sum()) {
        for packet in gauge.good() {
            let with_parity = packet
                .bytes()
                .into_iter()
                .map(|byte| byte | ((byte.count_ones() as u8 & 1) << 7));
            let bytes: Vec<u8> = with_parity.collect();
            let decoded = gauge.decode(&[&bytes]);
            let told = decoded.iter().any(|one| {
                matches!(one, Decoded::Rejected(rejected) if rejected.reason.contains("7 bit even"))
            });
            assert!(told, "{}: {decoded:?}", gauge.name);
            assert_eq!(samples(&decoded).len(), 0, "{}", gauge.name);
        }
    }
}

#[test]
fn unrequested_values_are_marked() {
    for gauge in Gauge::all() {
        let packet = gauge.good().next().unwrap().bytes();
        let mut decoder = gauge.decoder();
        let mut out = Vec::new();
        decoder.asked(CommandRole::Read);
        for _ in 0..2 {
            decoder.push(&packet, 0.0, &mut out);
            decoder.idle(0.0, &mut out);
        }
        let unrequested: Vec<bool> = samples(&out)
            .iter()
            .map(|sample| sample.marks.contains(&Mark::Unrequested))
            .collect();
        let by_itself = gauge.description.command(CommandRole::Read).is_none();
        assert_eq!(unrequested, [false, !by_itself], "{}", gauge.name);
    }
}

#[test]
fn no_shipped_description_is_from_memory() {
    for gauge in Gauge::all() {
        assert_ne!(
            gauge.description.status,
            DescriptionStatus::Recalled,
            "{}",
            gauge.name
        );
        assert!(!gauge.description.sources.is_empty(), "{}", gauge.name);
    }
}

/// Noise that holds no end mark of a line and no packet's beginning.
fn noise() -> impl Strategy<Value = Vec<u8>> {
    prop::collection::vec(prop_oneof![0x80..=0xFF_u8, Just(0), Just(b'~')], 0..40)
}

proptest! {
    #[test]
    fn any_bytes_are_taken_without_panic_and_however_they_are_cut(
        which in 0..shipped_instruments().len(),
        bytes in prop::collection::vec(prop_oneof![any::<u8>(), prop::sample::select(b"0123456789+-. NR\r\n\x02A".to_vec())], 0..400),
        cut in 0..400_usize,
    ) {
        let gauge = Gauge::named(shipped_instruments()[which].name);
        let (first, second) = bytes.split_at(cut.min(bytes.len()));
        prop_assert_eq!(gauge.decode(&[&bytes]), gauge.decode(&[first, second]));
    }

    #[test]
    fn every_byte_comes_out_in_some_way(which in 0..shipped_instruments().len(), bytes in prop::collection::vec(0x80..=0xFF_u8, 1..300)) {
        let gauge = Gauge::named(shipped_instruments()[which].name);
        let out = gauge.decode(&[&bytes]);
        let raw: usize = out.iter().map(|one| match one {
            Decoded::Rejected(rejected) => rejected.raw.len() / 4,
            _ => 0,
        }).sum();
        prop_assert_eq!(raw, bytes.len());
    }

    #[test]
    fn good_packets_survive_noise_between_them(which in 0..shipped_instruments().len(), noises in prop::collection::vec(noise(), 1..5)) {
        let gauge = Gauge::named(shipped_instruments()[which].name);
        prop_assume!(!gauge.counts_only());
        let good: Vec<Vec<u8>> = gauge.good().map(Packet::bytes).collect();
        let mut bytes = Vec::new();
        let mut expected = Vec::new();
        for (noise, packet) in noises.iter().zip(good.iter().cycle()) {
            bytes.extend_from_slice(noise);
            if gauge.is_lines() {
                // A line is known by its end: noise without one belongs to the line behind it.
                let end = packet.iter().rposition(|byte| !byte.is_ascii_control()).unwrap() + 1;
                bytes.extend_from_slice(&packet[end..]);
            }
            bytes.extend_from_slice(packet);
            expected.extend(samples(&gauge.decode(&[packet])).into_iter().map(|sample| sample.value));
        }
        let decoded = gauge.decode(&[&bytes]);
        let found: Vec<f64> = samples(&decoded).into_iter().map(|sample| sample.value).collect();
        prop_assert_eq!(found, expected);
    }
}

impl Gauge {
    fn is_lines(&self) -> bool {
        self.description.framing_text().starts_with("lines")
    }
}
