//! Load cases of a session with displacement gauges along the base axes: one for each run.

use indexmap::IndexMap;

use super::table::{LoadAxes, LoadCase, LoadCaseNote, LoadCaseTable};
use crate::readings::{FileCell, ReadingsError, VectorReading, VectorTable, largest_load};
use stiffbench_numeric::statistics::LeastSquaresLine;
use stiffbench_numeric::vector::dot;
use stiffbench_units_and_text::test_point::Branch;

/// Components of a force relative to its size that are rounding.
const NO_COMPONENT: f64 = 1e-9;

impl LoadCaseTable {
    /// One load case for each run of a session: its displacement per force, a least-squares line over the steps of the loading branch, at
    /// its largest load.
    ///
    /// A run counts from its own zero: its unloaded reading, or, where it has none, the zero of the gauges under the preload. What errors
    /// the steps of a run share (its zero, its seating) is then one error of one load case, and repeats show it.
    ///
    /// # Arguments
    /// - `preload_n`: force along the load at which the displacement gauges were zeroed, N.
    ///
    /// # Errors
    /// [`ReadingsError`] for a reading without the value of a joint whose column there is, and a table without a run that was loaded.
    pub fn of_runs(table: &VectorTable, preload_n: f64) -> Result<Self, ReadingsError> {
        let accepted: Vec<&VectorReading> = table.accepted().collect();
        let loading = accepted
            .iter()
            .copied()
            .filter(|reading| reading.branch == Branch::Loading);
        // One load history on one zero of the gauges each.
        let mut runs: IndexMap<_, Vec<&VectorReading>> = IndexMap::new();
        for reading in loading {
            for (joint, value) in table.joints.iter().zip(&reading.joints) {
                if value.is_none() {
                    let cell = FileCell {
                        file: table.source.clone(),
                        line: reading.line,
                        column: joint.name(),
                        value: String::new(),
                    };
                    return Err(ReadingsError::MissingValue {
                        cell,
                        expected: "the value of the joint in this pose",
                    });
                }
            }
            let cell = (&reading.pose, &reading.direction);
            let run = runs.entry((cell, &reading.run, &reading.zero));
            run.or_default().push(reading);
        }
        let cases: Vec<LoadCase> = runs
            .values()
            .filter_map(|run| load_case(run, preload_n))
            .collect();
        if cases.is_empty() {
            return Err(ReadingsError::NoReadings {
                file: table.source.clone(),
                line: 1,
            });
        }
        let used = runs.values().map(Vec::len).sum::<usize>();
        let mut notes = vec![LoadCaseNote::Runs {
            runs: cases.len(),
            readings: used,
            unloading: accepted.len() - used,
        }];
        let rejected: Vec<u32> = table
            .readings
            .iter()
            .filter(|reading| !accepted.iter().any(|of| of.seq == reading.seq))
            .map(|reading| reading.line)
            .collect();
        if !rejected.is_empty() {
            notes.push(LoadCaseNote::Rejected { lines: rejected });
        }
        Ok(Self {
            source: table.source.clone(),
            origin: table.origin.clone(),
            joints: table.joints.clone(),
            cases,
            notes,
        })
    }
}

/// `None` for a run that was never loaded beyond its zero.
fn load_case(run: &[&VectorReading], preload_n: f64) -> Option<LoadCase> {
    let first = run.first()?;
    let (largest, unit) = largest_load(run)?;
    let largest_n = largest.force_size_n();
    let along = |reading: &VectorReading| dot(reading.force_n, unit);
    let unloaded = run.iter().find(|of| of.target_n == 0.0);
    let zero_n = unloaded.map_or(preload_n, |of| along(of));
    let load_n = along(largest) - zero_n;
    if load_n.abs() <= NO_COMPONENT * largest_n {
        return None;
    }
    let displacement_m = [0, 1, 2].map(|axis| {
        let mut points: Vec<(f64, f64)> = Vec::new();
        let mut step = None;
        for reading in run {
            // Of a load that was held, the first reading.
            if step == Some(reading.step) {
                continue;
            }
            step = Some(reading.step);
            points.extend(reading.displacement_m[axis].map(|read| (along(reading), read)));
        }
        if points.is_empty() {
            return None;
        }
        if unloaded.is_none() {
            points.push((preload_n, 0.0));
        }
        Some(LeastSquaresLine::through(points.into_iter())?.slope * load_n)
    });
    displacement_m
        .iter()
        .any(Option::is_some)
        .then(|| LoadCase {
            line: first.line,
            pose: first.pose.clone(),
            joints: first.joints.iter().copied().flatten().collect(),
            repeat: first.repeat.max(1),
            axes: LoadAxes::Base,
            // Without a minus in front of zero.
            force_n: unit.map(|share| share * load_n + 0.0),
            moment_nm: [0.0; 3],
            displacement_m,
            rotation_rad: [None; 3],
            position_m: [None; 3],
        })
}
