//! Bytes to text.

use std::borrow::Cow;

use encoding_rs::{Encoding, UTF_16BE, UTF_16LE, WINDOWS_1252};

use super::error::{LinePlace, TableFileError};
use super::layout::TextEncoding;

/// How much of a file decides whether it is UTF-16 without a mark.
const LOOKED_AT: usize = 4096;

/// The text of a file, and how it was encoded.
///
/// # Errors
/// [`TableFileError::NotText`] for bytes that no encoding makes text of.
pub(super) fn decode<'a>(
    file: &str,
    bytes: &'a [u8],
) -> Result<(Cow<'a, str>, TextEncoding), TableFileError> {
    let (text, encoding) = match bytes {
        [0xEF, 0xBB, 0xBF, rest @ ..] => (eight_bits(rest).0, TextEncoding::Utf8Marked),
        [0xFF, 0xFE, rest @ ..] => (of(UTF_16LE, rest), TextEncoding::Utf16),
        [0xFE, 0xFF, rest @ ..] => (of(UTF_16BE, rest), TextEncoding::Utf16),
        _ => match unmarked_utf16(bytes) {
            Some(encoding) => (of(encoding, bytes), TextEncoding::Utf16),
            None => eight_bits(bytes),
        },
    };
    let wrong = |place: usize| TableFileError::NotText {
        at: LinePlace::new(file, text[..place].matches('\n').count() as u32 + 1),
    };
    let broken = (encoding == TextEncoding::Utf16)
        .then(|| text.find('\u{fffd}'))
        .flatten();
    match text.find('\0').or(broken) {
        Some(place) => Err(wrong(place)),
        None => Ok((text, encoding)),
    }
}

fn of<'a>(encoding: &'static Encoding, bytes: &'a [u8]) -> Cow<'a, str> {
    encoding.decode_without_bom_handling(bytes).0
}

/// UTF-8 if it is, else the code page of Windows for western Europe.
fn eight_bits(bytes: &[u8]) -> (Cow<'_, str>, TextEncoding) {
    match std::str::from_utf8(bytes) {
        Ok(text) => (text.into(), TextEncoding::Utf8),
        Err(_) => (of(WINDOWS_1252, bytes), TextEncoding::Windows1252),
    }
}

/// Text in UTF-16 whose characters are mostly of the first block has a zero in nearly every second byte.
fn unmarked_utf16(bytes: &[u8]) -> Option<&'static Encoding> {
    let start = &bytes[..bytes.len().min(LOOKED_AT)];
    if start.len() < 4 {
        return None;
    }
    let zeros = |odd: usize| {
        start
            .iter()
            .skip(odd)
            .step_by(2)
            .filter(|b| **b == 0)
            .count()
    };
    let (high, low) = (zeros(0), zeros(1));
    let most = start.len() / 2 * 3 / 4;
    if low > most && high == 0 {
        Some(UTF_16LE)
    } else if high > most && low == 0 {
        Some(UTF_16BE)
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(bytes: &[u8]) -> (String, TextEncoding) {
        let (text, encoding) = decode("t", bytes).unwrap();
        (text.into_owned(), encoding)
    }

    #[test]
    fn encodings_are_recognised() {
        let expected = "Weg [µm]; Kraft\n1;2\n";
        assert_eq!(
            text(expected.as_bytes()),
            (expected.into(), TextEncoding::Utf8)
        );
        let marked = [b"\xEF\xBB\xBF", expected.as_bytes()].concat();
        assert_eq!(text(&marked), (expected.into(), TextEncoding::Utf8Marked));
        let western: Vec<u8> = expected.chars().map(|c| c as u8).collect();
        assert_eq!(text(&western), (expected.into(), TextEncoding::Windows1252));
        for (order, mark) in [
            (u16::to_le_bytes as fn(u16) -> [u8; 2], [0xFF, 0xFE]),
            (u16::to_be_bytes, [0xFE, 0xFF]),
        ] {
            let wide: Vec<u8> = expected.encode_utf16().flat_map(order).collect();
            assert_eq!(text(&wide), (expected.into(), TextEncoding::Utf16));
            let marked = [&mark[..], &wide].concat();
            assert_eq!(text(&marked), (expected.into(), TextEncoding::Utf16));
        }
        // 0x80 is the euro sign there and nothing in ISO 8859-1.
        assert_eq!(text(b"\x80 5").0, "€ 5");
    }

    #[test]
    fn what_is_no_text_is_refused_with_its_line() {
        for broken in [&b"F\nd\0\n"[..], b"\xFF\xFEa\0\n\0\x00\xD8b\0"] {
            let error = decode("t", broken).unwrap_err();
            assert!(error.to_string().contains("line 2"), "{error}");
        }
    }
}
