//! The load that each reading was aimed at, where the file does not state it.

use std::collections::HashMap;
use std::hash::Hash;

use super::reading::Reading;
use super::table::ReadingTable;
use stiffbench_numeric::statistics::mean;
use stiffbench_units_and_text::count::counted;

/// A load counts as gone down (or up again) when it moves by more than this share of the largest load of its run.
///
/// Loads are commonly set by hand to some 0.5 N of 70 N, below 1 %; sequences have up to some ten steps, 10 % each. Half a step is well away
/// from both.
pub(super) const REVERSAL_SHARE: f64 = 0.05;

/// Load steps that are searched for, N, coarsest first.
const LOAD_STEPS_N: [f64; 10] = [1000.0, 500.0, 200.0, 100.0, 50.0, 20.0, 10.0, 5.0, 2.0, 1.0];

/// A force belongs to a multiple of the load step when it is within this share of a step of it.
///
/// At 0.15 a force that has nothing to do with the step still belongs with probability 0.3, so twenty such forces practically never
/// all do, while hand-set loads are within 0.05 of a step of 10 N.
const GRID_SHARE: f64 = 0.15;

/// A force belongs to the multiple zero only within this share of a step: a preload, commonly a tenth of a step, must not become an
/// unloaded gauge.
const ZERO_SHARE: f64 = 0.05;

/// This share of the forces must belong to a multiple; the rest may be slips of the hand.
const ON_GRID_SHARE: f64 = 0.95;

const TARGETS_ARE_FORCES: &str =
    "the forces have no common load step: each force is its own target";

const TARGETS_ARE_MEANS: &str = "where all forces of a pose and direction, or of a run, differ by no more than 5 %, they are one load, and its target is their mean";

/// Whether forces are one load: from the smallest to the largest they differ by no more than what counts as another load.
pub(crate) fn are_one_load(forces_n: impl Iterator<Item = f64>) -> bool {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    for force_n in forces_n {
        (low, high) = (low.min(force_n), high.max(force_n));
    }
    high - low <= REVERSAL_SHARE * low.abs().max(high.abs())
}

/// Takes the multiples of the forces' common load step as targets, or each force itself if there is no such step; the mean force of a pose and
/// direction, or else of a run, whose forces are one load.
pub(super) fn fill_targets(table: &mut ReadingTable) {
    let forces: Vec<f64> = table.accepted().map(|reading| reading.force_n).collect();
    let Some(load_step_n) = common_load_step(&forces) else {
        fill_targets_without_step(table);
        return;
    };
    let mut off_grid = 0;
    for reading in &mut table.readings {
        let multiple = multiple_of(load_step_n, reading.force_n);
        if multiple.is_none() {
            off_grid += 1;
        }
        reading.target_n = multiple.unwrap_or(reading.force_n);
    }
    let off_grid = match off_grid {
        0 => String::new(),
        _ => format!(
            "; near no multiple, so that the force is the target: {}",
            counted(off_grid, "reading")
        ),
    };
    table.assumptions.push(format!(
        "target loads are the multiples of {load_step_n} N nearest to the forces{off_grid}"
    ));
}

fn fill_targets_without_step(table: &mut ReadingTable) {
    let cell = |reading: &Reading| (reading.pose.clone(), reading.direction);
    let run = |reading: &Reading| reading.run;
    let (of_cells, of_runs) = (single_loads(table, cell), single_loads(table, run));
    let (mut means, mut own) = (false, false);
    for reading in &mut table.readings {
        let of_cell = of_cells.get(&cell(reading));
        let mean = of_cell.or_else(|| of_runs.get(&run(reading)));
        reading.target_n = mean.copied().unwrap_or(reading.force_n);
        means |= mean.is_some();
        own |= mean.is_none();
    }
    let said = [(means, TARGETS_ARE_MEANS), (own, TARGETS_ARE_FORCES)];
    let said = said.into_iter().filter(|(is_so, _)| *is_so);
    table
        .assumptions
        .extend(said.map(|(_, one)| one.to_owned()));
}

