//! `ports`: which serial ports there are, what is on them, and which gauge is bound to which.

use std::thread;
use std::time::Duration;

use clap::Args;
use stiffbench_document::Document;

use crate::analysis::ArgumentError;
use crate::clock::Clock;
use crate::instrument::port::{
    Binding, Bindings, PortError, PortIdentity, PortInfo, list_ports, newly_plugged,
};
use crate::instrument::probe::{ProbeFinding, clear_match, probe};
use crate::instrument::{Channel, InstrumentDescription};

use super::args::{Global, seconds};
use super::descriptions::{all_descriptions, find_description};
use super::failure::{CliError, Failure};
use super::gauge::{BINDINGS_FILE, channel, read_bindings};
use super::instrument_args::ProtocolsArgs;
use super::outcome::{Outcome, print_error};
use crate::report::{BindingReport, BoundGauge, PortList, PortReport, ProbeReport};
use crate::session::write_whole;

/// Arguments of `ports`.
#[derive(Debug, Args)]
#[command(
    after_help = "Listing opens no port. --probe opens each port, listens, and requests a value; it sends no command that changes a setting. If nothing answers, it tries other baud rates, which takes a minute with all descriptions and seconds with --instrument.\n\nExamples:\n  stiffbench ports\n  stiffbench ports --probe --port /dev/ttyUSB0\n  stiffbench ports --wait --bind force --instrument mark10-series5"
)]
pub(super) struct PortsArgs {
    /// Identify the instrument on each port
    #[arg(long)]
    probe: bool,
    /// Path of the only port to use, listed or not
    #[arg(long, value_name = "PORT")]
    port: Option<String>,
    /// Wait until a port is plugged in
    #[arg(long, conflicts_with = "port")]
    wait: bool,
    /// How long to wait for it, s
    #[arg(long, value_name = "S", default_value = "120", value_parser = seconds, requires = "wait")]
    within: f64,
    /// Bind the port to the force or displacement gauge
    #[arg(long, value_name = "CHANNEL", value_parser = channel)]
    bind: Option<Channel>,
    /// Instrument on the port [default: found by probing]
    #[arg(long, value_name = "NAME|FILE")]
    instrument: Option<String>,
    /// Unit that the gauge shows, if it does not send its unit
    #[arg(long)]
    unit: Option<String>,
    /// Bindings file: which gauge is on which adapter
    #[arg(long, value_name = "FILE", default_value = BINDINGS_FILE)]
    bindings: std::path::PathBuf,
    /// More descriptions.
    #[command(flatten)]
    protocols: ProtocolsArgs,
}

/// Runs `ports`.
pub(super) fn run(args: &PortsArgs, global: &Global) -> Result<Outcome, Failure> {
    let ports = if args.wait {
        vec![wait_for_port(args, global)?]
    } else {
        named_or_all(args)?
    };
    if let Some(bound) = args.bind {
        return bind(args, bound, &ports, global);
    }
    let descriptions = candidates(args)?;
    let (bindings, warnings) = read_bindings(&args.bindings)?;
    let listed = ports.clone();
    let found = ports.into_iter().map(|port| {
        let result = (args.probe || args.wait).then(|| probe_port(&port, &descriptions, global));
        (port, result)
    });
    let found: Vec<(PortInfo, Option<ProbeResult>)> = found.collect();
    let document = document(&found, |port| bound_to(port, &listed, &bindings));
    let ports = found.into_iter().map(|(port, probe_port)| PortReport {
        bound: bound_to(&port, &listed, &bindings),
        port,
        probe: probe_port.map(probed),
    });
    let ports = ports.collect();
    Ok(Outcome::new("ports", document, PortList { ports }).with_warnings(warnings))
}

/// The gauges that a bindings file has on a port.
fn bound_to(port: &PortInfo, ports: &[PortInfo], bindings: &Bindings) -> Vec<BoundGauge> {
    let bound = |channel: Channel| {
        let binding = bindings.of(channel)?;
        let meant = binding.port()?.resolve(ports).ok()?;
        let instrument = binding.instrument.clone();
        port.answers_to(&meant.path).then_some(BoundGauge {
            channel,
            instrument,
        })
    };
    Channel::EVERY.into_iter().filter_map(bound).collect()
}

/// What probing a port gave.
type ProbeResult = Result<Vec<ProbeFinding>, PortError>;

fn named_or_all(args: &PortsArgs) -> Result<Vec<PortInfo>, Failure> {
    let ports = list_ports()?;
    let Some(path) = &args.port else {
        return Ok(ports);
    };
    let known = ports.into_iter().find(|port| port.answers_to(path));
    Ok(vec![known.unwrap_or_else(|| PortInfo::of_path(path))])
}

