//! LDLᵀ of a symmetric matrix of 3 × 3 blocks, in many poses at once.

use pulp::Simd;

use super::plan::{PanelPlace, Plan, Target};
use crate::structure::solve::LOST_PIVOT;
use stiffbench_numeric::lanes::{Lane, Number, dot, multiply_add, multiply_subtract};

/// A block, row by row. Three freedoms a block: nine sums and the six numbers they need stay in the registers of every machine.
pub(super) type Block<S> = [[Lane<S>; 3]; 3];

#[inline(always)]
pub(super) fn zero<S: Simd>(simd: S) -> Block<S> {
    [[Lane::zero(simd); 3]; 3]
}

/// A block in memory: lanes start on cache lines.
#[derive(Debug, Clone, Copy)]
#[repr(C, align(64))]
struct Stored<S: Simd>(Block<S>);

/// The matrix, then its factor, in the same memory.
///
/// After [`Elimination::factorise`] the diagonal blocks hold Lᵀ above the diagonal and D⁻¹ on it, the panels D⁻¹ L⁻¹ times what
/// they were.
#[derive(Debug, Clone)]
pub(super) struct Elimination<S: Simd> {
    simd: S,
    diagonals: Vec<Stored<S>>,
    panels: Vec<Stored<S>>,
    /// Panels of the column at its turn, not yet divided by D.
    undivided: Vec<Stored<S>>,
    /// Displacements of each column's freedoms under three loads, one a column of the block.
    fields: Vec<Stored<S>>,
}

impl<S: Simd> Elimination<S> {
    pub(super) fn new(simd: S, plan: &Plan) -> Self {
        let zeros = |count| vec![Stored(zero(simd)); count];
        Self {
            simd,
            diagonals: zeros(plan.columns.len()),
            panels: zeros(plan.panel_count),
            undivided: zeros(plan.widest()),
            fields: zeros(plan.columns.len()),
        }
    }

