//! The robot, mechanism, factors and physics that options name, and physics in words.

use crate::analysis::{ConfiguredRobot, LoadedSession, ModelChoice, ResolvedModel, resolve};
use crate::physics::{ActingPhysics, Effect, NotAnEffect};
use crate::procedure::Procedure;

use super::args::ModelArgs;
use super::failure::Failure;

impl ModelArgs {
    /// The choice that the options make.
    pub(super) fn choice(&self) -> Result<ModelChoice, NotAnEffect> {
        let effects: Result<Vec<Effect>, _> =
            self.effects.iter().map(|text| text.parse()).collect();
        Ok(ModelChoice {
            robot: self.robot.clone(),
            default_robot: self.configured_robot(),
            mechanism: self.mechanism.clone(),
            factors: self.factors.clone(),
            model: self.model.clone(),
            effects: effects?,
            poses: Vec::new(),
        })
    }

    /// The robot of the configuration.
    fn configured_robot(&self) -> Option<ConfiguredRobot> {
        let [name, from] = self.default_robot.as_deref()? else {
            return None;
        };
        Some(ConfiguredRobot {
            name: name.clone(),
            from: from.clone(),
        })
    }

    /// The model without a session.
    ///
    /// # Errors
    /// For a robot, mechanism, factor set, model or effect that is not there or cannot be read.
    pub fn resolve(&self) -> Result<ResolvedModel, Failure> {
        resolve(&self.choice()?, None)
    }

    /// The model of a robot that takes the poses of a procedure too.
    pub(super) fn resolve_in(&self, procedure: &Procedure) -> Result<ResolvedModel, Failure> {
        let choice = ModelChoice {
            poses: procedure.joint_values.clone(),
            ..self.choice()?
        };
        resolve(&choice, None)
    }

    /// The model of a session.
    pub(super) fn resolve_for(&self, session: &LoadedSession) -> Result<ResolvedModel, Failure> {
        resolve(&self.choice()?, Some(session))
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
