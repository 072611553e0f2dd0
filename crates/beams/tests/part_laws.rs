//! Laws of parts in testing machines against textbook elements, driven both ways without noise.
//!
//! A part on a spring is driven by a force; the displacement that answers then drives the same part, which must answer with that force.

use stiffbench_beams::physics::laws::{
    BACKLASH_DUAL, CONTACT, CONTACT_DUAL, END_STOP, END_STOP_DUAL, FRICTION_DUAL,
    HARDENING_BEHIND_FRICTION, JOINT_SEPARATION, JOINT_SEPARATION_DUAL, LOAD_DEPENDENT_FRICTION,
    MAXWELL_SLIP, MAXWELL_SLIP_DUAL, ODD_POLYNOMIAL, PART_CREEP, PART_CREEP_DUAL, PART_FRICTION,
    PART_SETTING_IN, RELAXATION, RELAXATION_DUAL, SOFTENING_DUAL, WARM_UP,
};
use stiffbench_beams::physics::{DrivenPath, Law, values_of};

/// Stiffness of the spring, N/mm.
const SPRING: f64 = 40.0;

/// Rounding of sums of some hundred readings of some ten newtons.
const ROUNDING: f64 = 1e-9;

/// Cycles with growing and falling turns, in fine steps.
fn path() -> Vec<f64> {
    let turns = [0.0, 30.0, -12.0, 22.0, 5.0, 60.0, -60.0, 20.0, -20.0, 0.0];
    let steps = turns
        .windows(2)
        .flat_map(|pair| (0..200).map(|i| pair[0] + (pair[1] - pair[0]) * f64::from(i) / 200.0));
    steps.collect()
}

fn times(count: usize) -> Vec<f64> {
    (0..count).map(|i| 0.1 * i as f64).collect()
}

fn answers(law: Law, values: &[f64], driver: &[f64]) -> Vec<f64> {
    let time_s = times(driver.len());
    let mut out = vec![f64::NAN; driver.len()];
    let path = DrivenPath {
        driver,
        time_s: &time_s,
    };
    law.history()
        .unwrap()
        .answers(&values_of(values), path, &mut out);
    out
}

/// A part in series with the spring, driven by force, and beside the line of stiffness `line`, driven by what answered: the same forces.
fn both_ways(by_force: (Law, &[f64]), line: f64, by_displacement: (Law, &[f64]), tolerance: f64) {
    let force = path();
    let yields = answers(by_force.0, by_force.1, &force);
    let displacement: Vec<f64> = force
        .iter()
        .zip(&yields)
        .map(|(f, x)| f / SPRING + x)
        .collect();
    let carried = answers(by_displacement.0, by_displacement.1, &displacement);
    for (place, force) in force.iter().enumerate() {
        let again = line * displacement[place] + carried[place];
        assert!(
            (again - force).abs() <= tolerance,
            "{:?}, {place}: {again} instead of {force}",
            by_force.0
        );
    }
}

#[test]
fn a_slider_beside_a_spring_is_the_same_part_both_ways() {
    // One play operator of radius r and compliance c: five of them with one limit each would be maxwell-slip.
    let (c, r) = (0.03, 9.0);
    let line = 1.0 / (1.0 / SPRING + c);
    let force = path();
    let mut held = 0.0_f64;
    let displacement: Vec<f64> = force
        .iter()
        .map(|force| {
            held = held.clamp(force - r, force + r);
            force / SPRING + c * held
        })
        .collect();
    let values = [r * (1.0 - line / SPRING), r / SPRING];
    let carried = answers(FRICTION_DUAL, &values, &displacement);
    for (place, force) in force.iter().enumerate() {
        let again = line * displacement[place] + carried[place];
        assert!(
            (again - force).abs() < ROUNDING,
            "{place}: {again} instead of {force}"
        );
    }
    // The slider driven by force; load-dependent friction without growth is the same.
    for (law, values) in [
        (PART_FRICTION, &[c, r][..]),
        (LOAD_DEPENDENT_FRICTION, &[c, r, 0.0]),
    ] {
        let yields = answers(law, values, &force);
        for (place, yielded) in yields.iter().enumerate() {
            assert!((force[place] / SPRING + yielded - displacement[place]).abs() < ROUNDING);
        }
    }
}

