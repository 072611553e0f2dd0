//! The talk with a gauge, moment by moment, without a port and without waiting.

use std::collections::VecDeque;
use std::sync::Arc;

use proptest::prelude::*;

use crate::{Ask, CommandRole, Decoder, GaugeEvent, InstrumentDescription, LinkState};

use super::{Acquisition, AcquisitionSettings, Driver, DriverAction, DriverTimestamp};

const GAUGE: &str = r#"
schema = "stiffbench/instrument/1"
name = "trial"
text = "a gauge for tests"
channel = "force"
status = "documented"
[line]
baud = 9600
[timing]
reply_deadline_s = 0.5
drain_s = 0.1
retries = 2
most_per_s = 10
discard_after_open = 0
silent_after_s = 2
[commands]
terminator = "\r"
read = { send = "R", expects = "value" }
stream_start = { send = "ON", expects = "nothing", effect = "sets" }
zero = { send = "Z", expects = "acknowledgement", effect = "sets" }
identify = { send = "ID", expects = "text" }
[framing.line]
end = ["\r"]
[sign]
compression = "positive"
[unit]
from = "packet"
[unit.codes]
N = "N"
[[value]]
fields = [{ sign = { plus = ["+"], minus = ["-"] } }, { number = { count = [1, 8] } }, { blanks = [1] }, { unit = {} }]
[[error]]
meaning = "refused"
text = "the command is not known"
fields = [{ literal = "ERR" }]
[[reply]]
meaning = "acknowledged"
fields = [{ literal = "OK" }]
"#;

/// A driver and the time it is at.
struct Talk {
    driver: Driver,
    now_s: f64,
    told: Vec<GaugeEvent>,
    sent: Vec<CommandRole>,
    unused: usize,
    refused: Option<Box<str>>,
}

impl Talk {
    fn with(text: &str, acquisition_settings: AcquisitionSettings) -> Self {
        let (description, warnings) = InstrumentDescription::parse(text, "trial").unwrap();
        assert_eq!(warnings, [""; 0]);
        let decoder = Decoder::new(&description, None).unwrap();
        let driver = Driver::new(
            Arc::new(description),
            decoder,
            acquisition_settings,
            "/dev/trial",
            timestamp(0.0),
        );
        let mut talk = Self {
            driver,
            now_s: 0.0,
            told: Vec::new(),
            sent: Vec::new(),
            unused: 0,
            refused: None,
        };
        talk.turn(|_, _, _| {});
        talk
    }

    /// A polled gauge that has identified itself.
    fn polled() -> Self {
        let mut talk = Self::with(GAUGE, AcquisitionSettings::glance(POLL));
        talk.hears("trial 7\r");
        assert_eq!(talk.sent, [CommandRole::Identify, CommandRole::Read]);
        talk.sent.clear();
        talk.told.clear();
        talk
    }

    fn turn(&mut self, act: impl FnOnce(&mut Driver, DriverTimestamp, &mut Vec<DriverAction>)) {
        let mut actions = Vec::new();
        act(&mut self.driver, timestamp(self.now_s), &mut actions);
        self.driver.wake(timestamp(self.now_s), &mut actions);
        for action in actions {
            match action {
                DriverAction::Send { role, .. } => self.sent.push(role),
                DriverAction::Tell(event) => self.told.push(event),
                DriverAction::Unused { count, .. } => self.unused += count,
                DriverAction::Reset => {}
                DriverAction::Refuse { reason } => self.refused = Some(reason),
            }
        }
        assert!(
            self.driver.due_s() > self.now_s,
            "it would be woken without end at {}",
            self.now_s
        );
    }

    fn hears(&mut self, text: &str) {
        self.turn(|driver, now, actions| driver.received(text.as_bytes(), now, actions));
    }

    /// Lets time pass, waking the driver when it is due.
    fn wait(&mut self, seconds: f64) {
        let until_s = self.now_s + seconds;
        while self.driver.due_s() <= until_s {
            self.now_s = self.driver.due_s();
            self.turn(|_, _, _| {});
        }
        self.now_s = until_s;
        self.turn(|_, _, _| {});
    }

    fn values(&self) -> Vec<f64> {
        let value = |event: &GaugeEvent| match event {
            GaugeEvent::Sample { sample, .. } => Some(sample.value),
            _ => None,
        };
        self.told.iter().filter_map(value).collect()
    }

    fn links(&self) -> Vec<&LinkState> {
        let mut links = Vec::new();
        for event in &self.told {
            if let GaugeEvent::Link { state, .. } = event {
                links.push(state);
            }
        }
        links
    }

