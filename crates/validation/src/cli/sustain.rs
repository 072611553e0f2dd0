//! `sustain`: whether nothing is lost when two gauges stream for long, and what that costs.

use std::fmt::Write as _;
use std::time::Duration;

use clap::Args;

use stiffbench::clock::Clock;
use stiffbench::instrument::driver::Acquisition;
use stiffbench::instrument::live::{LiveGauge, LiveGauges, RetryPolicy};
use stiffbench::instrument::port::{PortIdentity, PortTimeouts};
use stiffbench::instrument::{Channel, GaugeEvent, Gauges, InstrumentDescription};

use crate::report::{GaugeTallyReport, SustainReport};

use super::counter::Counter;
use stiffbench::cli::args::{Global, seconds};
use stiffbench::cli::failure::Failure;
use stiffbench::cli::outcome::Outcome;
use stiffbench::cli::progress::progress;

/// Arguments of `sustain`.
#[derive(Debug, Args)]
pub(crate) struct SustainArgs {
    /// Seconds to stream
    #[arg(long, value_name = "S", default_value = "60", value_parser = seconds)]
    seconds: f64,
    /// Values a second of the force gauge
    #[arg(long, value_name = "N", default_value_t = 250, value_parser = clap::value_parser!(u32).range(1..=2000))]
    force_per_s: u32,
    /// Values a second of the displacement gauge
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(1..=2000))]
    displacement_per_s: u32,
}

/// A gauge that streams its count; `CHANNEL` and `UNIT` are put in.
const GAUGE: &str = r#"
schema = "stiffbench/instrument/1"
name = "counter"
text = "an emulated gauge that sends its count"
channel = "CHANNEL"
status = "documented"
[line]
baud = 115200
settle_s = 0.0
[timing]
discard_after_open = 0
silent_after_s = 5
[commands]
terminator = "\r"
stream_start = { send = "ON", expects = "nothing", effect = "sets" }
stream_stop = { send = "OFF", expects = "nothing", effect = "sets" }
[framing.line]
end = ["\r"]
[sign]
compression = "ask"
[unit]
from = "packet"
[unit.codes]
UNIT = "UNIT"
[[value]]
fields = [{ sign = { plus = ["+"], minus = ["-"] } }, { number = { count = [1, 9] } }, { literal = " " }, { unit = {} }]
"#;

/// What came of one gauge.
#[derive(Debug, Clone, Copy, Default)]
struct GaugeTally {
    sent: u64,
    received: u64,
    last: u64,
    out_of_order: u64,
    rejected: u64,
}

impl GaugeTally {
    fn take(&mut self, value: f64) {
        let value = value as u64;
        self.received += 1;
        if value <= self.last {
            self.out_of_order += 1;
        } else {
            self.last = value;
        }
    }

    fn lost(&self) -> u64 {
        (self.sent + self.out_of_order).saturating_sub(self.received)
    }

    fn report(&self) -> GaugeTallyReport {
        GaugeTallyReport {
            sent: self.sent,
            received: self.received,
            lost: self.lost(),
            out_of_order: self.out_of_order,
            rejected: self.rejected,
        }
    }
}

/// Runs `sustain`.
pub(crate) fn run(args: &SustainArgs, global: &Global) -> Result<Outcome, Failure> {
    let rates = [args.force_per_s, args.displacement_per_s];
    let totals = rates.map(|rate| (f64::from(rate) * args.seconds).round() as u64);
    let (mut counters, mut gauges) = (Vec::new(), Vec::new());
    for (channel, (rate, total)) in Channel::ALL.into_iter().zip(rates.into_iter().zip(totals)) {
        let counter = Counter::start(unit(channel), rate, total)?;
        gauges.push(live_gauge(channel, &counter.path)?);
        counters.push(counter);
    }
    let clock = Clock::default();
    let mut live = LiveGauges::start(
        gauges,
        clock,
        PortTimeouts::default(),
        RetryPolicy::default(),
    )?;
    let mut held = Held::default();
    let bar = progress(global, "streaming", args.seconds as u64);
    while held.is_going_on(totals, clock.now_s()) {
        if let Some(event) = live.next(Duration::from_millis(500)) {
            held.take(event, clock.now_s(), args.seconds);
            bar.set(clock.now_s() as u64, args.seconds as u64, "");
        }
    }
    bar.finish_and_clear();
    let at_end = usage(clock.now_s());
    drop(live);
    for (tally, counter) in held.tallies.iter_mut().zip(counters) {
        tally.sent = counter.sent();
    }
    let outcome = report(&held.tallies, held.at_start, at_end, clock.now_s());
    Ok(outcome.with_warnings(held.faults))
}

/// What came so far.
#[derive(Debug, Default)]
struct Held {
    tallies: [GaugeTally; 2],
    at_start: Option<Usage>,
    faults: Vec<String>,
    last_s: f64,
}

