//! Readings predicted by the baseline and effects.

use std::sync::{Arc, Mutex, PoisonError};

use stiffbench_beams::physics::{Effect, JointRotations, Place, PoseMechanics};

use super::linearised::{LinearisedModel, law_set};
use crate::mismatch::baselines::{Baseline, PoseSolver};
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::ReadForces;
use crate::mismatch::observed::Observations;

/// A solver of whatever baseline.
type AnySolver<'a> = Box<dyn PoseSolver + 'a>;

/// Solvers that no predictor uses at the moment, of each variant: to lay out a structure costs as much as several solutions.
#[derive(Default)]
pub(crate) struct IdleSolvers<'a>(Mutex<Vec<Vec<AnySolver<'a>>>>);

impl<'a> IdleSolvers<'a> {
    fn take(&self, variant: usize) -> Option<AnySolver<'a>> {
        let mut idle = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        idle.get_mut(variant)?.pop()
    }

    fn give_back(&self, solvers: &mut [Option<AnySolver<'a>>]) {
        let mut idle = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if idle.len() < solvers.len() {
            idle.resize_with(solvers.len(), Vec::new);
        }
        for (idle, solver) in idle.iter_mut().zip(solvers) {
            idle.extend(solver.take());
        }
    }
}

/// Predicts all readings for parameters and effects; one for each thread.
pub(crate) struct ReadingPredictor<'a> {
    baseline: &'a dyn Baseline,
    observations: &'a Observations,
    solvers: Vec<Option<AnySolver<'a>>>,
    /// Where its solvers come from and go to.
    idle: Arc<IdleSolvers<'a>>,
    joint_rotations: JointRotations,
    /// Poses whose joints act as they are there, not as the factors have them.
    held: Option<Vec<PoseMechanics>>,
    last: LastAnswers,
}

/// What a part was predicted to do last: a derivative moves one value of one effect, and all else answers as before.
#[derive(Default)]
struct LastAnswers {
    /// Parameters, and effects without a history, with the displacements under them.
    mechanics: Option<(Vec<f64>, Vec<Effect>, Vec<f64>)>,
    /// Of each effect with a history the last two, the later first, with what they answered.
    of_effects: Vec<[(Option<Effect>, Vec<f64>); 2]>,
}

impl LastAnswers {
    /// What the place-th effect with a history answers.
    fn of(&mut self, place: usize, effect: &Effect, observations: &Observations) -> &[f64] {
        if self.of_effects.len() <= place {
            self.of_effects.resize_with(place + 1, Default::default);
        }
        let both = &mut self.of_effects[place];
        let is_it = |one: &(Option<Effect>, Vec<f64>)| one.0.as_ref() == Some(effect);
        let known = both.iter().position(is_it);
        let (known, answers) = &mut both[known.unwrap_or(1)];
        if known.as_ref() != Some(effect) {
            answers.resize(observations.len(), 0.0);
            observations.answers_to(effect, answers);
            *known = Some(effect.clone());
        }
        both.sort_by_key(|one| !is_it(one));
        &both[0].1
    }
}

impl Drop for ReadingPredictor<'_> {
    fn drop(&mut self) {
        self.idle.give_back(&mut self.solvers);
    }
}

impl<'a> ReadingPredictor<'a> {
    pub(crate) fn new(
        baseline: &'a dyn Baseline,
        observations: &'a Observations,
        idle: Arc<IdleSolvers<'a>>,
    ) -> Self {
        Self {
            baseline,
            observations,
            solvers: (0..baseline.variants()).map(|_| None).collect(),
            idle,
            joint_rotations: JointRotations::default(),
            held: None,
            last: LastAnswers::default(),
        }
    }

    /// From now on twists act as in a frozen structure, whatever the factors; again as the factors have it with `None`.
    ///
    /// What twists do changes little with the factors, and to work it out is most of the work of a prediction.
    pub(crate) fn hold_joints(&mut self, linearised: Option<&LinearisedModel>) {
        self.held = linearised.map(|linearised| linearised.poses.clone());
        self.last.mechanics = None;
    }

