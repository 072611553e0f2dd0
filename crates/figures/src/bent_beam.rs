//! Shape of a beam between its nodes.

use stiffbench_numeric::vector::{cross, dot, norm, scale, subtract};

/// Pieces of the line: the cubic looks smooth from twelve on.
const PIECES: usize = 16;

/// Centre line of a beam whose ends move and turn, displacements magnified: cubic across the beam, linear along it.
///
/// The cubic is exact for an Euler-Bernoulli beam loaded at its ends only.
///
/// # Arguments
/// - `ends_m`: positions of the two ends without load, m.
/// - `displacements_m`, `rotations_rad`: of the two ends, global, m and rad.
/// - `magnification`: multiple of the displacements that is shown.
///
/// # Returns
/// Points from the first end to the second, m; `None` for a beam without length.
///
/// # Source
/// W. McGuire, R. H. Gallagher, R. D. Ziemian, Matrix Structural Analysis, 2nd ed., chapter on shape functions.
pub(super) fn bent_beam(
    ends_m: [[f64; 3]; 2],
    displacements_m: [[f64; 3]; 2],
    rotations_rad: [[f64; 3]; 2],
    magnification: f64,
) -> Option<Vec<[f64; 3]>> {
    let [first_m, second_m] = ends_m;
    let span_m = subtract(second_m, first_m);
    let length_m = norm(span_m);
    if !(length_m.is_finite() && length_m > 0.0) {
        return None;
    }
    let axis = scale(span_m, 1.0 / length_m);
    // An end that turns by θ tilts the centre line by θ × axis, at right angles to the beam.
    let slopes = rotations_rad.map(|rotation| cross(rotation, axis));
    let along = displacements_m.map(|u| scale(axis, dot(u, axis)));
    let across = [0, 1].map(|end| subtract(displacements_m[end], along[end]));
    let point = |s: f64| {
        let [h1, h2, h3, h4] = [
            1.0 - 3.0 * s * s + 2.0 * s * s * s,
            length_m * (s - 2.0 * s * s + s * s * s),
            3.0 * s * s - 2.0 * s * s * s,
            length_m * (s * s * s - s * s),
        ];
        std::array::from_fn(|i| {
            let displacement_m = (1.0 - s) * along[0][i]
                + s * along[1][i]
                + h1 * across[0][i]
                + h2 * slopes[0][i]
                + h3 * across[1][i]
                + h4 * slopes[1][i];
            first_m[i] + s * span_m[i] + magnification * displacement_m
        })
    };
    Some(
        (0..=PIECES)
            .map(|piece| point(piece as f64 / PIECES as f64))
            .collect(),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    const ENDS: [[f64; 3]; 2] = [[0.0; 3], [0.0, 0.0, 2.0]];
    const TIP_M: f64 = -1e-3;

    #[test]
    fn a_cantilever_takes_the_shape_of_the_textbook() {
        // Clamped at z = 0, force along y at the tip: θ = 3 δ/(2 L), and a tip that moves along +y turns about -x.
        let turned = [-1.5 * TIP_M / 2.0, 0.0, 0.0];
        let line = bent_beam(
            ENDS,
            [[0.0; 3], [0.0, TIP_M, 0.0]],
            [[0.0; 3], turned],
            10.0,
        )
        .unwrap();
        for point in line {
            // v(s) = δ (3 s² - s³)/2: Gere and Goodno, Mechanics of Materials, table of cantilevers, case of an end load.
            let s = point[2] / 2.0;
            let expected = 10.0 * TIP_M * (3.0 * s * s - s * s * s) / 2.0;
            assert!((point[1] - expected).abs() < 1e-15, "{point:?}");
        }
    }

    #[test]
    fn a_rigid_turn_leaves_a_beam_straight() {
        let turn = [0.5e-3, 0.0, 0.0];
        let line = bent_beam(ENDS, [[0.0; 3], [0.0, TIP_M, 0.0]], [turn; 2], 1.0).unwrap();
        for point in line {
            assert!((point[1] + 0.5e-3 * point[2]).abs() < 1e-15, "{point:?}");
        }
    }

    #[test]
    fn a_slanting_beam_bends_at_right_angles_to_itself() {
        let ends = [[1.0, 0.0, 0.0], [1.0, 3.0, 4.0]];
        let line = bent_beam(ends, [[0.0; 3]; 2], [[1e-3, 0.0, 0.0], [0.0; 3]], 1.0).unwrap();
        for (place, point) in line.iter().enumerate() {
            let s = place as f64 / PIECES as f64;
            let moved = [0, 1, 2].map(|i| point[i] - ends[0][i] - s * (ends[1][i] - ends[0][i]));
            assert!(dot(moved, [0.0, 0.6, 0.8]).abs() < 1e-14);
            // h2 θ = L (s - 2 s² + s³) θ, toward x × (0, 0.6, 0.8) = (0, -0.8, 0.6).
            let expected = 5.0 * (s - 2.0 * s * s + s * s * s) * 1e-3;
            assert!((dot(moved, [0.0, -0.8, 0.6]) - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn a_beam_without_length_has_no_shape() {
        assert_eq!(
            bent_beam([[1.0; 3]; 2], [[0.0; 3]; 2], [[0.0; 3]; 2], 1.0),
            None
        );
    }
}
