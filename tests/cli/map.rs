//! `stiffbench robot map`: its tables and files, shares and their union, and what it refuses.

use std::fs;
use std::process::Stdio;

use super::{Desk, assert_output_contains, desk, unwrapped};
use crate::support::{Contains, Json};

/// Every file of a folder with its bytes, by name.
fn files(desk: &Desk, folder: &str) -> Vec<(String, Vec<u8>)> {
    let entries = fs::read_dir(desk.path(folder)).unwrap();
    let mut files: Vec<(String, Vec<u8>)> = entries
        .map(|entry| entry.unwrap())
        .filter(|entry| entry.path().is_file())
        .map(|entry| {
            let name = entry.file_name().into_string().unwrap();
            (name, fs::read(entry.path()).unwrap())
        })
        .collect();
    files.sort();
    files
}

#[test]
fn all_mechanisms_beside_the_paper() {
    let desk = desk();
    let text = unwrapped(&desk.run("robot map --samples 400").succeeds().stdout);
    text.must_contain(&[
        "400 random poses (seed 0)",
        "varied: theta2, theta3; at nominal values: theta1, theta4",
        "mechanism F: supports to A2",
        "instruction set",
        "Table VII.",
        "Table X.",
        "mechanism F/A",
        "F x high",
        "held by",
    ]);
    let data = desk.data("robot map --samples 400");
    assert_eq!(data["mechanisms"].list().len(), 6);
    // Every printed cell of the four tables has one of ours.
    let cells = data["paper"].list();
    assert_eq!(cells.len(), 3 * (24 + 20) + 18 + 12);
    for cell in cells {
        assert!(
            cell["ours"].is_number() && cell["ratio"].is_number(),
            "{cell}"
        );
    }
    let x = &data["mechanisms"][0]["stiffness"][0];
    assert_eq!(x["along"], "x");
    assert_eq!(x["mean"]["unit"], "N/um");
    assert_eq!(x["mean"]["dof"], 399.0);
    let number = |value: &serde_json::Value| value["value"].number();
    let [low, high] = ["smallest", "largest"].map(|end| number(&x[end]["sampled"]["value"]));
    assert!((number(&x["difference"]) - (high - low)).abs() < 1e-15);
    assert!(number(&x["smallest"]["refined"]["value"]) <= low);
    let shares: f64 = (0..3)
        .map(|i| x["regions"][i]["share_of_area"].number())
        .sum();
    assert!((shares - 1.0).abs() < 1e-12);
}

#[test]
fn shares_joined_are_the_whole_byte_by_byte() {
    let desk = desk();
    let study = "--mechanisms A,F --samples 300 --seed 5 --directions x,z";
    for sampling in ["monte-carlo", "grid", "low-discrepancy"] {
        let study = format!("{study} --sampling {sampling}");
        desk.run(&format!("robot map {study} --out whole-{sampling}"))
            .succeeds();
        let whole = files(&desk, &format!("whole-{sampling}"));
        assert_eq!(whole.len(), 4);
        // Halves, one of which is made of quarters; and sevenths.
        for split in [
            vec!["2/2", "1/4", "3/4"],
            (1..=7)
                .map(|k| ["1/7", "2/7", "3/7", "4/7", "5/7", "6/7", "7/7"][k - 1])
                .collect(),
        ] {
            let (shards, joined) = (
                format!("shards-{sampling}-{}", split.len()),
                format!("joined-{sampling}-{}", split.len()),
            );
            let mut names = Vec::new();
            for share in &split {
                desk.run(&format!("robot map {study} --shard {share} --out {shards}"))
                    .succeeds();
                names.push(format!("{shards}/{}.map-shard", share.replace('/', "-of-")));
            }
            names.reverse();
            desk.run(&format!(
                "robot map merge {} --out {joined}",
                names.join(" ")
            ))
            .succeeds();
            assert!(files(&desk, &joined) == whole, "{sampling} {split:?}");
        }
    }
    // What is printed is the same, too.
    let whole = desk.run(&format!("robot map {study}")).succeeds().stdout;
    let names: Vec<String> = (1..=7)
        .map(|k| format!("shards-monte-carlo-7/{k}-of-7.map-shard"))
        .collect();
    for shards in [names.join(" "), "shards-monte-carlo-7".to_owned()] {
        assert_eq!(
            desk.run(&format!("robot map merge {shards}"))
                .succeeds()
                .stdout,
            whole
        );
    }
}

