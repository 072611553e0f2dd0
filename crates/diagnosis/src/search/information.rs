//! What readings say of quantities, made or planned: it adds up from one set of readings to the next, and gives the standard errors to be
//! expected, how far apart quantities are, and which further readings say most.

use nalgebra::DMatrix;

/// Information on quantities: scalar products of their columns, the derivatives of readings over the standard deviations of these.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Information(DMatrix<f64>);

/// Eigenvalues below this share of the largest are directions that the readings do not show.
const NOT_SHOWN: f64 = 1e-13;

/// Eigenvalues of columns of unit length are taken as this at least.
const LEAST_EIGENVALUE: f64 = 1e-14;

/// Information on a quantity that is a smaller share of that on the best known one is rounding.
const NOT_SEEN: f64 = 1e-12;

/// What others leave of the information on a quantity, as a share of it, below which it is rounding.
const ROUNDING: f64 = 1e3 * f64::EPSILON;

/// Passes of exchanges after the first choice; each ends where no exchange gains.
const MOST_PASSES: usize = 20;

/// A gain in what a choice is worth below this is none.
const LEAST_GAIN: f64 = 1e-9;

impl Information {
    /// What is known of the first quantities before any reading, by its standard deviations; of some behind them nothing is.
    pub(crate) fn of_prior(prior_sd: &[f64], unknown: usize) -> Self {
        let size = prior_sd.len() + unknown;
        let mut products = DMatrix::zeros(size, size);
        for (place, prior_sd) in prior_sd.iter().enumerate() {
            products[(place, place)] = prior_sd.powi(-2);
        }
        Self(products)
    }

    /// What readings say.
    ///
    /// # Arguments
    /// - `columns`: one a quantity, white: one value a reading.
    pub(crate) fn of_columns(columns: &[Vec<f64>]) -> Self {
        let length = columns.first().map_or(0, Vec::len);
        let flat = DMatrix::from_fn(length, columns.len(), |row, column| columns[column][row]);
        Self(flat.tr_mul(&flat))
    }

    /// With what further readings say.
    pub(crate) fn with(&self, further: &Self) -> Self {
        Self(&self.0 + &further.0)
    }

    /// Of some of the quantities, in other units.
    ///
    /// # Arguments
    /// - `places`: of the quantities; `units`: one for each of them.
    pub(crate) fn of_some(&self, places: &[usize], units: &[f64]) -> Self {
        let size = places.len();
        Self(DMatrix::from_fn(size, size, |i, j| {
            units[i] * units[j] * self.0[(places[i], places[j])]
        }))
    }

    /// Length of the column of each quantity: one over its standard error if all others were known.
    pub(crate) fn lengths(&self) -> Vec<f64> {
        self.0
            .diagonal()
            .iter()
            .map(|square| square.sqrt())
            .collect()
    }

    /// Logarithm of the determinant; minus infinity if a combination of quantities is not determined.
    pub(crate) fn log_determinant(&self) -> f64 {
        let factor = self.0.clone().cholesky();
        factor.map_or(f64::NEG_INFINITY, |factor| {
            let diagonal = factor.l_dirty().diagonal();
            diagonal.iter().map(|x| 2.0 * x.ln()).sum()
        })
    }

    /// Variance of each quantity, all others unknown too; `None` if a combination of them is not determined.
    pub(crate) fn variances(&self) -> Option<Vec<f64>> {
        let inverse = self.0.clone().cholesky()?.inverse();
        Some(inverse.diagonal().iter().copied().collect())
    }

    /// The covariance of quantities whose columns have unit length, those that are not determined at a large variance.
    pub(crate) fn inverse(&self) -> DMatrix<f64> {
        if self.0.is_empty() {
            return self.0.clone();
        }
        let mut eigen = self.0.clone().symmetric_eigen();
        for value in eigen.eigenvalues.iter_mut() {
            *value = value.max(LEAST_EIGENVALUE).recip();
        }
        eigen.recompose()
    }

    /// Standard error of a quantity beside the others that move, as far as the readings see these; `None` if they do not tell it from them.
    pub(crate) fn standard_error(
        &self,
        quantity: usize,
        moves: impl Fn(usize) -> bool,
    ) -> Option<f64> {
        let own = self.0[(quantity, quantity)];
        let least = NOT_SEEN * self.0.diagonal().max();
        let others = (0..self.0.nrows()).filter(|&other| other != quantity && moves(other));
        let mut places: Vec<usize> = others.filter(|&i| self.0[(i, i)] > least).collect();
        places.push(quantity);
        let some = self.of_some(&places, &vec![1.0; places.len()]);
        let left = some.projected(places.len() - 1).square(0);
        (own > least && left > ROUNDING * own).then(|| left.sqrt().recip())
    }

