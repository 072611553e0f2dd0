//! What agrees with the robot once the table is put right: readings of a pose or a component in another unit, with another decimal point or
//! sign, or under the name of others; a joint whose values have the other sign.

use std::collections::HashMap;

use schemars::JsonSchema;
use serde::Serialize;

use stiffbench_numeric::least_squares::{LeastSquaresSettings, minimise};
use stiffbench_units_and_text::test_point::PoseId;

use crate::fit::{FitError, FitOptions, FitOutcome};
use crate::mismatch::{
    Exchanged, FoundMistake, MisreadValues, NamedValue, ValueChange, ValueFit, ValueName,
    ValueScale, find_mistake,
};
use crate::search::constants::MOST_OF_THE_MISFIT;

use super::moved_columns::{moved_columns, moves, plain_sd};
use crate::fit::load_cases::fit::fit_load_cases;
use crate::fit::load_cases::posed::{COMPONENTS, PosedLoadCases};
use crate::fit::load_cases::problem::LoadCaseModel;
use crate::fit::load_cases::scatter::{RowScatter, SAME_LOAD, kinds};
use crate::fit::load_cases::white_rows::LinearRows;

/// Values of which a common factor can be seen: two agree with any line by chance.
const FEWEST: usize = 3;

/// Share of the squares of all readings below which too little is left for a joint to have the other sign (1): then a tenth of every reading is
/// not left.
const LEFT_BY_A_SIGN: f64 = 0.01;

/// What a table has wrong, if it agrees with the robot once that is put right.
#[derive(Debug, Clone, PartialEq, Default, Serialize, JsonSchema)]
pub struct TableMistake {
    /// The pose; `null` in all poses.
    pub pose: Option<PoseId>,
    /// The component; `null` of all components of a pose.
    pub component: Option<&'static str>,
    /// What readings, or values of a joint, must be multiplied by: a power of ten, a factor between units, or -1; `null` of what is exchanged.
    pub factor: Option<f64>,
    /// The component, or the pose, with which it is exchanged.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub exchanged_with: Option<ExchangedWith>,
    /// The variable of the robot whose values have the other sign.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint: Option<String>,
}

/// What readings were exchanged with.
#[derive(Debug, Clone, PartialEq, Serialize, JsonSchema)]
#[serde(untagged)]
pub enum ExchangedWith {
    /// Those of another component.
    Component(&'static str),
    /// Those of another pose.
    Pose(PoseId),
}

/// The mistake of a table that explains its misfit, if there is one.
///
/// None is sought of absolute positions, beside held-out poses, and where factors of beams are free.
///
/// # Errors
/// [`FitError`].
pub fn table_mistake(
    model: &LoadCaseModel<'_>,
    options: &FitOptions,
    fit: &FitOutcome,
) -> Result<Option<TableMistake>, FitError> {
    let mut free = fit.estimates.iter();
    let bends = free.any(|one| one.parameter.is_factor() && moves(&one.status));
    if model.posed.has_positions() || options.train.is_some() || bends {
        return Ok(None);
    }
    let mut rows = MisreadRows::new(model, fit, fit.residuals())?;
    if rows.changes.is_empty() {
        return Ok(None);
    }
    let found = find_mistake(&mut rows);
    let left = found.as_ref().map(|found| found.fit.squares);
    let sign = other_sign(model, options, fit, &rows);
    Ok(match sign {
        Some((after, sign)) if left.is_none_or(|left| after < left) => Some(sign),
        _ => found.map(|found| named(model.posed, &found)),
    })
}

/// A mistake by the names of the table.
fn named(posed: &PosedLoadCases, found: &FoundMistake) -> TableMistake {
    let mistake = &found.mistake;
    TableMistake {
        pose: mistake.pose.map(|pose| posed.labels[pose].clone()),
        component: mistake.component.map(|component| COMPONENTS[component]),
        factor: match mistake.changes.first() {
            Some((_, ValueChange::Times(factor))) => Some(*factor),
            _ => None,
        },
        exchanged_with: mistake.exchanged_with.map(|with| match with {
            Exchanged::Component(component) => ExchangedWith::Component(COMPONENTS[component]),
            Exchanged::Pose(pose) => ExchangedWith::Pose(posed.labels[pose].clone()),
        }),
        joint: None,
    }
}

/// The readings of a table, and what the values of a fit and changes of them make of these.
struct MisreadRows {
    names: Vec<ValueName>,
    /// m and rad.
    read: Vec<NamedValue>,
    /// What the values of the fit leave of them.
    residuals: Vec<f64>,
    /// The column of each parameter that moves, with the smallest and largest change of its value that the bounds allow.
    changes: Vec<(Vec<f64>, [f64; 2])>,
    /// The scatter of each kind of rows without a part that grows with the load: a mistake of the table must not pass for it.
    scatter: RowScatter,
    has_repeats: bool,
}

impl MisreadRows {
    /// # Arguments
    /// - `residuals`: what the values of the fit leave in the poses of the model.
    ///
    /// # Errors
    /// [`FitError`] for a structure that carries nothing.
    fn new(
        model: &LoadCaseModel<'_>,
        fit: &FitOutcome,
        residuals: Vec<f64>,
    ) -> Result<Self, FitError> {
        let posed = model.posed;
        let (places, columns) = moved_columns(model, fit, moves)?;
        let changes = places.into_iter().zip(columns).map(|(place, column)| {
            let one = &fit.estimates[place];
            let bounds = one.bounds.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            (column, bounds.map(|end| end - one.value))
        });
        let sd = plain_sd(posed, fit);
        let read = posed
            .rows()
            .zip(kinds(posed))
            .map(|((_, read), kind)| NamedValue {
                value: read.value,
                u: sd[kind],
            });
        let scatter = RowScatter::plain(posed, model.steps, sd);
        Ok(Self {
            names: names(posed),
            read: read.collect(),
            residuals,
            changes: changes.collect(),
            has_repeats: scatter.series.has_repeats(),
            scatter,
        })
    }
}

/// The name of each reading. A load has the same number in every pose that carries it.
fn names(posed: &PosedLoadCases) -> Vec<ValueName> {
    let (mut loads, mut applied) = (HashMap::new(), HashMap::new());
    let all = posed.cases.iter().flat_map(|case| {
        let largest = case
            .load
            .iter()
            .fold(0.0, |all: f64, one| all.max(one.abs()));
        let rounded = case
            .load
            .map(|one| (one / (SAME_LOAD * largest)).round() as i64);
        let size = (largest.ln() / SAME_LOAD).round() as i64;
        let next = loads.len();
        let load = *loads.entry((rounded, size)).or_insert(next);
        let times = applied.entry((case.label, load)).or_insert(0_usize);
        *times += 1;
        let load = load + posed.cases.len() * (*times - 1);
        case.components.iter().map(move |read| ValueName {
            pose: case.label,
            component: read.component,
            kind: usize::from(read.is_rotation()),
            load,
        })
    });
    all.collect()
}

impl MisreadValues for MisreadRows {
    fn names(&self) -> &[ValueName] {
        &self.names
    }

