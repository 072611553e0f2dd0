//! A Denavit-Hartenberg table, TOML or CSV, as a robot file.

use serde::Deserialize;

use crate::robot::format2::file::{DhConvention, JointKind};
use crate::robot::format2::measure::{AngleOf, InUnit, LengthOf, TravelOf, units};
use crate::source_text::SourceText;
use crate::toml_text::{DocumentStep, TomlDocument};

use DocumentStep::{Index, Key};

use super::dh_csv::csv_as_toml;
use super::draft::{Draft, DraftRow, key, made_from, number, poses_within, three};
use super::{ImportError, ImportProblem, NewRobot};

/// How a controller counts the angles of a six-axis arm.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Controller {
    /// A1 to A6; A1, A4 and A6 count against the axes of the table.
    Kuka,
    /// J1 to J6; J3 is stated against the horizontal, so that it moves with J2, and J4 to J6 count against the axes of the table.
    Fanuc,
}

impl Controller {
    /// Names of the variables, and the angle of each row as combination of them.
    fn angles(self) -> [(&'static str, &'static str); 6] {
        match self {
            Self::Kuka => [
                ("A1", "{ A1 = -1 }"),
                ("A2", "{ A2 = 1 }"),
                ("A3", "{ A3 = 1 }"),
                ("A4", "{ A4 = -1 }"),
                ("A5", "{ A5 = 1 }"),
                ("A6", "{ A6 = -1 }"),
            ],
            Self::Fanuc => [
                ("J1", "{ J1 = 1 }"),
                ("J2", "{ J2 = 1 }"),
                ("J3", "{ J2 = -1, J3 = -1 }"),
                ("J4", "{ J4 = -1 }"),
                ("J5", "{ J5 = -1 }"),
                ("J6", "{ J6 = -1 }"),
            ],
        }
    }
}

/// What a table does not state itself.
#[derive(Debug, Clone, Default)]
pub struct DhSettings {
    /// The convention, of a table that names none.
    pub convention: Option<DhConvention>,
    /// How the controller counts, of rows without `angle`.
    pub controller: Option<Controller>,
}

/// The table as TOML.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct DhTable {
    name: Option<String>,
    convention: Option<DhConvention>,
    rows: Vec<DhRow>,
    tool: Option<Vec<InUnit<LengthOf>>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DhRow {
    joint: Option<String>,
    #[serde(default)]
    kind: JointKind,
    alpha: Option<InUnit<AngleOf>>,
    a: Option<InUnit<LengthOf>>,
    theta: Option<InUnit<AngleOf>>,
    d: Option<InUnit<LengthOf>>,
    #[serde(default)]
    angle: Option<indexmap::IndexMap<String, InUnit<TravelOf>>>,
    min: Option<InUnit<TravelOf>>,
    max: Option<InUnit<TravelOf>>,
}

/// A robot file from a Denavit-Hartenberg table.
///
/// A CSV table has the columns `joint`, `kind`, `alpha_deg`, `a_mm`, `theta_deg`, `d_mm`, `angle`, `min_deg`, `max_deg`, of which only those of
/// the row itself are needed, in other units too and with these in brackets (`a [mm]`); a cell of `angle` is written `J2=-1 J3=-1`. Fields are
/// delimited by commas, semicolons or tabs; with semicolons and tabs a number may have a decimal comma. A TOML table has the same keys in `rows`.
///
/// # Errors
/// [`ImportError`] at the line that cannot be used.
pub fn robot_from_dh(source: &SourceText, settings: &DhSettings) -> Result<NewRobot, ImportError> {
    let is_csv = source.name.to_lowercase().ends_with(".csv");
    let rewritten;
    let source = if is_csv {
        rewritten = csv_as_toml(source)?;
        &rewritten
    } else {
        source
    };
    let document = TomlDocument::parse_with_units(source, &units()).map_err(ImportError::from)?;
    let table: DhTable = document.types().map_err(ImportError::from)?;
    let reader = DhReader {
        source,
        document: &document,
    };
    let mut made = reader.robot(&table, settings)?;
    made.notes.splice(0..0, notes_on_units(&table.rows));
    Ok(made)
}

/// Angles of a table in radians stay within a whole turn.
const WHOLE_TURN_RAD: f64 = std::f64::consts::TAU;

/// Radians of right angles and their halves are written with three decimals at least.
const ROUNDED_RAD: f64 = 1e-3;