/// Faults that are told one by one; all are counted.
const MOST_FAULTS: usize = 20;
/// Without any value for so long, nothing more comes, s.
const SILENCE_S: f64 = 10.0;

impl Held {
    fn is_going_on(&self, totals: [u64; 2], now_s: f64) -> bool {
        let is_short = self
            .tallies
            .iter()
            .zip(totals)
            .any(|(tally, total)| tally.last < total);
        is_short && now_s - self.last_s < SILENCE_S
    }

    fn take(&mut self, event: GaugeEvent, now_s: f64, seconds: f64) {
        let fault = match event {
            GaugeEvent::Sample { channel, sample } => {
                self.tallies[channel.index()].take(sample.value);
                self.last_s = now_s;
                // Measured when everything is running.
                if self.at_start.is_none() && now_s > 1.0_f64.min(seconds / 4.0) {
                    self.at_start = usage(now_s);
                }
                return;
            }
            GaugeEvent::Rejected { channel, rejected } => {
                self.tallies[channel.index()].rejected += 1;
                format!("{channel}: {} ({})", rejected.raw, rejected.reason)
            }
            GaugeEvent::Note { channel, text, .. } => format!("{channel}: {text}"),
            _ => return,
        };
        if self.faults.len() < MOST_FAULTS {
            self.faults.push(fault);
        }
    }
}

fn unit(channel: Channel) -> &'static str {
    match channel {
        Channel::Force => "N",
        _ => "mm",
    }
}

fn live_gauge(channel: Channel, path: &str) -> Result<LiveGauge, Failure> {
    let text = GAUGE
        .replace("CHANNEL", &channel.to_string())
        .replace("UNIT", unit(channel));
    let (description, _) = InstrumentDescription::parse(&text, "counter")?;
    Ok(LiveGauge {
        description,
        unit: None,
        port: PortIdentity::Path(path.to_owned()),
        acquisition: Acquisition::Stream,
        identity: None,
        trace: None,
    })
}

/// What the program has used so far: processor time of all its threads, s; resident memory, kB.
#[derive(Debug, Clone, Copy)]
struct Usage {
    at_s: f64,
    processor_s: f64,
    resident_kb: u64,
}

/// Clock ticks a second in which Linux counts processor time, the same on all its machines.
const TICKS_PER_S: f64 = 100.0;

/// What the program has used so far, where the system reports it.
fn usage(at_s: f64) -> Option<Usage> {
    let stat = std::fs::read_to_string("/proc/self/stat").ok()?;
    // The name in brackets may hold blanks; user and system time are the 12th and 13th field behind it.
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks = |place: usize| fields.get(place)?.parse::<f64>().ok();
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let resident = status
        .lines()
        .find_map(|line| line.strip_prefix("VmRSS:"))?;
    Some(Usage {
        at_s,
        processor_s: (ticks(11)? + ticks(12)?) / TICKS_PER_S,
        resident_kb: resident.split_whitespace().next()?.parse().ok()?,
    })
}

fn report(
    tallies: &[GaugeTally; 2],
    start: Option<Usage>,
    end: Option<Usage>,
    seconds: f64,
) -> Outcome {
    let mut text = String::new();
    for (channel, tally) in Channel::ALL.into_iter().zip(tallies) {
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{channel:<12} {} sent, {} received, {} lost, {} out of order, {} rejected",
            tally.sent,
            tally.received,
            tally.lost(),
            tally.out_of_order,
            tally.rejected
        );
    }
    let cost = start.zip(end).filter(|(start, end)| end.at_s > start.at_s);
    let share = cost.map(|(start, end)| {
        100.0 * (end.processor_s - start.processor_s) / (end.at_s - start.at_s)
    });
    match (share, cost) {
        (Some(share), Some((start, end))) => {
            let _ = writeln!(
                text,
                "processor    {share:.2} % of one core, with the two emulated gauges\nmemory       {} kB at the start, {} kB at the end",
                start.resident_kb, end.resident_kb
            );
        }
        _ => text.push_str("this system does not report processor time and memory\n"),
    }
    let is_clean = tallies
        .iter()
        .all(|tally| tally.lost() + tally.out_of_order + tally.rejected == 0);
    let data = SustainReport {
        seconds,
        force: tallies[0].report(),
        displacement: tallies[1].report(),
        processor_percent: share,
        resident_start_kb: cost.map(|(start, _)| start.resident_kb),
        resident_end_kb: cost.map(|(_, end)| end.resident_kb),
        reason: cost
            .is_none()
            .then_some("the system does not report processor time and memory"),
    };
    Outcome::new("trace-sustain", text, data).with_strict_exit(u8::from(!is_clean))
}
