//! Scalar products of what readings can show, which add up from one set of readings to the next.

use nalgebra::DMatrix;

/// Scalar products of white columns: those of the factors first, then those of effects.
///
/// Everything a comparison of two effects needs is in them, and the products of old and of planned readings simply add up.
#[derive(Debug, Clone)]
pub(super) struct Gram {
    factors: usize,
    products: DMatrix<f64>,
}

/// Eigenvalues below this share of the largest are directions that the readings do not show.
const NOT_SHOWN: f64 = 1e-13;

impl Gram {
    /// Products of what is known of the factors before any reading; `columns` effects are to come.
    pub(super) fn of_prior(prior_sd: &[f64], columns: usize) -> Self {
        let factors = prior_sd.len();
        let mut products = DMatrix::zeros(factors + columns, factors + columns);
        for (place, prior_sd) in prior_sd.iter().enumerate() {
            products[(place, place)] = prior_sd.powi(-2);
        }
        Self { factors, products }
    }

    /// Products of white columns, the factors' first.
    pub(super) fn of_columns(factors: usize, columns: &[Vec<f64>]) -> Self {
        let length = columns.first().map_or(0, Vec::len);
        let flat = DMatrix::from_fn(length, columns.len(), |row, column| columns[column][row]);
        Self {
            factors,
            products: flat.tr_mul(&flat),
        }
    }

    /// Adds the products of further readings.
    pub(super) fn add(&mut self, other: &Self) {
        self.products += &other.products;
    }

    /// Scalar products of the effects with the factors projected out.
    pub(super) fn projected(&self) -> Projected {
        let (k, n) = (self.factors, self.products.nrows());
        let effects = self.products.view((k, k), (n - k, n - k)).into_owned();
        if k == 0 {
            return Projected(effects);
        }
        let lengths: Vec<f64> = (0..k)
            .map(|i| self.products[(i, i)].sqrt().max(f64::MIN_POSITIVE))
            .collect();
        // Factors of unit length: they differ by orders of magnitude.
        let factors = DMatrix::from_fn(k, k, |i, j| {
            self.products[(i, j)] / (lengths[i] * lengths[j])
        });
        let cross = DMatrix::from_fn(k, n - k, |i, j| self.products[(i, k + j)] / lengths[i]);
        let eigen = factors.symmetric_eigen();
        let largest = eigen
            .eigenvalues
            .iter()
            .fold(0.0_f64, |most, v| most.max(*v));
        let mut products = effects;
        for (place, &value) in eigen.eigenvalues.iter().enumerate() {
            if value > NOT_SHOWN * largest {
                let along = eigen.eigenvectors.column(place).transpose() * &cross;
                products -= along.transpose() * along / value;
            }
        }
        Projected(products)
    }
}

/// Scalar products of effects that the factors leave.
#[derive(Debug, Clone)]
pub(super) struct Projected(DMatrix<f64>);

impl Projected {
    /// The same with an effect of any size among the factors.
    pub(super) fn without(&self, effect: usize) -> Self {
        let square = self.square(effect);
        if square <= 0.0 {
            return self.clone();
        }
        let along = self.0.column(effect).into_owned();
        Self(&self.0 - &along * along.transpose() / square)
    }

    /// Squared length of an effect: its standard errors, squared.
    pub(super) fn square(&self, effect: usize) -> f64 {
        self.0[(effect, effect)].max(0.0)
    }

    /// Cosine of two effects.
    pub(super) fn cosine(&self, a: usize, b: usize) -> f64 {
        let lengths = (self.square(a) * self.square(b)).sqrt();
        if lengths > 0.0 {
            (self.0[(a, b)] / lengths).clamp(-1.0, 1.0)
        } else {
            0.0
        }
    }

    /// Expected log-likelihood ratio of an effect against a rival of any size that physics allows: J = ½ ‖(I - P[factors, rival]) effect‖².
    pub(super) fn expected_log_lr(&self, effect: usize, rival: usize, any_sign: bool) -> f64 {
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
        let gram = Gram::of_columns(0, &[first.clone(), second.clone()]);
        let projected = gram.projected();
        let expected = a * a * n as f64 / 2.0;
        assert!((projected.expected_log_lr(0, 1, true) - expected).abs() < 1e-9);
        // Twice the readings, twice the ratio.
        let mut twice = gram.clone();
        twice.add(&gram);
        let found = twice.projected().expected_log_lr(0, 1, true);
        assert!((found - 2.0 * expected).abs() < 1e-9);
        // A factor equal to the first leaves nothing of it.
        let absorbed = Gram::of_columns(1, &[first.clone(), first, second]).projected();
        assert!(absorbed.square(0) < 1e-9);
    }

    #[test]
    fn an_effect_among_the_factors_takes_its_share() {
        // Of (1, 1) the direction (1, 0) takes half.
        let columns = [vec![1.0, 1.0], vec![3.0, 0.0]];
        let projected = Gram::of_columns(0, &columns).projected().without(1);
        assert!((projected.square(0) - 1.0).abs() < 1e-12);
        assert_eq!(projected.without(1).square(0), projected.square(0));
    }

    #[test]
    fn an_effect_and_its_opposite_differ_by_sign_alone() {
        let one = vec![1.0, 2.0, 3.0];
        let other = vec![-2.0, -4.0, -6.0];
        let projected = Gram::of_columns(0, &[one, other]).projected();
        assert!((projected.cosine(0, 1) + 1.0).abs() < 1e-12);
        assert!(projected.expected_log_lr(0, 1, true) < 1e-9);
        assert!((projected.expected_log_lr(0, 1, false) - 7.0).abs() < 1e-9);
    }

    #[test]
    fn an_angle_of_sixty_degrees_leaves_three_quarters() {
        let one = vec![2.0, 0.0];
        let other = vec![0.5, 0.75_f64.sqrt()];
        let projected = Gram::of_columns(0, &[one, other]).projected();
        assert!((projected.expected_log_lr(0, 1, true) - 0.5 * 4.0 * 0.75).abs() < 1e-12);
    }

    #[test]
    fn the_prior_of_a_factor_limits_what_it_absorbs() {
        // A factor known to s = 1 that looks like the effect leaves 1/(1 + n) of its square: Bayesian regression by hand.
        let column = vec![1.0; 9];
        let mut gram = Gram::of_prior(&[1.0], 1);
        gram.add(&Gram::of_columns(1, &[column.clone(), column]));
        assert!((gram.projected().square(0) - 9.0 * 0.1).abs() < 1e-9);
    }
}
