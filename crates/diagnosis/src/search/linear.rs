//! Linear problems: rows, a baseline of columns, candidates of one column or a pair, and a covariance that is found from what a model leaves.

use nalgebra::{DMatrix, DVector};

use super::batched::Batched;
use super::constants::{ABSORBED, ALTERNATIONS};
use super::covariance::Covariance;
use super::critical_values::CriticalValues;
use super::engine::{BestAmplitude, NullMaxima, NullShape, NullShapes, ScoreEngine};
use super::forward::{Evidence, ForwardProblem};
use super::null_noise::NullNoise;
use super::vectors::{RowVector, subtract};
use super::white_space::WhiteSpace;

/// A candidate: one column, or two of a law with a phase.
#[derive(Debug, Clone, PartialEq)]
pub struct LinearCandidate<F> {
    /// Candidates of one family share a critical value.
    pub family: F,
    /// One column or two, as long as the rows.
    pub columns: Vec<Vec<f64>>,
    /// Smallest and largest multiple of a single column.
    pub multiples: [f64; 2],
}

/// How the covariance of the rows follows from what a model leaves of them.
pub trait CovarianceModel {
    /// The covariance, and the degrees of freedom of its size.
    ///
    /// # Arguments
    /// - `parameters`: how many were fitted.
    fn estimate(&self, residuals: &[f64], parameters: usize) -> (Covariance, f64);
}

/// Rows, what is known of them, and what is searched for.
#[derive(Debug)]
pub struct LinearProblem<'a, F, C> {
    /// The rows.
    pub rows: &'a [f64],
    /// Columns of the baseline, independent of each other.
    pub baseline: &'a [Vec<f64>],
    /// The candidates.
    pub candidates: &'a [LinearCandidate<F>],
    /// Finds the covariance.
    pub covariance: C,
    /// Of the families of the candidates.
    pub critical_values: CriticalValues<F>,
}

/// Columns that contain each other.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[error("columns are not independent")]
pub struct NotIndependent;

/// A fit by least squares.
#[derive(Debug, Clone, PartialEq)]
pub struct LeastSquares {
    /// Factors of the columns.
    pub values: Vec<f64>,
    /// Their standard errors, the variance taken from the residuals.
    pub standard_errors: Vec<f64>,
    /// Squares of the white residuals.
    pub squares: f64,
    /// Rows less the sum of the columns.
    pub residuals: Vec<f64>,
}

/// A baseline with terms, and the covariance that they leave.
#[derive(Debug, Clone)]
pub struct LinearModel {
    /// Places of its candidates.
    pub terms: Vec<usize>,
    /// Its fit.
    pub fit: LeastSquares,
    /// The covariance that it leaves.
    pub covariance: Covariance,
    /// Degrees of freedom of its size.
    pub dof: f64,
}

/// The score of a candidate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LinearScore {
    /// Its place among the candidates.
    pub candidate: usize,
    /// Its best amplitude; of a pair along the first column.
    pub best: BestAmplitude,
}

/// A candidate beside the terms of a model.
#[derive(Debug, Clone)]
pub struct LinearFitted {
    /// Places of the candidates, itself the last.
    terms: Vec<usize>,
    evidence: Evidence,
}

impl LinearFitted {
    /// Place of the candidate.
    #[must_use]
    pub fn candidate(&self) -> Option<usize> {
        self.terms.last().copied()
    }
}

