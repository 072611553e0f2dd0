//! The published schemas are those of the result structs, and what the commands print follows them.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use serde_json::{Value, json};

use stiffbench::report::schemas;
use stiffbench_test_files::desk::assert_follows_schema;
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
