//! Stiffness values as a problem of the search: logarithms of stiffness as rows, beam factors as the baseline, linear laws as candidates.
//!
//! Laws are scored linearly at the fitted factors, and each is fitted in full, factors and size. All rows scatter alike; how much is estimated
//! from what a model leaves, in the null samples as in the values.

use std::convert::Infallible;

use stiffbench_beams::physics::{Mechanics, PoseMechanics};
use stiffbench_diagnosis::search::{
    Batched, Covariance, CriticalValues, Evidence, ForwardProblem, LinearCandidate, NULL_SAMPLES,
    NullNoise, ScoreEngine, WhiteSpace, distinguishable, dot, norm, null_maxima,
};
use stiffbench_units_and_text::test_point::Direction;

use super::error::ProveError;
use super::linear_model::{LinearFit, LinearLaw, ListedStiffness, StiffnessProblem, compliance};

/// Level of the search over all laws.
const LEVEL: f64 = 0.04;

/// All laws share one critical value.
const LAWS: &str = "linear laws";

/// The rows, the columns of every law, and all that was fitted to the rows.
pub(super) struct StiffnessSearch {
    rows: usize,
    /// White where every row scatters by 1, the beam factors projected out.
    space: WhiteSpace,
    /// What the factors alone leave, white and projected.
    residual: Vec<f64>,
    candidates: Vec<LinearCandidate<&'static str>>,
    critical_values: CriticalValues<&'static str>,
    /// Squares that the factors alone leave.
    start: f64,
    /// Squares that each law leaves beside the factors, and its effect on the rows, white and projected.
    fitted: Vec<(f64, Vec<f64>)>,
}

/// Beam factors with one law at most, and the variance of the rows.
#[derive(Debug, Clone, Copy)]
pub(super) struct StiffnessModel {
    /// Number of the law.
    pub(super) law: Option<usize>,
    variance: f64,
}

/// A law fitted beside the factors.
#[derive(Debug, Clone, Copy)]
pub(super) struct FittedCandidate {
    /// Its number.
    pub(super) law: usize,
    evidence: Evidence,
}

impl StiffnessSearch {
    /// Rows and columns at the factors that fit the rows best without a law.
    ///
    /// # Arguments
    /// - `start`: that fit.
    /// - `fits`: of each law beside the factors.
    ///
    /// # Errors
    /// [`ProveError::Robot`].
    pub(super) fn new(
        problem: &StiffnessProblem<'_>,
        mechanics: &mut Mechanics<'_>,
        laws: &[LinearLaw],
        (start, fits): (&LinearFit, &[&LinearFit]),
        seed: u64,
    ) -> Result<Self, ProveError> {
        let cells = &problem.cells;
        let effect = |mechanics: &mut Mechanics<'_>, law: &LinearLaw, fit: &LinearFit| {
            let without = problem.predict(mechanics, None, fit)?;
            let mut effect = problem.predict(mechanics, Some(law), fit)?;
            for (value, without) in effect.iter_mut().zip(without) {
                *value -= without;
            }
            Ok::<_, ProveError>(effect)
        };
        let effects: Vec<Vec<f64>> = laws
            .iter()
            .zip(fits)
            .map(|(law, fit)| effect(mechanics, law, fit))
            .collect::<Result<_, _>>()?;
        let predicted = problem.predict(mechanics, None, start)?;
        let left = cells.iter().zip(&predicted);
        let left: Vec<f64> = left.map(|(cell, ln)| cell.ln_stiffness - ln).collect();
        // ln K falls by what the relative compliance grows.
        let column = |of: &dyn Fn(&PoseMechanics, Direction) -> f64| -> Vec<f64> {
            let relative = |cell: &ListedStiffness| {
                let pose = mechanics.pose(cell.pose);
                -of(pose, cell.direction) / compliance(pose, cell.direction)
            };
            cells.iter().map(relative).collect()
        };
        let factor = |factor: usize| {
            column(&|pose, direction| pose.gradient[factor][direction.index()][direction.index()])
        };
        let factors: Vec<Vec<f64>> = (0..start.ln_factors.len()).map(factor).collect();
        let candidate = |law: &LinearLaw| LinearCandidate {
            family: LAWS,
            columns: vec![column(&|pose, direction| law.softening(pose, direction))],
            multiples: if law.size_range()[0] < 0.0 {
                [f64::NEG_INFINITY, f64::INFINITY]
            } else {
                [0.0, f64::INFINITY]
            },
        };
        let candidates: Vec<LinearCandidate<&str>> = laws.iter().map(candidate).collect();
        let space = WhiteSpace::new(Covariance::equal(cells.len(), 1.0), &[], &factors);
        let noise = NullNoise::normal(NULL_SAMPLES, seed);
        let (families, maxima) = null_maxima(&space, &candidates, &noise);
        let ratios = maxima.under_estimated_variance(dof(cells.len(), Some(0)));
        let fitted = fits.iter().zip(&effects);
        Ok(Self {
            rows: cells.len(),
            residual: space.projected(&left),
            critical_values: CriticalValues::calibrate(&families, &ratios, LEVEL),
            start: start.squares,
            fitted: fitted
                .map(|(fit, effect)| (fit.squares, space.projected(effect)))
                .collect(),
            candidates,
            space,
        })
    }

    /// The factors alone, under the smallest variance that any law leaves.
    ///
    /// Under their own no law would be worth a look: with eight degrees of freedom none can explain more than eight.
    pub(super) fn start(&self) -> StiffnessModel {
        let laws = 0..self.fitted.len();
        let models = laws.map(|law| self.model(Some(law)));
        let own = self.model(None);
        StiffnessModel {
            variance: models.fold(own.variance, |least, model| least.min(model.variance)),
            ..own
        }
    }

    fn model(&self, law: Option<usize>) -> StiffnessModel {
        let squares = law.map_or(self.start, |law| self.fitted[law].0);
        StiffnessModel {
            law,
            variance: squares / dof(self.rows, law),
        }
    }

    /// The critical value of all laws.
    pub(super) fn critical_value(&self) -> f64 {
        self.critical_values.of(LAWS)
    }

    /// What speaks for a law under the variance that it leaves itself, which makes Δχ² the F statistic; and the chance that noise alone gives any
    /// law as much.
    pub(super) fn weighed(&self, law: usize) -> (Evidence, f64) {
        let own = self.weighed_under(&self.model(Some(law)), law);
        (own.evidence, self.chance(own.evidence.judged(true)))
    }

    /// What speaks for a law under the variance of a model.
    fn weighed_under(&self, model: &StiffnessModel, law: usize) -> FittedCandidate {
        let candidate = &self.candidates[law];
        let engine = Batched::new(&self.space, &self.residual);
        let moments = engine.moments(&candidate.columns[0], &(0..self.rows), &mut Vec::new());
        // What the factors absorb altogether explains nothing.
        let linear = if moments.square > 0.0 {
            moments.best_within(candidate.multiples).delta_chi2
        } else {
            0.0
        };
        let fall = (self.start - self.fitted[law].0).max(0.0);
        FittedCandidate {
            law,
            evidence: Evidence {
                delta_chi2: fall / model.variance,
                linear_delta_chi2: linear / model.variance,
                amplitudes: 1.0,
                parameters: 1,
                // The null samples estimate their variance too.
                dof: f64::INFINITY,
                critical_value: self.critical_value(),
                log_prior: 0.0,
            },
        }
    }

    fn chance(&self, delta_chi2: f64) -> f64 {
        self.critical_values.p(LAWS, delta_chi2)
    }

    /// Laws in the order of their evidence that the rows do not distinguish from the first of them.
    ///
    /// # Arguments
    /// - `ranked`: all laws in this order.
    pub(super) fn not_distinguishable(&self, ranked: &[FittedCandidate]) -> Vec<usize> {
        let Some(best) = ranked.first() else {
            return Vec::new();
        };
        let of_best = &self.fitted[best.law].1;
        let stays = |one: &&FittedCandidate| {
            let effect = &self.fitted[one.law].1;
            let lengths = (norm(of_best) * norm(effect)).max(f64::MIN_POSITIVE);
            let cosine = dot(of_best, effect) / lengths;
            let behind = best.evidence.log_bayes() - one.evidence.log_bayes();
            one.law == best.law || !distinguishable(behind, cosine * cosine)
        };
        let members = ranked.iter().filter(stays);
        members.map(|one| one.law).collect()
    }
}

