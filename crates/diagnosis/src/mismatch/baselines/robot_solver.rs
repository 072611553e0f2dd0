//! The structure of a robot in all poses, solved for fitted values and for what effects make of the robot file.

use rayon::prelude::*;

use stiffbench_beams::physics::{
    Effect, Law, Mechanics, Place, PlaceScale, PoseMechanics, StructureEdit, VISIBLE_SHARE,
};
use stiffbench_beams::robot::{
    FittingFactors, JointModel, Mechanism, MechanismModel, ModelParameter, Pose, Predictor, Theory,
};

use super::baseline::{Baseline, PoseSolver, StructureColumn};
use super::robot_baseline::{BaselineValues, RobotBaseline};
use crate::mismatch::error::MismatchError;
use crate::parameters::bears_no_load;
use crate::search::constants::OPEN_LOOP;

/// One thread's solver of a robot.
pub(crate) struct RobotSolver<'a> {
    baseline: &'a RobotBaseline<'a>,
    mechanism: &'a Mechanism,
    /// The robot as its file has it.
    mechanics: Mechanics<'a>,
    values: BaselineValues,
    solved: Vec<f64>,
    joints: JointsSolved,
    /// Whether displacements across the load are differentiated too.
    is_whole: bool,
    /// Effects that make another structure, and what they change.
    effects: Vec<Effect>,
    edit: StructureEdit,
    /// The robot with springs that its file lacks, and these.
    sprung: Option<(Vec<ModelParameter>, Mechanics<'a>)>,
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
    pub(crate) fn new(
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
            is_whole: false,
            effects: Vec::new(),
            edit: StructureEdit::default(),
            sprung: None,
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
            let mechanics = match &mut self.sprung {
                Some((_, sprung)) => sprung,
                None => &mut self.mechanics,
            };
            if is_new {
                mechanics.set_factors_rigid(&factors)?;
            }
            if wanted != JointsSolved::None {
                mechanics.solve_joints(|joint| wanted.contains(joint))?;
            }
        }
        if is_new || self.changed.is_some() {
            self.see_by_tracker(parameters);
        }
        self.joints = wanted;
        if is_new {
            self.solved.extend_from_slice(parameters);
        }
        Ok(())
    }

    /// Moves all tools as the parameters of a tracker have it, where one sees them.
    fn see_by_tracker(&mut self, parameters: &[f64]) {
        let Some(tracked) = self.baseline.tracked() else {
            return;
        };
        let values = &parameters[self.values.free.len()..];
        for (index, tool) in tracked.tools.iter().enumerate() {
            let motions = tracked.frames.motions(tool);
            let pose = match (&mut self.changed, &mut self.sprung) {
                (Some(changed), _) => &mut changed[index],
                (None, Some((_, sprung))) => sprung.pose_mut(index),
                (None, None) => self.mechanics.pose_mut(index),
            };
            for (motion, value) in motions.iter().zip(values) {
                for (moved, share) in pose.unloaded.motion.iter_mut().zip(motion) {
                    *moved += value * share;
                }
            }
            pose.unloaded.gradient.extend(motions);
        }
    }

    /// Lays out the robot with the springs that effects put into it, where they are others than before.
    fn lay_out_springs(&mut self) -> Result<(), MismatchError> {
        let known = self.sprung.as_ref().map_or(&[][..], |(known, _)| known);
        if self.edit.springs().eq(known) {
            return Ok(());
        }
        self.sprung = None;
        let springs: Vec<ModelParameter> = self.edit.springs().cloned().collect();
        if !springs.is_empty() {
            let baseline = self.baseline;
            let factors = self.edit.factors(&self.values.at);
            let own = (baseline.robot, self.mechanism);
            let mut sprung = baseline.mechanics(own, &factors, &baseline.poses)?;
            if self.is_whole {
                sprung.differentiate_whole()?;
            }
            self.sprung = Some((springs, sprung));
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
        let mut mechanics = baseline.mechanics((&robot, self.mechanism), factors, &poses)?;
        if self.is_whole {
            mechanics.differentiate_whole()?;
        } else if self.values.springs_rad_per_nm.iter().any(Option::is_some) {
            mechanics.set_factors_rigid(factors)?;
        }
        if *joints != JointsSolved::None {
            mechanics.solve_joints(|joint| joints.contains(joint))?;
        }
        let mut solved: Vec<PoseMechanics> = (0..poses.len())
            .map(|pose| mechanics.pose(pose).clone())
            .collect();
        for (index, tool) in baseline
            .tracked()
            .iter()
            .flat_map(|one| one.tools.iter().enumerate())
        {
            let moved = robot
                .end_pose(self.mechanism, &poses[index])?
                .moved_from(tool);
            for (motion, by) in solved[index].unloaded.motion.iter_mut().zip(moved) {
                *motion += by;
            }
        }
        Ok(solved)
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
        self.lay_out_springs()
    }

    fn differentiate_whole(&mut self) -> Result<(), MismatchError> {
        self.is_whole = true;
        if let Some((_, sprung)) = &mut self.sprung {
            sprung.differentiate_whole()?;
        }
        Ok(self.mechanics.differentiate_whole()?)
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
        match (&self.changed, &self.sprung) {
            (Some(changed), _) => &changed[pose],
            (None, Some((_, sprung))) => sprung.pose(pose),
            (None, None) => self.mechanics.pose(pose),
        }
    }

    fn joints(&self) -> Vec<Place> {
        self.mechanics.joints().collect()
    }
}

