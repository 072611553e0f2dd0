//! Every subcommand once, for people and for programs.

use super::{Desk, desk, desk_with_session, five_columns, unwrapped};

/// Runs a subcommand in both forms; the text holds `words`, the JSON is an envelope of `kind`.
fn both(desk: &Desk, arguments: &str, words: &[&str], kind: &str) {
    let text = unwrapped(&desk.run(arguments).succeeds().stdout);
    for word in words {
        assert!(
            text.contains(word),
            "`{word}` is not in the text of {arguments}:\n{text}"
        );
    }
    let object = desk.run(&format!("{arguments} --json")).succeeds().json();
    let version = match kind {
        "compare" | "demo" | "map" | "stiffness" => 2,
        _ => 1,
    };
    assert_eq!(object["schema"], format!("stiffbench/{kind}/{version}"));
    assert!(object["inputs"].is_object());
    assert_eq!(object["kind"], kind);
    assert_eq!(object["ok"], true);
    assert_eq!(object["tool"]["name"], "stiffbench");
    assert_eq!(object["tool"]["version"], env!("CARGO_PKG_VERSION"));
    assert!(object["warnings"].is_array());
    assert!(!object["data"].is_null());
}

#[test]
fn stiffness_fit_and_compare() {
    let desk = desk_with_session();
    both(
        &desk,
        "stiffness session",
        &["P4", "K regression, N/µm", "U is the expanded uncertainty"],
        "stiffness",
    );
    both(
        &desk,
        "stiffness session --budget --branches both",
        &["Budget of P1 x", "repeatability"],
        "stiffness",
    );
    both(
        &desk,
        "fit session --train P1,P3",
        &["beam.Iy", "95 % interval", "the fit did not see"],
        "fit",
    );
    both(
        &desk,
        "fit session --method paper --train P1,P3",
        &["Step 8", "Step 9"],
        "fit",
    );
    both(
        &desk,
        "compare session session",
        &["The sessions agree."],
        "compare",
    );
}

#[test]
fn robots() {
    let desk = desk();
    both(&desk, "robot show", &["28 bodies", "Factor sets"], "robot");
    both(
        &desk,
        "robot check hp-robot",
        &["No problems found."],
        "robot-check",
    );
    both(
        &desk,
        "robot show --mobility",
        &["Total by eq. (1): F = 4."],
        "robot-mobility",
    );
    both(
        &desk,
        "robot workspace --samples 50",
        &["furthest", "theta2"],
        "robot-workspace",
    );
    both(
        &desk,
        "robot compliance --pose P1",
        &["rz", "m/N"],
        "robot-compliance",
    );
    let schema = desk.run("robot show --schema").succeeds().json();
    assert!(schema["properties"]["links"].is_object());
    assert_eq!(desk.data("robot show --schema"), schema);
}

#[test]
fn significance() {
    let desk = desk();
    both(
        &desk,
        "significance --pose P1 --factors unit",
        &["Iy", "mechanism F"],
        "significance",
    );
    both(
        &desk,
        "significance --beams-only",
        &["Pose P1"],
        "significance",
    );
}

#[test]
fn figures_and_sessions_are_listed_where_they_were_written() {
    let desk = desk();
    both(
        &desk,
        "plot robot --load 0,-50,0",
        &["robot.svg", "robot.png"],
        "plot",
    );
    assert!(
        desk.run("simulate a")
            .succeeds()
            .stdout
            .contains("540 readings")
    );
    let simulated = desk.data("simulate b --poses P1 --directions x --repeats 2 --loads-N 0,-10");
    assert_eq!(simulated["readings"], 4);
}

#[test]
fn completions_and_the_manual() {
    let desk = desk();
    for shell in ["bash", "zsh", "fish"] {
        assert!(
            desk.run(&format!("completions {shell}"))
                .succeeds()
                .stdout
                .contains("significance")
        );
    }
    assert!(desk.run("man").succeeds().stdout.contains(".TH stiffbench"));
}

