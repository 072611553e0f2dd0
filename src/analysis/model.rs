//! From names and files to robot, mechanism, factors and physics.

use std::path::{Path, PathBuf};

use crate::fit::usual_parameters;
use crate::mismatch::MismatchError;
use crate::nearest::nearest;
use crate::parameters::{FitRole, ParameterChoice};
use crate::physics::{ActingPhysics, Effect, FoundEffect, Law, ModelFile};
use crate::readings::{PoseJoints, SessionHeader, check_poses};
use crate::robot::file::FactorsEntry;
use crate::robot::{FittingFactors, Mechanism, Robot, RobotError};
use crate::shipped::{nearest_and_all, shipped_robot, shipped_robots};
use crate::source_text::SourceText;
use crate::toml_text::{TomlError, read};

use super::data::LoadedSession;
use super::error::{AnalysisError, ArgumentError, Failure};
use super::files::read_text;
use super::hash::sha256;
use super::procedure::add_missing_poses;

/// Which robot, mechanism and factors, and which physics beside them. What is not chosen comes from the model file, then from the
/// session, then from the defaults: the robot `hp-robot`, its last mechanism, its factors `m_fsd` or else `unit`.
#[derive(Debug, Clone, Default)]
pub struct ModelChoice {
    /// Name of a shipped robot, or a robot file.
    pub robot: Option<String>,
    /// The robot where neither this choice nor the model nor the session names one.
    pub default_robot: Option<ConfiguredRobot>,
    /// Name of a mechanism of the robot.
    pub mechanism: Option<String>,
    /// Name of a factor set of the robot, or a TOML file with tables `beam` and `link`.
    pub factors: Option<String>,
    /// File of a model with found physics, as a diagnosis writes it.
    pub model: Option<PathBuf>,
    /// Effects beside the beams, in addition to those of the model file.
    pub effects: Vec<Effect>,
    /// Poses that the robot file does not have: those of a procedure, which effects may name.
    pub poses: Vec<PoseJoints>,
}

/// A robot that a configuration names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ConfiguredRobot {
    /// Name of a shipped robot, or a robot file.
    pub name: String,
    /// The file or variable that names it.
    pub from: String,
}

/// A robot with one mechanism, factors and physics.
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
    /// The same effects with what is known of their values.
    pub found: Vec<FoundEffect>,
    /// The configuration file or variable that named the robot, if one did.
    pub robot_from: Option<String>,
    /// What a user should know of robot and model.
    pub warnings: Vec<String>,
}

impl ResolvedModel {
    /// The mechanism.
    ///
    /// # Errors
    /// If the robot was changed and lacks it.
    pub fn mechanism(&self) -> Result<&Mechanism, RobotError> {
        self.robot.mechanism(Some(&self.mechanism))
    }

    /// The parameters that are free unless the user says: the springs that the robot file frees; if it frees none, those of all joints
    /// on rigid links, else the factors of beams.
    ///
    /// # Errors
    /// As [`ResolvedModel::mechanism`].
    pub fn usual_parameters(&self) -> Result<ParameterChoice, RobotError> {
        Ok(usual_parameters(&self.robot, self.mechanism()?))
    }

    /// The factors with what the robot file states of the springs that a fit may move: it starts there.
    pub(super) fn start_of_fit(&self, choice: &ParameterChoice) -> FittingFactors {
        let own = self.robot.with_own_springs(&self.factors);
        let mut start = self.factors.clone();
        let moved = choice.members.iter();
        let moved = moved.filter(|one| one.role != FitRole::Fixed && !one.parameter.is_factor());
        for member in moved {
            if let Some(compliance) = own.spring(&member.parameter) {
                start.set(&member.parameter, compliance);
            }
        }
        start
    }

    /// The factors with the robot's own springs and those that the effects name, and the other effects.
    pub(super) fn springs_apart(&self) -> (FittingFactors, Vec<Effect>) {
        let mut start = self.robot.with_own_springs(&self.factors);
        let mut others = Vec::new();
        for effect in &self.physics.effects {
            match effect.as_spring() {
                Some((spring, own)) => start.set(&spring, start.get(&spring) + own),
                None => others.push(effect.clone()),
            }
        }
        (start, others)
    }
}

