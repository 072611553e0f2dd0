//! Robots that ship, where they stand, and how they yield there.

use stiffbench_beams::physics::{JointRotations, LawSet, LoadPoint, PoseMechanics, RunLoads};
use stiffbench_beams::robot::{
    FittingFactors, Keep, ModelParameter, MultiPosePredictor, Pose, PoseSweep, Predictor, Robot,
};
use stiffbench_beams::structure::Compliance6;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::read_axis::ReadAxis;
use stiffbench_units_and_text::test_point::PoseId;

/// A robot that ships, by name.
pub(crate) fn shipped(name: &str) -> Robot {
    Robot::parse(&stiffbench_test_files::shipped_robot(name).unwrap()).unwrap()
}

/// The pose of these values of the variables.
pub(crate) fn at_values(values: &[f64]) -> Pose {
    Pose {
        angles_deg: values.to_vec(),
    }
}

/// The poses that a robot's file names.
pub(crate) fn named_poses(robot: &Robot) -> Vec<Pose> {
    robot.poses.iter().map(|named| named.pose.clone()).collect()
}

/// A pose whose variables stand at the given shares of their ranges.
pub(crate) fn pose_at(robot: &Robot, shares: &[f64]) -> Pose {
    let variables = robot.variables.iter().zip(shares);
    let values = variables.map(|(v, share)| v.min_deg + share * (v.max_deg - v.min_deg));
    at_values(&values.collect::<Vec<f64>>())
}

/// Poses on a lattice of the pose space that repeats nowhere.
pub(crate) fn lattice(robot: &Robot, count: u32) -> Vec<Pose> {
    let at = |i: u32| {
        let shares =
            (1..=robot.variables.len()).map(|j| (f64::from(i) * 0.618_034 * j as f64).fract());
        pose_at(robot, &shares.collect::<Vec<f64>>())
    };
    (0..count).map(at).collect()
}

/// Factors of ten to these powers, of beams first.
pub(crate) fn factors_of_powers(exponents: &[f64]) -> FittingFactors {
    let power = |i: usize| 10_f64.powf(exponents[i]);
    FittingFactors::of_classes(
        std::array::from_fn(power),
        std::array::from_fn(|i| power(4 + i)),
    )
}

/// The whole robot in a pose, with the factors of nothing fitted.
pub(crate) fn predictor<'a>(robot: &'a Robot, pose: &Pose) -> Predictor<'a> {
    let mechanism = robot.mechanism(None).unwrap();
    let mut predictor = Predictor::new(robot, mechanism, &FittingFactors::UNIT).unwrap();
    predictor.place(pose).unwrap();
    predictor
}

/// The compliance in a pose as a sweep has it, which must take the robot in SIMD registers.
pub(crate) fn swept(robot: &Robot, pose: &Pose) -> Compliance6 {
    let mechanism = robot.mechanism(None).unwrap();
    let sweep = PoseSweep::new(robot, mechanism, &FittingFactors::UNIT).unwrap();
    let swept = sweep.run(std::slice::from_ref(pose), Keep::Full);
    assert_eq!(swept.alone, 0, "SIMD registers take it");
    swept.compliances[0].unwrap()
}

/// Displacements of a run under loads one after the other, m.
pub(crate) fn displacements(
    laws: &LawSet,
    id: &PoseId,
    pose: &PoseMechanics,
    (load, read): (&LoadDirection, ReadAxis),
    forces_n: &[f64],
) -> Vec<f64> {
    let load_point = |force_n: &f64| LoadPoint {
        force_n: *force_n,
        ..LoadPoint::default()
    };
    let loads: Vec<LoadPoint> = forces_n.iter().map(load_point).collect();
    let run = RunLoads {
        pose: id,
        load,
        read,
        repeat: 1,
        release_n: None,
        loads: &loads,
    };
    let mut moved = vec![0.0; loads.len()];
    laws.displacements_m(pose, &run, &mut JointRotations::default(), &mut moved);
    moved
}

/// Fails if derivatives of the compliance of the first pose are not its central differences, by a share of the diagonal.
pub(crate) fn assert_differences(
    together: &mut MultiPosePredictor<'_>,
    values: &FittingFactors,
    parameters: &[ModelParameter],
    derivatives: &[Compliance6],
    bound: f64,
) {
    together.solve(values, false).unwrap();
    let start = together.compliance(0).unwrap();
    for (parameter, derivative) in parameters.iter().zip(derivatives) {
        // A spring that is rigid is tried where it yields a little.
        let value = match values.get(parameter) {
            0.0 => 1e-8,
            value => value,
        };
        // The derivatives of factors are those to their logarithms.
        let unit = if parameter.is_factor() { 1.0 } else { value };
        let mut at = |share: f64| {
            let mut moved = values.clone();
            moved.set(parameter, value * (1.0 + share));
            together.solve(&moved, false).unwrap();
            together.compliance(0).unwrap()
        };
        let (up, down) = (at(1e-3), at(-1e-3));
        for i in 0..6 {
            for j in 0..6 {
                let slope = (up.0[i][j] - down.0[i][j]) / 2e-3;
                let scale = (start.0[i][i] * start.0[j][j]).sqrt();
                let error = (derivative.0[i][j] * unit - slope).abs();
                assert!(error <= bound * scale, "{parameter} {i} {j}: {error:e}");
            }
        }
    }
}
