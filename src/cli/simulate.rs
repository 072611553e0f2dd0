//! `stiffbench simulate`.

use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

use clap::Args;

use stiffbench_document::Document;

use crate::bench::{
    Jack, LoadCasePlan, NoiseModel, NoiseShape, PositionPlan, SimulatedPositions, VirtualBench,
    simulate_load_cases, simulate_positions,
};
use crate::load_cases::write_load_cases;
use crate::physics::{Effect, Place};
use crate::procedure::Procedure;
use crate::quantity::METRES_PER_MICROMETRE;
use crate::readings::{InstrumentRecord, Instruments, SessionHeader, WrittenRows, write_rows};
use crate::report::{BESIDE_BEAMS, SimulationReport, TrackerReport, physics_document};
use crate::robot::{FittingFactors, ModelParameter};
use crate::test_point::Direction;

use super::args::ModelArgs;
use super::failure::refuse_given;
use super::figure_files::write;
use super::model::effects_text;
use super::numbers::{MOST_LOAD_CASES, count_up_to};
use super::option_values::{OptionValue, one_of};
use super::procedure::{AxesArgs, ProcedureArgs, resolve_procedure, single_loads};
use super::{CliError, Failure, Outcome};
use crate::analysis::{
    ArgumentError, Inputs, ResolvedModel, UnknownSprings, add_poses, refuse_unseen_laws, sha256,
    state_joint_values,
};
use crate::count::{counted, hours_and_minutes};

/// Size of the largest force of load cases unless --loads-n says, N: that of the procedures.
const LARGEST_FORCE_N: f64 = 70.0;

/// What is made in place of series of loads.
#[derive(Debug, Clone, Copy)]
enum CaseKind {
    /// This many load cases.
    LoadCases(usize),
    /// This many absolute positions.
    Positions(usize),
}

/// A simulated session before it is written.
struct Simulated {
    resolved: ResolvedModel,
    report: SimulationReport,
    /// `readings.csv`.
    readings: Vec<u8>,
    /// `session.toml`.
    header: String,
    /// `simulation.toml`: the truth, which an analysis must not see.
    record: String,
    /// What it holds, how long it takes, and what the record knows beside the factors, in words.
    words: [String; 3],
    warnings: Vec<String>,
}

/// Distribution of the errors.
const NOISE_SHAPES: [OptionValue<NoiseShape>; 2] = [
    ("normal", "Normal", NoiseShape::Normal),
    (
        "skewed",
        "Shifted gamma, the same standard deviation, skewness 1",
        NoiseShape::Skewed,
    ),
];

/// Arguments of `simulate`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench simulate my-session --seed 7\n  stiffbench simulate exact --noise-free\n  stiffbench simulate b --true-factor beam.Iy=0.006 --poses P1,P2 --procedure load-unload\n  stiffbench simulate c --procedure my-procedure.toml --repeats 3 --noise-distribution skewed\n  stiffbench simulate sticky --effect 'joint-friction@A3:c=0.1urad/(N*m),friction_moment=26N*m'\n  stiffbench simulate three-gauges --displacement-axes x,y,z --directions x,0,0.7071,0.7071"
)]
pub(super) struct SimulateArgs {
    /// Session folder to create; must not exist
    #[arg(value_name = "SESSION")]
    out: PathBuf,
    /// Robot, mechanism and factors (the true ones, unless --true-factor changes them).
    #[command(flatten)]
    model: ModelArgs,
    /// True value of a factor, for example beam.Iy=0.006
    #[arg(long, value_delimiter = ',', value_name = "FACTOR=VALUE")]
    true_factor: Vec<String>,
    /// Seed of the noise
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Standard deviation of a displacement reading, um
    #[arg(long, default_value_t = 3.0, allow_negative_numbers = true)]
    reading_sd_um: f64,
    /// Standard deviation of a gauge zero, um
    #[arg(long, default_value_t = 2.5, allow_negative_numbers = true)]
    zero_sd_um: f64,
    /// Standard deviation of the slope from run to run, relative
    #[arg(long, default_value_t = 0.004, allow_negative_numbers = true)]
    run_slope_sd: f64,
    /// Display step of the displacement gauge, um
    #[arg(long, default_value_t = 1.0, allow_negative_numbers = true)]
    displacement_step_um: f64,
    /// Display step of the force gauge, N
    #[arg(long, default_value_t = 0.1, allow_negative_numbers = true)]
    force_step_n: f64,
    /// Distribution of the errors
    #[arg(long, value_parser = one_of(NOISE_SHAPES), default_value = "normal")]
    noise_distribution: NoiseShape,
    /// Simulate without noise and without display steps
    #[arg(long)]
    noise_free: bool,
    /// Simulate this many load cases instead of series of loads: one load in any direction each, in random poses or those of --poses (docs/joint-stiffness.md)
    #[arg(long, value_name = "N", value_parser = count_up_to(MOST_LOAD_CASES))]
    load_cases: Option<usize>,
    /// Simulate this many absolute positions under the robot's own weight instead of series of loads, read by a tracker in an unknown place; with --loads-n every second position has a force
    #[arg(long, value_name = "N", value_parser = count_up_to(MOST_LOAD_CASES), conflicts_with = "load_cases")]
    positions: Option<usize>,
    /// Joints keep their state from one run of a pose and direction to the next [default: every run starts from the unloaded state]
    #[arg(long)]
    keep_history: bool,
    /// What is measured in which order; last, as its heading would go on.
    #[command(flatten)]
    procedure: ProcedureArgs,
    /// Where displacements are read.
    #[command(flatten)]
    axes: AxesArgs,
}