    /// From now on twists act as in the structure of parameters and effects.
    pub(crate) fn hold_joints_as_at(
        &mut self,
        parameters: &[f64],
        effects: &[Effect],
    ) -> Result<(), MismatchError> {
        let count = self.observations.poses.len();
        let Some((_, solver)) = self.solver(effects)? else {
            return Ok(());
        };
        if let Some((_, turning)) = law_set(&solver.joints(), effects) {
            solver.solve_for(parameters, &turning)?;
            self.held = Some((0..count).map(|pose| solver.pose(pose).clone()).collect());
            self.last.mechanics = None;
        }
        Ok(())
    }

    /// The solver of the variant that the effects ask for.
    fn solver(
        &mut self,
        effects: &[Effect],
    ) -> Result<Option<(usize, &mut AnySolver<'a>)>, MismatchError> {
        let Some(variant) = self.baseline.variant(effects) else {
            return Ok(None);
        };
        let place = &mut self.solvers[variant];
        if place.is_none() {
            *place = self.idle.take(variant);
        }
        if place.is_none() {
            let mut solver = self.baseline.solver(variant)?;
            if self
                .observations
                .cells
                .iter()
                .any(|cell| !cell.is_along_load())
            {
                solver.differentiate_whole()?;
            }
            *place = Some(solver);
        }
        if let Some(solver) = place {
            solver.set_structure(effects)?;
        }
        Ok(place.as_mut().map(|solver| (variant, solver)))
    }

