//! How packets are distinguished in a stream of bytes.
//!
//! Works byte by byte, so that what comes out does not depend on how the bytes were cut. Bytes that belong to no packet come out too.

use std::fmt;

use super::registers;

/// How the packets of a gauge are distinguished.
#[derive(Debug, Clone)]
pub(super) struct Framing {
    pub(super) kind: FramingKind,
    /// Silence that ends a packet, or after which its rest does not come any more, s.
    pub(super) idle_s: f64,
}

/// What marks a packet.
#[derive(Debug, Clone)]
pub(super) enum FramingKind {
    /// An end mark; some replies come without it and are known by their bytes.
    Line {
        ends: Vec<Vec<u8>>,
        longest: usize,
        bare: Vec<Vec<u8>>,
    },
    /// Its length, and silence.
    Fixed { length: usize },
    /// Its first bytes, and its length.
    Start { mark: Vec<u8>, length: usize },
    /// Silence.
    Idle { longest: usize },
    /// The head of a Modbus reply, and its check sum.
    Modbus {
        slave: u8,
        function: u8,
        data_bytes: usize,
    },
}

impl Framing {
    /// A packet with its end mark, if it has one.
    pub(super) fn ended(&self, mut packet: Vec<u8>) -> Vec<u8> {
        if let FramingKind::Line { ends, bare, .. } = &self.kind
            && !bare.contains(&packet)
        {
            packet.extend(ends.first().into_iter().flatten());
        }
        packet
    }
}

impl fmt::Display for Framing {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.kind {
            FramingKind::Line { ends, .. } => {
                let ends: Vec<String> = ends
                    .iter()
                    .map(|end| end.escape_ascii().to_string())
                    .collect();
                write!(f, "lines that end with {}", ends.join(" or "))
            }
            FramingKind::Fixed { length } => {
                write!(f, "packets of {length} bytes without any mark")
            }
            FramingKind::Start { length, .. } => {
                write!(f, "packets of {length} bytes behind a start mark")
            }
            FramingKind::Idle { .. } => f.write_str("packets that end by silence"),
            FramingKind::Modbus { slave, .. } => write!(f, "Modbus RTU, address {slave}"),
        }
    }
}

/// Bytes with the time of the last.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Fragment {
    pub(super) bytes: Vec<u8>,
    pub(super) at_s: f64,
    /// The first of them among all bytes that came, and the one behind the last, end mark included.
    pub(super) place: [u64; 2],
    pub(super) kind: FragmentKind,
}

/// What bytes are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum FragmentKind {
    /// A packet with known beginning, without its end mark.
    Packet,
    /// A line whose beginning may be lost.
    Tail,
    /// Bytes before the next packet.
    Skipped,
    /// A packet that stopped in the middle.
    Cut,
    /// More bytes than any packet has.
    TooLong,
    /// A burst whose length is no multiple of a packet's.
    Uneven,
}

/// Most packets of fixed length that are taken without a silence between them.
const BURST_PACKETS: usize = 64;

/// Most skipped bytes that are kept for one report.
const SKIPPED: usize = 128;

/// Bytes that wait, with the time of each.
#[derive(Debug, Clone, Default)]
struct Waiting {
    bytes: Vec<u8>,
    times_s: Vec<f64>,
    /// How many bytes came up to the last that waits.
    came: u64,
}

impl Waiting {
    fn push(&mut self, byte: u8, at_s: f64) {
        self.bytes.push(byte);
        self.times_s.push(at_s);
        self.came += 1;
    }

    fn len(&self) -> usize {
        self.bytes.len()
    }

    /// Takes the first `count` bytes out as a piece; the last `without` of them are left out of it.
    fn take(&mut self, count: usize, without: usize, kind: FragmentKind) -> Fragment {
        let first = self.came - self.bytes.len() as u64;
        let mut bytes: Vec<u8> = self.bytes.drain(..count).collect();
        bytes.truncate(count - without);
        let at_s = self.times_s.drain(..count).next_back().unwrap_or_default();
        Fragment {
            bytes,
            at_s,
            place: [first, first + count as u64],
            kind,
        }
    }

    fn clear(&mut self) {
        self.bytes.clear();
        self.times_s.clear();
    }
}

/// Separates packets.
#[derive(Debug, Clone)]
pub(super) struct Framer {
    framing: FramingKind,
    waiting: Waiting,
    skipped: Waiting,
    /// The next byte begins a packet, or ends up in one whose beginning was seen.
    in_step: bool,
}

impl Framer {
    pub(super) fn new(framing: &Framing) -> Self {
        Self {
            framing: framing.kind.clone(),
            waiting: Waiting::default(),
            skipped: Waiting::default(),
            in_step: true,
        }
    }

    /// So many bytes came before the first.
    pub(super) fn begin_behind(&mut self, came: u64) {
        self.waiting.came = came;
    }

    /// Forgets what waits; the next byte begins a packet.
    pub(super) fn reset(&mut self) {
        self.waiting.clear();
        self.skipped.clear();
        self.in_step = true;
    }

