//! The readings of a session as the check of runs takes them.

use stiffbench_gauges::Channel;
use stiffbench_measurement::readings::ZeroScope;
use stiffbench_measurement::run_check::{LoadReading, LoadedRun, RunCheck, RunTerms};

use super::event::TakenReading;
use super::plan::{SessionPlan, is_done};
use super::state::{KeptReading, SessionState};

/// Reason of the readings of a run that was taken again because it differed; what was found to be its cause stands behind it.
pub(super) const TAKEN_AGAIN: &str = "a reading of its run contradicted the repeats";

/// Compares the runs of a session as far as they were taken.
///
/// # Arguments
/// - `scatter_m`: scatter of readings, where the bench states it.
pub(super) fn check_of(
    state: &SessionState,
    plan: &SessionPlan,
    scatter_m: Option<f64>,
) -> RunCheck {
    let step = |of: Channel| {
        let seen = state.instruments[of.index()].as_ref();
        seen.map_or(0.0, |seen| seen.step_si.unwrap_or(seen.resolution_si))
    };
    let gauges = gauges_of(plan).map(|of| (of.axis(), step(of)));
    let cells = plan.cells.iter();
    let terms = RunTerms {
        settle: plan.procedure.settle,
        zero_each_run: plan.procedure.zero == ZeroScope::Run,
        scatter_m,
        force_step_n: step(Channel::Force),
        gauges: gauges.collect(),
        cells: cells
            .map(|of| format!("{} {}", of.pose, of.direction))
            .collect(),
        repeats: plan.procedure.repeats,
    };
    RunCheck::new(terms, runs_of(state, plan))
}

/// The displacement gauges.
fn gauges_of(plan: &SessionPlan) -> impl Iterator<Item = Channel> {
    let channels = plan.channels().into_iter();
    channels.filter(|of| of.is_displacement())
}

/// The number of a gauge among them.
pub(super) fn gauge_number(plan: &SessionPlan, channel: Channel) -> usize {
    gauges_of(plan)
        .position(|of| of == channel)
        .unwrap_or_default()
}

/// All runs, in the order in which they were finished.
fn runs_of(state: &SessionState, plan: &SessionPlan) -> Vec<LoadedRun> {
    let mut runs: Vec<(u32, LoadedRun)> = Vec::new();
    for kept in &state.readings {
        let (taken, counts) = (&kept.taken, kept.superseded.is_none());
        let stays = kept.superseded.as_deref() == Some(TAKEN_AGAIN);
        let is_flagged = !is_unflagged(kept);
        if !counts && (!stays || is_flagged) {
            continue;
        }
        let reading = LoadReading {
            is_flagged,
            ..load_reading(taken, state, plan)
        };
        let same = runs.iter_mut().find(|(attempt, run)| {
            (run.cell, run.repeat, run.counts) == (taken.cell, taken.repeat, counts)
                && (counts || *attempt == taken.attempt)
        });
        if let Some((_, run)) = same {
            run.readings.push(reading);
        } else {
            let run = LoadedRun {
                cell: taken.cell,
                repeat: taken.repeat,
                counts,
                is_whole: !counts || !is_open(state, plan, taken.cell, taken.repeat),
                readings: vec![reading],
            };
            runs.push((taken.attempt, run));
        }
    }
    runs.sort_by_key(|(_, run)| run.readings.last().map(|one| one.number));
    runs.into_iter().map(|(_, run)| run).collect()
}

/// A reading with its force from that under which its zero was set.
pub(super) fn load_reading(
    taken: &TakenReading,
    state: &SessionState,
    plan: &SessionPlan,
) -> LoadReading {
    let zero_n = state.zero_forces.get(&(taken.cell, taken.zero.clone()));
    let planned = plan.cells.get(taken.cell);
    let planned = planned.and_then(|cell| cell.readings.get(taken.index));
    let hold_s = planned.and_then(|planned| planned.extra_hold_s);
    LoadReading {
        number: taken.number,
        step: taken.step,
        branch: taken.branch,
        target_n: taken.target_n,
        hold: hold_s.map_or(0, f64::to_bits),
        force_n: taken.force_n - zero_n.unwrap_or(&plan.procedure.preload_n),
        displacement_m: gauges_of(plan)
            .map(|of| taken.displacement_of(of))
            .collect(),
        is_flagged: false,
    }
}

/// Whether readings of a run are still to be taken.
pub(super) fn is_open(state: &SessionState, plan: &SessionPlan, cell: usize, repeat: u32) -> bool {
    let planned = plan.cells.get(cell).map_or(&[][..], |of| &of.readings);
    let of_run = planned.iter().enumerate();
    of_run
        .filter(|(_, reading)| reading.repeat == repeat)
        .any(|(index, _)| !is_done(state, (cell, index)))
}

/// Whether nothing is known against a reading, nor was the operator asked about it.
pub(super) fn is_unflagged(kept: &KeptReading) -> bool {
    kept.taken.flag.is_empty() && kept.flags.is_empty()
}
