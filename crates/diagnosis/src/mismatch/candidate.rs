//! Every law at every place it can have, with the shapes under which it is looked for.

use stiffbench_beams::physics::{Law, Place};
use stiffbench_units_and_text::test_point::Direction;

use super::changes::Frozen;
use super::joint_candidate::joint_candidates;
use super::observations::Observations;

/// A share of the compliance along a direction that makes an effect clearly visible and still small, 1.
pub(super) const REFERENCE_SHARE: f64 = 0.01;

/// Shortest period that is looked for: shorter ones cannot be told from reading errors, which move with the reading.
pub(super) const SHORTEST_PERIOD_M: f64 = 5e-5;

/// Periods of gauges with a wheel, a rack or a scale: preferred numbers, m.
#[rustfmt::skip]
pub(super) const NOMINAL_PERIODS_M: [f64; 15] = [
    5e-5, 6e-5, 8e-5, 1e-4, 1.25e-4, 1.5e-4, 2e-4, 2.5e-4, 3e-4, 4e-4, 5e-4, 6e-4, 8e-4, 1e-3, 2e-3,
];

/// How far a wheel, a rack or a scale is from its nominal period; one that is farther is found by the wide search, 1.
const NOMINAL_TOLERANCE: f64 = 0.01;

/// One shape of a law: values at which its effect is worked out, and how far its size may be scaled from there.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Shape {
    /// Values of the parameters.
    pub(super) values: Vec<f64>,
    /// Smallest and largest multiple of the size for which the shape holds.
    pub(super) scale: [f64; 2],
    /// Compliance times the stiffness of the loop it sits in: the effect grows as s/(1 + s), not as s.
    pub(super) saturation: f64,
}

impl Shape {
    /// Factor on the size that makes the effect `scale` times as large.
    pub(super) fn size_factor(&self, scale: f64) -> f64 {
        let s = self.saturation;
        // scale s/(1 + s) = s'/(1 + s'), solved for s'/s; an effect beyond a pin is cut to nearly a pin.
        scale / (1.0 + s - scale * s).max(0.05)
    }
}

/// A law at a place.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Candidate {
    pub(super) law: Law,
    pub(super) place: Place,
    pub(super) shapes: Vec<Shape>,
    /// Largest size that is plausible.
    pub(super) largest: f64,
    /// Whether it belongs to the wide search of a law that has a narrow one.
    pub(super) wide: bool,
    /// Smallest and largest value of each parameter that the fit may take; of a quadratic term over its linear one.
    pub(super) bounds: Vec<[f64; 2]>,
}

/// Bounds of the parameters: of the size from its shapes, of the others between their smallest and largest shape and a little more.
fn bounds(law: Law, shapes: &[Shape]) -> Vec<[f64; 2]> {
    let extreme = |index: usize, pick: fn(f64, f64) -> f64, start: f64| {
        shapes
            .iter()
            .map(|shape| shape.values[index])
            .fold(start, pick)
    };
    let count = shapes.first().map_or(0, |shape| shape.values.len());
    (0..count)
        .map(|index| match (law, index) {
            (_, 0) => {
                let largest = shapes
                    .iter()
                    .map(|shape| shape.values[0] * shape.scale[1] * (1.0 + shape.saturation))
                    .fold(0.0, f64::max);
                let either = any_scale(law)[0] < 0.0;
                [if either { f64::NEG_INFINITY } else { 0.0 }, largest]
            }
            (Law::GaugePeriodic, 2) => [f64::NEG_INFINITY, f64::INFINITY],
            // The quadratic term is bounded by the linear one.
            (Law::JointNonlinearity, _) => {
                let ratios = || shapes.iter().map(|shape| shape.values[1] / shape.values[0]);
                [
                    ratios().fold(0.0, f64::min) * SHAPE_ROOM,
                    ratios().fold(0.0, f64::max) * SHAPE_ROOM,
                ]
            }
            _ => [
                extreme(index, f64::min, f64::INFINITY) / SHAPE_ROOM,
                extreme(index, f64::max, 0.0) * SHAPE_ROOM,
            ],
        })
        .collect()
}

/// How far beyond its shapes a fit may go.
const SHAPE_ROOM: f64 = 1.12;

impl Candidate {
    fn one(law: Law, place: Place, size: f64, largest: f64) -> Self {
        let shapes = vec![Shape {
            values: vec![size],
            scale: any_scale(law),
            saturation: 0.0,
        }];
        Self::of_shapes(law, place, shapes, largest, false)
    }

