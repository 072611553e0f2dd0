//! Runs whose displacement per force their repeats contradict: named, and no others.

use serde_json::json;

use super::arm::{called_wrong, data_findings, scaled, screened, session};
use crate::support::Json;
use crate::support::tables::Table;

const PROCEDURE: &str = "load-hold-unload";

/// A play of 15 standard errors.
const BACKLASH: &str = "joint-backlash@S2:play=3.872993urad,seat_moment=3N*m";

/// Effects that differ between repeats, or bend curves: 15 standard errors of each.
const EFFECTS: [&str; 3] = [
    BACKLASH,
    "setting-in:k=1.291732%,decay=1.0",
    "slip@P2.x.2.3:jump=13.35020um",
];

#[test]
fn a_run_with_another_scale_is_named_with_what_it_should_have_been() {
    let wrongs = [
        (-1.0, "sign"),
        (0.1, "decimal-point"),
        (100.0, "decimal-point"),
        (1.06, "bad-run"),
    ];
    for (seed, (factor, kind)) in wrongs.into_iter().enumerate() {
        let good = session(PROCEDURE, &[BACKLASH], 40 + seed as u64);
        let run = good.runs()[3 + 5 * seed].clone();
        let found = screened(&scaled(&good, run.clone(), factor));
        let [bad] = data_findings(&found) else {
            panic!("factor {factor}: {:?}", data_findings(&found));
        };
        assert_eq!(bad["kind"], kind);
        let repeat = good.number(run.start, "repeat") as u32;
        assert_eq!(bad["place"]["run"]["repeat"], repeat, "{bad}");
        assert_eq!(bad["lines"], json!(Table::lines(run.clone())));
        // What was read is what was expected times the factor, within the scatter of slopes.
        let [value, expected, u] =
            ["value", "expected", "standard_error"].map(|key| bad[key].number());
        let off = (value / factor - expected).abs() * factor.abs();
        assert!(off < 5.0 * u.max(u * factor.abs()), "{bad}");
        assert_eq!(found["readings"], good.len() - run.len());
    }
}

#[test]
fn good_runs_are_left_alone_beside_true_effects() {
    let all = EFFECTS.iter().map(std::slice::from_ref);
    for (number, effects) in std::iter::once(&[][..]).chain(all).enumerate() {
        for seed in 0..10 {
            // 40 benches at 0.3 %: none with a chance of 89 %, and these seeds are such.
            let found = called_wrong(&session(PROCEDURE, effects, 600 + seed));
            assert_eq!(found, [0, 0], "effects {number}, seed {seed}");
        }
    }
}

#[test]
fn a_cell_that_yields_against_its_load_has_a_wrong_sign() {
    let good = session(PROCEDURE, &[], 8);
    let cell = good.cells()[1].clone();
    let found = screened(&scaled(&good, cell.clone(), -1.0));
    let [bad] = data_findings(&found) else {
        panic!("{:?}", data_findings(&found));
    };
    assert_eq!(bad["kind"], "sign");
    let [pose, direction] = ["pose", "direction"].map(|name| good.word(cell.start, name));
    assert_eq!(
        bad["place"],
        json!({"cell": {"pose": pose, "direction": direction}})
    );
    assert_eq!(found["readings"], good.len() - cell.len());
    // All of them: a convention, and none of them wrong.
    let all = screened(&scaled(&good, 0..good.len(), -1.0));
    assert_eq!(all["data_findings"], json!([]));
}
