//! Writes a table of load cases.

use std::fmt::Write as _;

use super::table::{LoadCaseTable, VectorQuantity};
use crate::readings::{escape_formula, write_decimal};
use stiffbench_units_and_text::test_point::Direction;

/// The table as text: `pose`, the joints, `repeat`, `axes`, the load, what was read, and `origin` if there is one.
///
/// Moments and rotations of which no case has a component have no columns; nor have forces and displacements beside positions. Values are written to 15 digits, so that they are read back as they were.
#[must_use]
pub fn write_load_cases(table: &LoadCaseTable) -> String {
    let used: Vec<VectorQuantity> = VectorQuantity::ALL
        .into_iter()
        .filter(|quantity| {
            let always = [VectorQuantity::Force, VectorQuantity::Displacement];
            (always.contains(quantity) && !table.has_positions())
                || table
                    .cases
                    .iter()
                    .any(|case| (0..3).any(|axis| component(case, *quantity, axis).is_some()))
        })
        .collect();
    let mut text = "pose".to_owned();
    for joint in &table.joints {
        let _ = write!(text, ",{}", joint.name());
    }
    text.push_str(",repeat,axes");
    for quantity in &used {
        for axis in Direction::ALL {
            let _ = write!(text, ",{}", quantity.column(axis));
        }
    }
    let origin = table.origin.as_ref().map(|origin| csv_field(origin));
    if origin.is_some() {
        text.push_str(",origin");
    }
    text.push('\n');
    let mut digits = String::new();
    for case in &table.cases {
        text.push_str(&csv_field(case.pose.as_str()));
        for (joint, value) in table.joints.iter().zip(&case.joints) {
            let _ = write!(text, ",{}", joint.unit.written(*value));
        }
        let _ = write!(text, ",{},{}", case.repeat, case.axes);
        for quantity in &used {
            for axis in 0..3 {
                text.push(',');
                let value = component(case, *quantity, axis);
                let value = value.or(quantity.is_load().then_some(0.0));
                if let Some(value) = value {
                    write_decimal(value, quantity.shift(), &mut digits);
                    text.push_str(&digits);
                }
            }
        }
        if let Some(origin) = &origin {
            let _ = write!(text, ",{origin}");
        }
        text.push('\n');
    }
    text
}

/// A component that is not zero, if a load, or was read.
fn component(case: &super::table::LoadCase, quantity: VectorQuantity, axis: usize) -> Option<f64> {
    let of_load = |value: f64| (value != 0.0).then_some(value);
    match quantity {
        VectorQuantity::Force => of_load(case.force_n[axis]),
        VectorQuantity::Moment => of_load(case.moment_nm[axis]),
        VectorQuantity::Displacement => case.displacement_m[axis],
        VectorQuantity::Rotation => case.rotation_rad[axis],
        VectorQuantity::Position => case.position_m[axis],
    }
}

/// A text as a field.
fn csv_field(text: &str) -> String {
    let text = escape_formula(text);
    if text.contains([',', '"', '\n', ';']) {
        format!("\"{}\"", text.replace('"', "\"\""))
    } else {
        text.into_owned()
    }
}
