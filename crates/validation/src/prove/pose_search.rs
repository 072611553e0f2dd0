//! Errors of poses as a linear problem: rigid geometry, and errors of joints beside it, each a column or a pair.
//!
//! The search is that of sessions ([`forward_selection`](stiffbench_diagnosis::search::forward_selection)).

use nalgebra::{DMatrix, DVector};

use stiffbench_diagnosis::search::{
    Batched, Covariance, CriticalValues, Evidence, ForwardProblem, NULL_SAMPLES, NullNoise,
    NullShape, RowVector, ScoreEngine, WhiteSpace, subtract,
};

/// Level of the search.
const LEVEL: f64 = 0.04;

/// A column that rigid geometry leaves less of than this share is contained in it.
const ABSORBED: f64 = 1e-6;

/// An error of a joint: one column, whose multiple is not negative, or two of any multiples.
#[derive(Debug, Clone)]
pub(super) struct PoseCandidate {
    pub(super) name: String,
    pub(super) columns: Vec<Vec<f64>>,
}

/// Columns that contain each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct NotIndependent;

/// A fit by least squares.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LinearFit {
    /// Factors of the columns.
    pub(super) values: Vec<f64>,
    /// Their standard errors, the variance taken from the residuals.
    pub(super) standard_errors: Vec<f64>,
    pub(super) squares: f64,
    /// Rows less the sum of the columns.
    pub(super) residuals: Vec<f64>,
}

impl LinearFit {
    /// Fits columns to rows.
    ///
    /// # Errors
    /// [`NotIndependent`].
    pub(super) fn new(columns: &[&Vec<f64>], rows: &[f64]) -> Result<Self, NotIndependent> {
        let vectors = columns
            .iter()
            .map(|column| DVector::from_column_slice(column));
        let vectors: Vec<DVector<f64>> = vectors.collect();
        // Columns of unit length: they may differ by orders of magnitude.
        let lengths: Vec<f64> = vectors.iter().map(DVector::norm).collect();
        let units: Vec<DVector<f64>> = vectors.iter().zip(&lengths).map(|(v, l)| v / *l).collect();
        let matrix = DMatrix::from_fn(rows.len(), columns.len(), |row, place| units[place][row]);
        let right = DVector::from_column_slice(rows);
        let normal = matrix.tr_mul(&matrix).cholesky().ok_or(NotIndependent)?;
        let scaled = normal.solve(&matrix.tr_mul(&right));
        let squares = (&right - &matrix * &scaled).norm_squared();
        let variance = squares / (rows.len() - columns.len()) as f64;
        let inverse = normal.inverse();
        let values: Vec<f64> = scaled.iter().zip(&lengths).map(|(v, l)| v / l).collect();
        let mut residuals = rows.to_vec();
        for (column, value) in columns.iter().zip(&values) {
            subtract(&mut residuals, *value, column);
        }
        Ok(Self {
            standard_errors: (0..columns.len())
                .map(|j| (variance * inverse[(j, j)]).sqrt() / lengths[j])
                .collect(),
            values,
            squares,
            residuals,
        })
    }
}

/// Rows, rigid geometry, and what is searched for beside it.
pub(super) struct PoseSearch<'a> {
    rows: &'a [f64],
    rigid: &'a [Vec<f64>],
    candidates: &'a [PoseCandidate],
    /// Share of the rows that count as independent, by what a model leaves.
    independent: fn(&[f64]) -> f64,
    /// All candidates share one.
    critical_values: CriticalValues<()>,
}

/// Rigid geometry with some of the candidates.
#[derive(Debug, Clone)]
pub(super) struct PoseErrorModel {
    /// Places of its candidates.
    pub(super) terms: Vec<usize>,
    pub(super) fit: LinearFit,
    /// Variance of a row, and the degrees of freedom of it.
    variance: f64,
    dof: f64,
}

/// The score of a candidate beside a model.
#[derive(Debug, Clone, Copy)]
pub(super) struct PoseScore {
    /// Its place.
    pub(super) candidate: usize,
    delta_chi2: f64,
    /// What a negative multiple would give, where that is not allowed.
    forbidden_delta_chi2: f64,
}

/// A candidate beside the terms of a model: a score is the fit itself, for all is linear.
#[derive(Debug, Clone)]
pub(super) struct RankedError {
    /// Places of the candidates, itself the last.
    terms: Vec<usize>,
    evidence: Evidence,
}

impl<'a> PoseSearch<'a> {
    pub(super) fn new(
        (rows, rigid): (&'a [f64], &'a [Vec<f64>]),
        candidates: &'a [PoseCandidate],
        independent: fn(&[f64]) -> f64,
        seed: u64,
    ) -> Self {
        let space = WhiteSpace::new(Covariance::equal(rows.len(), 1.0), &[], rigid);
        let shape = |candidate: &PoseCandidate| {
            let white = candidate.columns.iter().map(|column| space.white(column));
            let (units, length) = space.orthonormal(white.map(RowVector::from), ABSORBED)?;
            let is_single = units.len() == 1;
            Some(NullShape {
                family: 0,
                units,
                length,
                multiples: [
                    if is_single { 0.0 } else { f64::NEG_INFINITY },
                    f64::INFINITY,
                ],
            })
        };
        let shapes: Vec<NullShape> = candidates.iter().filter_map(shape).collect();
        let nothing_left = vec![0.0; space.length];
        let all = 0..rows.len();
        let maxima = Batched::new(&space, &nothing_left).null_maxima(
            vec![Box::new(move || shapes)],
            1,
            std::slice::from_ref(&all),
            &NullNoise::normal(NULL_SAMPLES, seed),
        );
        Self {
            rows,
            rigid,
            candidates,
            independent,
            critical_values: CriticalValues::calibrate(&[()], &maxima, LEVEL),
        }
    }

