//! The load curve of one cell: displacement against force, by load and by run.

use std::collections::BTreeSet;

use serde::{Deserialize, Serialize};

use crate::readings::Reading;
use stiffbench_numeric::statistics::{mean, standard_deviation};
use stiffbench_units_and_text::test_point::{Branch, Cell};

/// Which branches a stiffness is computed from.
#[derive(
    Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, schemars::JsonSchema,
)]
#[serde(rename_all = "kebab-case")]
pub enum Branches {
    /// Growing load only. The default: unloading carries the width of any friction loop with it.
    #[default]
    LoadingOnly,
    /// Growing and falling load together.
    Both,
}

impl Branches {
    /// Whether readings of `branch` take part.
    #[must_use]
    pub fn include(self, branch: Branch) -> bool {
        self == Self::Both || branch == Branch::Loading
    }
}

/// Mean and sample standard deviation, in the unit of the field that holds them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Spread {
    /// Arithmetic mean.
    pub mean: f64,
    /// Standard deviation with n - 1; `None` for a single value.
    pub sd: Option<f64>,
}

/// All readings of a cell at one target load of one branch.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LoadMean {
    /// Loading or unloading.
    pub branch: Branch,
    /// The load aimed at, N.
    pub target_n: f64,
    /// Number of readings.
    pub n: usize,
    /// Force as measured, N.
    pub force_n: Spread,
    /// Displacement from the gauge zero, m.
    pub displacement_m: Spread,
}

impl LoadMean {
    /// Whether this is the unloaded state.
    #[must_use]
    pub fn is_unloaded(&self) -> bool {
        self.target_n == 0.0
    }
}

/// One reading as it enters the curve.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CurvePoint {
    /// Index into `LoadCurve::loads`.
    pub load: usize,
    /// Index of the gauge zero within the cell, below `LoadCurve::n_zeros`.
    pub zero: usize,
    /// n-th application, from 1.
    pub repeat: u32,
    /// Sequence number of the reading in its session.
    pub seq: u32,
    /// Line of its file, 0 if none.
    pub line: u32,
    /// Seconds since the session began, if known.
    pub time_s: Option<f64>,
    /// Force, N.
    pub force_n: f64,
    /// Displacement, m.
    pub displacement_m: f64,
}

/// Readings with one virgin history: the unit that is exchangeable.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// Index of the run in its table.
    pub run: u32,
    /// Repeat number of its first reading.
    pub repeat: u32,
    /// Its readings, in the order of repeat and step.
    pub points: Vec<CurvePoint>,
}

/// Displacement against force of one cell.
///
/// Of several readings in one step (holds) the one with the smallest hold counts here; the others are counted as left out.
#[derive(Debug, Clone, PartialEq)]
pub struct LoadCurve {
    /// Pose and direction.
    pub cell: Cell,
    /// Loads: loading by growing size, then unloading by falling size.
    pub loads: Vec<LoadMean>,
    /// Runs, by their index.
    pub runs: Vec<Run>,
    /// Number of gauge zeros.
    pub n_zeros: usize,
    /// Accepted readings left out: later readings of a step that has one already.
    pub n_later_in_step: usize,
    /// Accepted readings left out: of a branch that was not asked for.
    pub n_other_branch: usize,
}

impl LoadCurve {
    /// The curve of `cell` from its accepted readings with finite numbers.
    #[must_use]
    pub fn new(cell: Cell, readings: &[&Reading], branches: Branches) -> Self {
        let mut used: Vec<&Reading> = readings
            .iter()
            .copied()
            .filter(|r| branches.include(r.branch))
            .collect();
        let n_other_branch = readings.len() - used.len();
        let place = |r: &Reading| (r.run, r.repeat, r.branch, r.step);
        used.sort_by(|a, b| {
            let hold = |r: &Reading| r.hold_s.unwrap_or(0.0);
            place(a)
                .cmp(&place(b))
                .then_with(|| hold(a).total_cmp(&hold(b)))
                .then_with(|| (a.seq, a.line).cmp(&(b.seq, b.line)))
        });
        let n_with_later = used.len();
        used.dedup_by_key(|r| place(r));

        let targets = sorted_targets(&used);
        let zeros: BTreeSet<u32> = used.iter().map(|reading| reading.zero).collect();
        let zeros = Vec::from_iter(zeros);
        let mut runs: Vec<Run> = Vec::new();
        for reading in &used {
            let point = point_of(reading, &targets, &zeros);
            match runs.last_mut().filter(|run| run.run == reading.run) {
                Some(run) => run.points.push(point),
                None => runs.push(Run {
                    run: reading.run,
                    repeat: reading.repeat,
                    points: vec![point],
                }),
            }
        }
        Self {
            cell,
            loads: load_means(&targets, &runs),
            n_zeros: zeros.len(),
            n_later_in_step: n_with_later - used.len(),
            n_other_branch,
            runs,
        }
    }

