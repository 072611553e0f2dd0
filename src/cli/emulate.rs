//! `stiffbench emulate`: a bench in software for other programs, worked by lines on standard input.

use std::io::BufRead;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, ValueEnum};
use serde_json::json;

use crate::bench::{EmulatedSetup, NoiseModel};
use crate::clock::Clock;
use crate::instrument::Channel;
use crate::instrument::emulator::{FaultScript, Panel};
use crate::quantity::METRES_PER_MICROMETRE;
use crate::source_text::SourceText;
use crate::test_point::{Direction, PoseId};

use super::args::{Global, ModelArgs};
use super::emulated::{Emulation, Hand};
use super::failure::{CliError, Failure};
use super::instrument_args::ProtocolsArgs;
use super::outcome::{Outcome, print_error, print_now};
use super::procedure::{ProcedureArgs, choose_procedure};
use super::resolve::resolve;

/// Arguments of `emulate`.
#[derive(Debug, Args)]
#[command(
    after_help = "Commands on standard input, each answered by ok or by what is wrong:\n  pose P1 | direction y | run N                 where and for which run; the jack is off\n  preload | apply -10 [STEP REPEAT] | release   the jack; a load is the first planned one of its size unless told otherwise\n  zero GAUGE | unit GAUGE WORD | key GAUGE      at the gauge; GAUGE is force or displacement\n  push -8 | push GAUGE - | let-go               by hand: both gauges as by a force in N, or one alone (- or +)\n  fault GAUGE WHAT [KEY=VALUE ...] | phase NAME what goes wrong (docs/fault-script.md)\n  wait | state | quit                           until all is at rest; what acts on the gauges; the end\n\nExamples:\n  stiffbench emulate\n  stiffbench emulate --force sauter-fh --displacement mahr-dk-u1 --link /tmp/bench --faults faults.toml\n  stiffbench emulate --force my-gauge.toml            a gauge of your own, as its description has it"
)]
pub(super) struct EmulateArgs {
    /// Robot, mechanism and true factors.
    #[command(flatten)]
    pub(super) model: ModelArgs,
    /// The force gauge: name of a description, or a file
    #[arg(long, default_value = "mark10-series5", value_name = "NAME")]
    pub(super) force: String,
    /// The displacement gauge: name of a description, or a file
    #[arg(long, default_value = "mitutoyo-01a", value_name = "NAME")]
    pub(super) displacement: String,
    /// What goes wrong, as docs/fault-script.md has it
    #[arg(long, value_name = "FILE")]
    pub(super) faults: Option<PathBuf>,
    /// Folder for the ports, links called force and displacement [default: a temporary one]
    #[arg(long, value_name = "FOLDER")]
    pub(super) link: Option<PathBuf>,
    /// Seed of noise and of where the operator stops
    #[arg(long, default_value_t = 0)]
    pub(super) seed: u64,
    /// How many times as fast as the real clock the jack is turned
    #[arg(long, default_value_t = 1.0)]
    pub(super) speed: f64,
    /// No noise
    #[arg(long)]
    pub(super) noise_free: bool,
    /// Gauges that stand on the other side: a force along the axis is compression, the displacement counts along the negative axis
    #[arg(long, value_enum, value_delimiter = ',', value_name = "GAUGE")]
    turned: Vec<GaugeWord>,
    /// Go on when standard input ends, until the process is stopped
    #[arg(long)]
    pub(super) stay: bool,
    /// More descriptions.
    #[command(flatten)]
    pub(super) protocols: ProtocolsArgs,
    /// What is to be measured; last, as its heading would go on.
    #[command(flatten)]
    pub(super) procedure: ProcedureArgs,
}

/// A gauge of the bench.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
enum GaugeWord {
    /// The force gauge
    Force,
    /// The displacement gauge
    Displacement,
}

/// How often `wait` looks.
const LOOK: Duration = Duration::from_millis(2);

/// Hosts the bench until it is told to end.
pub(super) fn run(args: &EmulateArgs, global: &Global) -> Result<Outcome, Failure> {
    let chosen = resolve(&args.model, None)?;
    let (procedure, mut warnings) = choose_procedure(&args.procedure)?;
    warnings.extend(chosen.warnings.iter().cloned());
    let hand = Emulation {
        chosen: &chosen,
        procedure: &procedure,
        force: &args.force,
        displacement: &args.displacement,
        protocols: &args.protocols,
        setup: setup(args),
        session: Clock::starting_at(0.0, args.speed),
        faults: args
            .faults
            .as_ref()
            .map_or_else(|| Ok(FaultScript::default()), fault_script)?,
        links: args.link.clone(),
    }
    .start()?;
    let [force, displacement] = Channel::ALL.map(|channel| hand.port(channel));
    let text = format!(
        "{:13} {}\n{:13} {}\nready\n",
        "force",
        force.display(),
        "displacement",
        displacement.display()
    );
    let data = json!({
        "ports": { "force": force, "displacement": displacement },
        "instruments": { "force": args.force, "displacement": args.displacement },
        "procedure": procedure.name,
        "seed": args.seed,
        "speed": args.speed,
    });
    let ready = Outcome::new("emulate", text, data).with_warnings(warnings);
    let ended = ready.print_before_the_end(global)?;
    obey_all(&hand, global)?;
    if args.stay {
        loop {
            std::thread::park();
        }
    }
    if !global.quiet {
        let [force, displacement] = Channel::ALL.map(|channel| hand.packets_sent(channel));
        print_error(&format!(
            "{force} packets of force, {displacement} of displacement sent"
        ));
    }
    Ok(ended)
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
        force_turned: args.turned.contains(&GaugeWord::Force),
        displacement_turned: args.turned.contains(&GaugeWord::Displacement),
        ..default
    }
}

