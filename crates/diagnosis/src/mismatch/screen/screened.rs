//! What a screen of the data says: readings, runs and cells that cannot be right, and the data without them.

use std::fmt;

use stiffbench_units_and_text::test_point::{Branch, Direction, DirectionName, PoseId};

use super::deleted_residuals::repeats_of;
use super::usual_factor::misread_factor;
use crate::mismatch::observed::{Observations, ReadingNoise};
use crate::search::constants::BAD_READING_LEVEL;

/// Readings without those that cannot be right.
#[derive(Debug, Clone, PartialEq)]
pub struct ScreenedData {
    /// The others.
    pub observations: Observations,
    /// Runs that their repeats contradict, and cells that cannot be.
    pub bad_runs: Vec<BadRun>,
    /// Readings that their repeats contradict, by their places among those of good runs.
    pub bad_readings: Vec<BadReading>,
    /// Degrees of freedom of Student's t that the others have; none where a normal distribution fits as well, or nothing could be tested.
    pub tails_dof: Option<f64>,
}

/// A run, or all runs of a cell, with a displacement per force that cannot be.
#[derive(Debug, Clone, PartialEq)]
pub struct BadRun {
    /// Lines in their file.
    pub lines: Vec<u32>,
    /// Its pose.
    pub pose: PoseId,
    /// Its direction.
    pub direction: Direction,
    /// Its repeat; none if the cell is meant.
    pub repeat: Option<u32>,
    /// The cell under whose name it was recorded, and the other way round.
    pub exchanged_with: Option<(PoseId, Direction)>,
    /// Displacement per force, m/N.
    pub compliance: f64,
    /// What the other repeats let expect, m/N; of a cell that yields against its load the same with the sign that it must have, of one
    /// that is exchanged or has another unit or decimal point what the other cells let expect.
    pub expected: f64,
    /// Standard error of the difference, m/N.
    pub u: f64,
    /// Chance that the worst of all good runs is as far off.
    pub p_family: f64,
    /// By what it must be multiplied to agree, if that is usual: -1, a power of ten, a factor between units.
    pub factor: Option<f64>,
}

impl BadRun {
    /// # Arguments
    /// - `run`: the run; none if the whole cell is meant.
    /// - `compliance`, `expected`, `u`: m/N.
    pub(crate) fn new(
        observations: &Observations,
        (cell, run): (usize, Option<usize>),
        [compliance, expected, u]: [f64; 3],
        p_family: f64,
        factor: Option<f64>,
    ) -> Self {
        let (own, run) = (
            &observations.cells[cell],
            run.map(|run| &observations.runs[run]),
        );
        let readings = run.map_or(&own.readings, |run| &run.readings).clone();
        let (pose, direction) = observations.name_of(cell);
        Self {
            lines: readings
                .map(|one| observations.readings[one].line)
                .collect(),
            pose,
            direction,
            repeat: run.map(|run| run.repeat),
            exchanged_with: None,
            compliance,
            expected,
            u,
            p_family,
            factor,
        }
    }
}

/// Readings without bad runs.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct ScreenedRuns {
    /// The others.
    pub(crate) observations: Observations,
    /// The bad ones, the worst first.
    pub(crate) bad: Vec<BadRun>,
    /// The noise of the others, where it was estimated.
    pub(crate) noise: Option<ReadingNoise>,
}

/// A reading that its repeats, its neighbours or the fit to all others contradict.
#[derive(Debug, Clone, PartialEq)]
pub struct BadReading {
    /// Its place among the readings that were tested.
    pub reading: usize,
    /// Its line in its file.
    pub line: u32,
    /// Its pose.
    pub pose: PoseId,
    /// Its direction.
    pub direction: Direction,
    /// What it is of; of a rotation the values below are in rad.
    pub quantity: ReadQuantity,
    /// The direction of its load, if it is another.
    pub load: Option<DirectionName>,
    /// Its repeat.
    pub repeat: u32,
    /// Its load step.
    pub step: u32,
    /// Its branch.
    pub branch: Branch,
    /// Whether it is the last of its run: a jump that stays, just before it, would look the same.
    pub is_last: bool,
    /// Lines of the repeats that contradict it; none where its neighbours do, or the fit to all others.
    pub repeats: Vec<u32>,
    /// What was read, m.
    pub value_m: f64,
    /// What the other readings let expect, m.
    pub expected_m: f64,
    /// Standard error of that difference, m.
    pub u_m: f64,
    /// Chance that the largest of all readings is as far off by noise alone.
    pub p_family: f64,
    /// By what it must be multiplied to agree, if that is usual: -1, a power of ten, a factor between units.
    pub factor: Option<f64>,
    /// Of absolute positions: the value of one joint with which this coordinate and all others that are off with it agree.
    pub joint: Option<OtherJointValue>,
}

impl BadReading {
    /// Whether errors with tails as long as those of the other readings are as far off in fewer benches than are called bad by chance.
    #[must_use]
    pub fn is_named(&self) -> bool {
        self.p_family <= BAD_READING_LEVEL
    }

    /// # Arguments
    /// - `shift_m`: by how much the reading is too large, and its standard error, m.
    pub(crate) fn new(
        observations: &Observations,
        reading: usize,
        (shift_m, u_m): (f64, f64),
        p_family: f64,
    ) -> Self {
        let detail = &observations.readings[reading];
        let run = &observations.runs[detail.run];
        let cell = &observations.cells[run.cell];
        let value_m = observations.displacement_m[reading];
        let expected_m = value_m - shift_m;
        let repeats = repeats_of(observations, reading).into_iter();
        Self {
            reading,
            line: detail.line,
            pose: observations.poses[cell.pose].clone(),
            direction: cell.axis(),
            quantity: if cell.read.is_rotation() {
                ReadQuantity::Rotation
            } else {
                ReadQuantity::Displacement
            },
            load: observations.named(cell).load,
            repeat: run.repeat,
            step: observations.loads[reading].step,
            branch: detail.branch,
            is_last: reading + 1 == run.readings.end,
            repeats: repeats
                .map(|other| observations.readings[other].line)
                .collect(),
            value_m,
            expected_m,
            u_m,
            p_family,
            factor: misread_factor(value_m, expected_m, u_m),
            joint: None,
        }
    }
}

/// What a reading is of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReadQuantity {
    /// A displacement, m.
    Displacement,
    /// A rotation, rad.
    Rotation,
    /// A coordinate of an absolute position, m.
    Position,
}

impl ReadQuantity {
    /// `um`, or `urad` of a rotation: its unit in JSON.
    #[must_use]
    pub fn micro_unit(self) -> &'static str {
        match self {
            Self::Rotation => "urad",
            Self::Displacement | Self::Position => "um",
        }
    }
}

impl fmt::Display for ReadQuantity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Displacement => "displacement",
            Self::Rotation => "rotation",
            Self::Position => "position",
        })
    }
}

/// A value of a joint with which the positions of a bad target or pose would agree.
#[derive(Debug, Clone, PartialEq)]
pub struct OtherJointValue {
    /// The variable of the robot.
    pub variable: String,
    /// Value of the table, degrees or m.
    pub stated: f64,
    /// Value with which they agree.
    pub agrees: f64,
    /// `deg` or `m`.
    pub unit: &'static str,
}
