//! A trace through the decoder that the live lines use.

use crate::{Ask, GaugeEvent, LinkState};
use crate::{CommandRole, InstrumentDescription};
use crate::{Decoded, Decoder, DecoderError, Meaning};

use super::{GaugeTrace, TraceEntry, What};

/// The content of a trace, with the time of each event, s: the samples that the live run gave, and all else that came.
///
/// # Errors
/// [`DecoderError`] if the description needs a unit and neither `unit` nor the trace names it.
pub fn events_of(
    trace: &GaugeTrace,
    description: &InstrumentDescription,
    unit: Option<&str>,
) -> Result<Vec<(f64, GaugeEvent)>, DecoderError> {
    let unit = unit.or(trace.header.unit.as_deref());
    let fresh = Decoder::new(description, unit)?;
    let mut replayed = Replayed {
        description,
        decoder: fresh.clone(),
        fresh,
        // Silence is measured in real seconds.
        received: 0,
        idle_s: description.idle_gap_s() * trace.header.speed.unwrap_or(1.0),
        last_byte_s: None,
        asked: None,
        decoded: Vec::new(),
        events: Vec::new(),
    };
    for entry in &trace.entries {
        replayed.take(entry);
    }
    replayed.close_packet(f64::INFINITY);
    Ok(replayed.events)
}

struct Replayed<'a> {
    description: &'a InstrumentDescription,
    decoder: Decoder,
    /// The decoder that a line begins with whenever its port is opened.
    fresh: Decoder,
    /// Bytes that the gauge sent so far.
    received: u64,
    idle_s: f64,
    last_byte_s: Option<f64>,
    asked: Option<Ask>,
    decoded: Vec<Decoded>,
    events: Vec<(f64, GaugeEvent)>,
}

impl Replayed<'_> {
    fn take(&mut self, entry: &TraceEntry) {
        let channel = self.description.channel;
        let at_s = entry.at_s;
        self.close_packet(at_s);
        match &entry.what {
            What::Received(bytes) => {
                self.decoder.push(bytes, at_s, &mut self.decoded);
                self.received += bytes.len() as u64;
                self.last_byte_s = Some(at_s);
                self.report(at_s);
            }
            What::Sent { role, bytes } => {
                if let Some(role) = role.or_else(|| self.role_of(bytes)) {
                    self.decoder.asked(role);
                    self.asked = ask_of(role);
                }
            }
            What::Unused { count, .. } => self.forget(*count),
            What::Reset => {
                self.decoder.reset();
                self.last_byte_s = None;
            }
            What::Link(state) => {
                if matches!(state, LinkState::Lost { .. }) {
                    self.decoder = self.fresh.clone().behind(self.received);
                    self.last_byte_s = None;
                }
                let state = state.clone();
                self.events.push((
                    at_s,
                    GaugeEvent::Link {
                        channel,
                        state,
                        at_s,
                    },
                ));
            }
            What::Note(text) => {
                let text = text.as_str().into();
                self.events.push((
                    at_s,
                    GaugeEvent::Note {
                        channel,
                        text,
                        at_s,
                    },
                ));
            }
            What::End => {}
        }
    }

    /// Ends a packet by silence, where the live line would have.
    fn close_packet(&mut self, now_s: f64) {
        if let Some(last_s) = self.last_byte_s
            && now_s - last_s >= self.idle_s
        {
            self.last_byte_s = None;
            self.decoder.idle(last_s, &mut self.decoded);
            self.report(last_s);
        }
    }

    fn report(&mut self, at_s: f64) {
        let channel = self.description.channel;
        for item in self.decoded.drain(..) {
            let event = match item {
                Decoded::Sample(sample) => GaugeEvent::Sample { channel, sample },
                Decoded::Rejected(rejected) => GaugeEvent::Rejected { channel, rejected },
                Decoded::Reply(reply) => match self.asked.take() {
                    Some(ask) => GaugeEvent::Answered {
                        channel,
                        ask,
                        answer: reported(reply.meaning),
                    },
                    None => GaugeEvent::Note {
                        channel,
                        text: format!("the gauge reports {}", reply.raw).into(),
                        at_s,
                    },
                },
            };
            self.events.push((at_s, event));
        }
    }

    /// Takes the last samples back.
    fn forget(&mut self, count: usize) {
        for _ in 0..count {
            let is_sample =
                |(_, event): &(f64, GaugeEvent)| matches!(event, GaugeEvent::Sample { .. });
            let Some(place) = self.events.iter().rposition(is_sample) else {
                return;
            };
            self.events.remove(place);
        }
    }

    /// What bytes ask for that were recorded without a word for it.
    fn role_of(&self, bytes: &[u8]) -> Option<CommandRole> {
        let roles = [
            CommandRole::Read,
            CommandRole::Identify,
            CommandRole::QueryUnit,
            CommandRole::QueryMode,
            CommandRole::Zero,
            CommandRole::StreamStart,
            CommandRole::StreamStop,
        ];
        roles.into_iter().find(|role| {
            self.description
                .command(*role)
                .is_some_and(|command| command.bytes == bytes)
        })
    }
}

fn ask_of(role: CommandRole) -> Option<Ask> {
    match role {
        CommandRole::Zero => Some(Ask::Zero),
        CommandRole::Identify => Some(Ask::Identity),
        CommandRole::QueryUnit | CommandRole::QueryMode => Some(Ask::State),
        _ => None,
    }
}

fn reported(meaning: Meaning) -> Result<Box<str>, Box<str>> {
    match meaning {
        Meaning::Acknowledged => Ok("".into()),
        Meaning::Refused(why) => Err(why.into()),
        Meaning::Identity(text)
        | Meaning::Unit(text)
        | Meaning::State(text)
        | Meaning::Text(text) => Ok(text.into()),
    }
}
