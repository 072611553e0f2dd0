//! Values of a table that the others contradict: their repeats where there are any, else the fit to all others.
//!
//! What is farthest off is taken away, and the rest is looked at again, until it is noise: so several bad ones do not hide each other (backward
//! search: Simonoff, Journal of the Royal Statistical Society C 40 (1991), with groups of rows by Cook & Weisberg, Residuals and Influence in
//! Regression, 1982, section 3.2). How rows scatter beside one another is that of the fit; how much they do is what all others show.

use stiffbench_numeric::statistics::f_upper_tail;
use stiffbench_units_and_text::read_axis::ReadAxis;
use stiffbench_units_and_text::test_point::Branch;

use crate::fit::load_cases::fit::fit_load_cases;
use crate::fit::load_cases::posed::PosedLoadCases;
use crate::fit::load_cases::prediction::SeenRows;
use crate::fit::load_cases::problem::{LoadCaseModel, LoadCaseProblem, coordinates};
use crate::fit::load_cases::scatter::{RowScatter, kinds, repeated_rows, sizes, smallest_step};
use crate::fit::{FactorStatus, FitError, FitOptions, FitOutcome};
use crate::mismatch::{BadReading, misread_factor};
use crate::search::constants::{BAD_READING_LEVEL, LEAST_INDEPENDENT, MOST_BAD_READINGS};
use crate::search::{DeletedRows, FittedRows, RowVector, chance_of_any, up_to_last_bad};

use super::bad_positions::{AGREES, groups_of_positions, other_joint_value};

/// Most bad values of a table: one with more has another fault, which more names would not make plainer.
const MOST: usize = 10;

/// Rows that determine more than this share of their own prediction have no witness (1).
const LARGEST_SHARE: f64 = 0.75;

/// Chance of a value without repeats below which it may be bad (1): far beyond that of a reading, because a model that lacks something
/// leaves residuals that are farther off than noise too.
const LONE_VALUE_LEVEL: f64 = 1e-6;

/// A value stands out where the others look like noise once it is gone: none is so far off that noise does it in fewer tables.
const REST_IS_NOISE: f64 = 0.05;

/// Or it stands alone: so many times as far off as the next, in standard errors. What a model lacks spreads over many values.
const STANDS_ALONE: f64 = 4.0;

/// Degrees of freedom below which a scatter is no measure of anything.
const FEWEST_DOF: f64 = 2.0;

/// Scatter, as a share of the usual size of a component, below which nothing is asked: a simulation without noise has none.
const LEAST_SCATTER: f64 = 1e-9;

/// The values that contradict others, in the order of the table; of absolute positions those that contradict the fit to all others, one after the
/// other.
///
/// # Arguments
/// - `fit`: of the model with these options.
///
/// # Errors
/// [`FitError`]: those of a fit.
pub fn bad_load_case_values(
    model: &LoadCaseModel<'_>,
    options: &FitOptions,
    fit: &FitOutcome,
) -> Result<Vec<BadReading>, FitError> {
    let posed = model.posed;
    let mut bad = Vec::new();
    if !posed.has_positions() {
        bad = contradicted(posed, fit, fit, &fit.residuals());
    }
    if !bad.is_empty() {
        // The model enters where loads differ a little, and where one of two repeats is bad: it is not to be drawn to bad values itself.
        let rows: Vec<usize> = bad.iter().map(|one| one.reading).collect();
        let others = posed.without_rows(&rows);
        let again = fit_load_cases(&model.under(&others), options)?;
        bad = contradicted(posed, fit, &again, &model.left_by(&again)?);
    }
    if bad.is_empty() && options.train.is_none() {
        bad = off_the_fit(model, options, fit)?;
    }
    bad.sort_by_key(|one| one.reading);
    Ok(bad)
}

