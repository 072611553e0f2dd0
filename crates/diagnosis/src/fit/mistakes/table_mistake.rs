//! What agrees with the robot once the table is put right: readings of a pose or a component in another unit, with another decimal point or
//! sign, or under the name of others; a joint whose values have the other sign; positions in another unit, or along left-handed axes.

use std::borrow::Cow;
use std::collections::{BTreeSet, HashMap};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_numeric::least_squares::{ParameterSet, minimise};
use stiffbench_units_and_text::test_point::PoseId;

use crate::fit::{FitError, FitOptions, FitOutcome};
use crate::mismatch::{
    Exchanged, FoundMistake, NamedValue, RecordedValues, ValueChange, ValueFit, ValueModel,
    ValueName, ValueScale, find_mistake, usual_factors_of_lengths,
};
use crate::search::constants::{MOST_OF_THE_MISFIT, STRONG_EVIDENCE};
use crate::search::norm;

use super::moved_columns::plain_sd;
use crate::fit::load_cases::posed::{COMPONENTS, PosedLoadCases};
use crate::fit::load_cases::prediction::SeenRows;
use crate::fit::load_cases::problem::{LoadCaseModel, LoadCaseProblem, coordinates};
use crate::fit::load_cases::scatter::{RowScatter, SAME_LOAD, kinds};
use crate::fit::weighed_problem::WeighedProblem;

/// Values of which a common factor can be seen: two agree with any line by chance.
const FEWEST: usize = 3;

/// Share of the squares of all readings below which too little is left for a joint to have the other sign (1): then a tenth of every reading is
/// not left.
const LEFT_BY_A_SIGN: f64 = 0.01;

/// The same of positions: a thousandth of what they extend over is not left. Where the tool does not turn, a tool point far away takes much of a mistake.
const LEFT_OF_POSITIONS: f64 = 1e-6;

/// How many times as much the rigid robot may leave of positions as of those that it leaves least of, for them to be fitted with springs (1): sag is a
/// small part of what another mistake leaves. By judgement.
const AS_WELL: f64 = 3.0;

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
    /// Whether positions are mirrored: two coordinates are exchanged, or one has the other sign. Base frames turn either into the other.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub mirrored: bool,
    /// The variable of the robot whose values have the other sign; of mirrored positions, that which would explain them as well.
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
/// None is sought beside held-out poses. Positions of single poses are for [`bad_load_case_values`](super::bad_load_case_values).
///
/// # Errors
/// [`FitError`].
pub fn table_mistake(
    model: &LoadCaseModel<'_>,
    options: &FitOptions,
    fit: &FitOutcome,
) -> Result<Option<TableMistake>, FitError> {
    if options.train.is_some() {
        return Ok(None);
    }
    let (read, mut rows) = MisreadRows::new(model, options, fit)?;
    if rows.set.free_indices().is_empty() {
        return Ok(None);
    }
    let has_positions = model.posed.has_positions();
    let found = (!has_positions).then(|| find_mistake(&read, &mut rows));
    let found = found.flatten();
    let left = found.as_ref().map(|found| found.fit.squares);
    let whole = whole_table(model, options, fit, (&read.values, &mut rows));
    Ok(match whole {
        Some((after, mistake)) if left.is_none_or(|left| after < left) => Some(mistake),
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
        ..TableMistake::default()
    }
}

/// The model that is fitted to the readings of a table.
struct MisreadRows<'a> {
    /// Under the scatter of each kind of rows without a part that grows with the load: a mistake of the table must not pass for it.
    problem: LoadCaseProblem<'a>,
    /// The coordinates, from where the parameters start: a mistake may have drawn a fit far away.
    set: ParameterSet,
}

impl<'a> MisreadRows<'a> {
    /// # Arguments
    /// - `fit`: of the model with these options.
    ///
    /// # Returns
    /// The readings, m and rad, beside it.
    ///
    /// # Errors
    /// [`FitError`] for a structure that carries nothing.
    fn new(
        model: &LoadCaseModel<'a>,
        options: &FitOptions,
        fit: &FitOutcome,
    ) -> Result<(RecordedValues, Self), FitError> {
        let posed = model.posed;
        let sd = plain_sd(posed, fit);
        let read = posed.rows().zip(kinds(posed));
        let read = read.map(|((_, read), kind)| NamedValue {
            value: read.value,
            u: sd[kind],
        });
        let scatter = RowScatter::plain(posed, model.steps, sd);
        let tracker = model.tracker()?;
        let parameters = model.parameters(&options.choice, tracker.as_ref())?.0;
        let recorded = RecordedValues {
            names: names(posed),
            values: read.collect(),
            scale: ValueScale::Linear,
            fewest: FEWEST,
            least_variance: f64::from(u8::from(scatter.series.has_repeats())),
        };
        let rows = Self {
            set: coordinates(&parameters, tracker.as_ref())?,
            problem: LoadCaseProblem::new(*model, &parameters, scatter, tracker.as_ref())?,
        };
        Ok((recorded, rows))
    }

