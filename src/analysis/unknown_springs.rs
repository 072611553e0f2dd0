//! Springs that have no value yet, and what of the compliance of the end depends on them.

use crate::parameters::{FitRole, ParameterChoice};
use crate::physics::{Effect, laws};
use crate::robot::{FittingFactors, Mechanism, ModelParameter, Pose, Predictor, Robot, RobotError};

use super::error::{AnalysisError, Failure};
use super::model::ResolvedModel;

/// Change of an entry of the compliance per compliance of a spring, SI, below which it does not depend on the spring: a lever of 30 um.
const INDEPENDENT: f64 = 1e-9;

/// Compliance, m/N, below which nothing of a robot gives way.
pub(super) const RIGID_M_PER_N: f64 = 1e-15;

/// A stiffness, N/um, by its compliance, m/N: the number, `rigid`, or `unknown` where it depends on a spring that has no value yet.
pub fn stiffness_words(compliance: Option<f64>, number: &dyn Fn(f64) -> String) -> String {
    match compliance {
        None => "unknown".to_owned(),
        Some(compliance) if compliance <= RIGID_M_PER_N => "rigid".to_owned(),
        Some(compliance) => number(1e-6 / compliance),
    }
}

/// What gives a spring a value.
const REMEDY: &str = "fit the robot and name --factors, or state a stiffness or `spring = \"rigid\"` in the robot file";

/// The springs of a mechanism that the robot file leaves to a fit and that have no value yet: neither rigid nor of a known stiffness.
#[derive(Debug)]
pub struct UnknownSprings<'a> {
    robot: &'a Robot,
    mechanism: &'a Mechanism,
    factors: &'a FittingFactors,
    /// The springs.
    pub springs: Vec<ModelParameter>,
}

impl<'a> UnknownSprings<'a> {
    /// # Arguments
    /// - `effects`: a spring among them is a value too.
    #[must_use]
    pub fn new(
        robot: &'a Robot,
        mechanism: &'a Mechanism,
        factors: &'a FittingFactors,
        effects: &[Effect],
    ) -> Self {
        let is_own = |effect: &Effect, spring: &ModelParameter| {
            effect.law == laws::JOINT_COMPLIANCE && spring.joint() == effect.place.joint()
        };
        let mut springs = robot.unknown_springs(mechanism, factors);
        springs.retain(|spring| !effects.iter().any(|effect| is_own(effect, spring)));
        Self {
            robot,
            mechanism,
            factors,
            springs,
        }
    }

    /// Those of a model.
    #[must_use]
    pub fn of(model: &'a ResolvedModel) -> Self {
        let physics = &model.physics;
        let (mechanism, effects) = (&physics.mechanism, &physics.effects);
        Self::new(&model.robot, mechanism, &model.factors, effects)
    }

    /// That they have no value, and what gives them one; `None` if all have.
    #[must_use]
    pub fn words(&self) -> Option<String> {
        (!self.springs.is_empty()).then(|| format!("{}: {REMEDY}", self.problem()))
    }

    fn problem(&self) -> String {
        let names: Vec<String> = self.springs.iter().map(ToString::to_string).collect();
        let have = if names.len() == 1 { "has" } else { "have" };
        format!("{} {have} {}", names.join(", "), ModelParameter::UNKNOWN)
    }

    /// Those that a choice of free parameters keeps, with what is said of them.
    pub(super) fn kept(&self, choice: &ParameterChoice) -> Vec<(&ModelParameter, String)> {
        let moves = |spring: &&ModelParameter| {
            let mut members = choice.members.iter();
            members.any(|one| one.parameter == **spring && one.role != FitRole::Fixed)
        };
        let kept = self.springs.iter().filter(|spring| !moves(spring));
        kept.map(|spring| (spring, format!("{}, kept rigid", ModelParameter::UNKNOWN)))
            .collect()
    }

    /// A compliance of the end in a pose without the entries that depend on them.
    ///
    /// # Errors
    /// [`RobotError`] for a pose that cannot be reached, or a structure that carries nothing.
    pub fn known(
        &self,
        compliance: [[f64; 6]; 6],
        pose: &Pose,
    ) -> Result<[[Option<f64>; 6]; 6], RobotError> {
        let mut known = compliance.map(|row| row.map(Some));
        if self.springs.is_empty() {
            return Ok(known);
        }
        let mut predictor = Predictor::new(self.robot, self.mechanism, self.factors)?;
        predictor.place(pose)?;
        // Derivatives are those of the compliance last asked for.
        let _ = predictor.compliance();
        for change in predictor.compliance_derivatives(&self.springs) {
            let entries = known.as_flattened_mut().iter_mut();
            for (entry, change) in entries.zip(change.0.as_flattened()) {
                entry.take_if(|_| change.abs() > INDEPENDENT);
            }
        }
        Ok(known)
    }

    /// Refuses what a force at the tool does in a pose, if that depends on them.
    ///
    /// # Errors
    /// [`AnalysisError::NoStiffness`]; as [`UnknownSprings::known`].
    pub fn refuse(&self, pose: &Pose) -> Result<(), Failure> {
        let known = self.known([[0.0; 6]; 6], pose)?;
        if known[..3].iter().any(|row| row[..3].contains(&None)) {
            return Err(AnalysisError::NoStiffness {
                robot: self.robot.name.clone(),
                problem: self.problem(),
                help: REMEDY,
            }
            .into());
        }
        Ok(())
    }
}
