//! What tests have in common: shipped robots, what a virtual bench measures on them, and fits to that.

use stiffbench_beams::physics::{ActingPhysics, Effect};
use stiffbench_beams::robot::{FittingFactors, Robot};
use stiffbench_diagnosis::fit::{
    FitError, FitOptions, FitOutcome, FitProblem, FixedPhysics, MeasuredStiffness, fit_cells,
};
use stiffbench_measurement::procedure::Procedure;
use stiffbench_measurement::readings::Reading;
use stiffbench_measurement::stiffness::{
    GaugePair, Method, StiffnessOptions, StiffnessTable, stiffness_table,
};
use stiffbench_simulation::{Jack, NoiseModel, VirtualBench};
use stiffbench_test_files::shipped_robot;

pub(crate) fn robot(name: &str) -> Robot {
    Robot::parse(&shipped_robot(name).unwrap()).unwrap()
}

pub(crate) fn hp_robot() -> Robot {
    robot("hp-robot")
}

/// Effects, by their texts, that act on a mechanism; `None` for the first.
pub(crate) fn acting(robot: &Robot, mechanism: Option<&str>, effects: &[&str]) -> ActingPhysics {
    let effects: Vec<Effect> = effects.iter().map(|text| text.parse().unwrap()).collect();
    ActingPhysics::new(robot, robot.mechanism(mechanism).unwrap(), effects).unwrap()
}

pub(crate) fn table(readings: &[Reading]) -> StiffnessTable {
    stiffness_table(readings, &GaugePair::default(), StiffnessOptions::default())
}

/// The stiffness that a session of the default procedure shows.
pub(crate) fn measured(
    robot: &Robot,
    (physics, factors): (&ActingPhysics, &FittingFactors),
    (noise, seed): (NoiseModel, u64),
    method: Method,
) -> MeasuredStiffness {
    let bench = VirtualBench::new(robot, physics, factors, noise, Jack::default()).unwrap();
    let session = bench.run(&Procedure::default(), "s", seed).unwrap();
    MeasuredStiffness::from_table(&table(&session.readings), method)
}

/// A fit that starts from the factors of the robot file.
pub(crate) fn fit(
    robot: &Robot,
    (mechanism, physics): (Option<&str>, Option<&FixedPhysics>),
    measured: &MeasuredStiffness,
    options: &FitOptions,
) -> Result<FitOutcome, FitError> {
    let (_, start) = robot.default_factors();
    let problem = FitProblem {
        robot,
        mechanism: robot.mechanism(mechanism).unwrap(),
        measured,
        start: &start,
        physics,
    };
    fit_cells(&problem, options)
}
