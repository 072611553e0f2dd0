//! Effects at work in a mechanism.

use crate::robot::{FittingFactors, Mechanism, Predictor, Robot};

use super::effect::{Effect, EffectError};
use super::law::Law;
use super::law_set::{LawSet, without_elements};
use super::place::Place;

/// A mechanism with effects in it: what is left of it without its loose members, and the laws that act there.
#[derive(Debug, Clone, PartialEq)]
pub struct ActingPhysics {
    /// The effects.
    pub effects: Vec<Effect>,
    /// The mechanism without its loose members.
    pub mechanism: Mechanism,
    /// The laws of all other effects.
    pub laws: LawSet,
}

impl ActingPhysics {
    /// Puts effects into a mechanism.
    ///
    /// # Errors
    /// [`EffectError::Unknown`] for a joint, element or pose that is not there, [`EffectError::FallsApart`] if the rest carries no load.
    pub fn new(
        robot: &Robot,
        mechanism: &Mechanism,
        effects: Vec<Effect>,
    ) -> Result<Self, EffectError> {
        check_poses(robot, mechanism, &effects)?;
        let rest = without_elements(robot, mechanism, &effects)?;
        if rest != *mechanism && !carries(robot, &rest) {
            let loose = effects.iter().filter_map(|effect| match &effect.place {
                Place::Element(name) => Some(name.as_str()),
                _ => None,
            });
            return Err(EffectError::FallsApart {
                element: loose.collect::<Vec<_>>().join(" and "),
                mechanism: mechanism.name.clone(),
            });
        }
        let others: Vec<Effect> = effects
            .iter()
            .filter(|effect| effect.law != Law::LooseMember)
            .cloned()
            .collect();
        Ok(Self {
            laws: LawSet::new(robot, &rest, &others)?,
            mechanism: rest,
            effects,
        })
    }
}

/// Runs that effects name must be in poses that the robot has.
fn check_poses(
    robot: &Robot,
    mechanism: &Mechanism,
    effects: &[Effect],
) -> Result<(), EffectError> {
    let unknown = effects.iter().find(|effect| match &effect.place {
        Place::Run { pose, .. } => robot.pose(pose).is_err(),
        _ => false,
    });
    unknown.map_or(Ok(()), |effect| {
        let known = robot.poses.iter().map(|named| named.id.to_string());
        Err(EffectError::Unknown {
            place: effect.place.clone(),
            mechanism: mechanism.name.clone(),
            kind: "pose",
            known: known.collect(),
        })
    })
}

/// Whether a mechanism carries a load in its nominal pose, or in a named one if that cannot be reached.
fn carries(robot: &Robot, mechanism: &Mechanism) -> bool {
    let Ok(mut predictor) = Predictor::new(robot, mechanism, &FittingFactors::UNIT) else {
        return false;
    };
    let named = robot.poses.iter().map(|named| named.pose.clone());
    let mut poses = std::iter::once(robot.nominal_pose()).chain(named);
    poses.any(|pose| predictor.place(&pose).is_ok())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::shipped_robot;

    fn acting(mechanism: &str, effects: &[&str]) -> Result<ActingPhysics, EffectError> {
        let robot = Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap();
        let effects = effects.iter().map(|text| text.parse().unwrap()).collect();
        ActingPhysics::new(&robot, robot.mechanism(Some(mechanism)).unwrap(), effects)
    }

    #[test]
    fn a_loose_member_leaves_the_mechanism_and_its_joints_with_it() {
        let all = acting("F", &[]).unwrap();
        let rest = acting(
            "F",
            &["loose-member@B1B2", "joint-compliance@A3:c=1urad/(N*m)"],
        );
        let rest = rest.unwrap();
        assert_eq!(
            rest.mechanism.members.len() + 1,
            all.mechanism.members.len()
        );
        assert_eq!(rest.effects.len(), 2);
    }

    #[test]
    fn what_is_not_there_or_cannot_be_spared_is_refused() {
        for effect in [
            "loose-member@Z9",
            "joint-compliance@Z9:c=1urad/(N*m)",
            "slip@P9.x.1.1:jump=1um",
        ] {
            let error = acting("F", &[effect]).unwrap_err();
            assert!(matches!(error, EffectError::Unknown { .. }), "{error}");
        }
        let error = acting("A", &["loose-member@A3A4"]);
        let names = acting("A", &["loose-member@Z9"]).unwrap_err();
        assert!(
            matches!(error, Err(EffectError::FallsApart { .. })),
            "{error:?} {names:?}"
        );
    }
}