/// Text of a robot file or of a shipped robot; a file that another file names stands beside that one.
///
/// # Errors
/// For a name that is neither a file nor a shipped robot, or a file that cannot be read.
pub fn robot_source(name: &str, named_by: Option<&Path>) -> Result<SourceText, Failure> {
    let path = named_by.map_or_else(|| PathBuf::from(name), |file| file.with_file_name(name));
    // A link beside another file may lead anywhere.
    if path.is_file() && !(named_by.is_some() && path.is_symlink()) {
        let text = read_text(&path)?;
        return Ok(SourceText::new(path.display().to_string(), text));
    }
    shipped_robot(name).ok_or_else(|| match named_by {
        Some(file) => Failure::from(AnalysisError::NamedRobot {
            file: file.to_owned(),
            robot: name.to_owned(),
        }),
        None => not_there("robot", name, shipped_robots()).into(),
    })
}

/// That a name is neither a file nor shipped.
pub(super) fn not_there<'a>(
    kind: &str,
    name: &str,
    shipped: impl Iterator<Item = &'a str> + Clone,
) -> ArgumentError {
    ArgumentError::new(
        format!("--{kind} {name}"),
        format!("there is no such file and no shipped {kind} of that name"),
        nearest_and_all(name, shipped, &format!("shipped {kind}s are")),
    )
}

/// Readings carry no information about the robot they come from.
pub(super) fn no_robot() -> Failure {
    AnalysisError::NoRobot {
        help: format!(
            "add --robot FILE, or --robot with a shipped name: {}",
            shipped_robots().collect::<Vec<_>>().join(", ")
        ),
    }
    .into()
}

/// Robot, mechanism, factors and physics: the user's choice first, then the model's, then the session's, then the defaults.
///
/// # Errors
/// For a robot, mechanism, factor set, model or effect that is not there or cannot be read.
pub fn resolve(
    choice: &ModelChoice,
    session: Option<&LoadedSession>,
) -> Result<ResolvedModel, Failure> {
    let Some(session) = session else {
        return resolve_beside(choice, None);
    };
    let mut model = resolve_beside(choice, Some((session.header.as_ref(), &session.folder)))?;
    add_missing_poses(&mut model.robot, &session.table.pose_joints);
    let poses = model.robot.poses.iter().map(|named| named.id.clone());
    check_poses(&session.table, &poses.collect::<Vec<_>>())?;
    Ok(model)
}

