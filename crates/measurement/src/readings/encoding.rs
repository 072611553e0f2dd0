//! Bytes to UTF-8 text: byte order marks, UTF-16, and line ends of old spreadsheets.

use std::io::{self, BufRead, Read};

/// How many raw bytes are taken at a time; also the stretch in which line ends are looked at.
const CHUNK_BYTES: usize = 64 * 1024;

/// How the text was encoded, as its first bytes tell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    /// No mark: UTF-8, or at least its ASCII part.
    Plain,
    /// UTF-8 behind a byte order mark.
    Utf8Marked,
    /// UTF-16, low byte first.
    Utf16Le,
    /// UTF-16, high byte first.
    Utf16Be,
}

impl Encoding {
    fn of(start: &[u8]) -> (Self, usize) {
        match start {
            [0xEF, 0xBB, 0xBF, ..] => (Self::Utf8Marked, 3),
            [0xFF, 0xFE, ..] => (Self::Utf16Le, 2),
            [0xFE, 0xFF, ..] => (Self::Utf16Be, 2),
            _ => (Self::Plain, 0),
        }
    }
}

/// A source of UTF-8 text over any input.
///
/// UTF-16 that is not well formed ends in an error of kind `InvalidData`.
pub(super) struct Decoded<R> {
    input: R,
    encoding: Encoding,
    lone_carriage_return: bool,
    raw: Vec<u8>,
    ready: Vec<u8>,
    position: usize,
}

impl<R: Read> Decoded<R> {
    pub(super) fn new(input: R) -> io::Result<Self> {
        let mut decoded = Self {
            input,
            encoding: Encoding::Plain,
            lone_carriage_return: false,
            raw: Vec::new(),
            ready: Vec::new(),
            position: 0,
        };
        decoded.read_chunk()?;
        let (encoding, mark) = Encoding::of(&decoded.raw);
        decoded.encoding = encoding;
        decoded.raw.drain(..mark);
        decoded.decode()?;
        decoded.lone_carriage_return =
            decoded.ready.contains(&b'\r') && !decoded.ready.contains(&b'\n');
        decoded.mend_line_ends();
        Ok(decoded)
    }

    pub(super) fn encoding(&self) -> Encoding {
        self.encoding
    }

    /// Whether lines end with a carriage return alone, as spreadsheets once wrote them on one kind of machine.
    pub(super) fn lone_carriage_return(&self) -> bool {
        self.lone_carriage_return
    }

    /// Appends input to `raw` until a chunk is full or the input ends; gives how many bytes came.
    fn read_chunk(&mut self) -> io::Result<usize> {
        let limit = (CHUNK_BYTES - self.raw.len()) as u64;
        self.input.by_ref().take(limit).read_to_end(&mut self.raw)
    }

    fn decode(&mut self) -> io::Result<()> {
        self.position = 0;
        self.ready.clear();
        let to_unit: fn([u8; 2]) -> u16 = match self.encoding {
            Encoding::Plain | Encoding::Utf8Marked => {
                std::mem::swap(&mut self.raw, &mut self.ready);
                return Ok(());
            }
            Encoding::Utf16Le => u16::from_le_bytes,
            Encoding::Utf16Be => u16::from_be_bytes,
        };
        let mut used = self.raw.len() / 2 * 2;
        // A pair of surrogates may be cut by the end of the chunk: its first half waits for the next one.
        if used >= 2 {
            let last = to_unit([self.raw[used - 2], self.raw[used - 1]]);
            if (0xD800..0xDC00).contains(&last) {
                used -= 2;
            }
        }
        let units = self.raw[..used]
            .chunks_exact(2)
            .map(|pair| to_unit([pair[0], pair[1]]));
        let mut utf8 = [0; 4];
        for character in char::decode_utf16(units) {
            let character =
                character.map_err(|error| io::Error::new(io::ErrorKind::InvalidData, error))?;
            self.ready
                .extend_from_slice(character.encode_utf8(&mut utf8).as_bytes());
        }
        self.raw.drain(..used);
        Ok(())
    }

    fn mend_line_ends(&mut self) {
        if self.lone_carriage_return {
            for byte in &mut self.ready {
                if *byte == b'\r' {
                    *byte = b'\n';
                }
            }
        }
    }
}

impl<R: Read> BufRead for Decoded<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.position >= self.ready.len() {
            let got = self.read_chunk()?;
            if got == 0 && !self.raw.is_empty() {
                return Err(io::Error::new(
                    io::ErrorKind::InvalidData,
                    "UTF-16 text with half a character at its end",
                ));
            }
            self.decode()?;
            self.mend_line_ends();
        }
        Ok(&self.ready[self.position..])
    }

    fn consume(&mut self, amount: usize) {
        self.position = (self.position + amount).min(self.ready.len());
    }
}

impl<R: Read> Read for Decoded<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let ready = self.fill_buf()?;
        let amount = ready.len().min(buffer.len());
        buffer[..amount].copy_from_slice(&ready[..amount]);
        self.consume(amount);
        Ok(amount)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn text(bytes: &[u8]) -> io::Result<String> {
        let mut text = String::new();
        Decoded::new(bytes)?.read_to_string(&mut text)?;
        Ok(text)
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
        assert_eq!(text(b"\xEF\xBB\xBFpose").unwrap(), "pose");
        assert_eq!(text(&utf16("µm;𝄞", false)).unwrap(), "µm;𝄞");
        assert_eq!(text(&utf16("µm;𝄞", true)).unwrap(), "µm;𝄞");
        assert_eq!(text(b"").unwrap(), "");
    }

    #[test]
    fn characters_cut_by_a_chunk_survive() {
        for shift in 0..3 {
            let long = "a".repeat(CHUNK_BYTES / 2 - 2 + shift) + "𝄞𝄞 end";
            assert_eq!(text(&utf16(&long, false)).unwrap(), long);
        }
    }

    #[test]
    fn broken_utf16_is_an_error() {
        let mut bytes = utf16("abc", false);
        bytes.pop();
        assert_eq!(text(&bytes).unwrap_err().kind(), io::ErrorKind::InvalidData);
        let lone = [0xFF, 0xFE, 0x00, 0xD8, b'a', 0];
        assert_eq!(text(&lone).unwrap_err().kind(), io::ErrorKind::InvalidData);
    }

    #[test]
    fn carriage_returns_alone_become_line_ends() {
        assert_eq!(text(b"a\rb\r").unwrap(), "a\nb\n");
        assert_eq!(text(b"a\r\nb\r").unwrap(), "a\r\nb\r");
    }
}
