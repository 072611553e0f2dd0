//! Models with found physics: files that `--model` names, and effects that `--effect` adds.

use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::mismatch::MismatchError;
use crate::nearest::nearest;
use crate::physics::{ActingPhysics, Effect, Law, ModelFile};
use crate::source_text::SourceText;

use super::args::ModelArgs;
use super::failure::{CliError, Failure};

/// A model file with its place.
pub(super) struct NamedModel {
    /// Where it stands.
    pub(super) path: PathBuf,
    /// What is in it.
    pub(super) model: ModelFile,
}

/// The model that the user names, if one.
pub(super) fn named_model(args: &ModelArgs) -> Result<Option<NamedModel>, Failure> {
    let read = |path: &PathBuf| {
        let text = fs::read_to_string(path).map_err(|source| CliError::Read {
            path: path.clone(),
            source,
        })?;
        let source = SourceText::new(path.display().to_string(), text);
        Ok(NamedModel {
            path: path.clone(),
            model: ModelFile::parse(&source)?,
        })
    };
    args.model.as_ref().map(read).transpose()
}

/// The effects of a model and those that the user adds.
pub(super) fn effects(model: Option<&ModelFile>, args: &ModelArgs) -> Result<Vec<Effect>, Failure> {
    let mut effects = model.map_or_else(Vec::new, ModelFile::acting);
    for text in &args.effects {
        effects.push(text.parse()?);
    }
    Ok(effects)
}

impl NamedModel {
    /// Warns of a robot file that is not the one of the model.
    pub(super) fn other_robot(&self, file: &Path, sha256: &str) -> Option<String> {
        let expected = self.model.robot_sha256.as_ref()?;
        (expected != sha256).then(|| {
            format!(
                "{} is not the robot file that {} was made with: its SHA-256 differs",
                file.display(),
                self.path.display()
            )
        })
    }
}

/// One line of text for each effect; empty without effects.
pub(super) fn physics_text(physics: &ActingPhysics) -> String {
    let lines = physics.effects.iter().map(|effect| format!("  {effect}\n"));
    match lines.collect::<String>() {
        lines if lines.is_empty() => lines,
        lines => format!("Physics beside the beams:\n{lines}"),
    }
}

/// The effects in a line, as `--effect` takes them.
pub(super) fn effects_text(physics: &ActingPhysics) -> String {
    let effects: Vec<String> = physics.effects.iter().map(Effect::compact).collect();
    match effects.as_slice() {
        [] => "no effects beside the beams".to_owned(),
        effects => format!("effects {}", effects.join("; ")),
    }
}

/// The effects for programs.
pub(super) fn physics_json(physics: &ActingPhysics) -> Value {
    json!(
        physics
            .effects
            .iter()
            .map(Effect::to_json)
            .collect::<Vec<_>>()
    )
}

/// Laws by name; a name may stand for two, as `thermal-drift` does.
///
/// # Errors
/// For a name that is no law's.
pub fn laws(names: &[String]) -> Result<Vec<Law>, Failure> {
    let mut laws = Vec::new();
    for name in names {
        let before = laws.len();
        laws.extend(Law::named(name));
        if laws.len() == before {
            return Err(unknown_law(name));
        }
    }
    laws.sort_unstable();
    laws.dedup();
    Ok(laws)
}

fn unknown_law(name: &str) -> Failure {
    let mut known: Vec<&str> = Law::ALL.iter().map(|law| law.name).collect();
    known.dedup();
    let list = known.join(", ");
    MismatchError::UnknownLaw {
        name: name.to_owned(),
        known: match nearest(name, known) {
            Some(near) => format!("{list}; did you mean {near}?"),
            None => list,
        },
    }
    .into()
}
