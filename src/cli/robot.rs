//! `stiffbench robot`.

use std::path::{Path, PathBuf};

use clap::{Args, Subcommand};

use crate::physics::{ActingPhysics, Effect, PlaceKind};
use crate::plot::robot_pose;
use crate::report::{
    ComplianceReport, MechanismRank, MobilityReport, RobotReport, pose_drawing,
    robot_check_document, robot_figure, with_equal_views,
};
use crate::robot::{
    FittingFactors, JointModel, Mechanism, MechanismModel, Predictor, Robot, RobotError, Theory,
    chain_mobility, mobility,
};
use crate::structure::Compliance6;

use super::args::RobotModelArgs;
use super::figure_files::{file_part, write_figures};
use super::map::{self, MapArgs};
use super::numbers::three_numbers;
use super::pose_args::{PoseArgs, limits_passed};
use super::robot_export::{self, RobotExportArgs};
use super::robot_new::{NewArgs, new_robot};
use super::significance::{self, SignificanceArgs};
use super::{Failure, Global, Outcome};
use crate::analysis::{ArgumentError, Inputs, UnknownSprings, check_robot, robot_source};

/// Arguments of `robot`.
#[derive(Debug, Args)]
#[command(
    after_help = "Examples:\n  stiffbench robot show\n  stiffbench robot check my-robot.toml --figures drawn\n  stiffbench robot compliance --pose P1 --set theta2=390 --mechanism F --json\n  stiffbench robot map --samples 5000 --out maps\n  stiffbench robot show --schema > robot.schema.json"
)]
pub(super) struct RobotArgs {
    /// What to look at.
    #[command(subcommand)]
    what: RobotCommand,
}

/// Subcommands of `robot`.
#[derive(Debug, Subcommand)]
pub(super) enum RobotCommand {
    /// Print bodies, mechanisms, variables, poses and factor sets, or the mobility, or the schema of robot files
    Show(ShowArgs),
    /// Check a robot file in every mechanism and pose: size, mass, stiffness, warnings
    Check(RobotCheckArgs),
    /// Create a robot file from a URDF, a Denavit-Hartenberg table or a template
    New(NewArgs),
    /// Compute the 6 x 6 compliance of the end in a pose
    Compliance(ComplianceArgs),
    /// Map the stiffness over the workspace of each mechanism: statistics, regions of high and low stiffness, the paper's Tables VII to X
    Map(Box<MapArgs>),
    /// Rank the section constants by their effect in each direction (the paper's Table III)
    Significance(SignificanceArgs),
    /// Write the robot with its springs, friction and play for a simulator, or its parameters and compliance as a table
    Export(Box<RobotExportArgs>),
}

/// Arguments of `robot check`.
#[derive(Debug, Args)]
pub(super) struct RobotCheckArgs {
    /// Name of a shipped robot, or a robot file
    robot: String,
    /// Draw every pose into this folder (SVG and PNG)
    #[arg(long, value_name = "FOLDER")]
    figures: Option<PathBuf>,
}

/// Arguments of `robot show`.
#[derive(Debug, Args)]
pub(super) struct ShowArgs {
    /// Name of a shipped robot, or a robot file [default: hp-robot]
    #[arg(value_name = "ROBOT")]
    robot: Option<String>,
    /// Print the mobility instead: degrees of freedom by the paper's eqs. (1) to (5), and by the rank of the closure conditions
    #[arg(long)]
    mobility: bool,
    /// Print the JSON Schema of the format of this robot file instead; without a file, that of stiffbench/robot/2
    #[arg(long, conflicts_with = "mobility")]
    schema: bool,
}

/// Arguments of `robot compliance`.
#[derive(Debug, Args)]
pub(super) struct ComplianceArgs {
    /// Robot, mechanism and factors.
    #[command(flatten)]
    model: RobotModelArgs,
    /// Which pose.
    #[command(flatten)]
    pose: PoseArgs,
    /// Let joints turn freely unless a drive or brake locks them
    #[arg(long)]
    pinned: bool,
    /// Include the shear deformation of beams
    #[arg(long)]
    timoshenko: bool,
    /// Load at the end for the secant compliance of nonlinear joints and the geometric stiffness of an arm of rigid links: force along x, y and z, N [default: the smallest]
    #[arg(long, value_name = "FX,FY,FZ", value_parser = three_numbers, allow_hyphen_values = true)]
    load: Option<[f64; 3]>,
    /// Draw the robot in the pose into this folder, displaced by the load of --load (50 N downward without it)
    #[arg(long, value_name = "FOLDER")]
    figures: Option<PathBuf>,
}

