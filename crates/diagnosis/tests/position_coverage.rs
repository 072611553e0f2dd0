//! How often the 95 % intervals of springs, base frame and tool point hold the truth, over simulated tables of absolute positions under own
//! weight. The long count is `cargo test --release -p stiffbench-diagnosis -- --ignored --nocapture a_thousand_tables_of_positions`.

use rayon::prelude::*;

use stiffbench_beams::robot::{FittingFactors, ModelParameter, Robot, TrackerFrames};
use stiffbench_diagnosis::elastostatics::{
    LoadCaseFit, LoadCaseFitOptions, LoadCaseModel, PosedLoadCases, fit_load_cases, spring_choice,
};
use stiffbench_diagnosis::fit::FactorStatus;
use stiffbench_simulation::{NoiseModel, PositionPlan, simulate_positions};
use stiffbench_test_files::text;
use stiffbench_units_and_text::source_text::SourceText;

/// Compliances of the six joints, rad/(N·m).
const TRUE: [f64; 6] = [1.2e-6, 0.8e-6, 1.1e-6, 3e-6, 3.5e-6, 6e-6];

/// Positions of a table.
const COUNT: usize = 100;

/// Standard deviation of a coordinate, m: that of a good tracker some metres away.
const SD_M: f64 = 20e-6;

/// What is known of a quantity after a table: its error and the half width of its 95 % interval.
struct Known {
    name: String,
    error: f64,
    half_width: f64,
}

/// Errors of what a table determines, and root mean square errors of the rigid robot and of the fit in poses left out, m.
struct Counted {
    known: Vec<Known>,
    rms_m: Option<[f64; 2]>,
}

fn truth() -> FittingFactors {
    let mut truth = FittingFactors::UNIT;
    for (joint, compliance) in TRUE.into_iter().enumerate() {
        let name = format!("J{}", joint + 1);
        truth.set(&ModelParameter::Joint(name.as_str().into()), compliance);
    }
    truth
}

/// Fits a simulated table.
///
/// # Arguments
/// - `leave_out`: whether each pose is to be left out in turn.
fn count(robot: &Robot, seed: u64, leave_out: bool) -> Counted {
    let mechanism = robot.mechanism(None).unwrap();
    let plan = PositionPlan {
        count: COUNT,
        repeats: 1,
        ..PositionPlan::default()
    };
    let noise = NoiseModel {
        reading_sd_m: SD_M,
        ..NoiseModel::default()
    };
    let made = simulate_positions(robot, mechanism, &truth(), &plan, &noise, seed).unwrap();
    let posed = PosedLoadCases::new(robot, mechanism, &made.table).unwrap();
    let options = LoadCaseFitOptions {
        train: (!leave_out).then(|| posed.labels.clone()),
        choice: spring_choice(robot, mechanism),
        sigma: None,
        keep_bad_values: false,
    };
    // The truth must not be where the fit begins.
    let start = FittingFactors::UNIT;
    let model = LoadCaseModel {
        robot,
        mechanism,
        start: &start,
        posed: &posed,
    };
    let fit = fit_load_cases(&model, &options).unwrap();
    let rms_m = fit.rms_m()[2].filter(|_| leave_out);
    Counted {
        known: springs(&fit).chain(frames(&fit, &made.frames)).collect(),
        rms_m: rms_m
            .zip(fit.rigid_unseen_m())
            .map(|(own, rigid)| [rigid, own]),
    }
}

/// Springs with an interval: that of the first joint turns about the vertical, and weight does not load it.
fn springs(fit: &LoadCaseFit) -> impl Iterator<Item = Known> {
    let joints = TRUE.into_iter().enumerate();
    joints.filter_map(|(joint, truth)| {
        let estimate = fit.estimate(&format!("joint.J{}", joint + 1)).unwrap();
        let is_open = matches!(estimate.status, FactorStatus::NotIdentified { .. });
        assert_eq!(is_open, joint == 0, "{estimate:?}");
        let [low, high] = estimate.interval_95.filter(|_| !is_open)?;
        Some(Known {
            name: estimate.name.clone(),
            error: 0.5 * (low + high) - truth,
            half_width: 0.5 * (high - low),
        })
    })
}