/// A session folder from a virtual bench.
pub(super) fn run(args: &SimulateArgs) -> Result<Outcome, Failure> {
    let load_cases = args.load_cases.map(CaseKind::LoadCases);
    let made = match load_cases.or(args.positions.map(CaseKind::Positions)) {
        Some(kind) => of_cases(args, kind)?,
        None => of_procedure(args)?,
    };
    create_new(&args.out)?;
    for (name, bytes) in [
        ("robot.toml", made.resolved.source.text.as_bytes()),
        ("readings.csv", &made.readings),
        ("session.toml", made.header.as_bytes()),
        ("simulation.toml", made.record.as_bytes()),
    ] {
        write(&args.out.join(name), bytes)?;
    }
    let folder = args.out.display();
    let [what, time, known] = made.words;
    let mut document = Document::of(format!("{folder}: {what}, seed {}", args.seed));
    document.append(physics_document(
        BESIDE_BEAMS,
        &made.resolved.physics.effects,
    ));
    document.paragraph(format!(
        "{time}session.toml, readings.csv, robot.toml and simulation.toml (true factors{known} and noise) written."
    ));
    document.next(format!("fit {folder}"));
    Ok(Outcome::new("simulate", document, made.report)
        .with_inputs(Inputs::default().with_model(&made.resolved))
        .with_warnings(made.warnings))
}

/// Series of loads by a procedure.
fn of_procedure(args: &SimulateArgs) -> Result<Simulated, Failure> {
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
    warnings.extend(rigid_springs);
    warnings.extend(resolved.warnings.iter().cloned());
    let mut readings = Vec::new();
    let rows = WrittenRows {
        of_vectors: several_gauges,
        ..WrittenRows::default()
    };
    write_rows(&table, rows, &mut readings)?;
    // A reading of several gauges is one.
    let count = table.readings.last().map_or(0, |last| last.seq as usize);
    let minutes = procedure.minutes(&jack.pace, n_poses);
    let what = format!(
        "{} of mechanism {} in {} and {} by procedure {}",
        counted(count, "reading"),
        resolved.mechanism,
        counted(n_poses, "pose"),
        counted(procedure.directions.len(), "direction"),
        procedure.name,
    );
    Ok(Simulated {
        header: header(args, &resolved, &procedure).to_toml(),
        record: simulation_record(args, &resolved, &truth, &noise, &procedure),
        report: SimulationReport {
            readings: count,
            procedure: procedure.name,
            minutes: minutes.round(),
            ..report(args, &resolved, truth, noise)
        },
        words: [
            what,
            format!(
                "On a real bench this takes about {}.\n",
                hours_and_minutes(minutes)
            ),
            ", physics".to_owned(),
        ],
        resolved,
        readings,
        warnings,
    })
}

