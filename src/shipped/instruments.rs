//! The instrument descriptions that come with the program.

use crate::nearest::nearest;

use crate::instrument::{DescriptionError, InstrumentDescription};

/// A shipped description: name and text.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ShippedInstrument {
    /// Its name.
    pub name: &'static str,
    /// The text of its file.
    pub text: &'static str,
}

macro_rules! shipped {
    ($($name:literal),* $(,)?) => {
        &[$(ShippedInstrument {
            name: $name,
            text: include_str!(concat!("../../protocols/instruments/", $name, ".toml")),
        }),*]
    };
}

/// In the order in which they are listed: force gauges, then displacement gauges, each with the best known first.
const SHIPPED: &[ShippedInstrument] = shipped![
    "mark10-series5",
    "sauter-fh",
    "imada-ds2",
    "aikoh-rx",
    "imada-zts",
    "nidec-shimpo-fg7000",
    "lutron-fg",
    "hp-modbus",
    "generic-ascii",
    "mitutoyo-01a",
    "sylvac-opto-rs",
    "mahr-dk-u1",
    "cdi-logic",
    "heidenhain-nd28x",
    "magnescale-lt20a",
    "shahe-modbus",
    "generic-ascii-displacement",
];

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

/// The shipped descriptions.
#[must_use]
pub fn shipped_instruments() -> &'static [ShippedInstrument] {
    SHIPPED
}

/// A shipped description by its name.
///
/// # Errors
/// [`RegistryError::Unknown`] with the name that is nearest.
pub fn shipped_instrument(name: &str) -> Result<InstrumentDescription, RegistryError> {
    let Some(shipped) = SHIPPED.iter().find(|shipped| shipped.name == name) else {
        return Err(unknown_name(
            name,
            SHIPPED.iter().map(|shipped| shipped.name),
        ));
    };
    Ok(InstrumentDescription::parse(shipped.text, shipped.name)?.0)
}

/// A name that stands for nothing among those that are known.
pub fn unknown_name<'a>(name: &str, known: impl Iterator<Item = &'a str> + Clone) -> RegistryError {
    let meant = nearest(name, known.clone())
        .map_or_else(String::new, |near| format!("did you mean {near}? "));
    RegistryError::Unknown {
        name: name.to_owned(),
        help: format!("{meant}there are {}", known.collect::<Vec<_>>().join(", ")),
    }
}
