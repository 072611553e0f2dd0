//! Readings predicted by the baseline and effects.

use crate::physics::{Effect, Law, LawSet, Place, PoseMechanics, Twists};

use super::baseline::{Baseline, PoseSolver};
use super::error::MismatchError;
use super::observations::Observations;
use super::screen::Frozen;

/// Predicts all readings for parameters and effects; one for each thread.
pub(super) struct ReadingPredictor<'a> {
    baseline: &'a dyn Baseline,
    observations: &'a Observations,
    solvers: Vec<Option<Box<dyn PoseSolver + 'a>>>,
    twists: Twists,
}

impl<'a> ReadingPredictor<'a> {
    pub(super) fn new(baseline: &'a dyn Baseline, observations: &'a Observations) -> Self {
        Self {
            baseline,
            observations,
            solvers: (0..baseline.variants()).map(|_| None).collect(),
            twists: Twists::default(),
        }
    }

    /// The solver of the variant that the effects ask for, solved.
    fn solved(
        &mut self,
        parameters: &[f64],
        effects: &[Effect],
    ) -> Result<Option<usize>, MismatchError> {
        let Some(variant) = self.baseline.variant(effects) else {
            return Ok(None);
        };
        if self.solvers[variant].is_none() {
            self.solvers[variant] = Some(self.baseline.solver(variant)?);
        }
        if let Some(solver) = &mut self.solvers[variant] {
            solver.solve(parameters)?;
        }
        Ok(Some(variant))
    }

    /// Displacements of all readings, m; `false` if there is no such structure.
    pub(super) fn predict(
        &mut self,
        parameters: &[f64],
        effects: &[Effect],
        out: &mut [f64],
    ) -> Result<bool, MismatchError> {
        let Some(variant) = self.solved(parameters, effects)? else {
            return Ok(false);
        };
        let Some(solver) = &self.solvers[variant] else {
            return Ok(false);
        };
        let names;
        let joints: &[String] = if variant == 0 {
            self.baseline.joints()
        } else {
            names = solver.joint_names();
            &names
        };
        let Some(laws) = law_set(joints, effects) else {
            return Ok(false);
        };
        for (index, run) in self.observations.runs.iter().enumerate() {
            let pose = self.observations.cells[run.cell].pose;
            laws.displacements_m(
                solver.pose(pose),
                &self.observations.run_loads(index),
                &mut self.twists,
                &mut out[run.readings.clone()],
            );
        }
        Ok(true)
    }

    /// Compliance of the baseline at each reading along its direction, m/N.
    pub(super) fn compliance(
        &mut self,
        parameters: &[f64],
        effects: &[Effect],
        out: &mut [f64],
    ) -> Result<(), MismatchError> {
        let Some(variant) = self.solved(parameters, effects)? else {
            return Ok(());
        };
        if let Some(solver) = &self.solvers[variant] {
            for cell in &self.observations.cells {
                let axis = cell.direction.index();
                let pose: &PoseMechanics = solver.pose(cell.pose);
                out[cell.readings.clone()].fill(pose.influence.compliance_m_per_n[axis][axis]);
            }
        }
        Ok(())
    }

    /// Derivatives of the baseline's prediction to its parameters, one column of readings after the other, m.
    ///
    /// Those of the linear structure: what an effect adds changes little with them.
    pub(super) fn gradient(
        &mut self,
        parameters: &[f64],
        effects: &[Effect],
        out: &mut [f64],
    ) -> Result<(), MismatchError> {
        let n = self.observations.len();
        let Some(variant) = self.solved(parameters, effects)? else {
            return Ok(());
        };
        if let Some(solver) = &self.solvers[variant] {
            for cell in &self.observations.cells {
                let axis = cell.direction.index();
                let pose = solver.pose(cell.pose);
                for (column, gradient) in out.chunks_mut(n).zip(&pose.compliance_gradient) {
                    for reading in cell.readings.clone() {
                        column[reading] = gradient[axis] * self.observations.loads[reading].force_n;
                    }
                }
            }
        }
        Ok(())
    }

    /// The poses of the structure that effects ask for, as they are now.
    pub(super) fn frozen(
        &mut self,
        parameters: &[f64],
        effects: &[Effect],
    ) -> Result<Frozen, MismatchError> {
        let variant = self.solved(parameters, effects)?.unwrap_or(0);
        let solver = self.solvers[variant].as_ref().ok_or(MismatchError::Empty)?;
        let poses = (0..self.observations.poses.len())
            .map(|pose| solver.pose(pose).clone())
            .collect();
        Ok(Frozen {
            poses,
            joints: solver.joint_names(),
        })
    }
}

/// The laws of effects; `None` if one sits in a joint that is not there.
fn law_set(joints: &[String], effects: &[Effect]) -> Option<LawSet> {
    let mut set = LawSet::default();
    for effect in effects
        .iter()
        .filter(|effect| effect.law != Law::LooseMember)
    {
        let joint = match &effect.place {
            Place::Joint(name) => Some(joints.iter().position(|joint| joint == name)?),
            _ => None,
        };
        set.push(effect, joint);
    }
    Some(set)
}
