//! Which column is what: as stated, else by names and units.

use std::collections::BTreeMap;

use indexmap::IndexMap;

use super::columns::{ColumnRole, GuessedFrom};
use super::keywords::{OF_A_PART, OF_A_ROBOT, ReadQuantities, roles_of};
use super::mapping::ImportMapping;
use super::runs::{CounterDoubt, counts_no_runs};
use crate::readings::{TableError, are_one_load};
use crate::table_files::keywords::{REPEAT, has, plain, words_of};
use crate::table_files::{FileColumn, MachineTable, StampKind};

/// Columns by what they hold, with where that comes from.
#[derive(Debug, Clone, Default)]
pub(super) struct FoundColumns {
    pub(super) places: BTreeMap<ColumnRole, (usize, GuessedFrom)>,
    /// Columns that could equally be a force or a displacement.
    pub(super) candidates: BTreeMap<ColumnRole, Vec<usize>>,
    /// Columns that could number the runs or the poses and do not, with why.
    pub(super) counters: Vec<(ColumnRole, usize, CounterDoubt)>,
    /// Columns of one name, of which nothing shows which is meant, and that are not needed.
    pub(super) ambiguous: Vec<(ColumnRole, [usize; 2])>,
}

impl FoundColumns {
    /// Finds columns.
    ///
    /// # Errors
    /// For a column that is stated and not there, or there twice, or stated for two things.
    pub(super) fn find(table: &MachineTable, mapping: &ImportMapping) -> Result<Self, TableError> {
        let mut found = Self::default();
        found.take_stated(table, mapping)?;
        let read = if mapping.is_of_a_part {
            &OF_A_PART
        } else {
            &OF_A_ROBOT
        };
        found.guess(table, read);
        found.drop_counter_of_loads(table);
        found.drop_counter(table);
        found.drop_ambiguous(table);
        Ok(found)
    }

    /// Columns of displacements that are the repeats of one load column: those that are stated, or that are numbered as repeats.
    ///
    /// # Errors
    /// For a column that is stated and not there.
    pub(super) fn repeats_beside_each_other(
        &self,
        table: &MachineTable,
        mapping: &ImportMapping,
    ) -> Result<Vec<usize>, TableError> {
        let role = ColumnRole::Displacement;
        let further = &mapping.columns.repeats;
        if let Some(first) = self.place(&role).filter(|_| !further.is_empty()) {
            let further = further
                .iter()
                .map(|name| table.column(name, "displacement"));
            return std::iter::once(Ok(first)).chain(further).collect();
        }
        let places = self.candidates.get(&role).map_or(&[][..], Vec::as_slice);
        let unit = |place: &usize| &table.layout.columns[*place].unit;
        let is_repeat = |place: &usize| {
            let name = plain(table.name(*place));
            unit(place) == unit(&places[0]) && words_of(&name).any(|word| has(REPEAT, word))
        };
        let has_loads = self.place(&ColumnRole::Force).is_some();
        let are_repeats =
            has_loads && places.iter().all(is_repeat) && self.place(&ColumnRole::Repeat).is_none();
        Ok(if are_repeats {
            places.to_vec()
        } else {
            Vec::new()
        })
    }

    /// The column of a role by its name alone, and that of the force.
    fn guessed_beside_force(&self, role: &ColumnRole) -> Option<(usize, usize)> {
        let (column, from) = *self.places.get(role)?;
        let force = self.place(&ColumnRole::Force)?;
        (from == GuessedFrom::Name).then_some((column, force))
    }

    /// Takes no runs from a guessed column that counts something else.
    fn drop_counter(&mut self, table: &MachineTable) {
        let role = ColumnRole::Repeat;
        let Some((column, force)) = self.guessed_beside_force(&role) else {
            return;
        };
        let loads = table.numbers(force).unwrap_or_default();
        let of_cell = [ColumnRole::Pose, ColumnRole::Direction].map(|role| self.place(&role));
        let joints: Vec<usize> = self.joints().map(|(_, index)| index).collect();
        let columns: Vec<usize> = of_cell.into_iter().flatten().chain(joints).collect();
        let mut cells: IndexMap<Vec<&str>, IndexMap<&str, Vec<f64>>> = IndexMap::new();
        let mut last = None;
        for (row, load) in loads.into_iter().enumerate() {
            let Some(load) = load else { continue };
            let cell = columns
                .iter()
                .map(|index| table.text(row, *index))
                .collect();
            let (of_cell, cell) = {
                let entry = cells.entry(cell);
                (entry.index(), entry.or_default())
            };
            let text = table.text(row, column);
            if cell.contains_key(text) && last != Some((of_cell, text)) {
                // Repeats that come by turns are no counter.
                return;
            }
            last = Some((of_cell, text));
            cell.entry(text).or_default().push(load);
        }
        let why = cells.values().find_map(|cell| {
            let stretches: Vec<&[f64]> = cell.values().map(Vec::as_slice).collect();
            counts_no_runs(&stretches)
        });
        if let Some(why) = why {
            self.places.remove(&role);
            self.counters.push((role, column, why));
        }
    }