    /// Sets the matrix to zero.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        let zero = Lane::zero(self.simd);
        for block in self.diagonals.iter_mut().chain(&mut self.panels) {
            for i in 0..3 {
                for j in 0..3 {
                    block.0[i][j] = zero;
                }
            }
        }
    }

    /// Adds to the block on the diagonal of a column; what is below its diagonal is not read.
    #[inline(always)]
    pub(super) fn add_to_diagonal(&mut self, column: usize, block: &Block<S>) {
        let target = &mut self.diagonals[column].0;
        for i in 0..3 {
            for j in i..3 {
                target[i][j] += block[i][j];
            }
        }
    }

    /// Adds to a block off the diagonal.
    #[inline(always)]
    pub(super) fn add_to_panel(&mut self, place: PanelPlace, block: &Block<S>) {
        let target = &mut self.panels[place.panel].0;
        if place.transposed {
            for i in 0..3 {
                for j in 0..3 {
                    target[i][j] += block[j][i];
                }
            }
        } else {
            for i in 0..3 {
                for j in 0..3 {
                    target[i][j] += block[i][j];
                }
            }
        }
    }

    /// Factorises; counts in `lost`, pose by pose, the pivots that are rounding.
    #[inline(always)]
    pub(super) fn factorise(&mut self, plan: &Plan, lost: &mut Lane<S>) {
        // The entry of the matrix that a pivot is compared with must be read before any update reaches it.
        for (field, block) in self.fields.iter_mut().zip(&self.diagonals) {
            for k in 0..3 {
                field.0[0][k] = block.0[k][k];
            }
        }
        for (position, column) in plan.columns.iter().enumerate() {
            let assembled = &self.fields[position].0[0];
            factorise_block(&mut self.diagonals[position].0, assembled, lost);
            let (before, after) = self.diagonals.split_at_mut(position + 1);
            let factor = &before[position].0;
            let next_panel = column.first_panel + column.neighbours.len();
            let (done, later) = self.panels.split_at_mut(next_panel);
            let own = &mut done[column.first_panel..];
            for (panel, undivided) in own.iter_mut().zip(&mut self.undivided) {
                reduce_panel(factor, &mut panel.0, &mut undivided.0);
            }
            for update in &column.updates {
                let rows = &own[update.rows].0;
                let columns = &self.undivided[update.columns].0;
                let target = match update.target {
                    Target::Diagonal(column) => &mut after[column - position - 1].0,
                    Target::Panel(panel) => &mut later[panel - next_panel].0,
                };
                subtract_product(target, rows, columns);
            }
        }
    }

    /// Inverse of what is left of the matrix at the end node, all other nodes free: the compliance of the end.
    ///
    /// Blocks by half, as [`IN_PLANE`](super::plan::IN_PLANE) and [`ACROSS`](super::plan::ACROSS) number them.
    #[inline(always)]
    pub(super) fn end_compliance(&self, plan: &Plan) -> [[Block<S>; 2]; 2] {
        let last = plan.columns.len() - 1;
        let in_plane = invert_factor(&self.diagonals[last].0);
        let across = invert_factor(&self.diagonals[last - 1].0);
        let column = &plan.columns[last - 1];
        if column.neighbours.is_empty() {
            let uncoupled = zero(self.simd);
            return [[in_plane, uncoupled], [uncoupled, across]];
        }
        // With M = K_aa⁻¹ K_ai: C_ai = -M C_ii, C_aa = K_aa⁻¹ + M C_ii Mᵀ.
        let mut coupling = self.panels[column.first_panel].0;
        for j in 0..3 {
            let solved = back_substitute(
                &self.diagonals[last - 1].0,
                [coupling[0][j], coupling[1][j], coupling[2][j]],
            );
            for k in 0..3 {
                coupling[k][j] = solved[k];
            }
        }
        let (mut mixed, mut transposed, mut own) = (coupling, coupling, across);
        for i in 0..3 {
            for j in 0..3 {
                // C_ii is symmetric: its rows serve as its columns.
                mixed[i][j] = -dot(&coupling[i], &in_plane[j]);
                transposed[j][i] = mixed[i][j];
            }
        }
        for i in 0..3 {
            for j in 0..3 {
                own[i][j] -= dot(&mixed[i], &coupling[j]);
            }
        }
        [[in_plane, transposed], [mixed, own]]
    }

    /// Displacements everywhere from those of the end under three loads on it, given by half.
    #[inline(always)]
    pub(super) fn respond(&mut self, plan: &Plan, end: &[Block<S>; 2]) {
        let last = plan.columns.len() - 1;
        self.fields[last].0 = end[0];
        self.fields[last - 1].0 = end[1];
        for (position, column) in plan.columns[..last - 1].iter().enumerate().rev() {
            let (before, after) = self.fields.split_at_mut(position + 1);
            let factor = &self.diagonals[position].0;
            let panels = &self.panels[column.first_panel..];
            let mut sums = zero(self.simd);
            for (panel, &neighbour) in panels.iter().zip(&column.neighbours) {
                let field = &after[neighbour - position - 1].0;
                let panel = &panel.0;
                for k in 0..3 {
                    for j in 0..3 {
                        for n in 0..3 {
                            sums[k][n] = multiply_subtract(panel[k][j], field[j][n], sums[k][n]);
                        }
                    }
                }
            }
            for n in 0..3 {
                let solved = back_substitute(factor, [sums[0][n], sums[1][n], sums[2][n]]);
                for k in 0..3 {
                    before[position].0[k][n] = solved[k];
                }
            }
        }
    }

    /// Displacements of [`Elimination::respond`]: freedoms × loads.
    #[inline(always)]
    pub(super) fn field(&self, column: usize) -> &Block<S> {
        &self.fields[column].0
    }
}

