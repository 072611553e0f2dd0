//! A short session on an emulated bench without an operator, to see what a fault does to it.

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use stiffbench::cli::emulated::{BenchOperator, Emulation};
use stiffbench::cli::failure::Failure;
use stiffbench::clock::Clock;
use stiffbench::instrument::Channel;
use stiffbench::instrument::driver::Acquisition;
use stiffbench::instrument::emulator::ScriptedFault;
use stiffbench::instrument::live::{LiveGauge, LiveGauges, RetryPolicy};
use stiffbench::instrument::port::{PortIdentity, PortTimeouts};
use stiffbench::procedure::Procedure;
use stiffbench::readings::Reading;
use stiffbench::session::{
    Answers, Bell, Event, JOURNAL_SCHEMA, Journal, Machine, Operator, OperatorEvent, Prompt,
    Resumed, RunError, SessionEnd, SessionInputs, SessionPlan, SessionState, SessionView, Settings,
    Started, lag_s, run,
};
use stiffbench::shipped::shipped_instrument;

use stiffbench::cli::rehearsal::{SimulatedOperator, unit_in_use};

/// Real time after which a session that gets nowhere is ended, so that the fault can be mended.
const PATIENCE: Duration = Duration::from_secs(8);

/// Times that a session may be taken up again.
const MOST_RESUMES: usize = 4;

/// What became of a session.
#[derive(Debug)]
pub(crate) struct Rehearsed {
    /// Accepted readings, in the order of the plan, and how many the plan has.
    pub(crate) readings: Vec<Reading>,
    pub(crate) planned: usize,
    /// How often it had to be taken up again.
    pub(crate) resumes: usize,
    /// What it reported that an operator would act on, once each, in order.
    pub(crate) said: Vec<String>,
}

/// A session to be rehearsed.
pub(crate) struct Rehearsal<'a> {
    /// The bench.
    pub(crate) emulation: Emulation<'a>,
    /// What somebody does at the bench once the session cannot go on by itself.
    pub(crate) mend: Vec<ScriptedFault>,
}

impl Rehearsal<'_> {
    /// Runs the session to its end, taking it up again as an operator would.
    pub(crate) fn run(self) -> Result<Rehearsed, Failure> {
        let (clock, procedure) = (self.emulation.session, self.emulation.procedure.clone());
        let name = |of: Channel| {
            let mut gauges = self.emulation.gauges.iter();
            gauges.find_map(|(channel, name)| (*channel == of).then(|| name.clone()))
        };
        let gauges = Channel::ALL.map(|channel| name(channel).unwrap_or_default());
        let hand = self.emulation.start()?;
        let mut nobody = Nobody::default();
        let mut state = SessionState::default();
        let mut mend = Some(self.mend);
        let mut resumes = 0;
        loop {
            let taken = state.taken.len();
            let (after, outcome) = one_go(&hand, &gauges, &procedure, clock, state, &mut nobody)?;
            state = after;
            if outcome == Some(SessionEnd::Complete) || resumes == MOST_RESUMES {
                break;
            }
            resumes += 1;
            // Who comes back and finds it stopped looks at the gauges first.
            let stuck = state.taken.len() == taken || nobody.gave_up;
            if let Some(mend) = mend.take_if(|_| stuck || outcome != Some(SessionEnd::Complete)) {
                for fault in mend {
                    hand.host.fail(fault);
                }
            }
        }
        let mut readings = state.table().readings;
        readings.retain(Reading::is_accepted);
        Ok(Rehearsed {
            readings,
            planned: SessionPlan::new(&procedure, &[]).len(),
            resumes,
            said: nobody.said,
        })
    }
}

/// Runs from where the session stands until it ends or stops.
fn one_go(
    hand: &BenchOperator,
    gauges: &[String; 2],
    procedure: &Procedure,
    clock: Clock,
    state: SessionState,
    nobody: &mut Nobody,
) -> Result<(SessionState, Option<SessionEnd>), Failure> {
    let (mut live, compression_sign) = open(hand, gauges, clock)?;
    let plan = SessionPlan::new(procedure, &[]);
    let settings = Settings {
        compression_sign,
        names: Channel::EVERY.map(|of| gauges[usize::from(of.is_displacement())].clone()),
        lag_s: lag_s(clock.speed()),
        ..Settings::default()
    };
    let resumed = state.started.is_some();
    let first = beginning(&state, procedure);
    let mut journal = Journal::behind(Vec::new(), state.events);
    let mut machine = Machine::new(plan, settings, state);
    machine.recorded(&journal.append(first, clock.utc(), clock.now_s())?);
    nobody.until = Some(Instant::now() + PATIENCE);
    nobody.gave_up = false;
    let mut operator = SimulatedOperator::new(nobody, hand);
    let ended = run(
        &mut machine,
        SessionInputs {
            gauges: &mut live,
            operator: &mut operator,
            clock: &clock,
            journal: &mut journal,
            table: None,
            answers: &answers(resumed),
            repeats: None,
        },
    );
    let outcome = match ended {
        Ok(outcome) => Some(outcome),
        Err(RunError::NeedsInput { text, .. }) => {
            nobody.hear(&text);
            None
        }
        Err(error) => return Err(error.into()),
    };
    Ok((machine.state().clone(), outcome))
}