    /// Bounds of the parameters for a fit that starts at a shape: a nominal period stays what it is.
    pub(super) fn bounds_near(&self, shape: &Shape) -> Vec<[f64; 2]> {
        let mut bounds = self.bounds.clone();
        if self.law == Law::GaugePeriodic && !self.wide {
            let period_m = shape.values[1];
            bounds[1] = [1.0 - NOMINAL_TOLERANCE, 1.0 + NOMINAL_TOLERANCE].map(|f| f * period_m);
        }
        bounds
    }

    pub(super) fn of_shapes(
        law: Law,
        place: Place,
        shapes: Vec<Shape>,
        largest: f64,
        wide: bool,
    ) -> Self {
        Self {
            bounds: bounds(law, &shapes),
            law,
            place,
            shapes,
            largest,
            wide,
        }
    }
}

/// Any size of the sign that physics allows for the first parameter of a law.
fn any_scale(law: Law) -> [f64; 2] {
    let either = law
        .parameters()
        .first()
        .is_some_and(|parameter| parameter.sign == stiffbench_beams::physics::Sign::Either);
    if either {
        [f64::NEG_INFINITY, f64::INFINITY]
    } else {
        [0.0, f64::INFINITY]
    }
}

/// What the candidates need to know of the observations: sizes of loads, displacements, times.
struct Scales {
    largest_force_n: f64,
    largest_displacement_m: f64,
}

/// All candidates but loose members, which are structures of their own.
///
/// # Arguments
/// - `poses`: the baseline, solved.
/// - `without`: laws that are left out.
pub(super) fn candidates(
    observations: &Observations,
    poses: &Frozen,
    without: &[Law],
) -> Vec<Candidate> {
    let scales = Scales {
        largest_force_n: observations
            .loads
            .iter()
            .map(|load| load.force_n.abs())
            .fold(0.0, f64::max),
        largest_displacement_m: observations
            .displacement_m
            .iter()
            .map(|displacement| displacement.abs())
            .fold(0.0, f64::max),
    };
    let mut out = Vec::new();
    if scales.largest_force_n > 0.0 {
        joint_candidates(observations, poses, scales.largest_force_n, &mut out);
        compliance_candidates(observations, poses, &scales, &mut out);
        growth_candidates(observations, &scales, &mut out);
    }
    clock_candidates(observations, &mut out);
    slip_candidates(observations, &mut out);
    period_candidates(&scales, &mut out);
    out.retain(|candidate| !without.contains(&candidate.law));
    out
}

fn compliance_candidates(
    observations: &Observations,
    poses: &Frozen,
    scales: &Scales,
    out: &mut Vec<Candidate>,
) {
    for axis in [Direction::X, Direction::Z] {
        let share = observations
            .cells
            .iter()
            .map(|cell| {
                let along = cell.direction.index();
                let pose = &poses.poses[cell.pose];
                let lever = pose.base_levers_m[axis.index()][along];
                lever * lever / pose.influence.compliance_m_per_n[along][along]
            })
            .fold(0.0, f64::max);
        if share > 0.0 {
            let place = Place::Axis(axis);
            let reference = REFERENCE_SHARE / share;
            out.push(Candidate::one(
                Law::BaseCompliance,
                place,
                reference,
                0.3 / share,
            ));
        }
    }
    for direction in Direction::ALL {
        let cells = || {
            observations
                .cells
                .iter()
                .filter(|cell| cell.direction == direction)
        };
        let axis = direction.index();
        let stiffest = cells()
            .map(|cell| poses.poses[cell.pose].influence.compliance_m_per_n[axis][axis])
            .fold(f64::INFINITY, f64::min);
        if !stiffest.is_finite() {
            continue;
        }
        let place = Place::Direction(direction);
        let reference = REFERENCE_SHARE * stiffest;
        out.push(Candidate::one(
            Law::GaugeStandCompliance,
            place,
            reference,
            0.3 * stiffest,
        ));
        for toward in Direction::ALL.into_iter().filter(|axis| *axis != direction) {
            let place = Place::Toward { direction, toward };
            // Three degrees are seen by eye.
            out.push(Candidate::one(Law::LoadMisalignment, place, 1e-3, 0.05));
        }
    }
    let place = Place::ForceGauge;
    let size = REFERENCE_SHARE / scales.largest_force_n;
    // A gauge that errs by a tenth of its reading is broken.
    out.push(Candidate::one(
        Law::ForceGaugeNonlinearity,
        place,
        size,
        10.0 * size,
    ));
}

