//! Every subcommand once, for people and for programs.

use super::{Desk, desk, desk_with_session, unwrapped};

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
        &["combined", "repeatability"],
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
        "robot significance --pose P1 --factors unit",
        &["Iy", "mechanism F"],
        "significance",
    );
    both(
        &desk,
        "robot significance --beams-only",
        &["Pose P1"],
        "significance",
    );
}

#[test]
fn figures_and_sessions_are_listed_where_they_were_written() {
    let desk = desk();
    let drawn = desk.run("robot compliance --load 0,-50,0 --figures drawn");
    let written = drawn.succeeds().stderr;
    assert!(
        written.contains("robot.svg") && written.contains("robot.png"),
        "{written}"
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
