//! Covariances with known answers and every status.

use super::*;
use crate::least_squares::rows::{ResidualRows, unbounded};
use crate::least_squares::{LeastSquaresSettings, Parameter, minimise};

fn described(
    rows: &[&[f64]],
    y: &[f64],
    parameters: Vec<Parameter>,
    mode: SigmaMode,
) -> Result<ParameterCovariance, LeastSquaresError> {
    let mut problem = ResidualRows(y.len(), |p: &[f64], i: usize| {
        let modelled: f64 = rows[i].iter().zip(p).map(|(a, p)| a * p).sum();
        (modelled - y[i], rows[i].to_vec())
    });
    let set = ParameterSet::new(parameters)?;
    let fit = minimise(&mut problem, &set, &LeastSquaresSettings::default())?;
    covariance(&set, &fit, mode, &CovarianceSettings::default())
}

const LINE: [&[f64]; 4] = [&[1.0, 0.0], &[1.0, 1.0], &[1.0, 2.0], &[1.0, 3.0]];
const Y: [f64; 4] = [1.0, 3.0, 4.0, 8.0];

fn a_and_b() -> Vec<Parameter> {
    unbounded([("a", 0.0), ("b", 0.0)])
}

fn close(found: Option<f64>, expected: f64) {
    let found = found.unwrap();
    assert!(
        (found / expected - 1.0).abs() < 1e-12,
        "{found} instead of {expected}"
    );
}

#[test]
fn a_line_with_known_standard_deviations() {
    // (AᵀA)⁻¹ = [0.7 -0.3; -0.3 0.2].
    let found = described(&LINE, &Y, a_and_b(), SigmaMode::Known).unwrap();
    close(found.estimates[0].standard_error, 0.7_f64.sqrt());
    close(found.of(0, 1), -0.3);
    close(found.correlation(0, 1), -0.3 / 0.14_f64.sqrt());
    let [lower, upper] = found.estimates[1].interval_95.unwrap();
    close(
        Some(upper - lower),
        2.0 * 1.959_963_984_540_054 * 0.2_f64.sqrt(),
    );
    close(found.reduced_chi_squared, 0.9);
    assert_eq!((found.dof, found.rank, found.estimated), (2, 2, 2));
    assert!(found.strong_pairs.is_empty() && found.unidentified.is_empty());
}

#[test]
fn a_line_with_estimated_standard_deviation_uses_the_spread_and_student_t() {
    let found = described(&LINE, &Y, a_and_b(), SigmaMode::Estimated).unwrap();
    close(found.estimates[1].standard_error, (0.9_f64 * 0.2).sqrt());
    // t(0.975, 2) = 4.30265272974946.
    let [lower, upper] = found.estimates[1].interval_95.unwrap();
    close(
        Some(0.5 * (upper - lower)),
        4.302_652_729_749_46 * 0.18_f64.sqrt(),
    );
}

#[test]
fn the_condition_number_is_that_of_columns_of_length_one() {
    // Two unit columns with cosine c have singular values √(1 ± c); c = 6/√(4·14).
    let found = described(&LINE, &Y, a_and_b(), SigmaMode::Known).unwrap();
    let c: f64 = 6.0 / 56.0_f64.sqrt();
    close(Some(found.condition_number), ((1.0 + c) / (1.0 - c)).sqrt());
}

#[test]
fn a_strong_pair_is_listed() {
    let rows: [&[f64]; 3] = [&[1.0, 10.0], &[1.0, 11.0], &[1.0, 12.0]];
    let found = described(&rows, &[1.0, 2.0, 4.0], a_and_b(), SigmaMode::Known).unwrap();
    assert_eq!(found.strong_pairs.len(), 1);
    // ρ = -Σx/√(n Σx²).
    close(
        Some(found.strong_pairs[0].correlation),
        -33.0 / (3.0 * 365.0_f64).sqrt(),
    );
    assert_eq!(
        (found.strong_pairs[0].first, found.strong_pairs[0].second),
        (0, 1)
    );
}

