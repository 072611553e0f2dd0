//! Keys: what a press means, and the line that is being typed.

use ratatui::crossterm::event::{KeyCode, KeyEvent, KeyModifiers};

use crate::session::{Answer, OperatorEvent, Prompt, PromptKind, SkipScope};

/// What the keys are being used for.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) enum Mode {
    /// Letters are orders, everything else takes the reading.
    #[default]
    Orders,
    /// A question of the session is open.
    Asked(Prompt),
    /// The number of a cell is being typed.
    Goto,
    /// A note is being typed while this question is open, or was.
    Note(Option<Prompt>),
}

/// The line that is being typed, and for what.
#[derive(Debug, Clone, PartialEq, Default)]
pub(super) struct TypedLine {
    /// What the keys are being used for.
    pub(super) mode: Mode,
    /// The line so far.
    pub(super) line: String,
    /// Ticked items of a checklist.
    pub(super) ticked: usize,
    /// What was wrong with the last line.
    pub(super) complaint: Option<String>,
    interrupts: u32,
    /// The question that was answered last: shown again by the session until it has taken the answer.
    answered: Option<Prompt>,
}

impl TypedLine {
    /// Turns to the session's open question, or away from one that is closed.
    pub(super) fn follow(&mut self, prompt: Option<&Prompt>) {
        match (prompt, &self.mode) {
            // What is being typed stays.
            (prompt, Mode::Note(_)) => self.mode = Mode::Note(prompt.cloned()),
            (None, Mode::Asked(_)) => self.turn_to(Mode::Orders),
            (Some(prompt), Mode::Asked(open)) if open == prompt => {}
            (Some(prompt), _) if self.answered.as_ref() != Some(prompt) => {
                self.turn_to(Mode::Asked(prompt.clone()));
            }
            _ => {}
        }
        if prompt.is_none() {
            self.answered = None;
        }
    }

    /// What a key does.
    pub(super) fn key(&mut self, key: KeyEvent) -> Option<OperatorEvent> {
        if key.modifiers.contains(KeyModifiers::CONTROL) {
            return match key.code {
                KeyCode::Char('c' | 'C') => Some(self.interrupt()),
                KeyCode::Char('n' | 'N') => self.begin_note(),
                _ => None,
            };
        }
        match self.mode.clone() {
            Mode::Orders => self.order(key.code),
            Mode::Goto => self.goto(key.code),
            Mode::Asked(prompt) if is_note(&prompt, key.code) => self.begin_note(),
            Mode::Asked(prompt) => self.answer(&prompt, key.code),
            Mode::Note(prompt) => self.note(prompt, key.code),
        }
    }

    /// Text that comes at once.
    pub(super) fn paste(&mut self, text: &str) {
        if self.mode != Mode::Orders {
            self.line.extend(text.chars().filter(|c| !c.is_control()));
        }
    }

    /// The terminal went away: as the first Ctrl-C, once.
    pub(super) fn terminal_is_gone(&mut self) -> Option<OperatorEvent> {
        (self.interrupts == 0).then(|| self.interrupt())
    }

    fn interrupt(&mut self) -> OperatorEvent {
        self.interrupts += 1;
        match self.interrupts {
            1 => OperatorEvent::Interrupt,
            _ => OperatorEvent::Abort,
        }
    }

    fn turn_to(&mut self, mode: Mode) {
        *self = Self {
            mode,
            interrupts: self.interrupts,
            ..Self::default()
        };
    }

    fn order(&mut self, code: KeyCode) -> Option<OperatorEvent> {
        match code {
            KeyCode::Char('r') => Some(OperatorEvent::Redo),
            KeyCode::Char('p') => Some(OperatorEvent::Pause),
            KeyCode::Char('n') => Some(OperatorEvent::Note { text: None }),
            KeyCode::Char('g') => {
                self.turn_to(Mode::Goto);
                None
            }
            KeyCode::Char('s') => Some(skip(SkipScope::Reading)),
            KeyCode::Char('S') => Some(skip(SkipScope::Cell)),
            // An escape is no pedal, and nothing may be lost or taken by the easy key.
            KeyCode::Esc => None,
            KeyCode::Char(_)
            | KeyCode::Enter
            | KeyCode::F(_)
            | KeyCode::PageDown
            | KeyCode::PageUp
            | KeyCode::Tab
            | KeyCode::Down
            | KeyCode::Up
            | KeyCode::Left
            | KeyCode::Right => Some(OperatorEvent::Capture),
            _ => None,
        }
    }

