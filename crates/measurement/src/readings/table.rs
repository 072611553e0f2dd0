//! A table of readings, with everything its reader assumed.

use std::collections::{HashMap, HashSet};
use std::fmt;

use super::assumption::{Excluded, first_in_line};
use super::column::Column;
use super::error::{TableError, line_of};
use super::joint_values::PoseJoints;
use super::reading::{Reading, ReadingStatus};
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::nearest::{listed_names, nearest};
use stiffbench_units_and_text::test_point::{Cell, Direction, PoseId};

/// What the readings of one run, or of one gauge zero, have in common.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct RunKey {
    /// The pose held.
    pub pose: PoseId,
    /// The direction loaded.
    pub direction: Direction,
    /// Repeat of its first reading.
    pub repeat: u32,
    /// Its name under `run` or `zero_id`; `None` where pose, direction and repeat are the name.
    pub label: Option<Box<str>>,
}

impl RunKey {
    /// The run of a pose, direction and repeat.
    #[must_use]
    pub fn of_repeat(pose: PoseId, direction: Direction, repeat: u32) -> Self {
        Self {
            pose,
            direction,
            repeat,
            label: None,
        }
    }

    /// The cell it belongs to.
    #[must_use]
    pub fn cell(&self) -> Cell {
        Cell::new(self.pose.clone(), self.direction)
    }
}

impl fmt::Display for RunKey {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} {} ", self.pose, self.direction)?;
        match &self.label {
            Some(label) => f.write_str(label),
            None => write!(f, "{}", self.repeat),
        }
    }
}

/// Numbers runs (or gauge zeros) in the order in which they first appear.
///
/// A label names a run within its pose and direction: the same label in another cell is another run. Without a label the repeat tells
/// runs apart.
#[derive(Debug, Default)]
pub struct RunNumbers {
    keys: Vec<RunKey>,
    /// Keys without the repeat where a label is the name.
    by_name: HashMap<RunKey, u32>,
    last: u32,
}

impl RunNumbers {
    /// The number of the run with this name, a new one if it is new.
    pub fn number(
        &mut self,
        pose: &PoseId,
        direction: Direction,
        repeat: u32,
        label: Option<&str>,
    ) -> u32 {
        // Most readings belong to the run of the reading before.
        if let Some(key) = self.keys.get(self.last as usize) {
            let same_name = match (&key.label, label) {
                (None, None) => key.repeat == repeat,
                (Some(known), Some(label)) => **known == *label,
                _ => false,
            };
            if same_name && key.direction == direction && key.pose == *pose {
                return self.last;
            }
        }
        let next = self.keys.len() as u32;
        let key = RunKey {
            pose: pose.clone(),
            direction,
            repeat,
            label: label.map(Into::into),
        };
        let mut name = key.clone();
        if label.is_some() {
            name.repeat = 0;
        }
        self.last = *self.by_name.entry(name).or_insert_with(|| {
            self.keys.push(key);
            next
        });
        self.last
    }

    /// The runs, by number.
    #[must_use]
    pub fn into_keys(self) -> Vec<RunKey> {
        self.keys
    }
}

/// Readings of one session, in the order in which they were made, with everything their reader assumed.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReadingTable {
    /// Where the readings come from, as the caller named it.
    pub source: String,
    /// The session they belong to, if known.
    pub session: Option<String>,
    /// How the readings came about if they were not measured.
    pub origin: Option<String>,
    /// All readings, those that do not count included.
    pub readings: Vec<Reading>,
    /// Joint values of poses, where the table states them.
    pub pose_joints: Vec<PoseJoints>,
    /// Directions of loads that are not those of the displacements read under them.
    pub load_directions: Vec<LoadDirection>,
    /// What the readings of a run have in common, by [`Reading::run`].
    pub runs: Vec<RunKey>,
    /// What the readings of a gauge zero have in common, by [`Reading::zero`].
    pub zeros: Vec<RunKey>,
    /// The columns that hold at least one value, in written order.
    pub columns: Vec<Column>,
    /// What the reader decided where the file leaves it open.
    pub assumptions: Vec<String>,
    /// What does not count.
    pub excluded: Excluded,
    /// What an analysis should know.
    pub notes: Vec<String>,
    /// What the load of each run is called in a file of readings along the base axes, by [`Reading::run`].
    pub load_names: Vec<String>,
    /// A reading of each load of the series without any force, whose direction nobody knows: kept, but in no run and no analysis.
    pub unloaded: Vec<Reading>,
    /// The file as it stands, of readings along the base axes; else empty.
    pub fields: FileFields,
}

