//! Residuals as a map: cells against load steps, and against runs.

use std::cmp::Ordering;

use indexmap::IndexSet;

use crate::analysis::DiagnosisReport;
use crate::mismatch::ReadingTrace;
use crate::plot::{MapLoadStep, MapValue, MismatchMap, ResidualMeasure, RunSummary};
use crate::report::diagnosis::DiagnosedModel;
use crate::test_point::{Branch, Cell};

/// The map, every square as a multiple of the standard uncertainty that the noise alone gives it.
///
/// Load steps are assessed within their runs, so that the scatter of zeros and slopes does not hide the shape of a curve; slopes of runs
/// stand beside them.
pub(super) fn map(report: &DiagnosisReport, model: DiagnosedModel) -> MismatchMap {
    let readings = &report.trace.readings;
    let slope_sd = report.diagnosis.noise.run_slope_sd;
    let cells: IndexSet<&Cell> = readings.iter().map(|reading| &reading.cell).collect();
    let cells: Vec<Cell> = cells.into_iter().cloned().collect();
    let load_steps = load_steps(readings);
    let mut repeats: Vec<u32> = readings.iter().map(|reading| reading.repeat).collect();
    repeats.sort_unstable();
    repeats.dedup();
    let of_cell = |cell: &Cell| -> Vec<&ReadingTrace> {
        readings.iter().filter(|r| r.cell == *cell).collect()
    };
    let by_load_step = cells.iter().map(|cell| {
        let own = of_cell(cell);
        load_steps
            .iter()
            .map(|step| {
                let at = own.iter().copied();
                let at = at.filter(|r| r.target_n == step.target_n && r.branch == step.branch);
                mean(model, at)
            })
            .collect()
    });
    let by_run = cells.iter().map(|cell| {
        let own = of_cell(cell);
        repeats
            .iter()
            .map(|repeat| {
                let run = own.iter().copied().filter(|r| r.repeat == *repeat);
                slope(model, slope_sd, &run.collect::<Vec<_>>())
            })
            .collect()
    });
    MismatchMap {
        prediction: match model {
            DiagnosedModel::Before => "fitted structure".to_owned(),
            DiagnosedModel::After => "structure with what was found".to_owned(),
        },
        measure: ResidualMeasure::StandardUncertainties,
        by_load_step: by_load_step.collect(),
        by_run: by_run.collect(),
        cells,
        load_steps,
        repeats,
        run_summary: RunSummary::SlopeAtLargestLoad,
    }
}

/// Target loads in the order of a sweep: those below zero first, each sign up and then down again.
fn load_steps(readings: &[ReadingTrace]) -> Vec<MapLoadStep> {
    let mut steps: Vec<MapLoadStep> = Vec::new();
    for reading in readings {
        let step = MapLoadStep {
            target_n: reading.target_n,
            branch: reading.branch,
        };
        if !steps.contains(&step) {
            steps.push(step);
        }
    }
    steps.sort_by(|a, b| {
        let size = a.target_n.abs().total_cmp(&b.target_n.abs());
        let size = if a.branch == Branch::Unloading {
            size.reverse()
        } else {
            size
        };
        let positive = |step: &MapLoadStep| step.target_n > 0.0;
        a.branch
            .cmp(&b.branch)
            .then(positive(a).cmp(&positive(b)))
            .then(size)
            .then(Ordering::Equal)
    });
    steps
}

/// Mean of residuals over its standard uncertainty; `None` of none.
fn mean<'r>(
    model: DiagnosedModel,
    readings: impl Iterator<Item = &'r ReadingTrace>,
) -> Option<MapValue> {
    let (mut sum, mut variance, mut n) = (0.0, 0.0, 0_usize);
    for reading in readings {
        let [_, within_run_m] = model.residuals_m(reading);
        sum += within_run_m;
        variance += reading.reading_sd_m.powi(2);
        n += 1;
    }
    (n > 0 && variance > 0.0).then(|| MapValue {
        value: sum / variance.sqrt(),
        n,
    })
}

/// Slope of a run's residuals over the load, over its standard uncertainty; `None` for a run under one load.
fn slope(model: DiagnosedModel, slope_sd: f64, run: &[&ReadingTrace]) -> Option<MapValue> {
    let n = run.len();
    let mean_n = run.iter().map(|r| r.force_n).sum::<f64>() / n.max(1) as f64;
    let (mut square, mut product, mut variance, mut of_run) = (0.0, 0.0, 0.0, 0.0);
    for reading in run {
        let force_n = reading.force_n - mean_n;
        square += force_n * force_n;
        product += force_n * model.residuals_m(reading)[0];
        variance += (force_n * reading.reading_sd_m).powi(2);
        of_run += force_n * reading.slope_m;
    }
    let sd = variance.sqrt().hypot(slope_sd * of_run);
    (square > 0.0 && sd > 0.0).then(|| MapValue {
        value: product / sd,
        n,
    })
}