#[test]
fn another_plane_with_rotation_and_matrix() {
    let desk = desk();
    let study = "robot map serial-arm --samples 200 --plane x,z --directions z,rx --matrix";
    let data = desk.data(study);
    assert_eq!(data["plane"], serde_json::json!(["x", "z"]));
    assert_eq!(data["varied"].list().len(), 4);
    let columns = data["mechanisms"][0]["stiffness"].list();
    let names: Vec<&str> = columns.iter().map(|c| c["along"].word()).collect();
    assert_eq!(names[..2], ["z", "rx"]);
    assert_eq!(
        names[5..],
        ["weakest rotation", "middle rotation", "stiffest rotation"]
    );
    let rotation = &columns[1];
    assert_eq!(rotation["mean"]["unit"], "N*m/rad");
    let sampled = &rotation["smallest"]["sampled"];
    let values = sampled["matrix"]["values"].list();
    assert_eq!(
        (values.len(), &sampled["matrix"]["kind"]),
        (6, &"stiffness".into())
    );
    let region = &rotation["regions"][0];
    assert!(
        region["first_m"].is_array() && region.get("reach_m").is_none(),
        "{region}"
    );
    // Shares of it are the whole, matrices and figures included.
    let files_of = |folder: &str| {
        let mut all = files(&desk, folder);
        all.extend(files(&desk, &format!("{folder}/figures")));
        all
    };
    desk.run(&format!("{study} --out whole --figures whole/figures"))
        .succeeds();
    for share in ["1/3", "2/3", "3/3"] {
        desk.run(&format!("{study} --shard {share} --out s"))
            .succeeds();
    }
    desk.run("robot map merge s/1-of-3.map-shard s/2-of-3.map-shard s/3-of-3.map-shard --out joined --figures joined/figures")
        .succeeds();
    assert!(files_of("joined") == files_of("whole"));
    let table = desk.read("whole/points-A.csv");
    let heads: Vec<&str> = table.lines().next().unwrap().split(',').collect();
    assert_eq!(heads.len(), 1 + 4 + 3 + 8 + 3 + 3 + 36);
    for head in [
        "stiffness_rx_Nm_per_rad",
        "weakest_axis_z",
        "K_Mz_rz_Nm_per_rad",
    ] {
        assert!(heads.contains(&head), "{head}");
    }
    desk.run(&format!("{study} --shard 1/2 --out other").replace(" --matrix", ""))
        .succeeds();
    let error = desk.refusal(
        "robot map merge s/2-of-3.map-shard other/1-of-2.map-shard",
        11,
        "stiffbench::input::foreign_shard",
    );
    assert_output_contains(&error, &["the matrices differ"]);
    // A secant stiffness along an axis has no matrix.
    let effect = "--effect joint-backlash@A3:play=30urad,seat_moment=9N*m --at-load 50";
    desk.refusal(
        &format!("robot map --mechanisms A --samples 20 {effect} --matrix"),
        10,
        "stiffbench::distribution::linear_only",
    );
}

