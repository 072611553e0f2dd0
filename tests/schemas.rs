//! The published schemas are those of the result structs, and what the commands print follows them.

#![cfg(unix)]

use std::collections::BTreeSet;

use clap::Command;
use rayon::prelude::*;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use stiffbench::analysis::StoredResult;
use stiffbench::mismatch::{DesignReport, LawAtPlace};
use stiffbench::physics::{Effect, Law};
use stiffbench::report::{
    ComparisonReport, DiagnosisSummary, FitReport, MapResult, PlanReport, PredictionReport,
    ShardReport, SignificanceReport, SimulationReport, VectorStiffnessReport, VerifyReport,
    schemas,
};
use stiffbench::stiffness::StiffnessReport;
use stiffbench_test_files::desk::{Desk, Ran};
use stiffbench_test_files::schemas::are_published;

use crate::support::Contains;

#[test]
fn the_schemas_are_published() {
    let schemas = schemas().into_iter();
    are_published(
        "docs/schemas",
        schemas.map(|(kind, schema)| (kind, json!(schema))),
    );
}

/// Commands that run one after the other in one folder, each with `--json`, and the folders whose files are there before. Every kind of data goes
/// through every command that reads it.
#[rustfmt::skip]
const RUNS: &[(&[&str], &[&str])] = &[
    // A session with one gauge.
    (&[], &[
        "simulate s --poses P1,P2 --procedure load-unload --seed 4", "stiffness s", "stiffness s --branches both --budget", "fit s",
        "fit s --parameter beam.J=fixed --bootstrap 20 --save-factors f.toml", "diagnose s", "diagnose s --without slip --no-figures --out d", "compare s s",
        "robot map --model s/diagnosis/model.toml --at-load 50 --samples 60", "report s --no-diagnosis --out r.html", "report verify r.html s",
        "report s --no-diagnosis --format markdown --out -", "report --print-template", "export s --out tables", "export s --format xlsx --out sheets",
        "simulate t --seed 5 --poses P1,P2 --procedure load-unload --mechanism A --effect joint-backlash@A3:play=30urad,seat_moment=9N*m",
        "diagnose t --no-figures",
    ]),
    // Three gauges.
    (&[], &[
        "simulate v --mechanism A --procedure load-unload --directions x,y --displacement-axes x,y,z --poses P1,P2 --seed 2", "stiffness v",
        "fit v --parameter beam.A,beam.J=fixed", "diagnose v --no-figures", "report v --no-diagnosis --out r.html",
    ]),
    // Load cases.
    (&[], &[
        "simulate l --robot serial-arm --load-cases 40 --seed 1", "fit l", "diagnose l --no-figures", "simulate r --robot serial-arm --load-cases 12 --repeats 3 --seed 5",
        "fit r", "diagnose r --no-figures", "report l --out r.html", "stiffness l",
    ]),
    // Positions of a tracker.
    (&["fixtures/cases/positions"], &[
        "simulate p --robot arm.toml --positions 30 --seed 4", "fit p", "diagnose p --no-figures", "robot check arm.toml",
        "robot map arm.toml --samples 60 --sag",
    ]),
    // A list of stiffnesses.
    (&["fixtures/cases/stiffness-list"], &[
        "fit spring.csv --robot hp-robot --mechanism F --factors m_fsd --parameter beam.A,beam.Iy,beam.Iz=fixed",
        "diagnose spring.csv --robot hp-robot --mechanism F --factors m_fsd --parameter beam.A,beam.Iy,beam.Iz=fixed",
        "fit paper-experiment --method paper --train P1,P3 --reference paper-reference",
    ]),
    // A part.
    (&["fixtures/cases/two-sliders", "fixtures/goldens/inputs"], &[
        "part diagnose two_sliders.csv --map force=force_kN,displacement=disp_mm --response force --out part",
        "part predict part/model.toml two_sliders.csv",
        "part diagnose softening.csv --map force=load,displacement=deflection,run=run,order=order --force-unit 1 --displacement-unit 1 --no-figures",
    ]),
    // What is asked before anything is measured.
    (&[], &[
        "session plan --procedure paper --design", "session plan --procedure load-unload --mechanism A --design", "session plan --procedure load-hold-unload --poses P1,P2",
        "session plan --robot serial-arm --directions x,y,z --loads-n=0,-20,-40 --best-poses 3", "robot significance --pose P1 --factors unit",
        "robot show", "robot show --mobility", "robot show --schema", "robot check serial-arm", "robot new n.toml --template serial",
        "robot compliance --pose P1 --mechanism F", "robot compliance serial-arm",
        "robot export serial-arm --format json --pose P4", "robot export --format mjcf --pose P1 --out a.xml",
    ]),
    (&[], &[
        "robot map --samples 60 --mechanisms A,F --directions x,y,z --difference A,F --figures figures --out maps", "robot map --samples 60 --mechanisms F --load 0,-50,0 --limit 0.5 --sensitivity",
        "robot map --samples 60 --mechanisms F --shard 1/1 --out shards", "robot map merge shards/1-of-1.map-shard",
        "robot map serial-arm --plane x,z --directions y,rx --matrix --samples 60 --out plane --figures plane --cell median",
    ]),
    // Gauges and their bytes.
    (&["fixtures/goldens/inputs", "protocols/instruments"], &[
        "gauge list", "gauge show mitutoyo-01a", "gauge show --schema", "gauge check sauter-fh.toml",
        "gauge decode mark10-series5 --unit N < mark10.bytes", "gauge read mark10-series5 --port gauge --count 2", "gauge ports",
        "gauge probe gauge --instrument mark10-series5", "gauge bind force --port gauge --instrument mark10-series5",
        "gauge record mark10-series5 --port gauge --seconds 0.5 --out a.trace", "gauge show a.trace", "gauge decode a.trace", "gauge replay a.trace --speed max",
        "gauge emulate --poses P1 --directions x --loads-n 0,-10 --repeats 1 --speed 100",
    ]),
    // Guided sessions.
    (&["fixtures/goldens/inputs", "fixtures/imports"], &[
        "session run s --procedure sweeps --poses P1 --directions x --loads-n 0,-30 --repeats 2 --emulated --speed 5 --no-input", "session replay s --out t",
        "session status s", "session log s", "session verify s", "session verify cut", "session status cut", "session undo cut", "session recover practice --out recovered",
        "import german-excel.csv --out i", "import joint-angles.csv --out j",
    ]),
    // The program itself.
    (&[], &[
        "config show", "config show --origin", "config show --schema", "config path", "doctor", "explain", "explain joint-backlash", "explain nothing-missing",
        "explain readings::wrong_unit", "explain 30", "completions bash", "man", "man --out pages", "__complete robots",
    ]),
];

