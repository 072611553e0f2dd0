//! A gauge emulated from its description: the fields that read its packets, written backwards.
//!
//! It knows what the description says and no more. Where its maker's gauge does otherwise, the description is wrong, and this gauge shares the
//! mistake: it rehearses a session, and proves nothing about decoding.

use crate::Channel;
use crate::description::{
    Command, Expect, InstrumentDescription, ReplyMeaning, Role, SignMeaning, Trouble,
};
use crate::framing::FramingKind;
use crate::grammar::{Pattern, ValuePacket};
use crate::write::{Said, State};

use super::gauge::Maker;
use super::meter::{Meter, Range, Unit};
use super::wire::{Packets, Stream};

/// Capacities of gauges whose description says none, N and m.
const USUAL_CAPACITY_SI: [f64; 2] = [500.0, 0.025];

/// Steps of the last digit of gauges whose description says none, N and m.
const USUAL_STEP_SI: [f64; 2] = [0.01, 1e-6];

/// Most decimals of a unit.
const MOST_DECIMALS: u8 = 6;

/// Longest command that is waited for.
const LONGEST_COMMAND: usize = 256;

/// What a described gauge is made for.
pub(super) fn range(description: &InstrumentDescription) -> Range {
    let mut units = description.units.all();
    let first = first_unit(description.channel);
    units.sort_by_key(|unit| unit != first);
    let place = usize::from(description.channel == Channel::Displacement);
    let kind = description.channel.kind();
    let units = units.into_iter().filter_map(|name| {
        let si = kind.si_factor(&name)?;
        let decimals = usize::from(decimals(description, &name, USUAL_STEP_SI[place] / si));
        Some(Unit { name, si, decimals })
    });
    let capacity_si = description.physical.capacity_si;
    Range {
        channel: description.channel,
        units: units.collect(),
        capacity_si: capacity_si.unwrap_or(USUAL_CAPACITY_SI[place]),
        plus_as_truth: match (description.channel, description.sign.compression) {
            (Channel::Force, SignMeaning::Positive) => false,
            (Channel::Force, SignMeaning::Negative | SignMeaning::Ask) => true,
            (Channel::Displacement, meaning) => meaning != SignMeaning::Negative,
        },
    }
}

fn first_unit(channel: Channel) -> &'static str {
    match channel {
        Channel::Force => "N",
        Channel::Displacement => "mm",
    }
}

/// Digits behind the point in a unit.
fn decimals(description: &InstrumentDescription, unit: &str, usual_step: f64) -> u8 {
    let physical = &description.physical;
    let mut decimals = physical.decimals.iter();
    if let Some((_, possible)) = decimals.find(|(name, _)| name == unit)
        && let Some(most) = possible.iter().max()
    {
        return *most;
    }
    let mut resolution = physical.resolution.iter();
    let step = resolution
        .find(|(name, _)| name == unit)
        .map_or(usual_step, |(_, step)| *step);
    let digits = (0..MOST_DECIMALS).find(|digits| {
        let steps = step * 10_f64.powi(i32::from(*digits));
        steps >= 0.999 && (steps - steps.round()).abs() < 1e-6 * steps
    });
    digits.unwrap_or(MOST_DECIMALS)
}

/// A gauge as its description has it.
pub(super) struct Described {
    description: InstrumentDescription,
    /// Bytes of a command that is not complete.
    heard: Vec<u8>,
    stream: Stream,
}

impl Described {
    pub(super) fn boxed(description: &InstrumentDescription) -> Box<dyn Maker> {
        Box::new(Self {
            description: description.clone(),
            heard: Vec::new(),
            stream: Stream::default(),
        })
    }

    /// Whether it sends values without having been asked for any.
    fn sends_unasked(&self) -> bool {
        let has = |role| self.description.command(role).is_some();
        !has(Role::Read) && !has(Role::StreamStart)
    }

    fn commands(&self) -> impl Iterator<Item = (Role, &Command)> {
        let roles = Role::ALL.into_iter();
        roles.filter_map(|role| Some((role, self.description.command(role)?)))
    }

