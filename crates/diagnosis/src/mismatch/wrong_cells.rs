//! Cells that were recorded under the name of others, or with another decimal point: poses or directions exchanged.
//!
//! What is compared are the logarithms of the compliances of cells, those measured and those of the baseline, fitted anew for every mistake that may
//! have been made, each beside one more spring or another structure if that explains more. With y what the fit leaves as
//! recorded and y - d as corrected, a mistake that was made leaves y in the direction of d. Two chances are asked for, the larger of
//! which counts:
//!
//! - that the residuals of all cells, by unknown physics of whatever direction, lie as near to d of any mistake (the angle between a fixed direction
//!   and one at random: Muirhead, Aspects of Multivariate Statistical Theory, 1982, theorem 1.5.7);
//! - that these cells alone, off by anything, come as near to the values that the mistake gives.
//!
//! So nothing is compared with the scatter of readings, and physics that the baseline lacks does not count for a mistake unless it imitates one.

use std::collections::BTreeSet;

use stiffbench_numeric::statistics::f_upper_tail;
use stiffbench_units_and_text::test_point::Direction;

use super::bad_readings::BadReadingKind;
use super::bad_runs::BadRun;
use super::baseline::Baseline;
use super::cell_compliance::{CellCompliance, CellComplianceModel, CellFit};
use super::error::MismatchError;
use super::known_noise::KnownNoise;
use super::observations::Observations;
use super::reading_screen::ReadingScreen;
use crate::search::constants::{
    BAD_READING_LEVEL, BY_COINCIDENCE, COLUMN_LEFT, LEAST_KNOWN_CELL, MISTAKES_FITTED,
    STRONG_EVIDENCE,
};
use crate::search::{dot, push_orthonormal, take_out};

/// What may have been done to the names or values of cells.
#[derive(Debug, Clone, PartialEq)]
enum CellMistake {
    /// Each pair has the names of the other.
    Exchanged(Vec<(usize, usize)>),
    /// The displacements of these have the decimal point so many places too far to the left.
    DecimalPoint(Vec<usize>, i32),
}

impl CellMistake {
    /// The cells that it changes.
    fn cells(&self) -> BTreeSet<usize> {
        match self {
            Self::Exchanged(pairs) => pairs.iter().flat_map(|(a, b)| [*a, *b]).collect(),
            Self::DecimalPoint(cells, _) => cells.iter().copied().collect(),
        }
    }

    /// What was measured, put right.
    fn corrected(&self, cells: &[CellCompliance]) -> Vec<CellCompliance> {
        let mut out = cells.to_vec();
        match self {
            Self::Exchanged(pairs) => {
                for (a, b) in pairs {
                    (out[*a].log, out[*b].log) = (cells[*b].log, cells[*a].log);
                    (out[*a].u, out[*b].u) = (cells[*b].u, cells[*a].u);
                }
            }
            Self::DecimalPoint(changed, places) => {
                for cell in changed {
                    out[*cell].log += f64::from(*places) * std::f64::consts::LN_10;
                }
            }
        }
        out
    }

    /// How many values of the same cells would be such a mistake too: the nearest of all decimal points counts on either side.
    fn alike(&self) -> f64 {
        match self {
            Self::Exchanged(_) => 1.0,
            Self::DecimalPoint(..) => 2.0,
        }
    }

    /// All that are considered: a pair of cells with a pose or direction in common, all of two poses or two directions; a decimal point of a cell, a
    /// pose, a direction.
    fn all(cells: &[CellCompliance]) -> Vec<Self> {
        let poses: BTreeSet<usize> = cells.iter().map(|cell| cell.pose).collect();
        let find = |pose: usize, direction: Direction| {
            let mut all = cells.iter();
            all.position(|cell| cell.pose == pose && cell.direction == direction)
        };
        let pose_pairs = pairs(&poses.iter().copied().collect::<Vec<_>>());
        let direction_pairs = pairs(&Direction::ALL);
        let mut groups: Vec<Vec<(usize, usize)>> = Vec::new();
        for (a, b) in pose_pairs {
            let common = Direction::ALL.iter();
            groups.push(
                common
                    .filter_map(|direction| Some((find(a, *direction)?, find(b, *direction)?)))
                    .collect(),
            );
        }
        for (a, b) in direction_pairs {
            let common = poses.iter();
            groups.push(
                common
                    .filter_map(|pose| Some((find(*pose, a)?, find(*pose, b)?)))
                    .collect(),
            );
        }
        let mut out = Vec::new();
        for group in groups.into_iter().filter(|group| !group.is_empty()) {
            out.extend(group.iter().map(|pair| Self::Exchanged(vec![*pair])));
            if group.len() > 1 {
                out.push(Self::Exchanged(group));
            }
        }
        let one = (0..cells.len()).map(|cell| vec![cell]);
        let those = |is_there: &dyn Fn(&CellCompliance) -> bool| -> Vec<usize> {
            let all = (0..cells.len()).filter(|cell| is_there(&cells[*cell]));
            all.collect()
        };
        let of_pose = poses.iter().map(|pose| those(&|cell| cell.pose == *pose));
        let of_direction = Direction::ALL.map(|one| those(&|cell| cell.direction == one));
        let several = of_pose.chain(of_direction);
        let several = several.filter(|set| set.len() > 1 && 2 * set.len() <= cells.len());
        for set in one.chain(several) {
            let places = [1, -1, 2, -2, 3, -3];
            out.extend(places.map(|places| Self::DecimalPoint(set.clone(), places)));
        }
        out
    }
}

