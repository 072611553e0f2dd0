//! The protocol of a gauge, from its description: the fields that read its packets, written backwards.
//!
//! It behaves as described and no more. Where the real gauge differs, the description is wrong, and this gauge shares the
//! mistake: it rehearses a session, and proves nothing about decoding.

use crate::check_sum::modbus_crc;
use crate::description::{
    CommandRole, Expect, GaugeCommand, InstrumentDescription, ReplyMeaning, Trouble,
};
use crate::framing::FramingKind;
use crate::grammar::ValuePacket;
use crate::registers::is_intact;
use crate::write::{PacketContent, WrittenState};

use super::meter::Meter;
use super::range::first_unit;
use super::wire::{Packets, Stream};

/// Longest command that is waited for.
const LONGEST_COMMAND: usize = 256;

/// Values a second of a stream, unless the description states that there are fewer.
const USUAL_STREAM_PER_S: f64 = 10.0;

/// Bytes of a Modbus request to read, and the code by which one for other registers is refused.
const MODBUS_REQUEST: usize = 8;
const MODBUS_ILLEGAL_ADDRESS: u8 = 2;

/// The behaviour of a gauge according to its description.
pub(super) struct Protocol {
    description: InstrumentDescription,
    /// Bytes of a command that is not complete.
    heard: Vec<u8>,
    heard_at_s: f64,
    stream: Stream,
}

impl Protocol {
    pub(super) fn new(description: &InstrumentDescription) -> Self {
        Self {
            description: description.clone(),
            heard: Vec::new(),
            heard_at_s: 0.0,
            stream: Stream::default(),
        }
    }

    /// Bytes arrive from the host.
    pub(super) fn receive(
        &mut self,
        meter: &mut Meter,
        bytes: &[u8],
        now_s: f64,
        out: &mut Packets,
    ) {
        if self.is_modbus() && now_s - self.heard_at_s > self.description.framing.idle_s {
            self.heard.clear();
        }
        self.heard_at_s = now_s;
        for byte in bytes {
            self.heard.push(*byte);
            self.hear(meter, now_s, out);
        }
    }

    /// Time passes: values of a stream.
    pub(super) fn tick(&mut self, meter: &mut Meter, now_s: f64, out: &mut Packets) {
        if self.streams() && !self.stream.is_on() {
            self.start(now_s);
        }
        for _ in 0..self.stream.due(now_s) {
            out.extend(self.value(meter));
        }
    }

    /// When time will have something to send, s.
    pub(super) fn next_due_s(&self) -> Option<f64> {
        let unasked = self.streams().then_some(0.0);
        self.stream.next_due_s().or(unasked)
    }

    /// A packet with what the display shows, or a packet without a value.
    pub(super) fn value(&self, meter: &mut Meter) -> Option<Vec<u8>> {
        let value_si = meter.displayed_si();
        self.packet(meter, value_si)
    }

    /// A packet with a value, or with the worst of the states that can be reported.
    fn packet(&self, meter: &Meter, value_si: f64) -> Option<Vec<u8>> {
        let shown = meter.rounded(value_si);
        let running = self.written(meter, shown, WrittenState::Running);
        let reported_text = states(meter, value_si).find_map(|state| {
            let troubles = troubles(state).iter();
            let mut packets = troubles.filter_map(|trouble| self.trouble(*trouble, meter));
            packets.next().or_else(|| {
                let written = self.written(meter, shown, state);
                written.filter(|packet| Some(packet) != running.as_ref())
            })
        });
        reported_text
            .or(running)
            .or_else(|| self.trouble(Trouble::Overload, meter))
    }

    /// The unit that a word means at the panel: a code of the line, or the usual name.
    pub(super) fn unit_named<'a>(&'a self, word: &'a str) -> &'a str {
        let mut codes = self.description.units.codes.iter();
        codes
            .find(|(code, _)| code == word)
            .map_or(word, |(_, means)| means)
    }

    fn is_modbus(&self) -> bool {
        matches!(self.description.framing.kind, FramingKind::Modbus { .. })
    }

    /// Whether it sends values without having been asked for any.
    fn streams(&self) -> bool {
        let has = |role| self.description.command(role).is_some();
        !has(CommandRole::Read) && !has(CommandRole::StreamStart)
    }

    fn commands(&self) -> impl Iterator<Item = (CommandRole, &GaugeCommand)> {
        let roles = CommandRole::ALL.into_iter();
        roles.filter_map(|role| Some((role, self.description.command(role)?)))
    }

    /// The byte that ends all commands, if one does. What clears half a command stands alone.
    fn common_end(&self) -> Option<u8> {
        let commands = self
            .commands()
            .filter(|(role, _)| *role != CommandRole::Resynchronise);
        let mut ends = commands.map(|(_, command)| match command.bytes[..] {
            [_, .., end] => Some(end),
            _ => None,
        });
        let end = ends.next().flatten().filter(u8::is_ascii_control)?;
        ends.all(|other| other == Some(end)).then_some(end)
    }

