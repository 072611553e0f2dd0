//! Load cases as a least-squares problem.

use stiffbench_beams::physics::{ActingPhysics, Mechanics, PlaceScale};
use stiffbench_beams::robot::{
    FittingFactors, GRAVITY_M_PER_S2, JointModel, Mechanism, MechanismModel, ModelParameter, Robot,
    RobotError, Theory, TrackedPoses,
};
use stiffbench_numeric::least_squares::{
    EvaluationFailure, JacobianView, LeastSquaresError, LeastSquaresSettings, Parameter,
    ParameterSet, ResidualFunction,
};

use crate::fit::parameters::FitParameters;
use crate::fit::weighed_problem::WeighedProblem;
use crate::fit::{FitError, FitOutcome};
use crate::mismatch::{GaugeSteps, ReadForces};
use crate::parameters::{FitRole, ParameterChoice, UNLOADED};
use crate::search::norm;

use super::frames::{
    frame_columns, frame_parameters, lengths_beside, moved_tracker, nearest_tracker,
};
use super::posed::PosedLoadCases;
use super::prediction::{AddedByLaws, PredictedMotions, SeenRows, ToolMotion};
use super::scatter::RowScatter;

/// Difference to a linear model, as a share of the largest displacement, below which a model is linear: rounding of stiff links is far below.
const NOT_LINEAR: f64 = 1e-6;

/// A robot with values to begin at, and the load cases that it was measured under.
#[derive(Debug, Clone, Copy)]
pub struct LoadCaseModel<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// Its mechanism.
    pub mechanism: &'a Mechanism,
    /// Values of the parameters; springs without one are rigid.
    pub start: &'a FittingFactors,
    /// The load cases.
    pub posed: &'a PosedLoadCases,
    /// Steps of the gauges.
    pub steps: GaugeSteps,
    /// What acts beside the linear structure, held fixed.
    pub physics: Option<&'a ActingPhysics>,
}

/// Residuals of all components: predicted less measured, white by the scatter of the load cases.
#[derive(Debug)]
pub(in crate::fit) struct LoadCaseProblem<'a> {
    model: LoadCaseModel<'a>,
    mechanics: Mechanics<'a>,
    parameters: FitParameters,
    measured: Vec<f64>,
    /// How all rows scatter, and those that take part.
    scatter: RowScatter,
    used: RowScatter,
    /// Where motions are linear in the coordinates of the parameters: motions and columns at all coordinates zero.
    linear: Option<PredictedMotions>,
    /// Of absolute positions: the tracker, whose coordinates follow those of the parameters.
    tracker: Option<TrackedPoses>,
    added: Option<AddedByLaws<'a>>,
}

/// Half the difference of coordinates over which what laws add is differentiated (1): central differences keep nine digits of the ten that a
/// solution has, less four.
const COORDINATE_STEP: f64 = 1e-4;

impl<'a> LoadCaseModel<'a> {
    /// What the values and frames of a fit leave of every row, also of those that it did not have: measured less predicted, m and rad, in the
    /// order of [`PosedLoadCases::rows`].
    ///
    /// # Errors
    /// [`FitError`] for a pose that cannot be reached, or a structure that carries nothing.
    pub(in crate::fit) fn left_by(&self, fit: &FitOutcome) -> Result<Vec<f64>, FitError> {
        let (start, posed) = (&fit.factors, self.posed);
        let mut mechanics = LoadCaseModel { start, ..*self }.mechanics(&[])?;
        let frames = fit.frames.as_ref().map(|fitted| fitted.frames);
        let tracker = frames
            .map(|frames| TrackedPoses::new(self.robot, self.mechanism, &posed.poses, frames));
        let seen = SeenRows::of(posed, tracker.transpose()?.as_ref());
        let mut rows = seen.read(&PredictedMotions::of(&mechanics, posed, false).values);
        if let Some(mut added) = AddedByLaws::of(self) {
            add(&mut rows, &added.rows(&mut mechanics, start, &seen)?);
        }
        let rows = self.measured().into_iter().zip(rows);
        Ok(rows.map(|(read, predicted)| read - predicted).collect())
    }

