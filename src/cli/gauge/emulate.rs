//! `stiffbench gauge emulate`: a bench in software for other programs, which works through a procedure by itself.

use stiffbench_document::Document;

use crate::analysis::read_text;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;

use clap::{Args, ValueEnum};
use signal_hook::consts::{SIGINT, SIGTERM};

use crate::bench::{EmulatedSetup, NoiseModel};
use crate::clock::Clock;
use crate::instrument::Channel;
use crate::instrument::emulator::FaultScript;
use crate::procedure::{PlannedReading, Procedure};
use crate::quantity::METRES_PER_MICROMETRE;
use crate::readings::RepeatOrder;
use crate::report::{EmulationReport, SimulatedGauges};
use crate::session::SessionPlan;
use crate::source_text::SourceText;
use crate::test_point::PoseId;

use super::descriptions::ProtocolsArgs;
use crate::cli::args::ModelArgs;
use crate::cli::emulated::{BenchOperator, Emulation};
use crate::cli::numbers::number_that;
use crate::cli::outcome::{print_error, print_now};
use crate::cli::procedure::{ProcedureArgs, resolve_procedure};
use crate::cli::{Failure, Global, Outcome};

/// How often it is looked whether a signal came.
const SIGNAL_WAIT: Duration = Duration::from_millis(50);

/// Arguments of `gauge emulate`.
#[derive(Debug, Args)]
#[command(
    after_help = "The virtual jack follows the procedure. One line per load states the load on the gauges; the last line is `end`.\n\nExamples:\n  stiffbench gauge emulate\n  stiffbench gauge emulate --force-instrument sauter-fh --displacement-instrument mahr-dk-u1 --link /tmp/bench --faults faults.toml\n  stiffbench gauge emulate --force-instrument my-gauge.toml            your own gauge, emulated from its description"
)]
pub(in crate::cli) struct EmulateArgs {
    /// Robot, mechanism and true factors.
    #[command(flatten)]
    pub(in crate::cli) model: ModelArgs,
    /// Description of the force gauge: a name or a file
    #[arg(long, default_value = "mark10-series5", value_name = "NAME|FILE")]
    pub(in crate::cli) force_instrument: String,
    /// Description of the displacement gauge: a name or a file
    #[arg(long, default_value = "mitutoyo-01a", value_name = "NAME|FILE")]
    pub(in crate::cli) displacement_instrument: String,
    /// Fault script: which fault occurs when (crates/gauges/fault-script.md)
    #[arg(long, value_name = "FILE")]
    pub(in crate::cli) faults: Option<PathBuf>,
    /// Folder for the links to the ports, called force and displacement [default: a temporary folder]
    #[arg(long, value_name = "FOLDER")]
    pub(in crate::cli) link: Option<PathBuf>,
    /// Seed of the noise and of the forces at which the operator stops
    #[arg(long, default_value_t = 0)]
    pub(in crate::cli) seed: u64,
    /// Speed of the bench relative to the real clock
    #[arg(long, default_value_t = 1.0, value_parser = faster)]
    pub(in crate::cli) speed: f64,
    /// Emulate without noise
    #[arg(long)]
    pub(in crate::cli) noise_free: bool,
    /// Gauges mounted on the other side: a force along the axis is compression, the displacement counts along the negative axis
    #[arg(long, value_enum, value_delimiter = ',', value_name = "GAUGE")]
    turned: Vec<BenchGauge>,
    /// Keep the ports open after the end, without load, until the process is stopped
    #[arg(long)]
    pub(in crate::cli) stay: bool,
    /// More descriptions.
    #[command(flatten)]
    pub(in crate::cli) protocols: ProtocolsArgs,
    /// What is to be measured; last, as its heading would go on.
    #[command(flatten)]
    pub(in crate::cli) procedure: ProcedureArgs,
}

/// A gauge of the bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum BenchGauge {
    /// The force gauge
    Force,
    /// The displacement gauge
    Displacement,
}

/// How often a jack that moves is checked.
const LOOK: Duration = Duration::from_millis(2);

/// Hosts the bench and works through the procedure.
pub(in crate::cli) fn run(args: &EmulateArgs, global: &Global) -> Result<Outcome, Failure> {
    let resolved = args.model.resolve()?;
    let (procedure, mut warnings) = resolve_procedure(&args.procedure)?;
    warnings.extend(resolved.warnings.iter().cloned());
    // Nobody mounts gauges here: one stands along the load.
    procedure.load_axes()?;
    let hand = Emulation {
        resolved: &resolved,
        procedure: &procedure,
        gauges: vec![
            (Channel::Force, args.force_instrument.clone()),
            (Channel::Displacement, args.displacement_instrument.clone()),
        ],
        protocols: &args.protocols,
        setup: setup(args),
        session: Clock::starting_at(0.0, args.speed),
        faults: args
            .faults
            .as_ref()
            .map_or_else(|| Ok(FaultScript::default()), |path| fault_script(path))?,
        links: args.link.clone(),
    }
    .start()?;
    let [force, displacement] = Channel::ALL.map(|channel| hand.port(channel));
    remove_when_stopped(vec![force.clone(), displacement.clone()]);
    let mut document = Document::new();
    document.pair("force", force.display().to_string());
    document.pair("displacement", displacement.display().to_string());
    document.paragraph("ready");
    let report = EmulationReport {
        ports: SimulatedGauges {
            force: force.clone(),
            displacement: displacement.clone(),
        },
        instruments: SimulatedGauges {
            force: args.force_instrument.clone(),
            displacement: args.displacement_instrument.clone(),
        },
        procedure: procedure.name.clone(),
        seed: args.seed,
        speed: args.speed,
    };
    let ready = Outcome::new("emulate", document, report).with_warnings(warnings);
    let ended = ready.print_before_the_end(global)?;
    let named: Vec<PoseId> = resolved
        .robot
        .poses
        .iter()
        .map(|pose| pose.id.clone())
        .collect();
    let worker = Worker {
        hand: &hand,
        procedure: &procedure,
        speed: args.speed,
        global,
    };
    worker.work(&SessionPlan::new(&procedure, &named))?;
    if args.stay {
        loop {
            std::thread::park();
        }
    }
    if !global.quiet {
        let [force, displacement] = Channel::ALL.map(|channel| hand.host.packets_sent(channel));
        print_error(&format!(
            "{force} packets of force, {displacement} of displacement sent"
        ));
    }
    Ok(ended)
}

