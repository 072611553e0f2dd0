//! The end of a session, and by whom.

use crate::event::{Ended, Event, SessionEnd};
use crate::operator::Bell;

use super::{Action, Machine};

impl Machine {
    /// Ends the session for a reason of the program's own.
    pub(super) fn end(&mut self, outcome: SessionEnd, reason: &str, out: &mut Vec<Action>) {
        self.end_by("program", outcome, reason, out);
    }

    pub(super) fn end_by_operator(
        &mut self,
        outcome: SessionEnd,
        reason: &str,
        out: &mut Vec<Action>,
    ) {
        let operator = self.settings.operator.clone();
        self.end_by(
            operator.as_deref().unwrap_or("operator"),
            outcome,
            reason,
            out,
        );
    }

    pub(super) fn end_by(
        &mut self,
        by: &str,
        outcome: SessionEnd,
        reason: &str,
        out: &mut Vec<Action>,
    ) {
        self.over = Some(outcome);
        self.pending = None;
        let event = Event::Ended(Ended {
            outcome,
            reason: reason.to_owned(),
            by: Some(by.to_owned()),
            accepted: self.state.taken.len() as u32,
            planned: self.plan.len() as u32,
        });
        self.record(event, out);
        out.push(Action::Bell(Bell::Done));
        out.push(Action::Finish(outcome));
    }
}
