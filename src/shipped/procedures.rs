//! The procedures that come with the program.

use crate::source_text::SourceText;

/// The shipped procedure that is followed where none is named.
pub const DEFAULT_PROCEDURE: &str = "sweeps";

/// Shipped procedures: name and text.
const SHIPPED: [(&str, &str); 6] = [
    (
        "paper",
        include_str!("../../protocols/procedures/paper.toml"),
    ),
    (
        "sweeps",
        include_str!("../../protocols/procedures/sweeps.toml"),
    ),
    (
        "load-unload",
        include_str!("../../protocols/procedures/load-unload.toml"),
    ),
    (
        "load-hold-unload",
        include_str!("../../protocols/procedures/load-hold-unload.toml"),
    ),
    (
        "shuffled",
        include_str!("../../protocols/procedures/shuffled.toml"),
    ),
    (
        "iso-9283-static-compliance",
        include_str!("../../protocols/procedures/iso-9283-static-compliance.toml"),
    ),
];

/// Names of the shipped procedures.
pub fn shipped_procedures() -> impl Iterator<Item = &'static str> {
    SHIPPED.iter().map(|(name, _)| *name)
}

/// Text of a shipped procedure.
#[must_use]
pub fn shipped_procedure(name: &str) -> Option<SourceText> {
    SHIPPED
        .iter()
        .find(|(shipped, _)| *shipped == name)
        .map(|(name, text)| SourceText::new(*name, *text))
}
