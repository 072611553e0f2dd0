//! `--strict`: findings become exit codes, and without it they do not.

use super::{desk, five_columns};
use crate::support::{Contains, Json};

#[test]
fn overdue_calibration_exits_with_12() {
    let desk = desk();
    desk.write("session/readings.csv", &five_columns(&["P1", "P2"], 5));
    let header = |due: &str| {
        format!(
            "schema = \"stiffbench/session/1\"\nrobot = \"hp-robot\"\n[instruments.force]\nmodel = \"spring\"\nresolution_N = 0.1\ncalibrated = 2001-01-01\ndue = {due}\n"
        )
    };
    desk.write("session/session.toml", &header("2002-01-01"));
    for subcommand in [
        "stiffness session",
        "fit session",
        "compare session session",
    ] {
        let ran = desk.run(subcommand).succeeds();
        ran.stderr
            .must_contain(&["calibration overdue: force gauge (due 2002-01-01)"]);
        desk.run(&format!("{subcommand} --strict")).exits_with(12);
    }
    // On the page and in the figure too.
    let page = desk.run("stiffness session --quiet").succeeds().stdout;
    let mark = "CALIBRATION OVERDUE: force gauge (due 2002-01-01)";
    assert!(page.contains(mark), "{page}");
    desk.run("fit session --figures figures").succeeds();
    assert!(desk.read("figures/residuals.svg").contains(mark));
    desk.run("export session --out tables").succeeds();
    for table in ["readings", "stiffness", "budget", "loads"] {
        let text = desk.read(&format!("tables/{table}.csv"));
        let mut lines = text.lines();
        assert!(lines.next().unwrap().ends_with(",calibration_overdue"));
        assert!(
            lines.all(|line| line.ends_with(",force gauge (due 2002-01-01)")),
            "{text}"
        );
    }
    let object = desk
        .run("stiffness session --strict --json")
        .exits_with(12)
        .json();
    assert_eq!(object["error"]["code"], "stiffbench::calibration::overdue");
    // What is worked out from the fit repeats its warning.
    let fit = desk.run("fit session --json").succeeds();
    desk.write("fit.json", &fit.stdout);
    for command in [
        "robot map --mechanisms F --samples 9 --fit fit.json",
        "robot export --format csv --fit fit.json",
    ] {
        let ran = desk.run(command).succeeds();
        let repeated = "fit.json: calibration overdue: force gauge (due 2002-01-01)";
        assert!(ran.stderr.contains(repeated), "{}", ran.stderr);
    }
    desk.write("session/session.toml", &header("9000-01-01"));
    desk.run("stiffness session --strict").succeeds();
}

#[test]
fn a_factor_that_the_data_do_not_determine_exits_with_41() {
    let desk = desk();
    let open = |fit: &serde_json::Value| {
        let factors = fit["factors"]["beam"].as_object().unwrap();
        factors
            .values()
            .filter(|factor| !["free", "fixed"].contains(&factor["status"].word()))
            .count()
    };
    let arguments = "fit paper-experiment --train P1,P3";
    assert!(open(&desk.data(arguments)) > 0);
    desk.run(&format!("{arguments} --strict")).exits_with(41);
    desk.run("simulate session --seed 4").succeeds();
    let arguments = "fit session --parameter beam.J=fixed";
    assert_eq!(open(&desk.data(arguments)), 0);
    desk.run(&format!("{arguments} --strict")).succeeds();
}