    /// Scalar products of the quantities behind some, with these projected out.
    pub(crate) fn projected(&self, factors: usize) -> Projected {
        let (k, n) = (factors, self.0.nrows());
        let effects = self.0.view((k, k), (n - k, n - k)).into_owned();
        if k == 0 {
            return Projected(effects);
        }
        let lengths: Vec<f64> = (0..k)
            .map(|i| self.0[(i, i)].sqrt().max(f64::MIN_POSITIVE))
            .collect();
        // Factors of unit length: they differ by orders of magnitude.
        let factors = DMatrix::from_fn(k, k, |i, j| self.0[(i, j)] / (lengths[i] * lengths[j]));
        let cross = DMatrix::from_fn(k, n - k, |i, j| self.0[(i, k + j)] / lengths[i]);
        let eigen = factors.symmetric_eigen();
        let largest = eigen.eigenvalues.iter();
        let largest = largest.fold(0.0_f64, |most, v| most.max(*v));
        let mut products = effects;
        for (place, &value) in eigen.eigenvalues.iter().enumerate() {
            if value > NOT_SHOWN * largest {
                let along = eigen.eigenvectors.column(place).transpose() * &cross;
                products -= along.transpose() * along / value;
            }
        }
        Projected(products)
    }

    /// The further readings that are worth most beside what is known, the first of those worth as much, with what it then is worth.
    ///
    /// # Arguments
    /// - `left_out`: places of candidates that are not to be chosen.
    /// - `worth`: of all that is then known.
    pub(crate) fn best_further(
        &self,
        candidates: &[Self],
        left_out: &[usize],
        worth: &dyn Fn(&Self) -> f64,
    ) -> Option<(f64, usize)> {
        let all = candidates.iter().enumerate().rev();
        all.filter(|(place, _)| !left_out.contains(place))
            .map(|(place, further)| (worth(&self.with(further)), place))
            .max_by(|a, b| a.0.total_cmp(&b.0))
    }

    /// Places of the candidates that together are worth most beside what is known: one after the other, then exchanged one by one for others
    /// while that gains (Fedorov, Theory of Optimal Experiments, 1972, section 3.3). With what is then known.
    pub(crate) fn best_together(
        mut self,
        candidates: &[Self],
        count: usize,
        worth: &dyn Fn(&Self) -> f64,
    ) -> (Vec<usize>, Self) {
        let mut chosen = Vec::new();
        while chosen.len() < count
            && let Some((_, place)) = self.best_further(candidates, &chosen, worth)
        {
            self = self.with(&candidates[place]);
            chosen.push(place);
        }
        for _ in 0..MOST_PASSES {
            let mut gained = false;
            for slot in 0..chosen.len() {
                let without = Self(&self.0 - &candidates[chosen[slot]].0);
                if let Some((then, place)) = without.best_further(candidates, &chosen, worth)
                    && then > worth(&self) + LEAST_GAIN
                {
                    self = without.with(&candidates[place]);
                    chosen[slot] = place;
                    gained = true;
                }
            }
            if !gained {
                break;
            }
        }
        (chosen, self)
    }
}

/// Scalar products of effects that the factors leave.
#[derive(Debug, Clone)]
pub(crate) struct Projected(DMatrix<f64>);

impl Projected {
    /// The same with an effect of any size among the factors.
    pub(crate) fn without(&self, effect: usize) -> Self {
        let square = self.square(effect);
        if square <= 0.0 {
            return self.clone();
        }
        let along = self.0.column(effect).into_owned();
        Self(&self.0 - &along * along.transpose() / square)
    }

    /// Squared length of an effect: its standard errors, squared.
    pub(crate) fn square(&self, effect: usize) -> f64 {
        self.0[(effect, effect)].max(0.0)
    }

    /// Cosine of two effects.
    pub(crate) fn cosine(&self, a: usize, b: usize) -> f64 {
        let lengths = (self.square(a) * self.square(b)).sqrt();
        if lengths > 0.0 {
            (self.0[(a, b)] / lengths).clamp(-1.0, 1.0)
        } else {
            0.0
        }
    }

