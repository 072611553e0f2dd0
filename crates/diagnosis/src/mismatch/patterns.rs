//! Patterns that belong to no law: what is left when the laws have been tried, and where it sits.
//!
//! Each pattern is a profile (over load, branch, repeat, time) on a group of readings (all, a direction, a pose, a cell), in displacement
//! or in proportion to the compliance. An effect outside the library shows in some of them; their maximum is calibrated like a law's.

use std::ops::Range;

use rayon::prelude::*;

use stiffbench_units_and_text::test_point::Direction;

use super::observations::{Observations, ObservedCell};
use super::profiles::profiles;
use super::stratum::Stratum;
use crate::search::WhiteSpace;
use crate::search::constants::{ABSORBED_PATTERN, ENOUGH_FOR_A_RHYTHM, FREQUENCIES};
use crate::search::{Batched, ScoreEngine, dot};

/// The readings a pattern acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct PatternGroup {
    pub(super) pose: Option<usize>,
    pub(super) direction: Option<Direction>,
}

impl PatternGroup {
    fn holds(&self, cell: &ObservedCell) -> bool {
        self.pose.is_none_or(|pose| pose == cell.pose)
            && self.direction.is_none_or(|d| d == cell.direction)
    }

    /// Readings from the first to the last cell of the group.
    fn range(&self, observations: &Observations) -> Range<usize> {
        let mut cells = observations.cells.iter().filter(|cell| self.holds(cell));
        let Some(first) = cells.next() else {
            return 0..0;
        };
        let last = cells.next_back().unwrap_or(first);
        first.readings.start..last.readings.end
    }
}

/// A pattern, white, and of unit length when projected.
#[derive(Debug, Clone)]
pub(super) struct ResidualPattern {
    pub(super) stratum: Stratum,
    pub(super) group: PatternGroup,
    /// Unit vectors: one, or two for a sine and cosine; not projected.
    pub(super) units: Vec<Vec<f64>>,
    /// Largest change of a reading for a unit along the first vector, m.
    pub(super) size_m: f64,
}

/// A pattern in readings, m: one vector, or two for a sine and cosine.
struct InReadings {
    stratum: Stratum,
    group: PatternGroup,
    values_m: Vec<Vec<f64>>,
}

/// All patterns that these observations can show.
pub(super) fn patterns(
    observations: &Observations,
    compliance: &[f64],
    space: &WhiteSpace,
) -> Vec<ResidualPattern> {
    in_readings(observations, compliance)
        .par_iter()
        .filter_map(|pattern| pattern.white(space))
        .collect()
}

/// The largest pattern of each stratum in white residuals, and its gain; of equal ones the first.
pub(super) fn largest_patterns(
    observations: &Observations,
    compliance: &[f64],
    space: &WhiteSpace,
    residuals: &[f64],
) -> Vec<(f64, ResidualPattern)> {
    // Gains by products have lost some of their digits.
    const NEARLY: f64 = 1.0 - 1e-6;
    let all = in_readings(observations, compliance);
    let engine = Batched::new(space, residuals);
    let delta_chi2s: Vec<f64> = all
        .par_iter()
        .map_init(Vec::new, |memory, pattern| {
            pattern.delta_chi2(observations, &engine, memory)
        })
        .collect();
    let largest_of = |stratum: Stratum| {
        let mut places: Vec<usize> = (0..all.len())
            .filter(|&place| all[place].stratum == stratum)
            .collect();
        places.sort_by(|&a, &b| delta_chi2s[b].total_cmp(&delta_chi2s[a]));
        let mut best: Option<(f64, usize, ResidualPattern)> = None;
        for place in places {
            let most = best.as_ref().map_or(f64::NEG_INFINITY, |best| best.0);
            if delta_chi2s[place] < NEARLY * most {
                break;
            }
            let Some(pattern) = all[place].white(space) else {
                continue;
            };
            let delta_chi2 = pattern.delta_chi2(residuals);
            let is_first = |best: &(f64, usize, ResidualPattern)| place < best.1;
            if delta_chi2 > most || delta_chi2 == most && best.as_ref().is_none_or(is_first) {
                best = Some((delta_chi2, place, pattern));
            }
        }
        best
    };
    let largest = Stratum::ALL.into_iter().filter_map(largest_of);
    largest
        .map(|(delta_chi2, _, pattern)| (delta_chi2, pattern))
        .collect()
}

