//! Unit tests of the decoder with the shipped descriptions.

use crate::instrument::sample::Sample;
use crate::instrument::shipped_instrument;

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

#[test]
fn all_parse() {
    for shipped in crate::instrument::shipped_instruments() {
        let parsed = InstrumentDescription::parse(shipped.text, shipped.name);
        match parsed {
            Ok((description, warnings)) => {
                assert_eq!(description.name, shipped.name);
                assert!(warnings.is_empty(), "{warnings:?}");
            }
            Err(e) => panic!("{e}"),
        }
    }
}
