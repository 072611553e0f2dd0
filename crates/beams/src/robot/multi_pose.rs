//! Compliance of the end of a robot in several poses, for any factors.

use super::hinges::JointModel;
use crate::structure::{Compliance6, ParameterPlaces, Reduction, SolutionPath};
use stiffbench_numeric::simd::InstructionSet;

use super::Robot;
use super::error::RobotError;
use super::fitting_factors::FittingFactors;
use super::members::{MechanismModel, Theory};
use super::model::{Mechanism, Pose};
use super::model_parameter::ModelParameter;
use super::predict::Predictor;
use super::sensitivity::places;
use super::simd_poses::{SimdPoses, class, simd_poses};

/// The global axes.
const AXES: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Model and solver of one mechanism in a fixed number of poses: placed once, solved with any factors.
///
/// Poses are solved side by side in SIMD registers. What the reduction does not serve (pins, balancers, loops of rigid links,
/// elements that carry nothing) or does not solve goes to a [`Predictor`], pose by pose, which also names what is wrong.
#[derive(Debug)]
pub struct MultiPosePredictor<'a> {
    model: MechanismModel<'a>,
    simd: Option<(Reduction, Box<dyn SimdPoses>)>,
    poses: Vec<Option<Pose>>,
    solutions: Vec<Option<Compliance6>>,
    /// What compliances are differentiated to.
    parameters: Vec<ModelParameter>,
    /// By pose, direction and parameter.
    gradients: Vec<f64>,
    /// By pose and parameter, where derivatives of the whole compliance are wanted; else empty.
    whole: Vec<Compliance6>,
    /// Made for the first pose that needs it.
    general: Option<Predictor<'a>>,
    places: ParameterPlaces,
}

impl<'a> MultiPosePredictor<'a> {
    /// Predictor of Euler-Bernoulli beams in `pose_count` poses, whose compliances are differentiated to `parameters`.
    ///
    /// Joints with a spring among the parameters yield, all others are rigid.
    ///
    /// # Errors
    /// [`RobotError::IncompleteMechanism`].
    pub fn new(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        parameters: &[ModelParameter],
        pose_count: usize,
    ) -> Result<Self, RobotError> {
        let (joints, theory) = (JointModel::Rigid, Theory::EulerBernoulli);
        Self::with(robot, mechanism, &joints, theory, parameters, pose_count)
    }

    /// The same of any structure of a mechanism: springs among the parameters are in series with those of `joints`.
    ///
    /// # Errors
    /// [`RobotError::IncompleteMechanism`].
    pub fn with(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        joints: &JointModel,
        theory: Theory,
        parameters: &[ModelParameter],
        pose_count: usize,
    ) -> Result<Self, RobotError> {
        let unit = FittingFactors::UNIT;
        let model =
            MechanismModel::with_parameters(robot, mechanism, joints, theory, &unit, parameters)?;
        let reduction = model.reduction(SolutionPath::Fastest);
        // Derivatives beside balancers are for the general solver.
        let reduction = reduction.filter(|_| robot.balancers.is_empty());
        let simd = reduction.map(|reduction| {
            let set = InstructionSet::for_poses(pose_count);
            let simd = simd_poses(set, &model, &reduction, pose_count, Some(parameters.len()));
            (reduction, simd)
        });
        Ok(Self {
            simd,
            poses: vec![None; pose_count],
            solutions: vec![None; pose_count],
            gradients: vec![0.0; pose_count * 3 * parameters.len()],
            whole: Vec::new(),
            parameters: parameters.to_vec(),
            general: None,
            places: places(&model, parameters),
            model,
        })
    }

    /// Number of poses there is room for.
    #[must_use]
    pub fn pose_count(&self) -> usize {
        self.poses.len()
    }

