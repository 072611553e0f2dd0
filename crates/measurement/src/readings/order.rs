//! The order of readings, and readings that occur twice.

use std::cmp::Ordering;

use super::error::{TableError, line_of};
use super::reading::Reading;
use super::table::{ReadingTable, RunKey, RunNumbers};

/// Sorts readings by their sequence numbers, or numbers them as they stand if the numbers cannot be used.
pub(super) fn put_in_order(table: &mut ReadingTable) {
    if table.readings.is_sorted_by(|a, b| a.seq < b.seq) {
        return;
    }
    let mut numbers: Vec<u32> = table.readings.iter().map(|reading| reading.seq).collect();
    numbers.sort_unstable();
    if numbers.windows(2).any(|pair| pair[0] == pair[1]) {
        for (index, reading) in table.readings.iter_mut().enumerate() {
            reading.seq = index as u32 + 1;
        }
        let said =
            "numbers under `seq` occur more than once; rows are numbered in the order of the file";
        table.assumptions.push(said.to_owned());
        return;
    }
    table.readings.sort_unstable_by_key(|reading| reading.seq);
    let said = "rows were sorted by `seq`".to_owned();
    table.assumptions.push(said);
    renumber(table);
}

/// Numbers runs and zeros in the order in which they now appear.
fn renumber(table: &mut ReadingTable) {
    let (mut runs, mut zeros) = (RunNumbers::default(), RunNumbers::default());
    for reading in &mut table.readings {
        let label = |keys: &[RunKey], index: u32| keys[index as usize].label.clone();
        let number = |numbers: &mut RunNumbers, label: Option<Box<str>>| {
            numbers.number(
                &reading.pose,
                reading.direction,
                reading.repeat,
                label.as_deref(),
            )
        };
        let run = number(&mut runs, label(&table.runs, reading.run));
        let zero = number(&mut zeros, label(&table.zeros, reading.zero));
        (reading.run, reading.zero) = (run, zero);
    }
    table.runs = runs.into_keys();
    table.zeros = zeros.into_keys();
}

/// The order of test points; equal means that two readings of one run claim the same one.
fn by_test_point(a: &Reading, b: &Reading) -> Ordering {
    let hold = |reading: &Reading| reading.hold_s.unwrap_or(-1.0);
    a.pose
        .cmp(&b.pose)
        .then(a.direction.cmp(&b.direction))
        .then(a.repeat.cmp(&b.repeat))
        .then(a.run.cmp(&b.run))
        .then(a.branch.cmp(&b.branch))
        .then(a.step.cmp(&b.step))
        .then(a.attempt.cmp(&b.attempt))
        .then(hold(a).total_cmp(&hold(b)))
}

/// Pairs of indices of accepted readings that are equal under `order`, earlier index first, sorted by the later one.
fn equal_pairs(
    table: &ReadingTable,
    order: impl Fn(&Reading, &Reading) -> Ordering,
) -> Vec<(u32, u32)> {
    let reading = |index: u32| &table.readings[index as usize];
    let mut indices: Vec<u32> = (0..table.readings.len() as u32)
        .filter(|index| reading(*index).is_accepted())
        .collect();
    // Sorting indices takes a fraction of the memory of a set of keys, and tables mostly are in order already.
    indices.sort_unstable_by(|a, b| order(reading(*a), reading(*b)).then(a.cmp(b)));
    let mut pairs: Vec<(u32, u32)> = indices
        .windows(2)
        .filter(|pair| order(reading(pair[0]), reading(pair[1])) == Ordering::Equal)
        .map(|pair| (pair[0], pair[1]))
        .collect();
    pairs.sort_unstable_by_key(|pair| pair.1);
    pairs
}

/// # Errors
/// [`TableError`] if two accepted readings claim the same test point, attempt and hold.
pub(super) fn refuse_duplicates(table: &ReadingTable) -> Result<(), TableError> {
    let Some((first, second)) = equal_pairs(table, by_test_point).first().copied() else {
        return Ok(());
    };
    let (first, second) = (
        &table.readings[first as usize],
        &table.readings[second as usize],
    );
    Err(TableError::new(
        "stiffbench::readings::duplicate_reading",
        format!(
            "{}: the same reading as line {} ({} {}, {}, step {}, repeat {}, attempt {}), both accepted",
            line_of(&table.source, second.line.max(first.line)),
            first.line.min(second.line),
            second.pose,
            second.direction,
            second.branch,
            second.step,
            second.repeat,
            second.attempt
        ),
        "mark one of them `superseded` under `status`, or distinguish them by `attempt` or `hold_s`",
    ))
}