    /// The same robot under other load cases.
    pub(in crate::fit) fn under<'b>(&'b self, posed: &'b PosedLoadCases) -> LoadCaseModel<'b> {
        LoadCaseModel { posed, ..*self }
    }

    /// The mechanism in its poses with the values of the start, under own weight where positions were read.
    ///
    /// # Arguments
    /// - `parameters`: to which its motions are differentiated; springs among them may be rigid.
    ///
    /// # Errors
    /// [`RobotError`] for a pose that cannot be reached, or in which the structure carries nothing.
    pub(in crate::fit) fn mechanics(
        &self,
        parameters: &[ModelParameter],
    ) -> Result<Mechanics<'a>, RobotError> {
        let (robot, mechanism, poses) = (self.robot, self.mechanism, &self.posed.poses);
        let mut mechanics = Mechanics::rigid_with(robot, mechanism, parameters, self.start, poses)?;
        if !parameters.is_empty() {
            mechanics.differentiate_whole()?;
        }
        if self.posed.has_positions() {
            mechanics.weigh(parameters)?;
        }
        Ok(mechanics)
    }

    /// The tools as a tracker sees them whose frames fit the rigid robot nearly best; `None` without positions.
    ///
    /// # Errors
    /// As of [`nearest_tracker`].
    pub(in crate::fit) fn tracker(&self) -> Result<Option<TrackedPoses>, FitError> {
        nearest_tracker(self.robot, self.mechanism, self.posed)
    }

    /// What was measured, in the order of the rows.
    pub(in crate::fit) fn measured(&self) -> Vec<f64> {
        self.posed.rows().map(|(_, read)| read.value).collect()
    }

    /// The coordinates of a fit: springs in units of the compliance that would give by itself all that was measured, beside positions what
    /// the rigid robot leaves; and the free springs on which no load acts, which are kept.
    ///
    /// # Errors
    /// [`FitError`] for a pose, structure, tie or bounds that cannot be.
    pub(in crate::fit) fn parameters(
        &self,
        choice: &ParameterChoice,
        tracker: Option<&TrackedPoses>,
    ) -> Result<(FitParameters, Vec<ModelParameter>), FitError> {
        let list = choice.parameters();
        let springs: Vec<ModelParameter> =
            list.into_iter().filter(|one| !one.is_factor()).collect();
        let posed = self.posed;
        let motions = PredictedMotions::of(&self.mechanics(&springs)?, posed, true);
        let seen = SeenRows::of(posed, tracker);
        let columns = motions.columns.iter();
        let columns: Vec<Vec<f64>> = columns.map(|column| seen.changed(column)).collect();
        let lengths: Vec<f64> = columns.iter().map(|column| norm(column)).collect();
        let measured = norm(&seen.left_by_rigid_robot(&self.measured()));
        let rigid = vec![[0.0; 6]; posed.cases.len()];
        let by_frames = tracker.map(|tracker| frame_columns(posed, tracker, &[], &rigid));
        let beside = lengths_beside(&by_frames.unwrap_or_default(), &columns);
        let scale = |parameter: &ModelParameter| {
            let place = springs.iter().position(|spring| spring == parameter);
            let own = place.map_or(0.0, |place| {
                if beside[place] > UNLOADED * lengths[place] {
                    beside[place]
                } else {
                    lengths[place]
                }
            });
            PlaceScale {
                compliance: if own > 0.0 { measured / own } else { 0.0 },
                ..PlaceScale::default()
            }
        };
        let mut choice = choice.clone();
        let mut unloaded = Vec::new();
        let is_unloaded = unloaded_springs(&springs, &lengths, unit_length(self)?);
        for (spring, is_unloaded) in springs.iter().zip(is_unloaded) {
            let mut members = choice.members.iter();
            let is_free = members.any(|m| m.parameter == *spring && m.role == FitRole::Free);
            if is_free && is_unloaded {
                choice.set(spring, FitRole::Fixed);
                unloaded.push(spring.clone());
            }
        }
        let parameters = FitParameters::with_scales(self.start, &choice, &scale)?;
        Ok((parameters, unloaded))
    }
}

