//! The instrument descriptions that come with the program.

use crate::instrument::{DescriptionError, InstrumentDescription};
use crate::nearest::nearest;

use super::files::shipped_instruments;

/// Why a name stands for no description.
#[derive(Debug, thiserror::Error, miette::Diagnostic)]
pub enum RegistryError {
    /// No description of that name.
    #[error("there is no instrument description {name:?}")]
    #[diagnostic(code(stiffbench::instrument::name))]
    Unknown {
        /// The name.
        name: String,
        /// What could be meant.
        #[help]
        help: String,
    },
    /// The description cannot be used.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Description(#[from] DescriptionError),
}

/// A shipped description by its name.
///
/// # Errors
/// [`RegistryError::Unknown`] with the name that is nearest.
pub fn shipped_instrument(name: &str) -> Result<InstrumentDescription, RegistryError> {
    let mut shipped = shipped_instruments().iter();
    let names = || shipped_instruments().iter().map(|shipped| shipped.name);
    let shipped = shipped.find(|shipped| shipped.name == name);
    let shipped = shipped.ok_or_else(|| unknown_name(name, names()))?;
    Ok(InstrumentDescription::parse(shipped.text, shipped.name)?.0)
}

/// A name that stands for nothing among those that are known.
pub fn unknown_name<'a>(name: &str, known: impl Iterator<Item = &'a str> + Clone) -> RegistryError {
    RegistryError::Unknown {
        name: name.to_owned(),
        help: nearest_and_all(name, known, "there are"),
    }
}

/// What could be meant by a name, and what there is.
///
/// # Arguments
/// - `there_are`: the words before the list.
#[must_use]
pub fn nearest_and_all<'a>(
    name: &str,
    known: impl Iterator<Item = &'a str> + Clone,
    there_are: &str,
) -> String {
    let meant = nearest(name, known.clone());
    let meant = meant.map_or_else(String::new, |near| format!("did you mean {near}? "));
    format!(
        "{meant}{there_are} {}",
        known.collect::<Vec<_>>().join(", ")
    )
}
