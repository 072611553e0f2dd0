//! The gauges that a session is measured with, from arguments, bindings, and what the session knows of them.

use crate::analysis::{AnalysisError, ArgumentError};
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

use crate::cli::failure::{CliError, Failure};
use crate::cli::gauge::descriptions::find_description;
use crate::cli::gauge::open::{BINDINGS_FILE, read_bindings};
use crate::cli::outcome::print_error;
use crate::clock::Clock;
use crate::instrument::driver::Acquisition;
use crate::instrument::live::{LiveGauge, LiveGauges, RetryPolicy};
use crate::instrument::port::{
    Binding, Bindings, PortError, PortIdentity, PortTimeouts, list_ports,
};
use crate::instrument::trace::{Sink, TraceHeader, TraceSink, TraceWriter};
use crate::instrument::{Channel, Decoder, Gauges, InstrumentDescription};
use crate::readings::{InstrumentRecord, Instruments};
use crate::session::{SessionState, Settings};

use super::answering::{AnsweringGauge, who_answers};
use super::args::{BenchArgs, StatedGauge};

/// Which gauge is meant, and where it is.
pub(super) struct ResolvedGauge {
    pub(super) description: InstrumentDescription,
    pub(super) unit: Option<String>,
    port: PortIdentity,
    identity: Option<String>,
}

impl ResolvedGauge {
    /// Step of its display in N or m: in the unit that is configured, or the only one that it has.
    pub(super) fn resolution_si(&self) -> Option<f64> {
        let steps = &self.description.physical.resolution;
        let (unit, step) = match &self.unit {
            Some(unit) => steps.iter().find(|(of, _)| of == unit)?,
            None => steps.first().filter(|_| steps.len() == 1)?,
        };
        Some(step * self.description.channel.kind().si_factor(unit)?)
    }

    /// What it is and where, in words.
    pub(super) fn words(&self) -> String {
        let (channel, name) = (self.description.channel, &self.description.name);
        format!("{channel} gauge: {name} on {}", self.port)
    }
}

/// What is meant by the arguments, before any port is touched; and what a user should know.
///
/// # Arguments
/// - `channels`: the gauges of the plan.
/// - `begun_with`: the records that the session was begun with, for resuming.
/// - `state`: where the session stands; knows the ports of before.
pub(super) fn resolve_gauges(
    args: &BenchArgs,
    channels: &[Channel],
    begun_with: &Instruments,
    state: &SessionState,
) -> Result<(Vec<ResolvedGauge>, Vec<String>), Failure> {
    let (bindings, mut warnings) = bindings_of(args, channels)?;
    let mut resolved = Vec::new();
    let mut answered: Vec<String> = Vec::new();
    for &channel in channels {
        let bound = bindings.of(channel);
        let stated = args.of(channel).beside(bound);
        let named = |of: &Channel| args.of(*of).port;
        let known_port = |of: &Channel| {
            let known = state.instruments[of.index()].as_ref()?;
            Some(known.port.clone()).filter(|port| !port.is_empty())
        };
        let port = known_port(&channel);
        let record = record_of(begun_with, channel);
        let model = record.and_then(InstrumentRecord::description_name);
        let bound_port = bound.and_then(Binding::port);
        let answers = if stated.port.is_none() && bound_port.is_none() && port.is_none() {
            check_named(args, channels)?;
            let name = stated.instrument.as_deref().or(model);
            let mut taken: Vec<String> = channels.iter().filter_map(named).collect();
            taken.extend(channels.iter().filter_map(known_port));
            let bound = channels.iter().filter_map(|of| bindings.of(*of)?.port());
            taken.extend(bound.map(|port| port.to_string()));
            taken.extend(answered.iter().cloned());
            who_answers(channel, name, &args.protocols, &taken)?
        } else {
            None
        };
        if let Some(found) = &answers {
            print_error(&format!("note: {}", found.note(channel)));
            answered.push(found.path.clone());
        }
        resolved.push(resolve_gauge(
            args,
            channel,
            (stated, bound),
            model,
            port.as_deref(),
            answers.as_ref(),
            &mut warnings,
        )?);
    }
    let twice = resolved
        .iter()
        .enumerate()
        .find_map(|(place, gauge): (usize, &ResolvedGauge)| {
            let mut before = resolved[..place].iter();
            before
                .find(|other| other.port == gauge.port)
                .map(|_| gauge.port.to_string())
        });
    if let Some(port) = twice {
        return ArgumentError::refuse(
            port,
            "two gauges of this session are on this port",
            "each gauge needs a port of its own: --force port=PORT, --displacement port=PORT, port=x=PORT for each of several",
        );
    }
    Ok((resolved, warnings))
}

