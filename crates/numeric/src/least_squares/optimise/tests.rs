//! Searches with known valleys, and every mistake in their input.

use super::*;
use crate::least_squares::Parameter;
use crate::least_squares::rows::{ResidualRows, Row};

/// A bowl with waves: lowest at 3.4, side valleys about every 1.5.
#[expect(
    clippy::unnecessary_wraps,
    reason = "the searches take functions that may have no value"
)]
fn valleys(p: &[f64]) -> Option<f64> {
    let u = p[0];
    Some((u - 3.4).powi(2) + 2.0 * (1.0 - (4.0 * (u - 3.4)).cos()))
}

fn area(bounds: &[(f64, f64)]) -> Result<SearchArea, LeastSquaresError> {
    SearchArea::new(bounds, vec!["a".to_owned(); bounds.len()])
}

fn swarm(
    objective: &mut dyn FnMut(&[f64]) -> Option<f64>,
    bounds: (f64, f64),
    settings: &SearchSettings,
) -> Result<Vec<f64>, LeastSquaresError> {
    swarm_within(objective, &area(&[bounds])?, settings)
}

#[test]
fn the_swarm_finds_the_lowest_of_several_valleys() {
    let found = swarm(&mut valleys, (-2.3, 6.9), &SearchSettings::default()).unwrap();
    assert!((found[0] - 3.4).abs() < 1e-6, "{found:?}");
}

#[test]
fn the_simplex_stays_in_its_valley_and_refines_it() {
    let start = 3.4 - 1.5;
    let settings = SearchSettings::default();
    let valley = area(&[(start - 0.4, start + 0.4)]).unwrap();
    let found = simplex_within(&mut valleys, &valley, &[start], &settings).unwrap();
    // Stationary: 2 d + 8 sin 4d = 0 beside d = -1.5.
    let d = found[0] - 3.4;
    assert!((2.0 * d + 8.0 * (4.0 * d).sin()).abs() < 1e-5, "{d}");
    assert!((d + 1.5).abs() < 0.2, "{d}");
}

#[test]
fn one_seed_gives_one_search() {
    let run = |seed| {
        let settings = SearchSettings {
            seed,
            swarm_iterations: 3,
            ..SearchSettings::default()
        };
        swarm(&mut valleys, (-2.3, 6.9), &settings).unwrap()
    };
    assert_eq!(run(5), run(5));
    assert_ne!(run(5), run(6));
}

#[test]
fn points_without_a_value_are_avoided() {
    let mut half = |p: &[f64]| {
        if p[0] < 1.0 {
            None
        } else {
            Some((p[0] - 1.5).powi(2))
        }
    };
    let found = swarm(&mut half, (0.1, 10.0), &SearchSettings::default()).unwrap();
    assert!((found[0] - 1.5).abs() < 1e-4);
}

#[test]
fn each_mistake_has_its_own_error() {
    let settings = SearchSettings {
        swarm_iterations: 2,
        ..SearchSettings::default()
    };
    for bounds in [
        (f64::NEG_INFINITY, 1.0),
        (1.0, f64::INFINITY),
        (2.0, 2.0),
        (f64::NAN, 1.0),
    ] {
        assert!(
            matches!(area(&[bounds]), Err(LeastSquaresError::NoRange { .. })),
            "{bounds:?}"
        );
    }
    assert!(matches!(
        area(&[]),
        Err(LeastSquaresError::NoFreeParameter { count: 0 })
    ));
    assert!(matches!(
        swarm(&mut |_| None, (1.0, 2.0), &settings),
        Err(LeastSquaresError::NoValueAnywhere { evaluations }) if evaluations >= 40
    ));
}

/// A sine with a slope: valleys every 2π/3, the lowest near 8.
fn waves(p: &[f64], i: usize) -> Row {
    let d = p[0] - 8.0;
    match i {
        0 => (2.0 * (1.5 * d).sin(), vec![3.0 * (1.5 * d).cos()]),
        _ => (0.3 * d + 0.1, vec![0.3]),
    }
}

#[test]
fn a_fit_in_a_side_valley_is_found_out_and_one_in_the_lowest_is_confirmed() {
    let fit_from = |start| {
        let set = ParameterSet::new(vec![Parameter::free("phase", start, 1.0, 20.0)]).unwrap();
        let mut waves = ResidualRows(2, waves);
        let fit = minimise(&mut waves, &set, &LeastSquaresSettings::default()).unwrap();
        assert!(fit.termination.is_converged());
        let search =
            search_for_lower_minimum(&mut waves, &set, &fit, &SearchSettings::default()).unwrap();
        (fit, search)
    };
    let (side, lower) = fit_from(3.9);
    let Some(lowest) = lower else {
        panic!(
            "the side valley at {:?} was taken for the lowest",
            side.values
        )
    };
    assert!((lowest.values[0] - 8.0).abs() < 0.05);
    assert!(fit_from(8.3).1.is_none());
}
