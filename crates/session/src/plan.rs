//! The readings of a whole session, in the order in which they are to be taken.

use stiffbench_measurement::procedure::{Pace, PlannedReading, Procedure};
use stiffbench_measurement::readings::ZeroScope;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::state::SessionState;

/// A procedure with its poses decided.
#[derive(Debug, Clone, PartialEq)]
pub struct SessionPlan {
    /// The procedure.
    pub procedure: Procedure,
    /// Poses and directions in the order of measurement, each with its readings.
    pub cells: Vec<SessionCell>,
}

/// One pose and direction.
#[derive(Debug, Clone, PartialEq)]
pub struct SessionCell {
    /// The pose.
    pub pose: PoseId,
    /// The direction.
    pub direction: Direction,
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
            .flat_map(|pose| procedure.directions.iter().map(move |way| (pose, *way)));
        let cells = (0..)
            .zip(places)
            .map(|(cell, (pose, direction))| SessionCell {
                pose: pose.clone(),
                direction,
                readings: procedure.steps(cell),
            });
        Self {
            cells: cells.collect(),
            procedure: procedure.clone(),
        }
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

    /// 1 or -1: the sense of the first load that is not zero.
    #[must_use]
    pub fn load_sense(&self) -> f64 {
        let first = self.procedure.loads_n.iter().find(|load_n| **load_n != 0.0);
        first.map_or(-1.0, |load_n| load_n.signum())
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

fn is_done(state: &SessionState, at: (usize, usize)) -> bool {
    state.taken.contains_key(&at) || state.skipped.contains_key(&at)
}
