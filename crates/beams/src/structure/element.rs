//! Two-node beams through their natural strains.
//!
//! A beam with twelve end freedoms has six ways to deform. With u, v, w the displacements and θ the rotations in local axes and L
//! the length, those used here are
//!
//! ```text
//!   0 elongation        e   = u2 - u1
//!   1 twist             φ   = θx2 - θx1
//!   2 curvature, xz     κ_y = θy1 - θy2
//!   3 shear mode, xz    γ_y = θy1 + θy2 + 2 (w2 - w1)/L
//!   4 curvature, xy     κ_z = θz1 - θz2
//!   5 shear mode, xy    γ_z = θz1 + θz2 - 2 (v2 - v1)/L
//! ```
//!
//! and the strain energy is ½ Σ d_m s_m² with the stiffnesses of [`NaturalStiffness`]: no coupling, so each is its own answer.

use super::rotation::LocalAxes;
use super::section::{Material, Property, Section, ShearCoefficients};

/// Number of natural strains of a beam.
pub const STRAINS: usize = 6;

/// Where an element end or a load hangs: on a node, behind zero or more hinges.
///
/// Its motion is the node's plus those of the hinges passed on the way.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Attachment {
    /// Index of the node.
    pub node: usize,
    /// Indices of the hinges between the node and what hangs here.
    pub hinges: Vec<usize>,
}

impl From<usize> for Attachment {
    fn from(node: usize) -> Self {
        Self {
            node,
            hinges: Vec::new(),
        }
    }
}

/// A straight two-node beam.
#[derive(Debug, Clone, PartialEq)]
pub struct Element {
    /// Where its first and second end hang.
    pub ends: [Attachment; 2],
    /// Direction of local y, global; its part along the element does not matter.
    pub toward_y: [f64; 3],
    /// Section constants.
    pub section: Section,
    /// Elastic constants.
    pub material: Material,
    /// Shear coefficients of the Timoshenko beam; `None` is Euler-Bernoulli (the paper).
    pub shear: Option<ShearCoefficients>,
}

impl Element {
    /// The first constant that is negative or not finite, with its name.
    pub(super) fn impossible_constant(&self) -> Option<(&'static str, f64)> {
        let Section {
            area_m2,
            iy_m4,
            iz_m4,
            j_m4,
        } = self.section;
        let Material {
            youngs_modulus_pa,
            shear_modulus_pa,
        } = self.material;
        // Euler-Bernoulli beams have no shear coefficient; any possible number passes for them.
        let shear = self.shear.map_or([1.0; 2], |k| [k.along_y, k.along_z]);
        [
            ("the area", area_m2),
            ("the second moment Iy", iy_m4),
            ("the second moment Iz", iz_m4),
            ("the torsion constant", j_m4),
            ("Young's modulus", youngs_modulus_pa),
            ("the shear modulus", shear_modulus_pa),
            ("the shear coefficient along y", shear[0]),
            ("the shear coefficient along z", shear[1]),
        ]
        .into_iter()
        .find(|(_, value)| !(value.is_finite() && *value >= 0.0))
    }
}

/// Stiffness of each natural strain, and how it depends on the section.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NaturalStiffness {
    /// d_m: N/m for the elongation, N·m/rad for the others.
    pub stiffness: [f64; STRAINS],
    /// ∂ ln d_m / ∂ ln Iy for the shear mode in xz, and ∂ ln d_m / ∂ ln Iz for that in xy; 1 for Euler-Bernoulli. What is missing
    /// to 1 is ∂ ln d_m / ∂ ln A, through the shear area.
    pub bending_share: [f64; 2],
}