/// Opens both gauges as a session does.
fn open(
    hand: &BenchOperator,
    gauges: &[String; 2],
    clock: Clock,
) -> Result<(LiveGauges, Option<f64>), Failure> {
    let mut compression_sign = None;
    let mut live = Vec::new();
    for (channel, name) in Channel::ALL.into_iter().zip(gauges) {
        let description = shipped_instrument(name)?.sped_up(clock.speed());
        if channel == Channel::Force {
            compression_sign = description.sign.compression.sign();
        }
        live.push(LiveGauge {
            acquisition: Acquisition::surest(&description).sped_up(clock.speed()),
            unit: unit_in_use(&description),
            port: PortIdentity::of_path(&hand.port(channel).to_string_lossy(), &[]),
            identity: None,
            trace: None,
            description,
        });
    }
    let retry_policy = RetryPolicy {
        longest_s: 0.5,
        ..RetryPolicy::default()
    };
    let live = LiveGauges::start(live, clock, PortTimeouts::default(), retry_policy)?;
    Ok((live, compression_sign))
}

/// What a journal begins with, or goes on with.
fn beginning(state: &SessionState, procedure: &Procedure) -> Event {
    let software = "rehearsal".to_owned();
    let (pid, host) = (std::process::id(), String::new());
    if state.started.is_some() {
        return Event::Resumed(Resumed {
            software,
            pid,
            host,
            cut_bytes: 0,
        });
    }
    Event::Started(Started {
        schema: Some(JOURNAL_SCHEMA.to_owned()),
        session: "rehearsal".to_owned(),
        procedure: procedure.name.clone(),
        procedure_sha256: String::new(),
        robot_sha256: None,
        header_sha256: None,
        instruments_sha256: None,
        mechanism: None,
        origin: None,
        software,
        pid,
        host,
        displacement_axes: Vec::new(),
    })
}

/// What a careful operator would answer: nothing doubtful is accepted. Who comes back to a session that stopped has looked which way the gauge
/// counts, and turns its sign where it is asked for.
fn answers(resumed: bool) -> Answers {
    let mut answers = Answers {
        no_input: true,
        ..Answers::default()
    };
    for answer in CAREFUL {
        // They are names of questions with answers of their kind; a test states it.
        let _ = answers.take_argument(answer);
    }
    if resumed {
        let _ = answers.take_argument("displacement-sign=flip");
    }
    answers
}

/// See [`answers`].
const CAREFUL: [&str; 13] = [
    "ready=true",
    "temperature=21",
    "setup=true",
    "sign-check=minus",
    "sign-differs=again",
    "zero-not-shown=again",
    "force-offset=wait",
    "force-sign=wait",
    "frozen=again",
    "displacement-sign=again",
    "implausible=again",
    "not-settled=wait",
    "drift=redo",
];

/// Nobody: hears what is said, and after a while ends what gets nowhere.
#[derive(Default)]
struct Nobody {
    until: Option<Instant>,
    progress: (usize, usize),
    gave_up: bool,
    heard: BTreeSet<String>,
    said: Vec<String>,
}

impl Nobody {
    fn hear(&mut self, text: &str) {
        if self.heard.insert(text.to_owned()) {
            self.said.push(text.to_owned());
        }
    }
}

impl Operator for Nobody {
    fn show(&mut self, view: &SessionView) {
        for text in &view.held_up {
            self.hear(text);
        }
        for message in view.messages.iter().filter(|message| message.urgent) {
            self.hear(&message.text);
        }
        let progress = (view.progress.accepted, view.messages.len());
        if std::mem::replace(&mut self.progress, progress).0 != progress.0 {
            self.until = Some(Instant::now() + PATIENCE);
        }
    }

    fn prompt(&mut self, _prompt: &Prompt) {}

    fn poll(&mut self, _wait: Duration) -> Option<OperatorEvent> {
        let over = self.until.is_some_and(|until| Instant::now() > until);
        if over {
            self.until = None;
            self.gave_up = true;
        }
        over.then_some(OperatorEvent::Abort)
    }

    fn bell(&mut self, _bell: Bell) {}

    fn notify(&mut self, line: &str) {
        if line.contains("Answered beforehand") {
            self.hear(line);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_careful_answer_is_one() {
        let mut answers = Answers::default();
        for answer in CAREFUL {
            answers.take_argument(answer).unwrap();
        }
    }
}
