//! Hardening and softening alike both ways: odd powers.

use super::one_of;
use super::joint_compliance::ACROSS_THE_JOINT;
use crate::physics::action::{DrivenPath, HistoryLaw, LawAction, Values};
use crate::physics::dimension::Dimension;
use crate::physics::law::{LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{OF_A_SIZE, OVER_RANGE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::part::{SEARCH, mean_slope};
use crate::physics::place::PlaceKind;
use crate::physics::search::{PlaceScale, SearchSpec, Shape};

/// The cube of what is set.
pub(super) const CUBIC: ParameterSpec = ParameterSpec {
    name: "c3",
    word: "cubic part",
    dimension: Dimension::AnswerPerDriverCubed,
    sign: SignConstraint::Either,
    plausible: PlausibleRange {
        bounds: |scale, _| [-20.0, 20.0].map(|side| side * cubic(scale)),
        reason: "up to twenty times the largest answer at the largest load",
    },
    typical: Typical {
        value: |scale| 1e-6 * cubic(scale),
        spread: 1.0,
    },
    fit: OF_A_SIZE,
};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "odd-polynomial",
    row: "odd-polynomial",
    kind: LawKind::Physics,
    equation: "answer += c3 driver^3 (1 + r driver^2)",
    place_kind: PlaceKind::Joint,
    parameters: &[
        CUBIC,
        ParameterSpec {
            name: "r",
            word: "fifth power relative to the cube",
            dimension: Dimension::PerDriverSquared,
            sign: SignConstraint::Either,
            plausible: PlausibleRange {
                bounds: |scale, _| [RATIOS[0], RATIOS[RATIOS.len() - 1]].map(|ratio| 1.2 * ratio / (scale.force_n * scale.force_n)),
                reason: "between minus twice the cube, beyond which the part would yield backwards, and ten times the cube at the largest load",
            },
            typical: Typical {
                value: |scale| 0.3 / (scale.force_n * scale.force_n),
                spread: 3.0,
            },
            fit: OVER_RANGE,
        },
    ],
    contains: &[],
    combination: None,
    action: LawAction::History(&OddPowers),
    search: SearchSpec {
        shapes,
        ..SEARCH
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, values| match values.first() {
            Some(c3) if *c3 < 0.0 => format!("{} whose response grows more slowly than its load", one_of(at)),
            Some(_) => format!("{} whose response grows faster than its load", one_of(at)),
            None => format!("{} whose slope changes with the load", one_of(at)),
        },
        heading: |place| format!("odd powers of {place}"),
        explanation: "The response has odd powers of the load besides the straight line, alike in both directions.",
    },
    check: Some(ACROSS_THE_JOINT),
};

/// Fifth power relative to the cube at the largest load.
const RATIOS: [f64; 8] = [-2.0, -1.2, -0.8, -0.5, -0.2, 0.0, 1.5, 10.0];

/// Cubic part that alone gives the largest answer at the largest load.
pub(super) fn cubic(scale: &PlaceScale) -> f64 {
    mean_slope(scale) / (scale.force_n * scale.force_n)
}

fn shapes(scale: &PlaceScale) -> Vec<Shape> {
    let shape = |ratio: f64| Shape::of_either_sign(vec![1e-3 * cubic(scale), ratio / (scale.force_n * scale.force_n)]);
    RATIOS.into_iter().map(shape).collect()
}

#[derive(Debug)]
struct OddPowers;

impl HistoryLaw for OddPowers {
    fn answers(&self, &[c3, ratio, ..]: &Values, path: DrivenPath<'_>, out: &mut [f64]) {
        for (answer, driver) in out.iter_mut().zip(path.driver) {
            let square = driver * driver;
            *answer = c3 * driver * square * (1.0 + ratio * square);
        }
    }
}
