//! Units in which a parameter of a law may be written, besides the SI unit that files carry.

/// Spellings of a unit: the word, and how many of them make one SI unit.
///
/// Division by such a count gives the number nearest to the quotient: 30 um is 3e-5 m, which 30 × 1e-6 is not.
type Spelling = (&'static str, f64);

/// Degrees in a radian.
const DEGREES: f64 = 180.0 / std::f64::consts::PI;

/// All spellings of an SI unit of [`super::Law::parameters`], itself first.
fn spellings(si: &str) -> &'static [Spelling] {
    match si {
        "rad" => &[("rad", 1.0), ("mrad", 1e3), ("urad", 1e6), ("deg", DEGREES)],
        "N*m" => &[("N*m", 1.0), ("N*mm", 1e3), ("mN*m", 1e3)],
        "rad/(N*m)" => &[("rad/(N*m)", 1.0), ("mrad/(N*m)", 1e3), ("urad/(N*m)", 1e6)],
        "rad/(N*m)^2" => &[
            ("rad/(N*m)^2", 1.0),
            ("mrad/(N*m)^2", 1e3),
            ("urad/(N*m)^2", 1e6),
        ],
        "m/N" => &[("m/N", 1.0), ("mm/N", 1e3), ("um/N", 1e6), ("nm/N", 1e9)],
        "m" => &[("m", 1.0), ("mm", 1e3), ("um", 1e6), ("nm", 1e9)],
        "m/s" => &[
            ("m/s", 1.0),
            ("um/s", 1e6),
            ("nm/s", 1e9),
            ("um/min", 6e7),
            ("um/h", 3.6e9),
        ],
        "m/K" => &[("m/K", 1.0), ("mm/K", 1e3), ("um/K", 1e6), ("nm/K", 1e9)],
        "1/N" => &[("1/N", 1.0), ("%/N", 1e2), ("1/kN", 1e3)],
        "1/decade" => &[("1/decade", 1.0), ("%/decade", 1e2)],
        "s" => &[("s", 1.0), ("ms", 1e3), ("min", 1.0 / 60.0)],
        "1" => &[("1", 1.0), ("", 1.0), ("%", 1e2)],
        "repeats" => &[("repeats", 1.0), ("repeat", 1.0), ("", 1.0)],
        _ => &[],
    }
}

/// A number in SI; `None` if `unit` is no spelling of `si`.
pub(super) fn in_si(number: f64, unit: &str, si: &str) -> Option<f64> {
    let plain = unit.replace(['µ', 'μ'], "u").replace(['·', '⋅'], "*");
    let (_, per_si) = spellings(si).iter().find(|(word, _)| *word == plain)?;
    Some(number / per_si)
}

/// The spellings of a unit in words, for messages.
pub(super) fn accepted(si: &str) -> String {
    let words: Vec<&str> = spellings(si)
        .iter()
        .map(|(word, _)| if word.is_empty() { "no unit" } else { word })
        .collect();
    words.join(", ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::Law;

    #[test]
    fn every_parameter_has_a_unit_that_is_its_own_first_spelling() {
        for law in Law::ALL {
            for parameter in law.parameters() {
                let [first, ..] = spellings(parameter.unit) else {
                    panic!("{law} {}: {} is unknown", parameter.name, parameter.unit)
                };
                assert_eq!(*first, (parameter.unit, 1.0));
            }
        }
    }

    #[test]
    fn numbers_are_divided_by_what_makes_one_si_unit() {
        for (number, unit, si, expected) in [
            (-30.0, "um", "m", -3e-5),
            (-30.0, "µm", "m", -3e-5),
            (120.0, "urad", "rad", 1.2e-4),
            (3.6, "N·m", "N*m", 3.6),
            (4.0, "%/decade", "1/decade", 0.04),
            (36.0, "um/h", "m/s", 1e-8),
            (2.0, "min", "s", 120.0),
            (1.5, "", "repeats", 1.5),
        ] {
            assert_eq!(in_si(number, unit, si), Some(expected), "{number} {unit}");
        }
        assert!((in_si(180.0, "deg", "rad").unwrap() - std::f64::consts::PI).abs() < 1e-15);
        assert_eq!(in_si(1.0, "N", "m"), None);
        assert_eq!(in_si(1.0, "", "m"), None);
        assert_eq!(accepted("repeats"), "repeats, repeat, no unit");
    }
}
