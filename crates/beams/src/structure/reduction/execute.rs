//! Runs a program in as many poses as a lane holds.

use pulp::Simd;

use super::block::{Block, add, add_product, factorise, inverse, mirror, reduce, subtract_square};
use super::program::{Form, Op, Piece, Program};
use stiffbench_numeric::lanes::{Aligned, Lane};

/// The matrices of a program: `H` uncoupled halves of `N` freedoms each.
#[derive(Debug)]
pub(super) struct Memory<S: Simd, const N: usize, const H: usize> {
    slots: Vec<Aligned<[Block<S, N>; H]>>,
    /// Panels of the node at its turn, not yet divided by D.
    undivided: Vec<Aligned<[Block<S, N>; H]>>,
}

/// What gives a program its elements and hinges.
pub(super) trait Members<S: Simd, const N: usize, const H: usize> {
    fn member(&mut self, piece: Piece, form: Form) -> [Block<S, N>; H];
}

impl<S: Simd, const N: usize, const H: usize> Memory<S, N, H> {
    pub(super) fn new(simd: S, program: &Program) -> Self {
        let zeros = Aligned([[[Lane::zero(simd); N]; N]; H]);
        Self {
            slots: vec![zeros; program.slot_count],
            undivided: vec![zeros; program.widest],
        }
    }

    /// Runs a program; gives its result, of which the upper triangles count. `worst` as in [`factorise`].
    #[inline(always)]
    pub(super) fn execute<M: Members<S, N, H>>(
        &mut self,
        program: &Program,
        members: &mut M,
        worst: &mut Lane<S>,
    ) -> &[Block<S, N>; H] {
        for op in &program.ops {
            match *op {
                Op::Piece {
                    piece,
                    form,
                    into,
                    fresh,
                } => {
                    let member = members.member(piece, form);
                    for half in 0..H {
                        add(&mut self.slots[into].0[half], fresh, &member[half]);
                    }
                }
                Op::Invert { from, into, fresh } => {
                    for half in 0..H {
                        let mut block = self.slots[from].0[half];
                        factorise(&mut block, worst);
                        add(&mut self.slots[into].0[half], fresh, &inverse(&block));
                    }
                }
                Op::Add { from, into, fresh } => {
                    for half in 0..H {
                        let block = self.slots[from].0[half];
                        add(&mut self.slots[into].0[half], fresh, &block);
                    }
                }
                Op::Mirror { slot } => {
                    for half in 0..H {
                        mirror(&mut self.slots[slot].0[half]);
                    }
                }
                Op::Eliminate {
                    diagonal,
                    ref panels,
                    ref updates,
                } => {
                    for half in 0..H {
                        let mut block = self.slots[diagonal].0[half];
                        factorise(&mut block, worst);
                        for (&panel, undivided) in panels.iter().zip(&mut self.undivided) {
                            let panel = &mut self.slots[panel].0[half];
                            reduce(&block, panel, &mut undivided.0[half]);
                        }
                    }
                    for update in updates {
                        for half in 0..H {
                            let rows = self.slots[panels[update.rows]].0[half];
                            let columns = &self.undivided[update.columns].0[half];
                            let target = &mut self.slots[update.target].0[half];
                            if update.on_diagonal {
                                subtract_square(target, &rows, columns);
                            } else {
                                add_product(target, update.fresh, &rows, columns);
                            }
                        }
                    }
                }
            }
        }
        &self.slots[0].0
    }
}
