//! Procedures by the names that a user gives them.

use std::path::Path;

use crate::nearest::nearest;
use crate::procedure::Procedure;
use crate::shipped::{shipped_procedure, shipped_procedures};
use crate::source_text::SourceText;

use super::error::{AnalysisError, ArgumentError};
use super::files::read_text;

/// A procedure by the name of a file or of a shipped one, and what a user should know of its file.
///
/// # Errors
/// For a name that is neither a file nor a shipped procedure, or a file that is no procedure.
pub fn named_procedure(name: &str) -> Result<(Procedure, Vec<String>), AnalysisError> {
    Ok(Procedure::parse(&procedure_source(name)?)?)
}

/// Text of a procedure file or of a shipped procedure.
fn procedure_source(name: &str) -> Result<SourceText, AnalysisError> {
    let path = Path::new(name);
    if path.is_file() {
        return Ok(SourceText::new(name, read_text(path)?));
    }
    shipped_procedure(name).ok_or_else(|| {
        let shipped = shipped_procedures().collect::<Vec<_>>().join(", ");
        let meant = nearest(name, shipped_procedures())
            .map_or_else(String::new, |near| format!("did you mean {near}? "));
        ArgumentError::new(
            format!("--procedure {name}"),
            "there is no such file and no shipped procedure of that name",
            format!("{meant}shipped procedures are {shipped}"),
        )
        .into()
    })
}
