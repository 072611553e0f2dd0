//! Stiffness of the fitted model over the workspace, for a report.

use stiffbench_document::{Document, NoteKind};

use crate::analysis::Failure;
use crate::distribution::{
    MapColumn, MapModel, MapPlane, MechanismStudy, PosePlan, PoseSample, Sampling, Shard,
    StiffnessMap, StudyPoses, variables_beside_the_plane,
};
use crate::fit::FactorEstimate;
use crate::physics::{ActingPhysics, Effect};
use crate::report::MapReport;
use crate::report::map::statistics_table;
use crate::robot::{FittingFactors, Robot};
use crate::test_point::Direction;

use super::figures::page_figure;
use super::{PageFigure, ReportPage};

/// Poses of the map: enough for a picture, few enough for a page.
const POSES: usize = 600;

/// Why there is no map, though the model acts.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
#[error("the model takes none of the {POSES} poses")]
struct NoPoseOfMap;

/// A fitted model.
pub(super) struct MappedModel<'a> {
    pub(super) robot: &'a Robot,
    pub(super) mechanism: &'a str,
    /// With the springs that were fitted.
    pub(super) factors: &'a FittingFactors,
    /// What acts beside the beams.
    pub(super) effects: &'a [Effect],
    pub(super) estimates: &'a [FactorEstimate],
    /// Load at which laws that are not linear are taken, N.
    pub(super) at_load_n: f64,
}

/// Adds the map of a fitted model to a report, or why there is none.
pub(super) fn add_map(page: &mut ReportPage, model: &MappedModel<'_>, directions: &[Direction]) {
    match workspace_map(model, directions, page.settings.seed) {
        Ok((map, figures)) => {
            page.map = map;
            page.figures.map = figures;
        }
        Err(failure) => page.leave_out("Stiffness over the workspace", &failure),
    }
}

/// Numbers and figures of the stiffness along some directions, and along the weakest one where the model is linear.
fn workspace_map(
    model: &MappedModel<'_>,
    directions: &[Direction],
    seed: u64,
) -> Result<(Document, Vec<PageFigure>), Failure> {
    let robot = model.robot;
    let mechanism = robot.mechanism(Some(model.mechanism))?;
    let factors = robot.with_own_springs(model.factors);
    let of_robot = model.effects.iter();
    let of_robot = of_robot.filter(|effect| effect.law.place_kind.is_of_robot());
    let effects: Vec<Effect> = of_robot
        .cloned()
        .chain(Effect::of_springs(&factors))
        .collect();
    let is_linear = !effects.iter().any(|effect| effect.law.is_nonlinear_joint());
    let plane = MapPlane::upright(robot.vertical);
    let plan = PosePlan {
        sampling: Sampling::LowDiscrepancy,
        poses: POSES,
        seed,
        held: variables_beside_the_plane(robot, mechanism, &plane)?,
    };
    let poses = PoseSample::draw(robot, &plan, Shard::WHOLE)?;
    let axes = MapColumn::axes().into_iter().zip(Direction::ALL);
    let mut columns: Vec<MapColumn> = axes
        .filter(|(_, direction)| directions.contains(direction))
        .map(|(column, _)| column)
        .collect();
    if is_linear {
        columns.push(MapColumn::Principal(0));
    }
    let physics = ActingPhysics::new(robot, mechanism, effects)?;
    let at_load_n = (!is_linear).then_some(model.at_load_n);
    let solved = MapModel::new(robot, &physics, &factors.without_springs(), at_load_n)?;
    let map = StiffnessMap::over(&solved, &poses, &columns)?;
    if map.is_empty() {
        return Err(NoPoseOfMap.into());
    }
    let poses = StudyPoses::new(poses, plan.sampling, plane);
    let study = MechanismStudy::of(&solved, map, &poses, None)?;
    let rows = study.columns.iter();
    let rows = rows.map(|found| (found.column.name(), found));
    let mut text = Document::of(
        "Predicted by the fitted model, in N/µm. What the readings show beyond this model is not in it.",
    );
    text.table(statistics_table("direction", rows, false));
    let report = MapReport {
        robot,
        factors_name: "fitted".to_owned(),
        seed,
        poses: &poses,
        mechanisms: vec![(Vec::new(), study)],
        at_load_n,
        cell: None,
    };
    let mut about = report.about();
    let open = model.estimates.iter();
    let open = open.filter(|estimate| estimate.status.why_open().is_some());
    let open: Vec<&str> = open.map(|estimate| estimate.name.as_str()).collect();
    if !open.is_empty() {
        about = format!(
            "{about} The readings do not determine {}: away from the measured poses the map is uncertain.",
            open.join(", ")
        );
    }
    let mut figures = report.figures();
    if is_linear {
        // The weakest direction first: of a full page the last are left out.
        figures.rotate_right(1);
    }
    let figures = figures
        .iter()
        .map(|(name, figure)| page_figure(name, figure));
    text.note(NoteKind::Remark, about);
    Ok((text, figures.collect()))
}
