//! The candidates of a problem, with what was computed of them already.
//!
//! A second search, with what was found in the gauge's positions, differs from the first in the gauge's periods only. What is kept here would come
//! out the same to the last bit.
//!
//! It stands beside [`crate::search::ScoreEngine`], not behind it: an engine lives as long as one model and knows its columns; what is kept are
//! scores and fits of many models, found by the effects that they hold, which rows and columns do not show.

use std::sync::{Arc, OnceLock};

use stiffbench_beams::physics::Effect;

use super::candidate_scores::ScoredCandidate;
use super::changes::MissingMemberChange;
use super::ranked_candidate::Ranked;
use crate::mismatch::baselines::StructureColumn;
use crate::mismatch::problem::{DiagnosisProblem, Memo, Model, StateKey, once, stands_anywhere};

/// Laws at places, as a problem shows and fits them.
#[derive(Clone, Copy)]
pub(crate) struct Candidates<'s, 'a> {
    pub(crate) problem: &'s DiagnosisProblem<'a>,
    pub(crate) memo: &'s CandidateMemo,
}

impl<'s, 'a> Candidates<'s, 'a> {
    pub(crate) fn new(problem: &'s DiagnosisProblem<'a>, memo: &'s CandidateMemo) -> Self {
        Self { problem, memo }
    }
}

/// What searches that share baseline and readings, but for where the gauge stood, have computed of candidates.
#[derive(Debug, Default)]
pub(crate) struct CandidateMemo {
    seen: Memo<StateKey, Vec<ScoredCandidate>>,
    fitted: Memo<(StateKey, Effect), Option<Ranked>>,
    left_out: Memo<(StateKey, Model), f64>,
    missing_member_changes: OnceLock<Vec<MissingMemberChange>>,
    columns: OnceLock<Arc<[StructureColumn]>>,
}

impl CandidateMemo {
    /// Candidates seen from a state, none of them a period.
    pub(crate) fn seen<E>(
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
    pub(crate) fn fitted<E>(
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

    /// Weighted squares of readings that a model beside a state was not fitted to.
    pub(crate) fn left_out<E>(
        &self,
        key: &StateKey,
        model: &Model,
        work: impl FnOnce() -> Result<f64, E>,
    ) -> Result<f64, E> {
        if !stands_anywhere(&model.effects) {
            return work();
        }
        self.left_out.of(&(key.clone(), model.clone()), work)
    }

    /// What mistakes of the robot file would change.
    pub(crate) fn structure_columns<E>(
        &self,
        work: impl FnOnce() -> Result<Vec<StructureColumn>, E>,
    ) -> Result<Arc<[StructureColumn]>, E> {
        once(&self.columns, || Ok(work()?.into())).cloned()
    }

    /// What loose members would change.
    pub(crate) fn missing_member_changes<E>(
        &self,
        work: impl FnOnce() -> Result<Vec<MissingMemberChange>, E>,
    ) -> Result<&[MissingMemberChange], E> {
        once(&self.missing_member_changes, work).map(Vec::as_slice)
    }
}

#[cfg(test)]
mod tests {
    use stiffbench_beams::robot::Robot;
    use stiffbench_measurement::readings::{SessionHeader, read_readings};
    use stiffbench_test_files::text;
    use stiffbench_units_and_text::source_text::SourceText;

    use super::*;
    use crate::mismatch::candidates::law_search::{Depth, SearchResult};
    use crate::mismatch::observed::Observations;
    use crate::mismatch::problem::{SearchOptions, key_of};
    use crate::search::Evidence;
    use crate::tests::baseline;

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
        let table = read_readings("2b464bf8", readings.as_bytes());
        let observations = Observations::new(&table.unwrap(), Some(&header.header));
        let robot = file("robots/serial-arm-more-poses.toml");
        let robot = Robot::parse(&SourceText::new("robot", robot)).unwrap();
        let factors = robot.factor_set("m_fsd").unwrap();
        let baseline = baseline(&robot, "A", factors, &observations.poses);
        let options = SearchOptions::default();
        let problem = DiagnosisProblem::new(&baseline, &observations);
        let memo = CandidateMemo::default();
        let search = |problem, memo, known| {
            Candidates::new(problem, memo).search(&options, known, Depth::OneByOne)
        };
        let (_, critical) = search(&problem, &memo, None).unwrap();
        let (again, _) = search(&problem, &memo, Some(&critical)).unwrap();
        let anew = DiagnosisProblem::new(&baseline, &observations);
        let (anew, _) = search(&anew, &CandidateMemo::default(), Some(&critical)).unwrap();
        let said_again = said(&again);
        assert!(!said_again.1.is_empty());
        assert_eq!(said_again, said(&anew));
    }
}
