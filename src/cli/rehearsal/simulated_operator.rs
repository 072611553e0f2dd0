//! The hand that does on an emulated bench what a session asks for.

use crate::cli::emulated::BenchOperator;
use crate::cli::failure::Failure;
use crate::instrument::Channel;
use crate::load_direction::LoadDirection;
use crate::session::{Operator, Purpose, SessionView, Task};
use crate::test_point::{Direction, PoseId};

/// Views in a row that show the same force outside the band before it is corrected; they are 50 ms apart at least, however fast the session.
const LOOKS: u32 = 4;

/// Tolerances within which a force is corrected: further away it is not the jack that is wrong.
const LITTLE: f64 = 4.0;

/// How often a load is corrected.
const MOST_CORRECTED: u32 = 3;

/// An operator whose jack, robot and gauges are emulated: whoever looks and answers is behind it, the turning is done here.
///
/// It acts on what is shown, as a person would, and knows nothing else of the session.
pub struct SimulatedOperator<'a> {
    /// Who looks at the screen and answers.
    operator: &'a mut dyn Operator,
    hand: &'a BenchOperator,
    done: Option<OperatorAction>,
    /// What the force gauge has shown outside the band, jack at rest, and in how many views in a row.
    seen: (String, u32),
    /// How often this load was corrected.
    corrected: u32,
    phase: &'static str,
}

/// What a hand can do, distinguished as far as it makes a difference to what has to be done.
#[derive(Debug, Clone, PartialEq)]
enum OperatorAction {
    SetUp(PoseId, LoadDirection),
    LetGo,
    Push(f64),
    PushEnd(Direction, f64),
    Free(u32),
    Preload,
    Load {
        target_n: f64,
        step: u32,
        repeat: u32,
        attempt: u32,
        cell: usize,
    },
}

impl<'a> SimulatedOperator<'a> {
    /// A hand on a bench.
    pub fn new(operator: &'a mut dyn Operator, hand: &'a BenchOperator) -> Self {
        Self {
            operator,
            hand,
            done: None,
            seen: <(String, u32)>::default(),
            corrected: 0,
            phase: "",
        }
    }

    /// Tells the faults of a script where the session is.
    fn announce_phase(&mut self, view: &SessionView) {
        let phase = phase(view);
        if std::mem::replace(&mut self.phase, phase) != phase {
            self.hand.host.phase(phase);
        }
    }

    fn act(&mut self, view: &SessionView) {
        let Some(action) = action(view) else { return };
        if self.done.as_ref() == Some(&action) {
            if matches!(action, OperatorAction::Load { .. }) {
                self.correct(view);
            }
            return;
        }
        self.seen = <(String, u32)>::default();
        self.corrected = 0;
        match &action {
            OperatorAction::SetUp(pose, direction) => {
                let moved = self.hand.bench.set_pose(pose);
                let moved = moved.and_then(|()| self.hand.bench.set_direction(direction));
                if let Err(error) = moved {
                    self.operator.notify(&format!(
                        "the emulated bench stays: {}",
                        Failure::from(error).message()
                    ));
                }
            }
            OperatorAction::LetGo => self.hand.bench.let_go(),
            OperatorAction::Push(force_n) => self.hand.bench.push_by_hand(*force_n),
            OperatorAction::PushEnd(axis, sense) => self.hand.bench.push_end(*axis, *sense),
            OperatorAction::Free(repeat) => self.hand.bench.begin_run(*repeat),
            OperatorAction::Preload => self.hand.bench.preload(),
            OperatorAction::Load {
                target_n,
                step,
                repeat,
                ..
            } => {
                self.hand.apply(*target_n, (*step, *repeat));
            }
        }
        self.done = Some(action);
    }

    /// Turns the jack a little where the display stays outside the band: the zero is off by some digits, and the jack stopped near its limit.
    fn correct(&mut self, view: &SessionView) {
        let outside = view.band.filter(|band| !band.inside);
        let shown = view.force.value_si.filter(|_| !view.force.stale);
        let (Some(band), Some(shown_n), true) = (outside, shown, self.hand.bench.is_at_rest())
        else {
            self.seen = <(String, u32)>::default();
            return;
        };
        if self.seen.0 != view.force.raw {
            self.seen = (view.force.raw.clone(), 0);
        }
        self.seen.1 += 1;
        let by_n = band.target_n - shown_n;
        let little = by_n.abs() <= LITTLE * band.tolerance_n;
        if self.seen.1 >= LOOKS && self.corrected < MOST_CORRECTED && little {
            self.hand.bench.turn(by_n);
            self.corrected += 1;
            self.seen = <(String, u32)>::default();
        }
    }
}

impl Operator for SimulatedOperator<'_> {
    fn behind(&mut self) -> Option<&mut dyn Operator> {
        Some(&mut *self.operator)
    }

    fn show(&mut self, view: &SessionView) {
        self.announce_phase(view);
        self.act(view);
        self.operator.show(view);
    }
}

/// What a view asks the hand to do; `None` if it is to keep still.
fn action(view: &SessionView) -> Option<OperatorAction> {
    let place = view.place.as_ref();
    let repeat = place.map_or(1, |place| place.repeat);
    match &view.task {
        Task::SetUp { pose, direction } => {
            Some(OperatorAction::SetUp(pose.clone(), direction.clone()))
        }
        Task::PushByHand { let_go: true, .. } => Some(OperatorAction::LetGo),
        Task::PushByHand { force_n, gauge, .. } => Some(match gauge.and_then(Channel::axis) {
            Some(axis) => OperatorAction::PushEnd(axis, *force_n),
            None => OperatorAction::Push(*force_n),
        }),
        Task::Load { target_n, purpose } => match purpose {
            Purpose::Free => Some(OperatorAction::Free(repeat)),
            Purpose::Preload | Purpose::Release | Purpose::ZeroCheck => {
                Some(OperatorAction::Preload)
            }
            Purpose::Again | Purpose::Reading => place.map(|place| OperatorAction::Load {
                target_n: *target_n,
                step: place.step,
                repeat,
                attempt: place.attempt,
                cell: place.cell,
            }),
        },
        _ => None,
    }
}

/// The phases of a session, in the order in which they come first.
pub const PHASES: [&str; 12] = [
    "instruments",
    "set-up",
    "sign-check",
    "free",
    "zero",
    "preload",
    "approach",
    "settle",
    "hold",
    "release",
    "again",
    "zero-check",
];

/// The phase that a view belongs to: one of [`PHASES`], or nothing between them.
fn phase(view: &SessionView) -> &'static str {
    match &view.task {
        Task::CheckInstruments => "instruments",
        Task::SetUp { .. } => "set-up",
        Task::PushByHand { .. } => "sign-check",
        Task::Wait => "zero",
        Task::Hold { .. } => "hold",
        Task::Load { purpose, .. } => match purpose {
            Purpose::Free => "free",
            Purpose::Preload => "preload",
            Purpose::Release => "release",
            Purpose::Again => "again",
            Purpose::ZeroCheck => "zero-check",
            Purpose::Reading if view.band.is_some_and(|band| band.inside) => "settle",
            Purpose::Reading => "approach",
        },
        Task::Answer | Task::Paused | Task::Done => "",
    }
}
