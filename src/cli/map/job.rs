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

/// The plane of coordinates; of reach and height without them.
pub(super) fn plane_of(axes: Option<[PlaneAxis; 2]>, robot: &Robot) -> MapPlane {
    let upright = MapPlane::upright(robot.vertical);
    axes.map_or(upright, |axes| MapPlane::new(axes, robot.vertical))
}

/// A study with what its record stands for.
pub(super) struct MapStudy {
    pub(super) job: MapJob,
    pub(super) robot: Robot,
    /// The physics of each mechanism.
    pub(super) physics: Vec<ActingPhysics>,
}

impl MapStudy {
    /// Reads robot and effects of the record.
    pub(super) fn new(job: MapJob) -> Result<Self, Failure> {
        let source = SourceText::new(job.robot_file.clone(), job.robot_text.clone());
        let robot = Robot::parse(&source)?;
        let of = |job: &MechanismJob| -> Result<ActingPhysics, Failure> {
            let effects: Result<Vec<Effect>, _> =
                job.effects.iter().map(|text| text.parse()).collect();
            let mechanism = robot.mechanism(Some(&job.name))?;
            Ok(ActingPhysics::new(&robot, mechanism, effects?)?)
        };
        Ok(Self {
            physics: job.mechanisms.iter().map(of).collect::<Result<_, _>>()?,
            robot,
            job,
        })
    }

    /// What results are made of.
    pub(super) fn inputs(&self) -> Inputs {
        let model = Inputs::default()
            .with_robot(&self.robot, &self.job.robot_text)
            .with_factors(&self.job.factors_name, &self.job.factors);
        let mechanisms = self.job.mechanisms.iter();
        mechanisms.fold(model, |inputs, mechanism| {
            inputs.with_mechanism(&mechanism.name)
        })
    }

    /// The poses of a share.
    pub(super) fn pose_set(&self, shard: Shard) -> Result<PoseSample, Failure> {
        let plan = PosePlan {
            sampling: self.job.sampling,
            poses: self.job.poses,
            seed: self.job.seed,
            held: self.job.held.clone(),
        };
        Ok(PoseSample::draw(&self.robot, &plan, shard)?)
    }

    /// Poses over the plane in which the map is shown.
    pub(super) fn shown(&self, poses: PoseSample) -> StudyPoses {
        let plane = plane_of(self.job.plane, &self.robot);
        StudyPoses::new(poses, self.job.sampling, plane)
    }

    /// A mechanism ready to be solved.
    fn model<'a>(&'a self, physics: &'a ActingPhysics) -> Result<MapModel<'a>, Failure> {
        let (factors, at_load_n) = (&self.job.factors, self.job.at_load_n);
        let model = MapModel::new(&self.robot, physics, factors, at_load_n)?;
        model.check(&self.job.columns)?;
        Ok(model)
    }

    /// What `of` makes of each mechanism. All mechanisms are ready before the first: what cannot be done is said at once.
    pub(super) fn of_each<T, E: Into<Failure>>(
        &self,
        of: impl Fn(&MapModel<'_>) -> Result<T, E>,
    ) -> Result<Vec<T>, Failure> {
        let models = self.physics.iter().map(|physics| self.model(physics));
        let models = models.collect::<Result<Vec<_>, _>>()?;
        models
            .iter()
            .map(|model| of(model).map_err(Into::into))
            .collect()
    }

    /// All that is said of the maps.
    pub(super) fn report<'a>(
        &'a self,
        poses: &'a StudyPoses,
        maps: Vec<StiffnessMap>,
    ) -> Result<MapReport<'a>, Failure> {
        let mut mechanisms = Vec::new();
        for (physics, map) in self.physics.iter().zip(maps) {
            let model = self.model(physics)?;
            let study = MechanismStudy::of(&model, map, poses, self.job.covariance.as_ref())?;
            let effects = physics.effects.iter().map(ToString::to_string).collect();
            debug_assert_eq!(physics.mechanism.name, study.map.mechanism);
            mechanisms.push((effects, study));
        }
        Ok(MapReport {
            robot: &self.robot,
            factors_name: self.job.factors_name.clone(),
            seed: self.job.seed,
            poses,
            mechanisms,
            at_load_n: self.job.at_load_n,
            cell: None,
        })
    }
}
