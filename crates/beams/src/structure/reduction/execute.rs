//! Runs a schedule in as many poses as a lane holds.

use pulp::Simd;

use super::block::{
    Block, add, add_product, back_substitute, factorise, inverse, mirror, reduce, solve,
    subtract_square,
};
use super::schedule::{
    Joined, Op, PanelMove, ReductionForm, Schedule, SchedulePiece, Slot, Update,
};
use stiffbench_numeric::simd::{Aligned, Lane, Number, multiply_add, multiply_subtract};

/// Why loads are never followed to hinges that struts stand over.
const NO_DERIVATIVES: &str = "derivatives beside struts are for the general solver";

/// Most loads that are followed at once.
pub(super) const LOADS: usize = 6;

/// Forces on a compliance or motions of a stiffness: by uncoupled half, load and freedom.
pub(super) type States<S, const N: usize, const H: usize> = [[[Lane<S>; N]; LOADS]; H];

/// The matrices of a schedule: `H` uncoupled halves of `N` freedoms each.
#[derive(Debug)]
pub(super) struct SolverBuffers<S: Simd, const N: usize, const H: usize> {
    slots: Vec<Aligned<[Block<S, N>; H]>>,
    /// Panels of the node at its turn, not yet divided by D.
    undivided: Vec<Aligned<[Block<S, N>; H]>>,
    /// What each matrix carries, or how it moves, under the loads followed last; empty if loads are never followed.
    states: Vec<Aligned<States<S, N, H>>>,
}

/// What gives a schedule its elements and hinges.
pub(super) trait Members<S: Simd, const N: usize, const H: usize> {
    fn element(&mut self, element: usize, form: ReductionForm) -> [Block<S, N>; H];
    /// Adds the compliance of a hinge to a matrix, or sets that if it is `fresh`.
    fn add_hinge(&mut self, hinge: usize, fresh: bool, sum: &mut [Block<S, N>; H]);
    /// Adds the hinges that struts stand over.
    fn add_braced(&mut self, fresh: bool, sum: &mut [Block<S, N>; H]);
    /// Motion of the point per unit of a hinge, and the hinge's stiffness.
    fn hinge(&mut self, hinge: usize) -> ([[Lane<S>; N]; H], f64);
}

/// What takes the loads that elements and hinges carry.
pub(super) trait Carriers<S: Simd, const N: usize, const H: usize> {
    fn carry(&mut self, piece: SchedulePiece, form: ReductionForm, states: &States<S, N, H>);
    /// Motion of the point per unit of a hinge, and the hinge's compliance.
    fn hinge(&mut self, hinge: usize) -> ([[Lane<S>; N]; H], f64);
    /// Takes the moments in a hinge, or forces along one that slides, by load.
    fn twist(&mut self, hinge: usize, moments: &[Lane<S>; LOADS]);
}

impl<S: Simd, const N: usize, const H: usize> SolverBuffers<S, N, H> {
    /// # Arguments
    /// - `follow`: whether loads are to be followed.
    pub(super) fn new(simd: S, schedule: &Schedule, follow: bool) -> Self {
        let zero = Lane::zero(simd);
        let zeros = Aligned([[[zero; N]; N]; H]);
        Self {
            slots: vec![zeros; schedule.slot_count],
            undivided: vec![zeros; schedule.widest],
            states: vec![
                Aligned([[[zero; N]; LOADS]; H]);
                if follow { schedule.slot_count } else { 0 }
            ],
        }
    }

