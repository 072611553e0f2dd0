//! Mistakes in the names and values of cells, and slips at the end of a run: named before everything else, on page, in JSON and in a figure.

use serde_json::json;
use stiffbench_test_files::desk::Desk;

use super::desk;
use crate::support::tables::Table;
use crate::support::{Contains, Json};

/// A session of four poses, `s`, and a copy `t` in which rows of its table are changed.
fn changed(change: &dyn Fn(&mut Table, usize)) -> Desk {
    let desk = desk();
    desk.run("simulate s --robot serial-arm --procedure load-unload --poses P1,P2,P3,P4 --seed 3")
        .succeeds();
    let mut table = Table::parse(&desk.read("s/readings.csv"));
    for row in 0..table.len() {
        change(&mut table, row);
    }
    desk.write("t/readings.csv", &table.text());
    desk.write("t/session.toml", &desk.read("s/session.toml"));
    desk
}

#[test]
fn exchanged_directions_are_named_with_the_cells_whose_readings_they_have() {
    let desk = changed(&|table, row| match ["pose", "direction"]
        .map(|column| table.word(row, column))
    {
        ["P2", "x"] => table.set(row, "direction", &"y"),
        ["P2", "y"] => table.set(row, "direction", &"x"),
        _ => {}
    });
    let robot = "--robot serial-arm --out out";
    let data = desk.data(&format!("diagnose t {robot}"));
    let found = data["data_findings"].list();
    assert_eq!(found.len(), 2, "{found:?}");
    for (one, [own, other]) in found.iter().zip([["x", "y"], ["y", "x"]]) {
        let cell = |direction| json!({"cell": {"pose": "P2", "direction": direction}});
        assert_eq!(one["kind"], "exchanged");
        assert_eq!(one["place"], cell(own));
        assert_eq!(one["exchanged_with"], cell(other));
        assert_eq!(
            (&one["unit"], &one["left_out"]),
            (&json!("um/N"), &json!(true))
        );
        assert!(one["p_family"].number() < 0.01);
    }
    // What one is expected to be is what the other was recorded as.
    let [value, expected] = ["value", "expected"].map(|key| {
        let of = |one: usize| found[one][key].number();
        [of(0), of(1)]
    });
    assert!(
        (value[0] / expected[1] - 1.0).abs() < 0.1,
        "{value:?} {expected:?}"
    );
    let page = desk.read("out/verdict.txt");
    page.must_contain(&["Data: P2 x and P2 y look exchanged; all left out."]);
    assert!(desk.path("out/load_displacement.svg").is_file());
    let before = desk.data("diagnose s --robot serial-arm --out before");
    assert_eq!(before["data_findings"], json!([]));
    assert_eq!(before["verdict"], data["verdict"]);
    assert!(!desk.path("before/load_displacement.svg").exists());
}

#[test]
fn a_cell_with_its_decimal_point_moved_is_named() {
    let desk = changed(&|table, row| {
        if ["pose", "direction"].map(|column| table.word(row, column)) == ["P3", "z"] {
            let moved = 10.0 * table.number(row, "displacement_um");
            table.set(row, "displacement_um", &format!("{moved:.2}"));
        }
    });
    let data = desk.data("diagnose t --robot serial-arm --out out");
    let [one] = data["data_findings"].list() else {
        panic!("{}", data["data_findings"]);
    };
    assert_eq!(one["kind"], "decimal-point");
    assert_eq!(
        one["place"],
        json!({"cell": {"pose": "P3", "direction": "z"}})
    );
    let [value, expected] = ["value", "expected"].map(|key| one[key].number());
    assert!(
        (value / expected / 10.0 - 1.0).abs() < 0.1,
        "{value} {expected}"
    );
    let page = desk.read("out/verdict.txt");
    let words: Vec<&str> = page.split_whitespace().collect();
    let page = words.join(" ");
    page.must_contain(&["with its decimal point moved (times 0.1000) it agrees"]);
}