    fn notes(&self) -> usize {
        let is_note = |event: &&GaugeEvent| matches!(event, GaugeEvent::Note { .. });
        self.told.iter().filter(is_note).count()
    }

    fn answers(&self) -> Vec<&Result<Box<str>, Box<str>>> {
        let mut answers = Vec::new();
        for event in &self.told {
            if let GaugeEvent::Answered { answer, .. } = event {
                answers.push(answer);
            }
        }
        answers
    }
}

const POLL: Acquisition = Acquisition::Poll { most_per_s: 100.0 };

fn timestamp(real_s: f64) -> DriverTimestamp {
    DriverTimestamp {
        real_s,
        at_s: real_s,
    }
}

#[test]
fn values_are_asked_for_at_the_rate_of_the_description() {
    let mut talk = Talk::polled();
    for i in 0..20 {
        talk.hears(&format!("+{i} N\r"));
        talk.wait(0.1);
    }
    assert_eq!(talk.values().len(), 20);
    assert_eq!(talk.sent.len(), 20);
    assert!(matches!(talk.links()[..], [LinkState::Connected { .. }]));
    assert_eq!(talk.driver.identity(), Some("trial 7"));
}

#[test]
fn a_reply_that_comes_while_the_line_is_drained_is_not_used() {
    let mut talk = Talk::polled();
    talk.wait(0.55);
    talk.hears("+1 N\r");
    talk.wait(0.1);
    assert_eq!((talk.values(), talk.unused), (vec![], 1));
    assert_eq!(
        talk.sent,
        [CommandRole::Read],
        "asked again after the drain"
    );
    talk.hears("+2 N\r");
    assert_eq!(talk.values(), [0.0; 0], "it could still be the late one");
    talk.wait(0.1);
    assert_eq!(talk.values(), [2.0]);
}

#[test]
fn a_slow_gauge_is_distinguished_from_a_silent_one() {
    let mut talk = Talk::polled();
    // Each request is answered 0.58 s later: beyond the 0.5 s, and while the line is drained.
    let (mut asked, mut answers) = (0, VecDeque::from([talk.now_s + 0.58]));
    while talk.now_s < 30.0 {
        talk.wait(0.02);
        if answers.front().is_some_and(|at_s| *at_s <= talk.now_s) {
            answers.pop_front();
            talk.hears("+1 N\r");
        }
        for _ in asked..talk.sent.len() {
            answers.push_back(talk.now_s + 0.58);
        }
        asked = talk.sent.len();
    }
    let said = |event: &GaugeEvent| match event {
        GaugeEvent::Note { text, .. } => text.contains("later than the 0.5 s"),
        GaugeEvent::Link { state, .. } => matches!(state, LinkState::Slow { .. }),
        _ => false,
    };
    assert!(talk.told.iter().any(said), "{:?}", talk.told);
}

#[test]
fn a_reply_that_comes_after_the_drain_does_not_answer_the_next_request() {
    let mut talk = Talk::polled();
    talk.wait(0.61);
    assert_eq!(talk.sent, [CommandRole::Read]);
    // The answer to the first request, then the answer to the second.
    talk.hears("+1 N\r");
    talk.wait(0.05);
    talk.hears("+2 N\r");
    talk.wait(0.11);
    assert_eq!((talk.values(), talk.unused), (vec![], 2));
    assert_eq!(talk.sent, [CommandRole::Read, CommandRole::Read]);
    talk.hears("+3 N\r");
    talk.wait(0.11);
    assert_eq!(talk.values(), [3.0]);
    // From then on a value counts at once again.
    talk.hears("+4 N\r");
    assert_eq!(talk.values(), [3.0, 4.0]);
}

#[test]
fn a_gauge_that_never_answers_is_asked_a_bounded_number_of_times_then_seldom() {
    let mut talk = Talk::polled();
    talk.hears("+1 N\r");
    talk.wait(2.0);
    assert_eq!(talk.sent.len(), 3, "three tries: {:?}", talk.sent);
    assert_eq!(talk.links().len(), 2);
    assert_eq!(talk.links()[1], &LinkState::Silent);
    let notes = talk.notes();
    talk.wait(60.0);
    assert!((5..40).contains(&talk.sent.len()), "{}", talk.sent.len());
    assert_eq!(
        (talk.links().len(), talk.notes()),
        (2, notes),
        "that it is silent is said once"
    );
    // It is switched on again.
    while !matches!(talk.sent.last(), Some(CommandRole::Read))
        || talk.driver.due_s() > talk.now_s + 0.5
    {
        talk.wait(0.1);
    }
    talk.sent.clear();
    while talk.sent.is_empty() {
        talk.wait(0.1);
    }
    talk.hears("+5 N\r");
    talk.wait(0.11);
    assert_eq!(talk.values(), [1.0, 5.0]);
    assert!(matches!(talk.links()[2], LinkState::Connected { .. }));
}