/// What each suspected entry of the robot file would change, by a difference over the value of its first shape; those that leave no
/// structure are passed over.
pub(crate) fn file_columns(
    baseline: &RobotBaseline<'_>,
    parameters: &[f64],
) -> Result<Vec<StructureColumn>, MismatchError> {
    let count = baseline.poses.len();
    let states = |solver: &dyn PoseSolver| -> Vec<([[f64; 6]; 6], [f64; 6])> {
        let poses = (0..count).map(|pose| solver.pose(pose));
        let states = poses.map(|pose| (pose.influence.compliance, pose.unloaded.motion));
        states.collect()
    };
    let mut solver = baseline.solver(0)?;
    solver.solve_for(parameters, &[])?;
    let before = states(&*solver);
    let column = |solver: &mut dyn PoseSolver, law: Law, place: Place| -> Option<StructureColumn> {
        let shapes = (law.search.shapes)(&PlaceScale::default());
        let values = shapes.first()?.values.clone();
        let step = *values.first()?;
        let effect = Effect { law, place, values };
        solver.set_structure(std::slice::from_ref(&effect)).ok()?;
        solver.solve_for(parameters, &[]).ok()?;
        let after = states(solver);
        let pairs = || after.iter().zip(&before);
        let change = pairs().map(|((after, _), (before, _))| {
            std::array::from_fn(|i| std::array::from_fn(|j| (after[i][j] - before[i][j]) / step))
        });
        let moved = pairs().map(|((_, after), (_, before))| {
            std::array::from_fn(|i| (after[i] - before[i]) / step)
        });
        Some(StructureColumn {
            law: effect.law,
            place: effect.place,
            compliance: change.collect(),
            loop_stiffness: Vec::new(),
            unloaded: moved.filter(|_| baseline.tracked().is_some()).collect(),
        })
    };
    let all = baseline.suspects().places();
    let places = all.par_iter().filter(|(_, place)| place.spring().is_none());
    let columns = places.map_init(
        || baseline.solver(0).ok(),
        |solver, (law, place)| column(&mut **solver.as_mut()?, *law, place.clone()),
    );
    let columns: Vec<Option<StructureColumn>> = columns.collect();
    Ok(columns.into_iter().flatten().collect())
}