impl NaturalStiffness {
    /// Of a beam of the given length.
    ///
    /// ```text
    ///   EA/L,  GJ/L,  E Iy/L,  3 E Iy/(L (1 + Φ_y)),  E Iz/L,  3 E Iz/(L (1 + Φ_z)),    Φ = 12 E I/(G k A L²)
    /// ```
    ///
    /// # Source
    /// Przemieniecki, Theory of Matrix Structural Analysis (1968), section 5.6, the 12 × 12 matrix with shear; natural modes as in
    /// Argyris, Recent Advances in Matrix Methods of Structural Analysis (1964). This is the paper's eq. (18), which our
    /// transcription lacks, in diagonal form.
    #[must_use]
    pub fn of(
        section: &Section,
        material: &Material,
        shear: Option<ShearCoefficients>,
        length_m: f64,
    ) -> Self {
        let e_over_l = material.youngs_modulus_pa / length_m;
        let flexibility_ratio = |i_m4: f64, coefficient: f64| {
            // An element that carries nothing has neither bending nor shear stiffness to compare.
            if i_m4 == 0.0 {
                return 0.0;
            }
            12.0 * material.youngs_modulus_pa * i_m4
                / (material.shear_modulus_pa * coefficient * section.area_m2 * length_m * length_m)
        };
        let [phi_y, phi_z] = match shear {
            None => [0.0; 2],
            Some(k) => [
                flexibility_ratio(section.iy_m4, k.along_z),
                flexibility_ratio(section.iz_m4, k.along_y),
            ],
        };
        let bending_share = [1.0 / (1.0 + phi_y), 1.0 / (1.0 + phi_z)];
        let bending_y = e_over_l * section.iy_m4;
        let bending_z = e_over_l * section.iz_m4;
        Self {
            stiffness: [
                e_over_l * section.area_m2,
                material.shear_modulus_pa * section.j_m4 / length_m,
                bending_y,
                3.0 * bending_y * bending_share[0],
                bending_z,
                3.0 * bending_z * bending_share[1],
            ],
            bending_share,
        }
    }

    /// Bilinear strain energy of two strain states, split by the property it would grow with: Σ_m ∂d_m/∂ln p · a_m b_m.
    ///
    /// The four parts add up to Σ_m d_m a_m b_m.
    #[must_use]
    pub fn energy_by_property(&self, a: &[f64; STRAINS], b: &[f64; STRAINS]) -> [f64; 4] {
        let w: [f64; STRAINS] = std::array::from_fn(|m| self.stiffness[m] * a[m] * b[m]);
        let [share_y, share_z] = self.bending_share;
        let mut parts = [0.0; 4];
        parts[Property::A.index()] = w[0] + (1.0 - share_y) * w[3] + (1.0 - share_z) * w[5];
        parts[Property::Iy.index()] = w[2] + share_y * w[3];
        parts[Property::Iz.index()] = w[4] + share_z * w[5];
        parts[Property::J.index()] = w[1];
        parts
    }
}

/// Natural strains of an element from the displacements and rotations of its ends, global.
///
/// Freedoms are ux uy uz rx ry rz of the first end, then of the second.
pub(super) fn natural_strains(axes: &LocalAxes, length_m: f64, ends: &[f64; 12]) -> [f64; STRAINS] {
    let [x1, y1, z1] = axes.to_local([ends[3], ends[4], ends[5]]);
    let [x2, y2, z2] = axes.to_local([ends[9], ends[10], ends[11]]);
    let [u, v, w] = axes.to_local([ends[6] - ends[0], ends[7] - ends[1], ends[8] - ends[2]]);
    let chord = 2.0 / length_m;
    [
        u,
        x2 - x1,
        y1 - y2,
        y1 + y2 + chord * w,
        z1 - z2,
        z1 + z2 - chord * v,
    ]
}