#[test]
fn a_non_value_is_reported_and_the_line_drained_first() {
    let mut talk = Talk::polled();
    talk.hears("+1.\x00rubbish\r");
    talk.hears("+7 N\r");
    assert_eq!(talk.values(), [0.0; 0]);
    assert!(matches!(talk.told[0], GaugeEvent::Rejected { .. }));
    talk.wait(0.2);
    assert_eq!(talk.unused, 1);
    assert_eq!(talk.sent, [CommandRole::Read]);
    talk.hears("+8 N\r");
    assert_eq!(talk.values(), [8.0]);
}

#[test]
fn questions_are_answered_between_values() {
    let mut talk = Talk::polled();
    talk.turn(|driver, _, actions| driver.ask(Ask::Zero, actions));
    talk.turn(|driver, _, actions| driver.ask(Ask::State, actions));
    assert_eq!(talk.answers().len(), 1, "there is no such command");
    assert!(talk.answers()[0].is_err());
    assert!(talk.sent.is_empty(), "one thing at a time");
    talk.hears("+1 N\r");
    assert_eq!(talk.sent, [CommandRole::Zero]);
    talk.hears("Z\r");
    talk.hears("OK\r");
    assert_eq!(talk.answers()[1], &Ok("".into()));
    talk.told.clear();
    talk.turn(|driver, _, actions| driver.ask(Ask::Zero, actions));
    talk.wait(0.1);
    talk.hears("+2 N\r");
    talk.wait(0.1);
    talk.hears("ERR\r");
    assert!(
        talk.answers()[0]
            .as_ref()
            .is_err_and(|why| why.contains("not known")),
        "{:?}",
        talk.told
    );
}

#[test]
fn another_identity_is_refused_before_any_value() {
    let expecting = AcquisitionSettings {
        expected: Some("trial 7".into()),
        ..AcquisitionSettings::glance(POLL)
    };
    let mut talk = Talk::with(GAUGE, expecting.clone());
    talk.hears("trial 8\r");
    let reason = talk.refused.take().unwrap();
    assert!(
        reason.contains("trial 7") && reason.contains("trial 8"),
        "{reason}"
    );
    assert_eq!(talk.values(), [0.0; 0]);
    // One that is silent is asked again, and no value is asked for before it has identified itself.
    let mut talk = Talk::with(GAUGE, expecting);
    talk.wait(20.0);
    assert!(
        talk.sent.iter().all(|role| *role == CommandRole::Identify) && talk.sent.len() > 4,
        "{:?}",
        talk.sent
    );
    assert_eq!(talk.links(), [&LinkState::Silent]);
    while talk.sent.pop().is_some() {}
    while talk.sent.is_empty() {
        talk.wait(0.1);
    }
    talk.hears("trial 7\r");
    assert_eq!(talk.sent, [CommandRole::Identify, CommandRole::Read]);
    assert_eq!(talk.refused, None);
}

#[test]
fn a_stream_that_stops_is_noticed_and_started_again() {
    let mut talk = Talk::with(GAUGE, AcquisitionSettings::glance(Acquisition::Stream));
    talk.hears("trial 7\r");
    assert_eq!(talk.sent, [CommandRole::Identify, CommandRole::StreamStart]);
    for i in 0..30 {
        talk.hears(&format!("+{i} N\r"));
        talk.wait(0.1);
    }
    assert_eq!(talk.values().len(), 30);
    assert_eq!(talk.sent.len(), 2);
    talk.wait(2.1);
    assert_eq!(talk.links()[1], &LinkState::Silent);
    assert_eq!(talk.sent.len(), 3);
    talk.wait(600.0);
    assert!(talk.sent.len() < 200, "{}", talk.sent.len());
    talk.hears("+1 N\r");
    assert!(matches!(
        talk.links()[..],
        [_, _, LinkState::Connected { .. }]
    ));
}

