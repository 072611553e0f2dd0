//! What a column is taken for.

use std::fmt;

use schemars::JsonSchema;
use serde::Serialize;
use stiffbench_units_and_text::quantity::Kind;

/// What a column holds.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum ColumnRole {
    Force,
    Displacement,
    Pose,
    Direction,
    Repeat,
    Branch,
    Time,
    Temperature,
    /// Values of this variable of the robot.
    Joint(String),
}

impl ColumnRole {
    /// All that `--map` can name, but for joints.
    pub(super) const NAMED: [Self; 8] = [
        Self::Force,
        Self::Displacement,
        Self::Pose,
        Self::Direction,
        Self::Repeat,
        Self::Branch,
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
            Self::Time => "time",
            Self::Temperature => "temperature",
            Self::Joint(name) => return write!(f, "joint.{name}"),
        })
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
    /// What it was taken for: `force`, `displacement`, `pose`, `direction`, `repeat`, `branch`, `time`, `temperature` or `joint.NAME`;
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
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum MissingPart {
    /// No column, or several, can be the force.
    ForceColumn {
        /// Columns that could be it.
        candidates: Vec<String>,
    },
    /// No column, or several, can be the displacement.
    DisplacementColumn {
        /// Columns that could be it.
        candidates: Vec<String>,
    },
    /// The unit of the force.
    ForceUnit {
        /// Its column.
        column: String,
        /// A unit that the file states and that is not known.
        unknown: Option<String>,
    },
    /// The unit of the displacement.
    DisplacementUnit {
        /// Its column.
        column: String,
        /// A unit that the file states and that is not known.
        unknown: Option<String>,
    },
    /// Whether joint values are degrees or radians.
    JointUnit {
        /// The first column with joint values.
        column: String,
    },
    /// The direction of the loads.
    Direction,
}

impl MissingPart {
    /// What settles it on the command line.
    #[must_use]
    pub fn option(&self) -> &'static str {
        match self {
            Self::ForceColumn { .. } => "--map force=COLUMN",
            Self::DisplacementColumn { .. } => "--map displacement=COLUMN",
            Self::ForceUnit { .. } => "--force-unit UNIT",
            Self::DisplacementUnit { .. } => "--displacement-unit UNIT",
            Self::JointUnit { .. } => "--joint-unit deg",
            Self::Direction => "--direction y",
        }
    }
}

impl fmt::Display for MissingPart {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let column = |f: &mut fmt::Formatter<'_>, what: &str, candidates: &[String]| {
            write!(f, "the column of the {what}")?;
            if candidates.is_empty() {
                return Ok(());
            }
            let names: Vec<String> = candidates.iter().map(|name| format!("`{name}`")).collect();
            write!(f, " (one of {})", names.join(", "))
        };
        match self {
            Self::ForceColumn { candidates } => column(f, "force", candidates),
            Self::DisplacementColumn { candidates } => column(f, "displacement", candidates),
            Self::ForceUnit { column, unknown } => {
                write!(f, "the unit of the force in `{column}`")?;
                unknown_unit(f, unknown.as_deref(), Kind::Force)
            }
            Self::DisplacementUnit { column, unknown } => {
                write!(f, "the unit of the displacement in `{column}`")?;
                unknown_unit(f, unknown.as_deref(), Kind::Displacement)
            }
            Self::JointUnit { column } => write!(f, "the unit of the joint values in `{column}`"),
            Self::Direction => f.write_str("the direction of the loads (x, y or z)"),
        }
    }
}

fn unknown_unit(f: &mut fmt::Formatter<'_>, unit: Option<&str>, kind: Kind) -> fmt::Result {
    match unit {
        Some(unit) => write!(f, " (`{unit}` is not known; known are {})", kind.units()),
        None => write!(f, " ({})", kind.units()),
    }
}
