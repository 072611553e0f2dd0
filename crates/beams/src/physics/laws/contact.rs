//! Free travel, then contact that stiffens.
//!
//! A sphere on a half-space carries by the power 3/2 of its approach: Johnson, Contact Mechanics, 1985, section 4.2, equation 4.23.

use crate::physics::action::{DrivenPath, HistoryLaw, LawAction, Values};
use crate::physics::dimension::Dimension;
use crate::physics::law::{LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{FitBy, OF_A_SIZE, OVER_RANGE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::part::{ANSWER, SEARCH};
use crate::physics::place::PlaceKind;
use crate::physics::search::{PlaceScale, SearchSpec, SearchedOn, Shape};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "contact",
    row: "contact",
    kind: LawKind::Physics,
    equation: "displacement += size (force/full)^(1/power) for force/full > 0",
    place_kind: PlaceKind::Structure,
    parameters: &[ANSWER, FULL, POWER],
    contains: &[],
    combination: None,
    action: LawAction::History(&ByForce),
    search: SearchSpec {
        shapes: |scale| {
            let shape = |power: f64, end: f64| Shape::of_any_size(vec![scale.small_answer(), end, power]);
            let powers = [1.5, 2.0].into_iter();
            powers.flat_map(|power| ends(scale).map(move |end| shape(power, end))).collect()
        },
        is_sharp: true,
        on: SearchedOn::FORCE_DRIVEN_PARTS,
        ..SEARCH
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |_, _| "contact after free travel".to_owned(),
        heading: |_| "contact after free travel".to_owned(),
        explanation: "Up to the onset the faces do not touch; beyond it the force grows with a power of the approach.",
    },
    check: None,
};

/// The end of what was set on the side on which the part touches: the size is that of the answer there.
const FULL: ParameterSpec = ParameterSpec {
    name: "full",
    word: "end of travel, where the size is reached",
    dimension: Dimension::Driver,
    sign: SignConstraint::Either,
    plausible: PlausibleRange {
        bounds: |scale, _| scale.force_range_n,
        reason: "an end of what was set, on the side on which the part touches; the size refers to it, and no fit moves it",
    },
    typical: Typical {
        value: |scale| scale.force_n,
        spread: 1.0,
    },
    fit: FitBy::Reference,
};

/// The ends of what was set that lie on a side.
fn ends(scale: &PlaceScale) -> impl Iterator<Item = f64> + Clone {
    let [least, most] = scale.force_range_n;
    [most.max(0.0), least.min(0.0)].into_iter().filter(|end| *end != 0.0)
}

const POWER: ParameterSpec = ParameterSpec {
    name: "power",
    word: "power",
    dimension: Dimension::Share,
    sign: SignConstraint::AboveZero,
    plausible: PlausibleRange {
        bounds: |_, _| [1.0, 2.5],
        reason: "from 1 (flat faces) over 3/2 (sphere) to slightly above 2 (cone or soft film)",
    },
    typical: Typical {
        value: |_| 1.5,
        spread: 1.3,
    },
    fit: OF_A_SIZE,
};

/// The same part with its displacement set.
pub(super) static DUAL: LawDefinition = LawDefinition {
    row: "contact (force read)",
    equation: "force += size ((displacement - onset)/(full - onset))^power sign(full) beyond the onset, toward full",
    parameters: &[
        ParameterSpec {
            word: "force at the end of travel",
            ..ANSWER
        },
        FULL,
        POWER,
        ParameterSpec {
            name: "onset",
            word: "onset",
            plausible: PlausibleRange {
                bounds: |scale, values| {
                    let [least, most] = scale.force_range_n;
                    if values[1] < 0.0 { [LAST_ONSET * least, most] } else { [least, LAST_ONSET * most] }
                },
                reason: "within the range that was set, up to the last hundredth before its end: outside it the faces never touch, or always do",
            },
            typical: Typical {
                value: |scale| 0.3 * scale.force_n,
                spread: 2.0,
            },
            fit: OVER_RANGE,
            ..FULL
        },
    ],
    action: LawAction::History(&ByDisplacement),
    search: SearchSpec {
        shapes,
        is_sharp: true,
        on: SearchedOn::DISPLACEMENT_DRIVEN_PARTS,
        ..SEARCH
    },
    ..LAW
};

/// Onset beyond which contact would begin with the last reading, as a share of the end of travel.
const LAST_ONSET: f64 = 0.99;

/// Onsets that are searched, as shares of the end of travel: a hard contact is met in the last percent of it.
const ONSETS: [f64; 21] = [
    -0.9, -0.8, -0.7, -0.6, -0.5, -0.4, -0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.98,
];

fn shapes(scale: &PlaceScale) -> Vec<Shape> {
    let [least, most] = scale.force_range_n;
    let shape = |end: f64, onset: f64, power: f64| Shape::of_any_size(vec![scale.small_answer(), end, power, onset]);
    let of_end = |end: f64| {
        let onsets = ONSETS.into_iter().map(move |share| share * end);
        let onsets = onsets.filter(move |onset| (least..=most).contains(onset));
        onsets.flat_map(move |onset| [1.0, 1.5, 2.0].map(|power| shape(end, onset, power)))
    };
    ends(scale).flat_map(of_end).collect()
}

#[derive(Debug)]
struct ByForce;

impl HistoryLaw for ByForce {
    fn answers(&self, &[size, full, power, _]: &Values, path: DrivenPath<'_>, out: &mut [f64]) {
        for (answer, force) in out.iter_mut().zip(path.driver) {
            *answer = size * full.signum() * (force / full).max(0.0).powf(power.recip());
        }
    }
}

#[derive(Debug)]
struct ByDisplacement;

impl HistoryLaw for ByDisplacement {
    fn answers(&self, &[size, full, power, onset]: &Values, path: DrivenPath<'_>, out: &mut [f64]) {
        for (answer, displacement) in out.iter_mut().zip(path.driver) {
            let approach = (displacement - onset) / (full - onset);
            *answer = size * full.signum() * approach.max(0.0).powf(power);
        }
    }
}
