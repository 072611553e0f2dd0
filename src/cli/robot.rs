//! `stiffbench robot`.

use stiffbench_document::{Document, Table, numbers, words};

use crate::distribution::{Extreme, MapPlane, RefinedExtreme, WorkspacePlan, WorkspaceSample};
use crate::physics::ActingPhysics;
use crate::plot::Figure;
use crate::report::{
    ComplianceReport, MechanismRank, MobilityReport, OutermostPoint, RobotReport, WorkspaceReport,
    plane_column_heads, robot_check_document, workspace_figure,
};
use crate::robot::{
    JointModel, Mechanism, Predictor, Robot, RobotError, Theory, chain_mobility, mobility,
};
use crate::structure::Compliance6;

use super::args::Global;
use super::failure::Failure;
use super::figure_files::write_figure;
use super::outcome::Outcome;
use super::pose_args::limits_passed;
use super::robot_args::{
    ComplianceArgs, RobotArgs, RobotCheckArgs, RobotCommand, ShowArgs, WorkspaceArgs,
};
use super::robot_new::new_robot;
use super::robot_pose;
use crate::analysis::{ArgumentError, Inputs, UnknownSprings, check_robot, robot_source};

/// Looks at a robot.
pub(super) fn run(args: RobotArgs, global: &Global) -> Result<Outcome, Failure> {
    match args.what {
        RobotCommand::Show(args) => show(&args),
        RobotCommand::Check(args) => check(&args, global),
        RobotCommand::New(args) => new_robot(&args),
        RobotCommand::Workspace(args) => workspace(&args),
        RobotCommand::Compliance(args) => compliance(&args),
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
fn check(args: &RobotCheckArgs, global: &Global) -> Result<Outcome, Failure> {
    let source = robot_source(&args.robot, None)?;
    let robot = Robot::parse(&source)?;
    let inputs = Inputs::default().with_robot(&robot, &source.text);
    let check = check_robot(&robot, &source)?;
    let drawn = robot_pose::draw(&robot, &inputs, args, global)?;
    let text = format!("{}{}", drawn.sketch, robot_check_document(&check).text());
    let strict = u8::from(!check.findings.is_empty());
    let findings = check.findings.clone();
    Ok(Outcome::new("robot-check", text, check)
        .with_inputs(inputs)
        .with_warnings(findings)
        .with_written(&drawn.written)
        .with_strict_exit(strict))
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

/// Random poses and the outermost points.
pub(super) struct SampledWorkspace {
    sample: WorkspaceSample,
    extremes: Vec<(&'static str, Option<RefinedExtreme>)>,
    stated: Vec<(String, [f64; 2])>,
}

/// Samples the workspace of the complete robot, all variables free.
pub(super) fn workspace_projection(
    robot: &Robot,
    poses: usize,
    seed: u64,
) -> Result<SampledWorkspace, Failure> {
    project(
        robot,
        &WorkspacePlan {
            poses,
            seed,
            vertical: robot.vertical,
            ..WorkspacePlan::paper()
        },
    )
}

fn project(robot: &Robot, plan: &WorkspacePlan) -> Result<SampledWorkspace, Failure> {
    let mechanism = robot.mechanism(None)?;
    let sample = WorkspaceSample::draw(robot, mechanism, plan)?;
    let points = sample.points.iter();
    let extremes = Extreme::of_points(points.map(|point| [point.reach_m, point.height_m]))
        .into_iter()
        .map(|extreme| {
            let refined = sample.refined_extreme(robot, mechanism, extreme)?;
            Ok((extreme.word(), refined))
        })
        .collect::<Result<_, RobotError>>()?;
    let stated = robot
        .poses
        .iter()
        .filter_map(|named| Some((named.id.to_string(), named.stated_zy_m?)))
        .collect();
    Ok(SampledWorkspace {
        sample,
        extremes,
        stated,
    })
}

impl SampledWorkspace {
    /// The projection as a figure.
    pub(super) fn figure(&self, robot: &Robot) -> Figure {
        let points = self
            .sample
            .points
            .iter()
            .map(|point| [point.reach_m, point.height_m])
            .collect();
        let extremes = self.extremes.iter().filter_map(|(name, extreme)| {
            let point = &extreme.as_ref()?.point;
            Some(((*name).to_owned(), [point.reach_m, point.height_m]))
        });
        workspace_figure(points, extremes.collect(), self.stated.clone(), robot)
    }

    fn document(&self, robot: &Robot) -> Document {
        let sample = &self.sample;
        let angles = robot.variables.iter().map(|v| numbers(&v.name));
        let plane = MapPlane::upright(self.sample.plan.vertical);
        let ends = plane_column_heads(&plane).map(|head| numbers(format!("{head}, m")));
        let columns = [words("extreme")].into_iter().chain(ends).chain(angles);
        let mut rows = Table::new(columns.chain([words("held by")]));
        for (name, extreme) in &self.extremes {
            let Some(extreme) = extreme else { continue };
            let head = [
                (*name).to_owned(),
                format!("{:.4}", extreme.point.reach_m),
                format!("{:.4}", extreme.point.height_m),
            ];
            let angles = extreme
                .point
                .pose
                .angles_deg
                .iter()
                .map(|angle| format!("{angle:.3}"));
            rows.row(
                head.into_iter()
                    .chain(angles)
                    .chain([extreme.limits.join(", ")]),
            );
        }
        let mut document = Document::of(format!(
            "{} poses within the limits of {} drawn (seed {}), {} of them not reachable.",
            sample.accepted(),
            sample.drawn,
            sample.plan.seed,
            sample.unreachable.len(),
        ));
        document.table(rows);
        if !self.stated.is_empty() {
            document.table(
                Table::of(&self.stated)
                    .words("stated by the paper", |(name, _)| name)
                    .numbers("z, m", |(_, [z, _])| *z)
                    .numbers("y, m", |(_, [_, y])| *y),
            );
        }
        document
    }

    fn report(&self) -> WorkspaceReport {
        let outermost = |extreme: &RefinedExtreme| OutermostPoint {
            position_m: extreme.point.position_m,
            reach_m: extreme.point.reach_m,
            height_m: extreme.point.height_m,
            angles_deg: extreme.point.pose.angles_deg.clone(),
            limits: extreme.limits.clone(),
        };
        let extremes = self.extremes.iter();
        WorkspaceReport {
            poses: self.sample.accepted(),
            drawn: self.sample.drawn,
            acceptance_rate: self.sample.acceptance_rate(),
            unreachable: self.sample.unreachable.len(),
            seed: self.sample.plan.seed,
            extremes: extremes
                .map(|(name, extreme)| ((*name).to_owned(), extreme.as_ref().map(outermost)))
                .collect(),
        }
    }
}

fn workspace(args: &WorkspaceArgs) -> Result<Outcome, Failure> {
    let (robot, inputs) = read(&args.robot)?;
    let mut plan = WorkspacePlan {
        poses: args.samples,
        seed: args.seed,
        vertical: robot.vertical,
        ..WorkspacePlan::paper()
    };
    if let Some(vary) = &args.vary {
        for name in vary {
            robot.variable(name)?;
        }
        plan.held = robot
            .variables
            .iter()
            .map(|v| v.name.clone())
            .filter(|name| !vary.contains(name))
            .collect();
    }
    let projection = project(&robot, &plan)?;
    let figure = args.figure.iter();
    let written = figure.map(|path| write_figure(path, &projection.figure(&robot), &inputs));
    let written: Vec<_> = written.collect::<Result<_, _>>()?;
    Ok(Outcome::new(
        "robot-workspace",
        projection.document(&robot),
        projection.report(),
    )
    .with_inputs(inputs)
    .with_warnings(robot.warnings.clone())
    .with_written(written.iter().flatten()))
}

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
    let mut model = args.model.clone();
    if args.shown.is_some() {
        model.robot.clone_from(&args.shown);
    }
    let resolved = model.resolve()?;
    let robot = &resolved.robot;
    let pose = args.pose.pose(robot)?;
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
    let compliance = physics.with_base(&fixed, predictor.model());
    let known = unknown.known(compliance.0, &pose)?;
    let report = ComplianceReport::new(known, predictor.model(), physics);
    Ok(Outcome::new("robot-compliance", report.document(), report)
        .with_inputs(Inputs::default().with_model(&resolved))
        .with_warnings(warnings))
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
