//! `trace`: bytes of a line, recorded, shown, decoded, replayed.

use std::fs::{File, OpenOptions};
use std::io::{self, BufWriter, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use clap::Args;
use stiffbench_document::{Document, Table};

use crate::analysis::{ArgumentError, is_dash, read_bytes};
use crate::clock::Clock;
use crate::instrument::trace::{
    GaugeTrace, Replay, ReplayPace, TraceSink, TraceWriter, What, escaped, events_of,
};
use crate::instrument::{GaugeEvent, Gauges};
use crate::report::{
    ChannelValue, RecordReport, ReplayReport, TimedPacket, TimedValue, TraceLine, TraceReport,
    TraceValues,
};

use super::descriptions::{ProtocolsArgs, find_description};
use super::open::{Gauge, PortArgs};
use super::read::line;
use crate::cli::args::seconds;
use crate::cli::outcome::{print, print_error};
use crate::cli::{CliError, Failure, Global, Outcome};
use crate::count::counted;

/// Arguments of `gauge record`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench gauge record mark10-series5 --port /dev/ttyUSB0 --seconds 30 --out pull.trace\n  stiffbench gauge show pull.trace\n  stiffbench gauge decode pull.trace --json"
)]
pub(super) struct RecordArgs {
    /// Name of an instrument description, or a file
    #[arg(value_name = "INSTRUMENT")]
    instrument: String,
    /// Port and line.
    #[command(flatten)]
    port: PortArgs,
    /// File to write; it must not exist
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// How long to record, s [default: until the line is lost or the program is stopped]
    #[arg(long, value_name = "S", value_parser = seconds)]
    seconds: Option<f64>,
}

/// Arguments of `gauge replay`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  stiffbench gauge replay force.trace dial.trace --speed 10")]
pub(super) struct ReplayArgs {
    /// Traces, one for each gauge
    #[arg(required = true, num_args = 1..=2)]
    files: Vec<PathBuf>,
    /// Speed relative to the real clock; max for as fast as possible
    #[arg(long, default_value = "1", value_parser = pace)]
    speed: Speed,
    /// More descriptions.
    #[command(flatten)]
    protocols: ProtocolsArgs,
}

/// How fast a trace is replayed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::cli) enum Speed {
    /// So many times as fast as it was recorded.
    Times(f64),
    /// As fast as possible.
    Fastest,
}

/// How the first line of every trace begins.
const TRACE_BEGINS: &[u8; 19] = b"# stiffbench/trace/";

/// A file whose flush reaches the disk.
struct Durable(BufWriter<File>);

impl Write for Durable {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()?;
        self.0.get_ref().sync_data()
    }
}

pub(super) fn record(args: &RecordArgs, global: &Global) -> Result<Outcome, Failure> {
    if is_dash(&args.out) {
        return Err(CliError::Dash.into());
    }
    let file = new_file(&args.out)?;
    let opened = Gauge::open(&args.instrument, &args.port, global.quiet);
    let mut gauge = opened.inspect_err(|_| {
        // An empty trace helps nobody; that the port is not there is the news.
        let _ = std::fs::remove_file(&args.out);
    })?;
    let warnings = std::mem::take(&mut gauge.warnings);
    let writer = TraceWriter::begin(Durable(BufWriter::new(file)), &gauge.header)
        .map_err(CliError::write(&args.out))?;
    let failed = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&failed);
    let sink = TraceSink::start(writer, move |error| {
        flag.store(true, Ordering::Relaxed);
        print_error(&format!("the trace cannot be written any more: {error}"));
    });
    let clock = Clock::default();
    let mut reader = gauge.reader(clock, Some(Box::new(sink)))?;
    let (mut values, mut rejected) = (0_usize, 0_usize);
    let end_s = args.seconds.unwrap_or(f64::INFINITY);
    while clock.now_s() < end_s && !failed.load(Ordering::Relaxed) {
        let left_s = (end_s - clock.now_s()).clamp(0.0, 0.5);
        for event in reader.events(Duration::from_secs_f64(left_s))? {
            match event {
                GaugeEvent::Sample { sample, .. } => {
                    values += 1;
                    show_value(&line(&sample), global);
                }
                GaugeEvent::Rejected { .. } => rejected += 1,
                GaugeEvent::Note { text, .. } if !global.quiet => {
                    print_error(&format!("note: {text}"));
                }
                _ => {}
            }
        }
    }
    drop(reader);
    let text = format!(
        "{} and {} in {}\n",
        counted(values, "value"),
        counted(rejected, "rejected packet"),
        args.out.display()
    );
    let report = RecordReport {
        file: args.out.clone(),
        values,
        rejected,
        complete: !failed.load(Ordering::Relaxed),
    };
    Ok(Outcome::new("trace-record", text, report).with_warnings(warnings))
}

