//! The search behind `minimise`: which steps are taken, and when it ends.

use super::error::LeastSquaresError;
use super::minimise::{Convergence, LeastSquaresFit, LeastSquaresSettings, Termination};
use super::parameter::{Bound, ParameterSet};
use super::point::{EvaluatedPoint, hold, linear_model};
use super::residual_function::{EvaluationFailure, ResidualFunction};
use super::singular_values::norm;
use super::trust_region::{Linearisation, Subproblem, TrustRegionStep, largest_cosine};

/// A promised relative reduction of ‖r‖² below this may be hidden by the rounding of the residuals; the gradient decides instead.
const OBJECTIVE_NOISE: f64 = 1e-12;

/// A change beyond this is no rounding: residuals of 1e-10 of the data still change by less.
const LARGEST_NOISE: f64 = 1e-6;

/// Moré's first radius, in lengths ‖D p‖ of the start: far enough to let the first step be a full one in most fits.
const FIRST_RADIUS: f64 = 100.0;

/// Each rejection shortens the radius at least to half: this many take it from any size to below rounding.
const MAX_REJECTIONS: usize = 80;

pub(super) struct LeastSquaresSearch<'a> {
    problem: &'a mut dyn ResidualFunction,
    set: &'a ParameterSet,
    settings: &'a LeastSquaresSettings,
    bounds: Vec<(f64, f64)>,
    current: EvaluatedPoint,
    trial: EvaluatedPoint,
    held: Vec<bool>,
    scale: Vec<f64>,
    radius: Option<f64>,
    subproblem: Subproblem,
    last_failure: Option<EvaluationFailure>,
    evaluations: usize,
    failed_evaluations: usize,
    iterations: usize,
    restarted_at: usize,
}

impl<'a> LeastSquaresSearch<'a> {
    pub(super) fn start(
        problem: &'a mut dyn ResidualFunction,
        set: &'a ParameterSet,
        settings: &'a LeastSquaresSettings,
    ) -> Result<Self, LeastSquaresError> {
        let rows = problem.residual_count();
        if rows == 0 {
            return Err(LeastSquaresError::NoResiduals);
        }
        let mut current = EvaluatedPoint::new(set, rows);
        current
            .evaluate(problem, set)
            .map_err(|source| LeastSquaresError::StartHasNoValue { source })?;
        let columns = current.free.len();
        Ok(Self {
            problem,
            set,
            settings,
            bounds: set.free_bounds(),
            current,
            trial: EvaluatedPoint::new(set, rows),
            held: vec![false; columns],
            scale: vec![0.0; columns],
            radius: None,
            subproblem: Subproblem::default(),
            last_failure: None,
            evaluations: 1,
            failed_evaluations: 0,
            iterations: 0,
            restarted_at: 0,
        })
    }

    pub(super) fn run(&mut self) -> Termination {
        loop {
            self.update_scale();
            hold(&self.current, &self.bounds, &mut self.held);
            if largest_cosine(&self.model()) <= self.settings.gradient_tolerance {
                return Termination::Converged(Convergence::Gradient);
            }
            match self.take_a_step() {
                None => self.iterations += 1,
                Some(Termination::Stalled) if self.iterations > self.restarted_at => self.restart(),
                Some(termination) => return termination,
            }
        }
    }

    /// Forgets the scale: from a far start a column may once have been so long that every later step drowns in its rounding.
    fn restart(&mut self) {
        self.restarted_at = self.iterations;
        self.scale.fill(0.0);
        self.radius = None;
    }

    /// D is the largest norm each column has had: scales as the parameters do, and never lets a step grow by forgetting.
    fn update_scale(&mut self) {
        let rows = self.current.residuals.len();
        let first = self.radius.is_none();
        for (scale, column) in self
            .scale
            .iter_mut()
            .zip(self.current.jacobian.chunks_exact(rows))
        {
            let length = norm(column);
            *scale = if first && length == 0.0 {
                1.0
            } else {
                scale.max(length)
            };
        }
    }