    /// All points, run by run.
    pub fn points(&self) -> impl Iterator<Item = &CurvePoint> {
        self.runs.iter().flat_map(|run| &run.points)
    }

    /// The points of each gauge zero, in the order of [`points`](Self::points).
    pub(super) fn points_by_zero(&self) -> Vec<Vec<&CurvePoint>> {
        let mut by_zero = vec![Vec::new(); self.n_zeros];
        for point in self.points() {
            by_zero[point.zero].push(point);
        }
        by_zero
    }

    /// Number of readings in the curve.
    #[must_use]
    pub fn n_points(&self) -> usize {
        self.loads.iter().map(|load| load.n).sum()
    }

    /// Indices of the loads that are not the unloaded state.
    pub fn loaded(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.loads.len()).filter(|&load| !self.loads[load].is_unloaded())
    }

    /// Largest mean force in size, N; 0 without readings.
    #[must_use]
    pub fn largest_force_n(&self) -> f64 {
        let sizes = self.loads.iter().map(|load| load.force_n.mean.abs());
        sizes.fold(0.0, f64::max)
    }

    /// Largest mean displacement in size, m; 0 without readings.
    #[must_use]
    pub fn largest_displacement_m(&self) -> f64 {
        let sizes = self.loads.iter().map(|load| load.displacement_m.mean.abs());
        sizes.fold(0.0, f64::max)
    }
}

/// -0 and 0 are one load.
fn target_of(reading: &Reading) -> f64 {
    reading.target_n + 0.0
}

fn sorted_targets(used: &[&Reading]) -> Vec<(Branch, f64)> {
    let mut targets: Vec<(Branch, f64)> = used.iter().map(|r| (r.branch, target_of(r))).collect();
    targets.sort_by(compare_targets);
    targets.dedup();
    targets
}

/// Loading from small to large, then unloading from large to small: the order in which they are met.
fn compare_targets(a: &(Branch, f64), b: &(Branch, f64)) -> std::cmp::Ordering {
    let by_size = a.1.abs().total_cmp(&b.1.abs());
    let in_order = match a.0 {
        Branch::Loading => by_size,
        Branch::Unloading => by_size.reverse(),
    };
    a.0.cmp(&b.0)
        .then(in_order)
        .then_with(|| a.1.total_cmp(&b.1))
}

fn point_of(reading: &Reading, targets: &[(Branch, f64)], zeros: &[u32]) -> CurvePoint {
    let target = (reading.branch, target_of(reading));
    // Both lists were made from these readings, so each reading is found in them.
    let load = targets.binary_search_by(|t| compare_targets(t, &target));
    let zero = zeros.binary_search(&reading.zero);
    CurvePoint {
        load: load.unwrap_or_default(),
        zero: zero.unwrap_or_default(),
        repeat: reading.repeat,
        seq: reading.seq,
        line: reading.line,
        time_s: reading.time_s,
        force_n: reading.force_n,
        displacement_m: reading.displacement_m,
    }
}

