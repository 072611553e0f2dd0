//! Poses drawn at random within the limits (the paper's Section II-C and Fig. 3).

use stiffbench_beams::robot::{
    FittingFactors, JointModel, Mechanism, MechanismModel, Pose, Robot, RobotError, Theory,
};
use stiffbench_numeric::vector::{dot, norm, scale, subtract};

use super::pose_set::{PosePlan, PoseSample, Sampling, Shard, WorkspaceError};

/// What to draw.
#[derive(Debug, Clone, PartialEq)]
pub struct WorkspacePlan {
    /// Poses within the limits.
    pub poses: usize,
    /// Seed of the draw; the same seed gives the same poses on every machine.
    pub seed: u64,
    /// Variables that stay at their nominal value.
    pub held: Vec<String>,
    /// Unit vector along which height is measured.
    pub vertical: [f64; 3],
    /// Unit vector along which reach is measured; `None` takes the distance from the vertical axis through the origin, which a
    /// turning waist does not change.
    pub radial: Option<[f64; 3]>,
}

impl WorkspacePlan {
    /// The paper's 30 000 poses (Fig. 3), all variables free, y up, reach as the distance from the vertical axis, seed 0.
    #[must_use]
    pub fn paper() -> Self {
        Self {
            poses: 30_000,
            seed: 0,
            held: Vec::new(),
            vertical: [0.0, 1.0, 0.0],
            radial: None,
        }
    }

    /// Reach and height of a point, m.
    #[must_use]
    pub fn reach_and_height(&self, position_m: [f64; 3]) -> [f64; 2] {
        let height_m = dot(position_m, self.vertical);
        let reach_m = match self.radial {
            Some(radial) => dot(position_m, radial),
            None => norm(subtract(position_m, scale(self.vertical, height_m))),
        };
        [reach_m, height_m]
    }

    /// This plan with some variables held: without those that only turn the arm plane or move nothing at the end, Fig. 3 is the
    /// projection on one plane.
    #[must_use]
    pub fn holding(self, names: &[&str]) -> Self {
        Self {
            held: names.iter().map(|name| (*name).to_owned()).collect(),
            ..self
        }
    }
}

/// Where the end is in a pose.
#[derive(Debug, Clone, PartialEq)]
pub struct EndPoint {
    /// The pose.
    pub pose: Pose,
    /// Position of the end node, m.
    pub position_m: [f64; 3],
    /// Reach, m: see [`WorkspacePlan::radial`].
    pub reach_m: f64,
    /// Height, m.
    pub height_m: f64,
}

/// A pose within the limits that the linkage cannot take.
#[derive(Debug, Clone, PartialEq)]
pub struct UnreachablePose {
    /// The pose.
    pub pose: Pose,
    /// Node whose loop does not close.
    pub node: String,
    /// How far it is from closing, m.
    pub gap_m: f64,
}

/// Poses drawn within the limits of a robot.
#[derive(Debug, Clone, PartialEq)]
pub struct WorkspaceSample {
    /// What was asked for.
    pub plan: WorkspacePlan,
    /// Poses the mechanism can take, in the order drawn.
    pub points: Vec<EndPoint>,
    /// Poses within the limits whose loops do not close, in the order drawn. With `points` they make up `plan.poses`.
    pub unreachable: Vec<UnreachablePose>,
    /// Poses drawn from the box of the variables' own limits, those that a coupled limit excludes included.
    pub drawn: usize,
}

impl WorkspaceSample {
    /// Draws poses evenly from the box of the variables' limits and keeps those within the coupled limits.
    ///
    /// # Errors
    /// [`WorkspaceError::Robot`] for a held variable that does not exist, a mechanism without end or support, or nodes that do not
    /// lie as the file says; [`WorkspaceError::LimitsExcludeNearlyAll`]. A pose whose loops do not close is no error: it is listed.
    pub fn draw(
        robot: &Robot,
        mechanism: &Mechanism,
        plan: &WorkspacePlan,
    ) -> Result<Self, WorkspaceError> {
        let mut place = EndPlacer::new(robot, mechanism, plan)?;
        let poses = PosePlan {
            sampling: Sampling::MonteCarlo,
            poses: plan.poses,
            seed: plan.seed,
            held: plan.held.clone(),
        };
        let poses = PoseSample::draw(robot, &poses, Shard::WHOLE)?;
        let mut sample = Self {
            plan: plan.clone(),
            points: Vec::new(),
            unreachable: Vec::new(),
            drawn: poses.drawn as usize,
        };
        for pose in (0..poses.len()).map(|number| poses.pose(number)) {
            match place.end_point(pose.clone()) {
                Ok(point) => sample.points.push(point),
                Err(RobotError::Unreachable { node, gap_m, .. }) => sample
                    .unreachable
                    .push(UnreachablePose { pose, node, gap_m }),
                Err(other) => return Err(other.into()),
            }
        }
        Ok(sample)
    }

