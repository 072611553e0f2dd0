//! Which variable of the robot a column of joint values holds.

use crate::analysis::ArgumentError;
use crate::import::{ColumnGuess, ImportDraft, ImportMapping};
use crate::robot::Robot;

use crate::cli::failure::Failure;

/// Columns that are named like variables of the robot hold their values. Where none is, columns numbered 1 to n hold those of the n variables
/// that the robot numbers 1 to n; returns a note that says so.
///
/// # Errors
/// For a table that cannot be read, and a column of joint values of a variable that the robot does not have.
pub(super) fn take_variables(
    mapping: &mut ImportMapping,
    robot: &Robot,
    files: &[(&str, &[u8])],
) -> Result<Option<String>, Failure> {
    let columns = ImportDraft::read(files, None, mapping)?.columns();
    let variables: Vec<&str> = robot
        .variables
        .iter()
        .map(|one| one.name.as_str())
        .collect();
    for &variable in &variables {
        let is_it = |name: &str| {
            let stem = name.split([' ', '[', '(']).next().unwrap_or(name);
            stem.eq_ignore_ascii_case(variable)
        };
        let mut alike = columns.iter().filter(|column| is_it(&column.name));
        if let (Some(column), None) = (alike.next(), mapping.joints.get(variable)) {
            mapping
                .joints
                .insert(variable.to_owned(), column.name.clone());
        }
    }
    let draft = ImportDraft::read(files, None, mapping)?;
    let columns = draft.columns();
    let joints: Vec<(&str, &ColumnGuess)> = columns
        .iter()
        .filter_map(|column| Some((column.role.as_deref()?.strip_prefix("joint.")?, column)))
        .collect();
    let unknown = joints.iter().find(|(name, _)| !variables.contains(name));
    let Some((unknown, column)) = unknown else {
        return Ok(None);
    };
    if let Some(pairs) = by_number(&joints, &variables) {
        let note = match pairs.as_slice() {
            [(variable, column), .., (last, last_column)] => format!(
                "joint columns `{column}` to `{last_column}` are taken as {variable} to {last}"
            ),
            _ => format!(
                "joint column `{}` is taken as {}",
                column.name,
                variables.join(", ")
            ),
        };
        mapping
            .joints
            .retain(|name, _| variables.contains(&name.as_str()));
        for (variable, column) in pairs {
            mapping
                .joints
                .insert(variable.to_owned(), column.to_owned());
        }
        return Ok(Some(note));
    }
    let (line, file) = (draft.header_line().unwrap_or(1), files.first());
    let file = file.map_or("", |(name, _)| *name);
    let has_column = |variable: &str| joints.iter().any(|(name, _)| *name == variable);
    let without = variables.iter().find(|variable| !has_column(variable));
    let help = match without {
        Some(variable) => format!(
            "its variables are {}: state which column holds each, --map \"joint.{variable}={},...\"",
            variables.join(", "),
            column.name
        ),
        None => format!(
            "all of its variables ({}) have a column: rename this one, or take it out",
            variables.join(", ")
        ),
    };
    ArgumentError::refuse(
        format!("{file}, line {line}, column `{}`", column.name),
        format!("{} has no variable {unknown}", robot.name),
        help,
    )
}

/// Each variable with its column, where the columns are numbered 1 to n and the variables too.
fn by_number<'a>(
    joints: &[(&str, &'a ColumnGuess)],
    variables: &[&'a str],
) -> Option<Vec<(&'a str, &'a str)>> {
    if joints.len() != variables.len() {
        return None;
    }
    let pairs = (1..=variables.len()).map(|number| {
        let variable = variables.iter().find(|name| ends_in(name, number))?;
        let (_, column) = joints.iter().find(|(name, _)| ends_in(name, number))?;
        Some((*variable, column.name.as_str()))
    });
    pairs.collect()
}

/// Whether a name ends in this number.
fn ends_in(name: &str, number: usize) -> bool {
    let word = name.trim_end_matches(|c: char| c.is_ascii_digit());
    name[word.len()..].parse() == Ok(number)
}
