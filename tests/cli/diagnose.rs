//! What the model leaves out: verdicts on sessions with known answers, the contract of the JSON, files, and what is refused.

use std::path::Path;

use serde_json::Value;

use stiffbench::physics::{Law, TestObject};
use stiffbench_test_files::desk::assert_follows_schema;

use super::{desk, five_columns};
use crate::support::tables::Table;
use crate::support::{Contains, Json};

/// Benches in which a joint of a serial arm rubs, nothing is missing, a joint has play while the robot sets in, one of two members that
/// vanish together is loose, and the gauge has a period; their answers are open (`data/concealed/development-answers.json`).
const FRICTION: &str = "a06d3026";
const NOTHING: &str = "3f551cfa";
const PLAY_AND_SETTING_IN: &str = "862ab930";
const LOOSE_MEMBER: &str = "831a7500";
const PERIOD: &str = "094df8da";

fn session(id: &str) -> String {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/data/concealed/sessions");
    format!("{folder}/{id}")
}

/// The open answer of a session.
fn answer(id: &str) -> Value {
    let text = include_str!("../../data/concealed/development-answers.json");
    let mut all: Value = serde_json::from_str(text).unwrap();
    all["benches"][id].take()
}

/// Physics and places of all findings.
fn found(data: &Value) -> Vec<(&str, &Value)> {
    let findings = data["findings"].list();
    findings
        .iter()
        .map(|finding| (finding["physics"].word(), &finding["place"]))
        .collect()
}

#[test]
fn friction_in_a_joint_is_named_with_its_size() {
    let desk = desk();
    let object = desk
        .run(&format!("diagnose {} --out out --json", session(FRICTION)))
        .succeeds()
        .json();
    let data = &object["data"];
    let truth = &answer(FRICTION)["truth"][0];
    assert_eq!(found(data), [(truth["physics"].word(), &truth["place"])]);
    assert_eq!(data["verdict"], "explained");
    let finding = &data["findings"][0];
    for (name, parameter) in truth["parameters"].as_object().unwrap() {
        let told = &finding["parameters"][name];
        assert_eq!(told["unit"], parameter["unit"]);
        let [low, high] = [0, 1].map(|end| told["ci95"][end].number());
        let (value, width) = (parameter["value"].number(), high - low);
        // Twice the width of a 95 % interval is beyond any chance.
        assert!(
            value > low - width && value < high + width,
            "{name}: {value} is far from {low} to {high}"
        );
    }
    let absorbed = finding["absorbed_share"].number();
    assert!((absorbed - truth["absorbed_share"].number()).abs() < 0.1);
    let [before, after] = ["before", "after"].map(|state| data[state]["noise_units"].number());
    assert!(after < before && after < 1.05, "{before} to {after}");
    // The page says it in words; the files are what was printed.
    let page = desk.read("out/verdict.txt");
    page.must_contain(&[
        "\n\nThe model leaves out friction in joint S1 (",
        "WHAT IS MISSING",
        "HOW SURE",
        "WHAT ELSE IT COULD BE",
        "HOW THE FITTED FACTORS CHANGE",
        "HOW FAR THE MODEL MISSES THE READINGS",
        "APPENDIX",
    ]);
    let written: Value = serde_json::from_str(&desk.read("out/diagnosis.json")).unwrap();
    assert_follows_schema(&written);
    assert_eq!(written["data"]["findings"], data["findings"]);
    // The model with the friction in it is one that the other subcommands take.
    desk.read("out/model.toml")
        .must_contain(&["joint-friction"]);
    desk.run("simulate again --model out/model.toml --poses P1 --seed 2")
        .succeeds();
    let files = data["files"].list();
    for figure in [
        "mismatch_map",
        "mismatch_map_after",
        "residuals_before_after",
        "found_law",
        "evidence_bars",
        "misfit_shares",
        "factor_shift",
        "held_out_error",
        "detection_limits",
    ] {
        for end in ["svg", "png"] {
            let name = format!("out/{figure}.{end}");
            assert!(files.contains(&Value::from(name.clone())), "{name}");
            assert!(desk.path(&name).is_file(), "{name}");
        }
    }
}

