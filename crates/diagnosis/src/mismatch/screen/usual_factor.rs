//! Usual mistakes in a value: another sign, a decimal point, another unit.

/// Inch over mm, pound-force over N, kilogram-force over N.
const OF_UNITS: [f64; 3] = [25.4, 4.448_221_6, 9.806_65];

/// Places by which a decimal point is moved at most: from micrometres to metres.
const MOST_PLACES: i32 = 6;

/// What a value that somebody recorded wrongly must be multiplied by, the likeliest first.
pub(crate) fn usual_factors() -> impl Iterator<Item = f64> + Clone {
    with_units(&OF_UNITS)
}

/// The same of a length that is compared with no force.
pub(crate) fn usual_factors_of_lengths() -> impl Iterator<Item = f64> + Clone {
    with_units(&OF_UNITS[..1])
}

fn with_units(units: &'static [f64]) -> impl Iterator<Item = f64> + Clone {
    let places = (1..=MOST_PLACES).flat_map(|places| [places, -places]);
    let units = units.iter().flat_map(|unit| [*unit, unit.recip()]);
    let tens = places.map(|places| 10_f64.powi(places));
    std::iter::once(-1.0).chain(tens).chain(units)
}

/// How many values are such a mistake too, either way: those of the same sort that are the nearest to one.
pub(crate) fn alike(factor: f64) -> f64 {
    let is_of_units = OF_UNITS
        .iter()
        .any(|unit| is(factor, *unit) || is(factor, unit.recip()));
    match factor {
        _ if factor < 0.0 => 1.0,
        _ if is_of_units => 2.0 * OF_UNITS.len() as f64,
        _ => 2.0,
    }
}

/// Whether a factor is a certain one: what a search gives has rounding errors.
fn is(factor: f64, other: f64) -> bool {
    (factor / other - 1.0).abs() < 1e-9
}

/// The usual factor by which a value agrees with what it should be; `None` if it is off by anything else.
pub(crate) fn misread_factor(value: f64, expected: f64, u: f64) -> Option<f64> {
    // A value that lies near zero agrees with itself of any sign.
    if expected.abs() < 10.0 * u {
        return None;
    }
    let agrees = |factor: &f64| (factor * value - expected).abs() < 4.0 * u;
    usual_factors().find(agrees)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn usual_factors_are_found_and_others_are_not() {
        let found = |factor: f64| misread_factor(3.0 / factor, 3.01, 0.01);
        for factor in [1000.0, 0.1, 25.4, 1.0 / 4.448_221_6, -1.0, 1e-6] {
            let found = found(factor).unwrap();
            assert!(is(found, factor), "{factor}: {found}");
        }
        for factor in [1.0, 2.0, 0.8, 50.0, -10.0] {
            assert_eq!(found(factor), None, "{factor}");
        }
        assert_eq!(misread_factor(-0.05, 0.05, 0.01), None);
    }

    #[test]
    fn a_decimal_point_is_nearest_on_either_side_and_so_is_each_unit() {
        let alike: Vec<f64> = [-1.0, 10.0, 0.001, 25.4, 1.0 / 9.806_65]
            .map(alike)
            .to_vec();
        assert_eq!(alike, [1.0, 2.0, 2.0, 6.0, 6.0]);
    }
}
