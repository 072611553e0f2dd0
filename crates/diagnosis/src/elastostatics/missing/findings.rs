//! What was selected, with sizes, rivals and what it leaves of repeats.

use stiffbench_numeric::statistics::{NORMAL_95, f_upper_tail, student_t_quantile};

use crate::search::{
    ForwardProblem, LinearFitted, LinearModel, NotIndependent, WhiteSpace, distinguishable, dot,
    rivals,
};

use super::candidates::{CandidateKind, MissingCandidate};
use super::find::{Basis, LoadCaseProblemOf};
use super::outcome::{LoadCaseFinding, LoadCaseRival};
use crate::elastostatics::problem::LoadCaseModel;

/// Rivals that are printed.
const PRINTED_RIVALS: usize = 4;

/// The problem with what it was made of.
pub(super) struct LoadCaseSearch<'s, 'a> {
    pub(super) model: &'s LoadCaseModel<'a>,
    pub(super) problem: &'s LoadCaseProblemOf<'s>,
    pub(super) candidates: &'s [MissingCandidate],
    pub(super) basis: &'s Basis,
    /// Whether the scatter is that of repeats.
    pub(super) from_repeats: bool,
    /// Of simulated noise.
    pub(super) seed: u64,
}

impl LoadCaseSearch<'_, '_> {
    /// The white space of a model, its columns projected out, under the covariance of it or another.
    pub(super) fn space_under(&self, model: &LinearModel, other: &LinearModel) -> WhiteSpace {
        let terms = model
            .terms
            .iter()
            .map(|&term| &self.candidates[term].column);
        let all: Vec<Vec<f64>> = self.basis.columns.iter().chain(terms).cloned().collect();
        WhiteSpace::new(other.covariance.clone(), &[], &all)
    }

    /// Everything that was selected.
    pub(super) fn findings(
        &self,
        model: &LinearModel,
    ) -> Result<Vec<LoadCaseFinding>, NotIndependent> {
        let terms = model.terms.iter().enumerate();
        terms
            .map(|(place, &term)| self.finding(model, place, term))
            .collect()
    }

    fn finding(
        &self,
        model: &LinearModel,
        place: usize,
        term: usize,
    ) -> Result<LoadCaseFinding, NotIndependent> {
        let candidate = &self.candidates[term];
        let value = model.fit.values[self.basis.columns.len() + place];
        let standard_error = model.fit.standard_errors[self.basis.columns.len() + place];
        let t = student_t_quantile(0.975, model.dof).unwrap_or(NORMAL_95);
        let [lowest, highest] = candidate.bounds;
        let ranked = rivals(self.problem, model, place)?;
        let own = ranked
            .iter()
            .find(|one| self.problem.is_term(model, place, one));
        let log_bayes = own.map_or(0.0, |own| self.problem.evidence(own).log_bayes());
        let (alternatives, rivals) = self.rivals_of(model, place, log_bayes, &ranked)?;
        let rows = self.model.posed.rows().zip(&candidate.column);
        let displacements = rows.filter(|((_, read), _)| !read.is_rotation());
        Ok(LoadCaseFinding {
            name: candidate.name.clone(),
            law: candidate.law,
            place: candidate.place.clone(),
            is_set_up: candidate.kind == CandidateKind::SetUp,
            value,
            standard_error,
            interval_95: [
                (value - t * standard_error).max(lowest),
                (value + t * standard_error).min(highest),
            ],
            unit: candidate.unit,
            end_effect_m: displacements
                .map(|(_, slope)| (slope * value).abs())
                .fold(0.0, f64::max),
            standard_errors: (value / standard_error).abs(),
            log_bayes,
            alternatives,
            rivals,
        })
    }

    /// Candidates in the place of a term: those that cannot be distinguished from it, and the nearest that can.
    fn rivals_of(
        &self,
        model: &LinearModel,
        place: usize,
        log_bayes: f64,
        ranked: &[LinearFitted],
    ) -> Result<(Vec<LoadCaseRival>, Vec<LoadCaseRival>), NotIndependent> {
        let rest = self.problem.without(model, place)?;
        let space = self.space_under(&rest, model);
        let own = space.projected(&self.candidates[model.terms[place]].column);
        let cosine = |column: &[f64]| {
            let other = space.projected(column);
            let lengths = dot(&own, &own).sqrt() * dot(&other, &other).sqrt();
            dot(&own, &other) / lengths.max(f64::MIN_POSITIVE)
        };
        let (mut alternatives, mut others) = (Vec::new(), Vec::new());
        for one in ranked {
            let Some(term) = one.candidate().filter(|term| !model.terms.contains(term)) else {
                continue;
            };
            let candidate = &self.candidates[term];
            let behind = log_bayes - self.problem.evidence(one).log_bayes();
            let cosine = cosine(&candidate.column);
            let rival = LoadCaseRival {
                name: candidate.name.clone(),
                place: candidate.place.clone(),
                log_bayes_to_winner: behind,
                cosine,
            };
            let evidence = self.problem.evidence(one);
            if !distinguishable(behind, cosine * cosine)
                && evidence.delta_chi2 > evidence.critical_value
            {
                alternatives.push(rival);
            } else if others.len() < PRINTED_RIVALS {
                others.push(rival);
            }
        }
        Ok((alternatives, others))
    }

    /// Chance of the residuals beside the scatter of repeats.
    pub(super) fn lack_of_fit(&self, model: &LinearModel) -> Option<f64> {
        let parameters = self.basis.columns.len() + model.terms.len();
        let dof = self.basis.residuals.len() as f64 - parameters as f64;
        let more = dof - model.dof;
        let lack = (model.fit.squares - model.dof).max(0.0) / more;
        f_upper_tail(lack, more, model.dof).filter(|_| more >= 1.0)
    }
}