/// How the rows of a table scatter beside one another.
struct TableScatter {
    /// Standard deviation of each row by the fit, m or rad.
    sd: Vec<f64>,
    /// Least variance of what is left of a row, in units of its own: where the fit leaves less than rounding.
    least_variance: f64,
    /// Values of one application of a load. They count as one against the degrees of freedom: a load that is off shifts them all.
    together: f64,
}

impl TableScatter {
    /// # Arguments
    /// - `fit`: of all rows.
    /// - `good`: of good ones, whose noise it is.
    /// - `least`: standard deviations of displacements and rotations below which nothing is asked.
    fn of(posed: &PosedLoadCases, [fit, good]: [&FitOutcome; 2], least: [f64; 2]) -> Option<Self> {
        let positions = posed.has_positions();
        let axes: Vec<ReadAxis> = SeenRows::of(posed, None)
            .iter()
            .map(|row| row.axis)
            .collect();
        let mut sd = fit
            .scatter
            .as_ref()?
            .sd_under(good.scatter.as_ref()?, &axes);
        let mut least_variance = 0.0;
        for (sd, kind) in sd.iter_mut().zip(kinds(posed)) {
            if positions {
                // They scatter alike.
                *sd = 1.0;
            } else if *sd <= least[kind] {
                (*sd, least_variance) = (least[kind], 1.0);
            }
        }
        Some(Self {
            sd,
            least_variance,
            together: if positions {
                1.0
            } else {
                posed.component_count() as f64 / posed.cases.len().max(1) as f64
            },
        })
    }
}

/// What is left of rows, and which of them may be off together.
struct Left {
    /// As of [`TableScatter`].
    least_variance: f64,
    together: f64,
    /// Places of the rows among all.
    places: Vec<usize>,
    /// Each over its standard deviation.
    fitted: FittedRows,
    /// By their places among these rows.
    groups: Vec<Vec<usize>>,
}

/// Rows that are off together.
struct OffGroup {
    /// By their places among all rows.
    rows: Vec<usize>,
    deleted: DeletedRows,
    /// Variance of the others, in units of their own.
    variance: f64,
    /// Chance that noise takes any group as far.
    p: f64,
}

impl OffGroup {
    /// Squares of a row.
    fn mean_square(&self) -> f64 {
        self.deleted.squares / self.rows.len() as f64
    }
}

impl Left {
    /// Variance of the rows, if some squares of it are those of others, and its degrees of freedom.
    fn scatter_beside(&self, squares: f64, rows: usize) -> Option<(f64, f64)> {
        let dof = self.fitted.dof_without(rows)?;
        let variance = (self.fitted.squares() - squares).max(f64::MIN_POSITIVE) / dof;
        let variance = variance.max(self.least_variance);
        (dof >= FEWEST_DOF).then_some((variance, dof / self.together.max(1.0)))
    }

    /// Chance that noise takes any group as far as one of so many rows.
    fn chance(&self, mean_square: f64, rows: usize, (variance, dof): (f64, f64)) -> f64 {
        let p = f_upper_tail(mean_square / variance, rows as f64, dof).unwrap_or(1.0);
        chance_of_any(p, self.groups.len() as f64)
    }

    /// The group that is farther off than any other for its size; `None` if none has a witness.
    fn farthest(&self) -> Option<OffGroup> {
        let (n, whole) = (self.places.len() as f64, self.fitted.squares());
        let tested = self.groups.iter().filter_map(|rows| {
            let deleted = self.fitted.without(rows, LARGEST_SHARE)?;
            let rest = self.scatter_beside(deleted.squares, rows.len())?;
            let mut group = OffGroup {
                rows: rows.iter().map(|row| self.places[*row]).collect(),
                deleted,
                variance: rest.0,
                p: 1.0,
            };
            group.p = self.chance(group.mean_square(), rows.len(), rest);
            // Information criterion of Schwarz, Annals of Statistics 6 (1978): so many numbers more say so much more.
            let left = (whole - group.deleted.squares).max(f64::MIN_POSITIVE);
            let score = n * (left / whole).ln() + rows.len() as f64 * n.ln();
            Some((score, group))
        });
        let farthest = tested.min_by(|a, b| a.0.total_cmp(&b.0));
        farthest.map(|(_, group)| group)
    }
}

