//! From bytes to samples, by the description of the gauge.
//!
//! Pure: bytes and their times in, samples, replies and rejected bytes out. Error packets are tried first; a packet counts only if a pattern
//! covers all of it, and a number is never searched for inside a line. What must not be used (peak mode, hold, overload, a unit of another
//! quantity, more digits than the gauge has) is rejected with the reason. Nothing is dropped silently.

mod error;
mod packet_values;
mod reasons;
mod reply;
mod values;

#[cfg(test)]
mod tests;

use super::description::{CommandRole, Expect, InstrumentDescription, ReplyMeaning, Trouble};
use super::framing::{Fragment, FragmentKind, Framer, FramingKind, fits_modbus};
use super::grammar::{Grammar, PacketField, ValuePacket};
use super::registers::exception;
use super::sample::Rejected;

use packet_values::packet_values;

pub use error::DecoderError;
pub use reply::{Decoded, Meaning, Reply, raw_text};

/// Turns the bytes of one gauge into samples.
#[derive(Debug, Clone)]
pub struct Decoder {
    description: InstrumentDescription,
    framer: Framer,
    /// The unit that was configured.
    configured: Option<String>,
    /// The unit that the gauge named when it was asked.
    reported: Option<String>,
    /// The codes of its units, in the order that its packets count them.
    unit_list: Option<Vec<String>>,
    /// Why values must not be used, by the gauge's own answer about its mode.
    objection: Option<String>,
    /// The last command that is not answered yet.
    waiting: Option<CommandRole>,
    /// Values that were asked for and have not come.
    values_due: u32,
    /// The gauge sends values unasked, and that is as it should be.
    streaming: bool,
}

impl Decoder {
    /// A decoder for a gauge; the next byte begins a packet.
    ///
    /// `unit` is the unit of packets that carry none.
    ///
    /// # Errors
    /// A unit is needed and not given, or the gauge cannot have it.
    pub fn new(
        description: &InstrumentDescription,
        unit: Option<&str>,
    ) -> Result<Self, DecoderError> {
        values::check_unit(description, unit)?;
        Ok(Self {
            framer: Framer::new(&description.framing),
            configured: unit.map(str::to_owned),
            reported: None,
            unit_list: None,
            objection: None,
            waiting: None,
            values_due: 0,
            streaming: description.command(CommandRole::Read).is_none(),
            description: description.clone(),
        })
    }

    /// Takes bytes that arrived at `at_s`.
    pub fn push(&mut self, bytes: &[u8], at_s: f64, out: &mut Vec<Decoded>) {
        let mut pieces = Vec::new();
        for byte in bytes {
            let Self {
                framer,
                description,
                ..
            } = self;
            framer.push(
                *byte,
                at_s,
                &|packet| fits(description, packet),
                &mut pieces,
            );
        }
        for piece in &pieces {
            self.piece(piece, out);
        }
    }

    /// Nothing came for [`InstrumentDescription::idle_gap_s`]: packets that end by silence are complete, the rest of others does not come.
    pub fn idle(&mut self, _at_s: f64, out: &mut Vec<Decoded>) {
        let mut pieces = Vec::new();
        let Self {
            framer,
            description,
            ..
        } = self;
        framer.idle(&|packet| fits(description, packet), &mut pieces);
        for piece in &pieces {
            self.piece(piece, out);
        }
    }

    /// A command was sent: its answer comes next.
    pub fn asked(&mut self, role: CommandRole) {
        match role {
            CommandRole::Read => self.values_due = self.values_due.saturating_add(1),
            CommandRole::StreamStart => self.streaming = true,
            CommandRole::StreamStop => self.streaming = false,
            _ => {}
        }
        self.waiting = Some(role);
    }

    /// The line was drained: what waited is forgotten, nothing is expected, and the next byte begins a packet.
    pub fn reset(&mut self) {
        self.framer.reset();
        self.waiting = None;
        self.values_due = 0;
    }

    /// The same decoder where the gauge sent so many bytes before it began.
    #[must_use]
    pub fn behind(mut self, received: u64) -> Self {
        self.framer.begin_behind(received);
        self
    }

    fn piece(&mut self, piece: &Fragment, out: &mut Vec<Decoded>) {
        let before = out.len();
        self.decode_piece(piece, out);
        for decoded in &mut out[before..] {
            if let Decoded::Sample(sample) = decoded {
                sample.bytes = piece.place;
            }
        }
    }

