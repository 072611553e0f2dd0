//! What parts without a robot file went through, and what they answer to it.

use std::ops::Range;
use std::sync::Arc;

use stiffbench_beams::physics::{DrivenPath, Effect, HistoryLaw, TestObject, Values, values_of};

use stiffbench_units_and_text::test_point::Branch;

use super::observations::Observations;

/// Share of the largest load within which a run of a part begins where the one before ended, so that its history goes on. Definition.
const CONTINUES: f64 = 0.05;

/// Path of a run, in its range, beyond which it is no way up with small errors but loads in shuffled order, if none of it is unloading. Definition.
const SHUFFLED: f64 = 2.0;

/// What a part went through from its virgin state on, and which of its readings count.
#[derive(Debug, Clone, PartialEq)]
pub struct RecordedHistory {
    /// Index of its configuration.
    configuration: usize,
    /// Factor on the sizes of effects in its configuration.
    size_factor: f64,
    /// The readings that count.
    readings: Range<usize>,
    /// Their places along the path.
    places: Vec<usize>,
    /// What was set at each place, in the unit of the loads.
    driver: Arc<[f64]>,
    /// The clock at each place, s or readings.
    time_s: Arc<[f64]>,
}

impl RecordedHistory {
    /// The histories of all runs: those of a configuration one after the other, where each begins near where the one before ended. Loads in
    /// shuffled order have no history: what lies between two of them was not recorded.
    ///
    /// # Arguments
    /// - `goes_on`: whether a run whose clock begins again goes on as well; the pause before it, which nobody knows, counts as none.
    pub(super) fn of_runs(observations: &Observations, goes_on: bool) -> Vec<Self> {
        let driver = |reading: usize| observations.loads[reading].force_n;
        let time_s = |reading: usize| observations.readings[reading].time_s.unwrap_or_default();
        let nearest = CONTINUES * observations.largest_load();
        let mut ranges: Vec<(usize, Range<usize>)> = Vec::new();
        for run in &observations.runs {
            if is_shuffled(observations, &run.readings) {
                let alone = run.readings.clone().map(|one| (run.cell, one..one + 1));
                ranges.extend(alone);
                continue;
            }
            let continues = |(cell, before): &&mut (usize, Range<usize>)| {
                let (end, begin) = (before.end - 1, run.readings.start);
                *cell == run.cell
                    && (driver(end) - driver(begin)).abs() <= nearest
                    && (goes_on || time_s(begin) >= time_s(end))
            };
            match ranges.last_mut().filter(continues) {
                Some((_, before)) => before.end = run.readings.end,
                None => ranges.push((run.cell, run.readings.clone())),
            }
        }
        let of_range = |(cell, readings): (usize, Range<usize>)| {
            let mut since_s = 0.0;
            let elapsed_s = readings.clone().map(|reading| {
                if reading > readings.start {
                    let step_s = time_s(reading) - time_s(reading - 1);
                    // A clock goes back within a run as it was recorded, and between runs where it begins again.
                    let begins = observations.readings[reading].run
                        != observations.readings[reading - 1].run;
                    since_s += if begins { step_s.max(0.0) } else { step_s };
                }
                time_s(readings.start) + since_s
            });
            Self {
                configuration: observations.cells[cell].pose,
                size_factor: 1.0,
                places: (0..readings.len()).collect(),
                driver: readings.clone().map(driver).collect(),
                time_s: elapsed_s.collect(),
                readings: readings.clone(),
            }
        };
        ranges.into_iter().map(of_range).collect()
    }

    /// Lets it begin with a load that was not read.
    pub(super) fn begin_at(&mut self, load: f64) {
        let first_s = self.time_s.first().copied();
        self.driver = std::iter::once(load)
            .chain(self.driver.iter().copied())
            .collect();
        self.time_s = first_s
            .into_iter()
            .chain(self.time_s.iter().copied())
            .collect();
        for place in &mut self.places {
            *place += 1;
        }
    }

    /// Takes the factor on sizes that its configuration has among others.
    pub(super) fn take_size_of(&mut self, others: &[Self]) {
        let own = others
            .iter()
            .find(|other| other.configuration == self.configuration);
        self.size_factor = own.map_or(self.size_factor, |own| own.size_factor);
    }

    /// The readings that count.
    pub(crate) fn kept_readings(&self) -> Range<usize> {
        self.readings.clone()
    }