/// The bindings, and what a user should know of them; values for gauges that the plan does not have are refused.
fn bindings_of(args: &BenchArgs, channels: &[Channel]) -> Result<(Bindings, Vec<String>), Failure> {
    // The usual file may be absent; one that was named may not.
    if !args.bindings.exists() && args.bindings != Path::new(BINDINGS_FILE) {
        return Err(AnalysisError::NotFound {
            path: args.bindings.clone(),
            help: "stiffbench gauge bind force makes a bindings file".to_owned(),
        }
        .into());
    }
    if let Some(value) = args.out_of_plan(channels) {
        return ArgumentError::refuse(
            value,
            "this session has no displacement gauge along that axis",
            "name the axes with --displacement-axes or in the procedure, for example --displacement-axes x,y,z",
        );
    }
    read_bindings(&args.bindings)
}

/// Whether the ports that the arguments name are there; others are searched only then.
fn check_named(args: &BenchArgs, channels: &[Channel]) -> Result<(), PortError> {
    let mut named = channels.iter().filter_map(|of| args.of(*of).port);
    let absent =
        named.find(|path| cfg!(unix) && path.starts_with('/') && !Path::new(path).exists());
    match absent {
        Some(port) => Err(PortError::Absent { port, near: None }),
        None => Ok(()),
    }
}

/// The record of a gauge.
pub(super) fn record_of(instruments: &Instruments, channel: Channel) -> Option<&InstrumentRecord> {
    let record = match (channel, channel.axis()) {
        (_, Some(axis)) => &instruments.displacement_along[axis.index()],
        (Channel::Force, _) => &instruments.force,
        _ => &instruments.displacement,
    };
    record.as_ref()
}

/// Whether the ports are there, where nobody could plug a gauge in.
///
/// # Errors
/// [`PortError::Absent`] for the first that is not.
pub(super) fn check_present(resolved: &[ResolvedGauge]) -> Result<(), Failure> {
    let ports = list_ports().unwrap_or_default();
    for gauge in resolved {
        let path = gauge.port.resolve(&ports)?.path;
        if cfg!(unix) && !Path::new(&path).exists() {
            return Err(PortError::Absent {
                port: path,
                near: None,
            }
            .into());
        }
    }
    Ok(())
}

fn resolve_gauge(
    args: &BenchArgs,
    channel: Channel,
    (stated, bound): (StatedGauge, Option<&Binding>),
    model: Option<&str>,
    port: Option<&str>,
    answers: Option<&AnsweringGauge>,
    warnings: &mut Vec<String>,
) -> Result<ResolvedGauge, Failure> {
    let (option, value) = option_of(channel);
    let needed = |what: &str| {
        ArgumentError::new(
            format!("--{option} {what}={value}"),
            format!("{what} of the {channel} gauge is missing"),
            format!(
                "name it, or bind the gauge once with stiffbench gauge bind and give the file with --bindings; stiffbench gauge list names the descriptions, stiffbench gauge ports the ports (--{option} {what}={value})"
            ),
        )
    };
    let name = stated.instrument.as_deref().or(model);
    let name = name.or(answers.map(|found| found.instrument.as_str()));
    let name = name.ok_or_else(|| needed("instrument"))?;
    let unit = stated.unit;
    let description = usable_description(args, channel, name, unit.as_deref(), warnings)?;
    let ports = list_ports().unwrap_or_default();
    let port = match (stated.port, bound.and_then(Binding::port), port) {
        (Some(path), ..) => PortIdentity::of_path(&path, &ports),
        (None, Some(port), _) => port,
        (None, None, Some(path)) => PortIdentity::of_path(path, &ports),
        (None, None, None) => match answers {
            Some(found) => PortIdentity::of_path(&found.path, &ports),
            None => return Err(needed("port").into()),
        },
    };
    let baud = bound.and_then(|bound| bound.baud);
    let baud = baud.or(answers.and_then(|found| found.other_baud));
    let baud = baud.unwrap_or(description.line.baud);
    Ok(ResolvedGauge {
        unit,
        identity: bound.and_then(|bound| bound.identity.clone()),
        port,
        description: description.with_baud(baud),
    })
}