/// The port that is plugged in from now on.
fn wait_for_port(args: &PortsArgs, global: &Global) -> Result<PortInfo, Failure> {
    let before = list_ports()?;
    if !global.quiet {
        print_error(
            "plug the gauge in now (if it is plugged in already: pull it out and put it back)",
        );
    }
    let clock = Clock::default();
    let mut known = before;
    while clock.now_s() < args.within {
        thread::sleep(Duration::from_millis(200));
        let now = list_ports()?;
        match newly_plugged(&known, &now).as_slice() {
            [] => {}
            [port] => {
                // Its lasting names appear a moment after it.
                thread::sleep(Duration::from_millis(500));
                let named = list_ports()?
                    .into_iter()
                    .find(|other| other.path == port.path);
                return Ok(named.unwrap_or_else(|| port.clone()));
            }
            several => return Err(several_plugged(several).into()),
        }
        // What was pulled out counts as new when it comes back.
        known.retain(|port| now.contains(port));
    }
    Err(PortError::Absent {
        port: format!("that was to be plugged in within {} s", args.within),
        near: None,
    }
    .into())
}

fn several_plugged(ports: &[PortInfo]) -> ArgumentError {
    let paths: Vec<&str> = ports.iter().map(|port| port.path.as_str()).collect();
    ArgumentError::new(
        "--wait",
        format!("more than one port appeared at once: {}", paths.join(", ")),
        "plug in one at a time, or name the one that is meant with --port",
    )
}

/// The descriptions to try.
fn candidates(args: &PortsArgs) -> Result<Vec<InstrumentDescription>, Failure> {
    let found = match &args.instrument {
        Some(name) => vec![find_description(name, &args.protocols)?],
        None => all_descriptions(&args.protocols)?.0,
    };
    Ok(found.into_iter().map(|found| found.description).collect())
}

fn probe_port(
    port: &PortInfo,
    descriptions: &[InstrumentDescription],
    global: &Global,
) -> ProbeResult {
    probe(port.stable_path(), descriptions, &mut |note| {
        if !global.quiet {
            print_error(&format!("note: {note}"));
        }
    })
}

/// Writes which gauge is on the one port there is to bind.
fn bind(
    args: &PortsArgs,
    bound: Channel,
    ports: &[PortInfo],
    global: &Global,
) -> Result<Outcome, Failure> {
    let [port] = ports else {
        return Err(not_one(ports).into());
    };
    let findings = probe_port(port, &candidates(args)?, global)?;
    let matching = clear_match(&findings);
    let instrument = match (&args.instrument, matching) {
        (Some(name), _) => name.clone(),
        (None, Some(found)) => found.instrument.clone(),
        (None, None) => return Err(not_clear(port, &findings)),
    };
    let found = find_description(&instrument, &args.protocols)?;
    check_channel(&found.description, bound)?;
    let mut warnings = found.warnings;
    if findings.is_empty() {
        warnings.push(format!(
            "{instrument} did not answer on {}; the binding was written all the same",
            port.path
        ));
    }
    let binding = binding_of(port, instrument, args.unit.clone(), matching);
    if binding.usb.as_ref().is_some_and(|usb| usb.serial.is_none()) {
        warnings.push("this adapter has no serial number: it is known by its socket only, and has to stay in it".to_owned());
    }
    warnings.extend(write_binding(args, bound, &binding)?);
    let port_name = binding
        .port()
        .map_or_else(String::new, |port| port.to_string());
    let document = Document::of(format!(
        "the {bound} gauge is {} on {port_name}; written to {}",
        binding.instrument,
        args.bindings.display()
    ));
    let report = BindingReport {
        channel: bound,
        binding,
        file: args.bindings.clone(),
    };
    Ok(Outcome::new("port-binding", document, report).with_warnings(warnings))
}

fn binding_of(
    port: &PortInfo,
    instrument: String,
    unit: Option<String>,
    found: Option<&ProbeFinding>,
) -> Binding {
    let (path, usb) = match PortIdentity::of_path(&port.path, std::slice::from_ref(port)) {
        PortIdentity::Usb(usb) => (port.stable_path().to_owned(), Some(usb)),
        PortIdentity::Path(path) => (path, None),
    };
    Binding {
        instrument,
        unit,
        baud: found.and_then(|found| found.other_baud),
        identity: found.and_then(|found| found.identity.clone()),
        path: Some(path),
        usb,
    }
}