    fn decode_piece(&mut self, piece: &Fragment, out: &mut Vec<Decoded>) {
        match piece.kind {
            FragmentKind::Packet => self.packet(piece, &piece.bytes, true, out),
            FragmentKind::Tail => self.packet(piece, &piece.bytes, false, out),
            kind => out.push(rejected(
                &piece.bytes,
                piece.at_s,
                reasons::no_packet(kind, &piece.bytes, &self.description),
            )),
        }
    }

    /// A packet; `whole` if its beginning was seen.
    fn packet(&mut self, piece: &Fragment, bytes: &[u8], whole: bool, out: &mut Vec<Decoded>) {
        if let Some(decoded) = self.known_packet(bytes, piece.at_s, whole) {
            out.extend(decoded);
            return;
        }
        // Noise before a packet is separated from the packet where the packet begins with a mark.
        let noise = bytes
            .iter()
            .take_while(|byte| !matches!(byte, 0x20..=0x7e))
            .count();
        if noise > 0
            && let Some(decoded) = self.known_packet(&bytes[noise..], piece.at_s, false)
        {
            out.push(rejected(
                &bytes[..noise],
                piece.at_s,
                reasons::noise_before_packet(),
            ));
            out.extend(decoded);
            return;
        }
        let reason = if whole || reasons::is_seven_bit_even(bytes) {
            reasons::unknown_packet(bytes, &self.description)
        } else {
            reasons::lost_beginning()
        };
        out.push(rejected(bytes, piece.at_s, reason));
    }

    /// The content of a packet, if a pattern matches it. Without its beginning only patterns that begin with a mark count.
    fn known_packet(&mut self, bytes: &[u8], at_s: f64, whole: bool) -> Option<Vec<Decoded>> {
        if let Some(error) = self.error(bytes, at_s, whole) {
            return Some(vec![error]);
        }
        if whole && let Some(echo) = self.echo(bytes, at_s) {
            return Some(vec![echo]);
        }
        if let Some(reply) = self.reply(bytes, at_s, whole) {
            return Some(vec![reply]);
        }
        let identity = self.waiting == Some(CommandRole::Identify) && self.expects_text();
        if let Some(values) = self.values(bytes, at_s, whole, identity) {
            return Some(values);
        }
        (whole
            && self.expects_text()
            && !bytes.is_empty()
            && bytes.iter().all(|byte| matches!(byte, 0x20..=0x7e)))
        .then(|| vec![self.text(bytes, at_s)])
    }

    /// A packet that reports an error.
    fn error(&mut self, bytes: &[u8], at_s: f64, whole: bool) -> Option<Decoded> {
        let (meaning, text) = self.error_words(bytes, whole)?;
        let refused_command = meaning == Trouble::Refused
            && self.waiting.is_some_and(|role| role != CommandRole::Read);
        if !matches!(meaning, Trouble::NotAValue) {
            self.answered();
        }
        Some(if refused_command {
            reply(bytes, at_s, Meaning::Refused(text))
        } else {
            rejected(bytes, at_s, text)
        })
    }

    fn error_words(&self, bytes: &[u8], whole: bool) -> Option<(Trouble, String)> {
        if let FramingKind::Modbus { .. } = self.description.framing.kind
            && let Some(text) = exception(bytes)
        {
            return Some((Trouble::Refused, text));
        }
        let mut errors = self.description.grammar.errors.iter();
        errors.find_map(|packet| {
            let fields = (whole || packet.pattern.begins_with_mark())
                .then(|| packet.pattern.matches(bytes))
                .flatten()?;
            let details = packet_values(&fields).refusals.join("; ");
            let text = if details.is_empty() {
                format!("{}: {}", packet.meaning, packet.text)
            } else {
                format!("{}: {}: {details}", packet.meaning, packet.text)
            };
            Some((packet.meaning, text))
        })
    }

    /// The command itself, sent back.
    fn echo(&mut self, bytes: &[u8], at_s: f64) -> Option<Decoded> {
        let command = self.description.command(self.waiting?)?;
        let sent = command.bytes.get(..bytes.len())?;
        let rest = &command.bytes[bytes.len()..];
        if bytes.is_empty()
            || !sent.eq_ignore_ascii_case(bytes)
            || !rest.iter().all(u8::is_ascii_control)
        {
            return None;
        }
        if matches!(command.expects, Expect::Echo | Expect::Acknowledgement) {
            self.answered();
            return Some(reply(bytes, at_s, Meaning::Acknowledged));
        }
        Some(reply(
            bytes,
            at_s,
            Meaning::Text("an echo of the command".to_owned()),
        ))
    }

