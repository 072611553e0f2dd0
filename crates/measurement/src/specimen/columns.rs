//! The header of a table: where the named columns stand, and in which units.

use super::assumption::SpecimenAssumption;
use super::error::SpecimenError;
use super::options::SpecimenOptions;
use super::table::ColumnScale;
use crate::readings::{Conversion, RecordTable, split_unit};
use stiffbench_units_and_text::nearest::nearest;
use stiffbench_units_and_text::quantity::Kind;

/// A column that is read.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct ColumnPosition {
    pub(super) index: usize,
    pub(super) name: String,
}

/// A column of numbers with a unit.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct MeasuredColumn {
    pub(super) place: ColumnPosition,
    pub(super) conversion: Conversion,
    pub(super) scale: ColumnScale,
}

/// Where everything stands.
#[derive(Debug)]
pub(super) struct SpecimenColumns {
    pub(super) force: Option<MeasuredColumn>,
    pub(super) displacement: MeasuredColumn,
    pub(super) time: Option<MeasuredColumn>,
    pub(super) hold: Option<MeasuredColumn>,
    pub(super) temperature: Option<MeasuredColumn>,
    pub(super) run: Vec<ColumnPosition>,
    pub(super) configuration: Vec<ColumnPosition>,
    pub(super) order: Option<ColumnPosition>,
    pub(super) branch: Option<ColumnPosition>,
    pub(super) unused: Vec<String>,
    pub(super) assumptions: Vec<SpecimenAssumption>,
}

impl SpecimenColumns {
    /// Finds the columns by their names.
    pub(super) fn find(
        text: &RecordTable<'_>,
        options: &SpecimenOptions,
    ) -> Result<Self, SpecimenError> {
        if options.force_column.as_deref() == Some(options.displacement_column.trim()) {
            let column = options.displacement_column.clone();
            return Err(SpecimenError::SameColumn { column });
        }
        let mut header = Header {
            file: text.file(),
            line: text.header_line,
            names: &text.names,
            used: vec![false; text.names.len()],
            assumptions: Vec::new(),
        };
        let force_unit = options.force_unit.as_deref();
        let displacement_unit = options.displacement_unit.as_deref();
        let time_unit = options.time_unit.as_deref();
        let force = options.force_column.as_deref();
        Ok(Self {
            force: force
                .map(|name| header.measured(name, Kind::Force, force_unit))
                .transpose()?,
            displacement: header.measured(
                &options.displacement_column,
                Kind::Displacement,
                displacement_unit,
            )?,
            time: header.optional(options.time_column.as_ref(), Kind::Time, time_unit)?,
            hold: header.optional(options.hold_column.as_ref(), Kind::Time, time_unit)?,
            temperature: header.optional(
                options.temperature_column.as_ref(),
                Kind::Temperature,
                options.temperature_unit.as_deref(),
            )?,
            run: header.places(&options.run_column)?,
            configuration: header.places(&options.configuration_column)?,
            order: header.place_of(options.order_column.as_ref())?,
            branch: header.place_of(options.branch_column.as_ref())?,
            unused: header.unused(),
            assumptions: header.assumptions,
        })
    }

    /// Columns whose values may be absent, with where they stand.
    pub(super) fn optional(&self) -> [Option<&MeasuredColumn>; 3] {
        [&self.time, &self.hold, &self.temperature].map(Option::as_ref)
    }
}

struct Header<'a> {
    file: String,
    line: u32,
    names: &'a [String],
    used: Vec<bool>,
    assumptions: Vec<SpecimenAssumption>,
}

