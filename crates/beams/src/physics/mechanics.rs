//! The robot in the poses of a session, reduced to what the laws need.

use super::place::Place;
use crate::robot::{
    FittingFactors, JointModel, Mechanism, MechanismModel, ModelParameter, MultiPosePredictor,
    Pose, Predictor, Robot, RobotError, SpringAxis, Theory,
};
use crate::structure::{RotationInfluence, Solver, Structure, StructureError};
use stiffbench_numeric::vector::dot6;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::read_axis::ReadAxis;
use stiffbench_units_and_text::test_point::Direction;

/// A mechanism in fixed poses, solved again with any factors: with rigid joints in all poses side by side, what twists do pose by pose
/// and only where it is asked for.
#[derive(Debug)]
pub struct Mechanics<'a> {
    robot: &'a Robot,
    mechanism: &'a Mechanism,
    /// Robot joints that exist in the mechanism, in the order of the levers.
    joints: Vec<usize>,
    /// All poses with rigid joints.
    rigid: MultiPosePredictor<'a>,
    factors: FittingFactors,
    /// What the derivatives to each parameter are multiplied by.
    units: Vec<f64>,
    /// Whether a joint has a spring among the parameters, by its place among the levers.
    sprung: Vec<bool>,
    poses: Vec<Posed<'a>>,
    weighing: Option<Weighing<'a>>,
}

/// What solves the poses under own weight.
#[derive(Debug)]
struct Weighing<'a> {
    predictor: Box<Predictor<'a>>,
    /// The parameters of the baseline, then what else turns or slides: joints and base.
    parameters: Vec<ModelParameter>,
    /// Places among them: of each joint, in the order of the levers, and of the base about x, y, z.
    joints: Vec<usize>,
    base: [usize; 3],
    /// For each pose the derivatives of its motion under own weight.
    derivatives: Vec<Vec<[f64; 6]>>,
}

/// One pose.
#[derive(Debug)]
struct Posed<'a> {
    pose: Pose,
    rigid: MechanismModel<'a>,
    /// `None` until it is asked for what twists do.
    twisting: Option<Twisting<'a>>,
    mechanics: PoseMechanics,
}

/// What works out the twists of one pose.
#[derive(Debug)]
struct Twisting<'a> {
    hinged: MechanismModel<'a>,
    solver: Solver,
    lacks: Lacks,
}

/// What of the structure a solver does not have yet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Lacks {
    /// Nothing.
    Nothing,
    /// The sections under the factors set last.
    Sections,
    /// Where the structure stands, and the sections.
    Place,
}

/// What a load and the laws need to know of a pose.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PoseMechanics {
    /// Compliance with rigid joints and the influence of a twist in each joint.
    pub influence: RotationInfluence,
    /// Motion of the end per rocking of the base about x, y, z through the first support: m/rad, and rotation.
    pub base_levers: [[f64; 6]; 3],
    /// Derivative of the compliance to each parameter of the baseline: to ln a of a factor, to the compliance of a spring. What is not along
    /// x, y, z under a force along the same axis is zero unless it was asked for ([`Mechanics::differentiate_whole`]).
    pub gradient: Vec<[[f64; 6]; 6]>,
    /// Where the end stands before a load acts.
    pub unloaded: Unloaded,
}

/// Where the end of a robot stands without a load, against the rigid robot of its file: under own weight, and where its lengths and angles are
/// others. All zero where only what loads move is read.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Unloaded {
    /// Displacement, m, and rotation, rad.
    pub motion: [f64; 6],
    /// Its derivative to each parameter of the baseline: as of [`PoseMechanics::gradient`]; those that are not there are zero.
    pub gradient: Vec<[f64; 6]>,
    /// Moment of own weight in each joint, in the order of the levers, N·m or N; none where weight does not count.
    pub joint_nm: Vec<f64>,
    /// The same of the base about x, y, z, N·m.
    pub base_nm: [f64; 3],
}

impl Unloaded {
    /// Moment of own weight in a joint, by its place among the levers, N·m.
    #[must_use]
    pub fn moment_nm(&self, joint: usize) -> f64 {
        self.joint_nm.get(joint).copied().unwrap_or(0.0)
    }
}

impl PoseMechanics {
    /// Motion along `read` per unit of a load: m/N, rad/N, m/(N·m) or rad/(N·m).
    #[must_use]
    pub fn compliance(&self, read: &ReadAxis, load: &LoadDirection) -> f64 {
        product(&self.influence.compliance, read.unit(), load.wrench())
    }

