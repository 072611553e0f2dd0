//! The robot in the poses of a session, reduced to what the laws need.

use crate::robot::{
    ElementClass, FittingFactors, JointModel, Mechanism, MechanismModel, Pose, Robot, RobotError,
    Theory,
};
use crate::structure::{ComplianceGradient, Solver, TwistInfluence};
use crate::test_point::Direction;
use crate::vector::{cross, subtract};

/// A mechanism in fixed poses, solved again with any factors.
#[derive(Debug)]
pub struct Mechanics<'a> {
    robot: &'a Robot,
    mechanism: &'a Mechanism,
    /// Robot joints that exist in the mechanism, in the order of the levers.
    joints: Vec<usize>,
    poses: Vec<Posed<'a>>,
}

/// One pose.
#[derive(Debug)]
struct Posed<'a> {
    rigid: MechanismModel<'a>,
    hinged: MechanismModel<'a>,
    solver: Solver,
    mechanics: PoseMechanics,
    /// Derivatives of each element; scratch memory.
    gradient: Vec<ComplianceGradient>,
}

/// What a load and the laws need to know of a pose.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct PoseMechanics {
    /// Compliance with rigid joints and the influence of a twist in each joint.
    pub influence: TwistInfluence,
    /// Displacement of the end per rocking of the base about x, y, z through the first support, m/rad.
    pub base_levers_m: [[f64; 3]; 3],
    /// Derivative of the compliance along x, y, z to each parameter of the baseline, m/N; for a robot to ln A, ln Iy, ln Iz, ln J
    /// of its beams.
    pub compliance_gradient: Vec<[f64; 3]>,
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
        let joints = mechanism.joints(robot);
        let all = JointModel::Hinged(joints.iter().map(|&joint| (joint, 0.0)).collect());
        let theory = Theory::EulerBernoulli;
        let model =
            |joints: &JointModel| MechanismModel::new(robot, mechanism, joints, theory, factors);
        let poses = poses
            .iter()
            .map(|pose| {
                let mut rigid = model(&JointModel::Rigid)?;
                let mut hinged = model(&all)?;
                rigid.place(pose)?;
                hinged.place(pose)?;
                let wrap = |source| RobotError::Structure {
                    mechanism: mechanism.name.clone(),
                    source,
                };
                let mut solver = Solver::new(rigid.structure()).map_err(wrap)?;
                solver.update(rigid.structure()).map_err(wrap)?;
                let base_levers_m = base_levers(&rigid);
                let mut posed = Posed {
                    rigid,
                    hinged,
                    solver,
                    mechanics: PoseMechanics {
                        influence: TwistInfluence::default(),
                        base_levers_m,
                        compliance_gradient: vec![[0.0; 3]; 4],
                    },
                    gradient: vec![[0.0; 4]; mechanism.members.len()],
                };
                posed.solve_rigid();
                posed.solve_joints(|_| true);
                Ok(posed)
            })
            .collect::<Result<_, RobotError>>()?;
        Ok(Self {
            robot,
            mechanism,
            joints,
            poses,
        })
    }

    /// Solves all poses with other factors; allocates nothing.
    ///
    /// # Errors
    /// [`RobotError::Structure`].
    pub fn set_factors(&mut self, factors: &FittingFactors) -> Result<(), RobotError> {
        self.set_factors_rigid(factors)?;
        self.solve_joints(|_| true);
        Ok(())
    }

    /// Solves all poses with other factors and rigid joints: what twists do is stale until [`Mechanics::solve_joints`].
    ///
    /// # Errors
    /// [`RobotError::Structure`].
    pub fn set_factors_rigid(&mut self, factors: &FittingFactors) -> Result<(), RobotError> {
        for posed in &mut self.poses {
            posed.rigid.set_factors(factors);
            posed
                .solver
                .update_sections(posed.rigid.structure())
                .map_err(|source| RobotError::Structure {
                    mechanism: self.mechanism.name.clone(),
                    source,
                })?;
            posed.solve_rigid();
        }
        Ok(())
    }

    /// Moves one of the poses and solves it there with rigid joints: what twists do is stale until [`Mechanics::solve_joints`].
    ///
    /// # Errors
    /// [`RobotError`] for a pose that cannot be reached or a structure that carries nothing there.
    pub fn move_to(&mut self, index: usize, pose: &Pose) -> Result<(), RobotError> {
        let posed = &mut self.poses[index];
        posed.rigid.place(pose)?;
        posed.hinged.place(pose)?;
        posed
            .solver
            .update(posed.rigid.structure())
            .map_err(|source| RobotError::Structure {
                mechanism: self.mechanism.name.clone(),
                source,
            })?;
        posed.mechanics.base_levers_m = base_levers(&posed.rigid);
        posed.solve_rigid();
        Ok(())
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
    pub fn solve_joints(&mut self, is_asked_for: impl Fn(usize) -> bool) {
        for posed in &mut self.poses {
            posed.solve_joints(&is_asked_for);
        }
    }

    /// What is known of pose number `pose`.
    #[must_use]
    pub fn pose(&self, pose: usize) -> &PoseMechanics {
        &self.poses[pose].mechanics
    }

    /// Names of the joints, in the order of the levers.
    pub fn joint_names(&self) -> impl Iterator<Item = &'a str> {
        self.joints
            .iter()
            .map(|&joint| self.robot.joints[joint].name.as_str())
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

impl Posed<'_> {
    fn solve_rigid(&mut self) {
        let structure = self.rigid.structure();
        self.mechanics.influence.compliance_m_per_n =
            self.solver.end_translation_compliance(structure);
        for axis in 0..3 {
            self.solver
                .compliance_gradient(structure, axis, &mut self.gradient);
            let mut sums = [0.0; 4];
            for (member, gradient) in self.rigid.members().zip(&self.gradient) {
                if member.class == ElementClass::Beam {
                    for (sum, part) in sums.iter_mut().zip(gradient) {
                        *sum += part;
                    }
                }
            }
            for (row, sum) in self.mechanics.compliance_gradient.iter_mut().zip(sums) {
                row[axis] = sum;
            }
        }
    }

    fn solve_joints(&mut self, is_asked_for: impl Fn(usize) -> bool) {
        self.solver.twist_influence_of(
            self.rigid.structure(),
            self.hinged.structure(),
            is_asked_for,
            &mut self.mechanics.influence,
        );
    }
}

/// Displacement of the end per rocking about each axis through the first support: axis × (end - support).
pub(super) fn base_levers(model: &MechanismModel<'_>) -> [[f64; 3]; 3] {
    let structure = model.structure();
    let end = structure.nodes[structure.end.node].position_m;
    let support = structure
        .supports
        .first()
        .map_or([0.0; 3], |support| structure.nodes[support.node].position_m);
    levers_between(support, end)
}

/// The same for a given support and end.
pub(super) fn levers_between(support_m: [f64; 3], end_m: [f64; 3]) -> [[f64; 3]; 3] {
    Direction::ALL.map(|axis| cross(axis.unit_vector(), subtract(end_m, support_m)))
}