impl LeastSquares {
    /// Fits columns to rows.
    ///
    /// # Errors
    /// [`NotIndependent`].
    pub fn new(
        columns: &[&Vec<f64>],
        rows: &[f64],
        covariance: &Covariance,
    ) -> Result<Self, NotIndependent> {
        if columns.is_empty() {
            let mut white = rows.to_vec();
            covariance.whiten(&mut white);
            return Ok(Self {
                values: Vec::new(),
                standard_errors: Vec::new(),
                squares: white.iter().map(|x| x * x).sum(),
                residuals: rows.to_vec(),
            });
        }
        let white = |column: &[f64]| {
            let mut white = DVector::from_column_slice(column);
            covariance.whiten(white.as_mut_slice());
            white
        };
        let whites: Vec<DVector<f64>> = columns.iter().map(|column| white(column)).collect();
        // Columns of unit length: they may differ by orders of magnitude.
        let lengths: Vec<f64> = whites.iter().map(DVector::norm).collect();
        let units: Vec<DVector<f64>> = whites.iter().zip(&lengths).map(|(w, l)| w / *l).collect();
        let matrix = DMatrix::from_columns(&units);
        let right = white(rows);
        let normal = (matrix.tr_mul(&matrix)).cholesky().ok_or(NotIndependent)?;
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

/// Maxima of families of candidates in null samples, and the families.
#[must_use]
pub fn null_maxima<F: Ord + Copy>(
    space: &WhiteSpace,
    candidates: &[LinearCandidate<F>],
    noise: &NullNoise<'_>,
) -> (Vec<F>, NullMaxima) {
    let mut families: Vec<F> = candidates.iter().map(|one| one.family).collect();
    families.sort_unstable();
    families.dedup();
    let shape = |candidate: &LinearCandidate<F>| {
        let white = candidate.columns.iter().map(|column| space.white(column));
        let (units, length) = space.orthonormal(white.map(RowVector::from), ABSORBED)?;
        Some(NullShape {
            family: families.iter().position(|one| *one == candidate.family)?,
            units,
            length,
            multiples: candidate.multiples,
        })
    };
    let shapes: Vec<NullShape> = candidates.iter().filter_map(shape).collect();
    let group: NullShapes<'_> = Box::new(move || shapes);
    let nothing_left = vec![0.0; space.length];
    let rows = 0..space.covariance.weights().len();
    let maxima = Batched::new(space, &nothing_left).null_maxima(
        vec![group],
        families.len(),
        std::slice::from_ref(&rows),
        noise,
    );
    (families, maxima)
}

impl<F: Ord + Copy + Sync, C: CovarianceModel> LinearProblem<'_, F, C> {
    /// The baseline alone.
    ///
    /// # Errors
    /// [`NotIndependent`].
    pub fn start(&self) -> Result<LinearModel, NotIndependent> {
        self.alternate(Vec::new())
    }

    /// Parameters and covariance of a model, each from the other.
    fn alternate(&self, terms: Vec<usize>) -> Result<LinearModel, NotIndependent> {
        let mut covariance = Covariance::equal(self.rows.len(), 1.0);
        let mut dof = 0.0;
        for _ in 0..ALTERNATIONS {
            let columns = self.columns(&terms);
            let fit = LeastSquares::new(&columns, self.rows, &covariance)?;
            (covariance, dof) = self.covariance.estimate(&fit.residuals, columns.len());
        }
        self.model(terms, covariance, dof)
    }

    fn columns(&self, terms: &[usize]) -> Vec<&Vec<f64>> {
        let of_terms = terms
            .iter()
            .flat_map(|term| &self.candidates[*term].columns);
        self.baseline.iter().chain(of_terms).collect()
    }

    fn model(
        &self,
        terms: Vec<usize>,
        covariance: Covariance,
        dof: f64,
    ) -> Result<LinearModel, NotIndependent> {
        Ok(LinearModel {
            fit: LeastSquares::new(&self.columns(&terms), self.rows, &covariance)?,
            terms,
            covariance,
            dof,
        })
    }
}

impl<F: Ord + Copy + Sync, C: CovarianceModel> ForwardProblem for LinearProblem<'_, F, C> {
    type Model = LinearModel;
    type Scores = Vec<LinearScore>;
    type Fitted = LinearFitted;
    type Error = NotIndependent;

    fn most_terms(&self) -> usize {
        self.candidates.len()
    }

    fn terms(&self, model: &LinearModel) -> usize {
        model.terms.len()
    }

