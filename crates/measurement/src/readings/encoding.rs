//! Bytes to UTF-8 text: byte order marks, UTF-16, and line ends of old spreadsheets.

use std::io::{self, BufRead, BufReader, Cursor, Read};

use encoding_rs_io::DecodeReaderBytesBuilder;

/// The stretch of text in which line ends are checked.
const CHUNK_BYTES: u64 = 64 * 1024;

/// How the text was encoded, by its first bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    /// No mark: UTF-8, or at least its ASCII part.
    Plain,
    /// UTF-8 behind a byte order mark.
    Utf8Marked,
    /// UTF-16 behind a byte order mark. What is not well formed in it becomes U+FFFD.
    Utf16,
}

/// Whether the bytes are a spreadsheet: a ZIP archive, or the container of old office programs.
pub(crate) fn is_spreadsheet(bytes: &[u8]) -> bool {
    bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(&[0xD0, 0xCF, 0x11, 0xE0])
}

/// A source of UTF-8 text over any input; without a byte order mark the bytes are left alone.
pub(super) struct Utf8Source<'a> {
    text: BufReader<Box<dyn Read + 'a>>,
    pub(super) encoding: Encoding,
    /// Whether the bytes are no text but a spreadsheet.
    pub(super) is_spreadsheet: bool,
    /// Whether lines end with a carriage return alone, as spreadsheets once wrote them on one kind of machine.
    pub(super) lone_carriage_return: bool,
}

impl<'a> Utf8Source<'a> {
    pub(super) fn new(input: impl Read + 'a) -> io::Result<Self> {
        let mut input = BufReader::new(input);
        let mut mark = Vec::new();
        input.by_ref().take(4).read_to_end(&mut mark)?;
        let is_spreadsheet = is_spreadsheet(&mark);
        let encoding = match mark[..] {
            [0xEF, 0xBB, 0xBF, ..] => Encoding::Utf8Marked,
            [0xFF, 0xFE, ..] | [0xFE, 0xFF, ..] => Encoding::Utf16,
            _ => Encoding::Plain,
        };
        let mut text = DecodeReaderBytesBuilder::new()
            .utf8_passthru(true)
            .strip_bom(true)
            .build(Cursor::new(mark).chain(input));
        let mut start = Vec::new();
        text.by_ref().take(CHUNK_BYTES).read_to_end(&mut start)?;
        let lone_carriage_return = start.contains(&b'\r') && !start.contains(&b'\n');
        Ok(Self {
            text: BufReader::new(Box::new(Cursor::new(start).chain(text))),
            encoding,
            is_spreadsheet,
            lone_carriage_return,
        })
    }

    /// Appends a line with its end, which becomes `\n` where it is a carriage return; gives how many bytes came.
    pub(super) fn read_line(&mut self, line: &mut Vec<u8>) -> io::Result<usize> {
        if !self.lone_carriage_return {
            return self.text.read_until(b'\n', line);
        }
        let mut taken = 0;
        loop {
            let ready = self.text.fill_buf()?;
            let end = ready.iter().position(|byte| b"\r\n".contains(byte));
            let used = end.map_or(ready.len(), |end| end + 1);
            line.extend_from_slice(&ready[..used]);
            self.text.consume(used);
            taken += used;
            if let (Some(_), Some(last)) = (end, line.last_mut()) {
                *last = b'\n';
            }
            if end.is_some() || used == 0 {
                return Ok(taken);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(bytes: &[u8]) -> String {
        let mut decoded = Utf8Source::new(bytes).unwrap();
        let mut text = Vec::new();
        while decoded.read_line(&mut text).unwrap() > 0 {}
        String::from_utf8(text).unwrap()
    }

    fn utf16(text: &str, big: bool) -> Vec<u8> {
        let order = if big {
            u16::to_be_bytes
        } else {
            u16::to_le_bytes
        };
        std::iter::once(0xFEFF)
            .chain(text.encode_utf16())
            .flat_map(order)
            .collect()
    }

    #[test]
    fn marks_are_taken_off() {
        assert_eq!(text(b"\xEF\xBB\xBFpose"), "pose");
        assert_eq!(text(&utf16("µm;𝄞", false)), "µm;𝄞");
        assert_eq!(text(&utf16("µm;𝄞", true)), "µm;𝄞");
        assert_eq!(text(b""), "");
    }

    #[test]
    fn characters_cut_by_a_chunk_survive() {
        for shift in 0..3 {
            let long = "a".repeat(32 * 1024 - 2 + shift) + "𝄞𝄞 end";
            assert_eq!(text(&utf16(&long, false)), long);
        }
    }

    #[test]
    fn carriage_returns_alone_become_line_ends() {
        assert_eq!(text(b"a\rb\r"), "a\nb\n");
        assert_eq!(text(b"a\r\nb\r"), "a\r\nb\r");
    }
}
