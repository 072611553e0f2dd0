//! What comes into a session, and what goes out of it.

use stiffbench_gauges::{Ask, Channel, GaugeEvent};

use crate::contradiction::Contradiction;
use crate::event::{Event, SessionEnd};
use crate::operator::{Bell, OperatorEvent, Prompt};

/// Something that happened.
#[derive(Debug, Clone, PartialEq)]
pub enum Input {
    /// A gauge.
    Gauge(GaugeEvent),
    /// The operator.
    Operator(OperatorEvent),
    /// Time has passed without us: what came before does not count towards settling.
    Gap,
    /// What [`Action::CheckRepeats`] found.
    RepeatsChecked(Vec<Contradiction>),
    /// Nothing but time.
    Tick,
}

/// Something to do, in this order; if one cannot be done, those behind it are not to be done.
#[derive(Debug, Clone, PartialEq)]
pub enum Action {
    /// To be kept.
    Record(Box<Event>),
    /// To ask a gauge.
    Ask(Channel, Ask),
    /// To ask the operator.
    Prompt(Prompt),
    /// To compare the readings of a cell with their repeats; [`Input::RepeatsChecked`] is the answer.
    CheckRepeats(usize),
    /// A sound.
    Bell(Bell),
    /// A line for the operator.
    Say(String),
    /// The session is over.
    Finish(SessionEnd),
}
