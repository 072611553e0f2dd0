//! Which quantity of a part was set, by the clock: a machine moves its crosshead along a straight line of time.

use stiffbench_beams::physics::TestObject;
use stiffbench_numeric::statistics::{LeastSquaresLine, NORMAL_MEDIAN_DEVIATION, median};

use super::observations::{Observations, ReadingClock};
use crate::search::largest;

/// Fewest readings of a branch that show whether it is a straight line.
const FEWEST: usize = 5;

/// Largest variance about a straight line, in units of the column's own noise; and by how much that of the force exceeds it.
const STRAIGHT: f64 = 4.0;

/// What a column is off a line by as it is written down, as a share of its size.
const ROUNDING: f64 = 1e-5;

impl Observations {
    /// Whether the displacement of a part is a straight line of time in every branch, and the force, for its size, clearly less of one: loads
    /// that are set step by step scatter in both alike.
    pub(crate) fn displacement_was_set(&self) -> bool {
        let has_clock = self.object == TestObject::ForceDriven && self.clock == ReadingClock::Times;
        let largest_n = self.largest_load();
        let largest_m = largest(&self.displacement_m);
        let force = || self.off_the_clock(|place| self.loads[place].force_n / largest_n);
        let displacement = || self.off_the_clock(|place| self.displacement_m[place] / largest_m);
        let both = has_clock.then(displacement).flatten().zip(force());
        both.is_some_and(|([off, noise], [of_force, _])| {
            STRAIGHT * off < of_force && off < STRAIGHT * noise + ROUNDING.powi(2)
        })
    }

    /// Mean square by which a quantity is off the lines of time through its branches, and that of its noise, which neighbours show by their
    /// differences; `None` without times.
    fn off_the_clock(&self, value: impl Fn(usize) -> f64) -> Option<[f64; 2]> {
        let all: Vec<usize> = (0..self.len()).collect();
        let branch = |reading: usize| (self.readings[reading].run, self.readings[reading].branch);
        let branches = all.chunk_by(|a, b| branch(*a) == branch(*b));
        let (mut squares, mut readings, mut differences) = (0.0, 0.0, Vec::new());
        for branch in branches.filter(|branch| branch.len() >= FEWEST) {
            let point = |at: &usize| Some((self.readings[*at].time_s?, value(*at)));
            let points: Vec<(f64, f64)> = branch.iter().map(point).collect::<Option<_>>()?;
            let line = LeastSquaresLine::through(points.iter().copied())?;
            let off = points.iter().map(|(time, value)| value - line.at(*time));
            let off: Vec<f64> = off.collect();
            squares += line.residual_squares;
            readings += branch.len() as f64;
            differences.extend(off.windows(2).map(|pair| (pair[1] - pair[0]).powi(2)));
        }
        // The median: few neighbours differ by a step of the load.
        let noise = 0.5 * median(&mut differences)? / NORMAL_MEDIAN_DEVIATION.powi(2);
        Some([squares / readings, noise])
    }
}
