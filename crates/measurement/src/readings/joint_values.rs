//! Joint values of poses: columns of tables, and the table `[joint_values]` of procedures.

use toml::{Table, Value};

use super::column::split_unit;
use super::error::TableError;
use super::number::{self, Conversion};
use super::text_table::RecordTable;
use super::toml_values::{decimal, in_si};
use stiffbench_units_and_text::quantity::Kind;
use stiffbench_units_and_text::test_point::PoseId;
use stiffbench_units_and_text::toml_text::{self, Read, TomlValue};

/// Whether a joint's variable turns or slides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointUnit {
    /// An angle, rad.
    Angle,
    /// A length, m.
    Length,
}

impl JointUnit {
    /// The units of both.
    pub(crate) const ACCEPTED: &str =
        "urad, mrad, rad, deg, arcmin, arcsec; of a sliding joint um, mm, m, nm, cm, in, mil, uin";

    /// The unit it is written in.
    #[must_use]
    pub fn word(self) -> &'static str {
        match self {
            Self::Angle => "deg",
            Self::Length => "mm",
        }
    }

    /// A value in the unit it is written in, with up to 15 significant digits.
    #[must_use]
    pub fn written(self, value_si: f64) -> String {
        let (value, shift) = self.scaled(value_si);
        number::decimal(value, shift)
    }

    /// A value as a number, and by how many places its decimal point moves to the right in the unit it is written in.
    fn scaled(self, value_si: f64) -> (f64, i32) {
        match self {
            Self::Angle => (value_si.to_degrees(), 0),
            Self::Length => (value_si, 3),
        }
    }

    /// What a unit measures of a joint, and its conversion; `None` for a unit that is neither of an angle nor of a length.
    pub(crate) fn of(unit: &str) -> Option<(Self, Conversion)> {
        let angle = Conversion::from_unit(Kind::Angle, unit).map(|of| (Self::Angle, of));
        let length = || Conversion::from_unit(Kind::Displacement, unit);
        angle.or_else(|| length().map(|of| (Self::Length, of)))
    }
}

/// A column with the values of one variable of the robot.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JointColumn {
    /// Name of the variable.
    pub variable: String,
    /// What its values are.
    pub unit: JointUnit,
}

impl JointColumn {
    /// The name of the column.
    #[must_use]
    pub fn name(&self) -> String {
        format!("joint_{}_{}", self.variable, self.unit.word())
    }
}

/// Where the values of a variable stand in a table.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct PlacedJointColumn {
    pub(crate) index: usize,
    pub(crate) conversion: Conversion,
    pub(crate) column: JointColumn,
}

impl PlacedJointColumn {
    /// Adds a column of a variable.
    ///
    /// # Errors
    /// [`TableError`] for a unit that is none of a joint, and if the variable has a column already.
    pub(crate) fn add(
        known: &mut Vec<Self>,
        text: &RecordTable<'_>,
        index: usize,
        variable: &str,
        unit: Option<&str>,
    ) -> Result<(), TableError> {
        let measures = unit.and_then(JointUnit::of);
        let wrong_unit = || text.wrong_unit(index, unit, JointUnit::ACCEPTED);
        let (unit, conversion) = measures.ok_or_else(wrong_unit)?;
        let mut alike = known.iter();
        if let Some(first) = alike.find(|known| known.column.variable == variable) {
            return Err(text.duplicate("a joint", first.index, index));
        }
        let variable = variable.to_owned();
        known.push(Self {
            index,
            conversion,
            column: JointColumn { variable, unit },
        });
        Ok(())
    }
}

/// A pose by the values of its joints.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseJoints {
    /// Name of the pose.
    pub pose: PoseId,
    /// The variables of the robot, each with its value, rad or m.
    pub values: Vec<(JointColumn, f64)>,
}

/// The table `[joint_values]`: under the name of each pose one key for each variable, `VARIABLE_deg` or `VARIABLE_mm`.
pub(super) fn read_joint_values(table: &toml_text::TomlTable<'_>) -> Read<Vec<PoseJoints>> {
    const EXPECTED: &str =
        "a variable with its unit, for example J1_deg = 30 or, of a sliding joint, q1_mm = 120";
    let Some(poses) = table.read("joint_values", TomlValue::table)? else {
        return Ok(Vec::new());
    };
    let read = poses.entries().map(|(pose, _, joints)| {
        let joints = joints.table()?;
        let values = joints.entries().map(|(key, span, value)| {
            let Some((variable, unit)) = split_unit(key).filter(|(stem, _)| !stem.is_empty())
            else {
                return Err(value.refused(format!("`{key}` without a unit"), EXPECTED));
            };
            let Some((measures, conversion)) = JointUnit::of(unit) else {
                return Err(joints.wrong_unit(span, &value, unit, Kind::Angle));
            };
            let column = JointColumn {
                variable: variable.to_owned(),
                unit: measures,
            };
            Ok((column, in_si(&value, conversion)?))
        });
        Ok(PoseJoints {
            pose: PoseId::new(pose),
            values: values.collect::<Read<_>>()?,
        })
    });
    read.collect()
}

/// The same as the value of the key; `None` without poses.
pub(super) fn joint_values_table(poses: &[PoseJoints]) -> Option<Value> {
    let mut table = Table::new();
    for pose in poses {
        let mut joints = Table::new();
        for (column, value) in &pose.values {
            let (value, shift) = column.unit.scaled(*value);
            let key = format!("{}_{}", column.variable, column.unit.word());
            joints.insert(key, decimal(value, shift).into());
        }
        table.insert(pose.pose.to_string(), joints.into());
    }
    (!table.is_empty()).then_some(Value::Table(table))
}
