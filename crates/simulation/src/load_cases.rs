//! Load cases of a robot that exists as a model: loads in any direction in poses of its own choice, displacements as vectors.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use stiffbench_beams::physics::{ActingPhysics, LoadPoint, Mechanics};
use stiffbench_beams::robot::{
    FittingFactors, JointModel, JointMotion, Pose, Predictor, Robot, RobotError, Theory,
};
use stiffbench_measurement::load_cases::{
    JointColumn, JointUnit, LoadAxes, LoadCase, LoadCaseTable,
};
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::{Branch, Direction, PoseId};

use super::mechanics::{ActingLoad, CellMechanics};
use super::noise::{NoiseModel, rounded};
use super::virtual_bench::BenchError;

/// Tries at a pose within the limits before the robot counts as one that cannot be posed at random.
const MOST_TRIES: usize = 10_000;

/// Smallest size of a load as a share of the largest.
const SMALLEST_SHARE: f64 = 0.4;

/// Which load cases are made.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadCasePlan {
    /// How many loads.
    pub count: usize,
    /// Size of the largest force, N; sizes are spread evenly from 0.4 of it, directions over the sphere.
    pub largest_force_n: f64,
    /// How often each load is applied.
    pub repeats: u32,
    /// Named poses, one load after the other in each in turn; `None`: a random pose within the limits for each load.
    pub poses: Option<Vec<PoseId>>,
}

/// Load cases with errors: each displacement has that of a reading and of a zero, each application an error of its slope. Laws act from the
/// unloaded state, every time anew.
///
/// The same seed gives the same table.
///
/// # Errors
/// [`BenchError`] for noise that cannot be, a pose that is not there or cannot be reached, a structure that carries nothing, and a robot
/// whose limits leave no pose.
pub fn simulate_load_cases(
    robot: &Robot,
    physics: &ActingPhysics,
    factors: &FittingFactors,
    plan: &LoadCasePlan,
    noise: &NoiseModel,
    seed: u64,
) -> Result<LoadCaseTable, BenchError> {
    noise.check()?;
    let (mechanism, factors) = (&physics.mechanism, &physics.with_springs(factors));
    // Poses and loads come from a stream of their own: they are the same for any noise.
    let mut choices = ChaCha8Rng::seed_from_u64(seed);
    let mut errors = ChaCha8Rng::seed_from_u64(seed);
    errors.set_stream(1);
    let theory = Theory::EulerBernoulli;
    let mut predictor = Predictor::with(robot, mechanism, &JointModel::Rigid, theory, factors)?;
    let mut mechanics: Option<Mechanics<'_>> = None;
    let mut cases = Vec::new();
    for number in 0..plan.count {
        let named = plan.poses.as_deref();
        let (name, pose) = next_pose(robot, named, number, &mut predictor, &mut choices)?;
        let force_n = random_force(plan.largest_force_n, &mut choices);
        let mechanics = match &mut mechanics {
            Some(mechanics) => {
                mechanics.move_to(0, &pose)?;
                mechanics.solve_joints(|_| true)?;
                mechanics
            }
            none => none.insert(Mechanics::new(
                robot,
                mechanism,
                factors,
                std::slice::from_ref(&pose),
            )?),
        };
        let structure = mechanics.pose(0);
        let [x, y, z] = force_n;
        let Some((load, amount_n)) = LoadDirection::of_wrench([x, y, z, 0.0, 0.0, 0.0]) else {
            continue;
        };
        let cell = CellMechanics {
            laws: &physics.laws,
            structure,
            pose: &name,
            load: &load,
            release_n: None,
            keep_history: false,
            zero_each_run: false,
        };
        let applied = (1..=plan.repeats).map(|repeat| ActingLoad {
            point: LoadPoint {
                force_n: amount_n,
                step: 1,
                ..LoadPoint::default()
            },
            run_slope: 0.0,
            repeat,
            branch: Branch::Loading,
            time_s: 0.0,
            temperature_deg_c: 0.0,
        });
        let applied: Vec<ActingLoad> = applied.collect();
        let moved_m = cell.along_m(&Direction::ALL, &applied);
        for (acting, moved_m) in applied.iter().zip(moved_m) {
            let slope = noise.error(noise.run_slope_sd, &mut errors);
            let displacement_m = Direction::ALL.map(|axis| {
                let seated_m = slope * structure.compliance(&axis.into(), &load) * amount_n;
                let zero_m = noise.error(noise.zero_sd_m, &mut errors);
                let error_m = zero_m + noise.error(noise.reading_sd_m, &mut errors);
                let read_m = moved_m[axis.index()] + seated_m + error_m;
                Some(rounded(read_m, noise.displacement_step_m))
            });
            cases.push(LoadCase {
                line: cases.len() as u32 + 2,
                pose: name.clone(),
                joints: joint_values(robot, &pose),
                repeat: acting.repeat,
                axes: LoadAxes::Base,
                force_n: force_n.map(|force| rounded(force, noise.force_step_n)),
                moment_nm: [0.0; 3],
                displacement_m,
                rotation_rad: [None; 3],
                position_m: [None; 3],
            });
        }
    }
    Ok(simulated_table(robot, cases))
}

