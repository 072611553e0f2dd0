//! What is asked on the way, and what an answer does.

use crate::event::{Event, InstrumentSeen, Noted, Skipped, Superseded, Surroundings};
use crate::operator::{Answer, Prompt, PromptKind, SkipScope};
use stiffbench_gauges::Channel;

use super::{Action, Job, Machine};

/// What an open question is about.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Why {
    Ready,
    Temperature,
    SetUp(usize),
    OtherGauge(Channel, String),
    /// Which way force and displacement counted under a push.
    Way([f64; 2]),
    SignDiffers {
        push: f64,
        way: [f64; 2],
    },
    ZeroNotShown(Channel),
    ForceOffset,
    ForceSign,
    Doubt(&'static str),
    NotSettled,
    Drift,
    SkipReason(SkipScope),
    NoteText,
    RedoCell(usize),
}

impl Machine {
    pub(super) fn ask_temperature(&mut self, out: &mut Vec<Action>) {
        let kind = PromptKind::Number {
            unit: "degC",
            range: [-40.0, 80.0],
        };
        let mut prompt = Prompt::new("temperature", "How warm is it at the bench?", kind);
        prompt.details = vec!["Left blank, the readings have no temperature.".to_owned()];
        prompt.default = Some(Answer::Text(String::new()));
        self.ask(prompt, Why::Temperature, out);
    }

    pub(super) fn ask_set_up(&mut self, cell: usize, out: &mut Vec<Action>) {
        let planned = &self.plan.cells[cell];
        let text = format!(
            "Set pose {} and mount jack and gauges along {} ({}). Done?",
            planned.pose,
            planned.direction,
            planned.direction.word()
        );
        let mut prompt = Prompt::confirm("setup", text);
        prompt.key = Some(format!("{}.{}", planned.pose, planned.direction));
        self.ask(prompt, Why::SetUp(cell), out);
    }

    pub(super) fn ask_other_gauge(
        &mut self,
        channel: Channel,
        identity: &str,
        out: &mut Vec<Action>,
    ) {
        let known = self.state.instruments[channel.index()].as_ref();
        let known = known.map_or("", |known| known.identity.as_str());
        let text = format!(
            "The {channel} gauge says it is \"{identity}\"; the session began with \"{known}\". Go on with this one?"
        );
        let mut prompt = Prompt::confirm("other-gauge", text);
        prompt.key = Some(channel.to_string());
        self.ask(prompt, Why::OtherGauge(channel, identity.to_owned()), out);
    }

    /// Takes an answer, if it is one to the open question.
    pub(super) fn answer(&mut self, id: &str, answer: &Answer, out: &mut Vec<Action>) {
        let Some(pending) = self.pending.take_if(|pending| pending.prompt.id == id) else {
            return;
        };
        if let Some(complaint) = pending.prompt.complaint(answer) {
            self.message(complaint, true, out);
            out.push(Action::Prompt(pending.prompt.clone()));
            self.pending = Some(pending);
            return;
        }
        let word = match answer {
            Answer::Text(word) => word.as_str(),
            _ => "",
        };
        let yes = *answer == Answer::Yes(true);
        match pending.why {
            Why::Ready => self.done(),
            Why::Temperature => self.temperature(answer, out),
            Why::SetUp(cell) if yes => self.set_up(cell, out),
            Why::SetUp(_) => {
                self.done();
                self.pause(out);
            }
            Why::OtherGauge(channel, identity) => self.other_gauge(channel, identity, yes, out),
            Why::Way(way) => self.way(word, way, out),
            Why::SignDiffers { push, way } if word == "use" => {
                self.keep_signs(push, way, "hand push, other than described", out);
            }
            Why::SignDiffers { .. } => self.reroute(),
            Why::ZeroNotShown(channel) => self.zero_not_shown(channel, word, out),
            Why::ForceOffset if word == "zero" => self.done(),
            Why::ForceSign if word == "flip" => {
                self.flip(Channel::Force, "loads went the other way", out);
            }
            Why::ForceOffset | Why::ForceSign => {}
            Why::Doubt(rule) => self.doubt_answered(rule, word, out),
            Why::NotSettled if word == "take" => self.take_unsettled(out),
            Why::NotSettled => {}
            Why::Drift if word == "redo" => self.redo_zero(out),
            Why::Drift => {}
            Why::SkipReason(what) => self.skip(what, word, out),
            Why::NoteText => self.note(word, out),
            Why::RedoCell(cell) if yes => self.redo_cell(cell, out),
            Why::RedoCell(_) => {}
        }
    }

