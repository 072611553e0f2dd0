//! The published schemas are those of the result structs, and what the commands print follows them.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use stiffbench::report::schemas;

/// How the goldens are kept too.
const MODE: &str = "STIFFBENCH_GOLDENS";

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

#[test]
fn the_schemas_are_published() {
    let folder = root().join("docs/schemas");
    let write = std::env::var(MODE).is_ok_and(|mode| mode == "write");
    let mut names = BTreeSet::new();
    for (kind, schema) in schemas() {
        let file = folder.join(format!("{kind}.json"));
        let text = format!("{:#}\n", json!(schema));
        if write {
            fs::create_dir_all(&folder).unwrap();
            fs::write(&file, &text).unwrap();
        }
        let published = fs::read_to_string(&file).unwrap_or_default();
        assert_eq!(published, text, "{}: just goldens", file.display());
        names.insert(file);
    }
    let files = fs::read_dir(&folder).unwrap();
    let files: BTreeSet<PathBuf> = files.map(|file| file.unwrap().path()).collect();
    assert_eq!(files, names);
}

/// What the goldens keep of `--json`.
fn printed() -> Vec<Value> {
    let mut found = Vec::new();
    for case in fs::read_dir(root().join("fixtures/goldens")).unwrap() {
        let Ok(text) = fs::read_to_string(case.unwrap().path().join("printed.txt")) else {
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
    let mut seen = BTreeSet::new();
    let printed = printed();
    for (kind, schema) in schemas() {
        let validator = jsonschema::validator_for(&json!(schema)).unwrap();
        // Loads, weights and sensitivities are results of `map` beside the maps, each with a key of its own.
        let of_kind = |object: &&Value| object["kind"] == kind && object["ok"] == true;
        for object in printed.iter().filter(of_kind) {
            let errors: Vec<String> = validator
                .iter_errors(&object["data"])
                .map(|error| format!("{}: {error}", error.instance_path()))
                .collect();
            assert!(errors.is_empty(), "{kind}: {errors:#?}");
            seen.insert(kind);
        }
    }
    // The others need gauges, ports or minutes.
    assert!(seen.len() >= 18, "{seen:?}");
}
