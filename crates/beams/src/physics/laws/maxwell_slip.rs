//! Friction that gives way little by little: sliders beside springs, with memory.
//!
//! Iwan, Journal of Applied Mechanics 33, 1966, p. 893; as play and stop operators: Visintin, Differential Models of Hysteresis, 1994,
//! chapter III.

use super::joint_compliance::ACROSS_THE_JOINT;
use crate::physics::action::{DrivenPath, HistoryLaw, LawAction, Values};
use crate::physics::law::{LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::ParameterSpec;
use crate::physics::part::{ANSWER, LEVEL, SEARCH, SLOPE, at_levels, mean_slope};
use crate::physics::place::PlaceKind;
use crate::physics::search::{SearchSpec, SearchedOn};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "maxwell-slip",
    row: "maxwell-slip",
    kind: LawKind::Physics,
    equation: "displacement += c mean(p_i), p_i following force within friction (i - 1/2)/5, i = 1 to 5",
    place_kind: PlaceKind::Joint,
    parameters: &[
        ParameterSpec {
            name: "c",
            word: "compliance",
            ..SLOPE
        },
        ParameterSpec {
            name: "friction",
            word: "largest friction",
            ..LEVEL
        },
    ],
    contains: &["joint-friction (of a part)"],
    combination: None,
    action: LawAction::History(&Sliders::ByForce),
    search: SearchSpec {
        shapes: |scale| at_levels(scale, 1e-3 * mean_slope(scale)),
        on: SearchedOn::FORCE_DRIVEN_PARTS,
        ..SEARCH
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, _| format!("gradual friction in {at}"),
        heading: |place| format!("gradual friction in {place}"),
        explanation: "Parts of the contact slide one after the other; on reversal they stick and slide again in the same order, so that every \
                      loop has the shape of the first loading at twice the size.",
    },
    check: Some(ACROSS_THE_JOINT),
};

/// The same part with its displacement set.
pub(super) static DUAL: LawDefinition = LawDefinition {
    row: "maxwell-slip (force read)",
    equation: "force += friction sum(s_i) / sum(l_i), s_i following displacement within l_i = lead (i - 1/2)/5, i = 1 to 5",
    parameters: &[
        ParameterSpec {
            name: "friction",
            word: "largest friction",
            ..ANSWER
        },
        ParameterSpec {
            name: "lead",
            word: "lead",
            ..LEVEL
        },
    ],
    contains: &["joint-friction (force read)"],
    combination: None,
    action: LawAction::History(&Sliders::ByDisplacement),
    search: SearchSpec {
        shapes: |scale| at_levels(scale, scale.small_answer()),
        on: SearchedOn::DISPLACEMENT_DRIVEN_PARTS,
        ..SEARCH
    },
    ..LAW
};

/// Sliders of a part.
const SLIDERS: usize = 5;

#[derive(Debug)]
enum Sliders {
    ByForce,
    ByDisplacement,
}

impl HistoryLaw for Sliders {
    fn answers(&self, &[size, level, ..]: &Values, path: DrivenPath<'_>, out: &mut [f64]) {
        let limits: [f64; SLIDERS] = std::array::from_fn(|i| level * (i as f64 + 0.5) / SLIDERS as f64);
        let start = match self {
            Self::ByForce => 0.0,
            Self::ByDisplacement => path.driver.first().copied().unwrap_or_default(),
        };
        let mut at = [start; SLIDERS];
        for (answer, &driver) in out.iter_mut().zip(path.driver) {
            for (at, limit) in at.iter_mut().zip(limits) {
                *at = at.clamp(driver - limit, driver + limit);
            }
            let sum: f64 = at.iter().sum();
            *answer = match self {
                Self::ByForce => size * sum / SLIDERS as f64,
                Self::ByDisplacement => size * (SLIDERS as f64 * driver - sum) / limits.iter().sum::<f64>(),
            };
        }
    }
}
