//! The header of a table of load cases: which column stands where, in which unit.

use super::table::VectorQuantity;
use crate::readings::{Conversion, PlacedJointColumn, RecordTable, TableError, split_unit};
use stiffbench_units_and_text::nearest::listed_names;
use stiffbench_units_and_text::test_point::Direction;

/// Columns that only a series of readings has.
const OF_READINGS: [&str; 4] = ["direction", "force", "displacement", "target"];

/// A column of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct NumberColumn {
    pub(super) index: usize,
    pub(super) conversion: Conversion,
}

/// Where the columns of a file are.
#[derive(Debug, Default)]
pub(super) struct LoadCaseColumns {
    pub(super) pose: Option<usize>,
    pub(super) repeat: Option<usize>,
    pub(super) axes: Option<usize>,
    pub(super) status: Option<usize>,
    pub(super) origin: Option<usize>,
    pub(super) joints: Vec<PlacedJointColumn>,
    /// By quantity, in the order of [`VectorQuantity::ALL`], and axis.
    pub(super) vectors: [[Option<NumberColumn>; 3]; 5],
    pub(super) notes: Vec<String>,
    pub(super) unused: Vec<String>,
}

/// The meaning of a name.
enum ColumnMeaning<'n> {
    Vector(VectorQuantity, Direction, Option<&'n str>),
    Joint(&'n str, &'n str),
    OfReadings,
    Unknown,
}

/// The quantity and axis of `force_x`, `Disp_z`.
fn component(stem: &str) -> Option<(VectorQuantity, Direction)> {
    let stem = stem.trim().to_lowercase();
    let (quantity, axis) = stem.rsplit_once(['_', ' '])?;
    let quantity = match quantity.trim_end_matches(['_', ' ']) {
        "force" | "load" => VectorQuantity::Force,
        "moment" | "torque" => VectorQuantity::Moment,
        "displacement" | "disp" | "deflection" => VectorQuantity::Displacement,
        "rotation" => VectorQuantity::Rotation,
        "position" => VectorQuantity::Position,
        _ => return None,
    };
    Some((quantity, axis.parse().ok()?))
}

fn meaning(name: &str) -> ColumnMeaning<'_> {
    let name = name.trim();
    if let Some((quantity, axis)) = component(name) {
        return ColumnMeaning::Vector(quantity, axis, None);
    }
    let (stem, unit) = split_unit(name).map_or((name, None), |(stem, unit)| (stem, Some(unit)));
    if let Some((quantity, axis)) = component(stem) {
        return ColumnMeaning::Vector(quantity, axis, unit);
    }
    let joint = stem
        .get(..6)
        .filter(|word| word.eq_ignore_ascii_case("joint_"));
    if let (Some(_), Some(unit)) = (joint, unit)
        && stem.len() > 6
    {
        return ColumnMeaning::Joint(&stem[6..], unit);
    }
    if OF_READINGS.contains(&stem.to_lowercase().as_str()) {
        return ColumnMeaning::OfReadings;
    }
    ColumnMeaning::Unknown
}

/// Whether a table has a column of a vector; a text that is no table has none.
#[must_use]
pub fn is_load_case_table(bytes: &[u8]) -> bool {
    vector_columns(bytes) > 0
}

/// How many columns of components of vectors a table has under the names of load cases.
pub(crate) fn vector_columns(bytes: &[u8]) -> usize {
    let names = RecordTable::names_of(bytes);
    let names = names.iter();
    names
        .filter(|name| matches!(meaning(name), ColumnMeaning::Vector(..)))
        .count()
}

impl LoadCaseColumns {
    /// Reads the header of a table.
    pub(super) fn read(text: &RecordTable<'_>) -> Result<Self, TableError> {
        let mut columns = Self::default();
        let mut of_readings = None;
        for (index, name) in text.names.iter().enumerate() {
            if let Some(place) = columns.place_of(name) {
                *place = Some(index);
                continue;
            }
            match meaning(name) {
                ColumnMeaning::Vector(quantity, axis, unit) => {
                    columns.vector(text, index, (quantity, axis), unit)?;
                }
                ColumnMeaning::Joint(variable, unit) => {
                    let joints = &mut columns.joints;
                    PlacedJointColumn::add(joints, text, index, variable, Some(unit))?;
                }
                ColumnMeaning::OfReadings => of_readings = Some(index),
                ColumnMeaning::Unknown if name.is_empty() => {}
                ColumnMeaning::Unknown => {
                    columns
                        .notes
                        .push(format!("column `{name}` means nothing here"));
                    columns.unused.push(name.clone());
                }
            }
        }
        let vector = columns.vectors.iter().flatten().flatten().next();
        if let (Some(index), Some(vector)) = (of_readings, vector) {
            let [column, vector] = [index, vector.index].map(|index| &text.names[index]);
            return Err(TableError::new(
                "stiffbench::load_cases::mixed",
                format!(
                    "{}: column `{column}` beside columns of vectors such as `{vector}`: the file mixes two forms",
                    text.at(text.header_line)
                ),
                "a load case has its load and what was read as vectors: write force_x_N and displacement_x_um (or y, z) for force_N and displacement_um, and leave direction out",
            ));
        }
        columns.check_complete(text)?;
        Ok(columns)
    }

