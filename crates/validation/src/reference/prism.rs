//! From the constants of a section to a prism that can be meshed.
//!
//! A robot file gives A, Iy, Iz, J and no shape. The prism is a rectangle or a rectangular tube about the element's axes with exactly
//! the wanted bending and axial stiffness:
//!
//! - the tube of even wall with the wanted A, Iy and Iz, of the material itself, where there is one whose wall is no thinner than
//!   a fortieth of its larger side;
//! - else the solid rectangle with the wanted radii of gyration, whose moduli are multiplied by A over its own area, so that EA, EIy and
//!   EIz are the wanted ones. Below the solid rectangle (144 Iy Iz < A⁴) hardly any shape has the three constants; far above it only foil.
//!
//! Price: the torsion constant and the shear stiffness are those of the prism, and J of the section is not met. Both are in the result.

use std::f64::consts::PI;

use stiffbench_beams::structure::{Section, ShearCoefficients};

/// Thinnest wall of a tube as a share of its larger side: below a fortieth plane walls bend by themselves, and the section no longer
/// keeps its shape as that of a beam does.
const THINNEST_WALL: f64 = 1.0 / 40.0;

/// Sides from which on a rectangle warps as a strip does; nearer to the square it warps less, and soon not at all.
const NARROW: f64 = 4.0;

/// Sections this near to the solid rectangle are one: the wall of the tube would meet in the middle within rounding.
const SOLID_WITHIN: f64 = 1e-9;

/// A rectangular prism or tube, sides along the element's local y and z.
#[derive(
    Debug, Clone, Copy, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema,
)]
#[serde(deny_unknown_fields)]
pub struct Prism {
    /// Side along local y, m.
    pub side_y_m: f64,
    /// Side along local z, m.
    pub side_z_m: f64,
    /// Wall of a tube, m; absent for a solid prism.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub wall_m: Option<f64>,
    /// What the moduli of the section's material are multiplied by.
    pub modulus_scale: f64,
}

impl Prism {
    /// The prism with the A, Iy and Iz of a section.
    #[must_use]
    pub fn of(section: &Section) -> Self {
        tube(section).unwrap_or_else(|| {
            let side = |second_moment: f64| (12.0 * second_moment / section.area_m2).sqrt();
            let (side_y_m, side_z_m) = (side(section.iz_m4), side(section.iy_m4));
            Self {
                side_y_m,
                side_z_m,
                wall_m: None,
                modulus_scale: section.area_m2 / (side_y_m * side_z_m),
            }
        })
    }

    /// Constants that act: those of the shape times the scale of the moduli.
    ///
    /// J of a rectangle by Saint-Venant's series (Timoshenko and Goodier, Theory of Elasticity, 3rd edition, art. 109), of a tube by
    /// Bredt's formula for the middle of the wall and what the wall has as an open strip, which is up to 5 % low (`fixtures/tube-torsion`).
    #[must_use]
    pub fn section(&self) -> Section {
        let (y, z) = (self.side_y_m, self.side_z_m);
        let hollow = |power_y: i32, power_z: i32| {
            let inner = self.wall_m.map_or(0.0, |wall| {
                (y - 2.0 * wall).powi(power_y) * (z - 2.0 * wall).powi(power_z)
            });
            y.powi(power_y) * z.powi(power_z) - inner
        };
        let j = match self.wall_m {
            None => rectangle_torsion(y, z),
            Some(wall) => {
                let (a, b) = (y - wall, z - wall);
                2.0 * wall * (a * b).powi(2) / (a + b) + 2.0 * (a + b) * wall.powi(3) / 3.0
            }
        };
        let scale = self.modulus_scale;
        Section {
            area_m2: scale * hollow(1, 1),
            iy_m4: scale * hollow(1, 3) / 12.0,
            iz_m4: scale * hollow(3, 1) / 12.0,
            j_m4: scale * j,
        }
    }

