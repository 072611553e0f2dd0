//! The header of a table: where the named columns stand, and in which units.

use super::options::SpecimenOptions;
use super::response::ResponseVariable;
use super::table::ColumnUnit;
use crate::readings::{Conversion, TableError};
use crate::table_files::{MachineTable, StatedUnit};
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
    pub(super) unit: ColumnUnit,
    /// Seconds since the first time of each row, where the column holds dates or times of day.
    pub(super) seconds: Option<Vec<Option<f64>>>,
}

/// What a column of a table may measure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum ColumnQuantity {
    /// Force, torque or stress.
    Force,
    /// Displacement, angle or strain.
    Displacement,
    /// Time.
    Time,
    /// Temperature.
    Temperature,
}

impl ColumnQuantity {
    fn kinds(self) -> &'static [Kind] {
        match self {
            Self::Force => &[Kind::Force, Kind::Torque, Kind::Stress],
            Self::Displacement => &[Kind::Displacement, Kind::Angle, Kind::Strain],
            Self::Time => &[Kind::Time],
            Self::Temperature => &[Kind::Temperature],
        }
    }

    /// What `--map` calls it.
    fn role(self) -> &'static str {
        self.option().trim_end_matches("-unit")
    }

    /// The option that names its unit.
    fn option(self) -> &'static str {
        match self {
            Self::Force => "force-unit",
            Self::Displacement => "displacement-unit",
            Self::Time => "time-unit",
            Self::Temperature => "temperature-unit",
        }
    }

    /// The units it may have, for messages.
    fn units(self) -> String {
        let units: Vec<&str> = self.kinds().iter().map(|kind| kind.units()).collect();
        units.join(", ")
    }

    /// The conversion from a unit of one of its kinds.
    fn conversion(self, unit: &str) -> Option<(Conversion, ColumnUnit)> {
        let mut kinds = self.kinds().iter();
        kinds.find_map(|kind| ColumnUnit::of(*kind, unit))
    }
}

/// Where everything stands.
#[derive(Debug)]
pub(super) struct SpecimenColumns {
    pub(super) force: Option<MeasuredColumn>,
    pub(super) displacement: Option<MeasuredColumn>,
    pub(super) time: Option<MeasuredColumn>,
    pub(super) hold: Option<MeasuredColumn>,
    pub(super) temperature: Option<MeasuredColumn>,
    pub(super) run: Vec<ColumnPosition>,
    pub(super) configuration: Vec<ColumnPosition>,
    pub(super) order: Option<ColumnPosition>,
    pub(super) branch: Option<ColumnPosition>,
    pub(super) unused: Vec<String>,
    pub(super) assumptions: Vec<String>,
}

impl SpecimenColumns {
    /// Finds the columns by their names.
    pub(super) fn find<'o>(
        table: &MachineTable,
        options: &'o SpecimenOptions,
    ) -> Result<Self, TableError> {
        let mut header = Header {
            table,
            used: vec![false; table.layout.columns.len()],
            assumptions: Vec::new(),
        };
        let [of_force, of_displacement] =
            [ColumnQuantity::Force, ColumnQuantity::Displacement].map(ColumnQuantity::role);
        let force = options.force_column.as_deref();
        let force = force.and_then(|name| table.column(name, of_force).ok());
        let displacement = table.column(&options.displacement_column, of_displacement);
        if let Some(force) = force.filter(|force| displacement.as_ref().ok() == Some(force)) {
            return Err(table.same_column(table.name(force), of_force, of_displacement));
        }
        let force_unit = options.force_unit.as_deref();
        let displacement_unit = options.displacement_unit.as_deref();
        let time_unit = options.time_unit.as_deref();
        let wanted = |quantity, name: Option<&'o String>| {
            name.filter(|name| !options.may_lack(quantity) || header.has(name))
        };
        let force = wanted(ResponseVariable::Force, options.force_column.as_ref());
        let displacement = Some(&options.displacement_column);
        let displacement = wanted(ResponseVariable::Displacement, displacement);
        let mut found = Self {
            force: header.optional(force, ColumnQuantity::Force, force_unit)?,
            displacement: header.optional(
                displacement,
                ColumnQuantity::Displacement,
                displacement_unit,
            )?,
            time: header.time(options.time_column.as_ref(), time_unit)?,
            hold: header.optional(
                options.hold_column.as_ref(),
                ColumnQuantity::Time,
                time_unit,
            )?,
            temperature: header.optional(
                options.temperature_column.as_ref(),
                ColumnQuantity::Temperature,
                options.temperature_unit.as_deref(),
            )?,
            run: header.places(&options.run_column, "run")?,
            configuration: header.places(&options.configuration_column, "configuration")?,
            order: header.place_of(options.order_column.as_ref(), "order")?,
            branch: header.place_of(options.branch_column.as_ref(), "branch")?,
            unused: header.unused(),
            assumptions: Vec::new(),
        };
        found.assumptions = header.assumptions;
        Ok(found)
    }

    /// Columns whose values may be absent, with where they stand.
    pub(super) fn optional(&self) -> [Option<&MeasuredColumn>; 3] {
        [&self.time, &self.hold, &self.temperature].map(Option::as_ref)
    }
}

