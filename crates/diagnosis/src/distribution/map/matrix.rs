//! The whole Cartesian stiffness of the end, 6 × 6.

use nalgebra::SMatrix;

use stiffbench_beams::structure::Compliance6;

/// Least pivot of the compliance, scaled to a diagonal of one, at which it still has an inverse: below it rounding decides.
const LEAST_PIVOT: f64 = 1e-12;

/// Numbers of a matrix in a row.
pub(super) const ENTRIES: usize = 36;

/// Which matrix of the end goes with each pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum MatrixKind {
    /// Force and moment per displacement and rotation: rows Fx Fy Fz Mx My Mz, columns ux uy uz rx ry rz.
    Stiffness,
    /// Displacement and rotation per force and moment, its inverse.
    Compliance,
}

impl MatrixKind {
    /// The matrix, SI; not a number where a stiffness has no inverse of the compliance.
    pub(super) fn of(self, compliance: &Compliance6) -> [[f64; 6]; 6] {
        match self {
            Self::Compliance => compliance.0,
            Self::Stiffness => cartesian_stiffness(compliance).unwrap_or([[f64::NAN; 6]; 6]),
        }
    }

    /// Writes the matrix row by row.
    pub(super) fn fill(self, compliance: &Compliance6, entries: &mut [f64]) {
        for (entries, row) in entries.chunks_exact_mut(6).zip(self.of(compliance)) {
            entries.copy_from_slice(&row);
        }
    }
}

/// Stiffness of the end: the inverse of its compliance, symmetric, SI (N/m, N/rad, N, N·m/rad by block).
///
/// `None` where the end cannot move or turn in some direction, because no joint and no member yields there.
#[must_use]
pub fn cartesian_stiffness(compliance: &Compliance6) -> Option<[[f64; 6]; 6]> {
    // Metres and radians are scaled to one before pivots are compared.
    let scale = [0, 1, 2, 3, 4, 5].map(|i| 1.0 / compliance.0[i][i].sqrt());
    if !scale.iter().all(|s| s.is_finite() && *s > 0.0) {
        return None;
    }
    let scaled = SMatrix::<f64, 6, 6>::from_fn(|i, j| {
        0.5 * (compliance.0[i][j] + compliance.0[j][i]) * scale[i] * scale[j]
    });
    let factor = scaled.cholesky()?;
    if !(0..6).all(|i| factor.l_dirty()[(i, i)].powi(2) > LEAST_PIVOT) {
        return None;
    }
    let inverse = factor.inverse();
    Some(std::array::from_fn(|i| {
        std::array::from_fn(|j| 0.5 * (inverse[(i, j)] + inverse[(j, i)]) * (scale[i] * scale[j]))
    }))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An arm of springs c about axes: the compliance is Σ c w wᵀ with w = (axis × lever, axis), its inverse is J⁻ᵀ K J⁻¹.
    fn arm(springs: &[([f64; 3], [f64; 3], f64)]) -> Compliance6 {
        let mut sum = [[0.0; 6]; 6];
        for ([a, b, c], [x, y, z], yielding) in springs {
            let w = [b * z - c * y, c * x - a * z, a * y - b * x, *a, *b, *c];
            for (row, along) in sum.iter_mut().zip(w) {
                for (entry, across) in row.iter_mut().zip(w) {
                    *entry += yielding * along * across;
                }
            }
        }
        Compliance6(sum)
    }

    fn six() -> Vec<([f64; 3], [f64; 3], f64)> {
        vec![
            ([0.0, 1.0, 0.0], [1.2, 0.3, 0.1], 2e-6),
            ([1.0, 0.0, 0.0], [1.1, -0.3, 0.4], 3e-6),
            ([1.0, 0.0, 0.0], [0.6, 0.3, 0.5], 4e-6),
            ([0.0, 0.6, 0.8], [0.3, 0.1, 0.2], 2e-5),
            ([1.0, 0.0, 0.0], [0.1, 0.1, 0.25], 3e-5),
            ([0.0, 0.0, 1.0], [0.1, 0.05, 0.1], 5e-5),
        ]
    }

    #[test]
    fn stiffness_times_compliance_is_one() {
        let compliance = arm(&six());
        let stiffness = cartesian_stiffness(&compliance).unwrap();
        for i in 0..6 {
            for j in 0..6 {
                let sum: f64 = (0..6).map(|k| stiffness[i][k] * compliance.0[k][j]).sum();
                let size = (stiffness[i][i] * compliance.0[j][j]).sqrt();
                let expected = f64::from(u8::from(i == j));
                assert!(
                    (sum - expected).abs() < 1e-10 * size.max(1.0),
                    "{i} {j}: {sum}"
                );
                assert_eq!(stiffness[i][j], stiffness[j][i]);
            }
        }
    }

    #[test]
    fn a_load_per_joint_comes_back() {
        // With F = K u of the displacement that one joint makes, each joint but this one has no moment: K w · w' = δ / c.
        let springs = six();
        let stiffness = cartesian_stiffness(&arm(&springs)).unwrap();
        let lever = |([a, b, c], [x, y, z], _): ([f64; 3], [f64; 3], f64)| {
            [b * z - c * y, c * x - a * z, a * y - b * x, a, b, c]
        };
        for (i, one) in springs.iter().enumerate() {
            for (j, other) in springs.iter().enumerate() {
                let (w, v) = (lever(*one), lever(*other));
                let pairs = (0..36).map(|k| w[k / 6] * stiffness[k / 6][k % 6] * v[k % 6]);
                let found = pairs.sum::<f64>() * (one.2 * other.2).sqrt();
                let expected = f64::from(u8::from(i == j));
                assert!((found - expected).abs() < 1e-9, "{i} {j}: {found}");
            }
        }
    }

    #[test]
    fn five_joints_have_no_stiffness() {
        assert_eq!(cartesian_stiffness(&arm(&six()[..5])), None);
        assert_eq!(cartesian_stiffness(&arm(&[])), None);
        let mut entries = [0.0; ENTRIES];
        MatrixKind::Stiffness.fill(&arm(&six()[..5]), &mut entries);
        assert!(entries.iter().all(|entry| entry.is_nan()));
        MatrixKind::Compliance.fill(&arm(&six()), &mut entries);
        assert_eq!(entries[35], arm(&six()).0[5][5]);
    }
}
