//! `stiffbench simulate`.

use std::fs;
use std::path::Path;

use crate::bench::{Jack, NoiseModel, NoiseShape, VirtualBench};
use crate::physics::{Effect, Place};
use crate::procedure::Procedure;
use crate::quantity::METRES_PER_MICROMETRE;
use crate::readings::{InstrumentRecord, Instruments, SessionHeader, WrittenRows, write_rows};
use crate::report::SimulationReport;
use crate::robot::{FittingFactors, ModelParameter};
use crate::test_point::Direction;

use super::args::{NoiseWord, SimulateArgs};
use super::failure::{CliError, Failure};
use super::figure_files::write;
use super::model::{effects_text, physics_text};
use super::outcome::Outcome;
use super::procedure::resolve_procedure;
use super::simulate_load_cases::{self, CaseKind};
use crate::analysis::{
    ArgumentError, Inputs, ResolvedModel, UnknownSprings, add_poses, sha256, state_joint_values,
};
use crate::count::counted;

/// A session folder from a virtual bench.
pub(super) fn run(args: &SimulateArgs) -> Result<Outcome, Failure> {
    if let Some(kind) = CaseKind::of(args) {
        let resolved = args.model.resolve()?;
        let truth = true_factors(args, &resolved)?;
        return simulate_load_cases::run(args, kind, resolved, truth);
    }
    let (mut procedure, mut warnings) = resolve_procedure(&args.procedure)?;
    procedure = args.axes.applied(procedure)?;
    let mut resolved = args.model.resolve_in(&procedure)?;
    let truth = true_factors(args, &resolved)?;
    warnings.extend(add_poses(&mut resolved.robot, &procedure)?);
    let poses = procedure.poses.get_or_insert_with(|| {
        let named = resolved.robot.poses.iter();
        named.map(|named| named.id.clone()).collect()
    });
    let n_poses = poses.len();
    let several_gauges = !procedure.displacement_axes.is_empty();
    if several_gauges {
        state_joint_values(&resolved.robot, &mut procedure)?;
    }
    let rigid_springs = rigid_springs(&resolved, &truth);
    let noise = noise(args);
    let jack = Jack::default();
    let mut table = VirtualBench::new(&resolved.robot, &resolved.physics, &truth, noise, jack)?
        .keeping_history(args.keep_history)
        .run(&procedure, &id(args), args.seed)?;
    table.origin = Some(origin(args, &resolved));
    let idle = resolved.physics.effects.iter();
    warnings.extend(idle.filter(|e| !acts(e, &procedure)).map(|effect| {
        format!("{effect}: the procedure has no such reading, and the effect does not act")
    }));

    create_new(&args.out)?;
    let mut readings = Vec::new();
    let rows = WrittenRows {
        of_vectors: several_gauges,
        ..WrittenRows::default()
    };
    write_rows(&table, rows, &mut readings)?;
    // A reading of several gauges is one.
    let count = table.readings.last().map_or(0, |last| last.seq as usize);
    let record = simulation_record(args, &resolved, &truth, &noise, &procedure);
    let header = header(args, &resolved, &procedure).to_toml();
    write_session(args, &resolved, &readings, [&header, &record])?;
    let minutes = procedure.minutes(&jack.pace, n_poses);
    let text = format!(
        "{}: {} of mechanism {} in {} and {} by procedure {}, seed {}\n{}On a real bench some {:.0} minutes.\n\
         session.toml, readings.csv, robot.toml and simulation.toml (true factors, physics and noise) written.\nNext: stiffbench fit {}\n",
        args.out.display(),
        counted(count, "reading"),
        resolved.mechanism,
        counted(n_poses, "pose"),
        counted(procedure.directions.len(), "direction"),
        procedure.name,
        args.seed,
        physics_text(&resolved.physics),
        minutes,
        args.out.display()
    );
    warnings.extend(rigid_springs);
    warnings.extend(resolved.warnings.iter().cloned());
    let report = SimulationReport {
        readings: count,
        procedure: procedure.name,
        minutes: minutes.round(),
        ..report(args, &resolved, truth, noise)
    };
    Ok(outcome(text, report, &resolved, warnings))
}

/// The files of a simulated session: its header and its truth beside robot and readings.
pub(super) fn write_session(
    args: &SimulateArgs,
    resolved: &ResolvedModel,
    readings: &[u8],
    [header, record]: [&str; 2],
) -> Result<(), CliError> {
    for (name, bytes) in [
        ("robot.toml", resolved.source.text.as_bytes()),
        ("readings.csv", readings),
        ("session.toml", header.as_bytes()),
        ("simulation.toml", record.as_bytes()),
    ] {
        write(&args.out.join(name), bytes)?;
    }
    Ok(())
}

