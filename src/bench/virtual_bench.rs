//! Follows a procedure on a robot that exists as a beam model.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use crate::procedure::{PlannedReading, Procedure, ProcedureProblem};
use crate::readings::{ReadingTable, ZeroScope};
use crate::robot::{FittingFactors, Mechanism, Predictor, Robot, RobotError};
use crate::test_point::{Direction, PoseId};

use super::STREAM_OF_TIMES;
use super::jack::{self, Jack};
use super::mechanics::{LoadPoint, RunLoads, mechanics};
use super::noise::NoiseModel;
use super::recorder::{Place, Recorder};
use super::temperature::TemperatureTrack;

/// Why a virtual bench cannot run.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum BenchError {
    /// The robot cannot take a pose, or its structure cannot carry a load.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Robot(#[from] RobotError),
    /// A procedure that cannot be followed.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Procedure(#[from] ProcedureProblem),
    /// A size of the noise that is negative or not finite.
    #[error("{what} is {value}: it must be finite and not negative")]
    #[diagnostic(
        code(stiffbench::bench::noise),
        help("give 0 or more; 0 switches this error off")
    )]
    Noise {
        /// Which size.
        what: &'static str,
        /// Its value, SI.
        value: f64,
    },
}

/// A robot on a bench, in software.
#[derive(Debug)]
pub struct VirtualBench<'a> {
    predictor: Predictor<'a>,
    robot: &'a Robot,
    noise: NoiseModel,
    jack: Jack,
}

/// What belongs to one pose and direction.
struct CellSetup<'a> {
    pose: &'a PoseId,
    direction: Direction,
    /// 3 × 3, row = direction of displacement, column = direction of force.
    compliance_m_per_n: [[f64; 3]; 3],
    planned: Vec<PlannedReading>,
}

/// A load as the operator set it, with the errors of its reading.
struct SetLoad {
    planned: PlannedReading,
    load: LoadPoint,
    /// Zero and reading together, m.
    error_m: f64,
}

/// Clock, thermometer and random numbers of a session.
struct Session {
    errors: ChaCha8Rng,
    times: ChaCha8Rng,
    temperature: TemperatureTrack,
    time_s: f64,
}

impl Session {
    fn new(seed: u64) -> Self {
        let mut times = ChaCha8Rng::seed_from_u64(seed);
        times.set_stream(STREAM_OF_TIMES);
        Self {
            errors: ChaCha8Rng::seed_from_u64(seed),
            times,
            temperature: TemperatureTrack::new(seed),
            time_s: 0.0,
        }
    }
}

impl<'a> VirtualBench<'a> {
    /// Sets a mechanism with its true factors on the bench.
    ///
    /// # Errors
    /// [`BenchError::Robot`], [`BenchError::Noise`].
    pub fn new(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        factors: &FittingFactors,
        noise: NoiseModel,
        jack: Jack,
    ) -> Result<Self, BenchError> {
        for (what, value) in [
            ("the reading error", noise.reading_sd_m),
            ("the zero error", noise.zero_sd_m),
            ("the run-to-run slope", noise.run_slope_sd),
            (
                "the step of the displacement gauge",
                noise.displacement_step_m,
            ),
            ("the step of the force gauge", noise.force_step_n),
        ] {
            if !(value.is_finite() && value >= 0.0) {
                return Err(BenchError::Noise { what, value });
            }
        }
        Ok(Self {
            predictor: Predictor::new(robot, mechanism, factors)?,
            robot,
            noise,
            jack,
        })
    }

    /// Follows a procedure; the same seed gives the same readings. Poses that it leaves open are all of the robot's.
    ///
    /// The gauge is zeroed without load: the preload of the procedure is a matter of a real contact. Every run starts virgin.
    ///
    /// # Errors
    /// [`BenchError::Procedure`]; [`BenchError::Robot`] for a pose that is unknown or cannot be reached.
    pub fn run(
        &mut self,
        procedure: &Procedure,
        name: &str,
        seed: u64,
    ) -> Result<ReadingTable, BenchError> {
        procedure.check()?;
        let named = || self.robot.poses.iter().map(|named| named.id.clone());
        let poses = procedure.poses.clone().unwrap_or_else(|| named().collect());
        let mut session = Session::new(seed);
        let mut recorder = Recorder::default();
        let mut cell = 0;
        for pose in &poses {
            self.predictor.place(self.robot.pose(pose)?)?;
            let compliance_m_per_n = self.predictor.translation_compliance();
            for (place, &direction) in procedure.directions.iter().enumerate() {
                let setup = CellSetup {
                    pose,
                    direction,
                    compliance_m_per_n,
                    planned: procedure.steps(cell),
                };
                // The session begins when the first pose is set up.
                if cell > 0 {
                    let pace = &self.jack.pace;
                    let mean_s = if place == 0 {
                        pace.pose_s
                    } else {
                        pace.direction_s
                    };
                    session.time_s += jack::seconds(mean_s, &mut session.times);
                }
                self.run_cell(procedure, &setup, &mut session, &mut recorder);
                cell += 1;
            }
        }
        Ok(recorder.finish(name))
    }

