//! The readings of a session against their repeats, as a diagnosis would hold them.

use crate::analysis::{ResolvedModel, check_data};
use crate::mismatch::{BadReading, BadRun};
use crate::quantity::METRES_PER_MICROMETRE;
use crate::readings::{ReadingTable, SessionHeader, read_readings};
use crate::report::significant;
use crate::session::{Contradiction, RepeatCheck, SessionState, table};

/// The test that a diagnosis makes before its search.
pub(super) struct BenchRepeats {
    /// The robot of the session.
    pub(super) model: ResolvedModel,
    /// Its header: the steps of the gauges.
    pub(super) header: SessionHeader,
}

impl RepeatCheck for BenchRepeats {
    fn contradictions(&self, state: &SessionState, cell: usize) -> Vec<Contradiction> {
        // What cannot be tested is no reason to stop at the bench.
        self.found(state, cell).unwrap_or_default()
    }
}

impl BenchRepeats {
    fn found(&self, state: &SessionState, cell: usize) -> Option<Vec<Contradiction>> {
        let mut text = Vec::new();
        table(state, &mut text).ok()?;
        let readings = read_readings("readings.csv", &text[..]).ok()?;
        let screened = check_data(&readings, Some(&self.header), &self.model).ok()?;
        let runs = screened.bad_runs.iter();
        let runs = runs.filter_map(|bad| of_run(&readings, bad));
        let single = screened.bad_readings.iter();
        let single = single.map(|bad| of_reading(&readings, bad));
        let is_here = |number: &u32| {
            let mut all = state.readings.iter();
            all.any(|kept| kept.taken.number == *number && kept.taken.cell == cell)
        };
        let found = runs.chain(single);
        Some(
            found
                .filter(|one| one.numbers.first().is_some_and(is_here))
                .collect(),
        )
    }
}

/// Numbers of the readings on some lines.
fn numbers(table: &ReadingTable, lines: &[u32]) -> Vec<u32> {
    let readings = table.readings.iter();
    let those = readings.filter(|reading| lines.contains(&reading.line));
    let mut numbers: Vec<u32> = those.map(|reading| reading.seq).collect();
    // Of several gauges the readings of one load have one number.
    numbers.dedup();
    numbers
}

/// A whole run; `None` for a cell, which no run puts right.
fn of_run(table: &ReadingTable, bad: &BadRun) -> Option<Contradiction> {
    let um_per_n = |compliance: f64| significant(compliance / METRES_PER_MICROMETRE, 4);
    let text = format!(
        "Repeat {} of {} {} yields by {} um/N, where the other repeats predict {} ± {} um/N (k = 2).",
        bad.repeat?,
        bad.pose,
        bad.direction,
        um_per_n(bad.compliance),
        um_per_n(bad.expected),
        significant(2.0 * bad.u / METRES_PER_MICROMETRE, 2),
    );
    Some(Contradiction {
        numbers: numbers(table, &bad.lines),
        text,
    })
}

fn of_reading(table: &ReadingTable, bad: &BadReading) -> Contradiction {
    let um = |metres: f64| significant(metres / METRES_PER_MICROMETRE, 4);
    let numbers = numbers(table, &[bad.line]);
    let number = numbers.first().copied().unwrap_or_default();
    let text = format!(
        "Reading {number} ({} {}, repeat {}, step {}, {}) is {} um, where the other repeats predict {} ± {} um (k = 2).",
        bad.pose,
        bad.direction,
        bad.repeat,
        bad.step,
        bad.branch,
        um(bad.value_m),
        um(bad.expected_m),
        significant(2.0 * bad.u_m / METRES_PER_MICROMETRE, 2),
    );
    Contradiction { numbers, text }
}