/// Puts a binding into the file; what a user should know of it.
fn write_binding(
    args: &PortsArgs,
    bound: Channel,
    binding: &Binding,
) -> Result<Vec<String>, Failure> {
    let (old, mut warnings) = read_bindings(&args.bindings)?;
    let (new, note) = old.with(bound, binding.clone());
    warnings.extend(note);
    write_whole(&args.bindings, new.to_toml().as_bytes())
        .map_err(CliError::write(&args.bindings))?;
    Ok(warnings)
}

fn not_one(ports: &[PortInfo]) -> ArgumentError {
    ArgumentError::new(
        "--bind",
        format!(
            "there are {} ports, and it is not clear which one to use",
            ports.len()
        ),
        "name it with --port, or plug it in after --wait",
    )
}

fn not_clear(port: &PortInfo, findings: &[ProbeFinding]) -> Failure {
    let candidates: Vec<&str> = findings
        .iter()
        .map(|finding| finding.instrument.as_str())
        .collect();
    PortError::WrongDevice {
        port: port.path.clone(),
        problem: if candidates.is_empty() {
            "no known instrument answers there".to_owned()
        } else {
            format!("more than one instrument fits: {}", candidates.join(", "))
        },
        help: "name it with --instrument (stiffbench instrument list shows what is known)"
            .to_owned(),
    }
    .into()
}

fn check_channel(description: &InstrumentDescription, bound: Channel) -> Result<(), ArgumentError> {
    if description.channel.kind() == bound.kind() {
        return Ok(());
    }
    Err(ArgumentError::new(
        format!("--bind {bound}"),
        format!("{} is a {} gauge", description.name, description.channel),
        format!("bind it as {}", description.channel),
    ))
}

fn probed(probe_port: ProbeResult) -> ProbeReport {
    let findings = match probe_port {
        Ok(findings) => findings,
        Err(error) => {
            let problem = error.to_string();
            return ProbeReport::Failed { problem };
        }
    };
    let r#match = clear_match(&findings).map(|found| found.instrument.clone());
    ProbeReport::Answered {
        instruments: findings,
        r#match,
    }
}

fn document(
    ports: &[(PortInfo, Option<ProbeResult>)],
    bound: impl Fn(&PortInfo) -> Vec<BoundGauge>,
) -> Document {
    let mut document = Document::new();
    if ports.is_empty() {
        document.paragraph("no serial port; plug an adapter in, or name a port by its path");
    }
    for (port, probe_port) in ports {
        document.paragraph(&port.path);
        let usb = port.usb.as_ref().map(ToString::to_string);
        for line in [&port.label, &usb, &port.by_id].into_iter().flatten() {
            document.item(line);
        }
        for BoundGauge {
            channel,
            instrument,
        } in bound(port)
        {
            document.item(format!("bound as the {channel} gauge: {instrument}"));
        }
        if let Some(latency_ms) = port.latency_ms.filter(|latency_ms| *latency_ms > 2) {
            document.item(format!(
                "holds short packets for {latency_ms} ms: at most {} requests a second (latency_timer in sysfs, 1 is best)",
                1000 / latency_ms
            ));
        }
        match probe_port {
            Some(Ok(findings)) if findings.is_empty() => {
                document.item("no known instrument answers");
            }
            Some(Ok(findings)) => findings.iter().for_each(|finding| {
                let said = finding.identity.iter();
                let said = said.map(|said| format!(", identifies itself as {said}"));
                let speed = finding.other_baud.iter();
                let speed = speed.map(|baud| format!(", at {baud} bit/s"));
                document.item(format!(
                    "{} points: {}: {}{}",
                    finding.points,
                    finding.instrument,
                    finding.evidence,
                    said.chain(speed).collect::<String>()
                ));
            }),
            Some(Err(error)) => document.item(error.to_string()),
            None => {}
        }
    }
    document
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source_text::SourceText;

    #[test]
    fn a_port_names_the_gauges_that_are_bound_to_it() {
        let text = "schema = \"stiffbench/bindings/1\"\n[force]\ninstrument = \"mark10-series5\"\npath = \"/dev/ttyS7\"\n";
        let source = SourceText::new("b.toml", text);
        let (bindings, _) = Bindings::parse(&source).unwrap();
        let ports = ["/dev/ttyS7", "/dev/ttyS8"].map(PortInfo::of_path);
        let bound = |port: &PortInfo| bound_to(port, &ports, &bindings);
        assert_eq!(bound(&ports[0])[0].instrument, "mark10-series5");
        assert!(bound(&ports[1]).is_empty());
        let found = ports.clone().map(|port| (port, None));
        assert!(
            document(&found, bound)
                .text()
                .contains("bound as the force gauge: mark10-series5")
        );
    }
}
