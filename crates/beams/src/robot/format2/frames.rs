//! Turns of axes, exact for right angles.

/// 3 × 3; column j is axis j of what is turned.
pub(super) type Rotation = [[f64; 3]; 3];

/// No turn.
pub(super) const IDENTITY: Rotation = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Where the axes that a file uses for a body stand in the axes of the body in the model.
#[derive(Debug, Clone, Copy)]
pub(super) struct FileFrame {
    /// The turn.
    pub(super) turn: Rotation,
    /// The origin, m.
    pub(super) origin_m: [f64; 3],
}

impl FileFrame {
    /// The axes of the model.
    pub(super) const SAME: Self = Self {
        turn: IDENTITY,
        origin_m: [0.0; 3],
    };

    /// A direction in the axes of the model.
    pub(super) fn direction(&self, v: [f64; 3]) -> [f64; 3] {
        apply(&self.turn, v)
    }

    /// A point in the axes of the model, m.
    pub(super) fn point(&self, at_m: [f64; 3]) -> [f64; 3] {
        let at = apply(&self.turn, at_m);
        std::array::from_fn(|i| self.origin_m[i] + at[i])
    }
}

/// Sine and cosine of an angle in degrees; exact at multiples of 90.
fn sin_cos_deg(angle_deg: f64) -> (f64, f64) {
    let quarters = (angle_deg / 90.0).round();
    let (sin, cos) = (angle_deg - 90.0 * quarters).to_radians().sin_cos();
    match quarters.rem_euclid(4.0) as u8 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// A turn about axis 0, 1 or 2.
pub(super) fn about(axis: usize, angle_deg: f64) -> Rotation {
    let (sin, cos) = sin_cos_deg(angle_deg);
    let (next, last) = ((axis + 1) % 3, (axis + 2) % 3);
    let mut turn = IDENTITY;
    turn[next][next] = cos;
    turn[next][last] = -sin;
    turn[last][next] = sin;
    turn[last][last] = cos;
    turn
}

/// Roll, pitch and yaw: about x, then y, then z of the axes that stay.
pub(super) fn roll_pitch_yaw([roll, pitch, yaw]: [f64; 3]) -> Rotation {
    product(&about(2, yaw), &product(&about(1, pitch), &about(0, roll)))
}

/// a b.
pub(super) fn product(a: &Rotation, b: &Rotation) -> Rotation {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

/// a v.
pub(super) fn apply(a: &Rotation, v: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| (0..3).map(|k| a[i][k] * v[k]).sum())
}

/// The columns.
pub(super) fn columns(a: &Rotation) -> [[f64; 3]; 3] {
    std::array::from_fn(|j| std::array::from_fn(|i| a[i][j]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn right_angles_are_exact_and_others_are_turns() {
        assert_eq!(apply(&about(0, 90.0), [0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
        assert_eq!(apply(&about(2, -450.0), [0.0, 1.0, 0.0]), [1.0, 0.0, 0.0]);
        assert_eq!(apply(&about(1, 180.0), [1.0, 0.0, 0.0]), [-1.0, 0.0, 0.0]);
        let turn = roll_pitch_yaw([17.0, -48.0, 205.0]);
        let square = product(&turn, &columns(&turn));
        for i in 0..3 {
            for j in 0..3 {
                assert!((square[i][j] - IDENTITY[i][j]).abs() < 1e-15);
            }
        }
    }

    /// Roll is applied first, about axes that stay (URDF, `rpy`).
    #[test]
    fn roll_pitch_yaw_in_their_order() {
        let turn = roll_pitch_yaw([90.0, 0.0, 90.0]);
        assert_eq!(apply(&turn, [0.0, 1.0, 0.0]), [0.0, 0.0, 1.0]);
        assert_eq!(apply(&turn, [0.0, 0.0, 1.0]), [1.0, 0.0, 0.0]);
    }
}