    /// The same per component of a force along x, y, z of the base; zero of those that are not asked for.
    #[must_use]
    pub fn compliance_by_components(&self, read: &ReadAxis, asked_for: [bool; 3]) -> [f64; 3] {
        Direction::ALL.map(|axis| {
            if asked_for[axis.index()] {
                self.compliance(read, LoadDirection::of_axis(axis))
            } else {
                0.0
            }
        })
    }

    /// Motion per unit of a load that acts along it, m/N or rad/(N·m).
    #[must_use]
    pub fn along(&self, read: &ReadAxis) -> f64 {
        product(&self.influence.compliance, read.unit(), read.unit())
    }

    /// Its derivative to a parameter of the baseline; what lies across the load only if it was asked for. Zero of a parameter of no compliance.
    #[must_use]
    pub fn gradient(&self, parameter: usize, read: &ReadAxis, load: &LoadDirection) -> f64 {
        let own = self.gradient.get(parameter);
        own.map_or(0.0, |own| product(own, read.unit(), load.wrench()))
    }

    /// Motion of the end under a force and moment, m and rad, with that of the unloaded end where it counts.
    #[must_use]
    pub fn motion(&self, wrench: [f64; 6]) -> [f64; 6] {
        let by_load = self.influence.compliance.map(|row| dot6(row, wrench));
        std::array::from_fn(|part| by_load[part] + self.unloaded.motion[part])
    }

    /// Its derivative to a parameter of the baseline, where the whole compliance is differentiated.
    #[must_use]
    pub fn motion_derivative(&self, parameter: usize, wrench: [f64; 6]) -> [f64; 6] {
        let by_load = self.gradient[parameter].map(|row| dot6(row, wrench));
        let unloaded = self.unloaded.gradient.get(parameter);
        let unloaded = unloaded.copied().unwrap_or_default();
        std::array::from_fn(|part| by_load[part] + unloaded[part])
    }

    /// Derivative to a parameter of the baseline of what `read` shows without a load.
    #[must_use]
    pub fn unloaded_gradient(&self, parameter: usize, read: &ReadAxis) -> f64 {
        let own = self.unloaded.gradient.get(parameter);
        own.map_or(0.0, |own| dot6(*own, read.unit()))
    }

    /// Moment of a joint at zero twist under a force and moment at the end, and own weight, N·m.
    pub(super) fn driving_nm(&self, joint: usize, wrench: [f64; 6]) -> f64 {
        self.unloaded.moment_nm(joint) + dot6(self.influence.levers[joint], wrench)
    }

    /// Share of a lever in a motion along `read` per unit of a load: the product of the lever along both.
    #[must_use]
    pub fn lever_product(lever: [f64; 6], read: &ReadAxis, load: &LoadDirection) -> f64 {
        dot6(lever, read.unit()) * dot6(lever, load.wrench())
    }
}

/// The moment on a spring, N·m: what the spring moves per compliance is its lever times that.
fn moment_nm(derivative: [f64; 6], lever: [f64; 6]) -> f64 {
    let square = dot6(lever, lever);
    if square > 0.0 {
        dot6(derivative, lever) / square
    } else {
        0.0
    }
}

/// A matrix between two vectors, of which most entries are zero.
fn product(matrix: &[[f64; 6]; 6], left: [f64; 6], right: [f64; 6]) -> f64 {
    let rows = matrix.iter().zip(left).filter(|(_, share)| *share != 0.0);
    rows.fold(0.0, |sum, (row, share)| sum + share * dot6(*row, right))
}

impl<'a> Mechanics<'a> {
    /// Places a mechanism in poses and solves it there.
    ///
    /// # Errors
    /// [`RobotError`] for an incomplete mechanism, a pose that cannot be reached, a structure that carries nothing.
    pub fn new(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        factors: &FittingFactors,
        poses: &[Pose],
    ) -> Result<Self, RobotError> {
        let mut mechanics = Self::rigid(robot, mechanism, factors, poses)?;
        mechanics.solve_joints(|_| true)?;
        Ok(mechanics)
    }

    /// The same with rigid joints: what twists do is not known until [`Mechanics::solve_joints`].
    ///
    /// # Errors
    /// As [`Mechanics::new`].
    pub fn rigid(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        factors: &FittingFactors,
        poses: &[Pose],
    ) -> Result<Self, RobotError> {
        Self::rigid_with(robot, mechanism, &ModelParameter::BEAMS, factors, poses)
    }

