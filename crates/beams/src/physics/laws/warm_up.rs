//! A reading that moves while the machine warms up.

use crate::physics::action::{DrivenPath, HistoryLaw, LawAction, Values};
use crate::physics::law::{LawDefinition, LawKind, LawWording};
use crate::physics::parameter::{ParameterSpec, PlausibleRange, SignConstraint};
use crate::physics::part::{ANSWER, OVER_TIME, SEARCH, TIME_CONSTANT, at_times};
use crate::physics::place::PlaceKind;
use crate::physics::search::{Needs, SearchSpec, Shape};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "warm-up",
    row: "warm-up",
    kind: LawKind::Physics,
    equation: "answer += size (1 - exp(-(t - t at the beginning)/tau))",
    place_kind: PlaceKind::Clock,
    parameters: &[
        ParameterSpec {
            sign: SignConstraint::Either,
            plausible: PlausibleRange {
                bounds: |scale, _| [-scale.displacement_m, scale.displacement_m],
                reason: "up to the largest answer",
            },
            ..ANSWER
        },
        TIME_CONSTANT,
    ],
    contains: &[],
    combination: None,
    action: LawAction::History(&WarmingUp),
    search: SearchSpec {
        shapes: |scale| {
            let either = |shape: Shape| Shape {
                scale: [f64::NEG_INFINITY, f64::INFINITY],
                ..shape
            };
            // In one run a drift or a slow answer of the part does as much.
            let shapes = at_times(scale, 1e-6).into_iter().map(either);
            shapes.filter(|_| scale.has_repeats).collect()
        },
        needs: Needs::Clock,
        ..SEARCH
    },
    figure: OVER_TIME,
    words: LawWording {
        phrase: |_, _| "a machine that warms up".to_owned(),
        heading: |_| "a machine that warms up".to_owned(),
        explanation: "The reading drifts with a time constant from the beginning, with and without load.",
    },
    check: None,
};

#[derive(Debug)]
struct WarmingUp;

impl HistoryLaw for WarmingUp {
    fn answers(&self, &[size, tau, ..]: &Values, path: DrivenPath<'_>, out: &mut [f64]) {
        let first = path.time_s.first().copied().unwrap_or_default();
        for (answer, time_s) in out.iter_mut().zip(path.time_s) {
            *answer = size * -(-(time_s - first) / tau).exp_m1();
        }
    }
}
