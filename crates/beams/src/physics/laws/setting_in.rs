//! First repeats that give more, or less, than the later ones.

use super::base_compliance::TOO_LITTLE_AT_PLACE;
use crate::physics::action::LawAction;
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, Curve, Driving, LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{
    OF_A_SIZE, FitBy, ParameterSpec, PlausibleRange, SignConstraint, Typical,
};
use crate::physics::place::PlaceKind;
use crate::physics::search::{Needs, PlaceScale, SHAPE_ROOM, SearchSpec, Shape};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "setting-in",
    row: "setting-in",
    kind: LawKind::Physics,
    equation: "displacement * (1 + k exp(-(repeat - 1)/decay))",
    place_kind: PlaceKind::Structure,
    parameters: &[
        ParameterSpec {
            name: "k",
            word: "share",
            dimension: Dimension::Share,
            sign: SignConstraint::Either,
            plausible: PlausibleRange {
                bounds: |_, _| [-0.5, 0.5],
                reason: "up to half of the displacement: a robot that gives more is loose",
            },
            typical: Typical {
                value: |_| 1e-7,
                spread: 1.0,
            },
            fit: OF_A_SIZE,
        },
        ParameterSpec {
            name: "decay",
            word: "decay",
            dimension: Dimension::Repeats,
            sign: SignConstraint::AboveZero,
            plausible: PlausibleRange {
                bounds: |_, _| [DECAYS[0] / SHAPE_ROOM, DECAYS[DECAYS.len() - 1] * SHAPE_ROOM],
                reason: "from half a repeat to six: less is the first repeat alone, more is a slope over all",
            },
            typical: Typical {
                value: |_| 1.0,
                spread: 2.0,
            },
            fit: FitBy::Search,
        },
    ],
    contains: &[],
    action: LawAction::Growth(|&[k, decay, ..], _, repeat| {
        k * (-(f64::from(repeat) - 1.0) / decay).exp()
    }),
    search: SearchSpec {
        shapes,
        wide_shapes: None,
        phase: None,
        is_freest: false,
        without_robot: true,
        needs: Needs::Nothing,
        unseen_at_place: TOO_LITTLE_AT_PLACE,
        unseen: (
            "there is only one repeat",
            Some("repeat each load sequence three to five times"),
        ),
    },
    figure: LawFigure {
        driving: Driving::Repeat,
        pooled: None,
        large_loads_only: true,
        curve: Curve::Lines,
    },
    words: LawWording {
        phrase: |_, values| match values.first() {
            Some(k) if *k < 0.0 => "setting in (the first repeats give way less)".to_owned(),
            _ => "setting in (the first repeats give way more)".to_owned(),
        },
        heading: |_| "setting in".to_owned(),
        explanation: "The first load sequences differ from the later ones by a share that dies away.",
    },
    check: Some(Check {
        rank: 3,
        text: |_| {
            "load and release the robot ten times before the gauge is zeroed, then repeat one cell".to_owned()
        },
        minutes: 20.0,
    }),
};

/// Repeats in which the share falls to 1/e.
const DECAYS: [f64; 6] = [0.4, 0.7, 1.2, 2.0, 3.5, 6.0];

fn shapes(scale: &PlaceScale) -> Vec<Shape> {
    let shape = |decay: f64| Shape::of_either_sign(vec![1e-3, decay]);
    let decays = DECAYS.into_iter().filter(|_| scale.has_repeats);
    decays.map(shape).collect()
}