    /// The solver of effects, its compliances and gradients solved, no joint; `None` if the structure is not there.
    fn solved(
        &mut self,
        parameters: &[f64],
        effects: &[Effect],
    ) -> Result<Option<&AnySolver<'a>>, MismatchError> {
        let Some((_, solver)) = self.solver(effects)? else {
            return Ok(None);
        };
        solver.solve_for(parameters, &[])?;
        Ok(Some(solver))
    }

    /// Displacements of all readings, m; `false` if there is no such structure.
    pub(crate) fn predict(
        &mut self,
        parameters: &[f64],
        effects: &[Effect],
        out: &mut [f64],
    ) -> Result<bool, MismatchError> {
        let observations = self.observations;
        if observations.histories.is_empty() {
            return self.mechanics(parameters, effects, out);
        }
        let (remembering, others): (Vec<_>, Vec<_>) = effects
            .iter()
            .cloned()
            .partition(|effect| effect.law.history().is_some());
        match &self.last.mechanics {
            Some((known, of, displacements)) if known == parameters && *of == others => {
                out.copy_from_slice(displacements);
            }
            _ => {
                if !self.mechanics(parameters, effects, out)? {
                    return Ok(false);
                }
                self.last.mechanics = Some((parameters.to_vec(), others, out.to_vec()));
            }
        }
        for (place, effect) in remembering.iter().enumerate() {
            let answers = self.last.of(place, effect, observations);
            for (value, answer) in out.iter_mut().zip(answers) {
                *value += answer;
            }
        }
        Ok(true)
    }

    /// What robots or the lines of parts do, without effects that remember what a part went through.
    fn mechanics(
        &mut self,
        parameters: &[f64],
        effects: &[Effect],
        out: &mut [f64],
    ) -> Result<bool, MismatchError> {
        let baseline = self.baseline;
        let is_held = self.held.is_some();
        let Some((variant, solver)) = self.solver(effects)? else {
            return Ok(false);
        };
        let names;
        let joints: &[Place] = if variant == 0 {
            baseline.joints()
        } else {
            names = solver.joints();
            &names
        };
        let Some((laws, turning)) = law_set(joints, effects) else {
            return Ok(false);
        };
        let asked_for = if is_held { &[] } else { &turning[..] };
        solver.solve_for(parameters, asked_for)?;
        let Some(solver) = &self.solvers[variant] else {
            return Ok(false);
        };
        for (index, held) in self.held.iter_mut().flatten().enumerate() {
            let now = solver.pose(index);
            held.influence.compliance = now.influence.compliance;
            held.unloaded.motion = now.unloaded.motion;
        }
        for (index, run) in self.observations.runs.iter().enumerate() {
            let pose = self.observations.cells[run.cell].pose;
            let mechanics = match &self.held {
                Some(held) => &held[pose],
                None => solver.pose(pose),
            };
            self.observations.displacements_of_run_m(
                (&laws, mechanics),
                index,
                &mut self.joint_rotations,
                &mut out[run.readings.clone()],
            );
        }
        Ok(true)
    }

    /// Compliance of the baseline at each reading along its direction, m/N.
    pub(crate) fn compliance(
        &mut self,
        parameters: &[f64],
        effects: &[Effect],
        out: &mut [f64],
    ) -> Result<(), MismatchError> {
        let observations = self.observations;
        if let Some(solver) = self.solved(parameters, effects)? {
            for cell in &observations.cells {
                out[cell.readings.clone()].fill(cell.compliance(solver.pose(cell.pose)));
            }
        }
        Ok(())
    }

    /// Displacement per component of the force along x, y, z of the base at each reading, m/N; zero of a component that was not read.
    pub(crate) fn force_components(
        &mut self,
        parameters: &[f64],
        effects: &[Effect],
    ) -> Result<Vec<[f64; 3]>, MismatchError> {
        let observations = self.observations;
        let mut out = vec![[0.0; 3]; observations.len()];
        if let Some(solver) = self.solved(parameters, effects)? {
            let wrenches = observations.cells.iter().map(|cell| cell.load.wrench());
            let read = ReadForces::of(wrenches);
            for cell in &observations.cells {
                let pose = solver.pose(cell.pose);
                let components = read.components(cell.load.wrench());
                let moved = pose.compliance_by_components(&cell.read, components);
                for reading in cell.readings.clone() {
                    if observations.loads[reading].force_n != 0.0 {
                        out[reading] = moved;
                    }
                }
            }
        }
        Ok(out)
    }

    /// Derivatives of the baseline's prediction to its parameters, one column of readings after the other, m.
    ///
    /// Those of the linear structure: what an effect adds changes little with them.
    pub(crate) fn gradient(
        &mut self,
        parameters: &[f64],
        effects: &[Effect],
        out: &mut [f64],
    ) -> Result<(), MismatchError> {
        let observations = self.observations;
        if let Some(solver) = self.solved(parameters, effects)? {
            for cell in &observations.cells {
                let pose = solver.pose(cell.pose);
                for (parameter, column) in out.chunks_mut(observations.len()).enumerate() {
                    let gradient = pose.gradient(parameter, &cell.read, &cell.load);
                    let unloaded = pose.unloaded_gradient(parameter, &cell.read);
                    for reading in cell.readings.clone() {
                        let force_n = observations.loads[reading].force_n;
                        column[reading] = gradient * force_n + unloaded;
                    }
                }
            }
        }
        Ok(())
    }

    /// The poses of the structure that effects ask for, as they are now.
    pub(crate) fn linearised(
        &mut self,
        parameters: &[f64],
        effects: &[Effect],
    ) -> Result<LinearisedModel, MismatchError> {
        let known: &[Effect] = match self.baseline.variant(effects) {
            Some(_) => effects,
            None => &[],
        };
        let count = self.observations.poses.len();
        let (_, solver) = self.solver(known)?.ok_or(MismatchError::Empty)?;
        solver.solve(parameters)?;
        let poses = (0..count).map(|pose| solver.pose(pose).clone()).collect();
        Ok(LinearisedModel {
            poses,
            joints: solver.joints(),
            rocking_axes: self.baseline.rocking_axes(),
            columns: Arc::default(),
        })
    }
}
