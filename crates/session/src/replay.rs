//! A recorded session once more: the values of its traces and the decisions of its operator, through the machine of a live session.

use std::collections::VecDeque;
use std::time::Duration;

use jiff::Timestamp;

use stiffbench_gauges::{Ask, Channel, GaugeEvent};

use super::decision::SkipCode;
use super::event::{Event, SessionEnd};
use super::journal::{Journal, JournalError, Record, Store};
use super::operator::{Answer, OperatorEvent, Prompt, PromptKind, SkipScope};
use super::state::SessionState;
use super::steps::{Action, Input, Machine};
use super::surroundings::Occasion;

/// Answers to a choice that the record does not decide, the first that there is.
const USUAL: [&str; 6] = ["again", "wait", "same", "keep", "zero", "use"];

/// Session time between two looks at the clock, s: a live session does not wait for a value either.
const TICK_S: f64 = 0.02;

/// A command is answered though the recorded answer came up to so long before it, s: what was noticed between two values is noticed at other
/// times in a replay.
const EARLY_S: f64 = 3.0;

/// What watches a replay: the session time, s, and the event that was just kept, if one was.
pub type ReplayWatch<'a> = dyn FnMut(f64, Option<&Record>) + 'a;

/// What a session has recorded.
pub struct RecordedSession<'a> {
    /// Its journal; its first event, and those of resuming, are kept as they are.
    pub records: &'a [Record],
    /// What its traces hold with the time of each, s, in order of time.
    pub events: Vec<(f64, GaugeEvent)>,
    /// How much later than live a replay may notice something, s: poses are confirmed earlier by so much.
    pub lag_s: f64,
}

/// Replays a session, part by part where it was resumed, and gives the state at its end.
///
/// # Arguments
/// - `machine`: a machine for a session in this state. Its dwell is to be shorter than the recorded one by the lag: a load may have left as
///   soon as the recorded dwell was over.
/// - `recording`: what is replayed.
/// - `journal`: where the events of the replay go.
///
/// # Errors
/// An event that cannot be kept.
pub fn replay_session<S: Store>(
    machine: &dyn Fn(SessionState) -> Machine,
    recording: RecordedSession<'_>,
    journal: &mut Journal<S>,
    watch: &mut ReplayWatch<'_>,
) -> Result<SessionState, JournalError> {
    let recorded = recording.records;
    let mut events = VecDeque::from(recording.events);
    let mut state = SessionState::default();
    let is_start = |record: &Record| matches!(record.event, Event::Started(_) | Event::Resumed(_));
    let starts: Vec<usize> = (0..recorded.len())
        .filter(|place| is_start(&recorded[*place]))
        .collect();
    for (place, start) in starts.iter().enumerate() {
        let end = starts.get(place + 1).copied().unwrap_or(recorded.len());
        let until_s = recorded.get(end).map_or(f64::INFINITY, |next| next.t_s);
        let count = events.partition_point(|(at_s, _)| *at_s < until_s);
        let mut part = Part {
            machine: machine(state),
            recorded: &recorded[*start..end],
            events: events.drain(..count).collect(),
            acts: acts(&recorded[*start..end]),
            answer: None,
            asked: Vec::new(),
            unclaimed: Vec::new(),
            now_s: recorded[*start].t_s,
            lag_s: recording.lag_s,
            journal: &mut *journal,
            watch: &mut *watch,
        };
        part.run()?;
        state = part.machine.state().clone();
    }
    Ok(state)
}

/// What the operator did by himself, with the time of each, s.
fn acts(recorded: &[Record]) -> VecDeque<(f64, OperatorEvent)> {
    let act = |record: &Record| {
        let event = match &record.event {
            Event::Note(noted) if !noted.text.starts_with("bench at the ") => {
                let text = Some(noted.text.clone());
                OperatorEvent::Note { text }
            }
            Event::Skipped(skipped) if skipped.code != Some(SkipCode::Check) => {
                OperatorEvent::Skip {
                    what: SkipScope::Reading,
                    reason: Some(skipped.words()),
                }
            }
            Event::Superseded(superseded) if superseded.reason == "taken once more" => {
                OperatorEvent::Redo
            }
            Event::Ended(ended) if ended.by.as_deref() != Some("program") => match ended.outcome {
                SessionEnd::Complete => return None,
                SessionEnd::Partial => OperatorEvent::Interrupt,
                SessionEnd::Aborted => OperatorEvent::Abort,
            },
            _ => return None,
        };
        Some((record.t_s, event))
    };
    recorded.iter().filter_map(act).collect()
}

