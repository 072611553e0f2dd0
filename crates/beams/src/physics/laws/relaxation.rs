//! A standard linear solid: a part that yields to a load, or lets go of a displacement, with one time constant.
//!
//! Findley, Lai & Onaran, Creep and Relaxation of Nonlinear Viscoelastic Materials, 1976, section 5.6.

use crate::physics::action::{DrivenPath, HistoryLaw, LawAction, Values};
use crate::physics::law::{LawDefinition, LawKind, LawWording};
use crate::physics::parameter::ParameterSpec;
use crate::physics::part::{OVER_TIME, SEARCH, SLOPE, TIME_CONSTANT, at_times, mean_slope};
use crate::physics::place::PlaceKind;
use crate::physics::search::{Needs, SearchSpec, SearchedOn};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "relaxation",
    row: "relaxation",
    kind: LawKind::Physics,
    equation: "displacement += c z, dz/dt = (force - z)/tau",
    place_kind: PlaceKind::Structure,
    parameters: &[
        ParameterSpec {
            name: "c",
            word: "delayed compliance",
            ..SLOPE
        },
        TIME_CONSTANT,
    ],
    contains: &[],
    combination: None,
    action: LawAction::History(&LinearSolid::ByForce),
    search: SearchSpec {
        shapes: |scale| at_times(scale, 1e-3 * mean_slope(scale)),
        on: SearchedOn::FORCE_DRIVEN_PARTS,
        needs: Needs::Clock,
        ..SEARCH
    },
    figure: OVER_TIME,
    words: LawWording {
        phrase: |_, _| "a part that yields with time".to_owned(),
        heading: |_| "a part that yields with time".to_owned(),
        explanation: "A spring beside a damper: part of the answer comes with a time constant.",
    },
    check: None,
};

/// The same part with its displacement set.
pub(super) static DUAL: LawDefinition = LawDefinition {
    row: "relaxation (force read)",
    equation: "force += k (displacement - z), dz/dt = (displacement - z)/tau",
    parameters: &[
        ParameterSpec {
            name: "k",
            word: "stiffness that relaxes",
            ..SLOPE
        },
        TIME_CONSTANT,
    ],
    action: LawAction::History(&LinearSolid::ByDisplacement),
    search: SearchSpec {
        on: SearchedOn::DISPLACEMENT_DRIVEN_PARTS,
        ..LAW.search
    },
    words: LawWording {
        phrase: |_, _| "a force that relaxes".to_owned(),
        heading: |_| "a force that relaxes".to_owned(),
        explanation: "A spring in series with a damper, beside the line: part of the force dies away with a time constant.",
    },
    ..LAW
};

/// Moves a delayed quantity on: exact where the driver changes evenly between readings.
///
/// # Arguments
/// - `step`: time passed, in units of the delay.
/// - `decay`: exp(-step).
pub(super) fn delayed(before: f64, [from, to]: [f64; 2], step: f64, decay: f64) -> f64 {
    if step <= 0.0 {
        return before;
    }
    // z = x - rate + (z0 - x0 + rate) exp(-step), with time in units of tau.
    let rate = (to - from) / step;
    to - rate + (before - from + rate) * decay
}

#[derive(Debug)]
enum LinearSolid {
    ByForce,
    ByDisplacement,
}

impl HistoryLaw for LinearSolid {
    fn answers(&self, &[slope, tau, ..]: &Values, path: DrivenPath<'_>, out: &mut [f64]) {
        let first = path.driver.first().copied().unwrap_or_default();
        let mut at = (path.time_s.first().copied().unwrap_or_default(), first);
        let mut z = first;
        for (answer, (&time_s, &driver)) in out.iter_mut().zip(path.time_s.iter().zip(path.driver)) {
            let step = (time_s - at.0) / tau;
            z = delayed(z, [at.1, driver], step, (-step).exp());
            at = (time_s, driver);
            *answer = match self {
                Self::ByForce => slope * z,
                Self::ByDisplacement => slope * (driver - z),
            };
        }
    }
}
