//! A result that `--json` printed, read back.

use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::inputs::Inputs;

/// What `--json` printed of a result.
#[derive(Debug, Clone, Deserialize)]
pub struct StoredResult<T> {
    /// What it was made of.
    pub inputs: Inputs,
    /// The result.
    pub data: T,
    /// What it warned of.
    #[serde(default)]
    pub warnings: Vec<String>,
}

/// What an object of `--json` is.
#[derive(Deserialize)]
struct StoredKind {
    kind: String,
    ok: bool,
}

impl<T: DeserializeOwned> StoredResult<T> {
    /// Reads what a command printed with `--json`.
    ///
    /// # Arguments
    /// - `kind`: word for the kind of result.
    ///
    /// # Errors
    /// What is wrong with it and where, in words.
    pub fn read(kind: &str, text: &str) -> Result<Self, String> {
        let found: serde_json::Result<StoredKind> = serde_json::from_str(text);
        match found {
            Err(error) if !error.is_data() => Err(format!("it is no JSON: {error}")),
            Ok(found) if found.kind == kind && found.ok => {
                serde_json::from_str(text).map_err(|error| {
                    format!("it is not what this version of {kind} --json prints: {error}")
                })
            }
            _ => Err(format!("it is not what stiffbench {kind} --json prints")),
        }
    }
}
