//! What a column is taken for.

use std::fmt;

use schemars::JsonSchema;
use serde::Serialize;
use stiffbench_units_and_text::nearest::listed_names;
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
    /// Dates whose times of day stand in the column of the time.
    Date,
    Time,
    Temperature,
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
        /// Its column, where that is known.
        column: Option<String>,
        /// What the file states and is no unit of a force.
        unknown: Option<String>,
    },
    /// The unit of the displacement.
    DisplacementUnit {
        /// Its column, where that is known.
        column: Option<String>,
        /// What the file states and is no unit of a displacement.
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
            let names = candidates.iter().map(String::as_str);
            write!(f, " (one of {})", listed_names(names))
        };
        match self {
            Self::ForceColumn { candidates } => column(f, "force", candidates),
            Self::DisplacementColumn { candidates } => column(f, "displacement", candidates),
            Self::ForceUnit { column, unknown } => {
                unit(f, "force", Kind::Force, [column.as_ref(), unknown.as_ref()])
            }
            Self::DisplacementUnit { column, unknown } => {
                let texts = [column.as_ref(), unknown.as_ref()];
                unit(f, "displacement", Kind::Displacement, texts)
            }
            Self::JointUnit { column } => write!(f, "the unit of the joint values in `{column}`"),
            Self::Direction => f.write_str("the direction of the loads (x, y or z)"),
        }
    }
}

/// A unit that is missing, of a column if that is known.
fn unit(
    f: &mut fmt::Formatter<'_>,
    what: &str,
    kind: Kind,
    [column, unknown]: [Option<&String>; 2],
) -> fmt::Result {
    write!(f, "the unit of the {what}")?;
    match column {
        Some(column) => write!(f, " in `{column}`")?,
        None => f.write_str(", which no column states")?,
    }
    if let Some(unknown) = unknown {
        write!(
            f,
            " (unit `{unknown}` is not known for a {what}; known are {})",
            kind.units()
        )?;
    }
    Ok(())
}
