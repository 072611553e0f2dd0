//! Making the bench ready, and a pose that the operator has set.

use stiffbench_gauges::Ask;

use crate::event::{Event, JointSet, PoseSet};
use crate::operator::{Prompt, PromptKind};

use super::answers::Why;
use super::{Action, Machine};

impl Machine {
    pub(super) fn ask_ready(&mut self, out: &mut Vec<Action>) {
        let items = if self.plan.procedure.displacement_axes.is_empty() {
            [
                "the robot has its brakes on and its reach is clear of people",
                "jack and force gauge push at the end node, in line with the displacement gauge",
                "the displacement gauge is mounted on something that the load does not move",
            ]
        } else {
            [
                "the robot has its brakes on and its reach is clear of people",
                "each displacement gauge touches the end node along its base axis",
                "the displacement gauges are mounted on something that the load does not move",
            ]
        };
        let list = PromptKind::Checklist(items.map(str::to_owned).to_vec());
        self.ask(
            Prompt::new("ready", "Is the bench ready?", list),
            Why::Ready,
            out,
        );
    }

    /// The pose stands.
    pub(super) fn set_up(&mut self, cell: usize, out: &mut Vec<Action>) {
        self.mounted = Some(cell);
        self.applied = None;
        self.loaded = false;
        self.begin_histories();
        for channel in self.channels.clone() {
            out.push(Action::Ask(channel, Ask::State));
        }
        let planned = &self.plan.cells[cell];
        let joints = self.plan.joints_of(&planned.pose);
        let joints = joints.map(|(joint, value)| JointSet::new(joint, *value));
        let event = Event::PoseSet(PoseSet {
            cell,
            pose: planned.pose.to_string(),
            direction: planned.direction.clone(),
            joints: joints.collect(),
        });
        self.record(event, out);
        self.done();
    }
}
