//! Readings that cannot be right, without a search for physics.

use std::collections::BTreeMap;

use crate::bench::NoiseModel;
use crate::count::counted;
use crate::mismatch::{KnownNoise, Observations, ScreenedData, screen_data};
use crate::procedure::Settle;
use crate::readings::{Instruments, Reading, ReadingTable, SessionHeader};
use crate::run_check::{LoadReading, LoadedRun, RunCheck, RunTerms};
use crate::test_point::Direction;

use super::design::baseline_of;
use super::error::Failure;
use super::model::ResolvedModel;

/// Looks for cells, runs and readings that cannot be right, as a diagnosis does before its search.
///
/// # Errors
/// For poses that the robot does not have, and a structure that cannot be solved.
pub fn check_data(
    table: &ReadingTable,
    header: Option<&SessionHeader>,
    model: &ResolvedModel,
) -> Result<ScreenedData, Failure> {
    let observations = Observations::new(table, header);
    let parameters = model.usual_parameters()?;
    let baseline = baseline_of(model, &observations, &observations.poses, &parameters)?;
    let screened = screen_data(&baseline, &observations, &KnownNoise::Nothing)?;
    Ok(screened)
}

/// No guided session has more runs, or more in a cell; of a recording with more, none is a repeat that somebody set.
const MOST_RUNS: (usize, u32) = (2_000, 50);

/// What a session would have asked about its runs and loads; nothing where it was asked, and flagged.
pub(super) fn asked_about_runs(
    table: &ReadingTable,
    header: Option<&SessionHeader>,
) -> Option<String> {
    let axes: Vec<Option<Direction>> = if table.is_of_vectors() {
        Direction::ALL.map(Some).into()
    } else {
        vec![None]
    };
    let (mut cells, mut runs) = (Vec::new(), Vec::<LoadedRun>::new());
    let mut of_run = BTreeMap::new();
    let procedure = header.and_then(|header| header.procedure.as_ref());
    let preload_n = procedure.and_then(|procedure| procedure.preload_n);
    for load in table.loads() {
        let counting = load.iter().filter(|one| one.is_accepted());
        let is_unflagged = |one: &&Reading| one.text.as_ref().is_none_or(|of| of.flag.is_empty());
        let load: Vec<&Reading> = counting.filter(is_unflagged).collect();
        let Some(first) = load.first() else { continue };
        let name = format!("{} {}", first.pose, table.load_direction(first));
        let cell = cells.iter().position(|of| *of == name);
        let cell = cell.unwrap_or_else(|| {
            cells.push(name);
            cells.len() - 1
        });
        let run = *of_run.entry((cell, first.repeat)).or_insert_with(|| {
            runs.push(LoadedRun {
                cell,
                repeat: first.repeat,
                counts: true,
                is_whole: true,
                readings: Vec::new(),
            });
            runs.len() - 1
        });
        if runs.len() > MOST_RUNS.0 {
            return None;
        }
        let readings = &mut runs[run].readings;
        let target = (first.step, first.branch, first.target_n.to_bits());
        let last = readings.last();
        let last = last.filter(|one| (one.step, one.branch, one.target_n.to_bits()) == target);
        let of_gauge = |axis: &Option<Direction>| {
            let mut load = load.iter();
            let read = load.find(|one| axis.is_none_or(|axis| one.direction == axis));
            read.map(|one| one.displacement_m)
        };
        readings.push(LoadReading {
            number: first.seq,
            step: first.step,
            branch: first.branch,
            target_n: first.target_n,
            hold: last.map_or(0, |last| last.hold + 1),
            force_n: first.force_n - preload_n.unwrap_or(0.0),
            displacement_m: axes.iter().map(of_gauge).collect(),
            is_flagged: false,
        });
    }
    let is_made = table.origin.is_some() || header.is_some_and(|header| header.origin.is_some());
    let terms = RunTerms {
        zero_each_run: table.zeros.len() > cells.len() * axes.len(),
        scatter_m: is_made.then(stated_scatter_m),
        ..terms(axes, cells, &runs, header)
    };
    if terms.repeats > MOST_RUNS.1 {
        return None;
    }
    let cells = 0..terms.cells.len();
    let check = RunCheck::new(terms, runs);
    let worst_of_cell = |cell| check.contradictions(cell).0.into_iter().next();
    let found: Vec<_> = cells.filter_map(worst_of_cell).collect();
    let first = found.first()?;
    Some(format!(
        "repeats contradict {}, which a session would have asked about. {}",
        counted(found.len(), "run"),
        first.text.trim_end_matches('.')
    ))
}

/// Scatter of readings that a bench in software states, m.
#[must_use]
pub fn stated_scatter_m() -> f64 {
    NoiseModel::default().reading_sd_m
}

/// What a session would have known beside its readings.
fn terms(
    axes: Vec<Option<Direction>>,
    cells: Vec<String>,
    runs: &[LoadedRun],
    header: Option<&SessionHeader>,
) -> RunTerms {
    let instruments = header.map(|header| &header.instruments);
    let step = |name: &str| {
        let mut named = instruments.into_iter().flat_map(Instruments::named);
        let record = named.find(|(of, _)| *of == name);
        record
            .and_then(|(_, record)| record.resolution)
            .unwrap_or(0.0)
    };
    let gauges = axes.into_iter().map(|axis| {
        let along = axis.map_or_else(String::new, |axis| format!(" along {axis}"));
        (axis, step(&format!("displacement gauge{along}")))
    });
    let procedure = header.and_then(|header| header.procedure.as_ref());
    let settle = procedure.map(|procedure| Settle::from_record(&procedure.settle));
    let mut repeats = vec![0; cells.len()];
    for run in runs {
        repeats[run.cell] += 1;
    }
    RunTerms {
        settle: settle.unwrap_or_default(),
        zero_each_run: true,
        scatter_m: None,
        force_step_n: step("force gauge"),
        gauges: gauges.collect(),
        cells,
        repeats: repeats.into_iter().max().unwrap_or_default(),
    }
}
