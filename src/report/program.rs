//! What the program tells about itself.

use schemars::JsonSchema;
use serde::Serialize;

/// Completions of a shell.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct CompletionScript {
    /// The script.
    pub script: String,
}

/// The manual page.
#[derive(Debug, Clone, Serialize, JsonSchema)]
pub struct ManualPage {
    /// Its source for `man`.
    pub roff: String,
}