    /// The histories of the readings that are kept: what a part went through stays as it was.
    ///
    /// # Arguments
    /// - `within`: the range of readings of which any are kept.
    /// - `keep`: one a reading.
    pub(crate) fn filtered(all: &[Self], within: &Range<usize>, keep: &[bool]) -> Vec<Self> {
        let is_kept = |reading: &usize| within.contains(reading) && keep[*reading];
        let mut first = 0;
        let own = all.iter().map(|history| {
            let readings = history.readings.clone().zip(&history.places);
            let kept = readings.filter(|(reading, _)| is_kept(reading));
            let places: Vec<usize> = kept.map(|(_, place)| *place).collect();
            let readings = first..first + places.len();
            first = readings.end;
            Self {
                configuration: history.configuration,
                size_factor: history.size_factor,
                readings,
                places,
                driver: Arc::clone(&history.driver),
                time_s: Arc::clone(&history.time_s),
            }
        });
        own.filter(|history| !history.places.is_empty()).collect()
    }
}

/// Whether a run goes back and forth without any branch of it counting as unloading.
fn is_shuffled(observations: &Observations, readings: &Range<usize>) -> bool {
    let mut own = observations.readings[readings.clone()].iter();
    if own.any(|reading| reading.branch == Branch::Unloading) {
        return false;
    }
    let driver = observations.loads[readings.clone()].iter();
    let driver: Vec<f64> = driver.map(|load| load.force_n).collect();
    let low = driver.iter().copied().fold(f64::INFINITY, f64::min);
    let high = driver.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let path: f64 = driver
        .windows(2)
        .map(|pair| (pair[1] - pair[0]).abs())
        .sum();
    path > SHUFFLED * (high - low)
}

impl Observations {
    /// Of each reading the number of its cycle in its run, from one unloading to the next.
    pub(crate) fn cycles(&self) -> Vec<u32> {
        let mut cycles = vec![0; self.len()];
        for run in &self.runs {
            let mut cycle = 0;
            for reading in run.readings.clone() {
                let branch = |place: usize| self.readings[place].branch;
                let begins = reading > run.readings.start
                    && branch(reading) == Branch::Loading
                    && branch(reading - 1) == Branch::Unloading;
                cycle += u32::from(begins);
                cycles[reading] = cycle;
            }
        }
        cycles
    }

    /// These as readings of a part: zeros may be anything, and what the part went through counts.
    pub(crate) fn of_part(mut self, object: TestObject) -> Self {
        self.object = object;
        self.free_zeros = true;
        self.histories = RecordedHistory::of_runs(&self, false);
        self
    }

    /// The factor on the sizes of effects in a configuration; 1 where nothing was recorded.
    pub(crate) fn size_factor(&self, configuration: usize) -> f64 {
        let of = |history: &&RecordedHistory| history.configuration == configuration;
        let own = self.histories.iter().find(of);
        own.map_or(1.0, |history| history.size_factor)
    }

    /// The same readings with factors on the sizes of effects.
    ///
    /// # Arguments
    /// - `factors`: one a configuration.
    pub(crate) fn with_size_factors(&self, factors: &[f64]) -> Self {
        let mut out = self.clone();
        for history in &mut out.histories {
            history.size_factor = factors[history.configuration];
        }
        out
    }

    /// What parts answer to their histories by a law; zero of readings that belong to none.
    ///
    /// # Arguments
    /// - `out`: one a reading, overwritten.
    pub(crate) fn answers(&self, law: &dyn HistoryLaw, values: &Values, out: &mut [f64]) {
        out.fill(0.0);
        let mut along = Vec::new();
        for history in &self.histories {
            let path = DrivenPath {
                driver: &history.driver,
                time_s: &history.time_s,
            };
            along.resize(path.driver.len(), 0.0);
            law.answers(values, path, &mut along);
            let read = out[history.readings.clone()].iter_mut();
            for (answer, place) in read.zip(&history.places) {
                *answer = history.size_factor * along[*place];
            }
        }
    }

    /// What parts answer to their histories under an effect; zero of one without a memory.
    ///
    /// # Arguments
    /// - `out`: one a reading, overwritten.
    pub(crate) fn answers_to(&self, effect: &Effect, out: &mut [f64]) {
        match effect.law.history() {
            Some(law) => self.answers(law, &values_of(&effect.values), out),
            None => out.fill(0.0),
        }
    }
}
