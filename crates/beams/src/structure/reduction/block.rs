//! Small symmetric matrices of lanes: LDLᵀ, inverse, and what the elimination of a node takes.

use pulp::Simd;

use stiffbench_numeric::simd::{Lane, Number, multiply_add, multiply_subtract};

/// A matrix, row by row; of a symmetric one the upper triangle.
pub(super) type Block<S, const N: usize> = [[Lane<S>; N]; N];

/// LDLᵀ in place: Lᵀ above the diagonal, D⁻¹ on it.
///
/// `worst` keeps the largest ratio of a diagonal entry to its pivot: how many digits were lost.
#[inline(always)]
pub(super) fn factorise<S: Simd, const N: usize>(block: &mut Block<S, N>, worst: &mut Lane<S>) {
    let mut before = block[0];
    for k in 0..N {
        before[k] = block[k][k];
    }
    for k in 0..N {
        let row = block[k];
        let inverse = row[k].inverse();
        *worst = (before[k] * inverse).abs().max(*worst);
        for i in k + 1..N {
            let factor = row[i] * inverse;
            for j in i..N {
                block[i][j] = multiply_subtract(factor, row[j], block[i][j]);
            }
            block[k][i] = factor;
        }
        block[k][k] = inverse;
    }
}

/// Upper triangle of the inverse of a factorised matrix: U⁻¹ D⁻¹ U⁻ᵀ with U = Lᵀ.
#[inline(always)]
pub(super) fn inverse<S: Simd, const N: usize>(factor: &Block<S, N>) -> Block<S, N> {
    let mut unit = *factor;
    for i in (0..N).rev() {
        for j in i + 1..N {
            let mut sum = factor[i][j];
            for k in i + 1..j {
                sum = multiply_add(unit[i][k], factor[k][j], sum);
            }
            unit[i][j] = -sum;
        }
    }
    let mut inverse = unit;
    for j in 0..N {
        for i in 0..=j {
            // Entry (j, j) of U⁻¹ is one.
            let mut sum = if i == j {
                factor[j][j]
            } else {
                unit[i][j] * factor[j][j]
            };
            for k in j + 1..N {
                sum = multiply_add(unit[i][k] * factor[k][k], unit[j][k], sum);
            }
            inverse[i][j] = sum;
        }
    }
    inverse
}

/// Solves with a factorised matrix.
#[inline(always)]
pub(super) fn solve<S: Simd, const N: usize>(
    factor: &Block<S, N>,
    right_side: &[Lane<S>; N],
) -> [Lane<S>; N] {
    let mut x = *right_side;
    for i in 0..N {
        for k in i + 1..N {
            x[k] = multiply_subtract(factor[i][k], x[i], x[k]);
        }
        x[i] = x[i] * factor[i][i];
    }
    back_substitute(factor, &mut x);
    x
}

/// Multiplies by L⁻ᵀ.
#[inline(always)]
pub(super) fn back_substitute<S: Simd, const N: usize>(factor: &Block<S, N>, x: &mut [Lane<S>; N]) {
    for i in (0..N).rev() {
        for k in i + 1..N {
            x[i] = multiply_subtract(factor[i][k], x[k], x[i]);
        }
    }
}

/// Multiplies a panel by L⁻¹ into `undivided`, and that by D⁻¹ into the panel.
#[inline(always)]
pub(super) fn reduce<S: Simd, const N: usize>(
    factor: &Block<S, N>,
    panel: &mut Block<S, N>,
    undivided: &mut Block<S, N>,
) {
    for i in 0..N {
        for j in 0..N {
            let mut sum = panel[i][j];
            for k in 0..i {
                sum = multiply_subtract(factor[k][i], undivided[k][j], sum);
            }
            undivided[i][j] = sum;
        }
    }
    for i in 0..N {
        for j in 0..N {
            panel[i][j] = undivided[i][j] * factor[i][i];
        }
    }
}

/// The upper triangle of target - rowsᵀ columns.
#[inline(always)]
pub(super) fn subtract_square<S: Simd, const N: usize>(
    target: &mut Block<S, N>,
    rows: &Block<S, N>,
    columns: &Block<S, N>,
) {
    for i in 0..N {
        for j in i..N {
            let mut sum = target[i][j];
            for k in 0..N {
                sum = multiply_subtract(rows[k][i], columns[k][j], sum);
            }
            target[i][j] = sum;
        }
    }
}

/// target + rowsᵀ columns; without the target if that is `fresh`.
#[inline(always)]
pub(super) fn add_product<S: Simd, const N: usize>(
    target: &mut Block<S, N>,
    fresh: bool,
    rows: &Block<S, N>,
    columns: &Block<S, N>,
) {
    for i in 0..N {
        for j in 0..N {
            let mut sum = rows[0][i] * columns[0][j];
            for k in 1..N {
                sum = multiply_add(rows[k][i], columns[k][j], sum);
            }
            target[i][j] = if fresh { sum } else { target[i][j] + sum };
        }
    }
}

/// Adds an upper triangle to another, or sets that if it is `fresh`.
#[inline(always)]
pub(super) fn add<S: Simd, const N: usize>(
    target: &mut Block<S, N>,
    fresh: bool,
    block: &Block<S, N>,
) {
    for i in 0..N {
        for j in i..N {
            target[i][j] = if fresh {
                block[i][j]
            } else {
                target[i][j] + block[i][j]
            };
        }
    }
}

/// Adds a whole matrix to another.
#[inline(always)]
pub(super) fn add_whole<S: Simd>(sum: &mut Block<S, 6>, block: &Block<S, 6>) {
    for i in 0..6 {
        for j in 0..6 {
            sum[i][j] += block[i][j];
        }
    }
}

/// Fills the lower triangle.
#[inline(always)]
pub(super) fn mirror<S: Simd, const N: usize>(block: &mut Block<S, N>) {
    for i in 0..N {
        for j in 0..i {
            block[i][j] = block[j][i];
        }
    }
}
