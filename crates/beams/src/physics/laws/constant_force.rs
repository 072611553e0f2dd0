//! A force that acts beside the one that the gauge reads.

use crate::physics::action::LawAction;
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, LawDefinition, LawFigure, LawKind, LawWording, MistakePrior};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::PlaceKind;
use crate::physics::search::{SearchSpec, Shape, VISIBLE_SHARE};

/// Share of the largest force that goes unseen beside it, 1.
const UNSEEN: f64 = 0.3;

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "constant-force",
    row: "constant-force",
    kind: LawKind::Setup(MistakePrior::Size(2.0)),
    equation: "true force = F + w under load, none at the zero",
    place_kind: PlaceKind::Direction,
    parameters: &[ParameterSpec {
        name: "w",
        word: "force",
        dimension: Dimension::Force,
        sign: SignConstraint::Either,
        plausible: PlausibleRange {
            bounds: |scale, _| [-1.0, 1.0].map(|side| side * UNSEEN * scale.force_n),
            reason: "up to three tenths of the largest force: a hook, a cable or a gauge that was not zeroed; more would show on the display",
        },
        typical: Typical {
            value: |_| 1e-8,
            spread: 1.0,
        },
        fit: OF_A_SIZE,
    }],
    contains: &[],
    combination: None,
    action: LawAction::Force(|&[w, ..], load| if load.is_unloaded { 0.0 } else { w }),
    search: SearchSpec {
        shapes: |scale| vec![Shape::of_either_sign(vec![VISIBLE_SHARE * scale.force_n])],
        // A line with a free zero contains it.
        unseen_at_place: (
            "without an unloaded reading the gauge zero absorbs it",
            "read the gauge unloaded too, before each load sequence",
        ),
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, _| format!("a constant force in {at}"),
        heading: |place| format!("a constant force, {place}"),
        explanation: "An additional constant force acts in every reading under load, such as the weight of a hook on the gauge; it is absent at the zero.",
    },
    check: Some(Check {
        rank: 0,
        text: |_| {
            "zero the force gauge with everything on it that it carries under load, and repeat the smallest loads of one cell".to_owned()
        },
        minutes: 10.0,
    }),
};

#[cfg(test)]
mod tests {
    use crate::physics::{Effect, LawSet, LoadPoint, PoseMechanics, RunLoads, JointRotations};
    use crate::structure::RotationInfluence;
    use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::Direction;

    #[test]
    fn it_acts_under_load_in_its_direction_and_not_at_the_zero() {
        let compliance_m_per_n = 3e-7;
        let pose = PoseMechanics {
            influence: RotationInfluence::of_one_joint(compliance_m_per_n, 0.3),
            ..PoseMechanics::default()
        };
        let mut laws = LawSet::default();
        laws.push(&"constant-force@y:w=-0.8N".parse::<Effect>().unwrap(), None);
        let loads = [0.0, -10.0, -20.0].map(|force_n| LoadPoint {
            force_n,
            is_unloaded: force_n == 0.0,
            ..LoadPoint::default()
        });
        for (direction, w_n) in [(Direction::Y, -0.8), (Direction::X, 0.0)] {
            let run = RunLoads {
                pose: &"P1".into(),
                load: LoadDirection::of_axis(direction),
                read: direction.into(),
                repeat: 1,
                release_n: None,
                loads: &loads,
            };
            let mut moved = [0.0; 3];
            laws.displacements_m(&pose, &run, &mut JointRotations::default(), &mut moved);
            let expected = [0.0, -10.0 + w_n, -20.0 + w_n].map(|acting| acting * compliance_m_per_n);
            assert!(
                moved.iter().zip(expected).all(|(m, e)| (m - e).abs() < 1e-18),
                "{moved:?} {expected:?}"
            );
        }
    }
}
