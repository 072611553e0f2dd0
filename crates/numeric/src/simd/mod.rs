//! Numbers for several poses side by side, and the instruction set that works on them.
//!
//! Kernels are written once over a [`Lane`], whose length and instructions are those of an instruction set S of the crate `pulp`,
//! chosen when the program runs: eight poses with AVX-512, four with AVX2, two with NEON, one where there is none of these. Between
//! sets results may differ by the rounding of fused products; for a given set they are the same on every machine and for any number
//! of threads.
//!
//! Decision: vector types, not loops over arrays that the compiler is trusted to vectorise. Such loops were tried: some were
//! vectorised along the wrong subscript, for three times the run time, and fused products in a function that was not inlined became
//! calls of software. Price: a dependency, which the linear algebra has anyway, and that every function here must be inlined.
//!
//! Leaf module: independent of structures and robots.

#![expect(
    clippy::inline_always,
    reason = "what is not inlined into a kernel is compiled for another instruction set, and calls its instructions one by one"
)]

mod angle;
mod instruction_set;
mod lane;
mod number;
mod products;
mod sums;

pub use angle::{sin_cos_deg, waves};
pub use instruction_set::InstructionSet;
pub use lane::{Aligned, Kernel, Lane, run, widest};
pub use number::{
    Number, across, cross, dot, frame_on, multiply_add, multiply_subtract, scale, subtract,
};
pub use products::sums_of_blocks;
pub use sums::sums_side_by_side;
