//! Follows a procedure on a robot that exists as a beam model.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;

use stiffbench_beams::physics::{ActingPhysics, LoadPoint, Mechanics, PoseMechanics};
use stiffbench_beams::robot::{FittingFactors, Pose, Robot, RobotError};
use stiffbench_measurement::procedure::{PlannedReading, Procedure, ProcedureProblem};
use stiffbench_measurement::readings::{ReadingTable, ZeroScope};
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::STREAM_OF_TIMES;
use super::jack::{self, Jack};
use super::mechanics::{ActingLoad, CellMechanics};
use super::noise::NoiseModel;
use super::recorder::{RecordedCell, Recorder};
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
    /// Positions of a robot that nothing loads.
    #[error("robot {robot} has no masses and no payload: its own weight does not move it")]
    #[diagnostic(
        code(stiffbench::bench::no_weight),
        help(
            "state them in the robot file ([masses], payload of [tool]), or give forces with --loads-n"
        )
    )]
    NoWeight {
        /// The robot.
        robot: String,
    },
    /// A pose or direction that the procedure does not have.
    #[error("the procedure has no {what}")]
    #[diagnostic(code(stiffbench::bench::not_planned), help("it has {planned}"))]
    NotPlanned {
        /// What it does not have.
        what: String,
        /// What it has.
        planned: String,
    },
}

/// A robot on a bench, in software.
#[derive(Debug)]
pub struct VirtualBench<'a> {
    robot: &'a Robot,
    physics: &'a ActingPhysics,
    factors: FittingFactors,
    noise: NoiseModel,
    jack: Jack,
    keep_history: bool,
}

/// What belongs to one pose and direction.
struct CellSetup<'a> {
    pose: &'a PoseId,
    load: &'a LoadDirection,
    /// The axes along which displacements are read.
    read: Vec<Direction>,
    structure: &'a PoseMechanics,
    planned: Vec<PlannedReading>,
}

/// The loads of a cell as the operator set them, with the errors of their readings.
#[derive(Default)]
struct SetLoads {
    loads: Vec<ActingLoad>,
    /// Zero and reading together at each load, m, of each gauge.
    errors_m: Vec<Vec<f64>>,
}

/// Clock, thermometer and random numbers of a session.
struct SimulatedSession {
    errors: ChaCha8Rng,
    times: ChaCha8Rng,
    temperature: TemperatureTrack,
    time_s: f64,
}

impl SimulatedSession {
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
    /// Sets a mechanism with its true factors on the bench, and whatever physics acts in it.
    ///
    /// # Errors
    /// [`BenchError::Noise`].
    pub fn new(
        robot: &'a Robot,
        physics: &'a ActingPhysics,
        factors: &FittingFactors,
        noise: NoiseModel,
        jack: Jack,
    ) -> Result<Self, BenchError> {
        noise.check()?;
        Ok(Self {
            robot,
            physics,
            factors: physics.with_springs(factors),
            noise,
            jack,
            keep_history: false,
        })
    }

    /// Joints stay as a run left them when the next run of the cell begins, as sliders of a real joint do, instead of starting virgin.
    #[must_use]
    pub fn keeping_history(self, keep_history: bool) -> Self {
        Self {
            keep_history,
            ..self
        }
    }

