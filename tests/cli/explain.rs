//! Every error code of the program, every law and every verdict has an explanation, and none is stale.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use stiffbench::physics::Law;
use stiffbench::shipped::error_explanations;

use super::desk;
use crate::support::{Contains, Json};

/// Codes that are put together from a word: the problems of a TOML file.
const OF_A_SESSION_FILE: [&str; 9] = [
    "syntax",
    "no_schema",
    "other_schema",
    "newer_schema",
    "unknown_key",
    "missing_key",
    "wrong_value",
    "given_twice",
    "wrong_unit",
];

/// Rust files below a folder.
fn sources(folder: &Path, found: &mut Vec<String>) {
    for entry in fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.is_dir() {
            sources(&path, found);
        } else if path.extension().is_some_and(|end| end == "rs") {
            found.push(fs::read_to_string(path).unwrap());
        }
    }
}

/// Codes in a source, where an error has one: `code(stiffbench::…)`, texts `"stiffbench::…"` in a box, and those of errors of tables.
fn codes(text: &str) -> Vec<String> {
    let lines: Vec<&str> = text.lines().map(str::trim).collect();
    let text = &lines.concat();
    let mut found = Vec::new();
    for start in [
        "code(stiffbench::",
        "Box::new(\"stiffbench::",
        "TableError::new(\"stiffbench::",
        "ProcedureProblem::new(\"stiffbench::",
        ".refused(\"stiffbench::",
        "code: \"stiffbench::",
    ] {
        for (at, _) in text.match_indices(start) {
            let rest = &text[at + start.len()..];
            let is_code = |c: char| c.is_ascii_lowercase() || c == '_' || c == ':';
            let end = rest.find(|c| !is_code(c)).unwrap_or(rest.len());
            found.push(rest[..end].to_owned());
        }
    }
    found
}

#[test]
fn every_code_of_the_source_is_explained_and_no_explanation_is_stale() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut texts = Vec::new();
    sources(&root.join("src"), &mut texts);
    for entry in fs::read_dir(root.join("crates")).unwrap().flatten() {
        // The second program explains its own.
        if entry.file_name() != "validation" {
            sources(&entry.path().join("src"), &mut texts);
        }
    }
    let mut used: BTreeSet<String> = texts.iter().flat_map(|text| codes(text)).collect();
    used.extend(OF_A_SESSION_FILE.map(|word| format!("session_file::{word}")));
    assert!(used.len() > 200, "{}", used.len());
    let explained: BTreeSet<String> = error_explanations().into_keys().collect();
    let missing: Vec<_> = used.difference(&explained).collect();
    let stale: Vec<_> = explained.difference(&used).collect();
    assert!(
        missing.is_empty() && stale.is_empty(),
        "missing {missing:?}, stale {stale:?}"
    );
}

#[test]
fn codes_are_explained_with_and_without_their_beginning() {
    let desk = desk();
    let short = desk.run("explain readings::wrong_unit").succeeds();
    let whole = desk
        .run("explain stiffbench::readings::wrong_unit")
        .succeeds();
    assert_eq!(short.stdout, whole.stdout);
    short
        .stdout
        .must_contain(&["exit code 11", "What to do", "force_N, force_lbf"]);
    // The code and the exit code are those of the error itself.
    desk.write(
        "readings.csv",
        "pose,direction,repeat,force,displacement_um\nP1,x,1,10,5\n",
    );
    let error = desk.refusal(
        "stiffness readings.csv",
        11,
        "stiffbench::readings::wrong_unit",
    );
    let data = desk.data(&format!("explain {}", error["code"].word()));
    assert_eq!(data["exit_code"], error["exit_code"]);
}

#[test]
fn every_law_and_verdict_is_explained() {
    let desk = desk();
    let list = desk.data("explain");
    let laws: Vec<&str> = list["laws"].list().iter().map(Json::word).collect();
    assert_eq!(laws, Law::names());
    for law in [
        "joint-backlash",
        "thermal-drift",
        "loose-member",
        "tool-compliance",
    ] {
        let data = desk.data(&format!("explain {law}"));
        assert_eq!(data["kind"], "law");
        assert_eq!(data["forms"].list().len(), Law::named(law).count());
    }
    for verdict in [
        "explained",
        "ambiguous",
        "unknown",
        "nothing-missing",
        "insufficient-data",
    ] {
        assert_eq!(desk.data(&format!("explain {verdict}"))["kind"], "verdict");
    }
    let text = desk.run("explain").succeeds().stdout;
    text.must_contain(&["  port::not_allowed\n", "  joint-friction\n"]);
}

#[test]
fn exit_codes_are_explained_with_their_errors() {
    let desk = desk();
    let found = desk.data("explain 30");
    assert_eq!(found["kind"], "exit-code");
    assert_eq!(found["exit_code"], 30);
    found["remedy"].word().must_contain(&["session::damaged"]);
    for (code, _) in stiffbench::cli::failure::EXIT_CODE_MEANINGS {
        desk.run(&format!("explain {code}")).succeeds();
    }
    desk.refusal("explain 99", 2, "stiffbench::usage::unknown_topic");
    // What the parser of arguments gives.
    assert_eq!(desk.data("explain stiffbench::usage")["exit_code"], 2);
}
