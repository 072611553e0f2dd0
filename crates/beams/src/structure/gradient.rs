//! How the end compliance changes with the section constants of the elements.

use stiffbench_numeric::vector::dot;

use super::compliance::ComplianceGradient;
use super::element::STRAINS;
use super::parts::Structure;
use super::solve::Solver;

impl Solver {
    /// Derivatives of entry (i, i) of the end compliance to the logarithm of each section constant of each element.
    ///
    /// -u_iᵀ ∂K/∂ln p u_i, exact; call after [`Solver::end_translation_compliance`] (i below 3) or
    /// [`Solver::end_compliance`]. `out` has one entry an element, unit of the compliance entry.
    pub fn compliance_gradient(
        &self,
        structure: &Structure,
        i: usize,
        out: &mut [ComplianceGradient],
    ) {
        for (element, gradient) in out.iter_mut().enumerate() {
            let strains = self.strains(structure, element, i);
            *gradient = self.energy_lost(element, &strains);
        }
    }

    /// The same for the displacement along a unit vector per force along it.
    pub fn compliance_gradient_along(
        &self,
        structure: &Structure,
        unit: [f64; 3],
        out: &mut [ComplianceGradient],
    ) {
        for (element, gradient) in out.iter_mut().enumerate() {
            let mut strains = [0.0; STRAINS];
            for (axis, share) in unit
                .into_iter()
                .enumerate()
                .filter(|(_, share)| *share != 0.0)
            {
                let of_axis = self.strains(structure, element, axis);
                for (sum, strain) in strains.iter_mut().zip(of_axis) {
                    *sum += share * strain;
                }
            }
            *gradient = self.energy_lost(element, &strains);
        }
    }

    /// Moment in a hinge that yields under a force of one along a unit vector at the end, N·m/N; after the same calls.
    pub(crate) fn hinge_moment(&self, structure: &Structure, hinge: usize, unit: [f64; 3]) -> f64 {
        let equations = self.topology.equation_count;
        let equation = self.topology.hinge_equations[hinge];
        let twists = [0, 1, 2].map(|axis| self.solution[axis * equations + equation]);
        structure.hinges[hinge].stiffness_nm_per_rad * dot(twists, unit)
    }

    fn energy_lost(&self, element: usize, strains: &[f64; STRAINS]) -> ComplianceGradient {
        self.natural[element]
            .energy_by_property(strains, strains)
            .map(|energy| -energy)
    }
}
