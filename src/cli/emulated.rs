//! A bench in software behind real ports: emulated gauges coupled to one robot, and the hand of whoever works there.

use std::path::PathBuf;
use std::sync::Arc;

use tempfile::TempDir;

use crate::bench::{EmulatedBench, EmulatedSetup};
use crate::clock::Clock;
use crate::instrument::Channel;
use crate::instrument::emulator::{
    EmulatedGauge, EmulatedLine, FaultScript, HostOptions, PanelAction, PtyHost, SharedTruth,
};
use crate::procedure::Procedure;

use super::failure::{CliError, Failure};
use super::gauge::ProtocolsArgs;
use super::gauge::descriptions::{all_descriptions, find_description};
use crate::analysis::{ArgumentError, ResolvedModel};

/// How many times as fast as real lines the emulated ones are run at most; streams and delays of a gauge get shorter, programs do not.
const FASTEST_LINE: f64 = 10.0;

/// What is emulated.
pub struct Emulation<'a> {
    /// Robot, mechanism, true factors, physics.
    pub resolved: &'a ResolvedModel,
    /// What is to be measured.
    pub procedure: &'a Procedure,
    /// The gauges, each with the name of its description.
    pub gauges: Vec<(Channel, String)>,
    /// Descriptions besides the shipped ones.
    pub protocols: &'a ProtocolsArgs,
    /// Noise, seed, and which way the gauges stand.
    pub setup: EmulatedSetup,
    /// Session time.
    pub session: Clock,
    /// What goes wrong.
    pub faults: FaultScript,
    /// Folder for the links to the ports; one of its own if none is named.
    pub links: Option<PathBuf>,
}

/// The hand at an emulated bench; it may be used from any thread. The bench goes when it is dropped.
pub struct BenchOperator {
    /// Robot, jack and stands, for what needs a hand only there.
    pub bench: EmulatedBench,
    /// The gauges behind their ports.
    pub host: PtyHost,
    /// Last, so that the links go before their folder.
    _folder: Option<TempDir>,
}

impl Emulation<'_> {
    /// Starts the gauges on the robot. Their ports are there when this returns.
    ///
    /// # Errors
    /// For a gauge that is not known or measures the other quantity, a procedure that the robot cannot follow, or no ports.
    pub fn start(self) -> Result<BenchOperator, Failure> {
        let bench = EmulatedBench::new(
            &self.resolved.robot,
            &self.resolved.physics,
            &self.resolved.factors,
            self.procedure,
            self.setup,
            self.session,
        )?;
        let mut lines = Vec::new();
        for (channel, name) in &self.gauges {
            let of = bench.clone();
            let truth: SharedTruth = match (channel, channel.axis()) {
                (_, Some(axis)) => Arc::new(move || of.displacement_along_m(axis)),
                (Channel::Force, _) => Arc::new(move || of.force_n()),
                _ => Arc::new(move || of.displacement_m()),
            };
            lines.push(line(name, self.protocols, *channel, truth)?);
        }
        let own = match &self.links {
            Some(folder) => {
                std::fs::create_dir_all(folder).map_err(CliError::write(folder))?;
                for (channel, _) in &self.gauges {
                    let path = folder.join(channel.to_string());
                    let there = path.symlink_metadata();
                    if there.is_ok_and(|there| !there.is_symlink()) {
                        return Err(CliError::FileExists { path }.into());
                    }
                }
                None
            }
            None => Some(link_folder()?),
        };
        let links = self.links.or(own.as_ref().map(|own| own.path().to_owned()));
        let speed = self.session.speed().clamp(1.0, FASTEST_LINE);
        let options = HostOptions {
            session: self.session,
            line: Clock::starting_at(0.0, speed),
            links,
            faults: self.faults,
        };
        Ok(BenchOperator {
            bench,
            host: PtyHost::start(lines, options)?,
            _folder: own,
        })
    }
}

/// A gauge emulated from its description, if it measures what it is to measure.
fn line(
    name: &str,
    protocols: &ProtocolsArgs,
    channel: Channel,
    truth: SharedTruth,
) -> Result<EmulatedLine, Failure> {
    let found = find_description(name, protocols)?;
    let mut description = found.description;
    if description.channel.kind() != channel.kind() {
        let (all, _) = all_descriptions(protocols)?;
        let fitting = all.iter().map(|found| &found.description);
        let fitting = fitting.filter(|other| other.channel.kind() == channel.kind());
        let fitting: Vec<&str> = fitting.map(|other| other.name.as_str()).collect();
        return ArgumentError::refuse(
            format!("--{channel} {name}"),
            format!("this gauge measures {}", description.channel),
            format!("gauges of {channel} are {}", fitting.join(", ")),
        );
    }
    description.channel = channel;
    Ok(EmulatedLine::new(EmulatedGauge::described(
        &description,
        truth,
    )))
}

impl BenchOperator {
    /// The port of a gauge, the same for as long as the bench is there.
    #[must_use]
    pub fn port(&self, channel: Channel) -> PathBuf {
        self.host.port(channel).unwrap_or_default()
    }

    /// Turns the jack to a load; `which` is its step and repeat.
    pub fn apply(&self, target_n: f64, (step, repeat): (u32, u32)) {
        self.host.reading();
        self.bench.apply(target_n, step, repeat);
    }

    /// Presses the zero key of a gauge.
    pub(super) fn zero(&self, channel: Channel) -> Result<(), Failure> {
        Ok(self.host.press(channel, &PanelAction::Zero)?)
    }

    /// What acts on the gauges now: N, and m from where the tip of the displacement gauge would hang free.
    pub(super) fn truth(&self) -> (f64, f64) {
        (self.bench.force_n(), self.bench.displacement_m())
    }
}

/// A folder for links among the system's temporary ones, with a name that nobody else has, whatever programs that were killed left there.
fn link_folder() -> Result<TempDir, Failure> {
    let made = tempfile::Builder::new().prefix("stiffbench-").tempdir();
    Ok(made.map_err(CliError::write(&std::env::temp_dir()))?)
}