/// Which units were taken where the table states none, and whether angles look like radians.
fn notes_on_units(rows: &[DhRow]) -> Vec<String> {
    fn numbers<K>(rows: &[DhRow], of: impl Fn(&DhRow) -> Option<&InUnit<K>>) -> Vec<f64> {
        let without_unit = rows.iter().filter_map(of).filter(|one| one.kind.is_none());
        without_unit.map(InUnit::number).collect()
    }
    let of = |key: &'static str, values: Vec<f64>| (!values.is_empty()).then_some((key, values));
    let named = |columns: &[(&str, Vec<f64>)]| {
        let names = columns.iter().map(|(key, _)| format!("`{key}`"));
        names.collect::<Vec<_>>().join(" and ")
    };
    let turning = |row: &DhRow| row.kind != JointKind::Sliding;
    let turns = rows.iter().any(turning);
    let slides = !rows.iter().all(turning);
    let travels = match (turns, slides) {
        (true, true) => "degrees, of sliding joints m",
        (false, true) => "m",
        _ => "degrees",
    };
    let columns = |of_two: [Option<(&'static str, Vec<f64>)>; 2]| -> Vec<_> {
        of_two.into_iter().flatten().collect()
    };
    let lengths = columns([
        of("a", numbers(rows, |row| row.a.as_ref())),
        of("d", numbers(rows, |row| row.d.as_ref())),
    ]);
    let angles = columns([
        of("alpha", numbers(rows, |row| row.alpha.as_ref())),
        of("theta", numbers(rows, |row| row.theta.as_ref())),
    ]);
    let limits = columns([
        of("min", numbers(rows, |row| row.min.as_ref())),
        of("max", numbers(rows, |row| row.max.as_ref())),
    ]);
    let groups = [("m", &lengths), ("degrees", &angles), (travels, &limits)];
    let groups = groups
        .into_iter()
        .filter(|(_, columns)| !columns.is_empty());
    let mut notes: Vec<String> = groups
        .map(|(unit, columns)| {
            let (key, _) = columns[0];
            let example = if unit == "m" { "mm" } else { "rad" };
            format!(
                "no unit is stated for {}: taken as {unit}; a name states another one, for example {key}_{example}",
                named(columns)
            )
        })
        .collect();
    for columns in [(true, &angles), (!slides, &limits)] {
        let (true, columns) = columns else { continue };
        if let Some(angle) = radians(columns) {
            let keys = columns.iter().map(|(key, _)| format!("{key}_rad"));
            notes.push(format!(
                "{} look like radians (first {angle}) and were taken as degrees: if they are radians, name them {}",
                named(columns),
                keys.collect::<Vec<_>>().join(" and ")
            ));
        }
    }
    notes
}

/// The first angle that is a multiple of an eighth of a turn in radians, where all are within a whole turn in radians.
fn radians(columns: &[(&str, Vec<f64>)]) -> Option<f64> {
    const EIGHTH: f64 = std::f64::consts::FRAC_PI_4;
    let angles = || columns.iter().flat_map(|(_, values)| values).copied();
    let is_multiple = |angle: &f64| {
        let nearest = (angle / EIGHTH).round();
        nearest != 0.0 && (angle - nearest * EIGHTH).abs() < ROUNDED_RAD
    };
    let within = angles().all(|angle| angle.abs() < WHOLE_TURN_RAD + ROUNDED_RAD);
    angles().find(is_multiple).filter(|_| within)
}

struct DhReader<'a> {
    source: &'a SourceText,
    document: &'a TomlDocument<'a>,
}

