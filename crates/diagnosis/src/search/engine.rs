//! Scores of shapes, and what all that is heavy in a search has to offer.
//!
//! With s a shape (a column of the rows), W the whitening and P the projection that leaves what the baseline does not absorb,
//!
//! ```text
//!   square = ‖P W s‖²,    product = (P W s)·r,    Δχ²(a) = 2 a product - a² square
//! ```
//!
//! r being the white residual of the baseline. The score of an amplitude is the fall of the weighted sum of squares: the score statistic of
//! the added parameter (C. R. Rao, Proc. Cambridge Phil. Soc. 44 (1948)).

use std::ops::Range;

use super::null_noise::NullNoise;
use super::vectors::{RowVector, dot, subtract};

/// A shape, white and projected, with the residuals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moments {
    /// Its squared length, in standard errors.
    pub square: f64,
    /// Its product with the white residual.
    pub product: f64,
}

/// Two shapes, the second made orthogonal to the first: sine and cosine of a candidate with a phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PairMoments {
    /// Of the first.
    pub first: Moments,
    /// Of what the second has beside it.
    pub second: Moments,
}

/// The best amplitude of a shape.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BestAmplitude {
    /// As a multiple of the shape.
    pub multiple: f64,
    /// Fall of the weighted squares.
    pub delta_chi2: f64,
    /// The fall that the forbidden sign would give; 0 where the best amplitude has the allowed one.
    pub forbidden_delta_chi2: f64,
}

impl Moments {
    /// Those of a white vector.
    #[must_use]
    pub fn of_white(white: &[f64], residual: &[f64]) -> Self {
        Self {
            square: dot(white, white),
            product: dot(white, residual),
        }
    }

    /// Fall of the weighted squares by the best of all amplitudes; none by a shape without length.
    #[must_use]
    pub fn delta_chi2(&self) -> f64 {
        if self.square > 0.0 {
            self.product * self.product / self.square
        } else {
            0.0
        }
    }

    /// The best amplitude between a lowest and a highest multiple of a shape with a length.
    #[must_use]
    pub fn best_within(&self, [lowest, highest]: [f64; 2]) -> BestAmplitude {
        let free = self.product / self.square;
        let multiple = free.clamp(lowest, highest);
        let is_forbidden = lowest >= 0.0 && free < 0.0;
        BestAmplitude {
            multiple,
            delta_chi2: multiple * (2.0 * self.product - multiple * self.square),
            forbidden_delta_chi2: if is_forbidden { self.delta_chi2() } else { 0.0 },
        }
    }
}

impl PairMoments {
    /// Those of two white and projected vectors; a second that carries no information beside the first has no product.
    ///
    /// # Arguments
    /// - `least`: share of its square that the second must keep beside the first to say something.
    #[must_use]
    pub fn of_white(first: &[f64], second: &[f64], residual: &[f64], least: f64) -> Self {
        let first_moments = Moments::of_white(first, residual);
        let whole = dot(second, second);
        let share = dot(first, second) / first_moments.square.max(f64::MIN_POSITIVE);
        let mut rest = second.to_vec();
        subtract(&mut rest, share, first);
        let mut second_moments = Moments::of_white(&rest, residual);
        if second_moments.square < least * whole {
            second_moments.product = 0.0;
        }
        Self {
            first: first_moments,
            second: second_moments,
        }
    }

    /// Fall of the weighted squares by the best amplitude and phase.
    #[must_use]
    pub fn delta_chi2(&self) -> f64 {
        self.first.delta_chi2() + self.second.delta_chi2()
    }
}

/// A shape, or a pair of shapes, as null samples see it.
#[derive(Debug, Clone)]
pub struct NullShape {
    /// Number of its family: the maximum of each is kept.
    pub family: usize,
    /// White vectors, before or after projection; of unit length after it, and orthogonal if they are two.
    pub units: Vec<RowVector>,
    /// Length of the first as it stands for the multiples, in standard errors.
    pub length: f64,
    /// Smallest and largest multiple.
    pub multiples: [f64; 2],
}

/// Makes the shapes of one group when they are wanted: those of all groups together would fill the memory.
///
/// Shapes of one group are much alike before projection and may share bases; it changes no result beyond rounding and their tolerance.
pub type NullShapes<'a> = Box<dyn FnOnce() -> Vec<NullShape> + Send + 'a>;

/// What the whole search gives on noise alone: for each family its largest Δχ², one a sample.
pub type NullMaxima = Vec<Vec<f64>>;

/// Scores of shapes against one white residual in one white space, and null samples of them.
///
/// Implementations differ in speed alone: [`super::Batched`] is for searches, the plain one of the tests is what it is compared with.
pub trait ScoreEngine: Sync {
    /// Moments of a shape that is zero outside some rows, a union of blocks.
    ///
    /// # Arguments
    /// - `scratch`: memory.
    fn moments(&self, shape: &[f64], rows: &Range<usize>, scratch: &mut Vec<f64>) -> Moments;

    /// Moments of two shapes that are zero outside some rows, a union of blocks, the second made orthogonal to the first.
    ///
    /// # Arguments
    /// - `scratch`: memory.
    fn pair_moments(
        &self,
        shapes: [&[f64]; 2],
        rows: &Range<usize>,
        scratch: &mut Vec<f64>,
    ) -> PairMoments;

    /// Maxima of families over their shapes in samples of noise.
    ///
    /// # Arguments
    /// - `families`: how many there are.
    /// - `blocks`: ranges that the rows divide into; shapes are much alike within each.
    fn null_maxima(
        &self,
        groups: Vec<NullShapes<'_>>,
        families: usize,
        blocks: &[Range<usize>],
        noise: &NullNoise<'_>,
    ) -> NullMaxima;
}

/// Shapes of one candidate without those that nearly have the direction of an earlier one and as free an amplitude: they add nothing to a
/// maximum.
///
/// # Arguments
/// - `along_basis`: products of a white vector with the columns of the baseline.
/// - `same`: cosine from which two directions count as one.
#[must_use]
pub fn without_duplicates(
    shapes: Vec<NullShape>,
    along_basis: impl Fn(&RowVector) -> Vec<f64>,
    same: f64,
) -> Vec<NullShape> {
    let mut kept: Vec<NullShape> = Vec::new();
    // Those of any amplitude, with their products with the baseline.
    let mut free: Vec<(usize, Vec<f64>)> = Vec::new();
    for shape in shapes {
        if shape.units.len() == 1 && shape.multiples[1] == f64::INFINITY {
            let unit = &shape.units[0];
            let absorbed = along_basis(unit);
            let is_known = free.iter().any(|(place, other)| {
                let cosine = kept[*place].units[0].dot_part(unit) - dot(other, &absorbed);
                kept[*place].multiples == shape.multiples && cosine > same
            });
            if is_known {
                continue;
            }
            free.push((kept.len(), absorbed));
        }
        kept.push(shape);
    }
    kept
}
