//! The order of measurement, and time that does not follow it.

use std::collections::{HashMap, HashSet};

use indexmap::IndexSet;

use super::row::SpecimenRow;
use super::table::SpecimenReading;
use stiffbench_units_and_text::count::counted;

/// Puts rows in the order of their numbers, or numbers them as they stand if the numbers cannot be used; states what was done.
///
/// Numbers may count through the whole table, or start again in each run.
pub(super) fn put_in_order(rows: &mut [SpecimenRow]) -> Option<String> {
    let Some(numbers) = rows.iter().map(|row| row.order).collect::<Option<Vec<_>>>() else {
        number_as_they_stand(rows);
        return None;
    };
    if numbers.is_sorted_by(|a, b| a < b) {
        return None;
    }
    let mut seen = HashSet::new();
    if numbers.iter().all(|number| seen.insert(*number)) {
        rows.sort_by_key(|row| row.order);
        return Some("rows were sorted by the order column".to_owned());
    }
    let mut within_runs = HashSet::new();
    let repeated = rows
        .iter()
        .find(|row| !within_runs.insert((&row.configuration, &row.run, row.order)));
    if let Some(row) = repeated {
        let line = row.reading.line;
        number_as_they_stand(rows);
        return Some(format!(
            "the number in the order column of line {line} occurs before: rows are numbered in the order of the file"
        ));
    }
    sort_within_runs(rows)
}

fn number_as_they_stand(rows: &mut [SpecimenRow]) {
    for (row, number) in rows.iter_mut().zip(1..) {
        row.order = Some(number);
    }
}

/// Runs follow each other in the order in which they appear.
fn sort_within_runs(rows: &mut [SpecimenRow]) -> Option<String> {
    let run = |row: &SpecimenRow| (row.configuration.clone(), row.run.clone());
    let runs: IndexSet<(String, String)> = rows.iter().map(run).collect();
    let place = |row: &SpecimenRow| (runs.get_index_of(&run(row)), row.order);
    if rows.is_sorted_by_key(place) {
        return None;
    }
    rows.sort_by_cached_key(place);
    let said = "the order column starts again in each run: rows were sorted within their runs";
    Some(said.to_owned())
}

/// Runs in which a reading has an earlier time than the one before it.
pub(super) fn time_goes_back(readings: &[SpecimenReading]) -> Option<String> {
    let mut latest: HashMap<u32, f64> = HashMap::new();
    let mut runs = HashSet::new();
    let mut line = None;
    for reading in readings {
        let Some(time_s) = reading.time_s else {
            continue;
        };
        let before = latest.insert(reading.run, time_s);
        if before.is_some_and(|before| time_s < before) {
            runs.insert(reading.run);
            line.get_or_insert(reading.line);
        }
    }
    Some(format!(
        "in {} time goes back, first in line {}; the order of the readings was kept",
        counted(runs.len(), "run"),
        line?
    ))
}
