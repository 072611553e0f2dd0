//! Results that are no error and hardly meant: each with its number and the likely cause.

use crate::fit::FitOutcome;
use crate::quantity::METRES_PER_MICROMETRE;
use crate::stiffness::{Method, StiffnessTable};

/// Stiffness of machines, N/m: 1 N/mm yields under a finger, 1000 N/um no robot reaches.
const STIFFNESS_N_PER_M: [f64; 2] = [1e3, 1e9];

/// Loads are set, displacements follow: across cells the largest force varies less than this, relative.
const SET: f64 = 0.05;

/// And the largest displacement varies more than this.
const FOLLOWS: f64 = 0.3;

/// A scatter between runs so uneven is in one session of twenty by chance.
const UNEVEN_P: f64 = 0.05;

/// Residuals so many times what the scatter explains are no chance.
const FAR_OUTSIDE: f64 = 10.0;

/// A model that errs by more than this explains the stiffness badly, percent.
const BAD_FIT_PERCENT: f64 = 10.0;

/// Doubts about readings that were taken for force and displacement.
#[must_use]
pub fn doubts_about_stiffness(table: &StiffnessTable) -> Vec<String> {
    let mut odd = Vec::new();
    let mut values: Vec<f64> = table
        .cells
        .iter()
        .filter_map(|row| Some(row.by(Method::Regression).ok()?.estimate.value))
        .collect();
    if values.is_empty() {
        return odd;
    }
    values.sort_by(f64::total_cmp);
    let median = values[values.len() / 2];
    if median < 0.0 {
        odd.push(
            "force and displacement have opposite signs in most cells: turn the sign of one of the gauges".to_owned(),
        );
    }
    let size = median.abs();
    if !(STIFFNESS_N_PER_M[0]..=STIFFNESS_N_PER_M[1]).contains(&size) {
        odd.push(format!(
            "the stiffness of the middle cell is {:.3e} N/um, expected {:e} to {:e}: does the displacement have the unit that its column names?",
            size * METRES_PER_MICROMETRE,
            STIFFNESS_N_PER_M[0] * METRES_PER_MICROMETRE,
            STIFFNESS_N_PER_M[1] * METRES_PER_MICROMETRE
        ));
    }
    if let Some(run_slope) = &table.run_slope
        && let Some(p) = run_slope.evenness_p.filter(|p| *p < UNEVEN_P)
    {
        odd.push(format!(
            "the scatter between runs is not the same in all cells (Bartlett's test, p = {p:.1e}); a fit assumes that it is, so that cells with more scatter weigh too much: check them for loose parts, or repeat them"
        ));
    }
    let largest = |of: fn(&crate::stiffness::LoadMean) -> f64| -> Vec<f64> {
        let cells = table.cells.iter();
        cells
            .map(|row| {
                row.loads
                    .iter()
                    .map(|load| of(load).abs())
                    .fold(0.0, f64::max)
            })
            .collect()
    };
    let forces = largest(|load| load.force_n.mean);
    let displacements = largest(|load| load.displacement_m.mean);
    if let (Some(force), Some(displacement)) = (variation(&forces), variation(&displacements))
        && displacement < SET
        && force > FOLLOWS
    {
        odd.push(format!(
            "the largest displacement is nearly the same in all cells and the largest force differs by {:.0} %: are the two columns exchanged?",
            100.0 * force
        ));
    }
    odd
}

/// Doubts about a model that was fitted.
#[must_use]
pub fn doubts_about_fit(outcome: &FitOutcome) -> Vec<String> {
    let mut odd = Vec::new();
    let agreement = outcome.agreement.as_ref();
    let agreement = agreement.and_then(|agreement| agreement.reduced_chi_squared);
    let times = agreement.map_or(0.0, f64::sqrt);
    if times > FAR_OUTSIDE {
        odd.push(format!(
            "the residuals are {times:.0} times what the scatter explains: `stiffbench diagnose` with the readings shows what the model leaves out"
        ));
    }
    let error = outcome
        .max_error_percent()
        .filter(|error| *error > BAD_FIT_PERCENT);
    if let Some(error) = error {
        odd.push(format!(
            "the model misses a measured stiffness by {error:.0} %: `stiffbench diagnose` with the readings shows what it leaves out"
        ));
    }
    odd
}

/// Standard deviation over mean, from three values on.
fn variation(values: &[f64]) -> Option<f64> {
    let mean = crate::statistics::mean(values).filter(|mean| *mean > 0.0)?;
    let enough = values.len() >= 3;
    crate::statistics::standard_deviation(values)
        .filter(|_| enough)
        .map(|sd| sd / mean)
}