    /// Opens the line for a note; the question waits.
    fn begin_note(&mut self) -> Option<OperatorEvent> {
        let prompt = match &self.mode {
            Mode::Orders => return Some(OperatorEvent::Note { text: None }),
            Mode::Asked(prompt) => Some(prompt.clone()),
            Mode::Goto => None,
            Mode::Note(_) => return None,
        };
        self.line.clear();
        self.complaint = None;
        self.mode = Mode::Note(prompt);
        None
    }

    fn note(&mut self, prompt: Option<Prompt>, code: KeyCode) -> Option<OperatorEvent> {
        if !matches!(code, KeyCode::Enter | KeyCode::Esc) {
            self.edit(code);
            return None;
        }
        let text = std::mem::take(&mut self.line).trim().to_owned();
        self.mode = prompt.map_or(Mode::Orders, Mode::Asked);
        (code == KeyCode::Enter && !text.is_empty())
            .then_some(OperatorEvent::Note { text: Some(text) })
    }

    fn goto(&mut self, code: KeyCode) -> Option<OperatorEvent> {
        match code {
            KeyCode::Enter => match self.line.trim().parse::<usize>() {
                Ok(number) if number > 0 => {
                    self.turn_to(Mode::Orders);
                    return Some(OperatorEvent::Goto { cell: number - 1 });
                }
                _ => self.complaint = Some("the number of a cell, from 1, is expected".to_owned()),
            },
            KeyCode::Esc => self.turn_to(Mode::Orders),
            code => self.edit(code),
        }
        None
    }

    fn answer(&mut self, prompt: &Prompt, code: KeyCode) -> Option<OperatorEvent> {
        let line = match (&prompt.kind, code) {
            (PromptKind::Checklist(items), KeyCode::Char(_) | KeyCode::Enter) => {
                self.ticked += 1;
                if self.ticked < items.len() {
                    return None;
                }
                "yes".to_owned()
            }
            (PromptKind::Checklist(_), KeyCode::Backspace | KeyCode::Esc) => {
                self.ticked = self.ticked.saturating_sub(1);
                return None;
            }
            (PromptKind::Choice(choices), KeyCode::Char(c)) => {
                let meant = choices.iter().find(|of| of.key == c.to_ascii_lowercase());
                match meant {
                    // What cannot be taken back waits for Enter behind its key, or takes its capital.
                    Some(choice) if !choice.harmless && c.is_lowercase() => {
                        choice.word.clone_into(&mut self.line);
                        return None;
                    }
                    Some(choice) => choice.word.to_owned(),
                    None => c.to_string(),
                }
            }
            (PromptKind::Confirm, KeyCode::Char(c)) => c.to_string(),
            (_, KeyCode::Enter) => self.line.clone(),
            (_, KeyCode::Esc) => {
                self.line.clear();
                return None;
            }
            (_, code) => {
                self.edit(code);
                return None;
            }
        };
        match prompt.read_line(&line) {
            Ok(answer) => Some(self.done(prompt, answer)),
            Err(complaint) => {
                self.complaint = Some(complaint);
                None
            }
        }
    }

    fn done(&mut self, prompt: &Prompt, answer: Answer) -> OperatorEvent {
        self.turn_to(Mode::Orders);
        self.answered = Some(prompt.clone());
        OperatorEvent::Answer {
            id: prompt.id.clone(),
            answer,
        }
    }

    fn edit(&mut self, code: KeyCode) {
        self.complaint = None;
        match code {
            KeyCode::Char(c) => self.line.push(c),
            KeyCode::Backspace => {
                self.line.pop();
            }
            _ => {}
        }
    }
}

/// Whether a key opens a note at a question: where the letter is no part of an answer.
fn is_note(prompt: &Prompt, code: KeyCode) -> bool {
    code == KeyCode::Char('n')
        && match &prompt.kind {
            PromptKind::Number { .. } | PromptKind::Checklist(_) => true,
            PromptKind::Choice(choices) => choices.iter().all(|choice| choice.key != 'n'),
            PromptKind::Confirm | PromptKind::Text => false,
        }
}

fn skip(what: SkipScope) -> OperatorEvent {
    OperatorEvent::Skip { what, reason: None }
}