fn growth_candidates(observations: &Observations, _scales: &Scales, out: &mut Vec<Candidate>) {
    let shaped = |law, size, largest, shapes: &[f64]| {
        let shapes = shapes
            .iter()
            .map(|&shape| Shape {
                values: vec![size, shape],
                scale: any_scale(law),
                saturation: 0.0,
            })
            .collect();
        Candidate::of_shapes(law, Place::Structure, shapes, largest, false)
    };
    if observations.recorded.hold {
        out.push(shaped(
            Law::Creep,
            1e-3,
            0.03,
            &[0.1, 0.3, 1.0, 3.0, 10.0, 30.0],
        ));
    }
    let repeats = observations.runs.iter().map(|run| run.repeat);
    if repeats.clone().max() != repeats.min() {
        out.push(shaped(
            Law::SettingIn,
            1e-3,
            0.05,
            &[0.4, 0.7, 1.2, 2.0, 3.5, 6.0],
        ));
    }
}

fn clock_candidates(observations: &Observations, out: &mut Vec<Candidate>) {
    let longest = |value: &dyn Fn(usize) -> f64| {
        (0..observations.len())
            .map(|reading| value(reading).abs())
            .fold(0.0, f64::max)
    };
    let seconds = longest(&|reading| observations.loads[reading].since_zero_s);
    let kelvins = longest(&|reading| observations.loads[reading].warming_k);
    // A drift of 30 um within one run spoils a session openly.
    if observations.recorded.time && seconds > 0.0 {
        out.push(Candidate::one(
            Law::DriftPerSecond,
            Place::Clock,
            1e-6 / seconds,
            3e-5 / seconds,
        ));
    }
    if observations.recorded.temperature && kelvins > 0.0 {
        out.push(Candidate::one(
            Law::DriftPerKelvin,
            Place::Clock,
            1e-6 / kelvins,
            3e-5 / kelvins,
        ));
    }
}

/// Readings that must follow a jump: with fewer it is an outlier.
const AFTER_A_SLIP: usize = 2;

fn slip_candidates(observations: &Observations, out: &mut Vec<Candidate>) {
    for run in &observations.runs {
        let cell = &observations.cells[run.cell];
        let loads = &observations.loads[run.readings.clone()];
        for place in 1..loads.len().saturating_sub(AFTER_A_SLIP) {
            if loads[place].step == loads[place - 1].step {
                continue;
            }
            let place = Place::Run {
                pose: observations.poses[cell.pose].clone(),
                direction: cell.direction,
                repeat: run.repeat,
                step: loads[place].step,
            };
            // As a drift of 30 um: a larger jump shows in the readings as they come.
            out.push(Candidate::one(Law::Slip, place, 1e-6, 3e-5));
        }
    }
}

fn period_candidates(scales: &Scales, out: &mut Vec<Candidate>) {
    let range_m = scales.largest_displacement_m;
    let shapes = |periods: &mut dyn Iterator<Item = f64>| -> Vec<Shape> {
        let shape = |period| Shape {
            values: vec![1e-6, period, 0.0],
            scale: [0.0, f64::INFINITY],
            saturation: 0.0,
        };
        periods.map(shape).collect()
    };
    let mut add = |shapes: Vec<Shape>, wide| {
        if !shapes.is_empty() {
            let place = Place::DisplacementGauge;
            out.push(Candidate::of_shapes(
                Law::GaugePeriodic,
                place,
                shapes,
                2e-5,
                wide,
            ));
        }
    };
    // A period that the readings do not span is a curve, not a period.
    let fits = |period: &f64| *period < 0.7 * range_m;
    add(
        shapes(&mut NOMINAL_PERIODS_M.into_iter().filter(fits)),
        false,
    );
    let (shortest, longest) = (SHORTEST_PERIOD_M, (0.7 * range_m).min(2e-3));
    if longest > shortest {
        // Half of the width of a line in the spectrum.
        let spacing = 0.5 / range_m;
        let count = (((shortest.recip() - longest.recip()) / spacing) as usize).min(1500);
        let frequency = |place: usize| longest.recip() + spacing * place as f64;
        add(
            shapes(&mut (0..count).map(|place| frequency(place).recip())),
            true,
        );
    }
}
