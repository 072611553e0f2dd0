//! What tests of load cases share.

use serde_json::Value;

use crate::support::Json;

/// Springs about the axes of an arm of the size of the FANUC, rad/(N·m).
pub(super) const SPRINGS: [f64; 6] = [1.2e-6, 0.4e-6, 0.6e-6, 3e-6, 2.4e-6, 5e-6];

/// Errors of a laser tracker, alike in all components.
pub(super) const TRACKER: &str = "--reading-sd-um 10 --zero-sd-um 0 --run-slope-sd 0";

/// The names of the three displacements.
pub(super) const DISPLACEMENTS: [&str; 3] = [
    "displacement_x_um",
    "displacement_y_um",
    "displacement_z_um",
];

/// The names of the three forces.
pub(super) const FORCES: [&str; 3] = ["force_x_N", "force_y_N", "force_z_N"];

/// The ends of an interval; `None` if there is none.
pub(super) fn interval(value: &Value) -> Option<[f64; 2]> {
    let ends = value.as_array()?;
    Some([ends[0].number(), ends[1].number()])
}

/// Names of the findings of a diagnosis: of springs those of the parameters, else law and place.
pub(super) fn names(diagnosis: &Value) -> Vec<String> {
    diagnosis["findings"].list().iter().map(name).collect()
}

/// The name of a finding.
pub(super) fn name(finding: &Value) -> String {
    let place = &finding["place"];
    let word = |key: &str| place[key].as_str().unwrap_or_default();
    match finding["physics"].word() {
        "joint-tilt-compliance" => format!("joint.{}.{}", word("joint"), word("axis")),
        "tool-compliance" => format!("tool.{}", word("tool")),
        "base-compliance" => format!("base.r{}", word("axis")),
        law => format!("{law}@{place}"),
    }
}
