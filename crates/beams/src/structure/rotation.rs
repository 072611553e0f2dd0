//! Local axes of an element in global coordinates.

use stiffbench_numeric::vector::{cross, dot, norm, scale};

/// Right-handed orthonormal axes of an element; the rows take global components to local ones (the paper's `t`, eq. (20)).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LocalAxes {
    /// From the first node to the second.
    pub x: [f64; 3],
    /// Normal of the plane in which I_y resists bending.
    pub y: [f64; 3],
    /// x × y.
    pub z: [f64; 3],
}

impl LocalAxes {
    /// Axes of an element along `span_m` whose local y is as near to `toward_y` as a right angle to x allows; also its length, m.
    ///
    /// Returns `None` if the element has no length or `toward_y` is parallel to it: then the axes are undefined.
    #[must_use]
    pub fn along(span_m: [f64; 3], toward_y: [f64; 3]) -> Option<(Self, f64)> {
        let length_m = norm(span_m);
        if !(length_m.is_finite() && length_m > 0.0) {
            return None;
        }
        let x = scale(span_m, 1.0 / length_m);
        let along_x = dot(toward_y, x);
        let y = [0, 1, 2].map(|i| toward_y[i] - along_x * x[i]);
        let y_norm = norm(y);
        // A hint within 1e-9 rad of the axis fixes no plane: what is left of it is rounding.
        if y_norm.is_nan() || y_norm <= 1e-9 * norm(toward_y) {
            return None;
        }
        let y = scale(y, 1.0 / y_norm);
        Some((
            Self {
                x,
                y,
                z: cross(x, y),
            },
            length_m,
        ))
    }

    /// Components of a global vector in these axes.
    #[must_use]
    pub fn to_local(&self, v: [f64; 3]) -> [f64; 3] {
        [dot(self.x, v), dot(self.y, v), dot(self.z, v)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The paper's rotation of an element with direction cosines (l, m, n) and angle α, rows x, y, z (eqs. (22) to (27)).
    ///
    /// Print and code differ twice: eq. (22), and (26) with it, prints -m/l where an orthogonal matrix needs -m/λ; and eq. (27) is the
    /// whole rotation for an element along +z, so along -z the signs of its first and third rows change.
    fn paper_rotation(direction_cosines: [f64; 3], alpha_rad: f64) -> [[f64; 3]; 3] {
        let [l, m, n] = direction_cosines;
        let (sin, cos) = alpha_rad.sin_cos();
        let lambda = l.hypot(m);
        // Parallel to z within rounding: the auxiliary axes of eq. (22) have no direction.
        if lambda < 1e-12 {
            let s = n.signum();
            return [[0.0, 0.0, s], [-sin, cos, 0.0], [-s * cos, -s * sin, 0.0]];
        }
        let t1 = [
            [l, m, n],
            [-m / lambda, l / lambda, 0.0],
            [-n * l / lambda, -m * n / lambda, lambda],
        ];
        [
            t1[0],
            [0, 1, 2].map(|i| cos * t1[1][i] + sin * t1[2][i]),
            [0, 1, 2].map(|i| -sin * t1[1][i] + cos * t1[2][i]),
        ]
    }

    fn assert_same(rows: [[f64; 3]; 3], axes: &LocalAxes) {
        for (row, axis) in rows.iter().zip([axes.x, axes.y, axes.z]) {
            for (a, b) in row.iter().zip(axis) {
                assert!((a - b).abs() < 1e-14, "{rows:?} against {axes:?}");
            }
        }
    }

    #[test]
    fn corrected_print_gives_the_same_axes() {
        // In the arm plane (l = 0), alpha = 0 puts local y along -x for an element that rises (m > 0); the stiffness does not
        // see the sign, so the hint here is -x.
        let cosines = [0.0, 0.6, 0.8];
        let (axes, length) = LocalAxes::along([0.0, 1.2, 1.6], [-1.0, 0.0, 0.0]).unwrap();
        assert!((length - 2.0).abs() < 1e-15);
        assert_same(paper_rotation(cosines, 0.0), &axes);
    }

    #[test]
    fn elements_along_plus_and_minus_z_need_alpha_of_ninety_degrees() {
        let quarter = std::f64::consts::FRAC_PI_2;
        for sign in [1.0, -1.0] {
            let (axes, _) = LocalAxes::along([0.0, 0.0, sign], [-1.0, 0.0, 0.0]).unwrap();
            assert_same(paper_rotation([0.0, 0.0, sign], quarter), &axes);
        }
    }

    #[test]
    fn print_as_it_stands_is_not_orthogonal() {
        // -m/l instead of -m/λ: the second row of eq. (22) for l = 0.6, m = 0.48, n = 0.64.
        let (l, m) = (0.6_f64, 0.48_f64);
        let lambda = l.hypot(m);
        let printed_row = [-m / l, l / lambda, 0.0];
        assert!((norm(printed_row) - 1.0).abs() > 0.05);
        for row in paper_rotation([l, m, 0.64], 0.3) {
            assert!((norm(row) - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn no_axes_without_length_or_plane() {
        assert!(LocalAxes::along([0.0; 3], [1.0, 0.0, 0.0]).is_none());
        assert!(LocalAxes::along([0.0, 0.0, 2.0], [0.0, 0.0, 1.0]).is_none());
    }
}
