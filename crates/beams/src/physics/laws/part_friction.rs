//! Friction of a part without a robot file, with all that the part went through.
//!
//! Play operator and Jenkins element: Iwan, Journal of Applied Mechanics 33, 1966, p. 893; Visintin, Differential Models of Hysteresis, 1994,
//! chapter III.

use super::joint_friction::LAW as OF_A_JOINT;
use super::load_dependent_friction::GrowingFriction;
use crate::physics::action::{DrivenPath, HistoryLaw, LawAction, Values};
use crate::physics::dimension::Dimension;
use crate::physics::law::{LawDefinition, LawFigure, LawWording};
use crate::physics::parameter::{OF_A_SIZE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::part::{LEVEL, SEARCH, SLOPE, at_levels, mean_slope};
use crate::physics::search::{SHAPE_ROOM, SearchSpec, SearchedOn, Shape};

pub(super) static LAW: LawDefinition = LawDefinition {
    row: "joint-friction (of a part)",
    equation: "displacement += c p, p following force within friction",
    parameters: &[
        ParameterSpec {
            name: "c",
            word: "compliance",
            ..SLOPE
        },
        ParameterSpec {
            name: "friction",
            word: "friction",
            ..LEVEL
        },
    ],
    contains: &[],
    combination: None,
    // Friction that does not grow with the load.
    action: LawAction::History(&GrowingFriction::ByForce),
    search: SearchSpec {
        shapes: |scale| at_levels(scale, 1e-3 * mean_slope(scale)),
        on: SearchedOn::FORCE_DRIVEN_PARTS,
        ..SEARCH
    },
    figure: LawFigure::OVER_FORCE,
    ..OF_A_JOINT
};

/// The same part with its displacement set: the spring and the slider beside each other, in series with the line, are a line beside a spring
/// that a slider limits (Jenkins element: Iwan, Journal of Applied Mechanics 33, 1966, p. 893).
pub(super) static DUAL: LawDefinition = LawDefinition {
    row: "joint-friction (force read)",
    equation: "force += friction_force * s, s following displacement/lead within -1 to 1",
    parameters: &[
        ParameterSpec {
            name: "friction_force",
            word: "friction",
            dimension: Dimension::Answer,
            sign: SignConstraint::Positive,
            plausible: PlausibleRange {
                bounds: |scale, _| [0.0, scale.displacement_m],
                reason: "up to the largest force read",
            },
            typical: Typical {
                value: |scale| 1e-6 * scale.displacement_m,
                spread: 1.0,
            },
            fit: OF_A_SIZE,
        },
        LEAD,
    ],
    action: LawAction::History(&Slider),
    search: SearchSpec {
        shapes: |scale| {
            let of_lead = |lead: f64| Shape::of_any_size(vec![scale.small_answer(), lead * scale.force_n]);
            LEADS.into_iter().map(of_lead).collect()
        },
        on: SearchedOn::DISPLACEMENT_DRIVEN_PARTS,
        ..LAW.search
    },
    words: LawWording {
        explanation: "The force follows the displacement stiffly over a short lead, then friction holds its size; on reversal it comes back the \
                      same way, so that the two directions differ.",
        ..OF_A_JOINT.words
    },
    ..LAW
};

/// The displacement over which friction builds up.
pub(super) const LEAD: ParameterSpec = ParameterSpec {
    name: "lead",
    word: "lead",
    dimension: Dimension::Driver,
    sign: SignConstraint::AboveZero,
    plausible: PlausibleRange {
        bounds: |scale, _| [LEADS[0] / SHAPE_ROOM, LEADS[LEADS.len() - 1] * SHAPE_ROOM].map(|lead| lead * scale.force_n),
        reason: "from a thousandth of the travel, below which it is a step, to half of it, beyond which the slider never slides",
    },
    typical: Typical {
        value: |scale| 0.03 * scale.force_n,
        spread: 5.0,
    },
    fit: OF_A_SIZE,
};

/// Displacements over which friction builds up, as shares of the largest.
pub(super) const LEADS: [f64; 7] = [0.001, 0.01, 0.03, 0.08, 0.16, 0.3, 0.5];

#[derive(Debug)]
struct Slider;

impl HistoryLaw for Slider {
    fn answers(&self, &[friction, lead, ..]: &Values, path: DrivenPath<'_>, out: &mut [f64]) {
        let mut slider = path.driver.first().copied().unwrap_or_default();
        for (answer, &driver) in out.iter_mut().zip(path.driver) {
            slider = slider.clamp(driver - lead, driver + lead);
            *answer = friction * (driver - slider) / lead;
        }
    }
}