/// Looks at a robot.
pub(super) fn run(args: &RobotArgs, global: &Global) -> Result<Outcome, Failure> {
    match &args.what {
        RobotCommand::Show(args) => show(args),
        RobotCommand::Check(args) => check(args),
        RobotCommand::New(args) => new_robot(args),
        RobotCommand::Compliance(args) => compliance(args),
        RobotCommand::Map(args) => map::run(args, global),
        RobotCommand::Significance(args) => significance::run(args),
        RobotCommand::Export(args) => robot_export::run(args),
    }
}

/// The robot, its mobility, or the schema of robot files.
fn show(args: &ShowArgs) -> Result<Outcome, Failure> {
    let named = args.robot.as_deref();
    if args.schema {
        let source = named.map(|name| robot_source(name, None)).transpose()?;
        let schema = source.map_or_else(crate::robot::format2::json_schema, |source| {
            crate::robot::schema_of(&source)
        });
        let text = format!("{schema:#}\n");
        return Ok(Outcome::new("robot-schema", text, schema));
    }
    let (robot, inputs) = read(named.unwrap_or("hp-robot"))?;
    if args.mobility {
        return Ok(show_mobility(&robot)?.with_inputs(inputs));
    }
    let report = RobotReport::new(&robot);
    Ok(Outcome::new("robot", report.document(), report)
        .with_inputs(inputs)
        .with_warnings(robot.warnings.clone()))
}

fn read(name: &str) -> Result<(Robot, Inputs), Failure> {
    let source = robot_source(name, None)?;
    let robot = Robot::parse(&source)?;
    let inputs = Inputs::default().with_robot(&robot, &source.text);
    Ok((robot, inputs))
}

/// Tries every mechanism in every named pose (the nominal one if there is none).
fn check(args: &RobotCheckArgs) -> Result<Outcome, Failure> {
    let source = robot_source(&args.robot, None)?;
    let robot = Robot::parse(&source)?;
    let inputs = Inputs::default().with_robot(&robot, &source.text);
    let check = check_robot(&robot, &source)?;
    let drawn = args.figures.iter();
    let drawn = drawn.map(|folder| draw_poses(&robot, &inputs, folder));
    let drawn = drawn.collect::<Result<Vec<_>, _>>()?.concat();
    let document = robot_check_document(&check);
    let strict = u8::from(!check.findings.is_empty());
    let findings = check.findings.clone();
    Ok(Outcome::new("robot-check", document, check)
        .with_inputs(inputs)
        .with_warnings(findings)
        .with_written(&drawn)
        .with_strict_exit(strict))
}

/// Draws every named pose that can be taken (the nominal one if none has a name) into a folder; the others are findings of the check.
fn draw_poses(robot: &Robot, inputs: &Inputs, folder: &Path) -> Result<Vec<PathBuf>, Failure> {
    let mechanism = robot.mechanism(None)?;
    let (joints, theory) = (JointModel::Rigid, Theory::EulerBernoulli);
    let mut model = MechanismModel::new(robot, mechanism, &joints, theory, &FittingFactors::UNIT)?;
    let (mut names, mut drawings) = (Vec::new(), Vec::new());
    for (name, pose) in robot.poses_or_nominal() {
        if model.place(&pose).is_ok() {
            drawings.push(pose_drawing(&model, &name));
            names.push(format!("pose-{}", file_part(&name)));
        }
    }
    with_equal_views(&mut drawings);
    let inputs = inputs.clone().with_mechanism(&mechanism.name);
    let figures = names.into_iter().zip(drawings.iter().map(robot_pose));
    write_figures(folder, figures.collect(), &inputs)
}

fn show_mobility(robot: &Robot) -> Result<Outcome, Failure> {
    let pose = robot
        .poses
        .first()
        .map_or_else(|| robot.nominal_pose(), |named| named.pose.clone());
    let chains = chain_mobility(robot, &pose)?;
    let rank = |mechanism: &Mechanism| {
        Ok(MechanismRank {
            mechanism: mechanism.name.clone(),
            rank_check: mobility(robot, mechanism, &pose)?,
        })
    };
    let mechanisms: Result<_, RobotError> = robot.mechanisms.values().map(rank).collect();
    let report = MobilityReport::new(chains, mechanisms?);
    Ok(Outcome::new("robot-mobility", report.document(), report)
        .with_warnings(robot.warnings.clone()))
}

