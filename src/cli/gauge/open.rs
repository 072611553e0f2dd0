//! Which instrument on which port.

use crate::analysis::{ArgumentError, read_text};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use clap::Args;

use crate::clock::Clock;
use crate::instrument::driver::{Acquisition, AcquisitionSettings};
use crate::instrument::port::{
    Binding, Bindings, OpenPort, PortIdentity, PortSettings, PortTimeouts, list_ports, open,
};
use crate::instrument::reader::Reader;
use crate::instrument::trace::{Sink, TraceHeader};
use crate::instrument::{Channel, CommandRole, Decoder, InstrumentDescription};
use crate::source_text::SourceText;

use super::descriptions::{ProtocolsArgs, find_description};
use crate::cli::failure::Failure;
use crate::cli::outcome::print_error;

/// File in which a bench keeps which gauge is on which adapter.
pub(in crate::cli) const BINDINGS_FILE: &str = "stiffbench-bench.toml";

/// Where a gauge is and how it is spoken to.
#[derive(Debug, Clone, Args)]
#[command(next_help_heading = "Gauge")]
pub(in crate::cli) struct PortArgs {
    /// Path of the port, listed or not [default: the one bound in the bindings file]
    #[arg(long, value_name = "PORT")]
    pub(in crate::cli) port: Option<String>,
    /// Unit that the gauge shows, if it does not send its unit
    #[arg(long)]
    pub(in crate::cli) unit: Option<String>,
    /// Baud rate, bit/s [default: that of the bindings file, else that of the description]
    #[arg(long)]
    pub(in crate::cli) baud: Option<u32>,
    /// Let the gauge stream its values if it can, instead of requesting each value
    #[arg(long)]
    pub(in crate::cli) stream: bool,
    /// Use an unverified description
    #[arg(long)]
    pub(in crate::cli) allow_unverified: bool,
    /// Bindings file: which gauge is on which adapter, as stiffbench gauge bind writes it
    #[arg(long, value_name = "FILE", default_value = BINDINGS_FILE)]
    pub(in crate::cli) bindings: PathBuf,
    /// More descriptions.
    #[command(flatten)]
    pub(in crate::cli) protocols: ProtocolsArgs,
}

/// The bindings of a bench; none if there is no file.
pub(in crate::cli) fn read_bindings(path: &Path) -> Result<(Bindings, Vec<String>), Failure> {
    if !path.exists() {
        return Ok((Bindings::default(), Vec::new()));
    }
    let text = read_text(path)?;
    Ok(Bindings::parse(&SourceText::new(
        path.to_string_lossy(),
        text,
    ))?)
}

/// A gauge on an open port, ready to be read.
pub(in crate::cli) struct Gauge {
    pub(in crate::cli) description: Arc<InstrumentDescription>,
    pub(in crate::cli) header: TraceHeader,
    pub(in crate::cli) warnings: Vec<String>,
    unit: Option<String>,
    acquisition: Acquisition,
    expected: Option<Box<str>>,
    open: OpenPort,
}

impl Gauge {
    /// Finds and opens the port of an instrument. What goes on meanwhile is told on standard error.
    pub(in crate::cli) fn open(
        instrument: &str,
        args: &PortArgs,
        quiet: bool,
    ) -> Result<Self, Failure> {
        let found = find_description(instrument, &args.protocols)?;
        let (description, mut warnings) = (found.description, found.warnings);
        check_permission(&description, args)?;
        let (bindings, of_bindings) = read_bindings(&args.bindings)?;
        warnings.extend(of_bindings);
        let bound = bindings
            .of(description.channel)
            .filter(|bound| bound.instrument == instrument);
        let identity = port_identity(&description, args, bound)?;
        let unit = args
            .unit
            .clone()
            .or_else(|| bound.and_then(|bound| bound.unit.clone()));
        // A port that is named may have any gauge of this kind on it; a bound one has the one that was bound.
        let expected = bound
            .filter(|_| args.port.is_none())
            .and_then(|bound| bound.identity.as_deref());
        let expected = expected.map(Into::into);
        // Before the port is touched.
        Decoder::new(&description, unit.as_deref())?;
        let resolved = identity.resolve(&list_ports()?)?;
        warnings.extend(resolved.note);
        let settings = PortSettings::of(&description.line, &description.modem);
        let bound_baud = bound.and_then(|bound| bound.baud);
        let baud = args.baud.or(bound_baud).unwrap_or(description.line.baud);
        let settings = settings.with_baud(baud);
        let mut note = |note| {
            if !quiet {
                print_error(&format!("note: {note}"));
            }
        };
        let opened = open(
            &resolved.path,
            &settings,
            &PortTimeouts::default(),
            &mut note,
        )?;
        Ok(Self {
            header: TraceHeader {
                instrument: Some(description.name.clone()),
                channel: Some(description.channel),
                unit: unit.clone(),
                port: Some(identity.to_string()),
                line: Some(settings.to_string()),
                started: Some(Clock::default().utc().to_string()),
                speed: None,
            },
            acquisition: acquisition(&description, args.stream)?,
            description: Arc::new(description),
            warnings,
            unit,
            expected,
            open: opened,
        })
    }

    /// Begins to read.
    pub(in crate::cli) fn reader(
        self,
        clock: Clock,
        trace: Option<Box<dyn Sink>>,
    ) -> Result<Reader, Failure> {
        let decoder = Decoder::new(&self.description, self.unit.as_deref())?;
        let acquisition_settings = AcquisitionSettings {
            expected: self.expected,
            ..AcquisitionSettings::glance(self.acquisition)
        };
        Ok(Reader::new(
            self.open,
            self.description,
            decoder,
            acquisition_settings,
            clock,
            trace,
        ))
    }
}

fn check_permission(
    description: &InstrumentDescription,
    args: &PortArgs,
) -> Result<(), ArgumentError> {
    if !description.is_unverified() || args.allow_unverified {
        return Ok(());
    }
    Err(ArgumentError::new(
        description.name.clone(),
        "this description was not verified with a gauge or a manual",
        "compare its values with the display, and allow it with --allow-unverified",
    ))
}

fn acquisition(
    description: &InstrumentDescription,
    stream: bool,
) -> Result<Acquisition, ArgumentError> {
    if !stream {
        return Ok(Acquisition::surest(description));
    }
    if description.command(CommandRole::StreamStart).is_some() {
        return Ok(Acquisition::Stream);
    }
    Err(ArgumentError::new(
        "--stream",
        format!("{} has no command that starts a stream", description.name),
        "leave it out",
    ))
}

fn port_identity(
    description: &InstrumentDescription,
    args: &PortArgs,
    bound: Option<&Binding>,
) -> Result<PortIdentity, ArgumentError> {
    if let Some(path) = &args.port {
        return Ok(PortIdentity::Path(path.clone()));
    }
    bound.and_then(Binding::port).ok_or_else(|| ArgumentError::new("--port", format!("no port is named, and {} binds {} to none", args.bindings.display(), description.name), match description.no_tty(std::env::consts::OS) {
            Some(note) => format!("on this system: {note}"),
            None => "name it with --port, see the ports with stiffbench gauge ports, or bind the gauge once with stiffbench gauge bind".to_owned(),
        }))
}

/// Parses a channel.
pub(in crate::cli) fn channel(text: &str) -> Result<Channel, String> {
    Channel::EVERY
        .into_iter()
        .find(|channel| channel.to_string() == text || channel.key() == text)
        .ok_or_else(|| {
            "it is force, displacement, displacement-x, displacement-y or displacement-z".to_owned()
        })
}
