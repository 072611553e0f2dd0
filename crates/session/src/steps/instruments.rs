//! What comes from the gauges, and who they are.

use crate::event::{Event, InstrumentSeen, LinkChange, SessionEnd};
use crate::link_text::link_text;
use crate::operator::Bell;
use stiffbench_gauges::{Ask, Channel, GaugeEvent, LinkState, Rejected};

use super::{Action, Job, Machine};

/// Time between two questions for the unit and mode of a gauge whose values are refused, s.
const STATE_AGAIN_S: f64 = 2.0;

/// What a session warns of from then on.
const LOW_BATTERY: &str = "change its battery";

/// A line that warns of a low battery stands between values, which go on; it holds no number that could be one.
fn warns_of_battery(rejected: &Rejected) -> bool {
    let line = rejected.raw.to_ascii_uppercase();
    line.contains("BAT") && !line.bytes().any(|byte| byte.is_ascii_digit())
}

impl Machine {
    pub(super) fn gauge(&mut self, event: GaugeEvent, out: &mut Vec<Action>) {
        let of = match &event {
            GaugeEvent::Sample { channel, .. }
            | GaugeEvent::Rejected { channel, .. }
            | GaugeEvent::Answered { channel, .. }
            | GaugeEvent::Link { channel, .. }
            | GaugeEvent::Note { channel, .. } => Some(*channel),
            GaugeEvent::Ended => None,
        };
        // A gauge that the plan does not need has no part in the session.
        if of.is_some_and(|of| !self.channels.contains(&of)) {
            return;
        }
        match event {
            // The other number of a packet is no value of this gauge.
            GaugeEvent::Sample { channel, sample } if sample.kind != channel.kind() => {}
            GaugeEvent::Sample { channel, sample }
                if self.stream_mut(channel).is_of_another_turn(&sample) =>
            {
                let own = self.stream(channel).unit.as_deref().unwrap_or_default();
                let text = format!(
                    "the {channel} gauge sends {own} and {other} in turn: values in {other} are left out",
                    other = sample.unit
                );
                if !self.settings.warnings.contains(&text) {
                    self.warn(&text, out);
                }
            }
            GaugeEvent::Sample { channel, sample } => {
                let was_blocked = self.stream(channel).blocked.is_some();
                let was_away = self.stream(channel).is_stale(sample.at_s);
                if self.state.readings.is_empty() && self.stream(channel).is_set_otherwise(&sample)
                {
                    self.set_otherwise_before_the_first_reading(channel, out);
                }
                if let Err(reason) = self.stream_mut(channel).sample(sample) {
                    self.hold_up(channel, reason, out);
                } else {
                    if was_blocked {
                        self.notify(format!("the {channel} gauge is good again"), out);
                    }
                    if was_away && self.settings.lag_s.is_finite() {
                        // Events in between were not observed.
                        self.left_band();
                    }
                    self.watch_load(channel);
                }
            }
            GaugeEvent::Rejected { channel, rejected } => {
                let text = format!("{} [{}]", rejected.reason, rejected.raw);
                if warns_of_battery(&rejected) {
                    if self
                        .settings
                        .warnings
                        .iter()
                        .all(|known| !known.contains(LOW_BATTERY))
                    {
                        let text = format!(
                            "the {channel} gauge sends \"{}\": {LOW_BATTERY}",
                            rejected.raw
                        );
                        self.warn(&text, out);
                    }
                    return;
                }
                if !self.stream(channel).is_reported(&text, self.now_s) {
                    self.message(format!("{channel} gauge: {text}"), true, out);
                }
                let now_s = self.now_s;
                self.stream_mut(channel).reject(&rejected, now_s);
                self.left_band();
            }
            GaugeEvent::Answered {
                channel,
                ask,
                answer,
            } => self.answered(channel, ask, answer, out),
            GaugeEvent::Link { channel, state, .. } => self.link(channel, &state, out),
            GaugeEvent::Note { channel, text, .. } => {
                self.notify(format!("{channel} gauge: {text}"), out);
            }
            GaugeEvent::Ended => {
                self.end(SessionEnd::Partial, "the gauges send no more values", out);
            }
        }
    }

    /// A warning that is shown, kept in the journal, and stays on the screen.
    fn warn(&mut self, text: &str, out: &mut Vec<Action>) {
        self.settings.warnings.push(text.to_owned());
        self.message(text.to_owned(), true, out);
        self.note(text, out);
    }

    /// Identity, unit and mode are asked for again; what was being done is computed again.
    fn recheck_instruments(&mut self, channel: Channel, out: &mut Vec<Action>) {
        self.checked = false;
        self.unit_unsure[channel.index()] = true;
        self.begin_histories();
        if let Some(open) = self.pending.take_if(|open| open.why.is_of_a_load()) {
            self.notify(format!("withdrawn: {}", open.prompt.text), out);
        }
        if self.pending.is_none() {
            self.reroute();
        }
    }

    /// Before the first reading nothing rests on the settings of a gauge: it may be set as it should be, and all is checked again, a zero
    /// that is set already with it.
    fn set_otherwise_before_the_first_reading(&mut self, channel: Channel, out: &mut Vec<Action>) {
        self.stream_mut(channel).forget_settings();
        self.stream_mut(channel).forget();
        self.message(
            format!("the {channel} gauge changed its unit or its number of decimals: it is checked again"),
            true,
            out,
        );
        self.unsure |= self.state.zero.is_some();
        self.recheck_instruments(channel, out);
    }

