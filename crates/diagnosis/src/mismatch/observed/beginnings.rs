//! How the runs of a recording begin: each virgin, or as what came before left the part or the joints.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiffbench_beams::physics::{
    JointRotations, LawSet, LoadPoint, PoseMechanics, RunLoads, TestObject,
};

use super::observations::Observations;
use super::recorded_history::RecordedHistory;

/// What came before the readings.
///
/// Sliders, plays and springs with dampers begin in a state that was not recorded. Any state of theirs is what one load leaves that they were
/// taken to from their virgin state.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct Beginnings {
    /// Whether runs go on as the run before left them, also where the clock begins again or the gauge was zeroed between them.
    pub goes_on: bool,
    /// For each stretch of readings that goes on without a gap the load to which the part was taken before, in the unit of what was set; `None`
    /// where it begins virgin. Empty where all do.
    pub loaded_to: Vec<Option<f64>>,
}

impl Beginnings {
    /// Whether everything begins virgin.
    #[must_use]
    pub fn are_virgin(&self) -> bool {
        *self == Self::default()
    }

    /// What is assumed of the beginnings, a sentence each; none where everything begins virgin.
    ///
    /// # Arguments
    /// - `load`: a load in words, with its unit.
    #[must_use]
    pub fn in_words(&self, load: impl Fn(f64) -> String) -> Vec<String> {
        let goes_on = self.goes_on.then(|| {
            "Runs go on as the run before left them, although a clock begins again or a gauge was zeroed between them; the pause counts as none."
                .to_owned()
        });
        let count = self.loaded_to.len();
        let mut loads: Vec<f64> = self.loaded_to.iter().flatten().copied().collect();
        loads.sort_by(f64::total_cmp);
        let range = match loads[..] {
            [] => None,
            [only] => Some(load(only)),
            [least, .., most] => Some(format!("{} to {}", load(least), load(most))),
        };
        let begun = range.map(|range| {
            let stretches = if count == 1 {
                "The recording does not begin virgin: it goes on".to_owned()
            } else {
                format!(
                    "{} of {count} stretches of readings do not begin virgin: they go on",
                    loads.len()
                )
            };
            format!("{stretches} as after a load of {range} that was not recorded.")
        });
        goes_on.into_iter().chain(begun).collect()
    }

    /// How many stretches do not begin virgin.
    pub(crate) fn loaded(&self) -> usize {
        self.loaded_to.iter().flatten().count()
    }
}

impl Observations {
    /// The same readings with other beginnings.
    pub(crate) fn with_beginnings(&self, beginnings: Beginnings) -> Self {
        let mut out = self.clone();
        if self.object != TestObject::Robot {
            let mut histories = RecordedHistory::of_runs(self, beginnings.goes_on);
            for history in &mut histories {
                history.take_size_of(&self.histories);
            }
            for (history, load) in histories.iter_mut().zip(&beginnings.loaded_to) {
                if let Some(load) = load {
                    history.begin_at(*load);
                }
            }
            out.histories = histories;
        } else if beginnings.goes_on {
            for next in 1..out.runs.len() {
                let [before, run] = [&self.runs[next - 1], &self.runs[next]];
                out.runs[next].goes_on =
                    before.cell == run.cell && before.session_run + 1 == run.session_run;
            }
        }
        out.beginnings = beginnings;
        out
    }

    /// Displacements of a run under laws, m; runs come in their order.
    ///
    /// # Arguments
    /// - `joint_rotations`: as the run before left them.
    /// - `out`: one a reading of the run, overwritten.
    pub(crate) fn displacements_of_run_m(
        &self,
        (laws, pose): (&LawSet, &PoseMechanics),
        run: usize,
        joint_rotations: &mut JointRotations,
        out: &mut [f64],
    ) {
        let loads = self.run_loads(run);
        let first_of_cell = run == 0 || self.runs[run - 1].cell != self.runs[run].cell;
        if !self.runs[run].goes_on || first_of_cell {
            laws.displacements_m(pose, &loads, joint_rotations, out);
            return;
        }
        let zero_of = |run: usize| self.readings[self.runs[run].readings.start].zero;
        let mut left_m = 0.0;
        if zero_of(run) != zero_of(run - 1) {
            // A gauge that is zeroed on what the run before left counts from there.
            let unloaded = [LoadPoint::release(0.0)];
            let at_zero = RunLoads {
                loads: &unloaded,
                ..loads
            };
            let (mut left, mut virgin) = ([0.0], [0.0]);
            laws.go_on_m(pose, &at_zero, joint_rotations, &mut left);
            laws.displacements_m(pose, &at_zero, &mut JointRotations::default(), &mut virgin);
            left_m = left[0] - virgin[0];
        }
        laws.go_on_m(pose, &loads, joint_rotations, out);
        for displacement in out {
            *displacement -= left_m;
        }
    }
}
