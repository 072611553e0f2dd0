//! The mapping between free and full vectors, and every mistake in a set.

use super::*;

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
    let free = |name: &str| Parameter::unbounded(name, 0.0);
    let (tied, nan) = (Parameter::tied, f64::NAN);
    #[rustfmt::skip]
    let cases = [
        (vec![Parameter::free("a", 3.0, 0.0, 2.0)], "`a` starts at 3, outside its bounds 0 to 2"),
        (vec![Parameter::free("a", 2.0, 2.0, 2.0)], "`a`: the bounds 2 to 2 leave nothing to choose"),
        (vec![Parameter::free("a", 2.0, nan, 3.0)], "`a`: its lower bound is NaN"),
        (vec![Parameter::unbounded("a", f64::INFINITY)], "`a`: its start is inf"),
        (vec![Parameter::fixed("a", nan)], "`a`: its value is NaN"),
        (vec![free("a"), tied("b", 0, nan)], "`b`: its ratio is NaN"),
        (vec![free("a"), tied("b", 2, 1.0)], "`b` is tied to parameter number 2, but there are 2"),
        (vec![Parameter::fixed("a", 0.0)], "none of the 1 parameters is free"),
        (vec![], "none of the 0 parameters is free"),
        (vec![free("a"), Parameter::fixed("a", 1.0)], "two parameters are called `a`"),
        (vec![tied("start", 1, 1.0), tied("b", 2, 1.0), tied("c", 1, 1.0), free("free")], "the ties form a cycle: b -> c -> b"),
        (vec![tied("a", 0, 1.0), free("b")], "the ties form a cycle: a -> a"),
    ];
    for (parameters, says) in cases {
        let error = ParameterSet::new(parameters).unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    }
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
