//! Compliance of the end of a robot, pose after pose.

use super::hinges::JointModel;
use crate::structure::{Compliance6, ComplianceGradient, Solver};

use super::Robot;
use super::error::RobotError;
use super::fitting_factors::FittingFactors;
use super::members::{MechanismModel, Theory};
use super::model::{Mechanism, Pose};

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
    ///
    /// # Errors
    /// [`RobotError::Structure`].
    pub fn of(model: MechanismModel<'a>) -> Result<Self, RobotError> {
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

    /// Takes other factors for the poses to come: nothing is factorised or solved before [`Predictor::place`].
    pub fn prepare(&mut self, factors: &FittingFactors) {
        self.model.set_factors(factors);
    }

    /// Compliance of the end where it was placed, 6 × 6, SI.
    #[must_use]
    pub fn compliance(&mut self) -> Compliance6 {
        self.solver.end_compliance()
    }

    /// Displacement per force of the end where it was placed, 3 × 3, m/N.
    #[must_use]
    pub fn translation_compliance(&mut self) -> [[f64; 3]; 3] {
        self.solver.end_translation_compliance()
    }

    /// Derivatives of entry (i, i) of the compliance last asked for, one row an element, to ln A, ln Iy, ln Iz, ln J.
    pub fn compliance_gradient(&self, i: usize, out: &mut [ComplianceGradient]) {
        self.solver.compliance_gradient(i, out);
    }

    /// The same for the displacement along a unit vector per force along it.
    pub fn compliance_gradient_along(&self, unit: [f64; 3], out: &mut [ComplianceGradient]) {
        self.solver.compliance_gradient_along(unit, out);
    }

    /// The structure's model.
    #[must_use]
    pub fn model(&self) -> &MechanismModel<'a> {
        &self.model
    }

    pub(super) fn solver(&self) -> &Solver {
        &self.solver
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