    /// Places pose number `index`; it has no result until the next [`MultiPosePredictor::solve`].
    ///
    /// # Errors
    /// [`RobotError::Unreachable`]; the number then keeps the pose it had.
    ///
    /// # Panics
    /// If `index` is out of range.
    pub fn place(&mut self, index: usize, pose: &Pose) -> Result<(), RobotError> {
        self.model.place(pose)?;
        if let Some((_, simd)) = &mut self.simd {
            simd.take(index, &self.model);
        }
        self.solutions[index] = None;
        match &mut self.poses[index] {
            Some(kept) => kept.angles_deg.clone_from(&pose.angles_deg),
            empty => *empty = Some(pose.clone()),
        }
        Ok(())
    }

    /// Differentiates the whole compliance, from the next solution on.
    pub fn differentiate_whole(&mut self) {
        let count = self.poses.len() * self.parameters.len();
        self.whole = vec![Compliance6([[0.0; 6]; 6]); count];
    }

    /// Solves every placed pose with the given values; `gradients` if derivatives will be asked for.
    ///
    /// # Errors
    /// [`RobotError::Structure`] of the first pose in which the structure cannot carry a load.
    pub fn solve(&mut self, factors: &FittingFactors, gradients: bool) -> Result<(), RobotError> {
        self.solutions.fill(None);
        self.gradients.fill(0.0);
        self.solve_together(factors, gradients);
        for index in 0..self.poses.len() {
            if self.solutions[index].is_none() && self.poses[index].is_some() {
                self.solve_alone(index, factors, gradients)?;
            }
        }
        Ok(())
    }

    /// Solves what the reduction serves.
    fn solve_together(&mut self, factors: &FittingFactors, gradients: bool) {
        let Some((reduction, simd)) = &mut self.simd else {
            return;
        };
        if !self.model.rate(reduction, factors) {
            return;
        }
        simd.forget();
        let (count, width) = (simd.lane_count(), self.parameters.len());
        let of_class = |parameter| matches!(parameter, &ModelParameter::Class(..));
        let by_class = self.whole.is_empty() && self.parameters.iter().all(of_class);
        for (bundle, found) in self.solutions.chunks_mut(count).enumerate() {
            simd.solve(bundle, reduction);
            match (gradients, by_class) {
                (false, _) => {}
                (true, true) => simd.differentiate(reduction, &vec![AXES; found.len()]),
                (true, false) => simd.differentiate_whole(reduction, &self.places),
            }
            for (lane, found) in found.iter_mut().enumerate() {
                *found = simd.pose(lane).map(|_| simd.compliance(lane));
                if !gradients || found.is_none() {
                    continue;
                }
                let index = bundle * count + lane;
                let rows = self.gradients[index * 3 * width..].chunks_mut(width.max(1));
                if by_class {
                    for (row, by_class) in rows.zip(simd.gradient(lane)) {
                        for (derivative, parameter) in row.iter_mut().zip(&self.parameters) {
                            if let ModelParameter::Class(of, property) = parameter {
                                *derivative = by_class[class(*of)][property.index()];
                            }
                        }
                    }
                    continue;
                }
                for (unit, row) in AXES.iter().zip(rows) {
                    for (place, derivative) in row.iter_mut().enumerate() {
                        *derivative = simd.whole_gradient(lane, place).along(*unit);
                    }
                }
                let whole = self.whole.iter_mut().skip(index * width).take(width);
                for (place, whole) in whole.enumerate() {
                    *whole = simd.whole_gradient(lane, place);
                }
            }
        }
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
        general.prepare(factors);
        general.place(pose)?;
        self.solutions[index] = Some(general.compliance());
        let width = self.parameters.len();
        if gradients && width > 0 {
            let rows = self.gradients[index * 3 * width..].chunks_mut(width);
            for (unit, row) in AXES.iter().zip(rows) {
                general.gradient_along(*unit, &self.places, row);
            }
            if !self.whole.is_empty() {
                let whole = general.compliance_derivatives(&self.parameters);
                self.whole[index * width..(index + 1) * width].copy_from_slice(&whole);
            }
        }
        Ok(())
    }