/// A bad reading is named first and left out, so that the answer is what it was without it.
#[test]
fn a_bad_reading_is_named_and_left_out() {
    let desk = desk();
    let folder = session(FRICTION);
    let read = |name: &str| std::fs::read_to_string(Path::new(&folder).join(name)).unwrap();
    let mut table = Table::parse(&read("readings.csv"));
    let line = 47;
    let good = table.number(line - 2, "displacement_um");
    table.change(line - 2, "displacement_um", |read| read + 300.0);
    desk.write("bench/readings.csv", &table.text());
    desk.write("bench/session.toml", &read("session.toml"));
    let robot = concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/data/concealed/robots/serial-arm-more-poses.toml"
    );
    let data = desk.data(&format!("diagnose bench --robot {robot} --out out"));
    let before = desk.data(&format!("diagnose {folder} --out before"));
    assert_eq!(before["data_findings"], serde_json::json!([]));
    assert_eq!(found(&data), found(&before));
    let [one] = data["data_findings"].list() else {
        panic!("{}", data["data_findings"]);
    };
    assert_eq!(one["kind"], "bad-reading");
    assert_eq!(one["lines"], serde_json::json!([line]));
    assert_eq!(
        one["place"]["reading"]["pose"],
        table.word(line - 2, "pose")
    );
    assert_eq!(one["value"].number().round(), good + 300.0);
    let [expected, se] = ["expected", "standard_error"].map(|key| one[key].number());
    assert!((expected - good).abs() < 5.0 * se, "{expected} ± {se}");
    assert!(se < 20.0 && one["p_family"].number() < 0.003);
    assert_eq!(one["left_out"], true);
    let page = desk.read("out/verdict.txt");
    let first = format!("One reading contradicts its repeats: line {line}, P");
    assert!(
        page.contains(&first) && page.contains("BAD READINGS"),
        "{page}"
    );
    // It is named all the same where it stays in; the file is as it was.
    let kept = desk.data(&format!(
        "diagnose bench --robot {robot} --keep-outliers --out kept"
    ));
    assert_eq!(kept["data_findings"][0]["lines"], one["lines"]);
    assert_eq!(kept["data_findings"][0]["left_out"], false);
    let [left_out, kept] = [&data, &kept].map(|data| data["after"]["rms_um"].number());
    assert!(kept > left_out, "{kept} {left_out}");
    assert_eq!(desk.read("bench/readings.csv"), table.text());
}

#[test]
fn nothing_missing_lists_the_detection_limits() {
    let desk = desk();
    let command = format!("diagnose {} --no-figures --out out", session(NOTHING));
    // One pose does not determine all factors: without a finding that is what --strict tells.
    let ran = desk.run(&format!("{command} --strict")).exits_with(41);
    ran.stdout.must_contain(&[
        "\n\nNo missing physics was detected.",
        "WHAT WOULD HAVE BEEN FOUND",
    ]);
    assert!(!desk.path("out/mismatch_map.svg").exists());
    let first = desk.read("out/diagnosis.json");
    let page = desk.read("out/verdict.txt");
    let data: Value = serde_json::from_str(&first).unwrap();
    assert_follows_schema(&data);
    let data = &data["data"];
    assert_eq!(data["verdict"], "nothing-missing");
    assert!(found(data).is_empty());
    let next = data["next_measurement"].list();
    assert_eq!(next[0]["separates"][0], "that nothing is missing");
    let words: Vec<&str> = page.split_whitespace().collect();
    words
        .join(" ")
        .must_contain(&["this should confirm or refute that nothing is missing."]);
    // Every law of the library is told of: with a limit, or with the reason why there is none.
    let limits = data["detection_limits"].list();
    for law in Law::searched_on(TestObject::Robot) {
        let tested = data["levels"]["laws"].list();
        assert!(
            limits
                .iter()
                .chain(tested)
                .any(|one| one["physics"] == law.name),
            "{law}"
        );
    }
    // Same session, same seed: same bytes.
    desk.run(&command).succeeds();
    assert_eq!(desk.read("out/diagnosis.json"), first);
    assert_eq!(desk.read("out/verdict.txt"), page);
}

#[test]
fn two_effects_are_distinguished_and_laws_can_be_left_out() {
    let desk = desk();
    let path = session(PLAY_AND_SETTING_IN);
    let data = desk.data(&format!("diagnose {path} --out a --no-figures"));
    for truth in answer(PLAY_AND_SETTING_IN)["truth"].list() {
        let name = (truth["physics"].word(), &truth["place"]);
        assert!(found(&data).contains(&name), "{name:?}");
    }
    let object = desk
        .run(&format!(
            "diagnose {path} --out b --no-figures --without joint-backlash,thermal-drift --seed 3 --json"
        ))
        .succeeds()
        .json();
    let data = &object["data"];
    assert!(found(data).iter().all(|(law, _)| *law != "joint-backlash"));
    assert_eq!(
        data["without"],
        serde_json::json!(["joint-backlash", "thermal-drift"])
    );
    assert_eq!(data["seed"], 3);
    let limits = data["detection_limits"].list();
    assert!(
        limits
            .iter()
            .any(|limit| limit["physics"] == "joint-backlash"
                && limit["size_80"].is_null()
                && limit["reason"].word().contains("left out"))
    );
}