/// The rows of each load that was applied again.
fn repeats(posed: &PosedLoadCases) -> Vec<Vec<usize>> {
    let mut repeats = repeated_rows(posed);
    repeats.retain(|rows| rows.len() > 1);
    repeats
}

/// Values that their repeats contradict; none where these do not scatter.
///
/// # Arguments
/// - `fit`: of all rows.
/// - `good`: of good rows, which says how these scatter.
/// - `residuals`: what a model leaves of all rows.
fn contradicted(
    posed: &PosedLoadCases,
    fit: &FitOutcome,
    good: &FitOutcome,
    residuals: &[f64],
) -> Vec<BadReading> {
    let (kinds, mut groups) = (kinds(posed), repeats(posed));
    // Two readings of one value differ by a step that neither is meant to show: the variance of rounding is the least.
    let mut steps = [f64::INFINITY; 2];
    let values: Vec<f64> = posed.rows().map(|(_, read)| read.value).collect();
    for rows in &groups {
        let step = &mut steps[kinds[rows[0]]];
        *step = step.min(smallest_step(rows.iter().map(|row| values[*row])));
    }
    let sizes = sizes(posed);
    let least = [0, 1].map(|kind| {
        let step = Some(steps[kind]).filter(|step| step.is_finite());
        f64::max(
            step.unwrap_or(0.0) / 12_f64.sqrt(),
            LEAST_SCATTER * sizes[kind],
        )
    });
    let Some(scatter) = TableScatter::of(posed, [fit, good], least) else {
        return Vec::new();
    };
    let repeated: usize = groups.iter().map(Vec::len).sum();
    let most = ((MOST_BAD_READINGS * repeated as f64).ceil() as usize).min(MOST);
    let taken = up_to_last_bad(most, BAD_READING_LEVEL, |_| {
        let farthest = among_repeats(&groups, residuals, &scatter).farthest()?;
        let row = *farthest.rows.first()?;
        let own = groups.iter_mut().find(|rows| rows.contains(&row))?;
        own.retain(|other| *other != row);
        let lines = own.iter().filter_map(|other| posed.rows().nth(*other));
        let repeats = lines.map(|(case, _)| case.line).collect();
        groups.retain(|rows| rows.len() > 1);
        let off = *farthest.deleted.sizes.first()? * scatter.sd[row];
        let bad = bad_values(posed, &farthest, &scatter, |_| off).next()?;
        Some((BadReading { repeats, ..bad }, farthest.p))
    });
    taken.into_iter().map(|(bad, _)| bad).collect()
}

/// The rows of each load beside one another.
///
/// # Arguments
/// - `groups`: the rows of each load.
fn among_repeats(groups: &[Vec<usize>], residuals: &[f64], scatter: &TableScatter) -> Left {
    let places = groups.concat();
    let left = |row: &usize| residuals[*row] / scatter.sd[*row];
    let mut fitted = FittedRows::new(places.iter().map(left).collect());
    let mut suspects = Vec::new();
    let mut first = 0;
    for own in groups {
        let values = own.iter().map(|row| scatter.sd[*row].recip()).collect();
        fitted.set_free(RowVector { first, values }, 0.0);
        let far = |place: &usize| residuals[own[*place]].abs();
        let all = 0..own.len();
        // Two repeats have one difference: of them the one that is farther from the model may be bad.
        let farther = all.clone().rev().max_by(|a, b| far(a).total_cmp(&far(b)));
        let is_suspect = |place: &usize| own.len() > 2 || Some(*place) == farther;
        let own_suspects = all.filter(is_suspect).map(|place| vec![first + place]);
        suspects.extend(own_suspects);
        first += own.len();
    }
    Left {
        least_variance: scatter.least_variance,
        together: scatter.together,
        places,
        fitted,
        groups: suspects,
    }
}

