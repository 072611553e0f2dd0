//! Which elements and hinges of a structure each parameter acts on, and the derivatives that follow.
//!
//! With s the natural strains of an element under a unit load and d its stiffnesses, ∂C_ij/∂ln p = -Σ ∂d/∂ln p s_i s_j over the elements
//! that p acts on; with m the load on a spring, ∂C_ij/∂c = m_i m_j. Both are exact, in closed loops too.
//!
//! # Source
//! Haftka and Gürdal, Elements of Structural Optimization (1992), section 7.2 (direct method; here load and response coincide).

use crate::structure::{Compliance6, LoadAt, ParameterPlaces, STRAINS};

use super::members::MechanismModel;
use super::model_parameter::ModelParameter;
use super::predict::Predictor;

/// Which elements and hinges of a model each of some parameters acts on.
pub(super) fn places(model: &MechanismModel<'_>, parameters: &[ModelParameter]) -> ParameterPlaces {
    let robot = model.robot();
    let all = || parameters.iter().enumerate();
    let of_element = |member: &super::model::Member| {
        let acting = |(place, parameter): (usize, &ModelParameter)| {
            let property = match parameter {
                ModelParameter::Class(class, property) => {
                    (member.class == *class).then_some(*property)
                }
                ModelParameter::Section(section, property) => {
                    (robot.section_name(member) == &**section).then_some(*property)
                }
                ModelParameter::Group(group, property) => {
                    member.groups.contains(group).then_some(*property)
                }
                _ => None,
            };
            Some((place, property?))
        };
        all().filter_map(acting).collect()
    };
    let of_hinge = |spring: &ModelParameter| parameters.iter().position(|known| known == spring);
    let hinges = model.hinges().iter();
    ParameterPlaces {
        of_elements: model.members().map(of_element).collect(),
        of_hinges: hinges.map(|hinge| of_hinge(&hinge.spring)).collect(),
        count: parameters.len(),
    }
}

impl Predictor<'_> {
    /// Derivatives of the compliance to each parameter: to ln a of a factor, and to the compliance of a spring; call after
    /// [`Predictor::compliance`] in the same pose.
    ///
    /// # Returns
    /// One 6 × 6 matrix a parameter, in the unit of the compliance, for a spring divided by its unit.
    #[must_use]
    pub fn compliance_derivatives(&self, parameters: &[ModelParameter]) -> Vec<Compliance6> {
        let places = places(self.model(), parameters);
        let mut out = vec![Compliance6([[0.0; 6]; 6]); parameters.len()];
        let (solver, structure) = (self.solver(), self.model().structure());
        for (element, acting) in places.of_elements.iter().enumerate() {
            if acting.is_empty() {
                continue;
            }
            let strains: [[f64; STRAINS]; 6] =
                std::array::from_fn(|column| solver.strains(element, column));
            for i in 0..6 {
                for j in i..6 {
                    let energies = solver.energies(element, &strains[i], &strains[j]);
                    for (place, property) in acting {
                        out[*place].0[i][j] -= energies[property.index()];
                    }
                }
            }
        }
        for (hinge, place) in places.of_hinges.iter().enumerate() {
            if let Some(place) = place {
                let loads: [f64; 6] =
                    std::array::from_fn(|column| solver.hinge_load(structure, hinge, column));
                for i in 0..6 {
                    for j in i..6 {
                        out[*place].0[i][j] += loads[i] * loads[j];
                    }
                }
            }
        }
        for matrix in &mut out {
            for i in 0..6 {
                for j in 0..i {
                    matrix.0[i][j] = matrix.0[j][i];
                }
            }
        }
        out
    }

    /// Derivatives of the displacement along a unit vector per force along it to each of the parameters of a places; after
    /// [`Predictor::compliance`] or [`Predictor::translation_compliance`].
    ///
    /// # Arguments
    /// - `out`: one entry a parameter, overwritten: m/N to ln a of a factor, and to the compliance of a spring divided by its unit.
    pub(super) fn gradient_along(&self, unit: [f64; 3], places: &ParameterPlaces, out: &mut [f64]) {
        out.fill(0.0);
        let (solver, structure) = (self.solver(), self.model().structure());
        for (element, acting) in places.of_elements.iter().enumerate() {
            if !acting.is_empty() {
                let strains = solver.strains_along(element, unit);
                let energies = solver.energies(element, &strains, &strains);
                for (place, property) in acting {
                    out[*place] -= energies[property.index()];
                }
            }
        }
        for (hinge, place) in places.of_hinges.iter().enumerate() {
            if let Some(place) = place {
                let load =
                    (0..3).map(|axis| unit[axis] * solver.hinge_load(structure, hinge, axis));
                out[*place] += load.sum::<f64>().powi(2);
            }
        }
    }

    /// Displacement and rotation of the end under any loads on the structure, and its derivatives to each parameter, where it was placed.
    ///
    /// # Returns
    /// ux, uy, uz (m), rx, ry, rz (rad); and the same per ln a of each factor and per compliance of each spring.
    #[must_use]
    pub fn displacement_derivatives(
        &mut self,
        loads: &[LoadAt],
        parameters: &[ModelParameter],
    ) -> ([f64; 6], Vec<[f64; 6]>) {
        let places = places(self.model(), parameters);
        self.displacement_gradient(loads, &places)
    }

    pub(super) fn displacement_gradient(
        &mut self,
        loads: &[LoadAt],
        places: &ParameterPlaces,
    ) -> ([f64; 6], Vec<[f64; 6]>) {
        let mut gradient = vec![[0.0; 6]; places.count];
        let (solver, model) = self.parts();
        let structure = model.structure();
        let displacement = solver.end_displacement(loads);
        let elements = 0..structure.elements.len();
        let under_load: Vec<[f64; STRAINS]> =
            elements.map(|element| solver.strains(element, 0)).collect();
        let hinges = 0..structure.hinges.len();
        let on_hinges: Vec<f64> = hinges
            .map(|hinge| solver.hinge_load(structure, hinge, 0))
            .collect();
        // The unit loads on the end, in all six columns.
        let _ = solver.end_compliance();
        for (element, acting) in places.of_elements.iter().enumerate() {
            for component in (0..6).filter(|_| !acting.is_empty()) {
                let strains = solver.strains(element, component);
                let energies = solver.energies(element, &strains, &under_load[element]);
                for (place, property) in acting {
                    gradient[*place][component] -= energies[property.index()];
                }
            }
        }
        for (hinge, place) in places.of_hinges.iter().enumerate() {
            if let Some(place) = place {
                for component in 0..6 {
                    gradient[*place][component] +=
                        solver.hinge_load(structure, hinge, component) * on_hinges[hinge];
                }
            }
        }
        (displacement, gradient)
    }

    /// Displacement and rotation of the end under the robot's own weight, payload and balancers, against the same robot without weight, and
    /// its derivatives to each parameter, where it was placed; as [`Predictor::displacement_derivatives`].
    #[must_use]
    pub fn weight_displacement(
        &mut self,
        parameters: &[ModelParameter],
    ) -> ([f64; 6], Vec<[f64; 6]>) {
        let loads = self.model().weight();
        self.displacement_derivatives(&loads, parameters)
    }
}