/// The faults in a file.
pub(super) fn fault_script(path: &PathBuf) -> Result<FaultScript, Failure> {
    let text = std::fs::read_to_string(path).map_err(|source| CliError::Read {
        path: path.clone(),
        source,
    })?;
    let source = SourceText::new(path.display().to_string(), text);
    Ok(FaultScript::parse(&source)?)
}

/// Obeys the lines of standard input until they end or `quit`. Answers go where text goes: standard output, or standard error beside JSON.
fn obey_all(hand: &Hand, global: &Global) -> Result<(), Failure> {
    for line in std::io::stdin().lock().lines() {
        let line = line.map_err(|source| CliError::Read {
            path: "standard input".into(),
            source,
        })?;
        let answer = match line.trim() {
            "" => continue,
            "quit" => break,
            command => obey(hand, command).unwrap_or_else(|wrong| format!("wrong: {wrong}")),
        };
        if global.json {
            print_error(&answer);
        } else {
            print_now(&format!("{answer}\n"));
        }
    }
    Ok(())
}

/// Does what a line says; the answer, or what is wrong with it.
fn obey(hand: &Hand, command: &str) -> Result<String, String> {
    let words: Vec<&str> = command.split_whitespace().collect();
    match words[..] {
        ["pose", name] => done(hand.set_pose(&PoseId::new(name)))?,
        ["direction", name] => {
            let direction: Direction = parsed(name)?;
            done(hand.set_direction(direction))?;
        }
        ["run", repeat] => hand.begin_run(parsed(repeat)?),
        ["preload"] => hand.preload(),
        ["apply", target_n] => hand.apply(finite(target_n)?, None),
        ["apply", target_n, step, repeat] => {
            hand.apply(finite(target_n)?, Some((parsed(step)?, parsed(repeat)?)));
        }
        ["release"] => hand.release(),
        ["zero", gauge] => done(hand.zero(channel(gauge)?))?,
        ["unit", gauge, unit] => done(hand.press(channel(gauge)?, &Panel::Unit(unit.into())))?,
        ["key", gauge] => done(hand.press(channel(gauge)?, &Panel::DataKey))?,
        ["push", force_n] => hand.push(finite(force_n)?),
        ["push", gauge, "+"] => hand.push_by_hand(channel(gauge)?, 1.0),
        ["push", gauge, "-"] => hand.push_by_hand(channel(gauge)?, -1.0),
        ["let-go"] => hand.let_go(),
        ["fault", ..] => {
            let fault = FaultScript::parse_line(command.trim_start_matches("fault").trim());
            hand.fail(fault.map_err(|error| error.to_string())?);
        }
        ["phase", name] => hand.phase(name),
        ["wait"] => {
            while !hand.is_at_rest() {
                std::thread::sleep(LOOK);
            }
        }
        ["state"] => {
            let (force_n, displacement_m) = hand.truth();
            let displacement_um = displacement_m / METRES_PER_MICROMETRE;
            let rest = if hand.is_at_rest() {
                "at rest"
            } else {
                "moving"
            };
            return Ok(format!("{force_n:.4} N  {displacement_um:.4} um  {rest}"));
        }
        _ => {
            return Err(format!(
                "`{command}` is no command (stiffbench emulate --help)"
            ));
        }
    }
    Ok("ok".to_owned())
}

fn done(result: Result<(), Failure>) -> Result<(), String> {
    result.map_err(|failure| failure.message())
}

fn parsed<T: std::str::FromStr<Err: std::fmt::Display>>(word: &str) -> Result<T, String> {
    word.parse().map_err(|error| format!("`{word}`: {error}"))
}

fn finite(word: &str) -> Result<f64, String> {
    let number: f64 = parsed(word)?;
    if number.is_finite() {
        Ok(number)
    } else {
        Err(format!("`{word}` is no load"))
    }
}

fn channel(word: &str) -> Result<Channel, String> {
    let named = Channel::ALL
        .into_iter()
        .find(|channel| channel.to_string() == word);
    named.ok_or_else(|| format!("`{word}` is no gauge: force or displacement"))
}