/// Base frame, its rotation by the small rotation between the fitted and the true, and tool point.
fn frames(fit: &LoadCaseFit, truth: &TrackerFrames) -> impl Iterator<Item = Known> {
    let fitted = fit.frames.as_ref().unwrap();
    let (a, b) = (&fitted.frames.rotation, &truth.rotation);
    let turned = TrackerFrames {
        rotation: [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| a[i][k] * b[j][k]).sum())),
        ..TrackerFrames::IDENTITY
    };
    let less = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| a[i] - b[i]);
    let errors = [
        less(fitted.frames.base_m, truth.base_m),
        turned.rotation_vector_rad(),
        less(fitted.frames.tool_point_m, truth.tool_point_m),
    ];
    let known = fitted.parameters.iter().zip(errors.as_flattened());
    let known: Vec<Known> = known
        .filter_map(|(parameter, error)| {
            Some(Known {
                name: parameter.name.to_owned(),
                error: *error,
                half_width: parameter.half_width_95?,
            })
        })
        .collect();
    known.into_iter()
}

/// Shares of intervals that hold the truth, by name; and the share of all.
fn coverage(tables: &[Counted]) -> (Vec<(String, f64)>, f64) {
    let mut counts: Vec<(String, usize, usize)> = Vec::new();
    for one in tables.iter().flat_map(|table| &table.known) {
        let place = counts.iter().position(|(name, ..)| *name == one.name);
        let place = place.unwrap_or_else(|| {
            counts.push((one.name.clone(), 0, 0));
            counts.len() - 1
        });
        counts[place].1 += usize::from(one.error.abs() <= one.half_width);
        counts[place].2 += 1;
    }
    let share = |hits: usize, of: usize| hits as f64 / of as f64;
    let (hits, of) = counts
        .iter()
        .fold((0, 0), |(a, b), (_, hits, of)| (a + hits, b + of));
    let by_name = counts.iter();
    let by_name = by_name.map(|(name, hits, of)| (name.clone(), share(*hits, *of)));
    (by_name.collect(), share(hits, of))
}

fn arm() -> Robot {
    let text = text("fixtures/elastic-calibration/arm.toml");
    Robot::parse(&SourceText::new("arm.toml", text)).unwrap()
}

fn study(tables: u64) -> Vec<Counted> {
    let robot = arm();
    let seeds = (0..tables).into_par_iter();
    seeds.map(|seed| count(&robot, seed, false)).collect()
}

#[test]
fn intervals_of_springs_and_frames_hold_the_truth() {
    let tables = study(40);
    let (by_name, all) = coverage(&tables);
    // Five springs and the nine coordinates of the frames; weight does not load the first joint.
    assert_eq!(by_name.len(), 14, "{by_name:?}");
    assert!((0.9..0.99).contains(&all), "{all} {by_name:?}");
    let [rigid, own] = count(&arm(), 1_000, true).rms_m.unwrap();
    assert!(own < 25e-6 && rigid > 20.0 * own, "{rigid} {own}");
}

#[test]
#[ignore = "a minute or two; `just nightly` runs it"]
fn a_thousand_tables_of_positions() {
    let tables = study(1_000);
    let (by_name, all) = coverage(&tables);
    for (name, share) in &by_name {
        println!("{name:14} {:5.1} %", 100.0 * share);
    }
    println!("all            {:5.1} %", 100.0 * all);
    let robot = arm();
    let seeds = (1_000..1_020_u64).into_par_iter();
    let errors: Vec<[f64; 2]> = seeds
        .map(|seed| count(&robot, seed, true).rms_m.unwrap())
        .collect();
    let mean = |of: usize| errors.iter().map(|one| one[of]).sum::<f64>() / errors.len() as f64;
    println!(
        "in poses left out: rigid robot {:.0} um, fit {:.1} um",
        1e6 * mean(0),
        1e6 * mean(1)
    );
    assert!((0.93..0.97).contains(&all), "{all}");
    for (name, share) in by_name {
        assert!((0.93..0.97).contains(&share), "{name}: {share}");
    }
}
