//! A model with found physics in it, as a file: schema `stiffbench/model/1`.
//!
//! Robot, mechanism and factors define the beam model; every effect names a law, its place and its values. Only `schema` is
//! required: what is absent is taken from elsewhere. A key that is not known is an error, for a misspelt effect would be left out.

mod error;
mod read;
mod write;

use crate::robot::FittingFactors;
use stiffbench_units_and_text::source_text::SourceText;

use super::effect::Effect;

pub use error::{ModelFileError, ModelProblem};

/// The only schema known to this version.
pub const MODEL_SCHEMA: &str = "stiffbench/model/1";

/// A beam model and the physics found beside it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ModelFile {
    /// Robot file, relative to this one, or the name of a shipped robot.
    pub robot: Option<String>,
    /// SHA-256 of the robot file's text, hexadecimal.
    pub robot_sha256: Option<String>,
    /// Mechanism of the robot.
    pub mechanism: Option<String>,
    /// Where the model comes from.
    pub provenance: Provenance,
    /// Fitting factors.
    pub factors: Option<FittingFactors>,
    /// The effects of the model, all of which act.
    pub effects: Vec<FoundEffect>,
    /// Effects that would serve as well as one of the model; they do not act.
    pub alternatives: Vec<FoundEffect>,
}

/// Where a model comes from; nothing is computed from it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Provenance {
    /// Id of the session that was diagnosed.
    pub session: Option<String>,
    /// Program and version that wrote the file.
    pub software: Option<String>,
    /// Verdict of the diagnosis.
    pub verdict: Option<String>,
}

/// An effect and how well its values are known.
#[derive(Debug, Clone, PartialEq)]
pub struct FoundEffect {
    /// The effect.
    pub effect: Effect,
    /// Known properties of its values, in the order of the law's parameters; may be shorter.
    pub uncertainties: Vec<ParameterUncertainty>,
    /// Effects with one number exclude each other and are indistinguishable: one is in `effects`, the others in `alternatives`.
    pub alternative_group: Option<u32>,
}

/// How well a value is known, SI.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ParameterUncertainty {
    /// Standard uncertainty.
    pub u: Option<f64>,
    /// Its degrees of freedom; `None` also where they are without limit.
    pub dof: Option<f64>,
    /// 95 % interval.
    pub ci95: Option<[f64; 2]>,
}

impl ModelFile {
    /// Reads a model file.
    ///
    /// # Errors
    /// [`ModelFileError`] pointing at the line that is wrong.
    pub fn parse(source: &SourceText) -> Result<Self, ModelFileError> {
        read::model(source)
    }

    /// The effects that act.
    #[must_use]
    pub fn acting(&self) -> Vec<Effect> {
        self.effects
            .iter()
            .map(|found| found.effect.clone())
            .collect()
    }
}

impl From<Effect> for FoundEffect {
    /// An effect of which nothing more is known.
    fn from(effect: Effect) -> Self {
        Self {
            effect,
            uncertainties: Vec::new(),
            alternative_group: None,
        }
    }
}

#[cfg(test)]
mod tests;
