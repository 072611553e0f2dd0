//! Readings that tests of several rooms share.

use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::{Branch, Direction};

use super::{GaugeSteps, Observations, PlannedCell, PlannedLoad};

/// Two cells, two repeats of five loads.
pub(crate) fn observations() -> Observations {
    let load = |repeat: u32, step: u32| PlannedLoad {
        step,
        force_n: -13.7 * f64::from(step),
        branch: Branch::Loading,
        repeat,
        hold_s: 5.0,
        time_s: 12.0 * f64::from(10 * repeat + step),
        temperature_deg_c: None,
        zero_before: step == 0,
    };
    let cell = |direction: Direction| PlannedCell {
        pose: "P1".into(),
        load: direction.into(),
        direction,
        loads: (1..=2)
            .flat_map(|repeat| (0..5).map(move |step| load(repeat, step)))
            .collect(),
    };
    let cells = [Direction::X, Direction::Y].map(cell);
    Observations::planned(&cells, GaugeSteps::default(), None)
}

/// Two cells of the same loads, read at once along y and z: two runs of five readings each.
pub(crate) fn two_gauges() -> Observations {
    let mut both = observations();
    both.gauges = vec![Direction::Y, Direction::Z];
    for (cell, axis) in both.cells.iter_mut().zip([Direction::Y, Direction::Z]) {
        cell.load = LoadDirection::Axis(Direction::X);
        cell.read = axis.into();
    }
    for run in &mut both.runs {
        run.session_run = run.repeat;
    }
    let half = both.len() / 2;
    for (place, reading) in both.readings.iter_mut().enumerate() {
        reading.seq = (place % half) as u32;
    }
    both
}
