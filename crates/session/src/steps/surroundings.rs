//! The surroundings: temperature, humidity and what is odd at the bench, asked for at the start, after each resume, and at the end.

use crate::answers_file::{HUMIDITIES_PERCENT, TEMPERATURES_DEG_C};
use crate::event::{Event, Noted};
use crate::operator::{Answer, Prompt, PromptKind};
use crate::surroundings::{Occasion, Surroundings};

use super::answers::Why;
use super::{Action, Job, Machine};

/// A question about the surroundings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct SurroundingsQuestion {
    occasion: Occasion,
    about: About,
}

/// What it is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum About {
    Temperature,
    Humidity,
    Notes,
}

/// The questions of an occasion, in order.
pub(super) fn surroundings(occasion: Occasion) -> [Job; 3] {
    [About::Temperature, About::Humidity, About::Notes]
        .map(|about| Job::Surroundings(SurroundingsQuestion { occasion, about }))
}

impl SurroundingsQuestion {
    fn id(self) -> &'static str {
        match (self.about, self.occasion) {
            (About::Temperature, Occasion::Start) => "temperature",
            (About::Temperature, Occasion::End) => "temperature-end",
            (About::Humidity, Occasion::Start) => "humidity",
            (About::Humidity, Occasion::End) => "humidity-end",
            (About::Notes, Occasion::Start) => "bench-note",
            (About::Notes, Occasion::End) => "bench-note-end",
        }
    }
}

impl Machine {
    pub(super) fn ask_surroundings(&mut self, of: SurroundingsQuestion, out: &mut Vec<Action>) {
        let number = |unit, range| PromptKind::Number { unit, range };
        let (text, kind, detail) = match of.about {
            About::Temperature => (
                "How warm is it at the bench?",
                number("degC", TEMPERATURES_DEG_C),
                match of.occasion {
                    Occasion::Start => "Left blank, the readings have no temperature.",
                    Occasion::End => "All readings are done. It may be left blank.",
                },
            ),
            About::Humidity => (
                "How large is the relative humidity at the bench?",
                number("%", HUMIDITIES_PERCENT),
                "It may be left blank.",
            ),
            About::Notes => (
                "Is anything at the bench worth a note?",
                PromptKind::Text,
                "It may be left blank.",
            ),
        };
        let mut prompt = Prompt::new(of.id(), text, kind);
        prompt.details = vec![detail.to_owned()];
        prompt.default = Some(Answer::Text(String::new()));
        self.ask(prompt, Why::Surroundings(of), out);
    }

    pub(super) fn surroundings_answered(
        &mut self,
        of: SurroundingsQuestion,
        answer: &Answer,
        out: &mut Vec<Action>,
    ) {
        match (of.about, answer) {
            (About::Temperature, Answer::Number(deg_c)) => {
                self.surroundings.temperature_deg_c = Some(*deg_c);
            }
            (About::Humidity, Answer::Number(percent)) => {
                self.surroundings.humidity_percent = Some(*percent);
            }
            (About::Notes, Answer::Text(text)) if !text.trim().is_empty() => {
                let noted = Noted {
                    cell: None,
                    text: format!("bench at the {}: {}", of.occasion, text.trim()),
                };
                self.record(Event::Note(noted), out);
            }
            _ => {}
        }
        if of.about == About::Humidity {
            let entered = std::mem::take(&mut self.surroundings);
            if !entered.is_empty() {
                let occasion = Some(of.occasion);
                let entered = Surroundings {
                    occasion,
                    ..entered
                };
                self.record(Event::Environment(entered), out);
            }
        }
        self.asked_at_end |= (of.about, of.occasion) == (About::Notes, Occasion::End);
        self.done();
    }
}
