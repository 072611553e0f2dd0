//! Compliance of the end of a robot in many poses at once.

use crate::structure::{BatchSolver, Compliance6, ComplianceGradient, ElementRole};

use super::Robot;
use super::error::RobotError;
use super::file::ElementClass;
use super::mechanism::Mechanism;
use super::members::{JointModel, MechanismModel, Theory};
use super::model::{FittingFactors, Pose};
use super::predict::Predictor;

/// Classes of elements, in the order of their derivatives.
const CLASSES: [ElementClass; 2] = [ElementClass::Beam, ElementClass::Link];

/// The global axes.
const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Derivatives of a compliance to ln A, ln Iy, ln Iz, ln J of all beams, and of all links.
pub type ClassGradient = [[f64; 4]; CLASSES.len()];

/// Model and solver of one mechanism in a fixed number of poses.
///
/// Poses are placed once and solved with any factors. What [`BatchSolver`] does not serve (turning joints) or does not solve goes to
/// a [`Predictor`], pose by pose, which also names what is wrong.
#[derive(Debug)]
pub struct BatchPredictor<'a> {
    model: MechanismModel<'a>,
    solver: Option<BatchSolver>,
    poses: Vec<Option<Pose>>,
    /// Directions of the derivatives in each pose.
    units: Vec<[[f64; 3]; 3]>,
    /// What the general solver found in the poses that needed it.
    exceptions: Vec<Option<Solution>>,
    /// Made for the first pose that needs it.
    general: Option<Predictor<'a>>,
    classes: Vec<usize>,
    gradient: Vec<ComplianceGradient>,
}

/// The result of one pose.
#[derive(Debug, Clone, Copy)]
struct Solution {
    compliance: Compliance6,
    gradients: [ClassGradient; 3],
}

impl<'a> BatchPredictor<'a> {
    /// Predictor of the paper's structure, rigid joints and Euler-Bernoulli beams, in `pose_count` poses.
    ///
    /// # Errors
    /// [`RobotError::IncompleteMechanism`].
    pub fn new(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        pose_count: usize,
    ) -> Result<Self, RobotError> {
        let (joints, theory) = (JointModel::Rigid, Theory::EulerBernoulli);
        Self::with(robot, mechanism, &joints, theory, pose_count)
    }

    /// Predictor of any structure of a mechanism in `pose_count` poses.
    ///
    /// # Errors
    /// [`RobotError::IncompleteMechanism`].
    pub fn with(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        joints: &JointModel,
        theory: Theory,
        pose_count: usize,
    ) -> Result<Self, RobotError> {
        let unit = FittingFactors::UNIT;
        let model = MechanismModel::new(robot, mechanism, joints, theory, &unit)?;
        let classes: Vec<usize> = model
            .members()
            .map(|member| usize::from(member.class == ElementClass::Link))
            .collect();
        let roles: Vec<ElementRole> = model
            .members()
            .zip(&classes)
            .map(|(member, &group)| ElementRole {
                group,
                plane: member.plane,
            })
            .collect();
        let solver = BatchSolver::new(model.structure(), &roles, pose_count);
        let solver = solver.map_err(|source| RobotError::Structure {
            mechanism: mechanism.name.clone(),
            source,
        })?;
        Ok(Self {
            general: None,
            gradient: vec![[0.0; 4]; classes.len()],
            classes,
            model,
            solver,
            poses: vec![None; pose_count],
            units: vec![AXES; pose_count],
            exceptions: vec![None; pose_count],
        })
    }

    /// Number of poses there is room for.
    #[must_use]
    pub fn pose_count(&self) -> usize {
        self.poses.len()
    }

    /// Places pose number `index`.
    ///
    /// # Errors
    /// [`RobotError::Unreachable`]; the number then keeps the pose it had.
    ///
    /// # Panics
    /// If `index` is out of range.
    pub fn place(&mut self, index: usize, pose: &Pose) -> Result<(), RobotError> {
        self.model.place(pose)?;
        if let Some(solver) = &mut self.solver {
            solver.place(index, self.model.structure());
        }
        self.exceptions[index] = None;
        match &mut self.poses[index] {
            Some(kept) => kept.angles_deg.clone_from(&pose.angles_deg),
            empty => *empty = Some(pose.clone()),
        }
        Ok(())
    }

    /// Takes the derivatives in pose number `index` along these unit vectors instead of x, y, z, from the next solution on.
    ///
    /// # Panics
    /// If `index` is out of range.
    pub fn differentiate_along(&mut self, index: usize, units: &[[f64; 3]; 3]) {
        self.units[index] = *units;
        if let Some(solver) = &mut self.solver {
            solver.differentiate_along(index, units);
        }
    }

