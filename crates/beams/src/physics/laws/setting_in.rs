//! First repeats that give more, or less, than the later ones.

use crate::physics::action::{DrivenPath, HistoryLaw, LawAction, Values};
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, Curve, Driving, LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{
    OF_A_SIZE, FitBy, ParameterSpec, PlausibleRange, SignConstraint, Typical,
};
use crate::physics::part::{ANSWER, LEVEL};
use crate::physics::place::PlaceKind;
use crate::physics::search::{Needs, PlaceScale, SHAPE_ROOM, SearchSpec, SearchedOn, Shape};

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
                reason: "up to half of the displacement: a robot that yields more is loose",
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
                reason: "from half a repeat to six: a shorter decay affects the first repeat alone, a longer one is a slope over all repeats",
            },
            typical: Typical {
                value: |_| 1.0,
                spread: 2.0,
            },
            fit: FitBy::Search,
        },
    ],
    contains: &[],
    combination: None,
    action: LawAction::Growth(|&[k, decay, ..], _, repeat| {
        k * (-(f64::from(repeat) - 1.0) / decay).exp()
    }),
    search: SearchSpec {
        shapes,
        on: SearchedOn::ALL,
        unseen: (
            "there is only one repeat",
            Some("repeat each load sequence three to five times"),
        ),
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure {
        driving: Driving::Repeat,
        pooled: None,
        large_loads_only: true,
        curve: Curve::Lines,
    },
    words: LawWording {
        phrase: |_, values| match values.first() {
            Some(k) if *k < 0.0 => "setting in (the first repeats yield less)".to_owned(),
            _ => "setting in (the first repeats yield more)".to_owned(),
        },
        heading: |_| "setting in".to_owned(),
        explanation: "The first load sequences differ from the later ones by a fraction that decays over the repeats.",
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

/// The same of a part whose runs are not distinguished: it sets over the path of what is set, whatever its sign.
pub(super) static DUAL: LawDefinition = LawDefinition {
    row: "setting-in (part)",
    equation: "answer += size (1 - exp(-path/decay)), path = sum |change of the driver| less the way from its start",
    parameters: &[
        ParameterSpec {
            sign: SignConstraint::Either,
            plausible: PlausibleRange {
                bounds: |scale, _| [-scale.displacement_m, scale.displacement_m],
                reason: "up to the largest answer",
            },
            ..ANSWER
        },
        ParameterSpec {
            name: "decay",
            word: "path over which it sets",
            plausible: PlausibleRange {
                bounds: |scale, _| [PATHS[0], PATHS[PATHS.len() - 1]].map(|path| path * scale.force_n),
                reason: "from a quarter of the largest load to sixteen times as much, which is eight cycles",
            },
            typical: Typical {
                value: |scale| 2.0 * scale.force_n,
                spread: 3.0,
            },
            ..LEVEL
        },
    ],
    action: LawAction::History(&SetOverPath),
    search: SearchSpec {
        shapes: |scale| {
            let of_path = |path: f64| Shape::of_either_sign(vec![scale.small_answer(), path * scale.force_n]);
            PATHS.into_iter().map(of_path).collect()
        },
        on: SearchedOn::PARTS,
        needs: Needs::Return,
        ..LAW.search
    },
    ..LAW
};

/// Paths over which a part sets, in largest loads.
const PATHS: [f64; 7] = [0.25, 0.5, 1.0, 2.0, 4.0, 8.0, 16.0];

#[derive(Debug)]
struct SetOverPath;

impl HistoryLaw for SetOverPath {
    fn answers(&self, &[size, decay, ..]: &Values, path: DrivenPath<'_>, out: &mut [f64]) {
        let mut length = 0.0;
        let first = path.driver.first().copied().unwrap_or_default();
        let mut before = first;
        for (answer, &driver) in out.iter_mut().zip(path.driver) {
            length += (driver - before).abs();
            before = driver;
            let back_and_forth = length - (driver - first).abs();
            *answer = -size * (-back_and_forth / decay).exp_m1();
        }
    }
}

