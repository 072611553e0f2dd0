//! Elastic constants of the elements, and the stiffness of their natural strains in many poses.

use pulp::Simd;

use crate::structure::element::Element;
use stiffbench_numeric::lanes::{Lane, Number, multiply_add};

/// Section and material of an element, multiplied, and the group it belongs to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NominalElement {
    pub(super) group: usize,
    /// Whether every constant is finite and not negative.
    possible: bool,
    /// EA (N), E Iy, E Iz, GJ (N·m²), in the order of the properties.
    rigidity: [f64; 4],
    /// 12/(G k A) for shear along local z and along local y, 1/N; zero for Euler-Bernoulli.
    shear_flexibility: [f64; 2],
}

/// The same after the multipliers of a group.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Rigidity {
    pub(super) group: usize,
    /// EA (N), E Iy, E Iz, GJ (N·m²).
    constants: [f64; 4],
    /// Φ L² of bending in xz and in xy, m²; zero for Euler-Bernoulli.
    flexibility_ratio_m2: [f64; 2],
}

impl NominalElement {
    pub(super) fn of(element: &Element, group: usize) -> Self {
        let (section, material) = (&element.section, &element.material);
        let (e, g) = (material.youngs_modulus_pa, material.shear_modulus_pa);
        let flexibility = |coefficient: f64| 12.0 / (g * coefficient * section.area_m2);
        Self {
            group,
            possible: element.impossible_constant().is_none(),
            rigidity: [
                e * section.area_m2,
                e * section.iy_m4,
                e * section.iz_m4,
                g * section.j_m4,
            ],
            shear_flexibility: element.shear.map_or([0.0; 2], |k| {
                [flexibility(k.along_z), flexibility(k.along_y)]
            }),
        }
    }

    /// With the section constants A, Iy, Iz, J multiplied; `None` if one becomes negative or not finite.
    pub(super) fn scaled(&self, multipliers: &[f64; 4]) -> Option<Rigidity> {
        let constants: [f64; 4] = std::array::from_fn(|p| self.rigidity[p] * multipliers[p]);
        let bending = [constants[1], constants[2]];
        let flexibility_ratio_m2: [f64; 2] = std::array::from_fn(|plane| {
            // A beam that carries nothing has no bending to compare with its shear.
            if bending[plane] == 0.0 || self.shear_flexibility[plane] == 0.0 {
                0.0
            } else {
                bending[plane] * self.shear_flexibility[plane] / multipliers[0]
            }
        });
        let sound = constants
            .iter()
            .chain(&flexibility_ratio_m2)
            .all(|value| value.is_finite() && *value >= 0.0);
        (self.possible && sound).then_some(Rigidity {
            group: self.group,
            constants,
            flexibility_ratio_m2,
        })
    }
}

/// Stiffness of a curvature and its shear mode, and the share of the latter that grows with the second moment; see
/// [`NaturalStiffness`](crate::structure::NaturalStiffness).
#[derive(Debug, Clone, Copy)]
pub(super) struct Bending<S: Simd> {
    pub(super) curvature: Lane<S>,
    pub(super) shear_mode: Lane<S>,
    pub(super) share: Lane<S>,
}

impl Rigidity {
    /// EA/L, N/m.
    #[inline(always)]
    pub(super) fn stretch<S: Simd>(&self, inverse_length: Lane<S>) -> Lane<S> {
        inverse_length.of(self.constants[0]) * inverse_length
    }

    /// GJ/L, N·m/rad.
    #[inline(always)]
    pub(super) fn twist<S: Simd>(&self, inverse_length: Lane<S>) -> Lane<S> {
        inverse_length.of(self.constants[3]) * inverse_length
    }

    /// Bending in the local xz plane (`plane` 0, I_y) or xy plane (1, I_z), N·m/rad.
    #[inline(always)]
    pub(super) fn bending<S: Simd>(&self, plane: usize, inverse_length: Lane<S>) -> Bending<S> {
        let curvature = inverse_length.of(self.constants[1 + plane]) * inverse_length;
        let ratio = self.flexibility_ratio_m2[plane];
        let share = if ratio == 0.0 {
            inverse_length.of(1.0)
        } else {
            let squared = inverse_length * inverse_length;
            multiply_add(inverse_length.of(ratio), squared, inverse_length.of(1.0)).inverse()
        };
        Bending {
            curvature,
            shear_mode: curvature.of(3.0) * curvature * share,
            share,
        }
    }
}

impl<S: Simd> Bending<S> {
    /// Subtracts twice the energy of a curvature and its shear mode from derivatives to A, Iy, Iz, J, as
    /// `NaturalStiffness::energy_by_property`; `moment` is the place of the second moment among them.
    #[inline(always)]
    pub(super) fn subtract_energy(
        &self,
        curvature: Lane<S>,
        shear: Lane<S>,
        moment: usize,
        out: &mut [Lane<S>; 4],
    ) {
        let of_shear = self.shear_mode * shear * shear;
        let through_moment = self.share * of_shear;
        let of_both = multiply_add(self.curvature * curvature, curvature, through_moment);
        out[moment] -= of_both;
        out[0] -= of_shear - through_moment;
    }
}
