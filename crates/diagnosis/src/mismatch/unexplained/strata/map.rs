//! The residuals as a map: pose, direction, load step, branch, repeat.

use crate::mismatch::observed::Observations;
use stiffbench_units_and_text::test_point::{Branch, Direction, PoseId};

/// Residuals of one step of one run, for tables and figures.
#[derive(Debug, Clone, PartialEq)]
pub struct MapEntry {
    /// The pose.
    pub pose: PoseId,
    /// The direction.
    pub direction: Direction,
    /// The repeat.
    pub repeat: u32,
    /// Place in the load sequence.
    pub step: u32,
    /// Branch.
    pub branch: Branch,
    /// Mean force, N.
    pub force_n: f64,
    /// Mean time since the session began, s, if known.
    pub time_s: Option<f64>,
    /// Number of readings.
    pub readings: usize,
    /// Mean residual about the mean of its gauge zero, m.
    pub residual_m: f64,
    /// Residual in standard deviations: the mean of the white residuals times the root of their number, standard normal where only
    /// noise is left.
    pub standardised: f64,
}

/// Entries in the order of the observations.
pub(super) fn entries(
    observations: &Observations,
    residual_m: &[f64],
    white: &[f64],
) -> Vec<MapEntry> {
    let about_zeros_m = observations.about_zeros(residual_m.to_vec());
    let mut out: Vec<(usize, MapEntry, f64)> = Vec::new();
    for (place, reading) in observations.readings.iter().enumerate() {
        let load = &observations.loads[place];
        let residual = about_zeros_m[place];
        match out.last_mut() {
            Some((run, entry, sum))
                if *run == reading.run
                    && entry.step == load.step
                    && entry.branch == reading.branch =>
            {
                let before = entry.readings as f64;
                let mean = |old: f64, new: f64| (old * before + new) / (before + 1.0);
                entry.residual_m = mean(entry.residual_m, residual);
                entry.force_n = mean(entry.force_n, load.force_n);
                entry.time_s = entry
                    .time_s
                    .zip(reading.time_s)
                    .map(|(old, new)| mean(old, new));
                entry.readings += 1;
                *sum += white[place];
                entry.standardised = *sum / (entry.readings as f64).sqrt();
            }
            _ => {
                let run = &observations.runs[reading.run];
                let cell = &observations.cells[run.cell];
                let entry = MapEntry {
                    pose: observations.poses[cell.pose].clone(),
                    direction: cell.axis(),
                    repeat: run.repeat,
                    step: load.step,
                    branch: reading.branch,
                    force_n: load.force_n,
                    time_s: reading.time_s,
                    readings: 1,
                    residual_m: residual,
                    standardised: white[place],
                };
                out.push((reading.run, entry, white[place]));
            }
        }
    }
    out.into_iter().map(|(_, entry, _)| entry).collect()
}
