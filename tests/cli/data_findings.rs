//! Mistakes in the names and values of cells, and slips at the end of a run: named before everything else, on page, in JSON and in a figure.

use serde_json::json;
use stiffbench_test_files::desk::Desk;

use super::desk;

/// A session of four poses, `s`, and a copy `t` in which lines of its table are changed.
fn changed(change: &dyn Fn(&[&str], &mut Vec<String>)) -> Desk {
    let desk = desk();
    desk.run("simulate s --robot serial-arm --procedure load-unload --poses P1,P2,P3,P4 --seed 3")
        .succeeds();
    let table = desk.read("s/readings.csv");
    let mut lines = table.lines();
    let head = lines.next().unwrap();
    let names: Vec<&str> = head.split(',').collect();
    let rows = lines.map(|line| {
        let mut values: Vec<String> = line.split(',').map(str::to_owned).collect();
        change(&names, &mut values);
        values.join(",")
    });
    let rows: Vec<String> = rows.collect();
    desk.write("t/readings.csv", &format!("{head}\n{}\n", rows.join("\n")));
    desk.write("t/session.toml", &desk.read("s/session.toml"));
    desk
}

fn at(names: &[&str], column: &str) -> usize {
    names.iter().position(|name| *name == column).unwrap()
}

#[test]
fn exchanged_directions_are_named_with_the_cells_whose_readings_they_have() {
    let desk = changed(&|names, values| {
        let (pose, direction) = (at(names, "pose"), at(names, "direction"));
        if values[pose] == "P2" {
            let other = match &values[direction][..] {
                "x" => "y",
                "y" => "x",
                same => same,
            };
            values[direction] = other.to_owned();
        }
    });
    let robot = "--robot serial-arm --out out";
    let data = desk.data(&format!("diagnose t {robot}"));
    let found = data["data_findings"].as_array().unwrap();
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
        assert!(one["p_family"].as_f64().unwrap() < 0.01);
    }
    // What one is expected to be is what the other was recorded as.
    let [value, expected] = ["value", "expected"].map(|key| {
        let of = |one: usize| found[one][key].as_f64().unwrap();
        [of(0), of(1)]
    });
    assert!(
        (value[0] / expected[1] - 1.0).abs() < 0.1,
        "{value:?} {expected:?}"
    );
    let page = desk.read("out/verdict.txt");
    assert!(
        page.contains("Data: P2 x and P2 y look exchanged; all left out."),
        "{page}"
    );
    assert!(desk.path("out/load_displacement.svg").is_file());
    let before = desk.data("diagnose s --robot serial-arm --out before");
    assert_eq!(before["data_findings"], json!([]));
    assert_eq!(before["verdict"], data["verdict"]);
    assert!(!desk.path("before/load_displacement.svg").exists());
}

#[test]
fn a_cell_with_its_decimal_point_moved_is_named() {
    let desk = changed(&|names, values| {
        let cell = [at(names, "pose"), at(names, "direction")].map(|one| values[one].clone());
        if cell == ["P3", "z"] {
            let place = at(names, "displacement_um");
            let value: f64 = values[place].parse().unwrap();
            values[place] = format!("{:.2}", 10.0 * value);
        }
    });
    let data = desk.data("diagnose t --robot serial-arm --out out");
    let [one] = &data["data_findings"].as_array().unwrap()[..] else {
        panic!("{}", data["data_findings"]);
    };
    assert_eq!(one["kind"], "decimal-point");
    assert_eq!(
        one["place"],
        json!({"cell": {"pose": "P3", "direction": "z"}})
    );
    let [value, expected] = ["value", "expected"].map(|key| one[key].as_f64().unwrap());
    assert!(
        (value / expected / 10.0 - 1.0).abs() < 0.1,
        "{value} {expected}"
    );
    let page = desk.read("out/verdict.txt");
    let words: Vec<&str> = page.split_whitespace().collect();
    let page = words.join(" ");
    assert!(
        page.contains("with its decimal point moved (times 0.1000) it agrees"),
        "{page}"
    );
}