#[test]
fn help_has_examples_and_exit_codes() {
    let desk = desk();
    let help = desk.run("--help").succeeds().stdout;
    assert!(
        help.contains("Examples:") && help.contains("Exit codes:"),
        "{help}"
    );
    for subcommand in [
        "demo",
        "robot",
        "stiffness",
        "fit",
        "significance",
        "plot",
        "simulate",
        "compare",
        "ports",
        "trace",
    ] {
        let help = desk.run(&format!("{subcommand} --help")).succeeds().stdout;
        assert!(
            help.contains(&format!("  stiffbench {subcommand}")),
            "{help}"
        );
    }
    assert_eq!(
        desk.run("--version").succeeds().stdout,
        concat!("stiffbench ", env!("PROGRAM_VERSION"), "\n")
    );
}

#[test]
fn the_smallest_readings_file_suffices_and_assumptions_are_listed() {
    let desk = desk();
    desk.write("readings.csv", &five_columns(&["P1", "P2"], 3));
    let ran = desk.run("stiffness readings.csv").succeeds();
    assert!(ran.stdout.contains("0.01000"), "{}", ran.stdout);
    assert!(
        ran.stderr.contains("note: assumed: no values of `branch`"),
        "{}",
        ran.stderr
    );
    assert_eq!(
        desk.run("stiffness readings.csv --quiet").succeeds().stderr,
        ""
    );
    let object = desk.run("stiffness readings.csv --json").succeeds().json();
    assert!(object["warnings"].as_array().unwrap().len() > 3);
    assert_eq!(
        desk.data("fit readings.csv --robot hp-robot")["cells"]
            .as_array()
            .unwrap()
            .len(),
        6
    );
}

#[test]
fn a_gauges_own_log_needs_pose_and_direction() {
    let desk = desk();
    let log = format!("{}/fixtures/sessions/gauge.log", env!("CARGO_MANIFEST_DIR"));
    let cells = &desk.data(&format!("stiffness {log} --pose P1 --direction y"))["cells"];
    assert_eq!(
        (cells[0]["pose"].as_str(), cells[0]["direction"].as_str()),
        (Some("P1"), Some("y"))
    );
    desk.run(&format!("stiffness {log} --pose P1"))
        .exits_with(2);
}

#[test]
fn lists_of_stiffness_values_can_be_fitted() {
    let desk = desk();
    desk.write(
        "list.csv",
        "pose,direction,stiffness_N_per_um,u_N_per_um\nP1,x,0.01,0.0001\nP1,y,0.03,0.0003\nP1,z,0.24,0.002\nP3,x,0.013,0.0001\nP3,y,0.035,0.0003\nP3,z,0.28,0.002\n",
    );
    for list in ["list.csv", "paper-experiment", "paper-reference"] {
        let robot = if list.ends_with("csv") {
            "--robot hp-robot"
        } else {
            ""
        };
        let fit = desk.data(&format!("fit {list} --fix beam.J {robot}"));
        assert_eq!(fit["factors"]["beam"]["J"]["status"], "fixed", "{list}");
    }
    assert_eq!(desk.data("fit list.csv --robot hp-robot")["sigma"], "known");
    assert_eq!(desk.data("fit paper-experiment")["sigma"], "estimated");
    let paper = "fit paper-experiment --method paper --train P1,P3 --weights 1,2 --reference paper-reference";
    assert_eq!(desk.data(paper)["method"], "paper");
}

#[test]
fn progress_is_text_if_asked_for() {
    let desk = desk_with_session();
    let ran = desk
        .run("fit session --bootstrap 50 --progress text")
        .succeeds();
    assert!(
        ran.stderr.contains("refits: 50 of 50 done"),
        "{}",
        ran.stderr
    );
    assert!(
        !desk
            .run("fit session --bootstrap 50 --progress none")
            .succeeds()
            .stderr
            .contains("refits")
    );
}

#[test]
fn cells_of_one_run_are_weighed_by_their_reading_noise() {
    let desk = desk();
    desk.run("simulate once --seed 5 --repeats 1").succeeds();
    let data = desk.data("fit once");
    assert_eq!(data["weights"]["basis"], "from-residuals");
    assert!(data["weights"]["run_slope_sd"].as_f64().unwrap() < 0.02);
    assert!(data["p_value"].is_null());
    let text = unwrapped(&desk.run("fit once").succeeds().stdout);
    assert!(
        text.contains(
            "scatter from run to run taken from the residuals; weights from reading noise"
        )
    );
    assert!(!text.contains("scatter about the fit"), "{text}");
}
