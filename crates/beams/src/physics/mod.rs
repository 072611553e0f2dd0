//! The physics that a beam model leaves out: laws, places, and how they act on readings.
//!
//! A law in a joint is not linearised: the structure is reduced exactly to the joints' twists ([`crate::structure::RotationInfluence`]),
//! and the law is solved there with its history, in closed loops too. All other laws act before or behind the mechanics, in the order
//! that [`LawSet::displacements_m`] states.

mod acting;
mod action;
mod dimension;
#[cfg(test)]
mod documentation_tests;
mod effect;
mod effect_object;
mod effect_text;
mod joint_effect;
mod joint_path;
mod law;
mod law_set;
pub mod laws;
mod mechanics;
mod model_file;
mod parameter;
mod part;
mod place;
mod place_object;
mod run_loads;
mod search;
mod structure_edit;
mod turning;

pub use acting::ActingPhysics;
pub use action::{
    Driven, DrivenPath, GaugeError, HistoryLaw, LawAction, MOST_PARAMETERS, OfLoad, OfRepeat,
    RotationLaw, SimulatedRotation, Values, values_of,
};
pub use dimension::Dimension;
pub use effect::{Effect, EffectError, title};
pub use effect_text::{EffectProblem, NotAnEffect};
pub use joint_effect::JointRotations;
pub use joint_path::JointPath;
pub use law::{
    Check, Combination, Curve, Driving, Law, LawDefinition, LawFigure, LawKind, LawWording,
    MistakePrior,
};
pub use law_set::{LawSet, without_elements};
pub use mechanics::{Mechanics, PoseMechanics, Unloaded};
pub use model_file::{
    FoundEffect, MODEL_SCHEMA, ModelFile, ModelFileError, ModelProblem, ParameterUncertainty,
    Provenance,
};
pub use parameter::{FitBy, ParameterSpec, PlausibleRange, SignConstraint, Typical};
pub use place::{Place, PlaceKind};
pub use run_loads::{LoadPoint, RunLoads};
pub use search::{Needs, PlaceScale, SearchSpec, SearchedOn, Shape, TestObject, VISIBLE_SHARE};
pub use structure_edit::{FileLine, FileSuspects, StructureEdit};