    /// Takes one byte; `fits` decides whether bytes of full length are a packet.
    pub(super) fn push(
        &mut self,
        byte: u8,
        at_s: f64,
        fits: &dyn Fn(&[u8]) -> bool,
        out: &mut Vec<Fragment>,
    ) {
        self.waiting.push(byte, at_s);
        match &self.framing {
            FramingKind::Line { .. } => self.line(out),
            FramingKind::Fixed { length } => {
                let length = *length;
                if self.waiting.len() >= length * BURST_PACKETS {
                    let whole = self.waiting.bytes.chunks(length).all(fits);
                    self.burst(length, whole, out);
                }
            }
            FramingKind::Idle { longest } => {
                if self.waiting.len() > *longest {
                    let count = self.waiting.len();
                    out.push(self.waiting.take(count, 0, FragmentKind::TooLong));
                    self.in_step = false;
                }
            }
            FramingKind::Start { .. } | FramingKind::Modbus { .. } => self.scan(fits, false, out),
        }
    }

    /// Nothing came for the idle gap.
    pub(super) fn idle(&mut self, fits: &dyn Fn(&[u8]) -> bool, out: &mut Vec<Fragment>) {
        let count = self.waiting.len();
        match &self.framing {
            FramingKind::Line { .. } if count > 0 => {
                out.push(self.waiting.take(count, 0, FragmentKind::Cut));
                // The rest may still come, and would look like a packet.
                self.in_step = false;
            }
            FramingKind::Fixed { length } => {
                let length = *length;
                if count > 0 {
                    self.burst(length, count.is_multiple_of(length), out);
                }
                self.in_step = true;
            }
            FramingKind::Idle { .. } => {
                if count > 0 {
                    let kind = if self.in_step {
                        FragmentKind::Packet
                    } else {
                        FragmentKind::TooLong
                    };
                    out.push(self.waiting.take(count, 0, kind));
                }
                self.in_step = true;
            }
            FramingKind::Start { .. } | FramingKind::Modbus { .. } => {
                self.scan(fits, true, out);
                self.flush_skipped(out);
            }
            FramingKind::Line { .. } => {}
        }
    }

    /// A line is complete, a reply without end mark is, or there are more bytes than any line has.
    fn line(&mut self, out: &mut Vec<Fragment>) {
        let FramingKind::Line {
            ends,
            longest,
            bare,
        } = &self.framing
        else {
            return;
        };
        let count = self.waiting.len();
        let longest = longest + ends.iter().map(Vec::len).max().unwrap_or_default();
        let bytes = &self.waiting.bytes;
        if self.in_step && bare.contains(bytes) {
            out.push(self.waiting.take(count, 0, FragmentKind::Packet));
        } else if let Some(end) = ends.iter().find(|end| bytes.ends_with(end)) {
            let end = end.len();
            let kind = if self.in_step {
                FragmentKind::Packet
            } else {
                FragmentKind::Tail
            };
            let piece = self.waiting.take(count, end, kind);
            // Nothing between two end marks is no packet.
            if !piece.bytes.is_empty() {
                out.push(piece);
            }
            self.in_step = true;
        } else if count > longest {
            out.push(self.waiting.take(count, 0, FragmentKind::TooLong));
            self.in_step = false;
        }
    }

    /// Packets of one length that came together; after a byte lost or too much there is no telling where the next begins.
    fn burst(&mut self, length: usize, whole: bool, out: &mut Vec<Fragment>) {
        let count = self.waiting.len();
        if whole && self.in_step {
            for _ in 0..count / length {
                out.push(self.waiting.take(length, 0, FragmentKind::Packet));
            }
        } else {
            out.push(self.waiting.take(count, 0, FragmentKind::Uneven));
            self.in_step = false;
        }
    }

    /// Packets that are known by their beginning: slides by one byte until one fits.
    fn scan(&mut self, fits: &dyn Fn(&[u8]) -> bool, at_rest: bool, out: &mut Vec<Fragment>) {
        while self.waiting.len() > 0 {
            match self.head() {
                PacketStart::Length(length)
                    if self.waiting.len() >= length && fits(&self.waiting.bytes[..length]) =>
                {
                    self.flush_skipped(out);
                    out.push(self.waiting.take(length, 0, FragmentKind::Packet));
                    continue;
                }
                PacketStart::Length(length) if self.waiting.len() < length && !at_rest => return,
                PacketStart::Short if !at_rest => return,
                _ => {}
            }
            let piece = self.waiting.take(1, 0, FragmentKind::Skipped);
            self.skipped.push(piece.bytes[0], piece.at_s);
            if self.skipped.len() >= SKIPPED {
                self.flush_skipped(out);
            }
        }
    }

    fn flush_skipped(&mut self, out: &mut Vec<Fragment>) {
        let count = self.skipped.len();
        if count > 0 {
            out.push(self.skipped.take(count, 0, FragmentKind::Skipped));
        }
    }