/// The same beside data of any form.
///
/// # Arguments
/// - `data`: the header of the session, if there is one, and its folder; `None` without data.
///
/// # Errors
/// As [`resolve`], but for poses.
pub(super) fn resolve_beside(
    choice: &ModelChoice,
    data: Option<(Option<&SessionHeader>, &Path)>,
) -> Result<ResolvedModel, Failure> {
    let header = data.and_then(|(header, _)| header.cloned());
    let header = header.unwrap_or_default();
    let folder = data.map_or(Path::new(""), |(_, folder)| folder);
    let named = named_model(choice.model.as_deref())?;
    let model = named.as_ref().map(|named| &named.model);
    let from_model = model.and_then(|model| model.robot.as_ref());
    let is_named = choice.robot.is_some() || from_model.is_some() || header.robot.is_some();
    let configured = choice.default_robot.as_ref().filter(|_| !is_named);
    let chosen = choice
        .robot
        .as_ref()
        .or(configured.map(|robot| &robot.name));
    let source = match (chosen, from_model, &header.robot) {
        (Some(name), ..) => robot_source(name, None)?,
        (None, Some(name), _) => {
            robot_source(name, named.as_ref().map(|named| named.path.as_path()))?
        }
        (None, None, Some(name)) => robot_source(name, Some(&folder.join("session.toml")))?,
        (None, None, None) if data.is_some() => return Err(no_robot()),
        (None, None, None) => robot_source("hp-robot", None)?,
    };
    let mut robot = Robot::parse(&source)?;
    add_missing_poses(&mut robot, &choice.poses);
    if let Some(procedure) = &header.procedure {
        add_missing_poses(&mut robot, &procedure.joint_values);
    }
    let mechanism = choice.mechanism.as_ref();
    if let (None, Some(named), Some(of_session)) = (mechanism, &named, &header.mechanism)
        && let Some(of_model) = named.model.mechanism.as_ref()
        && of_model != of_session
    {
        return Err(AnalysisError::OtherMechanism {
            model: named.path.display().to_string(),
            of_model: of_model.clone(),
            of_session: of_session.clone(),
        }
        .into());
    }
    let mechanism = mechanism.or(model.and_then(|model| model.mechanism.as_ref()));
    let mechanism = mechanism.or(header.mechanism.as_ref()).map(String::as_str);
    let mechanism = robot.mechanism(mechanism)?;
    let from_model = named.as_ref().and_then(|named| {
        Some((
            named.path.display().to_string(),
            named.model.factors.clone()?,
        ))
    });
    let (factors_name, factors) = match (&choice.factors, from_model, &header.factors) {
        (Some(name), ..) => (name.clone(), factor_set(&robot, name, Path::new(""))?),
        (None, Some(factors), _) => factors,
        (None, None, Some(name)) => (name.clone(), factor_set(&robot, name, folder)?),
        (None, None, None) => {
            let (name, factors) = robot.default_factors();
            (name.to_owned(), factors)
        }
    };
    robot.check_parameters(&factors)?;
    let mut found = model.map_or_else(Vec::new, |model| model.effects.clone());
    found.extend(choice.effects.iter().cloned().map(FoundEffect::from));
    let effects = found.iter().map(|found| found.effect.clone()).collect();
    let physics = ActingPhysics::new(&robot, mechanism, effects)?;
    let sha256 = sha256(&source.text);
    let mut warnings = robot.warnings.clone();
    let other = named
        .as_ref()
        .and_then(|named| named.other_robot(Path::new(&source.name), &sha256));
    warnings.extend(other);
    if data.is_some() {
        let other_file = header.robot_sha256.is_some_and(|hash| hash != sha256);
        if other_file && choice.robot.is_none() && named.is_none() {
            let robot = source.name.clone();
            return Err(AnalysisError::OtherRobot { robot }.into());
        }
        if other_file {
            warnings.push(format!(
                "{} is not the robot file of the session (its SHA-256 differs); it is used because you named it",
                source.name
            ));
        }
    }
    Ok(ResolvedModel {
        mechanism: mechanism.name.clone(),
        robot,
        factors_name,
        factors,
        source,
        physics,
        found,
        robot_from: configured.map(|robot| robot.from.clone()),
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
    let text = read_text(&path)?;
    let (entry, unknown) =
        read::<FactorsEntry>(&SourceText::new(name, text)).map_err(|TomlError(error)| {
            AnalysisError::Factors {
                file: error.place(),
                problem: error.problem.to_string(),
            }
        })?;
    if let Some(key) = unknown.first() {
        return Err(AnalysisError::Factors {
            file: format!("{name}:{}:{}", key.line, key.column),
            problem: format!("key `{}` is not known{}", key.key, key.advice()),
        }
        .into());
    }
    let wrong = |problem: String| AnalysisError::Factors {
        file: name.to_owned(),
        problem,
    };
    let factors = entry.values().map_err(|error| wrong(error.to_string()))?;
    let checked = robot.check_parameters(&factors);
    checked.map_err(|error| wrong(error.to_string()))?;
    Ok(factors)
}

/// A model file with its place.
struct NamedModel {
    /// Where it stands.
    path: PathBuf,
    /// What is in it.
    model: ModelFile,
}

/// Reads a model file, if one is named.
fn named_model(path: Option<&Path>) -> Result<Option<NamedModel>, Failure> {
    let Some(path) = path else { return Ok(None) };
    let source = SourceText::new(path.display().to_string(), read_text(path)?);
    Ok(Some(NamedModel {
        path: path.to_owned(),
        model: ModelFile::parse(&source)?,
    }))
}

impl NamedModel {
    /// Warns of a robot file that is not the one of the model.
    fn other_robot(&self, file: &Path, sha256: &str) -> Option<String> {
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

/// Laws by name; a name may stand for two, as `thermal-drift` does.
///
/// # Errors
/// For a name that is no law's.
pub fn laws(names: &[String]) -> Result<Vec<Law>, MismatchError> {
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

fn unknown_law(name: &str) -> MismatchError {
    let list = Law::names().join(", ");
    MismatchError::UnknownLaw {
        name: name.to_owned(),
        known: match nearest(name, Law::names()) {
            Some(near) => format!("{list}; did you mean {near}?"),
            None => list,
        },
    }
}
