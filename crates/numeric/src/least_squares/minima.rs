//! All minima of a sum of squares that starts spread over the bounds lead to.

use super::error::LeastSquaresError;
use super::minimise::{LeastSquaresFit, LeastSquaresSettings, minimise};
use super::parameter::ParameterSet;
use super::residual_function::ResidualFunction;
use crate::statistics::{even_share, golden_ratio};

/// Two fits that differ in no parameter by more than this share of the distance between its bounds are one minimum.
const SAME_MINIMUM: f64 = 1e-3;

/// Most minima kept. A valley without a bottom has as many as there are starts.
const MOST_MINIMA: usize = 6;

/// Distinct local minima within the bounds, lowest first, from the start of `set` and from further starts (values of the free parameters).
///
/// Only the first fit is kept if it did not converge. See [`spread`] for starts.
///
/// # Errors
/// Those of [`minimise`] from the start of `set`; other starts without a value are passed over.
pub fn minima(
    problem: &mut dyn ResidualFunction,
    set: &ParameterSet,
    starts: impl Iterator<Item = Vec<f64>>,
    settings: &LeastSquaresSettings,
) -> Result<Vec<LeastSquaresFit>, LeastSquaresError> {
    let mut found = vec![minimise(problem, set, settings)?];
    for point in starts {
        match minimise(problem, &set.with_start(&point)?, settings) {
            Ok(fit) if fit.termination.is_converged() => keep(&mut found, fit, set),
            Ok(_) | Err(LeastSquaresError::StartHasNoValue { .. }) => {}
            Err(error) => return Err(error),
        }
    }
    found.sort_by(|a, b| a.objective.total_cmp(&b.objective));
    found.truncate(MOST_MINIMA);
    Ok(found)
}

/// Adds a fit, or puts it in the place of the same minimum found less well.
fn keep(found: &mut Vec<LeastSquaresFit>, fit: LeastSquaresFit, set: &ParameterSet) {
    let bounds = set.free_bounds();
    let same = |known: &&mut LeastSquaresFit| {
        let pairs = known.free_values.iter().zip(&fit.free_values).zip(&bounds);
        pairs.into_iter().all(|((a, b), (lower, upper))| {
            let width = upper - lower;
            let scale = if width.is_finite() { width } else { a.abs() };
            (a - b).abs() <= SAME_MINIMUM * scale
        })
    };
    match found.iter_mut().find(same) {
        Some(known) if fit.objective < known.objective => *known = fit,
        Some(_) => {}
        None => found.push(fit),
    }
}

/// Points that fill the bounds evenly however many are taken.
///
/// A parameter without two finite bounds is at its start in all of them.
pub fn spread(set: &ParameterSet) -> impl Iterator<Item = Vec<f64>> {
    let (bounds, start) = (set.free_bounds(), set.free_start());
    let ratio = golden_ratio(bounds.len());
    (1..).map(move |k: u32| {
        let coordinate = |(place, (&(lower, upper), &start)): (usize, (&(f64, f64), &f64))| {
            let share = even_share(ratio, k, place);
            if lower.is_finite() && upper.is_finite() {
                lower + share * (upper - lower)
            } else {
                start
            }
        };
        bounds
            .iter()
            .zip(&start)
            .enumerate()
            .map(coordinate)
            .collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::least_squares::Parameter;
    use crate::least_squares::rows::{ResidualRows, Row};

    /// r = (p² - 1, (p - 1)/20): wells at 1 and near -1, the first lower.
    fn two_wells(p: &[f64], i: usize) -> Row {
        match i {
            0 => (p[0] * p[0] - 1.0, vec![2.0 * p[0]]),
            _ => ((p[0] - 1.0) / 20.0, vec![1.0 / 20.0]),
        }
    }

    #[test]
    fn both_wells_are_found_from_either_side_and_the_lower_comes_first() {
        for start in [-1.5, 1.5] {
            let set = ParameterSet::new(vec![Parameter::free("p", start, -3.0, 3.0)]).unwrap();
            let settings = LeastSquaresSettings::default();
            let mut wells = ResidualRows(2, two_wells);
            let found = minima(&mut wells, &set, spread(&set).take(16), &settings).unwrap();
            let at: Vec<f64> = found.iter().map(|fit| fit.free_values[0]).collect();
            assert_eq!(at.len(), 2, "{at:?}");
            // The slope of the second residual moves its well: 4p(p² - 1) + (p - 1)/200 = 0 near -1 at -1 + 1/800.
            assert!((at[0] - 1.0).abs() < 1e-9, "{at:?}");
            assert!((at[1] + 1.0 - 1.0 / 800.0).abs() < 1e-5, "{at:?}");
        }
    }

    #[test]
    fn points_lie_inside_the_bounds_and_fill_each_half_alike() {
        let set = ParameterSet::new(vec![
            Parameter::free("p", 0.0, -1.0, 3.0),
            Parameter::unbounded("q", 7.0),
        ])
        .unwrap();
        let points: Vec<Vec<f64>> = spread(&set).take(64).collect();
        assert!(
            points
                .iter()
                .all(|p| (-1.0..3.0).contains(&p[0]) && p[1] == 7.0)
        );
        let below = points.iter().filter(|p| p[0] < 1.0).count();
        assert!((31..=33).contains(&below), "{below}");
    }
}
