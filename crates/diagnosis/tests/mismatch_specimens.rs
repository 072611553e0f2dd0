//! What is said of tables without a robot: straight lines with something in them that this test has put there.

use std::fmt::Write as _;

use rand::seq::SliceRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use stiffbench_beams::physics::{DrivenPath, Law, laws, values_of};
use stiffbench_diagnosis::mismatch::{
    ConfigurationSizes, Diagnosis, Line, NoiseBasis, SearchOptions, Verdict, diagnose,
};
use stiffbench_measurement::specimen::{ResponseVariable, SpecimenOptions, read_specimen};

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

fn said_of(table: &str, options: &SpecimenOptions) -> Diagnosis {
    let table = read_specimen(&[("table.csv", table.as_bytes())], options).unwrap();
    let (baseline, observations) = Line::of_table(&table).unwrap();
    let search = SearchOptions::default();
    diagnose(&baseline, &observations, &search, None).unwrap().0
}

fn said(table: &str) -> Diagnosis {
    let options = SpecimenOptions {
        force_column: Some("F_N".to_owned()),
        displacement_column: "d_um".to_owned(),
        order_column: Some("order".to_owned()),
        ..SpecimenOptions::default()
    };
    said_of(table, &options)
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

/// A long line shows its noise about a smooth curve, whatever is fitted: none that grows or has a memory is asked for.
#[test]
fn a_long_line_shows_its_own_noise() {
    // Of lines with errors alone 95 % are to be answered so: of 40, less than 35 has a chance of 1.4 % (binomial).
    let nothing = (0..40)
        .filter(|&seed| {
            // Errors that swell in the middle, where they say least of the slope.
            let mut rng = ChaCha8Rng::seed_from_u64(100 + seed);
            let swelling: Vec<f64> = (0..40)
                .map(|place: i32| {
                    let swells = 1.0 - (f64::from(place) / 19.5 - 1.0).powi(2);
                    let error: f64 = StandardNormal.sample(&mut rng);
                    swells * error
                })
                .collect();
            let diagnosis = said(&line(40, seed, |place| swelling[place]));
            assert_eq!(diagnosis.noise_basis, NoiseBasis::Neighbours);
            assert_eq!(diagnosis.noise.growth_sd, 0.0);
            diagnosis.verdict == Verdict::NothingMissing
        })
        .count();
    assert!(nothing >= 35, "{nothing} of 40");
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

/// Three cycles of growing size through both signs, in readings a tenth of a second apart.
fn cycles() -> Vec<f64> {
    let turns = [0.0, 0.6, -0.6, 0.8, -0.8, 1.0, -1.0, 0.0];
    let steps = turns
        .windows(2)
        .flat_map(|pair| (0..60).map(|i| pair[0] + (pair[1] - pair[0]) * f64::from(i) / 60.0));
    steps.collect()
}

/// A recording of a part with one law besides its line, errors of a five-hundredth of the line.
///
/// # Arguments
/// - `values`: of the law, for a line whose largest load and answer are one.
fn recording(law: Law, values: &[f64], seed: u64) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let driver = cycles();
    let time_s: Vec<f64> = (0..driver.len()).map(|i| 0.1 * i as f64).collect();
    let mut extra = vec![0.0; driver.len()];
    let path = DrivenPath {
        driver: &driver,
        time_s: &time_s,
    };
    let history = law.history().expect("a law of parts");
    history.answers(&values_of(values), path, &mut extra);
    let mut table = "t_s,driver,answer\n".to_owned();
    for ((time, load), more) in time_s.iter().zip(&driver).zip(&extra) {
        let error: f64 = StandardNormal.sample(&mut rng);
        let answer = load + more + 0.002 * error;
        writeln!(table, "{time:.1},{load:.6},{answer:.6}").unwrap();
    }
    table
}

/// What is said of a part, the force set or the displacement.
fn said_of_part(table: &str, response: ResponseVariable) -> Diagnosis {
    let (force, displacement) = match response {
        ResponseVariable::Displacement => ("driver", "answer"),
        ResponseVariable::Force => ("answer", "driver"),
    };
    let options = SpecimenOptions {
        force_column: Some(force.to_owned()),
        displacement_column: displacement.to_owned(),
        time_column: Some("t_s".to_owned()),
        force_unit: Some("1".to_owned()),
        displacement_unit: Some("1".to_owned()),
        response: Some(response),
        ..SpecimenOptions::default()
    };
    said_of(table, &options)
}

#[test]
fn laws_of_parts_are_named_whichever_quantity_is_set() {
    use ResponseVariable::{Displacement, Force};
    let parts: [(Law, &[f64], ResponseVariable); 15] = [
        (laws::PART_FRICTION, &[0.5, 0.1], Displacement),
        (laws::FRICTION_DUAL, &[0.1, 0.05], Force),
        (laws::BACKLASH_DUAL, &[0.8, 0.3], Force),
        (laws::MAXWELL_SLIP, &[0.5, 0.4], Displacement),
        (laws::MAXWELL_SLIP_DUAL, &[0.2, 0.4], Force),
        (
            laws::LOAD_DEPENDENT_FRICTION,
            &[0.5, 0.05, 0.2],
            Displacement,
        ),
        (
            laws::LOAD_DEPENDENT_FRICTION_DUAL,
            &[0.03, 0.02, 4.0],
            Force,
        ),
        (laws::PRELOADED_BACKLASH, &[0.2, 0.3, 0.05], Displacement),
        (laws::PRELOADED_BACKLASH_DUAL, &[0.8, 0.3, 0.2], Force),
        (laws::ODD_POLYNOMIAL, &[0.4, 0.0], Displacement),
        (laws::END_STOP, &[0.7, 0.7], Displacement),
        (laws::END_STOP_DUAL, &[3.0, 0.7], Force),
        (laws::CONTACT_DUAL, &[2.0, 1.0, 1.5, 0.3], Force),
        (laws::RELAXATION, &[0.5, 3.0], Displacement),
        (laws::RELAXATION_DUAL, &[0.5, 3.0], Force),
    ];
    for (seed, (law, values, response)) in parts.into_iter().enumerate() {
        let diagnosis = said_of_part(&recording(law, values, seed as u64), response);
        let named: Vec<&str> = diagnosis
            .findings
            .iter()
            .map(|f| f.effect.law.row)
            .collect();
        // Alone or in a set; a simpler law that serves as well is right too.
        let is_it =
            |row: &&str| *row == law.row || law.contains.iter().any(|name| row.starts_with(name));
        assert!(
            named.iter().any(is_it),
            "{law:?}: {:?} {named:?}",
            diagnosis.verdict
        );
        assert!(
            matches!(diagnosis.verdict, Verdict::Explained | Verdict::Ambiguous),
            "{law:?}: {:?} {named:?}",
            diagnosis.verdict
        );
    }
}

#[test]
fn sizes_follow_the_number_of_a_configuration_where_they_do() {
    // Play of a column that grows with its height, as the slope does with the square of it.
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut table = "height,load,tilt\n".to_owned();
    let told = |exponent: i32, table: &mut String, rng: &mut ChaCha8Rng| {
        for height in [1.0_f64, 1.5, 2.0, 2.5] {
            for load in cycles() {
                let play = 0.3 * height.powi(exponent) * (load / 0.1).clamp(-0.5, 0.5);
                let error: f64 = StandardNormal.sample(rng);
                let tilt = height * height * load + play + 0.01 * error;
                writeln!(table, "{height},{load:.6},{tilt:.6}").unwrap();
            }
        }
        let options = SpecimenOptions {
            force_column: Some("load".to_owned()),
            displacement_column: "tilt".to_owned(),
            configuration_column: vec!["height".to_owned()],
            force_unit: Some("1".to_owned()),
            displacement_unit: Some("1".to_owned()),
            ..SpecimenOptions::default()
        };
        said_of(table, &options)
    };
    let growing = told(1, &mut table, &mut rng);
    assert_eq!(growing.sizes, ConfigurationSizes::Number);
    let names = |diagnosis: &Diagnosis| -> Vec<&str> {
        let laws = diagnosis.findings.iter();
        laws.map(|finding| finding.effect.law.name).collect()
    };
    assert!(
        names(&growing).contains(&"preloaded-backlash"),
        "{:?}",
        names(&growing)
    );
    "height,load,tilt\n".clone_into(&mut table);
    let common = told(0, &mut table, &mut rng);
    assert_eq!(common.sizes, ConfigurationSizes::Common);
}

#[test]
fn a_straight_line_set_either_way_lacks_nothing() {
    for response in [ResponseVariable::Displacement, ResponseVariable::Force] {
        let alarms = (0..20)
            .filter(|&seed| {
                // No law: a relaxation of no size.
                let table = recording(laws::RELAXATION, &[0.0, 1.0], 100 + seed);
                said_of_part(&table, response).verdict != Verdict::NothingMissing
            })
            .count();
        // Nominal 4 %: of twenty lines more than four have a chance of 0.1 % (binomial).
        assert!(alarms <= 4, "{alarms} of 20, {response:?}");
    }
}

#[test]
fn a_force_gauge_that_scatters_over_dead_weights_is_no_physics() {
    // The same loads five times: to what hangs there, order and travel follow more closely than the force that is read.
    let alarms = (0..40).filter(|&seed| {
        let mut rng = ChaCha8Rng::seed_from_u64(4000 + seed);
        let mut table = "run,F_N,d_um\n".to_owned();
        for run in 1..=5 {
            for load in (0..15).map(|step| 5.0 * f64::from(step)) {
                let [force, dial]: [f64; 2] =
                    std::array::from_fn(|_| StandardNormal.sample(&mut rng));
                let read = (load + 0.1 * force, 20.0 * load + dial);
                writeln!(table, "{run},{:.3},{:.2}", read.0, read.1).unwrap();
            }
        }
        let options = SpecimenOptions {
            force_column: Some("F_N".to_owned()),
            displacement_column: "d_um".to_owned(),
            run_column: vec!["run".to_owned()],
            ..SpecimenOptions::default()
        };
        said_of(&table, &options).verdict != Verdict::NothingMissing
    });
    // Nominal 4 %: of forty more than six have a chance of 0.1 % (binomial).
    let alarms = alarms.count();
    assert!(alarms <= 6, "{alarms} of 40");
}