    /// Runs a schedule; gives its result, of which the upper triangles count. `worst` as in [`factorise`].
    #[inline(always)]
    pub(super) fn execute<M: Members<S, N, H>>(
        &mut self,
        schedule: &Schedule,
        members: &mut M,
        worst: &mut Lane<S>,
    ) -> &[Block<S, N>; H] {
        let keep_factors = !self.states.is_empty();
        for op in &schedule.ops {
            match *op {
                Op::Piece {
                    piece,
                    form,
                    into,
                    fresh,
                } => match piece {
                    SchedulePiece::Element(element) => {
                        let member = members.element(element, form);
                        for half in 0..H {
                            add(&mut self.slots[into].0[half], fresh, &member[half]);
                        }
                    }
                    SchedulePiece::Hinge(hinge) => {
                        members.add_hinge(hinge, fresh, &mut self.slots[into].0);
                    }
                },
                Op::Brace { into, fresh } => {
                    members.add_braced(fresh, &mut self.slots[into].0);
                }
                Op::Invert { from, into, fresh } => {
                    for half in 0..H {
                        let mut block = self.slots[from].0[half];
                        factorise(&mut block, worst);
                        if keep_factors {
                            self.slots[from].0[half] = block;
                        }
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
                Op::Ease {
                    ref hinges,
                    diagonal,
                    ref panels,
                    ref updates,
                    ..
                } => {
                    for (place, &hinge) in hinges.iter().enumerate() {
                        let (motion, stiffness) = members.hinge(hinge);
                        let slots = (diagonal, &panels[..], &updates[..]);
                        self.ease(&motion, stiffness, slots, place == 0);
                    }
                }
                Op::Join {
                    diagonal,
                    into,
                    ref moves,
                } => self.join(diagonal, into, moves),
                Op::Eliminate {
                    diagonal,
                    ref panels,
                    ref updates,
                } => {
                    for half in 0..H {
                        let mut block = self.slots[diagonal].0[half];
                        factorise(&mut block, worst);
                        if keep_factors {
                            self.slots[diagonal].0[half] = block;
                        }
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

    /// Follows the first `L` forces on the result of the schedule run last back to every piece: its steps in reverse.
    ///
    /// What adds up in series carries the same force, what stands side by side moves alike.
    #[inline(always)]
    pub(super) fn follow<const L: usize, C: Carriers<S, N, H>>(
        &mut self,
        schedule: &Schedule,
        forces: &States<S, N, H>,
        carriers: &mut C,
    ) {
        self.states[0].0 = *forces;
        for op in schedule.ops.iter().rev() {
            match *op {
                Op::Piece {
                    piece, form, into, ..
                } => carriers.carry(piece, form, &self.states[into].0),
                Op::Brace { .. } => unreachable!("{NO_DERIVATIVES}"),
                Op::Invert { from, into, .. } => {
                    for half in 0..H {
                        for load in 0..L {
                            let state = self.states[into].0[half][load];
                            let factor = &self.slots[from].0[half];
                            self.states[from].0[half][load] = solve(factor, &state);
                        }
                    }
                }
                // A link between two nodes is added to both, and moves by their difference.
                Op::Add { from, into, .. } => {
                    for half in 0..H {
                        for load in 0..L {
                            for i in 0..N {
                                let motion = self.states[into].0[half][load][i];
                                let other = self.states[from].0[half][load][i];
                                self.states[from].0[half][load][i] = motion - other;
                            }
                        }
                    }
                }
                Op::Mirror { slot } => {
                    let zero = forces[0][0][0].of(0.0);
                    self.states[slot].0 = [[[zero; N]; LOADS]; H];
                }
                Op::Ease {
                    ref hinges,
                    diagonal,
                    ref panels,
                    ref neighbours,
                    ..
                } => {
                    let held = self.states[diagonal].0;
                    for &hinge in hinges {
                        let (motion, compliance) = carriers.hinge(hinge);
                        let around = (diagonal, &panels[..], &neighbours[..]);
                        let moments = self.twist::<L>(&motion, compliance, &held, around);
                        carriers.twist(hinge, &moments);
                    }
                }
                Op::Join { diagonal, into, .. } => {
                    let zero = forces[0][0][0].of(0.0);
                    self.states[diagonal].0 = match into {
                        Some(joined) => self.states[joined.diagonal].0,
                        None => [[[zero; N]; LOADS]; H],
                    };
                }
                Op::Eliminate {
                    diagonal,
                    ref panels,
                    ref updates,
                } => self.move_eliminated::<L>(diagonal, panels, updates),
            }
        }
    }

    /// Eliminates the twist φ of a hinge behind which a node stands: with t the motion by it and K the matrix, q = K t and d = 1/c + tᵀ q,
    /// K becomes K - q qᵀ/d over the node and its neighbours.
    #[inline(always)]
    fn ease(
        &mut self,
        motion: &[[Lane<S>; N]; H],
        stiffness: f64,
        (diagonal, panels, updates): (Slot, &[Slot], &[Update]),
        first: bool,
    ) {
        for half in 0..H {
            let t = &motion[half];
            let zero = t[0].of(0.0);
            let block = self.slots[diagonal].0[half];
            let mut own = [zero; N];
            let mut d = zero.of(stiffness);
            for i in 0..N {
                for j in 0..N {
                    own[i] = multiply_add(block[i.min(j)][i.max(j)], t[j], own[i]);
                }
                d = multiply_add(own[i], t[i], d);
            }
            let inverse = d.inverse();
            let target = &mut self.slots[diagonal].0[half];
            for i in 0..N {
                let share = own[i] * inverse;
                for j in i..N {
                    target[i][j] = multiply_subtract(share, own[j], target[i][j]);
                }
            }
            // Panels hold minus the block: theirs is minus q of the neighbour. Kept in the first row of `undivided`.
            for (&panel, kept) in panels.iter().zip(&mut self.undivided) {
                let block = &mut self.slots[panel].0[half];
                let mut theirs = [zero; N];
                for j in 0..N {
                    for i in 0..N {
                        theirs[j] = multiply_add(block[i][j], t[i], theirs[j]);
                    }
                }
                for i in 0..N {
                    let share = own[i] * inverse;
                    for j in 0..N {
                        block[i][j] = multiply_subtract(share, theirs[j], block[i][j]);
                    }
                }
                kept.0[half][0] = theirs;
            }
            for update in updates {
                let rows = self.undivided[update.rows].0[half][0];
                let columns = self.undivided[update.columns].0[half][0];
                let target = &mut self.slots[update.target].0[half];
                for i in 0..N {
                    let share = rows[i] * inverse;
                    if update.on_diagonal {
                        for j in i..N {
                            target[i][j] = multiply_subtract(share, columns[j], target[i][j]);
                        }
                    } else {
                        for j in 0..N {
                            let more = share * columns[j];
                            target[i][j] = if update.fresh && first {
                                more
                            } else {
                                target[i][j] + more
                            };
                        }
                    }
                }
            }
        }
    }

    /// Adds the matrix of a node to that of another that moves with it.
    #[inline(always)]
    fn join(&mut self, diagonal: Slot, into: Option<Joined>, moves: &[PanelMove]) {
        for half in 0..H {
            if let Some(joined) = into {
                let mut block = self.slots[diagonal].0[half];
                if let Some(between) = joined.between {
                    let between = &self.slots[between].0[half];
                    for i in 0..N {
                        for j in i..N {
                            block[i][j] = block[i][j] - between[i][j] - between[j][i];
                        }
                    }
                }
                add(
                    &mut self.slots[joined.diagonal].0[half],
                    joined.fresh,
                    &block,
                );
            }
            for PanelMove {
                from,
                into,
                transposed,
                fresh,
            } in moves
            {
                let block = self.slots[*from].0[half];
                let target = &mut self.slots[*into].0[half];
                for i in 0..N {
                    for j in 0..N {
                        let more = if *transposed {
                            block[j][i]
                        } else {
                            block[i][j]
                        };
                        target[i][j] = if *fresh { more } else { target[i][j] + more };
                    }
                }
            }
        }
    }

    /// Twist of a hinge that was eased, added to the motion of the node behind it; gives the moments in it, by load.
    ///
    /// With K as it became, the moment is -Σ tᵀ K u over the node and its neighbours as they move without the twists: the node as it is `held`.
    #[inline(always)]
    fn twist<const L: usize>(
        &mut self,
        motion: &[[Lane<S>; N]; H],
        compliance: f64,
        held: &States<S, N, H>,
        (diagonal, panels, neighbours): (Slot, &[Slot], &[Slot]),
    ) -> [Lane<S>; LOADS] {
        let zero = motion[0][0].of(0.0);
        let mut moments = [zero; LOADS];
        for load in 0..L {
            for half in 0..H {
                let t = &motion[half];
                let block = &self.slots[diagonal].0[half];
                let own = &held[half][load];
                let mut moment = zero;
                for i in 0..N {
                    let mut force = zero;
                    for j in 0..N {
                        force = multiply_add(block[i.min(j)][i.max(j)], own[j], force);
                    }
                    moment = multiply_subtract(force, t[i], moment);
                }
                for (&panel, &neighbour) in panels.iter().zip(neighbours) {
                    let panel = &self.slots[panel].0[half];
                    let theirs = &self.states[neighbour].0[half][load];
                    for i in 0..N {
                        let mut force = zero;
                        for j in 0..N {
                            force = multiply_add(panel[i][j], theirs[j], force);
                        }
                        moment = multiply_add(force, t[i], moment);
                    }
                }
                moments[load] += moment;
                let twist = moment * zero.of(compliance);
                for i in 0..N {
                    let moved = self.states[diagonal].0[half][load][i];
                    self.states[diagonal].0[half][load][i] = multiply_add(twist, t[i], moved);
                }
            }
        }
        moments
    }

    /// Motions of an eliminated node from those of its neighbours.
    #[inline(always)]
    fn move_eliminated<const L: usize>(
        &mut self,
        diagonal: Slot,
        panels: &[Slot],
        updates: &[Update],
    ) {
        for half in 0..H {
            for load in 0..L {
                let zero = self.slots[diagonal].0[half][0][0].of(0.0);
                let mut motion = [zero; N];
                let neighbours = updates.iter().filter(|update| update.on_diagonal);
                for (&panel, neighbour) in panels.iter().zip(neighbours) {
                    let panel = &self.slots[panel].0[half];
                    let theirs = &self.states[neighbour.target].0[half][load];
                    for i in 0..N {
                        for j in 0..N {
                            motion[i] = multiply_add(panel[i][j], theirs[j], motion[i]);
                        }
                    }
                }
                back_substitute(&self.slots[diagonal].0[half], &mut motion);
                self.states[diagonal].0[half][load] = motion;
            }
        }
    }
}
