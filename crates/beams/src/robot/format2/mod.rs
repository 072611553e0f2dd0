//! The robot file, format `stiffbench/robot/2`: joints with springs, links rigid or beams, units as suffixes of keys.
//!
//! A file in this format becomes the same [`Robot`] as one in the older format ([`crate::robot::file`]).

mod builder;
pub mod file;
mod frames;
mod joints;
mod links;
mod loads;
mod materials;
pub mod measure;
mod names;
pub mod parts;
mod points;
mod poses;
mod profiles;
mod rolled;
mod sections;
mod shapes;
mod springs;
mod variables;

use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::toml_text::{TomlDocument, remove_null};

use super::Robot;
use super::error::RobotError;

pub use names::ends_in_unit;
pub use variables::DEFAULT_LIMITS;

use builder::RobotBuilder;
use file::RobotFile2;

/// The schema that a file of this format names.
pub const SCHEMA: &str = "stiffbench/robot/2";

/// The JSON Schema of the format (draft 2020-12), for editors that complete and check TOML.
#[must_use]
pub fn json_schema() -> serde_json::Value {
    let mut schema = schemars::schema_for!(RobotFile2).to_value();
    if let Some(object) = schema.as_object_mut() {
        object.insert("title".to_owned(), format!("robot file, {SCHEMA}").into());
    }
    schema["properties"]["schema"]["const"] = SCHEMA.into();
    remove_null(&mut schema);
    measure::write_units(&mut schema);
    schema
}

/// Whether a text names a schema, as files of this format do and those of the older one do not.
pub(super) fn is_of_this_format(source: &SourceText) -> bool {
    TomlDocument::parse(source).is_ok_and(|document| document.root().get("schema").is_some())
}

/// Reads and checks a robot file.
pub(super) fn compile(source: &SourceText) -> Result<Robot, RobotError> {
    let document = TomlDocument::parse_with_units(source, &measure::units());
    let document = document.map_err(|error| RobotError::File(error.into()))?;
    let checked = document.root().check_schema(SCHEMA, true);
    let file = checked.and_then(|()| document.types::<RobotFile2>());
    let file = file.map_err(|error| RobotError::File(error.into()))?;
    RobotBuilder::new(source, &document, &file)?.robot()
}