    /// Compliance of the end in pose number `index`, 6 × 6, SI; `None` if no pose of that number is placed and solved.
    #[must_use]
    pub fn compliance(&self, index: usize) -> Option<Compliance6> {
        *self.solutions.get(index)?
    }

    /// Displacement along `axis` per force along it in pose number `index`, m/N; `None` if no pose of that number is placed and solved.
    #[must_use]
    pub fn direct_compliance(&self, index: usize, axis: usize) -> Option<f64> {
        Some(self.compliance(index)?.direct(axis))
    }

    /// Derivatives of [`MultiPosePredictor::direct_compliance`] to each parameter: to ln a of a factor, m/N, and to the compliance of a
    /// spring, N·m·m/N; zero if the solution was not asked for them.
    #[must_use]
    pub fn gradient(&self, index: usize, axis: usize) -> Option<&[f64]> {
        self.compliance(index)?;
        let width = self.parameters.len();
        let start = (3 * index + axis) * width;
        Some(&self.gradients[start..start + width])
    }

    /// Derivatives of [`MultiPosePredictor::compliance`] to each parameter; none unless they were asked for
    /// ([`MultiPosePredictor::differentiate_whole`]).
    #[must_use]
    pub fn whole_gradient(&self, index: usize) -> &[Compliance6] {
        let width = self.parameters.len();
        self.whole
            .get(index * width..(index + 1) * width)
            .unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{NodePlace, RadiusOf};

    const CLASSES: [ModelParameter; 8] = ModelParameter::CLASSES;

    use stiffbench_test_files::shipped_robot;

    fn robot() -> Robot {
        Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap()
    }

    /// Largest difference of compliances and gradients between poses together and a predictor, relative to the diagonal.
    fn largest_difference(joints: &JointModel, theory: Theory) -> f64 {
        let robot = robot();
        let mechanism = robot.mechanism(None).unwrap();
        let factors = robot.factor_set("m_fsd").unwrap();
        let count = robot.poses.len();
        let mut together =
            MultiPosePredictor::with(&robot, mechanism, joints, theory, &CLASSES, count).unwrap();
        let mut single = Predictor::with(&robot, mechanism, joints, theory, &factors).unwrap();
        for (index, named) in robot.poses.iter().enumerate() {
            together.place(index, &named.pose).unwrap();
        }
        together.solve(&factors, true).unwrap();
        let mut largest = 0.0_f64;
        for (index, named) in robot.poses.iter().enumerate() {
            single.place(&named.pose).unwrap();
            let expected = single.compliance();
            let found = together.compliance(index).unwrap();
            largest = largest.max(found.relative_difference(&expected));
            for axis in 0..3 {
                let compliance = together.direct_compliance(index, axis).unwrap();
                assert_eq!(compliance, found.direct(axis));
                let sum: f64 = together.gradient(index, axis).unwrap().iter().sum();
                largest = largest.max((sum / compliance + 1.0).abs());
            }
        }
        largest
    }

    #[test]
    fn several_poses_predict_what_the_single_predictor_does() {
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
            let mut together =
                MultiPosePredictor::with(&robot, mechanism, &joints, theory, &CLASSES, 2).unwrap();
            together.place(1, &robot.poses[1].pose).unwrap();
            together.differentiate_whole();
            let mut along = |beam_bending: f64| {
                let mut factors = factors.clone();
                factors.beam[1] *= beam_bending.exp();
                together.solve(&factors, true).unwrap();
                let compliance = together.compliance(1).unwrap();
                let gradient = together.whole_gradient(1)[1];
                let of = |matrix: Compliance6| units.map(|unit| matrix.along(unit));
                (of(compliance), of(gradient))
            };
            // Central differences of 1e-4: truncation 1e-9 of the compliance, rounding of it 1e-9/1e-4.
            let (up, down) = (along(1e-4).0, along(-1e-4).0);
            let (values, gradients) = along(0.0);
            for i in 0..3 {
                let slope = (up[i] - down[i]) / 2e-4;
                let error = (gradients[i] - slope).abs() / values[i];
                assert!(error < 1e-5, "{joints:?} {i}: {error:e}");
                assert!(slope < -1e-3 * values[i], "there is something to see");
            }
        }
    }