fn in_readings(observations: &Observations, compliance: &[f64]) -> Vec<InReadings> {
    let groups = groups(observations);
    let mut out = Vec::new();
    for profile in profiles(observations) {
        let plain: Vec<f64> = (0..observations.len()).map(&profile.value).collect();
        for scaled in [false, true].into_iter().filter(|s| !s || profile.scaled) {
            let scale = |reading: usize| if scaled { compliance[reading] } else { 1e-6 };
            for group in &groups {
                let mut values_m = vec![0.0; observations.len()];
                for cell in observations.cells.iter().filter(|cell| group.holds(cell)) {
                    for reading in cell.readings.clone() {
                        values_m[reading] = scale(reading) * plain[reading];
                    }
                }
                out.push(InReadings {
                    stratum: profile.stratum,
                    group: *group,
                    values_m: vec![values_m],
                });
            }
        }
    }
    out.extend(period_patterns(observations));
    out.extend(order_patterns(observations));
    out
}

/// Sines and cosines of the place in the run: something that repeats itself with the readings.
fn order_patterns(observations: &Observations) -> Vec<InReadings> {
    let longest = observations
        .runs
        .iter()
        .map(|run| run.readings.len())
        .max()
        .unwrap_or(0);
    if longest < ENOUGH_FOR_A_RHYTHM {
        return Vec::new();
    }
    let all = PatternGroup {
        pose: None,
        direction: None,
    };
    let count = (longest / 2).min(FREQUENCIES);
    (1..count)
        .into_par_iter()
        .map(|number| {
            let cycles = 0.5 * number as f64 / count as f64;
            let turn = |phase: f64| -> Vec<f64> {
                (0..observations.len())
                    .map(|reading| {
                        let first = observations.runs[observations.readings[reading].run]
                            .readings
                            .start;
                        let place = (reading - first) as f64;
                        1e-6 * (std::f64::consts::TAU * cycles * place + phase).sin()
                    })
                    .collect()
            };
            InReadings {
                stratum: Stratum::Rest,
                group: all,
                values_m: vec![turn(0.0), turn(std::f64::consts::FRAC_PI_2)],
            }
        })
        .collect()
}

impl InReadings {
    /// Made white; `None` if the fit absorbs it.
    fn white(&self, space: &WhiteSpace) -> Option<ResidualPattern> {
        let (units, length) = space.orthonormal(&self.values_m, ABSORBED_PATTERN)?;
        let first = self.values_m.first()?.iter();
        Some(ResidualPattern {
            stratum: self.stratum,
            group: self.group,
            units,
            size_m: first.fold(0.0_f64, |most, v| most.max(v.abs())) / length,
        })
    }

    /// Drop of the weighted squares, by products; that of what the fit absorbs is not to be relied on.
    fn delta_chi2(
        &self,
        observations: &Observations,
        engine: &impl ScoreEngine,
        memory: &mut Vec<f64>,
    ) -> f64 {
        match &self.values_m[..] {
            [values] => {
                let rows = self.group.range(observations);
                engine.moments(values, &rows, memory).delta_chi2()
            }
            [sine, cosine, ..] => engine.pair_moments([sine, cosine], memory).delta_chi2(),
            [] => 0.0,
        }
    }
}

