//! What to measure: before a session what a procedure can show, after one what separates the laws that it left open.

use crate::fit::{PoseRules, usual_parameters};
use crate::mismatch::{
    DesignBench, DesignReport, Diagnosis, GaugeSteps, Line, NextMeasurement, Observations,
    RobotBaseline, USUAL_NOISE, design_of_plan, next_measurements, poses_at_hand,
};
use crate::parameters::ParameterChoice;
use crate::physics::TestObject;
use crate::procedure::{Pace, Procedure};
use crate::readings::SessionHeader;
use crate::robot::{FittingFactors, GRAVITY_M_PER_S2, Masses, Mechanism, Pose, Robot};
use crate::test_point::{Branch, Direction, PoseId};

use super::error::Failure;
use super::model::ResolvedModel;
use super::procedure::{named_procedure, state_joint_values};

/// Steps of the gauges of a bench of which nothing is known yet: a dial gauge of 10 µm, a force gauge of a tenth of a newton.
const USUAL_STEPS: GaugeSteps = GaugeSteps {
    force_n: Some(0.1),
    displacement_m: Some(1e-5),
};

/// What a procedure would show on a bench of which nothing is known yet: with the usual noise and a dial gauge of 10 µm.
///
/// # Arguments
/// - `model`: robot and mechanism; the procedure's poses, else all that are named and can be measured.
/// - `parameters`: which parameters of the model are free.
/// - `seed`: of the simulated noise.
///
/// # Errors
/// For poses that the robot does not have, or a procedure that shows nothing.
pub fn design(
    model: &ResolvedModel,
    procedure: Procedure,
    parameters: &ParameterChoice,
    seed: u64,
) -> Result<DesignReport, Failure> {
    let mechanism = model.mechanism()?;
    let measured = procedure.poses.clone().unwrap_or_default();
    let poses = poses_at_hand(&model.robot, mechanism, &model.factors, &measured);
    let baseline = baseline(model, mechanism, &poses, parameters, 0.0)?;
    let procedure = Procedure {
        poses: Some(procedure.poses.unwrap_or_else(|| poses.clone())),
        ..procedure
    };
    usual_bench(&baseline, &poses, &procedure, seed)
}

fn usual_bench(
    baseline: &RobotBaseline<'_>,
    poses: &[PoseId],
    procedure: &Procedure,
    seed: u64,
) -> Result<DesignReport, Failure> {
    let bench = DesignBench {
        baseline,
        poses,
        may_be_measured: poses,
        parameters: None,
        noise: USUAL_NOISE,
        steps: USUAL_STEPS,
        pace: Pace::default(),
        object: TestObject::Robot,
    };
    Ok(design_of_plan(&bench, procedure, seed)?)
}

/// What a shipped procedure can show on a mechanism in its named poses, on a bench of which nothing is known yet.
///
/// # Errors
/// For a mechanism or procedure that is not there, or a plan that shows nothing.
pub fn usual_plan(
    robot: &Robot,
    mechanism: &str,
    procedure: &str,
    seed: u64,
) -> Result<DesignReport, Failure> {
    let (procedure, _) = named_procedure(procedure)?;
    let poses: Vec<PoseId> = robot.poses.iter().map(|named| named.id.clone()).collect();
    let placed: Vec<Pose> = robot.poses.iter().map(|named| named.pose.clone()).collect();
    let (_, factors) = robot.default_factors();
    let mechanism = robot.mechanism(Some(mechanism))?;
    let baseline = RobotBaseline::new(
        robot,
        mechanism,
        factors,
        placed,
        &usual_parameters(robot, mechanism),
        0.0,
    )?;
    let procedure = Procedure {
        poses: Some(poses.clone()),
        ..procedure
    };
    usual_bench(&baseline, &poses, &procedure, seed)
}

/// Measurements that are proposed.
#[derive(Debug, Default)]
pub(super) struct Proposals {
    pub(super) next: Vec<NextMeasurement>,
    /// The procedures to be written beside them: file name and text.
    pub(super) files: Vec<(String, String)>,
    /// What their poses keep and which are left out for it, if rules are stated.
    pub(super) note: Option<String>,
}