    /// Solves every placed pose with the given factors; `gradients` tells whether [`BatchPredictor::gradient`] will be asked for.
    ///
    /// # Errors
    /// [`RobotError::Structure`] of the first pose in which the structure cannot carry a load.
    pub fn solve(&mut self, factors: &FittingFactors, gradients: bool) -> Result<(), RobotError> {
        if let Some(solver) = &mut self.solver {
            solver.solve(&CLASSES.map(|class| factors.of(class)), gradients);
        }
        for index in 0..self.poses.len() {
            let solved = self
                .solver
                .as_ref()
                .is_some_and(|solver| solver.is_solved(index));
            self.exceptions[index] = None;
            if solved || self.poses[index].is_none() {
                continue;
            }
            self.solve_alone(index, factors, gradients)?;
        }
        Ok(())
    }

    /// Solves one pose by the general solver.
    fn solve_alone(
        &mut self,
        index: usize,
        factors: &FittingFactors,
        gradients: bool,
    ) -> Result<(), RobotError> {
        let Some(pose) = &self.poses[index] else {
            return Ok(());
        };
        let general = match &mut self.general {
            Some(general) => general,
            none => none.insert(Predictor::of(self.model.clone())?),
        };
        general.rate(factors);
        general.place(pose)?;
        let mut solution = Solution {
            compliance: general.compliance(),
            gradients: [[[0.0; 4]; CLASSES.len()]; 3],
        };
        if gradients {
            for (unit, by_class) in self.units[index].iter().zip(&mut solution.gradients) {
                general.compliance_gradient_along(*unit, &mut self.gradient);
                for (of_element, &class) in self.gradient.iter().zip(&self.classes) {
                    for (sum, derivative) in by_class[class].iter_mut().zip(of_element) {
                        *sum += derivative;
                    }
                }
            }
        }
        self.exceptions[index] = Some(solution);
        Ok(())
    }

    /// Compliance of the end in pose number `index`, 6 × 6, SI; `None` if no pose of that number is placed and solved.
    #[must_use]
    pub fn compliance(&self, index: usize) -> Option<Compliance6> {
        match self.exceptions.get(index)? {
            Some(solution) => Some(solution.compliance),
            None => Some(self.solved(index)?.end_compliance(index)),
        }
    }

    /// Displacement along `axis` per force along it in pose number `index`, m/N; `None` if no pose of that number is placed and solved.
    #[must_use]
    pub fn direct_compliance(&self, index: usize, axis: usize) -> Option<f64> {
        match self.exceptions.get(index)? {
            Some(solution) => Some(solution.compliance.direct(axis)),
            None => Some(self.solved(index)?.direct_compliance(index, axis)),
        }
    }

    /// Derivatives of [`BatchPredictor::direct_compliance`], or of the compliance along the direction that stands in its place, by class
    /// of element, m/N; zero if the solution was not asked for them.
    #[must_use]
    pub fn gradient(&self, index: usize, axis: usize) -> Option<ClassGradient> {
        if let Some(solution) = self.exceptions.get(index)? {
            return Some(solution.gradients[axis]);
        }
        let solver = self.solved(index)?;
        Some([0, 1].map(|group| solver.derivatives(index, axis, group)))
    }

