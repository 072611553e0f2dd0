//! Force against displacement without a robot, in the terms of the search.
//!
//! A specimen is the simplest bench there is: its baseline is one straight line a configuration with a zero for each run, and one joint
//! with a lever of one length unit stands for whatever has play, friction or curvature. Numbers are scaled so that the largest load is
//! that of the paper and the largest displacement a millimetre: the sizes of the laws' priors mean the same there.

use stiffbench_beams::physics::{LoadPoint, PoseMechanics, TestObject};
use stiffbench_beams::structure::RotationInfluence;
use stiffbench_measurement::specimen::{ResponseVariable, SpecimenReading, SpecimenTable};
use stiffbench_numeric::statistics::LeastSquaresLine;
use stiffbench_units_and_text::test_point::{Direction, PoseId};

use super::baseline::{Baseline, BaselineParameter, PoseSolver};
use super::error::MismatchError;
use super::observations::{GaugeSteps, Observations, ObservedReading, ReadingClock, Recorded};
use super::recorded_history::RecordedHistory;
use crate::search::constants::{LARGEST_DISPLACEMENT, LARGEST_LOAD};
use crate::search::largest;

/// Name of the joint that stands for the specimen.
pub const SPECIMEN_JOINT: &str = "specimen";

/// What one unit of the scaled numbers is in the table.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpecimenScale {
    /// Load of the table per scaled N.
    pub load: f64,
    /// Answer of the table per scaled m.
    pub answer: f64,
    /// Answer of the table at the scaled zero.
    pub offset: f64,
    /// Whether the order of the readings is used as time.
    pub order_is_clock: bool,
}

/// One straight line a configuration.
#[derive(Debug, Clone)]
pub struct SpecimenBaseline {
    parameters: Vec<BaselineParameter>,
    joints: Vec<String>,
}

/// Lays out a table for the search.
///
/// # Returns
/// The observations, the baseline, and what their units are.
///
/// # Errors
/// [`MismatchError::Empty`] if no reading counts.
pub fn specimen_bench(
    table: &SpecimenTable,
) -> Result<(Observations, SpecimenBaseline, SpecimenScale), MismatchError> {
    if table.readings.is_empty() {
        return Err(MismatchError::Empty);
    }
    let pairs: Vec<(f64, f64)> = table
        .readings
        .iter()
        .map(|reading| (table.driver(reading), table.answer(reading)))
        .collect();
    let load = largest(pairs.iter().map(|pair| &pair.0)) / LARGEST_LOAD;
    let (slope, offset) = line(&pairs);
    let answers: Vec<f64> = pairs.iter().map(|pair| pair.1 - offset).collect();
    let answer = largest(&answers).max(f64::MIN_POSITIVE) / LARGEST_DISPLACEMENT;
    let load = if load > 0.0 { load } else { 1.0 };
    let scale = SpecimenScale {
        load,
        answer,
        offset,
        order_is_clock: table
            .readings
            .iter()
            .all(|reading| reading.time_s.is_none()),
    };
    let observations = observations(table, &scale);
    // In scaled units; a line without any slope still needs a size to vary by.
    let start = slope * load / answer;
    let spread = start.abs().max(LARGEST_DISPLACEMENT / LARGEST_LOAD);
    let parameter = |name: &String| slope_parameter(name, start, spread);
    let baseline = SpecimenBaseline {
        parameters: table.configurations.iter().map(parameter).collect(),
        joints: vec![SPECIMEN_JOINT.to_owned()],
    };
    Ok((observations, baseline, scale))
}

fn slope_parameter(configuration: &str, start: f64, spread: f64) -> BaselineParameter {
    BaselineParameter {
        name: format!("slope of {configuration}"),
        spring_rad_per_nm: None,
        start,
        lower: start - 1e3 * spread,
        upper: start + 1e3 * spread,
        prior_sd: 100.0 * spread,
    }
}

