//! Anchored patterns of packets: ordered fields that together cover a whole packet, or do not match.
//!
//! A number is never searched for inside a packet. Fields are tried in order, longer before shorter; a dead end goes back to the field before.
//! What was tried in vain at one place is remembered, so the time is at most the product of fields, bytes and alternatives.

use super::check_sum::CheckSum;
use super::description::{ReplyMeaning, Trouble};
use super::integer::IntegerShape;
use super::number::NumberShape;
use super::registers::Registers;
use super::sample::Mark;

/// All packets of a gauge.
#[derive(Debug, Clone, Default)]
pub(super) struct Grammar {
    /// Packets that report an error: pattern, what, and words.
    pub(super) errors: Vec<ErrorPacket>,
    /// Packets that answer a command.
    pub(super) replies: Vec<ReplyPacket>,
    /// Packets that carry a value.
    pub(super) values: Vec<ValuePacket>,
}

/// A packet that reports an error.
#[derive(Debug, Clone)]
pub(super) struct ErrorPacket {
    pub(super) pattern: FieldPattern,
    pub(super) meaning: Trouble,
    pub(super) text: String,
}

/// A packet that answers a command.
#[derive(Debug, Clone)]
pub(super) struct ReplyPacket {
    pub(super) pattern: FieldPattern,
    pub(super) meaning: ReplyMeaning,
}

/// A packet that carries a value.
#[derive(Debug, Clone)]
pub(super) enum ValuePacket {
    /// In fields of text.
    Text(FieldPattern),
    /// In Modbus registers.
    Registers(Registers),
}

/// Fields in order.
#[derive(Debug, Clone, Default)]
pub(super) struct FieldPattern {
    pub(super) fields: Vec<PacketField>,
}

/// One field.
#[derive(Debug, Clone)]
pub(super) enum PacketField {
    /// These very bytes.
    Literal(Vec<u8>),
    /// Characters of a set, from least to most of them.
    Any { set: CharacterSet, count: Count },
    /// Texts for plus and for minus, the longest first.
    Sign(Vec<(Vec<u8>, bool)>),
    /// A digit, at most this, that gives how many decimals the number beside it has.
    Point { most: u8 },
    /// A decimal number.
    Number(NumberShape),
    /// An integer in hexadecimal digits or bytes.
    Integer(IntegerShape),
    /// A unit.
    Unit {
        codes: Vec<(Vec<u8>, UnitWord)>,
        others: Option<(CharacterSet, Count)>,
    },
    /// A digit, at most this, that gives which unit of the gauge's list it is.
    UnitPlace { most: u8 },
    /// One of several texts, the longest first.
    Choice(Vec<(Vec<u8>, ChoiceWord)>),
    /// A check sum of the bytes before it.
    CheckSum(CheckSum),
}

/// How many characters, least and most.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Count {
    pub(super) least: usize,
    pub(super) most: usize,
}

/// The meaning of the text of a unit.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum UnitWord {
    /// The unit.
    Unit(String),
    /// That the value is none, and why.
    Refuse(String),
}

/// The meaning of one of several texts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum ChoiceWord {
    /// Nothing against the value.
    Good,
    /// That the value must not be used, and why.
    Refuse(String),
    /// A mark.
    Note(Mark),
}

/// A set of ASCII characters.
#[derive(Debug, Clone)]
pub(super) struct CharacterSet([bool; 128]);

impl CharacterSet {
    /// The characters of a text.
    pub(super) fn of(text: &str) -> Self {
        let mut set = [false; 128];
        for byte in text.bytes().filter(u8::is_ascii) {
            set[usize::from(byte)] = true;
        }
        Self(set)
    }

    /// Every printable character.
    pub(super) fn printable() -> Self {
        Self(std::array::from_fn(|code| (0x20..0x7f).contains(&code)))
    }

    /// What units are made of: no digit, sign or point, which belong to a number.
    pub(super) fn unit_letters() -> Self {
        Self(std::array::from_fn(|code| {
            u8::try_from(code)
                .is_ok_and(|byte| byte.is_ascii_graphic() && !b"0123456789+-.,".contains(&byte))
        }))
    }

    pub(super) fn contains(&self, byte: u8) -> bool {
        self.0.get(usize::from(byte)).copied().unwrap_or_default()
    }
}

/// A field of a packet that matched: which one, its bytes, and which alternative.
#[derive(Debug, Clone, Copy)]
pub(super) struct Matched<'a> {
    pub(super) field: &'a PacketField,
    pub(super) bytes: &'a [u8],
    /// Place in the list of alternatives; its length for a unit that is not in the list.
    pub(super) alternative: usize,
}

impl FieldPattern {
    /// The fields of a packet, or `None` if it is not covered exactly.
    pub(super) fn matches<'a>(&'a self, packet: &'a [u8]) -> Option<Vec<Matched<'a>>> {
        self.covered(packet, true)
    }

    /// The check sum that a packet carries and the one that its bytes have, where nothing but these differs.
    pub(super) fn wrong_sum(&self, packet: &[u8]) -> Option<[i64; 2]> {
        let mut before = 0;
        for matched in self.covered(packet, false)? {
            if let PacketField::CheckSum(sum) = matched.field {
                return Some([sum.sent(matched.bytes)?, sum.of(&packet[..before])]);
            }
            before += matched.bytes.len();
        }
        None
    }

