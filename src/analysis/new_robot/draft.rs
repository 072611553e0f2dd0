//! The text of a robot file, written to be read and changed by hand.

use std::fmt::Write;

use crate::robot::format2::SCHEMA;
use crate::source_text::SourceText;
use crate::toml_text::quoted;

/// Digits that are kept of a converted number: more than any maker states, few enough to hide the rounding of the conversion.
const DIGITS: i32 = 14;

/// Degrees, mm or parts of a direction by which a converted number may be moved to a shorter one.
const NEGLIGIBLE: f64 = 5e-10;

/// A robot file in the making.
#[derive(Debug, Default)]
pub(super) struct Draft {
    pub(super) name: String,
    /// Where it comes from.
    pub(super) source: String,
    pub(super) dh: Option<&'static str>,
    /// Joints of the chain from base to tool.
    pub(super) chain: Vec<DraftRow>,
    /// Joints that carry only masses.
    pub(super) branches: Vec<DraftRow>,
    pub(super) variables: Vec<DraftRow>,
    pub(super) tool: Vec<(&'static str, String)>,
    pub(super) masses: Vec<DraftRow>,
    pub(super) poses: Vec<DraftRow>,
}

/// A name with its keys and values, as TOML.
#[derive(Debug, Clone, Default)]
pub(super) struct DraftRow {
    pub(super) name: String,
    pub(super) keys: Vec<(String, String)>,
    pub(super) comment: Option<String>,
}

impl DraftRow {
    pub(super) fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            ..Self::default()
        }
    }

    pub(super) fn set(&mut self, key: impl Into<String>, value: impl Into<String>) {
        self.keys.push((key.into(), value.into()));
    }
}

/// Where a robot file comes from: the name of the file without its folder, and the option that read it.
pub(super) fn made_from(source: &SourceText, option: &str) -> String {
    let name = source.name.rsplit(['/', '\\']).next();
    let name = name.unwrap_or_default();
    format!("made from {name} by `stiffbench robot new --{option}`")
}

/// A number rounded to what is worth writing.
pub(super) fn number(value: f64) -> String {
    let rounded = format!("{:.*e}", DIGITS as usize - 1, value);
    let rounded: f64 = rounded.parse().unwrap_or(value);
    // A right angle that a file states with eleven digits is one.
    let short = (1e4 * rounded).round() / 1e4;
    let rounded = if (rounded - short).abs() < NEGLIGIBLE {
        short
    } else {
        rounded
    };
    // A zero has no sign, and what is below any tolerance of a robot is zero.
    if rounded.abs() < 1e-12 {
        "0".to_owned()
    } else {
        rounded.to_string()
    }
}

/// Three numbers.
pub(super) fn three(values: [f64; 3]) -> String {
    format!("[{}]", values.map(number).join(", "))
}

/// A key, in quotes where TOML needs them.
pub(super) fn key(name: &str) -> String {
    let is_bare = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    if !name.is_empty() && name.chars().all(is_bare) {
        name.to_owned()
    } else {
        quoted(name)
    }
}

impl Draft {
    pub(super) fn text(&self) -> String {
        let mut text = format!(
            "schema = {}\nname = {}\nsource = {}\nup = \"z\"\n",
            quoted(SCHEMA),
            quoted(&self.name),
            quoted(&self.source)
        );
        if let Some(convention) = self.dh {
            let _ = writeln!(text, "dh = \"{convention}\"");
        }
        text.push_str(
            "\n# Joints from the base to the tool. A spring that is `free` is found by `fit`; one that is known has `stiffness_Nm_per_rad`.\n\
             # Without `link` the body behind a joint is rigid; `link = \"tube 120x6 aluminium\"` makes a beam of it.\n[joints]\n",
        );
        rows(&mut text, &self.chain);
        if !self.branches.is_empty() {
            text.push_str("# Side branches: no load passes through them, their masses move with these joints.\n");
            rows(&mut text, &self.branches);
        }
        table(&mut text, "variables", &self.variables);
        if !self.tool.is_empty() {
            text.push_str("\n# Loads act at the tool centre, and displacements are those of this point.\n[tool]\n");
            for (key, value) in &self.tool {
                let _ = writeln!(text, "{key} = {value}");
            }
        }
        if self.masses.is_empty() {
            text.push_str("\n# Masses are needed for own weight only: [masses] NAME = { mass_kg = 12, on = \"BODY\", at_mm = [0, 0, 100] }\n");
        }
        table(&mut text, "masses", &self.masses);
        text.push_str("\n# Replace these by the poses that you measure in.");
        table(&mut text, "poses", &self.poses);
        text
    }
}

fn table(text: &mut String, name: &str, entries: &[DraftRow]) {
    if !entries.is_empty() {
        let _ = writeln!(text, "\n[{name}]");
        rows(text, entries);
    }
}

fn rows(text: &mut String, entries: &[DraftRow]) {
    for row in entries {
        let keys = row
            .keys
            .iter()
            .map(|(key, value)| format!("{key} = {value}"));
        let keys = keys.collect::<Vec<_>>().join(", ");
        let comment = row.comment.as_ref();
        let comment = comment.map_or_else(String::new, |comment| format!("  # {comment}"));
        let _ = writeln!(text, "{} = {{ {keys} }}{comment}", key(&row.name));
    }
}

/// Four poses within limits, degrees or m: spread about the middle of each range, none with a stretched arm for long ranges.
pub(super) fn poses_within(variables: &[(String, bool, [f64; 2])]) -> Vec<DraftRow> {
    let pose = |index: usize| {
        let mut row = DraftRow::new(format!("P{}", index + 1));
        for (place, (name, slides, [low, high])) in variables.iter().enumerate() {
            let middle = 0.5 * (low + high);
            // Sines that no two joints share; 40 degrees or 0.3 m at most, in whole degrees or centimetres.
            let spread = 0.35 * (high - low);
            let spread = spread.min(if *slides { 0.3 } else { 40.0 });
            let phase = 1.3 + 2.4 * index as f64 + 1.7 * place as f64;
            let value = middle + spread * phase.sin();
            let (step, unit) = if *slides { (0.01, "m") } else { (1.0, "deg") };
            let rounded = (value / step).round() * step;
            let value = if (*low..=*high).contains(&rounded) {
                rounded
            } else {
                value
            };
            row.set(key(&format!("{name}_{unit}")), number(value));
        }
        row
    };
    (0..4).map(pose).collect()
}
