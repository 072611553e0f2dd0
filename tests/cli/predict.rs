//! What the model of a part predicts, and what is refused.

use std::fmt::Write;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde_json::Value;

use stiffbench::analysis::PartModelFile;
use stiffbench_test_files::desk::Desk;

use super::{desk, misuse};
use crate::support::{Contains, Json};

const COLUMNS: &str = "--specimen --response force --force-column force_N --displacement-column travel_mm --run-column run";

/// Cycles of a spring of 50 N/mm beside a slider of 12 N that slides after 0.3 mm, gauge noise 0.3 N.
///
/// # Arguments
/// - `amplitude_mm`: the travel of each run, up and down about zero.
fn slider(amplitude_mm: &[f64], seed: u64) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let mut text = "run,travel_mm,force_N\n".to_owned();
    let (mut slider, mut before) = (0.0_f64, 0.0);
    for (run, amplitude) in amplitude_mm.iter().enumerate() {
        for step in 0..=160_u16 {
            let phase = f64::from(step) / 40.0;
            let travel = amplitude
                * [phase, 2.0 - phase, 2.0 - phase, phase - 4.0][(step / 40).min(3) as usize];
            slider = (slider + 40.0 * (travel - before)).clamp(-12.0, 12.0);
            before = travel;
            let error: f64 = StandardNormal.sample(&mut rng);
            let force = 50.0 * travel + slider + 0.3 * error;
            let _ = writeln!(text, "{},{travel:.4},{force:.4}", run + 1);
        }
    }
    text
}

/// A desk with `part.csv`, and its diagnosis in `part`.
fn desk_with_model() -> Desk {
    let desk = desk();
    desk.write("part.csv", &slider(&[2.0, 2.0, 1.0], 1));
    desk.run(&format!("diagnose part.csv {COLUMNS} --out part"))
        .succeeds();
    desk
}

fn predict(desk: &Desk, table: &str) -> Value {
    desk.write("other.csv", table);
    let run = desk.run("part predict part/model.toml other.csv --out rows.csv --json");
    run.succeeds().json()["data"].clone()
}

#[test]
fn other_runs_and_amplitudes_lie_in_the_band() {
    let desk = desk_with_model();
    let data = predict(&desk, &slider(&[1.5, 0.7, 1.9], 2));
    // 1.96 of the noise, and a little for what the fit does not know.
    let band = data["band"].number();
    assert!((0.55..0.66).contains(&band), "{band}");
    assert_eq!(data["beyond_range"], 0);
    let runs = data["runs"].list();
    assert_eq!(runs.len(), 3);
    for run in runs {
        let (rms, within) = (run["rms"].number(), run["within_band"].number());
        assert!((rms / 0.3 - 1.0).abs() < 0.2, "{rms}");
        // 161 readings: a share of 95 % scatters by 1.7 %.
        assert!((0.90..=0.99).contains(&within), "{within}");
    }
    let rows = desk.read("rows.csv");
    assert_eq!(rows.lines().count(), 1 + 3 * 161);
}

#[test]
fn answers_need_not_be_there_and_are_predicted_alike() {
    let desk = desk_with_model();
    let table = slider(&[2.5], 3);
    let with = predict(&desk, &table);
    let without: Vec<&str> = table
        .lines()
        .map(|line| line.rsplit_once(',').unwrap().0)
        .collect();
    let without = without.join("\n");
    let alone = predict(&desk, &without);
    assert_eq!(alone["runs"].as_array().map(Vec::len), Some(0));
    let rows = |data: &Value| data["rows"].list().to_vec();
    for (one, other) in rows(&with).iter().zip(&rows(&alone)) {
        assert_eq!(one["predicted"], other["predicted"]);
        assert!(other.get("measured").is_none());
    }
    // Beyond 2 mm nothing was measured.
    let beyond = alone["beyond_range"].as_u64().unwrap();
    assert_eq!(
        beyond,
        rows(&alone)
            .iter()
            .filter(|row| row["driver"].number().abs() > 2.0)
            .count() as u64
    );
    assert!(beyond > 0);
}