#[test]
fn shards_that_do_not_fit_are_refused() {
    let desk = desk();
    let study = "robot map --mechanisms A --samples 100 --directions x";
    for share in ["1/2", "2/2", "1/3"] {
        desk.run(&format!("{study} --shard {share} --out s"))
            .succeeds();
    }
    desk.run(
        "robot map --mechanisms A --samples 100 --directions x --seed 1 --shard 2/2 --out other",
    )
    .succeeds();
    let refusal = |arguments: &str, code: &str| {
        desk.refusal(arguments, 11, &format!("stiffbench::input::{code}"))
    };
    let error = refusal("robot map merge s/1-of-2.map-shard", "incomplete_shards");
    assert_output_contains(&error, &["50 of 100 poses", "all shards"]);
    let error = refusal(
        "robot map merge s/1-of-2.map-shard s/2-of-2.map-shard s/1-of-3.map-shard",
        "overlapping_shards",
    );
    assert_output_contains(&error, &["1-of-2", "1-of-3"]);
    let error = refusal(
        "robot map merge s/1-of-2.map-shard other/2-of-2.map-shard",
        "foreign_shard",
    );
    assert_output_contains(&error, &["the seeds differ"]);
    refusal(
        "robot map merge s/1-of-2.map-shard s/3-of-3.map-shard",
        "not_found",
    );
    // Cut anywhere, or one bit turned, it is no shard.
    let whole = fs::read(desk.path("s/2-of-2.map-shard")).unwrap();
    for end in [0, 3, 100, whole.len() / 2, whole.len() - 1] {
        fs::write(desk.path("s/cut.map-shard"), &whole[..end]).unwrap();
        refusal(
            "robot map merge s/1-of-2.map-shard s/cut.map-shard",
            "shard",
        );
    }
    let mut turned = whole.clone();
    turned[whole.len() / 2] ^= 4;
    fs::write(desk.path("s/cut.map-shard"), turned).unwrap();
    refusal(
        "robot map merge s/1-of-2.map-shard s/cut.map-shard",
        "shard",
    );
    desk.write("s/text.map-shard", "pose,stiffness\n");
    refusal(
        "robot map merge s/1-of-2.map-shard s/text.map-shard",
        "shard",
    );
}

#[test]
fn a_shard_killed_on_its_way_leaves_none_and_can_be_run_again() {
    let desk = desk();
    // A law that is not linear goes pose by pose: slow enough to be killed at work.
    let study = "robot map --mechanisms F --samples 30000 --directions x --no-principal --effect joint-backlash@A4B:play=0.12mrad,seat_moment=0.05N*m --at-load 50";
    let mut child = std::process::Command::new(env!("CARGO_BIN_EXE_stiffbench"))
        .args(format!("{study} --shard 1/2 --out s").split_whitespace())
        .current_dir(desk.path(""))
        .stdout(Stdio::null())
        .spawn()
        .unwrap();
    std::thread::sleep(std::time::Duration::from_millis(100));
    child.kill().unwrap();
    assert!(
        !child.wait().unwrap().success(),
        "it was done before it was killed"
    );
    assert!(!desk.path("s/1-of-2.map-shard").exists());
    let study = study.replace("30000", "300");
    for share in ["1/2", "2/2"] {
        desk.run(&format!("{study} --shard {share} --out s"))
            .succeeds();
    }
    desk.run(&format!("{study} --out whole")).succeeds();
    desk.run("robot map merge s/1-of-2.map-shard s/2-of-2.map-shard --out joined")
        .succeeds();
    assert!(files(&desk, "joined") == files(&desk, "whole"));
}

#[test]
fn the_points_are_a_table_of_the_poses() {
    let desk = desk();
    desk.run("robot map --mechanisms A --samples 40 --out out")
        .succeeds();
    let table = desk.read("out/points-A.csv");
    let mut reader = csv::Reader::from_reader(table.as_bytes());
    let heads: Vec<String> = reader
        .headers()
        .unwrap()
        .iter()
        .map(str::to_owned)
        .collect();
    assert_eq!(
        heads[..6],
        ["id", "theta2_deg", "theta3_deg", "x_m", "y_m", "z_m"]
    );
    assert_eq!(heads[6], "stiffness_x_N_per_um");
    let rows: Vec<Vec<f64>> = reader
        .records()
        .map(|row| {
            row.unwrap()
                .iter()
                .map(|cell| cell.parse().unwrap())
                .collect()
        })
        .collect();
    assert_eq!(rows.len(), 40);
    for row in &rows {
        let data = desk.data(&format!(
            "robot compliance --mechanism A --set theta2={} theta3={}",
            row[1], row[2]
        ));
        let c = data["compliance"][0][0].number();
        assert!((row[6] * 1e6 * c - 1.0).abs() < 1e-9);
    }
}
