//! The units of joint values.

use super::guess::FoundColumns;
use super::keywords::is_of;
use super::mapping::ImportMapping;
use crate::readings::{Conversion, JointUnit};
use crate::table_files::MachineTable;
use stiffbench_units_and_text::quantity::Kind;

/// Joint values beyond this are no radians: a little more than a whole turn.
const LARGEST_RAD: f64 = 7.0;

/// The unit of joint values.
pub(super) struct JointValueUnit {
    pub(super) name: String,
    pub(super) unit: JointUnit,
    pub(super) conversion: Conversion,
    /// Whether only the size of the values shows it.
    pub(super) is_guessed: bool,
}

/// The unit of a column of joint values; `None` where nothing shows it.
pub(super) fn joint_unit(
    (table, mapping, found): (&MachineTable, &ImportMapping, &FoundColumns),
    index: usize,
) -> Option<JointValueUnit> {
    let joints = found.joints().map(|(_, index)| index);
    joint_unit_among(table, mapping, index, joints)
}

/// The same of one of several columns of joint values.
pub(super) fn joint_unit_among(
    table: &MachineTable,
    mapping: &ImportMapping,
    index: usize,
    mut joints: impl Iterator<Item = usize>,
) -> Option<JointValueUnit> {
    let column = &table.layout.columns[index];
    let of = |name: String, is_guessed| {
        let (unit, conversion) = JointUnit::of(&name)?;
        Some(JointValueUnit {
            name,
            unit,
            conversion,
            is_guessed,
        })
    };
    let length = column
        .unit
        .clone()
        .filter(|unit| is_of(Kind::Displacement, unit));
    let named = length.or_else(|| mapping.unit_of(column, Kind::Angle));
    if let Some(name) = named {
        return of(name, false);
    }
    // The end of `joint_q1_deg` is its unit.
    if let Some((_, end)) = column
        .stem
        .rsplit_once('_')
        .filter(|(_, end)| is_of(Kind::Angle, end))
    {
        return of(end.to_owned(), false);
    }
    let is_large = joints.any(|index| {
        let values = table.numbers(index).unwrap_or_default();
        let mut values = values.into_iter().flatten();
        values.any(|value| value.abs() > LARGEST_RAD)
    });
    is_large.then(|| of("deg".to_owned(), true)).flatten()
}