#[test]
fn an_effect_of_every_law_is_read_back() {
    for law in Law::ALL.iter().copied() {
        let place = law.place_kind.example().trim_start_matches('@');
        let place = law.place_kind.read(place).unwrap();
        let effect = Effect::new(law, place, vec![1.0; law.parameters.len()]).unwrap();
        let object = json!(effect);
        assert_eq!(Effect::deserialize(&object).unwrap(), effect, "{object}");
        let named = LawAtPlace::deserialize(&object).unwrap();
        assert_eq!(
            (named.law.name, named.place),
            (law.name, effect.place),
            "{object}"
        );
    }
    let unknown = json!({"physics": "joint-backlsh", "place": {"joint": "A3"}, "parameters": {}});
    let error = Effect::deserialize(&unknown).unwrap_err().to_string();
    error.must_contain(&["there is no law `joint-backlsh`: did you mean joint-backlash?"]);
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

/// The result that a command printed, read and written again; `None` of kinds that are only written.
fn read_back(kind: &str, printed: &str) -> Option<Value> {
    fn of<T: Serialize + DeserializeOwned>(kind: &str, printed: &str) -> Value {
        let stored = StoredResult::<T>::read(kind, printed);
        json!(
            stored
                .unwrap_or_else(|problem| panic!("{problem}: {printed}"))
                .data
        )
    }
    let reader = match kind {
        "compare" => of::<ComparisonReport>,
        "design" => of::<DesignReport>,
        "diagnosis" => of::<DiagnosisSummary>,
        "fit" => of::<FitReport>,
        "map" => of::<MapResult>,
        "map-shard" => of::<ShardReport>,
        "prediction" => of::<PredictionReport>,
        "session-plan" => of::<PlanReport>,
        "session-verify" => of::<VerifyReport>,
        "significance" => of::<SignificanceReport>,
        "simulate" => of::<SimulationReport>,
        "stiffness" => of::<StiffnessReport>,
        "stiffness-vectors" => of::<VectorStiffnessReport>,
        _ => return None,
    };
    Some(reader(kind, printed))
}

/// The kinds of results and the verdicts that commands print which run in one folder.
fn seen(given: &[&str], commands: &[&str]) -> BTreeSet<String> {
    let desk = Desk::new(env!("CARGO_BIN_EXE_stiffbench"));
    for folder in given {
        desk.copy(folder);
    }
    let needs_gauge = commands.iter().any(|line| line.contains("--port gauge"));
    let _gauge = needs_gauge.then(|| crate::cli::lines::mark10(&desk));
    let mut seen = BTreeSet::new();
    for line in commands {
        let (words, input) = line.split_once(" < ").unwrap_or((line, ""));
        let mut command = desk.command(&format!("{words} --json"));
        if !input.is_empty() {
            command.pipe_stdin(desk.path(input)).unwrap();
        }
        let ran = Ran::of(&mut command);
        let object = ran.json();
        let kind = object["kind"]
            .as_str()
            .unwrap_or_else(|| panic!("{line}: {}", ran.stdout));
        seen.insert(kind.to_owned());
        if object["ok"] == true
            && let Some(again) = read_back(kind, &ran.stdout)
        {
            assert_eq!(again.to_string(), object["data"].to_string(), "{line}");
        }
        if let Some(verdict) = object["data"]["verdict"].as_str() {
            seen.insert(verdict.to_owned());
        }
    }
    seen
}

/// Kinds that a command of another test prints: `demo` in `cli::files`.
const ELSEWHERE: [&str; 1] = ["demo"];

#[test]
fn what_the_commands_print_follows_the_schemas() {
    let seen: BTreeSet<String> = RUNS
        .par_iter()
        .flat_map_iter(|(given, commands)| seen(given, commands))
        .collect();
    let kinds = schemas().into_iter().map(|(kind, _)| kind);
    let absent: Vec<_> = kinds
        .filter(|kind| !seen.contains(*kind) && !ELSEWHERE.contains(kind))
        .collect();
    assert!(absent.is_empty(), "{absent:?}");
    for verdict in ["nothing-missing", "explained"] {
        assert!(seen.contains(verdict), "{verdict}: {seen:?}");
    }
}