/// Plans that separate what a diagnosis left open, with the procedures to be written beside it.
///
/// # Arguments
/// - `found`: values of the parameters with what was found.
/// - `rules`: what is stated of the poses that may be proposed.
pub(super) fn proposals(
    model: &ResolvedModel,
    header: Option<&SessionHeader>,
    done: &Observations,
    (diagnosis, found): (&Diagnosis, &FittingFactors),
    (parameters, rules): (&ParameterChoice, &PoseRules),
) -> Result<Proposals, Failure> {
    let mechanism = model.mechanism()?;
    // Planned are loads and displacements.
    if done.tracker.is_some() {
        return Ok(Proposals::default());
    }
    let poses = poses_at_hand(&model.robot, mechanism, &model.factors, &done.poses);
    let (may_be, within) = rules.of_known((&model.robot, mechanism), &poses, &done.poses);
    let measured = done.largest_m_per_n(0.0);
    let baseline = baseline(model, mechanism, &poses, parameters, measured)?;
    let fitted = baseline.fitted_values(found);
    let bench = DesignBench {
        baseline: &baseline,
        poses: &poses,
        may_be_measured: &may_be,
        parameters: Some(&fitted),
        noise: diagnosis.noise,
        steps: done.steps,
        pace: Pace::default(),
        object: TestObject::Robot,
    };
    let record = header.and_then(|header| header.procedure.as_ref());
    let base = record
        .and_then(|record| Procedure::from_record(record).ok())
        .unwrap_or_default();
    let mut next = next_measurements(&bench, done, diagnosis, &base)?;
    let mut files: Vec<(String, String)> = Vec::new();
    let filed = Robot::parse(&model.source).ok();
    let is_filed = |pose: &PoseId| filed.as_ref().is_some_and(|robot| robot.pose(pose).is_ok());
    for proposal in &mut next {
        // Poses of a table are not in the robot file.
        if let Some(procedure) = &mut proposal.procedure
            && !procedure.poses.iter().flatten().all(is_filed)
        {
            state_joint_values(&model.robot, procedure)?;
        }
        proposal.file = proposal.procedure.as_ref().map(|procedure| {
            let text = procedure.to_toml();
            // The same procedure is written once.
            let known = files.iter().position(|(_, written)| *written == text);
            let place = known.unwrap_or(files.len());
            let name = format!("next-{}.toml", place + 1);
            if known.is_none() {
                files.push((name.clone(), text));
            }
            name
        });
    }
    let left_out: Vec<&str> = poses
        .iter()
        .filter(|pose| !may_be.contains(pose))
        .map(PoseId::as_str)
        .collect();
    let rules = [
        (!within.words().is_empty()).then(|| format!("keep {}", within.words())),
        (!left_out.is_empty()).then(|| format!("are not {}", left_out.join(", "))),
    ];
    let rules: Vec<String> = rules.into_iter().flatten().collect();
    let note = (!rules.is_empty() && !next.is_empty()).then(|| {
        format!(
            "proposed measurements are in measured and named poses that {}",
            rules.join(" and ")
        )
    });
    Ok(Proposals { next, files, note })
}

/// Plans that separate what the diagnosis of a part left open, in words.
pub(super) fn proposals_for_part(
    line: &Line,
    done: &Observations,
    diagnosis: &Diagnosis,
) -> Result<Vec<NextMeasurement>, Failure> {
    /// Steps of a plan up to the largest load.
    const STEPS: u32 = 10;
    /// How near to its target a load comes, as a share of the largest.
    const TOLERANCE: f64 = 0.005;
    let loads = || done.loads.iter().map(|load| load.force_n);
    let [low, high] = [loads().fold(0.0, f64::min), loads().fold(0.0, f64::max)];
    let largest = high.max(-low);
    let ends = [high, low].into_iter();
    let ends = ends.filter(|end| end.abs() > largest / f64::from(STEPS));
    let steps = |end: f64| (1..=STEPS).map(move |step| end * f64::from(step) / f64::from(STEPS));
    let mut base = Procedure {
        loads_n: std::iter::once(0.0).chain(ends.flat_map(steps)).collect(),
        directions: vec![Direction::X.into()],
        unloading: done
            .readings
            .iter()
            .any(|one| one.branch == Branch::Unloading),
        preload_n: 0.0,
        ..Procedure::default()
    };
    base.settle.force_tolerance_n = TOLERANCE * largest;
    // What the model leaves comes again where the same readings are made again.
    let mut noise = diagnosis.noise;
    noise.reading_sd_m = noise.reading_sd_m.max(diagnosis.after.rms_m);
    let bench = DesignBench {
        baseline: line,
        poses: &done.poses,
        may_be_measured: &done.poses,
        parameters: Some(&diagnosis.parameters),
        noise,
        steps: done.steps,
        pace: Pace::default(),
        object: done.object,
    };
    Ok(next_measurements(&bench, done, diagnosis, &base)?)
}

/// The same for readings, those of a tracker among them.
pub(super) fn baseline_of<'a>(
    model: &'a ResolvedModel,
    observations: &Observations,
    poses: &[PoseId],
    parameters: &ParameterChoice,
) -> Result<RobotBaseline<'a>, Failure> {
    let mechanism = model.mechanism()?;
    let masses = Masses::of(&model.robot, mechanism).at_nodes;
    let mass_kg: f64 = masses.iter().map(|(_, mass_kg)| mass_kg).sum();
    let measured = observations.largest_m_per_n(GRAVITY_M_PER_S2 * mass_kg);
    let mut baseline = baseline(model, mechanism, poses, parameters, measured)?;
    baseline.add_variant(&model.physics.effects)?;
    if let Some(frames) = &observations.tracker {
        baseline.track(frames)?;
    }
    Ok(baseline)
}

/// The beam model of a resolved model in these poses, where so much was measured per force (m/N).
pub(super) fn baseline<'a>(
    model: &'a ResolvedModel,
    mechanism: &Mechanism,
    poses: &[PoseId],
    parameters: &ParameterChoice,
    measured_m_per_n: f64,
) -> Result<RobotBaseline<'a>, Failure> {
    let placed = poses
        .iter()
        .map(|pose| model.robot.pose(pose).cloned())
        .collect::<Result<Vec<Pose>, _>>()?;
    let factors = model.start_of_fit(parameters);
    Ok(RobotBaseline::new(
        &model.robot,
        mechanism,
        factors,
        placed,
        parameters,
        measured_m_per_n,
    )?)
}
