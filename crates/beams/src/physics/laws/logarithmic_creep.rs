//! A part that yields to a load, or lets go of a displacement, evenly over decades of time.
//!
//! Retardation times that lie evenly on a logarithmic scale: Findley, Lai & Onaran, Creep and Relaxation of Nonlinear Viscoelastic Materials,
//! 1976, sections 5.7 and 5.8.

use super::relaxation::{self, delayed};
use crate::physics::action::{DrivenPath, HistoryLaw, LawAction, Values};
use crate::physics::law::{Combination, LawDefinition, LawKind, LawWording};
use crate::physics::parameter::ParameterSpec;
use crate::physics::part::{OVER_TIME, SLOPE, TIME_CONSTANT};
use crate::physics::place::PlaceKind;
use crate::physics::search::{SearchSpec, SearchedOn};

pub(super) static LAW: LawDefinition = LawDefinition {
    name: "creep",
    row: "creep (part)",
    kind: LawKind::Physics,
    equation: "displacement += c sum(z_i)/2, dz_i/dt = (force - z_i)/(tau 10^(i/2)), i = 0 to 9",
    place_kind: PlaceKind::Structure,
    parameters: &[
        ParameterSpec {
            name: "c",
            word: "compliance per decade of time",
            ..SLOPE
        },
        TIME_CONSTANT,
    ],
    contains: &[],
    // Later times with more a decade make the same of a short record.
    combination: Some(Combination {
        spec: ParameterSpec {
            name: "growth_5_to_60_s",
            word: "growth from 5 to 60 s after a step, per unit of it",
            ..SLOPE
        },
        of: |values, _| growth(values),
    }),
    action: LawAction::History(&Decades { side: 1.0 }),
    search: relaxation::LAW.search,
    figure: OVER_TIME,
    words: LawWording {
        phrase: |_, _| "creep of the part".to_owned(),
        heading: |_| "creep".to_owned(),
        explanation: "The response to each change of the load grows with the logarithm of the time since that change.",
    },
    check: None,
};

/// The same part with its displacement set.
pub(super) static DUAL: LawDefinition = LawDefinition {
    row: "creep (force read)",
    equation: "force -= k sum(z_i)/2, dz_i/dt = (displacement - z_i)/(tau 10^(i/2)), i = 0 to 9",
    parameters: &[
        ParameterSpec {
            name: "k",
            word: "stiffness lost per decade of time",
            ..SLOPE
        },
        TIME_CONSTANT,
    ],
    action: LawAction::History(&Decades { side: -1.0 }),
    search: SearchSpec {
        on: SearchedOn::DISPLACEMENT_DRIVEN_PARTS,
        ..LAW.search
    },
    words: LawWording {
        explanation: "The force after each change of the displacement falls with the logarithm of the time since that change.",
        ..LAW.words
    },
    ..LAW
};

/// Retardation times: two a decade.
const TIMES: usize = 10;

/// What a unit step is answered with from 5 to 60 s after it.
fn growth(&[slope, tau, ..]: &Values) -> f64 {
    let after = |time_s: f64| -> f64 {
        let taus = (0..TIMES).map(|i| tau * 10_f64.powf(0.5 * i as f64));
        taus.map(|tau| -(-time_s / tau).exp_m1()).sum()
    };
    0.5 * slope * (after(60.0) - after(5.0))
}

/// What is left of each delay after a time. A decade faster is the tenth power: two exponentials serve for all.
fn decays_in(step_s: f64, taus: [f64; TIMES]) -> [f64; TIMES] {
    let mut decays: [f64; TIMES] = [1.0; TIMES];
    for i in (0..TIMES).rev() {
        decays[i] = if i + 2 < TIMES {
            decays[i + 2].powi(10)
        } else {
            (-step_s / taus[i]).exp()
        };
    }
    decays
}

#[derive(Debug)]
struct Decades {
    side: f64,
}

impl HistoryLaw for Decades {
    fn answers(&self, &[slope, tau, ..]: &Values, path: DrivenPath<'_>, out: &mut [f64]) {
        let first = path.driver.first().copied().unwrap_or_default();
        let mut at = (path.time_s.first().copied().unwrap_or_default(), first);
        let mut z = [first; TIMES];
        let taus: [f64; TIMES] = std::array::from_fn(|i| tau * 10_f64.powf(0.5 * i as f64));
        let (mut known_s, mut decays) = (f64::NAN, [1.0; TIMES]);
        for (answer, (&time_s, &driver)) in out.iter_mut().zip(path.time_s.iter().zip(path.driver)) {
            let step_s = time_s - at.0;
            if step_s != known_s {
                (known_s, decays) = (step_s, decays_in(step_s, taus));
            }
            for (z, (tau, decay)) in z.iter_mut().zip(taus.iter().zip(decays)) {
                *z = delayed(*z, [at.1, driver], step_s / tau, decay);
            }
            at = (time_s, driver);
            *answer = self.side * 0.5 * slope * z.iter().sum::<f64>();
        }
    }
}