/// Degrees of freedom that factors, and the size of a law, leave.
fn dof(rows: usize, law: Option<usize>) -> f64 {
    rows as f64 - 4.0 - f64::from(u8::from(law.is_some()))
}

impl ForwardProblem for StiffnessSearch {
    type Model = StiffnessModel;
    /// Every law, scored and fitted: twelve values are fitted once.
    type Scores = Vec<FittedCandidate>;
    type Fitted = FittedCandidate;
    type Error = Infallible;

    /// Two laws beside four factors are more than a dozen values can bear.
    fn most_terms(&self) -> usize {
        1
    }

    fn terms(&self, model: &StiffnessModel) -> usize {
        usize::from(model.law.is_some())
    }

    fn score(&self, model: &StiffnessModel) -> Result<Vec<FittedCandidate>, Infallible> {
        let laws = 0..self.candidates.len();
        Ok(laws.map(|law| self.weighed_under(model, law)).collect())
    }

    fn rescore(
        &self,
        model: &StiffnessModel,
        _: (&StiffnessModel, &Vec<FittedCandidate>),
        _: f64,
    ) -> Result<Vec<FittedCandidate>, Infallible> {
        self.score(model)
    }

    fn rank(
        &self,
        _: &StiffnessModel,
        scores: &Vec<FittedCandidate>,
        share: f64,
    ) -> Result<Vec<FittedCandidate>, Infallible> {
        let mut ranked = scores.clone();
        ranked.retain(|one| one.evidence.linear_delta_chi2 >= share * one.evidence.critical_value);
        ranked.sort_by(|a, b| b.evidence.log_bayes().total_cmp(&a.evidence.log_bayes()));
        Ok(ranked)
    }

    fn evidence(&self, fitted: &FittedCandidate) -> Evidence {
        fitted.evidence
    }

    fn p(&self, _: &FittedCandidate, delta_chi2: f64) -> f64 {
        self.chance(delta_chi2)
    }

    fn is_same(&self, one: &FittedCandidate, other: &FittedCandidate) -> bool {
        one.law == other.law
    }

    fn is_term(&self, model: &StiffnessModel, _: usize, fitted: &FittedCandidate) -> bool {
        model.law == Some(fitted.law)
    }

    fn with(&self, fitted: &FittedCandidate) -> Result<Option<StiffnessModel>, Infallible> {
        Ok(Some(self.model(Some(fitted.law))))
    }

    fn under_covariance_of(
        &self,
        model: &StiffnessModel,
        other: &StiffnessModel,
    ) -> Result<Option<StiffnessModel>, Infallible> {
        Ok(Some(StiffnessModel {
            variance: other.variance,
            ..*model
        }))
    }

    fn without(&self, model: &StiffnessModel, _: usize) -> Result<StiffnessModel, Infallible> {
        Ok(StiffnessModel {
            law: None,
            ..*model
        })
    }
}
