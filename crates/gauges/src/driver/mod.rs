//! The exchange with one gauge: what is sent when, which reply belongs to it, and what is done when none comes. No port and no clock.
//!
//! A [`Driver`] receives what arrived and when, and answers with [`DriverAction`]s. The blocking reader, the live engine and unit tests all drive the same
//! machine, so that deadlines, drains and retries are tested without waiting. It never pairs a reply with a request by order alone once
//! something went wrong: after a reply that did not come the line is drained until it is quiet, and the next value counts only if no second
//! one follows it.

mod answers;
mod exchange;
mod machine;
mod sending;
#[cfg(test)]
mod tests;

pub use machine::Driver;

use stiffbench_units_and_text::clock::Clock;

use super::trace::What;
use super::{CommandEffect, CommandRole, GaugeEvent, InstrumentDescription};

/// Now, on two clocks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct DriverTimestamp {
    /// Real seconds: deadlines of a line run on them, whatever the speed of a session.
    pub real_s: f64,
    /// Session time, s: the stamp of values.
    pub at_s: f64,
}

impl DriverTimestamp {
    /// What a clock of real time and that of the session show.
    #[must_use]
    pub fn of(real: &Clock, session: &Clock) -> Self {
        Self {
            real_s: real.now_s(),
            at_s: session.now_s(),
        }
    }
}

/// How a gauge is operated.
#[derive(Debug, Clone, PartialEq)]
pub struct AcquisitionSettings {
    /// How its values are had.
    pub acquisition: Acquisition,
    /// Whether it gets the command to stay on, where it has one.
    pub keep_awake: bool,
    /// The identity that it reported last, if known: another identity is another gauge.
    pub expected: Option<Box<str>>,
}

impl AcquisitionSettings {
    /// A look at a gauge that leaves its settings alone and takes whoever answers.
    #[must_use]
    pub fn glance(acquisition: Acquisition) -> Self {
        Self {
            acquisition,
            keep_awake: false,
            expected: None,
        }
    }
}

/// Requests a second where a description allows more: enough to see a load settle, and no more than adapters pass on that hold short packets
/// for 16 ms.
const ENOUGH_PER_S: f64 = 20.0;

/// How values are had from a gauge.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Acquisition {
    /// One request, one value.
    Poll {
        /// Most requests a second; fewer where the description requires it.
        most_per_s: f64,
    },
    /// After one start command it keeps sending.
    Stream,
    /// It sends by itself and takes no command.
    Listen,
}

impl Acquisition {
    /// The same where time runs `times` as fast.
    #[must_use]
    pub fn sped_up(self, times: f64) -> Self {
        match self {
            Self::Poll { most_per_s } => Self::Poll {
                most_per_s: most_per_s * times,
            },
            other => other,
        }
    }

    /// The way that a description allows and that is surest: a request for each value shows at once when the gauge falls silent.
    #[must_use]
    pub fn surest(description: &InstrumentDescription) -> Self {
        if description.command(CommandRole::Read).is_some() {
            Self::Poll {
                most_per_s: ENOUGH_PER_S,
            }
        } else if description
            .command(CommandRole::StreamStart)
            .is_some_and(|command| command.effect == CommandEffect::Sets)
        {
            Self::Stream
        } else {
            Self::Listen
        }
    }
}

/// What has to be done, in this order.
#[derive(Debug, Clone, PartialEq)]
pub enum DriverAction {
    /// To write these bytes to the port, in one piece.
    Send {
        /// What they ask for.
        role: CommandRole,
        /// The bytes.
        bytes: Vec<u8>,
    },
    /// Report this event.
    Tell(GaugeEvent),
    /// To note in the trace that the last `count` values are not used.
    Unused {
        /// How many, counted back from the last one decoded.
        count: usize,
        /// Why.
        reason: &'static str,
    },
    /// To note in the trace that the decoder restarts.
    Reset,
    /// To close the port: another instrument answers.
    Refuse {
        /// What answers, and what was expected.
        reason: Box<str>,
    },
}

impl DriverAction {
    /// What of it stands in a trace.
    #[must_use]
    pub fn traced(&self) -> Option<What> {
        Some(match self {
            Self::Send { role, bytes } => What::Sent {
                role: Some(*role),
                bytes: bytes.clone(),
            },
            Self::Tell(GaugeEvent::Link { state, .. }) => What::Link(state.clone()),
            Self::Tell(GaugeEvent::Note { text, .. }) => What::Note(text.to_string()),
            Self::Tell(_) | Self::Refuse { .. } => return None,
            Self::Unused { count, reason } => What::Unused {
                count: *count,
                reason: (*reason).to_owned(),
            },
            Self::Reset => What::Reset,
        })
    }
}