    fn solved(&self, index: usize) -> Option<&BatchSolver> {
        self.solver
            .as_ref()
            .filter(|solver| solver.is_solved(index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{NodePlace, RadiusOf};
    use stiffbench_test_files::shipped_robot;

    fn robot() -> Robot {
        Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap()
    }

    /// Largest difference of compliances and gradients between a batch and a predictor, relative to the diagonal.
    fn largest_difference(joints: &JointModel, theory: Theory) -> f64 {
        let robot = robot();
        let mechanism = robot.mechanism(None).unwrap();
        let factors = robot.factor_set("m_fsd").unwrap();
        let count = robot.poses.len();
        let mut batch = BatchPredictor::with(&robot, mechanism, joints, theory, count).unwrap();
        let mut single = Predictor::with(&robot, mechanism, joints, theory, &factors).unwrap();
        for (index, named) in robot.poses.iter().enumerate() {
            batch.place(index, &named.pose).unwrap();
        }
        batch.solve(&factors, true).unwrap();
        let mut largest = 0.0_f64;
        for (index, named) in robot.poses.iter().enumerate() {
            single.place(&named.pose).unwrap();
            let expected = single.compliance();
            let found = batch.compliance(index).unwrap();
            largest = largest.max(found.relative_difference(&expected));
            for axis in 0..3 {
                let compliance = batch.direct_compliance(index, axis).unwrap();
                assert_eq!(compliance, found.direct(axis));
                let sum: f64 = batch.gradient(index, axis).unwrap().iter().flatten().sum();
                largest = largest.max((sum / compliance + 1.0).abs());
            }
        }
        largest
    }

    #[test]
    fn a_batch_predicts_what_the_single_predictor_does() {
        for theory in [Theory::EulerBernoulli, Theory::Timoshenko] {
            let difference = largest_difference(&JointModel::Rigid, theory);
            assert!(difference < 2e-9, "{theory:?}: {difference:e}");
        }
    }

    #[test]
    fn derivatives_along_any_direction() {
        let robot = robot();
        let mechanism = robot.mechanism(None).unwrap();
        let factors = robot.factor_set("m_fsd").unwrap();
        let joint = robot.joints.iter().position(|j| j.name == "A3").unwrap();
        let (sin, cos) = 0.7_f64.sin_cos();
        let units = [[0.6, 0.0, 0.8], [0.0, cos, -sin], [0.48, 0.6, -0.64]];
        // Through the lanes, and through the general solver.
        for joints in [JointModel::Rigid, JointModel::Hinged(vec![(joint, 1e6)])] {
            let theory = Theory::EulerBernoulli;
            let mut batch = BatchPredictor::with(&robot, mechanism, &joints, theory, 2).unwrap();
            batch.place(1, &robot.poses[1].pose).unwrap();
            batch.differentiate_along(1, &units);
            let mut along = |beam_bending: f64| {
                let mut factors = factors;
                factors.beam[1] *= beam_bending.exp();
                batch.solve(&factors, true).unwrap();
                let compliance = batch.compliance(1).unwrap().translation();
                let values = units.map(|u| {
                    let terms = (0..9).map(|k| u[k / 3] * compliance[k / 3][k % 3] * u[k % 3]);
                    terms.sum::<f64>()
                });
                (values, [0, 1, 2].map(|i| batch.gradient(1, i).unwrap()))
            };
            // Central differences of 1e-4: truncation 1e-9 of the compliance, rounding of it 1e-9/1e-4.
            let (up, down) = (along(1e-4).0, along(-1e-4).0);
            let (values, gradients) = along(0.0);
            for i in 0..3 {
                let slope = (up[i] - down[i]) / 2e-4;
                let error = (gradients[i][0][1] - slope).abs() / values[i];
                assert!(error < 1e-5, "{joints:?} {i}: {error:e}");
                assert!(slope < -1e-3 * values[i], "there is something to see");
            }
        }
    }

    #[test]
    fn turning_joints_go_to_the_single_predictor() {
        let robot = robot();
        let joint = robot.joints.iter().position(|j| j.name == "A3").unwrap();
        // A stiff joint, so that the derivatives still add up to nearly the whole compliance.
        let joints = JointModel::Hinged(vec![(joint, 1e12)]);
        let difference = largest_difference(&joints, Theory::EulerBernoulli);
        assert!(difference < 1e-4, "{difference:e}");
        let mechanism = robot.mechanism(None).unwrap();
        let batch =
            BatchPredictor::with(&robot, mechanism, &joints, Theory::EulerBernoulli, 1).unwrap();
        assert!(batch.solver.is_none());
    }

    #[test]
    fn a_structure_that_moves_is_named_as_the_single_predictor_names_it() {
        let robot = robot();
        let mechanism = robot.mechanism(Some("A")).unwrap();
        let mut batch = BatchPredictor::new(&robot, mechanism, 3).unwrap();
        batch.place(1, &robot.poses[0].pose).unwrap();
        let mut factors = FittingFactors::UNIT;
        batch.solve(&factors, false).unwrap();
        assert!(batch.compliance(0).is_none() && batch.compliance(1).is_some());
        assert!(batch.compliance(3).is_none());
        factors.beam[3] = 0.0;
        let error = batch.solve(&factors, false).unwrap_err();
        let mut single = Predictor::new(&robot, mechanism, &factors).unwrap();
        let expected = single.place(&robot.poses[0].pose).unwrap_err();
        assert_eq!(error.to_string(), expected.to_string());
        assert!(batch.compliance(1).is_none());
    }

    /// A robot one of whose loops closes in its first pose and not in the one whose number is returned.
    fn robot_with_a_short_loop() -> (Robot, usize) {
        let whole = robot();
        for node in 0..whole.nodes.len() {
            for centimetres in 1..200 {
                let mut robot = whole.clone();
                let NodePlace::Loop { radii, .. } = &mut robot.nodes[node].place else {
                    break;
                };
                *radii = [RadiusOf::Length(0.01 * f64::from(centimetres)); 2];
                let mechanism = robot.mechanism(None).unwrap();
                let mut batch = BatchPredictor::new(&robot, mechanism, 1).unwrap();
                let mut reached = robot.poses.iter().map(|p| batch.place(0, &p.pose).is_ok());
                if reached.next() == Some(true)
                    && let Some(far) = reached.position(|reached| !reached)
                {
                    return (robot, 1 + far);
                }
            }
        }
        panic!("no loop of the robot can be made to open");
    }

    #[test]
    fn a_pose_out_of_reach_leaves_the_one_before() {
        let (robot, far) = robot_with_a_short_loop();
        let mechanism = robot.mechanism(None).unwrap();
        let mut batch = BatchPredictor::new(&robot, mechanism, 1).unwrap();
        batch.place(0, &robot.poses[0].pose).unwrap();
        batch.solve(&FittingFactors::UNIT, false).unwrap();
        let before = batch.compliance(0);
        assert!(matches!(
            batch.place(0, &robot.poses[far].pose),
            Err(RobotError::Unreachable { .. })
        ));
        batch.solve(&FittingFactors::UNIT, false).unwrap();
        assert!(before.is_some());
        assert_eq!(batch.compliance(0), before);
    }
}
