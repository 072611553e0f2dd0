//! How well a model predicts readings that were left out of its fit.
//!
//! Owner: [`HoldOut`]. It imports `problem` and the rooms below it.

mod held_out;
mod shares;
mod unseen_parts;

pub use held_out::{HeldOut, Quality};
pub(crate) use held_out::{HoldOut, folds_of, folds_that_ask};
pub(crate) use shares::{AllShares, misfit_shares};
pub use shares::{MisfitShares, MisfitSteps, NoShareReason};
pub(crate) use unseen_parts::unseen_parts;
