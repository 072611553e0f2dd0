//! What a change of the robot does to the distribution of its stiffness, and the cheapest change that does what is wanted.
//!
//! All derivatives are exact: of a compliance to the section constants of an element, -uᵀ ∂K/∂ln p u, added up by section; to the
//! compliance of a joint, the square of the moment that a unit force at the end sends through it. A change that was found is checked by
//! solving the changed robot in every pose again.

mod cheapest;
mod lift;
mod sensitivity;

pub use lift::{DesignCost, DesignGoal, Lift, LiftedDesign, NoDesign, SectionChange, lift};
pub use sensitivity::{
    DesignSensitivity, JointSensitivity, SectionSensitivity, design_sensitivity,
};
