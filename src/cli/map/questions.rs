//! What `robot map` is asked beside the stiffness: a load at the end, the own weight, a design.

use std::path::Path;

use stiffbench_document::Document;

use crate::analysis::ArgumentError;
use crate::cli::failure::Failure;
use crate::cli::figure_files::{write_figures, write_result};
use crate::cli::outcome::Outcome;
use crate::distribution::{
    PoseSample, Shard, ShiftMap, StiffnessMap, StudyPoses, design_sensitivity,
};
use crate::physics::ActingPhysics;
use crate::plot::Figure;
use crate::report::{
    MapAnswers, Sensitivities, SensitivityReport, ShiftCause, ShiftReport, ShiftSummary,
    sensitivity_document,
};
use crate::robot::{JointModel, Masses, MechanismModel, Robot, Theory};

use super::args::Asked;
use super::files::{FILES, WantedFigures};
use super::job::MapJob;

const MM: f64 = 1e-3;

/// Answers, one after the other.
pub(super) fn run(
    job: &MapJob,
    asked: &Asked,
    (out, wanted): (Option<&Path>, WantedFigures),
    warnings: Vec<String>,
) -> Result<Outcome, Failure> {
    let robot = job.robot()?;
    let physics = job.physics(&robot)?;
    let poses = job.pose_set(&robot, Shard::WHOLE)?;
    let poses = StudyPoses::new(poses, job.sampling, job.plane(&robot));
    let mut about = job.report(&robot, &physics, &poses, Vec::new())?;
    about.cell = wanted.cell;
    let mut answer = QuestionResult::default();
    if let Some(load) = asked.load {
        let maps = maps(job, &robot, &physics, |model| {
            ShiftMap::under_load(model, &poses.set, load.0)
        })?;
        let cause = ShiftCause::Load {
            load: load.0,
            limit_m: asked.limit.map(|limit| limit * MM),
        };
        answer.data.load = Some(answer.take(&ShiftReport {
            about: &about,
            cause,
            maps,
        }));
    }
    if asked.sag {
        let masses = masses(job, &robot, &physics, &poses.set)?;
        let maps = maps(job, &robot, &physics, |model| {
            ShiftMap::under_weight(model, &poses.set)
        })?;
        let cause = ShiftCause::Weight(masses);
        answer.data.sag = Some(answer.take(&ShiftReport {
            about: &about,
            cause,
            maps,
        }));
    }
    if asked.sensitivity {
        design(job, (&robot, &physics), &poses.set, &mut answer)?;
    }
    let outcome = Outcome::new("map", answer.document, answer.data)
        .with_inputs(job.inputs(&robot))
        .with_warnings(warnings);
    let mut written = Vec::new();
    if let Some(folder) = &wanted.folder {
        written = write_figures(folder, answer.figures, &outcome.inputs)?;
    }
    if let Some(folder) = out {
        written.extend(write_result(folder, FILES, &outcome)?);
    }
    Ok(outcome.with_written(&written))
}

/// What was found, for people, for programs, and as figures.
#[derive(Default)]
struct QuestionResult {
    document: Document,
    data: MapAnswers,
    figures: Vec<(String, Figure)>,
}

impl QuestionResult {
    fn take(&mut self, report: &ShiftReport<'_>) -> ShiftSummary {
        self.document.append(report.document());
        self.figures.extend(report.figures());
        report.summary()
    }
}

/// A map of each mechanism.
fn maps<T, E: Into<Failure>>(
    job: &MapJob,
    robot: &Robot,
    physics: &[ActingPhysics],
    of: impl Fn(&crate::distribution::MapModel<'_>) -> Result<T, E>,
) -> Result<Vec<T>, Failure> {
    let of_one = |physics: &ActingPhysics| -> Result<T, Failure> {
        of(&job.model(robot, physics)?).map_err(Into::into)
    };
    physics.iter().map(of_one).collect()
}

/// What is known of the masses of each mechanism, and their sum, kg.
fn masses(
    job: &MapJob,
    robot: &Robot,
    physics: &[ActingPhysics],
    poses: &PoseSample,
) -> Result<Vec<(Masses, f64)>, Failure> {
    let mut found = Vec::new();
    for physics in physics {
        let mechanism = &physics.mechanism;
        let masses = Masses::of(robot, mechanism);
        let (joints, theory) = (JointModel::Rigid, Theory::EulerBernoulli);
        let mut model = MechanismModel::new(robot, mechanism, &joints, theory, &job.factors)?;
        model.place(&poses.pose(0))?;
        found.push((masses, model.mass_kg()));
    }
    if found.iter().all(|(masses, _)| masses.is_empty()) {
        return ArgumentError::refuse(
            "--sag",
            format!(
                "{} has no masses, so nothing is known of its weight",
                robot.name
            ),
            "give its sections mass_per_m (kg/m) or their material a density (kg/m3), and nodes with motors or tools a mass under [masses]: docs/robot-file.md, Masses",
        );
    }
    Ok(found)
}

/// Sensitivities along every axis that is mapped.
fn design(
    job: &MapJob,
    (robot, physics): (&Robot, &[ActingPhysics]),
    poses: &PoseSample,
    answer: &mut QuestionResult,
) -> Result<(), Failure> {
    let mut sensitivities = Vec::new();
    for physics in physics {
        let model = job.model(robot, physics)?;
        let name = &model.mechanism().name;
        let map = StiffnessMap::over(&model, poses, &job.columns)?;
        for axis in 0..3 {
            if let Some(found) = design_sensitivity(&model, &map, poses, axis)? {
                answer.document.append(sensitivity_document(name, &found));
                sensitivities.push(SensitivityReport::new(name, &found));
            }
        }
    }
    if sensitivities.is_empty() {
        return ArgumentError::refuse(
            "--sensitivity",
            "laws that are not linear have no derivatives, and neither have directions that are no axes".to_owned(),
            "leave out the law, or name an axis, for example --directions y",
        );
    }
    answer.data.design = Some(Sensitivities { sensitivities });
    Ok(())
}
