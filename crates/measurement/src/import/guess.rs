//! Which column is what: as stated, else by names and units.

use std::collections::BTreeMap;

use super::columns::{ColumnRole, GuessedFrom};
use super::error::TableImportError;
use super::keywords::{plain, roles_of};
use super::mapping::ImportMapping;
use crate::table_files::{FileColumn, MachineTable, StampKind};
use stiffbench_units_and_text::nearest::{listed_names, nearest};

/// Columns by what they hold, with where that comes from.
#[derive(Debug, Clone, Default)]
pub(super) struct FoundColumns {
    pub(super) places: BTreeMap<ColumnRole, (usize, GuessedFrom)>,
    /// Columns that could equally be a force or a displacement.
    pub(super) candidates: BTreeMap<ColumnRole, Vec<usize>>,
}

impl FoundColumns {
    /// Finds columns.
    ///
    /// # Errors
    /// For a column that is stated and not there, or there twice, or stated for two things.
    pub(super) fn find(
        table: &MachineTable,
        mapping: &ImportMapping,
    ) -> Result<Self, TableImportError> {
        let mut found = Self::default();
        found.take_stated(table, mapping)?;
        found.guess(table);
        Ok(found)
    }

    pub(super) fn place(&self, role: &ColumnRole) -> Option<usize> {
        self.places.get(role).map(|(index, _)| *index)
    }

    /// The column of dates and that of the times of day that belong to them.
    pub(super) fn dates_and_times(&self, table: &MachineTable) -> Option<(usize, usize)> {
        let [dates, times] = [ColumnRole::Date, ColumnRole::Time].map(|role| self.place(&role));
        let is = |column: &usize, kind| table.stamp_kind(*column) == Some(kind);
        let times = times.filter(|column| is(column, StampKind::TimeOfDay))?;
        let dates = dates.filter(|column| is(column, StampKind::Date))?;
        Some((dates, times))
    }

    /// The columns of joint values, by variable.
    pub(super) fn joints(&self) -> impl Iterator<Item = (&str, usize)> {
        self.places
            .iter()
            .filter_map(|(role, (index, _))| match role {
                ColumnRole::Joint(name) => Some((name.as_str(), *index)),
                _ => None,
            })
    }

    fn take_stated(
        &mut self,
        table: &MachineTable,
        mapping: &ImportMapping,
    ) -> Result<(), TableImportError> {
        let joints = mapping.joints.keys().cloned().map(ColumnRole::Joint);
        for role in ColumnRole::NAMED.into_iter().chain(joints) {
            let Some(column) = mapping.stated_column(&role) else {
                continue;
            };
            let index = column_of(table, &role, &column)?;
            let taken = self.places.iter().find(|(_, (place, _))| *place == index);
            if let Some((first, _)) = taken {
                return Err(TableImportError::SameColumn {
                    file: table.source.clone(),
                    column,
                    first: first.to_string(),
                    second: role.to_string(),
                });
            }
            self.places.insert(role, (index, GuessedFrom::Stated));
        }
        Ok(())
    }

    fn guess(&mut self, table: &MachineTable) {
        let mut guesses: BTreeMap<ColumnRole, Vec<(u8, usize)>> = BTreeMap::new();
        for (index, column) in table.layout.columns.iter().enumerate() {
            if self.places.values().any(|(place, _)| *place == index) {
                continue;
            }
            for (role, sure) in roles_of(column, table.stamp_kind(index)) {
                guesses.entry(role).or_default().push((sure, index));
            }
        }
        for (role, mut columns) in guesses {
            columns.retain(|(_, index)| !self.is_taken(*index));
            let Some(most) = columns.iter().map(|(sure, _)| *sure).max() else {
                continue;
            };
            let best: Vec<usize> = columns
                .into_iter()
                .filter(|(sure, _)| *sure == most)
                .map(|(_, index)| index)
                .collect();
            let must_be_one = matches!(role, ColumnRole::Force | ColumnRole::Displacement);
            if self.places.contains_key(&role) {
                continue;
            }
            match best.as_slice() {
                [_, _, ..] if must_be_one => {
                    self.candidates.insert(role, best);
                }
                [first, ..] => {
                    let from = from_of(&role, &table.layout.columns[*first]);
                    self.places.insert(role, (*first, from));
                }
                [] => {}
            }
        }
    }

    fn is_taken(&self, index: usize) -> bool {
        self.places.values().any(|(place, _)| *place == index)
    }
}

/// Whether name or unit led to a role: without its unit, the same name is tried.
fn from_of(role: &ColumnRole, column: &FileColumn) -> GuessedFrom {
    let bare = FileColumn {
        unit: None,
        ..column.clone()
    };
    let by_name = roles_of(&bare, None).iter().any(|(found, _)| found == role);
    let is_read = matches!(role, ColumnRole::Force | ColumnRole::Displacement);
    if by_name || !is_read {
        GuessedFrom::Name
    } else {
        GuessedFrom::Unit
    }
}

/// The column of a name: as it stands in the file, without its unit, in other capitals; else a number from 1.
pub(super) fn column_of(
    table: &MachineTable,
    role: &ColumnRole,
    wanted: &str,
) -> Result<usize, TableImportError> {
    let columns = &table.layout.columns;
    let wanted = wanted.trim();
    let small = plain(wanted);
    let mut found = table.called(wanted);
    if found.is_empty() {
        let is_alike =
            |column: &FileColumn| plain(&column.name) == small || plain(&column.stem) == small;
        found = (0..columns.len()).collect();
        found.retain(|index| is_alike(&columns[*index]));
    }
    match found[..] {
        [one] => return Ok(one),
        [first, second, ..] => return Err(duplicate(table, role, wanted, first, second)),
        [] => {}
    }
    let number = wanted.parse::<usize>().ok();
    let index = number.and_then(|number| number.checked_sub(1));
    if let Some(index) = index.filter(|index| *index < columns.len()) {
        return Ok(index);
    }
    let advice = match nearest(wanted, table.names().filter(|name| !name.is_empty())) {
        Some(near) => format!("is `{near}` meant? --map {role}={near}"),
        None => format!("name one of these, or its number from 1: --map {role}=COLUMN"),
    };
    Err(TableImportError::UnknownColumn {
        at: table.header(),
        column: wanted.to_owned(),
        role: role.to_string(),
        found: listed_names(table.names()),
        advice,
    })
}

/// An error about two columns with one name, from places that count from 0.
pub(super) fn duplicate(
    table: &MachineTable,
    role: &ColumnRole,
    column: &str,
    first: usize,
    second: usize,
) -> TableImportError {
    TableImportError::DuplicateColumn {
        at: table.header(),
        column: column.to_owned(),
        role: role.to_string(),
        first: first + 1,
        second: second + 1,
    }
}
