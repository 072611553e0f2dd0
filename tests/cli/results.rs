//! Every subcommand once, for people and for programs.

use super::{desk, desk_with_session, unwrapped};
use crate::support::Contains;

/// Subcommands with words of their text, and the kind and version of their JSON.
#[rustfmt::skip]
const RESULTS: [(&str, &[&str], &str); 11] = [
    ("stiffness session", &["P4", "K regression, N/µm", "U is the expanded uncertainty"], "stiffness/2"),
    ("stiffness session --budget --branches both", &["combined", "repeatability"], "stiffness/2"),
    ("fit session --train P1,P3", &["beam.Iy", "95 % interval", "the fit did not see"], "fit/1"),
    ("fit session --method paper --train P1,P3", &["Step 8", "Step 9"], "fit/1"),
    ("compare session session", &["The sessions agree."], "compare/2"),
    ("robot show", &["28 bodies", "Factor sets"], "robot/1"),
    ("robot check hp-robot", &["No problems found."], "robot-check/1"),
    ("robot show --mobility", &["Total by eq. (1): F = 4."], "robot-mobility/1"),
    ("robot compliance --pose P1", &["rz", "m/N"], "robot-compliance/1"),
    ("robot significance --pose P1 --factors unit", &["Iy", "mechanism F"], "significance/1"),
    ("robot significance --beams-only", &["Pose P1"], "significance/1"),
];

#[test]
fn every_result_is_a_text_and_an_object() {
    let desk = desk_with_session();
    for (arguments, words, schema) in RESULTS {
        unwrapped(&desk.run(arguments).succeeds().stdout).must_contain(words);
        let object = desk.run(&format!("{arguments} --json")).succeeds().json();
        assert_eq!(object["schema"], format!("stiffbench/{schema}"));
        assert!(object["inputs"].is_object(), "{arguments}");
        assert_eq!(object["kind"], schema.split('/').next().unwrap());
        assert_eq!(object["ok"], true);
        assert_eq!(object["tool"]["name"], "stiffbench");
        assert_eq!(object["tool"]["version"], env!("CARGO_PKG_VERSION"));
        assert!(object["warnings"].is_array(), "{arguments}");
        assert!(!object["data"].is_null(), "{arguments}");
    }
    let schema = desk.run("robot show --schema").succeeds().json();
    assert!(schema["properties"]["links"].is_object());
    assert_eq!(desk.data("robot show --schema"), schema);
}

#[test]
fn figures_and_sessions_are_listed_where_they_were_written() {
    let desk = desk();
    let drawn = desk.run("robot compliance --load 0,-50,0 --figures drawn");
    let written = drawn.succeeds().stderr;
    written.must_contain(&["robot.svg", "robot.png"]);
    desk.run("simulate a")
        .succeeds()
        .stdout
        .must_contain(&["540 readings"]);
    let simulated = desk.data("simulate b --poses P1 --directions x --repeats 2 --loads-N 0,-10");
    assert_eq!(simulated["readings"], 4);
}
