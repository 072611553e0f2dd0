//! The one loop: gauges and operator in, journal and operator out.

use std::time::Duration;

use jiff::Timestamp;
use miette::Diagnostic;
use thiserror::Error;

use stiffbench_gauges::Gauges;
use stiffbench_units_and_text::clock::Clock;

use super::answers_file::Answers;
use super::contradiction::RepeatCheck;
use super::event::{ClockJump, Event, Gap, SessionEnd, ZeroOccasion};
use super::folder::SessionFolder;
use super::journal::{Journal, JournalError, Store};
use super::operator::{Answer, Bell, Operator, OperatorEvent, Prompt};
use super::steps::{Action, Input, Machine};

/// Longest real time that the loop waits for a gauge, so that keys and the screen do not wait longer.
const LONGEST_WAIT: Duration = Duration::from_millis(20);

/// Real time between two views.
const BETWEEN_VIEWS: Duration = Duration::from_millis(50);

/// Gauge events that are processed before the operator's input is read again.
const EVENTS_AT_ONCE: usize = 200;

/// Real time that the loop may lose before it counts as a gap, s.
const GAP_S: f64 = 5.0;

/// Difference of UTC and session time that counts as a jump, s.
pub(super) const JUMP_S: f64 = 2.0;

/// Prompts answered from a file in a row without anything happening: the answers go round in a circle.
const MOST_ANSWERS_IN_A_ROW: u32 = 50;

/// Why a session stopped that the operator did not stop.
#[derive(Debug, Error, Diagnostic)]
pub enum RunError {
    /// An event could not be kept.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Journal(#[from] JournalError),
    /// A question that no operator can answer.
    #[error("no operator can answer: {text}")]
    #[diagnostic(code(stiffbench::input_needed))]
    NeedsInput {
        /// The question.
        text: String,
        /// What would have answered it.
        #[help]
        help: String,
    },
}

/// What a session runs with.
pub struct SessionInputs<'a, S: Store> {
    /// The gauges.
    pub gauges: &'a mut dyn Gauges,
    /// The operator.
    pub operator: &'a mut dyn Operator,
    /// Session time; the gauges stamp their samples with it.
    pub clock: &'a Clock,
    /// Where events go.
    pub journal: &'a mut Journal<S>,
    /// Where the live table of readings is, if there is a folder for it.
    pub table: Option<&'a SessionFolder>,
    /// What is known beforehand.
    pub answers: &'a Answers,
    /// What compares the readings of a cell with their repeats, where [`Settings::checks_repeats`](super::Settings) asks for it.
    pub repeats: Option<&'a dyn RepeatCheck>,
}

/// Runs a session to its end.
///
/// # Errors
/// [`RunError`]; everything that was confirmed is in the journal, and the session can be resumed.
pub fn run<S: Store>(
    machine: &mut Machine,
    bench: SessionInputs<'_, S>,
) -> Result<SessionEnd, RunError> {
    let now_s = bench.clock.now_s();
    let mut session = RunningSession {
        before_s: now_s,
        before_utc: bench.clock.utc(),
        shown_s: f64::NEG_INFINITY,
        answered: 0,
        asked: None,
        moved_on_s: now_s,
        tasks: 0,
        table_failed: false,
        bench,
        machine,
    };
    let ended = session.run();
    session.show(true);
    if let Err(error) = &ended {
        session.bench.operator.bell(Bell::Attention);
        session.bench.operator.notify(&format!("stopped: {error}"));
    }
    ended
}

struct RunningSession<'a, 'b, S: Store> {
    bench: SessionInputs<'a, S>,
    machine: &'b mut Machine,
    before_s: f64,
    before_utc: Timestamp,
    shown_s: f64,
    answered: u32,
    /// The open question, and since when, s.
    asked: Option<(String, f64)>,
    /// When a reading or a zero was last kept, or a pose set, s.
    moved_on_s: f64,
    tasks: u64,
    table_failed: bool,
}

impl<S: Store> RunningSession<'_, '_, S> {
    fn run(&mut self) -> Result<SessionEnd, RunError> {
        loop {
            self.compare_clocks()?;
            let mut wait = LONGEST_WAIT;
            for _ in 0..EVENTS_AT_ONCE {
                let Some(event) = self.bench.gauges.next(wait) else {
                    break;
                };
                self.input(Input::Gauge(event))?;
                wait = Duration::ZERO;
            }
            while let Some(event) = self.bench.operator.poll(Duration::ZERO) {
                self.operator(event)?;
            }
            self.input(Input::Tick)?;
            self.end_of_patience()?;
            if let Some(outcome) = self.machine.outcome() {
                return Ok(outcome);
            }
            self.refuse_to_wait()?;
            self.show(false);
        }
    }