    #[test]
    fn joints_that_yield_give_no_derivatives() {
        let robot = robot();
        let joint = robot.joints.iter().position(|j| j.name == "A3").unwrap();
        // A stiff joint, so that the derivatives still add up to nearly the whole compliance.
        let joints = JointModel::Hinged(vec![(joint, 1e12)]);
        let difference = largest_difference(&joints, Theory::EulerBernoulli);
        assert!(difference < 1e-4, "{difference:e}");
    }

    #[test]
    fn pins_go_to_the_single_predictor() {
        let robot = robot();
        let mechanism = robot.mechanism(None).unwrap();
        let joint = robot.joints.iter().position(|j| j.name == "A3").unwrap();
        let joints = JointModel::Hinged(vec![(joint, 0.0)]);
        let theory = Theory::EulerBernoulli;
        let predictor =
            MultiPosePredictor::with(&robot, mechanism, &joints, theory, &CLASSES, 1).unwrap();
        assert!(predictor.simd.is_none());
    }

    #[test]
    fn a_structure_that_moves_is_named_as_the_single_predictor_names_it() {
        let robot = robot();
        let mechanism = robot.mechanism(Some("A")).unwrap();
        let mut together = MultiPosePredictor::new(&robot, mechanism, &CLASSES, 3).unwrap();
        together.place(1, &robot.poses[0].pose).unwrap();
        let mut factors = FittingFactors::UNIT;
        together.solve(&factors, false).unwrap();
        assert!(together.compliance(0).is_none() && together.compliance(1).is_some());
        assert!(together.compliance(3).is_none());
        factors.beam[3] = 0.0;
        let error = together.solve(&factors, false).unwrap_err();
        let mut single = Predictor::new(&robot, mechanism, &factors).unwrap();
        let expected = single.place(&robot.poses[0].pose).unwrap_err();
        assert_eq!(error.to_string(), expected.to_string());
        assert!(together.compliance(1).is_none());
    }

    #[test]
    fn other_factors_leave_nothing_of_those_before() {
        let robot = robot();
        let mechanism = robot.mechanism(None).unwrap();
        let factors = robot.factor_set("m_fsd").unwrap();
        let solved = |before: &[FittingFactors]| {
            let mut together = MultiPosePredictor::new(&robot, mechanism, &CLASSES, 3).unwrap();
            for index in 0..3 {
                together.place(index, &robot.poses[index].pose).unwrap();
            }
            for factors in before {
                together.solve(factors, true).unwrap();
            }
            together.solve(&factors, false).unwrap();
            assert_eq!(together.gradient(2, 1), Some(&[0.0; 8][..]));
            together.solve(&factors, true).unwrap();
            assert!(together.gradient(2, 1).unwrap()[1] < 0.0);
            (
                together.compliance(2),
                together.gradient(2, 1).map(<[f64]>::to_vec),
            )
        };
        let mut softer = factors.clone();
        softer.link[0] = 0.1;
        assert_eq!(solved(&[]), solved(&[softer, FittingFactors::UNIT]));
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
                let mut together = MultiPosePredictor::new(&robot, mechanism, &CLASSES, 1).unwrap();
                let mut reached = robot
                    .poses
                    .iter()
                    .map(|p| together.place(0, &p.pose).is_ok());
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
        let mut together = MultiPosePredictor::new(&robot, mechanism, &CLASSES, 1).unwrap();
        together.place(0, &robot.poses[0].pose).unwrap();
        together.solve(&FittingFactors::UNIT, false).unwrap();
        let before = together.compliance(0);
        assert!(matches!(
            together.place(0, &robot.poses[far].pose),
            Err(RobotError::Unreachable { .. })
        ));
        together.solve(&FittingFactors::UNIT, false).unwrap();
        assert!(before.is_some());
        assert_eq!(together.compliance(0), before);
    }
}