/// LDLᵀ of a block in place: Lᵀ above the diagonal, D⁻¹ on it; what is below is not read.
#[inline(always)]
fn factorise_block<S: Simd>(block: &mut Block<S>, assembled: &[Lane<S>; 3], lost: &mut Lane<S>) {
    let (a, b, c) = (block[0][0], block[0][1], block[0][2]);
    let (d, e, f) = (block[1][1], block[1][2], block[2][2]);
    let first = a.inverse();
    let (l1, l2) = (b * first, c * first);
    let d = multiply_subtract(l1, b, d);
    let e = multiply_subtract(l1, c, e);
    let f = multiply_subtract(l2, c, f);
    let second = d.inverse();
    let l3 = e * second;
    let third = multiply_subtract(l3, e, f).inverse();
    count_lost_pivots(assembled[0] * first, lost);
    count_lost_pivots(assembled[1] * second, lost);
    count_lost_pivots(assembled[2] * third, lost);
    block[0] = [first, l1, l2];
    block[1][1] = second;
    block[1][2] = l3;
    block[2][2] = third;
}

/// Counts poses in which a pivot is rounding; `ratio` is assembled entry by pivot.
#[inline(always)]
fn count_lost_pivots<S: Simd>(ratio: Lane<S>, lost: &mut Lane<S>) {
    *lost += ratio.fault_unless_below(ratio.of(1.0 / LOST_PIVOT));
    *lost += (-ratio).fault_unless_below(ratio.of(0.0));
}

/// Multiplies a panel by L⁻¹ into `undivided`, and that by D⁻¹ into the panel.
#[inline(always)]
fn reduce_panel<S: Simd>(factor: &Block<S>, panel: &mut Block<S>, undivided: &mut Block<S>) {
    for c in 0..3 {
        let first = panel[0][c];
        let second = multiply_subtract(factor[0][1], first, panel[1][c]);
        let third = multiply_subtract(factor[0][2], first, panel[2][c]);
        let third = multiply_subtract(factor[1][2], second, third);
        undivided[0][c] = first;
        undivided[1][c] = second;
        undivided[2][c] = third;
        panel[0][c] = first * factor[0][0];
        panel[1][c] = second * factor[1][1];
        panel[2][c] = third * factor[2][2];
    }
}

/// target -= rowsᵀ columns.
#[inline(always)]
fn subtract_product<S: Simd>(target: &mut Block<S>, rows: &Block<S>, columns: &Block<S>) {
    let mut sums = [[target[0][0]; 3]; 3];
    for i in 0..3 {
        for j in 0..3 {
            sums[i][j] = target[i][j];
        }
    }
    for k in 0..3 {
        for i in 0..3 {
            for j in 0..3 {
                sums[i][j] = multiply_subtract(rows[k][i], columns[k][j], sums[i][j]);
            }
        }
    }
    for i in 0..3 {
        for j in 0..3 {
            target[i][j] = sums[i][j];
        }
    }
}

/// L⁻ᵀ v of a factorised block.
#[inline(always)]
fn back_substitute<S: Simd>(
    factor: &Block<S>,
    [first, second, third]: [Lane<S>; 3],
) -> [Lane<S>; 3] {
    let second = multiply_subtract(factor[1][2], third, second);
    let first = multiply_subtract(factor[0][2], third, first);
    let first = multiply_subtract(factor[0][1], second, first);
    [first, second, third]
}

/// L⁻ᵀ D⁻¹ L⁻¹ of a factorised block.
#[inline(always)]
fn invert_factor<S: Simd>(factor: &Block<S>) -> Block<S> {
    let (l1, l2, l3) = (factor[0][1], factor[0][2], factor[1][2]);
    let (d1, d2, d3) = (factor[0][0], factor[1][1], factor[2][2]);
    // L⁻¹ = [1; -l1 1; m -l3 1].
    let m = multiply_add(l1, l3, -l2);
    let (c33, c23, c13) = (d3, -(l3 * d3), m * d3);
    let c22 = multiply_subtract(l3, c23, d2);
    let c12 = multiply_subtract(l3, c13, -(l1 * d2));
    let c11 = multiply_add(m, c13, multiply_add(l1 * d2, l1, d1));
    [[c11, c12, c13], [c12, c22, c23], [c13, c23, c33]]
}
