//! What agrees with the robot once the table is put right: readings of a pose or a component in another unit, with another decimal point or
//! sign, or under the name of others; a joint whose values have the other sign.

use std::borrow::Cow;

use std::collections::HashMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_numeric::least_squares::{ParameterSet, minimise};
use stiffbench_units_and_text::test_point::PoseId;

use crate::fit::{FitError, FitOptions, FitOutcome};
use crate::mismatch::{
    Exchanged, FoundMistake, MisreadValues, NamedValue, ValueChange, ValueFit, ValueName,
    ValueScale, find_mistake,
};
use crate::search::constants::MOST_OF_THE_MISFIT;

use super::moved_columns::plain_sd;
use crate::fit::load_cases::posed::{COMPONENTS, PosedLoadCases};
use crate::fit::load_cases::problem::{LoadCaseModel, LoadCaseProblem, coordinates};
use crate::fit::load_cases::scatter::{RowScatter, SAME_LOAD, kinds};
use crate::fit::weighed_problem::WeighedProblem;

/// Values of which a common factor can be seen: two agree with any line by chance.
const FEWEST: usize = 3;

/// Share of the squares of all readings below which too little is left for a joint to have the other sign (1): then a tenth of every reading is
/// not left.
const LEFT_BY_A_SIGN: f64 = 0.01;

/// What a table has wrong, if it agrees with the robot once that is put right.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize, JsonSchema)]
pub struct TableMistake {
    /// The pose; `null` in all poses.
    pub pose: Option<PoseId>,
    /// The component; `null` of all components of a pose.
    pub component: Option<Cow<'static, str>>,
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
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum ExchangedWith {
    /// Those of another component.
    Component(Cow<'static, str>),
    /// Those of another pose.
    Pose(PoseId),
}

/// The mistake of a table that explains its misfit, if there is one.
///
/// None is sought of absolute positions and beside held-out poses.
///
/// # Errors
/// [`FitError`].
pub fn table_mistake(
    model: &LoadCaseModel<'_>,
    options: &FitOptions,
    fit: &FitOutcome,
) -> Result<Option<TableMistake>, FitError> {
    if model.posed.has_positions() || options.train.is_some() {
        return Ok(None);
    }
    let mut rows = MisreadRows::new(model, options, fit)?;
    if rows.set.free_indices().is_empty() {
        return Ok(None);
    }
    let found = find_mistake(&mut rows);
    let left = found.as_ref().map(|found| found.fit.squares);
    let sign = other_sign(model, options, fit, &mut rows);
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
        component: mistake
            .component
            .map(|component| COMPONENTS[component].into()),
        factor: match mistake.changes.first() {
            Some((_, ValueChange::Times(factor))) => Some(*factor),
            _ => None,
        },
        exchanged_with: mistake.exchanged_with.map(|with| match with {
            Exchanged::Component(component) => {
                ExchangedWith::Component(COMPONENTS[component].into())
            }
            Exchanged::Pose(pose) => ExchangedWith::Pose(posed.labels[pose].clone()),
        }),
        joint: None,
    }
}

/// The readings of a table with the model that is fitted to them.
struct MisreadRows<'a> {
    names: Vec<ValueName>,
    /// m and rad.
    read: Vec<NamedValue>,
    /// Under the scatter of each kind of rows without a part that grows with the load: a mistake of the table must not pass for it.
    problem: LoadCaseProblem<'a>,
    /// The coordinates, from where the parameters start: a mistake may have drawn a fit far away.
    set: ParameterSet,
    has_repeats: bool,
}

impl<'a> MisreadRows<'a> {
    /// # Arguments
    /// - `fit`: of the model with these options.
    ///
    /// # Errors
    /// [`FitError`] for a structure that carries nothing.
    fn new(
        model: &LoadCaseModel<'a>,
        options: &FitOptions,
        fit: &FitOutcome,
    ) -> Result<Self, FitError> {
        let posed = model.posed;
        let sd = plain_sd(posed, fit);
        let read = posed.rows().zip(kinds(posed));
        let read = read.map(|((_, read), kind)| NamedValue {
            value: read.value,
            u: sd[kind],
        });
        let scatter = RowScatter::plain(posed, model.steps, sd);
        let parameters = model.parameters(&options.choice, None)?.0;
        Ok(Self {
            names: names(posed),
            read: read.collect(),
            set: coordinates(&parameters, None)?,
            has_repeats: scatter.series.has_repeats(),
            problem: LoadCaseProblem::new(*model, &parameters, scatter, None)?,
        })
    }

    /// Whether a fit leaves so much that it may have taken a mistake for its parameters.
    fn leaves_much(&self, fit: &ValueFit) -> bool {
        let squares: f64 = self
            .read
            .iter()
            .map(|one| (one.value / one.u).powi(2))
            .sum();
        fit.squares >= LEFT_BY_A_SIGN * squares
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

impl MisreadValues for MisreadRows<'_> {
    fn names(&self) -> &[ValueName] {
        &self.names
    }

    fn values(&self) -> &[NamedValue] {
        &self.read
    }

    fn scale(&self) -> ValueScale {
        ValueScale::Linear
    }

    fn may_be_drawn(&self, as_recorded: &ValueFit) -> bool {
        !self.problem.is_linear() && self.leaves_much(as_recorded)
    }

    fn fewest(&self) -> usize {
        FEWEST
    }

    fn free(&self) -> usize {
        self.set.free_indices().len()
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
        let problem = &mut self.problem;
        problem.set_measured(values.iter().map(|one| one.value));
        problem.leave_out(&|row| !keep(row));
        let settings = problem.settings();
        let fit = minimise(problem, &self.set, &settings).ok()?;
        let columns = (0..self.set.free_indices().len()).filter_map(|one| fit.jacobian_column(one));
        Some(ValueFit {
            squares: fit.sum_of_squares(),
            columns: columns.map(<[f64]>::to_vec).collect(),
            predicted: problem.predictions(&fit.values).ok()?,
            parameters: Vec::new(),
        })
    }
}

/// The joint whose values have the other sign, with the squares that a fit leaves then; only where much is left, and where the other sign explains
/// it.
fn other_sign(
    model: &LoadCaseModel<'_>,
    options: &FitOptions,
    fit: &FitOutcome,
    rows: &mut MisreadRows<'_>,
) -> Option<(f64, TableMistake)> {
    let read = rows.read.clone();
    let before = rows.fit(&read, &|_| true, None, None)?;
    if !rows.leaves_much(&before) {
        return None;
    }
    let variables = model.robot.variables.iter().enumerate();
    let moving = variables.filter(|(variable, _)| model.robot.moves_tool(*variable));
    let found = moving.filter_map(|(variable, named)| {
        let posed = model.posed.with_other_sign(variable)?;
        // Poses that cannot be reached are none that the robot stood in.
        let mut there = MisreadRows::new(&model.under(&posed), options, fit).ok()?;
        let after = there.fit(&read, &|_| true, None, None)?.squares;
        let mistake = TableMistake {
            factor: Some(-1.0),
            joint: Some(named.name.clone()),
            ..TableMistake::default()
        };
        Some((after, mistake))
    });
    let explains = |after: f64| after < (1.0 - MOST_OF_THE_MISFIT) * before.squares;
    let found = found.filter(|(after, _)| explains(*after));
    found.min_by(|a, b| a.0.total_cmp(&b.0))
}
