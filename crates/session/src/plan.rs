//! The readings of a whole session, in the order in which they are to be taken.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_gauges::Channel;
use stiffbench_measurement::procedure::{Pace, PlannedReading, Procedure};
use stiffbench_measurement::readings::{JointColumn, JointUnit, ZeroScope};
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::PoseId;

use super::state::SessionState;

/// A procedure with its poses decided.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct SessionPlan {
    /// The procedure.
    pub procedure: Procedure,
    /// Poses and directions in the order of measurement, each with its readings.
    pub cells: Vec<SessionCell>,
    /// What the robot file calls x, y and z.
    axis_words: [Option<String>; 3],
}

/// A pose and direction with its readings.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SessionCell {
    /// The pose.
    pub pose: PoseId,
    /// The direction of the load.
    pub direction: LoadDirection,
    /// Its readings, in order.
    pub readings: Vec<PlannedReading>,
}

impl SessionPlan {
    /// The plan of a procedure; `poses` are taken where it names none.
    #[must_use]
    pub fn new(procedure: &Procedure, poses: &[PoseId]) -> Self {
        let poses = procedure.poses.as_deref().unwrap_or(poses);
        let places = poses
            .iter()
            .flat_map(|pose| procedure.directions.iter().map(move |way| (pose, way)));
        let cells = (0..)
            .zip(places)
            .map(|(cell, (pose, direction))| SessionCell {
                pose: pose.clone(),
                direction: direction.clone(),
                readings: procedure.steps(cell),
            });
        Self {
            cells: cells.collect(),
            procedure: procedure.clone(),
            axis_words: Default::default(),
        }
    }

    /// With the words of the robot file for x, y and z.
    #[must_use]
    pub fn with_axis_words(self, axis_words: [Option<&str>; 3]) -> Self {
        Self {
            axis_words: axis_words.map(|word| word.map(str::to_owned)),
            ..self
        }
    }

    /// A direction with what it is, for example `y (vertical)`.
    #[must_use]
    pub fn direction_text(&self, direction: &LoadDirection) -> String {
        let words = match direction {
            LoadDirection::Axis(axis) => self.axis_words[axis.index()].clone(),
            LoadDirection::Oblique(_) => direction.components_text(),
        };
        match words {
            Some(words) => format!("{direction} ({words})"),
            None => direction.to_string(),
        }
    }

    /// The gauges that it needs: force first, then one displacement gauge along the load, or one along each base axis that is read.
    #[must_use]
    pub fn channels(&self) -> Vec<Channel> {
        let axes = &self.procedure.displacement_axes;
        let mut channels = vec![Channel::Force];
        if axes.is_empty() {
            channels.push(Channel::Displacement);
        }
        channels.extend(axes.iter().map(|axis| Channel::along(*axis)));
        channels
    }

    /// The joints of a pose with their values, rad or m; none where the procedure does not state them.
    pub fn joints_of(&self, pose: &PoseId) -> impl Iterator<Item = &(JointColumn, f64)> {
        let poses = self.procedure.joint_values.iter();
        let of_pose = poses.filter(move |known| known.pose == *pose);
        of_pose.flat_map(|known| &known.values)
    }

    /// A pose with its joint values in words, for example ` (J1 30°, q2 120 mm)`; empty where they are not stated.
    #[must_use]
    pub fn joints_text(&self, pose: &PoseId) -> String {
        let joints = self.joints_of(pose).map(|(joint, value)| {
            let written = joint.unit.written(*value);
            match joint.unit {
                JointUnit::Angle => format!("{} {written}°", joint.variable),
                JointUnit::Length => format!("{} {written} mm", joint.variable),
            }
        });
        let joints: Vec<String> = joints.collect();
        if joints.is_empty() {
            return String::new();
        }
        format!(" ({})", joints.join(", "))
    }

    /// The displacement gauge of a cell that moves most with the load: that of the axis nearest to it.
    #[must_use]
    pub fn leading(&self, cell: usize) -> Channel {
        let direction = self.cells.get(cell).map(|cell| &cell.direction);
        let share = |channel: &Channel| {
            let axis = channel.axis().zip(direction);
            axis.map_or(0.0, |(axis, direction)| direction.along(axis).abs())
        };
        let gauges = self
            .channels()
            .into_iter()
            .filter(|channel| channel.is_displacement());
        gauges
            .fold(None, |best: Option<Channel>, channel| match best {
                Some(best) if share(&best) >= share(&channel) => Some(best),
                _ => Some(channel),
            })
            .unwrap_or(Channel::Displacement)
    }

    /// Number of readings.
    #[must_use]
    pub fn len(&self) -> usize {
        self.cells.iter().map(|cell| cell.readings.len()).sum()
    }