    /// Expected log-likelihood ratio of an effect against a rival of any size that physics allows: J = ½ ‖(I - P[factors, rival]) effect‖².
    pub(crate) fn expected_log_lr(&self, effect: usize, rival: usize, any_sign: bool) -> f64 {
        let cosine = self.cosine(effect, rival);
        let taken = if any_sign { cosine } else { cosine.max(0.0) };
        0.5 * self.square(effect) * (1.0 - taken * taken)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_orthogonal_effects_have_half_their_square() {
        // a² n / 2: n readings of size a in one, none of it in the other.
        let (a, n) = (1.5, 40);
        let first: Vec<f64> = (0..n).map(|i| if i % 2 == 0 { a } else { -a }).collect();
        let second = vec![1.0; n];
        let once = Information::of_columns(&[first.clone(), second.clone()]);
        let projected = once.projected(0);
        let expected = a * a * n as f64 / 2.0;
        assert!((projected.expected_log_lr(0, 1, true) - expected).abs() < 1e-9);
        // Twice the readings, twice the ratio.
        let twice = once.with(&once);
        let found = twice.projected(0).expected_log_lr(0, 1, true);
        assert!((found - 2.0 * expected).abs() < 1e-9);
        // A factor equal to the first leaves nothing of it.
        let absorbed = Information::of_columns(&[first.clone(), first, second]).projected(1);
        assert!(absorbed.square(0) < 1e-9);
    }

    #[test]
    fn an_effect_among_the_factors_takes_its_share() {
        // Of (1, 1) the direction (1, 0) takes half.
        let columns = [vec![1.0, 1.0], vec![3.0, 0.0]];
        let projected = Information::of_columns(&columns).projected(0).without(1);
        assert!((projected.square(0) - 1.0).abs() < 1e-12);
        assert_eq!(projected.without(1).square(0), projected.square(0));
    }

    #[test]
    fn an_effect_and_its_opposite_differ_by_sign_alone() {
        let one = vec![1.0, 2.0, 3.0];
        let other = vec![-2.0, -4.0, -6.0];
        let projected = Information::of_columns(&[one, other]).projected(0);
        assert!((projected.cosine(0, 1) + 1.0).abs() < 1e-12);
        assert!(projected.expected_log_lr(0, 1, true) < 1e-9);
        assert!((projected.expected_log_lr(0, 1, false) - 7.0).abs() < 1e-9);
    }

    #[test]
    fn an_angle_of_sixty_degrees_leaves_three_quarters() {
        let one = vec![2.0, 0.0];
        let other = vec![0.5, 0.75_f64.sqrt()];
        let projected = Information::of_columns(&[one, other]).projected(0);
        assert!((projected.expected_log_lr(0, 1, true) - 0.5 * 4.0 * 0.75).abs() < 1e-12);
    }

    #[test]
    fn the_prior_of_a_factor_limits_what_it_absorbs() {
        // A factor known to s = 1 that looks like the effect leaves 1/(1 + n) of its square: Bayesian regression by hand.
        let column = vec![1.0; 9];
        let prior = Information::of_prior(&[1.0], 1);
        let known = prior.with(&Information::of_columns(&[column.clone(), column]));
        assert!((known.projected(1).square(0) - 9.0 * 0.1).abs() < 1e-9);
    }

    #[test]
    fn standard_errors_are_those_of_a_straight_line() {
        // Intercept and slope over -1, 0, 1, 5 about their mean 1.25: 1/sqrt(Sxx), and alone 1/sqrt(sum of squares).
        let x = vec![-1.0, 0.0, 1.0, 5.0];
        let line = Information::of_columns(&[vec![1.0; 4], x, vec![0.0; 4]]);
        let slope = line.standard_error(1, |_| true).unwrap();
        assert!((slope - 20.75_f64.sqrt().recip()).abs() < 1e-12);
        let alone = line.standard_error(1, |other| other != 0).unwrap();
        assert!((alone - 27_f64.sqrt().recip()).abs() < 1e-12);
        assert_eq!(line.standard_error(2, |_| true), None);
        let determined = line.of_some(&[0, 1], &[1.0, 2.0]);
        let variances = determined.variances().unwrap();
        assert!((variances[1] - 0.25 / 20.75).abs() < 1e-12);
        assert!(line.variances().is_none());
    }

    #[test]
    fn the_best_together_need_not_contain_the_best_alone() {
        // The oblique row is longest; the two along the axes together say more than it with either.
        let of = |row: [f64; 2]| Information::of_columns(&row.map(|x| vec![x]));
        let candidates = [[1.2, 1.0], [1.5, 0.1], [0.1, 1.5]].map(of);
        let start = Information::of_prior(&[1.0; 2], 0);
        let worth = Information::log_determinant;
        let first = start.best_further(&candidates, &[], &worth).unwrap().1;
        assert_eq!(first, 0);
        let (chosen, known) = start.best_together(&candidates, 2, &worth);
        assert_eq!(chosen, [1, 2]);
        assert!(
            (known.log_determinant() - (3.26_f64.powi(2) - 0.3_f64.powi(2)).ln()).abs() < 1e-12
        );
    }
}
