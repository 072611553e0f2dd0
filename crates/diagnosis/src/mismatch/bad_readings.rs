//! Bad readings: single ones that the repeats of the same load contradict.
//!
//! The test is that of a shift of the mean of one reading (Cook & Weisberg, Residuals and Influence in Regression, 1982, section 2.2.2), with
//! everything left free that physics or the bench may do to all readings of a load step and to all readings of a run:
//!
//! ```text
//!   y = mean(step, branch, hold) + zero(zero id) + slope(run) b + shift e + error
//! ```
//!
//! So it never asks the model. Errors may have long tails, as far as the others show them (`tails`); the step of the force has
//! none. Where physics jumps at some force, a reading beyond that force differs from its repeats, and its force is the largest or the smallest
//! of them: such readings are compared with each other, and those between against each other. Several bad readings are found one after the
//! other, the noise estimated anew without each, up to the largest number that may be bad, and believed up to the last that is significant:
//! until all are out, each makes the others look like long tails (generalised extreme studentised deviate: Rosner, Technometrics 25, 1983).
//! Of these each must contradict the good readings alone. Cells with fewer than three repeats have their neighbours instead (`curve_residuals`).

use std::fmt;

use stiffbench_units_and_text::test_point::{Branch, Direction, DirectionName, PoseId};

use super::bad_runs::ScreenedRuns;
use super::baseline::Baseline;
use super::data_screen::ScreenedData;
use super::deleted_residuals::{is_testable, repeats_of};
use super::error::MismatchError;
use super::known_noise::KnownNoise;
use super::observations::Observations;
use super::reading_screen::{ReadingScreen, TestedReadings};
use super::usual_factor::slip;
use crate::search::constants::{BAD_READING_LEVEL, MOST_BAD_READINGS};

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

/// Looks for bad readings in good runs, and lays out the others.
pub(super) fn screen_readings(
    baseline: &dyn Baseline,
    runs: &ScreenedRuns,
    noise: &KnownNoise,
) -> Result<ScreenedData, MismatchError> {
    let observations = &runs.observations;
    let screened = |observations, bad_readings, tails_dof| ScreenedData {
        observations,
        bad_runs: runs.bad.clone(),
        bad_readings,
        tails_dof,
    };
    let mut cells = 0..observations.cells.len();
    if !cells.any(|cell| is_testable(observations, cell)) {
        return Ok(screened(observations.clone(), Vec::new(), None));
    }
    let screen = ReadingScreen::new(baseline, observations, noise)?;
    let most = (MOST_BAD_READINGS * observations.len() as f64).ceil() as usize;
    let noise_of_all = runs.noise.unwrap_or_else(|| screen.noise_of_all());
    let all = vec![true; observations.len()];
    let mut tested = TestedReadings::new(&screen, all, noise_of_all);
    let tails_of_all = tested.tails_dof();
    let mut suspects: Vec<usize> = Vec::new();
    let mut p: Vec<f64> = Vec::new();
    while suspects.len() < most {
        let Some(suspect) = tested.take_worst() else {
            break;
        };
        let (suspect, is_clearly_good) = (suspect.own.reading, suspect.is_clearly_good());
        let mut family_p = 1.0;
        if !is_clearly_good {
            // What it does to the noise must not speak for it; a reading that passed for good hardly changed it.
            let similar = p.last().filter(|p| **p > BAD_READING_LEVEL);
            let similar = similar.map(|_| tested.noise);
            let noise = screen.noise_of(&tested.keep, similar.as_ref());
            tested = TestedReadings::new(&screen, tested.keep, noise);
            // Those before it that passed for good lie farther out than all others too.
            let passed = p.iter().rev().take_while(|p| **p > BAD_READING_LEVEL);
            let judged = tested.judged(suspect, 1 + passed.count());
            family_p = judged.map_or(1.0, |judged| judged.p_family);
        }
        suspects.push(suspect);
        p.push(family_p);
    }
    let Some(last) = p.iter().rposition(|p| *p <= BAD_READING_LEVEL) else {
        return Ok(screened(observations.clone(), Vec::new(), tails_of_all));
    };
    suspects.truncate(last + 1);
    // Each as the good readings alone let expect it: what lay far out only beside the others is good.
    let good_without = |suspects: &[usize]| observations.mask(|one| !suspects.contains(&one));
    let all_out = good_without(&suspects);
    let found = screen.noise_of(&all_out, None);
    let tested = TestedReadings::new(&screen, all_out, found);
    let again = suspects.iter().filter_map(|one| tested.judged(*one, 1));
    let mut bad: Vec<BadReading> = again.filter(BadReading::is_named).collect();
    let places: Vec<usize> = bad.iter().map(|one| one.reading).collect();
    let good = good_without(&places);
    bad.sort_by(|a, b| a.p_family.total_cmp(&b.p_family).then(a.line.cmp(&b.line)));
    let others = observations.filtered(&good);
    let tails_dof = TestedReadings::new(&screen, good, found).tails_dof();
    Ok(screened(others, bad, tails_dof))
}

impl BadReading {
    /// Whether errors with tails as long as those of the other readings are as far off in fewer benches than are called bad by chance.
    #[must_use]
    pub fn is_named(&self) -> bool {
        self.p_family <= BAD_READING_LEVEL
    }

    /// The same reading with the chance that its repeats give it, if it has enough of them.
    ///
    /// # Errors
    /// [`MismatchError`] if the structure cannot be solved at the start of the fit.
    pub(super) fn against_repeats(
        self,
        baseline: &dyn Baseline,
        observations: &Observations,
        noise: &KnownNoise,
    ) -> Result<Self, MismatchError> {
        let screen = ReadingScreen::new(baseline, observations, noise)?;
        let others = observations.mask(|one| one != self.reading);
        let found = screen.noise_of(&others, None);
        let tested = TestedReadings::new(&screen, others, found);
        Ok(tested.judged(self.reading, 1).unwrap_or(self))
    }

    /// # Arguments
    /// - `shift_m`: by how much the reading is too large, and its standard error, m.
    pub(super) fn new(
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
            factor: slip(value_m, expected_m, u_m),
            joint: None,
        }
    }
}
