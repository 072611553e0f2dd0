//! The structure of a robot in all poses, solved for fitted values and for what effects make of the robot file.

use rayon::prelude::*;

use stiffbench_beams::physics::{
    Effect, Law, Mechanics, Place, PlaceScale, PoseMechanics, StructureEdit,
};
use stiffbench_beams::robot::{FittingFactors, Mechanism, Pose};

use super::baseline::{Baseline, PoseSolver, StructureColumn};
use super::error::MismatchError;
use super::robot_baseline::{BaselineValues, RobotBaseline};

/// One thread's solver of a robot.
pub(super) struct RobotSolver<'a> {
    baseline: &'a RobotBaseline<'a>,
    mechanism: &'a Mechanism,
    /// The robot as its file has it.
    mechanics: Mechanics<'a>,
    values: BaselineValues,
    solved: Vec<f64>,
    joints: JointsSolved,
    /// Whether displacements across the load are differentiated too.
    is_across: bool,
    /// Effects that make another structure, and what they change.
    effects: Vec<Effect>,
    edit: StructureEdit,
    /// All poses of a robot with other lengths or angles.
    changed: Option<Vec<PoseMechanics>>,
}

/// Joints whose twists were computed for the parameters solved last.
#[derive(Debug, PartialEq)]
enum JointsSolved {
    None,
    Some(Vec<usize>),
    All,
}

impl JointsSolved {
    fn contains(&self, joint: usize) -> bool {
        match self {
            Self::None => false,
            Self::Some(known) => known.contains(&joint),
            Self::All => true,
        }
    }

    /// Whether all of these are among them.
    fn includes(&self, wanted: &Self) -> bool {
        match (self, wanted) {
            (Self::All, _) | (_, Self::None) => true,
            (_, Self::All) => false,
            (_, Self::Some(wanted)) => wanted.iter().all(|joint| self.contains(*joint)),
        }
    }
}

impl<'a> RobotSolver<'a> {
    pub(super) fn new(
        baseline: &'a RobotBaseline<'a>,
        mechanism: &'a Mechanism,
        mechanics: Mechanics<'a>,
    ) -> Self {
        Self {
            values: baseline.values.clone(),
            baseline,
            mechanism,
            mechanics,
            solved: Vec::new(),
            joints: JointsSolved::None,
            is_across: false,
            effects: Vec::new(),
            edit: StructureEdit::default(),
            changed: None,
        }
    }

    fn solve_with(
        &mut self,
        parameters: &[f64],
        wanted: JointsSolved,
    ) -> Result<(), MismatchError> {
        let is_new = self.solved != parameters;
        if !is_new && self.joints.includes(&wanted) {
            return Ok(());
        }
        if is_new {
            self.solved.clear();
            self.joints = JointsSolved::None;
            self.values.set(parameters);
        }
        let factors = self.edit.factors(&self.values.at);
        if self.edit.changes_geometry() {
            self.changed = Some(self.poses_of_changed(&factors, &wanted)?);
        } else {
            self.changed = None;
            if is_new {
                self.mechanics.set_factors_rigid(&factors)?;
            }
            if wanted != JointsSolved::None {
                self.mechanics
                    .solve_joints(|joint| wanted.contains(joint))?;
            }
        }
        self.joints = wanted;
        if is_new {
            self.solved.extend_from_slice(parameters);
        }
        Ok(())
    }

    /// All poses of the robot with other lengths or angles: it is laid out anew each time.
    fn poses_of_changed(
        &self,
        factors: &FittingFactors,
        joints: &JointsSolved,
    ) -> Result<Vec<PoseMechanics>, MismatchError> {
        let baseline = self.baseline;
        let robot = self.edit.robot(baseline.robot);
        let poses = baseline
            .poses
            .iter()
            .map(|pose| match baseline.pose_id(pose) {
                Some(id) => self.edit.pose(baseline.robot, id, pose),
                None => pose.clone(),
            });
        let poses: Vec<Pose> = poses.collect();
        let free = &self.values.free;
        let mut mechanics = Mechanics::rigid_with(&robot, self.mechanism, free, factors, &poses)?;
        let units = self.values.springs_rad_per_nm.iter();
        if units.clone().any(Option::is_some) {
            mechanics.differentiate_in(units.map(|unit| unit.unwrap_or(1.0)).collect());
            mechanics.set_factors_rigid(factors)?;
        }
        if self.is_across {
            mechanics.differentiate_across()?;
        }
        if *joints != JointsSolved::None {
            mechanics.solve_joints(|joint| joints.contains(joint))?;
        }
        Ok((0..poses.len())
            .map(|pose| mechanics.pose(pose).clone())
            .collect())
    }
}