/// A simulated session without what depends on its form.
pub(super) fn report(
    args: &SimulateArgs,
    resolved: &ResolvedModel,
    factors: FittingFactors,
    noise: NoiseModel,
) -> SimulationReport {
    SimulationReport {
        folder: args.out.clone(),
        readings: 0,
        seed: args.seed,
        procedure: String::new(),
        minutes: 0.0,
        mechanism: resolved.mechanism.clone(),
        factors,
        physics: resolved.physics.effects.clone(),
        noise,
        tracker: None,
    }
}

/// The outcome of a simulation.
pub(super) fn outcome(
    text: String,
    report: SimulationReport,
    resolved: &ResolvedModel,
    warnings: Vec<String>,
) -> Outcome {
    Outcome::new("simulate", text, report)
        .with_inputs(Inputs::default().with_model(resolved))
        .with_warnings(warnings)
}

/// The mark of readings that nobody measured.
pub(super) fn origin(args: &SimulateArgs, resolved: &ResolvedModel) -> String {
    let noise = if args.noise_free { "no noise" } else { "noise" };
    let physics = effects_text(&resolved.physics);
    format!("simulated; seed {}; {noise}; {physics}", args.seed)
}

/// Makes the session folder; one that exists is never touched.
pub(super) fn create_new(folder: &Path) -> Result<(), CliError> {
    if let Some(parent) = folder
        .parent()
        .filter(|parent| !parent.as_os_str().is_empty())
    {
        fs::create_dir_all(parent).map_err(CliError::write(parent))?;
    }
    fs::create_dir(folder).map_err(CliError::create(folder))
}

fn true_factors(args: &SimulateArgs, resolved: &ResolvedModel) -> Result<FittingFactors, Failure> {
    let (robot, mut truth) = (&resolved.robot, resolved.factors.clone());
    let mechanism = robot.mechanism(Some(&resolved.mechanism))?;
    for setting in &args.true_factor {
        let wrong = |problem: &str| {
            ArgumentError::new(
                format!("--true-factor {setting}"),
                problem,
                "--true-factor beam.Iy=0.006",
            )
        };
        let (name, value) = setting
            .split_once('=')
            .ok_or_else(|| wrong("a factor, an equals sign and a number are needed"))?;
        let value: f64 = value
            .parse()
            .map_err(|_| wrong("the value is not a number"))?;
        if !(value.is_finite() && value > 0.0) {
            return Err(wrong("the value must be above zero").into());
        }
        truth.set(&ModelParameter::find(robot, mechanism, name)?, value);
    }
    Ok(truth)
}

/// That springs without a value are simulated as rigid.
pub(super) fn rigid_springs(resolved: &ResolvedModel, truth: &FittingFactors) -> Vec<String> {
    let physics = &resolved.physics;
    let (mechanism, effects) = (&physics.mechanism, &physics.effects);
    let unknown = UnknownSprings::new(&resolved.robot, mechanism, truth, effects);
    let words = unknown.words().map(|words| {
        let first = &unknown.springs[0];
        format!(
            "{words}; simulated as rigid, unless --true-factor {first}=5e-6 states its compliance"
        )
    });
    words.into_iter().collect()
}

pub(super) fn noise(args: &SimulateArgs) -> NoiseModel {
    if args.noise_free {
        return NoiseModel::NONE;
    }
    NoiseModel {
        reading_sd_m: args.reading_sd_um * METRES_PER_MICROMETRE,
        zero_sd_m: args.zero_sd_um * METRES_PER_MICROMETRE,
        run_slope_sd: args.run_slope_sd,
        displacement_step_m: args.displacement_step_um * METRES_PER_MICROMETRE,
        force_step_n: args.force_step_n,
        shape: match args.noise_distribution {
            NoiseWord::Normal => NoiseShape::Normal,
            NoiseWord::Skewed => NoiseShape::Skewed,
        },
    }
}

fn header(args: &SimulateArgs, resolved: &ResolvedModel, procedure: &Procedure) -> SessionHeader {
    let step = |step: f64| (!args.noise_free && step > 0.0).then_some(step);
    let gauge = |model: &str, resolution| InstrumentRecord {
        model: Some(model.to_owned()),
        resolution,
        ..InstrumentRecord::default()
    };
    let axes = &procedure.displacement_axes;
    let dial_gauge = || {
        let step_m = args.displacement_step_um * METRES_PER_MICROMETRE;
        gauge("virtual dial gauge", step(step_m))
    };
    SessionHeader {
        factors: resolved
            .robot
            .factors
            .contains_key(&resolved.factors_name)
            .then(|| resolved.factors_name.clone()),
        procedure: Some(procedure.to_record()),
        instruments: Instruments {
            force: Some(gauge("virtual force gauge", step(args.force_step_n))),
            displacement: axes.is_empty().then(dial_gauge),
            displacement_along: Direction::ALL.map(|axis| axes.contains(&axis).then(dial_gauge)),
        },
        ..usual_header(args, resolved)
    }
}

