//! Something that slipped, once.

use crate::physics::action::LawAction;
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, Curve, Driving, LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::place::{Place, PlaceKind};
use crate::physics::search::{SearchSpec, SearchedOn, Shape};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "slip",
    row: "slip",
    kind: LawKind::Physics,
    equation: "displacement += jump from that step of that run on",
    place_kind: PlaceKind::Run,
    parameters: &[ParameterSpec {
        name: "jump",
        word: "jump",
        dimension: Dimension::Length,
        sign: SignConstraint::Either,
        plausible: PlausibleRange {
            bounds: |scale, _| [-scale.displacement_m, scale.displacement_m],
            reason: "up to the largest displacement: a larger jump would be noticed while measuring",
        },
        typical: Typical {
            value: |_| 1e-9,
            spread: 1.0,
        },
        fit: OF_A_SIZE,
    }],
    contains: &[],
    combination: None,
    action: LawAction::Added(|&[jump, ..], _| jump),
    search: SearchSpec {
        shapes: |scale| vec![Shape::of_either_sign(vec![scale.small_answer()])],
        on: SearchedOn::ALL,
        unseen: (
            "no run that is repeated has enough load steps to distinguish a slip from an outlier",
            Some("take at least four load steps per run"),
        ),
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure {
        driving: Driving::Clock,
        pooled: None,
        large_loads_only: false,
        curve: Curve::Steps,
    },
    words: LawWording {
        phrase: |at, _| format!("a slip {at}"),
        heading: |place| match place {
            Place::Run {
                pose,
                direction,
                repeat,
                gauge,
                ..
            } => {
                let of_gauge = gauge.map_or_else(String::new, |axis| format!(", gauge along {axis}"));
                format!("a slip in {pose} {direction}, repeat {repeat}{of_gauge}")
            }
            other => format!("a slip, {other}"),
        },
        explanation: "From that reading on, all readings of that one run are shifted.",
    },
    check: Some(Check {
        rank: 3,
        text: |_| "repeat the same run".to_owned(),
        minutes: 10.0,
    }),
};
