//! Compliance of the end of a robot, pose after pose.

use stiffbench_numeric::vector::dot;

use crate::structure::{Compliance6, ComplianceGradient, Property, Solver};

use super::Robot;
use super::error::RobotError;
use super::mechanism::Mechanism;
use super::members::{JointModel, MechanismModel, Theory};
use super::model::{Member, Pose};
use super::model_parameter::{FittingFactors, ModelParameter};

/// Model and solver of one mechanism: the one way from pose and factors to compliance.
#[derive(Debug)]
pub struct Predictor<'a> {
    model: MechanismModel<'a>,
    solver: Solver,
}

impl<'a> Predictor<'a> {
    /// Predictor of the paper's structure: rigid joints, Euler-Bernoulli beams.
    ///
    /// # Errors
    /// [`RobotError::IncompleteMechanism`].
    pub fn new(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        factors: &FittingFactors,
    ) -> Result<Self, RobotError> {
        Self::with(
            robot,
            mechanism,
            &JointModel::Rigid,
            Theory::EulerBernoulli,
            factors,
        )
    }

    /// Predictor of any structure of a mechanism.
    ///
    /// # Errors
    /// [`RobotError::IncompleteMechanism`].
    pub fn with(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        joints: &JointModel,
        theory: Theory,
        factors: &FittingFactors,
    ) -> Result<Self, RobotError> {
        Self::of(MechanismModel::new(
            robot, mechanism, joints, theory, factors,
        )?)
    }

    /// Predictor of a model.
    pub(super) fn of(model: MechanismModel<'a>) -> Result<Self, RobotError> {
        let solver = Solver::new(model.structure()).map_err(|source| RobotError::Structure {
            mechanism: model.mechanism().name.clone(),
            source,
        })?;
        Ok(Self { model, solver })
    }

    /// Moves to a pose and factorises there.
    ///
    /// # Errors
    /// [`RobotError::Unreachable`], or [`RobotError::Structure`] if the structure cannot carry a load.
    pub fn place(&mut self, pose: &Pose) -> Result<(), RobotError> {
        self.model.place(pose)?;
        self.solver
            .update(self.model.structure())
            .map_err(|source| self.wrapped(source))
    }

    /// Takes other factors in the same pose.
    ///
    /// # Errors
    /// [`RobotError::Structure`].
    pub fn set_factors(&mut self, factors: &FittingFactors) -> Result<(), RobotError> {
        self.model.set_factors(factors);
        self.solver
            .update_sections(self.model.structure())
            .map_err(|source| self.wrapped(source))
    }

    /// Takes other factors for the poses to come; nothing is factorised before [`Predictor::place`].
    pub(super) fn rate(&mut self, factors: &FittingFactors) {
        self.model.set_factors(factors);
    }

    /// Compliance of the end where it was placed, 6 × 6, SI.
    #[must_use]
    pub fn compliance(&mut self) -> Compliance6 {
        let compliance = self.solver.end_compliance(self.model.structure());
        self.model.with_base(compliance)
    }

    /// Displacement per force of the end where it was placed, 3 × 3, m/N.
    #[must_use]
    pub fn translation_compliance(&mut self) -> [[f64; 3]; 3] {
        let solved = self
            .solver
            .end_translation_compliance(self.model.structure());
        let mut whole = Compliance6([[0.0; 6]; 6]);
        for (row, solved) in whole.0.iter_mut().zip(solved) {
            row[..3].copy_from_slice(&solved);
        }
        self.model.with_base(whole).translation()
    }

    /// Derivatives of entry (i, i) of the compliance last asked for, one row an element, to ln A, ln Iy, ln Iz, ln J.
    pub fn compliance_gradient(&self, i: usize, out: &mut [ComplianceGradient]) {
        self.solver
            .compliance_gradient(self.model.structure(), i, out);
    }

    /// The same for the displacement along a unit vector per force along it.
    pub fn compliance_gradient_along(&self, unit: [f64; 3], out: &mut [ComplianceGradient]) {
        self.solver
            .compliance_gradient_along(self.model.structure(), unit, out);
    }

    /// Derivatives of the displacement along a unit vector per force along it to each of `parameters`: to ln a of a factor, m/N, and to the
    /// compliance of a spring, N·m·m/N; after [`Predictor::compliance`] or [`Predictor::translation_compliance`].
    ///
    /// # Arguments
    /// - `by_element`: room for as many entries as the structure has elements, overwritten.
    /// - `out`: one entry a parameter, overwritten.
    pub(super) fn gradient_along(
        &self,
        unit: [f64; 3],
        parameters: &[ModelParameter],
        by_element: &mut [ComplianceGradient],
        out: &mut [f64],
    ) {
        let structure = self.model.structure();
        self.solver
            .compliance_gradient_along(structure, unit, by_element);
        let over = |own: &dyn Fn(&Member) -> bool, property: Property| -> f64 {
            let elements = by_element.iter().zip(self.model.members());
            let own = elements.filter(|(_, member)| own(member));
            own.map(|(derivative, _)| derivative[property.index()])
                .sum()
        };
        for (derivative, parameter) in out.iter_mut().zip(parameters) {
            *derivative = match parameter {
                ModelParameter::Class(class, property) => {
                    over(&|member| member.class == *class, *property)
                }
                ModelParameter::Section(section, property) => {
                    let index = self.model.robot().sections.get_index_of(&**section);
                    over(&|member| Some(member.section) == index, *property)
                }
                // The work of the moment that the force puts on the joint.
                ModelParameter::Joint(joint) => {
                    let mut hinges = self.model.hinge_joints().iter();
                    let hinge =
                        hinges.position(|&known| *self.model.robot().joints[known].name == **joint);
                    let moment =
                        hinge.map(|hinge| self.solver.hinge_moment(structure, hinge, unit));
                    moment.unwrap_or(0.0).powi(2)
                }
                ModelParameter::Base(axis) => {
                    dot(self.model.base_levers_m()[axis.index()], unit).powi(2)
                }
            };
        }
    }

    /// The structure's model.
    #[must_use]
    pub fn model(&self) -> &MechanismModel<'a> {
        &self.model
    }

    /// Solver and structure, for displacements, forces and reactions under any load.
    pub fn parts(&mut self) -> (&mut Solver, &MechanismModel<'a>) {
        (&mut self.solver, &self.model)
    }

    fn wrapped(&self, source: crate::structure::StructureError) -> RobotError {
        RobotError::Structure {
            mechanism: self.model.mechanism().name.clone(),
            source,
        }
    }
}