impl DhReader<'_> {
    fn error(
        &self,
        path: &[DocumentStep<'_>],
        message: impl Into<String>,
        help: &str,
    ) -> ImportError {
        let problem = ImportProblem::new(message, help);
        ImportError::new(self.source, self.document.value_span(path), problem)
    }

    fn robot(&self, table: &DhTable, settings: &DhSettings) -> Result<NewRobot, ImportError> {
        let Some(convention) = table.convention.or(settings.convention) else {
            let message = "the table does not state its convention";
            return Err(self.error(
                &[],
                message,
                "add --convention standard or --convention modified (Craig)",
            ));
        };
        if table.rows.is_empty() {
            return Err(self.error(
                &[Key("rows")],
                "the table has no rows",
                "add a row for each joint",
            ));
        }
        let angles = match settings.controller {
            Some(controller) if table.rows.len() == 6 => Some(controller.angles()),
            Some(_) => {
                let message = format!("the table has {} rows", table.rows.len());
                return Err(self.error(
                    &[Key("rows")],
                    message,
                    "--controller is for arms with six axes; write `angle` in the rows",
                ));
            }
            None => None,
        };
        let mut draft = Draft {
            name: table.name.clone().unwrap_or_else(|| "arm".to_owned()),
            source: made_from(self.source, "dh"),
            dh: Some(match convention {
                DhConvention::Standard => "standard",
                DhConvention::Modified => "modified",
            }),
            ..Draft::default()
        };
        let mut rows = DhRows {
            reader: self,
            draft: &mut draft,
            notes: Vec::new(),
            ranges: Vec::new(),
        };
        for (place, row) in table.rows.iter().enumerate() {
            rows.write(place, row, angles.map(|angles| angles[place]))?;
        }
        let (notes, ranges) = (rows.notes, rows.ranges);
        let tool = table.tool.as_deref().unwrap_or(&[]);
        let mut centre = [0.0; 3];
        if !tool.is_empty() && tool.len() != 3 {
            return Err(self.error(
                &[Key("tool")],
                "the tool centre has three coordinates",
                "tool_mm = [0, 0, 100]",
            ));
        }
        for (place, (value, given)) in centre.iter_mut().zip(tool).enumerate() {
            *value = 1e3 * self.number(Some(given), &[Key("tool"), Index(place)])?;
        }
        draft.tool.push(("at_mm", three(centre)));
        draft.poses = poses_within(&ranges);
        Ok(NewRobot {
            text: draft.text(),
            notes,
        })
    }

    /// A number, zero where it is not given.
    fn number<K>(
        &self,
        measured: Option<&InUnit<K>>,
        path: &[DocumentStep<'_>],
    ) -> Result<f64, ImportError> {
        let Some(measured) = measured else {
            return Ok(0.0);
        };
        let value = measured.number();
        if value.abs() < 1e9 {
            return Ok(value);
        }
        Err(self.error(
            path,
            "this is not a finite number",
            "a table holds numbers; units are part of the key, for example a_mm",
        ))
    }
}

/// The rows of a file in the making.
struct DhRows<'r, 'd> {
    reader: &'r DhReader<'d>,
    draft: &'r mut Draft,
    notes: Vec<String>,
    /// Variables with their ranges.
    ranges: Vec<(String, bool, [f64; 2])>,
}

impl DhRows<'_, '_> {
    /// One joint; `preset` is the variable and the angle of the controller.
    fn write(
        &mut self,
        place: usize,
        row: &DhRow,
        preset: Option<(&str, &str)>,
    ) -> Result<(), ImportError> {
        let default = preset.map_or_else(|| format!("J{}", place + 1), |(name, _)| name.to_owned());
        let name = row.joint.clone().unwrap_or(default);
        let mut written = DraftRow::new(&name);
        let slides = row.kind == JointKind::Sliding;
        if slides {
            written.set("kind", "\"sliding\"");
        }
        let at = |key| [Key("rows"), Index(place), Key(key)];
        let reader = self.reader;
        let mm = |value: f64| number(1e3 * value);
        let alpha = reader.number(row.alpha.as_ref(), &at("alpha"))?;
        written.set("alpha_deg", number(alpha));
        written.set("a_mm", mm(reader.number(row.a.as_ref(), &at("a"))?));
        let theta = reader.number(row.theta.as_ref(), &at("theta"))?;
        written.set("theta_deg", number(theta));
        written.set("d_mm", mm(reader.number(row.d.as_ref(), &at("d"))?));
        let angle = match &row.angle {
            Some(terms) => {
                let mut parts = Vec::new();
                for (variable, coefficient) in terms {
                    let value = reader.number(Some(coefficient), &at("angle"))?;
                    parts.push(format!("{} = {}", key(variable), number(value)));
                }
                Some(format!("{{ {} }}", parts.join(", ")))
            }
            None => preset.map(|(_, angle)| angle.to_owned()),
        };
        // The variable of this row is its own, or the last that its angle names.
        let variable = match &row.angle {
            Some(terms) => terms.keys().rfind(|name| *name != "offset").cloned(),
            None => Some(preset.map_or_else(|| name.clone(), |(variable, _)| variable.to_owned())),
        };
        let limits = match (&row.min, &row.max) {
            (Some(min), Some(max)) => Some([
                reader.number(Some(min), &at("min"))?,
                reader.number(Some(max), &at("max"))?,
            ]),
            _ => None,
        };
        let default = if slides { 1.0 } else { 180.0 };
        let range = limits.unwrap_or([-default, default]);
        if limits.is_none() {
            let unit = if slides { "m" } else { "degrees" };
            self.notes.push(format!(
                "joint `{name}` has no limits: -{default} to {default} {unit} were taken"
            ));
        }
        if let Some(angle) = angle {
            written.set("angle", angle);
        }
        if let Some(variable) = variable
            && self.ranges.iter().all(|(known, ..)| *known != variable)
        {
            let (unit, scale) = if slides { ("mm", 1e3) } else { ("deg", 1.0) };
            let bounds = [("min", range[0]), ("max", range[1])];
            let bounds =
                bounds.map(|(key, bound)| (format!("{key}_{unit}"), number(scale * bound)));
            if variable == name {
                written.keys.extend(bounds);
            } else {
                let mut row = DraftRow::new(&variable);
                row.keys.extend(bounds);
                self.draft.variables.push(row);
            }
            self.ranges.push((variable, slides, range));
        }
        written.set("spring", "\"free\"");
        self.draft.chain.push(written);
        Ok(())
    }
}