/// The fields of a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct FileFields {
    /// Column names.
    pub names: Vec<String>,
    /// Its rows, in order.
    pub rows: Vec<FieldRow>,
}

/// The fields of a row.
#[derive(Debug, Clone, PartialEq)]
pub struct FieldRow {
    /// Line of the file, from 1.
    pub line: u32,
    /// Number of the reading in its session.
    pub seq: u32,
    /// A field for each name.
    pub fields: Vec<String>,
}

impl ReadingTable {
    /// Whether its file has forces and displacements along the base axes.
    #[must_use]
    pub fn is_of_vectors(&self) -> bool {
        !self.fields.names.is_empty()
    }

    /// Whether each load was read by one gauge, along the load.
    #[must_use]
    pub fn is_of_one_gauge(&self) -> bool {
        let at_once = self
            .readings
            .windows(2)
            .any(|pair| pair[0].seq == pair[1].seq);
        self.load_directions.is_empty() && !at_once
    }

    /// The readings of each load: one of each gauge.
    pub fn loads(&self) -> impl Iterator<Item = &[Reading]> {
        let readings = &self.readings;
        readings.chunk_by(|a, b| (a.seq, a.line) == (b.seq, b.line))
    }

    /// One reading of each load, those included whose direction nobody knows.
    pub fn one_of_each_load(&self) -> impl Iterator<Item = &Reading> {
        let known = self.loads().filter_map(<[Reading]>::first);
        known.chain(&self.unloaded)
    }

    /// The cell of a reading.
    #[must_use]
    pub fn cell(&self, reading: &Reading) -> Cell {
        let other = reading.load.map(|_| self.load_direction(reading).called());
        Cell {
            load: other,
            ..reading.cell()
        }
    }

    /// The direction of the load of a reading.
    #[must_use]
    pub fn load_direction(&self, reading: &Reading) -> LoadDirection {
        let other = reading.load.map(usize::from);
        let other = other.and_then(|place| self.load_directions.get(place));
        other.cloned().unwrap_or(reading.direction.into())
    }

    /// What the load of a reading is called, in its file if that names it.
    #[must_use]
    pub fn load_name(&self, reading: &Reading) -> String {
        let name = self.load_names.get(reading.run as usize).cloned();
        name.unwrap_or_else(|| self.load_direction(reading).to_string())
    }

    /// The place of a direction among those of loads that are not along the displacement.
    pub fn place_of(&mut self, load: &LoadDirection) -> u16 {
        let known = self.load_directions.iter().position(|known| known == load);
        let place = known.unwrap_or_else(|| {
            self.load_directions.push(load.clone());
            self.load_directions.len() - 1
        });
        u16::try_from(place).unwrap_or(u16::MAX)
    }

    /// The readings that count.
    pub fn accepted(&self) -> impl Iterator<Item = &Reading> {
        self.readings.iter().filter(|reading| reading.is_accepted())
    }

    /// The cells of all readings, in the order in which they first appear.
    #[must_use]
    pub fn cells(&self) -> Vec<Cell> {
        let mut seen = HashSet::new();
        let cells = self.runs.iter().map(RunKey::cell);
        cells.filter(|cell| seen.insert(cell.clone())).collect()
    }

    /// The poses of all readings, in the order in which they first appear.
    #[must_use]
    pub fn poses(&self) -> Vec<PoseId> {
        let mut seen = HashSet::new();
        self.runs
            .iter()
            .filter(|run| seen.insert(&run.pose))
            .map(|run| run.pose.clone())
            .collect()
    }

    /// Whether at least one value stands in a column; what cannot be tested without it depends on that.
    #[must_use]
    pub fn has(&self, column: Column) -> bool {
        self.columns.contains(&column)
    }

    /// Works out `excluded` and the notes on cells from the readings.
    pub(super) fn take_stock(&mut self) {
        for reading in &self.readings {
            match reading.status {
                ReadingStatus::Accepted => {}
                ReadingStatus::Superseded => self.excluded.superseded.push(reading.line),
                ReadingStatus::Rejected => self.excluded.rejected.push(reading.line),
            }
        }
        let unloaded: Vec<u32> = self
            .accepted()
            .filter(|reading| reading.force_n == 0.0 && reading.target_n != 0.0)
            .map(|reading| reading.line)
            .collect();
        let what = "zero force at a target load other than zero";
        self.notes.extend(first_in_line(what, &unloaded));
        self.note_duplicates();
        self.note_cells();
    }