    /// How many times stiffer in torsion the prism is with its warping held at both ends; 1 if it is not narrow.
    ///
    /// 1/(1 - tanh(κ)/κ), κ = (L/2) √(GJ/EΓ), of a bar whose ends cannot warp (Vlasov, Thin-Walled Elastic Beams, 2nd edition, chapter 2),
    /// with the warping constant Γ = b³h³/144 of a narrow rectangle.
    ///
    /// # Arguments
    /// - `modulus_ratio`: E/G.
    #[must_use]
    pub fn warping_stiffening(&self, length_m: f64, modulus_ratio: f64) -> f64 {
        let (b, h) = (
            self.side_y_m.min(self.side_z_m),
            self.side_y_m.max(self.side_z_m),
        );
        if self.wall_m.is_some() || h < NARROW * b {
            return 1.0;
        }
        let warping_m6 = (b * h).powi(3) / 144.0;
        let kappa =
            0.5 * length_m * (rectangle_torsion(b, h) / (modulus_ratio * warping_m6)).sqrt();
        1.0 / (1.0 - kappa.tanh() / kappa)
    }

    /// Shear coefficients of the shape: 5/6 of a rectangle; of a tube the walls along the shear over the whole, Cowper's value within a few percent.
    #[must_use]
    pub fn shear(&self) -> ShearCoefficients {
        match self.wall_m {
            None => ShearCoefficients {
                along_y: 5.0 / 6.0,
                along_z: 5.0 / 6.0,
            },
            Some(wall) => {
                let (a, b) = (self.side_y_m - wall, self.side_z_m - wall);
                ShearCoefficients {
                    along_y: a / (a + b),
                    along_z: b / (a + b),
                }
            }
        }
    }
}

/// The tube with exactly A, Iy and Iz, if there is one with a wall that can be meshed.
fn tube(section: &Section) -> Option<Prism> {
    let Section {
        area_m2: area,
        iy_m4: iy,
        iz_m4: iz,
        ..
    } = *section;
    // The wall of the square tube is thickest at a quarter of the side of the solid square.
    let (mut thin, mut thick) = (0.0, area.sqrt() / 2.0);
    if 144.0 * iy * iz <= area.powi(4) * (1.0 + SOLID_WITHIN) {
        return None;
    }
    for _ in 0..200 {
        let wall = 0.5 * (thin + thick);
        match sides(area, wall, iy / iz) {
            Some([y, z]) if y.min(z) > 2.0 * wall && second_moment(y, z, wall) > iy => thin = wall,
            _ => thick = wall,
        }
    }
    let [side_y_m, side_z_m] = sides(area, thin, iy / iz)?;
    let fits = (second_moment(side_y_m, side_z_m, thin) / iy - 1.0).abs() < 1e-9;
    (fits && thin >= THINNEST_WALL * side_y_m.max(side_z_m)).then_some(Prism {
        side_y_m,
        side_z_m,
        wall_m: Some(thin),
        modulus_scale: 1.0,
    })
}

/// Sides along y and z of the tube with this area and wall, and this Iy over Iz.
fn sides(area: f64, wall: f64, ratio: f64) -> Option<[f64; 2]> {
    // Area = 2 t (y + z) - 4 t².
    let sum = area / (2.0 * wall) + 2.0 * wall;
    if !(sum.is_finite() && sum > 4.0 * wall) {
        return None;
    }
    let (mut low, mut high) = (2.0 * wall, sum - 2.0 * wall);
    for _ in 0..200 {
        let z = 0.5 * (low + high);
        let y = sum - z;
        if second_moment(y, z, wall) < ratio * second_moment(z, y, wall) {
            low = z;
        } else {
            high = z;
        }
    }
    Some([sum - low, low])
}

/// Second moment of a tube with side `across` at right angles to the bending and `along` in its plane, m⁴.
fn second_moment(across: f64, along: f64, wall: f64) -> f64 {
    let inner = (across - 2.0 * wall) * (along - 2.0 * wall).powi(3);
    (across * along.powi(3) - inner) / 12.0
}