/// Mean force, N, of each group of two readings or more whose forces are one load.
fn single_loads<K: Hash + Eq>(
    table: &ReadingTable,
    key: impl Fn(&Reading) -> K,
) -> HashMap<K, f64> {
    let mut groups: HashMap<K, Vec<f64>> = HashMap::new();
    for reading in table.accepted() {
        groups
            .entry(key(reading))
            .or_default()
            .push(reading.force_n);
    }
    let single = groups.into_iter().filter_map(|(key, forces)| {
        let is_one = forces.len() > 1 && are_one_load(forces.iter().copied());
        Some((key, mean(&forces).filter(|_| is_one)?))
    });
    single.collect()
}

/// The multiple of a load step that a force belongs to, N.
fn multiple_of(load_step_n: f64, force_n: f64) -> Option<f64> {
    let multiple = (force_n / load_step_n).round();
    let share = if multiple == 0.0 {
        ZERO_SHARE
    } else {
        GRID_SHARE
    };
    let target_n = multiple * load_step_n;
    // Adding zero turns a negative zero, which would print as -0, into zero.
    ((force_n - target_n).abs() <= share * load_step_n).then_some(target_n + 0.0)
}

/// The coarsest of the usual load steps to whose multiples the forces belong, N.
fn common_load_step(forces_n: &[f64]) -> Option<f64> {
    LOAD_STEPS_N.into_iter().find(|step_n| {
        let allowed = ((1.0 - ON_GRID_SHARE) * forces_n.len() as f64) as usize;
        let off_grid = forces_n
            .iter()
            .filter(|force| multiple_of(*step_n, **force).is_none())
            .take(allowed + 1)
            .count();
        let loaded = |force: &f64| multiple_of(*step_n, *force).is_some_and(|target| target != 0.0);
        off_grid <= allowed && forces_n.iter().any(loaded)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::readings::defaults::tests::{assumes, five_columns, read};

    #[test]
    fn load_steps_are_the_coarsest_that_fit() {
        assert_eq!(common_load_step(&[0.0, -9.6, -20.4, -70.2]), Some(10.0));
        assert_eq!(common_load_step(&[0.0, 49.0, 101.0]), Some(50.0));
        assert_eq!(common_load_step(&[1.0, 2.1, 2.95, 4.0]), Some(1.0));
        // A preload of 1 N must not become an unloaded gauge, so 10 N does not fit here.
        assert_eq!(common_load_step(&[-1.0, -10.0, -20.0]), Some(1.0));
        assert_eq!(common_load_step(&[3.3, 7.47, 11.62]), None);
        assert_eq!(common_load_step(&[0.0, 0.0]), None);
        assert_eq!(common_load_step(&[]), None);
    }

    #[test]
    fn a_slip_of_the_hand_keeps_its_own_force() {
        let mut forces: Vec<f64> = (0..40).map(|i| f64::from(i % 8) * 10.0).collect();
        forces[13] = 44.0;
        let table = five_columns(&forces);
        assert_eq!(table.readings[13].target_n, 44.0);
        assert!(assumes(
            &table,
            "target loads are the multiples of 10 N nearest to the forces; near no multiple, so that the force is the target: 1 reading"
        ));
    }

    #[test]
    fn without_a_load_step_each_force_is_its_target() {
        let table = five_columns(&[3.3, 7.47, 11.62]);
        assert!(
            table
                .readings
                .iter()
                .all(|reading| reading.target_n == reading.force_n)
        );
        assert!(assumes(&table, TARGETS_ARE_FORCES));
    }

    #[test]
    fn forces_of_one_load_have_one_target() {
        let table = five_columns(&[33.31, 33.24, 33.41]);
        let targets: Vec<f64> = table.readings.iter().map(|r| r.target_n).collect();
        assert!(
            targets.iter().all(|target| (target - 33.32).abs() < 1e-9),
            "{targets:?}"
        );
        assert!(assumes(&table, TARGETS_ARE_MEANS));
        assert!(!assumes(&table, TARGETS_ARE_FORCES));
        // Two loads, one in each run.
        let rows = "1,33.31,1\nP1,x,1,33.24,1\nP1,x,2,71.27,2\nP1,x,2,71.37,2\n";
        let table = read(&format!(
            "pose,direction,repeat,force_N,displacement_um\nP1,x,{rows}"
        ));
        let targets: Vec<f64> = table.readings.iter().map(|r| r.target_n).collect();
        assert_eq!(targets[0], targets[1]);
        assert_eq!(targets[2], targets[3]);
        assert!((targets[2] - 71.32).abs() < 1e-9, "{targets:?}");
    }
}