/// Which parameters are springs that no load acts on: their columns are rounding beside the longest of their unit, or that of a lever of 1 m.
///
/// # Arguments
/// - `lengths`: of the columns of the parameters.
/// - `unit`: length of the column of a spring along every load, which is that of a lever of 1 m too.
pub(in crate::fit) fn unloaded_springs(
    parameters: &[ModelParameter],
    lengths: &[f64],
    unit: f64,
) -> Vec<bool> {
    let longest = |of: &str| {
        let alike = parameters.iter().zip(lengths);
        let alike = alike.filter(|(other, _)| other.unit() == of);
        alike.map(|(_, length)| *length).fold(unit, f64::max)
    };
    let own = parameters.iter().zip(lengths);
    own.map(|(one, length)| !one.is_factor() && *length <= UNLOADED * longest(one.unit()))
        .collect()
}

/// Length of the column of a spring that every load, or own weight where that acts, moves along itself.
///
/// # Errors
/// [`RobotError`] for a pose that cannot be reached.
pub(in crate::fit) fn unit_length(model: &LoadCaseModel<'_>) -> Result<f64, RobotError> {
    let (robot, posed) = (model.robot, model.posed);
    let loads: Vec<ToolMotion> = posed.cases.iter().map(|case| case.load).collect();
    let by_loads = norm(&SeenRows::of(posed, None).changed(&loads));
    let weighed = posed.poses.first().filter(|_| posed.has_positions());
    let Some(pose) = weighed else {
        return Ok(by_loads);
    };
    let (rigid, theory) = (JointModel::Rigid, Theory::EulerBernoulli);
    let mut structure = MechanismModel::new(robot, model.mechanism, &rigid, theory, model.start)?;
    structure.place(pose)?;
    let own_n = GRAVITY_M_PER_S2 * structure.mass_kg();
    Ok(by_loads.max(own_n * (posed.cases.len() as f64).sqrt()))
}

impl<'a> LoadCaseProblem<'a> {
    /// # Errors
    /// [`FitError`] for a pose that cannot be reached or a structure that carries nothing.
    pub(in crate::fit) fn new(
        model: LoadCaseModel<'a>,
        parameters: &FitParameters,
        scatter: RowScatter,
        tracker: Option<&TrackedPoses>,
    ) -> Result<Self, FitError> {
        let list = parameters.parameters();
        let mut mechanics = model.mechanics(list)?;
        let factors_move = list
            .iter()
            .enumerate()
            .any(|(place, one)| one.is_factor() && parameters.moves(place));
        let linear = if factors_move {
            None
        } else {
            linear_motions(&mut mechanics, model.posed, parameters)?
        };
        Ok(Self {
            measured: model.measured(),
            added: AddedByLaws::of(&model),
            parameters: parameters.clone(),
            model,
            mechanics,
            used: scatter.clone(),
            scatter,
            linear,
            tracker: tracker.cloned(),
        })
    }

