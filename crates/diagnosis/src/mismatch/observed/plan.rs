//! Readings that are planned and not yet made, laid out like those of a session.

use stiffbench_beams::physics::LoadPoint;
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::test_point::{Branch, Direction, PoseId};

use super::observations::{GaugeSteps, Observations, ObservedReading, Recorded};
use crate::parameters::place_of;

/// One planned reading.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlannedLoad {
    /// Place in the load sequence, counted on through unloading; readings of a hold share it.
    pub step: u32,
    /// The load, N, signed.
    pub force_n: f64,
    /// Branch.
    pub branch: Branch,
    /// n-th application of the sequence or load, from 1.
    pub repeat: u32,
    /// Seconds under the load at the reading.
    pub hold_s: f64,
    /// Seconds since the session began.
    pub time_s: f64,
    /// Temperature, °C, if it is to be recorded.
    pub temperature_deg_c: Option<f64>,
    /// Whether the gauge is zeroed before the load.
    pub zero_before: bool,
}

/// A pose, a direction of loads and the axis of a gauge with its planned readings, in the order in which they are to be made.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedCell {
    /// The pose.
    pub pose: PoseId,
    /// The direction of its loads.
    pub load: LoadDirection,
    /// The axis along which its displacements are read.
    pub direction: Direction,
    /// Its readings.
    pub loads: Vec<PlannedLoad>,
}

impl Observations {
    /// Lays out planned readings; their displacements are zero.
    ///
    /// # Arguments
    /// - `steps`: steps of the gauges that will be used.
    /// - `release_n`: force to which each load is released before the next, if it is.
    #[must_use]
    pub fn planned(cells: &[PlannedCell], steps: GaugeSteps, release_n: Option<f64>) -> Self {
        let (mut poses, mut others) = (Vec::new(), Vec::new());
        let mut place = |cell: &PlannedCell| {
            let load = match cell.load.axis() {
                Some(axis) => axis.index(),
                None => Direction::ALL.len() + place_of(&mut others, &cell.load),
            };
            let pose = place_of(&mut poses, &cell.pose);
            (pose, load, cell.direction.index())
        };
        let mut order: Vec<_> = cells.iter().map(|cell| (place(cell), cell)).collect();
        order.sort_by_key(|(place, _)| *place);
        let mut all = cells.iter().flat_map(|cell| &cell.loads).peekable();
        let recorded = Recorded {
            time: true,
            hold: true,
            temperature: all.peek().is_some() && all.all(|load| load.temperature_deg_c.is_some()),
        };
        let mut out = Self {
            poses,
            release_n,
            ..Self::without_readings(steps, recorded)
        };
        let mut zeros = 0;
        for ((pose, ..), cell) in order {
            out.begin_cell(pose, cell.load.clone(), cell.direction.into());
            out.push_cell(cell, &mut zeros);
        }
        out.gauges = out.gauges_read_at_once();
        out
    }

    fn push_cell(&mut self, cell: &PlannedCell, zeros: &mut u32) {
        // Each reading with its place and its zero.
        let mut planned: Vec<(u32, &PlannedLoad, u32, &PlannedLoad)> = Vec::new();
        for (place, load) in (1..).zip(&cell.loads) {
            let (zero, zeroed) = match planned.last() {
                Some((.., zero, zeroed)) if !load.zero_before => (*zero, *zeroed),
                _ => {
                    *zeros += 1;
                    (*zeros - 1, load)
                }
            };
            planned.push((place, load, zero, zeroed));
        }
        planned.sort_by_key(|(_, load, ..)| load.repeat);
        let mut repeat = None;
        for (seq, load, zero, zeroed) in planned {
            if repeat.replace(load.repeat) != Some(load.repeat) {
                self.begin_run(load.repeat, load.repeat);
            }
            let reading = ObservedReading {
                run: 0,
                seq,
                zero,
                branch: load.branch,
                hold_number: self.next_hold(load.step),
                time_s: Some(load.time_s),
                line: 0,
                target_n: load.force_n,
                flagged: false,
            };
            let warming = load.temperature_deg_c.zip(zeroed.temperature_deg_c);
            let load = LoadPoint {
                force_n: load.force_n,
                step: load.step,
                hold_s: load.hold_s,
                is_unloaded: load.force_n == 0.0,
                since_zero_s: load.time_s - zeroed.time_s,
                warming_k: warming.map_or(0.0, |(now, then)| now - then),
                ..LoadPoint::default()
            };
            self.push(reading, load, 0.0);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planned_readings_lie_as_a_session_lays_them_out() {
        let load = |step, repeat, time_s, zero_before| PlannedLoad {
            step,
            force_n: -10.0 * f64::from(step),
            branch: Branch::Loading,
            repeat,
            hold_s: 5.0,
            time_s,
            temperature_deg_c: None,
            zero_before,
        };
        // Each load twice before the next, one zero: two runs of two readings that share it.
        let loads = vec![
            load(0, 1, 10.0, true),
            load(0, 2, 20.0, false),
            load(1, 1, 30.0, false),
            load(1, 2, 40.0, false),
        ];
        let cell = |pose: &str, direction: Direction| PlannedCell {
            pose: pose.into(),
            load: direction.into(),
            direction,
            loads: loads.clone(),
        };
        let cells = [
            cell("B", Direction::Z),
            cell("A", Direction::X),
            cell("B", Direction::X),
        ];
        let observations = Observations::planned(&cells, GaugeSteps::default(), Some(-1.0));
        assert_eq!(observations.poses, ["B".into(), "A".into()]);
        let order: Vec<_> = observations
            .cells
            .iter()
            .map(|cell| {
                (
                    cell.pose,
                    cell.axis(),
                    cell.runs.clone(),
                    cell.readings.clone(),
                )
            })
            .collect();
        assert_eq!(
            order,
            [
                (0, Direction::X, 0..2, 0..4),
                (0, Direction::Z, 2..4, 4..8),
                (1, Direction::X, 4..6, 8..12)
            ]
        );
        let second = &observations.runs[1];
        assert_eq!((second.repeat, second.readings.clone()), (2, 2..4));
        assert_eq!(observations.loads[3].since_zero_s, 30.0);
        let zeros: Vec<u32> = observations.readings.iter().map(|r| r.zero).collect();
        assert_eq!(zeros, [0, 0, 0, 0, 1, 1, 1, 1, 2, 2, 2, 2]);
        assert!(!observations.recorded.temperature);
    }
}
