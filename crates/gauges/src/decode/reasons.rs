//! Why bytes are no sample, in words that help at the bench.

use crate::InstrumentDescription;
use crate::framing::FragmentKind;

/// Bytes that are part of no packet.
pub(super) fn no_packet(
    kind: FragmentKind,
    bytes: &[u8],
    description: &InstrumentDescription,
) -> String {
    if is_seven_bit_even(bytes) {
        return seven_bit_even();
    }
    let name = &description.name;
    match kind {
        FragmentKind::Packet | FragmentKind::Tail | FragmentKind::Skipped => {
            format!("bytes between packets: no packet of {name} begins here")
        }
        FragmentKind::Cut => {
            format!("the packet of {name} stopped in the middle; its rest did not arrive in time")
        }
        FragmentKind::TooLong => {
            format!(
                "more bytes than any packet of {name} without its end: another gauge, or other line settings"
            )
        }
        FragmentKind::Uneven => format!(
            "bytes were lost or added: {} arrived together, and packets of {name} are recognised by their length alone",
            bytes.len()
        ),
    }
}

/// A packet that no pattern covers.
pub(super) fn unknown_packet(bytes: &[u8], description: &InstrumentDescription) -> String {
    if is_seven_bit_even(bytes) {
        return seven_bit_even();
    }
    let name = &description.name;
    if let Some([sent, own]) = description.wrong_sum(bytes) {
        format!(
            "the check sum is {sent:X}, and that of the bytes is {own:X} (hexadecimal): the packet was damaged on the line, or check_sum is not that of {name}"
        )
    } else if with_point(bytes).is_some_and(|packet| description.covers_value(&packet)) {
        format!("a decimal comma: set `comma = true` for the number in the description of {name}")
    } else if bytes.iter().all(|byte| matches!(byte, 0x20..=0x7e)) {
        format!("not a packet of {name}: garbled, or from another gauge")
    } else {
        format!(
            "not a packet of {name}: bytes that are not text, from a garbled line or other line settings"
        )
    }
}

/// The same with a point for its only comma between digits.
fn with_point(bytes: &[u8]) -> Option<Vec<u8>> {
    let is_decimal =
        |three: &[u8]| three[1] == b',' && three[0].is_ascii_digit() && three[2].is_ascii_digit();
    let mut places =
        (0..bytes.len().saturating_sub(2)).filter(|at| is_decimal(&bytes[*at..at + 3]));
    let place = places.next()? + 1;
    let mut pointed = bytes.to_vec();
    pointed[place] = b'.';
    places.next().is_none().then_some(pointed)
}

/// A line whose beginning may be lost, and that could be part of a longer number.
pub(super) fn lost_beginning() -> String {
    "the rest of a packet whose beginning is lost".to_owned()
}

/// Bytes before a packet that begins with a mark.
pub(super) fn noise_before_packet() -> String {
    "noise before a packet".to_owned()
}

fn seven_bit_even() -> String {
    "the line is 7 bit even, read as 8 bit: set 7 data bits and even parity".to_owned()
}

/// Whether text with an even parity bit was read as 8 bits: with the top bit the number of ones is even in every byte.
///
/// Of bytes drawn at random one in 2^n passes, so fewer than four carry no information.
pub(super) fn is_seven_bit_even(bytes: &[u8]) -> bool {
    let text = |byte: &u8| matches!(byte & 0x7F, 0x20..=0x7E | b'\r' | b'\n' | b'\t' | 2 | 3);
    bytes.len() >= 4
        && bytes.iter().any(|byte| byte & 0x80 != 0)
        && bytes
            .iter()
            .all(|byte| byte.count_ones().is_multiple_of(2) && text(byte))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_with_a_parity_bit_is_recognised() {
        let with_parity = |text: &str| -> Vec<u8> {
            let byte = |byte: u8| byte | ((byte.count_ones() as u8 & 1) << 7);
            text.bytes().map(byte).collect()
        };
        assert_eq!(with_parity("+1"), [0x2B, 0xB1]);
        assert!(is_seven_bit_even(&with_parity("+012.345\r")));
        assert!(!is_seven_bit_even(b"+012.345\r"));
        assert!(!is_seven_bit_even(&with_parity("+1")));
        assert!(!is_seven_bit_even(&[0xFF, 0x00, 0xFF, 0x00]));
    }
}
