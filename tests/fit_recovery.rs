//! Known factors, simulated sessions, and whether the fit's intervals hold what they promise.
//!
//! The virtual bench makes the data with its own noise; the fit sees readings only.

#![expect(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test stops at what is not as it must be and shows what it found"
)]

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use stiffbench::bench::{BenchPlan, Jack, NoiseModel, VirtualBench};
use stiffbench::fit::{
    FACTOR_NAMES, FitOptions, FitOutcome, FitProblem, MeasuredStiffness, fit_cells,
};
use stiffbench::robot::{FittingFactors, Robot, shipped_robot};
use stiffbench::stiffness::{Gauges, Method, StiffnessOptions, stiffness_table};

/// True factors of a seed: those of the file with the beams' varied by up to two either way, so that no seed is special.
fn truth(start: &FittingFactors, seed: u64) -> FittingFactors {
    let mut rng = ChaCha8Rng::seed_from_u64(1_000_000 + seed);
    let mut factors = *start;
    for factor in &mut factors.beam {
        *factor *= 2f64.powf(2.0 * rng.random::<f64>() - 1.0);
    }
    factors
}

fn simulate_and_fit(robot: &Robot, mechanism: &str, seed: u64) -> (FittingFactors, FitOutcome) {
    let mechanism = robot.mechanism(Some(mechanism)).unwrap();
    let (_, start) = robot.default_factors();
    let factors = truth(&start, seed);
    let mut bench = VirtualBench::new(
        robot,
        mechanism,
        &factors,
        NoiseModel::default(),
        Jack::default(),
    )
    .unwrap();
    let plan = BenchPlan::sweeps(robot.poses.iter().map(|named| named.id.clone()).collect());
    let readings = bench.run(&plan, "s", seed).unwrap();
    let table = stiffness_table(
        &readings.readings,
        &Gauges::default(),
        StiffnessOptions::default(),
    );
    let measured = MeasuredStiffness::from_table(&table, Method::Regression);
    let problem = FitProblem {
        robot,
        mechanism,
        measured: &measured,
        start: &start,
    };
    (
        factors,
        fit_cells(&problem, &FitOptions::default()).unwrap(),
    )
}

/// Coverage of the 95 % intervals of the factors reported as identified, over seeds; prints it by factor.
fn coverage(robot_name: &str, mechanism: &str, seeds: u64) -> f64 {
    let robot = Robot::parse(&shipped_robot(robot_name).unwrap()).unwrap();
    let hits: Vec<Vec<Option<bool>>> = (0..seeds)
        .into_par_iter()
        .map(|seed| {
            let (truth, outcome) = simulate_and_fit(&robot, mechanism, seed);
            (0..4)
                .map(|i| {
                    outcome.estimates[i]
                        .interval_95
                        .map(|[lower, upper]| (lower..=upper).contains(&truth.beam[i]))
                })
                .collect()
        })
        .collect();
    let (mut inside, mut all) = (0, 0);
    for factor in 0..4 {
        let identified: Vec<bool> = hits.iter().filter_map(|seed| seed[factor]).collect();
        let covered = identified.iter().filter(|hit| **hit).count();
        println!(
            "{robot_name} {mechanism} {}: {covered} of {} identified ({seeds} seeds)",
            FACTOR_NAMES[factor],
            identified.len()
        );
        inside += covered;
        all += identified.len();
    }
    let share = inside as f64 / all as f64;
    println!(
        "{robot_name} {mechanism}: coverage {:.2} % of {all} intervals",
        100.0 * share
    );
    share
}

#[test]
fn intervals_cover_in_93_to_97_percent_of_1000_seeds() {
    for mechanism in ["F", "A"] {
        let share = coverage("hp-robot", mechanism, 1000);
        assert!(
            (0.93..=0.97).contains(&share),
            "mechanism {mechanism}: {share}"
        );
    }
}
