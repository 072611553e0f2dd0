//! The plan as a commented procedure file.

use std::fmt::Write as _;

use stiffbench_units_and_text::toml_text::quoted;
use toml::Value;

use super::plan::Procedure;

/// Column in which comments start, if the line leaves room.
const COMMENT_COLUMN: usize = 34;

impl Procedure {
    /// The plan as a complete procedure file with comments; [`Procedure::parse`] gives the same plan back.
    ///
    /// Numbers are written with 15 significant digits. Poses that are left to the robot stay out.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut text = String::new();
        let mut tables = Vec::new();
        for (key, value) in self.to_record().to_table() {
            match value {
                Value::Table(table) => tables.push((key, table)),
                _ if key == "poses" && self.poses.is_none() => {
                    text.push_str("# poses: every named pose of the robot\n");
                }
                value => put_line(&mut text, "", &key, &value),
            }
        }
        for (name, table) in tables {
            // Writing to a String cannot fail.
            let _ = write!(text, "\n[{name}]\n");
            let stem = format!("{name}.");
            for (key, value) in table {
                let written = if ["settle", "limits", "answer_within"].contains(&name.as_str()) {
                    key.clone()
                } else {
                    quoted(&key)
                };
                put_line(&mut text, &stem, &written, &value);
            }
        }
        text
    }
}

/// A key with its value and, behind it, what it means.
fn put_line(text: &mut String, table: &str, key: &str, value: &Value) {
    let line = format!("{key} = {value}");
    let comment = comment(&format!("{table}{key}"));
    let _ = if comment.is_empty() {
        writeln!(text, "{line}")
    } else {
        writeln!(text, "{line:<COMMENT_COLUMN$}  # {comment}")
    };
}

/// What a key means, in one line.
fn comment(key: &str) -> &'static str {
    match key {
        "poses" => "named in the robot file, in the order of measurement",
        "specimens" => "which may be measured",
        "directions" => {
            "x, y, z of the base; of the paper's robots x is lateral, y vertical, z radial"
        }
        "displacement_axes" => "base axes along which displacement gauges stand",
        "loads_N" => "signed, along the positive axis, in the order of loading",
        "branches" => "with \"unloading\" the loads are taken off in the same steps",
        "repeats" => "applications of the sequence (sweep) or of each load (at-load)",
        "repeat_order" => "\"sweep\" or \"at-load\"",
        "load_order" => {
            "\"ascending\" (as listed) or \"shuffled\" (anew for each run, with the seed)"
        }
        "seed" => "of a shuffled order",
        "zero" => {
            "the gauge is zeroed once per pose and direction (\"cell\") or before each \"run\""
        }
        "preload_N" => "contact force before zeroing",
        "holds_s" => "extra readings after these seconds under the largest load",
        "settle.force_tolerance_N" => "largest difference of force and target",
        "settle.dwell_s" => "how long the gauges are watched before a reading counts",
        "settle.spread_um" => "largest spread of the displacement meanwhile",
        "limits.force_warn_N" => "beyond this force a reading is flagged",
        "limits.force_hard_N" => "beyond this force a reading is asked about",
        "limits.displacement_warn_um" => "beyond this displacement a reading is flagged",
        "limits.displacement_hard_um" => "beyond this displacement a reading is asked about",
        "settle.slope_um_per_s" => "largest slope of the displacement meanwhile",
        _ => "",
    }
}
