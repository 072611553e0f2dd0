//! The arguments of `gauge`.

use std::path::PathBuf;

use clap::{Args, Subcommand};

use super::descriptions::ProtocolsArgs;
#[cfg(unix)]
use super::emulate::EmulateArgs;
use super::ports::{BindArgs, PortsArgs, ProbeArgs};
use super::read::ReadArgs;
use super::trace::{RecordArgs, ReplayArgs};

/// Arguments of `gauge`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench gauge list\n  stiffbench gauge bind force                                          plug the force gauge in now\n  stiffbench gauge show mitutoyo-01a\n  stiffbench gauge show generic-ascii --toml > protocols/instruments/my-gauge.toml\n  stiffbench gauge check protocols/instruments/my-gauge.toml\n  printf '4.285 N\\r\\n' | stiffbench gauge decode mark10-series5 --unit N\n  stiffbench gauge read mark10-series5 --port /dev/ttyUSB0 --seconds 10\n  stiffbench gauge decode my-session/raw/force.trace"
)]
pub(in crate::cli) struct GaugeArgs {
    /// What to do.
    #[command(subcommand)]
    pub(super) what: GaugeVerb,
}

/// Subcommands of `gauge`.
#[derive(Debug, Subcommand)]
pub(super) enum GaugeVerb {
    /// List the gauges that have a description, and how far each description is verified
    List {
        /// More descriptions.
        #[command(flatten)]
        protocols: ProtocolsArgs,
    },
    /// Print a gauge description, or the entries of a trace
    Show(GaugeShowArgs),
    /// Check your own description and report what is wrong with it
    Check {
        /// The file
        file: PathBuf,
    },
    /// List the serial ports and the gauges that are bound to them; opens no port
    Ports(PortsArgs),
    /// Find out which gauge answers on a port; changes no setting of a gauge
    Probe(ProbeArgs),
    /// Bind a gauge to its port once, so that sessions find it
    Bind(BindArgs),
    /// Read values from a gauge on its port
    Read(ReadArgs),
    /// Decode bytes from standard input, or a trace; say why each rejected packet was rejected
    Decode(DecodeArgs),
    /// Emulate two gauges on one robot behind serial ports, for rehearsal and for other programs
    #[cfg(unix)]
    Emulate(Box<EmulateArgs>),
    /// Record every byte on a gauge's line, in both directions, with times
    Record(RecordArgs),
    /// Replay traces as live gauges, at any speed
    Replay(ReplayArgs),
}

/// Arguments of `gauge show`.
#[derive(Debug, Args)]
pub(super) struct GaugeShowArgs {
    /// Name of a description, a description file, or a trace
    #[arg(value_name = "GAUGE|TRACE", required_unless_present = "schema")]
    pub(super) name: Option<String>,
    /// Print the description as TOML, to copy and adapt
    #[arg(long)]
    pub(super) toml: bool,
    /// Print the JSON Schema of gauge descriptions instead
    #[arg(long, conflicts_with_all = ["name", "toml"])]
    pub(super) schema: bool,
    /// More descriptions.
    #[command(flatten)]
    pub(super) protocols: ProtocolsArgs,
}

/// Arguments of `gauge decode`.
#[derive(Debug, Args)]
pub(super) struct DecodeArgs {
    /// Gauge whose bytes come on standard input: name of a description, or a file; or a trace, which names its gauge
    #[arg(value_name = "GAUGE|TRACE")]
    pub(super) what: String,
    /// Trace to decode with this description instead of the one that it names
    pub(super) trace: Option<PathBuf>,
    /// Unit of the printed values; if packets carry no unit, also the unit that the gauge shows [default: as sent]
    #[arg(long)]
    pub(super) unit: Option<String>,
    /// Use an unverified description
    #[arg(long)]
    pub(super) allow_unverified: bool,
    /// More descriptions.
    #[command(flatten)]
    pub(super) protocols: ProtocolsArgs,
}
