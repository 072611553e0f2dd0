//! From what the user names to robot, mechanism, factors and physics.

use std::fs;
use std::path::{Path, PathBuf};

use crate::physics::ActingPhysics;
use crate::readings::check_poses;
use crate::robot::{FittingFactors, Robot};
use crate::shipped::{shipped_robot, shipped_robots};
use crate::source_text::SourceText;
use crate::test_point::PoseId;
use crate::toml_text::{TomlError, read_types};

use super::args::ModelArgs;
use super::data::Session;
use super::failure::{CliError, Failure};
use super::hash::sha256;
use super::model::{effects, named_model};

/// The robot the user or the session names, with its text's hash.
#[derive(Debug)]
pub struct ResolvedModel {
    /// The robot.
    pub robot: Robot,
    /// The mechanism's name.
    pub mechanism: String,
    /// Name of the factor set.
    pub factors_name: String,
    /// The factors.
    pub factors: FittingFactors,
    /// The robot's file, for copies.
    pub source: SourceText,
    /// What acts beside the beams.
    pub physics: ActingPhysics,
    /// What a user should know of robot and model.
    pub warnings: Vec<String>,
}

/// Text of a robot file or of a shipped robot; a file that another file names stands beside that one.
///
/// # Errors
/// For a name that is neither a file nor a shipped robot, or a file that cannot be read.
pub fn robot_source(name: &str, named_by: Option<&Path>) -> Result<SourceText, Failure> {
    let path = named_by.map_or_else(|| PathBuf::from(name), |file| file.with_file_name(name));
    if path.is_file() {
        let text = fs::read_to_string(&path).map_err(|source| CliError::Read {
            path: path.clone(),
            source,
        })?;
        return Ok(SourceText::new(path.display().to_string(), text));
    }
    shipped_robot(name).ok_or_else(|| {
        if let Some(file) = named_by {
            let (file, robot) = (file.to_owned(), name.to_owned());
            return CliError::NamedRobot { file, robot }.into();
        }
        let shipped = shipped_robots().collect::<Vec<_>>().join(", ");
        CliError::Argument {
            argument: format!("--robot {name}"),
            problem: "there is no such file and no shipped robot of that name".to_owned(),
            help: Some(format!("shipped robots are {shipped}")),
        }
        .into()
    })
}

/// Readings say nothing about the robot they come from.
pub(super) fn no_robot() -> CliError {
    CliError::NoRobot {
        help: format!(
            "add --robot FILE, or --robot with a shipped name: {}",
            shipped_robots().collect::<Vec<_>>().join(", ")
        ),
    }
}

/// Robot, mechanism, factors and physics: the user's choice first, then the model's, then the session's, then the defaults.
///
/// # Errors
/// For a robot, mechanism, factor set, model or effect that is not there or cannot be read.
pub fn resolve(args: &ModelArgs, session: Option<&mut Session>) -> Result<ResolvedModel, Failure> {
    let header = session.as_ref().and_then(|session| session.header.clone());
    let header = header.unwrap_or_default();
    let folder = session.as_ref().map(|session| session.folder.clone());
    let folder = folder.unwrap_or_default();
    let named = named_model(args)?;
    let model = named.as_ref().map(|named| &named.model);
    let from_model = model.and_then(|model| model.robot.as_ref());
    let source = match (&args.robot, from_model, &header.robot) {
        (Some(name), ..) => robot_source(name, None)?,
        (None, Some(name), _) => {
            robot_source(name, named.as_ref().map(|named| named.path.as_path()))?
        }
        (None, None, Some(name)) => robot_source(name, Some(&folder.join("session.toml")))?,
        (None, None, None) if session.is_some() => return Err(no_robot().into()),
        (None, None, None) => robot_source("hp-robot", None)?,
    };
    let robot = Robot::parse(&source)?;
    let mechanism = args.mechanism.as_ref();
    let mechanism = mechanism.or(model.and_then(|model| model.mechanism.as_ref()));
    let mechanism = mechanism.or(header.mechanism.as_ref()).map(String::as_str);
    let mechanism = robot.mechanism(mechanism)?;
    let from_model = named.as_ref().and_then(|named| {
        Some((
            named.path.display().to_string(),
            named.model.factors.clone()?,
        ))
    });
    let (factors_name, factors) = match (&args.factors, from_model, &header.factors) {
        (Some(name), ..) => (name.clone(), factor_set(&robot, name, Path::new(""))?),
        (None, Some(factors), _) => factors,
        (None, None, Some(name)) => (name.clone(), factor_set(&robot, name, &folder)?),
        (None, None, None) => {
            let (name, factors) = robot.default_factors();
            (name.to_owned(), factors)
        }
    };
    robot.check_parameters(&factors)?;
    let physics = ActingPhysics::new(&robot, mechanism, effects(model, args)?)?;
    let sha256 = sha256(&source.text);
    let mut warnings = robot.warnings.clone();
    let other = named
        .as_ref()
        .and_then(|named| named.other_robot(Path::new(&source.name), &sha256));
    warnings.extend(other);
    if let Some(session) = session {
        session.warnings.extend(warnings.iter().cloned());
        let other_file = header.robot_sha256.is_some_and(|hash| hash != sha256);
        if other_file && args.robot.is_none() && named.is_none() {
            let robot = source.name.clone();
            return Err(CliError::OtherRobot { robot }.into());
        }
        if other_file {
            session.warnings.push(format!(
                "{} is not the robot file of the session (its SHA-256 differs); it was named and is used",
                source.name
            ));
        }
        let poses: Vec<PoseId> = robot.poses.iter().map(|named| named.id.clone()).collect();
        check_poses(&session.table, &poses)?;
    }
    Ok(ResolvedModel {
        mechanism: mechanism.name.clone(),
        robot,
        factors_name,
        factors,
        source,
        physics,
        warnings,
    })
}

/// A factor set by name, or from a TOML file with tables `beam` and `link` in `folder`.
fn factor_set(robot: &Robot, name: &str, folder: &Path) -> Result<FittingFactors, Failure> {
    let path = folder.join(name);
    let is_file_name = path.is_file() || path.extension().is_some_and(|end| end == "toml");
    if robot.factors.contains_key(name) || !is_file_name {
        return Ok(robot.factor_set(name)?);
    }
    let text = fs::read_to_string(&path).map_err(|source| CliError::Read {
        path: path.clone(),
        source,
    })?;
    let entry: crate::robot::file::FactorsEntry = read_types(&SourceText::new(name, text))
        .map_err(|TomlError(error)| CliError::Factors {
            file: error.place(),
            problem: error.problem.to_string(),
        })?;
    let factors = entry.values();
    let checked = robot.check_parameters(&factors);
    checked.map_err(|error| CliError::Factors {
        file: name.to_owned(),
        problem: error.to_string(),
    })?;
    Ok(factors)
}