/// Without steps a row that occurs twice cannot be distinguished from two readings that agree; both are kept and reported.
pub(super) fn note_repeated_rows(table: &mut ReadingTable) {
    let order = |a: &Reading, b: &Reading| {
        let time = |reading: &Reading| reading.time_s.unwrap_or(f64::NEG_INFINITY);
        let hold = |reading: &Reading| reading.hold_s.unwrap_or(f64::NEG_INFINITY);
        (a.run, a.repeat, a.branch, a.attempt)
            .cmp(&(b.run, b.repeat, b.branch, b.attempt))
            .then(a.force_n.total_cmp(&b.force_n))
            .then(a.displacement_m.total_cmp(&b.displacement_m))
            .then(time(a).total_cmp(&time(b)))
            .then(hold(a).total_cmp(&hold(b)))
    };
    for pair in equal_pairs(table, order) {
        let [first, line] = [pair.0, pair.1].map(|index| table.readings[index as usize].line);
        table.assumptions.push(format!(
            "line {line} repeats line {first} word for word; both are kept as separate readings"
        ));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::readings::defaults::tests::assumes;
    use crate::readings::read_readings;

    fn read(text: &str) -> Result<ReadingTable, TableError> {
        read_readings("t.csv", text.as_bytes())
    }

    const HEADER: &str = "seq,pose,direction,repeat,force_N,displacement_um,step,hold_s,status\n";

    #[test]
    fn rows_follow_their_sequence_numbers() {
        let text = format!("{HEADER}7,P2,x,1,0,0,0,,\n3,P1,x,1,0,0,0,,\n5,P1,x,2,0,0,0,,\n");
        let table = read(&text).unwrap();
        let order: Vec<(u32, u32)> = table.readings.iter().map(|r| (r.seq, r.run)).collect();
        assert_eq!(order, [(3, 0), (5, 1), (7, 2)]);
        assert_eq!(table.cells()[0].to_string(), "P1 x");
        assert!(assumes(&table, "rows were sorted by `seq`"));
    }

    #[test]
    fn sequence_numbers_that_repeat_are_not_used() {
        let text = format!("{HEADER}1,P1,x,1,0,0,0,,\n1,P1,x,2,0,0,0,,\n");
        let table = read(&text).unwrap();
        assert_eq!(table.readings[1].seq, 2);
        assert!(assumes(
            &table,
            "numbers under `seq` occur more than once; rows are numbered in the order of the file"
        ));
    }

    #[test]
    fn runs_of_one_repeat_number_their_steps_by_themselves_and_survive_being_written() {
        let table = read("pose,direction,repeat,force_N,displacement_um,run\nP1,x,1,0,0,a\nP1,x,1,-10,-9,a\nP1,x,1,0,0,b\n").unwrap();
        assert_eq!(table.runs.len(), 2);
        let mut written = Vec::new();
        crate::readings::write_readings(&table, &mut written).unwrap();
        let again = read(std::str::from_utf8(&written).unwrap()).unwrap();
        assert_eq!(again.runs, table.runs);
    }

    #[test]
    fn a_reading_given_twice_names_both_lines() {
        let text = format!(
            "{HEADER}1,P1,x,1,0,0,0,5,\n2,P1,x,1,9,1,1,5,\n3,P1,y,1,0,0,0,5,\n4,P1,x,1,9,1,1,5,\n"
        );
        let error = read(&text).unwrap_err();
        assert_eq!(
            error.to_string(),
            "t.csv, line 5: the same reading as line 3 (P1 x, loading, step 1, repeat 1, attempt 1), both accepted"
        );
    }

    #[test]
    fn holds_and_superseded_readings_are_no_duplicates() {
        let text = format!(
            "{HEADER}1,P1,x,1,70,9,7,5,\n2,P1,x,1,70,9,7,60,\n3,P1,x,1,70,9,7,60,superseded\n"
        );
        assert_eq!(read(&text).unwrap().accepted().count(), 2);
    }

    #[test]
    fn without_steps_a_repeated_row_is_kept_and_said() {
        let text = "pose,direction,repeat,force_N,displacement_um\nP1,x,1,10,4\nP1,x,1,20,8\nP1,x,1,20,8\n";
        let table = read(text).unwrap();
        assert_eq!(table.readings.len(), 3);
        assert!(assumes(
            &table,
            "line 4 repeats line 3 word for word; both are kept as separate readings"
        ));
    }
}