#[test]
fn a_spring_behind_friction_answers_to_what_friction_leaves() {
    let (friction, growth, cubic) = (4.0, 0.1, 2e-6);
    let force = path();
    let carried = answers(LOAD_DEPENDENT_FRICTION, &[1.0, friction, growth], &force);
    let yields = answers(
        HARDENING_BEHIND_FRICTION,
        &[cubic, friction, growth],
        &force,
    );
    let cube = answers(ODD_POLYNOMIAL, &[cubic, 0.0], &carried);
    for (yielded, cube) in yields.iter().zip(cube) {
        assert!((yielded - cube).abs() < ROUNDING, "{yielded} {cube}");
    }
}

#[test]
fn a_standard_linear_solid_is_the_same_part_both_ways() {
    let (c, tau) = (0.03, 7.0);
    let line = 1.0 / (1.0 / SPRING + c);
    // The displacement that answers is no straight line between readings: the error falls with the square of the step.
    both_ways(
        (RELAXATION, &[c, tau]),
        line,
        (RELAXATION_DUAL, &[SPRING - line, tau * line / SPRING]),
        2e-3,
    );
}

#[test]
fn a_stop_is_the_same_part_both_ways() {
    let (c, stop) = (0.015, 35.0);
    let stiff = 1.0 / (1.0 / SPRING - c);
    both_ways(
        (END_STOP, &[c, stop]),
        SPRING,
        (END_STOP_DUAL, &[stiff - SPRING, stop / SPRING]),
        ROUNDING,
    );
}

#[test]
fn contact_is_the_same_part_both_ways() {
    let (size, full, power) = (2.0, 60.0, 1.5);
    let force: Vec<f64> = path().iter().map(|force| force.abs()).collect();
    let approach = answers(CONTACT, &[size, full, power], &force);
    // Toward the same end, where the size is the force.
    let carried = answers(CONTACT_DUAL, &[full, size, power, 0.0], &approach);
    for (force, again) in force.iter().zip(carried) {
        assert!(
            (force - again).abs() < ROUNDING,
            "{again} instead of {force}"
        );
    }
}

/// Of two springs in series one is preloaded against a rigid face: closed form of either face, one from the other.
#[test]
fn a_preload_that_opens_is_the_same_part_both_ways() {
    let (soft, preload) = (0.06, 30.0);
    let (stiff, opening) = (SPRING, preload / SPRING);
    let force = path();
    let opened = answers(JOINT_SEPARATION, &[soft, preload], &force);
    let travel: Vec<f64> = force
        .iter()
        .zip(opened)
        .map(|(f, more)| f / stiff + more)
        .collect();
    // Beyond the opening 1/(1/k + c) is left of k.
    let lost = stiff - 1.0 / (1.0 / stiff + soft);
    let missing = answers(JOINT_SEPARATION_DUAL, &[lost, opening], &travel);
    for ((force, x), missing) in force.iter().zip(&travel).zip(missing) {
        let again = stiff * x + missing;
        assert!(
            (force - again).abs() < ROUNDING,
            "{again} instead of {force}"
        );
    }
}

#[test]
fn play_carries_nothing_within_itself() {
    let displacement = [0.0, 0.4, 1.0, 1.6, -0.4, -2.0];
    let lost = answers(BACKLASH_DUAL, &[SPRING, 2.0], &displacement);
    let force = displacement
        .iter()
        .zip(lost)
        .map(|(x, lost)| SPRING * x + lost);
    let expected = [0.0, 0.0, 0.0, 0.6 * SPRING, 0.0, -SPRING];
    for (force, expected) in force.zip(expected) {
        assert!(
            (force - expected).abs() < ROUNDING,
            "{force} instead of {expected}"
        );
    }
}