/// Values that the fit to all others contradicts, taken away one after the other: of positions those of a target or a pose together, else one without
/// repeats.
///
/// # Errors
/// [`FitError`]: those of a fit.
fn off_the_fit(
    model: &LoadCaseModel<'_>,
    options: &FitOptions,
    fit: &FitOutcome,
) -> Result<Vec<BadReading>, FitError> {
    let posed = model.posed;
    let least = sizes(posed).map(|size| LEAST_SCATTER * size);
    let Some(mut scatter) = TableScatter::of(posed, [fit, fit], least) else {
        return Ok(Vec::new());
    };
    let all = 0..posed.component_count();
    let (groups, most) = if posed.has_positions() {
        (groups_of_positions(posed), MOST)
    } else {
        let repeated = repeats(posed).concat();
        let lone = all.clone().filter(|row| !repeated.contains(row));
        (lone.map(|row| vec![row]).collect(), 1)
    };
    if groups.is_empty() {
        return Ok(Vec::new());
    }
    let mut taken: Vec<OffGroup> = Vec::new();
    let places: Vec<usize> = all.clone().collect();
    let mut left = beside_fit((model, options, fit), &scatter, places, &groups)?;
    let mut last = fit.clone();
    // How far off the next is that is not taken, squares of it a row.
    let mut next = 0.0;
    while let Some(farthest) = left.farthest()
        && farthest.p <= REST_IS_NOISE
    {
        if taken.len() == most {
            next = farthest.mean_square();
            break;
        }
        taken.push(farthest);
        let rows: Vec<usize> = taken.iter().flat_map(|one| one.rows.clone()).collect();
        let others = posed.without_rows(&rows);
        let others = model.under(&others);
        // Not enough are left, or they show no parameter any more.
        let Ok(again) = fit_load_cases(&others, options) else {
            taken.pop();
            break;
        };
        // It is not to be drawn to bad values in how rows scatter either.
        scatter = TableScatter::of(posed, [fit, &again], least).unwrap_or(scatter);
        let places = all.clone().filter(|row| !rows.contains(row)).collect();
        left = beside_fit((&others, options, &again), &scatter, places, &groups)?;
        last = again;
    }
    // What is left is noise, or those stand alone: what a model lacks spreads over many.
    if next > 0.0 {
        let sizes = taken.iter().map(OffGroup::mean_square);
        let sizes: Vec<f64> = sizes.chain([next]).collect();
        let stands = |pair: &[f64]| pair[0] >= STANDS_ALONE * STANDS_ALONE * pair[1];
        let count = sizes.windows(2).rposition(stands);
        taken.truncate(count.map_or(0, |place| place + 1));
    }
    let Some(rest) = left.scatter_beside(0.0, 0) else {
        return Ok(Vec::new());
    };
    let left_m = model.left_by(&last)?;
    for one in &mut taken {
        // How a lone value scatters is known better than when it was taken away.
        if let (1, [row], [of_itself]) = (most, &one.rows[..], &one.deleted.variances[..]) {
            one.deleted.squares = (left_m[*row] / scatter.sd[*row]).powi(2) / of_itself;
        }
        one.variance = rest.0;
        one.p = left.chance(one.mean_square(), one.rows.len(), rest);
    }
    taken.retain(|one| one.p <= LONE_VALUE_LEVEL);
    let mut bad = Vec::new();
    for group in &taken {
        let sd_m = rest.0.sqrt() * scatter.sd[group.rows[0]];
        let joint = other_joint_value(model, &last, &group.rows, sd_m);
        let own = bad_values(posed, group, &scatter, |row| left_m[row]);
        let mut own: Vec<BadReading> = own.collect();
        // One coordinate may have hidden in a group as long as it drew the fit to itself.
        let is_off = |one: &BadReading| (one.value_m - one.expected_m).abs() > AGREES * one.u_m;
        if own.iter().filter(|one| is_off(one)).count() == 1 {
            own.retain(is_off);
        }
        bad.extend(own.into_iter().map(|one| BadReading {
            joint: joint.clone(),
            ..one
        }));
    }
    Ok(bad)
}

