//! What a search has computed already.
//!
//! A search asks the same of the same model again and again: to swap an effect, to weigh it, to list its rivals; and a second search,
//! with what was found in the gauge's positions, differs from the first in the gauge's periods only. What is kept here would come out the
//! same to the last bit, but for the noise of the first model, from which other models are only given a start.
//!
//! It stands beside [`crate::search::ScoreEngine`], not behind it: an engine lives as long as one model and knows its columns; what is kept are
//! fits and noises of many models, found by the effects that they hold, which rows and columns do not show.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use stiffbench_beams::physics::Effect;

use super::baseline::StructureColumn;
use super::candidate_scores::ScoredCandidate;
use super::changes::MissingMemberChange;
use super::estimated_noise::EstimatedNoise;
use super::known_noise::KnownNoise;
use super::model::Model;
use super::place_scales::PlaceScales;
use super::ranked_candidate::Ranked;
use super::reading_noise::ReadingNoise;
use super::state::State;

/// Results of searches that share baseline and readings, but for where the gauge stood.
#[derive(Debug, Default)]
pub(super) struct SearchMemo {
    models: Memo<(Model, KnownNoise), Option<State>>,
    seen: Memo<StateKey, Vec<ScoredCandidate>>,
    fitted: Memo<(StateKey, Effect), Option<Ranked>>,
    noise: OnceLock<ReadingNoise>,
    missing_member_changes: OnceLock<Vec<MissingMemberChange>>,
    scales: OnceLock<PlaceScales>,
    columns: OnceLock<Arc<[StructureColumn]>>,
}

/// What distinguishes a state from others under the same readings.
pub(super) type StateKey = (Model, EstimatedNoise);

/// The key of a state.
pub(super) fn key_of(state: &State) -> StateKey {
    (state.fitted.model.clone(), state.noise)
}

/// Whether nothing depends on where the gauge stood.
fn stands_anywhere(effects: &[Effect]) -> bool {
    effects.iter().all(|effect| !effect.law.is_gauge_error())
}

impl SearchMemo {
    /// A fitted model with its noise; computed with `work` if it is not known.
    pub(super) fn model<E>(
        &self,
        start: Model,
        noise: KnownNoise,
        work: impl FnOnce(Model) -> Result<Option<State>, E>,
    ) -> Result<Option<State>, E> {
        if !stands_anywhere(&start.effects) {
            return work(start);
        }
        let key = (start.clone(), noise);
        self.models.of(&key, || work(start))
    }

    /// Candidates seen from a state, none of them a period.
    pub(super) fn seen<E>(
        &self,
        key: &StateKey,
        work: impl FnOnce() -> Result<Vec<ScoredCandidate>, E>,
    ) -> Result<Vec<ScoredCandidate>, E> {
        if !stands_anywhere(&key.0.effects) {
            return work();
        }
        self.seen.of(key, work)
    }

    /// A candidate fitted from a state, by the effect that it starts with.
    pub(super) fn fitted<E>(
        &self,
        key: &StateKey,
        start: &Effect,
        work: impl FnOnce() -> Result<Option<Ranked>, E>,
    ) -> Result<Option<Ranked>, E> {
        if !stands_anywhere(&key.0.effects) || start.law.is_gauge_error() {
            return work();
        }
        self.fitted.of(&(key.clone(), start.clone()), work)
    }

    /// The noise that the first model left, where the search for that of others starts.
    pub(super) fn noise(&self) -> Option<&ReadingNoise> {
        self.noise.get()
    }

    /// Keeps a noise, if it is the first.
    pub(super) fn keep_noise(&self, noise: ReadingNoise) {
        self.noise.get_or_init(|| noise);
    }

    /// What the loads make of places.
    pub(super) fn scales(&self, work: impl FnOnce() -> PlaceScales) -> &PlaceScales {
        self.scales.get_or_init(work)
    }

    /// What mistakes of the robot file would change.
    pub(super) fn structure_columns<E>(
        &self,
        work: impl FnOnce() -> Result<Vec<StructureColumn>, E>,
    ) -> Result<Arc<[StructureColumn]>, E> {
        once(&self.columns, || Ok(work()?.into())).cloned()
    }

