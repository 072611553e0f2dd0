//! Stiffness of the fitted model over the workspace, for a report.

use schemars::JsonSchema;
use serde::Serialize;

use crate::distribution::{
    MapColumn, MapModel, MapPlane, MechanismStudy, NoMap, PosePlan, PoseSample, Sampling, Shard,
    StiffnessMap, StudyPoses, WorkspaceError, variables_beside_the_plane,
};
use crate::fit::FactorEstimate;
use crate::physics::{ActingPhysics, Effect, EffectError};
use crate::quantity::NEWTON_PER_METRE_PER_NEWTON_PER_MICROMETRE as N_PER_UM;
use crate::report::MapReport;
use crate::report::text::{or_dash, significant};
use crate::robot::{FittingFactors, Robot, RobotError};
use crate::test_point::Direction;

use super::figures::page_figure;
use super::{PageFigure, ReportPage};

/// Poses of the map: enough for a picture, few enough for a page.
const POSES: usize = 600;
/// Digits of a stiffness.
const DIGITS: usize = 3;

/// Stiffness of the fitted model over the workspace.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
pub struct PageMap {
    /// How many poses, how they were chosen, and what is in the model.
    pub about: String,
    /// One row a direction.
    pub rows: Vec<PageMapRow>,
}

/// Stiffness in one direction over the poses as printed, N/µm.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct PageMapRow {
    /// The direction.
    pub direction: String,
    /// The smallest.
    pub smallest: String,
    /// 5 % of the poses lie below.
    pub quantile_5: String,
    /// Half of the poses lie below.
    pub median: String,
    /// 95 % of the poses lie below.
    pub quantile_95: String,
    /// The largest.
    pub largest: String,
}

/// Why there is no map.
#[derive(Debug, thiserror::Error)]
enum NoPageMap {
    #[error(transparent)]
    Robot(#[from] RobotError),
    #[error(transparent)]
    Effect(#[from] EffectError),
    #[error(transparent)]
    Poses(#[from] WorkspaceError),
    #[error(transparent)]
    Map(#[from] NoMap),
    #[error("the model takes none of the {POSES} poses")]
    Empty,
}

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
            page.map = Some(map);
            page.figures.map = figures;
        }
        Err(error) => page.leave_out("Stiffness over the workspace", &error),
    }
}

/// Numbers and figures of the stiffness along some directions, and along the weakest one where the model is linear.
fn workspace_map(
    model: &MappedModel<'_>,
    directions: &[Direction],
    seed: u64,
) -> Result<(PageMap, Vec<PageFigure>), NoPageMap> {
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
        return Err(NoPageMap::Empty);
    }
    let poses = StudyPoses::new(poses, plan.sampling, plane);
    let study = MechanismStudy::of(&solved, map, &poses, None)?;
    let rows = study.columns.iter().map(|found| {
        let words = |si: f64| significant(si / N_PER_UM, DIGITS);
        let quantile = |share: f64| {
            let own = found.statistics.quantiles.iter();
            let mut own = own.filter(|quantile| quantile.share == share);
            or_dash(own.next(), |q| words(q.stiffness_n_per_m))
        };
        PageMapRow {
            direction: if found.column.is_principal() {
                "weakest".to_owned()
            } else {
                found.column.name().to_owned()
            },
            smallest: words(found.statistics.smallest.stiffness_n_per_m),
            quantile_5: quantile(0.05),
            median: quantile(0.5),
            quantile_95: quantile(0.95),
            largest: words(found.statistics.largest.stiffness_n_per_m),
        }
    });
    let rows = rows.collect();
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
    Ok((PageMap { about, rows }, figures.collect()))
}
