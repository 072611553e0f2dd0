//! A table with what its columns were taken for, before readings are made of it.

use super::columns::{ColumnGuess, ColumnRole, ImportedQuantity, MissingPart};
use super::guess::FoundColumns;
use super::joint_unit::joint_unit;
use super::keywords::is_of;
use super::mapping::ImportMapping;
use super::pairs::PairedLog;
use crate::readings::{Conversion, TableError};
use crate::table_files::{MachineTable, read_table_files};
use stiffbench_units_and_text::quantity::Kind;

/// A table with what its columns were taken for.
#[derive(Debug)]
pub struct ImportDraft {
    pub(super) table: MachineTable,
    pub(super) mapping: ImportMapping,
    pub(super) found: FoundColumns,
    pub(super) log: Option<PairedLog>,
    /// Columns of the displacement of repeats after the first.
    pub(super) repeats: Vec<String>,
}

impl ImportDraft {
    /// Reads a table and guesses its columns.
    ///
    /// # Arguments
    /// - `files`: names, for messages, and bytes; several with the same columns are read as one table.
    /// - `log`: name and bytes of a log of the displacement, where `bytes` are a log of the force alone.
    /// - `mapping`: what is known of the columns.
    ///
    /// # Errors
    /// [`TableError`] for a file that is no table, and for columns or units that cannot be.
    pub fn read(
        files: &[(&str, &[u8])],
        log: Option<(&str, &[u8])>,
        mapping: &ImportMapping,
    ) -> Result<Self, TableError> {
        for (kind, quantity) in [
            (Kind::Force, "force"),
            (Kind::Displacement, "displacement"),
            (Kind::Time, "time"),
            (Kind::Angle, "joint value"),
        ] {
            let stated = mapping.stated_unit(kind);
            if let Some(unit) = stated.filter(|unit| !is_of(kind, unit)) {
                return Err(TableError::new(
                    "stiffbench::import::unit",
                    format!("`{unit}` is not a unit of a {quantity}"),
                    format!("known are {}", kind.units()),
                ));
            }
        }
        let mut table = read_table_files(files, &mapping.of_file())?;
        let mut of_force = mapping.clone();
        if log.is_some() {
            of_force.columns.displacement = None;
        }
        let mut found = FoundColumns::find(&table, &of_force)?;
        let repeats = found.repeats_beside_each_other(&table, &of_force)?;
        let further = repeats.iter().skip(1);
        let further = further.map(|place| table.name(*place).to_owned()).collect();
        if !repeats.is_empty() {
            table = table.stacked(&repeats, "series");
            of_force.columns.displacement = Some((repeats[0] + 1).to_string());
            found = FoundColumns::find(&table, &of_force)?;
        }
        if let Some((dates, times)) = found.dates_and_times(&table) {
            table.join_dates(dates, times);
        }
        let log = log
            .map(|(name, bytes)| PairedLog::read(name, bytes, mapping))
            .transpose()?;
        let draft = Self {
            table,
            mapping: mapping.clone(),
            found,
            log,
            repeats: further,
        };
        draft.refuse_duplicates()?;
        Ok(draft)
    }

    /// What is missing, in the order in which a person would be asked.
    #[must_use]
    pub fn missing(&self) -> Vec<MissingPart> {
        let mut missing = Vec::new();
        for quantity in ImportedQuantity::ALL {
            if let (ImportedQuantity::Displacement, Some(log)) = (quantity, &self.log) {
                missing.extend(log.missing());
                continue;
            }
            let (role, kind) = (quantity.role(), quantity.kind());
            let place = self.found.place(&role);
            if place.is_none() {
                let candidates = self.found.candidates.get(&role).into_iter().flatten();
                missing.push(MissingPart::Column {
                    quantity,
                    candidates: candidates
                        .map(|index| self.name(*index).to_owned())
                        .collect(),
                });
            }
            let has_unit = match place {
                Some(index) => self.unit(index, kind).is_some(),
                None => self.states_unit(kind),
            };
            if !has_unit {
                let column = place.map(|index| &self.table.layout.columns[index]);
                missing.push(MissingPart::Unit {
                    quantity,
                    column: column.map(|column| column.name.clone()),
                    unknown: column.and_then(|column| column.unit.clone()),
                });
            }
        }
        if let Some((_, index)) = self.found.joints().next()
            && joint_unit((&self.table, &self.mapping, &self.found), index).is_none()
        {
            let column = self.name(index).to_owned();
            missing.push(MissingPart::JointUnit { column });
        }
        let has_direction =
            self.mapping.direction.is_some() || self.found.place(&ColumnRole::Direction).is_some();
        if !has_direction {
            missing.push(MissingPart::Direction);
        }
        missing
    }