    /// A packet that answers a command, known by its pattern.
    fn reply(&mut self, bytes: &[u8], at_s: f64, whole: bool) -> Option<Decoded> {
        let mut replies = self.description.grammar.replies.iter();
        let (fields, meaning) = replies.find_map(|packet| {
            let pattern = &packet.pattern;
            let fields = (whole || pattern.begins_with_mark())
                .then(|| pattern.matches(bytes))
                .flatten()?;
            let varies = fields
                .iter()
                .find(|matched| !matches!(matched.field, PacketField::Literal(_)));
            Some((varies.map(|matched| matched.bytes.to_vec()), packet.meaning))
        })?;
        let text = String::from(raw_text(bytes).trim());
        let meaning = match meaning {
            ReplyMeaning::Acknowledged => Meaning::Acknowledged,
            ReplyMeaning::Identity => Meaning::Identity(text),
            ReplyMeaning::Unit => self.unit_reported(&text),
            ReplyMeaning::Units => {
                self.units_listed(&fields.unwrap_or_default());
                Meaning::State(text)
            }
            ReplyMeaning::State => self.state_reported(text),
            ReplyMeaning::Text => Meaning::Text(text),
        };
        self.answered();
        Some(reply(bytes, at_s, meaning))
    }

    /// A text that was asked for.
    fn text(&mut self, bytes: &[u8], at_s: f64) -> Decoded {
        let text = String::from(raw_text(bytes).trim());
        let meaning = match self.waiting {
            Some(CommandRole::Identify) => Meaning::Identity(text),
            Some(CommandRole::QueryUnit) => self.unit_reported(&text),
            Some(CommandRole::QueryMode) => self.state_reported(text),
            _ => Meaning::Text(text),
        };
        self.answered();
        reply(bytes, at_s, meaning)
    }

    fn unit_reported(&mut self, text: &str) -> Meaning {
        let unit = self
            .description
            .units
            .named_by(text)
            .unwrap_or(text)
            .to_owned();
        self.reported = Some(unit.clone());
        Meaning::Unit(unit)
    }

    /// The gauge has given the codes of its units, all of one length.
    fn units_listed(&mut self, codes: &[u8]) {
        let length = self
            .description
            .units
            .codes
            .first()
            .map_or(1, |(code, _)| code.len());
        let codes = codes
            .chunks(length.max(1))
            .map(|code| raw_text(code).into());
        self.unit_list = Some(codes.collect());
    }

    fn state_reported(&mut self, text: String) -> Meaning {
        let command = self.description.command(CommandRole::QueryMode);
        let objection = command.and_then(|command| command.objection(&text));
        self.objection = objection.map(str::to_owned);
        Meaning::State(text)
    }

    fn expects_text(&self) -> bool {
        let command = self.waiting.and_then(|role| self.description.command(role));
        command.is_some_and(|command| command.expects == Expect::Text)
    }

    /// The last command has had its answer.
    fn answered(&mut self) {
        if self.waiting.take() == Some(CommandRole::Read) {
            self.values_due = self.values_due.saturating_sub(1);
        }
    }
}

impl InstrumentDescription {
    /// The check sum of a packet with a value, and that of its bytes, where nothing else is wrong with it.
    fn wrong_sum(&self, packet: &[u8]) -> Option<[i64; 2]> {
        let mut values = self.grammar.values.iter();
        values.find_map(|value| match value {
            ValuePacket::Text(pattern) => pattern.wrong_sum(packet),
            ValuePacket::Registers(_) => None,
        })
    }

    /// Whether bytes are a packet with a value in fields.
    fn covers_value(&self, packet: &[u8]) -> bool {
        let mut values = self.grammar.values.iter();
        values.any(|value| matches!(value, ValuePacket::Text(pattern) if pattern.matches(packet).is_some()))
    }
}

/// Whether bytes of full length are a packet of the gauge.
fn fits(description: &InstrumentDescription, packet: &[u8]) -> bool {
    if let FramingKind::Modbus { .. } = description.framing.kind {
        return fits_modbus(packet);
    }
    let Grammar {
        errors, replies, ..
    } = &description.grammar;
    let fits = |pattern: &super::grammar::FieldPattern| pattern.matches(packet).is_some();
    errors.iter().any(|error| fits(&error.pattern))
        || replies.iter().any(|reply| fits(&reply.pattern))
        || description.covers_value(packet)
}

fn rejected(bytes: &[u8], at_s: f64, reason: String) -> Decoded {
    Decoded::Rejected(Rejected {
        raw: raw_text(bytes),
        reason: reason.into(),
        at_s,
    })
}

fn reply(bytes: &[u8], at_s: f64, meaning: Meaning) -> Decoded {
    Decoded::Reply(Reply {
        raw: raw_text(bytes),
        meaning,
        at_s,
    })
}