/// Stiffness matrix of an element in global axes: the paper's eq. (29) with (18) in it.
///
/// 12 × 12, freedoms as in [`natural_strains`]. Only four of its 3 × 3 blocks differ: with T the displacements and R the rotations
/// of an end, TT is ± one block, TR is ± another, and RR is the sum or difference of the shear modes and the rest.
pub(super) fn global_matrix(
    axes: &LocalAxes,
    length_m: f64,
    natural: &NaturalStiffness,
) -> [[f64; 12]; 12] {
    let LocalAxes { x, y, z } = axes;
    let [stretch, twist, curve_y, shear_y, curve_z, shear_z] = natural.stiffness;
    let chord = 2.0 / length_m;
    let mut matrix = [[0.0; 12]; 12];
    for i in 0..3 {
        for j in 0..3 {
            let (xx, yy, zz) = (x[i] * x[j], y[i] * y[j], z[i] * z[j]);
            let tt = stretch * xx + chord * chord * (shear_y * zz + shear_z * yy);
            let tr = chord * (shear_z * y[i] * z[j] - shear_y * z[i] * y[j]);
            let shear = shear_y * yy + shear_z * zz;
            let bend = twist * xx + curve_y * yy + curve_z * zz;
            for (end, sign) in [(0, 1.0), (6, -1.0)] {
                matrix[end + i][end + j] = tt;
                matrix[end + i][6 - end + j] = -tt;
                matrix[end + 3 + i][end + 3 + j] = shear + bend;
                matrix[end + 3 + i][9 - end + j] = shear - bend;
                for other in [3, 9] {
                    matrix[end + i][other + j] = sign * tr;
                    matrix[other + j][end + i] = sign * tr;
                }
            }
        }
    }
    matrix
}

#[cfg(test)]
mod tests {
    use super::*;

    const MATERIAL: Material = Material {
        youngs_modulus_pa: 210e9,
        shear_modulus_pa: 81e9,
    };
    const SECTION: Section = Section {
        area_m2: 2e-3,
        iy_m4: 3e-6,
        iz_m4: 5e-7,
        j_m4: 7e-7,
    };

    /// The textbook's matrix in local axes (Przemieniecki 1968, eq. (5.116)), written out.
    #[rustfmt::skip]
    fn textbook_matrix(l: f64, phi_y: f64, phi_z: f64) -> [[f64; 12]; 12] {
        let (e, g) = (MATERIAL.youngs_modulus_pa, MATERIAL.shear_modulus_pa);
        let a = e * SECTION.area_m2 / l;
        let t = g * SECTION.j_m4 / l;
        let z = e * SECTION.iz_m4 / (1.0 + phi_z);
        let y = e * SECTION.iy_m4 / (1.0 + phi_y);
        let (z3, z2, z4, z1) = (12.0 * z / l.powi(3), 6.0 * z / l.powi(2), (4.0 + phi_z) * z / l, (2.0 - phi_z) * z / l);
        let (y3, y2, y4, y1) = (12.0 * y / l.powi(3), 6.0 * y / l.powi(2), (4.0 + phi_y) * y / l, (2.0 - phi_y) * y / l);
        let o = 0.0;
        [
            [  a,   o,   o,  o,   o,   o, -a,   o,   o,  o,   o,   o],
            [  o,  z3,   o,  o,   o,  z2,  o, -z3,   o,  o,   o,  z2],
            [  o,   o,  y3,  o, -y2,   o,  o,   o, -y3,  o, -y2,   o],
            [  o,   o,   o,  t,   o,   o,  o,   o,   o, -t,   o,   o],
            [  o,   o, -y2,  o,  y4,   o,  o,   o,  y2,  o,  y1,   o],
            [  o,  z2,   o,  o,   o,  z4,  o, -z2,   o,  o,   o,  z1],
            [ -a,   o,   o,  o,   o,   o,  a,   o,   o,  o,   o,   o],
            [  o, -z3,   o,  o,   o, -z2,  o,  z3,   o,  o,   o, -z2],
            [  o,   o, -y3,  o,  y2,   o,  o,   o,  y3,  o,  y2,   o],
            [  o,   o,   o, -t,   o,   o,  o,   o,   o,  t,   o,   o],
            [  o,   o, -y2,  o,  y1,   o,  o,   o,  y2,  o,  y4,   o],
            [  o,  z2,   o,  o,   o,  z1,  o, -z2,   o,  o,   o,  z4],
        ]
    }

