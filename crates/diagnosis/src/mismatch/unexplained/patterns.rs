//! Patterns that belong to no law: what is left when the laws have been tried, and where it sits.
//!
//! Each pattern is a profile (over load, branch, repeat, time) on a group of readings (all, a direction, a pose, a cell), in displacement
//! or in proportion to the compliance. An effect outside the library shows in some of them; their maximum is calibrated like a law's.

use std::ops::Range;

use indexmap::IndexSet;
use rayon::prelude::*;

use stiffbench_units_and_text::test_point::Direction;

use super::profiles::profiles;
use super::stratum::Stratum;
use crate::mismatch::noise::{loads_off, positions_of_repeats, positions_off};
use crate::mismatch::observed::{Observations, ObservedCell};
use crate::search::WhiteSpace;
use crate::search::{Batched, RowVector, ScoreEngine, largest};

/// A pattern shorter than this share of its length before projection is absorbed by the baseline (1). Numerics.
const ABSORBED_PATTERN: f64 = 1e-3;

/// Readings in a run from which on a rhythm in their order is searched for (1). By judgement (0f36cf8).
const ENOUGH_FOR_A_RHYTHM: usize = 32;

/// Runs from which on a swing of the clock is searched for (1): fewer show a trend at most. By judgement.
const RUNS_OF_A_SWING: usize = 8;

/// Most frequencies that are searched for (1). It bounds the work of runs of more than 400 readings and sessions of more than 100 runs. By
/// judgement (0f36cf8).
const FREQUENCIES: usize = 200;

/// The readings a pattern acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(crate) struct PatternGroup {
    pub(crate) pose: Option<usize>,
    pub(crate) direction: Option<Direction>,
}

impl PatternGroup {
    /// Each direction that was measured.
    pub(crate) fn of_directions(observations: &Observations) -> impl Iterator<Item = Self> {
        observations.directions().map(|direction| Self {
            direction: Some(direction),
            ..EVERYWHERE
        })
    }

    /// Each pose, if there are several.
    pub(crate) fn of_poses(observations: &Observations) -> impl Iterator<Item = Self> + use<> {
        let count = observations.poses.len();
        (0..count).filter(move |_| count > 1).map(|pose| Self {
            pose: Some(pose),
            ..EVERYWHERE
        })
    }

    /// Each cell.
    pub(crate) fn of_cells(observations: &Observations) -> impl Iterator<Item = Self> {
        observations.cells.iter().map(|cell| Self {
            pose: Some(cell.pose),
            direction: Some(cell.axis()),
        })
    }

    pub(crate) fn holds(&self, cell: &ObservedCell) -> bool {
        self.pose.is_none_or(|pose| pose == cell.pose)
            && self.direction.is_none_or(|d| d == cell.axis())
    }
}

/// Where the readings of groups lie.
struct GroupPlaces {
    groups: IndexSet<PatternGroup>,
    /// Cells from the first to the last series with a cell of each group: what gauges were read at once is white together only.
    cells: Vec<Range<usize>>,
    /// Whether all loads of each group have one size: then every shape over the load, all of which are odd, is the same.
    has_one_load: Vec<bool>,
}

/// Loads whose sizes differ by a smaller share are of one size.
const ONE_SIZE: f64 = 1e-9;

impl GroupPlaces {
    fn new(observations: &Observations, groups: impl IntoIterator<Item = PatternGroup>) -> Self {
        let groups: IndexSet<PatternGroup> = groups.into_iter().collect();
        let series: Vec<Range<usize>> = observations.series().collect();
        // Series from the first to the last with a cell of each pose.
        let mut of_poses: Vec<Range<usize>> = vec![0..0; observations.poses.len()];
        for (number, cells) in series.iter().enumerate() {
            for cell in &observations.cells[cells.clone()] {
                let own = &mut of_poses[cell.pose];
                let first = if own.end == 0 { number } else { own.start };
                *own = first..number + 1;
            }
        }
        let cells = groups.iter().map(|group| {
            let among = match group.pose {
                Some(pose) => &series[of_poses[pose].clone()],
                None => &series[..],
            };
            let holds = |cells: &&Range<usize>| {
                let mut cells = observations.cells[(*cells).clone()].iter();
                cells.any(|cell| group.holds(cell))
            };
            let first = among.iter().find(holds);
            let last = among.iter().rev().find(holds);
            first
                .zip(last)
                .map_or(0..0, |(first, last)| first.start..last.end)
        });
        let cells: Vec<Range<usize>> = cells.collect();
        let has_one_load = groups.iter().zip(&cells).map(|(group, cells)| {
            let own = observations.cells[cells.clone()].iter();
            let own = own.filter(|cell| group.holds(cell));
            let mut loads = own.flat_map(|cell| &observations.loads[cell.readings.clone()]);
            let first_n = loads.next().map_or(0.0, |load| load.force_n.abs());
            loads.all(|load| (load.force_n.abs() - first_n).abs() <= ONE_SIZE * first_n)
        });
        Self {
            has_one_load: has_one_load.collect(),
            cells,
            groups,
        }
    }