/// What the headers of all simulated sessions state.
pub(super) fn usual_header(args: &SimulateArgs, resolved: &ResolvedModel) -> SessionHeader {
    SessionHeader {
        id: Some(id(args)),
        robot: Some("robot.toml".to_owned()),
        robot_sha256: Some(sha256(&resolved.source.text)),
        mechanism: Some(resolved.mechanism.clone()),
        origin: Some(origin(args, resolved)),
        operator: Some("simulation".to_owned()),
        software: Some(concat!("stiffbench ", env!("CARGO_PKG_VERSION")).to_owned()),
        ..SessionHeader::default()
    }
}

fn id(args: &SimulateArgs) -> String {
    format!("simulated-{}", args.seed)
}

/// Whether a slip has readings after it and a gauge of several is read; everything else acts anywhere.
fn acts(effect: &Effect, procedure: &Procedure) -> bool {
    let loads = &procedure.directions;
    let is_read = |axis: &Direction| {
        let mut loads = loads.iter();
        loads.any(|load| procedure.axes_read_under(load).contains(axis))
    };
    match &effect.place {
        Place::DisplacementGauge(gauge) | Place::Clock(gauge) => gauge.iter().all(is_read),
        Place::Run {
            pose,
            direction,
            repeat,
            step,
            gauge,
        } => {
            let loaded = loads.iter().find(|load| load.is_called(direction));
            let read = loaded.map(|load| procedure.axes_read_under(load));
            read.is_some_and(|read| gauge.is_none_or(|axis| read.contains(&axis)))
                && procedure.poses.iter().flatten().any(|known| known == pose)
                && procedure
                    .steps(0)
                    .iter()
                    .any(|planned| planned.repeat == *repeat && planned.step >= *step)
        }
        _ => true,
    }
}

/// What an analysis must not see: the truth.
fn simulation_record(
    args: &SimulateArgs,
    resolved: &ResolvedModel,
    truth: &FittingFactors,
    noise: &NoiseModel,
    procedure: &Procedure,
) -> String {
    let shape = match noise.shape {
        NoiseShape::Normal => "normal",
        NoiseShape::Skewed => "skewed",
    };
    let effects = effects_line(resolved);
    let effects = if effects.is_empty() {
        "\n".to_owned()
    } else {
        format!("{effects}keep_history = {}\n\n", args.keep_history)
    };
    let shape = format!("shape = \"{shape}\"\n");
    let force_tolerance_n = procedure.settle.force_tolerance_n;
    truth_text(args.seed, truth, noise, [&effects, &shape])
        + &format!("force_tolerance_N = {force_tolerance_n:?}\n")
}

/// The line of the effects that acted, as --effect takes them; empty without any.
pub(super) fn effects_line(resolved: &ResolvedModel) -> String {
    let effects = resolved.physics.effects.iter();
    let effects: Vec<toml::Value> = effects
        .map(|effect| toml::Value::String(effect.compact()))
        .collect();
    if effects.is_empty() {
        return String::new();
    }
    format!("effects = {}\n", toml::Value::Array(effects))
}

/// The truth of any simulated session: its seed, its factors and its noise.
///
/// # Arguments
/// - `lines`: behind the seed, and before the noise.
pub(super) fn truth_text(
    seed: u64,
    truth: &FittingFactors,
    noise: &NoiseModel,
    [behind_seed, of_noise]: [&str; 2],
) -> String {
    format!(
        "# The truth behind readings.csv; no analysis reads this file.\nschema = \"stiffbench/simulation/1\"\nseed = {seed}\n{behind_seed}[factors]\n{}\n[noise]\n{of_noise}\
         reading_sd_um = {:?}\nzero_sd_um = {:?}\nrun_slope_sd = {:?}\ndisplacement_step_um = {:?}\nforce_step_N = {:?}\n",
        truth.to_toml(),
        noise.reading_sd_m / METRES_PER_MICROMETRE,
        noise.zero_sd_m / METRES_PER_MICROMETRE,
        noise.run_slope_sd,
        noise.displacement_step_m / METRES_PER_MICROMETRE,
        noise.force_step_n
    )
}
