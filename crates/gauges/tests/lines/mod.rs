//! Live lines through pseudo-terminals that are opened by name, as real ports are: what comes, what is lost, what is found again.

#![cfg(unix)]
mod device;
mod faults;
mod trace;
mod values;

use std::path::{Path, PathBuf};
use std::time::Duration;

use stiffbench_gauges::driver::Acquisition;
use stiffbench_gauges::live::{LiveGauge, LiveGauges, RetryPolicy};
use stiffbench_gauges::port::{PortIdentity, PortTimeouts};
use stiffbench_gauges::trace::Sink;
use stiffbench_gauges::{Channel, GaugeEvent, Gauges, InstrumentDescription, LinkState, Sample};
use stiffbench_units_and_text::clock::Clock;
use tempfile::TempDir;

use device::Device;

/// Long enough for anything that should happen; a test that waits so long fails.
const LONG: Duration = Duration::from_secs(20);

const POLL: Acquisition = Acquisition::Poll { most_per_s: 500.0 };

/// A gauge that is asked for each value and identifies itself.
const GAUGE: &str = r#"
schema = "stiffbench/instrument/1"
name = "trial"
text = "a gauge for tests"
channel = "force"
status = "documented"
[line]
baud = 9600
settle_s = 0
[timing]
reply_deadline_s = 0.25
drain_s = 0.03
retries = 2
most_per_s = 500
discard_after_open = 0
silent_after_s = 0.5
[commands]
terminator = "\r"
read = { send = "R", expects = "value" }
identify = { send = "ID", expects = "text" }
[framing.line]
end = ["\r"]
[sign]
compression = "positive"
[unit]
from = "packet"
[unit.codes]
N = "N"
[[value]]
fields = [{ sign = { plus = ["+"], minus = ["-"] } }, { number = { count = [1, 8] } }, { blanks = [1] }, { unit = {} }]
"#;

/// The description of a gauge for tests, on a channel.
fn description(channel: Channel) -> InstrumentDescription {
    let text = match channel {
        Channel::Force => GAUGE.to_owned(),
        _ => GAUGE
            .replace("\"force\"", "\"displacement\"")
            .replace("compression = \"positive\"", "compression = \"ask\"")
            .replace("N = \"N\"", "mm = \"mm\""),
    };
    let (description, warnings) = InstrumentDescription::parse(&text, "trial").unwrap();
    assert_eq!(warnings, [""; 0]);
    description
}

/// A gauge of the live bench on a port that is named by its path.
fn gauge(description: InstrumentDescription, path: &str) -> LiveGauge {
    LiveGauge {
        description,
        unit: None,
        port: PortIdentity::Path(path.to_owned()),
        acquisition: POLL,
        identity: None,
        trace: None,
    }
}

/// A live bench that looks for lost gauges without much waiting.
fn start(gauges: Vec<LiveGauge>) -> LiveGauges {
    start_by(Clock::default(), gauges)
}

fn start_by(clock: Clock, gauges: Vec<LiveGauge>) -> LiveGauges {
    let retry_policy = RetryPolicy {
        first_s: 0.01,
        longest_s: 0.05,
        tries: 400,
    };
    LiveGauges::start(gauges, clock, PortTimeouts::without_waiting(), retry_policy).unwrap()
}

impl Device {
    /// A device that identifies itself and counts: the n-th value is n, in `unit`.
    pub(crate) fn counting(name: &Path, identity: &'static str, unit: &'static str) -> Self {
        let mut count = 0;
        Self::at(name, move |command| {
            if command == "ID" {
                return vec![format!("{identity}\r").into_bytes()];
            }
            count += 1;
            vec![format!("+{count} {unit}\r").into_bytes()]
        })
    }
}

/// Where devices put the names of their ports.
struct Desk(TempDir);

impl Desk {
    fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    fn name(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    fn path(&self, name: &str) -> String {
        self.name(name).to_str().unwrap().to_owned()
    }
}

/// Takes events until one is as wanted; all of them.
fn until(gauges: &mut LiveGauges, mut wanted: impl FnMut(&GaugeEvent) -> bool) -> Vec<GaugeEvent> {
    let clock = Clock::default();
    let mut events = Vec::new();
    loop {
        assert!(
            clock.now_s() < LONG.as_secs_f64(),
            "it never came; what came: {events:#?}"
        );
        let Some(event) = gauges.next(Duration::from_millis(100)) else {
            continue;
        };
        let found = wanted(&event);
        events.push(event);
        if found {
            return events;
        }
    }
}

fn is_link(event: &GaugeEvent, wanted: impl FnOnce(&LinkState) -> bool) -> bool {
    matches!(event, GaugeEvent::Link { state, .. } if wanted(state))
}

/// Takes events until the line is in a state; all of them.
fn until_link(gauges: &mut LiveGauges, wanted: impl Fn(&LinkState) -> bool) -> Vec<GaugeEvent> {
    until(gauges, |event| is_link(event, &wanted))
}

fn is_lost(state: &LinkState) -> bool {
    matches!(state, LinkState::Lost { .. })
}

fn is_reconnecting(state: &LinkState) -> bool {
    matches!(state, LinkState::Reconnecting { .. })
}

/// Why a line is lost, or another device's.
fn reason_of(event: Option<&GaugeEvent>) -> &str {
    match event {
        Some(GaugeEvent::Link {
            state: LinkState::Lost { reason } | LinkState::WrongDevice { reason },
            ..
        }) => reason,
        other => panic!("{other:?} has no reason"),
    }
}

fn is_connected(event: &GaugeEvent) -> bool {
    is_link(event, |state| matches!(state, LinkState::Connected { .. }))
}

fn samples(events: &[GaugeEvent]) -> Vec<&Sample> {
    let mut samples = Vec::new();
    for event in events {
        if let GaugeEvent::Sample { sample, .. } = event {
            samples.push(sample);
        }
    }
    samples
}

fn is_sample(event: &GaugeEvent) -> bool {
    matches!(event, GaugeEvent::Sample { .. })
}

/// A trace in memory, to be checked while it is written.
#[derive(Clone, Default)]
struct Memory(std::sync::Arc<std::sync::Mutex<Vec<stiffbench_gauges::trace::TraceEntry>>>);

impl Sink for Memory {
    fn take(&mut self, entry: stiffbench_gauges::trace::TraceEntry) {
        self.0.lock().unwrap().push(entry);
    }
}