    fn run_cell(
        &self,
        procedure: &Procedure,
        setup: &CellSetup<'_>,
        session: &mut Session,
        recorder: &mut Recorder,
    ) {
        let slopes: Vec<f64> = (0..procedure.repeats)
            .map(|_| {
                self.noise
                    .error(self.noise.run_slope_sd, &mut session.errors)
            })
            .collect();
        let set_loads = self.set_loads(procedure, setup, session);
        let mechanics_m = mechanics_by_run(procedure, setup, &set_loads);
        let i = setup.direction.index();
        let along_m_per_n = setup.compliance_m_per_n[i][i];
        for (set, mechanics_m) in set_loads.iter().zip(mechanics_m) {
            let repeat = set.planned.repeat;
            let seated_m = slopes[repeat as usize - 1] * along_m_per_n * set.load.force_n;
            let place = Place {
                pose: setup.pose,
                direction: setup.direction,
                repeat,
                target_n: set.planned.target_n,
                shared_zero: procedure.zero == ZeroScope::Cell,
            };
            let displacement_m = mechanics_m + seated_m + set.error_m;
            recorder.add(&place, &set.load, displacement_m, &self.noise);
        }
    }

    /// The loads of a cell as the operator sets them, one after the other.
    fn set_loads(
        &self,
        procedure: &Procedure,
        setup: &CellSetup<'_>,
        session: &mut Session,
    ) -> Vec<SetLoad> {
        let (noise, pace) = (&self.noise, &self.jack.pace);
        let release_s = procedure.release_n().map_or(0.0, |_| pace.release_s);
        let (mut zero_m, mut zero_at_s) = (0.0, session.time_s);
        let (mut force_n, mut hold_s) = (0.0, 0.0);
        let mut set_loads = Vec::with_capacity(setup.planned.len());
        for &planned in &setup.planned {
            if planned.zero_before {
                zero_m = noise.error(noise.zero_sd_m, &mut session.errors);
                session.time_s += jack::seconds(pace.zero_s, &mut session.errors);
                zero_at_s = session.time_s;
            }
            let error_m = if let Some(extra_s) = planned.extra_hold_s {
                let until_s = jack::extra_hold_s(extra_s, hold_s, &mut session.times);
                session.time_s += until_s - hold_s;
                hold_s = until_s;
                noise.error(noise.reading_sd_m, &mut session.errors)
            } else {
                session.time_s += jack::seconds(pace.reading_s, &mut session.errors)
                    + jack::seconds(release_s, &mut session.times);
                let tolerance_n = procedure.settle.force_tolerance_n;
                force_n = jack::force_n(planned.target_n, tolerance_n, &mut session.errors);
                let error_m = noise.error(noise.reading_sd_m, &mut session.errors);
                hold_s = jack::seconds(pace.hold_s, &mut session.errors);
                error_m
            };
            let temperature_deg_c = session.temperature.at(session.time_s);
            set_loads.push(SetLoad {
                planned,
                load: LoadPoint {
                    step: planned.step,
                    branch: planned.branch,
                    force_n,
                    hold_s,
                    time_s: session.time_s,
                    since_zero_s: session.time_s - zero_at_s,
                    temperature_deg_c,
                    warming_k: temperature_deg_c - session.temperature.at(zero_at_s),
                },
                error_m: zero_m + error_m,
            });
        }
        set_loads
    }
}

/// Displacement at each load of a cell, m, in the order of the loads; each run is handed to the mechanics as a whole.
fn mechanics_by_run(
    procedure: &Procedure,
    setup: &CellSetup<'_>,
    set_loads: &[SetLoad],
) -> Vec<f64> {
    let mut runs: Vec<Vec<usize>> = vec![Vec::new(); procedure.repeats as usize];
    for (place, set) in set_loads.iter().enumerate() {
        runs[set.planned.repeat as usize - 1].push(place);
    }
    let mut displacements_m = vec![0.0; set_loads.len()];
    for (places, repeat) in runs.into_iter().zip(1..) {
        let run = RunLoads {
            pose: setup.pose,
            direction: setup.direction,
            repeat,
            release_n: procedure.release_n(),
            loads: places.iter().map(|&place| set_loads[place].load).collect(),
        };
        let run_m = mechanics(&setup.compliance_m_per_n, &run);
        for (place, displacement_m) in places.into_iter().zip(run_m) {
            displacements_m[place] = displacement_m;
        }
    }
    displacements_m
}

#[cfg(test)]
mod tests;
