//! The arguments of `instrument`, and where descriptions come from.

use std::path::PathBuf;

use clap::{Args, Subcommand};

#[cfg(unix)]
use super::emulate::EmulateArgs;
use super::instrument_read::ReadArgs;

/// Where descriptions come from besides the shipped ones.
#[derive(Debug, Clone, Default, Args)]
pub struct ProtocolsArgs {
    /// Folder with descriptions of your own in FOLDER/instruments/*.toml; they go before shipped ones of the same name
    #[arg(long, value_name = "FOLDER")]
    pub protocols: Option<PathBuf>,
}

/// Arguments of `instrument`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench instrument list\n  stiffbench instrument show mitutoyo-01a\n  stiffbench instrument show generic-ascii --toml > protocols/instruments/my-gauge.toml\n  stiffbench instrument check protocols/instruments/my-gauge.toml\n  printf '4.285 N\\r\\n' | stiffbench instrument decode mark10-series5 --unit N\n  stiffbench instrument read mark10-series5 --port /dev/ttyUSB0 --seconds 10"
)]
pub(super) struct InstrumentArgs {
    /// What to do.
    #[command(subcommand)]
    pub(super) what: InstrumentCommand,
}

/// Subcommands of `instrument`.
#[derive(Debug, Subcommand)]
pub(super) enum InstrumentCommand {
    /// The gauges that can be used, and how far each description can be trusted
    List {
        /// More descriptions.
        #[command(flatten)]
        protocols: ProtocolsArgs,
    },
    /// What is known of one gauge: line, commands, packets, sign, notes, sources; or the schema of descriptions
    Show {
        /// Name of a description, or a file
        #[arg(value_name = "INSTRUMENT", required_unless_present = "schema")]
        name: Option<String>,
        /// The description itself, to copy and adapt
        #[arg(long)]
        toml: bool,
        /// Instead: the JSON Schema of instrument descriptions
        #[arg(long, conflicts_with_all = ["name", "toml"])]
        schema: bool,
        /// More descriptions.
        #[command(flatten)]
        protocols: ProtocolsArgs,
    },
    /// Read a description of your own and say what is wrong with it
    Check {
        /// The file
        file: PathBuf,
    },
    /// The bytes on standard input as samples, and what is none with its reason
    Decode(DecodeArgs),
    /// Values of a gauge on its port, now
    Read(ReadArgs),
    /// A bench in software behind ports: two emulated gauges on one robot, for practice and for other programs
    #[cfg(unix)]
    Emulate(Box<EmulateArgs>),
}

/// Arguments of `instrument decode`.
#[derive(Debug, Args)]
pub(super) struct DecodeArgs {
    /// Name of a description, or a file
    #[arg(value_name = "INSTRUMENT")]
    pub(super) name: String,
    /// Unit of the values that are printed; where packets carry none, also the unit that the gauge shows [default: as sent]
    #[arg(long)]
    pub(super) unit: Option<String>,
    /// Use a description that nobody has verified
    #[arg(long)]
    pub(super) allow_unverified: bool,
    /// More descriptions.
    #[command(flatten)]
    pub(super) protocols: ProtocolsArgs,
}