    /// The line to a gauge went down or came back.
    fn link(&mut self, channel: Channel, state: &LinkState, out: &mut Vec<Action>) {
        let now_s = self.now_s;
        self.stream_mut(channel).link(state, now_s);
        self.left_band();
        let text = link_text(state);
        let away = !matches!(state, LinkState::Connected { .. });
        let lost = away && self.checked;
        if lost {
            out.push(Action::Bell(Bell::Attention));
            self.gauge_was_away(channel, out);
        }
        if let LinkState::Connected { port } = state {
            self.ports[channel.index()] = port.to_string();
            // What it was asked before it was there has no answer.
            if !self.checked && self.job == Some(Job::CheckInstruments) {
                self.ask_who(channel, out);
            }
        }
        if self.links[channel.index()] != text {
            self.links[channel.index()].clone_from(&text);
            self.notify(format!("{channel} gauge: {text}"), out);
            self.record(
                Event::Link(LinkChange {
                    channel,
                    text,
                    lost,
                }),
                out,
            );
        }
    }

    /// A gauge that was away may have forgotten its zero, its unit and its mode: all of it is checked again before the next reading.
    fn gauge_was_away(&mut self, channel: Channel, out: &mut Vec<Action>) {
        self.unsure |= self.state.zero.is_some();
        self.compares = self.unsure;
        self.recheck_instruments(channel, out);
    }

    /// Nothing of a gauge may be used until it is good again.
    fn hold_up(&mut self, channel: Channel, reason: String, out: &mut Vec<Action>) {
        if !self.stream(channel).is_reported(&reason, self.now_s) {
            self.message(reason.clone(), true, out);
            out.push(Action::Bell(Bell::Attention));
            let text = reason.clone();
            let lost = false;
            self.record(
                Event::Link(LinkChange {
                    channel,
                    text,
                    lost,
                }),
                out,
            );
        }
        let now_s = self.now_s;
        self.stream_mut(channel).refuse(reason, now_s);
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

    /// Rings once when a gauge that has sent values falls silent.
    pub(super) fn ring_for_silence(&mut self, out: &mut Vec<Action>) {
        for channel in self.channels.clone() {
            let silent = self.checked && self.stream(channel).is_stale(self.now_s);
            let was_silent = std::mem::replace(&mut self.silent[channel.index()], silent);
            if silent && !was_silent {
                out.push(Action::Bell(Bell::Attention));
            }
        }
    }

    /// A gauge whose values are refused for its unit or mode is asked again from time to time: it may have been set correctly.
    pub(super) fn ask_state_of_refused(&mut self, out: &mut Vec<Action>) {
        if self.now_s - self.asked_state_s < STATE_AGAIN_S {
            return;
        }
        for channel in self.channels.clone() {
            if self.stream(channel).is_refused() {
                self.asked_state_s = self.now_s;
                out.push(Action::Ask(channel, Ask::State));
            }
        }
    }

    /// Asks a gauge its identity and how it is set.
    pub(super) fn ask_who(&mut self, channel: Channel, out: &mut Vec<Action>) {
        self.identities[channel.index()] = None;
        out.push(Action::Ask(channel, Ask::Identity));
        out.push(Action::Ask(channel, Ask::State));
    }

    /// Waits for a value of each gauge and for both answers, then keeps what they are.
    pub(super) fn check_instruments(&mut self, out: &mut Vec<Action>) {
        let mut channels = self.channels.iter();
        if channels.any(|channel| self.identities[channel.index()].is_none()) {
            return;
        }
        for channel in self.channels.clone() {
            let identity = self.identities[channel.index()].clone().unwrap_or_default();
            let known = self.state.instruments[channel.index()].as_ref();
            // A gauge that has not answered yet carries no information either.
            let said = !identity.is_empty() || self.stream(channel).is_good(self.now_s);
            let other = said
                && known
                    .is_some_and(|known| !known.identity.is_empty() && known.identity != identity);
            if other && self.other_accepted[channel.index()].as_ref() != Some(&identity) {
                self.ask_other_gauge(channel, &identity, out);
                return;
            }
        }
        if !self.feeds.iter().all(|stream| stream.is_good(self.now_s)) {
            return;
        }
        for channel in self.channels.clone() {
            let identity = self.identities[channel.index()].clone().unwrap_or_default();
            let Some(last) = &self.stream(channel).last else {
                return;
            };
            let known = self.state.instruments[channel.index()].as_ref();
            let seen = InstrumentSeen {
                channel,
                identity: identity.clone(),
                port: self.ports[channel.index()].clone(),
                unit: last.unit.to_string(),
                resolution_si: last.resolution_si,
                step_si: known.and_then(|known| known.step_si),
            };
            let changed = known != Some(&seen);
            if identity.is_empty() {
                self.notify(format!("the {channel} gauge does not identify itself"), out);
            }
            if changed {
                self.record(Event::Instrument(seen), out);
            }
        }
        self.checked = true;
        self.done();
    }
}
