//! A part that is softer wherever it has been loaded before.
//!
//! The stress softening of rubber: Mullins, Rubber Chemistry and Technology 42, 1969, p. 339.

use crate::physics::action::{DrivenPath, HistoryLaw, LawAction, Values};
use crate::physics::law::{LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::ParameterSpec;
use crate::physics::part::{SEARCH, SLOPE, mean_slope};
use crate::physics::place::PlaceKind;
use crate::physics::search::{SearchSpec, SearchedOn, Shape};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "softening",
    row: "softening",
    kind: LawKind::Physics,
    equation: "displacement += c force (1 - |force|/m), m the largest |force| so far",
    place_kind: PlaceKind::Structure,
    parameters: &[ParameterSpec {
        name: "c",
        word: "compliance gained",
        ..SLOPE
    }],
    contains: &[],
    combination: None,
    action: LawAction::History(&Softer { side: 1.0 }),
    search: SearchSpec {
        shapes: |scale| vec![Shape::of_any_size(vec![1e-3 * mean_slope(scale)])],
        is_sharp: true,
        on: SearchedOn::FORCE_DRIVEN_PARTS,
        ..SEARCH
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |_, _| "a part softened by its first loading".to_owned(),
        heading: |_| "softening by the first loading".to_owned(),
        explanation: "Below the largest load so far the part is softer than at its first loading.",
    },
    check: None,
};

/// The same part with its displacement set.
pub(super) static DUAL: LawDefinition = LawDefinition {
    row: "softening (force read)",
    equation: "force -= k displacement (1 - |displacement|/m), m the largest |displacement| so far",
    parameters: &[ParameterSpec {
        name: "k",
        word: "stiffness lost",
        ..SLOPE
    }],
    action: LawAction::History(&Softer { side: -1.0 }),
    search: SearchSpec {
        is_sharp: true,
        on: SearchedOn::DISPLACEMENT_DRIVEN_PARTS,
        ..LAW.search
    },
    ..LAW
};

#[derive(Debug)]
struct Softer {
    side: f64,
}

impl HistoryLaw for Softer {
    fn answers(&self, &[slope, ..]: &Values, path: DrivenPath<'_>, out: &mut [f64]) {
        let mut most = f64::MIN_POSITIVE;
        for (answer, driver) in out.iter_mut().zip(path.driver) {
            most = most.max(driver.abs());
            *answer = self.side * slope * driver * (1.0 - driver.abs() / most);
        }
    }
}
