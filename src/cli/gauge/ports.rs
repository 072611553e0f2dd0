//! `gauge ports`, `gauge probe` and `gauge bind`: which serial ports there are, what is on them, and which gauge is bound to which.

use std::path::{Path, PathBuf};
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

use super::descriptions::{ProtocolsArgs, all_descriptions, find_description};
use super::open::{BINDINGS_FILE, channel, read_bindings};
use crate::cli::args::seconds;
use crate::cli::outcome::print_error;
use crate::cli::{CliError, Failure, Global, Outcome};
use crate::report::{BindingReport, BoundGauge, PortList, PortReport, ProbeReport};
use crate::session::write_whole;

/// Arguments of `gauge ports`.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  stiffbench gauge ports")]
pub(super) struct PortsArgs {
    /// Bindings file: which gauge is on which adapter
    #[arg(long, value_name = "FILE", default_value = BINDINGS_FILE)]
    bindings: PathBuf,
}

/// Arguments of `gauge probe`.
#[derive(Debug, Args)]
#[command(
    after_help = "Opens each port, listens, and requests a value; sends no command that changes a setting. If nothing answers, it tries other baud rates, which takes a minute with all descriptions and seconds with --instrument.\n\nExamples:\n  stiffbench gauge probe\n  stiffbench gauge probe /dev/ttyUSB0"
)]
pub(super) struct ProbeArgs {
    /// Ports to probe, listed or not [default: all that are listed]
    #[arg(value_name = "PORT")]
    ports: Vec<String>,
    /// Bindings file: which gauge is on which adapter
    #[arg(long, value_name = "FILE", default_value = BINDINGS_FILE)]
    bindings: PathBuf,
    /// Which descriptions are tried.
    #[command(flatten)]
    candidates: CandidateArgs,
}

/// Arguments of `gauge bind`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench gauge bind force                                      plug the force gauge in now\n  stiffbench gauge bind displacement --port /dev/ttyUSB1\n  stiffbench gauge bind displacement-x --instrument mitutoyo-01a"
)]
pub(super) struct BindArgs {
    /// Gauge: force, displacement, or displacement-x, displacement-y, displacement-z
    #[arg(value_name = "CHANNEL", value_parser = channel)]
    bound: Channel,
    /// Path of the port, listed or not [default: the one that is plugged in next]
    #[arg(long, value_name = "PORT")]
    port: Option<String>,
    /// How long to wait for a port to be plugged in, s
    #[arg(long, value_name = "S", default_value = "120", value_parser = seconds, conflicts_with = "port")]
    within: f64,
    /// Unit that the gauge shows, if it does not send its unit
    #[arg(long)]
    unit: Option<String>,
    /// Bindings file: which gauge is on which adapter
    #[arg(long, value_name = "FILE", default_value = BINDINGS_FILE)]
    bindings: PathBuf,
    /// Which descriptions are tried.
    #[command(flatten)]
    candidates: CandidateArgs,
}

/// Which descriptions are tried on a port.
#[derive(Debug, Args)]
struct CandidateArgs {
    /// Instrument on the port [default: found by probing]
    #[arg(long, value_name = "NAME|FILE")]
    instrument: Option<String>,
    /// More descriptions.
    #[command(flatten)]
    protocols: ProtocolsArgs,
}

impl CandidateArgs {
    /// The descriptions to try.
    fn descriptions(&self) -> Result<Vec<InstrumentDescription>, Failure> {
        let found = match &self.instrument {
            Some(name) => vec![find_description(name, &self.protocols)?],
            None => all_descriptions(&self.protocols)?.0,
        };
        Ok(found.into_iter().map(|found| found.description).collect())
    }
}

/// Runs `gauge ports`.
pub(super) fn list(args: &PortsArgs) -> Result<Outcome, Failure> {
    let ports = list_ports()?.into_iter().map(|port| (port, None));
    listed(ports.collect(), &args.bindings)
}

/// Runs `gauge probe`.
pub(super) fn probe_ports(args: &ProbeArgs, global: &Global) -> Result<Outcome, Failure> {
    let descriptions = args.candidates.descriptions()?;
    let known = list_ports()?;
    let ports: Vec<PortInfo> = if args.ports.is_empty() {
        known
    } else {
        args.ports.iter().map(|path| named(path, &known)).collect()
    };
    let probed = ports.into_iter().map(|port| {
        let result = probe_port(&port, &descriptions, global);
        (port, Some(probed(result)))
    });
    listed(probed.collect(), &args.bindings)
}

