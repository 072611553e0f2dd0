//! Sine and cosine of angles in degrees.

use pulp::{Simd, WithSimd};

use super::lane::Lane;
use super::number::{Number, multiply_add, multiply_subtract};

/// Adding and subtracting it rounds numbers far below it to whole ones.
const ROUNDING: f64 = 6_755_399_441_055_744.0;

/// Coefficients of (sin r - r)/r³ in powers of r², highest first: the series to r¹⁵, whose next term is below 2e-18 for |r| ≤ π/4.
const SINE: [f64; 7] = [
    -1.0 / 1_307_674_368_000.0,
    1.0 / 6_227_020_800.0,
    -1.0 / 39_916_800.0,
    1.0 / 362_880.0,
    -1.0 / 5_040.0,
    1.0 / 120.0,
    -1.0 / 6.0,
];

/// Coefficients of (cos r - 1)/r² in powers of r², highest first: the series to r¹⁶.
const COSINE: [f64; 8] = [
    1.0 / 20_922_789_888_000.0,
    -1.0 / 87_178_291_200.0,
    1.0 / 479_001_600.0,
    -1.0 / 3_628_800.0,
    1.0 / 40_320.0,
    -1.0 / 720.0,
    1.0 / 24.0,
    -0.5,
];

/// Sine and cosine of an angle in degrees, to 3e-16 for angles of a few thousand turns.
///
/// Whole quarters of a turn are taken off in degrees, where that is exact; what is left is at most 45 degrees.
#[inline(always)]
pub fn sin_cos_deg<T: Number>(angle_deg: T) -> (T, T) {
    let quarters = rounded(angle_deg * angle_deg.of(1.0 / 90.0));
    let rest = multiply_subtract(quarters, angle_deg.of(90.0), angle_deg)
        * angle_deg.of(std::f64::consts::PI / 180.0);
    let squared = rest * rest;
    let sine = multiply_add(polynomial(&SINE, squared) * squared, rest, rest);
    let cosine = multiply_add(polynomial(&COSINE, squared), squared, angle_deg.of(1.0));

    // -2, -1, 0, 1 or 2 quarters: every other one swaps the two, half of them turn a sign.
    let quarter = multiply_subtract(
        rounded(quarters * angle_deg.of(0.25)),
        angle_deg.of(4.0),
        quarters,
    );
    let distance = multiply_add(quarter, quarter, angle_deg.of(-1.0));
    let odd = distance * distance;
    let half = angle_deg.of(0.5);
    let s = odd.choose(half, cosine, sine);
    let c = odd.choose(half, sine, cosine);
    (
        quarter.choose(-half, -s, quarter.choose(angle_deg.of(1.5), s, -s)),
        quarter.choose(angle_deg.of(-1.5), -c, quarter.choose(half, c, -c)),
    )
}

/// Sines of many angles, and the same a quarter of a turn further.
///
/// # Arguments
/// - `[amplitude, per_unit_deg, phase_deg]`: of the sine of a place.
/// - `places`: where it is asked for; `out` as long.
pub fn waves(wave: [f64; 3], places: &[f64], out: [&mut [f64]; 2]) {
    pulp::Arch::new().dispatch(Waves { wave, places, out });
}

struct Waves<'a> {
    wave: [f64; 3],
    places: &'a [f64],
    out: [&'a mut [f64]; 2],
}

impl WithSimd for Waves<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let [amplitude, per_unit_deg, phase_deg] = self.wave.map(|x| Lane::splat(simd, x));
        let [sines, cosines] = self.out;
        let count = Lane::<S>::COUNT;
        let out = sines.chunks_mut(count).zip(cosines.chunks_mut(count));
        for (place, (sine, cosine)) in self.places.chunks(count).zip(out) {
            let place = Lane::read(simd, place);
            let (s, c) = sin_cos_deg(multiply_add(place, per_unit_deg, phase_deg));
            (amplitude * s).write(sine);
            (amplitude * c).write(cosine);
        }
    }
}

/// The nearest whole number.
#[inline(always)]
fn rounded<T: Number>(value: T) -> T {
    (value + value.of(ROUNDING)) - value.of(ROUNDING)
}

#[inline(always)]
fn polynomial<T: Number>(coefficients: &[f64], at: T) -> T {
    let mut sum = at.of(coefficients[0]);
    for &coefficient in &coefficients[1..] {
        sum = multiply_add(sum, at, at.of(coefficient));
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_are_those_of_the_standard_library() {
        for step in -100_000..100_000 {
            let angle_deg = 0.0137 * f64::from(step);
            let (sin, cos) = sin_cos_deg(angle_deg);
            // The standard library takes radians, whose rounding grows with the angle.
            let (expected_sin, expected_cos) = (angle_deg % 360.0).to_radians().sin_cos();
            assert!((sin - expected_sin).abs() < 1.5e-15, "sin {angle_deg}");
            assert!((cos - expected_cos).abs() < 1.5e-15, "cos {angle_deg}");
        }
    }

    #[test]
    fn waves_are_those_of_every_place() {
        let places: Vec<f64> = (0..21).map(|i| 1.3e-4 * f64::from(i * i)).collect();
        let (mut sines, mut cosines) = (vec![0.0; 21], vec![0.0; 21]);
        waves(
            [2e-6, 360.0 / 5e-5, 30.0],
            &places,
            [&mut sines, &mut cosines],
        );
        for (place, (sine, cosine)) in places.iter().zip(sines.iter().zip(&cosines)) {
            let (s, c) = (std::f64::consts::TAU * place / 5e-5 + 30_f64.to_radians()).sin_cos();
            assert!((sine - 2e-6 * s).abs() < 1e-17, "{place}");
            assert!((cosine - 2e-6 * c).abs() < 1e-17, "{place}");
        }
    }

    #[test]
    fn whole_quarters_are_exact() {
        for quarter in -9..10 {
            let (sin, cos) = sin_cos_deg(90.0 * f64::from(quarter));
            let expected = [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)];
            assert_eq!(
                (sin, cos),
                expected[usize::try_from(quarter + 12).unwrap() % 4]
            );
        }
    }
}