#[test]
fn what_is_missing_beside_known_physics_is_found() {
    let desk = desk();
    let path = session(PLAY_AND_SETTING_IN);
    let answer = answer(PLAY_AND_SETTING_IN);
    let truth = answer["truth"].list();
    let play = truth
        .iter()
        .find(|truth| truth["physics"] == "joint-backlash")
        .unwrap();
    let joint = play["place"]["joint"].word();
    let effect = format!("joint-backlash@{joint}:play=1e-4rad,seat_moment=2N*m");
    let data = desk.data(&format!(
        "diagnose {path} --out a --no-figures --effect {effect}"
    ));
    assert!(found(&data).iter().all(|(law, _)| *law != "joint-backlash"));
    assert!(found(&data).iter().any(|(law, _)| *law == "setting-in"));
    let [known] = data["known_effects"].list() else {
        panic!("{}", data["known_effects"]);
    };
    let value = &known["parameters"]["play"];
    let ci95 = &value["after"]["ci95"];
    assert_eq!(value["given"], 1e-4);
    assert_ne!(value["after"]["value"], 1e-4);
    assert!(ci95[0].as_f64() < ci95[1].as_f64(), "{ci95}");
    // With all of it in the model nothing is missing.
    let data = desk.data(&format!(
        "diagnose {path} --out b --no-figures --model a/model.toml"
    ));
    assert_eq!(data["verdict"], "nothing-missing");
    assert_eq!(data["known_effects"].list().len(), 2);
}

#[test]
fn indistinguishable_effects_are_named_as_a_set() {
    let desk = desk();
    let command = format!("diagnose {} --no-figures --out out", session(LOOSE_MEMBER));
    let data = desk.data(&command);
    assert_eq!(data["verdict"], "ambiguous");
    let found = found(&data);
    let truth = &answer(LOOSE_MEMBER)["truth"][0];
    let rivals = truth["rivals"].list();
    for member in rivals
        .iter()
        .filter(|rival| rival["standard_errors_between"].number() < 2.0)
        .chain([truth])
    {
        let name = (member["physics"].word(), &member["place"]);
        assert!(found.contains(&name), "{name:?} is not in {found:?}");
    }
    for finding in data["findings"].list() {
        assert_eq!(finding["alternative_group"], 1);
    }
    let page = desk.read("out/verdict.txt");
    page.must_contain(&[
        "\n\nThe model leaves out a loose element ",
        "these readings do not decide",
    ]);
}

#[test]
fn what_no_law_explains_is_called_unknown() {
    let desk = desk();
    let command = format!(
        "diagnose {} --without gauge-periodic --no-figures --out out",
        session(PERIOD)
    );
    let data = desk.data(&command);
    assert_eq!(data["verdict"], "unknown");
    assert_eq!(data["left_over"]["stratum"], "rest");
    assert!(data["left_over"]["p"].number() < 0.01);
    let page = desk.read("out/verdict.txt");
    page.must_contain(&[
        "\n\nSomething is missing from the model, and no law of the library explains it",
    ]);
    if !found(&data).is_empty() {
        page.must_contain(&["WHAT EXPLAINS A PART OF IT"]);
    }
    page.must_contain(&["without gauge-periodic"]);
}

#[test]
fn a_bare_table_is_diagnosed_and_missing_columns_are_listed() {
    let desk = desk();
    desk.write("readings.csv", &five_columns(&["P1", "P2"], 1));
    let before = std::fs::read_dir(desk.folder.path()).unwrap().count();
    let object = desk
        .run("diagnose readings.csv --robot hp-robot --mechanism A --json")
        .succeeds()
        .json();
    assert_eq!(object["data"]["verdict"], "insufficient-data");
    assert!(object["data"]["files"].is_null());
    let text = desk
        .run("diagnose readings.csv --robot hp-robot --mechanism A")
        .succeeds()
        .stdout;
    text.must_contain(&[
        "\n\nThese readings cannot decide whether the model leaves something out.",
        "WHAT IS LACKING",
        "three repeats",
        "APPENDIX",
    ]);
    let after = std::fs::read_dir(desk.folder.path()).unwrap().count();
    assert_eq!(before, after);
    desk.run("diagnose readings.csv --robot hp-robot --mechanism A --strict")
        .exits_with(1);
}

