//! What a fit leaves of white rows, and some of them beside the fit to all others: deleted residuals (Cook & Weisberg, Residuals and Influence in
//! Regression, 1982, sections 2.2 and 3.2).

use nalgebra::{DMatrix, DVector};

use super::vectors::{RowVector, dot, push_orthonormal_rows, subtract};

/// White rows, and what a fit may make of them.
#[derive(Debug, Clone, Default)]
pub(crate) struct FittedRows {
    /// What the fit leaves of them.
    pub(crate) residuals: Vec<f64>,
    /// Orthonormal columns of the fit.
    columns: Vec<RowVector>,
}

/// A shift of some rows, white, beside what is free.
#[derive(Debug, Clone)]
pub(crate) struct Shift {
    column: RowVector,
    /// What the column has of each free one.
    free: Vec<f64>,
    /// The square of the whole column.
    whole: f64,
    /// The square of what is not free of it: of one row by itself, the variance of what the fit leaves of it over that of the row.
    pub(crate) square: f64,
    /// Product of the column with the residuals: of one row by itself, what the fit leaves of it.
    pub(crate) product: f64,
}

/// Some rows beside the fit to all others.
pub(crate) struct DeletedRows {
    /// Variances of what that fit leaves of them, over that of a row.
    pub(crate) variances: Vec<f64>,
    /// Squares that they add to those of the fit.
    pub(crate) squares: f64,
}

impl FittedRows {
    /// Rows of which nothing is free yet.
    pub(crate) fn new(rows: Vec<f64>) -> Self {
        Self {
            residuals: rows,
            columns: Vec::new(),
        }
    }

    /// Makes a column free, unless what is new in it is no longer than a share of its length.
    pub(crate) fn set_free(&mut self, column: RowVector, share: f64) {
        let before = self.columns.len();
        push_orthonormal_rows(&mut self.columns, column, share);
        for unit in &self.columns[before..] {
            let product = unit.dot(&self.residuals);
            subtract(&mut self.residuals[unit.rows()], product, &unit.values);
        }
    }

    pub(crate) fn squares(&self) -> f64 {
        dot(&self.residuals, &self.residuals)
    }

    /// Degrees of freedom without some rows; `None` if there are none.
    pub(crate) fn dof_without(&self, rows: usize) -> Option<f64> {
        let taken = self.columns.len() + rows;
        let dof = self.residuals.len().checked_sub(taken)?;
        (dof > 0).then_some(dof as f64)
    }

    /// The shift of some rows by a white column.
    pub(crate) fn shift(&self, column: RowVector) -> Shift {
        let units = self.columns.iter();
        let free: Vec<f64> = units.map(|unit| unit.dot_part(&column)).collect();
        let whole = dot(&column.values, &column.values);
        Shift {
            square: whole - dot(&free, &free),
            product: column.dot(&self.residuals),
            whole,
            column,
            free,
        }
    }

    /// The shift of one row by itself.
    pub(crate) fn shift_of_row(&self, row: usize) -> Shift {
        self.shift(RowVector {
            first: row,
            values: vec![1.0],
        })
    }

    /// Some rows, each by itself, beside the fit to all others.
    ///
    /// # Arguments
    /// - `largest_share`: rows that determine more than this share of their own prediction have no witness, which is `None`.
    pub(crate) fn without(&self, rows: &[usize], largest_share: f64) -> Option<DeletedRows> {
        let shifts: Vec<Shift> = rows.iter().map(|row| self.shift_of_row(*row)).collect();
        let count = shifts.len();
        let free = DMatrix::from_fn(count, count, |i, j| shifts[i].common(&shifts[j]));
        if free.clone().symmetric_eigenvalues().min() < 1.0 - largest_share {
            return None;
        }
        let inverse = free.try_inverse()?;
        let own = DVector::from_fn(count, |i, _| shifts[i].product);
        Some(DeletedRows {
            squares: own.dot(&(&inverse * &own)),
            variances: inverse.diagonal().iter().copied().collect(),
        })
    }
}

impl Shift {
    /// Whether what is free leaves more than a share of its square.
    pub(crate) fn is_seen(&self, share: f64) -> bool {
        self.square > share * self.whole
    }

    /// Fall of the squares with it.
    pub(crate) fn fall(&self) -> f64 {
        self.product * self.product / self.square
    }

    /// By how much the rows are off.
    pub(crate) fn size(&self) -> f64 {
        self.product / self.square
    }

    /// The same over its standard error: the deleted residual.
    pub(crate) fn ratio(&self) -> f64 {
        self.product / self.square.sqrt()
    }