/// Removes links when a signal ends the program, which then ends as it would have.
fn remove_when_stopped(links: Vec<PathBuf>) {
    let stopped_by = Arc::new(AtomicUsize::new(0));
    for signal in [SIGINT, SIGTERM] {
        let flag = Arc::clone(&stopped_by);
        if let Err(error) = signal_hook::flag::register_usize(signal, flag, signal as usize) {
            print_error(&format!("note: no signal handler: {error}"));
        }
    }
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(SIGNAL_WAIT);
            let signal = stopped_by.load(Ordering::Relaxed);
            if signal == 0 {
                continue;
            }
            for link in &links {
                // A link that is not there is what is wanted.
                let _ = std::fs::remove_file(link);
            }
            let _ = signal_hook::low_level::emulate_default_handler(signal as i32);
        }
    });
}

/// A speed from that of the real clock on.
fn faster(text: &str) -> Result<f64, String> {
    number_that(
        text,
        |speed| speed >= 1.0,
        "it must be a number of at least 1",
    )
}

fn setup(args: &EmulateArgs) -> EmulatedSetup {
    let default = EmulatedSetup::default();
    EmulatedSetup {
        noise: if args.noise_free {
            NoiseModel::NONE
        } else {
            default.noise
        },
        seed: args.seed,
        force_turned: args.turned.contains(&BenchGauge::Force),
        displacement_turned: args.turned.contains(&BenchGauge::Displacement),
        ..default
    }
}

/// The faults in a file.
pub(in crate::cli) fn fault_script(path: &Path) -> Result<FaultScript, Failure> {
    let text = read_text(path)?;
    let source = SourceText::new(path.display().to_string(), text);
    Ok(FaultScript::parse(&source)?)
}

/// What an operator does at the jack, without a look at the gauges: the whole plan, once.
struct Worker<'a> {
    hand: &'a BenchOperator,
    procedure: &'a Procedure,
    speed: f64,
    global: &'a Global,
}

impl Worker<'_> {
    fn work(&self, plan: &SessionPlan) -> Result<(), Failure> {
        for cell in &plan.cells {
            self.hand.host.phase("set-up");
            self.hand.bench.set_pose(&cell.pose)?;
            self.hand.bench.set_direction(&cell.direction)?;
            for reading in &cell.readings {
                self.load(reading)?;
                let (force_n, displacement_m) = self.hand.truth();
                self.notify(&format!(
                    "{} {} run {} step {}: {force_n:.4} N  {:.4} µm",
                    cell.pose,
                    cell.direction,
                    reading.repeat,
                    reading.step + 1,
                    displacement_m / METRES_PER_MICROMETRE
                ));
            }
        }
        self.hand.bench.release();
        self.rest();
        self.notify("end");
        Ok(())
    }

    /// Applies the load of a reading and waits as long as it asks for.
    fn load(&self, reading: &PlannedReading) -> Result<(), Failure> {
        if let Some(hold_s) = reading.extra_hold_s {
            self.hand.host.phase("hold");
            self.wait(hold_s);
            return Ok(());
        }
        if reading.zero_before {
            self.hand.host.phase("free");
            self.hand.bench.begin_run(reading.repeat);
            self.rest();
            self.hand.zero(Channel::Force)?;
        }
        if reading.zero_before || self.procedure.repeat_order == RepeatOrder::AtLoad {
            self.hand.host.phase("preload");
            self.hand.bench.preload();
            self.rest();
        }
        if reading.zero_before {
            self.hand.zero(Channel::Displacement)?;
        }
        self.hand.host.phase("approach");
        let which = (reading.step, reading.repeat);
        self.hand.apply(reading.target_n, which);
        self.rest();
        self.hand.host.phase("settle");
        self.wait(self.procedure.settle.dwell_s);
        Ok(())
    }

    fn rest(&self) {
        while !self.hand.bench.is_at_rest() {
            std::thread::sleep(LOOK);
        }
    }

    /// Waits for session seconds.
    fn wait(&self, seconds: f64) {
        let wait = Duration::try_from_secs_f64(seconds / self.speed);
        std::thread::sleep(wait.unwrap_or(Duration::MAX));
    }

    /// A line where text goes: standard output, or standard error beside JSON.
    fn notify(&self, line: &str) {
        if self.global.json {
            print_error(line);
        } else {
            print_now(&format!("{line}\n"));
        }
    }
}
