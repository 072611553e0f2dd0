//! Absolute positions of a robot that exists as a model: own weight moves it, and a tracker that stands anywhere sees a point of its tool.

use std::f64::consts::PI;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use stiffbench_beams::physics::{ActingPhysics, JointRotations, LoadPoint, Mechanics, RunLoads};
use stiffbench_beams::robot::{
    FittingFactors, JointModel, Predictor, Robot, Theory, TrackerFrames,
};
use stiffbench_measurement::load_cases::{LoadAxes, LoadCase, LoadCaseTable};
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::read_axis::ReadAxis;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::load_cases::{joint_values, next_pose, random_force, simulated_table};
use super::noise::{NoiseModel, rounded};
use super::virtual_bench::BenchError;

/// The tracker stands no farther than this from the base along each of its axes, m.
const FARTHEST_BASE_M: f64 = 3.0;

/// The measured point lies no farther than this from the tool centre along each axis of the tool, m.
const FARTHEST_POINT_M: f64 = 0.15;

/// Which positions are made.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PositionPlan {
    /// How many.
    pub count: usize,
    /// Size of the largest force on the tool, N: every second position has a force of any direction; `None`: own weight alone.
    pub largest_force_n: Option<f64>,
    /// How often each position is taken.
    pub repeats: u32,
    /// Names of poses that are taken in turn; `None`: a random pose within the limits for each position.
    pub poses: Option<Vec<PoseId>>,
}

/// Positions with the truth behind them.
#[derive(Debug, Clone, PartialEq)]
pub struct SimulatedPositions {
    /// The positions.
    pub table: LoadCaseTable,
    /// Where the tracker stands, and which point of the tool it sees.
    pub frames: TrackerFrames,
}

/// Positions of a tracker, each coordinate with the error of a reading. The base frame and the measured point of the tool are drawn by the seed.
///
/// Motions are small: weight and forces act in the pose of the rigid robot, laws of joints and springs on both together. Zeros and slopes of runs have no meaning here, and no error.
/// The same seed gives the same table.
///
/// # Errors
/// [`BenchError`] for noise that cannot be, a robot without weight and forces, a pose that is not there or cannot be reached, a structure that
/// carries nothing, and a robot whose limits leave no pose.
pub fn simulate_positions(
    robot: &Robot,
    physics: &ActingPhysics,
    factors: &FittingFactors,
    plan: &PositionPlan,
    noise: &NoiseModel,
    seed: u64,
) -> Result<SimulatedPositions, BenchError> {
    noise.check()?;
    // Frames, poses and loads come from streams of their own: they are the same for any noise.
    let [mut of_frames, mut choices, mut errors] = [2, 0, 1].map(|stream| {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(stream);
        random
    });
    let frames = random_frames(&mut of_frames);
    let (mechanism, factors) = (&physics.mechanism, &physics.with_springs(factors));
    let theory = Theory::EulerBernoulli;
    let mut predictor = Predictor::with(robot, mechanism, &JointModel::Rigid, theory, factors)?;
    let mut mechanics: Option<Mechanics<'_>> = None;
    let mut joint_rotations = JointRotations::default();
    let mut cases = Vec::new();
    for number in 0..plan.count {
        let named = plan.poses.as_deref();
        let (name, pose) = next_pose(robot, named, number, &mut predictor, &mut choices)?;
        if plan.largest_force_n.is_none() && predictor.model().weight().is_empty() {
            let robot = robot.name.clone();
            return Err(BenchError::NoWeight { robot });
        }
        let force_n = match plan.largest_force_n {
            Some(largest_n) if number % 2 == 1 => random_force(largest_n, &mut choices),
            _ => [0.0; 3],
        };
        let solved = match &mut mechanics {
            Some(known) => {
                known.move_to(0, &pose)?;
                known
            }
            none => {
                let poses = std::slice::from_ref(&pose);
                let mut first = Mechanics::rigid_with(robot, mechanism, &[], factors, poses)?;
                first.weigh(&[])?;
                none.insert(first)
            }
        };
        solved.solve_joints(|_| true)?;
        let tool = robot.end_pose(mechanism, &pose)?;
        let mut exact_m = frames.position_m(&tool, &[0.0; 6]);
        let [x, y, z] = force_n;
        let load = LoadDirection::of_wrench([x, y, z, 0.0, 0.0, 0.0]);
        let (load, amount) = load.unwrap_or_else(|| (Direction::Z.into(), 0.0));
        for axis in Direction::ALL {
            let run = RunLoads {
                pose: &name,
                load: &load,
                read: ReadAxis::new(axis, false, frames.read_unit(&tool, axis)),
                repeat: 1,
                release_n: None,
                loads: &[LoadPoint {
                    force_n: amount,
                    ..LoadPoint::default()
                }],
            };
            let mut moved = [0.0];
            let laws = &physics.laws;
            laws.displacements_m(solved.pose(0), &run, &mut joint_rotations, &mut moved);
            exact_m[axis.index()] += moved[0];
        }
        for repeat in 1..=plan.repeats {
            let position_m = exact_m.map(|exact_m| {
                let read_m = exact_m + noise.error(noise.reading_sd_m, &mut errors);
                Some(rounded(read_m, noise.displacement_step_m))
            });
            cases.push(LoadCase {
                line: cases.len() as u32 + 2,
                pose: name.clone(),
                joints: joint_values(robot, &pose),
                repeat,
                axes: LoadAxes::Base,
                force_n: force_n.map(|force| rounded(force, noise.force_step_n)),
                moment_nm: [0.0; 3],
                displacement_m: [None; 3],
                rotation_rad: [None; 3],
                position_m,
            });
        }
    }
    Ok(SimulatedPositions {
        table: simulated_table(robot, cases),
        frames,
    })
}

/// A tracker that stands and is turned anyhow.
fn random_frames(random: &mut ChaCha8Rng) -> TrackerFrames {
    let mut within =
        |farthest: f64| [0.0; 3].map(|_: f64| random.random_range(-farthest..farthest));
    let (base_m, tool_point_m) = (within(FARTHEST_BASE_M), within(FARTHEST_POINT_M));
    let axis: [f64; 3] = std::array::from_fn(|_| StandardNormal.sample(random));
    let length = axis.iter().map(|x: &f64| x * x).sum::<f64>().sqrt();
    let angle = random.random_range(0.0..PI) / length.max(f64::MIN_POSITIVE);
    TrackerFrames {
        base_m,
        tool_point_m,
        ..TrackerFrames::IDENTITY
    }
    .turned(axis.map(|x| angle * x))
}
