//! What one more effect changes in the readings of a frozen structure.

use std::ops::Range;

use stiffbench_beams::physics::{
    Effect, JointPath, JointRotations, LawAction, LawSet, Place, values_of,
};

use crate::mismatch::noise::groups;
use crate::mismatch::observed::{Observations, ObservedCell};
use crate::mismatch::problem::LinearisedModel;
use crate::search::subtract;

/// What the absence of a member would change in readings of the baseline.
#[derive(Debug)]
pub(crate) struct MissingMemberChange {
    pub(crate) effect: Effect,
    /// With the factors fitted again, m; `None` if the structure without it could not be fitted.
    pub(crate) change_m: Option<Vec<f64>>,
}

/// Readings under effects, and what one more would change in them.
///
/// Most laws at most places add to what the others do, and are computed alone: that the others need not be solved again makes it ten
/// times cheaper. Beside a law that turns a joint already this is exact up to the next kink of that law, and good enough to choose what
/// is fitted in full.
#[derive(Debug)]
pub(crate) struct Changes<'a> {
    observations: &'a Observations,
    linearised: &'a LinearisedModel,
    effects: &'a [Effect],
    laws: LawSet,
    /// Displacements under the effects, m.
    before_m: Vec<f64>,
    /// Where the gauge stood, m.
    stood_m: Vec<f64>,
    /// Readings that share a zero or a run.
    groups: Vec<Range<usize>>,
}

impl<'a> Changes<'a> {
    /// The readings under effects; `None` if one sits in a joint that is not there.
    pub(crate) fn new(
        observations: &'a Observations,
        linearised: &'a LinearisedModel,
        effects: &'a [Effect],
    ) -> Option<Self> {
        let all: Vec<&Effect> = effects.iter().collect();
        let mut before_m = vec![0.0; observations.len()];
        linearised.predict(
            observations,
            &all,
            &mut JointRotations::default(),
            &mut before_m,
        )?;
        let readings = before_m.iter().zip(&observations.loads);
        let stood_m = readings.map(|(before, load)| load.position_m.unwrap_or(*before));
        Some(Self {
            observations,
            linearised,
            effects,
            laws: linearised.laws(&all)?,
            stood_m: stood_m.collect(),
            before_m,
            groups: groups(observations).collect(),
        })
    }

