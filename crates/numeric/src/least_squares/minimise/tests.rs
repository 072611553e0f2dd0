//! Fits with known answers, fits on bounds, and every way a fit can end.

use proptest::prelude::*;

use super::*;
use crate::least_squares::rows::{ResidualRows, Row, unbounded};
use crate::least_squares::singular_values::dot;
use crate::least_squares::{JacobianView, Parameter};

fn fitted(problem: &mut dyn ResidualFunction, parameters: Vec<Parameter>) -> LeastSquaresFit {
    let set = ParameterSet::new(parameters).unwrap();
    minimise(problem, &set, &LeastSquaresSettings::default()).unwrap()
}

/// Why a fit has no value where it starts.
fn fault_at_the_start(
    problem: &mut dyn ResidualFunction,
    parameters: Vec<Parameter>,
) -> EvaluationFailure {
    let set = ParameterSet::new(parameters).unwrap();
    match minimise(problem, &set, &LeastSquaresSettings::default()) {
        Err(LeastSquaresError::StartHasNoValue { source }) => source,
        other => panic!("{other:?}"),
    }
}

/// y = a + b x through (0, 1), (1, 3), (2, 4), (3, 8): a = 0.7, b = 2.2 by hand.
fn line(p: &[f64], i: usize) -> Row {
    let x = i as f64;
    (p[0] + p[1] * x - [1.0, 3.0, 4.0, 8.0][i], vec![1.0, x])
}

const LINE: ResidualRows<fn(&[f64], usize) -> Row> = ResidualRows(4, line);

/// Rosenbrock's valley, minimum (1, 1), in its usual two residuals.
fn rosenbrock(p: &[f64], i: usize) -> Row {
    match i {
        0 => (10.0 * (p[1] - p[0] * p[0]), vec![-20.0 * p[0], 10.0]),
        _ => (1.0 - p[0], vec![-1.0, 0.0]),
    }
}

const ROSENBROCK: ResidualRows<fn(&[f64], usize) -> Row> = ResidualRows(2, rosenbrock);

#[test]
fn a_line_by_hand() {
    let fit = fitted(&mut { LINE }, unbounded([("a", 0.0), ("b", 0.0)]));
    assert!(
        (fit.values[0] - 0.7).abs() < 1e-14 && (fit.values[1] - 2.2).abs() < 1e-14,
        "{:?}",
        fit.values
    );
    assert!((fit.sum_of_squares() - 1.8).abs() < 1e-14);
    assert!(fit.termination.is_converged());
    assert_eq!(
        fit.jacobian_column(1),
        Some([0.0, 1.0, 2.0, 3.0].as_slice())
    );
    assert_eq!(fit.jacobian_column(2), None);
}

#[test]
fn the_valley_of_rosenbrock_down_to_zero() {
    let fit = fitted(&mut { ROSENBROCK }, unbounded([("x", -1.2), ("y", 1.0)]));
    assert!(fit.termination.is_converged());
    assert!((fit.values[0] - 1.0).abs() < 1e-12 && (fit.values[1] - 1.0).abs() < 1e-12);
}

#[test]
fn a_solution_beyond_a_bound_ends_on_it_and_the_rest_is_the_fixed_fit() {
    let bounded = fitted(
        &mut { LINE },
        vec![
            Parameter::unbounded("a", 0.0),
            Parameter::free("b", 1.0, 0.0, 2.0),
        ],
    );
    let fixed = fitted(
        &mut { LINE },
        vec![Parameter::unbounded("a", 0.0), Parameter::fixed("b", 2.0)],
    );
    assert_eq!(bounded.at_bound, [None, Some(Bound::Upper)]);
    assert_eq!(bounded.values[1], 2.0);
    assert!((bounded.values[0] - fixed.values[0]).abs() < 1e-15);
    assert!(bounded.termination.is_converged());
}

#[test]
fn a_start_on_the_wrong_bound_leaves_it() {
    let parameters = vec![
        Parameter::free("a", -5.0, -5.0, 5.0),
        Parameter::free("b", 9.0, 0.0, 9.0),
    ];
    let fit = fitted(&mut { LINE }, parameters);
    assert_eq!(fit.at_bound, [None, None]);
    assert!((fit.values[1] - 2.2).abs() < 1e-14);
}

