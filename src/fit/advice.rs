//! Which measurement would determine a factor that the data leave open.

use crate::robot::{FittingFactors, Mechanism, Robot, RobotError};
use crate::test_point::{Cell, Direction};

use super::cell_model::{CellModel, FACTOR_NAMES, FACTORS, Shares};

/// The single further cell that would help most with one factor.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Advice {
    /// The factor.
    pub factor: &'static str,
    /// Pose and direction to measure.
    pub measure: Cell,
    /// Standard uncertainty of ln a with the data at hand.
    pub ln_uncertainty_now: f64,
    /// The same with the further cell.
    pub ln_uncertainty_then: f64,
}

impl Advice {
    /// Whether the further cell halves the uncertainty; if not, no stiffness at the end determines the factor.
    #[must_use]
    pub fn helps(&self) -> bool {
        self.ln_uncertainty_then < 0.5 * self.ln_uncertainty_now
    }
}

/// For each open factor the cell among the robot's named poses that determines it best.
///
/// # Arguments
/// - `information`: JᵀJ of ln K to ln a over all eight factors, in units of the inverse variance, at `factors`.
/// - `free`: which factors the fit moves.
/// - `open`: those that need help.
/// - `ln_uncertainty`: of the further cell's ln K.
/// - `prior_ln`: half the width of what bounds allow, taken as a standard deviation: keeps undetermined directions finite.
///
/// # Errors
/// Those of [`CellModel::new`]; poses the mechanism cannot reach are passed over.
pub(super) fn advise(
    robot: &Robot,
    mechanism: &Mechanism,
    factors: &FittingFactors,
    information: &[[f64; FACTORS]; FACTORS],
    free: &[usize],
    open: &[usize],
    ln_uncertainty: f64,
    prior_ln: f64,
) -> Result<Vec<Advice>, RobotError> {
    if open.is_empty() {
        return Ok(Vec::new());
    }
    let mut candidates: Vec<(Cell, Shares)> = Vec::new();
    for named in &robot.poses {
        let cells = Direction::ALL.map(|direction| Cell {
            pose: named.id.clone(),
            direction,
        });
        let mut model = match CellModel::new(robot, mechanism, &cells) {
            Ok(model) => model,
            Err(RobotError::Unreachable { .. }) => continue,
            Err(error) => return Err(error),
        };
        let mut shares = [[0.0; FACTORS]; 3];
        model.evaluate(factors, &mut [0.0; 3], Some(&mut shares))?;
        candidates.extend(cells.into_iter().zip(shares));
    }
    let p = free.len();
    let matrix = |extra: Option<&Shares>| {
        nalgebra::DMatrix::from_fn(p, p, |i, j| {
            let (a, b) = (free[i], free[j]);
            let prior = if i == j {
                1.0 / (prior_ln * prior_ln)
            } else {
                0.0
            };
            let further = extra.map_or(0.0, |s| s[a] * s[b] / (ln_uncertainty * ln_uncertainty));
            information[a][b] + prior + further
        })
    };
    let uncertainty = |extra: Option<&Shares>, factor: usize| {
        let place = free.iter().position(|f| *f == factor)?;
        Some(matrix(extra).cholesky()?.inverse()[(place, place)].sqrt())
    };
    let best = |&factor: &usize| {
        let now = uncertainty(None, factor)?;
        let (cell, then) = candidates
            .iter()
            .filter_map(|(cell, shares)| Some((cell, uncertainty(Some(shares), factor)?)))
            .min_by(|a, b| a.1.total_cmp(&b.1))?;
        Some(Advice {
            factor: FACTOR_NAMES[factor],
            measure: cell.clone(),
            ln_uncertainty_now: now,
            ln_uncertainty_then: then,
        })
    };
    Ok(open.iter().filter_map(best).collect())
}