    /// The structure.
    pub(crate) fn linearised(&self) -> &'a LinearisedModel {
        self.linearised
    }

    /// How many readings there are.
    pub(crate) fn readings(&self) -> usize {
        self.before_m.len()
    }

    /// Changes of the readings by one effect more, m.
    ///
    /// # Arguments
    /// - `path`: of its joint, if it has one.
    ///
    /// # Returns
    /// The readings it can change: those of `out` are overwritten, the others are not, and count as zero. `None` if it sits in a joint
    /// that is not there.
    pub(crate) fn of(
        &self,
        effect: &Effect,
        path: Option<&JointPath>,
        joint_rotations: &mut JointRotations,
        out: &mut [f64],
    ) -> Option<Range<usize>> {
        if let Some(readings) = self.after_all_others(effect, out) {
            return Some(readings);
        }
        if let Some(path) = path {
            path.added_m(effect, out);
        } else {
            let mut all: Vec<&Effect> = self.effects.iter().collect();
            if effect.law.changes_structure() {
                let changed = self.linearised.with_mistake(effect)?;
                changed.predict(self.observations, &all, joint_rotations, out)?;
            } else {
                all.push(effect);
                self.linearised
                    .predict(self.observations, &all, joint_rotations, out)?;
            }
            subtract(out, 1.0, &self.before_m);
        }
        Some(0..out.len())
    }

    /// Changes by an effect with a phase, and by the same a quarter of a turn further, m; `None` where they cannot be computed.
    ///
    /// # Arguments
    /// - `phase`: the parameter that is the phase.
    /// - `out`: overwritten.
    pub(crate) fn of_both_phases(
        &self,
        effect: &Effect,
        phase: usize,
        joint_rotations: &mut JointRotations,
        out: [&mut [f64]; 2],
    ) -> Option<()> {
        if let LawAction::Gauge(error) = effect.law.action
            && !self.has_gauge_error()
        {
            let [first, second] = out;
            error.both_phases_m(
                &values_of(&effect.values),
                &self.stood_m,
                [&mut *first, &mut *second],
            );
            self.of_gauge_alone(&effect.place, first);
            self.of_gauge_alone(&effect.place, second);
            return Some(());
        }
        let mut turned = effect.clone();
        *turned.values.get_mut(phase)? += std::f64::consts::FRAC_PI_2;
        let [first, second] = out;
        self.of(effect, None, joint_rotations, first)?;
        self.of(&turned, None, joint_rotations, second)?;
        Some(())
    }

    /// Whether an error of the gauge is among the effects: it depends on where all others put the gauge.
    fn has_gauge_error(&self) -> bool {
        self.effects
            .iter()
            .any(|effect| effect.law.is_gauge_error())
    }

    /// Changes by an effect that acts after all mechanics, with nothing among the others that acts after it.
    ///
    /// # Returns
    /// `None` if the effect is another one, and nothing was written.
    fn after_all_others(&self, effect: &Effect, out: &mut [f64]) -> Option<Range<usize>> {
        if self.has_gauge_error() {
            return None;
        }
        let values = values_of(&effect.values);
        match effect.law.action {
            LawAction::Gauge(error) => {
                for (out, stood_m) in out.iter_mut().zip(&self.stood_m) {
                    *out = error.error_m(&values, *stood_m);
                }
                self.of_gauge_alone(&effect.place, out);
                Some(0..out.len())
            }
            LawAction::History(law) => {
                self.observations.answers(law, &values, out);
                Some(0..out.len())
            }
            LawAction::Added(added_m) => {
                let loads = &self.observations.loads;
                let (range, covered) = self.covered(&effect.place);
                out[range.clone()].fill(0.0);
                for readings in covered {
                    let run = self
                        .observations
                        .run_loads(self.observations.readings[readings.start].run);
                    for reading in readings {
                        out[reading] = added_m(&values, &run.as_read(&loads[reading]));
                    }
                }
                Some(range)
            }
            _ => None,
        }
    }

    /// Takes what an effect at one of several gauges does out of the readings of the others.
    fn of_gauge_alone(&self, place: &Place, out: &mut [f64]) {
        if let Place::DisplacementGauge(Some(axis)) = place {
            let others = self.observations.cells.iter();
            let is_read = |cell: &&ObservedCell| !cell.read.is_rotation() && cell.axis() == *axis;
            for cell in others.filter(|cell| !is_read(cell)) {
                out[cell.readings.clone()].fill(0.0);
            }
        }
    }

    /// The readings that an effect at a place can change: all of them in one range, and the parts of it that it does change.
    fn covered(&self, place: &Place) -> (Range<usize>, Vec<Range<usize>>) {
        let observations = self.observations;
        let all = 0..observations.len();
        match place {
            Place::Run { repeat, step, .. } => {
                let cells = observations.cells.iter();
                let here = cells.filter(|cell| observations.is_cell_of(place, cell));
                let runs = here.flat_map(|cell| &observations.runs[cell.runs.clone()]);
                let from_step = |readings: Range<usize>| {
                    let is_later = |reading: &usize| observations.loads[*reading].step >= *step;
                    readings
                        .filter(is_later)
                        .map(|reading| reading..reading + 1)
                };
                let own = runs.filter(|run| run.repeat == *repeat);
                let covered: Vec<Range<usize>> = own
                    .flat_map(|run| from_step(run.readings.clone()))
                    .collect();
                let (Some(first), Some(last)) = (covered.first(), covered.last()) else {
                    return (0..0, Vec::new());
                };
                let group_of = |reading: usize| {
                    let place = self.groups.partition_point(|group| group.end <= reading);
                    &self.groups[place]
                };
                let range = group_of(first.start).start..group_of(last.start).end;
                (range, covered)
            }
            Place::Direction(axis) | Place::Clock(Some(axis)) => {
                let cells = observations.cells.iter();
                let along = cells.filter(|cell| cell.read == *axis);
                (all, along.map(|cell| cell.readings.clone()).collect())
            }
            _ => (all.clone(), vec![all]),
        }
    }

    /// The path of loads as a joint meets it, on which all laws at that joint are followed; `None` where they have to be solved together
    /// with the others, and for a place that is no joint of the structure.
    pub(crate) fn path(&self, place: &Place) -> Option<JointPath> {
        let joint = self.linearised.joint(place)?;
        let observations = self.observations;
        if observations.beginnings.goes_on {
            return None;
        }
        let mut path = JointPath::default();
        let adds = observations.runs.iter().enumerate().all(|(index, run)| {
            let pose = &self.linearised.poses[observations.cells[run.cell].pose];
            let loads = observations.run_loads(index);
            self.laws.add_to_path(pose, &loads, joint, &mut path)
        });
        adds.then_some(path)
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::mismatch::observed::tests::observations;
    use stiffbench_beams::physics::PoseMechanics;
    use stiffbench_beams::structure::RotationInfluence;
    use stiffbench_numeric::vector::along6;

    /// A pose with two joints that mind each other.
    fn linearised() -> LinearisedModel {
        let mut influence = RotationInfluence::of_one_joint(3e-7, 0.3);
        influence.levers = [[0.3, 0.2, 0.1], [0.1, 0.4, 0.2]].map(along6).to_vec();
        influence.stiffness_nm_per_rad = vec![2e5, 8e4, 8e4, 1e5];
        LinearisedModel {
            poses: vec![PoseMechanics {
                influence,
                ..PoseMechanics::default()
            }],
            joints: ["A3", "A4"]
                .map(|name| Place::Joint(name.to_owned()))
                .to_vec(),
            rocking_axes: Vec::new(),
            columns: Arc::default(),
        }
    }

    fn effect(text: &str) -> Effect {
        text.parse().unwrap()
    }

    /// Changes by the shortest way, and as the difference of two predictions; how many readings differ.
    fn compare(others: &[Effect], text: &str, tolerance_m: f64) -> usize {
        let (observations, linearised) = (observations(), linearised());
        let one = effect(text);
        let predict = |effects: &[&Effect]| {
            let mut out = vec![f64::NAN; observations.len()];
            linearised
                .predict(
                    &observations,
                    effects,
                    &mut JointRotations::default(),
                    &mut out,
                )
                .unwrap();
            out
        };
        let all: Vec<&Effect> = others.iter().collect();
        let before = predict(&all);
        let after = predict(&[&all[..], &[&one]].concat());
        let changes = Changes::new(&observations, &linearised, others).unwrap();
        let path = changes.path(&one.place);
        let mut found = vec![f64::NAN; observations.len()];
        let readings = changes
            .of(
                &one,
                path.as_ref(),
                &mut JointRotations::default(),
                &mut found,
            )
            .unwrap();
        for place in 0..observations.len() {
            let found = if readings.contains(&place) {
                found[place]
            } else {
                0.0
            };
            let expected = after[place] - before[place];
            assert!(
                (found - expected).abs() <= tolerance_m,
                "{text}, reading {place}: {found:e} instead of {expected:e}"
            );
        }
        after.iter().zip(&before).filter(|(a, b)| a != b).count()
    }

    #[test]
    fn every_law_changes_readings_by_the_difference_of_predictions() {
        // Rounding of predictions of tens of micrometres.
        const ROUNDING_M: f64 = 1e-18;
        let linear = [
            effect("joint-compliance@A3:c=5urad/(N*m)"),
            effect("creep@structure:k=0.01 1/decade,t0=1s"),
        ];
        let cases = [
            ("slip@P1.y.2.3:jump=7um", 2),
            (
                "gauge-periodic@displacement:amplitude=3um,period=150um,phase=0.4rad",
                20,
            ),
            ("joint-compliance@A4:c=3urad/(N*m)", 16),
            ("joint-backlash@A4:play=20urad,seat_moment=4N*m", 12),
            ("joint-friction@A4:c=3urad/(N*m),friction_moment=3N*m", 12),
            ("joint-nonlinearity@A4:c=3urad/(N*m),q=0.2urad/(N*m)^2", 16),
            ("gauge-stand-compliance@y:c=1um/N", 8),
        ];
        for (text, changed) in cases {
            assert!(
                compare(&linear, text, ROUNDING_M) >= changed.min(1),
                "{text}"
            );
        }
        for (text, changed) in [cases[0], cases[1]] {
            assert_eq!(compare(&linear, text, ROUNDING_M), changed, "{text}");
        }
    }

    #[test]
    fn beside_play_a_joint_is_exact_up_to_the_next_kink() {
        let play = [effect("joint-backlash@A3:play=2mrad,seat_moment=0N*m")];
        // The play is nowhere taken up: the other joint only sees a softer structure.
        compare(&play, "joint-compliance@A4:c=3urad/(N*m)", 1e-16);
        let full = [effect("joint-backlash@A3:play=1urad,seat_moment=0N*m")];
        compare(
            &full,
            "joint-nonlinearity@A4:c=3urad/(N*m),q=0.2urad/(N*m)^2",
            1e-16,
        );
    }

    #[test]
    fn what_is_not_the_last_to_act_is_predicted_with_all() {
        let period = "gauge-periodic@displacement:amplitude=3um,period=150um,phase=0.4rad";
        compare(&[effect(period)], "slip@P1.y.2.3:jump=7um", 0.0);
        let two = [
            effect("joint-friction@A3:c=3urad/(N*m),friction_moment=3N*m"),
            effect("joint-compliance@A4:c=3urad/(N*m)"),
        ];
        compare(&two, "joint-backlash@A4:play=20urad,seat_moment=4N*m", 0.0);
    }
}
