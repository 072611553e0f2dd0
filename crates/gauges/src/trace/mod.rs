//! Recorded traces: every byte of a line, both directions, with its time (docs/trace-file.md, schema `stiffbench/trace/1`).
//!
//! A trace is text that a person can read and a program can trust: each line states how many bytes it holds, so that a cut or damaged one is
//! known. What the driver decided (values not used, the decoder restarted) stands in it too, so that a replay gives the samples of the
//! live run.

mod decode;
mod escape;
mod read;
mod replay;
mod sink;
mod write;

pub use decode::events_of;
pub use escape::{escaped, unescaped};
pub use read::{DamagedLine, GaugeTrace, TraceError};
pub use replay::{Replay, ReplayPace};
pub use sink::{Sink, TraceSink};
pub use write::TraceWriter;

use super::description::CommandRole;
use super::gauges::LinkState;
use super::sample::Channel;

/// Schema of a trace, its first line behind `# `.
pub const TRACE_SCHEMA: &str = "stiffbench/trace/1";

/// Known properties of a trace as a whole.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct TraceHeader {
    /// Name of the instrument description.
    pub instrument: Option<String>,
    /// Which gauge of the bench.
    pub channel: Option<Channel>,
    /// Unit, where the gauge does not send one.
    pub unit: Option<String>,
    /// The port, by what stays of it.
    pub port: Option<String>,
    /// Line settings.
    pub line: Option<String>,
    /// UTC of time 0, RFC 3339.
    pub started: Option<String>,
    /// Seconds of the trace in a real one: other than 1 for a session in fast-forward.
    pub speed: Option<f64>,
}

impl TraceHeader {
    /// What is known, by its keys, in the order of the file; a speed of 1 is omitted.
    #[must_use]
    pub fn fields(&self) -> Vec<(&'static str, String)> {
        let speed = self.speed.filter(|speed| *speed != 1.0);
        let fields = [
            ("instrument", self.instrument.clone()),
            ("channel", self.channel.map(|channel| channel.to_string())),
            ("unit", self.unit.clone()),
            ("port", self.port.clone()),
            ("line", self.line.clone()),
            ("started", self.started.clone()),
            ("speed", speed.map(|speed| speed.to_string())),
        ];
        let known = fields.into_iter();
        known
            .filter_map(|(key, value)| Some((key, value?)))
            .collect()
    }
}

/// One line of a trace.
#[derive(Debug, Clone, PartialEq)]
pub struct TraceEntry {
    /// When, s.
    pub at_s: f64,
    /// What.
    pub what: What,
}

/// What happened on a line.
#[derive(Debug, Clone, PartialEq)]
pub enum What {
    /// Bytes from the gauge, as one read gave them.
    Received(Vec<u8>),
    /// Bytes to the gauge, and what they ask for where that is known.
    Sent {
        /// What they ask for.
        role: Option<CommandRole>,
        /// The bytes.
        bytes: Vec<u8>,
    },
    /// The last `count` values before this are not used.
    Unused {
        /// How many.
        count: usize,
        /// Why.
        reason: String,
    },
    /// The decoder restarted: the line was drained.
    Reset,
    /// The line went down or came back.
    Link(LinkState),
    /// Something worth keeping.
    Note(String),
    /// Recording ended here as it should.
    End,
}

fn role_of(key: &str) -> Option<CommandRole> {
    CommandRole::ALL.into_iter().find(|role| role.key() == key)
}
