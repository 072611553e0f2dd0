//! Tables that other programs made, in `fixtures`.

use std::collections::BTreeMap;

use stiffbench_beams::robot::{Pose, Robot};
use stiffbench_beams::structure::Compliance6;

/// A row by the names of its columns.
pub(crate) type Row = BTreeMap<String, String>;

/// The rows of a table, from `fixtures`.
pub(crate) fn rows(file: &str) -> Vec<Row> {
    let fixtures = stiffbench_test_files::repository().join("fixtures");
    let mut reader = csv::Reader::from_path(fixtures.join(file)).unwrap();
    reader.deserialize().collect::<Result<_, _>>().unwrap()
}

pub(crate) fn number(row: &Row, key: &str) -> f64 {
    let number = row[key].parse();
    number.unwrap_or_else(|_| panic!("{key} in {row:?}"))
}

pub(crate) fn numbers<const N: usize>(row: &Row, keys: [&str; N]) -> [f64; N] {
    keys.map(|key| number(row, key))
}

/// The pose whose angles are columns.
pub(crate) fn pose_of(row: &Row, robot: &Robot) -> Pose {
    let angle = |name: &String| number(row, &format!("{name}_deg"));
    let variables = robot.variables.iter();
    Pose {
        angles_deg: variables.map(|variable| angle(&variable.name)).collect(),
    }
}

/// All 36 entries of a compliance by OpenSees.
pub(crate) fn compliance_of(row: &Row) -> Compliance6 {
    let displacements = ["ux", "uy", "uz", "rx", "ry", "rz"];
    let forces = ["Fx", "Fy", "Fz", "Mx", "My", "Mz"];
    Compliance6(displacements.map(|d| forces.map(|f| number(row, &format!("c_{d}_{f}")))))
}