/// What a fit leaves of its rows, beside what it may make of them at no bound.
///
/// # Arguments
/// - `places`: of the rows of the fit among all.
/// - `groups`: by their places among all; of those whose rows are there the chance counts.
///
/// # Errors
/// [`FitError`] for a structure that carries nothing.
fn beside_fit(
    (model, options, fit): (&LoadCaseModel<'_>, &FitOptions, &FitOutcome),
    scatter: &TableScatter,
    places: Vec<usize>,
    groups: &[Vec<usize>],
) -> Result<Left, FitError> {
    // Frames that fit the rigid robot nearly best are near enough to those of the fit: rotations between them are small.
    let tracker = model.tracker()?;
    let tracker = tracker.as_ref();
    let (parameters, _) = model.parameters(&options.choice, tracker)?;
    let set = coordinates(&parameters, tracker)?;
    let plain = RowScatter::plain(model.posed, model.steps, [1.0; 2]);
    let mut problem = LoadCaseProblem::new(*model, &parameters, plain, tracker)?;
    let mut point = parameters.coordinates(&fit.factors);
    point.resize(set.parameters().len(), 0.0);
    let columns = problem.linear_columns(&point)?;
    let white = |values: &[f64]| -> Vec<f64> {
        let values = values.iter().zip(&places);
        values
            .map(|(value, row)| value / scatter.sd[*row])
            .collect()
    };
    let mut fitted = FittedRows::new(white(&fit.residuals()));
    for &place in set.free_indices() {
        let own = fit.estimates.get(place);
        if !own.is_some_and(|own| matches!(own.status, FactorStatus::AtBound { .. })) {
            fitted.set_free(white(&columns[place]).into(), LEAST_INDEPENDENT);
        }
    }
    let here = |rows: &Vec<usize>| {
        let rows = rows.iter().filter_map(|row| places.binary_search(row).ok());
        let rows: Vec<usize> = rows.collect();
        (!rows.is_empty()).then_some(rows)
    };
    let mut groups: Vec<Vec<usize>> = groups.iter().filter_map(here).collect();
    groups.sort();
    groups.dedup();
    Ok(Left {
        least_variance: scatter.least_variance,
        together: scatter.together,
        places,
        fitted,
        groups,
    })
}

/// The values of a group, each with by how much it is off, m or rad, and the chance that noise takes any as far.
fn bad_values<'b>(
    posed: &'b PosedLoadCases,
    group: &'b OffGroup,
    scatter: &'b TableScatter,
    off: impl Fn(usize) -> f64 + 'b,
) -> impl Iterator<Item = BadReading> + 'b {
    let rows = group.rows.iter().zip(&group.deleted.variances);
    rows.filter_map(move |(&row, of_itself)| {
        let (case, read) = posed.rows().nth(row)?;
        let expected_m = read.value - off(row);
        let u_m = (group.variance * of_itself).sqrt() * scatter.sd[row];
        Some(BadReading {
            reading: row,
            line: case.line,
            pose: posed.labels[case.label].clone(),
            direction: read.axis(),
            quantity: read.quantity(),
            load: None,
            repeat: case.repeat,
            step: 1,
            branch: Branch::Loading,
            is_last: false,
            repeats: Vec::new(),
            value_m: read.value,
            expected_m,
            u_m,
            p_family: group.p,
            factor: misread_factor(read.value, expected_m, u_m),
            joint: None,
        })
    })
}
