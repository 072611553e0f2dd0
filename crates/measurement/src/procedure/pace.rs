//! How long a procedure takes.

use super::plan::Procedure;
use super::steps::PlannedReading;

/// How fast an operator with a hand jack works.
///
/// None of it is stated in the paper; the numbers are those of a careful operator and are for comparing plans rather than for keeping
/// appointments.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Pace {
    /// From one reading to the next: turning the jack, settling, capture, s.
    pub reading_s: f64,
    /// Within that, from the load to the capture, s.
    pub hold_s: f64,
    /// Releasing a load to the preload, where a procedure asks for it before the next, s.
    pub release_s: f64,
    /// From the last reading on one gauge zero to the next zero: releasing, waiting, pressing on again, s.
    pub zero_s: f64,
    /// Moving jack and gauges to another direction, s.
    pub direction_s: f64,
    /// Moving the robot to another pose and setting everything up there, s.
    pub pose_s: f64,
}

impl Default for Pace {
    /// Five readings a minute, three quarters of a minute a zero, eight minutes a direction, half an hour a pose.
    fn default() -> Self {
        Self {
            reading_s: 12.0,
            hold_s: 5.0,
            release_s: 6.0,
            zero_s: 45.0,
            direction_s: 480.0,
            pose_s: 1800.0,
        }
    }
}

impl Pace {
    /// Seconds that readings of one pose and direction take, without setting up.
    #[must_use]
    pub fn seconds(&self, procedure: &Procedure, readings: &[PlannedReading]) -> f64 {
        let released_s = procedure.release_n().map_or(0.0, |_| self.release_s);
        let mut seconds = 0.0;
        let mut held_s = self.hold_s;
        for reading in readings {
            if reading.zero_before {
                seconds += self.zero_s;
            }
            if let Some(hold_s) = reading.extra_hold_s {
                // The load stays on: only the waiting counts.
                seconds += (hold_s - held_s).max(0.0);
                held_s = hold_s;
            } else {
                seconds += self.reading_s + released_s;
                held_s = self.hold_s;
            }
        }
        seconds
    }
}

impl Procedure {
    /// Minutes that the whole plan takes at this pace, setting up the first pose included.
    ///
    /// # Arguments
    /// - `poses`: how many poses are measured; a procedure without a list of its own does not know.
    #[must_use]
    pub fn minutes(&self, pace: &Pace, poses: usize) -> f64 {
        let directions = self.directions.len() as f64;
        let cell_s = pace.seconds(self, &self.steps(0));
        let pose_s =
            pace.pose_s + directions * cell_s + (directions - 1.0).max(0.0) * pace.direction_s;
        poses as f64 * pose_s / 60.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::readings::{RepeatOrder, ZeroScope};
    use stiffbench_units_and_text::test_point::Direction;

    #[test]
    fn minutes_add_up_by_hand() {
        let pace = Pace {
            reading_s: 10.0,
            hold_s: 5.0,
            release_s: 2.0,
            zero_s: 40.0,
            direction_s: 300.0,
            pose_s: 900.0,
        };
        // Two runs of 8 readings up and 7 down with 115 s of waiting at the top: 2 (40 + 150 + 115) s a cell.
        let sweeps = Procedure {
            unloading: true,
            holds_s: vec![60.0, 120.0],
            repeats: 2,
            directions: vec![Direction::X.into(), Direction::Z.into()],
            ..Procedure::default()
        };
        let pose_s = 900.0 + 300.0 + 2.0 * 610.0;
        assert!((sweeps.minutes(&pace, 3) - 3.0 * pose_s / 60.0).abs() < 1e-9);
        // The paper's order in one direction: 40 readings with a release each, one zero.
        let paper = Procedure {
            repeat_order: RepeatOrder::AtLoad,
            zero: ZeroScope::Cell,
            directions: vec![Direction::Y.into()],
            ..Procedure::default()
        };
        assert!((paper.minutes(&pace, 1) - (900.0 + 40.0 + 480.0) / 60.0).abs() < 1e-9);
    }
}
