//! Whether the repeats of a cell refute the straight line whose slope its stiffness is.

use super::checks::CellWork;
use super::curve::LoadCurve;
use super::flags::Flag;
use super::gauges::GaugePair;
use super::line::StraightLine;
use super::outliers::{ROUNDING, step_variance_m2};
use stiffbench_numeric::statistics::f_upper_tail;

/// Repeats refute a line that they would miss as far with less than this chance.
const LEVEL: f64 = 0.01;

impl CellWork {
    /// Flags a cell whose step means are off the line by more than its repeats explain, and whose halves differ by more than U.
    ///
    /// F of the step means against step times run, zero and slope of each run taken out and loads corrected to their mean, with (n - 2) and
    /// (n - 2)(r - 1) degrees of freedom. A display rounds all repeats of a load alike, so its steps count once for each repeat.
    ///
    /// # Arguments
    /// - `expanded_n_per_m`: U of the stiffness.
    pub(super) fn not_straight(&self, gauges: &GaugePair, expanded_n_per_m: f64) -> Option<Flag> {
        let scatter = self.scatter.as_ref()?;
        let (squares_m2, dof) = scatter.lack_of_fit;
        let steps_m2 = step_variance_m2(gauges, scatter.compliance_m_per_n);
        let rounding_m = ROUNDING * self.curve.largest_displacement_m();
        let variance_m2 = scatter.sum_of_squares_m2 / scatter.dof
            + steps_m2 * self.curve.runs.len() as f64
            + rounding_m * rounding_m;
        // Displacements that are too large to be squared tell nothing.
        let f = Some(squares_m2 / dof / variance_m2).filter(|f| (f * dof).is_finite())?;
        f_upper_tail(f, dof, scatter.dof).filter(|p| *p < LEVEL)?;
        let apart = |halves: &[([f64; 2], f64); 2]| (halves[0].1 - halves[1].1).abs();
        // Loads of both signs may bend at zero, or alike on either side of it.
        let halves = [|target_n| target_n, f64::abs].map(|order| halves(&self.curve, order));
        let halves = halves.into_iter().flatten();
        let halves = halves.max_by(|a, b| apart(a).total_cmp(&apart(b)))?;
        (apart(&halves) > expanded_n_per_m).then_some(Flag::NotStraight {
            f,
            dof: [dof, scatter.dof],
            halves,
        })
    }
}

/// Two halves of the loads in an order: their ends, N, and the stiffness of each, N/m, with a zero for every run.
fn halves(curve: &LoadCurve, order: fn(f64) -> f64) -> Option<[([f64; 2], f64); 2]> {
    let mut loads: Vec<usize> = (0..curve.loads.len()).collect();
    let place = |load: &usize| order(curve.loads[*load].target_n);
    loads.sort_by(|a, b| place(a).total_cmp(&place(b)));
    let half = |loads: &[usize]| {
        let here = |run: &super::curve::Run| {
            StraightLine::through(
                run.points
                    .iter()
                    .filter(|point| loads.contains(&point.load)),
            )
        };
        let lines: Vec<StraightLine> = curve.runs.iter().filter_map(here).collect();
        let sxx: f64 = lines.iter().map(|line| line.sxx_n2).sum();
        let sxy: f64 = lines
            .iter()
            .map(|line| line.sxx_n2 * line.slope_m_per_n)
            .sum();
        let ends = [loads.first()?, loads.last()?].map(|load| curve.loads[*load].target_n);
        (sxy != 0.0).then_some((ends, sxx / sxy))
    };
    Some([
        half(&loads[..loads.len().div_ceil(2)])?,
        half(&loads[loads.len() / 2..])?,
    ])
}