    fn has_one_load(&self, group: &PatternGroup) -> bool {
        let place = self.groups.get_index_of(group);
        place.is_some_and(|place| self.has_one_load[place])
    }

    /// The cells of a group, with others between them.
    fn cells_of(&self, group: &PatternGroup) -> Range<usize> {
        let place = self.groups.get_index_of(group);
        place.map_or(0..0, |place| self.cells[place].clone())
    }
}

/// A pattern, white, and of unit length when projected.
#[derive(Debug, Clone)]
pub(crate) struct ResidualPattern {
    pub(crate) stratum: Stratum,
    pub(crate) group: PatternGroup,
    /// Unit vectors: one, or two for a sine and cosine; not projected.
    pub(crate) units: Vec<RowVector>,
    /// Largest change of a reading for a unit along the first vector, m.
    pub(crate) size_m: f64,
    /// Of a swing of the clock, s.
    pub(crate) period_s: Option<f64>,
}

/// All patterns that some observations can show, each written out when it is wanted: together they would fill the memory.
pub(crate) struct Patterns<'a> {
    observations: &'a Observations,
    compliance: &'a [f64],
    /// Profiles, one value a reading.
    profiles: Vec<Vec<f64>>,
    /// Where the gauge stood at each reading, m.
    positions_m: Vec<f64>,
    /// Share of a profile that the scatter of the loads makes of it.
    loads_off: f64,
    all: Vec<Pattern>,
    places: GroupPlaces,
}

/// A pattern by what it is made of.
#[derive(Debug, Clone, Copy)]
struct Pattern {
    stratum: Stratum,
    group: PatternGroup,
    form: PatternForm,
}

#[derive(Debug, Clone, Copy)]
enum PatternForm {
    /// A profile by its number, in displacement or in proportion to the compliance.
    Profile { number: usize, scaled: bool },
    /// Sine and cosine of the reading, with a period in m.
    Period(f64),
    /// Sine and cosine of the place in the run, with so many cycles a reading.
    Order(f64),
    /// Sine and cosine of the clock, with a period in s.
    Swing(f64),
}

/// Memory for the changes of readings by a pattern, m, and for products.
#[derive(Debug, Default)]
pub(crate) struct PatternScratch {
    values_m: [Vec<f64>; 2],
    products: Vec<f64>,
}

impl<'a> Patterns<'a> {
    /// # Arguments
    /// - `compliance`: of the baseline at each reading, m/N.
    pub(crate) fn new(observations: &'a Observations, compliance: &'a [f64]) -> Self {
        let groups = groups(observations);
        let places = GroupPlaces::new(observations, groups.iter().copied());
        let profiles = profiles(observations);
        let mut shapes = profiles.iter();
        let first_shape = shapes.position(|one| one.stratum == Stratum::LoadStep);
        let (mut all, mut values) = (Vec::new(), Vec::new());
        for (number, profile) in profiles.into_iter().enumerate() {
            let is_further_shape =
                profile.stratum == Stratum::LoadStep && Some(number) != first_shape;
            let shown = groups
                .iter()
                .filter(|group| !(is_further_shape && places.has_one_load(group)));
            for scaled in [false, true].into_iter().filter(|s| !s || profile.scaled) {
                all.extend(shown.clone().map(|group| Pattern {
                    stratum: profile.stratum,
                    group: *group,
                    form: PatternForm::Profile { number, scaled },
                }));
            }
            values.push(profile.values);
        }
        let waves = period_patterns(observations).chain(order_patterns(observations));
        let waves = waves.map(|(group, form)| (Stratum::Rest, group, form));
        let swings = swing_patterns(observations);
        let swings = swings.map(|(group, form)| (Stratum::RepeatTime, group, form));
        all.extend(waves.chain(swings).map(|(stratum, group, form)| Pattern {
            stratum,
            group,
            form,
        }));
        let read = observations.loads.iter().zip(&observations.displacement_m);
        let read = read.map(|(load, read)| load.position_m.unwrap_or(*read));
        Self {
            observations,
            compliance,
            profiles: values,
            loads_off: loads_off(observations),
            positions_m: positions_of_repeats(observations, read.collect()),
            all,
            places,
        }
    }

