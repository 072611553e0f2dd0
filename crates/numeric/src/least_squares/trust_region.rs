//! One step: the minimum of the linearised problem within bounds and a trust radius.

use super::singular_values::{SingularValues, dot, norm};

/// The problem linearised at a point; matrices by columns, all slices over the free parameters unless stated otherwise.
#[derive(Debug, Clone, Copy)]
pub(super) struct Linearisation<'a> {
    /// Residuals at the point, one for each residual.
    pub(super) residuals: &'a [f64],
    /// ‖r‖².
    pub(super) squared_norm: f64,
    /// rows × free columns.
    pub(super) jacobian: &'a [f64],
    /// Jᵀ r.
    pub(super) gradient: &'a [f64],
    /// The point.
    pub(super) point: &'a [f64],
    /// (lower, upper).
    pub(super) bounds: &'a [(f64, f64)],
    /// On a bound with the gradient pointing outward: not to be moved.
    pub(super) held: &'a [bool],
    /// D: the scale in which the length of a step is measured.
    pub(super) scale: &'a [f64],
}

impl Linearisation<'_> {
    fn column(&self, j: usize) -> &[f64] {
        let rows = self.residuals.len();
        &self.jacobian[j * rows..(j + 1) * rows]
    }
}

/// Predicted decrease of a step.
#[derive(Debug, Clone, Copy)]
pub(super) struct TrustRegionStep {
    /// ‖D p‖.
    pub(super) scaled_norm: f64,
    /// 1 − ‖r + J p‖²/‖r‖².
    pub(super) predicted_reduction: f64,
    /// gᵀ p/‖r‖²: half the slope of the relative reduction along the step.
    pub(super) slope: f64,
    /// Whether the radius did not shorten the step.
    pub(super) full: bool,
}

/// Memory of the subproblem between steps.
#[derive(Debug, Clone, Default)]
pub(super) struct Subproblem {
    decomposition: SingularValues,
    working: Vec<usize>,
    /// Which singular values are more than rounding.
    useful: Vec<bool>,
    column_norms: Vec<f64>,
    shifted: Vec<f64>,
    coefficients: Vec<f64>,
    product: Vec<f64>,
    /// The step p.
    pub(super) step: Vec<f64>,
    /// Point plus step; exactly on the bound where the step ended on one.
    pub(super) target: Vec<f64>,
}

impl Subproblem {
    /// Minimises ‖r + J p‖ over ‖D p‖ ≤ radius and the bounds.
    ///
    /// A parameter that would leave its range stops on the bound, the one reached first along the step before the others,
    /// and the rest is solved again with what is left of the radius. `step` and `target` hold the result.
    pub(super) fn solve(&mut self, model: &Linearisation<'_>, radius: f64) -> TrustRegionStep {
        self.step.clear();
        self.step.resize(model.point.len(), 0.0);
        self.target.clear();
        self.target.extend_from_slice(model.point);
        self.working.clear();
        self.working
            .extend((0..model.point.len()).filter(|&j| !model.held[j]));
        self.shifted.clear();
        self.shifted.extend_from_slice(model.residuals);

        let mut radius_left = radius;
        let mut full = true;
        while !self.working.is_empty() {
            full = self.solve_working(model, radius_left);
            let Some((place, bound)) = self.first_crossing(model) else {
                break;
            };
            let j = self.working.remove(place);
            self.step[j] = bound - model.point[j];
            self.target[j] = bound;
            for (s, derivative) in self.shifted.iter_mut().zip(model.column(j)) {
                *s += derivative * self.step[j];
            }
            let used = model.scale[j] * self.step[j];
            // A tenth stays for the others, so that one long clipped move does not freeze them.
            radius_left = (radius_left * radius_left - used * used)
                .max(0.01 * radius * radius)
                .sqrt();
        }
        for &j in &self.working {
            let (lower, upper) = model.bounds[j];
            self.target[j] = (model.point[j] + self.step[j]).clamp(lower, upper);
        }
        self.predicted_decrease(model, full)
    }

