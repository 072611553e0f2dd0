//! What the columns of a file mean, as a small TOML file.

use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use super::columns::{ColumnRole, ImportedQuantity};
use super::keywords::is_of;
use super::vector_role::is_component;
use crate::readings::{DecimalSign, TableError};
use crate::table_files::{FieldDelimiter, FileColumn, TableFileOptions, TextEncoding, ThreeDigits};
use stiffbench_units_and_text::quantity::Kind;

/// The schema of mapping files.
pub const MAPPING_SCHEMA: &str = "stiffbench/mapping/1";

/// What the columns of a file mean; what is absent is guessed.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ImportMapping {
    /// [`MAPPING_SCHEMA`].
    pub schema: String,
    /// Pose of all rows, if no column states it.
    pub pose: Option<String>,
    /// Direction of all rows, where no column names it.
    pub direction: Option<String>,
    /// Quantities whose sign is turned.
    pub flip: Vec<ImportedQuantity>,
    /// What delimits fields.
    pub delimiter: Option<FieldDelimiter>,
    /// The decimal sign.
    pub decimal: Option<MarkWord>,
    /// The mark between thousands.
    pub thousands: Option<MarkWord>,
    /// How the text is encoded.
    pub encoding: Option<TextEncoding>,
    /// The sheet of a spreadsheet.
    pub sheet: Option<String>,
    /// The columns.
    pub columns: MappedColumns,
    /// Units, where the file states none or a wrong one.
    pub units: MappedUnits,
    /// Columns of joint values, by the variable of the robot.
    pub joints: IndexMap<String, String>,
    /// Whether the table is of a part, which may have torque against angle, or stress against strain.
    #[serde(skip)]
    pub is_of_a_part: bool,
    /// Columns of components of vectors: `force_x`, `displacement_z`, ….
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub vectors: IndexMap<String, String>,
}

/// A mark in a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum MarkWord {
    /// `.`
    Point,
    /// `,`
    Comma,
    /// No mark; of thousands only.
    None,
}

/// Names of columns, as they stand in the file or without their units, or their numbers from 1.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MappedColumns {
    /// The force.
    pub force: Option<String>,
    /// The displacement.
    pub displacement: Option<String>,
    /// The displacement of further repeats, where each has a column of its own.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub repeats: Vec<String>,
    /// The pose.
    pub pose: Option<String>,
    /// The direction.
    pub direction: Option<String>,
    /// What tells runs apart.
    pub repeat: Option<String>,
    /// Loading or unloading.
    pub branch: Option<String>,
    /// The date, where `time` holds the time of day.
    pub date: Option<String>,
    /// The time.
    pub time: Option<String>,
    /// The temperature.
    pub temperature: Option<String>,
}

impl MappedColumns {
    /// The entry of a role; `None` for a name that is no role.
    pub(super) fn entry(&mut self, role: &str) -> Option<&mut Option<String>> {
        Some(match role {
            "force" => &mut self.force,
            "displacement" => &mut self.displacement,
            "pose" => &mut self.pose,
            "direction" => &mut self.direction,
            "repeat" | "run" => &mut self.repeat,
            "branch" => &mut self.branch,
            "date" => &mut self.date,
            "time" => &mut self.time,
            "temperature" => &mut self.temperature,
            _ => return None,
        })
    }
}

/// Units of columns.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MappedUnits {
    /// Of the force.
    pub force: Option<String>,
    /// Of the displacement.
    pub displacement: Option<String>,
    /// Of the time.
    pub time: Option<String>,
    /// Of joint values.
    pub joint: Option<String>,
}