    /// The role of what was heard, if it is a whole command; `Err` if it is none and will be none.
    fn understood(&self) -> Result<Option<CommandRole>, ()> {
        let mut whole = None;
        for (role, command) in self.commands() {
            if command.bytes == self.heard {
                whole = whole.or(Some(role));
            } else if command.bytes.starts_with(&self.heard) {
                return Ok(None);
            }
        }
        whole.map(Some).ok_or(())
    }

    fn hear(&mut self, meter: &mut Meter, now_s: f64, out: &mut Packets) {
        match self.understood() {
            Ok(None) => {}
            Ok(Some(role)) => {
                self.heard.clear();
                self.handle_command(role, meter, now_s, out);
            }
            Err(()) if self.is_modbus() => out.extend(self.refused_request()),
            Err(()) => self.hear_wrong(meter, out),
        }
        self.heard.truncate(LONGEST_COMMAND);
    }

    /// What begins no command: a line is refused when it ends, other bytes are overlooked.
    fn hear_wrong(&mut self, meter: &Meter, out: &mut Packets) {
        let clear = self.description.command(CommandRole::Resynchronise);
        let Some(end) = self.common_end() else {
            while !self.heard.is_empty() && self.understood().is_err() {
                self.heard.remove(0);
            }
            return;
        };
        // A line feed behind a carriage return ends nothing.
        let overlooked =
            self.heard == b"\n" || clear.is_some_and(|it| self.heard.ends_with(&it.bytes));
        if overlooked {
            self.heard.clear();
        } else if self.heard.last() == Some(&end) {
            self.heard.clear();
            out.extend(self.trouble(Trouble::Refused, meter));
        }
    }

    /// The answer to a Modbus request that the gauge does not know; none to one that is garbled or not for it.
    fn refused_request(&mut self) -> Option<Vec<u8>> {
        let FramingKind::Modbus { slave, .. } = self.description.framing.kind else {
            return None;
        };
        if self.heard.len() < MODBUS_REQUEST {
            return None;
        }
        let request = std::mem::take(&mut self.heard);
        if request[0] != slave || !is_intact(&request) {
            return None;
        }
        let mut packet = vec![slave, request[1] | 0x80, MODBUS_ILLEGAL_ADDRESS];
        packet.extend(modbus_crc(&packet).to_le_bytes());
        Some(packet)
    }

    fn handle_command(
        &mut self,
        role: CommandRole,
        meter: &mut Meter,
        now_s: f64,
        out: &mut Packets,
    ) {
        match role {
            CommandRole::StreamStart => self.start(now_s),
            CommandRole::StreamStop => self.stream.stop(),
            CommandRole::Zero => meter.zero(),
            CommandRole::SetUnit => {
                meter.set_unit(first_unit(self.description.channel));
            }
            CommandRole::SetMode => {
                meter.peak_mode = false;
                meter.hold(false);
            }
            CommandRole::Read
            | CommandRole::Identify
            | CommandRole::QueryUnit
            | CommandRole::QueryMode
            | CommandRole::KeepAwake
            | CommandRole::Resynchronise => {}
        }
        let Some(command) = self.description.command(role) else {
            return;
        };
        out.extend(match command.expects {
            Expect::Nothing => None,
            Expect::Value if command.running => {
                let value_si = meter.live_si();
                self.packet(meter, value_si)
            }
            Expect::Value => self.value(meter),
            Expect::Acknowledgement => self
                .reply(ReplyMeaning::Acknowledged, meter, None)
                .or_else(|| Some(self.echo(command))),
            Expect::Echo => Some(self.echo(command)),
            Expect::Text => Some(self.reported_text(role, command, meter)),
        });
    }

    fn start(&mut self, now_s: f64) {
        let most_per_s = self.description.timing().most_per_s;
        self.stream.start(most_per_s.min(USUAL_STREAM_PER_S), now_s);
    }

    /// The first packet with a value that has room for it.
    fn written(&self, meter: &Meter, value: f64, state: WrittenState) -> Option<Vec<u8>> {
        let packet_text = PacketContent {
            value,
            decimals: meter.unit().decimals,
            state,
            ..Self::packet_text(meter)
        };
        let mut packets = self.description.grammar.values.iter();
        let written = packets.find_map(|packet| match packet {
            ValuePacket::Text(pattern) => pattern.write(&packet_text),
            ValuePacket::Registers(registers) => match self.description.framing.kind {
                FramingKind::Modbus {
                    slave,
                    function,
                    data_bytes,
                } => registers.write(value, slave, function, data_bytes),
                _ => None,
            },
        });
        Some(self.ended(written?))
    }

