//! Single bad values, wrong units and signs in load cases, and what a diagnosis may say beside them.

use std::collections::BTreeSet;

use proptest::prelude::*;

use stiffbench_beams::robot::{FittingFactors, ModelParameter, Robot};
use stiffbench_diagnosis::elastostatics::{
    BadLoadCaseValue, LoadCaseDiagnosis, LoadCaseFit, LoadCaseFitOptions, LoadCaseModel,
    NextStandardError, PosedLoadCases, WrongFactor, bad_load_case_values, fit_load_cases,
    plan_load_cases, usual_choice, wrong_factor,
};
use stiffbench_diagnosis::fit::FactorStatus;
use stiffbench_diagnosis::mismatch::Verdict;
use stiffbench_diagnosis::parameters::FitRole;
use stiffbench_measurement::load_cases::LoadCaseTable;
use stiffbench_simulation::{LoadCasePlan, NoiseModel, simulate_load_cases};
use stiffbench_units_and_text::test_point::PoseId;

use super::load_case_diagnosis::{diagnose, fanuc, springs};

/// Load cases of an arm; with repeats their loads vary by 0.4 %, as the noise model has it.
fn simulated(robot: &Robot, truth: &FittingFactors, repeats: u32, seed: u64) -> LoadCaseTable {
    let mechanism = robot.mechanism(None).unwrap();
    let plan = LoadCasePlan {
        count: 24,
        largest_force_n: 800.0,
        repeats,
        poses: None,
    };
    let noise = if repeats > 1 {
        NoiseModel::default()
    } else {
        NoiseModel {
            reading_sd_m: 10e-6,
            zero_sd_m: 0.0,
            run_slope_sd: 0.0,
            ..NoiseModel::default()
        }
    };
    simulate_load_cases(robot, mechanism, truth, &plan, &noise, seed).unwrap()
}

