//! What a study is, as one record: with it any share of the study can be computed, anywhere, and shares of other studies are distinguished.

use serde::{Deserialize, Serialize};

use crate::analysis::Inputs;
use crate::cli::failure::Failure;
use crate::distribution::{
    FittedCovariance, MapColumn, MapModel, MapPlane, MatrixKind, MechanismStudy, PlaneAxis,
    PosePlan, PoseSample, Sampling, Shard, StiffnessMap, StudyPoses,
};
use crate::physics::{ActingPhysics, Effect};
use crate::report::MapReport;
use crate::robot::{FittingFactors, Robot};
use crate::source_text::SourceText;

/// Schema of shard files, whose first line this is.
pub(super) const SCHEMA: &str = "stiffbench/map-shard/1";

/// A study: everything its numbers depend on.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct MapJob {
    pub(super) schema: String,
    /// Version of the program: another one may round otherwise.
    pub(super) version: String,
    pub(super) robot_file: String,
    pub(super) robot_text: String,
    pub(super) factors_name: String,
    pub(super) factors: FittingFactors,
    pub(super) covariance: Option<FittedCovariance>,
    pub(super) at_load_n: Option<f64>,
    pub(super) mechanisms: Vec<MechanismJob>,
    pub(super) sampling: Sampling,
    pub(super) poses: usize,
    pub(super) seed: u64,
    pub(super) held: Vec<String>,
    pub(super) columns: Vec<MapColumn>,
    /// The coordinates of the plane; `None` for reach and height.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) plane: Option<[PlaneAxis; 2]>,
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) matrix: Option<MatrixKind>,
}

/// A mechanism of a study with the effects that act in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct MechanismJob {
    pub(super) name: String,
    pub(super) effects: Vec<String>,
}

impl MapJob {
    /// What results are made of.
    pub(super) fn inputs(&self, robot: &Robot) -> Inputs {
        let model = Inputs::default()
            .with_robot(robot, &self.robot_text)
            .with_factors(&self.factors_name, &self.factors);
        let mechanisms = self.mechanisms.iter();
        mechanisms.fold(model, |inputs, mechanism| {
            inputs.with_mechanism(&mechanism.name)
        })
    }

    /// The robot.
    pub(super) fn robot(&self) -> Result<Robot, Failure> {
        Ok(Robot::parse(&SourceText::new(
            self.robot_file.clone(),
            self.robot_text.clone(),
        ))?)
    }

    /// The plane over which the map is shown.
    pub(super) fn plane(&self, robot: &Robot) -> MapPlane {
        let upright = MapPlane::upright(robot.vertical);
        self.plane
            .map_or(upright, |axes| MapPlane::new(axes, robot.vertical))
    }

    /// The poses of a share.
    pub(super) fn pose_set(&self, robot: &Robot, shard: Shard) -> Result<PoseSample, Failure> {
        let plan = PosePlan {
            sampling: self.sampling,
            poses: self.poses,
            seed: self.seed,
            held: self.held.clone(),
        };
        Ok(PoseSample::draw(robot, &plan, shard)?)
    }

    /// The physics of each mechanism.
    pub(super) fn physics(&self, robot: &Robot) -> Result<Vec<ActingPhysics>, Failure> {
        let of = |job: &MechanismJob| -> Result<ActingPhysics, Failure> {
            let effects: Result<Vec<Effect>, _> =
                job.effects.iter().map(|text| text.parse()).collect();
            let mechanism = robot.mechanism(Some(&job.name))?;
            Ok(ActingPhysics::new(robot, mechanism, effects?)?)
        };
        self.mechanisms.iter().map(of).collect()
    }

    /// A mechanism ready to be solved.
    pub(super) fn model<'a>(
        &self,
        robot: &'a Robot,
        physics: &'a ActingPhysics,
    ) -> Result<MapModel<'a>, Failure> {
        let model = MapModel::new(robot, physics, &self.factors, self.at_load_n)?;
        model.check(&self.columns)?;
        Ok(model)
    }

    /// The maps of all mechanisms.
    ///
    /// # Arguments
    /// - `mapped`: called after each mechanism.
    pub(super) fn maps(
        &self,
        robot: &Robot,
        physics: &[ActingPhysics],
        poses: &PoseSample,
        mapped: &dyn Fn(),
    ) -> Result<Vec<StiffnessMap>, Failure> {
        // All models before the first map: what cannot be done is said at once.
        let models: Vec<MapModel<'_>> = physics
            .iter()
            .map(|physics| self.model(robot, physics))
            .collect::<Result<_, Failure>>()?;
        let maps = models.iter().map(|model| {
            let map = StiffnessMap::with_matrix(model, poses, &self.columns, self.matrix);
            mapped();
            map
        });
        Ok(maps.collect::<Result<_, _>>()?)
    }

    /// All that is said of the maps.
    pub(super) fn report<'a>(
        &self,
        robot: &'a Robot,
        physics: &'a [ActingPhysics],
        poses: &'a StudyPoses,
        maps: Vec<StiffnessMap>,
    ) -> Result<MapReport<'a>, Failure> {
        let mut mechanisms = Vec::new();
        for ((physics, job), map) in physics.iter().zip(&self.mechanisms).zip(maps) {
            let model = self.model(robot, physics)?;
            let study = MechanismStudy::of(&model, map, poses, self.covariance.as_ref())?;
            let effects = physics.effects.iter().map(ToString::to_string).collect();
            debug_assert_eq!(job.name, study.map.mechanism);
            mechanisms.push((effects, study));
        }
        Ok(MapReport {
            robot,
            factors_name: self.factors_name.clone(),
            seed: self.seed,
            poses,
            mechanisms,
            at_load_n: self.at_load_n,
            cell: None,
        })
    }
}
