//! Section constants and materials.

/// Constants of a cross-section, in the element's local axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Section {
    /// Area A, m².
    pub area_m2: f64,
    /// Second moment I_y, m⁴: resists bending in the local xz plane (rotation about local y).
    pub iy_m4: f64,
    /// Second moment I_z, m⁴: resists bending in the local xy plane (rotation about local z).
    pub iz_m4: f64,
    /// Torsion constant J, m⁴.
    pub j_m4: f64,
}

impl Section {
    /// A solid circular section of the given diameter.
    ///
    /// # Source
    /// Young, Budynas and Sadegh, Roark's Formulas for Stress and Strain, 8th edition, table A.1 case 15 and table 10.7 case 1.
    #[must_use]
    pub fn solid_circle(diameter_m: f64) -> Self {
        let i = std::f64::consts::PI * diameter_m.powi(4) / 64.0;
        Self {
            area_m2: std::f64::consts::FRAC_PI_4 * diameter_m * diameter_m,
            iy_m4: i,
            iz_m4: i,
            j_m4: 2.0 * i,
        }
    }

    /// The four constants in the order of [`Property::ALL`].
    #[must_use]
    pub fn constants(&self) -> [f64; 4] {
        [self.area_m2, self.iy_m4, self.iz_m4, self.j_m4]
    }

    /// This section with each constant multiplied by its fitting factor (paper eq. (17)).
    #[must_use]
    pub fn scaled(&self, factors: [f64; 4]) -> Self {
        Self {
            area_m2: self.area_m2 * factors[0],
            iy_m4: self.iy_m4 * factors[1],
            iz_m4: self.iz_m4 * factors[2],
            j_m4: self.j_m4 * factors[3],
        }
    }
}

/// One of the four section constants that a fitting factor multiplies.
#[derive(
    Debug,
    Clone,
    Copy,
    PartialEq,
    Eq,
    PartialOrd,
    Ord,
    Hash,
    serde::Serialize,
    serde::Deserialize,
    schemars::JsonSchema,
)]
pub enum Property {
    /// Area.
    A,
    /// Second moment for bending in the local xz plane.
    Iy,
    /// Second moment for bending in the local xy plane.
    Iz,
    /// Torsion constant.
    J,
}

impl Property {
    /// All four, in the paper's order (eq. (15)).
    pub const ALL: [Self; 4] = [Self::A, Self::Iy, Self::Iz, Self::J];

    /// Place in arrays of four.
    #[must_use]
    pub fn index(self) -> usize {
        self as usize
    }

    /// Name as in files: `A`, `Iy`, `Iz`, `J`.
    #[must_use]
    pub fn name(self) -> &'static str {
        ["A", "Iy", "Iz", "J"][self.index()]
    }
}

/// Elastic constants of an isotropic material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Material {
    /// Young's modulus E, Pa.
    pub youngs_modulus_pa: f64,
    /// Shear modulus G, Pa.
    pub shear_modulus_pa: f64,
}

/// Timoshenko's shear coefficients: shear area divided by area.
///
/// 5/6 for a rectangle, 9/10 for a circle (Timoshenko 1921; Cowper 1966 gives values that depend on Poisson's ratio).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShearCoefficients {
    /// For shear along local y, which goes with bending resisted by I_z.
    pub along_y: f64,
    /// For shear along local z, which goes with bending resisted by I_y.
    pub along_z: f64,
}