    fn model(&self) -> Linearisation<'_> {
        linear_model(&self.current, &self.bounds, &self.held, &self.scale)
    }

    fn solve(&mut self, radius: f64) -> TrustRegionStep {
        let mut subproblem = std::mem::take(&mut self.subproblem);
        let step = subproblem.solve(&self.model(), radius);
        self.subproblem = subproblem;
        step
    }

    fn scaled_point_norm(&self) -> f64 {
        let squared: f64 = self
            .current
            .free
            .iter()
            .zip(&self.scale)
            .map(|(x, d)| (x * d) * (x * d))
            .sum();
        squared.sqrt()
    }

    /// Shortens the radius until a step is accepted; a termination if none is, or none is needed.
    fn take_a_step(&mut self) -> Option<Termination> {
        let size = self.scaled_point_norm();
        for _ in 0..MAX_REJECTIONS {
            // A start at zero has no size of its own.
            let first_radius = if size == 0.0 {
                FIRST_RADIUS
            } else {
                FIRST_RADIUS * size
            };
            let radius = self.radius.unwrap_or(first_radius);
            // The decrease that the linear model predicts without a radius is all there is to gain. A radius that shrank because the objective's own
            // error hid what small steps gain must not hide that nothing is left.
            let mut step = self.solve(f64::INFINITY);
            if let Some(convergence) = self.convergence(&step) {
                return Some(Termination::Converged(convergence));
            }
            if step.scaled_norm > radius {
                step = self.solve(radius);
            }
            let stands = self.subproblem.target == self.current.free;
            if stands || radius <= f64::EPSILON * size {
                break;
            }
            if self.evaluations >= self.settings.max_evaluations {
                let max_evaluations = self.settings.max_evaluations;
                return Some(Termination::AtLimit { max_evaluations });
            }
            let radius = if self.radius.is_none() {
                radius.min(step.scaled_norm)
            } else {
                radius
            };
            let (accepted, radius) = self.try_step(&step, radius);
            self.radius = Some(radius);
            if accepted {
                std::mem::swap(&mut self.current, &mut self.trial);
                return None;
            }
        }
        Some(self.why_no_step(size))
    }

    fn convergence(&self, step: &TrustRegionStep) -> Option<Convergence> {
        let mut moves = self.subproblem.step.iter().zip(&self.current.free);
        if moves.all(|(p, x)| p.abs() <= self.settings.step_tolerance * x.abs()) {
            Some(Convergence::Step)
        } else if step.predicted_reduction <= self.settings.reduction_tolerance
            || step.predicted_reduction * self.current.squared_norm
                <= self.settings.negligible_reduction
        {
            Some(Convergence::Reduction)
        } else {
            None
        }
    }

    /// Evaluates the target of a step: (accepted, next radius).
    fn try_step(&mut self, step: &TrustRegionStep, radius: f64) -> (bool, f64) {
        let shorter = 0.25 * radius.min(step.scaled_norm);
        // Only after clipping at several bounds can a step predict no decrease; a shorter one follows the gradient.
        if step.predicted_reduction <= 0.0 {
            return (false, shorter);
        }
        self.trial.free.copy_from_slice(&self.subproblem.target);
        self.evaluations += 1;
        if let Err(failure) = self.trial.evaluate(self.problem, self.set) {
            self.failed_evaluations += 1;
            self.last_failure = Some(failure);
            return (false, shorter);
        }
        let actual = 1.0 - self.trial.squared_norm / self.current.squared_norm;
        if step.predicted_reduction > OBJECTIVE_NOISE {
            // From here on the steps succeed or fail by their values, not by the lack of one.
            self.last_failure = None;
        } else if actual.abs() <= LARGEST_NOISE {
            let accepted = self.trial_predicts_less();
            let longer = radius.max(2.0 * step.scaled_norm);
            return (accepted, if accepted { longer } else { shorter });
        }
        judge(step, actual, radius)
    }

    /// Whether the linear model at the trial point predicts less than that at the current one: the size of the gradient in the
    /// measure of the problem itself, which still has digits when the objective has none left.
    fn trial_predicts_less(&mut self) -> bool {
        let mut held = self.held.clone();
        let mut predicted_decrease = |point: &EvaluatedPoint| {
            hold(point, &self.bounds, &mut held);
            let model = linear_model(point, &self.bounds, &held, &self.scale);
            self.subproblem
                .solve(&model, f64::INFINITY)
                .predicted_reduction
        };
        predicted_decrease(&self.trial) < predicted_decrease(&self.current)
    }

    /// No step was accepted: is this the floor of rounding, or a model that contradicts its derivatives?
    fn why_no_step(&mut self, size: f64) -> Termination {
        if let Some(failure) = self.last_failure.take() {
            return Termination::EvaluationFailed(failure);
        }
        let full = self.solve(f64::INFINITY);
        if full.scaled_norm <= f64::EPSILON.sqrt() * size
            || full.predicted_reduction <= OBJECTIVE_NOISE
        {
            Termination::Converged(Convergence::Rounding)
        } else {
            Termination::Stalled
        }
    }

    pub(super) fn finish(self, termination: Termination) -> LeastSquaresFit {
        let EvaluatedPoint {
            free,
            full,
            residuals,
            mut jacobian,
            squared_norm,
            ..
        } = self.current;
        jacobian.truncate(residuals.len() * free.len());
        let at_bound = free
            .iter()
            .zip(&self.bounds)
            .map(|(&x, &(lower, upper))| {
                if x == lower {
                    Some(Bound::Lower)
                } else {
                    (x == upper).then_some(Bound::Upper)
                }
            })
            .collect();
        LeastSquaresFit {
            values: full,
            free_values: free,
            at_bound,
            objective: 0.5 * squared_norm,
            residuals,
            termination,
            evaluations: self.evaluations,
            failed_evaluations: self.failed_evaluations,
            iterations: self.iterations,
            jacobian,
        }
    }
}

/// Moré's rule: accept what reduces at all, lengthen the radius where the linear model was good, shorten it where it was not.
fn judge(step: &TrustRegionStep, actual: f64, radius: f64) -> (bool, f64) {
    let ratio = actual / step.predicted_reduction;
    // ‖r‖ more than ten times as long carries no information on curvature any more.
    let hopeless = actual <= -99.0;
    let next = if ratio <= 0.25 {
        let factor = if actual >= 0.0 {
            0.5
        } else if hopeless {
            0.1
        } else {
            (0.5 * step.slope / (step.slope + 0.5 * actual)).max(0.1)
        };
        factor * radius.min(10.0 * step.scaled_norm)
    } else if step.full || ratio >= 0.75 {
        2.0 * step.scaled_norm
    } else {
        radius
    };
    (ratio >= 1e-4, next)
}