    fn temperature(&mut self, answer: &Answer, out: &mut Vec<Action>) {
        if let Answer::Number(temperature_deg_c) = *answer {
            self.record(Event::Environment(Surroundings { temperature_deg_c }), out);
        }
        self.done();
    }

    fn other_gauge(
        &mut self,
        channel: Channel,
        identity: String,
        yes: bool,
        out: &mut Vec<Action>,
    ) {
        let Some(last) = self.feed(channel).last.as_ref().filter(|_| yes) else {
            // Asked once more when another gauge has been plugged in.
            self.identities[channel.index()] = None;
            self.done();
            self.queue.push_front(Job::CheckInstruments);
            return;
        };
        let seen = InstrumentSeen {
            channel,
            identity,
            port: self.ports[channel.index()].clone(),
            unit: last.unit.to_string(),
            resolution_si: last.resolution_si,
        };
        self.record(Event::Instrument(seen), out);
    }

    fn way(&mut self, word: &str, way: [f64; 2], out: &mut Vec<Action>) {
        match word {
            "minus" => self.way_told(-1.0, way, out),
            "plus" => self.way_told(1.0, way, out),
            _ => self.reroute(),
        }
    }

    fn doubt_answered(&mut self, rule: &'static str, word: &str, out: &mut Vec<Action>) {
        match word {
            "accept" => {
                if let Some(load) = &mut self.load {
                    load.accepted.push(rule);
                }
            }
            "flip" => self.flip(Channel::Displacement, "loads went the other way", out),
            "skip" => self.skip(SkipScope::Reading, rule, out),
            _ => self.forget_windows(),
        }
    }

    fn take_unsettled(&mut self, out: &mut Vec<Action>) {
        if let Some(load) = &mut self.load {
            load.accepted.push("not-settled");
        }
        if let Some(Job::Read { cell, index }) = self.job {
            self.capture(cell, index, out);
        }
    }

    /// Leaves out what is open, with a reason.
    pub(super) fn skip(&mut self, what: SkipScope, reason: &str, out: &mut Vec<Action>) {
        let open = match self.job {
            Some(Job::Read { cell, index }) => Some((cell, index)),
            _ => self.plan.next_open(&self.state, self.focus),
        };
        let Some((cell, index)) = open else {
            return;
        };
        let last = match what {
            SkipScope::Reading => index,
            SkipScope::Cell => self.plan.cells[cell].readings.len() - 1,
        };
        for index in index..=last {
            if self.state.taken.contains_key(&(cell, index)) {
                continue;
            }
            let reason = reason.to_owned();
            self.record(
                Event::Skipped(Skipped {
                    cell,
                    index,
                    reason,
                }),
                out,
            );
        }
        self.reroute();
    }

    /// Keeps the operator's words.
    pub(super) fn note(&mut self, text: &str, out: &mut Vec<Action>) {
        let noted = Noted {
            cell: self.mounted,
            text: text.to_owned(),
        };
        self.record(Event::Note(noted), out);
    }

    fn redo_cell(&mut self, cell: usize, out: &mut Vec<Action>) {
        let of_cell = self.state.taken.iter().filter(|((of, _), _)| *of == cell);
        let numbers: Vec<u32> = of_cell
            .filter_map(|(_, &place)| Some(self.state.readings.get(place)?.taken.number))
            .collect();
        for number in numbers {
            let reason = "the cell is measured once more".to_owned();
            self.record(Event::Superseded(Superseded { number, reason }), out);
        }
        self.focus = cell;
        self.reroute();
    }
}