    /// Whether there is nothing to read.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Largest load in size, N.
    #[must_use]
    pub fn largest_n(&self) -> f64 {
        let sizes = self.procedure.loads_n.iter().map(|load_n| load_n.abs());
        sizes.fold(0.0, f64::max)
    }

    /// What of the plan the gauge zero of a reading is for.
    #[must_use]
    pub fn zero_scope(&self, reading: &PlannedReading) -> String {
        match self.procedure.zero {
            ZeroScope::Cell => "cell".to_owned(),
            ZeroScope::Run => reading.repeat.to_string(),
        }
    }

    /// The first reading that is neither taken nor left out: in `first_cell` if there is one, else in the order of the plan.
    #[must_use]
    pub fn next_open(&self, state: &SessionState, first_cell: usize) -> Option<(usize, usize)> {
        let open = |cell: usize| {
            let places = (0..self.cells.get(cell)?.readings.len()).map(|index| (cell, index));
            let mut open = places.filter(|at| !is_done(state, *at));
            open.next()
        };
        open(first_cell).or_else(|| (0..self.cells.len()).find_map(open))
    }

    /// What is neither taken nor left out, in words, a cell each: `5 of 9 readings at P3 y`, `all 9 at P3 z`.
    #[must_use]
    pub fn missing(&self, state: &SessionState) -> Vec<String> {
        let cells = self.cells.iter().enumerate();
        let of_cell = |(cell, planned): (usize, &SessionCell)| {
            let all = planned.readings.len();
            let is_open = |index: &usize| !is_done(state, (cell, *index));
            let share = match (0..all).filter(is_open).count() {
                0 => return None,
                open if open == all => format!("all {all}"),
                open => format!("{open} of {all} readings"),
            };
            Some(format!("{share} at {} {}", planned.pose, planned.direction))
        };
        cells.filter_map(of_cell).collect()
    }

    /// Loads to be applied again, N, before a reading in the middle of a run can be taken: those of the steps before it.
    #[must_use]
    pub fn loads_before(&self, cell: usize, index: usize) -> Vec<f64> {
        let readings = &self.cells[cell].readings;
        let wanted = &readings[index];
        let before = readings.iter().filter(|reading| {
            reading.repeat == wanted.repeat
                && reading.step < wanted.step
                && reading.extra_hold_s.is_none()
        });
        before.map(|reading| reading.target_n).collect()
    }

    /// What is done once more when a session in this state is resumed, in words; empty where nothing is open.
    ///
    /// # Arguments
    /// - `undecided`: how far a zero moved about which nobody has decided yet.
    #[must_use]
    pub fn repeated_on_resume(&self, state: &SessionState, undecided: Option<&str>) -> Vec<String> {
        let question = undecided.map(|moved| format!("the question what to do, as {moved}"));
        let Some((cell, index)) = self.next_open(state, 0) else {
            return question.into_iter().collect();
        };
        let planned = &self.cells[cell];
        let reading = &planned.readings[index];
        let mut repeats = vec![
            "the identity of the gauges".to_owned(),
            "the question for temperature and humidity".to_owned(),
            format!("setting up {} {}", planned.pose, planned.direction),
        ];
        let zero = state.zero.as_ref().map(|zero| &zero.set);
        let in_use = zero.filter(|set| set.cell == cell && set.scope == self.zero_scope(reading));
        repeats.extend(question);
        if let Some(zero) = in_use {
            repeats.push(format!("the check of zero {}", zero.label));
        }
        let loads = self.loads_before(cell, index);
        if self.procedure.release_n().is_none() && !loads.is_empty() {
            let loads: Vec<String> = loads.iter().map(ToString::to_string).collect();
            repeats.push(format!("the loads {} N, not recorded", loads.join(", ")));
        }
        repeats.push(format!(
            "settling for the reading at {} N, repeat {}",
            reading.target_n, reading.repeat
        ));
        repeats
    }

    /// Seconds that the open readings will take, with setting up.
    #[must_use]
    pub fn seconds_left(&self, state: &SessionState, pace: &Pace) -> f64 {
        let mut seconds = 0.0;
        let mut before: Option<&PoseId> = None;
        for (place, cell) in self.cells.iter().enumerate() {
            let open = cell.readings.iter().enumerate();
            let open: Vec<PlannedReading> = open
                .filter(|(index, _)| !is_done(state, (place, *index)))
                .map(|(_, reading)| *reading)
                .collect();
            if open.len() == cell.readings.len() {
                seconds += if before == Some(&cell.pose) {
                    pace.direction_s
                } else {
                    pace.pose_s
                };
            }
            seconds += pace.seconds(&self.procedure, &open);
            before = Some(&cell.pose);
        }
        seconds
    }
}

pub(super) fn is_done(state: &SessionState, at: (usize, usize)) -> bool {
    state.taken.contains_key(&at) || state.skipped.contains_key(&at)
}
