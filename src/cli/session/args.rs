//! The arguments of `session`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use crate::cli::args::ModelArgs;
use crate::cli::gauge::ProtocolsArgs;
use crate::cli::gauge::open::BINDINGS_FILE;
use crate::cli::gauge::trace::{Speed, pace};
use crate::cli::numbers::number_that;
use crate::cli::parameter_args::ParameterArgs;
use crate::cli::pose_args::PoseRulesArgs;
use crate::cli::procedure::{AxesArgs, ProcedureArgs};
use crate::instrument::Channel;
use crate::instrument::port::Binding;
use crate::test_point::Direction;

/// Arguments of `session`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench session plan --procedure paper\n  stiffbench session plan --procedure paper --design\n  stiffbench session run monday --procedure sweeps --force instrument=mark10-series5,port=/dev/ttyUSB0 \\\n      --displacement instrument=mitutoyo-01a,port=/dev/ttyUSB1\n  stiffbench session run trial --emulated --speed 5 --no-input --procedure sweeps --poses P1\n  stiffbench session resume monday\n  stiffbench session status monday\n  stiffbench session log monday\n  stiffbench session undo monday\n  stiffbench session replay monday --out monday-again\n  stiffbench session verify monday\n  stiffbench session recover monday --out monday-recovered\n\nKeys in a session: any key or a pedal takes the reading, r repeats the last reading, g goes to a cell, s skips, n adds a note,\np pauses; Ctrl-C ends at the next safe point, a second Ctrl-C at once. Every confirmed reading is on disk."
)]
pub(in crate::cli) struct SessionArgs {
    /// What to do.
    #[command(subcommand)]
    pub(super) what: SessionCommand,
}

/// Subcommands of `session`.
#[derive(Debug, Subcommand)]
pub(super) enum SessionCommand {
    /// Print the steps, questions, duration and files of a session; no port is opened
    Plan(Box<PlanArgs>),
    /// Measure: create a session folder and guide the operator through the procedure
    Run(Box<RunArgs>),
    /// Resume an interrupted session at its first open reading
    Resume(Box<ResumeArgs>),
    /// Print the progress of a session
    Status(FolderArgs),
    /// Verify that the journal of a session is intact and that its files agree with it
    Verify(FolderArgs),
    /// Recover the intact part of a damaged session into a new folder
    Recover(RecoverArgs),
    /// Print the events of a session, one per line
    Log(FolderArgs),
    /// Undo the last reading, skip or flag of a stopped, incomplete session, and print what it was
    Undo(FolderArgs),
    /// Replay the traces of a session through decoder and session logic, into a new folder, and compare the readings
    Replay(SessionReplayArgs),
}

/// A session folder.
#[derive(Debug, Args)]
pub(super) struct FolderArgs {
    /// Session folder
    #[arg(value_name = "SESSION")]
    pub(super) folder: PathBuf,
}

/// Arguments of `session plan`.
#[derive(Debug, Args)]
pub(super) struct PlanArgs {
    /// Which robot.
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// Which procedure.
    #[command(flatten)]
    pub(super) procedure: ProcedureArgs,
    /// Place of the measurement displacements are read.
    #[command(flatten)]
    pub(super) axes: AxesArgs,
    /// Print what the procedure can and cannot distinguish instead of its steps
    #[arg(long)]
    pub(super) design: bool,
    /// Which parameters the poses are to determine, or are free beside every candidate.
    #[command(flatten)]
    pub(super) parameters: ParameterArgs,
    /// Which poses determine the parameters best.
    #[command(flatten)]
    pub(super) best: BestPosesArgs,
}

/// Poses of the program's own choice.
#[derive(Debug, Default, Args)]
pub(super) struct BestPosesArgs {
    /// Choose this many poses within the limits of the robot that best determine the free parameters
    #[arg(long, value_name = "N", conflicts_with = "poses")]
    pub(super) best_poses: Option<usize>,
    /// Write the planned procedure as a file for --procedure
    #[arg(long, value_name = "FILE")]
    pub(super) save_procedure: Option<PathBuf>,
    /// Which poses may be chosen.
    #[command(flatten)]
    pub(super) rules: PoseRulesArgs,
}

/// Arguments of `session recover`.
#[derive(Debug, Args)]
pub(super) struct RecoverArgs {
    /// Session folder; it is not changed
    #[arg(value_name = "SESSION")]
    pub(super) folder: PathBuf,
    /// Session folder to create; must not exist
    #[arg(long, value_name = "FOLDER")]
    pub(super) out: PathBuf,
}

/// Arguments of `session replay`.
#[derive(Debug, Args)]
pub(super) struct SessionReplayArgs {
    /// Session folder with its traces; it is not touched
    #[arg(value_name = "SESSION")]
    pub(super) folder: PathBuf,
    /// Session folder to create; must not exist
    #[arg(long, value_name = "FOLDER")]
    pub(super) out: PathBuf,
    /// Speed relative to the real clock; max for as fast as possible
    #[arg(long, default_value = "max", value_parser = pace)]
    pub(super) speed: Speed,
    /// More descriptions.
    #[command(flatten)]
    pub(super) protocols: ProtocolsArgs,
}