    fn score(&self, model: &LinearModel) -> Result<Vec<LinearScore>, NotIndependent> {
        let columns: Vec<Vec<f64>> = self.columns(&model.terms).into_iter().cloned().collect();
        let space = WhiteSpace::new(model.covariance.clone(), &[], &columns);
        let residual = space.projected(self.rows);
        let engine = Batched::new(&space, &residual);
        let rows = 0..self.rows.len();
        let mut scratch = Vec::new();
        let mut score = |candidate: &LinearCandidate<F>| match &candidate.columns[..] {
            [first, second] => {
                let pair = engine.pair_moments([first, second], &rows, &mut scratch);
                BestAmplitude {
                    multiple: pair.first.product / pair.first.square,
                    delta_chi2: pair.delta_chi2(),
                    forbidden_delta_chi2: 0.0,
                }
            }
            columns => engine
                .moments(&columns[0], &rows, &mut scratch)
                .best_within(candidate.multiples),
        };
        let free = (0..self.candidates.len()).filter(|place| !model.terms.contains(place));
        Ok(free
            .map(|candidate| LinearScore {
                candidate,
                best: score(&self.candidates[candidate]),
            })
            .collect())
    }

    fn rescore(
        &self,
        model: &LinearModel,
        _: (&LinearModel, &Vec<LinearScore>),
        _: f64,
    ) -> Result<Vec<LinearScore>, NotIndependent> {
        self.score(model)
    }

    /// A score is the fit itself: all is linear.
    fn rank(
        &self,
        model: &LinearModel,
        scores: &Vec<LinearScore>,
        share: f64,
    ) -> Result<Vec<LinearFitted>, NotIndependent> {
        let fitted = |score: &LinearScore| {
            let candidate = &self.candidates[score.candidate];
            let mut terms = model.terms.clone();
            terms.push(score.candidate);
            LinearFitted {
                terms,
                evidence: Evidence {
                    delta_chi2: score.best.delta_chi2,
                    linear_delta_chi2: score.best.delta_chi2,
                    amplitudes: candidate.columns.len() as f64,
                    parameters: candidate.columns.len(),
                    dof: model.dof,
                    critical_value: self.critical_values.of(candidate.family),
                    log_prior: 0.0,
                },
            }
        };
        let mut ranked: Vec<LinearFitted> = scores.iter().map(fitted).collect();
        ranked.retain(|one| one.evidence.delta_chi2 >= share * one.evidence.critical_value);
        ranked.sort_by(|a, b| b.evidence.log_bayes().total_cmp(&a.evidence.log_bayes()));
        Ok(ranked)
    }

    fn evidence(&self, fitted: &LinearFitted) -> Evidence {
        fitted.evidence
    }

    fn p(&self, fitted: &LinearFitted, delta_chi2: f64) -> f64 {
        let place = fitted.terms.last().map_or(0, |place| *place);
        self.critical_values
            .p(self.candidates[place].family, delta_chi2)
    }

    fn is_same(&self, one: &LinearFitted, other: &LinearFitted) -> bool {
        one.terms.last() == other.terms.last()
    }

    fn is_term(&self, model: &LinearModel, term: usize, fitted: &LinearFitted) -> bool {
        fitted.terms.last() == model.terms.get(term)
    }

    fn with(&self, fitted: &LinearFitted) -> Result<Option<LinearModel>, NotIndependent> {
        self.alternate(fitted.terms.clone()).map(Some)
    }

    fn under_covariance_of(
        &self,
        model: &LinearModel,
        other: &LinearModel,
    ) -> Result<Option<LinearModel>, NotIndependent> {
        let model = self.model(model.terms.clone(), other.covariance.clone(), other.dof)?;
        Ok(Some(model))
    }

    fn without(&self, model: &LinearModel, term: usize) -> Result<LinearModel, NotIndependent> {
        let mut terms = model.terms.clone();
        terms.remove(term);
        self.model(terms, model.covariance.clone(), model.dof)
    }
}
