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

use super::bad_readings::{BadReadingKind, DECIMAL_PLACES};
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
use crate::search::{chance_of_any, dot, push_orthonormal, take_out};

/// What may have been done to a cell.
#[derive(Debug, Clone, Copy, PartialEq)]
enum CellSlip {
    /// It has the name of another.
    NameOf(usize),
    /// Its displacements have the decimal point so many places too far to the left.
    DecimalPoint(i32),
}

/// What may have been done to the names or values of cells, of each that it changes.
#[derive(Debug, Clone, PartialEq)]
struct CellMistake(Vec<(usize, CellSlip)>);

impl CellMistake {
    /// The cells that it changes.
    fn cells(&self) -> BTreeSet<usize> {
        self.0.iter().map(|(cell, _)| *cell).collect()
    }

    /// What was measured, put right.
    fn corrected(&self, cells: &[CellCompliance]) -> Vec<CellCompliance> {
        let mut out = cells.to_vec();
        for (cell, change) in &self.0 {
            let own = &mut out[*cell];
            match change {
                CellSlip::NameOf(other) => (own.log, own.u) = (cells[*other].log, cells[*other].u),
                CellSlip::DecimalPoint(places) => {
                    own.log += f64::from(*places) * std::f64::consts::LN_10;
                }
            }
        }
        out
    }

    /// How many values of the same cells would be such a mistake too: the nearest of all decimal points counts on either side.
    fn alike(&self) -> f64 {
        let mut changes = self.0.iter();
        if changes.any(|(_, change)| matches!(change, CellSlip::DecimalPoint(_))) {
            2.0
        } else {
            1.0
        }
    }

    /// Each pair has the names of the other.
    fn exchanged(pairs: &[(usize, usize)]) -> Self {
        let both = pairs.iter().flat_map(|(a, b)| [(*a, *b), (*b, *a)]);
        Self(
            both.map(|(cell, other)| (cell, CellSlip::NameOf(other)))
                .collect(),
        )
    }

    /// All that are considered: a pair of cells with a pose or direction in common, all of two poses or two directions; a decimal point of a cell, a
    /// pose, a direction.
    fn all(cells: &[CellCompliance]) -> Vec<Self> {
        let name = |cell: &CellCompliance| [cell.pose, cell.direction.index()];
        let keys = [0, 1].map(|part| {
            let keys = cells.iter().map(|cell| name(cell)[part]);
            keys.collect::<BTreeSet<usize>>()
        });
        let mut out = Vec::new();
        let mut sets: Vec<Vec<usize>> = (0..cells.len()).map(|cell| vec![cell]).collect();
        for part in 0..2 {
            let find = |own: usize, other: usize| {
                let wanted = if part == 0 {
                    [own, other]
                } else {
                    [other, own]
                };
                cells.iter().position(|cell| name(cell) == wanted)
            };
            for a in &keys[part] {
                for b in keys[part].range(a + 1..) {
                    let common = keys[1 - part].iter();
                    let group = common.filter_map(|one| Some((find(*a, *one)?, find(*b, *one)?)));
                    let group: Vec<(usize, usize)> = group.collect();
                    out.extend(group.iter().map(|pair| Self::exchanged(&[*pair])));
                    if group.len() > 1 {
                        out.push(Self::exchanged(&group));
                    }
                }
                let own = (0..cells.len()).filter(|cell| name(&cells[*cell])[part] == *a);
                let own: Vec<usize> = own.collect();
                if own.len() > 1 && 2 * own.len() <= cells.len() {
                    sets.push(own);
                }
            }
        }
        for set in sets {
            out.extend(DECIMAL_PLACES.map(|places| {
                let change = CellSlip::DecimalPoint(places);
                Self(set.iter().map(|cell| (*cell, change)).collect())
            }));
        }
        out
    }
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
    let (cells, places) = measured(baseline, observations, noise)?;
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
        chance_of_any(0.5 * f_upper_tail(ratio, 1.0, dof).unwrap_or(1.0), tried)
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
    let bad = |(cell, change): &(usize, CellSlip)| {
        let (kind, exchanged_with) = match change {
            CellSlip::NameOf(other) => (
                BadReadingKind::Any,
                Some(observations.name_of(places[*other])),
            ),
            CellSlip::DecimalPoint(moved) => (BadReadingKind::DecimalPoint(*moved), None),
        };
        let (place, expected) = (places[*cell], chosen.fit.logs[*cell].exp());
        let u = chosen.corrected[*cell].u * scale.sqrt() * expected;
        let values = [cells[*cell].log.exp(), expected, u];
        let bad = BadRun {
            exchanged_with,
            ..BadRun::new(observations, (place, None), values, p_family, kind)
        };
        (place, bad)
    };
    Ok(chosen.mistake.0.iter().map(bad).collect())
}

/// The fit that leaves least, with one mistake of the model or none.
fn best_fit(
    model: &mut CellComplianceModel<'_>,
    cells: &[CellCompliance],
    start: &CellFit,
) -> Option<(Option<usize>, CellFit)> {
    let all = model.alternatives();
    let fitted = all.filter_map(|suspect| {
        let fit = model.fit(cells, &|_| true, suspect, Some(start))?;
        Some((suspect, fit))
    });
    fitted.min_by(|(_, a), (_, b)| a.squares.total_cmp(&b.squares))
}

/// The compliances of cells that the readings determine, with the places of the cells.
fn measured(
    baseline: &dyn Baseline,
    observations: &Observations,
    noise: &KnownNoise,
) -> Result<(Vec<CellCompliance>, Vec<usize>), MismatchError> {
    let screen = ReadingScreen::new(baseline, observations, noise)?;
    let found = screen.noise_of_all();
    let uncertainties = screen.relative_uncertainties(&found);
    let compliance = |place: usize| screen.compliance[observations.cells[place].readings.start];
    // Across the load a compliance has either sign.
    let mut along: Vec<usize> = (0..observations.cells.len()).collect();
    along.retain(|place| observations.cells[*place].is_along_load());
    // Where most yield against their load, that is the convention of the session.
    let against = along
        .iter()
        .filter(|place| compliance(**place) < 0.0)
        .count();
    let is_convention = 2 * against >= along.len();
    let sign = if is_convention { -1.0 } else { 1.0 };
    let is_usual = |place: &usize| sign * compliance(*place) > 0.0;
    along.retain(|place| is_usual(place) && uncertainties[*place] < LEAST_KNOWN_CELL);
    let cells = along.iter().map(|place| CellCompliance {
        pose: observations.cells[*place].pose,
        direction: observations.cells[*place].axis(),
        log: compliance(*place).abs().ln(),
        u: uncertainties[*place],
    });
    Ok((cells.collect(), along))
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