fn load_means(targets: &[(Branch, f64)], runs: &[Run]) -> Vec<LoadMean> {
    let mut forces = vec![Vec::new(); targets.len()];
    let mut displacements = vec![Vec::new(); targets.len()];
    for point in runs.iter().flat_map(|run| &run.points) {
        forces[point.load].push(point.force_n);
        displacements[point.load].push(point.displacement_m);
    }
    let spread = |values: &[f64]| Spread {
        mean: mean(values).unwrap_or_default(),
        sd: standard_deviation(values),
    };
    targets
        .iter()
        .enumerate()
        .map(|(load, &(branch, target_n))| LoadMean {
            branch,
            target_n,
            n: forces[load].len(),
            force_n: spread(&forces[load]),
            displacement_m: spread(&displacements[load]),
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::stiffness::sample::{cell, reading};

    #[test]
    fn the_first_reading_of_a_step_counts_and_holds_do_not() {
        let mut readings = [
            reading(1, 0, 0.0, 0.0, 0.0),
            reading(1, 1, -10.0, -10.0, -200e-6),
            reading(1, 1, -10.0, -10.0, -210e-6),
        ];
        // The long hold stands first in the file.
        readings[1].hold_s = Some(60.0);
        readings[2].hold_s = Some(5.0);
        let refs: Vec<&Reading> = readings.iter().collect();
        let curve = LoadCurve::new(cell(), &refs, Branches::LoadingOnly);
        assert_eq!(curve.n_later_in_step, 1);
        assert_eq!(curve.loads[1].displacement_m.mean, -210e-6);
        assert_eq!(curve.loads[1].displacement_m.sd, None);
    }

    #[test]
    fn loads_are_collected_by_target_and_not_by_step() {
        // A shuffled order: the same target stands at different steps of the runs.
        let readings = [
            reading(1, 0, -20.0, -20.0, -4e-4),
            reading(1, 1, -10.0, -10.2, -2e-4),
            reading(2, 0, -10.0, -9.8, -1e-4),
            reading(2, 1, -20.0, -20.0, -4e-4),
        ];
        let refs: Vec<&Reading> = readings.iter().collect();
        let curve = LoadCurve::new(cell(), &refs, Branches::LoadingOnly);
        assert_eq!(curve.loads.len(), 2);
        assert_eq!(curve.loads[0].target_n, -10.0);
        assert_eq!(curve.loads[0].n, 2);
        assert!((curve.loads[0].force_n.mean + 10.0).abs() < 1e-12);
        assert!((curve.loads[0].displacement_m.mean + 1.5e-4).abs() < 1e-18);
        let sd = curve.loads[0].displacement_m.sd.unwrap();
        assert!((sd - 1e-4 / 2_f64.sqrt()).abs() < 1e-15);
    }

    #[test]
    fn unloading_is_left_out_unless_asked_for_and_counted() {
        let mut readings = [
            reading(1, 0, -10.0, -10.0, -2e-4),
            reading(1, 1, -20.0, -20.0, -4e-4),
            reading(1, 2, -10.0, -10.0, -3e-4),
            reading(1, 3, -0.0, 0.0, -1e-4),
        ];
        readings[2].branch = Branch::Unloading;
        readings[3].branch = Branch::Unloading;
        let refs: Vec<&Reading> = readings.iter().collect();
        let loading = LoadCurve::new(cell(), &refs, Branches::LoadingOnly);
        assert_eq!((loading.n_points(), loading.n_other_branch), (2, 2));
        let both = LoadCurve::new(cell(), &refs, Branches::Both);
        let order: Vec<f64> = both.loads.iter().map(|load| load.target_n).collect();
        assert_eq!(order, [-10.0, -20.0, -10.0, 0.0]);
        assert!(both.loads[3].is_unloaded());
    }

    #[test]
    fn one_run_over_several_repeats_keeps_all_of_them() {
        // Each load applied five times with one history: the repeats are not holds of one another.
        let readings: Vec<Reading> = (1..=5)
            .map(|repeat| Reading {
                run: 0,
                ..reading(repeat, 0, -10.0, -10.0, -2e-4)
            })
            .collect();
        let refs: Vec<&Reading> = readings.iter().collect();
        let curve = LoadCurve::new(cell(), &refs, Branches::LoadingOnly);
        assert_eq!((curve.runs.len(), curve.n_points()), (1, 5));
    }
}