#[test]
fn a_curved_problem_with_a_bound_across_the_valley() {
    // With x ≤ 0.5 the minimum of Rosenbrock's function is x = 0.5, y = 0.25.
    let parameters = vec![
        Parameter::free("x", -1.2, -2.0, 0.5),
        Parameter::unbounded("y", 1.0),
    ];
    let fit = fitted(&mut { ROSENBROCK }, parameters);
    assert_eq!(fit.at_bound, [Some(Bound::Upper), None]);
    assert!((fit.values[1] - 0.25).abs() < 1e-13);
    assert!((fit.sum_of_squares() - 0.25).abs() < 1e-13);
}

#[test]
fn everything_on_bounds_is_an_answer_too() {
    let parameters = vec![
        Parameter::free("a", 5.0, 4.0, 6.0),
        Parameter::free("b", 5.0, 4.0, 6.0),
    ];
    let fit = fitted(&mut { LINE }, parameters);
    assert_eq!(fit.at_bound, [Some(Bound::Lower), Some(Bound::Lower)]);
    assert!(matches!(
        fit.termination,
        Termination::Converged(Convergence::Gradient)
    ));
}

#[test]
fn a_tied_parameter_moves_with_the_one_it_is_tied_to() {
    // y = a (1 + 3 x): least squares by hand gives a = Σ y u/Σ u² with u = 1, 4, 7, 10: 121/166.
    let fit = fitted(
        &mut { LINE },
        vec![
            Parameter::tied("a", 1, 1.0 / 3.0),
            Parameter::unbounded("b", 1.0),
        ],
    );
    assert!(
        (fit.values[0] - 121.0 / 166.0).abs() < 1e-15,
        "{:?}",
        fit.values
    );
    assert_eq!(fit.values[1], 3.0 * fit.values[0]);
    assert!((fit.jacobian_column(0).unwrap()[3] - 10.0 / 3.0).abs() < 1e-15);
}

#[test]
fn a_parameter_without_effect_does_not_move() {
    let mut problem = ResidualRows(3, |p: &[f64], i| (p[0] - i as f64, vec![1.0, 0.0]));
    let fit = fitted(&mut problem, unbounded([("mean", 9.0), ("idle", 3.25)]));
    assert!((fit.values[0] - 1.0).abs() < 1e-15);
    assert_eq!(fit.values[1], 3.25);
}

#[test]
fn parameters_that_only_act_together_share_the_step() {
    let mut problem = ResidualRows(3, |p: &[f64], i| (p[0] + p[1] - i as f64, vec![1.0, 1.0]));
    let fit = fitted(&mut problem, unbounded([("a", 0.0), ("b", 0.0)]));
    assert!((fit.values[0] - 0.5).abs() < 1e-15 && (fit.values[1] - 0.5).abs() < 1e-15);
}

#[test]
fn a_residual_that_is_not_a_number_at_the_start_is_named() {
    let mut problem = ResidualRows(20, |p: &[f64], i| {
        (if i == 17 { f64::NAN } else { p[0] }, vec![1.0])
    });
    let source = fault_at_the_start(&mut problem, unbounded([("p", 1.0)]));
    assert_eq!(source.to_string(), "the model returned NaN at load step 17");
}

#[test]
fn a_derivative_that_is_infinite_is_named_with_its_parameter() {
    let mut problem = ResidualRows(2, |p: &[f64], i| {
        (p[1], vec![0.0, if i == 1 { f64::INFINITY } else { 1.0 }])
    });
    let parameters = vec![Parameter::fixed("a", 1.0), Parameter::unbounded("b", 1.0)];
    let source = fault_at_the_start(&mut problem, parameters);
    assert_eq!(
        source.to_string(),
        "the derivative to `b` is inf at load step 1"
    );
}

#[test]
fn an_overflow_of_the_squares_is_not_a_minimum() {
    let mut problem = ResidualRows(1, |p: &[f64], _| (1e200 * p[0], vec![1e200]));
    let source = fault_at_the_start(&mut problem, unbounded([("p", 1.0)]));
    assert!(matches!(source, EvaluationFailure::Overflow), "{source}");
}

#[test]
fn no_residuals_is_an_error() {
    let mut problem = ResidualRows(0, line);
    let set = ParameterSet::new(unbounded([("p", 1.0)])).unwrap();
    assert!(matches!(
        minimise(&mut problem, &set, &LeastSquaresSettings::default()),
        Err(LeastSquaresError::NoResiduals)
    ));
}

#[test]
fn a_place_without_a_value_on_the_way_only_shortens_the_step() {
    // ln has no value below zero, where the first full step from 3 leads.
    let mut problem = ResidualRows(1, |p: &[f64], _| (p[0].ln() + 2.0, vec![1.0 / p[0]]));
    let fit = fitted(&mut problem, unbounded([("p", 3.0)]));
    assert!(fit.termination.is_converged(), "{:?}", fit.termination);
    assert!((fit.values[0] - (-2.0_f64).exp()).abs() < 1e-14);
    assert!(fit.failed_evaluations > 0);
}

