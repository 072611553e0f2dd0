//! A robot on a bench that can be loaded and read at any time: what emulated gauges measure.
//!
//! What a gauge shows at rest depends on seed, pose, direction, step and repeat, and on nothing else: not on how often or when it is read, not
//! on what was done before, and not on whether the program was started again in between. So the same seed gives the same session, interrupted
//! or not. The price: laws that depend on time (creep, drift) act at the times that the pace of the procedure plans, not at those of the clock;
//! and a gauge that goes back to its zero has drifted as far as at the last load.

mod cell;
mod motion;

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use stiffbench_beams::physics::{ActingPhysics, LawSet, Mechanics, Place, PoseMechanics};
use stiffbench_beams::robot::{FittingFactors, Pose, Robot};
use stiffbench_measurement::procedure::Procedure;
use stiffbench_measurement::readings::ZeroScope;
use stiffbench_units_and_text::clock::Clock;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::jack::Jack;
use super::noise::NoiseModel;
use super::virtual_bench::BenchError;
use cell::{CellKey, SolvedCell};
use motion::{Motion, Stand};

/// How far a hand that pushes moves the end, m, if it does not take more than the largest load of the procedure.
const HAND_M: f64 = 150e-6;

/// How much more than was asked for a hand pushes.
const FIRMLY: f64 = 1.25;

/// How a bench is set up.
#[derive(Debug, Clone, Copy)]
pub struct EmulatedSetup {
    /// Errors of readings, zeros and runs. Steps of gauges are those of the gauges.
    pub noise: NoiseModel,
    /// The times that the procedure plans.
    pub jack: Jack,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Whether the force gauge counts a force along the negative axis as tension: it stands on the other side.
    pub force_turned: bool,
    /// Whether the displacement gauge counts along the negative axis.
    pub displacement_turned: bool,
}

impl Default for EmulatedSetup {
    /// A careful bench; both gauges count along the axis.
    fn default() -> Self {
        Self {
            noise: NoiseModel::default(),
            jack: Jack::default(),
            seed: 0,
            force_turned: false,
            displacement_turned: false,
        }
    }
}

/// A robot, a jack, and two gauges that may be read from any thread; clones are the same bench.
#[derive(Debug, Clone)]
pub struct EmulatedBench {
    inner: Arc<Mutex<Inner>>,
    clock: Clock,
}

#[derive(Debug)]
struct Inner {
    laws: LawSet,
    /// Of these, what acts with the clock alone: it moves a gauge that is not loaded too.
    drift: LawSet,
    poses: Vec<(PoseId, PoseMechanics)>,
    procedure: Procedure,
    setup: EmulatedSetup,
    /// Cells that have been computed.
    cells: BTreeMap<(usize, usize), SolvedCell>,
    pose: usize,
    direction: usize,
    /// The run that is made ready or under way, from 1.
    repeat: u32,
    /// By how much each gauge had drifted since its zero at the last load, m.
    drift_m: [f64; 3],
    /// Force to which the jack is set without a planned load: nothing or the preload.
    motion: Motion,
    /// What a hand adds.
    hand: Stand,
}

impl EmulatedBench {
    /// Sets a robot up for a procedure, in its first pose and direction, nothing loaded.
    ///
    /// # Arguments
    /// - `clock`: session time, in which the jack moves.
    ///
    /// # Errors
    /// [`BenchError`] for a procedure or noise that cannot be, or a pose that the robot does not have or reach.
    pub fn new(
        robot: &Robot,
        physics: &ActingPhysics,
        factors: &FittingFactors,
        procedure: &Procedure,
        setup: EmulatedSetup,
        clock: Clock,
    ) -> Result<Self, BenchError> {
        procedure.check()?;
        setup.noise.check()?;
        procedure.check_directions()?;
        let named = || robot.poses.iter().map(|named| named.id.clone());
        let names = procedure.poses.clone().unwrap_or_else(|| named().collect());
        let angles: Vec<Pose> = names
            .iter()
            .map(|name| robot.pose(name).cloned())
            .collect::<Result<_, _>>()?;
        let factors = physics.with_springs(factors);
        let mechanics = Mechanics::new(robot, &physics.mechanism, &factors, &angles)?;
        let poses = names.into_iter().enumerate();
        let poses = poses.map(|(place, name)| (name, mechanics.pose(place).clone()));
        let mut drift = LawSet::default();
        for effect in &physics.effects {
            if matches!(effect.place, Place::Clock(_)) {
                drift.push(effect, None);
            }
        }
        let mut inner = Inner {
            laws: physics.laws.clone(),
            drift,
            poses: poses.collect(),
            procedure: procedure.clone(),
            setup,
            cells: BTreeMap::new(),
            pose: 0,
            direction: 0,
            repeat: 1,
            drift_m: [0.0; 3],
            motion: Motion::default(),
            hand: Stand::default(),
        };
        inner.stand_at_rest();
        Ok(Self {
            inner: Arc::new(Mutex::new(inner)),
            clock,
        })
    }

