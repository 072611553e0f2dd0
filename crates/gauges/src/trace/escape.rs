//! Bytes as printable text, and back.

use std::fmt::Write;

/// Bytes as text: printable ASCII as it is, `\\`, `\r`, `\n`, `\t`, all else as `\xNN`; a blank at either end too, where an editor could lose it.
#[must_use]
pub fn escaped(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len() + 8);
    for (place, byte) in bytes.iter().enumerate() {
        let at_end = place == 0 || place + 1 == bytes.len();
        match byte {
            b'\\' => text.push_str("\\\\"),
            b'\r' => text.push_str("\\r"),
            b'\n' => text.push_str("\\n"),
            b'\t' => text.push_str("\\t"),
            b' ' if !at_end => text.push(' '),
            0x21..=0x7e => text.push(char::from(*byte)),
            // Writing to a string cannot fail.
            _ => {
                let _ = write!(text, "\\x{byte:02X}");
            }
        }
    }
    text
}

/// The bytes of such a text; `None` if it is none.
#[must_use]
pub fn unescaped(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((first, behind)) = rest.split_first() {
        rest = behind;
        match first {
            b'\\' => {
                let (kind, behind) = rest.split_first()?;
                rest = behind;
                bytes.push(match kind {
                    b'\\' => b'\\',
                    b'r' => b'\r',
                    b'n' => b'\n',
                    b't' => b'\t',
                    b'x' => {
                        let digits = rest.split_at_checked(2)?;
                        rest = digits.1;
                        let digits = std::str::from_utf8(digits.0).ok()?;
                        // `from_str_radix` takes a sign, a byte has none.
                        if !digits.bytes().all(|digit| digit.is_ascii_hexdigit()) {
                            return None;
                        }
                        u8::from_str_radix(digits, 16).ok()?
                    }
                    _ => return None,
                });
            }
            0x20..=0x7e => bytes.push(*first),
            _ => return None,
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn bytes_are_shown_as_people_write_them() {
        assert_eq!(escaped(b"4.285 N\r\n"), "4.285 N\\r\\n");
        assert_eq!(escaped(b" +1 \\\x00\xff"), "\\x20+1 \\\\\\x00\\xFF");
        for bad in ["\\", "\\q", "\\x4", "\\x+1", "µ", "\\xZZ", "a\tb"] {
            assert_eq!(unescaped(bad), None, "{bad}");
        }
    }

    proptest! {
        #[test]
        fn every_byte_comes_back(bytes: Vec<u8>) {
            let text = escaped(&bytes);
            prop_assert!(text.bytes().all(|byte| (0x20..0x7f).contains(&byte)));
            prop_assert_eq!(unescaped(&text), Some(bytes));
        }
    }
}
