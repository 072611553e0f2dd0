//! A fit with the poses solved at its values: what a mistake of the table is compared with.

use stiffbench_beams::robot::ModelParameter;

use crate::elastostatics::compliances::{ComplianceSolver, EndCompliance, motion_along};
use crate::elastostatics::error::LoadCaseFitError;
use crate::elastostatics::outcome::LoadCaseFit;
use crate::elastostatics::posed::{PosedLoad, PosedLoadCases, ReadComponent};
use crate::elastostatics::problem::{LoadCaseModel, unit_length, unloaded_springs};
use crate::fit::FactorStatus;
use crate::search::constants::LEAST_INDEPENDENT;
use crate::search::{dot, push_orthonormal};

/// What the candidates are tried beside.
pub(super) struct Basis {
    pub(super) baseline: LoadCaseFit,
    pub(super) residuals: Vec<f64>,
    /// Places of the free parameters among the estimates.
    pub(super) free: Vec<usize>,
    /// One column for each of them.
    pub(super) columns: Vec<Vec<f64>>,
}

impl Basis {
    /// That of a fit, with the poses solved at its values.
    ///
    /// # Errors
    /// [`LoadCaseFitError`] for a structure that carries nothing.
    pub(super) fn of(
        model: &LoadCaseModel<'_>,
        fit: &LoadCaseFit,
    ) -> Result<Self, LoadCaseFitError> {
        Self::with_residuals(model, fit, fit.residuals())
    }

    /// That of the same values in other poses.
    ///
    /// # Errors
    /// As [`Basis::of`].
    pub(super) fn in_poses_of(
        model: &LoadCaseModel<'_>,
        fit: &LoadCaseFit,
    ) -> Result<Self, LoadCaseFitError> {
        let start = &fit.factors;
        let predicted = LoadCaseModel { start, ..*model }.predicted()?;
        let rows = model.measured().into_iter().zip(predicted);
        let residuals = rows.map(|(read, predicted)| read - predicted);
        Self::with_residuals(model, fit, residuals.collect())
    }

    fn with_residuals(
        model: &LoadCaseModel<'_>,
        fit: &LoadCaseFit,
        residuals: Vec<f64>,
    ) -> Result<Self, LoadCaseFitError> {
        let solved = solve(model, fit)?;
        let (free, columns) = baseline_columns(&solved, fit);
        Ok(Self {
            residuals,
            baseline: fit.clone(),
            free,
            columns,
        })
    }

    /// The columns of the free parameters, each with the smallest and largest change of its value that the bounds allow.
    pub(super) fn changes(&self) -> Vec<(&[f64], [f64; 2])> {
        let free = self.free.iter().zip(&self.columns);
        free.map(|(&place, column)| {
            let one = &self.baseline.estimates[place];
            let bounds = one.bounds.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            let change = |end: f64| {
                if one.parameter.is_factor() {
                    (end / one.value).ln()
                } else {
                    end - one.value
                }
            };
            (column.as_slice(), bounds.map(change))
        })
        .collect()
    }
}

/// The compliance of every pose with its derivatives to the parameters of a robot.
pub(super) struct SolvedPoses<'a> {
    /// The load cases.
    pub(super) posed: &'a PosedLoadCases,
    /// Compliance of the end by pose.
    pub(super) compliance: Vec<EndCompliance>,
    /// The parameters.
    pub(super) parameters: Vec<ModelParameter>,
    /// Derivative by pose and parameter.
    pub(super) derivatives: Vec<Vec<EndCompliance>>,
}

impl SolvedPoses<'_> {
    /// A column from what each row gives.
    fn column(&self, of: &dyn Fn(&PosedLoad, &ReadComponent) -> f64) -> Vec<f64> {
        self.posed
            .rows()
            .map(|(case, read)| of(case, read))
            .collect()
    }

    /// The column of a parameter.
    pub(super) fn of_parameter(&self, place: usize) -> Vec<f64> {
        self.column(&|case, read| {
            motion_along(&self.derivatives[case.pose][place], &read.unit, &case.load)
        })
    }

    /// Which parameters are springs that no load acts on: nothing can be missing there that a reading shows.
    pub(super) fn unloaded(&self) -> Vec<bool> {
        let places = 0..self.parameters.len();
        let columns = places.map(|place| self.of_parameter(place));
        let lengths: Vec<f64> = columns.map(|column| dot(&column, &column).sqrt()).collect();
        unloaded_springs(&self.parameters, &lengths, unit_length(self.posed))
    }
}

/// Whether a parameter is a column of the baseline: also one at a bound, which what is missing may have driven there.
pub(super) fn moves(status: &FactorStatus) -> bool {
    matches!(
        status,
        FactorStatus::Free | FactorStatus::NotIdentified { .. } | FactorStatus::AtBound { .. }
    )
}

/// Compliances of all poses at the fitted values, with their derivatives to every spring and factor of the robot.
fn solve<'a>(
    model: &LoadCaseModel<'a>,
    baseline: &LoadCaseFit,
) -> Result<SolvedPoses<'a>, LoadCaseFitError> {
    let (robot, mechanism) = (model.robot, model.mechanism);
    let in_fit = |parameter: &ModelParameter| {
        let estimate = baseline
            .estimates
            .iter()
            .find(|one| one.parameter == *parameter);
        estimate.is_some_and(|one| moves(&one.status))
    };
    let parameters: Vec<ModelParameter> = ModelParameter::all(robot, mechanism)
        .into_iter()
        .filter(|one| !one.is_factor() || in_fit(one))
        .collect();
    let factors = &baseline.factors;
    let mut solver = ComplianceSolver::new(robot, mechanism, &parameters, factors)?;
    let mut solved = SolvedPoses {
        posed: model.posed,
        compliance: Vec::new(),
        derivatives: Vec::new(),
        parameters: Vec::new(),
    };
    for pose in &model.posed.poses {
        let found = solver.solve(pose, factors, true, false)?;
        solved.compliance.push(found.compliance);
        solved.derivatives.push(found.derivatives);
    }
    solved.parameters = parameters;
    Ok(solved)
}

/// Places of the free parameters among the estimates, and their columns; those that the ones before contain are left out, and springs that no
/// load acts on.
fn baseline_columns(
    solved: &SolvedPoses<'_>,
    baseline: &LoadCaseFit,
) -> (Vec<usize>, Vec<Vec<f64>>) {
    let (mut free, mut columns) = (Vec::new(), Vec::new());
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let unloaded = solved.unloaded();
    for (place, one) in baseline.estimates.iter().enumerate() {
        let mut known = solved.parameters.iter();
        let Some(parameter) = known.position(|known| *known == one.parameter) else {
            continue;
        };
        if !moves(&one.status) || unloaded[parameter] {
            continue;
        }
        let column = solved.of_parameter(parameter);
        let before = basis.len();
        push_orthonormal(&mut basis, column.clone(), LEAST_INDEPENDENT, 0.0);
        if basis.len() > before {
            free.push(place);
            columns.push(column);
        }
    }
    (free, columns)
}
