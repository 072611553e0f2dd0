//! The outermost points of a workspace: found in a sample, then exactly.

use stiffbench_beams::robot::{Mechanism, Pose, Robot, RobotError};

use super::pose_set::free_variables;
use super::projected_ascent::{AscentObjective, ProjectedAscent};
use super::workspace::{EndPlacer, EndPoint, WorkspaceSample};

/// Step of the differences that give slopes, degrees: their truncation is then near 1e-15 m a degree, their rounding near 1e-12.
const STEP_DEG: f64 = 1e-4;

/// A slope below this is flat, m per degree: what is left to gain then lies far below a nanometre.
const FLAT_M_PER_DEG: f64 = 1e-9;

/// Reach or height that varies by less than this share of the other is constant: what is left is rounding.
const CONSTANT: f64 = 1e-6;

/// One of the four outermost points that enclose a workspace (the paper's P1 to P4).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Extreme {
    /// Largest height (P1).
    Highest,
    /// Largest reach (P2).
    Furthest,
    /// Smallest height (P3).
    Lowest,
    /// Smallest reach (P4).
    Nearest,
}

impl Extreme {
    /// All four, in the paper's order.
    pub const ALL: [Self; 4] = [Self::Highest, Self::Furthest, Self::Lowest, Self::Nearest];

    /// What is largest at this point, m.
    fn value_m(self, point: &EndPoint) -> f64 {
        self.of_reach_and_height([point.reach_m, point.height_m])
    }

    /// What is largest at the point with this reach and height, or these two coordinates of another plane, m.
    #[must_use]
    pub fn of_reach_and_height(self, [reach_m, height_m]: [f64; 2]) -> f64 {
        match self {
            Self::Highest => height_m,
            Self::Furthest => reach_m,
            Self::Lowest => -height_m,
            Self::Nearest => -reach_m,
        }
    }

    /// Those along which points (reach and height, m) differ at all: an end that keeps its height has no highest place.
    pub fn of_points(points: impl Iterator<Item = [f64; 2]>) -> Vec<Self> {
        let none = [f64::INFINITY, f64::NEG_INFINITY];
        let ranges = points.fold([none; 2], |ranges, point| {
            [0, 1].map(|i| [ranges[i][0].min(point[i]), ranges[i][1].max(point[i])])
        });
        let [reach, height] = ranges.map(|[low, high]| high - low);
        let least = CONSTANT * reach.max(height);
        let differs = |extreme: &Self| match extreme {
            Self::Highest | Self::Lowest => height > least,
            Self::Furthest | Self::Nearest => reach > least,
        };
        Self::ALL.into_iter().filter(differs).collect()
    }

    /// What it is called.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Highest => "highest",
            Self::Furthest => "furthest",
            Self::Lowest => "lowest",
            Self::Nearest => "nearest",
        }
    }
}

/// An outermost point, refined from a point of a sample.
#[derive(Debug, Clone, PartialEq)]
pub struct RefinedExtreme {
    /// The point.
    pub point: EndPoint,
    /// The limits that hold it, in words, for example `theta2 <= 397.44`.
    pub limits: Vec<String>,
    /// Steepest way on that the limits leave, m per degree: below 1e-9 the point is exact.
    pub slope_m_per_deg: f64,
}

impl WorkspaceSample {
    /// The outermost point of the sample itself; `None` if it has no point.
    #[must_use]
    pub fn extreme(&self, extreme: Extreme) -> Option<&EndPoint> {
        let value = |point: &&EndPoint| extreme.value_m(point);
        self.points
            .iter()
            .max_by(|a, b| value(a).total_cmp(&value(b)))
    }