    #[test]
    fn natural_strains_give_the_textbook_matrix() {
        let length = 0.8;
        let shear = ShearCoefficients {
            along_y: 0.5,
            along_z: 5.0 / 6.0,
        };
        for shear in [None, Some(shear)] {
            let natural = NaturalStiffness::of(&SECTION, &MATERIAL, shear, length);
            let phi = |share: f64| 1.0 / share - 1.0;
            let expected = textbook_matrix(
                length,
                phi(natural.bending_share[0]),
                phi(natural.bending_share[1]),
            );
            // Local axes equal to the global ones: element along x, local y along y.
            let (axes, _) = LocalAxes::along([length, 0.0, 0.0], [0.0, 1.0, 0.0]).unwrap();
            let matrix = global_matrix(&axes, length, &natural);
            for i in 0..12 {
                for j in 0..12 {
                    let scale = (expected[i][i] * expected[j][j]).sqrt();
                    let difference = (matrix[i][j] - expected[i][j]).abs();
                    assert!(
                        difference < 1e-14 * scale,
                        "({i}, {j}): {} {}",
                        matrix[i][j],
                        expected[i][j]
                    );
                }
            }
        }
    }

    #[test]
    fn matrix_and_strains_give_the_same_energy() {
        let (axes, length) = LocalAxes::along([0.3, -0.5, 0.4], [0.2, 1.0, 0.1]).unwrap();
        let natural = NaturalStiffness::of(&SECTION, &MATERIAL, None, length);
        let matrix = global_matrix(&axes, length, &natural);
        let ends: [f64; 12] = std::array::from_fn(|i| 1e-3 * ((7 * i % 5) as f64 - 1.7));
        let strains = natural_strains(&axes, length, &ends);
        let by_strains: f64 = (0..STRAINS)
            .map(|m| natural.stiffness[m] * strains[m] * strains[m])
            .sum();
        let by_matrix: f64 = (0..12)
            .flat_map(|i| (0..12).map(move |j| (i, j)))
            .map(|(i, j)| ends[i] * matrix[i][j] * ends[j])
            .sum();
        assert!((by_matrix / by_strains - 1.0).abs() < 1e-12);
    }

    #[test]
    fn timoshenko_shear_is_that_of_the_formula() {
        // Φ_y = 12 E Iy/(G k A L²), worked by hand: 12·210e9·3e-6/(81e9·0.9·2e-3·0.64).
        let shear = ShearCoefficients {
            along_y: 0.9,
            along_z: 0.9,
        };
        let natural = NaturalStiffness::of(&SECTION, &MATERIAL, Some(shear), 0.8);
        let phi = 12.0 * 210e9 * 3e-6 / (81e9 * 0.9 * 2e-3 * 0.64);
        assert!((natural.bending_share[0] * (1.0 + phi) - 1.0).abs() < 1e-14);
    }

    #[test]
    fn energy_by_property_adds_up() {
        let shear = ShearCoefficients {
            along_y: 0.3,
            along_z: 0.4,
        };
        let natural = NaturalStiffness::of(&SECTION, &MATERIAL, Some(shear), 0.3);
        let (a, b) = (
            [1e-4, 2e-4, -3e-4, 4e-4, 5e-4, -6e-4],
            [2e-4, -1e-4, 3e-4, 1e-4, 2e-4, 4e-4],
        );
        let parts: f64 = natural.energy_by_property(&a, &b).iter().sum();
        let whole: f64 = (0..STRAINS)
            .map(|m| natural.stiffness[m] * a[m] * b[m])
            .sum();
        assert!((parts / whole - 1.0).abs() < 1e-13);
    }
}
