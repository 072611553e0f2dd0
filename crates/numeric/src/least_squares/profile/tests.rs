//! Profiles with exact ends, open ends, and what stops a walk.

use super::*;
use crate::least_squares::rows::{ResidualRows, Row, unbounded};
use crate::least_squares::{
    CovarianceSettings, LeastSquaresSettings, Parameter, covariance, minimise,
};

fn profiled(
    problem: &mut dyn ResidualFunction,
    parameters: Vec<Parameter>,
    mode: SigmaMode,
    parameter: usize,
) -> Result<(ProfileInterval, Option<[f64; 2]>), LeastSquaresError> {
    let set = ParameterSet::new(parameters)?;
    let fit = minimise(problem, &set, &LeastSquaresSettings::default())?;
    let covariance = covariance(&set, &fit, mode, &CovarianceSettings::default())?;
    let rise = rise_at_95(&fit, &covariance)?;
    let settings = ProfileSettings::default();
    let found = profile(problem, &set, &fit, parameter, rise, &settings)?;
    Ok((found, covariance.estimates[parameter].interval_95))
}

/// ln of a quantity measured once as 5 ± sigma: the exact ends are ln(5 ± 1.96 sigma).
fn logarithm(sigma: f64) -> ResidualRows<impl FnMut(&[f64], usize) -> Row> {
    ResidualRows(1, move |p: &[f64], _| {
        ((p[0].exp() - 5.0) / sigma, vec![p[0].exp() / sigma])
    })
}

const K: f64 = 1.959_963_984_540_054;

#[test]
fn of_a_line_the_profile_is_the_quadratic_interval() {
    for mode in [SigmaMode::Known, SigmaMode::Estimated] {
        let y = [1.0, 2.1, 2.9, 4.2, 5.0];
        let mut line = ResidualRows(5, move |p: &[f64], i| {
            (p[0] + p[1] * i as f64 - y[i], vec![1.0, i as f64])
        });
        let parameters = unbounded([("a", 0.0), ("b", 0.0)]);
        let (found, quadratic) = profiled(&mut line, parameters, mode, 1).unwrap();
        let [lower, upper] = quadratic.unwrap();
        assert!((found.lower.closed().unwrap() - lower).abs() < 1e-4 * (upper - lower));
        assert!((found.upper.closed().unwrap() - upper).abs() < 1e-4 * (upper - lower));
        assert_eq!(found.lower_minimum, None);
    }
}

#[test]
fn a_curved_model_has_exact_interval_ends_beside_those_of_the_covariance() {
    let (found, quadratic) = profiled(
        &mut logarithm(2.0),
        unbounded([("u", 1.0)]),
        SigmaMode::Known,
        0,
    )
    .unwrap();
    assert!((found.threshold - K * K).abs() < 1e-9);
    assert!((found.lower.closed().unwrap() - (5.0 - 2.0 * K).ln()).abs() < 1e-3);
    assert!((found.upper.closed().unwrap() - (5.0 + 2.0 * K).ln()).abs() < 1e-4);
    // The covariance knows no curvature: its half-length is 1.96 * 2/5.
    let [lower, upper] = quadratic.unwrap();
    assert!((0.5 * (upper - lower) - K * 0.4).abs() < 1e-6);
}

#[test]
fn an_end_that_does_not_exist_is_open() {
    let (found, _) = profiled(
        &mut logarithm(3.0),
        unbounded([("u", 1.0)]),
        SigmaMode::Known,
        0,
    )
    .unwrap();
    let ProfileEnd::Open { rise, .. } = found.lower else {
        panic!("{:?}", found.lower)
    };
    // All the way down ‖r‖² is (5/3)².
    assert!(
        (rise - (5.0_f64 / 3.0).powi(2) / (K * K)).abs() < 1e-6,
        "{rise}"
    );
    assert!(found.upper.closed().is_some());
}