    /// The same with the parameters of a baseline, to which compliances are differentiated. Joints with a spring among them or in `factors`
    /// yield by it under every law.
    ///
    /// # Errors
    /// As [`Mechanics::new`].
    pub fn rigid_with(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        parameters: &[ModelParameter],
        factors: &FittingFactors,
        poses: &[Pose],
    ) -> Result<Self, RobotError> {
        let factors = &robot.with_own_springs(factors);
        let springs = factors.springs();
        let springs = springs.filter(|spring| !parameters.contains(spring));
        let all: Vec<ModelParameter> = parameters.iter().cloned().chain(springs).collect();
        let mut predictor = MultiPosePredictor::new(robot, mechanism, &all, poses.len())?;
        let (joints, theory) = (JointModel::Rigid, Theory::EulerBernoulli);
        let rigid = factors.without_springs();
        // The other springs are part of the structure under all laws.
        let others = all
            .iter()
            .filter(|spring| !spring.is_beside_structure() && !spring.is_factor());
        let others: Vec<ModelParameter> = others.cloned().collect();
        let model =
            MechanismModel::with_parameters(robot, mechanism, &joints, theory, &rigid, &others)?;
        let placed = poses.iter().enumerate().map(|(index, pose)| {
            predictor.place(index, pose)?;
            let mut rigid = model.clone();
            rigid.place(pose)?;
            Ok(Posed {
                pose: pose.clone(),
                mechanics: PoseMechanics {
                    influence: RotationInfluence::default(),
                    base_levers: rigid.base_levers(),
                    gradient: vec![[[0.0; 6]; 6]; parameters.len()],
                    unloaded: Unloaded::default(),
                },
                rigid,
                twisting: None,
            })
        });
        let poses = placed.collect::<Result<Vec<_>, RobotError>>()?;
        let mut mechanics = Self {
            robot,
            mechanism,
            sprung: mechanism
                .joints(robot)
                .into_iter()
                .map(|joint| {
                    let name = robot.joints[joint].name.as_str();
                    all.contains(&ModelParameter::Joint(name.into()))
                })
                .collect(),
            units: vec![1.0; parameters.len()],
            joints: mechanism.joints(robot),
            rigid: predictor,
            factors: factors.clone(),
            poses,
            weighing: None,
        };
        mechanics.solve_rigid()?;
        Ok(mechanics)
    }

    /// Solves own weight too, from now on: where the end stands without a load.
    ///
    /// # Arguments
    /// - `parameters`: of the baseline.
    ///
    /// # Errors
    /// [`RobotError`] as in the poses where it was placed.
    pub fn weigh(&mut self, parameters: &[ModelParameter]) -> Result<(), RobotError> {
        let (robot, mechanism) = (self.robot, self.mechanism);
        let mut all = parameters.to_vec();
        let mut place = |parameter: ModelParameter| {
            let known = all.iter().position(|known| *known == parameter);
            known.unwrap_or_else(|| {
                all.push(parameter);
                all.len() - 1
            })
        };
        let joints = self.joints.iter().map(|&joint| {
            let joint = &robot.joints[joint];
            place(ModelParameter::of_joint(&joint.name, joint.motion))
        });
        let joints = joints.collect();
        let base = [SpringAxis::Rx, SpringAxis::Ry, SpringAxis::Rz]
            .map(|axis| place(ModelParameter::Base(axis)));
        let (rigid, theory) = (JointModel::Rigid, Theory::EulerBernoulli);
        let factors = &self.factors;
        let model =
            MechanismModel::with_parameters(robot, mechanism, &rigid, theory, factors, &all)?;
        self.weighing = Some(Weighing {
            predictor: Box::new(Predictor::of(model)?),
            derivatives: vec![Vec::new(); self.poses.len()],
            parameters: all,
            joints,
            base,
        });
        self.solve_weight()
    }

