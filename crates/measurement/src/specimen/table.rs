//! What the reader gives.

use super::excluded::ExcludedLines;
use super::response::{ResponseDoubt, ResponseVariable};
use crate::readings::Conversion;
use crate::table_files::FileLayout;
use stiffbench_units_and_text::quantity::Kind;
use stiffbench_units_and_text::test_point::Branch;

/// The unit of a column.
#[derive(Debug, Clone, PartialEq)]
pub struct ColumnUnit {
    /// The unit of the file, in which results are printed; `1` of numbers without one.
    pub name: String,
    /// The SI unit that the numbers of the table are in; `1` of numbers kept as they are in the file.
    pub si: &'static str,
    /// SI units in one of them.
    pub si_per_unit: f64,
}

impl ColumnUnit {
    /// Numbers without a unit, kept as they are in the file.
    #[must_use]
    pub fn none() -> Self {
        Self {
            name: "1".to_owned(),
            si: "1",
            si_per_unit: 1.0,
        }
    }

    /// A unit by its name in a file, of whatever kind; `None` if there is no such unit.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        if name == "1" {
            return Some(Self::none());
        }
        let mut units = Kind::ALL
            .into_iter()
            .filter_map(|kind| Self::of(kind, name));
        Some(units.next()?.1)
    }

    /// A unit of a kind, and how its numbers become SI; `None` for a name of no such unit.
    pub(super) fn of(kind: Kind, name: &str) -> Option<(Conversion, Self)> {
        let conversion = Conversion::from_unit(kind, name)?;
        let unit = Self {
            name: name.to_owned(),
            si: kind.si_unit(),
            si_per_unit: conversion.factor(),
        };
        Some((conversion, unit))
    }

    /// The SI unit of a kind.
    #[must_use]
    pub fn si(kind: Kind) -> Self {
        Self {
            name: kind.si_unit().to_owned(),
            si: kind.si_unit(),
            si_per_unit: 1.0,
        }
    }
}

/// One pair of numbers, with what is known of when and how it was taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpecimenReading {
    /// Line of the file, from 1.
    pub line: u32,
    /// Index of its configuration in the table.
    pub configuration: u32,
    /// Index of its run in the table.
    pub run: u32,
    /// Place in the order of measurement: the file's own number, or the place among the readings from 1.
    pub order: u32,
    /// Loading or unloading.
    pub branch: Branch,
    /// Force in the SI unit of [`SpecimenTable::force_unit`].
    pub force: f64,
    /// Displacement in the SI unit of [`SpecimenTable::displacement_unit`].
    pub displacement: f64,
    /// Time in s, if known.
    pub time_s: Option<f64>,
    /// Time under this load in s, if known.
    pub hold_s: Option<f64>,
    /// Temperature in °C, if known.
    pub temperature_deg_c: Option<f64>,
}

/// Readings with one zero and one history.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SpecimenRun {
    /// The texts of its columns, with ` / ` between them; that of its configuration if no column names runs.
    pub label: String,
    /// Index of the configuration it belongs to.
    pub configuration: u32,
}

/// A table of pairs, in the order of measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct SpecimenTable {
    /// The input, as the caller named it.
    pub source: String,
    /// Which quantity answers.
    pub response: ResponseVariable,
    /// Whether what was set went one way in every run, at one rate.
    pub is_one_sweep: bool,
    /// What the clock has against the response.
    pub response_doubt: Option<ResponseDoubt>,
    /// What the forces are in: force, torque or stress.
    pub force_unit: ColumnUnit,
    /// What the displacements are in: displacement, angle or strain.
    pub displacement_unit: ColumnUnit,
    /// Whether the quantity that answers was recorded; else it is zero.
    pub has_response: bool,
    /// Whether a column gives the order of measurement; else it is that of the rows.
    pub has_order: bool,
    /// What in the file was taken for what.
    pub layout: FileLayout,
    /// Specimens or configurations, in the order in which they appear; the only one is called `specimen` if no column names them.
    pub configurations: Vec<String>,
    /// Runs, in the order in which they appear.
    pub runs: Vec<SpecimenRun>,
    /// The readings, in the order of measurement.
    pub readings: Vec<SpecimenReading>,
    /// What the file leaves open and the reader decided.
    pub assumptions: Vec<String>,
    /// What was left out.
    pub excluded: ExcludedLines,
    /// Columns of the file that are not part of the format.
    pub unused_columns: Vec<String>,
}

impl SpecimenTable {
    /// The quantity that was set: force, or displacement if the force answers.
    #[must_use]
    pub fn driver(&self, reading: &SpecimenReading) -> f64 {
        match self.response {
            ResponseVariable::Displacement => reading.force,
            ResponseVariable::Force => reading.displacement,
        }
    }

    /// The quantity that answered.
    #[must_use]
    pub fn answer(&self, reading: &SpecimenReading) -> f64 {
        match self.response {
            ResponseVariable::Displacement => reading.displacement,
            ResponseVariable::Force => reading.force,
        }
    }
}