    /// Fills `step` for the working parameters; returns whether the radius left it alone.
    fn solve_working(&mut self, model: &Linearisation<'_>, radius: f64) -> bool {
        let svd = &mut self.decomposition;
        svd.reshape(self.shifted.len(), self.working.len());
        for (place, &j) in self.working.iter().enumerate() {
            for (entry, derivative) in svd.column_mut(place).iter_mut().zip(model.column(j)) {
                *entry = derivative / model.scale[j];
            }
        }
        svd.right_hand_side_mut().copy_from_slice(&self.shifted);
        self.column_norms.clear();
        self.column_norms
            .extend((0..self.working.len()).map(|place| norm(svd.column_mut(place))));
        svd.decompose();
        mark_useful(svd, &self.column_norms, &mut self.useful);
        let lambda = damping(svd, &self.useful, radius);

        self.coefficients.clear();
        self.coefficients.resize(self.working.len(), 0.0);
        for (j, (&s, &z)) in svd.values().iter().zip(svd.projections()).enumerate() {
            if self.useful[j] {
                let factor = -s * z / (s * s + lambda);
                for (c, v) in self.coefficients.iter_mut().zip(svd.right_vector(j)) {
                    *c += factor * v;
                }
            }
        }
        for (c, &j) in self.coefficients.iter().zip(&self.working) {
            self.step[j] = c / model.scale[j];
        }
        lambda == 0.0
    }

    /// The working parameter that the step takes to its bound first: (place in `working`, bound).
    fn first_crossing(&self, model: &Linearisation<'_>) -> Option<(usize, f64)> {
        let mut first: Option<(usize, f64, f64)> = None;
        for (place, &j) in self.working.iter().enumerate() {
            let (lower, upper) = model.bounds[j];
            let (from, p) = (model.point[j], self.step[j]);
            let bound = if from + p < lower {
                lower
            } else if from + p > upper {
                upper
            } else {
                continue;
            };
            let share = (bound - from) / p;
            if first.is_none_or(|(_, _, smallest)| share < smallest) {
                first = Some((place, bound, share));
            }
        }
        first.map(|(place, bound, _)| (place, bound))
    }

    fn predicted_decrease(&mut self, model: &Linearisation<'_>, full: bool) -> TrustRegionStep {
        self.product.clear();
        self.product.resize(model.residuals.len(), 0.0);
        for (j, &p) in self.step.iter().enumerate() {
            if p != 0.0 {
                for (q, derivative) in self.product.iter_mut().zip(model.column(j)) {
                    *q += derivative * p;
                }
            }
        }
        let slope = dot(model.gradient, &self.step) / model.squared_norm;
        let curvature = dot(&self.product, &self.product) / model.squared_norm;
        let scaled: f64 = self
            .step
            .iter()
            .zip(model.scale)
            .map(|(p, d)| (p * d) * (p * d))
            .sum();
        TrustRegionStep {
            scaled_norm: scaled.sqrt(),
            // From the slope and not from ‖r + J p‖, which has no digits left for the last steps.
            predicted_reduction: -2.0 * slope - curvature,
            slope,
            full,
        }
    }
}

/// Marks the singular values that are more than rounding; a step along the others would be noise and is left out.
///
/// The rounding of s = uᵀ A v is that of the columns, each weighted by its entry in v: a single column that has become small
/// is still known to all its digits, the difference of two equal ones is not.
fn mark_useful(svd: &SingularValues, column_norms: &[f64], useful: &mut Vec<bool>) {
    let count = column_norms.len() as f64;
    useful.clear();
    useful.extend(svd.values().iter().enumerate().map(|(j, &s)| {
        let weighted: f64 = svd
            .right_vector(j)
            .iter()
            .zip(column_norms)
            .map(|(v, length)| v.abs() * length)
            .sum();
        s > count * f64::EPSILON * weighted
    }));
}

