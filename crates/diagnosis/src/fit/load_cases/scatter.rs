//! How the rows of load cases scatter, each by itself and together with the others of its case.

use indexmap::IndexMap;
use stiffbench_numeric::statistics::root_mean_square;

use super::posed::{PosedLoadCases, ReadComponent};
use crate::mismatch::{ForceReading, GaugeSteps, NoiseCovariance, Observations, ReadingNoise};
use crate::search::constants::ROUNDING;
use crate::search::{Covariance, dot, largest};

/// Loads that differ by less than this share of the larger are one load applied again.
pub(in crate::fit) const SAME_LOAD: f64 = 0.05;

/// Rows that hold one component under one load in one pose, each as often as it was read.
pub(in crate::fit) fn repeated_rows(posed: &PosedLoadCases) -> Vec<Vec<usize>> {
    struct Repeated<'p> {
        load: [f64; 6],
        read: &'p ReadComponent,
        rows: Vec<usize>,
    }
    let mut groups: IndexMap<(usize, usize), Vec<Repeated<'_>>> = IndexMap::new();
    for (row, (case, read)) in posed.rows().enumerate() {
        let groups = groups.entry((case.label, case.pose)).or_default();
        let known = groups
            .iter_mut()
            .find(|known| known.read.unit == read.unit && is_same_load(&known.load, &case.load));
        match known {
            Some(known) => known.rows.push(row),
            None => groups.push(Repeated {
                load: case.load,
                read,
                rows: vec![row],
            }),
        }
    }
    let mut rows: Vec<Vec<usize>> = groups
        .into_values()
        .flatten()
        .map(|known| known.rows)
        .collect();
    rows.sort_by_key(|rows| rows[0]);
    rows
}

/// Root mean square of displacements, m, and of rotations, rad; one of what was not read.
pub(in crate::fit) fn sizes(posed: &PosedLoadCases) -> [f64; 2] {
    [false, true].map(|rotation| {
        let rows = posed.rows();
        let own = rows.filter(|(_, read)| read.is_rotation() == rotation);
        let size = root_mean_square(own.map(|(_, read)| read.value));
        size.filter(|size| *size > 0.0).unwrap_or(1.0)
    })
}

/// Kind of each row: 0 of displacements, 1 of rotations.
pub(in crate::fit) fn kinds(posed: &PosedLoadCases) -> Vec<usize> {
    let rows = posed.rows();
    rows.map(|(_, read)| usize::from(read.is_rotation()))
        .collect()
}

/// How rows scatter: as readings of a session, each by itself and together with the others of its load case. Rows that are no readings weigh nothing.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct RowScatter {
    /// The rows that take part as readings of series.
    pub(in crate::fit) series: Observations,
    /// The row of the table of each reading.
    pub(in crate::fit) rows: Vec<usize>,
    noise: RowNoise,
    covariance: Covariance,
}

/// What makes rows scatter.
#[derive(Debug, Clone, PartialEq)]
enum RowNoise {
    /// Standard deviations of displacements, m, and of rotations, rad.
    Kinds([f64; 2]),
    /// The noise of a session, with what each row moves by without error and by each component of the force, of every row of the table.
    Readings {
        noise: ReadingNoise,
        moved_m: Vec<f64>,
        by_force: Vec<[f64; 3]>,
    },
}

impl RowScatter {
    /// Each row by itself.
    ///
    /// # Arguments
    /// - `sd`: standard deviations of displacements, m, and of rotations, rad.
    pub(in crate::fit) fn plain(posed: &PosedLoadCases, steps: GaugeSteps, sd: [f64; 2]) -> Self {
        let (series, rows) = posed.series_and_rows(steps, None);
        Self::new(series, rows, RowNoise::Kinds(sd))
    }

    fn new(series: Observations, rows: Vec<usize>, noise: RowNoise) -> Self {
        let gathered =
            |column: &[f64]| -> Vec<f64> { rows.iter().map(|row| column[*row]).collect() };
        let covariance = match &noise {
            RowNoise::Kinds(sd) => {
                let readings = 0..series.len();
                let kind =
                    |reading| usize::from(series.cells[series.cell_of(reading)].read.is_rotation());
                let variances: Vec<f64> = readings.map(|one| sd[kind(one)].powi(2)).collect();
                Covariance::new(&variances, [])
            }
            RowNoise::Readings {
                noise,
                moved_m,
                by_force,
            } => {
                let by_force: Vec<[f64; 3]> = rows.iter().map(|row| by_force[*row]).collect();
                let force = ForceReading::ByComponents(&by_force);
                NoiseCovariance::new(&series, noise, &gathered(moved_m), force).covariance
            }
        };
        Self {
            series,
            rows,
            noise,
            covariance,
        }
    }