    /// What the waiting bytes begin with.
    fn head(&self) -> PacketStart {
        let bytes = &self.waiting.bytes[..];
        match &self.framing {
            FramingKind::Start { mark, length } => {
                let seen = bytes.len().min(mark.len());
                match bytes[..seen] == mark[..seen] {
                    true if seen == mark.len() => PacketStart::Length(*length),
                    true => PacketStart::Short,
                    false => PacketStart::None,
                }
            }
            FramingKind::Modbus {
                slave,
                function,
                data_bytes,
            } => match bytes {
                [first, ..] if first != slave => PacketStart::None,
                [_] => PacketStart::Short,
                [_, second, ..] if *second == function | 0x80 => PacketStart::Length(5),
                [_, second, ..] if second != function => PacketStart::None,
                [_, _] => PacketStart::Short,
                [_, _, count, ..] if usize::from(*count) == *data_bytes => {
                    PacketStart::Length(data_bytes + 5)
                }
                _ => PacketStart::None,
            },
            _ => PacketStart::None,
        }
    }
}

/// What bytes begin with.
enum PacketStart {
    /// No packet.
    None,
    /// Too few bytes to decide.
    Short,
    /// A packet of this length.
    Length(usize),
}

/// Whether an intact Modbus packet stands here.
pub(super) fn fits_modbus(packet: &[u8]) -> bool {
    registers::is_intact(packet)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The pieces of bytes, with a silence at each `None`.
    fn pieces(kind: FramingKind, bytes: &[Option<u8>]) -> Vec<(FragmentKind, String)> {
        let mut framer = Framer::new(&Framing { kind, idle_s: 0.1 });
        let mut out = Vec::new();
        let fits = |packet: &[u8]| packet.ends_with(b"!");
        for (place, byte) in bytes.iter().enumerate() {
            match byte {
                Some(byte) => framer.push(*byte, place as f64, &fits, &mut out),
                None => framer.idle(&fits, &mut out),
            }
        }
        let text = |piece: Fragment| (piece.kind, piece.bytes.escape_ascii().to_string());
        out.into_iter().map(text).collect()
    }

    /// Text with `|` for silence.
    fn timed(text: &str) -> Vec<Option<u8>> {
        text.bytes()
            .map(|byte| (byte != b'|').then_some(byte))
            .collect()
    }

    fn expect(kind: FramingKind, text: &str, expected: &[(FragmentKind, &str)]) {
        let found = pieces(kind, &timed(text));
        let found: Vec<(FragmentKind, &str)> = found
            .iter()
            .map(|(kind, text)| (*kind, text.as_str()))
            .collect();
        assert_eq!(found, expected, "{text}");
    }

    use FragmentKind::{Cut, Packet, Skipped, Tail, TooLong, Uneven};

    #[test]
    fn lines_end_where_their_mark_stands_and_are_in_step_from_there() {
        let lines = || FramingKind::Line {
            ends: vec![b";;".to_vec()],
            longest: 5,
            bare: vec![b"K!".to_vec()],
        };
        expect(lines(), "ab;;c;;", &[(Packet, "ab"), (Packet, "c")]);
        expect(lines(), ";;a;b;;", &[(Packet, "a;b")]);
        expect(
            lines(),
            "ab|c;;d;;",
            &[(Cut, "ab"), (Tail, "c"), (Packet, "d")],
        );
        expect(lines(), "abcde;;", &[(Packet, "abcde")]);
        expect(
            lines(),
            "abcdefgh;;i;;",
            &[(TooLong, "abcdefgh"), (Packet, "i")],
        );
        expect(
            lines(),
            "abcdefghi;;j;;",
            &[(TooLong, "abcdefgh"), (Tail, "i"), (Packet, "j")],
        );
        expect(
            lines(),
            "K!a;;K;;",
            &[(Packet, "K!"), (Packet, "a"), (Packet, "K")],
        );
    }

    #[test]
    fn packets_of_one_length_are_whole_between_silences() {
        let fixed = || FramingKind::Fixed { length: 2 };
        expect(
            fixed(),
            "ab|cdef|",
            &[(Packet, "ab"), (Packet, "cd"), (Packet, "ef")],
        );
        expect(fixed(), "abc|de|", &[(Uneven, "abc"), (Packet, "de")]);
        expect(fixed(), "|ab", &[]);
    }

    #[test]
    fn packets_that_end_by_silence_end_there() {
        let idle = || FramingKind::Idle { longest: 3 };
        expect(idle(), "ab|c|", &[(Packet, "ab"), (Packet, "c")]);
        expect(
            idle(),
            "abcdef|g|",
            &[(TooLong, "abcd"), (TooLong, "ef"), (Packet, "g")],
        );
    }

    #[test]
    fn packets_with_a_start_mark_are_found_by_sliding() {
        let start = || FramingKind::Start {
            mark: b"<<".to_vec(),
            length: 4,
        };
        expect(start(), "<<a!<<b!", &[(Packet, "<<a!"), (Packet, "<<b!")]);
        expect(start(), "<x<<<a!", &[(Skipped, "<x<"), (Packet, "<<a!")]);
        expect(start(), "<<a<|<<b!", &[(Skipped, "<<a<"), (Packet, "<<b!")]);
        // The packet stands in what a false start had claimed; silence settles it.
        expect(start(), "<<<<a!|", &[(Skipped, "<<"), (Packet, "<<a!")]);
    }
}