    /// The load cases.
    pub(in crate::fit) fn posed(&self) -> &'a PosedLoadCases {
        self.model.posed
    }

    /// How rows scatter.
    pub(in crate::fit) fn scatter(&self) -> &RowScatter {
        &self.scatter
    }

    /// From now on rows scatter like this.
    pub(in crate::fit) fn set_scatter(&mut self, scatter: RowScatter) {
        self.used.clone_from(&scatter);
        self.scatter = scatter;
    }

    /// From now on the rows read these values.
    pub(in crate::fit) fn set_measured(&mut self, values: impl Iterator<Item = f64>) {
        self.measured = values.collect();
    }

    /// Predictions at a point of the coordinates.
    ///
    /// # Errors
    /// [`RobotError`].
    pub(in crate::fit) fn predictions(&mut self, point: &[f64]) -> Result<Vec<f64>, RobotError> {
        let motions = self.motions(point, false)?;
        self.rows(point, &motions.values)
    }

    /// What each component of the force along x, y, z of the base moves each row by at a point of the coordinates, m/N; nothing of positions, and of
    /// components that were not read.
    ///
    /// # Errors
    /// [`RobotError`].
    pub(in crate::fit) fn force_components(
        &mut self,
        point: &[f64],
    ) -> Result<Vec<[f64; 3]>, RobotError> {
        let factors = self.parameters.values(point);
        self.mechanics.set_factors_rigid(&factors)?;
        let (posed, is_position) = (self.model.posed, self.tracker.is_some());
        let forces = ReadForces::of(posed.cases.iter().map(|case| case.load));
        let seen = self.seen(point);
        let rows = seen.iter().map(|row| {
            if is_position {
                return [0.0; 3];
            }
            let components = forces.components(posed.cases[row.case].load);
            let pose = self.mechanics.pose(row.pose);
            pose.compliance_by_components(&row.axis, components)
        });
        Ok(rows.collect())
    }

    /// What laws add to the rows; nothing without laws.
    fn added(&mut self, point: &[f64]) -> Result<Option<Vec<f64>>, RobotError> {
        let (factors, seen) = (self.parameters.values(point), self.seen(point));
        let (added, mechanics) = (self.added.as_mut(), &mut self.mechanics);
        added
            .map(|added| added.rows(mechanics, &factors, &seen))
            .transpose()
    }

    /// Adds the derivatives of what laws add to the columns of the parameters.
    fn differentiate_added(
        &mut self,
        point: &[f64],
        columns: &mut [Vec<f64>],
    ) -> Result<(), RobotError> {
        if self.added.is_none() {
            return Ok(());
        }
        for place in 0..self.parameters.parameters().len() {
            if !self.parameters.moves(place) {
                continue;
            }
            let [lowest, _] = self.parameters.bounds(place);
            let ends = [-COORDINATE_STEP, COORDINATE_STEP].map(|step| point[place] + step);
            let ends = ends.map(|end| end.max(lowest));
            let mut at = point.to_vec();
            let mut sides = ends.map(|end| {
                at[place] = end;
                self.added(&at)
            });
            let [Ok(Some(low)), Ok(Some(high))] = &mut sides else {
                for side in sides {
                    side?;
                }
                continue;
            };
            let width = ends[1] - ends[0];
            for (entry, (low, high)) in columns[place].iter_mut().zip(low.iter().zip(high)) {
                *entry += (*high - low) / width;
            }
        }
        Ok(())
    }

    /// Derivatives of all rows to every coordinate at a point, those of what laws add left out.
    ///
    /// # Errors
    /// [`RobotError`].
    pub(in crate::fit) fn linear_columns(
        &mut self,
        point: &[f64],
    ) -> Result<Vec<Vec<f64>>, RobotError> {
        let motions = self.motions(point, true)?;
        Ok(self.columns(point, &motions))
    }

    /// Motions of the tool centre at a point with, where asked for, their derivatives to the coordinates of the parameters.
    fn motions(
        &mut self,
        point: &[f64],
        derivatives: bool,
    ) -> Result<PredictedMotions, RobotError> {
        if let Some(linear) = &self.linear {
            return Ok(PredictedMotions {
                values: linear.at(point),
                columns: Vec::new(),
            });
        }
        let factors = self.parameters.values(point);
        let posed = self.model.posed;
        self.mechanics.set_factors_rigid(&factors)?;
        let mut motions = PredictedMotions::of(&self.mechanics, posed, derivatives);
        by_coordinate(&mut motions, &self.parameters);
        Ok(motions)
    }

    /// Coordinates of the tracker.
    fn of_tracker<'p>(&self, point: &'p [f64]) -> &'p [f64] {
        &point[self.parameters.parameters().len()..]
    }

    /// What the rows read at a point.
    fn seen(&self, point: &[f64]) -> SeenRows {
        let tracker = self.tracker.as_ref();
        let there = tracker.map(|tracker| moved_tracker(tracker, self.of_tracker(point)));
        SeenRows::of(self.model.posed, there.as_ref())
    }

    fn rows(&mut self, point: &[f64], motions: &[ToolMotion]) -> Result<Vec<f64>, RobotError> {
        let mut rows = self.seen(point).read(motions);
        if let Some(added) = self.added(point)? {
            add(&mut rows, &added);
        }
        Ok(rows)
    }

    /// Derivatives of all rows to every coordinate.
    fn columns(&self, point: &[f64], motions: &PredictedMotions) -> Vec<Vec<f64>> {
        let (posed, seen) = (self.model.posed, self.seen(point));
        let changes = self.linear.as_ref().unwrap_or(motions).columns.iter();
        let mut columns: Vec<Vec<f64>> = changes.map(|changes| seen.changed(changes)).collect();
        if let Some(tracker) = &self.tracker {
            let coordinates = self.of_tracker(point);
            columns.extend(frame_columns(posed, tracker, coordinates, &motions.values));
        }
        columns
    }
}