/// Load cases or positions.
fn of_cases(args: &SimulateArgs, kind: CaseKind) -> Result<Simulated, Failure> {
    let option = match kind {
        CaseKind::LoadCases(_) => "--load-cases",
        CaseKind::Positions(_) => "--positions",
    };
    let mut resolved = args.model.resolve()?;
    resolved.factors = true_factors(args, &resolved)?;
    let help = |_: &str| format!("leave it out, or leave out {option}");
    let history = [("--keep-history", args.keep_history)];
    refuse_given(&history, "a load case has no history", help)?;
    let axes = [("--displacement-axes", args.axes.is_given())];
    refuse_given(&axes, "it belongs to series of loads", help)?;
    refuse_unseen_laws(&resolved, matches!(kind, CaseKind::Positions(_)))?;
    let (robot, physics) = (&resolved.robot, &resolved.physics);
    let truth = robot.with_own_springs(&resolved.factors);
    let warnings = [&resolved.warnings[..], &rigid_springs(&resolved, &truth)].concat();
    let noise = noise(args);
    let loads = single_loads(&args.procedure, option)?;
    let (mut table, tracker, words) = match kind {
        CaseKind::LoadCases(count) => {
            let largest_force_n = loads.largest_n.unwrap_or(LARGEST_FORCE_N);
            let plan = LoadCasePlan {
                count,
                largest_force_n,
                repeats: loads.repeats,
                poses: loads.poses,
            };
            let table = simulate_load_cases(robot, physics, &truth, &plan, &noise, args.seed)?;
            let words = format!("load cases up to {largest_force_n} N");
            (table, None, words)
        }
        CaseKind::Positions(count) => {
            let plan = PositionPlan {
                count,
                largest_force_n: loads.largest_n,
                repeats: loads.repeats,
                poses: loads.poses,
            };
            let SimulatedPositions { table, frames } =
                simulate_positions(robot, physics, &truth, &plan, &noise, args.seed)?;
            let forces = loads.largest_n.map_or_else(String::new, |force_n| {
                format!(" and forces up to {force_n} N")
            });
            let words = format!("positions under own weight{forces}");
            (table, Some(TrackerReport::from(&frames)), words)
        }
    };
    table.origin = Some(origin(args, &resolved));
    let mut record = truth_text(args.seed, &truth, &noise, [&effects_line(&resolved), ""]);
    if let Some(tracker) = &tracker {
        let _ = write!(
            record,
            "[tracker]\nbase_mm = {:?}\nrotation_vector_deg = {:?}\ntool_point_mm = {:?}\n",
            tracker.base_mm, tracker.rotation_vector_deg, tracker.tool_point_mm
        );
    }
    let what = format!(
        "{} {words} of mechanism {} in {} poses",
        table.cases.len(),
        resolved.mechanism,
        table.poses().len(),
    );
    let known = tracker.map_or("", |_| ", tracker");
    Ok(Simulated {
        header: usual_header(args, &resolved).to_load_case_toml(),
        record,
        report: SimulationReport {
            readings: table.component_count(),
            procedure: match kind {
                CaseKind::LoadCases(_) => "load cases".to_owned(),
                CaseKind::Positions(_) => "positions".to_owned(),
            },
            tracker,
            ..report(args, &resolved, truth, noise)
        },
        words: [what, String::new(), known.to_owned()],
        readings: write_load_cases(&table).into_bytes(),
        resolved,
        warnings,
    })
}

/// A simulated session without what depends on its form.
fn report(
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

/// The mark of readings that nobody measured.
fn origin(args: &SimulateArgs, resolved: &ResolvedModel) -> String {
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
fn rigid_springs(resolved: &ResolvedModel, truth: &FittingFactors) -> Vec<String> {
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

fn noise(args: &SimulateArgs) -> NoiseModel {
    if args.noise_free {
        return NoiseModel::NONE;
    }
    NoiseModel {
        reading_sd_m: args.reading_sd_um * METRES_PER_MICROMETRE,
        zero_sd_m: args.zero_sd_um * METRES_PER_MICROMETRE,
        run_slope_sd: args.run_slope_sd,
        displacement_step_m: args.displacement_step_um * METRES_PER_MICROMETRE,
        force_step_n: args.force_step_n,
        shape: args.noise_distribution,
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
fn usual_header(args: &SimulateArgs, resolved: &ResolvedModel) -> SessionHeader {
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
fn effects_line(resolved: &ResolvedModel) -> String {
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
fn truth_text(
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