/// Arguments of `session run`.
#[derive(Debug, Args)]
pub(super) struct RunArgs {
    /// Session folder to create; must not exist
    #[arg(value_name = "SESSION")]
    pub(super) out: PathBuf,
    /// Which robot.
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// Which procedure.
    #[command(flatten)]
    pub(super) procedure: ProcedureArgs,
    /// Place of the measurement displacements are read.
    #[command(flatten)]
    pub(super) axes: AxesArgs,
    /// What it is measured with.
    #[command(flatten)]
    pub(super) bench: BenchArgs,
    /// Instrument records: a file with [instruments.force] and [instruments.displacement] as in session.toml
    #[arg(
        long = "instrument-records",
        value_name = "FILE",
        help_heading = "Record"
    )]
    pub(super) instruments: Option<PathBuf>,
    /// Name of the operator
    #[arg(long, help_heading = "Record")]
    pub(super) operator: Option<String>,
    /// Specimen that is measured; one of the procedure's, if it lists any
    #[arg(long, value_name = "ID", help_heading = "Record")]
    pub(super) specimen_id: Option<String>,
    /// Place of the measurement
    #[arg(long, help_heading = "Record")]
    pub(super) place: Option<String>,
    /// Check all arguments and print the plan like session plan, with every file and the duration; measure and write nothing
    #[arg(long, help_heading = "Record")]
    pub(super) dry_run: bool,
}

/// Arguments of `session resume`.
#[derive(Debug, Args)]
pub(super) struct ResumeArgs {
    /// Session folder
    #[arg(value_name = "SESSION")]
    pub(super) folder: PathBuf,
    /// What it is measured with; what is left out is as it was when the session began.
    #[command(flatten)]
    pub(super) bench: BenchArgs,
}

/// What a session is measured with, and how it asks.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Bench")]
pub(super) struct BenchArgs {
    /// Force gauge: instrument=NAME|FILE, its description; port=PORT; unit=UNIT set at it, if it does not send its unit [default: that of the bindings file]
    #[arg(long, value_name = "KEY=VALUE,...", value_delimiter = ',', value_parser = gauge_key)]
    force: Vec<GaugeKey>,
    /// Displacement gauge, with the same keys; of several gauges a value is that of all, or x=VALUE that of one: port=x=PORT
    #[arg(long, value_name = "KEY=VALUE,...", value_delimiter = ',', value_parser = gauge_key)]
    displacement: Vec<GaugeKey>,
    /// Description of the force gauge
    #[arg(long, hide = true)]
    force_instrument: Option<String>,
    /// Port of the force gauge
    #[arg(long, hide = true)]
    force_port: Option<String>,
    /// Unit set at the force gauge
    #[arg(long, hide = true)]
    force_unit: Option<String>,
    /// Description of the displacement gauge
    #[arg(long, hide = true)]
    displacement_instrument: Vec<String>,
    /// Port of the displacement gauge
    #[arg(long, hide = true)]
    displacement_port: Vec<String>,
    /// Unit set at the displacement gauge
    #[arg(long, hide = true)]
    displacement_unit: Vec<String>,
    /// Bindings file: which gauge is on which adapter, as stiffbench gauge bind writes it
    #[arg(long, value_name = "FILE", default_value = BINDINGS_FILE)]
    pub(super) bindings: PathBuf,
    /// More descriptions.
    #[command(flatten)]
    pub(super) protocols: ProtocolsArgs,
    /// Use an unverified description
    #[arg(long)]
    pub(super) allow_unverified: bool,
    /// Which bench is emulated; other systems have no emulated ones.
    #[cfg_attr(unix, command(flatten))]
    #[cfg_attr(not(unix), arg(skip))]
    pub(super) emulation: EmulationArgs,
    /// The gauges of the emulated bench, in place of those that are stated.
    #[arg(skip)]
    pub(super) emulated_gauges: Vec<(Channel, StatedGauge)>,
    /// When a reading is taken
    #[arg(long, value_enum, default_value_t = CaptureWord::Settled, help_heading = "Guiding")]
    pub(super) capture: CaptureWord,
    /// TOML file with answers to questions, given beforehand
    #[arg(long = "answer-file", value_name = "FILE", help_heading = "Guiding")]
    pub(super) answers: Option<PathBuf>,
    /// Answer to a question, given beforehand; repeatable
    #[arg(long = "answer", value_name = "ID=VALUE", help_heading = "Guiding")]
    pub(super) answer: Vec<String>,
    /// Print plain lines instead of the full-screen view
    #[arg(long, help_heading = "Guiding")]
    pub(super) line: bool,
}

/// A bench that is emulated.
#[derive(Debug, Clone, Default, Args)]
pub(super) struct EmulationArgs {
    /// Measure an emulated bench: emulated gauges behind real ports, a virtual robot and a simulated operator
    #[arg(long)]
    pub(super) emulated: bool,
    /// Speed relative to the real clock, with --emulated
    #[arg(long, default_value_t = 1.0, requires = "emulated", value_parser = speed)]
    pub(super) speed: f64,
    /// Seed of the noise, with --emulated
    #[arg(long, default_value_t = 0, requires = "emulated")]
    pub(super) seed: u64,
}

