//! A table of load cases, with everything its reader assumed.

use std::fmt;

use indexmap::IndexSet;

use crate::readings::JointColumn;
use stiffbench_units_and_text::quantity::Kind;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

/// What a vector column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum VectorQuantity {
    /// Force at the end, N.
    Force,
    /// Moment at the end, N·m.
    Moment,
    /// Displacement of the end, m.
    Displacement,
    /// Rotation of the end, rad.
    Rotation,
    /// Position of a point of the tool in the axes of a tracker, m.
    Position,
}

impl VectorQuantity {
    /// All, in the order in which they are written.
    pub const ALL: [Self; 5] = [
        Self::Force,
        Self::Moment,
        Self::Displacement,
        Self::Rotation,
        Self::Position,
    ];

    /// Its name in a column, the unit it is written in as a power of ten of the SI unit, and what it measures.
    fn facts(self) -> (&'static str, &'static str, i32, Kind) {
        match self {
            Self::Force => ("force", "N", 0, Kind::Force),
            Self::Moment => ("moment", "Nm", 0, Kind::Torque),
            Self::Displacement => ("displacement", "um", 6, Kind::Displacement),
            Self::Rotation => ("rotation", "urad", 6, Kind::Angle),
            Self::Position => ("position", "mm", 3, Kind::Displacement),
        }
    }

    /// Its name in a column.
    #[must_use]
    pub fn name(self) -> &'static str {
        self.facts().0
    }

    /// The unit it is written in.
    #[must_use]
    pub fn unit(self) -> &'static str {
        self.facts().1
    }

    /// Decimal places by which a value in SI is moved to be written in its unit.
    pub(super) fn shift(self) -> i32 {
        self.facts().2
    }

    /// What it measures.
    #[must_use]
    pub fn kind(self) -> Kind {
        self.facts().3
    }

    /// Whether it is applied; else it is read.
    #[must_use]
    pub fn is_load(self) -> bool {
        matches!(self, Self::Force | Self::Moment)
    }

    /// The column of one of its components, with its unit.
    #[must_use]
    pub fn column(self, axis: Direction) -> String {
        format!("{}_{axis}_{}", self.name(), self.unit())
    }
}

/// Along which axes the components of a load case stand.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum LoadAxes {
    /// Those of the robot's base.
    #[default]
    Base,
    /// Those of the body that carries the end.
    Tool,
    /// Those of a body of the robot, by name.
    Body(String),
}

impl fmt::Display for LoadAxes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Base => "base",
            Self::Tool => "tool",
            Self::Body(name) => name,
        })
    }
}

/// One load application, or one position, in one pose.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadCase {
    /// Line of the file, from 1; 0 if there is none.
    pub line: u32,
    /// Name of the pose, or its number where the table gives none.
    pub pose: PoseId,
    /// Values of the joint columns, rad or m.
    pub joints: Vec<f64>,
    /// n-th application of the load, from 1.
    pub repeat: u32,
    /// Along which axes its components stand.
    pub axes: LoadAxes,
    /// Force at the end, N.
    pub force_n: [f64; 3],
    /// Moment at the end, N·m.
    pub moment_nm: [f64; 3],
    /// Displacement of the end, m; `None` for a component that was not read.
    pub displacement_m: [Option<f64>; 3],
    /// Rotation of the end, rad; `None` for a component that was not read.
    pub rotation_rad: [Option<f64>; 3],
    /// Position of a point of the tool in the axes of a tracker, m; `None` for a component that was not read.
    pub position_m: [Option<f64>; 3],
}

impl LoadCase {
    /// Number of components that were read.
    #[must_use]
    pub fn component_count(&self) -> usize {
        let motion = self.displacement_m.iter().chain(&self.rotation_rad);
        motion.chain(&self.position_m).flatten().count()
    }
}

/// Load cases of one session, in the order of the file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct LoadCaseTable {
    /// Where they come from, as the caller named it.
    pub source: String,
    /// How they came about if they were not measured.
    pub origin: Option<String>,
    /// The columns of joint values.
    pub joints: Vec<JointColumn>,
    /// The load cases that count.
    pub cases: Vec<LoadCase>,
    /// What its reader took for granted, left out or noticed.
    pub notes: Vec<String>,
    /// Columns that mean nothing here.
    pub unused_columns: Vec<String>,
}

impl LoadCaseTable {
    /// The names of the poses, in the order in which they first appear.
    #[must_use]
    pub fn poses(&self) -> Vec<PoseId> {
        let poses: IndexSet<&PoseId> = self.cases.iter().map(|case| &case.pose).collect();
        poses.into_iter().cloned().collect()
    }

    /// Whether the table has absolute positions; else it has displacements and rotations under a load.
    #[must_use]
    pub fn has_positions(&self) -> bool {
        let mut read = self.cases.iter().flat_map(|case| &case.position_m);
        read.any(Option::is_some)
    }

    /// Number of components that were read.
    #[must_use]
    pub fn component_count(&self) -> usize {
        self.cases.iter().map(LoadCase::component_count).sum()
    }
}
