//! The compliance of the end of a structure, and its derivatives.

/// End compliance: displacement and rotation per force and moment at one point.
///
/// 6 × 6, rows ux uy uz rx ry rz, columns Fx Fy Fz Mx My Mz; m/N, rad/N, m/(N·m) and rad/(N·m) by block; symmetric by
/// reciprocity.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Compliance6(pub [[f64; 6]; 6]);

impl Compliance6 {
    /// Names of the rows.
    pub const DISPLACEMENTS: [&'static str; 6] = ["ux", "uy", "uz", "rx", "ry", "rz"];
    /// Names of the columns.
    pub const LOADS: [&'static str; 6] = ["Fx", "Fy", "Fz", "Mx", "My", "Mz"];

    /// Displacement along axis `i` per force along axis `i`, m/N.
    #[must_use]
    pub fn direct(&self, i: usize) -> f64 {
        self.0[i][i]
    }

    /// Displacement per force, 3 × 3, m/N.
    #[must_use]
    pub fn translation(&self) -> [[f64; 3]; 3] {
        std::array::from_fn(|i| std::array::from_fn(|j| self.0[i][j]))
    }

    /// Displacement along a unit vector per force along it, m/N.
    #[must_use]
    pub fn along(&self, unit: [f64; 3]) -> f64 {
        let terms = (0..9).map(|k| unit[k / 3] * self.0[k / 3][k % 3] * unit[k % 3]);
        terms.sum()
    }

    /// Displacement and rotation under a force and moment: ux, uy, uz, rx, ry, rz per Fx, Fy, Fz, Mx, My, Mz.
    #[must_use]
    pub fn times(&self, load: [f64; 6]) -> [f64; 6] {
        self.0
            .map(|row| row.iter().zip(load).map(|(c, f)| c * f).sum())
    }

    /// Adds an end that rocks with its supports: Σ c w wᵀ for each axis.
    ///
    /// # Arguments
    /// - `rad_per_nm`: compliance about x, y, z.
    /// - `levers`: w, the motion of the end per rocking about each.
    pub(crate) fn add_rocking(&mut self, rad_per_nm: [f64; 3], levers: &[[f64; 6]; 3]) {
        for (c, &lever) in rad_per_nm.into_iter().zip(levers) {
            for (row, along) in self.0.iter_mut().zip(lever) {
                for (entry, across) in row.iter_mut().zip(lever) {
                    *entry += c * along * across;
                }
            }
        }
    }

    /// Largest difference to `other`, each entry relative to the root of the product of its two diagonal entries in `other`.
    ///
    /// This is the measure in which solvers are compared: entries that a symmetry makes zero do not count as 100 % wrong. NaN if an
    /// entry is.
    #[must_use]
    pub fn relative_difference(&self, other: &Self) -> f64 {
        let mut largest = 0.0_f64;
        for i in 0..6 {
            for j in 0..6 {
                let difference = (self.0[i][j] - other.0[i][j]).abs();
                if difference == 0.0 {
                    continue;
                }
                let relative = difference / (other.0[i][i] * other.0[j][j]).sqrt();
                // `max` would pass over an entry that is no number.
                if relative.is_nan() {
                    return f64::NAN;
                }
                largest = largest.max(relative);
            }
        }
        largest
    }
}

/// Derivatives of one entry of the end compliance to the logarithms of the section constants of one element.
///
/// Order A, Iy, Iz, J; unit of the entry. All of a structure without compliant joints add up to minus the entry.
pub type ComplianceGradient = [f64; 4];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn difference_is_relative_to_the_diagonal() {
        let mut a = Compliance6(std::array::from_fn(|i| {
            std::array::from_fn(|j| if i == j { 4.0 } else { 0.0 })
        }));
        let b = a;
        assert_eq!(a.relative_difference(&b), 0.0);
        a.0[1][2] = 1.0;
        assert_eq!(a.relative_difference(&b), 0.25);
        a.0[5][5] = f64::NAN;
        assert!(a.relative_difference(&b).is_nan());
        assert_eq!(
            Compliance6([[0.0; 6]; 6]).relative_difference(&Compliance6([[0.0; 6]; 6])),
            0.0
        );
    }
}
