//! Columns of readings: of one cell each (zeros, slopes, levels of load), and through all cells (factors, clock, repeats).

use std::ops::Range;

use crate::mismatch::noise::{NoiseCovariance, force_within_steps, loads_off};
use crate::mismatch::observed::{Observations, ObservedReading};
use stiffbench_units_and_text::test_point::Branch;

use super::bases::{CellColumns, GlobalColumn, LocalBasis};
use super::contrasts::{Basis, Stage};
use super::levels::{indicators, levels};
use crate::search::RowVector;
use crate::search::constants::{COLUMN_LEFT, ROUNDING};

/// A factor that moves no reading by more than this many standard errors within all that is known of it is left out: it absorbs nothing. By
/// judgement (f10797f).
const ABSORBS_NOTHING: f64 = 0.05;

/// The same of a level of load (1): its loads differ by what the jack left, and what differs between them alone is no level. Numerics: the last
/// contrast of five even levels beside a line and two curves is an eighth of one of them.
const LEVEL_LEFT: f64 = 0.1;

/// What a decomposition is made for.
pub(super) struct Setting<'a, 'c> {
    /// The readings.
    pub(super) observations: &'a Observations,
    /// Their noise.
    pub(super) whitening: &'a NoiseCovariance,
    /// Derivatives of the readings to the parameters of the model, m: baseline first, then effects.
    pub(super) columns: &'c [Vec<f64>],
    /// Standard deviation of what is known of each parameter of the baseline beforehand.
    pub(super) prior_sd: &'c [f64],
    /// Prediction of the linear structure, m.
    pub(super) slope_m: &'c [f64],
}

/// Global columns by what they are for.
pub(super) struct ColumnSets {
    pub(super) globals: Vec<GlobalColumn>,
    pub(super) model: Vec<usize>,
    pub(super) clock: Vec<usize>,
    pub(super) repeat: Vec<usize>,
}

/// All bases.
///
/// # Arguments
/// - `mixed`: whether there are runs that pull and push, within which one slope is compared with the other; else runs are compared.
pub(super) fn bases(
    observations: &Observations,
    whitening: &NoiseCovariance,
    mixed: bool,
) -> [LocalBasis; 4] {
    let cells = CellColumnSet {
        observations,
        errors_of_force: force_within_steps(observations, &whitening.noise),
    };
    Basis::ALL.map(|basis| {
        let has_sign = mixed != (basis == Basis::Between);
        let columns = |stage: Stage, cell: usize| match stage {
            Stage::Sign if !has_sign => CellColumns::new(),
            _ => cells.of_stage(stage, cell),
        };
        LocalBasis::new(observations, whitening, basis, &columns)
    })
}

impl Stage {
    /// Share of the length of a column below which, once the stages before are taken out, it counts as spanned by them.
    pub(super) fn least(self) -> f64 {
        match self {
            Self::Zeros | Self::RunSlopes | Self::Slope | Self::Offset => ROUNDING,
            Self::Levels | Self::Branches => LEVEL_LEFT,
            Self::Holds | Self::Sign | Self::Curves | Self::Loops => COLUMN_LEFT,
        }
    }
}

/// Columns of one cell.
struct CellColumnSet<'a> {
    observations: &'a Observations,
    /// By cell, of all readings; empty where they are not told apart.
    errors_of_force: Vec<Vec<f64>>,
}

