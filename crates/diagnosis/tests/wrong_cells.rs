//! Cells under the names of others, or with another decimal point: named, and no others.

use std::ops::Range;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stiffbench_beams::physics::{Effect, Place, laws};
use stiffbench_diagnosis::mismatch::{
    BadReadingKind, Baseline, KnownNoise, Observations, ScreenedRuns, Truth, scale_to, screen_runs,
    simulate,
};
use stiffbench_units_and_text::test_point::Direction;

use crate::mismatch_verdicts::{Arm, truth};

fn screened(arm: &Arm, readings: &Observations) -> ScreenedRuns {
    screen_runs(&arm.baseline, readings, &KnownNoise::Nothing).unwrap()
}

fn cell(readings: &Observations, pose: usize, direction: Direction) -> usize {
    let mut cells = readings.cells.iter();
    cells
        .position(|cell| cell.pose == pose && cell.direction == direction)
        .unwrap()
}

/// Readings where two cells have the names of each other.
fn exchanged(readings: &Observations, a: usize, b: usize) -> Observations {
    let rows = |cell: usize| -> Range<usize> { readings.cells[cell].readings.clone() };
    assert_eq!(rows(a).len(), rows(b).len());
    let mut out = readings.clone();
    for (a, b) in rows(a).zip(rows(b)) {
        out.displacement_m.swap(a, b);
        out.loads.swap(a, b);
    }
    out
}

fn scaled(readings: &Observations, cells: &[usize], factor: f64) -> Observations {
    let mut displacement_m = readings.displacement_m.clone();
    for cell in cells {
        for reading in readings.cells[*cell].readings.clone() {
            displacement_m[reading] *= factor;
        }
    }
    readings.with_displacements(displacement_m)
}

fn spring(joint: &str, c: f64) -> Effect {
    let place = Place::Joint(joint.to_owned());
    Effect::new(laws::JOINT_COMPLIANCE, place, vec![c]).unwrap()
}

fn backlash() -> Effect {
    let place = Place::Joint("S2".to_owned());
    Effect::new(laws::JOINT_BACKLASH, place, vec![1e-5, 3.0]).unwrap()
}

fn named(found: &ScreenedRuns, readings: &Observations) -> Vec<usize> {
    let place = |pose: &_, direction| {
        let mut cells = readings.cells.iter();
        cells.position(|one| readings.poses[one.pose] == *pose && one.direction == direction)
    };
    let bad = found.bad.iter();
    let mut cells: Vec<usize> = bad
        .map(|bad| place(&bad.pose, bad.direction).unwrap())
        .collect();
    cells.sort_unstable();
    cells
}

#[test]
fn exchanged_cells_are_named_with_each_other_beside_true_effects() {
    let arm = Arm::new("load-hold-unload");
    let slack = scale_to(&arm.baseline, &arm.plan, &truth(vec![backlash()]), 15.0);
    let truths = [truth(Vec::new()), slack.unwrap().unwrap()];
    for (number, truth) in truths.iter().enumerate() {
        for seed in 0..4_u64 {
            let good = simulate(&arm.baseline, &arm.plan, truth, 70 + seed).unwrap();
            let pose = seed as usize;
            let (x, y) = (
                cell(&good, pose, Direction::X),
                cell(&good, pose, Direction::Y),
            );
            let wrong = exchanged(&good, x, y);
            let found = screened(&arm, &wrong);
            let mut both = [x, y];
            both.sort_unstable();
            assert_eq!(named(&found, &good), both, "effects {number}, pose {pose}");
            for bad in &found.bad {
                let (of, with) = bad.exchanged_with.clone().unwrap();
                assert_eq!(of, bad.pose);
                assert_ne!(with, bad.direction);
                // What it was recorded beside is what it would have been, within what a play of 15 standard errors does to slopes.
                let other = found.bad.iter().find(|one| one.direction == with).unwrap();
                let ratio = bad.expected / other.compliance;
                assert!((0.9..1.1).contains(&ratio), "{ratio}");
            }
            let left = found.observations.len();
            assert_eq!(left, good.len() - 2 * good.cells[x].readings.len());
        }
    }
}

#[test]
fn exchanged_poses_are_named_in_every_direction_that_shows_it() {
    let arm = Arm::new("load-hold-unload");
    let good = simulate(&arm.baseline, &arm.plan, &truth(Vec::new()), 5).unwrap();
    let mut wrong = good.clone();
    let mut all = Vec::new();
    for direction in Direction::ALL {
        let (a, b) = (cell(&good, 0, direction), cell(&good, 3, direction));
        wrong = exchanged(&wrong, a, b);
        all.extend([a, b]);
    }
    all.sort_unstable();
    let found = screened(&arm, &wrong);
    assert_eq!(named(&found, &good), all);
    assert!(found.bad.iter().all(|bad| bad.exchanged_with.is_some()));
}

#[test]
fn a_cell_with_another_decimal_point_is_named_with_what_it_should_have_been() {
    let arm = Arm::new("load-hold-unload");
    for (seed, (factor, places)) in [(0.1, 1), (10.0, -1), (100.0, -2)].into_iter().enumerate() {
        let good = simulate(
            &arm.baseline,
            &arm.plan,
            &truth(Vec::new()),
            20 + seed as u64,
        );
        let good = good.unwrap();
        let wrong = scaled(&good, &[4 + seed], factor);
        let found = screened(&arm, &wrong);
        let [bad] = &found.bad[..] else {
            panic!("{factor}: {:?}", found.bad);
        };
        assert_eq!(bad.kind, BadReadingKind::DecimalPoint(places));
        assert_eq!(
            (
                bad.repeat,
                bad.exchanged_with.is_none(),
                named(&found, &good)
            ),
            (None, true, vec![4 + seed])
        );
        let off = bad.compliance / factor / bad.expected - 1.0;
        assert!(off.abs() < 0.05, "{off}");
    }
}

/// One joint or all of them as soft as an industrial arm's, or far softer; loose play; nothing.
#[test]
fn good_cells_are_left_alone_however_soft_the_joints() {
    let arm = Arm::new("load-unload");
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let joints = arm.baseline.joints().to_vec();
    for seed in 0..60_u64 {
        let soft = if seed % 2 == 0 { 1 } else { joints.len() };
        let first = rng.random_range(0..joints.len());
        let effects = (0..soft).map(|one| {
            // From a tenth of what the links yield to some hundred times it.
            let c = 10_f64.powf(rng.random_range(-6.0..-3.0));
            spring(&joints[(first + one) % joints.len()], c)
        });
        let mut effects: Vec<Effect> = effects.collect();
        if seed % 3 == 0 {
            effects.push(backlash());
        }
        let parameters = (0..4).map(|_| rng.random_range(-1.0..1.0)).collect();
        let truth = Truth {
            parameters,
            ..truth(effects)
        };
        let readings = simulate(&arm.baseline, &arm.plan, &truth, 900 + seed).unwrap();
        let found = screened(&arm, &readings);
        assert_eq!(found.bad, [], "seed {seed}: {:?}", truth.effects);
    }
}
