//! A part without a robot file: a straight line a configuration, with a zero for each run.
//!
//! What was set stands for the force and what answered for the displacement, in SI units; in those of the file where it has none. One joint
//! with a lever of one unit stands for whatever has play, friction or curvature, so that the laws of joints act on a part.

use stiffbench_beams::physics::{LoadPoint, Place, PoseMechanics, TestObject};
use stiffbench_beams::structure::RotationInfluence;
use stiffbench_measurement::specimen::{ResponseVariable, SpecimenReading, SpecimenTable};
use stiffbench_numeric::statistics::LeastSquaresLine;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::baseline::{Baseline, BaselineParameter, PoseSolver};
use crate::mismatch::error::MismatchError;
use crate::mismatch::observed::{
    GaugeSteps, Observations, ObservedReading, ReadingClock, Recorded,
};
use crate::search::largest;

/// One straight line a configuration.
#[derive(Debug, Clone)]
pub struct Line {
    parameters: Vec<BaselineParameter>,
    joints: Vec<Place>,
    /// What answers without a load: readings count from there.
    pub(crate) zero: f64,
}

impl Line {
    /// The line through all readings of a table, and the readings.
    ///
    /// # Errors
    /// [`MismatchError::Empty`] if no reading counts.
    pub fn of_table(table: &SpecimenTable) -> Result<(Self, Observations), MismatchError> {
        let readings = table.readings.iter();
        let points = readings.map(|reading| (table.driver(reading), table.answer(reading)));
        let (slope, zero) = match LeastSquaresLine::through(points) {
            Some(line) => (line.slope, line.at(0.0)),
            None => (0.0, mean_answer(table)),
        };
        let (observations, _) = part_observations(table, zero);
        if observations.is_empty() {
            return Err(MismatchError::Empty);
        }
        // A line without any slope still needs a size to vary by.
        let mean = largest(&observations.displacement_m) / observations.largest_load();
        let unit = if mean.is_normal() {
            slope.abs().max(mean)
        } else {
            1.0
        };
        let slopes = table.configurations.iter().map(|name| (name, slope));
        Ok((Self::new(slopes, unit, zero), observations))
    }

    /// Lines of known slopes.
    pub(crate) fn with_slopes(configurations: &[String], slopes: &[f64]) -> Self {
        Self::new(configurations.iter().zip(slopes.iter().copied()), 1.0, 0.0)
    }

    fn new<'a>(slopes: impl Iterator<Item = (&'a String, f64)>, unit: f64, zero: f64) -> Self {
        let parameter = |(configuration, start): (&String, f64)| BaselineParameter {
            name: format!("slope of {configuration}"),
            spring_rad_per_nm: None,
            unit,
            start,
            lower: start - 1e3 * unit,
            upper: start + 1e3 * unit,
            prior_sd: 100.0 * unit,
        };
        Self {
            parameters: slopes.map(parameter).collect(),
            joints: vec![Place::Joint(Place::PART.to_owned())],
            zero,
        }
    }
}

fn mean_answer(table: &SpecimenTable) -> f64 {
    let answers = table.readings.iter().map(|one| table.answer(one));
    answers.sum::<f64>() / table.readings.len().max(1) as f64
}

/// The face of the laws of a part.
#[must_use]
pub fn test_object(response: ResponseVariable) -> TestObject {
    match response {
        ResponseVariable::Displacement => TestObject::ForceDriven,
        ResponseVariable::Force => TestObject::DisplacementDriven,
    }
}

/// The readings of a table, configuration by configuration, and the place of each in the table.
///
/// # Arguments
/// - `zero`: the answer from which they count.
pub(crate) fn part_observations(table: &SpecimenTable, zero: f64) -> (Observations, Vec<usize>) {
    let mut places: Vec<usize> = (0..table.readings.len()).collect();
    places.sort_by_key(|&place| {
        let run = table.readings[place].run;
        (table.runs[run as usize].configuration, run)
    });
    (observations(table, zero), places)
}