    /// What loose members would change.
    pub(super) fn missing_member_changes<E>(
        &self,
        work: impl FnOnce() -> Result<Vec<MissingMemberChange>, E>,
    ) -> Result<&[MissingMemberChange], E> {
        once(&self.missing_member_changes, work).map(Vec::as_slice)
    }
}

/// Values by key, in the order in which they came: they are few.
#[derive(Debug)]
struct Memo<K, V>(Mutex<Vec<(K, Arc<V>)>>);

impl<K, V> Default for Memo<K, V> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<K: PartialEq + Clone, V: Clone> Memo<K, V> {
    fn of<E>(&self, key: &K, work: impl FnOnce() -> Result<V, E>) -> Result<V, E> {
        let kept = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let find = |kept: &[(K, Arc<V>)]| {
            let mut known = kept.iter().filter(|(known, _)| known == key);
            known.next().map(|(_, value)| Arc::clone(value))
        };
        let known = find(&kept());
        if let Some(known) = known {
            return Ok((*known).clone());
        }
        // Not under the lock: others work on other keys meanwhile.
        let value = Arc::new(work()?);
        kept().push((key.clone(), Arc::clone(&value)));
        Ok((*value).clone())
    }
}

/// A value that is worked out once.
fn once<T, E>(kept: &OnceLock<T>, work: impl FnOnce() -> Result<T, E>) -> Result<&T, E> {
    if let Some(known) = kept.get() {
        return Ok(known);
    }
    let value = work()?;
    Ok(kept.get_or_init(|| value))
}

#[cfg(test)]
mod tests {
    use stiffbench_beams::robot::Robot;
    use stiffbench_measurement::readings::{ReadOptions, SessionHeader, read_readings};
    use stiffbench_test_files::text;
    use stiffbench_units_and_text::source_text::SourceText;

    use super::*;
    use crate::mismatch::observations::Observations;
    use crate::mismatch::options::SearchOptions;
    use crate::mismatch::problem::DiagnosisProblem;
    use crate::mismatch::robot_baseline::RobotBaseline;
    use crate::mismatch::search::SearchResult;
    use crate::parameters::ParameterChoice;
    use crate::search::Evidence;

    /// The model that a search ends with, and for each of its effects the ranked candidates.
    type Said = (StateKey, Vec<Vec<(Effect, Evidence)>>);

    fn said(found: &SearchResult) -> Said {
        let ranked = |ranked: &Vec<Ranked>| {
            let each = ranked.iter();
            each.map(|one| (one.effect.clone(), one.evidence)).collect()
        };
        let resolved = found.resolved.iter();
        (
            key_of(&found.after),
            resolved.map(|one| ranked(&one.ranked)).collect(),
        )
    }

    #[test]
    fn a_search_that_remembers_ends_as_one_that_does_not() {
        let file = |path: &str| text(&format!("data/concealed/{path}"));
        let header = file("sessions/2b464bf8/session.toml");
        let header = SessionHeader::from_toml("session.toml", header).unwrap();
        let readings = file("sessions/2b464bf8/readings.csv");
        let table = read_readings("2b464bf8", readings.as_bytes(), &ReadOptions::default());
        let observations = Observations::new(&table.unwrap(), Some(&header.header));
        let robot = file("robots/serial-arm-more-poses.toml");
        let robot = Robot::parse(&SourceText::new("robot", robot)).unwrap();
        let poses = observations.poses.iter();
        let baseline = RobotBaseline::new(
            &robot,
            robot.mechanism(Some("A")).unwrap(),
            robot.factor_set("m_fsd").unwrap(),
            poses
                .map(|pose| robot.pose(pose).unwrap().clone())
                .collect(),
            &ParameterChoice::default(),
        )
        .unwrap();
        let options = SearchOptions::default();
        let bench = DiagnosisProblem::new(&baseline, &observations);
        let (_, critical) = bench.search(&options, None).unwrap();
        let (again, _) = bench.search(&options, Some(&critical)).unwrap();
        let anew = DiagnosisProblem::new(&baseline, &observations);
        let (anew, _) = anew.search(&options, Some(&critical)).unwrap();
        let said_again = said(&again);
        assert!(!said_again.1.is_empty());
        assert_eq!(said_again, said(&anew));
    }
}
