//! A run or cell that is complete: its readings against their repeats, and what the operator decides about one that they contradict.

use crate::contradiction::Contradiction;
use crate::decision::Flagged;
use crate::event::Event;
use crate::operator::{Answer, Prompt, PromptKind};
use crate::run_scatter::{TAKEN_AGAIN, check_of, gauge_number, is_open, is_unflagged};

use super::answers::Why;
use super::{Action, Job, Machine};

/// The flag of readings that were kept against their repeats.
const KEPT: &str = "its repeats contradict it";

impl Machine {
    /// The cell whose last run is complete and has not been compared with its repeats.
    pub(super) fn unchecked_cell(&self) -> Option<usize> {
        let cell = self.mounted.filter(|_| self.settings.checks_repeats)?;
        let last = self.state.accepted().rev();
        let last = last
            .map(|kept| &kept.taken)
            .find(|taken| taken.cell == cell)?;
        let is_known = self.repeats_checked == Some((cell, self.state.readings.len()));
        (!is_known && !is_open(&self.state, &self.plan, cell, last.repeat)).then_some(cell)
    }

    /// Compares the runs of a cell with those before them, and a cell that is complete as a diagnosis would.
    pub(super) fn check_repeats(&mut self, cell: usize, out: &mut Vec<Action>) {
        let check = check_of(&self.state, &self.plan, self.settings.scatter_m);
        let (found, alike) = check.contradictions(cell);
        let open = self.plan.next_open(&self.state, cell);
        let is_open = open.is_some_and(|(of, _)| of == cell);
        let gauge = gauge_number(&self.plan, self.plan.leading(cell));
        let from = check.asked_from(cell, gauge).filter(|_| is_open);
        if !is_open && !found.iter().any(|one| self.is_new(one)) {
            out.push(Action::CheckRepeats(cell));
        } else {
            self.repeats_checked(found, out);
        }
        let from = from.filter(|_| self.pending.is_none());
        for text in alike.into_iter().chain(from) {
            self.notify(text, out);
        }
    }

    /// Whether some of its readings have no flag yet.
    fn is_new(&self, one: &Contradiction) -> bool {
        let mut kept = self.state.accepted();
        kept.any(|kept| one.numbers.contains(&kept.taken.number) && is_unflagged(kept))
    }

    /// The answer of the check.
    pub(super) fn repeats_checked(&mut self, found: Vec<Contradiction>, out: &mut Vec<Action>) {
        let Some(Job::CheckRepeats(cell)) = self.job else {
            return;
        };
        let Some(worst) = found.into_iter().find(|one| self.is_new(one)) else {
            self.repeats_checked = Some((cell, self.state.readings.len()));
            self.done();
            return;
        };
        if self.was_taken_again(&worst.numbers) {
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
            let text = "What was the cause? Leave it blank if none was found: then the run stays in the scatter.";
            let mut prompt = Prompt::new("redo-cause", text, PromptKind::Text);
            prompt.default = Some(Answer::Text(String::new()));
            self.ask(prompt, Why::RedoCause(numbers), out);
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

    fn run_of(&self, numbers: &[u32]) -> Option<(usize, u32)> {
        let mut accepted = self.state.accepted().map(|kept| &kept.taken);
        let taken = accepted.find(|taken| numbers.contains(&taken.number))?;
        Some((taken.cell, taken.repeat))
    }

    /// Whether the run was taken again already because it differed: what repeats itself is no slip.
    fn was_taken_again(&self, numbers: &[u32]) -> bool {
        let run = self.run_of(numbers);
        self.state.readings.iter().any(|kept| {
            let reason = kept.superseded.as_deref().unwrap_or_default();
            run == Some((kept.taken.cell, kept.taken.repeat)) && reason.starts_with(TAKEN_AGAIN)
        })
    }

    /// Every reading of the run that these belong to is taken once more.
    pub(super) fn redo_run(&mut self, numbers: &[u32], cause: &str, out: &mut Vec<Action>) {
        let Some((cell, repeat)) = self.run_of(numbers) else {
            self.done();
            return;
        };
        let accepted = self.state.accepted();
        let run = accepted.filter(|kept| (kept.taken.cell, kept.taken.repeat) == (cell, repeat));
        let run: Vec<u32> = run.map(|kept| kept.taken.number).collect();
        let reason = match cause.trim() {
            "" => TAKEN_AGAIN.to_owned(),
            cause => format!("{TAKEN_AGAIN}: {cause}"),
        };
        self.supersede(run, &reason, out);
        self.focus = cell;
        self.reroute();
    }
}
