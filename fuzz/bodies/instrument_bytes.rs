//! Any bytes from a gauge, whose description and whose cuts the first bytes choose: no panic, and the same samples however the bytes are cut.
use std::sync::LazyLock;

use stiffbench::instrument::{CommandRole, Decoded, Decoder, InstrumentDescription};
use stiffbench::shipped::shipped_instruments;

/// The shipped descriptions, read once.
static DESCRIPTIONS: LazyLock<Vec<InstrumentDescription>> = LazyLock::new(|| {
    let shipped = shipped_instruments().iter();
    let parsed = shipped.map(|shipped| InstrumentDescription::parse(shipped.text, shipped.name));
    parsed.map(|parsed| parsed.expect("shipped").0).collect()
});

/// What comes of bytes in pieces of one length, followed by silence.
fn decode(
    description: &InstrumentDescription,
    role: CommandRole,
    bytes: &[u8],
    length: usize,
) -> Vec<Decoded> {
    let unit = description.unit_choices().first().map(ToString::to_string);
    let mut decoder = Decoder::new(description, unit.as_deref()).expect("its own unit");
    let mut out = Vec::new();
    decoder.asked(role);
    for piece in bytes.chunks(length) {
        decoder.push(piece, 0.0, &mut out);
    }
    decoder.idle(0.0, &mut out);
    out
}

/// Tries some bytes.
pub(crate) fn run(bytes: &[u8]) {
    let [which, role, length, bytes @ ..] = bytes else {
        return;
    };
    let description = &DESCRIPTIONS[usize::from(*which) % DESCRIPTIONS.len()];
    let role = CommandRole::ALL[usize::from(*role) % CommandRole::ALL.len()];
    let whole = decode(description, role, bytes, bytes.len().max(1));
    assert_eq!(
        decode(description, role, bytes, usize::from(*length).max(1)),
        whole
    );
    for one in whole {
        if let Decoded::Sample(sample) = one {
            assert!(
                sample.value_si.is_finite() && sample.resolution_si > 0.0 && !sample.raw.is_empty()
            );
        }
    }
}