    /// The byte that ends all commands, if one does.
    fn common_end(&self) -> Option<u8> {
        let mut ends = self
            .commands()
            .map(|(_, command)| command.bytes.last().copied());
        let end = ends.next().flatten().filter(u8::is_ascii_control)?;
        ends.all(|other| other == Some(end)).then_some(end)
    }

    /// The role of what was heard, if it is a whole command; `Err` if it is none and will be none.
    fn understood(&self) -> Result<Option<Role>, ()> {
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
        match (self.understood(), self.common_end()) {
            (Ok(None), _) => {}
            (Ok(Some(role)), _) => {
                self.heard.clear();
                self.obey(role, meter, now_s, out);
            }
            (Err(()), Some(end)) => {
                if self.heard.last() == Some(&end) {
                    self.heard.clear();
                    out.extend(self.trouble(Trouble::Refused, meter));
                }
            }
            (Err(()), None) => {
                while !self.heard.is_empty() && self.understood().is_err() {
                    self.heard.remove(0);
                }
            }
        }
        self.heard.truncate(LONGEST_COMMAND);
    }

    fn obey(&mut self, role: Role, meter: &mut Meter, now_s: f64, out: &mut Packets) {
        match role {
            Role::StreamStart => self.start(now_s),
            Role::StreamStop => self.stream.stop(),
            Role::Zero => meter.zero(),
            Role::SetUnit => {
                meter.set_unit(first_unit(self.description.channel));
            }
            Role::SetMode => {
                meter.peak_mode = false;
                meter.hold(false);
            }
            Role::Read
            | Role::Identify
            | Role::QueryUnit
            | Role::QueryMode
            | Role::KeepAwake
            | Role::Resynchronise => {}
        }
        let Some(command) = self.description.command(role) else {
            return;
        };
        out.extend(match command.expects {
            Expect::Nothing => None,
            Expect::Value => self.value(meter),
            Expect::Acknowledgement => self
                .reply(ReplyMeaning::Acknowledged, meter, None)
                .or_else(|| Some(self.echo(command))),
            Expect::Echo => Some(self.echo(command)),
            Expect::Text => self.told(role, command, meter),
        });
    }

    fn start(&mut self, now_s: f64) {
        self.stream
            .start(self.description.timing().most_per_s.min(50.0), now_s);
    }

    /// A packet with the value, or what says that there is none.
    fn value(&self, meter: &mut Meter) -> Option<Vec<u8>> {
        if meter.tool_off {
            return self.trouble(Trouble::NoData, meter);
        }
        let value_si = meter.displayed_si();
        let state = state(meter, value_si);
        let trouble = match state {
            State::Overload => Some(Trouble::Overload),
            State::Hold => Some(Trouble::Hold),
            State::LowBattery => Some(Trouble::LowBattery),
            State::Running | State::Peak => None,
        };
        if let Some(said) = trouble.and_then(|trouble| self.trouble(trouble, meter)) {
            return Some(said);
        }
        let unit = meter.unit();
        // As the display rounds it.
        let shown = meter.digits(value_si);
        let size = shown.steps as f64 / 10_f64.powi(shown.decimals as i32);
        let value = if shown.negative { -size } else { size };
        let said = Said {
            value,
            decimals: unit.decimals as u8,
            state,
            ..Self::said(meter)
        };
        let mut packets = self.description.grammar.values.iter();
        let written = packets.find_map(|packet| match packet {
            ValuePacket::Text(pattern) => pattern.write(&said),
            ValuePacket::Registers(registers) => match self.description.framing.kind {
                FramingKind::Modbus {
                    slave,
                    function,
                    data_bytes,
                } => registers.write(value, slave, function, data_bytes),
                _ => None,
            },
        });
        match written {
            Some(packet) => Some(self.ended(packet)),
            None => self.trouble(Trouble::Overload, meter),
        }
    }