/// A file that was not there before.
fn new_file(path: &Path) -> Result<File, CliError> {
    let file = OpenOptions::new().write(true).create_new(true).open(path);
    file.map_err(CliError::create(path))
}

/// Shows a value as it comes.
fn show_value(line: &str, global: &Global) {
    if !global.json {
        // A reader that went away is found out when the rest is printed.
        let _ = print(&format!("{line}\n"));
    }
}

/// A trace, and what is to be said of its state.
fn read(file: &Path) -> Result<(GaugeTrace, Vec<String>), Failure> {
    let bytes = read_bytes(file)?;
    let name = file.to_string_lossy();
    let trace = GaugeTrace::parse(&bytes, &name)?;
    let mut warnings: Vec<String> = trace
        .damage
        .iter()
        .take(10)
        .map(|damage| {
            format!(
                "{name}, line {}: {}; it is left out",
                damage.line, damage.problem
            )
        })
        .collect();
    if trace.damage.len() > 10 {
        warnings.push(format!(
            "{name}: {} more lines are damaged and left out",
            trace.damage.len() - 10
        ));
    }
    if !trace.complete {
        warnings.push(format!(
            "{name} has no end mark: recording was interrupted, or the file was cut"
        ));
    }
    Ok((trace, warnings))
}

pub(super) fn show(file: &Path) -> Result<Outcome, Failure> {
    let (trace, warnings) = read(file)?;
    let mut document = Document::new();
    let header = &trace.header;
    let channel = header.channel.map(|channel| channel.to_string());
    for (name, value) in header.fields() {
        document.pair(name, value);
    }
    let entries = trace.entries.iter().map(|entry| {
        let (kind, what) = words(&entry.what);
        TraceLine {
            t_s: entry.at_s,
            kind,
            what,
        }
    });
    let entries: Vec<TraceLine> = entries.collect();
    document.table(
        Table::of(&entries)
            .numbers("t, s", |entry| format!("{:.6}", entry.t_s))
            .words("bytes or words", |entry| {
                format!("{} {}", entry.kind, entry.what)
            }),
    );
    let (received, sent) = byte_counts(&trace);
    document.paragraph(format!("{received} bytes received, {sent} sent"));
    let report = TraceReport {
        instrument: header.instrument.clone(),
        channel,
        unit: header.unit.clone(),
        port: header.port.clone(),
        line: header.line.clone(),
        started: header.started.clone(),
        speed: header.speed.unwrap_or(1.0),
        complete: trace.complete,
        bytes_received: received,
        bytes_sent: sent,
        entries,
    };
    Ok(Outcome::new("trace", document, report).with_warnings(warnings))
}

fn words(what: &What) -> (&'static str, String) {
    match what {
        What::Received(bytes) => ("received", escaped(bytes)),
        What::Sent { bytes, .. } => ("sent", escaped(bytes)),
        What::Unused { count, reason } => ("unused", format!("the last {count}: {reason}")),
        What::Reset => ("reset", String::new()),
        What::Link(state) => ("link", format!("{state:?}")),
        What::Note(text) => ("note", text.clone()),
        What::End => ("end", String::new()),
    }
}

fn byte_counts(trace: &GaugeTrace) -> (usize, usize) {
    let mut counts = (0, 0);
    for entry in &trace.entries {
        match &entry.what {
            What::Received(bytes) => counts.0 += bytes.len(),
            What::Sent { bytes, .. } => counts.1 += bytes.len(),
            _ => {}
        }
    }
    counts
}