#[test]
fn fixed_tied_and_bounded_parameters_have_their_status() {
    let rows: [&[f64]; 4] = [
        &[1.0, 0.0, 1.0, 0.0],
        &[0.0, 1.0, 1.0, 0.0],
        &[1.0, 1.0, 0.0, 0.0],
        &[0.0, 0.0, 0.0, 1.0],
    ];
    let parameters = vec![
        Parameter::unbounded("free", 0.0),
        Parameter::tied("tied", 0, -2.0),
        Parameter::fixed("fixed", 0.5),
        Parameter::free("bounded", 1.0, 0.0, 2.0),
    ];
    let found = described(&rows, &[1.0, 2.0, 3.0, 7.0], parameters, SigmaMode::Known).unwrap();
    let statuses: Vec<ParameterStatus> = found.estimates.iter().map(|e| e.status).collect();
    assert_eq!(
        statuses,
        [
            ParameterStatus::Free,
            ParameterStatus::Tied,
            ParameterStatus::Fixed,
            ParameterStatus::AtBound(Bound::Upper)
        ]
    );
    // Columns 1, 0, 1 and 0, 1, 1 combine to 1, -2, -1: length² 6.
    close(found.estimates[0].standard_error, 1.0 / 6.0_f64.sqrt());
    close(found.estimates[1].standard_error, 2.0 / 6.0_f64.sqrt());
    assert_eq!(found.estimates[2].standard_error, None);
    assert_eq!(found.estimates[3].standard_error, None);
    assert_eq!((found.estimated, found.dof), (1, 3));
    assert_eq!(found.of(0, 3), None);
}

#[test]
fn parameters_that_only_act_together_are_named_and_the_rest_keeps_its_error() {
    // d = b - 2 a cannot be seen: columns a, b, c with a = 2 b; e acts on nothing.
    let rows: [&[f64]; 4] = [
        &[2.0, 1.0, 0.0, 0.0],
        &[4.0, 2.0, 1.0, 0.0],
        &[2.0, 1.0, 1.0, 0.0],
        &[0.0, 0.0, 3.0, 0.0],
    ];
    let parameters = ["a", "b", "c", "e"]
        .map(|name| Parameter::unbounded(name, 1.0))
        .to_vec();
    let found = described(&rows, &[1.0, 2.0, 3.0, 4.0], parameters, SigmaMode::Known).unwrap();
    assert_eq!((found.rank, found.estimated, found.dof), (2, 4, 2));
    assert!(found.condition_number > 1e15);
    let pair = found
        .unidentified
        .iter()
        .position(|d| d.components.len() == 2)
        .unwrap();
    let why = WhyNotIdentified::OnlyInCombination { direction: pair };
    assert_eq!(
        found.estimates[0].status,
        ParameterStatus::NotIdentified { why }
    );
    assert_eq!(
        found.estimates[1].status,
        ParameterStatus::NotIdentified { why }
    );
    let alone = ParameterStatus::NotIdentified {
        why: WhyNotIdentified::NoEffect,
    };
    assert_eq!(found.estimates[3].status, alone);
    let components = &found.unidentified[pair].components;
    let change = |name: &str| components.iter().find(|c| c.name == name).unwrap().change;
    assert!((change("b") / change("a") + 2.0).abs() < 1e-12);
    // c as in the problem with a alone: columns (2, 4, 2, 0), (0, 1, 1, 3); inverse entry 24/(24·11 - 36).
    assert_eq!(found.estimates[2].status, ParameterStatus::Free);
    close(
        found.estimates[2].standard_error,
        (24.0_f64 / (24.0 * 11.0 - 36.0)).sqrt(),
    );
    assert_eq!(found.estimates[0].standard_error, None);
}

#[test]
fn more_parameters_than_residuals_are_not_identified() {
    let found = described(&[&[1.0, 1.0]], &[3.0], a_and_b(), SigmaMode::Known).unwrap();
    assert_eq!((found.rank, found.dof), (1, 0));
    assert_eq!(found.reduced_chi_squared, None);
    assert!(
        found
            .estimates
            .iter()
            .all(|e| matches!(e.status, ParameterStatus::NotIdentified { .. }))
    );
}

#[test]
fn without_degrees_of_freedom_a_spread_cannot_be_estimated() {
    let rows: [&[f64]; 2] = [&[1.0, 0.0], &[1.0, 1.0]];
    assert!(matches!(
        described(&rows, &[1.0, 2.0], a_and_b(), SigmaMode::Estimated),
        Err(LeastSquaresError::NoDegreesOfFreedom {
            residuals: 2,
            estimated: 2
        })
    ));
    assert!(described(&rows, &[1.0, 2.0], a_and_b(), SigmaMode::Known).is_ok());
}