/// All coordinates of a fit: those of the parameters, then those of the frames.
///
/// # Errors
/// [`LeastSquaresError`] if ties go in a circle.
pub(in crate::fit) fn coordinates(
    parameters: &FitParameters,
    tracker: Option<&TrackedPoses>,
) -> Result<ParameterSet, LeastSquaresError> {
    let mut list = parameters.list();
    if tracker.is_some() {
        list.extend(frame_parameters());
    }
    ParameterSet::with_any_number_of_free(list)
}

/// The same with the frames alone free, and every parameter as in the rigid robot.
///
/// # Errors
/// As [`coordinates`].
pub(in crate::fit) fn frames_alone(
    parameters: &FitParameters,
) -> Result<ParameterSet, LeastSquaresError> {
    let list = parameters.list().into_iter();
    let rigid = list.zip(parameters.coordinates_of_rigid());
    let rigid = rigid.map(|(one, coordinate)| Parameter::fixed(one.name, coordinate));
    ParameterSet::new(rigid.chain(frame_parameters()).collect())
}

/// Adds one vector of rows to another.
fn add(rows: &mut [f64], further: &[f64]) {
    for (row, further) in rows.iter_mut().zip(further) {
        *row += further;
    }
}

/// Derivatives to parameters as those to their coordinates.
fn by_coordinate(motions: &mut PredictedMotions, parameters: &FitParameters) {
    for (place, column) in motions.columns.iter_mut().enumerate() {
        let slope = parameters.slope(place);
        for value in column.iter_mut().flatten() {
            *value *= slope;
        }
    }
}

/// Motions at all coordinates zero, and columns; `None` if the model is not linear in the springs, as with those in a closed loop.
fn linear_motions(
    mechanics: &mut Mechanics<'_>,
    posed: &PosedLoadCases,
    parameters: &FitParameters,
) -> Result<Option<PredictedMotions>, RobotError> {
    let mut point = vec![0.0; parameters.parameters().len()];
    mechanics.set_factors_rigid(&parameters.values(&point))?;
    let mut motions = PredictedMotions::of(mechanics, posed, true);
    by_coordinate(&mut motions, parameters);
    // Far from there, all springs at once: whatever is not linear shows.
    for (place, coordinate) in point.iter_mut().enumerate() {
        *coordinate = if parameters.moves(place) { 1.0 } else { 0.0 };
    }
    mechanics.set_factors_rigid(&parameters.values(&point))?;
    let exact = PredictedMotions::of(mechanics, posed, false).values;
    let linear = motions.at(&point);
    let size = exact
        .iter()
        .flatten()
        .fold(0.0_f64, |size, value| size.max(value.abs()));
    let mut pairs = exact.iter().flatten().zip(linear.iter().flatten());
    let is_linear = pairs.all(|(a, b)| (a - b).abs() <= NOT_LINEAR * size);
    Ok(is_linear.then_some(motions))
}

