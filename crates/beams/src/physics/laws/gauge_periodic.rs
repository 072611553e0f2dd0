//! A displacement gauge with a periodic error.

use std::f64::consts::TAU;

use stiffbench_numeric::simd::waves;

use crate::physics::action::{LawAction, GaugeError, Values};
use crate::physics::dimension::Dimension;
use crate::physics::law::{Check, Curve, Driving, LawDefinition, LawFigure, LawKind, LawWording};
use crate::physics::parameter::{
    OF_A_SIZE, FitBy, ParameterSpec, PlausibleRange, SignConstraint, Typical,
};
use crate::physics::place::PlaceKind;
use crate::physics::search::{PlaceScale, SearchSpec, SearchedOn, Shape};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "gauge-periodic",
    row: "gauge-periodic",
    kind: LawKind::Physics,
    equation: "displacement += amplitude sin(2 pi displacement/period + phase)",
    place_kind: PlaceKind::DisplacementGauge,
    parameters: &[
        ParameterSpec {
            name: "amplitude",
            word: "amplitude",
            dimension: Dimension::Length,
            sign: SignConstraint::Positive,
            plausible: PlausibleRange {
                bounds: |_, values| [0.0, values.get(1).map_or(LONGEST_M, |period_m| *period_m) / TAU],
                reason: "up to the period over 2 pi: with a larger one the gauge would run backwards",
            },
            typical: Typical {
                value: |_| 1e-9,
                spread: 1.0,
            },
            fit: OF_A_SIZE,
        },
        ParameterSpec {
            name: "period",
            word: "period",
            dimension: Dimension::Length,
            sign: SignConstraint::AboveZero,
            plausible: PlausibleRange {
                bounds: |scale, _| {
                    // Both ends by the width of a wheel, a rack or a scale as it is made.
                    let [low, high] = [1.0 - NOMINAL_TOLERANCE, 1.0 + NOMINAL_TOLERANCE];
                    [SHORTEST_PERIOD_M * low, (longest_m(scale) * high).max(SHORTEST_PERIOD_M)]
                },
                reason: "from 50 µm, below which it cannot be distinguished from reading errors, to most of the travel: a fraction of a period is only a curve",
            },
            typical: Typical {
                value: |_| 2.5e-4,
                // A wheel or a rack is as wide as it is made.
                spread: 1.005,
            },
            // A period is known to a share of itself; the sine turns with the displacement over it.
            fit: FitBy::Derivative { relative_step: 1e-6 },
        },
        ParameterSpec {
            name: "phase",
            word: "phase",
            dimension: Dimension::Angle,
            sign: SignConstraint::Either,
            plausible: PlausibleRange {
                bounds: |_, _| [f64::NEG_INFINITY, f64::INFINITY],
                reason: "any angle: the position of a wheel at the zero is random",
            },
            typical: Typical {
                value: |_| 0.5,
                spread: f64::NAN,
            },
            fit: FitBy::FixedStep { step: 1e-4 },
        },
    ],
    contains: &[],
    combination: None,
    action: LawAction::Gauge(&Periodic),
    search: SearchSpec {
        shapes: nominal,
        wide_shapes: Some(any_period),
        phase: Some(2),
        is_sharp: true,
        on: SearchedOn::FORCE_DRIVEN,
        unseen: (
            "the displacements do not span a period of any gauge",
            Some("shift the zero of the gauge by a few tenths of a millimetre between repeats"),
        ),
        ..SearchSpec::OF_ROBOTS
    },
    figure: LawFigure {
        driving: Driving::Displacement,
        pooled: Some("all cells, folded to one period"),
        large_loads_only: false,
        curve: Curve::Period {
            parameter: 1,
            value_m: |values, turn| match values {
                &[amplitude_m, _, phase] => amplitude_m * (TAU * turn + phase).sin(),
                _ => 0.0,
            },
        },
    },
    words: LawWording {
        phrase: |_, _| "a periodic error of the displacement gauge".to_owned(),
        heading: |_| "the period of the gauge".to_owned(),
        explanation: "The error of the gauge is periodic over its travel.",
    },
    check: Some(Check {
        rank: 0,
        text: |_| {
            "run the dial gauge over gauge blocks in steps of a tenth of a millimetre, or move its zero by 0.3 mm and repeat one cell"
                .to_owned()
        },
        minutes: 25.0,
    }),
};

/// Shortest period that is searched for: shorter ones cannot be distinguished from reading errors, which move with the reading.
pub const SHORTEST_PERIOD_M: f64 = 5e-5;

/// Longest period of a wheel, a rack or a scale.
const LONGEST_M: f64 = 2e-3;

/// Periods of gauges with a wheel, a rack or a scale: preferred numbers, m.
#[rustfmt::skip]
pub const NOMINAL_PERIODS_M: [f64; 15] = [
    5e-5, 6e-5, 8e-5, 1e-4, 1.25e-4, 1.5e-4, 2e-4, 2.5e-4, 3e-4, 4e-4, 5e-4, 6e-4, 8e-4, 1e-3, LONGEST_M,
];

/// How far a wheel, a rack or a scale is from its nominal period; one that is farther is found by the wide search, 1.
const NOMINAL_TOLERANCE: f64 = 0.01;

/// Share of the travel from which a period is one: what the readings do not span is a curve.
const SPANNED: f64 = 0.7;

fn longest_m(scale: &PlaceScale) -> f64 {
    (SPANNED * scale.displacement_m).min(LONGEST_M)
}

fn shape(period_m: f64) -> Shape {
    Shape::of_any_size(vec![1e-6, period_m, 0.0])
}

fn nominal(scale: &PlaceScale) -> Vec<Shape> {
    let fits = |period: &f64| *period < SPANNED * scale.displacement_m;
    let held = |period| Shape {
        held: Some((1, NOMINAL_TOLERANCE)),
        ..shape(period)
    };
    NOMINAL_PERIODS_M.into_iter().filter(fits).map(held).collect()
}

fn any_period(scale: &PlaceScale) -> Vec<Shape> {
    let longest_m = longest_m(scale);
    if longest_m <= SHORTEST_PERIOD_M {
        return Vec::new();
    }
    // Half of the width of a line in the spectrum.
    let spacing = 0.5 / scale.displacement_m;
    let lines = (SHORTEST_PERIOD_M.recip() - longest_m.recip()) / spacing;
    let count = (lines as usize).min(1500);
    let frequency = |place: usize| longest_m.recip() + spacing * place as f64;
    (0..count).map(|place| shape(frequency(place).recip())).collect()
}

#[derive(Debug)]
struct Periodic;

impl GaugeError for Periodic {
    fn error_m(&self, &[amplitude, period, phase, ..]: &Values, at_m: f64) -> f64 {
        amplitude * (TAU * at_m / period + phase).sin()
    }

    fn both_phases_m(
        &self,
        &[amplitude, period, phase, ..]: &Values,
        at_m: &[f64],
        out: [&mut [f64]; 2],
    ) {
        waves([amplitude, 360.0 / period, phase.to_degrees()], at_m, out);
    }
}
