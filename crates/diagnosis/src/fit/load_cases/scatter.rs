//! How the rows of load cases scatter, each by itself and together with the others of its case.

use indexmap::IndexMap;
use stiffbench_numeric::statistics::root_mean_square;

use super::posed::{PosedLoadCases, ReadComponent};
use crate::mismatch::{
    ForceReading, GaugeNoise, GaugeSteps, NoiseCovariance, Observations, ReadingNoise, kept,
};
use crate::search::{Covariance, dot};

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
    noise: ReadingNoise,
    /// What each reading is without error, m.
    slope_m: Vec<f64>,
    /// What each component of the force moves it by, as of [`ForceReading::ByComponents`].
    by_force: Vec<[f64; 3]>,
    covariance: Covariance,
}

impl RowScatter {
    /// Each row by itself.
    ///
    /// # Arguments
    /// - `sd`: standard deviations of displacements, m, and of rotations, rad.
    pub(in crate::fit) fn plain(posed: &PosedLoadCases, steps: GaugeSteps, sd: [f64; 2]) -> Self {
        let (series, rows) = posed.series_and_rows(steps, None);
        let noise = ReadingNoise {
            reading_sd_m: sd[0],
            gauges: GaugeNoise {
                rotation_ratio: sd[1] / sd[0],
                ..GaugeNoise::ALIKE
            },
            ..ReadingNoise::default()
        };
        let none = vec![0.0; rows.len()];
        let by_force = vec![[0.0; 3]; rows.len()];
        Self::new(series, rows, noise, none, by_force)
    }

    fn new(
        series: Observations,
        rows: Vec<usize>,
        noise: ReadingNoise,
        slope_m: Vec<f64>,
        by_force: Vec<[f64; 3]>,
    ) -> Self {
        // A load that moves nothing has no error that the rows of a case have in common, which is most of the work.
        let covariance = if slope_m.iter().all(|moved| *moved == 0.0) {
            let own = |reading| {
                let read = &series.cells[series.cell_of(reading)].read;
                noise.own_variance(read, 0.0)
            };
            let own: Vec<f64> = (0..series.len()).map(own).collect();
            Covariance::new(&own, [])
        } else {
            let force = ForceReading::ByComponents(&by_force);
            NoiseCovariance::new(&series, &noise, &slope_m, force).covariance
        };
        Self {
            series,
            rows,
            noise,
            slope_m,
            by_force,
            covariance,
        }
    }

    /// The same rows under the noise of a session: of each row its own, and what an error of the load moves, common to the rows of a case.
    ///
    /// # Arguments
    /// - `slope_m`, `by_force`: what each reading is without error, and what each component of the force moves it by.
    pub(in crate::fit) fn with_noise(
        &self,
        noise: ReadingNoise,
        slope_m: Vec<f64>,
        by_force: Vec<[f64; 3]>,
    ) -> Self {
        let (series, rows) = (self.series.clone(), self.rows.clone());
        Self::new(series, rows, noise, slope_m, by_force)
    }

    /// Mean share of what a case has in common in the variance of its rows.
    pub(in crate::fit) fn common_share(&self) -> f64 {
        let noise = &self.noise;
        let step_n = self.series.steps.force_n.unwrap_or(0.0);
        let force_variance = step_n * step_n / 12.0 + noise.gauges.force_sd_n.powi(2);
        let readings = self.slope_m.iter().zip(&self.by_force).enumerate();
        let shares = readings.map(|(reading, (moved, by_force))| {
            let read = &self.series.cells[self.series.cell_of(reading)].read;
            let own =
                noise.own_variance(read, *moved) + (noise.gauges.own_slope_sd * moved).powi(2);
            let common =
                (noise.run_slope_sd * moved).powi(2) + force_variance * dot(by_force, by_force);
            common / (own + common)
        });
        shares.sum::<f64>() / self.rows.len().max(1) as f64
    }

    /// The same with the rows that take part only: others show nothing of the scatter either.
    pub(in crate::fit) fn of_some(&self, takes_part: impl Fn(usize) -> bool) -> Self {
        let keep: Vec<bool> = self.rows.iter().map(|row| takes_part(*row)).collect();
        if keep.iter().all(|keep| *keep) {
            return self.clone();
        }
        let series = self.series.filtered(&keep);
        let rows = kept(&self.rows, &keep);
        let (slope_m, by_force) = (kept(&self.slope_m, &keep), kept(&self.by_force, &keep));
        Self::new(series, rows, self.noise, slope_m, by_force)
    }

    /// The same scatter with some rows of the table that weigh nothing.
    pub(in crate::fit) fn without(&self, is_left_out: impl Fn(usize) -> bool) -> Self {
        let left_out: Vec<bool> = self.rows.iter().map(|row| is_left_out(*row)).collect();
        Self {
            covariance: self.covariance.without(&left_out),
            ..self.clone()
        }
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
