//! Play whose middle does not lie at zero load: one-sided, or held off by a preload.

use super::joint_compliance::ACROSS_THE_JOINT;
use crate::physics::action::{DrivenPath, HistoryLaw, LawAction, Values};
use crate::physics::dimension::Dimension;
use crate::physics::law::{LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{OVER_RANGE, ParameterSpec, PlausibleRange, SignConstraint, Typical};
use crate::physics::part::{ANSWER, HARDEST, LEVEL, SEARCH, SLOPE, mean_slope};
use crate::physics::place::PlaceKind;
use crate::physics::search::{PlaceScale, SearchSpec, SearchedOn, Shape};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "preloaded-backlash",
    row: "preloaded-backlash",
    kind: LawKind::Physics,
    equation: "displacement += play ((force - preload)/width within -1/2 to 1/2)",
    place_kind: PlaceKind::Joint,
    parameters: &[
        ParameterSpec {
            name: "play",
            word: "play",
            ..ANSWER
        },
        MIDDLE,
        ParameterSpec {
            name: "width",
            word: "change of force over which the play is taken up",
            ..WIDTH
        },
    ],
    contains: &[],
    combination: None,
    action: LawAction::History(&Play::ByForce),
    search: SearchSpec {
        shapes: |scale| shapes(scale, scale.small_answer()),
        is_sharp: true,
        on: SearchedOn::FORCE_DRIVEN_PARTS,
        ..SEARCH
    },
    figure: LawFigure::OVER_FORCE,
    words: LawWording {
        phrase: |at, _| format!("play in {at} away from zero load"),
        heading: |place| format!("play of {place} away from zero load"),
        explanation: "At its preload the part passes through its play; before and after, it carries load.",
    },
    check: Some(ACROSS_THE_JOINT),
};

/// The same part with its displacement set.
pub(super) static DUAL: LawDefinition = LawDefinition {
    row: "preloaded-backlash (force read)",
    equation: "force -= k (displacement - middle within -play/2 to play/2)",
    parameters: &[
        ParameterSpec {
            name: "k",
            word: "stiffness outside the play",
            plausible: PlausibleRange {
                bounds: |scale, _| [0.0, HARDEST * mean_slope(scale)],
                reason: "up to a thousand times the mean slope of the part, as hard faces have it",
            },
            ..SLOPE
        },
        ParameterSpec {
            name: "middle",
            word: "middle of the play",
            ..MIDDLE
        },
        ParameterSpec {
            name: "play",
            word: "play",
            ..WIDTH
        },
    ],
    contains: &["joint-backlash (force read)"],
    combination: None,
    action: LawAction::History(&Play::ByDisplacement),
    search: SearchSpec {
        shapes: |scale| shapes(scale, 1e-3 * mean_slope(scale)),
        is_sharp: true,
        on: SearchedOn::DISPLACEMENT_DRIVEN_PARTS,
        ..SEARCH
    },
    ..LAW
};

/// How much of what was set the play takes up.
const WIDTH: ParameterSpec = ParameterSpec {
    plausible: PlausibleRange {
        bounds: |scale, _| [0.001 * scale.force_n, scale.force_range_n[1] - scale.force_range_n[0]],
        reason: "from a thousandth of the largest value that was set (less is a step) up to all of the range that was set",
    },
    ..LEVEL
};

/// Where the play lies.
const MIDDLE: ParameterSpec = ParameterSpec {
    name: "preload",
    word: "preload",
    dimension: Dimension::Driver,
    sign: SignConstraint::Either,
    plausible: PlausibleRange {
        bounds: |scale, _| [-scale.force_n, scale.force_n],
        reason: "within the range that was set: outside it the play is never passed",
    },
    typical: Typical {
        value: |scale| 0.3 * scale.force_n,
        spread: 2.0,
    },
    fit: OVER_RANGE,
};

/// Plays that are searched, as shares of the largest that was set: between two stops nearly all of the travel may lie.
const WIDTHS: [f64; 5] = [0.02, 0.1, 0.3, 0.6, 0.95];

fn shapes(scale: &PlaceScale, size: f64) -> Vec<Shape> {
    let middles = (-8..=8).map(|eighths| 0.1 * f64::from(eighths));
    let shape = |middle: f64, width: f64| Shape::of_any_size(vec![size, middle * scale.force_n, width * scale.force_n]);
    middles.flat_map(|middle| WIDTHS.map(|width| shape(middle, width))).collect()
}

#[derive(Debug)]
enum Play {
    ByForce,
    ByDisplacement,
}

impl HistoryLaw for Play {
    fn answers(&self, &[size, middle, width, _]: &Values, path: DrivenPath<'_>, out: &mut [f64]) {
        for (answer, driver) in out.iter_mut().zip(path.driver) {
            let within = (driver - middle).clamp(-0.5 * width, 0.5 * width);
            *answer = match self {
                Self::ByForce => size * within / width,
                Self::ByDisplacement => -size * within,
            };
        }
    }
}
