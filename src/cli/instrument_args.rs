//! The arguments of `instrument`, and where descriptions come from.

use std::path::PathBuf;

use clap::{Args, Subcommand};

#[cfg(unix)]
use super::emulate::EmulateArgs;
use super::instrument_read::ReadArgs;

/// Where descriptions come from besides the shipped ones.
#[derive(Debug, Clone, Default, Args)]
pub struct ProtocolsArgs {
    /// Folder with your own descriptions in FOLDER/instruments/*.toml; they take precedence over shipped ones of the same name
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
    /// List the available gauges and how far each description is verified
    List {
        /// More descriptions.
        #[command(flatten)]
        protocols: ProtocolsArgs,
    },
    /// Print a gauge description: line, commands, packets, sign, notes, sources; or the schema of descriptions
    Show {
        /// Name of a description, or a file
        #[arg(value_name = "INSTRUMENT", required_unless_present = "schema")]
        name: Option<String>,
        /// Print the description as TOML, to copy and adapt
        #[arg(long)]
        toml: bool,
        /// Print the JSON Schema of instrument descriptions instead
        #[arg(long, conflicts_with_all = ["name", "toml"])]
        schema: bool,
        /// More descriptions.
        #[command(flatten)]
        protocols: ProtocolsArgs,
    },
    /// Check your own description and report what is wrong with it
    Check {
        /// The file
        file: PathBuf,
    },
    /// Decode bytes from standard input; say why each rejected packet was rejected
    Decode(DecodeArgs),
    /// Read values from a gauge on its port
    Read(ReadArgs),
    /// Emulate two gauges on one robot behind serial ports, for rehearsal and for other programs
    #[cfg(unix)]
    Emulate(Box<EmulateArgs>),
}

/// Arguments of `instrument decode`.
#[derive(Debug, Args)]
pub(super) struct DecodeArgs {
    /// Name of a description, or a file
    #[arg(value_name = "INSTRUMENT")]
    pub(super) name: String,
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