    fn packet_text(meter: &Meter) -> PacketContent<'_> {
        PacketContent {
            value: 0.0,
            decimals: 0,
            unit: &meter.unit().name,
            unit_place: u8::try_from(meter.unit_place()).unwrap_or_default(),
            state: WrittenState::Running,
            list: None,
        }
    }

    /// A packet that reports an error, if the gauge has one.
    fn trouble(&self, trouble: Trouble, meter: &Meter) -> Option<Vec<u8>> {
        let mut errors = self.description.grammar.errors.iter();
        let packet_text = Self::packet_text(meter);
        let packet = errors
            .find(|error| error.meaning == trouble)
            .and_then(|error| error.pattern.write(&packet_text))?;
        Some(self.ended(packet))
    }

    fn reply(&self, meaning: ReplyMeaning, meter: &Meter, list: Option<&[u8]>) -> Option<Vec<u8>> {
        let mut replies = self.description.grammar.replies.iter();
        let pattern = &replies.find(|reply| reply.meaning == meaning)?.pattern;
        let packet_text = PacketContent {
            list,
            ..Self::packet_text(meter)
        };
        Some(self.ended(pattern.write(&packet_text)?))
    }

    /// An answer in words.
    fn reported_text(
        &self,
        role: CommandRole,
        command: &GaugeCommand,
        meter: &mut Meter,
    ) -> Vec<u8> {
        let name = format!("emulated {}", self.description.name);
        let meanings: &[ReplyMeaning] = match role {
            CommandRole::Identify => &[ReplyMeaning::Identity],
            CommandRole::QueryUnit => &[ReplyMeaning::Unit, ReplyMeaning::Units],
            CommandRole::QueryMode => &[ReplyMeaning::State, ReplyMeaning::Units],
            _ => &[ReplyMeaning::Text],
        };
        let mut replies = meanings.iter().filter_map(|meaning| match meaning {
            ReplyMeaning::Identity => self.reply(*meaning, meter, Some(name.as_bytes())),
            ReplyMeaning::Units => self.reply(*meaning, meter, Some(&self.unit_list(meter))),
            _ => self.reply(*meaning, meter, None),
        });
        let reply = replies.next();
        reply.unwrap_or_else(|| {
            let text = match role {
                CommandRole::Identify => name,
                CommandRole::QueryUnit => self.code(&meter.unit().name).to_owned(),
                CommandRole::QueryMode => mode_text(command, meter),
                _ => "OK".to_owned(),
            };
            self.ended(text.into_bytes())
        })
    }

    /// What stands on the wire for a unit.
    fn code<'a>(&'a self, unit: &'a str) -> &'a str {
        let mut codes = self.description.units.codes.iter();
        codes
            .find(|(_, means)| means == unit)
            .map_or(unit, |(code, _)| code)
    }

    /// The codes of its units, in the order of the meter, again and again: as many as any field takes.
    fn unit_list(&self, meter: &Meter) -> Vec<u8> {
        let codes = meter.range.units.iter().map(|unit| self.code(&unit.name));
        let codes: Vec<u8> = codes.flat_map(str::bytes).collect();
        codes
            .iter()
            .copied()
            .cycle()
            .take(LONGEST_COMMAND)
            .collect()
    }

    /// The command itself.
    fn echo(&self, command: &GaugeCommand) -> Vec<u8> {
        match self.description.framing.kind {
            FramingKind::Line { .. } => self.ended(command.bytes.trim_ascii_end().to_vec()),
            _ => command.bytes.clone(),
        }
    }

    fn ended(&self, packet: Vec<u8>) -> Vec<u8> {
        self.description.framing.ended(packet)
    }
}

/// States to report beside the value, the worst first.
fn states(meter: &Meter, value_si: f64) -> impl Iterator<Item = WrittenState> + use<> {
    let states = [
        (meter.tool_off, WrittenState::ToolOff),
        (meter.overloaded(value_si), WrittenState::Overload),
        (meter.is_held(), WrittenState::Hold),
        (meter.peak_mode, WrittenState::Peak),
        (meter.battery_low, WrittenState::LowBattery),
    ];
    states
        .into_iter()
        .filter_map(|(is, state)| is.then_some(state))
}

/// Packets that stand in place of a value in a state.
fn troubles(state: WrittenState) -> &'static [Trouble] {
    match state {
        WrittenState::ToolOff => &[Trouble::NoData, Trouble::SensorFault],
        WrittenState::Overload => &[Trouble::Overload],
        WrittenState::Hold => &[Trouble::Hold],
        WrittenState::LowBattery => &[Trouble::LowBattery],
        WrittenState::Running | WrittenState::Peak => &[],
    }
}

/// The answer to the question for the mode: a word that the description refuses if the gauge is in that state, else one that it does not.
fn mode_text(command: &GaugeCommand, meter: &mut Meter) -> String {
    let value_si = meter.displayed_si();
    let reported_text = states(meter, value_si).find_map(|state| {
        let mut words = command.refuse.iter();
        words.find(|(_, why)| state.is_reported_by(why))
    });
    reported_text.map_or_else(|| "RUN".to_owned(), |(word, _)| word.clone())
}