    /// Takes no poses from guessed numbers of which each stands at a load of its own: they count readings, or the loads of a run.
    fn drop_counter_of_loads(&mut self, table: &MachineTable) {
        /// Loads are the same within this share of their range.
        const SAME: f64 = 0.05;
        let role = ColumnRole::Pose;
        let Some((column, force)) = self.guessed_beside_force(&role) else {
            return;
        };
        if !table.layout.columns[column].is_numeric {
            return;
        }
        let loads = table.numbers(force).unwrap_or_default();
        let mut of_number: BTreeMap<&str, [f64; 2]> = BTreeMap::new();
        let mut whole = [f64::INFINITY, f64::NEG_INFINITY];
        let wider = |[low, high]: [f64; 2], load: f64| [low.min(load), high.max(load)];
        for (row, load) in loads.into_iter().enumerate() {
            let Some(load) = load else { continue };
            let range = of_number.entry(table.text(row, column));
            let range = range.or_insert([f64::INFINITY, f64::NEG_INFINITY]);
            *range = wider(*range, load);
            whole = wider(whole, load);
        }
        let most = SAME * (whole[1] - whole[0]);
        let has_one_load = |[low, high]: &[f64; 2]| high - low <= most;
        if of_number.len() > 2
            && !are_one_load(whole.into_iter())
            && of_number.values().all(has_one_load)
        {
            self.places.remove(&role);
            let why = CounterDoubt::OneLoadEach;
            self.counters.push((role, column, why));
        }
    }

    /// Takes nothing from guessed columns that are not needed and share their name with another.
    fn drop_ambiguous(&mut self, table: &MachineTable) {
        let columns = &table.layout.columns;
        self.places.retain(|role, (index, from)| {
            let is_needed = matches!(role, ColumnRole::Force | ColumnRole::Displacement);
            let is_alike =
                |other: &usize| other != index && columns[*other].name == columns[*index].name;
            let other = (0..columns.len()).find(is_alike);
            let Some(other) = other.filter(|_| !is_needed && *from != GuessedFrom::Stated) else {
                return true;
            };
            self.ambiguous.push((role.clone(), [*index, other]));
            false
        });
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
    ) -> Result<(), TableError> {
        let joints = mapping.joints.keys().cloned().map(ColumnRole::Joint);
        for role in ColumnRole::NAMED.into_iter().chain(joints) {
            let Some(column) = mapping.stated_column(&role) else {
                continue;
            };
            let index = table.column(&column, &role.to_string())?;
            let taken = self.places.iter().find(|(_, (place, _))| *place == index);
            if let Some((first, _)) = taken {
                return Err(table.same_column(&column, &first.to_string(), &role.to_string()));
            }
            self.places.insert(role, (index, GuessedFrom::Stated));
        }
        Ok(())
    }

    fn guess(&mut self, table: &MachineTable, read: &ReadQuantities) {
        let mut guesses: BTreeMap<ColumnRole, Vec<(u8, usize)>> = BTreeMap::new();
        for (index, column) in table.layout.columns.iter().enumerate() {
            if self.places.values().any(|(place, _)| *place == index) {
                continue;
            }
            for (role, sure) in roles_of(column, read, table.stamp_kind(index)) {
                guesses.entry(role).or_default().push((sure, index));
            }
        }
        for (role, mut columns) in guesses {
            columns.retain(|(_, index)| !self.is_taken(*index));
            if role == ColumnRole::Time {
                let best = columns
                    .iter()
                    .map(|(_, index)| progress(table, *index))
                    .max();
                columns.retain(|(_, index)| Some(progress(table, *index)) == best);
            }
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
                    let from = from_of(&role, &table.layout.columns[*first], read);
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

/// How much a column of times tells: never back is more than sometimes, and anything more than the same in all rows.
fn progress(table: &MachineTable, column: usize) -> u8 {
    let times = if table.is_time_stamp(column) {
        table.seconds(column)
    } else {
        table.numbers(column)
    };
    let times: Vec<f64> = times.unwrap_or_default().into_iter().flatten().collect();
    let goes = |is: fn(&f64, &f64) -> bool| times.windows(2).any(|two| is(&two[1], &two[0]));
    u8::from(goes(f64::gt)) * (1 + u8::from(!goes(f64::lt)))
}

/// Whether name or unit led to a role: without its unit, the same name is tried.
fn from_of(role: &ColumnRole, column: &FileColumn, read: &ReadQuantities) -> GuessedFrom {
    let bare = FileColumn {
        unit: None,
        ..column.clone()
    };
    let by_name = roles_of(&bare, read, None)
        .iter()
        .any(|(found, _)| found == role);
    let is_read = matches!(role, ColumnRole::Force | ColumnRole::Displacement);
    if by_name || !is_read {
        GuessedFrom::Name
    } else {
        GuessedFrom::Unit
    }
}
