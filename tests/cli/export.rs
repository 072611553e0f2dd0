//! Tables for other programs hold the numbers of the session, with units and hashes, and overwrite nothing.

use std::collections::BTreeMap;
use std::process::Command;

use calamine::{Data, Reader, Xlsx, open_workbook};
use serde_json::Value;

use stiffbench::analysis::sha256;
use stiffbench_test_files::desk::Desk;
use stiffbench_test_files::text;

use super::{desk, desk_with_session, five_columns};
use crate::support::{Contains, Json};

fn package(desk: &Desk, folder: &str) -> Value {
    serde_json::from_str(&desk.read(&format!("{folder}/datapackage.json"))).unwrap()
}

/// Rows of a CSV file by the names of their columns.
fn rows(desk: &Desk, file: &str) -> Vec<BTreeMap<String, String>> {
    let mut reader = csv::Reader::from_path(desk.path(file)).unwrap();
    let rows: Result<Vec<_>, _> = reader.deserialize().collect();
    rows.unwrap()
}

/// Follows the schema of packages; hash, size, heads and types of every file are those described.
fn assert_is_package(desk: &Desk, folder: &str) {
    let package = package(desk, folder);
    let schema = serde_json::from_str(text("fixtures/export/datapackage.schema.json")).unwrap();
    let validator = jsonschema::validator_for(&schema).unwrap();
    let errors: Vec<String> = validator
        .iter_errors(&package)
        .map(|error| error.to_string())
        .collect();
    assert!(errors.is_empty(), "{errors:?}");
    for resource in package["resources"].list() {
        let path = format!("{folder}/{}", resource["path"].word());
        let content = desk.read(&path);
        assert_eq!(resource["bytes"], content.len());
        assert_eq!(resource["hash"], format!("sha256:{}", sha256(&content)));
        let fields = resource["schema"]["fields"].list();
        let names: Vec<&str> = fields.iter().map(|field| field["name"].word()).collect();
        assert_eq!(content.lines().next().unwrap(), names.join(","));
        for row in rows(desk, &path) {
            for field in fields {
                let name = field["name"].word();
                let value = &row[name];
                let is_good = value.is_empty()
                    || match field["type"].word() {
                        "integer" => value.parse::<i64>().is_ok(),
                        "number" => value.parse::<f64>().is_ok_and(f64::is_finite),
                        "datetime" => value.ends_with('Z'),
                        _ => true,
                    };
                assert!(is_good, "{path}, {name}: {value}");
                let has_unit = ["_N", "_um", "_s", "_degC", "_N_per_um", "_um_per_N"];
                let has_unit = has_unit.iter().any(|unit| name.ends_with(unit));
                assert_eq!(
                    has_unit || name.ends_with("_percent"),
                    field.get("unit").is_some(),
                    "{name}"
                );
            }
        }
    }
}

#[test]
fn csv_files_are_as_their_package_describes_them() {
    let desk = desk_with_session();
    let data = desk.data("export session --out tables");
    assert_is_package(&desk, "tables");
    let files = data["files"].list();
    let names = [
        "readings.csv",
        "stiffness.csv",
        "budget.csv",
        "loads.csv",
        "flags.csv",
        "datapackage.json",
    ];
    assert_eq!(files.len(), names.len());
    for (file, name) in files.iter().zip(names) {
        assert_eq!(file["path"], format!("tables/{name}"));
        assert_eq!(file["sha256"], sha256(desk.read(&format!("tables/{name}"))));
    }
    let about = &package(&desk, "tables")["stiffbench"];
    about["not_measured"].word().must_contain(&["simulated"]);
    assert_eq!(about["branches"], "loading");
}

#[test]
fn numbers_are_those_of_the_analysis() {
    let desk = desk_with_session();
    desk.run("export session --out tables").succeeds();
    let stiffness = desk.data("stiffness session");
    let cells = stiffness["cells"].list();
    let table = rows(&desk, "tables/stiffness.csv");
    assert_eq!(table.len(), cells.len());
    for (row, cell) in table.iter().zip(cells) {
        assert_eq!(cell["pose"], row["pose"].as_str());
        for (column, key) in [
            ("stiffness_N_per_um", "value"),
            ("u_N_per_um", "u"),
            ("expanded_U_N_per_um", "U"),
        ] {
            let number: f64 = row[column].parse().unwrap();
            assert_eq!(
                cell["stiffness_regression"][key].as_f64(),
                Some(number),
                "{column}"
            );
        }
    }
    let budget = rows(&desk, "tables/budget.csv");
    let repeatability = budget.iter().filter(|row| row["source"] == "repeatability");
    assert_eq!(repeatability.count(), cells.len());
    // Every reading is there, with its run.
    let readings = rows(&desk, "tables/readings.csv");
    assert_eq!(
        readings.len(),
        desk.read("session/readings.csv").lines().count() - 1
    );
    assert!(readings.iter().all(|row| !row["run"].is_empty()));
    // What was exported can be analysed again: readings as a session, stiffness as a list.
    let again = desk.data("stiffness tables/readings.csv");
    assert_eq!(
        again["cells"][0]["stiffness_regression"]["value"],
        cells[0]["stiffness_regression"]["value"]
    );
    desk.run("fit tables/stiffness.csv --robot hp-robot --train P1,P3")
        .succeeds();
}