/// What each spring that the robot file lacks would change.
pub(crate) fn spring_columns(
    baseline: &RobotBaseline<'_>,
    parameters: &[f64],
) -> Result<Vec<StructureColumn>, MismatchError> {
    let places = baseline.suspects().places().iter();
    let mut found: Vec<(ModelParameter, StructureColumn)> = places
        .filter_map(|(law, place)| {
            let column = StructureColumn {
                law: *law,
                place: place.clone(),
                compliance: Vec::with_capacity(baseline.poses.len()),
                loop_stiffness: Vec::with_capacity(baseline.poses.len()),
                unloaded: Vec::new(),
            };
            Some((place.spring()?, column))
        })
        .collect();
    let springs: Vec<ModelParameter> = found.iter().map(|(spring, _)| spring.clone()).collect();
    let factors = baseline.factors(parameters);
    let (joints, theory) = (JointModel::Rigid, Theory::EulerBernoulli);
    let (robot, mechanism) = (baseline.robot, baseline.mechanism());
    let model =
        MechanismModel::with_parameters(robot, mechanism, &joints, theory, &factors, &springs)?;
    let mut predictor = Predictor::of(model)?;
    let mut rigid = Vec::with_capacity(baseline.poses.len());
    for pose in &baseline.poses {
        predictor.place(pose)?;
        // The derivatives are those of the compliance solved last.
        rigid.push(predictor.compliance());
        let derivatives = predictor.compliance_derivatives(&springs);
        for ((_, column), derivative) in found.iter_mut().zip(derivatives) {
            let rows = std::array::from_fn(|i| std::array::from_fn(|j| derivative.0[i][j]));
            column.compliance.push(rows);
        }
        if baseline.tracked().is_some() {
            let (_, by_weight) = predictor.weight_displacement(&springs);
            for ((_, column), moved) in found.iter_mut().zip(by_weight) {
                column.unloaded.push(moved);
            }
        }
    }
    for (spring, column) in &mut found {
        let poses = rigid.iter().zip(&column.compliance);
        let shares =
            poses.flat_map(|(c, slope)| (0..3).map(|axis| slope[axis][axis] / c.0[axis][axis]));
        let share = shares.fold(0.0, f64::max);
        // A hinge is one freedom: how much a finite compliance falls short of its slope is its loop.
        if share <= 0.0 || bears_no_load(share.recip(), f64::INFINITY) {
            column.loop_stiffness.resize(rigid.len(), 0.0);
            continue;
        }
        let compliance = VISIBLE_SHARE / share;
        let mut sprung = factors.clone();
        sprung.set(spring, factors.get(spring) + compliance);
        predictor.prepare(&sprung);
        let poses = baseline.poses.iter().zip(&rigid).zip(&column.compliance);
        for ((pose, rigid), slope) in poses {
            predictor.place(pose)?;
            let whole = predictor.compliance();
            let along = |axis: &usize| slope[*axis][*axis];
            let best = (0..3).max_by(|a, b| along(a).total_cmp(&along(b)));
            let axis = best.unwrap_or_default();
            let full = compliance * along(&axis);
            let change = whole.0[axis][axis] - rigid.0[axis][axis];
            let stiffness = (full / change - 1.0) / compliance;
            // Without a loop the rest is rounding.
            let is_open = share > OPEN_LOOP * stiffness;
            let stiffness = if is_open { 0.0 } else { stiffness };
            column.loop_stiffness.push(stiffness);
        }
        predictor.prepare(&factors);
    }
    Ok(found.into_iter().map(|(_, column)| column).collect())
}

#[cfg(test)]
mod tests {
    use stiffbench_units_and_text::test_point::PoseId;

    use super::*;
    use crate::tests::{baseline, hp_robot};

    /// A column with its loop is the structure with the spring in it, of any compliance: a hinge is one freedom.
    #[test]
    fn a_spring_changes_the_structure_as_its_column_says() {
        let robot = hp_robot();
        let poses: Vec<PoseId> = robot.poses.iter().map(|one| one.id.clone()).collect();
        let (_, factors) = robot.default_factors();
        let baseline = baseline(&robot, "C", factors, &poses);
        let start: Vec<f64> = baseline.parameters().iter().map(|one| one.start).collect();
        let columns = spring_columns(&baseline, &start).unwrap();
        let in_loops = columns.iter().filter(|one| one.loop_stiffness[0] > 1.0);
        assert!(in_loops.count() > 10 && columns.len() > 20);
        let mut solver = baseline.solver(0).unwrap();
        let compliances = |solver: &dyn PoseSolver| -> Vec<[[f64; 6]; 6]> {
            let poses = 0..baseline.poses.len();
            poses
                .map(|pose| solver.pose(pose).influence.compliance)
                .collect()
        };
        solver.solve_for(&start, &[]).unwrap();
        let rigid = compliances(&*solver);
        for column in columns {
            for compliance in [1e-6, 1e-4, 1e-2] {
                let effect = Effect {
                    law: column.law,
                    place: column.place.clone(),
                    values: vec![compliance],
                };
                solver.set_structure(&[effect]).unwrap();
                solver.solve_for(&start, &[]).unwrap();
                let whole = compliances(&*solver);
                for (pose, whole) in whole.iter().enumerate() {
                    let size = compliance / (1.0 + compliance * column.loop_stiffness[pose]);
                    for i in 0..3 {
                        let found = rigid[pose][i][i] + size * column.compliance[pose][i][i];
                        assert!(
                            (found / whole[i][i] - 1.0).abs() < 1e-5,
                            "{}, {compliance}, pose {pose}: {found:e} {:e}",
                            column.place,
                            whole[i][i]
                        );
                    }
                }
            }
        }
    }
}