    /// Follows a procedure; the same seed gives the same readings. Poses that it leaves open are all of the robot's. Gauges along base axes
    /// give a reading each under every load, as [`read_readings`](stiffbench_measurement::readings::read_readings) has them.
    ///
    /// The gauge is zeroed without load: the preload of the procedure is a matter of a real contact. Every run starts virgin unless
    /// [`VirtualBench::keeping_history`] says otherwise.
    ///
    /// # Errors
    /// [`BenchError::Procedure`]; [`BenchError::Robot`] for a pose that is unknown or cannot be reached.
    pub fn run(
        &self,
        procedure: &Procedure,
        name: &str,
        seed: u64,
    ) -> Result<ReadingTable, BenchError> {
        procedure.check()?;
        procedure.check_directions()?;
        let named = || self.robot.poses.iter().map(|named| named.id.clone());
        let poses = procedure.poses.clone().unwrap_or_else(|| named().collect());
        let angles: Vec<Pose> = poses
            .iter()
            .map(|pose| self.robot.pose(pose).cloned())
            .collect::<Result<_, _>>()?;
        let mechanism = &self.physics.mechanism;
        let mechanics = Mechanics::new(self.robot, mechanism, &self.factors, &angles)?;
        let mut session = SimulatedSession::new(seed);
        let mut recorder = Recorder::new(name, &self.noise);
        let mut cell = 0;
        for (number, pose) in poses.iter().enumerate() {
            for (place, load) in procedure.directions.iter().enumerate() {
                let setup = CellSetup {
                    pose,
                    load,
                    read: procedure.axes_read_under(load),
                    structure: mechanics.pose(number),
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
        let mut table = recorder.finish();
        if !procedure.displacement_axes.is_empty() {
            table.pose_joints.clone_from(&procedure.joint_values);
        }
        Ok(table)
    }

    fn run_cell(
        &self,
        procedure: &Procedure,
        setup: &CellSetup<'_>,
        session: &mut SimulatedSession,
        recorder: &mut Recorder<'_>,
    ) {
        let slopes: Vec<f64> = (0..procedure.repeats)
            .map(|_| {
                self.noise
                    .error(self.noise.run_slope_sd, &mut session.errors)
            })
            .collect();
        let mut set = self.set_loads(procedure, setup, session);
        for load in &mut set.loads {
            load.run_slope = slopes[load.repeat as usize - 1];
        }
        let along_m = CellMechanics {
            laws: &self.physics.laws,
            structure: setup.structure,
            pose: setup.pose,
            load: setup.load,
            release_n: procedure.release_n(),
            keep_history: self.keep_history,
            zero_each_run: procedure.zero == ZeroScope::Run,
        }
        .along_m(&setup.read, &set.loads);
        let cell = RecordedCell {
            pose: setup.pose,
            load: setup.load,
            read: &setup.read,
            repeats: procedure.repeats,
            shared_zero: procedure.zero == ZeroScope::Cell,
        };
        recorder.begin(&cell);
        for (place, (load, planned)) in set.loads.iter().zip(&setup.planned).enumerate() {
            let shown_m = setup.read.iter().zip(&set.errors_m[place]);
            let shown_m = shown_m.map(|(&axis, error_m)| along_m[place][axis.index()] + error_m);
            let shown_m: Vec<f64> = shown_m.collect();
            recorder.add(&cell, planned.target_n, load, &shown_m);
        }
    }

    /// The loads of a cell as the operator sets them, one after the other.
    fn set_loads(
        &self,
        procedure: &Procedure,
        setup: &CellSetup<'_>,
        session: &mut SimulatedSession,
    ) -> SetLoads {
        let (noise, pace) = (&self.noise, &self.jack.pace);
        let release_s = procedure.release_n().map_or(0.0, |_| pace.release_s);
        let mut zeros_m = vec![0.0; setup.read.len()];
        let mut zero_at_s = session.time_s;
        let (mut force_n, mut hold_s) = (0.0, 0.0);
        let mut set = SetLoads::default();
        let reading_errors = |zeros_m: &[f64], errors: &mut ChaCha8Rng| -> Vec<f64> {
            let errors_m = zeros_m.iter();
            errors_m
                .map(|zero_m| zero_m + noise.error(noise.reading_sd_m, errors))
                .collect()
        };
        for &planned in &setup.planned {
            if planned.zero_before {
                for zero_m in &mut zeros_m {
                    *zero_m = noise.error(noise.zero_sd_m, &mut session.errors);
                }
                session.time_s += jack::seconds(pace.zero_s, &mut session.errors);
                zero_at_s = session.time_s;
            }
            let errors_m = if let Some(extra_s) = planned.extra_hold_s {
                let until_s = jack::extra_hold_s(extra_s, hold_s, &mut session.times);
                session.time_s += until_s - hold_s;
                hold_s = until_s;
                reading_errors(&zeros_m, &mut session.errors)
            } else {
                session.time_s += jack::seconds(pace.reading_s, &mut session.errors)
                    + jack::seconds(release_s, &mut session.times);
                let tolerance_n = procedure.settle.force_tolerance_n;
                force_n = jack::force_n(planned.target_n, tolerance_n, &mut session.errors);
                let errors_m = reading_errors(&zeros_m, &mut session.errors);
                hold_s = jack::seconds(pace.hold_s, &mut session.errors);
                errors_m
            };
            let temperature_deg_c = session.temperature.at(session.time_s);
            set.errors_m.push(errors_m);
            set.loads.push(ActingLoad {
                point: LoadPoint {
                    force_n,
                    step: planned.step,
                    hold_s,
                    since_zero_s: session.time_s - zero_at_s,
                    warming_k: temperature_deg_c - session.temperature.at(zero_at_s),
                    position_m: None,
                    seated_m: 0.0,
                    is_unloaded: planned.target_n == 0.0,
                },
                run_slope: 0.0,
                repeat: planned.repeat,
                branch: planned.branch,
                time_s: session.time_s,
                temperature_deg_c,
            });
        }
        set
    }
}

#[cfg(test)]
mod tests;