/// One statement of a gauge: which of instrument, port and unit, and its value.
type GaugeKey = (GaugeProperty, String);

/// What is stated of a gauge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum GaugeProperty {
    Instrument,
    Port,
    Unit,
}

fn gauge_key(text: &str) -> Result<GaugeKey, &'static str> {
    let (key, value) = text.split_once('=').unwrap_or((text, ""));
    let property = match key {
        "instrument" => GaugeProperty::Instrument,
        "port" => GaugeProperty::Port,
        "unit" => GaugeProperty::Unit,
        _ => return Err("instrument=NAME, port=PORT or unit=UNIT is expected"),
    };
    Ok((property, value.to_owned()))
}

/// A gauge as arguments state it.
#[derive(Debug, Clone, Default)]
pub(super) struct StatedGauge {
    pub(super) instrument: Option<String>,
    pub(super) port: Option<String>,
    pub(super) unit: Option<String>,
}

impl StatedGauge {
    /// Instrument and unit of a binding where none are stated.
    pub(super) fn beside(self, bound: Option<&Binding>) -> Self {
        Self {
            instrument: self
                .instrument
                .or(bound.map(|bound| bound.instrument.clone())),
            unit: self.unit.or(bound.and_then(|bound| bound.unit.clone())),
            ..self
        }
    }
}

impl BenchArgs {
    /// The values of a property, later ones count more: those of the options that scripts have for each, then those by key.
    fn values(&self, of_force: bool, property: GaugeProperty) -> Vec<&str> {
        use GaugeProperty::{Instrument, Port, Unit};
        let (by_option, by_key) = match (of_force, property) {
            (true, Instrument) => (self.force_instrument.as_slice(), &self.force),
            (true, Port) => (self.force_port.as_slice(), &self.force),
            (true, Unit) => (self.force_unit.as_slice(), &self.force),
            (false, Instrument) => (&self.displacement_instrument[..], &self.displacement),
            (false, Port) => (&self.displacement_port[..], &self.displacement),
            (false, Unit) => (&self.displacement_unit[..], &self.displacement),
        };
        let by_key = by_key.iter().filter(|(of, _)| *of == property);
        let all = by_option.iter().chain(by_key.map(|(_, value)| value));
        all.map(String::as_str).collect()
    }

    /// What is stated of a gauge.
    pub(super) fn of(&self, channel: Channel) -> StatedGauge {
        let mut emulated = self.emulated_gauges.iter();
        if let Some((_, own)) = emulated.find(|(of, _)| *of == channel) {
            return own.clone();
        }
        let of_force = channel == Channel::Force;
        // Each gauge has a port of its own.
        let stated = |property, of_all: bool| {
            let values = self.values(of_force, property);
            let value = if of_force {
                values.last().copied()
            } else {
                given(&values, channel, of_all)
            };
            value.map(str::to_owned)
        };
        StatedGauge {
            instrument: stated(GaugeProperty::Instrument, true),
            port: stated(GaugeProperty::Port, channel.axis().is_none()),
            unit: stated(GaugeProperty::Unit, true),
        }
    }

    /// The first value for a displacement gauge that is not in the plan, as it was given; the gauges of an emulated bench are in it.
    pub(super) fn out_of_plan(&self, channels: &[Channel]) -> Option<&str> {
        use GaugeProperty::{Instrument, Port, Unit};
        let all = [Instrument, Port, Unit].into_iter();
        let mut values = all.flat_map(|property| self.values(false, property));
        let is_out = |value: &&str| {
            let of = axis_of(value).map(|(axis, _)| Channel::along(axis));
            of.is_some_and(|of| !channels.contains(&of))
        };
        values
            .find(is_out)
            .filter(|_| self.emulated_gauges.is_empty())
    }
}

/// `x=VALUE` as axis and value.
fn axis_of(value: &str) -> Option<(Direction, &str)> {
    let (axis, value) = value.split_once('=')?;
    let axis = Direction::ALL
        .into_iter()
        .find(|of| of.to_string() == axis)?;
    Some((axis, value))
}

/// The last value for a gauge: that of its axis, else one for all of them where that makes sense.
fn given<'a>(values: &[&'a str], channel: Channel, of_all: bool) -> Option<&'a str> {
    let last = |axis: Option<Direction>| {
        let mut values = values.iter().rev().map(|value| match axis_of(value) {
            Some((axis, value)) => (Some(axis), value),
            None => (None, *value),
        });
        values.find(|(of, _)| *of == axis).map(|(_, value)| value)
    };
    let own = channel.axis().and_then(|axis| last(Some(axis)));
    own.or_else(|| last(None).filter(|_| of_all))
}

/// A speed that is one.
fn speed(text: &str) -> Result<f64, String> {
    let holds = |speed| (1.0..=1000.0).contains(&speed);
    number_that(text, holds, "a number from 1 to 1000 is expected")
}

/// When a reading is taken.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(super) enum CaptureWord {
    /// As soon as everything has settled
    #[default]
    Settled,
    /// When a key or pedal is pressed
    Key,
}
