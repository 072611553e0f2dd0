//! Where the displacement gauge stands without load, if that is not its zero.

use stiffbench_numeric::statistics::{LeastSquaresLine, median};
use stiffbench_units_and_text::test_point::Branch;

use super::observations::Observations;

/// Standard errors beyond which a cell was not zeroed without load. Nothing depends on the exact number: a shift by less would be taken
/// for the scatter of the zeros, one that is made without need costs the mean of the zeros of a cell, which no law has an effect on.
const NOT_ZEROED: f64 = 8.0;

/// Standard deviation of a normal distribution over its median absolute deviation, 1/Φ⁻¹(3/4).
const SD_PER_MAD: f64 = 1.4826;

/// Steps of the gauge that are never taken for a shift.
const STEPS: f64 = 2.0;

impl Observations {
    /// Counts the displacements of each cell from where the gauge stood without load, if it was zeroed elsewhere.
    ///
    /// A guided session zeroes the gauge under the preload, so that its tip has contact; a table by hand may not be zeroed at all. The
    /// laws count from the unloaded structure.
    ///
    /// # Returns
    /// The largest shift, m; `None` if the gauge was zeroed without load, or nothing was read without.
    pub(crate) fn count_from_unloaded(&mut self) -> Option<f64> {
        let unloaded: Vec<Vec<f64>> = (0..self.cells.len())
            .map(|cell| self.first_unloaded(cell))
            .collect();
        let centre = |values: &Vec<f64>| median(&mut values.clone());
        let centres: Vec<Option<f64>> = unloaded.iter().map(centre).collect();
        let mut deviations: Vec<f64> = unloaded
            .iter()
            .zip(&centres)
            .flat_map(|(values, centre)| {
                let centre = centre.unwrap_or_default();
                values.iter().map(move |value| (value - centre).abs())
            })
            .collect();
        let scatter = SD_PER_MAD * median(&mut deviations)?;
        let step = STEPS * self.steps.displacement_m.unwrap_or_default();
        let is_shifted = |(values, centre): (&Vec<f64>, &Option<f64>)| {
            let error = scatter / (values.len() as f64).sqrt();
            centre.is_some_and(|centre| centre.abs() > (NOT_ZEROED * error).max(step))
        };
        if !unloaded.iter().zip(&centres).any(is_shifted) {
            return None;
        }
        let mut largest = 0.0_f64;
        for (cell, centre) in self.cells.iter().zip(&centres) {
            let shift = centre.unwrap_or_default();
            largest = largest.max(shift.abs());
            for displacement in &mut self.displacement_m[cell.readings.clone()] {
                *displacement -= shift;
            }
        }
        Some(largest)
    }

    /// The readings of a cell with which runs begin without load, m, one for each zero of the gauge; without what the force does that was left on.
    fn first_unloaded(&self, cell: usize) -> Vec<f64> {
        let mut zeros = Vec::new();
        let readings = self.cells[cell].readings.clone();
        let points = readings.map(|place| (self.loads[place].force_n, self.displacement_m[place]));
        let m_per_n = LeastSquaresLine::through(points).map_or(0.0, |line| line.slope);
        let runs = &self.runs[self.cells[cell].runs.clone()];
        let first = runs.iter().map(|run| run.readings.start);
        let unloaded = first.filter(|&place| {
            let reading = &self.readings[place];
            let is_new = !zeros.contains(&reading.zero);
            zeros.push(reading.zero);
            is_new && reading.branch == Branch::Loading && self.loads[place].is_unloaded
        });
        let without_force = |place: usize| {
            let left_n = self.loads[place].force_n;
            self.displacement_m[place] - m_per_n * left_n
        };
        unloaded.map(without_force).collect()
    }
}
