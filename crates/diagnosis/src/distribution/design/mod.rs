//! What a change of the robot does to the distribution of its stiffness.
//!
//! All derivatives are exact: of a compliance to the section constants of an element, -uᵀ ∂K/∂ln p u, added up by section; to the
//! compliance of a joint, the square of the moment that a unit force at the end sends through it.

mod sensitivity;

pub use sensitivity::{
    DesignSensitivity, JointSensitivity, SectionSensitivity, design_sensitivity,
};