/// λ for which the step (JᵀJ + λ D²)⁻¹ Jᵀ r has the length of the radius to a tenth; 0 if the undamped step is short enough.
///
/// Newton's method on 1/radius − 1/‖q(λ)‖, which rises to the solution from the left without passing it.
///
/// # Source
/// Moré, The Levenberg-Marquardt algorithm: implementation and theory, Lecture Notes in Mathematics 630 (1978), section 5;
/// with singular values the length is a sum, ‖q‖² = Σ (s z/(s² + λ))².
fn damping(svd: &SingularValues, useful: &[bool], radius: f64) -> f64 {
    let terms = || {
        let pairs = svd.values().iter().zip(svd.projections()).zip(useful);
        pairs.filter(|&(_, useful)| *useful).map(|(pair, _)| pair)
    };
    let length_and_derivative = |lambda: f64| {
        let (mut squared, mut derivative) = (0.0, 0.0);
        for (&s, &z) in terms() {
            let term = s * z / (s * s + lambda);
            squared += term * term;
            derivative -= term * term / (s * s + lambda);
        }
        let length: f64 = squared.sqrt();
        (length, derivative / length)
    };
    let mut lambda = 0.0;
    // Newton gains digits from the first round on; the count only guards against rounding.
    for _ in 0..100 {
        let (length, derivative) = length_and_derivative(lambda);
        if length <= 1.1 * radius || derivative == 0.0 {
            break;
        }
        lambda -= length / radius * (length - radius) / derivative;
    }
    lambda
}

/// Largest |g_j|/(‖J_j‖ ‖r‖) over the parameters that are not held: the cosine between the residuals and a column.
pub(super) fn largest_cosine(model: &Linearisation<'_>) -> f64 {
    let residual_norm = model.squared_norm.sqrt();
    (0..model.point.len())
        .filter(|&j| !model.held[j] && model.gradient[j] != 0.0)
        .map(|j| model.gradient[j].abs() / (norm(model.column(j)) * residual_norm))
        .fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    const JACOBIAN: [f64; 6] = [1.0, 0.0, 1.0, 0.5, 2.0, 0.0];
    const RESIDUALS: [f64; 3] = [1.0, -2.0, 3.0];

    fn solved(bounds: [(f64, f64); 2], radius: f64) -> (Subproblem, TrustRegionStep) {
        let gradient = [
            dot(&JACOBIAN[..3], &RESIDUALS),
            dot(&JACOBIAN[3..], &RESIDUALS),
        ];
        let model = Linearisation {
            residuals: &RESIDUALS,
            squared_norm: dot(&RESIDUALS, &RESIDUALS),
            jacobian: &JACOBIAN,
            gradient: &gradient,
            point: &[0.0, 0.0],
            bounds: &bounds,
            held: &[false, false],
            scale: &[1.0, 2.0],
        };
        let mut subproblem = Subproblem::default();
        let step = subproblem.solve(&model, radius);
        (subproblem, step)
    }

    const NO_BOUNDS: [(f64, f64); 2] = [(f64::NEG_INFINITY, f64::INFINITY); 2];

    #[test]
    fn without_limits_the_step_solves_the_normal_equations() {
        // JᵀJ = [2 0.5; 0.5 4.25], Jᵀr = [4 -3.5]: p = -[18.75 -9]/8.25.
        let (subproblem, step) = solved(NO_BOUNDS, 1e9);
        assert!(step.full);
        assert!((subproblem.step[0] + 18.75 / 8.25).abs() < 1e-14);
        assert!((subproblem.step[1] - 9.0 / 8.25).abs() < 1e-14);
        // ‖r + J p‖² at the minimum is ‖r‖² + gᵀp.
        assert!((step.predicted_reduction + step.slope).abs() < 1e-14);
    }

    #[test]
    fn the_radius_shortens_the_step_to_a_tenth() {
        for radius in [1.0, 1e-3, 1e-9] {
            let (_, step) = solved(NO_BOUNDS, radius);
            assert!(!step.full);
            assert!(
                (step.scaled_norm / radius - 1.0).abs() <= 0.1,
                "{}",
                step.scaled_norm
            );
            assert!(step.predicted_reduction > 0.0);
        }
    }

    #[test]
    fn a_step_that_would_cross_stops_on_the_bound_and_the_rest_is_solved_again() {
        let (subproblem, step) = solved([(-1.0, 1.0), (-5.0, 5.0)], 1e9);
        assert_eq!(subproblem.target[0], -1.0);
        // With p0 = -1 the second normal equation is 4.25 p1 = 3.5 + 0.5.
        assert!((subproblem.target[1] - 4.0 / 4.25).abs() < 1e-14);
        assert!(step.full);
    }

    #[test]
    fn both_bounds_can_stop_a_step() {
        let (subproblem, step) = solved([(-1.0, 1.0), (-5.0, 0.25)], 1e9);
        assert_eq!(subproblem.target, [-1.0, 0.25]);
        assert!(step.predicted_reduction > 0.0);
    }
}