#[test]
fn the_first_values_after_opening_are_left_out() {
    let text = GAUGE.replace("discard_after_open = 0", "discard_after_open = 2");
    let mut talk = Talk::with(&text, AcquisitionSettings::glance(POLL));
    talk.hears("trial 7\r");
    for i in 0..4 {
        talk.hears(&format!("+{i} N\r"));
        talk.wait(0.1);
    }
    assert_eq!((talk.values(), talk.unused), (vec![2.0, 3.0], 2));
}

#[test]
fn a_line_that_is_lost_leaves_no_question_open() {
    let mut talk = Talk::polled();
    talk.turn(|driver, _, actions| driver.ask(Ask::Zero, actions));
    talk.turn(|driver, _, actions| driver.ask(Ask::Identity, actions));
    talk.hears("+1 N\r");
    talk.turn(|driver, _, actions| driver.abandon(actions));
    assert_eq!(talk.answers().len(), 2);
    assert!(talk.answers().iter().all(|answer| answer.is_err()));
}

#[test]
fn toggling_commands_are_never_sent_at_opening() {
    let text = GAUGE.replace(
        "identify = {",
        "stream_stop = { send = \"*\", expects = \"nothing\", effect = \"toggles\" }\nidentify = {",
    );
    let talk = Talk::with(&text, AcquisitionSettings::glance(POLL));
    assert_eq!(talk.sent, [CommandRole::Identify]);
    let text = GAUGE.replace(
        "identify = {",
        "stream_stop = { send = \"OFF\", expects = \"nothing\", effect = \"sets\" }\nidentify = {",
    );
    let mut talk = Talk::with(&text, AcquisitionSettings::glance(POLL));
    assert_eq!(talk.sent, [CommandRole::StreamStop]);
    // What the stream had still under way is not used.
    talk.hears("+1 N\r");
    talk.wait(0.11);
    assert_eq!((talk.values(), talk.unused), (vec![], 1));
    assert_eq!(talk.sent, [CommandRole::StreamStop, CommandRole::Identify]);
}

#[test]
fn a_gauge_of_another_protocol_is_reported_once_until_a_value_arrives() {
    let mut talk = Talk::with(GAUGE, AcquisitionSettings::glance(POLL));
    talk.hears("trial 7\r");
    for _ in 0..20 {
        talk.hears("+1.5 mm\r");
        talk.wait(0.2);
    }
    let [LinkState::WrongDevice { reason }] = talk.links()[..] else {
        panic!("{:?}", talk.links())
    };
    assert!(
        reason.contains("+1.5 mm") && reason.contains("trial"),
        "{reason}"
    );
    assert_eq!(talk.values(), [0.0; 0]);
    talk.hears("+2 N\r");
    assert!(matches!(talk.links()[..], [_, LinkState::Connected { .. }]));
    // What is no value later on does not identify the gauge.
    for _ in 0..20 {
        talk.wait(0.2);
        talk.hears("+1.5 mm\r");
    }
    assert_eq!(talk.links().len(), 2);
}

proptest! {
    /// Whatever comes and whenever, the driver is never woken without end, asks no more often than it may, and every value was asked for.
    #[test]
    fn no_traffic_upsets_the_talk(
        traffic in prop::collection::vec(
            (
                prop::sample::select(vec!["+1 N\r", "+2", ".5 N\r", "OK\r", "ERR\r", "trial 7\r", "\0\r", "R\r", "\r"]),
                0.0..0.7_f64,
                prop::option::weighted(0.1, prop::sample::select(vec![Ask::Zero, Ask::Identity, Ask::State])),
            ),
            0..60,
        ),
        streams: bool,
    ) {
        let acquisition = if streams { Acquisition::Stream } else { POLL };
        let mut talk = Talk::with(GAUGE, AcquisitionSettings::glance(acquisition));
        let mut asked = 0;
        for (bytes, wait_s, ask) in traffic {
            if let Some(ask) = ask {
                asked += 1;
                talk.turn(|driver, _, actions| driver.ask(ask, actions));
            }
            talk.hears(bytes);
            talk.wait(wait_s);
        }
        talk.wait(0.01);
        let seconds = talk.now_s;
        talk.turn(|driver, _, actions| driver.abandon(actions));
        prop_assert_eq!(talk.answers().len(), asked);
        if !streams {
            let reads = talk.sent.iter().filter(|role| **role == CommandRole::Read).count();
            prop_assert!(talk.values().len() <= reads + 2 * 60);
            prop_assert!(reads as f64 <= 20.0 * seconds + 2.0 + 60.0, "{} in {} s", reads, seconds);
        }
    }
}
