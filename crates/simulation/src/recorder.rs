//! Readings as the gauges show them, in the order in which they are made.

use stiffbench_measurement::readings::{Reading, ReadingStatus, ReadingTable, ReadingText, RunKey};
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::mechanics::ActingLoad;
use super::noise::{NoiseModel, decimals, rounded};

/// Micrometres in a metre.
const MICROMETRES: f64 = 1e6;

/// The cell whose readings come in.
pub(super) struct RecordedCell<'a> {
    pub(super) pose: &'a PoseId,
    pub(super) load: &'a LoadDirection,
    /// The axes along which displacements are read.
    pub(super) read: &'a [Direction],
    pub(super) repeats: u32,
    /// Whether all runs of the cell are on one zero of each gauge.
    pub(super) shared_zero: bool,
}

/// Readings as they come in, one for each gauge.
#[derive(Debug)]
pub(super) struct Recorder<'n> {
    noise: &'n NoiseModel,
    table: ReadingTable,
    loads: u32,
    /// Places of the first run and the first gauge zero of the cell.
    first: [u32; 2],
}

impl<'n> Recorder<'n> {
    /// No readings yet.
    ///
    /// # Arguments
    /// - `session`: its name.
    pub(super) fn new(session: &str, noise: &'n NoiseModel) -> Self {
        let table = ReadingTable {
            source: format!("simulation {session}"),
            session: Some(session.to_owned()),
            ..ReadingTable::default()
        };
        Self {
            noise,
            table,
            loads: 0,
            first: [0; 2],
        }
    }

    /// Adds the runs and gauge zeros of a cell; its readings follow.
    pub(super) fn begin(&mut self, cell: &RecordedCell<'_>) {
        let table = &mut self.table;
        self.first = [&table.runs, &table.zeros].map(|of| of.len() as u32);
        let key = |axis, repeat: u32| RunKey {
            label: Some(repeat.to_string().into()),
            ..RunKey::of_repeat(cell.pose.clone(), axis, repeat)
        };
        for repeat in 1..=cell.repeats {
            table.runs.push(key(cell.read[0], repeat));
            let zeros = cell.read.iter().map(|&axis| key(axis, repeat));
            if !cell.shared_zero {
                table.zeros.extend(zeros);
            } else if repeat == 1 {
                table.zeros.extend(zeros.map(|zero| RunKey {
                    label: Some("cell".into()),
                    ..zero
                }));
            }
        }
    }

    /// Adds what the gauges show at a load with the displacements along their axes.
    pub(super) fn add(
        &mut self,
        cell: &RecordedCell<'_>,
        target_n: f64,
        load: &ActingLoad,
        displacements_m: &[f64],
    ) {
        let (noise, [first_run, first_zero]) = (self.noise, self.first);
        let shown_n = rounded(load.point.force_n, noise.force_step_n);
        let force_raw = format!("{shown_n:.*}", decimals(noise.force_step_n));
        let gauges = cell.read.len() as u32;
        let zero = if cell.shared_zero { 0 } else { load.repeat - 1 };
        self.loads += 1;
        for (gauge, (&axis, &displacement_m)) in (0..).zip(cell.read.iter().zip(displacements_m)) {
            let shown_um = rounded(displacement_m, noise.displacement_step_m) * MICROMETRES;
            let displacement_raw = format!(
                "{shown_um:.*}",
                decimals(noise.displacement_step_m * MICROMETRES)
            );
            let other = (*cell.load != axis).then(|| self.table.place_of(cell.load));
            self.table.readings.push(Reading {
                line: 0,
                seq: self.loads,
                run: first_run + load.repeat - 1,
                zero: first_zero + zero * gauges + gauge,
                pose: cell.pose.clone(),
                direction: axis,
                load: other,
                branch: load.branch,
                step: load.point.step,
                repeat: load.repeat,
                attempt: 1,
                status: ReadingStatus::Accepted,
                target_n,
                // The numbers are those that the instruments show, so that text and number agree.
                force_n: force_raw.parse().unwrap_or(shown_n),
                displacement_m: displacement_raw.parse::<f64>().unwrap_or(shown_um) / MICROMETRES,
                time_s: Some(to_digits(load.time_s, 100.0)),
                hold_s: Some(to_digits(load.point.hold_s, 10.0)),
                temperature_deg_c: Some(to_digits(load.temperature_deg_c, 100.0)),
                text: Some(Box::new(ReadingText {
                    force_raw: force_raw.as_str().into(),
                    displacement_raw: displacement_raw.into(),
                    // Its gauges show nothing without load.
                    zero_si: [Some(0.0); 2],
                    ..ReadingText::default()
                })),
            });
        }
    }

    /// The table of a session.
    pub(super) fn finish(self) -> ReadingTable {
        self.table
    }
}

/// A number as a clock or thermometer of `per_unit` steps in a unit shows it.
fn to_digits(value: f64, per_unit: f64) -> f64 {
    (value * per_unit).round() / per_unit
}
