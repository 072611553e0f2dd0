//! How displacements and rotations scatter: from repeats where there are any, else from what a fit leaves.

use super::posed::PosedLoadCases;

/// Loads that differ by less than this share of the larger are one load applied again.
const SAME_LOAD: f64 = 0.05;

/// Sums of squares of displacements and of rotations, with their degrees of freedom.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct ScatterSums {
    /// Of displacements, m², and of rotations, rad².
    squares: [f64; 2],
    dof: [f64; 2],
}

/// One component under one load in one pose, as often as it was read.
struct RepeatedComponent {
    label: usize,
    pose: usize,
    load: [f64; 6],
    unit: [f64; 6],
    residuals: Vec<f64>,
}

impl ScatterSums {
    /// From the differences between repeats of one load in one pose; what a model predicts for the loads' differences is taken off.
    pub(super) fn of_repeats(posed: &PosedLoadCases, residuals: &[f64]) -> Self {
        let mut groups: Vec<RepeatedComponent> = Vec::new();
        for ((case, read), residual) in posed.rows().zip(residuals) {
            let known = groups.iter_mut().find(|group| {
                (group.label, group.pose) == (case.label, case.pose)
                    && group.unit == read.unit
                    && is_same_load(&group.load, &case.load)
            });
            match known {
                Some(group) => group.residuals.push(*residual),
                None => groups.push(RepeatedComponent {
                    label: case.label,
                    pose: case.pose,
                    load: case.load,
                    unit: read.unit,
                    residuals: vec![*residual],
                }),
            }
        }
        let mut sums = Self::default();
        for group in &groups {
            let (kind, values) = (usize::from(group.unit[..3] == [0.0; 3]), &group.residuals);
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            sums.squares[kind] += values
                .iter()
                .map(|value| (value - mean).powi(2))
                .sum::<f64>();
            sums.dof[kind] += values.len() as f64 - 1.0;
        }
        sums
    }

    /// From what a fit leaves of the rows that took part; its parameters are counted against both kinds in proportion to their rows.
    pub(super) fn of_residuals(
        posed: &PosedLoadCases,
        residuals: &[f64],
        takes_part: &[bool],
        parameters: usize,
    ) -> Self {
        let mut sums = Self::default();
        let rows = posed.rows().zip(residuals).zip(takes_part);
        for (((_, read), residual), _) in rows.filter(|(_, takes_part)| **takes_part) {
            let kind = usize::from(read.is_rotation());
            sums.squares[kind] += residual * residual;
            sums.dof[kind] += 1.0;
        }
        let all: f64 = sums.dof.iter().sum();
        if all > 0.0 {
            for dof in &mut sums.dof {
                *dof *= (1.0 - parameters as f64 / all).max(0.0);
            }
        }
        sums
    }

    /// Whether every kind that was read has at least one degree of freedom.
    pub(super) fn serves(&self, posed: &PosedLoadCases) -> bool {
        [false, true].into_iter().all(|rotation| {
            let is_read = posed.rows().any(|(_, read)| read.is_rotation() == rotation);
            !is_read || self.dof[usize::from(rotation)] >= 1.0
        })
    }

    /// Degrees of freedom of both kinds.
    pub(super) fn dof(&self) -> f64 {
        self.dof.iter().sum()
    }

    /// Standard deviation of displacements, m, and of rotations, rad; `None` of what was not read.
    pub(super) fn standard_deviations(&self) -> [Option<f64>; 2] {
        [0, 1].map(|kind| {
            let dof = self.dof[kind];
            (dof > 0.0).then(|| (self.squares[kind] / dof).sqrt())
        })
    }

    /// One over the standard deviation of each row; of rows that do not scatter, one over `least`.
    pub(super) fn weights(&self, posed: &PosedLoadCases, least: [f64; 2]) -> Vec<f64> {
        let of_kind: Vec<f64> = self
            .standard_deviations()
            .into_iter()
            .zip(least)
            .map(|(sd, least)| 1.0 / sd.unwrap_or(least).max(least))
            .collect();
        let rows = posed.rows();
        rows.map(|(_, read)| of_kind[usize::from(read.is_rotation())])
            .collect()
    }
}

/// Root mean square of displacements, m, and of rotations, rad; one of what was not read.
pub(super) fn sizes(posed: &PosedLoadCases) -> [f64; 2] {
    [false, true].map(|rotation| {
        let values: Vec<f64> = posed
            .rows()
            .filter(|(_, read)| read.is_rotation() == rotation)
            .map(|(_, read)| read.value)
            .collect();
        let squares: f64 = values.iter().map(|value| value * value).sum();
        let size = (squares / values.len().max(1) as f64).sqrt();
        if size > 0.0 { size } else { 1.0 }
    })
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