    /// The outermost point of the workspace next to that of the sample: uphill along the limits until none of them lets it go on.
    ///
    /// Rosen's gradient projection (Journal of the Society for Industrial and Applied Mathematics 8 (1960) 181): all limits are
    /// linear in the angles. The sample is to be dense enough to have found the right hill; what is found here is then exact.
    ///
    /// # Errors
    /// [`RobotError`] if the mechanism cannot be built or a pose on the way cannot be taken: where loops stop closing before any
    /// limit is met, the extreme has no slope to follow. `None` if the sample has no point.
    pub fn refined_extreme(
        &self,
        robot: &Robot,
        mechanism: &Mechanism,
        extreme: Extreme,
    ) -> Result<Option<RefinedExtreme>, RobotError> {
        let Some(start) = self.extreme(extreme) else {
            return Ok(None);
        };
        let free = free_variables(robot, &self.plan.held)?;
        let objective = Outermost {
            extreme,
            place: EndPlacer::new(robot, mechanism, &self.plan)?,
        };
        let (mut objective, top) =
            ProjectedAscent::ascend(robot, free, objective, start.pose.clone())?;
        Ok(Some(RefinedExtreme {
            point: objective.place.end_point(top.pose)?,
            limits: top.limits,
            slope_m_per_deg: top.slope_per_deg,
        }))
    }
}

/// Height, reach or their opposites, m.
struct Outermost<'a> {
    extreme: Extreme,
    place: EndPlacer<'a>,
}