/// Events with their times, s.
type Events = Vec<(f64, GaugeEvent)>;

/// The events of a trace, by the description that it names or that is named.
fn events(
    file: &Path,
    instrument: Option<&str>,
    unit: Option<&str>,
    protocols: &ProtocolsArgs,
) -> Result<(Events, Vec<String>), Failure> {
    let (trace, mut warnings) = read(file)?;
    let Some(name) = instrument.or(trace.header.instrument.as_deref()) else {
        return ArgumentError::refuse(
            file.display().to_string(),
            "this trace does not name its gauge",
            "stiffbench gauge decode GAUGE TRACE names it; stiffbench gauge list shows what is known",
        );
    };
    let found = find_description(name, protocols)?;
    warnings.extend(found.warnings);
    Ok((events_of(&trace, &found.description, unit)?, warnings))
}

/// Whether a file is meant as a trace: it is called one, or begins as one of whatever version.
pub(super) fn is_trace(file: &Path) -> bool {
    let mut begin = [0; TRACE_BEGINS.len()];
    let read = File::open(file).and_then(|mut file| file.read_exact(&mut begin));
    let is_called = file.extension().is_some_and(|ending| ending == "trace");
    is_called || (read.is_ok() && begin == *TRACE_BEGINS)
}

/// Decodes the values of a trace, by the description that it names or by `gauge`.
pub(super) fn decode(
    file: &Path,
    gauge: Option<&str>,
    (unit, protocols): (Option<&str>, &ProtocolsArgs),
) -> Result<Outcome, Failure> {
    let (events, warnings) = events(file, gauge, unit, protocols)?;
    let mut document = Document::new();
    let (mut samples, mut rejected) = (Vec::new(), Vec::new());
    for (_, event) in &events {
        match event {
            GaugeEvent::Sample { sample, .. } => {
                document.lines(line(sample));
                samples.push(TimedValue::from(sample));
            }
            GaugeEvent::Rejected {
                rejected: packet, ..
            } => {
                document.lines(format!(
                    "{:10.3} s  no value: {} ({})",
                    packet.at_s, packet.raw, packet.reason
                ));
                rejected.push(TimedPacket::from(packet));
            }
            _ => {}
        }
    }
    document.lines(format!(
        "{}, {}",
        counted(samples.len(), "value"),
        counted(rejected.len(), "rejected packet")
    ));
    let report = TraceValues { samples, rejected };
    Ok(Outcome::new("trace-decode", document, report).with_warnings(warnings))
}

pub(super) fn replay(args: &ReplayArgs, global: &Global) -> Result<Outcome, Failure> {
    let mut traces = Vec::new();
    let mut warnings = Vec::new();
    for file in &args.files {
        let (events, of_file) = events(file, None, None, &args.protocols)?;
        traces.push(events);
        warnings.extend(of_file);
    }
    let pace = match args.speed {
        Speed::Times(times) => ReplayPace::By(Clock::starting_at(0.0, times)),
        Speed::Fastest => ReplayPace::Fastest,
    };
    let mut replay = Replay::new(traces, pace);
    let mut samples = Vec::new();
    loop {
        match replay.next(Duration::from_secs(1)) {
            Some(GaugeEvent::Sample { channel, sample }) => {
                show_value(&format!("{channel:<12} {}", line(&sample)), global);
                samples.push(ChannelValue {
                    value: (&sample).into(),
                    channel,
                });
            }
            Some(GaugeEvent::Ended) => break,
            _ => {}
        }
    }
    let text = format!("{}\n", counted(samples.len(), "value"));
    Ok(Outcome::new("trace-replay", text, ReplayReport { samples }).with_warnings(warnings))
}

/// A speed as typed: a number, or max.
pub(in crate::cli) fn pace(text: &str) -> Result<Speed, String> {
    if text == "max" {
        return Ok(Speed::Fastest);
    }
    match text.trim_end_matches(['x', '×']).parse::<f64>() {
        Ok(times) if times.is_finite() && times > 0.0 => Ok(Speed::Times(times)),
        _ => Err("it is a positive number, or max".to_owned()),
    }
}