    /// Rows of a run that agree in every number. Unloaded readings of a coarse gauge may well agree, loaded ones of one branch hardly.
    fn note_duplicates(&mut self) {
        let mut seen = HashSet::new();
        let loaded = self.accepted().filter(|reading| reading.force_n != 0.0);
        let twice: Vec<u32> = loaded
            .filter(|reading| {
                let numbers = [
                    reading.force_n,
                    reading.displacement_m,
                    reading.target_n,
                    reading.time_s.unwrap_or(f64::NAN),
                    reading.hold_s.unwrap_or(f64::NAN),
                ];
                let bits = numbers.map(f64::to_bits);
                !seen.insert((reading.run, reading.branch, reading.repeat, bits))
            })
            .map(|reading| reading.line)
            .collect();
        let what = "identical in every number to an earlier row of the same run";
        let twice = first_in_line(what, &twice);
        let asked = twice.map(|twice| format!("{twice}; was part of the file pasted twice?"));
        self.notes.extend(asked);
    }

    fn note_cells(&mut self) {
        let cells = self.cells();
        let place_of: HashMap<&Cell, usize> = cells.iter().zip(0..).collect();
        let cell_of_run: Vec<usize> = self.runs.iter().map(|run| place_of[&run.cell()]).collect();
        let mut seen: Vec<Option<SeenCell>> = vec![None; cells.len()];
        for reading in self.accepted() {
            let cell = seen[cell_of_run[reading.run as usize]].get_or_insert(SeenCell {
                repeat: reading.repeat,
                several_repeats: false,
                loaded: false,
            });
            cell.several_repeats |= reading.repeat != cell.repeat;
            cell.loaded |= reading.force_n != 0.0;
        }
        for (cell, seen) in cells.iter().zip(&seen) {
            let Some(seen) = seen else { continue };
            if !seen.several_repeats {
                self.notes.push(format!(
                    "{cell} has one repeat: the scatter between repeats is unknown"
                ));
            }
            if !seen.loaded {
                self.notes.push(format!(
                    "{cell} has no force other than zero, so it has no stiffness"
                ));
            }
        }
    }
}

/// What the accepted readings of a cell show.
#[derive(Clone)]
struct SeenCell {
    repeat: u32,
    several_repeats: bool,
    loaded: bool,
}

/// Checks that every pose of a table is one of `known`, the poses of the robot or procedure file.
///
/// # Errors
/// [`TableError`] for the first pose that is not, with its first line and the nearest known name.
pub fn check_poses(table: &ReadingTable, known: &[PoseId]) -> Result<(), TableError> {
    let Some(pose) = table.poses().into_iter().find(|pose| !known.contains(pose)) else {
        return Ok(());
    };
    let line = table
        .readings
        .iter()
        .find(|reading| reading.pose == pose)
        .map_or(0, |reading| reading.line);
    let advice = match nearest(pose.as_str(), known.iter().map(PoseId::as_str)) {
        Some(near) => format!("is `{near}` meant?"),
        None => "correct the name, or add the pose to the robot or procedure file".to_owned(),
    };
    let at = line_of(&table.source, line);
    let known = listed_names(known.iter().map(PoseId::as_str));
    Err(TableError::new(
        "stiffbench::readings::unknown_pose",
        format!("{at}, column `pose`: `{pose}` is not one of the known poses {known}"),
        advice,
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_name_runs_within_their_cell() {
        let (p1, p2) = (PoseId::new("P1"), PoseId::new("P2"));
        let mut numbers = RunNumbers::default();
        assert_eq!(numbers.number(&p1, Direction::X, 1, None), 0);
        assert_eq!(numbers.number(&p1, Direction::X, 1, None), 0);
        assert_eq!(numbers.number(&p1, Direction::X, 2, None), 1);
        assert_eq!(numbers.number(&p1, Direction::X, 1, Some("1")), 2);
        assert_eq!(numbers.number(&p1, Direction::X, 2, Some("1")), 2);
        assert_eq!(numbers.number(&p2, Direction::X, 2, Some("1")), 3);
        assert_eq!(numbers.number(&p1, Direction::Y, 2, Some("1")), 4);
        assert_eq!(numbers.number(&p1, Direction::X, 1, None), 0);
        let names: Vec<String> = numbers
            .into_keys()
            .iter()
            .map(ToString::to_string)
            .collect();
        assert_eq!(names, ["P1 x 1", "P1 x 2", "P1 x 1", "P2 x 1", "P1 y 1"]);
    }
}