    /// Product of what is not free of two shifts.
    fn common(&self, other: &Self) -> f64 {
        self.column.dot_part(&other.column) - dot(&self.free, &other.free)
    }

    /// The same shift with another one free.
    pub(crate) fn beside(mut self, other: &Self) -> Self {
        let both = self.common(other);
        self.product -= both / other.square * other.product;
        self.square -= both * both / other.square;
        self
    }
}

/// Takes suspects away one after the other, the farthest first, and gives those up to the last that is too far for noise: until all are out, each
/// makes the others look good (generalised extreme studentised deviate: Rosner, Technometrics 25, 1983).
///
/// # Arguments
/// - `most`: how many may be bad.
/// - `level`: chance of noise from which one is good.
/// - `next`: the farthest beside those that were taken, with its chance.
pub(crate) fn up_to_last_bad<T>(
    most: usize,
    level: f64,
    mut next: impl FnMut(&[(T, f64)]) -> Option<(T, f64)>,
) -> Vec<(T, f64)> {
    let mut taken = Vec::new();
    while taken.len() < most
        && let Some(farthest) = next(&taken)
    {
        taken.push(farthest);
    }
    let last = taken.iter().rposition(|(_, chance)| *chance <= level);
    taken.truncate(last.map_or(0, |last| last + 1));
    taken
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A straight line through some values less two of them, by the formulas of the line.
    #[test]
    fn deleted_rows_add_what_the_line_through_the_others_leaves() {
        let x = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0];
        let y = [0.3, 1.1, 5.0, 2.8, 1.0, 5.2];
        let deleted = [2, 4];
        let others = [0, 1, 3, 5].map(|row: usize| (x[row], y[row]));
        let line = |points: &[(f64, f64)]| {
            let n = points.len() as f64;
            let [mx, my] = [0, 1].map(|i| {
                let values = points.iter().map(|(x, y)| [*x, *y][i]);
                values.sum::<f64>() / n
            });
            let slope = points.iter().map(|(x, y)| (x - mx) * (y - my));
            let square = points.iter().map(|(x, _)| (x - mx).powi(2));
            let slope = slope.sum::<f64>() / square.sum::<f64>();
            move |x: f64| my + slope * (x - mx)
        };
        let squares = |points: &[(f64, f64)]| {
            let at = line(points);
            points
                .iter()
                .map(|(x, y)| (y - at(*x)).powi(2))
                .sum::<f64>()
        };
        let all: Vec<(f64, f64)> = x.into_iter().zip(y).collect();
        let whole = line(&all);
        let mut fitted = FittedRows::new(y.to_vec());
        for column in [vec![1.0; 6], x.to_vec()] {
            fitted.set_free(column.into(), 1e-9);
        }
        for ((x, y), left) in all.iter().zip(&fitted.residuals) {
            assert!((y - whole(*x) - left).abs() < 1e-12);
        }
        let found = fitted.without(&deleted, 1.0).unwrap();
        assert!((squares(&all) - squares(&others) - found.squares).abs() < 1e-12);
        assert_eq!(fitted.dof_without(2), Some(2.0));
        assert_eq!(fitted.dof_without(4), None);
        // One row shows no line.
        assert!(fitted.without(&[0, 1, 2, 3, 4], 0.9).is_none());
    }

    #[test]
    fn a_shift_is_the_distance_from_the_others() {
        let mut fitted = FittedRows::new(vec![1.0, 3.0, 5.0, 6.0, 10.0]);
        for (first, count) in [(0, 2), (2, 3)] {
            let values = vec![1.0; count];
            fitted.set_free(RowVector { first, values }, 1e-9);
        }
        let shift = |row: usize| fitted.shift_of_row(row);
        // The last is 4.5 above the mean of the two others.
        let last = shift(4);
        assert!((last.size() - 4.5).abs() < 1e-12);
        assert!((last.square - 2.0 / 3.0).abs() < 1e-12);
        assert!((last.ratio() - 4.5 / 1.5_f64.sqrt()).abs() < 1e-12);
        assert!((last.fall() - 4.5 * 3.0).abs() < 1e-12);
        // Beside a free shift of one of them it stands against the other alone; of a pair nothing is left then.
        assert!((shift(4).beside(&shift(3)).size() - 5.0).abs() < 1e-12);
        assert!((shift(4).beside(&shift(0)).size() - 4.5).abs() < 1e-12);
        assert!(!shift(0).beside(&shift(1)).is_seen(1e-9) && shift(0).is_seen(0.4));
    }
}