fn pairs<T: Copy>(all: &[T]) -> Vec<(T, T)> {
    let mut out = Vec::new();
    for (place, a) in all.iter().enumerate() {
        out.extend(all[place + 1..].iter().map(|b| (*a, *b)));
    }
    out
}

/// A mistake, fitted.
struct FittedMistake<'m> {
    mistake: &'m CellMistake,
    corrected: Vec<CellCompliance>,
    suspect: Option<usize>,
    fit: CellFit,
}

/// Finds cells that are exchanged or have a wrong decimal point, by their places among the observed cells.
///
/// # Errors
/// [`MismatchError`] if the structure cannot be solved at the start of the fit.
pub(super) fn wrong_cells(
    baseline: &dyn Baseline,
    observations: &Observations,
    noise: &KnownNoise,
) -> Result<Vec<(usize, BadRun)>, MismatchError> {
    let (places, cells) = measured(baseline, observations, noise)?;
    let free = baseline.parameters().len();
    // One more spring may be free, and one direction is that of the mistake.
    let Some(dof) = cells.len().checked_sub(free + 2).filter(|dof| *dof > 0) else {
        return Ok(Vec::new());
    };
    let dof = dof as f64;
    let mut model = CellComplianceModel::new(baseline, &cells)?;
    let Some(as_recorded) = model.fit(&cells, &|_| true, None, None) else {
        return Ok(Vec::new());
    };
    let mistakes = CellMistake::all(&cells);
    let tried = (mistakes.len() * model.alternatives().count()) as f64;
    // Less than the scatter of the slopes no fit leaves but by luck.
    let chance = |before: f64, after: f64| {
        let after = after.max(dof);
        let ratio = (before - after).max(0.0) / (after / dof);
        let one = 0.5 * f_upper_tail(ratio, 1.0, dof).unwrap_or(1.0);
        -(tried * (-one).ln_1p()).exp_m1()
    };
    if chance(as_recorded.squares, 0.0) > BAD_READING_LEVEL {
        return Ok(Vec::new());
    }
    let mut fitted: Vec<FittedMistake<'_>> = Vec::new();
    for mistake in nearest(&mistakes, &cells, &as_recorded) {
        let corrected = mistake.corrected(&cells);
        let fit = model.fit(&corrected, &|_| true, None, None);
        fitted.extend(fit.map(|fit| FittedMistake {
            mistake,
            corrected,
            suspect: None,
            fit,
        }));
    }
    let Some((_, before)) = best_fit(&mut model, &cells, &as_recorded) else {
        return Ok(Vec::new());
    };
    // A mistake that was made leaves less by itself than any other mistake of the model.
    fitted.retain(|one| one.fit.squares < before.squares);
    for one in &mut fitted {
        if let Some((suspect, fit)) = best_fit(&mut model, &one.corrected, &one.fit) {
            (one.suspect, one.fit) = (suspect, fit);
        }
    }
    fitted.sort_by(|a, b| a.fit.squares.total_cmp(&b.fit.squares));
    let Some(chosen) = unambiguous(&fitted, dof) else {
        return Ok(Vec::new());
    };
    // The cells by themselves: their distance from what all others predict, as recorded and as corrected.
    let changed = chosen.mistake.cells();
    let others = model.fit(
        &chosen.corrected,
        &|cell| !changed.contains(&cell),
        chosen.suspect,
        Some(&chosen.fit),
    );
    let of_others = others.map_or(0.0, |fit| fit.squares);
    let scale = (chosen.fit.squares / dof).max(1.0);
    let seen = (changed.len() as f64).min(dof);
    let near = (chosen.fit.squares - of_others).max(seen * scale);
    let far = (before.squares - of_others).max(near);
    let by_coincidence = chosen.mistake.alike() * (near / far).powf(0.5 * seen);
    let p = chance(before.squares, chosen.fit.squares);
    if p > BAD_READING_LEVEL || by_coincidence > BY_COINCIDENCE {
        return Ok(Vec::new());
    }
    let p_family = p.max(by_coincidence);
    let bad = |cell: usize, kind: BadReadingKind| {
        let expected = chosen.fit.logs[cell].exp();
        let u = chosen.corrected[cell].u * scale.sqrt() * expected;
        let values = [cells[cell].log.exp(), expected, u];
        BadRun::new(observations, (places[cell], None), values, p_family, kind)
    };
    Ok(match chosen.mistake {
        CellMistake::Exchanged(pairs) => pairs
            .iter()
            .flat_map(|(a, b)| [(*a, *b), (*b, *a)])
            .map(|(cell, with)| {
                let exchanged_with = Some(observations.name_of(places[with]));
                let bad = bad(cell, BadReadingKind::Any);
                let bad = BadRun {
                    exchanged_with,
                    ..bad
                };
                (places[cell], bad)
            })
            .collect(),
        CellMistake::DecimalPoint(cells, moved) => cells
            .iter()
            .map(|cell| {
                (
                    places[*cell],
                    bad(*cell, BadReadingKind::DecimalPoint(*moved)),
                )
            })
            .collect(),
    })
}