    fn values(&self) -> &[NamedValue] {
        &self.read
    }

    fn scale(&self) -> ValueScale {
        ValueScale::Linear
    }

    fn fewest(&self) -> usize {
        FEWEST
    }

    fn free(&self) -> usize {
        self.changes.len()
    }

    fn alternatives(&self) -> usize {
        0
    }

    fn least_variance(&self) -> f64 {
        f64::from(u8::from(self.has_repeats))
    }

    fn fit(
        &mut self,
        values: &[NamedValue],
        keep: &dyn Fn(usize) -> bool,
        _alternative: Option<usize>,
        _start: Option<&ValueFit>,
    ) -> Option<ValueFit> {
        let rows = values.iter().zip(&self.read).zip(&self.residuals);
        let rows: Vec<f64> = rows
            .map(|((right, read), left)| left + right.value - read.value)
            .collect();
        let scatter = self.scatter.without(|row| !keep(row));
        let (mut problem, set) = LinearRows::new(&rows, &self.changes, scatter).ok()?;
        let fit = minimise(&mut problem, &set, &LeastSquaresSettings::default()).ok()?;
        let left = rows.iter().zip(problem.at(&fit.values));
        let predicted = values.iter().zip(left);
        let columns = self.changes.iter().map(|(column, _)| {
            let rows = column.iter().zip(values);
            rows.map(|(change, value)| change / value.u).collect()
        });
        Some(ValueFit {
            squares: fit.sum_of_squares(),
            predicted: predicted
                .map(|(value, (row, at))| value.value - row + at)
                .collect(),
            columns: columns.collect(),
            parameters: Vec::new(),
        })
    }
}

/// The joint whose values have the other sign, with the squares that a fit leaves then; only where much is left, and where the linear structure
/// at the values of the fit explains it.
fn other_sign(
    model: &LoadCaseModel<'_>,
    options: &FitOptions,
    fit: &FitOutcome,
    rows: &MisreadRows,
) -> Option<(f64, TableMistake)> {
    let scatter = &rows.scatter;
    let before = scatter.squares(&rows.residuals);
    if before < LEFT_BY_A_SIGN * scatter.squares(&model.measured()) {
        return None;
    }
    let explains = |after: f64| after < (1.0 - MOST_OF_THE_MISFIT) * before;
    let variables = model.robot.variables.iter().enumerate();
    let moving = variables.filter(|(variable, _)| model.robot.moves_tool(*variable));
    let found = moving.filter_map(|(variable, named)| {
        let posed = model.posed.with_other_sign(variable)?;
        let mirrored = model.under(&posed);
        // Poses that cannot be reached are none that the robot stood in.
        let left = mirrored.left_by(fit).ok()?;
        let mut there = MisreadRows::new(&mirrored, fit, left).ok()?;
        let read = there.read.clone();
        let nearly = there.fit(&read, &|_| true, None, None)?;
        if !explains(nearly.squares) {
            return None;
        }
        let fit = fit_load_cases(&mirrored, options).ok()?;
        let mistake = TableMistake {
            factor: Some(-1.0),
            joint: Some(named.name.clone()),
            ..TableMistake::default()
        };
        Some((scatter.squares(&fit.residuals()), mistake))
    });
    let found = found.filter(|(after, _)| explains(*after));
    found.min_by(|a, b| a.0.total_cmp(&b.0))
}