/// Masing's rules: every branch after a turn is the first loading at twice the size, and a closed inner loop is forgotten.
#[test]
fn sliders_follow_masings_rules() {
    for (law, values) in [
        (MAXWELL_SLIP, [0.02, 20.0]),
        (MAXWELL_SLIP_DUAL, [8.0, 20.0]),
    ] {
        let first: Vec<f64> = (0..=60).map(f64::from).collect();
        let back: Vec<f64> = (0..=120).map(|i| 60.0 - f64::from(i)).collect();
        let virgin = answers(law, &values, &first);
        let whole = answers(law, &values, &[&first[..], &back[..]].concat());
        for half in 0..=60 {
            let fall = whole[60] - whole[61 + 2 * half];
            assert!(
                (fall - 2.0 * virgin[half]).abs() < ROUNDING,
                "{law:?}, {half}: {fall}"
            );
        }
        let inner = [60.0, 40.0, 52.0, 40.0, 60.0, -60.0];
        let with = answers(law, &values, &[&first[..], &inner[..]].concat());
        assert!(
            (with[with.len() - 1] - whole[whole.len() - 1]).abs() < ROUNDING,
            "{law:?}"
        );
    }
}

#[test]
fn friction_that_grows_with_the_load_opens_the_loop_with_it() {
    let (c, friction, mu) = (0.02, 4.0, 0.2);
    let up: Vec<f64> = (0..=60).map(f64::from).collect();
    let down: Vec<f64> = (0..=60).rev().map(f64::from).collect();
    let loops = answers(
        LOAD_DEPENDENT_FRICTION,
        &[c, friction, mu],
        &[up, down].concat(),
    );
    // Sliding, the loop is twice the friction wide: c (friction + mu F) to either side of c F.
    for load in [10, 20, 25] {
        let width = loops[121 - load] - loops[load];
        let expected = 2.0 * c * (friction + mu * load as f64);
        assert!(
            (width - expected).abs() < ROUNDING,
            "{load}: {width} instead of {expected}"
        );
    }
}

#[test]
fn creep_and_relaxation_follow_the_logarithm_of_time() {
    for (law, side) in [(PART_CREEP, 1.0), (PART_CREEP_DUAL, -1.0)] {
        let mut step = vec![1.0; 3001];
        step[0] = 0.0;
        let grown = answers(law, &[1.0, 0.3], &step);
        // A decade of time adds the slope, between ten of the shortest time and the longest; times lie half a decade apart.
        for decade in [60, 300] {
            let growth = side * (grown[10 * decade] - grown[decade]);
            assert!(
                (growth - 1.0).abs() < 0.02,
                "{law:?} from {decade}: {growth}"
            );
        }
    }
}

#[test]
fn laws_of_one_run_start_and_end_where_they_say() {
    let force = path();
    let odd = answers(ODD_POLYNOMIAL, &[2.0, -0.5], &[0.5, -0.5, 2.0]);
    assert_eq!(odd, [0.25 * 0.875, -0.25 * 0.875, -16.0]);
    // A virgin path is not softened, a path below its largest load is.
    let soft = answers(
        SOFTENING_DUAL,
        &[10.0],
        &[0.0, 1.0, 2.0, 1.0, 0.0, -1.0, -2.0],
    );
    assert_eq!(soft, [0.0, 0.0, 0.0, -5.0, 0.0, 5.0, 0.0]);
    let warm = answers(WARM_UP, &[3.0, 10.0], &force);
    assert!(warm[0] == 0.0 && (warm[100] - 3.0 * (1.0 - (-1.0_f64).exp())).abs() < ROUNDING);
    let set = answers(PART_SETTING_IN, &[3.0, 30.0], &force);
    // The first loading shows nothing; thirty newtons there and 42 back, to -12 N, are sixty newtons of path more than the way from the start.
    assert!(set[..=200].iter().all(|set| set.abs() < ROUNDING));
    assert!(
        (set[400] - 3.0 * (1.0 - (-2.0_f64).exp())).abs() < ROUNDING,
        "{}",
        set[400]
    );
}