    /// Moves the robot to a pose; the jack is off, and the first run comes next.
    ///
    /// # Errors
    /// [`BenchError::NotPlanned`] for a pose that the procedure does not have.
    pub fn set_pose(&self, pose: &PoseId) -> Result<(), BenchError> {
        let mut inner = self.lock();
        let place = inner.poses.iter().position(|(name, _)| name == pose);
        inner.pose = place.ok_or_else(|| BenchError::NotPlanned {
            what: format!("pose {pose}"),
            planned: listed(inner.poses.iter().map(|(name, _)| name.to_string())),
        })?;
        inner.stand_at_rest();
        Ok(())
    }

    /// Moves jack and gauges to a direction; the jack is off, and the first run comes next.
    ///
    /// # Errors
    /// [`BenchError::NotPlanned`] for a direction that the procedure does not have.
    pub fn set_direction(&self, direction: &LoadDirection) -> Result<(), BenchError> {
        let mut inner = self.lock();
        let directions = &inner.procedure.directions;
        let place = directions.iter().position(|known| known == direction);
        inner.direction = place.ok_or_else(|| BenchError::NotPlanned {
            what: format!("direction {direction}"),
            planned: listed(directions.iter().map(ToString::to_string)),
        })?;
        inner.stand_at_rest();
        Ok(())
    }

    /// Makes ready for a run: where the procedure zeroes before each run, the gauge stands as it does at the zero of this one. Say it before
    /// the zero is set.
    ///
    /// # Arguments
    /// - `repeat`: from 1.
    pub fn begin_run(&self, repeat: u32) {
        let mut inner = self.lock();
        inner.repeat = repeat;
        if inner.procedure.zero == ZeroScope::Run {
            inner.drift_m = [0.0; 3];
        }
        inner.go_to_rest(0.0, self.clock.now_s());
    }

    /// Turns the jack until the preload of the procedure acts.
    pub fn preload(&self) {
        let mut inner = self.lock();
        let preload_n = inner.procedure.preload_n;
        inner.go_to_rest(preload_n, self.clock.now_s());
    }

    /// Takes the load off; the force gauge hangs free.
    pub fn release(&self) {
        self.lock().go_to_rest(0.0, self.clock.now_s());
    }

    /// Turns the jack toward a load; the operator stops within four fifths of the procedure's tolerance of it.
    ///
    /// # Arguments
    /// - `step`, `repeat`: which load of the procedure this is. One that is not planned so has the displacement of a first load.
    pub fn apply(&self, target_n: f64, step: u32, repeat: u32) {
        let mut inner = self.lock();
        inner.repeat = repeat;
        let now_s = self.clock.now_s();
        let stages = inner.cell().stages(target_n, step, repeat);
        inner.drift_m = inner.cell().drift_m(step, repeat);
        inner.go_to(stages, now_s);
    }

    /// Turns the jack a little further, because the display asks for it; the end gives way as under a first load.
    pub fn turn(&self, by_n: f64) {
        let mut inner = self.lock();
        let by = inner.cell().more_load(by_n);
        inner.motion = inner.motion.turned_by(by, self.clock.now_s());
    }

    /// A hand pushes on the force gauge, and the end of the robot with it, until [`EmulatedBench::let_go`].
    ///
    /// # Arguments
    /// - `force_n`: what was asked for, N along the axis; a hand pushes a quarter more, and harder until the end moves visibly.
    pub fn push_by_hand(&self, force_n: f64) {
        let mut inner = self.lock();
        let loads_n = inner.procedure.loads_n.iter();
        let largest_n = loads_n.fold(0.0_f64, |largest, load_n| largest.max(load_n.abs()));
        let least_n = FIRMLY * force_n.abs();
        let unit = inner.procedure.directions[inner.direction].unit_vector();
        let least = inner.cell().more_load(least_n);
        let moved_m: f64 = (0..3).map(|axis| unit[axis] * least.along_m[axis]).sum();
        let harder = (HAND_M / moved_m.abs()).min(largest_n / least_n).max(1.0);
        let moved_m = moved_m.abs() * harder.copysign(force_n);
        inner.hand = Stand {
            force_n: harder * FIRMLY * force_n,
            // Along the push alone: whoever pushes guides the end.
            along_m: unit.map(|part| part * moved_m),
        };
    }

