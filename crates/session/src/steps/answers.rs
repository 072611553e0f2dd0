//! What is asked on the way, and what an answer does.

use crate::decision::{Flagged, SkipCode, Skipped, Superseded};
use crate::event::{Event, Noted};
use crate::operator::{Answer, Prompt, SkipScope};
use stiffbench_gauges::Channel;

use super::load::LoadApproach;
use super::signs::CountedWays;
use super::surroundings::SurroundingsQuestion;
use super::{Action, Job, Machine};

/// What an open question is about.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Why {
    Ready,
    Surroundings(SurroundingsQuestion),
    Unit(Channel),
    SetUp(usize),
    OtherGauge(Channel, String),
    /// Which way gauges counted under a push.
    Way(CountedWays),
    SignDiffers {
        push: f64,
        way: CountedWays,
    },
    ZeroNotShown(Channel),
    ForceOffset,
    ForceSign,
    CaptureCheck(&'static str, Channel),
    NotSettled,
    Changed,
    Drift,
    SkipReason(SkipScope),
    NoteText,
    RedoCell(usize),
    /// Readings of a run that their repeats contradict.
    Contradicted(Vec<u32>),
    /// Why they are taken again.
    RedoCause(Vec<u32>),
}

impl Why {
    /// Whether it is about the load that is on, and falls away with it.
    pub(super) fn is_of_a_load(&self) -> bool {
        match self {
            Self::ZeroNotShown(_)
            | Self::ForceOffset
            | Self::ForceSign
            | Self::CaptureCheck(..)
            | Self::NotSettled
            | Self::Changed
            | Self::Way(_)
            | Self::SignDiffers { .. } => true,
            Self::Ready
            | Self::Surroundings(_)
            | Self::Unit(_)
            | Self::SetUp(_)
            | Self::OtherGauge(..)
            | Self::Drift
            | Self::SkipReason(_)
            | Self::NoteText
            | Self::RedoCell(_)
            | Self::Contradicted(_)
            | Self::RedoCause(_) => false,
        }
    }
}

impl Machine {
    /// A gauge that does not send its unit is asked for it by way of the operator's eyes.
    pub(super) fn ask_unit(&mut self, channel: Channel, out: &mut Vec<Action>) {
        let Some(unit) = self.settings.units_by_eye[channel.index()].clone() else {
            self.done();
            return;
        };
        let text =
            format!("The {channel} gauge does not send its unit. Does its display show {unit}?");
        let same = format!("the display shows {unit}");
        let other = format!("it shows another unit: set it to {unit}, then answer");
        let choices = [("same", same.as_str()), ("other", other.as_str())];
        let mut prompt = Prompt::choice("unit", text, &choices);
        prompt.key = Some(channel.to_string());
        prompt.default = Some(Answer::Text("same".to_owned()));
        self.ask(prompt, Why::Unit(channel), out);
    }

    fn unit_answered(&mut self, channel: Channel, word: &str, out: &mut Vec<Action>) {
        if word == "same" {
            self.unit_unsure[channel.index()] = false;
            self.done();
        } else {
            self.stream_mut(channel).forget_settings();
            self.ask_unit(channel, out);
        }
    }

