//! One structure, solved: what laws make of its readings without solving it again.

use std::sync::Arc;

use stiffbench_beams::physics::{Effect, JointRotations, LawSet, Place, PoseMechanics};
use stiffbench_units_and_text::test_point::Direction;

use crate::mismatch::baselines::StructureColumn;
use crate::mismatch::observed::Observations;
use crate::search::{largest, subtract};

/// The solved poses of one structure, shared by all threads.
#[derive(Debug, Clone, Default)]
pub(crate) struct LinearisedModel {
    pub(crate) poses: Vec<PoseMechanics>,
    pub(crate) joints: Vec<Place>,
    /// Axes about which the base may rock.
    pub(crate) rocking_axes: Vec<Direction>,
    /// What mistakes of the robot file would change.
    pub(crate) columns: Arc<[StructureColumn]>,
}

impl LinearisedModel {
    /// Displacements of all readings under effects, m; `None` if one sits in a joint that is not there.
    pub(crate) fn predict(
        &self,
        observations: &Observations,
        effects: &[&Effect],
        joint_rotations: &mut JointRotations,
        out: &mut [f64],
    ) -> Option<()> {
        let laws = self.laws(effects)?;
        for (index, run) in observations.runs.iter().enumerate() {
            let pose = &self.poses[observations.cells[run.cell].pose];
            observations.displacements_of_run_m(
                (&laws, pose),
                index,
                joint_rotations,
                &mut out[run.readings.clone()],
            );
        }
        let mut answers = vec![0.0; out.len()];
        let remembers = |effect: &&&Effect| effect.law.history().is_some();
        for effect in effects.iter().filter(remembers) {
            observations.answers_to(effect, &mut answers);
            for (value, answer) in out.iter_mut().zip(&answers) {
                *value += answer;
            }
        }
        Some(())
    }

    /// The laws of effects; `None` if one sits in a joint that is not there.
    pub(crate) fn laws(&self, effects: &[&Effect]) -> Option<LawSet> {
        Some(law_set(&self.joints, effects.iter().copied())?.0)
    }

    /// The structure with a mistake of the robot file put right, to the first order, or with a spring that it lacks; `None` for what is not
    /// known.
    pub(crate) fn with_mistake(&self, effect: &Effect) -> Option<Self> {
        let mut columns = self.columns.iter();
        let column =
            columns.find(|column| column.law == effect.law && column.place == effect.place)?;
        let size = *effect.values.first()?;
        let mut changed = self.clone();
        let poses = changed.poses.iter_mut().zip(&column.compliance);
        for (index, (pose, change)) in poses.enumerate() {
            let stiffness = column.loop_stiffness.get(index).copied().unwrap_or(0.0);
            let size = size / (1.0 + size * stiffness);
            let rows = pose.influence.compliance.iter_mut().zip(change);
            for (compliance, change) in rows.flat_map(|(row, change)| row.iter_mut().zip(change)) {
                *compliance += size * change;
            }
            let unloaded = column.unloaded.get(index).copied().unwrap_or_default();
            for (motion, change) in pose.unloaded.motion.iter_mut().zip(unloaded) {
                *motion += size * change;
            }
        }
        Some(changed)
    }

    pub(crate) fn joint(&self, place: &Place) -> Option<usize> {
        self.joints.iter().position(|joint| joint == place)
    }
}

/// Largest change of a reading by the last effect of a model, m.
pub(crate) fn end_effect_m(
    linearised: &LinearisedModel,
    observations: &Observations,
    effects: &[Effect],
) -> f64 {
    let all: Vec<&Effect> = effects.iter().collect();
    let without = &all[..all.len().saturating_sub(1)];
    let n = observations.len();
    let (mut with, mut rest) = (vec![0.0; n], vec![0.0; n]);
    let mut joint_rotations = JointRotations::default();
    let known = linearised
        .predict(observations, &all, &mut joint_rotations, &mut with)
        .and_then(|()| linearised.predict(observations, without, &mut joint_rotations, &mut rest));
    known.map_or(0.0, |()| {
        subtract(&mut with, 1.0, &rest);
        largest(&with)
    })
}

/// The laws of effects, and the joints that they turn; `None` if one sits in a joint that is not there.
pub(crate) fn law_set<'e>(
    joints: &[Place],
    effects: impl IntoIterator<Item = &'e Effect>,
) -> Option<(LawSet, Vec<usize>)> {
    let mut set = LawSet::default();
    let mut turning = Vec::new();
    let acting = effects.into_iter();
    for effect in acting.filter(|effect| !effect.law.changes_structure()) {
        let joint = match effect.place.joint() {
            Some(_) => Some(joints.iter().position(|joint| *joint == effect.place)?),
            None => None,
        };
        turning.extend(joint);
        set.push(effect, joint);
    }
    Some((set, turning))
}
