//! From text to the types of the file, with its errors in the words of TOML.

use crate::robot::error::{RobotError, RobotProblem};
use crate::robot::file::RobotFile;
use stiffbench_units_and_text::source_text::SourceText;

/// The file's types from its text, and a warning for each key that belongs to none of them.
pub(super) fn deserialize(source: &SourceText) -> Result<(RobotFile, Vec<String>), RobotError> {
    let (file, unknown) = source.read_toml().map_err(|problem| {
        let what = RobotProblem::Syntax(problem.message);
        RobotError::at(source, problem.span, what, None)
    })?;
    let warnings = unknown.iter().map(|unknown| {
        format!(
            "{}:{}:{}: key `{}` is not known and was not used",
            source.name, unknown.line, unknown.column, unknown.key
        )
    });
    Ok((file, warnings.collect()))
}