    /// The line of the column names, from 1; `None` of a file without them.
    #[must_use]
    pub fn header_line(&self) -> Option<u32> {
        self.table.layout.header_line
    }

    /// The columns with what they were taken for.
    #[must_use]
    pub fn columns(&self) -> Vec<ColumnGuess> {
        let columns = self.table.layout.columns.iter().enumerate();
        columns
            .map(|(index, column)| {
                let mut places = self.found.places.iter();
                let found = places.find(|(_, (place, _))| *place == index);
                let is_repeat = self.repeats.contains(&column.name);
                let displacement = ColumnRole::Displacement;
                let stacked = self.found.places.get_key_value(&displacement);
                let found = found.or(stacked.filter(|_| is_repeat));
                ColumnGuess {
                    name: column.name.clone(),
                    role: found.map(|(role, _)| role.to_string()),
                    unit: self.shown_unit(index, found.map(|(role, _)| role)),
                    from: found.map(|(_, (_, from))| *from),
                    first_values: self.table.first_values(index),
                }
            })
            .collect()
    }

    pub(super) fn name(&self, index: usize) -> &str {
        self.table.name(index)
    }

    /// The unit of a column of forces, displacements or times.
    pub(super) fn unit(&self, index: usize, kind: Kind) -> Option<String> {
        let column = &self.table.layout.columns[index];
        self.mapping.unit_of(column, kind)
    }

    /// How a column of this kind becomes SI; as it is without a unit.
    pub(super) fn conversion(&self, index: usize, kind: Kind) -> Conversion {
        let unit = self.unit(index, kind);
        let conversion = unit.and_then(|unit| Conversion::from_unit(kind, &unit));
        conversion.unwrap_or(Conversion::NONE)
    }

    /// Whether the mapping or a column states a unit of this kind.
    fn states_unit(&self, kind: Kind) -> bool {
        let columns = 0..self.table.layout.columns.len();
        columns
            .into_iter()
            .any(|index| self.unit(index, kind).is_some())
    }

    fn shown_unit(&self, index: usize, role: Option<&ColumnRole>) -> Option<String> {
        let kind = match role {
            Some(ColumnRole::Force) => Kind::Force,
            Some(ColumnRole::Displacement) => Kind::Displacement,
            Some(ColumnRole::Joint(_)) => {
                return joint_unit((&self.table, &self.mapping, &self.found), index)
                    .map(|unit| unit.name);
            }
            _ => return self.table.layout.columns[index].unit.clone(),
        };
        self.unit(index, kind)
    }

    /// Two columns of one name of which one was guessed: nothing shows which is meant.
    fn refuse_duplicates(&self) -> Result<(), TableError> {
        for (role, (index, _)) in &self.found.places {
            let name = self.name(*index);
            let columns = self.table.layout.columns.iter().enumerate();
            let mut alike = columns.filter(|(other, c)| other != index && c.name == name);
            let stated = self.mapping.stated_column(role);
            let by_number = stated.is_some_and(|name| name.parse::<usize>().is_ok());
            if let Some((other, _)) = alike.next().filter(|_| !by_number && !name.is_empty()) {
                let (first, second) = ((*index).min(other), (*index).max(other));
                return Err(self
                    .table
                    .duplicate(name, &role.to_string(), [first, second]));
            }
        }
        for (role, places) in &self.found.candidates {
            let same = places
                .iter()
                .all(|index| self.name(*index) == self.name(places[0]));
            if let ([first, second, ..], true) = (places.as_slice(), same) {
                let name = self.name(*first);
                return Err(self
                    .table
                    .duplicate(name, &role.to_string(), [*first, *second]));
            }
        }
        Ok(())
    }
}
