//! What a cell has given so far, computed after every reading.

use stiffbench_measurement::readings::Reading;
use stiffbench_measurement::stiffness::{
    CellStiffness, GaugePair, Method, StiffnessEstimate, StiffnessOptions, StiffnessTable,
    stiffness_table,
};
use stiffbench_units_and_text::test_point::{Cell, Direction};

use super::plan::SessionCell;
use super::state::SessionState;
use super::view::{CellView, RepeatSpread, StiffnessSoFar};

/// What the cell has given so far; its flags are tested against the scatter of all cells. Of gauges along base axes it is what they give
/// along the load, from this cell alone.
pub(super) fn cell_view(
    state: &SessionState,
    (number, planned): (usize, &SessionCell),
    gauges: &GaugePair,
) -> CellView {
    let of_vectors = state.is_of_vectors();
    let (readings, direction) = match planned.direction.axis() {
        Some(axis) if !of_vectors => (state.table().readings, axis),
        _ => (state.readings_along_load(number), Direction::X),
    };
    let cell = &Cell::new(planned.pose.clone(), direction);
    let table = stiffness_table(&readings, gauges, StiffnessOptions::default());
    let accepted: Vec<&Reading> = readings
        .iter()
        .filter(|reading| {
            reading.is_accepted()
                && reading.pose == cell.pose
                && reading.direction == cell.direction
        })
        .collect();
    let row = table.cell(cell);
    let mut view = CellView {
        spreads: spreads(&accepted),
        ..CellView::default()
    };
    match row {
        Some(row) => {
            view.flags = row.flags.iter().map(ToString::to_string).collect();
            match row.by(Method::Regression) {
                Ok(estimate) => view.stiffness = Some(so_far(estimate, row)),
                Err(reason) => view.no_stiffness = Some(reason.to_string()),
            }
        }
        None => view.no_stiffness = skipped(&table, cell),
    }
    view
}

fn skipped(table: &StiffnessTable, cell: &Cell) -> Option<String> {
    let skipped = table.skipped.iter().find(|skipped| skipped.cell == *cell);
    skipped.map(|skipped| skipped.reason.to_string())
}

/// Repeats of each load, in the order in which the loads first appear.
fn spreads(accepted: &[&Reading]) -> Vec<RepeatSpread> {
    let mut groups: Vec<(&Reading, Vec<f64>)> = Vec::new();
    for reading in accepted {
        let same =
            |first: &Reading| first.target_n == reading.target_n && first.branch == reading.branch;
        match groups.iter_mut().find(|(first, _)| same(first)) {
            Some((_, values)) => values.push(reading.displacement_m),
            None => groups.push((reading, vec![reading.displacement_m])),
        }
    }
    let spread = |(first, values): (&Reading, Vec<f64>)| {
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        RepeatSpread {
            target_n: first.target_n,
            branch: first.branch,
            n: values.len(),
            mean_m: values.iter().sum::<f64>() / values.len() as f64,
            range_m: high - low,
        }
    };
    groups.into_iter().map(spread).collect()
}

/// The stiffness so far. One more repeat is expected to leave the scatter as it is: u shrinks with the root of the number of runs, and k with
/// the degree of freedom that is won.
fn so_far(estimate: &StiffnessEstimate, row: &CellStiffness) -> StiffnessSoFar {
    let now = estimate.estimate;
    let runs = row.n_runs as f64;
    let mut more = now;
    more.standard_uncertainty *= (runs / (runs + 1.0)).sqrt();
    more.dof += 1.0;
    StiffnessSoFar {
        stiffness_n_per_m: now.value,
        expanded_n_per_m: now.expanded_95(),
        k: now.coverage_factor_95(),
        dof: now.dof,
        runs: row.n_runs,
        with_one_more_n_per_m: more.expanded_95(),
    }
}