    /// Places of the patterns that may share bases, group by group.
    pub(crate) fn alike(&self) -> Vec<Vec<usize>> {
        let patterns = self.all.iter();
        places_alike(patterns.map(|one| (one.stratum != Stratum::Rest).then_some(one.group)))
    }

    /// Writes what a pattern changes.
    ///
    /// # Returns
    /// The readings that it can change, a union of cells: the others are not written, and count as zero.
    fn write(&self, pattern: &Pattern, scratch: &mut PatternScratch) -> Range<usize> {
        let observations = self.observations;
        for values in &mut scratch.values_m {
            values.resize(observations.len(), 0.0);
        }
        let cells = &observations.cells[self.places.cells_of(&pattern.group)];
        let (Some(first), Some(last)) = (cells.first(), cells.last()) else {
            return 0..0;
        };
        let range = first.readings.start..last.readings.end;
        let [first, second] = &mut scratch.values_m;
        for cell in cells {
            if !pattern.group.holds(cell) {
                first[cell.readings.clone()].fill(0.0);
                second[cell.readings.clone()].fill(0.0);
                continue;
            }
            for reading in cell.readings.clone() {
                let turn = match pattern.form {
                    PatternForm::Profile { number, scaled } => {
                        let scale = if scaled {
                            self.compliance[reading]
                        } else {
                            1e-6
                        };
                        first[reading] = scale * self.profiles[number][reading];
                        continue;
                    }
                    PatternForm::Period(period_m) => self.positions_m[reading] / period_m,
                    PatternForm::Order(cycles) => {
                        let run = &observations.runs[observations.readings[reading].run];
                        cycles * (reading - run.readings.start) as f64
                    }
                    PatternForm::Swing(period_s) => {
                        observations.readings[reading].time_s.unwrap_or(0.0) / period_s
                    }
                };
                let angle = std::f64::consts::TAU * turn;
                first[reading] = 1e-6 * angle.sin();
                second[reading] = 1e-6 * angle.cos();
            }
        }
        range
    }

    /// A pattern made white; `None` if the fit absorbs it.
    pub(crate) fn white(
        &self,
        place: usize,
        space: &WhiteSpace,
        scratch: &mut PatternScratch,
    ) -> Option<ResidualPattern> {
        let pattern = &self.all[place];
        let range = self.write(pattern, scratch);
        let values = scratch.values_m.iter().take(pattern.form.vectors());
        let white = values.map(|values| space.white_part(values, &range));
        let by_scatter = match pattern.form {
            PatternForm::Profile { .. } | PatternForm::Order(_) | PatternForm::Swing(_) => {
                self.loads_off
            }
            PatternForm::Period(period_m) => {
                positions_off(self.observations, &space.covariance) / period_m
            }
        };
        let (units, length) = space.orthonormal(white, ABSORBED_PATTERN)?;
        let own = space.covariance.own_length(&scratch.values_m[0], &range);
        if length < by_scatter * own {
            return None;
        }
        Some(ResidualPattern {
            stratum: pattern.stratum,
            group: pattern.group,
            units,
            size_m: largest(&scratch.values_m[0][range]) / length,
            period_s: match pattern.form {
                PatternForm::Swing(period_s) => Some(period_s),
                _ => None,
            },
        })
    }

    /// Drop of the weighted squares by a pattern, by products; that of what the fit absorbs is not to be relied on.
    fn delta_chi2(
        &self,
        pattern: &Pattern,
        engine: &impl ScoreEngine,
        scratch: &mut PatternScratch,
    ) -> f64 {
        let range = self.write(pattern, scratch);
        let PatternScratch {
            values_m: [first, second],
            products,
        } = scratch;
        if pattern.form.vectors() == 1 {
            return engine.moments(first, &range, products).delta_chi2();
        }
        let pair = engine.pair_moments([first, second], &range, products);
        pair.delta_chi2()
    }