    /// Motions under own weight and their derivatives.
    fn solve_weight(&mut self) -> Result<(), RobotError> {
        let Some(weighing) = &mut self.weighing else {
            return Ok(());
        };
        weighing.predictor.prepare(&self.factors);
        for (posed, derivatives) in self.poses.iter_mut().zip(&mut weighing.derivatives) {
            weighing.predictor.place(&posed.pose)?;
            let unloaded = &mut posed.mechanics.unloaded;
            (unloaded.motion, *derivatives) =
                weighing.predictor.weight_displacement(&weighing.parameters);
            let of_parameters = derivatives.iter().zip(&self.units);
            let scaled = of_parameters.map(|(own, unit)| own.map(|derivative| derivative * unit));
            unloaded.gradient = scaled.collect();
            for (axis, lever) in posed.mechanics.base_levers.iter().enumerate() {
                unloaded.base_nm[axis] = moment_nm(derivatives[weighing.base[axis]], *lever);
            }
        }
        Ok(())
    }

    /// Multiplies derivatives to each parameter from the next solution on: a compliance differentiated in units of its own size.
    pub fn differentiate_in(&mut self, units: Vec<f64>) {
        self.units = units;
    }

    /// Differentiates the whole compliance, from now on: motions along one axis under a load along another too.
    ///
    /// # Errors
    /// [`RobotError`] as in the poses where it was placed.
    pub fn differentiate_whole(&mut self) -> Result<(), RobotError> {
        self.rigid.differentiate_whole();
        self.solve_rigid()
    }

    /// Solves all poses with other factors; allocates nothing.
    ///
    /// # Errors
    /// [`RobotError::Structure`].
    pub fn set_factors(&mut self, factors: &FittingFactors) -> Result<(), RobotError> {
        self.set_factors_rigid(factors)?;
        self.solve_joints(|_| true)
    }

    /// Solves all poses with other factors and rigid joints: what twists do is stale until [`Mechanics::solve_joints`].
    ///
    /// # Errors
    /// [`RobotError::Structure`].
    pub fn set_factors_rigid(&mut self, factors: &FittingFactors) -> Result<(), RobotError> {
        self.factors.clone_from(factors);
        self.robot.add_own_springs(&mut self.factors);
        for twisting in self.poses.iter_mut().flat_map(|posed| &mut posed.twisting) {
            if twisting.lacks == Lacks::Nothing {
                twisting.lacks = Lacks::Sections;
            }
        }
        self.solve_rigid()
    }

    /// Compliances and their derivatives with rigid joints.
    fn solve_rigid(&mut self) -> Result<(), RobotError> {
        self.rigid.solve(&self.factors, true)?;
        for (index, posed) in self.poses.iter_mut().enumerate() {
            let solved = self.rigid.compliance(index);
            let mechanics = &mut posed.mechanics;
            mechanics.influence.compliance = solved.expect("every pose was placed and solved").0;
            let whole = self.rigid.whole_gradient(index);
            let gradients = mechanics.gradient.iter_mut().zip(&self.units);
            for ((gradient, unit), whole) in gradients.zip(whole) {
                *gradient = whole.0.map(|row| row.map(|derivative| derivative * unit));
            }
            for axis in 0..3 {
                let solved = self.rigid.gradient(index, axis);
                let gradient = solved.expect("every pose was placed and solved");
                let gradients = mechanics.gradient.iter_mut().zip(&self.units);
                for ((own, unit), derivative) in gradients.zip(gradient) {
                    own[axis][axis] = derivative * unit;
                }
            }
        }
        self.solve_weight()
    }

    /// Moves one of the poses and solves it there with rigid joints: what twists do is stale until [`Mechanics::solve_joints`].
    ///
    /// # Errors
    /// [`RobotError`] for a pose that cannot be reached or a structure that carries nothing there.
    pub fn move_to(&mut self, index: usize, pose: &Pose) -> Result<(), RobotError> {
        let posed = &mut self.poses[index];
        posed.rigid.place(pose)?;
        posed.pose.clone_from(pose);
        if let Some(twisting) = &mut posed.twisting {
            twisting.hinged.place(pose)?;
            twisting.lacks = Lacks::Place;
        }
        posed.mechanics.base_levers = posed.rigid.base_levers();
        self.rigid.place(index, pose)?;
        self.solve_rigid()
    }

    /// Where the end is in pose number `pose`, m.
    #[must_use]
    pub fn end_m(&self, pose: usize) -> [f64; 3] {
        let structure = self.poses[pose].rigid.structure();
        structure.nodes[structure.end.node].position_m
    }