    /// The same rows under the noise of a session: of each row its own, and what an error of the load moves, common to the rows of a case.
    ///
    /// # Arguments
    /// - `moved_m`: every row of the table as it is without error.
    /// - `by_force`: what each component of the force moves it by, as of [`ForceReading::ByComponents`].
    pub(in crate::fit) fn with_noise(
        &self,
        noise: ReadingNoise,
        moved_m: Vec<f64>,
        by_force: Vec<[f64; 3]>,
    ) -> Self {
        let noise = RowNoise::Readings {
            noise,
            moved_m,
            by_force,
        };
        Self::new(self.series.clone(), self.rows.clone(), noise)
    }

    /// Mean share of what a case has in common in the variance of its rows.
    pub(in crate::fit) fn common_share(&self) -> f64 {
        let RowNoise::Readings {
            noise,
            moved_m,
            by_force,
        } = &self.noise
        else {
            return 0.0;
        };
        let step_n = self.series.steps.force_n.unwrap_or(0.0);
        let force_variance = step_n * step_n / 12.0 + noise.gauges.force_sd_n.powi(2);
        let share = |(reading, &row): (usize, &usize)| {
            let moved = moved_m[row];
            let read = &self.series.cells[self.series.cell_of(reading)].read;
            let own = noise.own_variance(read, moved) + (noise.gauges.own_slope_sd * moved).powi(2);
            let common = (noise.run_slope_sd * moved).powi(2)
                + force_variance * dot(&by_force[row], &by_force[row]);
            common / (own + common)
        };
        let shares = self.rows.iter().enumerate().map(share);
        shares.sum::<f64>() / self.rows.len().max(1) as f64
    }

    /// The same without some rows of the table.
    pub(in crate::fit) fn without(&self, is_left_out: impl Fn(usize) -> bool) -> Self {
        let keep: Vec<bool> = self.rows.iter().map(|row| !is_left_out(*row)).collect();
        if keep.iter().all(|keep| *keep) {
            return self.clone();
        }
        let rows = self.rows.iter().zip(&keep).filter(|(_, keep)| **keep);
        let rows = rows.map(|(row, _)| *row).collect();
        Self::new(self.series.filtered(&keep), rows, self.noise.clone())
    }

    /// A column of all rows in the order of the readings.
    pub(in crate::fit) fn of_readings(&self, column: &[f64]) -> Vec<f64> {
        self.rows.iter().map(|row| column[*row]).collect()
    }

    /// Makes rows white in place, those that take no part zero.
    pub(in crate::fit) fn whiten(&self, rows: &mut [f64]) {
        let mut white = self.of_readings(rows);
        self.covariance.whiten(&mut white);
        rows.fill(0.0);
        for (row, white) in self.rows.iter().zip(white) {
            rows[*row] = white;
        }
    }

    /// The sum of the squares of white rows.
    pub(in crate::fit) fn squares(&self, rows: &[f64]) -> f64 {
        let mut white = self.of_readings(rows);
        self.covariance.whiten(&mut white);
        dot(&white, &white)
    }

    /// The length of a column of white rows; `None` if the rows with weight do not show it.
    pub(in crate::fit) fn length(&self, column: &[f64]) -> Option<f64> {
        let (length, whole) = (self.squares(column).sqrt(), dot(column, column).sqrt());
        let heaviest = largest(self.covariance.weights());
        (length > ROUNDING * whole * heaviest).then_some(length)
    }
}

/// The smallest difference between values that differ; infinite if none do.
pub(in crate::fit) fn smallest_step(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let steps = values.windows(2).map(|pair| pair[1] - pair[0]);
    steps
        .filter(|step| *step > 0.0)
        .fold(f64::INFINITY, f64::min)
}

fn is_same_load(one: &[f64; 6], other: &[f64; 6]) -> bool {
    [0, 3].into_iter().all(|first| {
        let length = |of: &dyn Fn(usize) -> f64| -> f64 {
            (first..first + 3)
                .map(|place| of(place).powi(2))
                .sum::<f64>()
                .sqrt()
        };
        let larger = length(&|place| one[place]).max(length(&|place| other[place]));
        length(&|place| one[place] - other[place]) <= SAME_LOAD * larger
    })
}