/// White residuals of predictions, and the white columns of their derivatives where they are asked for.
fn fill_white(
    scatter: &RowScatter,
    (predicted, measured): (&[f64], &[f64]),
    residuals: &mut [f64],
    jacobian: Option<&mut JacobianView<'_>>,
    columns: &[Vec<f64>],
) {
    let rows = predicted.iter().zip(measured);
    for (residual, (predicted, measured)) in residuals.iter_mut().zip(rows) {
        *residual = predicted - measured;
    }
    scatter.whiten(residuals);
    let Some(jacobian) = jacobian else { return };
    for (place, derivatives) in columns.iter().enumerate() {
        if let Some(column) = jacobian.column_mut(place) {
            column.copy_from_slice(derivatives);
            scatter.whiten(column);
        }
    }
}

impl ResidualFunction for LoadCaseProblem<'_> {
    fn residual_count(&self) -> usize {
        self.measured.len()
    }

    fn evaluate(
        &mut self,
        parameters: &[f64],
        residuals: &mut [f64],
        jacobian: Option<&mut JacobianView<'_>>,
    ) -> Result<(), EvaluationFailure> {
        let motions = self.motions(parameters, jacobian.is_some());
        let motions = motions.map_err(EvaluationFailure::of_model)?;
        let rows = self.rows(parameters, &motions.values);
        let rows = rows.map_err(EvaluationFailure::of_model)?;
        let columns = jacobian.is_some().then(|| {
            let mut columns = self.columns(parameters, &motions);
            let added = self.differentiate_added(parameters, &mut columns);
            added.map(|()| columns)
        });
        let columns = columns.transpose().map_err(EvaluationFailure::of_model)?;
        let rows = (&rows[..], &self.measured[..]);
        let columns = columns.as_deref().unwrap_or_default();
        fill_white(&self.used, rows, residuals, jacobian, columns);
        Ok(())
    }

    fn label(&self, residual: usize) -> String {
        let posed = self.model.posed;
        posed.rows().nth(residual).map_or_else(
            || format!("residual {residual}"),
            |(case, read)| {
                let (pose, force) = (&posed.labels[case.label], case.force_words());
                format!(
                    "pose {pose}, {force}, repeat {}, {}",
                    case.repeat,
                    read.name()
                )
            },
        )
    }
}

impl WeighedProblem for LoadCaseProblem<'_> {
    fn parameters(&self) -> &FitParameters {
        &self.parameters
    }

    /// Of a model that is linear the end is where double precision ends; else a compliance keeps about nine digits, so that a share of
    /// 1e-10 of ‖r‖² is the least that shows.
    fn settings(&self) -> LeastSquaresSettings {
        if self.is_linear() {
            LeastSquaresSettings::default()
        } else {
            LeastSquaresSettings::for_refits()
        }
    }

    /// Linear but for frames: their rotations are small, and their product with the elastic motions smaller still.
    fn is_linear(&self) -> bool {
        self.linear.is_some() && self.added.is_none()
    }

    fn leave_out(&mut self, is_left_out: &dyn Fn(usize) -> bool) {
        self.used = self.scatter.without(is_left_out);
    }

    fn predict(&mut self, point: &[f64]) -> Result<Vec<f64>, FitError> {
        Ok(self.predictions(point)?)
    }
}

#[cfg(test)]
mod tests;