#[test]
fn its_own_table_is_predicted_as_well_as_it_was_fitted() {
    let desk = desk_with_model();
    let data = predict(&desk, &slider(&[2.0, 2.0, 1.0], 1));
    let page = desk
        .run(&format!("diagnose part.csv {COLUMNS} --json"))
        .succeeds()
        .json();
    let fitted = page["data"]["after"]["rms"]["value"].number();
    let runs = data["runs"].list();
    let squares: f64 = runs.iter().map(|run| run["rms"].number().powi(2)).sum();
    let rms = (squares / 3.0).sqrt();
    assert!((rms / fitted - 1.0).abs() < 1e-6, "{rms} {fitted}");
}

#[test]
fn what_cannot_be_predicted_is_refused() {
    let desk = desk_with_model();
    let model = desk.read("part/model.toml");
    let table = slider(&[1.0], 4);
    let refused = |model: &str, table: &str, code: &str, words: &str| {
        desk.write("other.toml", model);
        desk.write("table.csv", table);
        let code = format!("stiffbench::part_model::{code}");
        let error = desk.refusal("part predict other.toml table.csv", 10, &code);
        error["message"].word().must_contain(&[words]);
    };
    #[rustfmt::skip]
    let changes = [
        ("joint-friction", "joint-fiction", "bad_value", "joint-fiction"),
        ("\nunit = \"mm\"", "\nunit = \"m\"", "bad_value", "the unit mm"),
        ("part-model/2", "part-model/9", "bad_value", "part-model/2"),
        ("[band]", "[bend]", "unreadable", "bend"),
        ("half_width = ", "half_width = -", "bad_value", "above zero"),
    ];
    for (old, new, code, words) in changes {
        refused(&model.replace(old, new), &table, code, words);
    }
    let of_robot = "schema = \"stiffbench/model/1\"\n";
    refused(of_robot, &table, "unreadable", "missing field");
    let in_degrees = model.replace("= \"travel_mm\"", "= \"travel_deg\"");
    let turned = table.replace("travel_mm", "travel_deg");
    let words = "in deg, and the model in mm";
    refused(&in_degrees, &turned, "other_unit", words);
    desk.write("table.csv", &table.replace("travel_mm", "way_mm"));
    let code = "stiffbench::table::unknown_column";
    desk.refusal("part predict part/model.toml table.csv", 11, code);
}

#[test]
fn a_configuration_that_was_not_fitted_is_refused() {
    let desk = desk();
    let named = |name: &str, seed| -> String {
        let table = slider(&[2.0], seed);
        let rows = table.lines().skip(1);
        let rows: Vec<String> = rows.map(|line| format!("{name},{line}")).collect();
        rows.join("\n") + "\n"
    };
    let table = |rows: String| format!("part,run,travel_mm,force_N\n{rows}");
    desk.write("part.csv", &table(named("A", 1) + &named("B", 2)));
    desk.run(&format!(
        "diagnose part.csv {COLUMNS} --configuration-column part --out part"
    ))
    .succeeds();
    desk.write("B.csv", &table(named("B", 3)));
    desk.run("part predict part/model.toml B.csv").succeeds();
    desk.write("C.csv", &table(named("C", 3)));
    let code = "stiffbench::part_model::unknown_configuration";
    let message =
        desk.refusal("part predict part/model.toml C.csv", 10, code)["message"].to_string();
    message.must_contain(&["`C`", "`A`, `B`"]);
}

#[test]
fn a_damaged_model_is_an_error_or_a_model() {
    let model = include_bytes!("../../fixtures/part-model.toml");
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut refused = 0;
    for _ in 0..2000 {
        let mut bytes = model.to_vec();
        let place = rng.random_range(0..bytes.len());
        bytes[place] = rng.random();
        let text = String::from_utf8_lossy(&bytes);
        let read = PartModelFile::parse("model.toml", &text);
        let read = read.and_then(|file| file.model("model.toml"));
        refused += u32::from(read.is_err());
    }
    assert!((200..1900).contains(&refused), "{refused}");
}

#[test]
fn options_of_a_robot_are_refused_with_a_part() {
    let desk = desk();
    desk.write("part.csv", &slider(&[2.0], 1));
    for option in [
        "--robot hp-robot",
        "--mechanism F",
        "--model m.toml",
        "--parameter joint.A3=free",
    ] {
        let arguments = format!("diagnose part.csv {COLUMNS} {option}");
        misuse(&desk, &arguments);
    }
}
