//! `gauge read`: values of one gauge, now.

use std::collections::BTreeMap;
use std::time::Duration;

use clap::Args;

use crate::clock::Clock;
use crate::count::counted;
use crate::instrument::port::PortError;
use crate::instrument::{GaugeEvent, LinkState, Sample};
use crate::report::{ReadReport, TimedPacket, TimedValue};

use super::open::{Gauge, PortArgs};
use crate::cli::args::seconds;
use crate::cli::outcome::{print, print_error};
use crate::cli::{Failure, Global, Outcome};

/// Arguments of `gauge read`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench gauge read mark10-series5 --port /dev/ttyUSB0\n  stiffbench gauge read sauter-fh --unit N --seconds 10 --json"
)]
pub(in crate::cli) struct ReadArgs {
    /// Name of an instrument description, or a file
    #[arg(value_name = "INSTRUMENT")]
    instrument: String,
    /// Port and line.
    #[command(flatten)]
    port: PortArgs,
    /// Number of values to read [default: 1, or as many as arrive within --seconds]
    #[arg(long, value_name = "N")]
    count: Option<usize>,
    /// How long to read, s
    #[arg(long, value_name = "S", value_parser = seconds)]
    seconds: Option<f64>,
}

/// Without a value for so long none comes any more, s.
const PATIENCE_S: f64 = 10.0;

/// So many rejected packets of one kind are printed one by one.
const ALIKE: usize = 3;

/// Runs `gauge read`.
pub(in crate::cli) fn run(args: &ReadArgs, global: &Global) -> Result<Outcome, Failure> {
    let mut gauge = Gauge::open(&args.instrument, &args.port, global.quiet)?;
    let mut warnings = std::mem::take(&mut gauge.warnings);
    let (name, port) = (gauge.description.name.clone(), gauge.header.port.clone());
    let clock = Clock::default();
    let mut reader = gauge.reader(clock, None)?;
    let wanted = match (args.count, args.seconds) {
        (Some(count), _) => count,
        (None, Some(_)) => usize::MAX,
        (None, None) => 1,
    };
    let end_s = args.seconds.unwrap_or(f64::INFINITY);
    let mut taken = Taken::default();
    while taken.samples.len() < wanted && clock.now_s() < end_s {
        let left_s = (end_s - clock.now_s()).clamp(0.0, 1.0);
        for event in reader.events(Duration::from_secs_f64(left_s))? {
            if taken.samples.len() < wanted {
                taken.take(event, clock.now_s(), global);
            }
        }
        let is_hopeless = taken.silent || clock.now_s() - taken.last_s > PATIENCE_S;
        if args.seconds.is_none() && is_hopeless {
            break;
        }
    }
    if taken.samples.is_empty() && args.seconds.is_none() {
        return Err(taken
            .nothing(port.unwrap_or_default(), clock.now_s())
            .into());
    }
    warnings.extend(taken.samples.is_empty().then(|| {
        format!(
            "no value of {name} was received: is another gauge on this port, or does it have another unit or mode? stiffbench gauge probe identifies the gauge on every port"
        )
    }));
    Ok(taken
        .outcome(&name, reader.identity(), clock.now_s())
        .with_warnings(warnings))
}

/// What came.
#[derive(Debug, Default)]
struct Taken {
    samples: Vec<TimedValue>,
    rejected: Vec<TimedPacket>,
    /// How many packets were rejected for each reason.
    alike: BTreeMap<String, usize>,
    notes: Vec<String>,
    silent: bool,
    /// When the last value came, s.
    last_s: f64,
}

impl Taken {
    /// Why there is no value.
    fn nothing(&self, port: String, waited_s: f64) -> PortError {
        match self.rejected.last() {
            None => PortError::Silent { port, waited_s },
            Some(last) => PortError::WrongDevice {
                port,
                problem: format!(
                    "no value was received, but {:?} ({:?})",
                    last.packet.raw, last.packet.reason
                ),
                help: "is another gauge on this port? Compare instrument, unit and mode with what the gauge shows; stiffbench gauge probe identifies the gauge on every port".to_owned(),
            },
        }
    }

    fn take(&mut self, event: GaugeEvent, now_s: f64, global: &Global) {
        match event {
            GaugeEvent::Sample { sample, .. } => {
                if !global.json {
                    // A reader that went away is found out when the rest is printed.
                    let _ = print(&format!("{}\n", line(&sample)));
                }
                self.samples.push((&sample).into());
                self.last_s = now_s;
                self.silent = false;
            }
            GaugeEvent::Rejected { rejected, .. } => {
                let alike = self.alike.entry(rejected.reason.to_string()).or_default();
                *alike += 1;
                if !global.json && !global.quiet && *alike <= ALIKE {
                    let more = match *alike {
                        ALIKE => "; others of this kind are not printed",
                        _ => "",
                    };
                    let (raw, reason) = (&rejected.raw, &rejected.reason);
                    print_error(&format!("no value: {raw} ({reason}){more}"));
                }
                self.rejected.push((&rejected).into());
            }
            GaugeEvent::Note { text, .. } => {
                if !global.json && !global.quiet {
                    print_error(&format!("note: {text}"));
                }
                self.notes.push(text.into());
            }
            GaugeEvent::Link {
                state: LinkState::Silent,
                ..
            } => self.silent = true,
            GaugeEvent::Link {
                state: LinkState::Slow { reason },
                ..
            } => self.notes.push(reason.into()),
            _ => {}
        }
    }

    fn outcome(self, instrument: &str, identity: Option<&str>, seconds: f64) -> Outcome {
        let text = format!(
            "{instrument}{}: {} and {} in {seconds:.1} s\n",
            identity.map_or_else(String::new, |identity| format!(" ({identity})")),
            counted(self.samples.len(), "value"),
            counted(self.rejected.len(), "rejected packet")
        );
        let report = ReadReport {
            instrument: instrument.to_owned(),
            identity: identity.map(str::to_owned),
            seconds,
            samples: self.samples,
            rejected: self.rejected,
            notes: self.notes,
        };
        Outcome::new("instrument-read", text, report)
    }
}

/// A value for people: time, value as sent, unit, marks.
pub(in crate::cli) fn line(sample: &Sample) -> String {
    let marks: Vec<String> = sample
        .marks
        .iter()
        .map(|mark| format!("{mark:?}"))
        .collect();
    format!(
        "{:10.3} s  {:>12} {}  {}",
        sample.at_s,
        sample.value,
        sample.unit,
        marks.join(" ")
    )
    .trim_end()
    .to_owned()
}
