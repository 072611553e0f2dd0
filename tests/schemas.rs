//! The published schemas are those of the result structs, and what the commands print follows them.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use clap::Command;
use serde_json::{Value, json};

use stiffbench::report::schemas;
use stiffbench_test_files::desk::{Desk, assert_follows_schema};
use stiffbench_test_files::schemas::are_published;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn the_schemas_are_published() {
    let schemas = schemas().into_iter();
    are_published(
        "docs/schemas",
        schemas.map(|(kind, schema)| (kind, json!(schema))),
    );
}

/// What the goldens keep of `--json`.
fn printed() -> Vec<Value> {
    let fixtures = root().join("fixtures");
    let cases = fs::read_dir(fixtures.join("goldens")).unwrap();
    let cases = cases.map(|case| case.unwrap().path());
    let mut found = Vec::new();
    for case in cases.chain([fixtures.join("goldens-validate/paper")]) {
        let Ok(text) = fs::read_to_string(case.join("printed.txt")) else {
            continue;
        };
        let mut lines = text.lines();
        while let Some(line) = lines.next() {
            if line != "{" {
                continue;
            }
            let rest = lines.by_ref().take_while(|line| *line != "}");
            let object = std::iter::once("{").chain(rest).chain(["}"]);
            found.push(serde_json::from_str(&object.collect::<String>()).unwrap());
        }
    }
    found
}

/// The words of every command that is shown and has none below it that must be named, with a bad value for each argument that it needs.
fn with_bad_arguments() -> Vec<String> {
    fn walk(command: &Command, words: &str, found: &mut Vec<String>) {
        let below = command.get_subcommands();
        for below in below.filter(|below| !below.is_hide_set()) {
            let mut words = format!("{words} {}", below.get_name());
            walk(below, &words, found);
            for argument in below.get_arguments().filter(|one| one.is_required_set()) {
                if let Some(long) = argument.get_long() {
                    words = format!("{words} --{long}");
                }
                words += " absent/of-no-use";
            }
            if !below.is_subcommand_required_set() {
                found.push(words);
            }
        }
    }
    let mut found = Vec::new();
    walk(&stiffbench::cli::command(), "", &mut found);
    found
}

#[test]
fn what_commands_print_on_failure_follows_the_schema() {
    let mut codes = BTreeSet::new();
    let commands = with_bad_arguments();
    assert!(commands.len() > 30, "{commands:?}");
    for words in commands {
        let desk = Desk::new(env!("CARGO_BIN_EXE_stiffbench"));
        // An option that there is not.
        let usage = desk.run(&format!("{words} --no-such-option --json"));
        let object = usage.exits_with(2).json();
        assert_eq!(object["error"]["code"], "stiffbench::usage", "{words}");
        // Arguments that are not there: what comes is of its schema, whether it is a failure or a result.
        if words.contains("absent") {
            let object = desk.run(&format!("{words} --json")).json();
            codes.extend(object["error"]["code"].as_str().map(str::to_owned));
        }
    }
    assert!(codes.len() >= 6, "{codes:?}");
}

#[test]
fn what_the_commands_print_follows_the_schemas() {
    let printed = printed();
    for object in &printed {
        assert_follows_schema(object);
    }
    let kinds = || printed.iter().filter_map(|object| object["kind"].as_str());
    let published: BTreeSet<&str> = schemas().into_iter().map(|(kind, _)| kind).collect();
    let seen: BTreeSet<&str> = kinds().filter(|kind| published.contains(kind)).collect();
    // The others need gauges, ports or minutes.
    assert!(seen.len() >= 20, "{seen:?}");
    let diagnoses = kinds().filter(|kind| *kind == "diagnosis").count();
    assert!(diagnoses >= 8, "{diagnoses}");
}
