//! A log of the force and a log of the displacement, paired by their times.

use super::columns::{ColumnRole, ImportedQuantity, MissingPart};
use super::guess::FoundColumns;
use super::mapping::ImportMapping;
use super::note::ImportNotes;
use crate::readings::{Conversion, TableError};
use crate::table_files::{MachineTable, read_table_file};
use stiffbench_numeric::statistics::median;
use stiffbench_units_and_text::count::counted;
use stiffbench_units_and_text::quantity::Kind;

/// The log of the displacement.
#[derive(Debug)]
pub(super) struct PairedLog {
    table: MachineTable,
    found: FoundColumns,
    unit: Option<String>,
}

impl PairedLog {
    pub(super) fn read(
        name: &str,
        bytes: &[u8],
        mapping: &ImportMapping,
    ) -> Result<Self, TableError> {
        let mut table = read_table_file(name, bytes, &mapping.of_file())?;
        let mut own = ImportMapping::default();
        own.columns
            .displacement
            .clone_from(&mapping.columns.displacement);
        let found = FoundColumns::find(&table, &own)?;
        if let Some((dates, times)) = found.dates_and_times(&table) {
            table.join_dates(dates, times);
        }
        let column = found.place(&ColumnRole::Displacement);
        let unit = column
            .and_then(|index| mapping.unit_of(&table.layout.columns[index], Kind::Displacement));
        Ok(Self { table, found, unit })
    }

    /// What the log does not state.
    pub(super) fn missing(&self) -> Option<MissingPart> {
        let quantity = ImportedQuantity::Displacement;
        let Some(index) = self.found.place(&ColumnRole::Displacement) else {
            let candidates = Vec::new();
            return Some(MissingPart::Column {
                quantity,
                candidates,
            });
        };
        let column = &self.table.layout.columns[index];
        self.unit.is_none().then(|| MissingPart::Unit {
            quantity,
            column: Some(column.name.clone()),
            unknown: column.unit.clone(),
        })
    }

    /// The displacement at the time of each row of the log of the force, m; `None` outside the times of this log.
    ///
    /// # Errors
    /// For logs without times, and cells that are no numbers.
    pub(super) fn displacements_m(
        &self,
        force: &MachineTable,
        force_time: Option<usize>,
        notes: &mut ImportNotes,
    ) -> Result<Vec<Option<f64>>, TableError> {
        let problem = |problem: &str| {
            TableError::new(
                "stiffbench::import::pairs",
                format!(
                    "{} and {} cannot be paired: {problem}",
                    force.source, self.table.source
                ),
                "both logs need a column of times of the same clock; name it with --map time=COLUMN",
            )
        };
        let (Some(of_force), Some(time)) = (force_time, self.found.place(&ColumnRole::Time)) else {
            return Err(problem("one of them has no column of times"));
        };
        let [wanted, known] = times(force, of_force, &self.table, time)?
            .ok_or_else(|| problem("one has times of day and the other seconds"))?;
        if are_all_equal(&wanted) || are_all_equal(&known) {
            return Err(problem(
                "all times of one of them are equal, as of a column of dates beside one of times",
            ));
        }
        let conversion = self.unit.as_ref();
        let conversion =
            conversion.and_then(|unit| Conversion::from_unit(Kind::Displacement, unit));
        let column = self.found.place(&ColumnRole::Displacement).unwrap_or(0);
        let values = self
            .table
            .numbers_in(column, conversion.unwrap_or(Conversion::NONE))?;
        let points = known.into_iter().zip(values);
        let mut points: Vec<_> = points.filter_map(|(time, value)| time.zip(value)).collect();
        points.sort_by(|a, b| a.0.total_cmp(&b.0));
        let interval_s = usual_interval(points.iter().map(|(time, _)| *time));
        let of_force_s = usual_interval(wanted.iter().copied().flatten());
        let paired = if interval_s > SPARSE * of_force_s {
            nearest(&points, &wanted, of_force_s)
        } else {
            let times = wanted.iter();
            let paired = times.map(|time| at(&points, GAP * interval_s, (*time)?));
            paired.collect()
        };
        let rows = paired.iter().flatten().count();
        if rows == 0 {
            return Err(problem("their times do not overlap"));
        }
        let rows = counted(rows, "value");
        notes.note(format!(
            "displacements were interpolated at the times of the forces: {rows}"
        ));
        Ok(paired)
    }
}

