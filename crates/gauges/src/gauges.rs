//! What a session sees of its two gauges, live, replayed or mocked.

use std::time::Duration;

use super::sample::{Channel, Rejected, Sample};

/// The two gauges of a bench.
///
/// Implementations: the live engine, a replayed trace, mock devices of tests. None blocks longer than its timeout.
pub trait Gauges {
    /// The next thing that happened on either gauge, in order of arrival; `None` if nothing did for `wait` of real time.
    fn next(&mut self, wait: Duration) -> Option<GaugeEvent>;

    /// Asks a gauge for something other than its value. What comes of it arrives as [`GaugeEvent::Answered`]; nothing is retried without a
    /// [`GaugeEvent::Note`].
    fn ask(&mut self, channel: Channel, ask: Ask);
}

/// What a gauge can be asked for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ask {
    /// To set its zero here.
    Zero,
    /// Who it is: model, serial number, firmware.
    Identity,
    /// Which unit and mode it is in.
    State,
}

/// What came from a gauge.
#[derive(Debug, Clone, PartialEq)]
pub enum GaugeEvent {
    /// A value.
    Sample {
        /// Which gauge.
        channel: Channel,
        /// The value.
        sample: Sample,
    },
    /// Bytes that are no value.
    Rejected {
        /// Which gauge.
        channel: Channel,
        /// The bytes and why they are none.
        rejected: Rejected,
    },
    /// The answer to [`Gauges::ask`].
    Answered {
        /// Which gauge.
        channel: Channel,
        /// What it was asked for.
        ask: Ask,
        /// Its reply (empty for an acknowledgement without text), or why there is no answer and what the operator can do instead.
        answer: Result<Box<str>, Box<str>>,
    },
    /// The line went down or came back.
    Link {
        /// Which gauge.
        channel: Channel,
        /// How it stands now.
        state: LinkState,
        /// When, s.
        at_s: f64,
    },
    /// Something the log should keep: a retry, a drain, bytes left over.
    Note {
        /// Which gauge.
        channel: Channel,
        /// What happened.
        text: Box<str>,
        /// When, s.
        at_s: f64,
    },
    /// There will be nothing more: the end of a replayed trace.
    Ended,
}

/// How the line to a gauge stands.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LinkState {
    /// Open, and the gauge that was expected answers.
    Connected {
        /// The port that it was found on.
        port: Box<str>,
    },
    /// Open, but nothing comes.
    Silent,
    /// Open, and answers come, but later than is waited for.
    Slow {
        /// How long is waited, and what to do.
        reason: Box<str>,
    },
    /// The port is gone: cable pulled, adapter reset, machine suspended.
    Lost {
        /// The error of the operating system.
        reason: Box<str>,
    },
    /// Looking for the gauge by its identity; the n-th try.
    Reconnecting {
        /// Which try, from 1.
        attempt: u32,
    },
    /// On the remembered port answers something else.
    WrongDevice {
        /// What answers, and what was expected.
        reason: Box<str>,
    },
    /// Tries are used up; [`Gauges::ask`] starts them again.
    GivenUp,
}