/// The fit that leaves least, with one mistake of the model or none.
fn best_fit(
    model: &mut CellComplianceModel<'_>,
    cells: &[CellCompliance],
    start: &CellFit,
) -> Option<(Option<usize>, CellFit)> {
    let mut best: Option<(Option<usize>, CellFit)> = None;
    for suspect in model.alternatives() {
        let Some(fit) = model.fit(cells, &|_| true, suspect, Some(start)) else {
            continue;
        };
        if best
            .as_ref()
            .is_none_or(|(_, best)| fit.squares < best.squares)
        {
            best = Some((suspect, fit));
        }
    }
    best
}

/// The compliances of cells that the readings determine, with the places of the cells.
fn measured(
    baseline: &dyn Baseline,
    observations: &Observations,
    noise: &KnownNoise,
) -> Result<(Vec<usize>, Vec<CellCompliance>), MismatchError> {
    let screen = ReadingScreen::new(baseline, observations, noise)?;
    let found = screen.noise_of(&vec![true; observations.len()], None);
    let uncertainties = screen.relative_uncertainties(&found);
    let of_cell = |place: usize| {
        let cell = &observations.cells[place];
        let compliance = screen.compliance[cell.readings.start];
        let cell = CellCompliance {
            pose: cell.pose,
            direction: cell.axis(),
            log: compliance.abs().ln(),
            u: uncertainties[place],
        };
        (place, compliance, cell)
    };
    let all: Vec<(usize, f64, CellCompliance)> =
        (0..observations.cells.len()).map(of_cell).collect();
    // Where most yield against their load, that is the convention of the session.
    let along = || {
        all.iter()
            .filter(|(place, ..)| observations.cells[*place].is_along_load())
    };
    let against = along().filter(|(_, c, _)| *c < 0.0).count();
    let sign = if 2 * against >= along().count() {
        -1.0
    } else {
        1.0
    };
    // Across the load a compliance has either sign.
    let usable = all.into_iter().filter(|(place, c, cell)| {
        let is_along = observations.cells[*place].is_along_load();
        is_along && sign * c > 0.0 && cell.u < LEAST_KNOWN_CELL
    });
    Ok(usable.map(|(place, _, cell)| (place, cell)).unzip())
}

/// The mistakes that leave least if the model is linear about its fit to what was recorded.
fn nearest<'m>(
    mistakes: &'m [CellMistake],
    cells: &[CellCompliance],
    as_recorded: &CellFit,
) -> Vec<&'m CellMistake> {
    let mut basis = Vec::new();
    for column in &as_recorded.columns {
        push_orthonormal(&mut basis, column.clone(), COLUMN_LEFT * COLUMN_LEFT, 0.0);
    }
    let rows = as_recorded
        .columns
        .first()
        .map_or(cells.len(), std::vec::Vec::len);
    let left = |mistake: &CellMistake| {
        let corrected = mistake.corrected(cells);
        let mut residual = vec![0.0; rows];
        for (place, cell) in corrected.iter().enumerate() {
            residual[place] = (as_recorded.logs[place] - cell.log) / cells[place].u;
        }
        take_out(&basis, &mut residual);
        dot(&residual, &residual)
    };
    let mut all: Vec<(f64, &CellMistake)> = mistakes.iter().map(|one| (left(one), one)).collect();
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    all.truncate(MISTAKES_FITTED);
    all.into_iter().map(|(_, mistake)| mistake).collect()
}

/// Of the mistakes that explain about as much as the best the one with the fewest cells, if the others have all of its cells too.
fn unambiguous<'f, 'm>(fitted: &'f [FittedMistake<'m>], dof: f64) -> Option<&'f FittedMistake<'m>> {
    let best = fitted.first()?;
    let scale = (best.fit.squares / dof).max(1.0);
    let within = best.fit.squares + 2.0 * STRONG_EVIDENCE * scale;
    let near = || fitted.iter().filter(|one| one.fit.squares <= within);
    let chosen = near().min_by_key(|one| one.mistake.cells().len())?;
    let own = chosen.mistake.cells();
    near()
        .all(|one| own.is_subset(&one.mistake.cells()))
        .then_some(chosen)
}