    fn said(meter: &Meter) -> Said<'_> {
        Said {
            value: 0.0,
            decimals: 0,
            unit: &meter.unit().name,
            unit_place: u8::try_from(meter.unit_place()).unwrap_or_default(),
            state: State::Running,
            list: None,
        }
    }

    /// A packet that says that something is wrong, if the gauge has one.
    fn trouble(&self, trouble: Trouble, meter: &Meter) -> Option<Vec<u8>> {
        let mut errors = self.description.grammar.errors.iter();
        let said = Self::said(meter);
        let packet = errors
            .find(|error| error.meaning == trouble)
            .and_then(|error| error.pattern.write(&said))?;
        Some(self.ended(packet))
    }

    fn reply(&self, meaning: ReplyMeaning, meter: &Meter, list: Option<&[u8]>) -> Option<Vec<u8>> {
        let mut replies = self.description.grammar.replies.iter();
        let pattern: &Pattern = &replies.find(|reply| reply.meaning == meaning)?.pattern;
        let said = Said {
            list,
            ..Self::said(meter)
        };
        Some(self.ended(pattern.write(&said)?))
    }

    /// An answer in words.
    fn told(&self, role: Role, command: &Command, meter: &Meter) -> Option<Vec<u8>> {
        let reply = |meaning, list: Option<&[u8]>| self.reply(meaning, meter, list);
        let written = match role {
            Role::Identify => reply(ReplyMeaning::Identity, None),
            Role::QueryUnit => reply(ReplyMeaning::Unit, None)
                .or_else(|| reply(ReplyMeaning::Units, Some(&self.unit_list(meter)))),
            Role::QueryMode => reply(ReplyMeaning::State, None)
                .or_else(|| reply(ReplyMeaning::Units, Some(&self.unit_list(meter)))),
            _ => reply(ReplyMeaning::Text, None),
        };
        if written.is_some() {
            return written;
        }
        let text = match role {
            Role::Identify => format!("emulated {}", self.description.name),
            Role::QueryUnit => self.code(&meter.unit().name).to_owned(),
            Role::QueryMode => mode_text(command, meter),
            _ => "OK".to_owned(),
        };
        Some(self.ended(text.into_bytes()))
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
    fn echo(&self, command: &Command) -> Vec<u8> {
        match self.description.framing.kind {
            FramingKind::Line { .. } => self.ended(command.bytes.trim_ascii_end().to_vec()),
            _ => command.bytes.clone(),
        }
    }

    fn ended(&self, packet: Vec<u8>) -> Vec<u8> {
        self.description.framing.ended(packet)
    }
}

fn state(meter: &Meter, value_si: f64) -> State {
    if meter.overloaded(value_si) {
        State::Overload
    } else if meter.is_held() {
        State::Hold
    } else if meter.peak_mode {
        State::Peak
    } else if meter.battery_low {
        State::LowBattery
    } else {
        State::Running
    }
}

/// The answer to the question for the mode: a word that the description refuses if the gauge is in that state, else one that it does not.
fn mode_text(command: &Command, meter: &Meter) -> String {
    let state = state(meter, 0.0);
    let told = command
        .refuse
        .iter()
        .find(|(_, why)| state.is_told_by(why))
        .map(|(word, _)| word.clone());
    told.unwrap_or_else(|| "RUN".to_owned())
}

impl Maker for Described {
    fn receive(&mut self, meter: &mut Meter, bytes: &[u8], now_s: f64, out: &mut Packets) {
        for byte in bytes {
            self.heard.push(*byte);
            self.hear(meter, now_s, out);
        }
    }

    fn tick(&mut self, meter: &mut Meter, now_s: f64, out: &mut Packets) {
        if self.sends_unasked() && !self.stream.is_on() {
            self.start(now_s);
        }
        for _ in 0..self.stream.due(now_s) {
            out.extend(self.value(meter));
        }
    }

    fn next_due_s(&self) -> Option<f64> {
        let unasked = self.sends_unasked().then_some(0.0);
        self.stream.next_due_s().or(unasked)
    }

    fn data_key(&mut self, meter: &mut Meter, _now_s: f64, out: &mut Packets) {
        out.extend(self.value(meter));
    }
}
