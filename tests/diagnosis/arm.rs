//! A plain arm on a bench: what is simulated on it, and what a diagnosis finds.

use std::collections::BTreeSet;
use std::ops::Range;

use serde_json::Value;
use tempfile::TempDir;

use stiffbench::analysis::{LoadedSession, ModelChoice, OpenSettings, check_data, resolve};
use stiffbench::physics::{Law, TestObject};

use crate::support::Json;
use crate::support::tables::Table;

/// Where a diagnosis begins.
pub(super) const MODEL: &str = "--robot serial-arm --factors unit";

/// Four poses; factors between 0.6 and 1.6; zeros and slopes of runs.
const BENCH: &str = "--poses P1,P2,P3,P4 --true-factor beam.A=1.221402758,beam.Iy=0.740818221,beam.Iz=1.568312185,beam.J=0.670320046 \
                     --zero-sd-um 2 --run-slope-sd 0.002";

/// Scatter of single readings.
const SCATTER: &str = "--reading-sd-um 1.2";

/// The readings of a session by a shipped procedure.
pub(super) fn session(procedure: &str, effects: &[&str], seed: u64) -> Table {
    session_of(&format!("{MODEL} {SCATTER}"), procedure, effects, seed)
}

/// The same with options of its own: for robot, scatter and step of the gauge.
pub(super) fn session_of(options: &str, procedure: &str, effects: &[&str], seed: u64) -> Table {
    let options = format!("{options} {BENCH} --procedure {procedure} --seed {seed}");
    Table::simulated(&options, effects)
}

/// The same on a robot that differs from the file of [`MODEL`].
pub(super) fn session_on(robot: &str, procedure: &str, seed: u64) -> Table {
    let desk = TempDir::new().unwrap();
    let file = desk.path().join("robot.toml");
    std::fs::write(&file, robot).unwrap();
    let model = format!("--robot {} --factors unit", file.display());
    session_of(&format!("{model} {SCATTER}"), procedure, &[], seed)
}

/// A diagnosis.
pub(super) fn diagnosis(table: &Table, options: &str) -> Value {
    table.data("diagnose", &format!("{MODEL} {options}"))
}

/// A diagnosis that looks at the data and then searches for nothing.
pub(super) fn screened(table: &Table) -> Value {
    let laws: BTreeSet<&str> = Law::searched_on(TestObject::Robot)
        .map(|law| law.name)
        .collect();
    let laws: Vec<&str> = laws.into_iter().collect();
    diagnosis(table, &format!("--without {}", laws.join(",")))
}

/// What of the data a diagnosis calls wrong.
pub(super) fn data_findings(diagnosis: &Value) -> &[Value] {
    diagnosis["data_findings"].list()
}

/// How many runs or cells, and how many readings, a diagnosis would call wrong before it searches: what [`screened`] names, without what
/// comes after it, so that many good sessions can be looked at.
pub(super) fn called_wrong(table: &Table) -> [usize; 2] {
    let desk = TempDir::new().unwrap();
    let file = desk.path().join("readings.csv");
    std::fs::write(&file, table.text()).unwrap();
    let session = LoadedSession::open(&file, &OpenSettings::default()).unwrap();
    let choice = ModelChoice {
        robot: Some("serial-arm".to_owned()),
        factors: Some("unit".to_owned()),
        ..ModelChoice::default()
    };
    let model = resolve(&choice, Some(&session)).unwrap();
    let found = check_data(&session.table, session.header.as_ref(), &model).unwrap();
    [found.bad_runs.len(), found.bad_readings.len()]
}

/// Multiplies the displacements of some rows.
pub(super) fn scaled(table: &Table, rows: Range<usize>, factor: f64) -> Table {
    let mut out = table.clone();
    for row in rows {
        out.change(row, "displacement_um", |read| factor * read);
    }
    out
}
