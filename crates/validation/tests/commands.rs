//! Commands of the program that have no file of their own here.

use std::fmt::Write;

use stiffbench_test_files::desk::{Desk, assert_output_contains};

fn desk() -> Desk {
    Desk::new(env!("CARGO_BIN_EXE_stiffbench-validate"))
}

#[test]
fn recordings_are_read_from_the_folder_that_is_named() {
    let desk = desk();
    let error = desk.refusal("recordings --from .", 11, "stiffbench::input::recordings");
    assert_output_contains(&error, &["recordings.toml"]);
    // A parabola with the noise of the recording whose place it takes.
    let mut table = String::from("run,order,load,deflection\n");
    for order in 1..=40_i32 {
        let load = 150_000.0 * f64::from((order - 1) % 20 + 1);
        let noise = 2e-4 * f64::from((order * 37) % 11 - 5) / 3.0;
        let deflection = 6.7e-4 + 7.32e-7 * load - 3.2e-15 * load * load + noise;
        let run = (order - 1) / 20 + 1;
        writeln!(table, "{run},{order},{load},{deflection:.5}").unwrap();
    }
    desk.write("mine/nist-load-cell-pontius/pontius.csv", &table);
    let mut object = desk.run("recordings --from mine --json").succeeds().json();
    let data = object["data"].take();
    assert_eq!(data["recordings"][0]["is_right"], true, "{data}");
    assert_eq!(data["recordings"][0]["outcome"], "right", "{data}");
    assert_eq!(data["totals"]["headline_right"], 1, "{data}");
    assert_eq!(data["recordings"].as_array().unwrap().len(), 1);
    assert_eq!(data["absent"].as_array().unwrap().len(), 58);
    let warning = object["warnings"][0].as_str().unwrap();
    assert!(warning.contains("its SHA-256 differs"), "{warning}");
}

#[test]
fn a_fault_in_a_session_is_survived_or_said() {
    let data = desk().data("faults --fault garbage --phase settle");
    assert_eq!(data["sessions"], 1);
    assert_eq!(data["false_readings"], 0, "{data}");
    assert_eq!(data["stuck"], 0, "{data}");
}

#[test]
fn two_streams_are_held_without_a_loss() {
    let desk = desk();
    let data = desk.data("sustain --seconds 2");
    for (gauge, sent) in [("force", 500), ("displacement", 100)] {
        let tally = &data[gauge];
        assert_eq!(
            (tally["sent"].as_u64(), tally["received"].as_u64()),
            (Some(sent), Some(sent)),
            "{data}"
        );
        assert_eq!(
            (&tally["lost"], &tally["out_of_order"]),
            (&0.into(), &0.into())
        );
    }
    assert!(data["processor_percent"].is_number() || data["reason"].is_string());
}