impl AscentObjective for Outermost<'_> {
    const STEP_DEG: f64 = STEP_DEG;
    const FLAT_PER_DEG: f64 = FLAT_M_PER_DEG;

    fn height(&mut self, pose: &Pose) -> Result<f64, RobotError> {
        let point = self.place.end_point(pose.clone())?;
        Ok(self.extreme.value_m(&point))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::distribution::workspace::WorkspacePlan;
    use stiffbench_test_files::shipped_robot;

    fn shipped(name: &str) -> Robot {
        Robot::parse(&shipped_robot(name).unwrap()).unwrap()
    }

    /// The paper's sample of 30 000 poses, and what its stated points P1 to P4 are near to.
    #[test]
    fn extremes_of_the_paper() {
        let robot = shipped("hp-robot");
        let mechanism = robot.mechanism(Some("F")).unwrap();
        let plan = WorkspacePlan::paper().holding(&["theta1", "theta4"]);
        let sample = WorkspaceSample::draw(&robot, mechanism, &plan).unwrap();
        // Reach and height of the exact extremes and the angles there, worked from eqs. (9) and (10); and the stated points. On the
        // coupled limit reach is largest where 0.776 sin theta2 + 0.420 sin theta3 = 0: the end is then as high as A3, 0.890 m.
        type Case<'a> = (Extreme, [f64; 4], [f64; 2], &'a [&'a str]);
        let expected: [Case<'_>; 4] = [
            (
                Extreme::Highest,
                [1.6375, 1.2318, 397.44, 341.97],
                [1.638, 1.229],
                &["theta2 <= 397.44", "theta3 <= 341.97"],
            ),
            (
                Extreme::Furthest,
                [1.7075, 0.8900, 377.7939, 325.6239],
                [1.7076, 0.901],
                &["theta2 - theta3 >= 52.17"],
            ),
            (
                Extreme::Lowest,
                [1.5350, 0.3942, 352.51, 290.0],
                [1.538, 0.396],
                &["theta2 >= 352.51", "theta3 >= 290"],
            ),
            (
                Extreme::Nearest,
                [1.3818, 0.9671, 397.44, 290.0],
                [1.384, 0.966],
                &["theta2 <= 397.44", "theta3 >= 290"],
            ),
        ];
        for (extreme, [reach, height, theta2, theta3], stated, limits) in expected {
            let refined = sample
                .refined_extreme(&robot, mechanism, extreme)
                .unwrap()
                .unwrap();
            let found = &refined.point;
            assert!(refined.slope_m_per_deg < 1e-9, "{refined:?}");
            assert_eq!(refined.limits, limits);
            assert!((found.reach_m - reach).abs() < 6e-5, "{found:?}");
            assert!((found.height_m - height).abs() < 6e-5, "{found:?}");
            assert!(
                (found.pose.angles_deg[1] - theta2).abs() < 6e-4,
                "{found:?}"
            );
            assert!(
                (found.pose.angles_deg[2] - theta3).abs() < 6e-4,
                "{found:?}"
            );
            assert!(robot.violated_limits(&found.pose).is_empty());
            // The sample comes near, as the paper's did, and never beyond.
            let sampled = sample.extreme(extreme).unwrap();
            let gain = extreme.value_m(found) - extreme.value_m(sampled);
            assert!((0.0..4e-3).contains(&gain), "{extreme:?}: {gain}");
            let value = match extreme {
                Extreme::Highest | Extreme::Lowest => found.height_m - stated[1],
                Extreme::Furthest | Extreme::Nearest => found.reach_m - stated[0],
            };
            assert!(value.abs() < 4e-3, "{extreme:?}: {value}");
        }
    }

    /// A turning waist changes neither reach nor height, so that the extremes stay.
    #[test]
    fn free_waist_and_fourth_axis_change_nothing() {
        let robot = shipped("hp-robot");
        let mechanism = robot.mechanism(Some("F")).unwrap();
        let plan = WorkspacePlan {
            poses: 2_000,
            ..WorkspacePlan::paper()
        };
        let sample = WorkspaceSample::draw(&robot, mechanism, &plan).unwrap();
        for (extreme, value) in [
            (Extreme::Highest, 1.2318),
            (Extreme::Furthest, 1.7075),
            (Extreme::Lowest, -0.3942),
            (Extreme::Nearest, -1.3818),
        ] {
            let refined = sample
                .refined_extreme(&robot, mechanism, extreme)
                .unwrap()
                .unwrap();
            assert!(
                (extreme.value_m(&refined.point) - value).abs() < 6e-5,
                "{refined:?}"
            );
        }
    }

    /// The serial arm reaches furthest stretched out level, in the inside of its limits: h = 0.55 m, l = 0.55 + 0.48 + 0.20 m.
    #[test]
    fn an_extreme_inside_the_limits() {
        let robot = shipped("serial-arm");
        let mechanism = robot.mechanism(None).unwrap();
        let plan = WorkspacePlan {
            poses: 3_000,
            ..WorkspacePlan::paper()
        };
        let sample = WorkspaceSample::draw(&robot, mechanism, &plan).unwrap();
        // theta2 >= 10 keeps the first link from the level: the others are.
        let refined = sample
            .refined_extreme(&robot, mechanism, Extreme::Furthest)
            .unwrap()
            .unwrap();
        let expected = 0.55 * 10.0_f64.to_radians().cos() + 0.68;
        assert!(
            (refined.point.reach_m - expected).abs() < 1e-9,
            "{refined:?}"
        );
        assert_eq!(refined.limits, ["theta2 >= 10"]);
        // Upright as far as the limits let it: 90 is inside theta2, 40 and 30 are the ends of the others.
        let refined = sample
            .refined_extreme(&robot, mechanism, Extreme::Highest)
            .unwrap()
            .unwrap();
        let expected =
            0.40 + 0.55 + 0.48 * 40.0_f64.to_radians().sin() + 0.20 * 30.0_f64.to_radians().sin();
        assert!(
            (refined.point.height_m - expected).abs() < 1e-9,
            "{refined:?}"
        );
    }

    #[test]
    fn an_empty_sample_has_no_extreme() {
        let robot = shipped("serial-arm");
        let mechanism = robot.mechanism(None).unwrap();
        let plan = WorkspacePlan {
            poses: 0,
            ..WorkspacePlan::paper()
        };
        let sample = WorkspaceSample::draw(&robot, mechanism, &plan).unwrap();
        assert!(sample.extreme(Extreme::Lowest).is_none());
        assert!(
            sample
                .refined_extreme(&robot, mechanism, Extreme::Lowest)
                .unwrap()
                .is_none()
        );
    }
}