/// Load under which a robot is drawn if no other is named: force along x, y and z, N.
const DRAWN_LOAD_N: [f64; 3] = [0.0, -50.0, 0.0];

/// Compliance where it was placed; of an arm of rigid links with the load's own term.
fn under_load(
    predictor: &mut Predictor<'_>,
    [fx, fy, fz]: [f64; 3],
) -> Result<Compliance6, Failure> {
    let structure = predictor.model().structure();
    if !structure.is_serial() {
        return Ok(predictor.compliance());
    }
    let mechanism = &predictor.model().mechanism().name;
    let loaded = structure
        .compliance_under_load([fx, fy, fz, 0.0, 0.0, 0.0])
        .map_err(|source| RobotError::Structure {
            mechanism: mechanism.clone(),
            source,
        })?;
    loaded.ok_or_else(|| {
        ArgumentError::new(
            format!("--load {fx},{fy},{fz}"),
            "the joints give way under this load: the arm is not stable there",
            "--load 0,-50,0",
        )
        .into()
    })
}

fn compliance(args: &ComplianceArgs) -> Result<Outcome, Failure> {
    let resolved = args.model.model().resolve()?;
    let robot = &resolved.robot;
    let chosen = args.pose.chosen(robot)?;
    let (name, pose) = chosen.unwrap_or_else(|| ("nominal".to_owned(), robot.nominal_pose()));
    let unknown = UnknownSprings::of(&resolved);
    unknown.refuse(&pose)?;
    let mut warnings = resolved.warnings.clone();
    warnings.extend(unknown.words());
    warnings.extend(limits_passed(robot, &pose));
    let physics = &resolved.physics;
    let joints = if args.pinned {
        refuse_laws_of_free_joints(physics)?;
        JointModel::Pinned
    } else {
        let force_n = args.load.unwrap_or_default();
        physics.joints_under(robot, &resolved.factors, &pose, force_n)?
    };
    warnings.extend(physics.of_the_bench().map(|effect| {
        format!("{effect}: of the bench, not of the robot, and not in its compliance")
    }));
    let theory = if args.timoshenko {
        Theory::Timoshenko
    } else {
        Theory::EulerBernoulli
    };
    let mut predictor = Predictor::with(
        robot,
        &physics.mechanism,
        &joints,
        theory,
        &physics.with_springs(&resolved.factors),
    )?;
    predictor.place(&pose)?;
    let fixed = match args.load {
        Some(force_n) => under_load(&mut predictor, force_n)?,
        None => predictor.compliance(),
    };
    let inputs = Inputs::default().with_model(&resolved);
    let mut drawn = Vec::new();
    if let Some(folder) = &args.figures {
        let not_drawn = physics.effects.iter().filter(|effect| is_at_rest(effect));
        warnings.extend(not_drawn.map(|effect| format!("{effect}: not drawn")));
        let figure = robot_figure(&mut predictor, &name, args.load.unwrap_or(DRAWN_LOAD_N));
        drawn = write_figures(folder, vec![("robot", figure)], &inputs)?;
    }
    let compliance = physics.with_base(&fixed, predictor.model());
    let known = unknown.known(compliance.0, &pose)?;
    let report = ComplianceReport::new(known, predictor.model(), physics);
    Ok(Outcome::new("robot-compliance", report.document(), report)
        .with_inputs(inputs)
        .with_warnings(warnings)
        .with_written(&drawn))
}

/// Whether an effect is left out of the drawing of a robot: it is none of a joint or a beam.
fn is_at_rest(effect: &Effect) -> bool {
    let kind = effect.law.place_kind;
    let is_drawn = matches!(kind, PlaceKind::Joint | PlaceKind::Element)
        || effect.spring_of_structure().is_some();
    !is_drawn
}

/// A joint that turns freely has no law.
fn refuse_laws_of_free_joints(physics: &ActingPhysics) -> Result<(), ArgumentError> {
    match physics.effects.iter().find(|e| e.law.is_of_a_joint()) {
        None => Ok(()),
        Some(effect) => Err(ArgumentError::new(
            "--pinned",
            format!("{} says how its joint moves", effect.title()),
            "leave out --pinned, or the effect",
        )),
    }
}