    /// # Arguments
    /// - `sums_count`: whether check sums must be right.
    fn covered<'a>(&'a self, packet: &'a [u8], sums_count: bool) -> Option<Vec<Matched<'a>>> {
        let mut attempt = Attempt {
            fields: &self.fields,
            sums_count,
            packet,
            dead: vec![false; (self.fields.len() + 1) * (packet.len() + 1)],
            taken: Vec::with_capacity(self.fields.len()),
        };
        attempt.from(0, 0).then_some(attempt.taken)
    }

    /// Whether before the number stands something that can stand nowhere else: fixed bytes, or a sign that is always sent. Without it the
    /// rest of a packet whose beginning is lost could pass for a packet.
    pub(super) fn begins_with_mark(&self) -> bool {
        let blank = |text: &[u8]| text.iter().all(|byte| *byte == b' ');
        for field in &self.fields {
            match field {
                PacketField::Literal(bytes) if !blank(bytes) => return true,
                PacketField::Literal(_) => {}
                PacketField::Sign(texts) => return !texts.iter().any(|(text, _)| blank(text)),
                _ => return false,
            }
        }
        false
    }

    /// The bytes of a pattern that can be only one text.
    pub(super) fn fixed_bytes(&self) -> Option<Vec<u8>> {
        let mut bytes = Vec::new();
        for field in &self.fields {
            let PacketField::Literal(literal) = field else {
                return None;
            };
            bytes.extend_from_slice(literal);
        }
        Some(bytes)
    }
}

/// A packet while it is tried.
struct Attempt<'a> {
    fields: &'a [PacketField],
    sums_count: bool,
    packet: &'a [u8],
    /// By field and byte: tried in vain.
    dead: Vec<bool>,
    taken: Vec<Matched<'a>>,
}

impl Attempt<'_> {
    /// Whether the fields from `field` on cover the packet from `at` on; what they took is then in `taken`.
    fn from(&mut self, field: usize, at: usize) -> bool {
        let fields = self.fields;
        let Some(next) = fields.get(field) else {
            return at == self.packet.len();
        };
        let key = field * (self.packet.len() + 1) + at;
        if self.dead[key] {
            return false;
        }
        let packet = self.packet;
        for (length, alternative) in next.ways(packet, at, self.sums_count) {
            self.taken.push(Matched {
                field: next,
                bytes: &packet[at..at + length],
                alternative,
            });
            if self.from(field + 1, at + length) {
                return true;
            }
            self.taken.pop();
        }
        self.dead[key] = true;
        false
    }
}

impl PacketField {
    /// Whether it is the number of a packet, or of one of two quantities.
    pub(super) fn is_number(&self) -> bool {
        matches!(self, Self::Number(_) | Self::Integer(_))
    }

    /// The lengths that this field can take from `at` on, in order of preference, each with its alternative.
    fn ways(&self, packet: &[u8], at: usize, sums_count: bool) -> Vec<(usize, usize)> {
        let rest = &packet[at..];
        match self {
            Self::Literal(bytes) => one_if(rest.starts_with(bytes), bytes.len()),
            Self::Any { set, count } => {
                let run = rest.iter().take_while(|byte| set.contains(**byte)).count();
                count.down_from(run)
            }
            Self::Sign(texts) => starting(texts, rest),
            Self::Point { most } | Self::UnitPlace { most } => {
                let digit = rest
                    .first()
                    .is_some_and(|byte| (b'0'..=b'0' + most).contains(byte));
                one_if(digit, 1)
            }
            Self::Number(shape) => shape.lengths(rest),
            Self::Integer(shape) => one_if(shape.counts(rest).is_some(), shape.width),
            Self::Unit { codes, others } => {
                let mut ways = starting(codes, rest);
                if let Some((set, count)) = others {
                    let run = rest.iter().take_while(|byte| set.contains(**byte)).count();
                    let unknown = count.down_from(run).into_iter();
                    ways.extend(unknown.map(|(length, _)| (length, codes.len())));
                }
                ways
            }
            Self::Choice(texts) => starting(texts, rest),
            Self::CheckSum(sum) => {
                let fits = |sent| !sums_count || sent == sum.of(&packet[..at]);
                one_if(sum.sent(rest).is_some_and(fits), sum.shape.width)
            }
        }
    }
}

/// The number, by its place among the fields of a packet, that a sign or a point at a place belongs to: the next one, or the last where no
/// other follows.
pub(super) fn number_of<'f>(
    fields: impl DoubleEndedIterator<Item = &'f PacketField> + ExactSizeIterator,
    place: usize,
) -> Option<usize> {
    let numbers = fields.enumerate().filter(|(_, field)| field.is_number());
    let places: Vec<usize> = numbers.map(|(number, _)| number).collect();
    let behind = places.iter().find(|number| **number > place);
    behind.or(places.last()).copied()
}

impl Count {
    /// Lengths from the longest that a run allows down to the least.
    fn down_from(self, run: usize) -> Vec<(usize, usize)> {
        let longest = run.min(self.most);
        (self.least..=longest)
            .rev()
            .map(|length| (length, 0))
            .collect()
    }
}

fn one_if(fits: bool, length: usize) -> Vec<(usize, usize)> {
    if fits { vec![(length, 0)] } else { Vec::new() }
}

/// The alternatives with which `rest` begins.
fn starting<T>(texts: &[(Vec<u8>, T)], rest: &[u8]) -> Vec<(usize, usize)> {
    let places = texts.iter().enumerate();
    places
        .filter(|(_, (text, _))| rest.starts_with(text))
        .map(|(place, (text, _))| (text.len(), place))
        .collect()
}