    /// A hand pushes on the end of the robot along a base axis, beside the force gauge, until [`EmulatedBench::let_go`].
    ///
    /// # Arguments
    /// - `sense`: above zero toward the positive end.
    pub fn push_end(&self, axis: Direction, sense: f64) {
        let mut inner = self.lock();
        inner.hand = Stand {
            along_m: axis.unit_vector().map(|part| part * HAND_M.copysign(sense)),
            ..Stand::default()
        };
    }

    /// The hand lets go.
    pub fn let_go(&self) {
        let mut inner = self.lock();
        inner.hand = Stand::default();
    }

    /// What acts on the force gauge now, N, tension positive for a gauge that is not turned round: the loads of a procedure compress it.
    #[must_use]
    pub fn force_n(&self) -> f64 {
        let inner = self.lock();
        let force_n = inner.stand(self.clock.now_s()).force_n;
        let positive = inner.procedure.load_sense() > 0.0;
        turned(force_n, inner.setup.force_turned != positive)
    }

    /// Where the tip of the displacement gauge along the load stands now, m, as the gauge counts.
    #[must_use]
    pub fn displacement_m(&self) -> f64 {
        let inner = self.lock();
        let load = &inner.procedure.directions[inner.direction];
        let along_m = inner.stand(self.clock.now_s()).along_m;
        let displacement_m = Direction::ALL.map(|axis| load.along(axis) * along_m[axis.index()]);
        turned(displacement_m.iter().sum(), inner.setup.displacement_turned)
    }

    /// Where the tip of the displacement gauge along a base axis stands now, m, as the gauge counts.
    #[must_use]
    pub fn displacement_along_m(&self, axis: Direction) -> f64 {
        let inner = self.lock();
        let along_m = inner.stand(self.clock.now_s()).along_m[axis.index()];
        turned(along_m, inner.setup.displacement_turned)
    }

    /// Whether jack and robot are at rest.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.lock().motion.is_over(self.clock.now_s())
    }

    fn lock(&self) -> MutexGuard<'_, Inner> {
        // No step leaves the bench halfway.
        self.inner.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Inner {
    /// The cell that is set up, computed when it is first needed.
    fn cell(&mut self) -> &SolvedCell {
        let Self {
            laws,
            drift,
            poses,
            procedure,
            setup,
            ..
        } = self;
        let (pose, structure) = &poses[self.pose];
        let direction = procedure.directions[self.direction].clone();
        let number = self.pose * procedure.directions.len() + self.direction;
        self.cells
            .entry((self.pose, self.direction))
            .or_insert_with(|| {
                let key = CellKey {
                    pose: pose.clone(),
                    direction,
                    number: number as u32,
                };
                SolvedCell::new(key, [laws, drift], structure, procedure, setup)
            })
    }

    /// A new pose or direction: everything stands, nothing is loaded.
    fn stand_at_rest(&mut self) {
        self.repeat = 1;
        self.drift_m = [0.0; 3];
        let stand = self.cell().at_rest(0.0, 1);
        self.motion = Motion::standing(stand);
    }

    fn go_to_rest(&mut self, force_n: f64, now_s: f64) {
        let repeat = self.repeat;
        let mut stand = self.cell().at_rest(force_n, repeat);
        for (along_m, drift_m) in stand.along_m.iter_mut().zip(self.drift_m) {
            *along_m += drift_m;
        }
        self.go_to(vec![(0.0, stand)], now_s);
    }

    /// Where everything stands, with what a hand adds.
    fn stand(&self, now_s: f64) -> Stand {
        self.motion.at(now_s).plus(&self.hand)
    }

    fn go_to(&mut self, stages: Vec<(f64, Stand)>, now_s: f64) {
        self.hand = Stand::default();
        self.motion = Motion::new(self.motion.at(now_s), stages, now_s);
    }
}

fn turned(value: f64, turned: bool) -> f64 {
    if turned { -value } else { value }
}

fn listed(names: impl Iterator<Item = String>) -> String {
    names.collect::<Vec<_>>().join(", ")
}

#[cfg(test)]
mod tests;
