//! How the end compliance changes with the section constants of the elements.

use super::compliance::ComplianceGradient;
use super::element::STRAINS;
use super::parts::Structure;
use super::section::Property;
use super::solve::Solver;

/// Which elements and hinges each parameter acts on.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct ParameterPlaces {
    /// Of each element: place of a parameter, and the section constant that it multiplies.
    pub(crate) of_elements: Vec<Vec<(usize, Property)>>,
    /// Of each hinge: place of the parameter that is its compliance.
    pub(crate) of_hinges: Vec<Option<usize>>,
    /// How many parameters there are.
    pub(crate) count: usize,
}

impl Solver {
    /// Derivatives of entry (i, i) of the end compliance to the logarithm of each section constant of each element.
    ///
    /// -u_iᵀ ∂K/∂ln p u_i, exact; call after [`Solver::end_translation_compliance`] (i below 3) or
    /// [`Solver::end_compliance`]. `out` has one entry an element, unit of the compliance entry.
    pub fn compliance_gradient(&self, i: usize, out: &mut [ComplianceGradient]) {
        for (element, gradient) in out.iter_mut().enumerate() {
            let strains = self.strains(element, i);
            *gradient = self.energy_lost(element, &strains);
        }
    }

    /// The same for the displacement along a unit vector per force along it.
    pub fn compliance_gradient_along(&self, unit: [f64; 3], out: &mut [ComplianceGradient]) {
        for (element, gradient) in out.iter_mut().enumerate() {
            let strains = self.strains_along(element, unit);
            *gradient = self.energy_lost(element, &strains);
        }
    }

    /// Natural strains of an element under a force of one along a unit vector at the end; after the same calls.
    pub(crate) fn strains_along(&self, element: usize, unit: [f64; 3]) -> [f64; STRAINS] {
        let mut strains = [0.0; STRAINS];
        let shares = unit.into_iter().enumerate();
        for (axis, share) in shares.filter(|(_, share)| *share != 0.0) {
            let of_axis = self.strains(element, axis);
            for (sum, strain) in strains.iter_mut().zip(of_axis) {
                *sum += share * strain;
            }
        }
        strains
    }

    /// Moment in a hinge that yields, or force of one that slides, in solution `column` of the last response, N·m or N.
    pub(crate) fn hinge_load(&self, structure: &Structure, hinge: usize, column: usize) -> f64 {
        let equation = self.topology.hinge_equations[hinge];
        let moved = self.solution[column * self.topology.equation_count + equation];
        structure.hinges[hinge].stiffness_nm_per_rad * moved
    }

    /// Bilinear strain energy of two strain states of an element, by section constant: see
    /// [`NaturalStiffness::energy_by_property`](super::NaturalStiffness::energy_by_property).
    pub(crate) fn energies(
        &self,
        element: usize,
        a: &[f64; STRAINS],
        b: &[f64; STRAINS],
    ) -> [f64; 4] {
        self.natural[element].energy_by_property(a, b)
    }

    fn energy_lost(&self, element: usize, strains: &[f64; STRAINS]) -> ComplianceGradient {
        self.energies(element, strains, strains)
            .map(|energy| -energy)
    }
}
