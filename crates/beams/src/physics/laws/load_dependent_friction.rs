//! Friction that grows with the load.
//!
//! Coulomb's law with a normal force that the load itself brings: Armstrong-Hélouvry, Dupont & Canudas de Wit, Automatica 30, 1994, p. 1083,
//! section 2.

use super::joint_compliance::ACROSS_THE_JOINT;
use super::part_friction::LEAD;
use crate::physics::action::{DrivenPath, HistoryLaw, LawAction, Values};
use crate::physics::dimension::Dimension;
use crate::physics::law::{LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::part::{ANSWER, LEVEL, SEARCH, SLOPE, mean_slope};
use crate::physics::place::PlaceKind;
use crate::physics::search::{PlaceScale, SearchSpec, SearchedOn, Shape};

/// How friction grows with the load.
pub(super) const GROWTH: ParameterSpec = ParameterSpec {
    name: "mu",
    word: "growth with the load",
    dimension: Dimension::Share,
    sign: SignConstraint::Positive,
    plausible: PlausibleRange {
        bounds: |_, _| [0.0, 0.8],
        reason: "below one, at which nothing would ever slide",
    },
    typical: Typical {
        value: |_| 0.1,
        spread: 3.0,
    },
    fit: OF_A_SIZE,
};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "load-dependent-friction",
    row: "load-dependent-friction",
    kind: LawKind::Physics,
    equation: "displacement += c p, p following force within friction + mu |force|",
    place_kind: PlaceKind::Joint,
    parameters: &[
        ParameterSpec {
            name: "c",
            word: "compliance",
            ..SLOPE
        },
        ParameterSpec {
            name: "friction",
            word: "friction without load",
            ..LEVEL
        },
        GROWTH,
    ],
    contains: &["joint-friction (of a part)"],
    combination: None,
    action: LawAction::History(&GrowingFriction::ByForce),
    search: SearchSpec {
        shapes: |scale| {
            let shape = |level: f64, mu: f64| Shape::of_any_size(vec![1e-3 * mean_slope(scale), level * scale.force_n, mu]);
            FRICTIONS.into_iter().flat_map(|level| GROWTHS.map(|mu| shape(level, mu))).collect()
        },
        on: SearchedOn::FORCE_DRIVEN_PARTS,
        ..SEARCH
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, _| format!("friction in {at} that grows with the load"),
        heading: |place| format!("friction of {place} that grows with the load"),
        explanation: "Friction holds the part until it is overcome, and it grows with the load; the loop between loading and unloading widens with the load.",
    },
    check: Some(ACROSS_THE_JOINT),
};

/// The same part with its displacement set.
pub(super) static DUAL: LawDefinition = LawDefinition {
    row: "load-dependent-friction (force read)",
    equation: "force += s, s following displacement friction/lead within friction (1 + growth |displacement|)",
    parameters: &[
        ParameterSpec {
            name: "friction_force",
            word: "friction without load",
            ..ANSWER
        },
        LEAD,
        ParameterSpec {
            name: "growth",
            word: "growth with the displacement",
            dimension: Dimension::PerDriver,
            sign: SignConstraint::Positive,
            plausible: PlausibleRange {
                bounds: |scale, _| [0.0, 50.0 / scale.force_n],
                reason: "up to fifty times as large at the largest displacement",
            },
            typical: Typical {
                value: |scale| 1.0 / scale.force_n,
                spread: 5.0,
            },
            fit: OF_A_SIZE,
        },
    ],
    contains: &["joint-friction (force read)"],
    combination: None,
    action: LawAction::History(&GrowingFriction::ByDisplacement),
    search: SearchSpec {
        shapes: by_displacement,
        on: SearchedOn::DISPLACEMENT_DRIVEN_PARTS,
        ..SEARCH
    },
    ..LAW
};

/// Friction without load, as shares of the largest load.
const FRICTIONS: [f64; 4] = [0.01, 0.05, 0.15, 0.3];

/// Growth of friction with the load.
const GROWTHS: [f64; 4] = [0.04, 0.1, 0.2, 0.4];

fn by_displacement(scale: &PlaceScale) -> Vec<Shape> {
    let shape = |lead: f64, growth: f64| Shape::of_any_size(vec![scale.small_answer(), lead * scale.force_n, growth / scale.force_n]);
    let leads = [0.01, 0.05, 0.15];
    leads.into_iter().flat_map(|lead| [0.5, 2.0, 8.0].map(|growth| shape(lead, growth))).collect()
}

#[derive(Debug)]
pub(super) enum GrowingFriction {
    ByForce,
    ByDisplacement,
}

impl HistoryLaw for GrowingFriction {
    fn answers(&self, &[size, level, growth, _]: &Values, path: DrivenPath<'_>, out: &mut [f64]) {
        match self {
            Self::ByForce => {
                let mut at = 0.0_f64;
                for (answer, &force) in out.iter_mut().zip(path.driver) {
                    let limit = level + growth * force.abs();
                    at = at.clamp(force - limit, force + limit);
                    *answer = size * at;
                }
            }
            Self::ByDisplacement => {
                let mut before = path.driver.first().copied().unwrap_or_default();
                let mut carried = 0.0_f64;
                for (answer, &displacement) in out.iter_mut().zip(path.driver) {
                    let limit = 1.0 + growth * displacement.abs();
                    carried = (carried + (displacement - before) / level).clamp(-limit, limit);
                    before = displacement;
                    *answer = size * carried;
                }
            }
        }
    }
}