/// Saint-Venant's torsion constant of a solid rectangle, m⁴.
fn rectangle_torsion(side: f64, other: f64) -> f64 {
    let (a, b) = (side.min(other), side.max(other));
    // The n-th term falls as n⁻⁵; eleven odd ones are exact to 1e-7.
    let series: f64 = (0..11)
        .map(|n| f64::from(2 * n + 1))
        .map(|n| (n * PI * b / (2.0 * a)).tanh() / n.powi(5))
        .sum();
    b * a.powi(3) / 3.0 * (1.0 - 192.0 / PI.powi(5) * (a / b) * series)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn section(area_m2: f64, iy_m4: f64, iz_m4: f64) -> Section {
        Section {
            area_m2,
            iy_m4,
            iz_m4,
            j_m4: 1e-6,
        }
    }

    fn near(found: f64, expected: f64, tolerance: f64) {
        assert!(
            (found / expected - 1.0).abs() < tolerance,
            "{found} is not {expected}"
        );
    }

    /// The constants that bend and stretch come back, whatever the prism.
    fn acts_as(section: &Section, prism: &Prism) {
        let found = prism.section();
        near(found.area_m2, section.area_m2, 1e-9);
        near(found.iy_m4, section.iy_m4, 1e-8);
        near(found.iz_m4, section.iz_m4, 1e-8);
    }

    #[test]
    fn a_rectangle_is_found_again_with_its_own_material() {
        // 20 mm along y, 60 mm along z.
        let wanted = section(
            1.2e-3,
            0.02 * 0.06_f64.powi(3) / 12.0,
            0.06 * 0.02_f64.powi(3) / 12.0,
        );
        let prism = Prism::of(&wanted);
        near(prism.side_y_m, 0.02, 1e-9);
        near(prism.side_z_m, 0.06, 1e-9);
        near(prism.modulus_scale, 1.0, 1e-9);
        assert_eq!(prism.wall_m, None);
        acts_as(&wanted, &prism);
        // Timoshenko and Goodier, art. 109: J = 0.263 b a³ for sides 1 : 3.
        near(prism.section().j_m4, 0.263 * 0.06 * 0.02_f64.powi(3), 2e-3);
    }

    #[test]
    fn only_strips_that_are_short_are_stiffened_by_held_warping() {
        let strip = |side_y_m| Prism {
            side_y_m,
            side_z_m: 0.1,
            wall_m: None,
            modulus_scale: 1.0,
        };
        // κ = (L/2) √(48 G/E)/h for a thin strip: with E/G = 8/3 and L = 4h, κ = 2 √18 and the factor 1/(1 - 1/κ).
        let kappa = 2.0 * 18.0_f64.sqrt();
        near(
            strip(1e-5).warping_stiffening(0.4, 8.0 / 3.0),
            1.0 / (1.0 - 1.0 / kappa),
            1e-3,
        );
        near(strip(1e-5).warping_stiffening(1e4, 8.0 / 3.0), 1.0, 1e-4);
        assert_eq!(strip(0.05).warping_stiffening(0.1, 8.0 / 3.0), 1.0);
    }

    #[test]
    fn a_tube_is_found_again() {
        // Outside 60 by 40 mm, wall 4 mm.
        let (y, z, wall) = (0.060, 0.040, 0.004);
        let wanted = section(
            y * z - (y - 2.0 * wall) * (z - 2.0 * wall),
            second_moment(y, z, wall),
            second_moment(z, y, wall),
        );
        let prism = Prism::of(&wanted);
        near(prism.side_y_m, y, 1e-7);
        near(prism.side_z_m, z, 1e-7);
        near(prism.wall_m.unwrap(), wall, 1e-7);
        acts_as(&wanted, &prism);
    }

    #[test]
    fn the_torsion_constant_of_a_tube_is_at_most_5_percent_low() {
        let rows = stiffbench_test_files::text("fixtures/tube-torsion/torsion.csv");
        for row in rows.lines().skip(1) {
            let numbers: Vec<f64> = row.split(',').map(|word| word.parse().unwrap()).collect();
            let [side_y_m, side_z_m, wall, expected] = numbers[..] else {
                panic!("{row}");
            };
            let tube = Prism {
                side_y_m,
                side_z_m,
                wall_m: Some(wall),
                modulus_scale: 1.0,
            };
            let ratio = tube.section().j_m4 / expected;
            assert!((0.95..1.0).contains(&ratio), "{row}: {ratio}");
        }
    }

    #[test]
    fn what_no_tube_has_is_a_rectangle_of_other_moduli() {
        // More area than any shape with these second moments has, and so little that only foil would do.
        for wanted in [
            section(8e-3, 1.07e-6, 5.67e-8),
            section(1.5e-4, 2.17e-6, 4e-9),
        ] {
            let prism = Prism::of(&wanted);
            assert_eq!(prism.wall_m, None);
            assert!((prism.modulus_scale - 1.0).abs() > 0.5);
            acts_as(&wanted, &prism);
        }
    }
}