impl SpecimenBaseline {
    /// Lines of known slopes.
    pub(super) fn with_slopes(configurations: &[String], slopes: &[f64]) -> Self {
        let named = configurations.iter().zip(slopes);
        let parameter = |(name, slope): (&String, &f64)| slope_parameter(name, *slope, 1.0);
        Self {
            parameters: named.map(parameter).collect(),
            joints: vec![SPECIMEN_JOINT.to_owned()],
        }
    }
}

fn line(pairs: &[(f64, f64)]) -> (f64, f64) {
    let mean = pairs.iter().map(|pair| pair.1).sum::<f64>() / pairs.len() as f64;
    let line = LeastSquaresLine::through(pairs.iter().copied());
    line.map_or((0.0, mean), |line| (line.slope, line.at(0.0)))
}

/// The face of the laws of a part.
#[must_use]
pub fn test_object(response: ResponseVariable) -> TestObject {
    match response {
        ResponseVariable::Displacement => TestObject::ForceDriven,
        ResponseVariable::Force => TestObject::DisplacementDriven,
    }
}

/// A table in scaled numbers, and the place of each reading in the table.
pub(super) fn specimen_observations(
    table: &SpecimenTable,
    scale: &SpecimenScale,
) -> (Observations, Vec<usize>) {
    let mut places: Vec<usize> = (0..table.readings.len()).collect();
    places.sort_by_key(|&place| {
        let run = table.readings[place].run;
        (table.runs[run as usize].configuration, run)
    });
    (observations(table, scale), places)
}

fn observations(table: &SpecimenTable, scale: &SpecimenScale) -> Observations {
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
        free_zeros: true,
        clock: clock_of(table, scale),
        bench: test_object(table.response),
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
            add_run(table, scale, index, &mut out);
        }
    }
    out.histories = RecordedHistory::of_runs(&out);
    out
}

fn clock_of(table: &SpecimenTable, scale: &SpecimenScale) -> ReadingClock {
    match (scale.order_is_clock, table.has_order) {
        (false, _) => ReadingClock::Times,
        (true, true) => ReadingClock::Order,
        (true, false) => ReadingClock::Rows,
    }
}

fn add_run(table: &SpecimenTable, scale: &SpecimenScale, run: usize, out: &mut Observations) {
    let readings = || {
        table
            .readings
            .iter()
            .filter(|reading| reading.run as usize == run)
    };
    let clock = |reading: &SpecimenReading| {
        if scale.order_is_clock {
            Some(f64::from(reading.order))
        } else {
            reading.time_s
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
            target_n: table.driver(reading) / scale.load,
            flagged: false,
        };
        let load = LoadPoint {
            force_n: table.driver(reading) / scale.load,
            step: step as u32,
            hold_s: reading.hold_s.unwrap_or(0.0),
            since_zero_s: time_s.map_or(0.0, |time| time - first_time),
            warming_k: match (reading.temperature_deg_c, first_warmth) {
                (Some(now), Some(then)) => now - then,
                _ => 0.0,
            },
            position_m: None,
            is_unloaded: table.driver(reading) == 0.0,
        };
        let displacement_m = (table.answer(reading) - scale.offset) / scale.answer;
        out.push(observed, load, displacement_m);
    }
}

impl Baseline for SpecimenBaseline {
    fn parameters(&self) -> &[BaselineParameter] {
        &self.parameters
    }

    fn solver(&self, _variant: usize) -> Result<Box<dyn PoseSolver + '_>, MismatchError> {
        let poses = vec![PoseMechanics::default(); self.parameters.len()];
        Ok(Box::new(SpecimenSolver {
            joints: &self.joints,
            poses,
        }))
    }

    fn joints(&self) -> &[String] {
        &self.joints
    }
}

struct SpecimenSolver<'a> {
    joints: &'a [String],
    poses: Vec<PoseMechanics>,
}

impl PoseSolver for SpecimenSolver<'_> {
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

    fn joint_names(&self) -> Vec<String> {
        self.joints.to_vec()
    }
}