#[test]
fn a_bound_ends_the_walk_and_is_named() {
    let parameters = vec![Parameter::free("u", 1.0, -2.0, 2.0)];
    let (found, _) = profiled(&mut logarithm(2.0), parameters, SigmaMode::Known, 0).unwrap();
    let ProfileEnd::OpenAtBound {
        bound: Bound::Upper,
        value,
        rise,
    } = found.upper
    else {
        panic!("{:?}", found.upper)
    };
    assert_eq!(value, 2.0);
    assert!((rise - ((2.0_f64.exp() - 5.0) / 2.0).powi(2) / (K * K)).abs() < 1e-9);
}

#[test]
fn a_parameter_on_its_bound_is_open_there_and_profiled_to_the_other_side() {
    let parameters = vec![Parameter::free("u", 2.5, 2.0, 9.0)];
    let (found, quadratic) =
        profiled(&mut logarithm(2.0), parameters, SigmaMode::Known, 0).unwrap();
    assert!(matches!(
        found.lower,
        ProfileEnd::OpenAtBound {
            bound: Bound::Lower,
            rise: 0.0,
            ..
        }
    ));
    assert_eq!(quadratic, None);
    // Rise counts from the minimum within the bounds: (x-5)²/4 = ((e²-5)/2)² + k².
    let exact = (5.0 + 2.0 * (((2.0_f64.exp() - 5.0) / 2.0).powi(2) + K * K).sqrt()).ln();
    assert!((found.upper.closed().unwrap() - exact).abs() < 1e-4);
}

#[test]
fn a_region_without_a_value_stops_the_walk_at_its_edge() {
    let mut edge = ResidualRows(1, |p: &[f64], _| {
        let value = if p[0] > 0.5 { f64::NAN } else { p[0] };
        (value, vec![1.0])
    });
    let (found, _) = profiled(&mut edge, unbounded([("p", 0.2)]), SigmaMode::Known, 0).unwrap();
    let ProfileEnd::NotFollowed { value, .. } = found.upper else {
        panic!("{:?}", found.upper)
    };
    assert!((0.4999..=0.5).contains(&value), "{value}");
    assert!(found.lower.closed().is_some());
}

#[test]
fn a_lower_minimum_met_while_profiling_is_reported() {
    // A fit that was stopped at its start; refitting `a` alone already does better.
    let mut line = ResidualRows(3, |p: &[f64], i| {
        (p[0] + p[1] * i as f64 - 10.0, vec![1.0, i as f64])
    });
    let set = ParameterSet::new(unbounded([("a", 0.0), ("b", 1.0)]));
    let set = set.unwrap();
    let settings = LeastSquaresSettings {
        max_evaluations: 1,
        ..LeastSquaresSettings::default()
    };
    let fit = minimise(&mut line, &set, &settings).unwrap();
    let covariance =
        covariance(&set, &fit, SigmaMode::Known, &CovarianceSettings::default()).unwrap();
    let (rise, settings) = (
        rise_at_95(&fit, &covariance).unwrap(),
        ProfileSettings::default(),
    );
    let found = profile(&mut line, &set, &fit, 1, rise, &settings).unwrap();
    let lower = found.lower_minimum.unwrap();
    assert!(lower.sum_of_squares < fit.sum_of_squares() - 100.0);
    assert!((lower.values[0] + lower.values[1] - 10.0).abs() < 1e-9);
}

#[test]
fn only_a_free_parameter_has_a_profile() {
    let parameters = || {
        vec![
            Parameter::unbounded("u", 1.0),
            Parameter::fixed("f", 1.0),
            Parameter::tied("t", 0, 2.0),
        ]
    };
    for (index, says) in [
        (1, "parameter `f` is fixed"),
        (2, "parameter `t` is tied"),
        (3, "there is no parameter number 3; there are 3"),
    ] {
        let refused = profiled(&mut logarithm(2.0), parameters(), SigmaMode::Known, index);
        let error = refused.unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    }
}
