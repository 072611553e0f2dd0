//! End compliance of one structure in very many poses, by the shortest exact way.
//!
//! [`Solver`](super::Solver) eliminates every node. This one looks first at how the elements hang together:
//!
//! 1. What hangs on the way from the ground to the end by one node carries nothing, and is left out.
//! 2. Where every path from the ground to the end passes one node, the structure is cut in two: the compliance of the end is the
//!    sum of both, each carried rigidly to the end. A part that stands as it stood in the poses before is not computed again: in a
//!    robot, all that lies below the waist while the waist does not turn.
//! 3. Within a part, elements in series become one by adding compliances, and elements side by side by adding stiffnesses. Both
//!    are referred to one point common to the part, so nothing but these sums is needed. Only nodes that then still have three
//!    neighbours or more are eliminated, in order of least degree.
//! 4. A part whose elements lie in one plane moves in that plane and across it without mixing: two problems of three freedoms a
//!    node for one of six. Whether they do lie in it is checked pose by pose; where not, the part is solved in space.
//!
//! 5. A joint that yields adds the compliance of its turn to what it is in series with. Where several elements end on either side of it, the
//!    matrix of one side is joined to that of the other after the turn is eliminated: K - q qᵀ/(1/c + tᵀ q) with t the motion by the turn
//!    and q = K t. The common point of such a part is that joint. Joints that close a loop without anything that bends are left to
//!    [`Solver`](super::Solver).
//!
//! 6. A strut over joints of a chain couples their turns: their compliance is T K⁻¹ Tᵀ with K the stiffness of springs and struts. A strut
//!    over anything that bends is left to [`Solver`](super::Solver).
//!
//! Rounding costs no more than in [`Solver`](super::Solver), in the plane or with joints that yield a third of it:
//! `crates/beams/tests/pose_sweep.rs` holds both against extended precision.
//!
//! Derivatives to the section constants cost one more pass over the same steps, in reverse: loads on the end are followed to every
//! element, whose strain energy they give.
//!
//! Decision: no loads but on the end, no pins, no errors that name a node. [`Solver`](super::Solver) has them.

#![expect(
    clippy::inline_always,
    reason = "what is not inlined into a kernel is compiled for another instruction set, and calls its instructions one by one"
)]

mod block;
mod braced;
mod combine;
mod execute;
mod gradient;
mod graph;
mod member;
mod placed;
mod schedule;
mod series_parallel;
mod solve;
mod strained;
mod substructure;

pub(crate) use gradient::{GroupGradient, WholeGradient};
pub(crate) use placed::{Placed, PlacedStrut};
pub(crate) use solve::Reducer;
pub(crate) use substructure::Reduction;
pub use substructure::{PartMethod, SolutionPath};

#[cfg(test)]
mod tests;
