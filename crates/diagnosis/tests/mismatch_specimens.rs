//! What is said of tables without a robot: straight lines with something in them that this test has put there.

use std::fmt::Write as _;

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use stiffbench_beams::physics::laws;
use stiffbench_diagnosis::mismatch::{
    Diagnosis, SearchOptions, Verdict, diagnose, laws_that_need_a_robot, specimen_bench,
};
use stiffbench_measurement::specimen::{SpecimenOptions, read_specimen};

/// Slope of the lines, um/N, and largest load, N.
const SLOPE: f64 = 15.0;
const LARGEST_N: f64 = 70.0;

/// Readings of one line, um, errors of 1 um; loads in random order.
///
/// # Arguments
/// - `extra_um`: what is there besides, from the place in the order and the number of readings.
fn line(readings: usize, seed: u64, extra_um: impl Fn(usize) -> f64) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut loads: Vec<f64> = (0..readings)
        .map(|place| LARGEST_N * place as f64 / (readings - 1) as f64)
        .collect();
    loads.shuffle(&mut rng);
    let mut table = "order,F_N,d_um\n".to_owned();
    for (place, load) in loads.into_iter().enumerate() {
        let error: f64 = StandardNormal.sample(&mut rng);
        let read = SLOPE * load + extra_um(place) + error;
        writeln!(table, "{},{load},{read:.6}", place + 1).unwrap();
    }
    table
}

fn said(table: &str) -> Diagnosis {
    let options = SpecimenOptions {
        force_column: Some("F_N".to_owned()),
        displacement_column: "d_um".to_owned(),
        order_column: Some("order".to_owned()),
        ..SpecimenOptions::default()
    };
    let table = read_specimen("line.csv", table.as_bytes(), &options).unwrap();
    let (observations, baseline, _) = specimen_bench(&table).unwrap();
    let search = SearchOptions {
        without: laws_that_need_a_robot(),
        ..SearchOptions::default()
    };
    diagnose(&baseline, &observations, &search, None).unwrap().0
}

/// A drift of a given length in standard errors: places in the order, less their mean, are that long.
fn drift(readings: usize, standard_errors: f64) -> impl Fn(usize) -> f64 {
    let middle = 0.5 * (readings - 1) as f64;
    let square: f64 = (0..readings)
        .map(|place| (place as f64 - middle).powi(2))
        .sum();
    move |place| standard_errors / square.sqrt() * (place as f64 - middle)
}

#[test]
fn a_drift_along_enough_readings_is_named_or_among_what_it_could_be() {
    // Of these lines 95 % are to be answered so: with 40 of them, less than 35 has a chance of 1.4 % (binomial).
    let right = (0..40)
        .filter(|&seed| {
            let diagnosis = said(&line(18, seed, drift(18, 6.0)));
            let is_drift = |law| [laws::DRIFT_PER_SECOND, laws::DRIFT_PER_KELVIN].contains(&law);
            diagnosis.findings.iter().any(|f| is_drift(f.effect.law))
        })
        .count();
    assert!(right >= 35, "{right} of 40");
}

#[test]
fn a_dozen_readings_without_repeats_are_too_few() {
    let diagnosis = said(&line(12, 1, drift(12, 6.0)));
    assert_eq!(diagnosis.verdict, Verdict::InsufficientData);
    assert!(diagnosis.lacking[0].contains("18 readings along the line"));
    assert!(diagnosis.findings.is_empty());
}

#[test]
fn an_effect_that_a_trend_explains_as_well_is_not_named() {
    // A drift that swings back and forth is in no library; a slip where it turns would explain a part of it.
    let named = (0..8)
        .map(|seed| {
            let phase = ChaCha8Rng::seed_from_u64(seed).random::<f64>();
            let swing = |place: usize| {
                12.0 * (std::f64::consts::TAU * (place as f64 / 60.0 + phase)).sin()
                    + 5.0 * (place as f64 / 30.0 - 1.0).powi(2)
            };
            said(&line(60, seed, swing))
        })
        .filter(|diagnosis| {
            assert_eq!(diagnosis.verdict, Verdict::Unknown);
            !diagnosis.findings.is_empty()
        })
        .count();
    assert_eq!(named, 0);
}