fn groups(observations: &Observations) -> Vec<PatternGroup> {
    let mut groups = vec![PatternGroup {
        pose: None,
        direction: None,
    }];
    let directions = Direction::ALL
        .into_iter()
        .filter(|d| observations.cells.iter().any(|cell| cell.direction == *d));
    groups.extend(directions.map(|direction| PatternGroup {
        pose: None,
        direction: Some(direction),
    }));
    if observations.poses.len() > 1 {
        groups.extend((0..observations.poses.len()).map(|pose| PatternGroup {
            pose: Some(pose),
            direction: None,
        }));
    }
    groups.extend(observations.cells.iter().map(|cell| PatternGroup {
        pose: Some(cell.pose),
        direction: Some(cell.direction),
    }));
    groups
}

/// Sines and cosines of the reading, in all cells together and in each pose: periods of gauges, and half of them for their harmonics.
fn period_patterns(observations: &Observations) -> Vec<InReadings> {
    let range_m = observations
        .displacement_m
        .iter()
        .map(|d| d.abs())
        .fold(0.0, f64::max);
    let allowed = stiffbench_beams::physics::laws::SHORTEST_PERIOD_M..0.7 * range_m;
    let nominal = stiffbench_beams::physics::laws::NOMINAL_PERIODS_M;
    let mut periods: Vec<f64> = nominal
        .into_iter()
        .chain(nominal.map(|p| 0.5 * p))
        .collect();
    periods.retain(|period| allowed.contains(period));
    periods.sort_by(f64::total_cmp);
    periods.dedup();
    let group = |pose| PatternGroup {
        pose,
        direction: None,
    };
    let poses = observations.poses.len();
    let each = (0..poses).filter(|_| poses > 1).map(Some);
    let groups: Vec<PatternGroup> = std::iter::once(None).chain(each).map(group).collect();
    let wanted: Vec<(f64, PatternGroup)> = periods
        .iter()
        .flat_map(|period| groups.iter().map(|group| (*period, *group)))
        .collect();
    wanted
        .into_par_iter()
        .map(|(period, group)| {
            let turn = |phase: f64| -> Vec<f64> {
                (0..observations.len())
                    .map(|reading| {
                        let cell = &observations.cells[observations.cell_of(reading)];
                        if group.pose.is_some_and(|pose| pose != cell.pose) {
                            return 0.0;
                        }
                        let read = observations.displacement_m[reading];
                        let at = observations.loads[reading].position_m.unwrap_or(read);
                        1e-6 * (std::f64::consts::TAU * at / period + phase).sin()
                    })
                    .collect()
            };
            InReadings {
                stratum: Stratum::Rest,
                group,
                values_m: vec![turn(0.0), turn(std::f64::consts::FRAC_PI_2)],
            }
        })
        .collect()
}

/// Chance that white residuals follow each other as closely as these; `None` if no run is long enough for the question.
///
/// Sum of the products of neighbours within runs over the square root of the sum of their squares: normal for many readings
/// (Bartlett, J. R. Stat. Soc. Suppl. 8 (1946)). What the fit of a run's zero and slope takes away only lowers it.
pub(super) fn autocorrelation_p(observations: &Observations, residuals: &[f64]) -> Option<f64> {
    let long = || {
        observations
            .runs
            .iter()
            .filter(|run| run.readings.len() >= ENOUGH_FOR_A_RHYTHM)
    };
    long().next()?;
    let (mut sum, mut squares) = (0.0, 0.0);
    for run in long() {
        for pair in residuals[run.readings.clone()].windows(2) {
            let product = pair[0] * pair[1];
            sum += product;
            squares += product * product;
        }
    }
    (squares > 0.0).then(|| stiffbench_numeric::statistics::normal_upper_tail(sum / squares.sqrt()))
}

impl ResidualPattern {
    /// The same, as a sign that what is left belongs to no particular stratum.
    pub(super) fn of_the_rest(self) -> Self {
        Self {
            stratum: Stratum::Rest,
            ..self
        }
    }

    /// Drop of the weighted squares of residuals that are projected.
    pub(super) fn delta_chi2(&self, residuals: &[f64]) -> f64 {
        self.units
            .iter()
            .map(|unit| dot(unit, residuals).powi(2))
            .sum()
    }
}