fn observations(table: &SpecimenTable, zero: f64) -> Observations {
    let any = |known: fn(&SpecimenReading) -> bool| table.readings.iter().any(known);
    let recorded = Recorded {
        time: true,
        hold: any(|reading| reading.hold_s.is_some()),
        temperature: any(|reading| reading.temperature_deg_c.is_some()),
    };
    let mut out = Observations {
        poses: table
            .configurations
            .iter()
            .map(|name| PoseId::new(name))
            .collect(),
        clock: clock_of(table),
        response_doubt: table.response_doubt,
        ..Observations::without_readings(GaugeSteps::default(), recorded)
    };
    for configuration in 0..table.configurations.len() {
        out.begin_cell(configuration, Direction::X.into(), Direction::X.into());
        let members = table
            .runs
            .iter()
            .enumerate()
            .filter(|(_, run)| run.configuration as usize == configuration);
        for (number, (index, _)) in members.enumerate() {
            out.begin_run(number as u32 + 1, index as u32);
            add_run(table, (index, zero), &mut out);
        }
    }
    out.of_part(test_object(table.response))
}

fn clock_of(table: &SpecimenTable) -> ReadingClock {
    if table.is_one_sweep {
        return ReadingClock::OneSweep;
    }
    let has_times = table.readings.iter().any(|one| one.time_s.is_some());
    match (has_times, table.has_order) {
        (true, _) => ReadingClock::Times,
        (false, true) => ReadingClock::Order,
        (false, false) => ReadingClock::Rows,
    }
}

fn add_run(table: &SpecimenTable, (run, zero): (usize, f64), out: &mut Observations) {
    let readings = || {
        table
            .readings
            .iter()
            .filter(|reading| reading.run as usize == run)
    };
    let kind = out.clock;
    let clock = |reading: &SpecimenReading| match kind {
        ReadingClock::Times => reading.time_s,
        ReadingClock::Order | ReadingClock::Rows | ReadingClock::OneSweep => {
            Some(f64::from(reading.order))
        }
    };
    let first_time = readings().find_map(clock).unwrap_or(0.0);
    let first_warmth = readings().find_map(|reading| reading.temperature_deg_c);
    for (step, reading) in readings().enumerate() {
        let time_s = clock(reading);
        let observed = ObservedReading {
            run: 0,
            seq: reading.line,
            zero: run as u32,
            branch: reading.branch,
            hold_number: 0,
            time_s,
            line: reading.line,
            target_n: table.driver(reading),
            flagged: false,
        };
        let load = LoadPoint {
            force_n: table.driver(reading),
            step: step as u32,
            hold_s: reading.hold_s.unwrap_or(0.0),
            since_zero_s: time_s.map_or(0.0, |time| time - first_time),
            warming_k: match (reading.temperature_deg_c, first_warmth) {
                (Some(now), Some(then)) => now - then,
                _ => 0.0,
            },
            is_unloaded: table.driver(reading) == 0.0,
            ..LoadPoint::default()
        };
        out.push(observed, load, table.answer(reading) - zero);
    }
}

impl Baseline for Line {
    fn parameters(&self) -> &[BaselineParameter] {
        &self.parameters
    }

    fn solver(&self, _variant: usize) -> Result<Box<dyn PoseSolver + '_>, MismatchError> {
        let poses = vec![PoseMechanics::default(); self.parameters.len()];
        Ok(Box::new(LineSolver {
            joints: &self.joints,
            poses,
        }))
    }

    fn joints(&self) -> &[Place] {
        &self.joints
    }
}

struct LineSolver<'a> {
    joints: &'a [Place],
    poses: Vec<PoseMechanics>,
}

impl PoseSolver for LineSolver<'_> {
    fn solve(&mut self, parameters: &[f64]) -> Result<(), MismatchError> {
        for (index, (pose, slope)) in self.poses.iter_mut().zip(parameters).enumerate() {
            pose.influence = RotationInfluence::of_one_joint(*slope, 1.0);
            pose.gradient = (0..parameters.len())
                .map(|other| {
                    let is_own = |i, j| other == index && i == j && i < 3;
                    std::array::from_fn(|i| {
                        std::array::from_fn(|j| f64::from(u8::from(is_own(i, j))))
                    })
                })
                .collect();
        }
        Ok(())
    }

    fn pose(&self, pose: usize) -> &PoseMechanics {
        &self.poses[pose]
    }

    fn joints(&self) -> Vec<Place> {
        self.joints.to_vec()
    }
}
