//! Load plans worth considering: the one at hand, and what can be changed in it.

use stiffbench_measurement::procedure::Procedure;
use stiffbench_measurement::readings::{LoadOrder, RepeatOrder, ZeroScope};

use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::bench::DesignBench;
use super::next_measurement::NextMeasurement;

/// A way of loading in some poses and directions, as a measurement that separates two explanations.
///
/// # Arguments
/// - `words`: the whole plan.
pub(super) fn proposed(
    bench: &DesignBench<'_>,
    loading: &Procedure,
    words: String,
    (poses, directions): (Vec<PoseId>, &[Direction]),
    separates: [String; 2],
) -> NextMeasurement {
    let count = poses.len();
    let procedure = Procedure {
        name: format!("next-{}", loading.name),
        text: Some(words.clone()),
        poses: Some(poses),
        directions: directions.iter().map(|axis| (*axis).into()).collect(),
        ..loading.clone()
    };
    let minutes = procedure.minutes(&bench.pace, count);
    NextMeasurement {
        procedure: Some(procedure),
        ..NextMeasurement::check(words, minutes, separates)
    }
}

/// Ways of loading, derived from a procedure, by name and in words; each can be followed.
pub(super) fn loadings(base: &Procedure) -> Vec<Procedure> {
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
    let shuffled = Procedure {
        load_order: LoadOrder::Shuffled,
        seed: 1,
        ..sweeps.clone()
    };
    let held = Procedure {
        holds_s: vec![60.0, 120.0],
        ..up_and_down.clone()
    };
    let both_signs = Procedure {
        loads_n: both_signs(&up_and_down.loads_n),
        ..up_and_down.clone()
    };
    let half_steps = Procedure {
        loads_n: half_steps(&up_and_down.loads_n),
        ..up_and_down.clone()
    };
    let more_repeats = Procedure {
        repeats: 2 * up_and_down.repeats,
        ..up_and_down.clone()
    };
    let named = [
        ("again", "the same plan again", base.clone()),
        ("sweeps", "loading in sweeps", sweeps),
        ("shuffled", "loads in shuffled order", shuffled),
        ("load-unload", "loading and unloading", up_and_down),
        (
            "load-hold-unload",
            "loading and unloading, held for two minutes at the largest load",
            held,
        ),
        (
            "both-signs",
            "pushing and pulling, each with unloading",
            both_signs,
        ),
        (
            "half-steps",
            "loading and unloading in half steps",
            half_steps,
        ),
        (
            "more-repeats",
            "loading and unloading, twice as many repeats",
            more_repeats,
        ),
    ];
    let named = named.into_iter().map(|(name, words, procedure)| Procedure {
        name: name.to_owned(),
        text: Some(words.to_owned()),
        ..procedure
    });
    let has_both = |sign: f64| base.loads_n.iter().any(|load_n| sign * load_n > 0.0);
    let is_new =
        |loading: &Procedure| loading.name != "both-signs" || !(has_both(1.0) && has_both(-1.0));
    named
        .filter(|loading| is_new(loading) && loading.check().is_ok())
        .collect()
}

/// The loads, and behind them the same in the other sense.
fn both_signs(loads_n: &[f64]) -> Vec<f64> {
    let acting = loads_n.iter().filter(|load_n| **load_n != 0.0);
    let mirrored = acting.map(|load_n| -load_n);
    loads_n.iter().copied().chain(mirrored).collect()
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
                loading.check().unwrap();
                assert!(!loading.steps(0).is_empty());
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