    pub(super) fn ask_set_up(&mut self, cell: usize, out: &mut Vec<Action>) {
        let planned = &self.plan.cells[cell];
        let axes = &self.plan.procedure.displacement_axes;
        let (pose, direction) = (&planned.pose, &planned.direction);
        let joints = self.plan.joints_text(pose);
        let text = if axes.is_empty() {
            format!(
                "Set pose {pose}{joints} and mount jack and gauges along {}. Done?",
                self.plan.direction_text(direction)
            )
        } else {
            let axes: Vec<String> = axes.iter().map(ToString::to_string).collect();
            format!(
                "Set pose {pose}{joints} and mount the jack along {}, the displacement gauges along {}. Done?",
                self.plan.direction_text(direction),
                axes.join(", ")
            )
        };
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
            "The {channel} gauge identifies itself as \"{identity}\"; the session began with \"{known}\". Continue with this one?"
        );
        let mut prompt = Prompt::confirm("other-gauge", text);
        prompt.key = Some(channel.to_string());
        self.ask(prompt, Why::OtherGauge(channel, identity.to_owned()), out);
    }

    /// A question is withdrawn when its cause disappears.
    pub(super) fn withdraw_what_is_gone(&mut self, out: &mut Vec<Action>) {
        let in_band = self.load.as_ref().is_some_and(LoadApproach::is_in_band);
        let gone = match (self.pending.as_ref().map(|open| &open.why), self.job) {
            (Some(Why::ForceOffset | Why::ForceSign), _) => in_band,
            (Some(Why::NotSettled), Some(Job::Read { cell, index })) => self.is_ready(cell, index),
            (Some(Why::CaptureCheck(rule, channel)), Some(Job::Read { cell, index })) => {
                self.is_ready(cell, index) && !self.fails_a_check(cell, index, (rule, *channel))
            }
            _ => false,
        };
        if gone && let Some(open) = self.pending.take() {
            self.notify(format!("withdrawn: {}", open.prompt.text), out);
            // What it showed before it moved again is as wrong as what it showed then.
            self.flag_while_still(out);
        }
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
            Why::Ready => {
                self.begun = true;
                self.done();
            }
            Why::Unit(channel) => self.unit_answered(channel, word, out),
            Why::Surroundings(of) => self.surroundings_answered(of, answer, out),
            Why::SetUp(cell) if yes => self.set_up(cell, out),
            Why::SetUp(_) => {
                self.done();
                self.pause(out);
            }
            Why::OtherGauge(channel, identity) => self.other_gauge(channel, identity, yes),
            Why::Way(way) => self.way(word, &way, out),
            Why::SignDiffers { push, way } if word == "use" => {
                self.keep_signs(push, &way, "hand push, other than described", out);
            }
            Why::SignDiffers { .. } => self.reroute(),
            Why::ZeroNotShown(channel) => self.zero_not_shown(channel, word, out),
            Why::ForceOffset if word == "zero" => self.done(),
            Why::ForceSign if word == "flip" => {
                self.flip(Channel::Force, "loads went the other way", out);
            }
            Why::ForceOffset | Why::ForceSign => {}
            Why::CaptureCheck(rule, channel) => {
                self.capture_check_answered((rule, channel), word, out);
            }
            Why::NotSettled if word == "take" => self.take_unsettled(out),
            Why::NotSettled => {}
            Why::Changed => self.changed_answered(word),
            Why::Drift => self.drift_answered(word, out),
            Why::SkipReason(what) => self.skip_for(what, word, out),
            Why::NoteText => self.note(word, out),
            Why::RedoCell(cell) if yes => self.redo_cell(cell, out),
            Why::RedoCell(_) => {}
            Why::Contradicted(numbers) => self.contradiction_answered(numbers, word, out),
            Why::RedoCause(numbers) => self.redo_run(&numbers, word, out),
        }
    }

    fn other_gauge(&mut self, channel: Channel, identity: String, yes: bool) {
        if yes {
            self.stream_mut(channel).forget_settings();
            self.other_accepted[channel.index()] = Some(identity);
        } else {
            // Asked once more when another gauge has been plugged in.
            self.identities[channel.index()] = None;
            self.done();
            self.queue.push_front(Job::CheckInstruments);
        }
    }

    fn way(&mut self, word: &str, way: &[(Channel, f64)], out: &mut Vec<Action>) {
        match word {
            "minus" => self.confirmed_sign(-1.0, way, out),
            "plus" => self.confirmed_sign(1.0, way, out),
            _ => self.reroute(),
        }
    }

    fn capture_check_answered(
        &mut self,
        (rule, channel): (&'static str, Channel),
        word: &str,
        out: &mut Vec<Action>,
    ) {
        if matches!(rule, "force-steps" | "displacement-steps") {
            self.coarse_answered(channel, word == "accept", out);
        }
        if rule == "displacement-sign" && matches!(word, "accept" | "skip") {
            // Readings without load do not show it.
            let since_s = self.state.zero.as_ref().map_or(0.0, |zero| zero.at_s);
            let flag = format!("the {channel} went against the force on this zero");
            self.flag_since(channel, since_s, flag, out);
        }
        if word != "accept" {
            self.flag_while_still(out);
        }
        match word {
            "accept" => {
                self.stood_still = None;
                if let Some(load) = &mut self.load {
                    load.accepted.push((rule, channel));
                }
            }
            "flip" => self.flip(channel, "loads went the other way", out),
            // What was wrong may have been the zero, or may have changed it.
            "skip" => {
                self.unsure = true;
                self.skip(SkipScope::Reading, (SkipCode::Check, rule), out);
            }
            _ if rule == "implausible" || rule == "displacement-sign" => {
                self.unsure = true;
                self.reroute();
            }
            _ => self.forget_windows(),
        }
    }

    /// A gauge that counts in coarse steps does so by its setting, or all readings since then are doubtful.
    fn coarse_answered(&mut self, channel: Channel, accepted: bool, out: &mut Vec<Action>) {
        let few = self.few_digits(channel);
        let known = self.state.instruments[channel.index()].as_ref();
        if let (true, Some(few), Some(known)) = (accepted, few, known) {
            let mut seen = known.clone();
            seen.step_si = Some(few.step as f64 * known.resolution_si);
            self.record(Event::Instrument(seen), out);
            return;
        }
        self.flag_few_digits(channel, out);
    }

    /// Flags the readings of a gauge since it uses few last digits.
    pub(super) fn flag_few_digits(&mut self, channel: Channel, out: &mut Vec<Action>) {
        let known = self.state.instruments[channel.index()].as_ref();
        let confirmed = known.is_some_and(|known| known.step_si.is_some());
        let Some(few) = self.few_digits(channel).filter(|_| !confirmed) else {
            return;
        };
        let flag = format!("the {channel} gauge showed few last digits");
        self.flag_since(channel, few.since_s, flag, out);
    }

    /// Flags what was read of the gauge that was asked about because it stood still.
    fn flag_while_still(&mut self, out: &mut Vec<Action>) {
        if let Some((channel, since_s)) = self.stood_still.take() {
            let flag = format!("the {channel} gauge stood still");
            self.flag_since(channel, since_s, flag, out);
        }
    }

    /// Flags the readings whose value of a gauge came after a time.
    fn flag_since(&mut self, channel: Channel, since_s: f64, flag: String, out: &mut Vec<Action>) {
        let since = self.state.accepted().filter(|kept| {
            kept.taken.sampled_at_s(channel) > Some(since_s) && !kept.flags.contains(&flag)
        });
        let numbers: Vec<u32> = since.map(|kept| kept.taken.number).collect();
        if !numbers.is_empty() {
            self.record(
                Event::Flagged(Flagged {
                    numbers,
                    flag,
                    by_operator: false,
                }),
                out,
            );
        }
    }

    fn take_unsettled(&mut self, out: &mut Vec<Action>) {
        if let Some(load) = &mut self.load {
            load.accepted.push(("not-settled", Channel::Force));
        }
        if let Some(Job::Read { cell, index }) = self.job {
            self.capture(cell, index, out);
        }
    }

    /// Leaves out what is open, with a reason as typed; without one nothing is.
    pub(super) fn skip_for(&mut self, what: SkipScope, typed: &str, out: &mut Vec<Action>) {
        match SkipCode::of_typed(typed) {
            Some(reason) => self.skip(what, reason, out),
            None => self.notify("nothing is left out: a reason is needed", out),
        }
    }

    fn skip(&mut self, what: SkipScope, (code, reason): (SkipCode, &str), out: &mut Vec<Action>) {
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
            let planned = &self.plan.cells[cell];
            let skipped = Skipped {
                cell,
                index,
                code: Some(code),
                reason: reason.to_owned(),
                pose: Some(planned.pose.to_string()),
                direction: Some(planned.direction.clone()),
            };
            self.record(Event::Skipped(skipped), out);
        }
        self.reroute();
    }

    /// Keeps the operator's words, on the cell that stands or is being set up.
    pub(super) fn note(&mut self, text: &str, out: &mut Vec<Action>) {
        let being_set_up = match self.job {
            Some(Job::SetUp(cell)) => Some(cell),
            _ => None,
        };
        let noted = Noted {
            cell: being_set_up.or(self.mounted),
            text: text.to_owned(),
        };
        self.record(Event::Note(noted), out);
    }

    /// These readings no longer count.
    pub(super) fn supersede(&mut self, numbers: Vec<u32>, reason: &str, out: &mut Vec<Action>) {
        for number in numbers {
            let reason = reason.to_owned();
            self.record(Event::Superseded(Superseded { number, reason }), out);
        }
    }

    fn redo_cell(&mut self, cell: usize, out: &mut Vec<Action>) {
        let of_cell = self.state.taken.iter().filter(|((of, _), _)| *of == cell);
        let numbers: Vec<u32> = of_cell
            .filter_map(|(_, &place)| Some(self.state.readings.get(place)?.taken.number))
            .collect();
        self.supersede(numbers, "the cell is measured once more", out);
        self.focus = cell;
        self.reroute();
    }
}
