//! When and under which force each reading of a procedure will be made.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

use crate::mismatch::error::MismatchError;
use crate::mismatch::observed::{Observations, PlannedCell, PlannedLoad};
use stiffbench_beams::physics::TestObject;
use stiffbench_measurement::procedure::Procedure;
use stiffbench_units_and_text::test_point::PoseId;

use super::bench::DesignBench;

/// Share by which a planned time varies from one reading to the next, at most (1). By judgement (2d002a9).
const TIMES_VARY: f64 = 0.2;

/// Seed of times and forces: a plan has one schedule.
const SEED: u64 = 0;

impl DesignBench<'_> {
    /// The poses of a procedure: its own, or all at hand.
    pub(super) fn poses_of(&self, procedure: &Procedure) -> Vec<PoseId> {
        let own = procedure.poses.clone();
        own.unwrap_or_else(|| self.poses.to_vec())
    }

    /// The readings that a procedure plans.
    ///
    /// Forces miss their targets within the procedure's tolerance and times vary by a fifth, as with a hand jack: a plan that tells two
    /// laws apart only because every load takes exactly as long would not do so on a bench.
    pub(super) fn observations(
        &self,
        procedure: &Procedure,
    ) -> Result<Observations, MismatchError> {
        procedure.check_directions()?;
        let mut clock = ScheduleClock {
            rng: ChaCha8Rng::seed_from_u64(SEED),
            time_s: 0.0,
        };
        let mut cells: Vec<PlannedCell> = Vec::new();
        let mut planned = 0;
        for pose in self.poses_of(procedure) {
            for (place, load) in procedure.directions.iter().enumerate() {
                let number = planned;
                planned += 1;
                if number > 0 {
                    clock.wait(if place == 0 {
                        self.pace.pose_s
                    } else {
                        self.pace.direction_s
                    });
                }
                let loads = self.loads(procedure, number, &mut clock);
                let axes = procedure.axes_read_under(load).into_iter();
                cells.extend(axes.map(|direction| PlannedCell {
                    pose: pose.clone(),
                    load: load.clone(),
                    direction,
                    loads: loads.clone(),
                }));
            }
        }
        let planned = Observations::planned(&cells, self.steps, procedure.release_n());
        let planned = self.in_order(&planned)?;
        Ok(match self.object {
            TestObject::Robot => planned,
            object => planned.of_part(object),
        })
    }

    fn loads(
        &self,
        procedure: &Procedure,
        cell: u32,
        clock: &mut ScheduleClock,
    ) -> Vec<PlannedLoad> {
        let released_s = procedure.release_n().map_or(0.0, |_| self.pace.release_s);
        let (mut force_n, mut hold_s) = (0.0, 0.0);
        let mut loads = Vec::new();
        for planned in procedure.steps(cell) {
            if planned.zero_before {
                clock.wait(self.pace.zero_s);
            }
            if let Some(until_s) = planned.extra_hold_s {
                clock.time_s += (until_s - hold_s).max(0.0);
                hold_s = until_s.max(hold_s);
            } else {
                clock.wait(self.pace.reading_s + released_s);
                hold_s = clock.varied(self.pace.hold_s);
                force_n = planned.target_n;
                if force_n != 0.0 {
                    let tolerance_n = procedure.settle.force_tolerance_n;
                    force_n += tolerance_n * (2.0 * clock.rng.random::<f64>() - 1.0);
                }
            }
            loads.push(PlannedLoad {
                step: planned.step,
                force_n,
                branch: planned.branch,
                repeat: planned.repeat,
                hold_s,
                time_s: clock.time_s,
                temperature_deg_c: Some(room_deg_c(clock.time_s)),
                zero_before: planned.zero_before,
            });
        }
        loads
    }
}

struct ScheduleClock {
    rng: ChaCha8Rng,
    time_s: f64,
}

impl ScheduleClock {
    fn varied(&mut self, mean_s: f64) -> f64 {
        mean_s * (1.0 + TIMES_VARY * (2.0 * self.rng.random::<f64>() - 1.0))
    }

    fn wait(&mut self, mean_s: f64) {
        self.time_s += self.varied(mean_s);
    }
}

/// Temperature of a workshop: half a degree up and down in two hours.
fn room_deg_c(time_s: f64) -> f64 {
    20.0 + 0.5 * (std::f64::consts::TAU * time_s / 7200.0).sin()
}
