//! The force gauge reads too little or too much by a share.

use crate::physics::action::LawAction;
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, LawDefinition, LawFigure, LawKind, LawWording, MistakePrior};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::PlaceKind;
use crate::physics::search::{SearchSpec, Shape};

/// A larger error of scale is another unit, and is seen at once.
pub(super) const ANOTHER_UNIT: f64 = 0.3;

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "gauge-scale",
    row: "gauge-scale (force)",
    kind: LawKind::Setup(MistakePrior::Size(0.03)),
    equation: "true force = F (1 + scale)",
    place_kind: PlaceKind::ForceGauge,
    parameters: &[ParameterSpec {
        name: "scale",
        word: "error of scale",
        dimension: Dimension::Share,
        sign: SignConstraint::Either,
        plausible: PlausibleRange {
            bounds: |_, _| [-ANOTHER_UNIT, ANOTHER_UNIT],
            reason: "up to 0.3: more would be a wrong unit, and obvious",
        },
        typical: Typical {
            value: |_| 1e-6,
            spread: 1.0,
        },
        fit: OF_A_SIZE,
    }],
    contains: &[],
    combination: None,
    action: LawAction::Force(|&[scale, ..], load| scale * load.force_n),
    search: SearchSpec {
        shapes: |_| vec![Shape::of_either_sign(vec![1e-3])],
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |_, _| "a wrong scale of the force gauge".to_owned(),
        heading: |_| "scale of the force gauge".to_owned(),
        explanation: "The true force differs from the reading of the force gauge by the same fraction at every load.",
    },
    check: Some(Check {
        rank: 0,
        text: |_| "hang a known weight on the force gauge and compare its reading; check the date of its calibration and its sensitivity setting".to_owned(),
        minutes: 10.0,
    }),
};