/// Times of two tables, on one clock, s; `None` if they cannot be.
fn times(
    a: &MachineTable,
    of_a: usize,
    b: &MachineTable,
    of_b: usize,
) -> Result<Option<[Vec<Option<f64>>; 2]>, TableError> {
    match (a.is_time_stamp(of_a), b.is_time_stamp(of_b)) {
        (true, true) => Ok(Some(a.seconds_with(of_a, b, of_b)?)),
        (false, false) => Ok(Some([a.numbers(of_a)?, b.numbers(of_b)?])),
        _ => Ok(None),
    }
}

/// Usual intervals beyond which a log has a gap, in which nothing is known.
const GAP: f64 = 5.0;

/// A log of displacements whose intervals are so many times those of the force was read at some moments, as by a button: between them nothing is
/// known of the displacement, and the force is taken at its moments.
const SPARSE: f64 = 3.0;

/// The median interval of a log, s.
fn usual_interval(times: impl Iterator<Item = f64> + Clone) -> f64 {
    let intervals = times.clone().skip(1).zip(times);
    let mut intervals: Vec<f64> = intervals.map(|(next, time)| next - time).collect();
    median(&mut intervals).unwrap_or_default()
}

/// Each value at the time that is nearest to its own, and no further than an interval.
fn nearest(points: &[(f64, f64)], times: &[Option<f64>], interval_s: f64) -> Vec<Option<f64>> {
    let mut paired = vec![None; times.len()];
    let known = times.iter().enumerate();
    let mut known: Vec<(f64, usize)> = known.filter_map(|(row, at)| Some(((*at)?, row))).collect();
    known.sort_by(|a, b| a.0.total_cmp(&b.0));
    for (time, value) in points {
        let distance = |of: &f64| (of - time).abs();
        let next = known.partition_point(|(of, _)| of < time);
        let both = known[next.saturating_sub(1)..].iter().take(2);
        let near = both.min_by(|a, b| distance(&a.0).total_cmp(&distance(&b.0)));
        if let Some((_, row)) = near.filter(|(of, _)| distance(of) <= interval_s) {
            paired[*row] = Some(*value);
        }
    }
    paired
}

/// The value at a time, on the line between its neighbours; `None` outside, and between neighbours that are further apart than `longest`.
fn at(points: &[(f64, f64)], longest: f64, time: f64) -> Option<f64> {
    let next = points.partition_point(|(known, _)| *known < time);
    let (t1, y1) = *points.get(next)?;
    if t1 == time {
        return Some(y1);
    }
    let (t0, y0) = *points.get(next.checked_sub(1)?)?;
    if t1 - t0 > longest {
        return None;
    }
    Some(y0 + (y1 - y0) * (time - t0) / (t1 - t0))
}

/// Whether times tell nothing: a column of dates, whose times of day stand in another.
pub(super) fn are_all_equal(times: &[Option<f64>]) -> bool {
    let mut known = times.iter().flatten();
    let first = known.next();
    known.clone().next().is_some() && known.all(|time| Some(time) == first)
}

#[cfg(test)]
mod tests {
    use super::{at, nearest};

    #[test]
    fn a_value_by_a_button_belongs_to_the_force_of_its_moment() {
        let times = [Some(0.0), Some(0.5), None, Some(1.0), Some(1.5)];
        let points = [(0.6, 7.0), (1.5, 8.0), (9.0, 9.0)];
        let expected = [None, Some(7.0), None, None, Some(8.0)];
        assert_eq!(nearest(&points, &times, 0.5), expected);
    }

    #[test]
    fn values_lie_on_the_line_between_neighbours() {
        let points = [(0.0, 1.0), (1.0, 3.0), (1.0, 5.0)];
        assert_eq!(at(&points, 2.0, 0.5), Some(2.0));
        assert_eq!(at(&points, 2.0, 0.0), Some(1.0));
        assert_eq!(at(&points, 2.0, 1.0), Some(3.0));
        assert_eq!(
            (at(&points, 2.0, 1.1), at(&points, 2.0, -0.1)),
            (None, None)
        );
        assert_eq!(at(&[], 2.0, 0.0), None);
        assert_eq!(at(&points, 0.5, 0.5), None);
    }
}
