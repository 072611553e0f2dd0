//! What can be wrong with a model file.

use std::fmt::Display;

use miette::Diagnostic;

use crate::physics::effect_text::EffectProblem;
use stiffbench_units_and_text::source_text::PlacedError;
use stiffbench_units_and_text::toml_text::TomlProblem;

/// A model file that is wrong at one place.
pub type ModelFileError = PlacedError<ModelProblem>;

/// What is wrong at one place of a model file.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum ModelProblem {
    /// Not TOML, another schema, a key or a value that does not belong there.
    #[error(transparent)]
    Toml(#[from] TomlProblem),
    /// An effect that is none.
    #[error(transparent)]
    Effect(#[from] EffectProblem),
}

impl Diagnostic for ModelProblem {
    fn code<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        Some(Box::new("stiffbench::physics::model_file"))
    }

    fn help<'a>(&'a self) -> Option<Box<dyn Display + 'a>> {
        match self {
            Self::Toml(problem) => problem.help(),
            Self::Effect(problem) => problem.help().map(|help| Box::new(help) as _),
        }
    }
}