/// The option of a gauge, and the form of the values of its keys.
fn option_of(channel: Channel) -> (String, String) {
    match channel.axis() {
        Some(axis) => ("displacement".to_owned(), format!("{axis}=…")),
        None => (channel.to_string(), "…".to_owned()),
    }
}

/// The description of a gauge, if a session can be measured with it.
fn usable_description(
    args: &BenchArgs,
    channel: Channel,
    name: &str,
    unit: Option<&str>,
    warnings: &mut Vec<String>,
) -> Result<InstrumentDescription, Failure> {
    let (option, _) = option_of(channel);
    let refused = |problem: String, help: &str| {
        ArgumentError::new(format!("--{option} instrument={name}"), problem, help)
    };
    let found = find_description(name, &args.protocols)?;
    warnings.extend(found.warnings);
    let mut description = found.description;
    if description.channel.kind() != channel.kind() {
        let help = "stiffbench gauge list shows what each measures";
        return Err(refused(format!("it measures {}", description.channel), help).into());
    }
    // From here on it stands for its place on the bench.
    description.channel = channel;
    if description.is_unverified() {
        if !args.allow_unverified {
            return Err(refused(
                "this description was not verified with the gauge".to_owned(),
                "check its values against the display first, then give --allow-unverified",
            )
            .into());
        }
        warnings.push(format!("the description {name} is not verified"));
    }
    // A decoder knows whether it needs a unit.
    Decoder::new(&description, unit)?;
    Ok(description)
}

/// Checks the descriptions of the gauges that arguments and bindings name, without touching a port; what a user should know.
///
/// # Errors
/// As [`resolve_gauges`] for them.
pub(super) fn check_descriptions(
    args: &BenchArgs,
    channels: &[Channel],
) -> Result<Vec<String>, Failure> {
    let (bindings, mut warnings) = bindings_of(args, channels)?;
    check_named(args, channels)?;
    for &channel in channels {
        let StatedGauge {
            instrument, unit, ..
        } = args.of(channel).beside(bindings.of(channel));
        if let Some(name) = instrument {
            usable_description(args, channel, &name, unit.as_deref(), &mut warnings)?;
        }
    }
    Ok(warnings)
}

/// Starts reading; with the gauges comes what is known of them.
pub(super) fn connect(
    resolved: Vec<ResolvedGauge>,
    raw: &Path,
    clock: Clock,
) -> Result<(Box<dyn Gauges>, Settings), Failure> {
    let mut known = Settings {
        names: Default::default(),
        ..Settings::default()
    };
    let mut gauges = Vec::new();
    for gauge in resolved {
        let description = gauge.description;
        let channel = description.channel;
        known.names[channel.index()].clone_from(&description.name);
        known.take(&description, gauge.unit.as_deref());
        let header = TraceHeader {
            instrument: Some(description.name.clone()),
            channel: Some(channel),
            unit: gauge.unit.clone(),
            port: Some(gauge.port.to_string()),
            line: None,
            started: Some(clock.utc().to_string()),
            speed: Some(clock.speed()),
        };
        let (file, trace) = trace(raw, channel, &header)?;
        known.traces[channel.index()] = file;
        gauges.push(LiveGauge {
            acquisition: Acquisition::surest(&description).sped_up(clock.speed()),
            trace: Some(trace),
            description: description.sped_up(clock.speed()),
            unit: gauge.unit,
            port: gauge.port,
            identity: gauge.identity,
        });
    }
    let live = LiveGauges::start(
        gauges,
        clock,
        PortTimeouts::default(),
        RetryPolicy::default(),
    )?;
    Ok((Box::new(live), known))
}

/// A new trace in the folder, with its name: `force.trace`, and `force-2.trace` and so on after each interruption.
fn trace(
    raw: &Path,
    channel: Channel,
    header: &TraceHeader,
) -> Result<(String, Box<dyn Sink>), CliError> {
    let mut file = format!("{channel}.trace");
    let mut number = 1;
    while raw.join(&file).symlink_metadata().is_ok() {
        number += 1;
        file = format!("{channel}-{number}.trace");
    }
    let path = raw.join(&file);
    let begun =
        File::create_new(&path).and_then(|file| TraceWriter::begin(BufWriter::new(file), header));
    let writer = begun.map_err(CliError::write(&path))?;
    let failed = move |error| {
        print_error(&format!("note: {} takes no more: {error}", path.display()));
    };
    Ok((file, Box::new(TraceSink::start(writer, failed))))
}