    /// Feeds the machine and performs its actions until there are no more.
    fn input(&mut self, input: Input) -> Result<(), RunError> {
        let mut next = Some(input);
        while let Some(input) = next.take() {
            let now_s = self.bench.clock.now_s();
            let actions = self.machine.input(input, now_s);
            let acted = !actions.is_empty();
            let tasks = self.machine.tasks();
            let answer = self.act(actions)?;
            // Another task is shown at once, not at the next turn.
            let another = std::mem::replace(&mut self.tasks, tasks) != tasks;
            self.show(another);
            next = answer.or_else(|| acted.then_some(Input::Tick));
        }
        Ok(())
    }

    /// Performs the actions of the machine, in order; the answer to a question that is known beforehand, or to a check, comes back.
    fn act(&mut self, actions: Vec<Action>) -> Result<Option<Input>, RunError> {
        let mut answer = None;
        for action in actions {
            match action {
                Action::Record(event) => self.record(*event)?,
                Action::Ask(channel, ask) => self.bench.gauges.ask(channel, ask),
                Action::Prompt(prompt) => answer = self.prompt(&prompt)?.map(Input::Operator),
                Action::CheckRepeats(cell) => {
                    let state = self.machine.state();
                    let check = self.bench.repeats;
                    let found = check.map(|check| check.contradictions(state, cell));
                    answer = Some(Input::RepeatsChecked(found.unwrap_or_default()));
                }
                Action::Bell(bell) => self.bench.operator.bell(bell),
                Action::Say(line) => self.bench.operator.notify(&line),
                Action::Finish(_) => {}
            }
        }
        Ok(answer)
    }

    /// Keeps an event; only then does it count.
    fn record(&mut self, event: Event) -> Result<(), RunError> {
        let progress = matches!(
            event,
            Event::Reading(_) | Event::Zero(_) | Event::PoseSet(_)
        );
        let rows_change = match &event {
            Event::Superseded(_) | Event::Flagged(_) => true,
            Event::Zero(zeroed) => zeroed.moment != ZeroOccasion::Before,
            _ => false,
        };
        let row_added = matches!(event, Event::Reading(_));
        let (utc, now_s) = (self.bench.clock.utc(), self.bench.clock.now_s());
        let record = self.bench.journal.append(event, utc, now_s)?;
        self.machine.recorded(&record);
        self.bench.operator.recorded(&record);
        if progress {
            self.answered = 0;
            self.moved_on_s = now_s;
        }
        let state = self.machine.state();
        let written = match self.bench.table {
            Some(folder) if rows_change => folder.rewrite_table(state),
            Some(folder) if row_added => folder.add_last_row(state),
            _ => Ok(()),
        };
        // The journal has it: the table is rebuilt from that when the session goes on or ends.
        if let Err(error) = written
            && !std::mem::replace(&mut self.table_failed, true)
        {
            let text = format!("{error}: the reading is in the journal, readings.csv is behind");
            self.bench.operator.notify(&text);
        }
        Ok(())
    }

    /// Asks the operator, or finds the answer.
    fn prompt(&mut self, prompt: &Prompt) -> Result<Option<OperatorEvent>, RunError> {
        let answers = self.bench.answers;
        let known = answers.find(prompt);
        let known = known.or(prompt.default.as_ref().filter(|_| answers.no_input));
        let problem = match known {
            Some(answer) => prompt.complaint(answer),
            None if answers.no_input => Some("there is no answer".to_owned()),
            None => {
                self.bench.operator.prompt(prompt);
                return Ok(None);
            }
        };
        self.answered += 1;
        let problem = problem.or_else(|| {
            let circle = self.answered > MOST_ANSWERS_IN_A_ROW;
            circle.then(|| "the same answers repeat".to_owned())
        });
        if let Some(problem) = problem {
            return Err(self.needs_input(prompt, &problem));
        }
        let answer = known.cloned().unwrap_or(Answer::Yes(false));
        let text = format!("{} Answered beforehand: {answer}.", prompt.text);
        self.bench.operator.notify(&text);
        let id = prompt.id.clone();
        Ok(Some(OperatorEvent::Answer { id, answer }))
    }

    fn operator(&mut self, event: OperatorEvent) -> Result<(), RunError> {
        if event != OperatorEvent::NoInput {
            return self.input(Input::Operator(event));
        }
        let open = self.machine.open_question();
        match open.map(|(prompt, _)| prompt.clone()) {
            Some(prompt) => Err(self.needs_input(&prompt, "the input has ended")),
            None => Ok(()),
        }
    }