impl CellColumnSet<'_> {
    /// Columns of a cell, m.
    fn of_stage(&self, stage: Stage, cell: usize) -> CellColumns {
        let unloads = |one: &ObservedReading| one.branch == Branch::Unloading;
        match stage {
            Stage::Zeros => {
                let mut zeros = self.by_level(cell, |_, one| Some(one.zero));
                let readings = self.observations.cells[cell].readings.clone();
                zeros.extend(self.errors_of_force.get(cell).map(|column| RowVector {
                    first: readings.start,
                    values: column[readings].to_vec(),
                }));
                zeros
            }
            Stage::RunSlopes => self.run_slopes(cell),
            Stage::Slope => vec![self.of(cell, |force| force)],
            Stage::Offset => vec![self.of(cell, |_| 1.0)],
            Stage::Sign => vec![self.of(cell, f64::abs)],
            Stage::Curves => vec![
                self.of(cell, |force| force * force.abs()),
                self.of(cell, |force| force.powi(3)),
            ],
            Stage::Levels => self.by_level(cell, |level, _| Some(level)),
            Stage::Loops => self.by_level(cell, |_, one| unloads(one).then_some(())),
            Stage::Branches => self.by_level(cell, |level, one| unloads(one).then_some(level)),
            Stage::Holds => self.by_level(cell, |level, one| {
                let number = one.hold_number;
                (number > 0).then_some((level, unloads(one), number))
            }),
        }
    }

    /// A function of force and place, with forces as shares of the largest.
    fn of(&self, cell: usize, value: impl Fn(f64) -> f64) -> RowVector {
        self.of_readings(cell, &self.observations.cells[cell].readings, value)
    }

    /// The same in some of its readings.
    fn of_readings(
        &self,
        cell: usize,
        readings: &Range<usize>,
        value: impl Fn(f64) -> f64,
    ) -> RowVector {
        let all = self.observations.cells[cell].readings.clone();
        let loads = &self.observations.loads;
        let most = all
            .map(|reading| loads[reading].force_n.abs())
            .fold(f64::MIN_POSITIVE, f64::max);
        let values = readings
            .clone()
            .map(|reading| value(loads[reading].force_n / most));
        RowVector {
            first: readings.start,
            values: values.collect(),
        }
    }

    /// Columns of ones, one for each key that the levels and readings of a cell have.
    fn by_level<K: Ord>(
        &self,
        cell: usize,
        key: impl Fn(usize, &ObservedReading) -> Option<K>,
    ) -> CellColumns {
        let readings = self.observations.cells[cell].readings.clone();
        let details = self.observations.readings[readings.clone()].iter();
        let keys = levels(self.observations, cell).into_iter().zip(details);
        indicators(readings.start, keys.map(|(level, one)| key(level, one)))
    }

    fn run_slopes(&self, cell: usize) -> CellColumns {
        let runs = self.observations.cells[cell].runs.clone();
        let readings = |run: usize| &self.observations.runs[run].readings;
        runs.map(|run| self.of_readings(cell, readings(run), |force| force))
            .collect()
    }
}

/// All global columns, white.
pub(super) fn sets(setting: &Setting<'_, '_>) -> ColumnSets {
    let observations = setting.observations;
    let mut globals: Vec<GlobalColumn> = Vec::new();
    let mut push = |columns: Vec<Vec<f64>>, least_share: f64, least: &dyn Fn(usize) -> f64| {
        let first = globals.len();
        for (place, mut white) in columns.into_iter().enumerate() {
            setting.whitening.covariance.whiten(&mut white);
            globals.push(GlobalColumn {
                white,
                least_share,
                least: least(place),
            });
        }
        (first..globals.len()).collect::<Vec<usize>>()
    };
    let model = push(setting.columns.to_vec(), ROUNDING, &|place| {
        let prior_sd = setting.prior_sd.get(place);
        prior_sd.map_or(0.0, |prior_sd| ABSORBS_NOTHING / prior_sd)
    });
    let clock = clock_columns(observations);
    let off = loads_off(observations);
    let by_loads = |column: &Vec<f64>| {
        let covariance = &setting.whitening.covariance;
        off * covariance.own_length(column, &(0..column.len()))
    };
    let least: Vec<f64> = clock.iter().map(by_loads).collect();
    let clock = push(clock, COLUMN_LEFT, &|place| least[place]);
    let repeat = push(
        repeat_columns(observations, setting.slope_m),
        COLUMN_LEFT,
        &|_| 0.0,
    );
    ColumnSets {
        globals,
        model,
        clock,
        repeat,
    }
}

/// Time since the zero, the same with a rate that changes through the session, and warming since the zero.
fn clock_columns(observations: &Observations) -> Vec<Vec<f64>> {
    let loads = &observations.loads;
    let mut columns: Vec<Vec<f64>> = Vec::new();
    if observations.recorded.time && !observations.is_one_sweep() {
        let times = || {
            observations
                .readings
                .iter()
                .map(|r| r.time_s.unwrap_or(0.0))
        };
        let end = times().fold(f64::MIN_POSITIVE, f64::max);
        for power in 0..3 {
            let column = loads
                .iter()
                .zip(times())
                .map(|(load, time)| load.since_zero_s * (time / end - 0.5).powi(power));
            columns.push(column.collect());
        }
    }
    if observations.recorded.temperature {
        columns.push(loads.iter().map(|load| load.warming_k).collect());
    }
    columns
}

/// The slope in proportion to itself: of the first repeat, decaying over the repeats, growing with them.
fn repeat_columns(observations: &Observations, slope_m: &[f64]) -> Vec<Vec<f64>> {
    let trends: [fn(f64) -> f64; 3] = [
        |after| f64::from(u8::from(after == 0.0)),
        |after| (-0.5 * after).exp(),
        |after| after,
    ];
    trends
        .into_iter()
        .map(|trend| {
            observations
                .readings
                .iter()
                .zip(slope_m)
                .map(|(reading, slope)| {
                    let repeat = observations.runs[reading.run].repeat;
                    slope * trend(f64::from(repeat) - 1.0)
                })
                .collect()
        })
        .collect()
}