    /// The place of a column that is known by its name alone.
    fn place_of(&mut self, name: &str) -> Option<&mut Option<usize>> {
        Some(match name.trim().to_lowercase().as_str() {
            "pose" => &mut self.pose,
            "repeat" => &mut self.repeat,
            "axes" => &mut self.axes,
            "status" => &mut self.status,
            "origin" => &mut self.origin,
            _ => return None,
        })
    }

    /// The columns of a quantity.
    pub(super) fn of(&self, quantity: VectorQuantity) -> &[Option<NumberColumn>; 3] {
        &self.vectors[quantity as usize]
    }

    fn vector(
        &mut self,
        text: &RecordTable<'_>,
        index: usize,
        (quantity, axis): (VectorQuantity, Direction),
        unit: Option<&str>,
    ) -> Result<(), TableError> {
        let name = &text.names[index];
        let conversion = unit.and_then(|unit| Conversion::from_unit(quantity.kind(), unit));
        let Some(conversion) = conversion else {
            let accepted = quantity.kind().units();
            return Err(text.wrong_unit(index, unit, accepted));
        };
        let place = &mut self.vectors[quantity as usize][axis.index()];
        if let Some(first) = place {
            return Err(text.duplicate(quantity.name(), first.index, index));
        }
        *place = Some(NumberColumn { index, conversion });
        if Conversion::from_unit(quantity.kind(), quantity.unit()) != Some(conversion) {
            self.notes.push(format!(
                "assumed: column `{name}` was converted to {}",
                quantity.unit()
            ));
        }
        Ok(())
    }

    /// Whether there is a column of a quantity.
    pub(super) fn has(&self, quantity: VectorQuantity) -> bool {
        self.of(quantity).iter().any(Option::is_some)
    }

    /// The first column of a quantity, as named in the file.
    fn first(&self, text: &RecordTable<'_>, quantity: VectorQuantity) -> Option<String> {
        let column = self.of(quantity).iter().flatten().next()?;
        Some(text.names[column.index].clone())
    }

    fn check_complete(&self, text: &RecordTable<'_>) -> Result<(), TableError> {
        let has = |quantity| self.has(quantity);
        let motion = [VectorQuantity::Displacement, VectorQuantity::Rotation];
        let motion = motion
            .into_iter()
            .find_map(|quantity| self.first(text, quantity));
        let position = self.first(text, VectorQuantity::Position);
        if let (Some(position), Some(displacement)) = (&position, motion) {
            return Err(TableError::new(
                "stiffbench::load_cases::positions_and_displacements",
                format!(
                    "{}: column `{position}` beside column `{displacement}`: absolute positions and displacements under a load are two tables",
                    text.at(text.header_line)
                ),
                "put the positions, with their loads, into a separate table",
            ));
        }
        let (what, advice) = if self.pose.is_none() && self.joints.is_empty() {
            (
                "a pose or a joint",
                "add `pose` with names of the robot file, or one column for each variable, for example joint_J1_deg",
            )
        } else if position.is_some() {
            return Ok(());
        } else if !(has(VectorQuantity::Force) || has(VectorQuantity::Moment)) {
            ("a load", "add force_x_N, force_y_N and force_z_N")
        } else if !(has(VectorQuantity::Displacement) || has(VectorQuantity::Rotation)) {
            (
                "a displacement",
                "add at least one of displacement_x_um, displacement_y_um and displacement_z_um; or position_x_mm, position_y_mm and position_z_mm for absolute positions",
            )
        } else {
            return Ok(());
        };
        let found = listed_names(text.names.iter().map(String::as_str));
        Err(TableError::new(
            "stiffbench::load_cases::missing_column",
            format!(
                "{}: no column of {what} among {found}",
                text.at(text.header_line)
            ),
            advice,
        ))
    }
}
