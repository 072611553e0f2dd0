//! Load plans worth considering: the one at hand, and what can be changed in it.

use stiffbench_measurement::procedure::Procedure;
use stiffbench_measurement::readings::{LoadOrder, RepeatOrder, ZeroScope};

use crate::search::constants::CAN_TELL;

/// A plan, and what it tells apart.
#[derive(Debug, Clone, PartialEq)]
pub struct ProposedMeasurement {
    /// What to do, in words.
    pub plan: String,
    /// The two that it tells apart.
    pub separates: [String; 2],
    /// Expected log-likelihood ratio of all readings then, old and planned; `None` for a check without loads, which decides by itself,
    /// and where one of the two is no law.
    pub expected_log_lr: Option<f64>,
    /// The same of the readings already made.
    pub log_lr_now: f64,
    /// Minutes it takes, setting up included.
    pub minutes: f64,
    /// The plan as a procedure; `None` for a check without loads.
    pub procedure: Option<Procedure>,
    /// Posterior weight of the pair among those that are open.
    pub weight: f64,
}

impl ProposedMeasurement {
    /// Whether the pair will be distinguished.
    #[must_use]
    pub fn decides(&self) -> bool {
        self.expected_log_lr.is_none_or(|j| j >= CAN_TELL)
    }
}

/// A way of loading, in words.
pub(super) struct LoadingPlan {
    pub(super) words: String,
    pub(super) procedure: Procedure,
}

/// Ways of loading, derived from a procedure; each can be followed.
pub(super) fn loadings(base: &Procedure) -> Vec<LoadingPlan> {
    let sweeps = Procedure {
        unloading: false,
        repeat_order: RepeatOrder::Sweep,
        load_order: LoadOrder::Ascending,
        zero: ZeroScope::Run,
        holds_s: Vec::new(),
        repeats: base.repeats.max(3),
        ..base.clone()
    };
    let up_and_down = Procedure {
        unloading: true,
        ..sweeps.clone()
    };
    let mut out = vec![
        loading("the same plan again", "again", base.clone()),
        loading("loading in sweeps", "sweeps", sweeps.clone()),
        loading(
            "loads in shuffled order",
            "shuffled",
            Procedure {
                load_order: LoadOrder::Shuffled,
                seed: 1,
                ..sweeps
            },
        ),
        loading("loading and unloading", "load-unload", up_and_down.clone()),
        loading(
            "loading and unloading, held for two minutes at the largest load",
            "load-hold-unload",
            Procedure {
                holds_s: vec![60.0, 120.0],
                ..up_and_down.clone()
            },
        ),
        loading(
            "pushing and pulling, each with unloading",
            "both-signs",
            Procedure {
                loads_n: both_signs(&up_and_down.loads_n),
                ..up_and_down.clone()
            },
        ),
        loading(
            "loading and unloading in half steps",
            "half-steps",
            Procedure {
                loads_n: half_steps(&up_and_down.loads_n),
                ..up_and_down.clone()
            },
        ),
        loading(
            "loading and unloading, twice as many repeats",
            "more-repeats",
            Procedure {
                repeats: 2 * up_and_down.repeats,
                ..up_and_down
            },
        ),
    ];
    out.retain(|loading| loading.procedure.check().is_ok());
    out
}

fn loading(words: &str, name: &str, procedure: Procedure) -> LoadingPlan {
    LoadingPlan {
        words: words.to_owned(),
        procedure: Procedure {
            name: name.to_owned(),
            text: Some(words.to_owned()),
            ..procedure
        },
    }
}

/// The loads, and behind them the same in the other sense.
fn both_signs(loads_n: &[f64]) -> Vec<f64> {
    let mut out = loads_n.to_vec();
    out.extend(
        loads_n
            .iter()
            .filter(|load_n| **load_n != 0.0)
            .map(|load_n| -load_n),
    );
    out
}

/// The loads with one between each and the next.
fn half_steps(loads_n: &[f64]) -> Vec<f64> {
    let mut out: Vec<f64> = Vec::new();
    for &load_n in loads_n {
        if let Some(before_n) = out.last().copied() {
            out.push(0.5 * (before_n + load_n));
        }
        out.push(load_n);
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use stiffbench_test_files::shipped_procedure;

    #[test]
    fn every_loading_can_be_followed() {
        for name in stiffbench_test_files::shipped_procedures() {
            let procedure = Procedure::parse(&shipped_procedure(name).unwrap());
            let all = loadings(&procedure.unwrap().0);
            assert_eq!(all.len(), 8, "{name}");
            for loading in all {
                loading.procedure.check().unwrap();
                assert!(!loading.procedure.steps(0).is_empty());
            }
        }
    }

    #[test]
    fn loads_are_halved_and_mirrored() {
        assert_eq!(
            half_steps(&[0.0, -10.0, -30.0]),
            [0.0, -5.0, -10.0, -20.0, -30.0]
        );
        assert_eq!(both_signs(&[0.0, -10.0]), [0.0, -10.0, 10.0]);
        assert!(half_steps(&[]).is_empty());
    }
}
