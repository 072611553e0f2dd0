//! The list of model parameters that a fit moves, keeps or ties: what `fit` and the baseline of `mismatch` have in common.

mod choice;
mod spring_scales;

pub use choice::{ChosenParameter, FitRole, ParameterChoice};
/// The place of a member in a list, added if it is new.
pub(crate) fn place_of<T: PartialEq + Clone>(list: &mut Vec<T>, member: &T) -> usize {
    let known = list.iter().position(|known| known == member);
    known.unwrap_or_else(|| {
        list.push(member.clone());
        list.len() - 1
    })
}

pub(crate) use spring_scales::{FIRST_SPRING, ScaleCell, SpringScales, UNLOADED, bears_no_load};