#[test]
fn an_edge_without_values_behind_it_ends_the_fit_with_the_reason() {
    // Falls towards 1, where the values end; the state is the last point with one.
    let mut problem = ResidualRows(1, |p: &[f64], _| {
        (if p[0] > 1.0 { f64::NAN } else { 5.0 - p[0] }, vec![-1.0])
    });
    let fit = fitted(&mut problem, unbounded([("p", 0.0)]));
    assert!(matches!(
        fit.termination,
        Termination::EvaluationFailed(EvaluationFailure::ResidualNotFinite { residual: 0, .. })
    ));
    assert!(
        (fit.values[0] - 1.0).abs() < 1e-9 && fit.objective.is_finite(),
        "{:?}",
        fit.values
    );
}

#[test]
fn a_model_may_refuse_with_its_own_error() {
    struct Refusing;
    impl ResidualFunction for Refusing {
        fn residual_count(&self) -> usize {
            1
        }
        fn evaluate(
            &mut self,
            _: &[f64],
            _: &mut [f64],
            _: Option<&mut JacobianView<'_>>,
        ) -> Result<(), EvaluationFailure> {
            Err(EvaluationFailure::of_model("the structure is a mechanism"))
        }
    }
    let source = fault_at_the_start(&mut Refusing, unbounded([("p", 1.0)]));
    assert_eq!(source.to_string(), "the model has no value");
    assert_eq!(
        std::error::Error::source(&source).unwrap().to_string(),
        "the structure is a mechanism"
    );
}

#[test]
fn too_few_evaluations_end_the_fit_where_it_stands() {
    let set = ParameterSet::new(unbounded([("x", -1.2), ("y", 1.0)])).unwrap();
    let settings = LeastSquaresSettings {
        max_evaluations: 5,
        ..LeastSquaresSettings::default()
    };
    let fit = minimise(&mut { ROSENBROCK }, &set, &settings).unwrap();
    assert!(matches!(
        fit.termination,
        Termination::AtLimit { max_evaluations: 5 }
    ));
    assert_eq!(fit.evaluations, 5);
    assert!(fit.objective < 12.1);
}

#[test]
fn derivatives_of_the_wrong_sign_stall_and_are_not_called_a_minimum() {
    let mut problem = ResidualRows(2, |p: &[f64], i| (p[0] + 3.0 + i as f64, vec![-1.0]));
    let fit = fitted(&mut problem, unbounded([("p", 1.0)]));
    assert!(
        matches!(fit.termination, Termination::Stalled),
        "{:?}",
        fit.termination
    );
    assert_eq!(fit.values, [1.0]);
}

proptest! {
    /// A linear problem in a box has one minimum, and the conditions of Karush, Kuhn and Tucker tell it: the gradient is zero
    /// inside and points outward on a bound.
    #[test]
    fn in_a_random_box_the_conditions_of_a_minimum_hold(
        entries in prop::collection::vec(-1.0..1.0_f64, 8 * 4),
        targets in prop::collection::vec(-5.0..5.0_f64, 8),
        corners in prop::collection::vec((-2.0..1.0_f64, 0.1..2.0_f64, 0.0..=1.0_f64), 4),
    ) {
        let row = |p: &[f64], i: usize| {
            let a = &entries[4 * i..4 * i + 4];
            (a.iter().zip(p).map(|(a, p)| a * p).sum::<f64>() - targets[i], a.to_vec())
        };
        let parameters = corners
            .iter()
            .enumerate()
            .map(|(j, &(lower, width, share))| {
                let upper = lower + width;
                Parameter::free(format!("p{j}"), (lower + share * width).min(upper), lower, upper)
            })
            .collect();
        let fit = fitted(&mut ResidualRows(8, row), parameters);
        prop_assert!(fit.termination.is_converged(), "{:?}", fit.termination);
        for j in 0..4 {
            let g = dot(fit.jacobian_column(j).unwrap(), &fit.residuals);
            match fit.at_bound[j] {
                None => prop_assert!(g.abs() < 1e-9, "{j}: {g}"),
                Some(Bound::Lower) => prop_assert!(g > -1e-9, "{j}: {g}"),
                Some(Bound::Upper) => prop_assert!(g < 1e-9, "{j}: {g}"),
            }
        }
    }
}