/// Ports with what is bound to them and what answered.
fn listed(
    found: Vec<(PortInfo, Option<ProbeReport>)>,
    bindings: &Path,
) -> Result<Outcome, Failure> {
    let (bindings, warnings) = read_bindings(bindings)?;
    let known: Vec<PortInfo> = found.iter().map(|(port, _)| port.clone()).collect();
    let ports = found.into_iter().map(|(port, probe)| PortReport {
        bound: bound_to(&port, &known, &bindings),
        port,
        probe,
    });
    let ports: Vec<PortReport> = ports.collect();
    Ok(Outcome::new("ports", document(&ports), PortList { ports }).with_warnings(warnings))
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

/// The port of a path, listed or not.
fn named(path: &str, known: &[PortInfo]) -> PortInfo {
    let known = known.iter().find(|port| port.answers_to(path));
    known.cloned().unwrap_or_else(|| PortInfo::of_path(path))
}

/// The port that is plugged in from now on.
fn wait_for_port(args: &BindArgs, global: &Global) -> Result<PortInfo, Failure> {
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
        "gauge bind",
        format!("more than one port appeared at once: {}", paths.join(", ")),
        "plug in one at a time, or name the one that is meant with --port",
    )
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

/// Runs `gauge bind`: writes which gauge is on a port.
pub(super) fn bind(args: &BindArgs, global: &Global) -> Result<Outcome, Failure> {
    let bound = args.bound;
    let port = &match &args.port {
        Some(path) => named(path, &list_ports()?),
        None => wait_for_port(args, global)?,
    };
    let findings = probe_port(port, &args.candidates.descriptions()?, global)?;
    let matching = clear_match(&findings);
    let instrument = match (&args.candidates.instrument, matching) {
        (Some(name), _) => name.clone(),
        (None, Some(found)) => found.instrument.clone(),
        (None, None) => return Err(not_clear(port, &findings)),
    };
    let found = find_description(&instrument, &args.candidates.protocols)?;
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
    warnings.extend(write_binding(&args.bindings, bound, &binding)?);
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
fn write_binding(file: &Path, bound: Channel, binding: &Binding) -> Result<Vec<String>, Failure> {
    let (old, mut warnings) = read_bindings(file)?;
    let (new, note) = old.with(bound, binding.clone());
    warnings.extend(note);
    write_whole(file, new.to_toml().as_bytes()).map_err(CliError::write(file))?;
    Ok(warnings)
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
        help: "name it with --instrument (stiffbench gauge list shows what is known)".to_owned(),
    }
    .into()
}

fn check_channel(description: &InstrumentDescription, bound: Channel) -> Result<(), ArgumentError> {
    if description.channel.kind() == bound.kind() {
        return Ok(());
    }
    Err(ArgumentError::new(
        format!("gauge bind {bound}"),
        format!("{} is a {} gauge", description.name, description.channel),
        format!("bind it as {}", description.channel),
    ))
}

fn probed(result: ProbeResult) -> ProbeReport {
    match result {
        Ok(instruments) => ProbeReport::Answered {
            r#match: clear_match(&instruments).map(|found| found.instrument.clone()),
            instruments,
        },
        Err(error) => ProbeReport::Failed {
            problem: error.to_string(),
        },
    }
}

fn document(ports: &[PortReport]) -> Document {
    let mut document = Document::new();
    if ports.is_empty() {
        document.paragraph("no serial port; plug an adapter in, or name a port by its path");
    }
    for PortReport { port, bound, probe } in ports {
        document.paragraph(&port.path);
        let usb = port.usb.as_ref().map(ToString::to_string);
        for line in [&port.label, &usb, &port.by_id].into_iter().flatten() {
            document.item(line);
        }
        for BoundGauge {
            channel,
            instrument,
        } in bound
        {
            document.item(format!("bound as the {channel} gauge: {instrument}"));
        }
        if let Some(latency_ms) = port.latency_ms.filter(|latency_ms| *latency_ms > 2) {
            document.item(format!(
                "holds short packets for {latency_ms} ms: at most {} requests a second (latency_timer in sysfs, 1 is best)",
                1000 / latency_ms
            ));
        }
        match probe {
            Some(ProbeReport::Answered { instruments, .. }) if instruments.is_empty() => {
                document.item("no known instrument answers");
            }
            Some(ProbeReport::Answered { instruments, .. }) => {
                for finding in instruments {
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
                }
            }
            Some(ProbeReport::Failed { problem }) => document.item(problem),
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
        let report = PortReport {
            bound: bound(&ports[0]),
            port: ports[0].clone(),
            probe: None,
        };
        assert!(
            document(&[report])
                .text()
                .contains("bound as the force gauge: mark10-series5")
        );
    }
}
