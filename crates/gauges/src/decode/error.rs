//! Why a decoder cannot be made.

use miette::Diagnostic;
use thiserror::Error;

/// Why a decoder cannot be made.
#[derive(Debug, Clone, PartialEq, Eq, Error, Diagnostic)]
pub enum DecoderError {
    /// No unit is sent and none is configured.
    #[error("{instrument} sends no unit, and none was named")]
    #[diagnostic(
        code(stiffbench::instrument::unit_needed),
        help(
            "name the unit that its display shows, with --unit, or in a session with --force-unit or --displacement-unit: {choices}"
        )
    )]
    UnitNeeded {
        /// Name of the description.
        instrument: String,
        /// Units it can have.
        choices: String,
    },
    /// A unit that the gauge cannot have.
    #[error("{instrument} measures {quantity}, and {unit:?} is not a known unit of it")]
    #[diagnostic(
        code(stiffbench::instrument::unit_unknown),
        help("name one of {choices}")
    )]
    UnitUnknown {
        /// Name of the description.
        instrument: String,
        /// What it measures.
        quantity: String,
        /// The unit that was named.
        unit: String,
        /// Units it can have.
        choices: String,
    },
}