impl PoseSolver for RobotSolver<'_> {
    fn set_structure(&mut self, effects: &[Effect]) -> Result<(), MismatchError> {
        let others = || {
            effects
                .iter()
                .filter(|effect| effect.law.changes_structure())
        };
        if others().eq(&self.effects) {
            return Ok(());
        }
        self.effects = others().cloned().collect();
        self.solved.clear();
        self.edit = if self.effects.iter().all(|effect| effect.values.is_empty()) {
            StructureEdit::default()
        } else {
            let (baseline, mechanism) = (self.baseline, self.mechanism);
            StructureEdit::new(
                baseline.robot,
                mechanism,
                baseline.suspects(),
                &self.effects,
            )?
        };
        Ok(())
    }

    fn differentiate_across(&mut self) -> Result<(), MismatchError> {
        self.is_across = true;
        Ok(self.mechanics.differentiate_across()?)
    }

    fn solve(&mut self, parameters: &[f64]) -> Result<(), MismatchError> {
        self.solve_with(parameters, JointsSolved::All)
    }

    fn solve_for(&mut self, parameters: &[f64], joints: &[usize]) -> Result<(), MismatchError> {
        let wanted = match joints {
            [] => JointsSolved::None,
            joints => JointsSolved::Some(joints.to_vec()),
        };
        self.solve_with(parameters, wanted)
    }

    fn pose(&self, pose: usize) -> &PoseMechanics {
        match &self.changed {
            Some(changed) => &changed[pose],
            None => self.mechanics.pose(pose),
        }
    }

    fn joint_names(&self) -> Vec<String> {
        self.mechanics.joint_names().map(str::to_owned).collect()
    }
}

/// What each suspected entry of the robot file would change, by a difference over the value of its first shape; those that leave no
/// structure are passed over.
pub(super) fn structure_columns(
    baseline: &RobotBaseline<'_>,
    parameters: &[f64],
) -> Result<Vec<StructureColumn>, MismatchError> {
    let count = baseline.poses.len();
    let compliances = |solver: &dyn PoseSolver| -> Vec<[[f64; 3]; 3]> {
        let poses = (0..count).map(|pose| solver.pose(pose).influence.compliance_m_per_n);
        poses.collect()
    };
    let mut solver = baseline.solver(0)?;
    solver.solve_for(parameters, &[])?;
    let before = compliances(&*solver);
    let column = |solver: &mut dyn PoseSolver, law: Law, place: Place| -> Option<StructureColumn> {
        let shapes = (law.search.shapes)(&PlaceScale::default());
        let values = shapes.first()?.values.clone();
        let step = *values.first()?;
        let effect = Effect { law, place, values };
        solver.set_structure(std::slice::from_ref(&effect)).ok()?;
        solver.solve_for(parameters, &[]).ok()?;
        let after = compliances(solver);
        let change = after.iter().zip(&before).map(|(after, before)| {
            std::array::from_fn(|i| std::array::from_fn(|j| (after[i][j] - before[i][j]) / step))
        });
        Some(StructureColumn {
            law: effect.law,
            place: effect.place,
            compliance_m_per_n: change.collect(),
        })
    };
    let places = baseline.suspects().places().par_iter();
    let columns = places.map_init(
        || baseline.solver(0).ok(),
        |solver, (law, place)| column(&mut **solver.as_mut()?, *law, place.clone()),
    );
    let columns: Vec<Option<StructureColumn>> = columns.collect();
    Ok(columns.into_iter().flatten().collect())
}