    /// The largest pattern of each stratum in white residuals, and its fall of the squares; of equal ones the first.
    pub(crate) fn largest(
        &self,
        space: &WhiteSpace,
        residuals: &[f64],
    ) -> Vec<(f64, ResidualPattern)> {
        // Gains by products have lost some of their digits.
        const NEARLY: f64 = 1.0 - 1e-6;
        let all = &self.all;
        let engine = Batched::new(space, residuals);
        let delta_chi2s: Vec<f64> = all
            .par_iter()
            .map_init(PatternScratch::default, |scratch, pattern| {
                self.delta_chi2(pattern, &engine, scratch)
            })
            .collect();
        let mut scratch = PatternScratch::default();
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
                let Some(pattern) = self.white(place, space, &mut scratch) else {
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
}

impl PatternForm {
    /// How many vectors it has.
    fn vectors(self) -> usize {
        match self {
            Self::Profile { .. } => 1,
            Self::Period(_) | Self::Order(_) | Self::Swing(_) => 2,
        }
    }
}

/// Places that have the same key, in the order in which the keys come.
pub(crate) fn places_alike<K: PartialEq>(keys: impl Iterator<Item = K>) -> Vec<Vec<usize>> {
    let mut alike: Vec<(K, Vec<usize>)> = Vec::new();
    for (place, key) in keys.enumerate() {
        // Those of one key mostly follow each other.
        match alike.iter_mut().rfind(|(known, _)| *known == key) {
            Some((_, places)) => places.push(place),
            None => alike.push((key, vec![place])),
        }
    }
    alike.into_iter().map(|(_, places)| places).collect()
}

/// All readings.
const EVERYWHERE: PatternGroup = PatternGroup {
    pose: None,
    direction: None,
};

/// Sines and cosines of the clock, with periods from twice the session down to the time between the starts of two runs: a room that swings.
///
/// Faster ones show as a correlation within runs. The frequencies are half the resolution of the session apart.
fn swing_patterns(
    observations: &Observations,
) -> impl Iterator<Item = (PatternGroup, PatternForm)> {
    let times = observations.readings.iter().filter_map(|r| r.time_s);
    let (first, last) = times.fold((f64::INFINITY, f64::NEG_INFINITY), |(first, last), time| {
        (first.min(time), last.max(time))
    });
    let longest_s = 2.0 * (last - first);
    let count = if longest_s > 0.0 && observations.runs.len() >= RUNS_OF_A_SWING {
        (2 * observations.runs.len()).min(FREQUENCIES)
    } else {
        0
    };
    (1..=count).map(move |number| (EVERYWHERE, PatternForm::Swing(longest_s / number as f64)))
}

/// Sines and cosines of the place in the run: something that repeats itself with the readings.
fn order_patterns(
    observations: &Observations,
) -> impl Iterator<Item = (PatternGroup, PatternForm)> {
    let runs = observations.runs.iter();
    let longest = runs.map(|run| run.readings.len()).max().unwrap_or(0);
    let count = if longest < ENOUGH_FOR_A_RHYTHM {
        1
    } else {
        (longest / 2).min(FREQUENCIES)
    };
    (1..count).map(move |number| {
        (
            EVERYWHERE,
            PatternForm::Order(0.5 * number as f64 / count as f64),
        )
    })
}

fn groups(observations: &Observations) -> Vec<PatternGroup> {
    let directions = PatternGroup::of_directions(observations);
    let parts = directions.chain(PatternGroup::of_poses(observations));
    let parts = parts.chain(PatternGroup::of_cells(observations));
    std::iter::once(EVERYWHERE).chain(parts).collect()
}

/// Sines and cosines of the reading, in all cells together and in each pose: periods of gauges, and half of them for their harmonics.
fn period_patterns(
    observations: &Observations,
) -> impl Iterator<Item = (PatternGroup, PatternForm)> {
    let range_m = largest(&observations.displacement_m);
    let allowed = stiffbench_beams::physics::laws::SHORTEST_PERIOD_M..0.7 * range_m;
    let nominal = stiffbench_beams::physics::laws::NOMINAL_PERIODS_M;
    let mut periods: Vec<f64> = nominal
        .into_iter()
        .chain(nominal.map(|p| 0.5 * p))
        .collect();
    periods.retain(|period| allowed.contains(period));
    periods.sort_by(f64::total_cmp);
    periods.dedup();
    let poses = PatternGroup::of_poses(observations);
    let groups: Vec<PatternGroup> = std::iter::once(EVERYWHERE).chain(poses).collect();
    periods.into_iter().flat_map(move |period| {
        let groups = groups.clone().into_iter();
        groups.map(move |group| (group, PatternForm::Period(period)))
    })
}

/// Chance that white residuals follow each other as closely as these; `None` if no run is long enough for the question.
///
/// Sum of the products of neighbours within runs over the square root of the sum of their squares: normal for many readings
/// (Bartlett, J. R. Stat. Soc. Suppl. 8 (1946)). What the fit of a run's zero and slope takes away only lowers it.
pub(crate) fn autocorrelation_p(observations: &Observations, residuals: &[f64]) -> Option<f64> {
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
    pub(crate) fn of_the_rest(self) -> Self {
        Self {
            stratum: Stratum::Rest,
            period_s: None,
            ..self
        }
    }

    /// Drop of the weighted squares of residuals that are projected.
    pub(crate) fn delta_chi2(&self, residuals: &[f64]) -> f64 {
        self.units
            .iter()
            .map(|unit| unit.dot(residuals).powi(2))
            .sum()
    }
}
