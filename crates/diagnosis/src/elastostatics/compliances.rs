//! The compliance of the end in every pose, with its derivatives to the parameters of a fit.

use stiffbench_beams::robot::{
    FittingFactors, JointModel, Mechanism, MechanismModel, ModelParameter, Pose, Predictor, Robot,
    RobotError, Theory,
};
use stiffbench_beams::structure::Compliance6;
use stiffbench_numeric::vector::dot6;

/// Six by six: displacement and rotation per force and moment of the end, SI.
pub(super) type EndCompliance = [[f64; 6]; 6];

/// A pose solved.
#[derive(Debug, Clone)]
pub(super) struct PoseCompliance {
    /// Of the end.
    pub(super) compliance: EndCompliance,
    /// Its derivative to each parameter: to ln a of a factor, to the compliance of a spring.
    pub(super) derivatives: Vec<EndCompliance>,
    /// Motion of the end under own weight; zero where it was not asked for.
    weight: [f64; 6],
    /// Its derivatives to each parameter.
    weight_derivatives: Vec<[f64; 6]>,
}

impl PoseCompliance {
    /// Motion of the end under a load, and under own weight if that was asked for.
    pub(super) fn motion(&self, load: &[f64; 6]) -> [f64; 6] {
        moved(&self.compliance, load, &self.weight)
    }

    /// Derivative of that motion to a parameter.
    pub(super) fn derivative(&self, parameter: usize, load: &[f64; 6]) -> [f64; 6] {
        let none = [0.0; 6];
        let weight = self.weight_derivatives.get(parameter).unwrap_or(&none);
        moved(&self.derivatives[parameter], load, weight)
    }
}

/// Model and solver of a mechanism for any poses and values.
#[derive(Debug)]
pub(super) struct ComplianceSolver<'a> {
    predictor: Predictor<'a>,
    parameters: Vec<ModelParameter>,
}

impl<'a> ComplianceSolver<'a> {
    /// # Arguments
    /// - `parameters`: to which compliances are differentiated; springs among them may be rigid.
    ///
    /// # Errors
    /// [`RobotError`] for an incomplete mechanism.
    pub(super) fn new(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        parameters: &[ModelParameter],
        factors: &FittingFactors,
    ) -> Result<Self, RobotError> {
        let (joints, theory) = (JointModel::Rigid, Theory::EulerBernoulli);
        let model = MechanismModel::with_parameters(
            robot, mechanism, &joints, theory, factors, parameters,
        )?;
        Ok(Self {
            predictor: Predictor::of(model)?,
            parameters: parameters.to_vec(),
        })
    }

    /// Solves a pose with the given values.
    ///
    /// # Arguments
    /// - `weighs`: whether own weight is to be solved for too.
    ///
    /// # Errors
    /// [`RobotError`] for a pose that cannot be reached, or in which the structure carries nothing.
    pub(super) fn solve(
        &mut self,
        pose: &Pose,
        factors: &FittingFactors,
        derivatives: bool,
        weighs: bool,
    ) -> Result<PoseCompliance, RobotError> {
        // Values first: a structure is factorised where it is placed.
        self.predictor.prepare(factors);
        self.predictor.place(pose)?;
        let compliance = self.predictor.compliance().0;
        let derivatives = if derivatives {
            let solved = self.predictor.compliance_derivatives(&self.parameters);
            solved.into_iter().map(|matrix| matrix.0).collect()
        } else {
            Vec::new()
        };
        let (weight, weight_derivatives) = if weighs {
            let asked = if derivatives.is_empty() {
                &[]
            } else {
                &self.parameters[..]
            };
            self.predictor.weight_displacement(asked)
        } else {
            ([0.0; 6], Vec::new())
        };
        Ok(PoseCompliance {
            compliance,
            derivatives,
            weight,
            weight_derivatives,
        })
    }
}

/// Motion by a matrix under a load, and a further one.
fn moved(matrix: &EndCompliance, load: &[f64; 6], further: &[f64; 6]) -> [f64; 6] {
    let by_load = Compliance6(*matrix).times(*load);
    std::array::from_fn(|row| by_load[row] + further[row])
}

/// Component of the end's motion along a unit vector of six under a load.
pub(super) fn motion_along(matrix: &EndCompliance, unit: &[f64; 6], load: &[f64; 6]) -> f64 {
    dot6(*unit, Compliance6(*matrix).times(*load))
}
