//! Emulated benches: the gauges of a session in software, behind pseudo-terminals that are opened by name like any port.
//!
//! `session run --emulated`, `session faults`, `demo` and `emulate` all stand on [`PracticeBench`]; what is measured is the beam model with
//! noise, and the real drivers read it.

mod faults;
mod hand;
mod rehearsal;

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

use crate::bench::{EmulatedBench, EmulatedSetup, Jack, NoiseModel};
use crate::clock::Clock;
use crate::instrument::{Channel, InstrumentDescription};
use crate::instrument::emulator::{
    EmulatedGauge, FaultScript, HostOptions, Line, PtyHost, SharedTruth,
};
use crate::physics::ActingPhysics;
use crate::procedure::Procedure;
use crate::robot::{FittingFactors, Robot};

use super::failure::{CliError, Failure};

pub(super) use faults::{FaultsArgs, run as run_faults};
pub(super) use hand::{HelpingHand, PHASES};

/// What an emulated bench is made of.
pub(super) struct Practice<'a> {
    /// The robot.
    pub(super) robot: &'a Robot,
    /// What acts in it.
    pub(super) physics: &'a ActingPhysics,
    /// Its true factors.
    pub(super) factors: &'a FittingFactors,
    /// The procedure that will be followed.
    pub(super) procedure: &'a Procedure,
    /// Names of the gauges, force first.
    pub(super) gauges: [&'a str; 2],
    /// Errors of readings, zeros and runs.
    pub(super) noise: NoiseModel,
    /// Seed of these.
    pub(super) seed: u64,
    /// Session time.
    pub(super) clock: Clock,
    /// Time of the lines.
    pub(super) line: Clock,
    /// What goes wrong.
    pub(super) faults: FaultScript,
}

/// The unit that an emulated gauge is in where its packets carry none: the first of its description.
pub(super) fn default_unit(description: &InstrumentDescription) -> Option<String> {
    description.needs_unit().then(|| match description.channel {
        Channel::Force => "N".to_owned(),
        Channel::Displacement => "mm".to_owned(),
    })
}

/// A bench in software with its two lines, until it is dropped.
pub(super) struct PracticeBench {
    /// Robot and jack.
    pub(super) bench: EmulatedBench,
    /// The gauges.
    pub(super) host: PtyHost,
    links: Links,
}

impl PracticeBench {
    /// Sets the bench up; both ports are there when this returns.
    pub(super) fn start(practice: Practice<'_>) -> Result<Self, Failure> {
        let setup = EmulatedSetup {
            noise: practice.noise,
            jack: Jack::default(),
            seed: practice.seed,
            ..EmulatedSetup::default()
        };
        let bench = EmulatedBench::new(
            practice.robot,
            practice.physics,
            practice.factors,
            practice.procedure,
            setup,
            practice.clock,
        )?;
        let truths: [SharedTruth; 2] = {
            let (force, displacement) = (bench.clone(), bench.clone());
            [
                Arc::new(move || force.force_n()),
                Arc::new(move || displacement.displacement_m()),
            ]
        };
        let mut lines = Vec::new();
        for (name, truth) in practice.gauges.into_iter().zip(truths) {
            lines.push(Line::new(EmulatedGauge::new(name, truth)?));
        }
        let links = Links::make()?;
        let options = HostOptions {
            session: practice.clock,
            line: practice.line,
            links: Some(links.folder.clone()),
            faults: practice.faults,
        };
        Ok(Self {
            bench,
            host: PtyHost::start(lines, options)?,
            links,
        })
    }

    /// The name under which a gauge is opened.
    pub(super) fn port(&self, channel: Channel) -> String {
        let link = self.links.folder.join(channel.to_string());
        link.to_string_lossy().into_owned()
    }
}

/// A folder for the names of the lines, removed at the end.
struct Links {
    folder: PathBuf,
}

impl Links {
    fn make() -> Result<Self, CliError> {
        static MADE: AtomicU32 = AtomicU32::new(0);
        let number = MADE.fetch_add(1, Ordering::Relaxed);
        let name = format!("stiffbench-lines-{}-{number}", std::process::id());
        let folder = std::env::temp_dir().join(name);
        match std::fs::create_dir_all(&folder) {
            Ok(()) => Ok(Self { folder }),
            Err(source) => Err(CliError::Write {
                path: folder,
                source,
            }),
        }
    }
}

impl Drop for Links {
    fn drop(&mut self) {
        // The links themselves are removed with the lines; what is left is empty.
        let _ = std::fs::remove_dir_all(&self.folder);
    }
}
