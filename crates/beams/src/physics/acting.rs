//! Effects at work in a mechanism.

use crate::robot::{
    FittingFactors, JointModel, Mechanism, MechanismModel, ModelParameter, Pose, Predictor, Robot,
    RobotError, base_levers_between,
};
use crate::structure::Compliance6;

use super::effect::{Effect, EffectError};
use super::law_set::{LawSet, without_elements};
use super::mechanics::Mechanics;
use super::place::Place;

/// A mechanism with effects in it: what is left of it without its loose members, and the laws that act there.
#[derive(Debug, Clone)]
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
        check_springs(robot, mechanism, &effects)?;
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
            .filter(|effect| !effect.law.is_missing_element())
            .cloned()
            .collect();
        Ok(Self {
            laws: LawSet::new(robot, &rest, &others)?,
            mechanism: rest,
            effects,
        })
    }

    /// Values of all parameters with the springs that effects put into the structure.
    #[must_use]
    pub fn with_springs(&self, factors: &FittingFactors) -> FittingFactors {
        let mut sprung = factors.clone();
        for (spring, compliance) in self.effects.iter().filter_map(Effect::spring_of_structure) {
            sprung.set(&spring, factors.get(&spring) + compliance);
        }
        sprung
    }

    /// The joints as the effects leave them in a pose under a force at the end: laws that are not linear by their secant from the
    /// unloaded state.
    ///
    /// # Arguments
    /// - `force_n`: zero takes each law under the smallest force: a joint with friction stuck, play not taken up.
    ///
    /// # Errors
    /// [`RobotError`] for the pose or the structure.
    pub fn joints_under(
        &self,
        robot: &Robot,
        factors: &FittingFactors,
        pose: &Pose,
        force_n: [f64; 3],
    ) -> Result<JointModel, RobotError> {
        // Without a law no joint turns beside its spring, also where rigid links close a loop.
        if !self.effects.iter().any(|effect| effect.law.is_of_a_joint()) {
            return Ok(JointModel::Rigid);
        }
        let poses = std::slice::from_ref(pose);
        let factors = &self.with_springs(factors);
        let mechanics = Mechanics::new(robot, &self.mechanism, factors, poses)?;
        let joints = self.mechanism.joints(robot);
        let secants = self.laws.secants_nm_per_rad(mechanics.pose(0), force_n);
        let turning = secants.into_iter().filter(|(_, k)| k.is_finite());
        let hinges: Vec<(usize, f64)> = turning.map(|(lever, k)| (joints[lever], k)).collect();
        Ok(if hinges.is_empty() {
            JointModel::Rigid
        } else {
            JointModel::Hinged(hinges)
        })
    }

    /// The compliance of an end on a base that rocks: C + Σ c w wᵀ, w = (axis × (end - first support), axis) for each axis.
    #[must_use]
    pub fn with_base(&self, fixed: &Compliance6, model: &MechanismModel<'_>) -> Compliance6 {
        self.rocking(fixed, model.base_levers())
    }

    /// The same for an end at `end_m` whose first support is at `support_m`.
    #[must_use]
    pub fn with_base_at(
        &self,
        fixed: &Compliance6,
        support_m: [f64; 3],
        end_m: [f64; 3],
    ) -> Compliance6 {
        self.rocking(fixed, base_levers_between(support_m, end_m))
    }

    fn rocking(&self, fixed: &Compliance6, levers: [[f64; 6]; 3]) -> Compliance6 {
        let mut compliance = *fixed;
        compliance.add_rocking(self.laws.base_rad_per_nm(), &levers);
        compliance
    }

    /// Effects of the bench rather than of the robot: of gauges, their stand, the load's direction, time and repeats.
    pub fn of_the_bench(&self) -> impl Iterator<Item = &Effect> {
        let effects = self.effects.iter();
        effects.filter(|effect| !effect.law.place_kind.is_of_robot())
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

/// Springs of the structure must be in a joint of the mechanism, across its axis.
fn check_springs(
    robot: &Robot,
    mechanism: &Mechanism,
    effects: &[Effect],
) -> Result<(), EffectError> {
    let all = ModelParameter::all(robot, mechanism);
    let is_there = |effect: &&Effect| {
        let spring = effect.spring_of_structure();
        spring.is_none_or(|(spring, _)| all.contains(&spring))
    };
    let mut effects = effects.iter();
    effects.find(|one| !is_there(one)).map_or(Ok(()), |effect| {
        let across = all.iter().filter_map(|one| Effect::of_spring(one, 0.0));
        let alike = across.filter(|other| other.law == effect.law);
        Err(EffectError::Unknown {
            place: effect.place.clone(),
            mechanism: mechanism.name.clone(),
            kind: "axis across a joint",
            known: alike.map(|other| other.place.compact()).collect(),
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
    use crate::physics::{JointRotations, LoadPoint, RunLoads};
    use crate::robot::Theory;
    use stiffbench_test_files::shipped_robot;
    use stiffbench_units_and_text::load_direction::LoadDirection;
    use stiffbench_units_and_text::test_point::Direction;

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
    fn joint_and_base_together_make_the_displacements_of_the_laws() {
        let robot = Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap();
        let mechanism = robot.mechanism(Some("F")).unwrap();
        let factors = robot.factor_set("m_fsd").unwrap();
        let pose = robot.pose(&"P2".into()).unwrap();
        let effects = [
            "joint-compliance@A4:c=4urad/(N*m)",
            "joint-friction@A4B:c=0.19mrad/(N*m),friction_moment=0.1N*m",
            "joint-backlash@A4B:play=0.12mrad,seat_moment=0.05N*m",
            "joint-nonlinearity@B3:c=0.2mrad/(N*m),q=30urad/(N*m)^2",
            "base-compliance@x:c=0.2urad/(N*m)",
            "base-compliance@z:c=0.1urad/(N*m)",
        ];
        let effects: Vec<Effect> = effects.iter().map(|text| text.parse().unwrap()).collect();
        let physics = ActingPhysics::new(&robot, mechanism, effects).unwrap();
        let poses = std::slice::from_ref(pose);
        let mechanics = Mechanics::new(&robot, mechanism, &factors, poses).unwrap();
        for direction in Direction::ALL {
            let mut force_n = [0.0; 3];
            force_n[direction.index()] = -60.0;
            let joints = physics
                .joints_under(&robot, &factors, pose, force_n)
                .unwrap();
            let theory = Theory::EulerBernoulli;
            let mut predictor =
                Predictor::with(&robot, mechanism, &joints, theory, &factors).unwrap();
            predictor.place(pose).unwrap();
            let compliance = physics.with_base(&predictor.compliance(), predictor.model());
            let loads = [LoadPoint {
                force_n: -60.0,
                ..LoadPoint::default()
            }];
            let run = RunLoads {
                pose: &"P2".into(),
                load: LoadDirection::of_axis(direction),
                read: direction.into(),
                repeat: 1,
                release_n: None,
                loads: &loads,
            };
            let mut moved = [0.0];
            let laws = &physics.laws;
            laws.displacements_m(
                mechanics.pose(0),
                &run,
                &mut JointRotations::default(),
                &mut moved,
            );
            let secant = compliance.direct(direction.index());
            assert!(
                (moved[0] / -60.0 / secant - 1.0).abs() < 1e-7,
                "{direction}: {moved:?} {secant}"
            );
        }
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
