//! The tool of a robot in some poses as a tracker sees it.

use std::sync::Arc;

use stiffbench_units_and_text::read_axis::ReadAxis;
use stiffbench_units_and_text::test_point::Direction;

use super::error::RobotError;
use super::model::Mechanism;
use super::tool_pose::ToolPose;
use super::tracker_frames::TrackerFrames;
use super::{Pose, Robot};

/// A tracker, with the tool of the rigid robot in each of some poses.
#[derive(Debug, Clone, PartialEq)]
pub struct TrackedPoses {
    /// Where the tracker stands, and which point of the tool it sees.
    pub frames: TrackerFrames,
    /// The tool of the rigid robot in each pose.
    pub tools: Arc<[ToolPose]>,
}

impl TrackedPoses {
    /// The tools of a mechanism.
    ///
    /// # Errors
    /// [`RobotError`] for a pose that cannot be reached.
    pub fn new(
        robot: &Robot,
        mechanism: &Mechanism,
        poses: &[Pose],
        frames: TrackerFrames,
    ) -> Result<Self, RobotError> {
        let tools = poses.iter();
        let tools = tools.map(|pose| robot.end_pose(mechanism, pose));
        let tools = tools.collect::<Result<_, _>>()?;
        Ok(Self { frames, tools })
    }

    /// What is read in a pose along an axis of the tracker: of motions of the tool centre, and of the rigid robot, m.
    #[must_use]
    pub fn seen(&self, pose: usize, axis: Direction) -> (ReadAxis, f64) {
        let tool = &self.tools[pose];
        let unit = self.frames.read_unit(tool, axis);
        let rigid_m = self.frames.position_m(tool, &[0.0; 6]);
        (ReadAxis::new(axis, false, unit), rigid_m[axis.index()])
    }
}
