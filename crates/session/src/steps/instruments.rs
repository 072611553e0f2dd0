//! What comes from the gauges, and who they are.

use crate::event::{Event, InstrumentSeen, LinkChange, Outcome};
use crate::feed::link_text;
use crate::operator::Bell;
use stiffbench_gauges::{Ask, Channel, GaugeEvent, LinkState};

use super::{Action, Job, Machine};

impl Machine {
    pub(super) fn gauge(&mut self, event: GaugeEvent, out: &mut Vec<Action>) {
        match event {
            GaugeEvent::Sample { channel, sample } => {
                let was_blocked = self.feed(channel).blocked.is_some();
                if let Err(reason) = self.feeds[channel.index()].sample(sample) {
                    self.hold_up(channel, reason, out);
                } else {
                    if was_blocked {
                        self.say(format!("the {channel} gauge is good again"), out);
                    }
                    self.watch_load(channel);
                }
            }
            GaugeEvent::Rejected { channel, rejected } => {
                let text = format!("{} [{}]", rejected.reason, rejected.raw);
                if self.feed(channel).blocked.is_none() {
                    self.message(format!("{channel} gauge: {text}"), true, out);
                }
                self.feeds[channel.index()].reject(&rejected);
                self.left_band();
            }
            GaugeEvent::Answered {
                channel,
                ask,
                answer,
            } => self.answered(channel, ask, answer, out),
            GaugeEvent::Link { channel, state, .. } => self.link(channel, &state, out),
            GaugeEvent::Note { channel, text, .. } => {
                self.say(format!("{channel} gauge: {text}"), out);
            }
            GaugeEvent::Ended => {
                self.end(Outcome::Partial, "the gauges have nothing more to say", out);
            }
        }
    }

    /// The line to a gauge went down or came back.
    fn link(&mut self, channel: Channel, state: &LinkState, out: &mut Vec<Action>) {
        self.feeds[channel.index()].link(state);
        self.left_band();
        let text = link_text(state);
        if let LinkState::Connected { port } = state {
            self.ports[channel.index()] = port.to_string();
            // What it was asked before it was there has no answer.
            if !self.checked && self.job == Some(Job::CheckInstruments) {
                self.ask_who(channel, out);
            }
        }
        if self.links[channel.index()] != text {
            self.links[channel.index()].clone_from(&text);
            self.say(format!("{channel} gauge: {text}"), out);
            self.record(Event::Link(LinkChange { channel, text }), out);
        }
    }

    /// Nothing of a gauge may be used until it is good again.
    fn hold_up(&mut self, channel: Channel, reason: String, out: &mut Vec<Action>) {
        if self.feed(channel).blocked.as_ref() != Some(&reason) {
            self.message(reason.clone(), true, out);
            out.push(Action::Bell(Bell::Attention));
            let text = reason.clone();
            self.record(Event::Link(LinkChange { channel, text }), out);
        }
        self.feeds[channel.index()].block(reason);
        self.left_band();
    }

    fn answered(
        &mut self,
        channel: Channel,
        ask: Ask,
        answer: Result<Box<str>, Box<str>>,
        out: &mut Vec<Action>,
    ) {
        match ask {
            Ask::Identity => {
                self.identities[channel.index()] = Some(answer.unwrap_or_default().into());
            }
            Ask::Zero => self.zero_answered(channel, answer, out),
            Ask::State => {}
        }
    }

    /// Asks a gauge who it is and how it is set.
    pub(super) fn ask_who(&mut self, channel: Channel, out: &mut Vec<Action>) {
        self.identities[channel.index()] = None;
        out.push(Action::Ask(channel, Ask::Identity));
        out.push(Action::Ask(channel, Ask::State));
    }

    /// Waits for a value of each gauge and for both answers, then keeps what they are.
    pub(super) fn check_instruments(&mut self, out: &mut Vec<Action>) {
        let good = self.feeds.iter().all(|feed| feed.is_good(self.now_s));
        if !good || self.identities.iter().any(Option::is_none) {
            return;
        }
        for channel in Channel::ALL {
            let identity = self.identities[channel.index()].clone().unwrap_or_default();
            let Some(last) = &self.feed(channel).last else {
                return;
            };
            let seen = InstrumentSeen {
                channel,
                identity: identity.clone(),
                port: self.ports[channel.index()].clone(),
                unit: last.unit.to_string(),
                resolution_si: last.resolution_si,
            };
            let known = self.state.instruments[channel.index()].as_ref();
            if known.is_some_and(|known| !known.identity.is_empty() && known.identity != identity) {
                self.ask_other_gauge(channel, &identity, out);
                return;
            }
            let changed = known != Some(&seen);
            if identity.is_empty() {
                self.say(format!("the {channel} gauge does not say who it is"), out);
            }
            if changed {
                self.record(Event::Instrument(seen), out);
            }
        }
        self.checked = true;
        self.done();
    }
}
