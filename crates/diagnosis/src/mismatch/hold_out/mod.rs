//! How well a model predicts readings that were left out of its fit.
//!
//! Owner: [`MisfitShares`]. It imports `problem` and the rooms below it.

mod held_out;
mod shares;
mod unseen_parts;

pub(crate) use held_out::folds_of;
pub use held_out::{HeldOut, Quality};
pub(crate) use shares::AllShares;
pub use shares::{MisfitShares, MisfitSteps};
pub(crate) use unseen_parts::unseen_parts;
