//! A stop: beyond a load or a travel the part is stiffer.

use super::joint_compliance::ACROSS_THE_JOINT;
use crate::physics::action::{DrivenPath, HistoryLaw, LawAction, Values};
use crate::physics::law::{LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{ParameterSpec, PlausibleRange, Typical};
use crate::physics::part::{HARDEST, LEVEL, SEARCH, SLOPE, mean_slope};
use crate::physics::place::PlaceKind;
use crate::physics::search::{PlaceScale, SearchSpec, SearchedOn, Shape};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "end-stop",
    row: "end-stop",
    kind: LawKind::Physics,
    equation: "displacement -= c (|force| - stop) sign(force) beyond the stop",
    place_kind: PlaceKind::Joint,
    parameters: &[
        ParameterSpec {
            name: "c",
            word: "compliance lost at the stop",
            ..CHANGE
        },
        ParameterSpec {
            name: "stop",
            word: "load at the stop",
            ..FAR_OUT
        },
    ],
    contains: &[],
    combination: None,
    action: LawAction::History(&Stop { side: -1.0 }),
    search: SearchSpec {
        shapes,
        is_sharp: true,
        on: SearchedOn::FORCE_DRIVEN_PARTS,
        ..SEARCH
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, _| format!("a stop that {at} runs into"),
        heading: |place| format!("a stop of {place}"),
        explanation: "Up to the stop the part follows its straight line; beyond it the part is stiffer.",
    },
    check: Some(ACROSS_THE_JOINT),
};

/// The same part with its displacement set.
pub(super) static DUAL: LawDefinition = LawDefinition {
    row: "end-stop (force read)",
    equation: "force += k (|displacement| - stop) sign(displacement) beyond the stop",
    parameters: &[
        ParameterSpec {
            name: "k",
            word: "stiffness of the stop",
            ..CHANGE
        },
        ParameterSpec {
            name: "stop",
            word: "travel to the stop",
            ..FAR_OUT
        },
    ],
    action: LawAction::History(&Stop { side: 1.0 }),
    search: SearchSpec {
        is_sharp: true,
        on: SearchedOn::DISPLACEMENT_DRIVEN_PARTS,
        ..LAW.search
    },
    ..LAW
};

/// How much the slope changes at a stop.
pub(super) const CHANGE: ParameterSpec = ParameterSpec {
    plausible: PlausibleRange {
        bounds: |scale, _| [LEAST_CHANGE, HARDEST].map(|factor| factor * mean_slope(scale)),
        reason: "at least a third of the mean slope: less would be a curve, not a stop; at most a thousand times, as hard faces have it",
    },
    typical: Typical {
        value: mean_slope,
        spread: 3.0,
    },
    ..SLOPE
};

/// Change of the slope, in mean slopes, below which a stop would be a curve.
const LEAST_CHANGE: f64 = 0.3;

/// A stop lies in the outer part of the range that was set: a part that is softer only in the middle has play.
const FAR_OUT: ParameterSpec = ParameterSpec {
    plausible: PlausibleRange {
        bounds: |scale, _| [STOPS[0], LAST_STOP].map(|stop| stop * scale.force_n),
        reason: "in the outer part of the range that was set, up to its last hundredth: a part that is softer only in the middle has play",
    },
    typical: Typical {
        value: |scale| 0.7 * scale.force_n,
        spread: 1.3,
    },
    ..LEVEL
};

/// Stops that are searched, as shares of the largest that was set.
const STOPS: [f64; 9] = [0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98];

/// Stop beyond which the part would reach it with the last reading, as a share of the largest that was set.
const LAST_STOP: f64 = 0.99;

fn shapes(scale: &PlaceScale) -> Vec<Shape> {
    bent_at(scale, &STOPS)
}

/// Changes of the slope at shares of the largest that was set.
pub(super) fn bent_at(scale: &PlaceScale, shares: &[f64]) -> Vec<Shape> {
    let at = |share: &f64| Shape {
        scale: [LEAST_CHANGE, HARDEST],
        ..Shape::of_any_size(vec![mean_slope(scale), share * scale.force_n])
    };
    shares.iter().map(at).collect()
}

#[derive(Debug)]
pub(super) struct Stop {
    /// Along with what was set, or against it.
    pub(super) side: f64,
}

impl HistoryLaw for Stop {
    fn answers(&self, &[slope, stop, ..]: &Values, path: DrivenPath<'_>, out: &mut [f64]) {
        for (answer, driver) in out.iter_mut().zip(path.driver) {
            *answer = self.side * slope * (driver - driver.clamp(-stop, stop));
        }
    }
}