/// What is done with the model of a table.
fn with_model<T>(
    robot: &Robot,
    table: &LoadCaseTable,
    free: &[&str],
    of: impl Fn(&LoadCaseModel<'_>, &LoadCaseFitOptions) -> T,
) -> T {
    let mechanism = robot.mechanism(None).unwrap();
    let posed = PosedLoadCases::new(robot, mechanism, table).unwrap();
    let start = FittingFactors::UNIT;
    let mut choice = usual_choice(robot, mechanism, &start, &posed).unwrap();
    for name in free {
        let parameter = ModelParameter::find(robot, mechanism, name).unwrap();
        choice.set(&parameter, FitRole::Free);
    }
    let options = LoadCaseFitOptions {
        choice,
        ..LoadCaseFitOptions::default()
    };
    let model = LoadCaseModel {
        robot,
        mechanism,
        start: &start,
        posed: &posed,
    };
    of(&model, &options)
}

fn fitted(robot: &Robot, table: &LoadCaseTable, free: &[&str]) -> LoadCaseFit {
    with_model(robot, table, free, |model, options| {
        fit_load_cases(model, options).unwrap()
    })
}

fn bad_values(robot: &Robot, table: &LoadCaseTable) -> Vec<BadLoadCaseValue> {
    with_model(robot, table, &[], |model, options| {
        let fit = fit_load_cases(model, options).unwrap();
        bad_load_case_values(model, options, &fit).unwrap()
    })
}

/// Tables in which a value is called bad, of simulated ones without any; half of those without repeats lack a spring.
fn false_alarms(tables: u64, repeats: u32) -> usize {
    let robot = fanuc();
    let clean = springs(&robot, &[]);
    let lacking = springs(&robot, &[("joint.J3.z", 0.5e-6)]);
    (0..tables)
        .filter(|seed| {
            let truth = if seed % 2 == 0 { &clean } else { &lacking };
            let table = simulated(&robot, truth, repeats, 9000 + seed);
            !bad_values(&robot, &table).is_empty()
        })
        .count()
}

#[test]
fn good_values_are_not_called_bad() {
    for repeats in [1, 2, 3] {
        let found = false_alarms(30, repeats);
        // At 0.3 % more than 1 of 30 come once in 250.
        assert!(found <= 1, "{repeats} repeats: {found} of 30");
    }
}

#[test]
#[ignore = "a minute; `just nightly` runs it"]
fn good_values_are_called_bad_in_few_tables() {
    for repeats in [1, 2, 3] {
        let found = false_alarms(400, repeats);
        println!("{repeats} repeats: {found} of 400 tables with a good value called bad");
        // At 0.3 % more than 5 come once in a thousand.
        assert!(found <= 5, "{repeats} repeats: {found} of 400");
    }
}

/// Of tables with one bad value those in which it and nothing else is named.
fn found(tables: u64, repeats: u32, wrong: impl Fn(f64) -> f64) -> usize {
    let robot = fanuc();
    let truth = springs(&robot, &[]);
    (0..tables)
        .filter(|seed| {
            let mut table = simulated(&robot, &truth, repeats, 7000 + seed);
            // The largest component of a case is the one whose digits are moved; any case serves.
            let place = (seed * 7 % table.cases.len() as u64) as usize;
            let case = &mut table.cases[place];
            let size = |axis: &usize| case.displacement_m[*axis].unwrap().abs();
            let axis = (0..3).max_by(|a, b| size(a).total_cmp(&size(b))).unwrap();
            let good = case.displacement_m[axis].unwrap();
            case.displacement_m[axis] = Some(wrong(good));
            let line = case.line;
            let bad = bad_values(&robot, &table);
            let [one] = &bad[..] else { return false };
            assert_eq!(one.repeats.is_empty(), repeats == 1);
            let off = (one.expected - good).abs();
            one.line == line && one.value == wrong(good) && off < 6.0 * one.standard_error
        })
        .count()
}

#[test]
fn a_single_bad_value_is_named_with_what_it_should_be() {
    for repeats in [1, 2, 3] {
        // Without repeats a model that lacks something looks alike, and a value has to be further off.
        let least = if repeats == 1 { 13 } else { 18 };
        let moved = found(20, repeats, |good| 10.0 * good);
        assert!(
            moved >= least,
            "{repeats} repeats, decimal point: {moved} of 20"
        );
        let off = found(20, repeats, |good| good + 1e-3);
        assert!(off >= least, "{repeats} repeats, 1 mm: {off} of 20");
        println!("{repeats} repeats: of 20 each, decimal point {moved}, 1 mm {off}");
    }
}

#[test]
fn a_diagnosis_goes_on_without_a_bad_value() {
    let robot = fanuc();
    let truth = springs(&robot, &[("joint.J3.z", 0.5e-6)]);
    for repeats in [1, 3] {
        let table = simulated(&robot, &truth, repeats, 1);
        let mut spoiled = table.clone();
        spoiled.cases[5].displacement_m[1] = Some(table.cases[5].displacement_m[1].unwrap() + 0.02);
        let (good, bad) = (diagnose(&robot, &table), diagnose(&robot, &spoiled));
        assert!(good.bad_values.is_empty());
        let [one] = &bad.bad_values[..] else {
            panic!("{repeats}: {:?}", bad.bad_values)
        };
        assert_eq!(
            (one.line, one.component),
            (table.cases[5].line, "displacement y")
        );
        let names = |of: &LoadCaseDiagnosis| -> Vec<String> {
            of.findings
                .iter()
                .map(|finding| finding.name.clone())
                .collect()
        };
        assert_eq!(names(&good), names(&bad), "{repeats}");
    }
}

#[test]
fn a_pose_in_another_unit_and_a_turned_axis_are_suspected() {
    let robot = fanuc();
    let truth = springs(&robot, &[]);
    let mechanism = robot.mechanism(None).unwrap();
    let plan = LoadCasePlan {
        count: 24,
        largest_force_n: 800.0,
        repeats: 1,
        poses: None,
    };
    let noise = NoiseModel::default();
    let table = simulate_load_cases(&robot, mechanism, &truth, &plan, &noise, 4).unwrap();
    let suspected = |table: &LoadCaseTable| {
        with_model(&robot, table, &[], |model, options| {
            let fit = fit_load_cases(model, options).unwrap();
            wrong_factor(model, options, &fit).unwrap()
        })
    };
    assert_eq!(suspected(&table), None);
    let mut in_mm = table.clone();
    let pose = in_mm.cases[3].pose.clone();
    for case in in_mm.cases.iter_mut().filter(|case| case.pose == pose) {
        case.displacement_m = case
            .displacement_m
            .map(|read| read.map(|read| read / 1000.0));
    }
    let expected = |pose: Option<&PoseId>, component, factor| {
        Some(WrongFactor {
            pose: pose.cloned(),
            component,
            factor,
        })
    };
    assert_eq!(suspected(&in_mm), expected(Some(&pose), None, 1000.0));
    let mut turned = table;
    for case in &mut turned.cases {
        case.displacement_m[1] = case.displacement_m[1].map(|read| -read);
    }
    let axis = Some("displacement y");
    assert_eq!(suspected(&turned), expected(None, axis, -1.0));
}

#[test]
fn both_commands_give_one_error_in_poses_left_out() {
    let robot = fanuc();
    let truth = springs(&robot, &[("joint.J3.z", 0.5e-6)]);
    for repeats in [1, 3] {
        let table = simulated(&robot, &truth, repeats, 3);
        let diagnosis = diagnose(&robot, &table);
        let names: Vec<&str> = diagnosis
            .findings
            .iter()
            .map(|one| one.name.as_str())
            .collect();
        let before = fitted(&robot, &table, &[]).rms_m()[2].unwrap();
        assert_eq!(diagnosis.before_unseen_m, Some(before));
        // What is found is a parameter of a fit too: the fit must say of it what the diagnosis says.
        assert!(names.iter().all(|name| !name.contains('@')), "{names:?}");
        let after = fitted(&robot, &table, &names).rms_m()[2].unwrap();
        let said = diagnosis.after_unseen_m.unwrap();
        assert!(after < 0.9 * before, "{names:?}: {before} to {after}");
        // The scatter without repeats is estimated with each model; it does not change the weights of displacements among themselves. With
        // repeats the weights go with what each fit predicts, and differ a little.
        let within = if repeats == 1 { 1e-4 } else { 1e-3 };
        assert!(
            (said / after - 1.0).abs() < within,
            "{repeats}: {said} and {after}"
        );
    }
}

#[test]
fn forces_with_the_wrong_sign_leave_what_the_fit_leaves() {
    let robot = fanuc();
    let mut table = simulated(&robot, &springs(&robot, &[]), 2, 5);
    for case in &mut table.cases {
        case.force_n = case.force_n.map(|force| -force);
    }
    let fit = fitted(&robot, &table, &[]);
    let diagnosis = diagnose(&robot, &table);
    assert_eq!(diagnosis.verdict, Verdict::Unknown);
    assert_eq!(diagnosis.before_unseen_m, fit.rms_m()[2]);
    let residuals = fit.residuals();
    let largest = residuals.iter().map(|one| one.abs()).fold(0.0, f64::max);
    assert_eq!(diagnosis.unexplained.unwrap().size.abs(), largest);
    assert!(
        diagnosis
            .parameters_after
            .iter()
            .all(|(_, value)| *value >= 0.0)
    );
}

#[test]
fn errors_of_held_out_poses_are_over_those_poses() {
    let robot = fanuc();
    let table = simulated(&robot, &springs(&robot, &[]), 1, 6);
    let poses: Vec<PoseId> = table.poses().into_iter().take(10).collect();
    let fit = with_model(&robot, &table, &[], |model, options| {
        let options = LoadCaseFitOptions {
            train: Some(poses.clone()),
            ..options.clone()
        };
        fit_load_cases(model, &options).unwrap()
    });
    // Rigid: nothing moves, so the error is the reading itself.
    let rms = |is_out: bool| {
        let cases = table.cases.iter();
        let own = cases.filter(|case| poses.contains(&case.pose) != is_out);
        let read: Vec<f64> = own.flat_map(|case| case.displacement_m).flatten().collect();
        (read.iter().map(|read| read * read).sum::<f64>() / read.len() as f64).sqrt()
    };
    assert!((fit.rigid_unseen_m().unwrap() / rms(true) - 1.0).abs() < 1e-9);
    assert!((fit.rigid_of(false).unwrap() / rms(false) - 1.0).abs() < 1e-9);
    assert_eq!(fit.held_out_poses(), table.poses().len() - 10);
}

#[test]
fn a_plan_begins_at_the_standard_errors_of_the_fit() {
    let robot = fanuc();
    // Four poses and a poor gauge leave springs open.
    let mut table = simulated(&robot, &springs(&robot, &[]), 1, 8);
    table.cases.truncate(4);
    let cases = table.cases.iter_mut();
    let values = cases.flat_map(|case| case.displacement_m.iter_mut());
    for (place, value) in values.flatten().enumerate() {
        *value += [2e-4, -1e-4, -1e-4, 0.0, 1e-4][place % 5];
    }
    with_model(&robot, &table, &[], |model, options| {
        let fit = fit_load_cases(model, options).unwrap();
        let planned = plan_load_cases(model, &fit, 1).unwrap();
        let mut compared = 0;
        for NextStandardError { name, now, then } in &planned[0].errors {
            let estimate = fit.estimate(name).unwrap();
            if let (Some(own), FactorStatus::Free) =
                (estimate.standard_uncertainty, &estimate.status)
            {
                assert!((now / own - 1.0).abs() < 1e-6, "{name}: {now} and {own}");
                assert!(then <= now, "{name}: {now} to {then}");
                compared += 1;
            }
        }
        assert!(compared > 0, "{:?}", planned[0].errors);
    });
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    /// Whatever is wrong with a table, an interval contains its value, and an unknown cause has at most three names that serve unseen poses.
    #[test]
    fn sizes_are_possible_and_lie_in_their_intervals(
        seed in 0_u64..1000,
        repeats in 1_u32..3,
        pose in 0_usize..24,
        factor in prop::sample::select(vec![1.0, -1.0, 1e-3, 10.0, 1.3]),
        axis in 0_usize..4,
        lean in -0.4_f64..0.4,
    ) {
        let robot = fanuc();
        let mut table = simulated(&robot, &springs(&robot, &[]), repeats, seed);
        let label = table.cases[pose].pose.clone();
        for case in &mut table.cases {
            for (place, read) in case.displacement_m.iter_mut().enumerate() {
                if place == axis || axis == 3 && case.pose == label {
                    *read = read.map(|read| factor * read);
                }
            }
            let [x, y, z] = case.force_n;
            case.force_n = [x, y - lean * z, z + lean * y];
        }
        let diagnosis = diagnose(&robot, &table);
        let mut names = BTreeSet::new();
        for finding in &diagnosis.findings {
            let [low, high] = finding.interval_95;
            prop_assert!(low <= finding.value && finding.value <= high, "{finding:?}");
            prop_assert!(names.insert(finding.name.clone()), "{} twice", finding.name);
            if finding.name.starts_with("force-axes") {
                prop_assert!(finding.value.abs() <= 0.05, "{finding:?}");
            }
        }
        if diagnosis.verdict == Verdict::Unknown && !diagnosis.findings.is_empty() {
            prop_assert!(diagnosis.findings.len() <= 3);
            let (before, after) = (diagnosis.before_unseen_m, diagnosis.after_unseen_m);
            prop_assert!(after < before, "{before:?} to {after:?}");
        }
        for one in &diagnosis.implausible {
            let [low, high] = one.bounds;
            prop_assert!(one.value < low || one.value > high, "{one:?}");
        }
    }
}
