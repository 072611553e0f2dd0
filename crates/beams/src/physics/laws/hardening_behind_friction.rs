//! A part whose slope changes with the load that friction leaves to it.
//!
//! The play operator (Visintin, Differential Models of Hysteresis, 1994, chapter III) before a spring with odd powers: friction beside a spring
//! that is no line.

use super::odd_polynomial::{self, CUBIC};
use crate::physics::action::{DrivenPath, HistoryLaw, LawAction, Values};
use crate::physics::law::{LawDefinition, LawWording};
use crate::physics::parameter::ParameterSpec;
use crate::physics::part::LEVEL;
use crate::physics::search::{PlaceScale, SearchSpec, SearchedOn, Shape};

use super::load_dependent_friction::{GROWTH, GrowingFriction};

pub(super) static LAW: LawDefinition = LawDefinition {
    row: "odd-polynomial (behind friction)",
    equation: "displacement += c3 p^3, p following force within friction + mu |force|",
    parameters: &[
        CUBIC,
        ParameterSpec {
            name: "friction",
            word: "friction without load",
            ..LEVEL
        },
        GROWTH,
    ],
    action: LawAction::History(&CubeBehindFriction),
    search: SearchSpec {
        shapes,
        on: SearchedOn::FORCE_DRIVEN_PARTS,
        ..odd_polynomial::LAW.search
    },
    words: LawWording {
        explanation: "Friction holds the part until it is overcome; the force beyond friction loads a spring whose slope changes with its load.",
        ..odd_polynomial::LAW.words
    },
    ..odd_polynomial::LAW
};

fn shapes(scale: &PlaceScale) -> Vec<Shape> {
    let size = 1e-3 * odd_polynomial::cubic(scale);
    let shape = |level: f64, growth: f64| Shape::of_either_sign(vec![size, level * scale.force_n, growth]);
    let levels = [0.02, 0.06, 0.15].into_iter();
    levels.flat_map(|level| [0.0, 0.1, 0.3].map(|growth| shape(level, growth))).collect()
}

#[derive(Debug)]
struct CubeBehindFriction;

impl HistoryLaw for CubeBehindFriction {
    fn answers(&self, &[cubic, level, growth, ..]: &Values, path: DrivenPath<'_>, out: &mut [f64]) {
        GrowingFriction::ByForce.answers(&[1.0, level, growth, 0.0], path, out);
        for answer in out {
            *answer = cubic * answer.powi(3);
        }
    }
}
