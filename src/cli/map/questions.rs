//! What `robot map` is asked beside the stiffness: a load at the end, the own weight, a design.

use std::path::Path;

use stiffbench_document::Document;

use crate::analysis::ArgumentError;
use crate::cli::figure_files::{write_figures, write_result};
use crate::cli::{Failure, Outcome};
use crate::distribution::{PoseSample, ShiftMap, StiffnessMap, design_sensitivity};
use crate::plot::Figure;
use crate::report::{
    MapAnswers, MapReport, Sensitivities, SensitivityReport, ShiftCause, ShiftReport, ShiftSummary,
    sensitivity_document,
};
use crate::robot::{JointModel, Masses, MechanismModel, Theory};

use super::args::Asked;
use super::files::{FILES, WantedFigures};
use super::job::MapStudy;

const MM: f64 = 1e-3;

/// Answers, one after the other.
pub(super) fn run(
    study: &MapStudy,
    poses: PoseSample,
    asked: &Asked,
    (out, wanted): (Option<&Path>, &WantedFigures),
    warnings: Vec<String>,
) -> Result<Outcome, Failure> {
    let poses = study.shown(poses);
    let mut about = study.report(&poses, Vec::new())?;
    about.cell = wanted.cell;
    let mut answer = QuestionResult::default();
    if let Some(load) = asked.load {
        let maps = study.of_each(|model| ShiftMap::under_load(model, &poses.set, load.0))?;
        let cause = ShiftCause::Load {
            load: load.0,
            limit_m: asked.limit.map(|limit| limit * MM),
        };
        answer.data.load = Some(answer.take(&about, cause, maps));
    }
    if asked.sag {
        let cause = ShiftCause::Weight(masses(study, &poses.set)?);
        let maps = study.of_each(|model| ShiftMap::under_weight(model, &poses.set))?;
        answer.data.sag = Some(answer.take(&about, cause, maps));
    }
    if asked.sensitivity {
        design(study, &poses.set, &mut answer)?;
    }
    let outcome = Outcome::new("map", answer.document, answer.data)
        .with_inputs(study.inputs())
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
    fn take(
        &mut self,
        about: &MapReport<'_>,
        cause: ShiftCause,
        maps: Vec<ShiftMap>,
    ) -> ShiftSummary {
        let report = ShiftReport { about, cause, maps };
        self.document.append(report.document());
        self.figures.extend(report.figures());
        report.summary()
    }
}

/// What is known of the masses of each mechanism, and their sum, kg.
fn masses(study: &MapStudy, poses: &PoseSample) -> Result<Vec<(Masses, f64)>, Failure> {
    let (robot, factors) = (&study.robot, &study.job.factors);
    let mut found = Vec::new();
    for physics in &study.physics {
        let mechanism = &physics.mechanism;
        let masses = Masses::of(robot, mechanism);
        let (joints, theory) = (JointModel::Rigid, Theory::EulerBernoulli);
        let mut model = MechanismModel::new(robot, mechanism, &joints, theory, factors)?;
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
    study: &MapStudy,
    poses: &PoseSample,
    answer: &mut QuestionResult,
) -> Result<(), Failure> {
    let of_axes = study.of_each(|model| -> Result<_, Failure> {
        let map = StiffnessMap::over(model, poses, &study.job.columns)?;
        let along = |axis| design_sensitivity(model, &map, poses, axis);
        Ok([along(0)?, along(1)?, along(2)?])
    })?;
    let mut sensitivities = Vec::new();
    for (physics, of_axes) in study.physics.iter().zip(of_axes) {
        let name = &physics.mechanism.name;
        for found in of_axes.into_iter().flatten() {
            answer.document.append(sensitivity_document(name, &found));
            sensitivities.push(SensitivityReport::new(name, &found));
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
