//! What a column is taken for.

use std::fmt;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use stiffbench_units_and_text::nearest::listed_names;
use stiffbench_units_and_text::quantity::Kind;
use thiserror::Error;

/// What a column holds.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum ColumnRole {
    Force,
    Displacement,
    Pose,
    Direction,
    Repeat,
    Branch,
    /// Dates whose times of day stand in the column of the time.
    Date,
    Time,
    Temperature,
    /// Specimens, of parts.
    Configuration,
    /// Values of this variable of the robot.
    Joint(String),
}

impl ColumnRole {
    /// All that `--map` can name, but for joints.
    pub(super) const NAMED: [Self; 9] = [
        Self::Force,
        Self::Displacement,
        Self::Pose,
        Self::Direction,
        Self::Repeat,
        Self::Branch,
        Self::Date,
        Self::Time,
        Self::Temperature,
    ];
}

impl fmt::Display for ColumnRole {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Force => "force",
            Self::Displacement => "displacement",
            Self::Pose => "pose",
            Self::Direction => "direction",
            Self::Repeat => "repeat",
            Self::Branch => "branch",
            Self::Date => "date",
            Self::Time => "time",
            Self::Temperature => "temperature",
            Self::Configuration => "configuration",
            Self::Joint(name) => return write!(f, "joint.{name}"),
        })
    }
}

/// One of the two quantities that every reading has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum ImportedQuantity {
    /// The force.
    Force,
    /// The displacement.
    Displacement,
}

impl ImportedQuantity {
    /// Both, in the order in which they are asked for.
    pub(super) const ALL: [Self; 2] = [Self::Force, Self::Displacement];

    pub(super) fn role(self) -> ColumnRole {
        match self {
            Self::Force => ColumnRole::Force,
            Self::Displacement => ColumnRole::Displacement,
        }
    }

    pub(super) fn kind(self) -> Kind {
        match self {
            Self::Force => Kind::Force,
            Self::Displacement => Kind::Displacement,
        }
    }
}

impl fmt::Display for ImportedQuantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(f)
    }
}

/// Where the meaning of a column comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum GuessedFrom {
    /// The user or a mapping states it.
    Stated,
    /// Its name.
    Name,
    /// Its unit.
    Unit,
}

/// A column of the file and what it was taken for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, JsonSchema)]
pub struct ColumnGuess {
    /// Its name in the file.
    pub name: String,
    /// What it was taken for: `force`, `displacement`, `pose`, `direction`, `repeat`, `branch`, `date`, `time`, `temperature` or `joint.NAME`;
    /// `null` of a column that is not used.
    pub role: Option<String>,
    /// Its unit, where it has one.
    pub unit: Option<String>,
    /// Where that meaning comes from; `null` of a column that is not used.
    pub from: Option<GuessedFrom>,
    /// Its first values, as they stand in the file.
    pub first_values: Vec<String>,
}

/// Something that an import needs and the file does not state.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum MissingPart {
    /// No column, or several, can be the force or the displacement.
    #[error("the column of the {quantity}{}", one_of(.candidates))]
    Column {
        /// Which of the two.
        quantity: ImportedQuantity,
        /// Columns that could be it.
        candidates: Vec<String>,
    },
    /// The unit of the force or of the displacement.
    #[error("the unit of the {quantity}{}{}", of_column(.column.as_ref()), not_known(.unknown.as_ref(), *.quantity))]
    Unit {
        /// Which of the two.
        quantity: ImportedQuantity,
        /// Its column, where that is known.
        column: Option<String>,
        /// What the file states and is no unit of the quantity.
        unknown: Option<String>,
    },
    /// Whether joint values are degrees or radians.
    #[error("the unit of the joint values in `{column}`")]
    JointUnit {
        /// The first column with joint values.
        column: String,
    },
    /// The direction of the loads.
    #[error("the direction of the loads (x, y or z)")]
    Direction,
}

impl MissingPart {
    /// What settles it on the command line.
    #[must_use]
    pub fn option(&self) -> String {
        match self {
            Self::Column { quantity, .. } => format!("--map {quantity}=COLUMN"),
            Self::Unit { quantity, .. } => format!("--{quantity}-unit UNIT"),
            Self::JointUnit { .. } => "--joint-unit deg".to_owned(),
            Self::Direction => "--direction y".to_owned(),
        }
    }
}

/// Which columns could be the one that is missing.
fn one_of(candidates: &[String]) -> String {
    if candidates.is_empty() {
        return String::new();
    }
    let names = candidates.iter().map(String::as_str);
    format!(" (one of {})", listed_names(names))
}

/// Where a unit is missing, if that is known.
fn of_column(column: Option<&String>) -> String {
    column.map_or_else(
        || ", which no column states".to_owned(),
        |column| format!(" in `{column}`"),
    )
}

/// What stands in place of a unit.
fn not_known(unit: Option<&String>, quantity: ImportedQuantity) -> String {
    let known = quantity.kind().units();
    unit.map_or_else(String::new, |unit| {
        format!(" (unit `{unit}` is not known for a {quantity}; known units: {known})")
    })
}
