//! The bench on which a procedure is to be followed.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Deserializer, Serialize};
use stiffbench_beams::physics::{Effect, Law, Place, TestObject, title};
use stiffbench_beams::robot::{FittingFactors, Mechanism, Robot};
use stiffbench_measurement::procedure::Pace;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use crate::mismatch::baselines::Baseline;
use crate::mismatch::error::MismatchError;
use crate::mismatch::observed::{GaugeNoise, GaugeSteps, Observations, ReadingNoise};

/// Scatter of a reading on a bench of which nothing is known yet, m: a dial gauge with a step of 10 µm, read to 6 µm, √(6² + 10²/12). Stated.
const USUAL_READING_SD_M: f64 = 6.66e-6;

/// Scatter of its zero, m. Stated.
const USUAL_ZERO_SD_M: f64 = 5e-6;

/// Relative scatter of its slope from run to run (1): how well the fixture seats. Stated.
const USUAL_RUN_SLOPE_SD: f64 = 5e-3;

/// Noise of a bench of which nothing is known yet.
///
/// That of a dial gauge in a fixture.
pub const USUAL_NOISE: ReadingNoise = ReadingNoise {
    reading_sd_m: USUAL_READING_SD_M,
    zero_sd_m: USUAL_ZERO_SD_M,
    run_slope_sd: USUAL_RUN_SLOPE_SD,
    growth_sd: 0.0,
    correlation: 0.0,
    gauges: GaugeNoise::ALIKE,
};

/// A law at a place.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, JsonSchema)]
pub struct LawAtPlace {
    /// The law.
    #[serde(rename = "physics")]
    pub law: Law,
    /// The place.
    pub place: Place,
}

/// Of several laws of one name the first that acts at such a place.
impl<'de> Deserialize<'de> for LawAtPlace {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        struct NamedPlace {
            physics: Law,
            place: Place,
        }
        let NamedPlace { physics, place } = NamedPlace::deserialize(deserializer)?;
        let mut laws = Law::named(physics.name);
        let law = laws.find(|law| place.clone().of(law.place_kind).kind() == law.place_kind);
        let law = law.unwrap_or(physics);
        let place = place.of(law.place_kind);
        Ok(Self { law, place })
    }
}

impl From<&Effect> for LawAtPlace {
    fn from(effect: &Effect) -> Self {
        Self {
            law: effect.law,
            place: effect.place.clone(),
        }
    }
}

impl fmt::Display for LawAtPlace {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&title(self.law, &self.place))
    }
}

/// The bench on which a procedure is to be followed.
#[derive(Clone, Copy)]
pub struct DesignBench<'a> {
    /// The structure; it knows [`DesignBench::poses`], in that order.
    pub baseline: &'a dyn Baseline,
    /// The poses at hand.
    pub poses: &'a [PoseId],
    /// Those of them that may be proposed for a measurement.
    pub may_be_measured: &'a [PoseId],
    /// Values of the baseline's parameters; those it starts from if `None`.
    pub parameters: Option<&'a [f64]>,
    /// Noise of the readings.
    pub noise: ReadingNoise,
    /// Steps of the gauges.
    pub steps: GaugeSteps,
    /// How fast the operator works.
    pub pace: Pace,
    /// What is loaded.
    pub object: TestObject,
}

impl DesignBench<'_> {
    /// Whether it is of a part without a robot file.
    pub(super) fn is_of_part(&self) -> bool {
        self.object != TestObject::Robot
    }

    /// Directions in which it can be loaded: a part has one.
    pub(super) fn directions(&self) -> &'static [Direction] {
        if self.is_of_part() {
            &[Direction::X]
        } else {
            &Direction::ALL
        }
    }

    /// Places of the poses that may be measured: those that were, and the others.
    pub(super) fn measured_and_further(&self, done: &Observations) -> [Vec<usize>; 2] {
        let measured = |pose: &usize| done.cells.iter().any(|cell| cell.pose == *pose);
        let may_be = |pose: &usize| self.may_be_measured.contains(&self.poses[*pose]);
        let (old, new) = (0..self.poses.len()).filter(may_be).partition(measured);
        [old, new]
    }

    /// Poses by their names.
    pub(super) fn named(&self, poses: &[usize]) -> Vec<PoseId> {
        poses.iter().map(|&pose| self.poses[pose].clone()).collect()
    }

    /// Observations with the poses numbered as the baseline does.
    pub(super) fn in_order(
        &self,
        observations: &Observations,
    ) -> Result<Observations, MismatchError> {
        let mut out = observations.clone();
        for cell in &mut out.cells {
            let pose = &observations.poses[cell.pose];
            let place = self.poses.iter().position(|known| known == pose);
            cell.pose = place.ok_or_else(|| MismatchError::UnknownPose {
                pose: pose.to_string(),
                known: self.poses.iter().map(PoseId::to_string).collect(),
            })?;
        }
        out.poses = self.poses.to_vec();
        Ok(out)
    }
}

/// Poses in which a next measurement can be made: those measured, and behind them the robot's other named ones that this mechanism can
/// hold.
#[must_use]
pub fn poses_at_hand(
    robot: &Robot,
    mechanism: &Mechanism,
    factors: &FittingFactors,
    measured: &[PoseId],
) -> Vec<PoseId> {
    let mut poses = measured.to_vec();
    for named in &robot.poses {
        let solved = || {
            let pose = std::slice::from_ref(&named.pose);
            stiffbench_beams::physics::Mechanics::new(robot, mechanism, factors, pose).is_ok()
        };
        if !poses.contains(&named.id) && solved() {
            poses.push(named.id.clone());
        }
    }
    poses
}
