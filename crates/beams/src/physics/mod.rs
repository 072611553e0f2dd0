//! The physics that a beam model leaves out: laws, places, and how they act on readings.
//!
//! A law in a joint is not linearised: the structure is reduced exactly to the joints' twists ([`crate::structure::TwistInfluence`]),
//! and the law is solved there with its history, in closed loops too. All other laws act before or behind the mechanics, in the order
//! that [`LawSet::displacements_m`] states.

mod acting;
#[cfg(test)]
mod documentation_tests;
mod effect;
mod effect_text;
mod joint_law;
mod law;
mod law_set;
mod mechanics;
mod model_file;
mod place;
mod turning;
mod unit;

pub use acting::ActingPhysics;
pub use effect::{Effect, EffectError, title};
pub use effect_text::{EffectProblem, NotAnEffect};
pub use law::{Law, ParameterSpec, Sign};
pub use law_set::{LawSet, LoadPoint, RunLoads, period_m, without_elements};
pub use mechanics::{Mechanics, PoseMechanics};
pub use model_file::{
    FoundEffect, MODEL_SCHEMA, ModelFile, ModelFileError, ModelProblem, ParameterUncertainty,
    Provenance,
};
pub use place::{Place, PlaceKind};
pub use turning::{JointPath, Twists};
