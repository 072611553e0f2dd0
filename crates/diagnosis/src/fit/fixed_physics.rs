//! Physics beside the beams that a fit holds fixed, and the loads under which the cells were measured.

use std::sync::Arc;

use stiffbench_beams::physics::{ActingPhysics, LoadPoint};
use stiffbench_measurement::readings::{Reading, ReadingStatus, ReadingTable, SessionHeader};
use stiffbench_measurement::stiffness::{
    Branches, LoadCurve, Method, NoStiffness, stiffness_value,
};
use stiffbench_units_and_text::test_point::{Branch, Cell};

use crate::mismatch::{CellSlopes, load_point};

/// What acts beside the beams, and how the stiffness of a cell is made of readings under it.
///
/// A law that is not linear has no stiffness of its own. What a fit compares is the stiffness that the estimator of the data gives for
/// the readings that the model predicts, under the loads of the session itself, their history and their times. Where all laws are
/// linear that is the exact stiffness.
#[derive(Debug, Clone)]
pub struct FixedPhysics {
    /// The mechanism and its laws.
    pub acting: ActingPhysics,
    method: Method,
    release_n: Option<f64>,
    cells: Vec<CellReadings>,
    /// How the compliances of cells were made of readings, where it was by least squares in their noise.
    slopes: Vec<Arc<CellSlopes>>,
}

/// The readings of a cell, run by run; their displacements are of no account.
#[derive(Debug, Clone)]
pub(super) struct CellReadings {
    pub(super) cell: Cell,
    pub(super) readings: Vec<Reading>,
    pub(super) loads: Vec<LoadPoint>,
}

/// Loads of a cell without readings: the paper's (Section IV-C), -10 to -70 N in steps of 10, five times.
const LOADS: u32 = 7;

/// See [`LOADS`].
const REPEATS: u32 = 5;

impl FixedPhysics {
    /// Physics in cells without readings: their stiffness is that of the paper's loads, 0 to -70 N five times, without time.
    ///
    /// # Arguments
    /// - `method`: how the stiffness that is compared was computed of readings.
    #[must_use]
    pub fn new(acting: ActingPhysics, method: Method) -> Self {
        Self {
            acting,
            method,
            release_n: None,
            cells: Vec::new(),
            slopes: Vec::new(),
        }
    }

    /// The same with the loads of a session.
    #[must_use]
    pub fn under(mut self, table: &ReadingTable, header: Option<&SessionHeader>) -> Self {
        self.release_n = header.and_then(SessionHeader::release_n);
        let since_zero = table.since_zero();
        for (reading, since) in table.readings.iter().zip(since_zero) {
            let numbers = [reading.target_n, reading.force_n, reading.displacement_m];
            if reading.status != ReadingStatus::Accepted || !numbers.iter().all(|n| n.is_finite()) {
                continue;
            }
            let cell = reading.cell();
            let known = self.cells.iter().position(|known| known.cell == cell);
            let place = known.unwrap_or_else(|| {
                self.cells.push(CellReadings::empty(cell));
                self.cells.len() - 1
            });
            self.cells[place].readings.push(Reading {
                text: None,
                ..reading.clone()
            });
            self.cells[place].loads.push(load_point(reading, since));
        }
        for cell in &mut self.cells {
            cell.sort_by_run();
        }
        self
    }

    /// The same, where cells have the compliances of slopes.
    #[must_use]
    pub fn by(mut self, slopes: Option<&Arc<CellSlopes>>) -> Self {
        self.slopes.extend(slopes.cloned());
        self
    }

    /// The slopes in which a cell has its compliance: with its series, and its place there.
    pub(super) fn slope(&self, cell: &Cell) -> Option<(Arc<CellSlopes>, [usize; 2])> {
        self.slopes.iter().find_map(|slopes| {
            let found = slopes.find(cell)?;
            Some((Arc::clone(slopes), found))
        })
    }

    /// The readings of a cell; those of the paper's loads if it has none.
    pub(super) fn readings(&self, cell: &Cell) -> CellReadings {
        let known = self.cells.iter().find(|known| known.cell == *cell);
        known.cloned().unwrap_or_else(|| CellReadings::paper(cell))
    }

    pub(super) fn release_n(&self) -> Option<f64> {
        self.release_n
    }

    /// Stiffness of a cell whose readings show `displacement_m`, N/m.
    ///
    /// # Errors
    /// [`NoStiffness`].
    pub(super) fn stiffness_n_per_m(
        &self,
        cell: &mut CellReadings,
        displacement_m: &[f64],
    ) -> Result<f64, NoStiffness> {
        for (reading, &displacement_m) in cell.readings.iter_mut().zip(displacement_m) {
            reading.displacement_m = displacement_m;
        }
        let readings: Vec<&Reading> = cell.readings.iter().collect();
        let curve = LoadCurve::new(cell.cell.clone(), &readings, Branches::LoadingOnly);
        stiffness_value(&curve, self.method)
    }
}

impl CellReadings {
    pub(super) fn empty(cell: Cell) -> Self {
        Self {
            cell,
            readings: Vec::new(),
            loads: Vec::new(),
        }
    }

    fn paper(cell: &Cell) -> Self {
        let mut paper = Self::empty(cell.clone());
        for repeat in 1..=REPEATS {
            for step in 0..=LOADS {
                let force_n = -10.0 * f64::from(step);
                let Cell {
                    pose, direction, ..
                } = cell.clone();
                paper.readings.push(Reading {
                    line: 0,
                    seq: paper.readings.len() as u32 + 1,
                    pose,
                    direction,
                    load: None,
                    branch: Branch::Loading,
                    step,
                    repeat,
                    attempt: 1,
                    run: repeat - 1,
                    zero: repeat - 1,
                    status: ReadingStatus::Accepted,
                    target_n: force_n,
                    force_n,
                    displacement_m: 0.0,
                    time_s: None,
                    hold_s: None,
                    temperature_deg_c: None,
                    text: None,
                });
                paper.loads.push(LoadPoint {
                    force_n,
                    step,
                    ..LoadPoint::default()
                });
            }
        }
        paper
    }

    /// Brings the readings of each run together; within a run the order of the session is kept.
    fn sort_by_run(&mut self) {
        let mut order: Vec<usize> = (0..self.readings.len()).collect();
        order.sort_by_key(|&place| self.readings[place].run);
        self.readings = order.iter().map(|&i| self.readings[i].clone()).collect();
        self.loads = order.iter().map(|&i| self.loads[i]).collect();
    }
}
