//! Cells under the names of others, or with another decimal point: named, and no others.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use serde_json::{Value, json};

use super::arm::{MODEL, called_wrong, data_findings, scaled, screened, session};
use crate::support::Json;
use crate::support::tables::Table;

const PROCEDURE: &str = "load-hold-unload";

/// A play of 15 standard errors.
const SLACK: &str = "joint-backlash@S2:play=3.872993urad,seat_moment=3N*m";

/// The place of a cell in the JSON.
fn cell(pose: &str, direction: &str) -> Value {
    json!({"cell": {"pose": pose, "direction": direction}})
}

/// Readings under other names in one column, where another has a certain one.
fn renamed(table: &Table, [column, one, other]: [&str; 3], within: Option<(&str, &str)>) -> Table {
    let mut out = table.clone();
    for row in 0..table.len() {
        if within.is_some_and(|(column, name)| table.word(row, column) != name) {
            continue;
        }
        let name = table.word(row, column);
        if name == one {
            out.set(row, column, &other);
        } else if name == other {
            out.set(row, column, &one);
        }
    }
    out
}

/// Places that are called wrong, sorted.
fn named(found: &Value) -> Vec<String> {
    let bad = data_findings(found).iter();
    let mut places: Vec<String> = bad.map(|bad| bad["place"].to_string()).collect();
    places.sort_unstable();
    places
}

fn sorted(places: impl IntoIterator<Item = Value>) -> Vec<String> {
    let mut places: Vec<String> = places.into_iter().map(|one| one.to_string()).collect();
    places.sort_unstable();
    places
}

#[test]
fn exchanged_cells_are_named_with_each_other_beside_true_effects() {
    for effects in [&[][..], &[SLACK]] {
        for seed in 0..4_u64 {
            let good = session(PROCEDURE, effects, 70 + seed);
            let pose = &format!("P{}", seed + 1)[..];
            let wrong = renamed(&good, ["direction", "x", "y"], Some(("pose", pose)));
            let found = screened(&wrong);
            let both = [cell(pose, "x"), cell(pose, "y")];
            assert_eq!(
                named(&found),
                sorted(both),
                "effects {effects:?}, pose {pose}"
            );
            let bad = data_findings(&found);
            for (one, other) in [(&bad[0], &bad[1]), (&bad[1], &bad[0])] {
                assert_eq!(one["kind"], "exchanged");
                assert_eq!(one["exchanged_with"], other["place"]);
                // What it was recorded beside is what it would have been, within what a play of 15 standard errors does to slopes.
                let ratio = one["expected"].number() / other["value"].number();
                assert!((0.9..1.1).contains(&ratio), "{ratio}");
            }
            let of_both = bad.iter().map(|one| one["lines"].list().len());
            let cell = good.cells()[0].len();
            assert_eq!(of_both.sum::<usize>(), 2 * cell);
            assert_eq!(found["readings"], good.len() - 2 * cell);
        }
    }
}

#[test]
fn exchanged_poses_are_named_in_every_direction_that_shows_it() {
    let good = session(PROCEDURE, &[], 5);
    let found = screened(&renamed(&good, ["pose", "P1", "P4"], None));
    let all = ["P1", "P4"]
        .into_iter()
        .flat_map(|pose| ["x", "y", "z"].map(|direction| cell(pose, direction)));
    assert_eq!(named(&found), sorted(all));
    let bad = data_findings(&found);
    assert!(bad.iter().all(|bad| bad["exchanged_with"].is_object()));
}

#[test]
fn a_cell_with_another_decimal_point_is_named_with_what_it_should_have_been() {
    for (seed, factor) in [0.1, 10.0, 100.0].into_iter().enumerate() {
        let good = session(PROCEDURE, &[], 20 + seed as u64);
        let rows = good.cells()[4 + seed].clone();
        let [pose, direction] = ["pose", "direction"].map(|name| good.word(rows.start, name));
        let found = screened(&scaled(&good, rows.clone(), factor));
        let [bad] = data_findings(&found) else {
            panic!("{factor}: {:?}", data_findings(&found));
        };
        assert_eq!(bad["kind"], "decimal-point");
        assert_eq!(bad["place"], cell(pose, direction));
        assert_eq!(bad["exchanged_with"], Value::Null);
        // Which way the point moved, and by how much, follows from the two values.
        let off = bad["value"].number() / factor / bad["expected"].number() - 1.0;
        assert!(off.abs() < 0.05, "{off}");
    }
}

/// A gauge that shows inches, forces in pounds. One cell would have to agree to a six-hundredth, and four times the compliance of a whole direction
/// other sections have too.
#[test]
fn cells_in_another_unit_are_named_with_its_factor() {
    let of_cells = |table: &Table, [pose, direction]: [Option<&str>; 2], factor: f64| {
        let mut out = table.clone();
        for row in 0..table.len() {
            let is = |column: &str, name: Option<&str>| {
                name.is_none_or(|name| table.word(row, column) == name)
            };
            if is("pose", pose) && is("direction", direction) {
                out.change(row, "displacement_um", |read| read / factor);
            }
        }
        out
    };
    let (pose, direction) = ([Some("P3"), None], [None, Some("z")]);
    let cases = [
        (pose, 25.4, 3),
        (pose, 1.0 / 4.448_221_6, 3),
        (direction, 25.4, 4),
    ];
    for (seed, (place, factor, count)) in cases.into_iter().enumerate() {
        let good = session(PROCEDURE, &[], 50 + seed as u64);
        let found = screened(&of_cells(&good, place, factor));
        let bad = data_findings(&found);
        assert_eq!(bad.len(), count, "{place:?}, {factor}: {bad:?}");
        for one in bad {
            assert_eq!(one["kind"], "unit", "{place:?}, {factor}");
            let said = one["factor"].number();
            assert!((said / factor - 1.0).abs() < 1e-9, "{place:?}: {said}");
        }
    }
}

/// One joint or all of them as soft as an industrial arm's, or far softer; loose play; nothing.
#[test]
fn good_cells_are_left_alone_however_soft_the_joints() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let joints = ["S1", "S2", "S3", "S4"];
    for seed in 0..60_u64 {
        let soft = if seed % 2 == 0 { 1 } else { joints.len() };
        let first = rng.random_range(0..joints.len());
        let effects = (0..soft).map(|one| {
            // From a tenth of what the links yield to some hundred times it.
            let c = 10_f64.powf(rng.random_range(-6.0..-3.0));
            let joint = joints[(first + one) % joints.len()];
            format!("joint-compliance@{joint}:c={c:e}rad/(N*m)")
        });
        let mut effects: Vec<String> = effects.collect();
        if seed % 3 == 0 {
            effects.push("joint-backlash@S2:play=10urad,seat_moment=3N*m".to_owned());
        }
        let factors = ["A", "Iy", "Iz", "J"].map(|name| {
            let factor = f64::exp(rng.random_range(-1.0..1.0));
            format!("beam.{name}={factor}")
        });
        let options = format!(
            "{MODEL} --poses P1,P2,P3,P4 --procedure load-unload --reading-sd-um 1.2 --zero-sd-um 2 --run-slope-sd 0.002 --true-factor {} --seed {}",
            factors.join(","),
            900 + seed
        );
        let effects: Vec<&str> = effects.iter().map(String::as_str).collect();
        let readings = Table::simulated(&options, &effects);
        let [cells, _] = called_wrong(&readings);
        assert_eq!(cells, 0, "seed {seed}: {effects:?}");
    }
}
