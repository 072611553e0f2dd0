//! Free travel, then contact that stiffens.
//!
//! A sphere on a half-space carries by the power 3/2 of its approach: Johnson, Contact Mechanics, 1985, section 4.2, equation 4.23.

use crate::physics::action::{DrivenPath, HistoryLaw, LawAction, Values};
use crate::physics::dimension::Dimension;
use crate::physics::law::{Combination, LawDefinition, LawKind, LawWording};
use crate::physics::parameter::{FitBy, OF_A_SIZE, OVER_RANGE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::part::{ANSWER, FIGURE, SEARCH};
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
            let shape = |power: f64, side: f64| Shape {
                held: Some((1, 0.0)),
                ..Shape::of_any_size(vec![scale.small_answer(), side * scale.force_n, power])
            };
            let powers = [1.5, 2.0].into_iter();
            powers.flat_map(|power| [1.0, -1.0].map(|side| shape(power, side))).collect()
        },
        is_sharp: true,
        on: SearchedOn::FORCE_DRIVEN_PARTS,
        ..SEARCH
    },
    figure: FIGURE,
    words: LawWording {
        phrase: |_, _| "contact after free travel".to_owned(),
        heading: |_| "contact after free travel".to_owned(),
        explanation: "Up to the onset the faces do not touch; beyond it the force grows with a power of the approach.",
    },
    check: None,
};

/// Where the size is reached, on the side on which the part touches.
const FULL: ParameterSpec = ParameterSpec {
    name: "full",
    word: "where the size is reached",
    dimension: Dimension::Driver,
    sign: SignConstraint::Either,
    plausible: PlausibleRange {
        bounds: |scale, _| [-scale.force_n, scale.force_n],
        reason: "the largest value that was set, with the sign of the side on which the part touches; the size refers to it",
    },
    typical: Typical {
        value: |scale| scale.force_n,
        spread: 1.0,
    },
    fit: FitBy::Search,
};

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
    equation: "force += size ((displacement - onset)/full)^power beyond the onset, toward full",
    parameters: &[
        ParameterSpec {
            sign: SignConstraint::Either,
            plausible: PlausibleRange {
                bounds: |scale, _| [-200.0 * scale.displacement_m, 200.0 * scale.displacement_m],
                reason: "up to two hundred times the largest force: contact may cover only a small part of the travel",
            },
            ..ANSWER
        },
        FULL,
        POWER,
        ParameterSpec {
            name: "onset",
            word: "onset",
            plausible: PlausibleRange {
                bounds: |scale, _| [-scale.force_n, scale.force_n],
                reason: "within the range that was set: outside it the faces never touch, or always do",
            },
            typical: Typical {
                value: |scale| 0.3 * scale.force_n,
                spread: 2.0,
            },
            fit: OVER_RANGE,
            ..FULL
        },
    ],
    // Onset, power and size trade against each other where little was set beyond the onset.
    combination: Some(Combination {
        spec: ParameterSpec {
            name: "at_end_of_travel",
            word: "force at the end of travel",
            sign: SignConstraint::Either,
            ..ANSWER
        },
        of: |values, scale| force(values, values[1].signum() * scale.force_n),
    }),
    action: LawAction::History(&ByDisplacement),
    search: SearchSpec {
        shapes,
        is_sharp: true,
        on: SearchedOn::DISPLACEMENT_DRIVEN_PARTS,
        ..SEARCH
    },
    ..LAW
};

fn shapes(scale: &PlaceScale) -> Vec<Shape> {
    let onsets = (-9..=9).map(|tenths| 0.1 * f64::from(tenths));
    let shape = |onset: f64, power: f64, side: f64| Shape {
        held: Some((1, 0.0)),
        ..Shape::of_either_sign(vec![scale.small_answer(), side * scale.force_n, power, onset * scale.force_n])
    };
    let of_onset = |onset: f64| {
        let powers = [1.0, 1.5, 2.0].into_iter();
        powers.flat_map(move |power| [shape(onset, power, 1.0), shape(onset, power, -1.0)])
    };
    onsets.flat_map(of_onset).collect()
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

fn force(&[size, full, power, onset]: &Values, displacement: f64) -> f64 {
    size * ((displacement - onset) / full).max(0.0).powf(power)
}

#[derive(Debug)]
struct ByDisplacement;

impl HistoryLaw for ByDisplacement {
    fn answers(&self, values: &Values, path: DrivenPath<'_>, out: &mut [f64]) {
        for (answer, displacement) in out.iter_mut().zip(path.driver) {
            *answer = force(values, *displacement);
        }
    }
}
