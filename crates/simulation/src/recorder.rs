//! Readings as the gauges show them, in the order in which they are made.

use stiffbench_measurement::readings::{
    Reading, ReadingStatus, ReadingTable, ReadingText, RunNumbers,
};
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::mechanics::ActingLoad;
use super::noise::{NoiseModel, decimals, rounded};

/// Micrometres in a metre.
const MICROMETRES: f64 = 1e6;

/// Where a reading belongs, beyond the load it was made at.
pub(super) struct ReadingContext<'a> {
    pub(super) pose: &'a PoseId,
    pub(super) direction: Direction,
    pub(super) target_n: f64,
    /// Whether all runs of the cell are on one gauge zero.
    pub(super) shared_zero: bool,
}

/// Readings as they come in.
#[derive(Debug, Default)]
pub(super) struct Recorder {
    readings: Vec<Reading>,
    runs: RunNumbers,
    zeros: RunNumbers,
}

impl Recorder {
    /// Adds what the gauges show at a load with a displacement.
    pub(super) fn add(
        &mut self,
        place: &ReadingContext<'_>,
        load: &ActingLoad,
        displacement_m: f64,
        noise: &NoiseModel,
    ) {
        let shown_n = rounded(load.point.force_n, noise.force_step_n);
        let shown_um = rounded(displacement_m, noise.displacement_step_m) * MICROMETRES;
        let force_raw = format!("{shown_n:.*}", decimals(noise.force_step_n));
        let displacement_raw = format!(
            "{shown_um:.*}",
            decimals(noise.displacement_step_m * MICROMETRES)
        );
        let (pose, direction, repeat) = (place.pose, place.direction, load.repeat);
        let zero = place.shared_zero.then_some("cell");
        self.readings.push(Reading {
            line: 0,
            seq: self.readings.len() as u32 + 1,
            run: self.runs.number(pose, direction, repeat, None),
            zero: self.zeros.number(pose, direction, repeat, zero),
            pose: pose.clone(),
            direction,
            load: None,
            branch: load.branch,
            step: load.point.step,
            repeat,
            attempt: 1,
            status: ReadingStatus::Accepted,
            target_n: place.target_n,
            // The numbers are those that the instruments show, so that text and number agree.
            force_n: force_raw.parse().unwrap_or(shown_n),
            displacement_m: displacement_raw.parse::<f64>().unwrap_or(shown_um) / MICROMETRES,
            time_s: Some(to_digits(load.time_s, 100.0)),
            hold_s: Some(to_digits(load.point.hold_s, 10.0)),
            temperature_deg_c: Some(to_digits(load.temperature_deg_c, 100.0)),
            text: Some(Box::new(ReadingText {
                force_raw: force_raw.into(),
                displacement_raw: displacement_raw.into(),
                // Its gauges show nothing without load.
                zero_si: [Some(0.0); 2],
                ..ReadingText::default()
            })),
        });
    }

    /// The table of a session.
    pub(super) fn finish(self, session: &str) -> ReadingTable {
        ReadingTable {
            source: format!("simulation {session}"),
            session: Some(session.to_owned()),
            readings: self.readings,
            runs: self.runs.into_keys(),
            zeros: self.zeros.into_keys(),
            ..ReadingTable::default()
        }
    }
}

/// A number as a clock or thermometer of `per_unit` steps in a unit shows it.
fn to_digits(value: f64, per_unit: f64) -> f64 {
    (value * per_unit).round() / per_unit
}