/// A part of a session between its start, or a resumption, and the next.
struct Part<'a, S: Store> {
    machine: Machine,
    recorded: &'a [Record],
    events: VecDeque<(f64, GaugeEvent)>,
    acts: VecDeque<(f64, OperatorEvent)>,
    /// The answer to the open question, and when it comes, s.
    answer: Option<(f64, OperatorEvent)>,
    /// What the gauges were asked and have not answered.
    asked: Vec<(Channel, Ask)>,
    /// Answers that nobody has asked for yet, with the time of each, s.
    unclaimed: Vec<(f64, GaugeEvent)>,
    now_s: f64,
    lag_s: f64,
    journal: &'a mut Journal<S>,
    watch: &'a mut ReplayWatch<'a>,
}

impl<S: Store> Part<'_, S> {
    fn run(&mut self) -> Result<(), JournalError> {
        if let Some(first) = self.recorded.first() {
            self.keep(first.event.clone())?;
        }
        while self.machine.outcome().is_none() {
            let Some((at_s, input)) = self.next() else {
                if self.goes_on_behind_the_last_value()? {
                    continue;
                }
                let actions = self.machine.stop("the recording ends here", self.now_s);
                self.act(actions)?;
                break;
            };
            while at_s > self.now_s + TICK_S {
                self.now_s += TICK_S;
                self.input(Input::Tick)?;
            }
            self.now_s = self.now_s.max(at_s);
            (self.watch)(self.now_s, None);
            match input {
                Input::Gauge(event) => self.gauge(event)?,
                input => self.input(input)?,
            }
        }
        Ok(())
    }

    /// Lets the time pass up to the last event that was recorded: whether something came of it.
    fn goes_on_behind_the_last_value(&mut self) -> Result<bool, JournalError> {
        let last_s = self.recorded.last().map_or(self.now_s, |record| record.t_s);
        while self.now_s + TICK_S <= last_s {
            self.now_s += TICK_S;
            self.input(Input::Tick)?;
            if self.machine.outcome().is_some() || self.answer.is_some() {
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// What comes first: a value, an answer, or what the operator did.
    fn next(&mut self) -> Option<(f64, Input)> {
        let value_s = self.events.front().map(|(at_s, _)| *at_s);
        let times_s = [self.answer.as_ref(), self.acts.front()];
        let [answer_s, act_s] = times_s.map(|next| next.map(|(at_s, _)| *at_s));
        let answers = answer_s.is_some_and(|answer_s| act_s.is_none_or(|act_s| answer_s <= act_s));
        match (value_s, if answers { answer_s } else { act_s }) {
            // Without values nothing goes on, but for questions at the end.
            (value_s, Some(act_s)) if value_s.is_none_or(|value_s| act_s <= value_s) => {
                let acted = if answers {
                    self.answer.take()
                } else {
                    self.acts.pop_front()
                };
                acted.map(|(at_s, event)| (at_s, Input::Operator(event)))
            }
            _ => {
                let (at_s, event) = self.events.pop_front()?;
                Some((at_s, Input::Gauge(event)))
            }
        }
    }

    /// A value, or an answer of a gauge: one that nobody has asked for waits until somebody does.
    fn gauge(&mut self, event: GaugeEvent) -> Result<(), JournalError> {
        if let GaugeEvent::Answered { channel, ask, .. } = &event {
            let asked = (*channel, *ask);
            let Some(place) = self.asked.iter().position(|open| *open == asked) else {
                self.unclaimed.push((self.now_s, event));
                return Ok(());
            };
            self.asked.remove(place);
        }
        self.input(Input::Gauge(event))
    }

    /// The answer to a question that comes at once; `None` where the recorded one is still to come.
    fn ask(&mut self, channel: Channel, ask: Ask) -> Option<GaugeEvent> {
        let is_answer = |event: &GaugeEvent| matches!(event, GaugeEvent::Answered { channel: of, ask: what, .. } if (*of, *what) == (channel, ask));
        let oldest_s = if ask == Ask::Zero {
            self.now_s - EARLY_S
        } else {
            f64::NEG_INFINITY
        };
        let came = |(at_s, event): &(f64, GaugeEvent)| *at_s >= oldest_s && is_answer(event);
        if let Some(place) = self.unclaimed.iter().rposition(came) {
            return Some(self.unclaimed.remove(place).1);
        }
        if self.events.iter().any(|(_, event)| is_answer(event)) {
            self.asked.push((channel, ask));
            return None;
        }
        Some(GaugeEvent::Answered {
            channel,
            ask,
            answer: Err("no answer to that was recorded".into()),
        })
    }

    fn input(&mut self, input: Input) -> Result<(), JournalError> {
        let mut inputs = VecDeque::from([input]);
        while let Some(input) = inputs.pop_front() {
            let actions = self.machine.input(input, self.now_s);
            let acted = !actions.is_empty();
            inputs.extend(self.act(actions)?);
            if acted && inputs.is_empty() {
                inputs.push_back(Input::Tick);
            }
        }
        Ok(())
    }

    fn act(&mut self, actions: Vec<Action>) -> Result<Vec<Input>, JournalError> {
        let mut answers = Vec::new();
        for action in actions {
            match action {
                Action::Record(event) => self.keep(*event)?,
                Action::Prompt(prompt) => self.answer = Some(self.answer_to(&prompt)),
                Action::CheckRepeats(_) => answers.push(Input::RepeatsChecked(Vec::new())),
                Action::Ask(channel, ask) => {
                    answers.extend(self.ask(channel, ask).map(Input::Gauge));
                }
                Action::Bell(_) | Action::Say(_) | Action::Finish(_) => {}
            }
        }
        Ok(answers)
    }

    fn keep(&mut self, event: Event) -> Result<(), JournalError> {
        let record = self.journal.append(event, self.utc(), self.now_s)?;
        self.machine.recorded(&record);
        (self.watch)(self.now_s, Some(&record));
        Ok(())
    }

    fn utc(&self) -> Timestamp {
        let Some(first) = self.recorded.first() else {
            return Timestamp::UNIX_EPOCH;
        };
        let passed = Duration::try_from_secs_f64(self.now_s - first.t_s).unwrap_or_default();
        first.utc.checked_add(passed).unwrap_or(first.utc)
    }

    /// How the operator answered, and when, s.
    fn answer_to(&self, prompt: &Prompt) -> (f64, OperatorEvent) {
        let next = |is: &dyn Fn(&Event) -> bool| {
            let mut later = self.recorded.iter();
            let later = later.find(|record| record.t_s >= self.now_s && is(&record.event));
            later.map_or(self.now_s, |record| record.t_s)
        };
        let (at_s, answer) = match prompt.id.as_str() {
            "ready" => (self.now_s, Answer::Yes(true)),
            "setup" => {
                let is_same = |event: &Event| match (event, &prompt.key) {
                    (Event::PoseSet(set), Some(key)) => {
                        format!("{}.{}", set.pose, set.direction) == *key
                    }
                    _ => false,
                };
                let at_s = (next(&is_same) - self.lag_s).max(self.now_s);
                (at_s, Answer::Yes(true))
            }
            "sign-check" => {
                let way = if self.machine.load_sense() < 0.0 {
                    "minus"
                } else {
                    "plus"
                };
                let checked = next(&|event| matches!(event, Event::SignCheck(_)));
                (checked, Answer::Text(way.to_owned()))
            }
            id => (
                self.now_s,
                self.entered(id).unwrap_or_else(|| self.usual(prompt)),
            ),
        };
        let id = prompt.id.clone();
        (at_s, OperatorEvent::Answer { id, answer })
    }

    /// What was entered of the surroundings.
    fn entered(&self, id: &str) -> Option<Answer> {
        let (about, occasion) = match id.strip_suffix("-end") {
            Some(about) => (about, Occasion::End),
            None => (id, Occasion::Start),
        };
        let number = self.recorded.iter().find_map(|record| match &record.event {
            // Without an occasion it is of an older version, which asked at the start only.
            Event::Environment(of) if of.occasion.unwrap_or(Occasion::Start) == occasion => {
                match about {
                    "temperature" => of.temperature_deg_c,
                    "humidity" => of.humidity_percent,
                    _ => None,
                }
            }
            _ => None,
        });
        let note = self.recorded.iter().find_map(|record| match &record.event {
            Event::Note(noted) if about == "bench-note" => noted
                .text
                .strip_prefix(&format!("bench at the {occasion}: ")),
            _ => None,
        });
        let note = note.map(|note| Answer::Text(note.to_owned()));
        number.map(Answer::Number).or(note)
    }

    /// What the record shows of a decision, or else what is usual.
    fn usual(&self, prompt: &Prompt) -> Answer {
        let was_accepted = self.recorded.iter().any(|record| match &record.event {
            Event::Reading(taken) => taken.flag.contains(&format!("{}:", prompt.id)),
            _ => false,
        });
        match (&prompt.kind, &prompt.default) {
            (PromptKind::Choice(choices), default) => {
                let has = |word: &&str| choices.iter().any(|choice| choice.word == *word);
                let accept = Some("accept").filter(|_| was_accepted).filter(has);
                let usual = accept.or_else(|| USUAL.into_iter().find(|word| has(word)));
                let first = choices.first().map_or("", |choice| choice.word);
                match default {
                    Some(default) if accept.is_none() => default.clone(),
                    _ => Answer::Text(usual.unwrap_or(first).to_owned()),
                }
            }
            (_, Some(default)) => default.clone(),
            (PromptKind::Confirm | PromptKind::Checklist(_), None) => Answer::Yes(true),
            (PromptKind::Text | PromptKind::Number { .. }, None) => Answer::Text(String::new()),
        }
    }
}