    /// Whether a fit leaves so much that it may have taken a mistake for its parameters.
    fn leaves_much(&self, read: &[NamedValue], fit: &ValueFit) -> bool {
        let posed = self.problem.posed();
        // Where a tracker stands is no part of what a robot does.
        let mut means: HashMap<usize, (f64, f64)> = HashMap::new();
        for (_, read) in posed.rows().filter(|(_, read)| read.is_position()) {
            let (sum, count) = means.entry(read.component).or_default();
            (*sum, *count) = (*sum + read.value, *count + 1.0);
        }
        let squares = read.iter().zip(posed.rows()).map(|(one, (_, read))| {
            let mean = means.get(&read.component);
            let mean = mean.map_or(0.0, |(sum, count)| sum / count);
            ((one.value - mean) / one.u).powi(2)
        });
        let least = if means.is_empty() {
            LEFT_BY_A_SIGN
        } else {
            LEFT_OF_POSITIONS
        };
        fit.squares >= least * squares.sum::<f64>()
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

impl ValueModel for MisreadRows<'_> {
    fn free(&self) -> usize {
        self.set.free_indices().len()
    }

    fn may_be_drawn(&self, read: &[NamedValue], as_recorded: &ValueFit) -> bool {
        !self.problem.is_linear() && self.leaves_much(read, as_recorded)
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

/// What may be wrong with a whole table.
struct WholeChange {
    mistake: TableMistake,
    /// The table put right.
    posed: PosedLoadCases,
    /// How many times as long its readings are, on average of their logarithms.
    longer: f64,
}

impl WholeChange {
    /// All that are considered: the other sign of a joint; of positions another unit or decimal point of all or of one coordinate, and axes that
    /// are left-handed.
    fn all(model: &LoadCaseModel<'_>) -> Vec<Self> {
        let (robot, posed) = (model.robot, model.posed);
        let variables = robot.variables.iter().enumerate();
        let moving = variables.filter(|(variable, _)| robot.moves_tool(*variable));
        let signs = moving.filter_map(|(variable, named)| {
            Some(Self {
                mistake: TableMistake {
                    factor: Some(-1.0),
                    joint: Some(named.name.clone()),
                    ..TableMistake::default()
                },
                posed: posed.with_other_sign(variable)?,
                longer: 1.0,
            })
        });
        let mut all: Vec<Self> = signs.collect();
        if !posed.has_positions() {
            return all;
        }
        let read: BTreeSet<usize> = posed.rows().map(|(_, read)| read.component).collect();
        let rows = posed.component_count() as f64;
        let sets = std::iter::once(None).chain(read.into_iter().map(Some));
        for (component, factor) in
            sets.flat_map(|one| usual_factors_of_lengths().map(move |by| (one, by)))
        {
            // One coordinate with the other sign is what all with the other sign are, turned.
            if factor < 0.0 && component.is_some() {
                continue;
            }
            let changed = posed.with_components_times(component, factor);
            let count = posed
                .rows()
                .filter(|(_, read)| component.is_none_or(|own| own == read.component));
            all.push(Self {
                mistake: TableMistake {
                    component: component.map(|own| COMPONENTS[own].into()),
                    factor: Some(factor),
                    mirrored: factor < 0.0,
                    ..TableMistake::default()
                },
                posed: changed,
                longer: factor.abs().powf(count.count() as f64 / rows),
            });
        }
        all
    }

    /// Of positions those with which the rigid robot agrees about as well as with any, else all.
    fn likely(model: &LoadCaseModel<'_>) -> Vec<Self> {
        let all = Self::all(model);
        if !model.posed.has_positions() {
            return all;
        }
        let rigid = all.into_iter().filter_map(|change| {
            let model = model.under(&change.posed);
            let seen = SeenRows::of(&change.posed, model.tracker().ok()?.as_ref());
            let left = norm(&seen.left_by_rigid_robot(&model.measured())) / change.longer;
            Some((left, change))
        });
        let rigid: Vec<(f64, Self)> = rigid.collect();
        let least = rigid.iter().map(|(left, _)| *left);
        let most = AS_WELL * least.fold(f64::INFINITY, f64::min);
        let likely = rigid.into_iter().filter(|(left, _)| *left <= most);
        likely.map(|(_, change)| change).collect()
    }
}

/// What is wrong with a whole table, with the squares that a fit leaves then; only where much is left, and where it explains that.
fn whole_table(
    model: &LoadCaseModel<'_>,
    options: &FitOptions,
    fit: &FitOutcome,
    (read, rows): (&[NamedValue], &mut MisreadRows<'_>),
) -> Option<(f64, TableMistake)> {
    let before = rows.fit(read, &|_| true, None, None)?;
    if !rows.leaves_much(read, &before) {
        return None;
    }
    let tried = WholeChange::likely(model).into_iter().filter_map(|change| {
        // Poses that cannot be reached are none that the robot stood in.
        let there = MisreadRows::new(&model.under(&change.posed), options, fit);
        let (right, mut rows) = there.ok()?;
        let after = rows.fit(&right.values, &|_| true, None, None)?.squares;
        // In the unit of what was recorded.
        Some((after / (change.longer * change.longer), change.mistake))
    });
    let explains = |after: f64| after < (1.0 - MOST_OF_THE_MISFIT) * before.squares;
    let mut found: Vec<_> = tried.filter(|(after, _)| explains(*after)).collect();
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let dof = (read.len().saturating_sub(rows.free())).max(1) as f64;
    let (least, _) = *found.first()?;
    found.retain(|(after, _)| dof * (after / least).ln() <= 2.0 * STRONG_EVIDENCE);
    // An arm without lateral offsets is its own mirror image with its first joint turned the other way.
    let place = found.iter().position(|(_, one)| one.mirrored);
    let (after, mut mistake) = found.swap_remove(place.unwrap_or(0));
    if mistake.mirrored {
        mistake.joint = found.into_iter().find_map(|(_, other)| other.joint);
    }
    Some((after, mistake))
}
