//! What the operator does besides answering.

use crate::decision::SkipCode;
use crate::event::{Event, Paused, SessionEnd};
use crate::operator::{OperatorEvent, Prompt, PromptKind, SkipScope};
use stiffbench_gauges::{Ask, Channel};

use super::answers::Why;
use super::{Action, Job, Machine};

impl Machine {
    pub(super) fn operator(&mut self, event: OperatorEvent, out: &mut Vec<Action>) {
        match event {
            OperatorEvent::Answer { id, answer } => self.answer(&id, &answer, out),
            OperatorEvent::Note { text: Some(text) } => self.note(&text, out),
            OperatorEvent::Interrupt => {
                self.stopping = true;
                self.notify(
                    "stopping at the next safe point; once more to stop now",
                    out,
                );
                self.notify_of_repeats(out);
            }
            OperatorEvent::Abort => {
                self.end_by_operator(SessionEnd::Aborted, "the operator stopped it at once", out);
            }
            OperatorEvent::NoInput => {}
            OperatorEvent::Pause => self.pause(out),
            _ if self.pending.is_some() => {
                self.notify("there is a question to be answered first", out);
            }
            _ if self.paused.is_some() => self.pause(out),
            OperatorEvent::Capture => self.capture_now(out),
            OperatorEvent::Redo => self.redo(out),
            OperatorEvent::Goto { cell } => self.goto(cell, out),
            OperatorEvent::Skip {
                what,
                reason: Some(reason),
            } => self.skip_for(what, &reason, out),
            OperatorEvent::Skip { what, reason: None } => {
                let left_out = match what {
                    SkipScope::Reading => "this reading",
                    SkipScope::Cell => "the rest of this cell",
                };
                let text = format!("Why is {left_out} left out? A reason is required.");
                let mut prompt = Prompt::new("skip-reason", text, PromptKind::Text);
                let words = SkipCode::GIVEN.map(SkipCode::word).join(", ");
                prompt.details = vec![format!(
                    "Begin with one of {words}; more about it may follow."
                )];
                self.ask(prompt, Why::SkipReason(what), out);
            }
            OperatorEvent::Note { text: None } => {
                let prompt = Prompt::new("note", "What should the note say?", PromptKind::Text);
                self.ask(prompt, Why::NoteText, out);
            }
        }
    }

    /// Stops for a while, or goes on: the windows restart, and a line that was given up is searched for once more.
    pub(super) fn pause(&mut self, out: &mut Vec<Action>) {
        if self.paused.take().is_some() {
            self.forget_windows();
            for channel in self.channels.clone() {
                if self.stream(channel).blocked.is_some() {
                    out.push(Action::Ask(channel, Ask::Identity));
                }
            }
            self.notify("continuing", out);
            return;
        }
        let reason = "by the operator".to_owned();
        self.paused = Some(reason.clone());
        self.record(Event::Paused(Paused { reason }), out);
        if let Some(Job::Read { cell, index }) = self.job {
            let reading = &self.plan.cells[cell].readings[index];
            let text = format!(
                "after continuing: the gauges settle again for the reading at {} N, repeat {}",
                reading.target_n, reading.repeat
            );
            self.notify(text, out);
        }
        self.notify_of_repeats(out);
    }

    /// What a session that ends here will do once more.
    fn notify_of_repeats(&mut self, out: &mut Vec<Action>) {
        let repeats = self.repeated_on_resume();
        if !repeats.is_empty() {
            self.notify(
                format!(
                    "if the session ends here, session resume repeats: {}",
                    repeats.join("; ")
                ),
                out,
            );
        }
    }

    fn capture_now(&mut self, out: &mut Vec<Action>) {
        let Some(Job::Read { cell, index }) = self.job else {
            self.notify("no reading can be taken now", out);
            return;
        };
        if self.is_ready(cell, index) {
            self.capture(cell, index, out);
            return;
        }
        let good = self.feeds.iter().all(|stream| stream.is_good(self.now_s));
        if !good {
            self.notify("a gauge has no current value", out);
            return;
        }
        let in_band = self
            .load
            .as_ref()
            .is_some_and(super::LoadApproach::is_in_band);
        let text = if in_band {
            "The gauges have not settled yet."
        } else {
            "The force is outside its band."
        };
        let choices = [
            ("wait", "wait until everything has settled"),
            ("take", "take it as it is; the reading is flagged"),
        ];
        let prompt = Prompt::choice("not-settled", text, &choices);
        self.ask(prompt, Why::NotSettled, out);
    }

    fn redo(&mut self, out: &mut Vec<Action>) {
        let Some(last) = self.state.last_accepted() else {
            self.notify("there is no reading yet", out);
            return;
        };
        let (number, cell, target_n) = (last.taken.number, last.taken.cell, last.taken.target_n);
        let tolerance_n = self.plan.procedure.settle.force_tolerance_n;
        let force_n = self.value(Channel::Force);
        // On the way to the next load already: the old one has to be approached from where it was approached before.
        if !force_n.is_some_and(|force_n| (force_n - target_n).abs() <= tolerance_n) {
            self.applied = None;
        }
        self.supersede(vec![number], "taken once more", out);
        self.notify(format!("reading {number} is taken once more"), out);
        self.focus = cell;
        self.queue.clear();
        self.job = None;
    }

    fn goto(&mut self, cell: usize, out: &mut Vec<Action>) {
        let Some(planned) = self.plan.cells.get(cell) else {
            let cells = self.plan.cells.len();
            self.notify(format!("there are cells 1 to {cells}"), out);
            return;
        };
        let open =
            (0..planned.readings.len()).any(|index| !self.state.taken.contains_key(&(cell, index)));
        if open {
            let text = format!(
                "cell {} is next: {} {}",
                cell + 1,
                planned.pose,
                planned.direction
            );
            self.notify(text, out);
            self.focus = cell;
            self.reroute();
            return;
        }
        let text = format!(
            "{} {} is complete. Measure it again? The existing readings stay, superseded.",
            planned.pose, planned.direction
        );
        self.ask(Prompt::confirm("redo-cell", text), Why::RedoCell(cell), out);
    }
}