    /// Poses within the limits, reachable or not.
    #[must_use]
    pub fn accepted(&self) -> usize {
        self.points.len() + self.unreachable.len()
    }

    /// Share of the box that lies within the coupled limits, estimated from the draw; `None` if nothing was drawn.
    #[must_use]
    pub fn acceptance_rate(&self) -> Option<f64> {
        (self.drawn > 0).then(|| self.accepted() as f64 / self.drawn as f64)
    }
}

/// Finds the end of a mechanism in one pose after another.
pub(super) struct EndPlacer<'a> {
    model: MechanismModel<'a>,
    plan: WorkspacePlan,
}

impl<'a> EndPlacer<'a> {
    pub(super) fn new(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        plan: &WorkspacePlan,
    ) -> Result<Self, RobotError> {
        let model = MechanismModel::new(
            robot,
            mechanism,
            &JointModel::Rigid,
            Theory::EulerBernoulli,
            &FittingFactors::UNIT,
        )?;
        Ok(Self {
            model,
            plan: plan.clone(),
        })
    }

    /// # Errors
    /// [`RobotError::Unreachable`] and the other errors of placing.
    pub(super) fn end_point(&mut self, pose: Pose) -> Result<EndPoint, RobotError> {
        self.model.place(&pose)?;
        let structure = self.model.structure();
        let position_m = structure.nodes[structure.end.node].position_m;
        let [reach_m, height_m] = self.plan.reach_and_height(position_m);
        Ok(EndPoint {
            pose,
            position_m,
            reach_m,
            height_m,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiffbench_test_files::shipped_robot;
    use stiffbench_units_and_text::source_text::SourceText;

    fn shipped(name: &str) -> Robot {
        Robot::parse(&shipped_robot(name).unwrap()).unwrap()
    }

    fn small(poses: usize, seed: u64) -> WorkspacePlan {
        WorkspacePlan {
            poses,
            seed,
            ..WorkspacePlan::paper()
        }
    }

    #[test]
    fn all_poses_lie_within_the_limits_and_a_seed_repeats_them() {
        let robot = shipped("hp-robot");
        let mechanism = robot.mechanism(None).unwrap();
        let draw = |seed| WorkspaceSample::draw(&robot, mechanism, &small(500, seed)).unwrap();
        let sample = draw(7);
        assert_eq!(sample.points.len(), 500);
        assert!(sample.unreachable.is_empty());
        for point in &sample.points {
            assert!(robot.violated_limits(&point.pose).is_empty());
        }
        assert_eq!(draw(7), sample);
        assert_ne!(draw(8).points, sample.points);
        // More poses of the same seed begin with the same poses.
        let more = WorkspaceSample::draw(&robot, mechanism, &small(600, 7)).unwrap();
        assert_eq!(more.points[..500], sample.points);
    }

    #[test]
    fn acceptance_is_the_share_of_the_box() {
        // theta2 - theta3 < 52.17 cuts a triangle off the box: 352.51 - 290 = 62.51, 352.51 - 341.97 = 10.54, so that the legs are
        // 52.17 - 10.54 = 41.63 degrees each, of 44.93 × 51.97.
        let share = 1.0 - 0.5 * 41.63_f64.powi(2) / (44.93 * 51.97);
        let robot = shipped("hp-robot");
        let mechanism = robot.mechanism(Some("A")).unwrap();
        let sample = WorkspaceSample::draw(&robot, mechanism, &small(30_000, 1)).unwrap();
        let rate = sample.acceptance_rate().unwrap();
        // Four standard deviations of a count.
        let bound = 4.0 * (share * (1.0 - share) / sample.drawn as f64).sqrt();
        assert!((rate - share).abs() < bound, "{rate} for {share} ± {bound}");
        assert_eq!(sample.accepted(), 30_000);
    }

    #[test]
    fn held_variables_stay_nominal() {
        let robot = shipped("hp-robot");
        let mechanism = robot.mechanism(Some("F")).unwrap();
        let plan = small(200, 3).holding(&["theta1", "theta4"]);
        let sample = WorkspaceSample::draw(&robot, mechanism, &plan).unwrap();
        for point in &sample.points {
            assert_eq!(
                (point.pose.angles_deg[0], point.pose.angles_deg[3]),
                (360.0, 50.0)
            );
            // In the yz plane the distance from the vertical axis is z itself.
            assert!((point.reach_m - point.position_m[2]).abs() < 1e-14);
            assert_eq!(point.height_m, point.position_m[1]);
        }
        let unknown = small(10, 0).holding(&["theta9"]);
        assert!(matches!(
            WorkspaceSample::draw(&robot, mechanism, &unknown),
            Err(WorkspaceError::Robot(RobotError::UnknownName { .. }))
        ));
    }

    #[test]
    fn reach_along_a_direction_or_from_the_axis() {
        let robot = shipped("hp-robot");
        let mechanism = robot.mechanism(Some("A")).unwrap();
        let around = WorkspaceSample::draw(&robot, mechanism, &small(100, 5)).unwrap();
        let along = WorkspacePlan {
            radial: Some([0.0, 0.0, 1.0]),
            ..small(100, 5)
        };
        let along = WorkspaceSample::draw(&robot, mechanism, &along).unwrap();
        for (around, along) in around.points.iter().zip(&along.points) {
            assert_eq!(around.pose, along.pose);
            let [x, _, z] = around.position_m;
            assert!((around.reach_m - x.hypot(z)).abs() < 1e-14);
            assert_eq!(along.reach_m, z);
        }
    }

    #[test]
    fn poses_that_cannot_be_reached_are_listed() {
        // A forearm rod of less than half its length: chain F closes in part of the workspace only.
        let text = shipped_robot("hp-robot").unwrap().text;
        let text = text.replace(r#"[["F6", "l_A4A5"]"#, r#"[["F6", 0.200]"#);
        let robot = Robot::parse(&SourceText::new("short.toml", text)).unwrap();
        let mechanism = robot.mechanism(Some("F")).unwrap();
        let sample = WorkspaceSample::draw(&robot, mechanism, &small(400, 2)).unwrap();
        assert_eq!(sample.points.len() + sample.unreachable.len(), 400);
        assert!(!sample.unreachable.is_empty() && !sample.points.is_empty());
        for pose in &sample.unreachable {
            assert!(pose.gap_m > 0.0 && pose.node.starts_with('F'), "{pose:?}");
        }
        // Without chain F every pose can be taken, and the end is where it was.
        let host = robot.mechanism(Some("A")).unwrap();
        let sample = WorkspaceSample::draw(&robot, host, &small(400, 2)).unwrap();
        assert!(sample.unreachable.is_empty());
    }

    #[test]
    fn limits_that_exclude_everything_are_an_error() {
        let text = shipped_robot("hp-robot").unwrap().text;
        let text = text.replace("at_least = 52.17", "at_least = 200.0");
        let robot = Robot::parse(&SourceText::new("tight.toml", text)).unwrap();
        let mechanism = robot.mechanism(Some("A")).unwrap();
        let error = WorkspaceSample::draw(&robot, mechanism, &small(3, 0)).unwrap_err();
        let WorkspaceError::LimitsExcludeNearlyAll {
            drawn,
            accepted,
            wanted,
        } = error
        else {
            panic!("{error:?}")
        };
        assert_eq!((drawn, accepted, wanted), (30_000, 0, 3));
    }

    #[test]
    fn no_poses_are_no_poses() {
        let robot = shipped("serial-arm");
        let mechanism = robot.mechanism(None).unwrap();
        let sample = WorkspaceSample::draw(&robot, mechanism, &small(0, 0)).unwrap();
        assert_eq!((sample.drawn, sample.acceptance_rate()), (0, None));
    }
}