impl ImportMapping {
    /// Reads a mapping file.
    ///
    /// # Errors
    /// [`TableError`] for a text that is no such file, with its line.
    pub fn from_toml(file: &str, text: &str) -> Result<Self, TableError> {
        let refused = |line: usize, problem: &str| {
            TableError::new(
                "stiffbench::import::mapping",
                format!("{file}, line {line}: no mapping: {problem}"),
                "mapping.toml in the folder of an import is one; docs/import.md describes it",
            )
        };
        let mapping: Self = toml::from_str(text).map_err(|error| {
            let before = error.span().and_then(|span| text.get(..span.start));
            let line = before.map_or(0, |before| before.matches('\n').count()) + 1;
            refused(line, error.message())
        })?;
        if mapping.schema != MAPPING_SCHEMA {
            let problem = format!("schema `{}`, expected `{MAPPING_SCHEMA}`", mapping.schema);
            return Err(refused(1, &problem));
        }
        Ok(mapping)
    }

    /// The mapping as a file.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let stated = Self {
            schema: MAPPING_SCHEMA.to_owned(),
            ..self.clone()
        };
        toml::to_string(&stated).unwrap_or_default()
    }

    /// States a column, as `force=Kraft` or `joint.q1=Achse 1`; further columns of the displacement are repeats.
    ///
    /// # Errors
    /// [`TableError`] for a name that is no role.
    pub fn set(&mut self, role: &str, column: &str) -> Result<(), TableError> {
        let column = column.trim().to_owned();
        if let Some(variable) = role.strip_prefix("joint.") {
            self.joints.insert(variable.to_owned(), column);
            return Ok(());
        }
        if is_component(role) {
            self.vectors.insert(role.to_owned(), column);
            return Ok(());
        }
        if role == "displacement" && self.columns.displacement.is_some() {
            self.columns.repeats.push(column);
            return Ok(());
        }
        let entry = self.columns.entry(role);
        *entry.ok_or_else(|| {
            TableError::new(
                "stiffbench::import::unknown_role",
                format!("--map {role}: this is not a quantity of a reading"),
                "known are force, displacement, pose, direction, repeat, branch, date, time, temperature, and joint.NAME for joint values; of vectors force_x, moment_x, displacement_x, rotation_x and position_x, and the same along y and z",
            )
        })? = Some(column);
        Ok(())
    }

    /// The column stated for a role.
    pub(super) fn stated_column(&self, role: &ColumnRole) -> Option<String> {
        match role {
            ColumnRole::Joint(name) => self.joints.get(name).cloned(),
            role => self.columns.clone().entry(&role.to_string())?.take(),
        }
    }

    /// How the table is read.
    pub(super) fn of_file(&self) -> TableFileOptions {
        let decimal = match (self.decimal, self.thousands) {
            (Some(MarkWord::Comma), _) | (None, Some(MarkWord::Point)) => Some(DecimalSign::Comma),
            (Some(MarkWord::Point), _) | (None, Some(MarkWord::Comma)) => Some(DecimalSign::Point),
            _ => None,
        };
        let mark_is_decimal = self.thousands == Some(MarkWord::None);
        TableFileOptions {
            delimiter: self.delimiter,
            decimal,
            encoding: self.encoding,
            sheet: self.sheet.clone(),
            three_digits: if mark_is_decimal {
                ThreeDigits::Decimal
            } else {
                ThreeDigits::Refuse
            },
            units_in_cells: true,
            ..TableFileOptions::default()
        }
    }

    /// The unit stated for columns of this kind.
    pub(super) fn stated_unit(&self, kind: Kind) -> Option<&String> {
        match kind {
            Kind::Force => self.units.force.as_ref(),
            Kind::Displacement => self.units.displacement.as_ref(),
            Kind::Time => self.units.time.as_ref(),
            Kind::Angle => self.units.joint.as_ref(),
            _ => None,
        }
    }

    /// The unit of a column: the one stated, else that of the file if it is of the kind.
    pub(super) fn unit_of(&self, column: &FileColumn, kind: Kind) -> Option<String> {
        let of_file = || column.unit.as_ref().filter(|unit| is_of(kind, unit));
        self.stated_unit(kind).or_else(of_file).cloned()
    }

    /// The sign by which the values of a quantity count.
    pub(super) fn sign(&self, quantity: ImportedQuantity) -> f64 {
        if self.flip.contains(&quantity) {
            -1.0
        } else {
            1.0
        }
    }
}