    /// A question that the procedure gives a time is not left open longer: its default counts, or the session ends as partial.
    fn end_of_patience(&mut self) -> Result<(), RunError> {
        let now_s = self.bench.clock.now_s();
        let Some((prompt, within_s)) = self.machine.open_question() else {
            self.asked = None;
            return Ok(());
        };
        let same = self.asked.as_ref().filter(|(id, _)| *id == prompt.id);
        let since_s = same.map_or(now_s, |(_, since_s)| *since_s);
        let (id, default) = (prompt.id.clone(), prompt.default.clone());
        self.asked = Some((id.clone(), since_s));
        let Some(within_s) = within_s.filter(|within_s| now_s - since_s > *within_s) else {
            return Ok(());
        };
        self.asked = None;
        let text = format!("no answer to {id} within {within_s:.0} s");
        match default {
            Some(answer) => {
                let text = format!("{text}: {answer} counts");
                self.bench.operator.notify(&text);
                self.input(Input::Operator(OperatorEvent::Answer { id, answer }))
            }
            None => self.stop(&text),
        }
    }

    /// Ends the session as partial, since no answer comes.
    fn needs_input(&mut self, prompt: &Prompt, problem: &str) -> RunError {
        if let Err(error) = self.stop(&format!("no answer to {}", prompt.id)) {
            return error;
        }
        let name = prompt.name();
        RunError::NeedsInput {
            text: prompt.text.clone(),
            help: format!(
                "{problem}: answer it with --answer {name}=VALUE, or with {name} in the file of --answer-file; then stiffbench session resume"
            ),
        }
    }

    fn stop(&mut self, reason: &str) -> Result<(), RunError> {
        let now_s = self.bench.clock.now_s();
        let actions = self.machine.stop(reason, now_s);
        self.act(actions).map(|_| ())
    }

    /// Without an operator, a pause would last for ever, and so would a load that does not come or a gauge that stays away.
    fn refuse_to_wait(&mut self) -> Result<(), RunError> {
        if !self.bench.answers.no_input {
            return Ok(());
        }
        let waited_s = self.bench.clock.now_s() - self.moved_on_s;
        if waited_s > self.machine.longest_wait_s() {
            self.stop("no progress without an operator")?;
            return Err(RunError::NeedsInput {
                text: format!("no progress for {waited_s:.0} s"),
                help: "check the load and the gauges; continue with stiffbench session resume"
                    .to_owned(),
            });
        }
        if !self.machine.is_paused() {
            return Ok(());
        }
        self.stop("paused without an operator")?;
        Err(RunError::NeedsInput {
            text: "the session is paused".to_owned(),
            help: "continue with stiffbench session resume without --no-input".to_owned(),
        })
    }

    /// Notices when the machine slept or its clock was set: nothing from before counts towards settling.
    fn compare_clocks(&mut self) -> Result<(), RunError> {
        let (now_s, utc) = (self.bench.clock.now_s(), self.bench.clock.utc());
        let speed = self.bench.clock.speed();
        let passed_s = now_s - self.before_s;
        let utc_s = utc.duration_since(self.before_utc).as_secs_f64();
        (self.before_s, self.before_utc) = (now_s, utc);
        let lost = lost_time(passed_s, utc_s, speed);
        let any = !lost.is_empty();
        for event in lost {
            if let Event::ClockJump(jump) = &event {
                let text = format!(
                    "the clock jumped by {:.0} s: suspended, or set?",
                    jump.seconds
                );
                self.bench.operator.notify(&text);
            }
            self.record(event)?;
        }
        if any {
            self.input(Input::Gap)?;
        }
        Ok(())
    }

    fn show(&mut self, always: bool) {
        let now_s = self.bench.clock.now_s();
        let real_s = (now_s - self.shown_s) / self.bench.clock.speed();
        if always || real_s >= BETWEEN_VIEWS.as_secs_f64() {
            self.shown_s = now_s;
            self.bench.operator.show(&self.machine.view());
        }
    }
}

/// The time between two turns of the loop by both clocks: `passed_s` of session time, `utc_s` of UTC.
fn lost_time(passed_s: f64, utc_s: f64, speed: f64) -> Vec<Event> {
    let mut lost = Vec::new();
    if passed_s / speed > GAP_S {
        lost.push(Event::Gap(Gap { seconds: passed_s }));
    }
    let seconds = utc_s - passed_s;
    // In fast-forward UTC is made from session time.
    if speed == 1.0 && seconds.abs() > JUMP_S {
        lost.push(Event::ClockJump(ClockJump { seconds }));
    }
    lost
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suspension_and_clock_changes_are_recorded() {
        let gap = |seconds| Event::Gap(Gap { seconds });
        let jump = |seconds| Event::ClockJump(ClockJump { seconds });
        assert_eq!(lost_time(0.02, 0.02, 1.0), []);
        // Some systems count sleep in their monotonic clock, others only in UTC.
        assert_eq!(lost_time(600.0, 600.0, 1.0), [gap(600.0)]);
        assert_eq!(lost_time(0.0, 600.0, 1.0), [jump(600.0)]);
        assert_eq!(lost_time(1.0, -3599.0, 1.0), [jump(-3600.0)]);
        assert_eq!(lost_time(60.0, 0.0, 20.0), []);
        assert_eq!(lost_time(600.0, 600.0, 20.0), [gap(600.0)]);
    }
}
