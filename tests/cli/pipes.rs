//! `-`: tables from standard input, files to standard output.

use serde_json::Value;
use stiffbench_test_files::desk::{Desk, Ran};

use super::{assert_output_contains, desk, desk_with_session, five_columns};

/// Runs the program with a text on standard input.
fn piped(desk: &Desk, arguments: &str, text: &str) -> Ran {
    Ran::of(desk.command(arguments).write_stdin(text))
}

/// The `data` of a run with a text on standard input.
fn data(desk: &Desk, arguments: &str, text: &str) -> Value {
    let ran = piped(desk, &format!("{arguments} --json"), text);
    ran.succeeds().json()["data"].take()
}

#[test]
fn a_table_on_standard_input_is_read_as_a_file_is() {
    let desk = desk();
    let table = five_columns(&["P1", "P2"], 3);
    desk.write("table.csv", &table);
    // What lies in the folder does not belong to standard input.
    desk.write("session.toml", "schema = \"stiffbench/session/9\"\n");
    let robot = "--robot hp-robot --fix beam.J";
    desk.write("alone/table.csv", &table);
    for command in ["stiffness", "fit", "diagnose", "export"] {
        let more = match command {
            "fit" => robot,
            "diagnose" => "--robot hp-robot",
            "export" => "--out tables-NAME",
            _ => "",
        };
        let of = |name: &str| format!("{command} {name} {more}").replace("-NAME", &name[..1]);
        let from_input = data(&desk, &of("-"), &table);
        let from_file = desk.data(&of("alone/table.csv"));
        for key in ["cells", "factors", "verdict", "rows"] {
            assert_eq!(from_input[key], from_file[key], "{command} {key}");
        }
    }
    let text = piped(&desk, "stiffness -", &table).succeeds().stdout;
    assert!(text.contains("standard input"), "{text}");
    let list = "pose,direction,stiffness_N_per_um\nP1,x,0.01\nP1,y,0.03\nP1,z,0.2\nP2,x,0.01\nP2,y,0.03\nP2,z,0.2\n";
    piped(&desk, "fit - --robot hp-robot", list).succeeds();
    let specimen = "force_N,displacement_um\n0,0\n10,5\n20,10\n30,15\n40,20\n50,25\n";
    let columns = "--force-column force_N --displacement-column displacement_um";
    piped(&desk, &format!("diagnose - --specimen {columns}"), specimen).succeeds();
    let error = piped(&desk, "stiffness - --json", "nonsense\n").exits_with(11);
    assert_output_contains(
        &error.json()["error"],
        &["standard input", "import FILE --out"],
    );
}

#[test]
fn an_import_keeps_what_came_from_standard_input() {
    let desk = desk();
    let table = five_columns(&["P1"], 2);
    piped(&desk, "import - --out session", &table).succeeds();
    assert_eq!(desk.read("session/raw/standard-input"), table);
    desk.run("stiffness session").succeeds();
}

#[test]
fn one_file_goes_to_standard_output() {
    let desk = desk_with_session();
    let report = "report session --no-diagnosis --out";
    desk.run(&format!("{report} page.html")).succeeds();
    let page = desk.run(&format!("{report} -")).succeeds().stdout;
    assert_eq!(page, desk.read("page.html"));
    let model = "model export --format csv --robot serial-arm";
    let table = desk.run(model).succeeds().stdout;
    assert_eq!(desk.run(&format!("{model} -o -")).succeeds().stdout, table);
    let figure = desk.run("plot robot --out -").succeeds().stdout;
    desk.run("plot robot --out robot.svg").succeeds();
    assert_eq!(figure, desk.read("robot.svg"));
    assert!(!desk.path("-").exists());
    // The object alone is on standard output, and says so.
    let object = desk.run(&format!("{report} - --json")).succeeds().json();
    let warnings = object["warnings"].to_string();
    assert!(warnings.contains("--out -"), "{warnings}");
}

#[test]
fn a_folder_cannot_be_standard_input_or_output() {
    let desk = desk();
    for arguments in [
        "session status -",
        "session resume - --emulated",
        "simulate -",
        "import table.csv --out -",
        "export table.csv --out -",
        "demo -o -",
        "map --out -",
        "man --out -",
    ] {
        let error = desk.refusal(arguments, 2, "stiffbench::usage");
        assert_output_contains(&error, &["cannot be a folder"]);
    }
    let error = desk.refusal(
        "robot new - --template serial",
        2,
        "stiffbench::usage::no_standard_output",
    );
    assert_output_contains(&error, &["name a file"]);
}