struct Header<'a> {
    table: &'a MachineTable,
    used: Vec<bool>,
    assumptions: Vec<String>,
}

impl Header<'_> {
    /// Whether there is a column of this name, with or without its unit.
    fn has(&self, wanted: &str) -> bool {
        self.table.column(wanted, "").is_ok()
    }

    fn place(&mut self, wanted: &str, role: &str) -> Result<ColumnPosition, TableError> {
        let index = self.table.column(wanted, role)?;
        self.used[index] = true;
        let name = self.table.name(index).to_owned();
        Ok(ColumnPosition { index, name })
    }

    fn place_of(
        &mut self,
        wanted: Option<&String>,
        role: &str,
    ) -> Result<Option<ColumnPosition>, TableError> {
        wanted.map(|name| self.place(name, role)).transpose()
    }

    fn places(&mut self, wanted: &[String], role: &str) -> Result<Vec<ColumnPosition>, TableError> {
        wanted.iter().map(|name| self.place(name, role)).collect()
    }

    fn optional(
        &mut self,
        wanted: Option<&String>,
        quantity: ColumnQuantity,
        unit: Option<&str>,
    ) -> Result<Option<MeasuredColumn>, TableError> {
        wanted
            .map(|name| self.measured(name, quantity, unit))
            .transpose()
    }

    /// A time, which may stand as dates or times of day.
    fn time(
        &mut self,
        wanted: Option<&String>,
        unit: Option<&str>,
    ) -> Result<Option<MeasuredColumn>, TableError> {
        let Some(name) = wanted else { return Ok(None) };
        let place = self.place(name, ColumnQuantity::Time.role())?;
        if !self.table.is_time_stamp(place.index) {
            return self.optional(wanted, ColumnQuantity::Time, unit);
        }
        let seconds = self.table.seconds(place.index)?;
        self.assumptions.push(format!(
            "column `{}` holds times: they became seconds since the first",
            place.name
        ));
        Ok(Some(MeasuredColumn {
            place,
            conversion: Conversion::NONE,
            unit: ColumnUnit::si(Kind::Time),
            seconds: Some(seconds),
        }))
    }

    fn measured(
        &mut self,
        wanted: &str,
        quantity: ColumnQuantity,
        unit: Option<&str>,
    ) -> Result<MeasuredColumn, TableError> {
        let place = self.place(wanted, quantity.role())?;
        let (conversion, unit) = match unit.map(str::trim) {
            Some("1")
                if matches!(
                    quantity,
                    ColumnQuantity::Force | ColumnQuantity::Displacement
                ) =>
            {
                (Conversion::NONE, ColumnUnit::none())
            }
            Some(unit) => quantity
                .conversion(unit)
                .ok_or_else(|| {
                    let (option, accepted) = (quantity.option(), quantity.units());
                    TableError::new(
                        "stiffbench::specimen::wrong_unit",
                        format!("`{unit}` is not a unit for --{option}, expected one of {accepted}"),
                        "force and displacement may also have the unit 1: numbers kept as they are in the file",
                    )
                })?,
            None => self.unit_of_file(&place, quantity)?,
        };
        Ok(MeasuredColumn {
            place,
            conversion,
            unit,
            seconds: None,
        })
    }

    fn unit_of_file(
        &mut self,
        place: &ColumnPosition,
        quantity: ColumnQuantity,
    ) -> Result<(Conversion, ColumnUnit), TableError> {
        let column = &self.table.layout.columns[place.index];
        let name = column.name.clone();
        let (at, option) = (self.table.header(), quantity.option());
        let accepted = quantity.units();
        if let (Some(unit), Some(source)) = (&column.unit, column.unit_from) {
            if let Some(found) = quantity.conversion(unit) {
                let by = if source == StatedUnit::Name {
                    "its name"
                } else {
                    "the file"
                };
                self.assumptions
                    .push(format!("column `{name}` is in {unit}, by {by}"));
                return Ok(found);
            }
            if source != StatedUnit::Name && quantity != ColumnQuantity::Temperature {
                return Err(TableError::new(
                    "stiffbench::specimen::wrong_column_unit",
                    format!("{at}: column `{name}` is in `{unit}`, expected one of {accepted}"),
                    format!(
                        "is it another column that is meant? Else state the unit with --{option}; force and displacement may have --{option} 1, numbers kept as they are in the file"
                    ),
                ));
            }
        }
        if quantity == ColumnQuantity::Temperature {
            self.assumptions
                .push("temperatures without a unit are °C".to_owned());
            return Ok((Conversion::NONE, ColumnUnit::si(Kind::Temperature)));
        }
        Err(TableError::new(
            "stiffbench::specimen::no_unit",
            format!("{at}: column `{name}` has no unit, expected one of {accepted}"),
            format!(
                "name it with --{option}, or at the end of the column's name (force_N, travel_mm, t_s); force and displacement may have --{option} 1, numbers without a unit"
            ),
        ))
    }

    fn unused(&self) -> Vec<String> {
        let columns = self.table.names().zip(&self.used);
        let unused = columns.filter(|(_, used)| !**used);
        unused.map(|(name, _)| name.to_owned()).collect()
    }
}
