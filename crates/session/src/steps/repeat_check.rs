//! A cell that is complete: its readings against their repeats, and what the operator decides about one that they contradict.

use crate::contradiction::Contradiction;
use crate::decision::Flagged;
use crate::event::Event;
use crate::operator::{Answer, Prompt};

use super::answers::Why;
use super::{Action, Job, Machine};

/// The flag of readings that were kept against their repeats.
const KEPT: &str = "its repeats contradict it";

/// Tries of a reading after which none is offered: what repeats itself is no slip.
const MOST_TRIES: u32 = 4;

impl Machine {
    /// The cell whose readings are all there and have not been compared with their repeats.
    pub(super) fn unchecked_cell(&self) -> Option<usize> {
        let cell = self.mounted.filter(|_| self.settings.checks_repeats)?;
        let open = self.plan.next_open(&self.state, cell);
        let is_open = open.is_some_and(|(of, _)| of == cell);
        let is_known = self.repeats_checked == Some((cell, self.state.readings.len()));
        (!is_open && !is_known).then_some(cell)
    }

    /// The answer of the check.
    pub(super) fn repeats_checked(&mut self, found: Vec<Contradiction>, out: &mut Vec<Action>) {
        let Some(Job::CheckRepeats(cell)) = self.job else {
            return;
        };
        let is_new = |one: &Contradiction| {
            self.state.accepted().any(|kept| {
                one.numbers.contains(&kept.taken.number)
                    && !kept.flags.iter().any(|flag| flag == KEPT)
            })
        };
        let Some(worst) = found.into_iter().find(is_new) else {
            self.repeats_checked = Some((cell, self.state.readings.len()));
            self.done();
            return;
        };
        let tries = worst.numbers.iter().filter_map(|number| {
            let mut all = self.state.readings.iter();
            let kept = all.find(|kept| kept.taken.number == *number)?;
            Some(self.state.attempts(kept.taken.cell, kept.taken.index))
        });
        if tries.max().unwrap_or(0) >= MOST_TRIES {
            self.message(format!("{} It is flagged.", worst.text), true, out);
            self.keep_contradicted(worst.numbers, false, out);
            return;
        }
        let choices = [
            (
                "redo",
                "take its run again; the existing readings stay, superseded",
            ),
            ("keep", "keep it; the reading is flagged"),
        ];
        let mut prompt = Prompt::choice("bad-reading", worst.text, &choices);
        let planned = &self.plan.cells[cell];
        prompt.key = Some(format!("{}.{}", planned.pose, planned.direction));
        prompt.details = vec![
            "The other repeats of this load contradict it. A diagnosis would leave it out."
                .to_owned(),
        ];
        prompt.default = Some(Answer::Text("keep".to_owned()));
        self.ask(prompt, Why::Contradicted(worst.numbers), out);
    }

    /// What the operator decided.
    pub(super) fn contradiction_answered(
        &mut self,
        numbers: Vec<u32>,
        word: &str,
        out: &mut Vec<Action>,
    ) {
        if word == "redo" {
            self.redo_run(&numbers, out);
        } else {
            self.keep_contradicted(numbers, true, out);
        }
    }

    fn keep_contradicted(&mut self, numbers: Vec<u32>, by_operator: bool, out: &mut Vec<Action>) {
        let flagged = Flagged {
            numbers,
            flag: KEPT.to_owned(),
            by_operator,
        };
        self.record(Event::Flagged(flagged), out);
        self.done();
    }

    /// Every reading of the run that these belong to is taken once more.
    fn redo_run(&mut self, numbers: &[u32], out: &mut Vec<Action>) {
        let of_run = self
            .state
            .accepted()
            .find(|kept| numbers.contains(&kept.taken.number))
            .map(|kept| (kept.taken.cell, kept.taken.repeat));
        let Some((cell, repeat)) = of_run else {
            self.done();
            return;
        };
        let accepted = self.state.accepted();
        let run = accepted.filter(|kept| (kept.taken.cell, kept.taken.repeat) == (cell, repeat));
        let run: Vec<u32> = run.map(|kept| kept.taken.number).collect();
        self.supersede(run, "a reading of its run contradicted the repeats", out);
        self.focus = cell;
        self.reroute();
    }
}