/// Load cases with a column for each variable of the robot.
pub(super) fn simulated_table(robot: &Robot, cases: Vec<LoadCase>) -> LoadCaseTable {
    let joints = robot.variables.iter().map(|variable| JointColumn {
        variable: variable.name.clone(),
        unit: match variable.motion {
            JointMotion::Turns => JointUnit::Angle,
            JointMotion::Slides => JointUnit::Length,
        },
    });
    LoadCaseTable {
        source: "simulated".to_owned(),
        joints: joints.collect(),
        cases,
        ..LoadCaseTable::default()
    }
}

/// The named poses in turn, else one at random, where the predictor then stands.
pub(super) fn next_pose(
    robot: &Robot,
    named: Option<&[PoseId]>,
    number: usize,
    predictor: &mut Predictor<'_>,
    random: &mut ChaCha8Rng,
) -> Result<(PoseId, Pose), BenchError> {
    match named {
        Some(names) if !names.is_empty() => {
            let name = &names[number % names.len()];
            let pose = robot.pose(name)?.clone();
            predictor.place(&pose)?;
            Ok((name.clone(), pose))
        }
        _ => Ok((
            PoseId::new(&(number + 1).to_string()),
            random_pose(robot, predictor, random)?,
        )),
    }
}

/// A pose evenly distributed within the limits, where the predictor then stands.
fn random_pose(
    robot: &Robot,
    predictor: &mut Predictor<'_>,
    random: &mut ChaCha8Rng,
) -> Result<Pose, BenchError> {
    let mut why = None;
    for _ in 0..MOST_TRIES {
        let angles = robot.variables.iter().map(|variable| {
            let share: f64 = random.random_range(0.0..1.0);
            let value = variable.min_deg + share * (variable.max_deg - variable.min_deg);
            // Files state angles to a thousandth of a degree; a micrometre of a distance is as good.
            let steps = if variable.motion == JointMotion::Turns {
                1e3
            } else {
                1e6
            };
            (value * steps).round() / steps
        });
        let pose = Pose {
            angles_deg: angles.collect(),
        };
        if !robot.is_within_limits(&pose) {
            continue;
        }
        match predictor.place(&pose) {
            Ok(()) => return Ok(pose),
            Err(error @ RobotError::Unreachable { .. }) => why = Some(error),
            Err(error) => return Err(error.into()),
        }
    }
    Err(why.map_or_else(
        || BenchError::NotPlanned {
            what: format!("pose within the limits of {} at random", robot.name),
            planned: "limits that no pose meets: name poses with --poses".to_owned(),
        },
        BenchError::Robot,
    ))
}

/// Values of the variables in a pose, rad and m.
pub(super) fn joint_values(robot: &Robot, pose: &Pose) -> Vec<f64> {
    let values = robot.variables.iter().zip(&pose.angles_deg);
    values
        .map(|(variable, value)| match variable.motion {
            JointMotion::Turns => value.to_radians(),
            JointMotion::Slides => *value,
        })
        .collect()
}

/// A force of any direction.
pub(super) fn random_force(largest_n: f64, random: &mut ChaCha8Rng) -> [f64; 3] {
    let direction: [f64; 3] = std::array::from_fn(|_| StandardNormal.sample(random));
    let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
    let share: f64 = random.random_range(SMALLEST_SHARE..1.0);
    direction.map(|x| x / length.max(f64::MIN_POSITIVE) * share * largest_n)
}
