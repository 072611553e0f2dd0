//! The mapping between free and full vectors, and every mistake in a set.

use super::*;

fn error_of(parameters: Vec<Parameter>) -> LeastSquaresError {
    ParameterSet::new(parameters).unwrap_err()
}

#[test]
fn ties_are_followed_to_a_free_or_a_fixed_parameter() {
    let set = ParameterSet::new(vec![
        Parameter::tied("a", 1, 2.0),
        Parameter::tied("b", 2, 3.0),
        Parameter::unbounded("c", 1.0),
        Parameter::fixed("d", 7.0),
        Parameter::tied("e", 3, 0.5),
        Parameter::unbounded("f", 4.0),
    ])
    .unwrap();
    assert_eq!(set.free_indices(), [2, 5]);
    assert_eq!(set.free_start(), [1.0, 4.0]);
    let mut full = [0.0; 6];
    set.expand(&[10.0, 20.0], &mut full).unwrap();
    assert_eq!(full, [60.0, 30.0, 10.0, 7.0, 3.5, 20.0]);
    assert_eq!(
        set.slots(),
        [Some(2), Some(3), Some(0), None, None, Some(1)]
    );
    assert_eq!(
        set.tied_columns().collect::<Vec<_>>(),
        [(2, 0, 6.0), (3, 0, 3.0)]
    );
}

#[test]
fn each_mistake_has_its_own_error() {
    assert!(matches!(
        error_of(vec![Parameter::free("a", 3.0, 0.0, 2.0)]),
        LeastSquaresError::StartOutsideBounds { start: 3.0, .. }
    ));
    assert!(matches!(
        error_of(vec![Parameter::free("a", 2.0, 2.0, 2.0)]),
        LeastSquaresError::EmptyRange { .. }
    ));
    assert!(matches!(
        error_of(vec![Parameter::free("a", 2.0, f64::NAN, 3.0)]),
        LeastSquaresError::NotFinite {
            what: "its lower bound",
            ..
        }
    ));
    assert!(matches!(
        error_of(vec![Parameter::unbounded("a", f64::INFINITY)]),
        LeastSquaresError::NotFinite {
            what: "its start",
            ..
        }
    ));
    assert!(matches!(
        error_of(vec![Parameter::fixed("a", f64::NAN)]),
        LeastSquaresError::NotFinite {
            what: "its value",
            ..
        }
    ));
    assert!(matches!(
        error_of(vec![
            Parameter::unbounded("a", 0.0),
            Parameter::tied("b", 0, f64::NAN)
        ]),
        LeastSquaresError::NotFinite {
            what: "its ratio",
            ..
        }
    ));
    assert!(matches!(
        error_of(vec![
            Parameter::unbounded("a", 0.0),
            Parameter::tied("b", 2, 1.0)
        ]),
        LeastSquaresError::UnknownTie {
            index: 2,
            count: 2,
            ..
        }
    ));
    assert!(matches!(
        error_of(vec![Parameter::fixed("a", 0.0)]),
        LeastSquaresError::NoFreeParameter { count: 1 }
    ));
    assert!(matches!(
        error_of(vec![]),
        LeastSquaresError::NoFreeParameter { count: 0 }
    ));
    assert!(matches!(
        error_of(vec![
            Parameter::unbounded("a", 0.0),
            Parameter::fixed("a", 1.0)
        ]),
        LeastSquaresError::DuplicateName { .. }
    ));
}

#[test]
fn a_circle_of_ties_is_named() {
    let error = error_of(vec![
        Parameter::tied("start", 1, 1.0),
        Parameter::tied("b", 2, 1.0),
        Parameter::tied("c", 1, 1.0),
        Parameter::unbounded("free", 0.0),
    ]);
    assert_eq!(error.to_string(), "the ties form a cycle: b -> c -> b");
}

#[test]
fn a_parameter_tied_to_itself_is_an_error() {
    let error = error_of(vec![
        Parameter::tied("a", 0, 1.0),
        Parameter::unbounded("b", 0.0),
    ]);
    assert_eq!(error.to_string(), "the ties form a cycle: a -> a");
}

#[test]
fn a_start_of_wrong_length_or_outside_is_refused() {
    let set = ParameterSet::new(vec![Parameter::free("a", 1.0, 0.0, 2.0)]).unwrap();
    assert!(matches!(
        set.with_start(&[]),
        Err(LeastSquaresError::WrongLength {
            expected: 1,
            found: 0,
            ..
        })
    ));
    assert!(matches!(
        set.with_start(&[5.0]),
        Err(LeastSquaresError::StartOutsideBounds { .. })
    ));
    assert_eq!(set.with_start(&[2.0]).unwrap().free_start(), [2.0]);
    assert!(matches!(
        set.expand(&[1.0], &mut []),
        Err(LeastSquaresError::WrongLength { .. })
    ));
}