impl Header<'_> {
    fn place(&mut self, wanted: &str) -> Result<ColumnPosition, SpecimenError> {
        let wanted = wanted.trim();
        let mut found = (0..self.names.len()).filter(|index| self.names[*index] == wanted);
        let Some(index) = found.next() else {
            return Err(self.missing(wanted));
        };
        if let Some(second) = found.next() {
            return Err(SpecimenError::DuplicateColumn {
                file: self.file.clone(),
                line: self.line,
                column: wanted.to_owned(),
                first: index + 1,
                second: second + 1,
            });
        }
        self.used[index] = true;
        let name = wanted.to_owned();
        Ok(ColumnPosition { index, name })
    }

    fn missing(&self, wanted: &str) -> SpecimenError {
        let known = self.names.iter().map(String::as_str);
        let advice = match nearest(wanted, known.filter(|name| !name.is_empty())) {
            Some(near) => format!("is `{near}` meant?"),
            None => {
                "columns are named as in the first line of the file, capitals included".to_owned()
            }
        };
        let found: Vec<String> = self.names.iter().map(|name| format!("`{name}`")).collect();
        SpecimenError::MissingColumn {
            file: self.file.clone(),
            line: self.line,
            column: wanted.to_owned(),
            found: found.join(", "),
            advice,
        }
    }

    fn place_of(
        &mut self,
        wanted: Option<&String>,
    ) -> Result<Option<ColumnPosition>, SpecimenError> {
        wanted.map(|name| self.place(name)).transpose()
    }

    fn places(&mut self, wanted: &[String]) -> Result<Vec<ColumnPosition>, SpecimenError> {
        wanted.iter().map(|name| self.place(name)).collect()
    }

    fn optional(
        &mut self,
        wanted: Option<&String>,
        kind: Kind,
        unit: Option<&str>,
    ) -> Result<Option<MeasuredColumn>, SpecimenError> {
        wanted
            .map(|name| self.measured(name, kind, unit))
            .transpose()
    }

    fn measured(
        &mut self,
        wanted: &str,
        kind: Kind,
        unit: Option<&str>,
    ) -> Result<MeasuredColumn, SpecimenError> {
        let place = self.place(wanted)?;
        let (conversion, scale) = match unit.map(str::trim) {
            Some("1") if matches!(kind, Kind::Force | Kind::Displacement) => {
                (Conversion::NONE, ColumnScale::AsInFile)
            }
            Some(unit) => match Conversion::from_unit(kind, unit) {
                Some(conversion) => (conversion, ColumnScale::Si),
                None => {
                    return Err(SpecimenError::WrongUnit {
                        unit: unit.to_owned(),
                        option: option_of(kind),
                        accepted: kind.units(),
                    });
                }
            },
            None => (self.unit_from_name(&place.name, kind)?, ColumnScale::Si),
        };
        Ok(MeasuredColumn {
            place,
            conversion,
            scale,
        })
    }

    fn unit_from_name(&mut self, name: &str, kind: Kind) -> Result<Conversion, SpecimenError> {
        let named = split_unit(name)
            .filter(|(stem, _)| !ends_with_a_unit(stem))
            .and_then(|(_, unit)| Some((unit, Conversion::from_unit(kind, unit)?)));
        if let Some((unit, conversion)) = named {
            self.assumptions.push(SpecimenAssumption::UnitFromName {
                column: name.to_owned(),
                unit: unit.to_owned(),
            });
            return Ok(conversion);
        }
        if kind == Kind::Temperature {
            self.assumptions
                .push(SpecimenAssumption::TemperatureInCelsius);
            return Ok(Conversion::NONE);
        }
        Err(SpecimenError::NoUnit {
            file: self.file.clone(),
            line: self.line,
            column: name.to_owned(),
            option: option_of(kind),
            accepted: kind.units(),
        })
    }

    fn unused(&self) -> Vec<String> {
        let unused = self
            .names
            .iter()
            .zip(&self.used)
            .filter(|(_, used)| !**used);
        unused.map(|(name, _)| name.clone()).collect()
    }
}

/// Whether the rest of a name ends with a unit too: `strain_um_m` is in µm/m, not in m.
fn ends_with_a_unit(stem: &str) -> bool {
    let kinds = [
        Kind::Force,
        Kind::Displacement,
        Kind::Time,
        Kind::Temperature,
    ];
    split_unit(stem).is_some_and(|(_, unit)| {
        unit == "per" || kinds.iter().any(|kind| kind.si_factor(unit).is_some())
    })
}

/// The option that names the unit of a kind.
fn option_of(kind: Kind) -> &'static str {
    match kind {
        Kind::Force | Kind::Torque => "force-unit",
        Kind::Displacement | Kind::Angle => "displacement-unit",
        Kind::Time => "time-unit",
        Kind::Temperature => "temperature-unit",
    }
}