    /// Whether a candidate would have passed with a multiple that is not allowed.
    pub(super) fn is_forbidden(&self, score: &PoseScore) -> bool {
        score.forbidden_delta_chi2 > self.critical_values.of(())
    }

    /// Rigid geometry with some of the candidates, and what these leave.
    ///
    /// # Errors
    /// [`NotIndependent`].
    pub(super) fn model(&self, terms: Vec<usize>) -> Result<PoseErrorModel, NotIndependent> {
        let fit = self.fit(&terms)?;
        let dof = (self.rows.len() - fit.values.len()) as f64;
        let share = (self.independent)(&fit.residuals);
        Ok(PoseErrorModel {
            variance: fit.squares / dof / share,
            dof: dof * share,
            terms,
            fit,
        })
    }

    fn fit(&self, terms: &[usize]) -> Result<LinearFit, NotIndependent> {
        let of_terms = terms
            .iter()
            .flat_map(|term| &self.candidates[*term].columns);
        let columns: Vec<&Vec<f64>> = self.rigid.iter().chain(of_terms).collect();
        LinearFit::new(&columns, self.rows)
    }
}

impl ForwardProblem for PoseSearch<'_> {
    type Model = PoseErrorModel;
    type Scores = Vec<PoseScore>;
    type Fitted = RankedError;
    type Error = NotIndependent;

    fn most_terms(&self) -> usize {
        self.candidates.len()
    }

    fn terms(&self, model: &PoseErrorModel) -> usize {
        model.terms.len()
    }

    fn score(&self, model: &PoseErrorModel) -> Result<Vec<PoseScore>, NotIndependent> {
        let score = |candidate: usize| {
            let fit = self.fit(&[&model.terms[..], &[candidate]].concat())?;
            let fall = (model.fit.squares - fit.squares) / model.variance;
            let is_single = self.candidates[candidate].columns.len() == 1;
            let is_forbidden = is_single && fit.values.last().is_some_and(|value| *value < 0.0);
            Ok(PoseScore {
                candidate,
                delta_chi2: if is_forbidden { 0.0 } else { fall },
                forbidden_delta_chi2: if is_forbidden { fall } else { 0.0 },
            })
        };
        let free = (0..self.candidates.len()).filter(|place| !model.terms.contains(place));
        free.map(score).collect()
    }

    fn rescore(
        &self,
        model: &PoseErrorModel,
        _: (&PoseErrorModel, &Vec<PoseScore>),
        _: f64,
    ) -> Result<Vec<PoseScore>, NotIndependent> {
        self.score(model)
    }

    fn rank(
        &self,
        model: &PoseErrorModel,
        scores: &Vec<PoseScore>,
        share: f64,
    ) -> Result<Vec<RankedError>, NotIndependent> {
        let fitted = |score: &PoseScore| {
            let columns = self.candidates[score.candidate].columns.len();
            RankedError {
                terms: [&model.terms[..], &[score.candidate]].concat(),
                evidence: Evidence {
                    delta_chi2: score.delta_chi2,
                    linear_delta_chi2: score.delta_chi2,
                    amplitudes: columns as f64,
                    parameters: columns,
                    dof: model.dof,
                    critical_value: self.critical_values.of(()),
                    log_prior: 0.0,
                },
            }
        };
        let mut ranked: Vec<RankedError> = scores.iter().map(fitted).collect();
        ranked.retain(|one| one.evidence.delta_chi2 >= share * one.evidence.critical_value);
        ranked.sort_by(|a, b| b.evidence.log_bayes().total_cmp(&a.evidence.log_bayes()));
        Ok(ranked)
    }

    fn evidence(&self, fitted: &RankedError) -> Evidence {
        fitted.evidence
    }

    fn p(&self, _: &RankedError, delta_chi2: f64) -> f64 {
        self.critical_values.p((), delta_chi2)
    }

    fn is_same(&self, one: &RankedError, other: &RankedError) -> bool {
        one.terms.last() == other.terms.last()
    }

    fn is_term(&self, model: &PoseErrorModel, term: usize, fitted: &RankedError) -> bool {
        fitted.terms.last() == model.terms.get(term)
    }

    fn with(&self, fitted: &RankedError) -> Result<Option<PoseErrorModel>, NotIndependent> {
        self.model(fitted.terms.clone()).map(Some)
    }

    fn under_covariance_of(
        &self,
        model: &PoseErrorModel,
        other: &PoseErrorModel,
    ) -> Result<Option<PoseErrorModel>, NotIndependent> {
        Ok(Some(PoseErrorModel {
            variance: other.variance,
            dof: other.dof,
            ..model.clone()
        }))
    }

    fn without(
        &self,
        model: &PoseErrorModel,
        term: usize,
    ) -> Result<PoseErrorModel, NotIndependent> {
        let mut terms = model.terms.clone();
        terms.remove(term);
        Ok(PoseErrorModel {
            fit: self.fit(&terms)?,
            terms,
            ..*model
        })
    }
}