#[test]
fn earlier_sessions_contribute_to_the_noise() {
    let desk = desk();
    let simulate = |name: &str, options: &str| {
        desk.run(&format!(
            "simulate {name} --mechanism A --procedure load-unload {options}"
        ))
        .succeeds();
    };
    simulate("now", "--seed 1");
    simulate("before", "--seed 2");
    simulate("long-before", "--seed 3");
    // Its runs scatter three times as much.
    simulate("worn", "--seed 4 --run-slope-sd 0.012");
    let told = |options: &str| {
        let run = desk.run(&format!("diagnose now --no-figures {options} --json"));

        run.succeeds().json()
    };
    let alone = told("");
    let object = told("--earlier before --earlier long-before --earlier worn");
    // The errors of single poses are those of which the whole is made.
    let after = &object["data"]["after"];
    let poses = after["held_out"].list();
    let squares = poses.iter().map(|pose| pose["rms_um"].number().powi(2));
    let rms_um = (squares.sum::<f64>() / poses.len() as f64).sqrt();
    let whole_um = after["held_out_rms_um"].number();
    assert!(poses.len() > 1 && (rms_um / whole_um - 1.0).abs() < 1e-9);
    let noise = &object["data"]["noise"];
    assert_eq!(noise["source"], "earlier-sessions");
    let sessions = noise["earlier"].list();
    let used: Vec<bool> = sessions
        .iter()
        .filter_map(|s| s["used"].as_bool())
        .collect();
    assert_eq!(used, [true, true, false]);
    let dof = |noise: &Value| noise["run_slope_sd"]["dof"].number();
    let sum = dof(&alone["data"]["noise"]) + dof(&sessions[0]) + dof(&sessions[1]);
    // A curvature at the likeliest noise, which moves a little: a tenth.
    assert!((dof(noise) / sum - 1.0).abs() < 0.1, "{} {sum}", dof(noise));
    let warnings = object["warnings"].to_string();
    warnings.must_contain(&["has a different scatter than this session", "simulated-4"]);
    let page =
        std::fs::read_to_string(desk.folder.path().join("now/diagnosis/verdict.txt")).unwrap();
    page.must_contain(&["simulated-3", "together"]);
    for (twice, name) in [
        ("--earlier now", "now"),
        ("--earlier before --earlier ./before", "./before"),
    ] {
        let error = desk.run(&format!("diagnose now {twice} --json"));
        let error = error.exits_with(2).json()["error"].clone();
        assert_eq!(error["code"], "stiffbench::usage::argument");
        error["message"].word().must_contain(&[name]);
    }
    desk.run("diagnose now --earlier before --noise records")
        .exits_with(2);
    // A bare file without repeats tells no scatter.
    desk.write("once.csv", &five_columns(&["P1", "P2"], 1));
    let error = desk.run("diagnose now --earlier once.csv --robot hp-robot --json");
    let error = error.exits_with(2).json()["error"].clone();
    error["message"].word().must_contain(&["once.csv"]);
}

/// A table whose gauge reads `zero_um` of its cell where nothing is loaded.
fn zeroed_elsewhere(table: &str, zero_um: impl Fn(&str) -> f64) -> String {
    let mut table = Table::parse(table);
    for row in 0..table.len() {
        let zero_um = zero_um(table.word(row, "direction"));
        table.change(row, "displacement_um", |read| read + zero_um);
    }
    table.text()
}

#[test]
fn a_gauge_that_was_not_zeroed_without_load_is_not_missing_physics() {
    let desk = desk();
    desk.run("simulate bench --seed 7").succeeds();
    let table = desk.read("bench/readings.csv");
    // Under a preload of 1 N, whose displacement depends on the direction.
    let shifted = zeroed_elsewhere(
        &table,
        |direction| {
            if direction == "y" { 38.0 } else { 5.0 }
        },
    );
    desk.write("zeroed.csv", &table);
    desk.write("preloaded.csv", &shifted);
    let said = |file: &str| {
        let ran = desk.run(&format!("diagnose {file} --robot hp-robot --json"));
        let answer = ran.json();
        let noted = answer["warnings"].to_string();
        assert_eq!(answer["data"]["verdict"], "nothing-missing", "{file}");
        let factor = answer["data"]["factors"][1]["after"].clone();
        (factor, noted.contains("not zeroed without load"))
    };
    let (factor, noted) = said("zeroed.csv");
    assert!(!noted);
    let (shifted_factor, noted) = said("preloaded.csv");
    assert!(noted);
    // Slopes do not change. The mean of the zeros of a cell no longer takes part in the fit: a small part of the interval.
    let value = |factor: &Value| factor["value"].number();
    let [low, high] = [0, 1].map(|end| factor["ci95"][end].number());
    let change = (value(&shifted_factor) - value(&factor)).abs();
    assert!(change < 0.25 * (high - low), "{shifted_factor} {factor}");
}
