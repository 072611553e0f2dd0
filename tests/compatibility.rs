//! Every version of a file that docs/compatibility.md promises to read is read.

use std::collections::BTreeSet;
use std::path::Path;

use stiffbench::instrument::emulator::FaultScript;
use stiffbench::instrument::port::Bindings;
use stiffbench::source_text::SourceText;

use crate::cli::desk;

/// What reads a file.
enum Reader {
    /// A command, with the path of the file in place of FILE.
    Command(&'static str),
    /// A library: the command would need gauges, or run until it is stopped.
    Library(fn(&SourceText)),
}
use Reader::{Command, Library};

/// Schema, a file that has it, and what reads the file.
const VERSIONS: &[(&str, &str, Reader)] = &[
    (
        "stiffbench/session/1",
        "fixtures/goldens/inputs/practice/session.toml",
        Command("stiffness FILE/.."),
    ),
    (
        "stiffbench/session/2",
        "fixtures/versions/session-2/session.toml",
        Command("stiffness FILE/.."),
    ),
    (
        "stiffbench/robot/2",
        "data/robots/scara.toml",
        Command("robot check FILE"),
    ),
    (
        "planar-linkage-robot/1",
        "fixtures/robots/scara.toml",
        Command("robot check FILE"),
    ),
    (
        "stiffbench/instrument/1",
        "protocols/instruments/sauter-fh.toml",
        Command("gauge check FILE"),
    ),
    (
        "stiffbench/bindings/1",
        "fixtures/versions/bindings-1.toml",
        Library(|source| {
            let (bindings, unknown) = Bindings::parse(source).unwrap();
            assert!(bindings.force.is_some() && bindings.displacement.is_some());
            assert!(unknown.is_empty(), "{unknown:?}");
        }),
    ),
    (
        "stiffbench/procedure/1",
        "fixtures/versions/procedure-1.toml",
        Command("session plan --procedure FILE"),
    ),
    (
        "stiffbench/model/1",
        "fixtures/versions/model-1.toml",
        Command("robot compliance --pose P1 --model FILE"),
    ),
    (
        "stiffbench/part-model/2",
        "fixtures/part-model.toml",
        Command("part predict FILE part.csv"),
    ),
    (
        "stiffbench/answers/1",
        "fixtures/versions/answers-1.toml",
        Command(
            "session run s --emulated --speed 200 --no-input --poses P1 --directions x --repeats 1 --loads-n=0,-40 --answer-file FILE",
        ),
    ),
    (
        "stiffbench/trace/1",
        "fixtures/goldens/inputs/force.trace",
        Command("gauge decode FILE"),
    ),
    (
        "stiffbench/faults/1",
        "fixtures/versions/faults-1.toml",
        Library(|source| assert_eq!(FaultScript::parse(source).unwrap().faults.len(), 1)),
    ),
    (
        "stiffbench/mapping/1",
        "fixtures/versions/mapping-1.toml",
        Command("import table.csv --out imported --mapping FILE"),
    ),
];

fn repository() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The schemas in the last column of the table of files.
fn promised() -> BTreeSet<String> {
    let page = std::fs::read_to_string(repository().join("docs/compatibility.md")).unwrap();
    let (_, table) = page.split_once("| file | written | read |").unwrap();
    let rows = table.lines().filter(|line| line.starts_with("| "));
    rows.filter(|row| !row.starts_with("| ---"))
        .flat_map(|row| {
            let read = row.trim_end_matches(" |").rsplit(" | ").next().unwrap();
            let marked = read.split('`').skip(1).step_by(2).map(str::to_owned);
            marked.collect::<Vec<_>>()
        })
        .collect()
}

#[test]
fn every_promised_version_has_a_file_that_is_read() {
    let tested: BTreeSet<String> = VERSIONS.iter().map(|one| one.0.to_owned()).collect();
    assert_eq!(promised(), tested);
    for (schema, file, reader) in VERSIONS {
        let path = repository().join(file);
        let text = std::fs::read_to_string(&path).unwrap();
        assert!(text.contains(schema), "{file} is no {schema}");
        match reader {
            Library(read) => read(&SourceText::new(*file, text)),
            Command(command) => {
                let desk = desk();
                desk.write("table.csv", "Kraft,Weg\n1,2.5\n2,5.0\n3,7.5\n4,10.0\n");
                desk.write(
                    "part.csv",
                    "force_N,travel_mm,cycle\n0.1,-1,1\n0.2,0,1\n0.3,1,1\n",
                );
                let path = path.to_str().unwrap();
                // The folder of a file.
                let (folder, _) = path.rsplit_once('/').unwrap();
                let command = command.replace("FILE/..", folder).replace("FILE", path);
                desk.run(&command).succeeds();
            }
        }
    }
}