#[test]
fn a_research_object_names_every_file_with_its_hash() {
    let desk = desk_with_session();
    desk.run("export session --out tables --ro-crate")
        .succeeds();
    let crated: Value = serde_json::from_str(&desk.read("tables/ro-crate-metadata.json")).unwrap();
    let graph = crated["@graph"].list();
    let of = |id: &str| graph.iter().find(|entity| entity["@id"] == id).unwrap();
    assert_eq!(
        of("ro-crate-metadata.json")["conformsTo"]["@id"],
        "https://w3id.org/ro/crate/1.1"
    );
    let parts = of("./")["hasPart"].list();
    assert_eq!(
        parts.len(),
        std::fs::read_dir(desk.path("tables")).unwrap().count() - 1
    );
    for part in parts {
        let name = part["@id"].word();
        let bytes = std::fs::read(desk.path(&format!("tables/{name}"))).unwrap();
        if let Some(hash) = of(name)["sha256"].as_str() {
            assert_eq!(hash, sha256(bytes), "{name}");
        } else {
            assert_eq!(name, "datapackage.json");
        }
    }
}

#[test]
fn a_spreadsheet_holds_the_same_and_always_the_same_bytes() {
    let desk = desk_with_session();
    desk.run("export session --out tables").succeeds();
    desk.run("export session --out one --format xlsx")
        .succeeds();
    // The directory of a ZIP file has times in steps of two seconds.
    std::thread::sleep(std::time::Duration::from_millis(2100));
    desk.run("export session --out two --format xlsx")
        .succeeds();
    let bytes = |name: &str| std::fs::read(desk.path(name)).unwrap();
    assert_eq!(bytes("one/tables.xlsx"), bytes("two/tables.xlsx"));
    // CSV and its schema come with it.
    for name in ["readings.csv", "datapackage.json"] {
        assert_eq!(
            bytes(&format!("one/{name}")),
            bytes(&format!("tables/{name}"))
        );
    }
    let mut book: Xlsx<_> = open_workbook(desk.path("one/tables.xlsx")).unwrap();
    assert_eq!(
        book.sheet_names(),
        ["readings", "stiffness", "budget", "loads", "flags", "about"]
    );
    for name in ["readings", "stiffness"] {
        let sheet = book.worksheet_range(name).unwrap();
        let table = rows(&desk, &format!("tables/{name}.csv"));
        let heads: Vec<String> = sheet
            .rows()
            .next()
            .unwrap()
            .iter()
            .map(ToString::to_string)
            .collect();
        assert_eq!(sheet.height(), table.len() + 1);
        for (cells, row) in sheet.rows().skip(1).zip(&table) {
            for (head, cell) in heads.iter().zip(cells) {
                match cell {
                    Data::Empty => assert_eq!(row[head], ""),
                    Data::Float(number) => assert_eq!(row[head].parse(), Ok(*number), "{head}"),
                    other => assert_eq!(row[head], other.to_string(), "{head}"),
                }
            }
        }
    }
    let about = book.worksheet_range("about").unwrap();
    let words: Vec<String> = about.rows().flatten().map(ToString::to_string).collect();
    assert!(words.iter().any(|word| word.contains("simulated")));
    assert!(words.contains(&"N/um".to_owned()));
}

#[test]
fn files_of_few_columns_and_load_cases_are_exported() {
    let desk = desk();
    desk.write("readings.csv", &five_columns(&["P1", "P2"], 3));
    desk.run("export readings.csv --out few").succeeds();
    assert_is_package(&desk, "few");
    assert!(package(&desk, "few").get("created").is_none());
    desk.run("export readings.csv --out sheets --format xlsx")
        .succeeds();
    desk.write(
        "cases.csv",
        "pose,force_x_N,displacement_x_um\nP1,-10,-20\nP2,-10,-21.5\n",
    );
    desk.run("export cases.csv --out cases").succeeds();
    assert_is_package(&desk, "cases");
    assert_eq!(
        rows(&desk, "cases/load-cases.csv")[1]["displacement_x_um"],
        "-21.5"
    );
}

/// The snippets of the page and of the command, run as they stand; without pandas they are skipped with a note.
#[test]
fn the_snippets_run() {
    let desk = desk();
    desk.run("simulate my-session --seed 4").succeeds();
    let exported = desk.run("export my-session --out my-tables").succeeds();
    let (_, printed) = exported.stdout.split_once("In Python:\n").unwrap();
    let printed: String = printed
        .lines()
        .map(|line| line.trim_start().to_owned() + "\n")
        .collect();
    printed.must_contain(&["stiffness = pd.read_csv(\"my-tables/stiffness.csv\")"]);
    let page = text("docs/export.md");
    let (_, of_page) = page.split_once("```python\n").unwrap();
    let (of_page, _) = of_page.split_once("```").unwrap();
    let python = |code: &str| {
        Command::new("python3")
            .current_dir(&desk.folder)
            .args(["-c", code])
            .output()
    };
    if !python("import pandas").is_ok_and(|run| run.status.success()) {
        eprintln!("skipped: python3 with pandas was not found");
        return;
    }
    for code in [of_page.to_owned(), printed + "print(readings, stiffness)"] {
        let run = python(&code).unwrap();
        let shown = String::from_utf8_lossy(&run.stdout);
        assert!(
            run.status.success(),
            "{}",
            String::from_utf8_lossy(&run.stderr)
        );
        shown.must_contain(&["P1"]);
    }
}