    /// Works out what twists in some joints do under the factors set last; of the others nothing is known then.
    ///
    /// # Arguments
    /// - `is_asked_for`: of a joint, by its place among the levers.
    ///
    /// # Errors
    /// [`RobotError::Structure`].
    pub fn solve_joints(&mut self, is_asked_for: impl Fn(usize) -> bool) -> Result<(), RobotError> {
        let (robot, mechanism, factors) = (self.robot, self.mechanism, &self.factors);
        for index in 0..self.poses.len() {
            let (before, rest) = self.poses.split_at_mut(index);
            let posed = &mut rest[0];
            let twisting = if let Some(twisting) = posed.twisting.take() {
                twisting
            } else {
                let first = before.first().and_then(|first| first.twisting.as_ref());
                Twisting::new(robot, mechanism, factors, posed, first)?
            };
            let twisting = posed.twisting.insert(twisting);
            posed.rigid.set_factors(factors);
            let structure = posed.rigid.structure();
            twisting.bring_up_to_date(mechanism, structure)?;
            let solved = twisting.solver.rotation_influence_of(
                twisting.hinged.structure(),
                // Behind the joints stand the springs of the structure.
                |hinge| {
                    let sprung = self.sprung.get(hinge);
                    sprung.is_some_and(|sprung| *sprung || is_asked_for(hinge))
                },
                &mut posed.mechanics.influence,
            );
            solved.map_err(carries_nothing(mechanism))?;
            if self.sprung.contains(&true) {
                let joints = self.joints.iter();
                let springs: Vec<f64> = joints
                    .map(|&joint| factors.joint_rad_per_nm(&robot.joints[joint].name))
                    .collect();
                posed.mechanics.influence.yield_by(&springs);
            }
            if let Some(weighing) = &self.weighing {
                let own = &weighing.derivatives[index];
                let levers = posed.mechanics.influence.levers.iter();
                let joints = weighing.joints.iter().zip(levers);
                let moments = joints.map(|(&joint, lever)| moment_nm(own[joint], *lever));
                posed.mechanics.unloaded.joint_nm = moments.collect();
            }
        }
        Ok(())
    }

    /// The record of pose number `pose`.
    #[must_use]
    pub fn pose(&self, pose: usize) -> &PoseMechanics {
        &self.poses[pose].mechanics
    }

    /// The same, to be changed.
    pub fn pose_mut(&mut self, pose: usize) -> &mut PoseMechanics {
        &mut self.poses[pose].mechanics
    }

    /// The joints, in the order of the levers.
    pub fn joints(&self) -> impl Iterator<Item = Place> {
        let joints = self.joints.iter().map(|&joint| &self.robot.joints[joint]);
        joints.map(|joint| Place::of_joint(&joint.name, joint.motion))
    }

    /// The robot.
    #[must_use]
    pub fn robot(&self) -> &'a Robot {
        self.robot
    }

    /// The mechanism.
    #[must_use]
    pub fn mechanism(&self) -> &'a Mechanism {
        self.mechanism
    }
}

impl<'a> Twisting<'a> {
    /// # Arguments
    /// - `known`: of another pose, if there is one: its structure is connected like this.
    fn new(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        factors: &FittingFactors,
        posed: &Posed<'a>,
        known: Option<&Self>,
    ) -> Result<Self, RobotError> {
        let joints = mechanism.joints(robot);
        let all = JointModel::Hinged(joints.into_iter().map(|joint| (joint, 0.0)).collect());
        let theory = Theory::EulerBernoulli;
        let mut hinged = MechanismModel::new(robot, mechanism, &all, theory, factors)?;
        hinged.place(&posed.pose)?;
        let solver = match known {
            Some(known) => known.solver.another(),
            None => Solver::new(posed.rigid.structure()).map_err(carries_nothing(mechanism))?,
        };
        Ok(Self {
            hinged,
            solver,
            lacks: Lacks::Place,
        })
    }

    /// Gives the solver what it lacks of the structure with rigid joints.
    fn bring_up_to_date(
        &mut self,
        mechanism: &Mechanism,
        structure: &Structure,
    ) -> Result<(), RobotError> {
        let updated = match self.lacks {
            Lacks::Nothing => Ok(()),
            Lacks::Sections => self.solver.update_sections(structure),
            Lacks::Place => self.solver.update(structure),
        };
        updated.map_err(carries_nothing(mechanism))?;
        self.lacks = Lacks::Nothing;
        Ok(())
    }
}

fn carries_nothing(mechanism: &Mechanism) -> impl Fn(StructureError) -> RobotError {
    |source| RobotError::Structure {
        mechanism: mechanism.name.clone(),
        source,
    }
}
