//! What a fit found, and what its numbers are worth.

use std::borrow::Cow;
use std::fmt;

use std::collections::BTreeSet;

use indexmap::IndexMap;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_beams::physics::Effect;
use stiffbench_beams::robot::{FittingFactors, Mechanism, ModelParameter, TrackerFrames};
use stiffbench_numeric::least_squares::{
    Bound, ParameterCovariance, ParameterEstimate, ParameterSet, ParameterStatus, SigmaMode,
};
use stiffbench_numeric::statistics::root_mean_square;
use stiffbench_units_and_text::digits::significant;
use stiffbench_units_and_text::quantity::micro;
use stiffbench_units_and_text::test_point::{Cell, Direction, PoseId};

use super::load_cases::scatter::RowScatter;
use super::measured::{MeasuredCell, MeasuredCompliance, MeasuredStiffness, WeightBasis};
use super::parameters::FitParameters;
use super::problem::FitProblem;
use crate::search::Information;

/// A change that is a smaller share of the value is rounding: the parameter did not move.
const UNMOVED: f64 = 1e-9;

/// Ends of two intervals that lie further apart than this share of half the width disagree.
const DISAGREEMENT: f64 = 0.2;

/// How the factors were found.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum FitMethod {
    /// All cells at once, weights from their uncertainties.
    LeastSquares,
    /// The paper's nine steps: pose by pose, factor by factor, by random trials.
    Paper,
}

/// What is known of a parameter besides its value.
#[derive(Debug, Clone, PartialEq)]
pub enum FactorStatus {
    /// Moved by the fit and determined by the data.
    Free,
    /// Kept at its start.
    Fixed,
    /// Kept in proportion to another factor.
    Tied {
        /// The other one.
        to: String,
    },
    /// Ended on a bound: the bound speaks, not the data.
    AtBound {
        /// Whether it is the upper bound.
        upper: bool,
        /// What the data say instead.
        words: String,
    },
    /// The data do not determine it.
    NotIdentified {
        /// What the data say instead.
        words: String,
    },
}

/// A [`FactorStatus`] in a word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum StatusWord {
    /// Moved by the fit and determined by the data.
    Free,
    /// Kept at its start.
    Fixed,
    /// Kept in proportion to another parameter.
    Tied,
    /// Ended on a bound.
    AtBound,
    /// Not determined by the data.
    NotIdentified,
}

impl StatusWord {
    /// As files and JSON have it.
    #[must_use]
    pub fn key(self) -> &'static str {
        match self {
            Self::Free => "free",
            Self::Fixed => "fixed",
            Self::Tied => "tied",
            Self::AtBound => "at_bound",
            Self::NotIdentified => "not_identified",
        }
    }

    /// Whether a fit moves the parameter by itself.
    #[must_use]
    pub fn moves(self) -> bool {
        !matches!(self, Self::Fixed | Self::Tied)
    }
}

impl fmt::Display for StatusWord {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.key().replace('_', " "))
    }
}

impl FactorStatus {
    /// Of a parameter that no reading depends on.
    pub(crate) fn unloaded(parameter: &ModelParameter) -> Self {
        Self::NotIdentified {
            words: parameter.unloaded_words().to_owned(),
        }
    }

    /// The same in a word.
    #[must_use]
    pub fn word(&self) -> StatusWord {
        match self {
            Self::Free => StatusWord::Free,
            Self::Fixed => StatusWord::Fixed,
            Self::Tied { .. } => StatusWord::Tied,
            Self::AtBound { .. } => StatusWord::AtBound,
            Self::NotIdentified { .. } => StatusWord::NotIdentified,
        }
    }

    /// What the data show instead of an interval, if they do not determine the parameter.
    #[must_use]
    pub fn why_open(&self) -> Option<&str> {
        match self {
            Self::AtBound { words, .. } | Self::NotIdentified { words } => Some(words),
            Self::Free | Self::Fixed | Self::Tied { .. } => None,
        }
    }
}

/// One parameter after a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FactorEstimate {
    /// The parameter.
    pub parameter: ModelParameter,
    /// Its name, for example `beam.Iy` or `joint.J2`.
    pub name: String,
    /// Where the fit began.
    pub start: f64,
    /// Where it ended.
    pub value: f64,
    /// 95 % likelihood-ratio interval over all minima; only for factors that the data determine. From the first of its parts to the last.
    pub interval_95: Option<[f64; 2]>,
    /// The separate parts that this interval consists of; empty if it has no gaps.
    pub islands_95: Vec<[f64; 2]>,
    /// Smallest and largest value that the fit could give it; none for one that it does not move.
    pub bounds: Option<[f64; 2]>,
    /// Standard uncertainty from the covariance, in its unit.
    pub standard_uncertainty: Option<f64>,
    /// 95 % interval from the covariance, for comparison.
    pub quadratic_interval_95: Option<[f64; 2]>,
    /// 95 % percentile interval from resampled runs, if asked for.
    pub bootstrap_interval_95: Option<[f64; 2]>,
    /// What is known of it.
    pub status: FactorStatus,
}

impl FactorEstimate {
    /// The value; `None` of a spring that had none before the fit and of which the data say nothing.
    #[must_use]
    pub fn known_value(&self) -> Option<f64> {
        let is_open = matches!(self.status, FactorStatus::NotIdentified { .. });
        let is_unknown = is_open && !self.parameter.is_factor() && self.value == 0.0;
        (!is_unknown).then_some(self.value)
    }

    /// Whether the fit moved it from its start; `None` of one that it may not move, or that ended on a bound.
    #[must_use]
    pub fn moved(&self) -> Option<bool> {
        let may_move = matches!(
            self.status,
            FactorStatus::Free | FactorStatus::NotIdentified { .. }
        );
        let size = self.start.abs().max(self.value.abs());
        may_move.then(|| (self.value - self.start).abs() > UNMOVED * size)
    }

    /// Takes bounds, standard uncertainty and interval from the covariance, and words where there is no interval.
    ///
    /// # Arguments
    /// - `place`: of the parameter among `parameters`; `found`: what the covariance says of its coordinate.
    /// - `data`, `others`: what the cells, and the further parameters, are called.
    pub(crate) fn describe(
        &mut self,
        parameters: &FitParameters,
        place: usize,
        found: &ParameterEstimate,
        [data, others]: [&str; 2],
    ) {
        let scaled = |coordinate: f64| parameters.value(place, coordinate);
        self.bounds = Some(parameters.bounds(place).map(scaled));
        self.standard_uncertainty = found.standard_error.map(|error| {
            let by_coordinate = parameters.slope(place) * error;
            by_coordinate
                * if self.parameter.is_factor() {
                    self.value
                } else {
                    1.0
                }
        });
        self.quadratic_interval_95 = found.interval_95.map(|interval| interval.map(scaled));
        match found.status {
            ParameterStatus::AtBound(bound) => {
                let upper = bound == Bound::Upper;
                let side = if upper { "upper" } else { "lower" };
                // Zero only of a spring.
                let words = if scaled(found.value) == 0.0 {
                    format!("zero fits best: these {data} show no compliance")
                } else {
                    format!(
                        "the data push it beyond its {side} bound; the {others} hold for this value, and it has no uncertainty unless you widen the bound"
                    )
                };
                self.status = FactorStatus::AtBound { upper, words };
            }
            ParameterStatus::NotIdentified { .. } => {
                self.status = FactorStatus::NotIdentified {
                    words: format!("any value fits equally well with suitable values of {others}"),
                };
            }
            _ => {}
        }
    }

    /// A warning where the likelihood does not support the interval of the covariance; `None` where both agree or there is no such interval.
    pub(crate) fn disagreement(&self) -> Option<String> {
        let quadratic = self.quadratic_interval_95?;
        let name = &self.name;
        let by_covariance = format!("the covariance gives {} (95 %)", interval_words(quadratic));
        let Some([lower, upper]) = self.interval_95 else {
            let is_open = matches!(self.status, FactorStatus::NotIdentified { .. });
            return is_open.then(|| {
                format!(
                    "{name}: {by_covariance}, but the profile likelihood has no such interval: do not use its standard error"
                )
            });
        };
        // The covariance is that of ln a of a factor and of the compliance of a spring.
        let coordinates = |interval: [f64; 2]| {
            let is_factor = self.parameter.is_factor();
            interval.map(|end| if is_factor { end.ln() } else { end })
        };
        let [from, to] = coordinates(quadratic);
        let ends = coordinates([lower, upper]);
        let shift = (ends[0] - from).abs().max((ends[1] - to).abs());
        let differs = shift > DISAGREEMENT * 0.5 * (to - from) || !self.islands_95.is_empty();
        differs.then(|| {
            format!(
                "{name}: {by_covariance}, the profile likelihood {}: do not use its standard error, use the interval of the likelihood",
                interval_words([lower, upper])
            )
        })
    }

    /// The parts of the 95 % interval, or the interval itself; empty without one.
    #[must_use]
    pub fn parts_95(&self) -> Vec<[f64; 2]> {
        if self.islands_95.is_empty() {
            Vec::from_iter(self.interval_95)
        } else {
            self.islands_95.clone()
        }
    }
}

/// The ends of an interval with four digits, in powers of ten where that is shorter.
fn interval_words(ends: [f64; 2]) -> String {
    let [low, high] = ends.map(|end| significant(end, 4));
    format!("{low} to {high}")
}

/// One cell after a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedCell {
    /// Pose and direction.
    pub cell: Cell,
    /// Measured stiffness, N/m.
    pub measured_n_per_m: f64,
    /// Combined standard uncertainty of ln K measured, if known.
    pub ln_uncertainty: Option<f64>,
    /// Stiffness from the fitted factors, N/m.
    pub predicted_n_per_m: f64,
    /// Whether its pose took no part in the fit.
    pub held_out: bool,
    /// Stiffness predicted by a fit without this pose, N/m, when poses were left out in turn.
    pub predicted_without_its_pose_n_per_m: Option<f64>,
}

/// A measured compliance along another axis than that of the load, beside the model's.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedCompliance {
    /// Pose, axis and load.
    pub cell: Cell,
    /// Measured, m/N.
    pub measured_m_per_n: f64,
    /// Standard uncertainty of it, calibration included, m/N.
    pub u_m_per_n: f64,
    /// From the fitted parameters, m/N.
    pub predicted_m_per_n: f64,
}

impl FittedCell {
    /// Predicted over measured, percent.
    #[must_use]
    pub fn ratio_percent(&self) -> f64 {
        100.0 * self.predicted_n_per_m / self.measured_n_per_m
    }

    /// The prediction by which the model is assessed: that of a fit which did not know the pose, if there is one.
    #[must_use]
    pub fn judged_n_per_m(&self) -> f64 {
        self.predicted_without_its_pose_n_per_m
            .unwrap_or(self.predicted_n_per_m)
    }

    /// |predicted/measured - 1| of the assessed prediction, percent.
    #[must_use]
    pub fn error_percent(&self) -> f64 {
        100.0 * (self.judged_n_per_m() / self.measured_n_per_m - 1.0).abs()
    }
}

/// A component with what the model says of it.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedComponent {
    /// Line of the table.
    pub line: u32,
    /// The pose.
    pub pose: PoseId,
    /// n-th application of the load.
    pub repeat: u32,
    /// Its name, for example `displacement x`.
    pub component: &'static str,
    /// Whether it is a rotation, rad; else a displacement, m.
    pub is_rotation: bool,
    /// Whether it is an absolute position, m.
    pub is_position: bool,
    /// Its axis among the stated ones, of a position among those of the tracker.
    pub axis: Direction,
    /// What was read, m or rad.
    pub measured: f64,
    /// What the rigid robot predicts, m or rad; of positions with frames of its own.
    pub rigid: f64,
    /// What the model of the start predicts, m or rad; of positions the same as the rigid robot.
    pub before: f64,
    /// What the fitted model predicts, m or rad.
    pub predicted: f64,
    /// What a fit without this pose predicts, m or rad.
    pub without_its_pose: Option<f64>,
    /// Whether its pose took no part in the fit.
    pub held_out: bool,
}

impl FittedComponent {
    /// Predicted less measured, m or rad, by a fit that did not know the pose; `None` without one.
    fn unseen_error(&self) -> Option<f64> {
        let predicted = self.held_out.then_some(self.predicted);
        Some(self.without_its_pose.or(predicted)? - self.measured)
    }
}

/// Root mean square errors of the displacements of a pose, m, in JSON um.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct PoseError {
    /// The pose.
    pub pose: PoseId,
    /// Of the rigid robot: fitted springs without compliance, fitted factors 1; of positions with frames of its own.
    #[serde(
        rename = "rigid_um",
        serialize_with = "micro::serialize",
        deserialize_with = "micro::deserialize"
    )]
    pub rigid_m: f64,
    /// Of the model with the values that the fit began at; of positions that of the rigid robot.
    #[serde(
        rename = "before_um",
        serialize_with = "micro::serialize",
        deserialize_with = "micro::deserialize"
    )]
    pub before_m: f64,
    /// Of the fitted model.
    #[serde(
        rename = "fitted_um",
        serialize_with = "micro::serialize",
        deserialize_with = "micro::deserialize"
    )]
    pub fitted_m: f64,
    /// Of a fit without this pose.
    #[serde(
        rename = "unseen_um",
        serialize_with = "micro::serialize",
        deserialize_with = "micro::deserialize"
    )]
    pub without_its_pose_m: Option<f64>,
}

/// Base frame and tool point, fitted to absolute positions beside the springs.
#[derive(Debug, Clone, PartialEq)]
pub struct FittedFrames {
    /// Where the tracker stands, and which point of the tool it measures.
    pub frames: TrackerFrames,
    /// Those that fit the rigid robot best, the same springs rigid.
    pub rigid: TrackerFrames,
    /// Position of the base (m), its rotation about the axes of the tracker (rad), and the point of the tool (m), each along three axes.
    pub parameters: [FrameParameter; 9],
    /// Root mean square error of the rigid robot with its own frames in poses that its fit did not know, m.
    pub rigid_unseen_m: Option<f64>,
}

/// How well one of the nine parameters of the frames is known.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "FrameParameterReport")]
pub struct FrameParameter {
    /// Its name: `base_frame.x`, `base_frame.rx` (about the axes of the tracker), `tool_point.x`.
    pub name: Cow<'static, str>,
    /// `um` or `urad`.
    pub unit: Cow<'static, str>,
    /// Standard error, m or rad, in JSON in `unit`; `null` where the poses do not determine it.
    #[serde(
        rename = "se",
        serialize_with = "micro::serialize",
        deserialize_with = "micro::deserialize"
    )]
    pub standard_error: Option<f64>,
    /// Half of its 95 % interval, m or rad, in JSON in `unit`.
    #[serde(
        serialize_with = "micro::serialize",
        deserialize_with = "micro::deserialize"
    )]
    pub half_width_95: Option<f64>,
}

/// Correlations of the factors the data determine.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FactorCorrelations {
    /// Names, in the order of rows and columns.
    pub names: Vec<String>,
    /// Correlation coefficients of ln a of factors and of the compliance of springs, row by row.
    pub matrix: Vec<Vec<f64>>,
    /// Standard uncertainties of ln a of factors, 1, and of the compliance of springs, rad/(N·m).
    pub u_ln: Vec<f64>,
    /// Covariance of the same quantities, row by row.
    pub covariance: Vec<Vec<f64>>,
    /// Degrees of freedom of the uncertainties; absent where they are without limit.
    pub dof: Option<f64>,
}

impl FactorCorrelations {
    /// Those of the coordinates that the data determine, the ones behind the parameters as they are.
    pub(crate) fn of(
        parameters: &FitParameters,
        set: &ParameterSet,
        covariance: &ParameterCovariance,
    ) -> Self {
        let free = set.free_indices().iter().copied();
        let known: Vec<usize> = free.filter(|&i| covariance.of(i, i).is_some()).collect();
        let entry = |a: usize, b: usize| {
            let same = f64::from(u8::from(a == b));
            covariance.correlation(a, b).unwrap_or(same)
        };
        let uncertainty = |&place: &usize| {
            let own = place < parameters.parameters().len();
            let slope = if own { parameters.slope(place) } else { 1.0 };
            slope * covariance.of(place, place).unwrap_or_default().sqrt()
        };
        let names = known.iter().map(|&i| set.parameters()[i].name.clone());
        let row = |&a: &usize| known.iter().map(|&b| entry(a, b)).collect();
        let matrix: Vec<Vec<f64>> = known.iter().map(row).collect();
        let u_ln: Vec<f64> = known.iter().map(uncertainty).collect();
        let scaled = |(rhos, u): (&Vec<f64>, &f64)| {
            let others = rhos.iter().zip(&u_ln);
            others.map(|(rho, other)| rho * u * other).collect()
        };
        let dof = covariance.interval_dof;
        Self {
            covariance: matrix.iter().zip(&u_ln).map(scaled).collect(),
            names: names.collect(),
            matrix,
            u_ln,
            dof: dof.is_finite().then_some(dof),
        }
    }
}

/// How well the fitted model agrees with what it was fitted to.
#[derive(Debug, Clone, PartialEq)]
pub struct FitAgreement {
    /// Where the standard deviation of the residuals comes from.
    pub sigma: SigmaMode,
    /// Where the weights come from.
    pub basis: WeightBasis,
    /// Standard deviations of displacements, m, and of rotations, rad, beside what a load scatters by; none of what was not read, and of cells.
    pub component_sd: [Option<f64>; 2],
    /// Residuals less determined factors.
    pub dof: usize,
    /// Sum of squared residuals over `dof`; with known uncertainties 1 is expected.
    pub reduced_chi_squared: Option<f64>,
    /// Probability of a sum of squares at least as large if the model and the uncertainties are right; only with known uncertainties.
    pub p_value: Option<f64>,
    /// Rank of the Jacobian: number of independent combinations of parameters that the cells determine.
    pub rank: usize,
    /// Number of parameters that were to be determined: free and not on a bound.
    pub free: usize,
    /// Largest over smallest singular value of the Jacobian with columns of unit length; infinite if the smallest is zero.
    pub condition: f64,
    /// Combinations of parameters that the cells do not determine, in words.
    pub not_determined: Vec<String>,
}

/// How a bootstrap drew.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
pub struct BootstrapDraws {
    /// What was drawn anew: `runs` within their cell, or whole `cells`.
    pub over: Cow<'static, str>,
    /// How often.
    pub replicates: usize,
    /// Refits that failed or did not converge.
    pub failed: usize,
    /// Seed of the draws.
    pub seed: u64,
}

/// The result of a fit.
#[derive(Debug, Clone, PartialEq)]
pub struct FitOutcome {
    /// How the factors were found.
    pub method: FitMethod,
    /// The mechanism that was fitted.
    pub mechanism: String,
    /// What acted beside the beams, held fixed.
    pub physics: Vec<Effect>,
    /// Fitted factors.
    pub factors: FittingFactors,
    /// One entry a parameter: the eight factors of classes, then the others of the choice.
    pub estimates: Vec<FactorEstimate>,
    /// Correlations, for least squares.
    pub correlation: Option<FactorCorrelations>,
    /// Agreement with the cells of the fit, for least squares.
    pub agreement: Option<FitAgreement>,
    /// Every measured cell, held-out ones included, in the order of the data.
    pub cells: Vec<FittedCell>,
    /// The same of every compliance along another axis than that of the load; empty of one gauge.
    pub across: Vec<FittedCompliance>,
    /// Every component of load cases, held-out ones included, in the order of the table; empty of cells.
    pub components: Vec<FittedComponent>,
    /// Base frame and tool point; only of absolute positions.
    pub frames: Option<FittedFrames>,
    /// How the components that took part scatter; only of load cases.
    pub(crate) scatter: Option<RowScatter>,
    /// What the rows that took part say of ln a of factors and of the compliance of springs, one for each of `estimates`: nothing of those that
    /// the fit keeps. Of a fit with a covariance.
    pub(crate) information: Option<Information>,
    /// Why the search ended.
    pub termination: String,
    /// How the intervals of the bootstrap came about, if it was asked for.
    pub bootstrap: Option<BootstrapDraws>,
    /// What a user should know before using the numbers.
    pub warnings: Vec<String>,
}

impl FitOutcome {
    /// Measured and predicted values, and parameters without intervals.
    ///
    /// # Arguments
    /// - `predicted`: stiffness of the measured cells, N/m, then the other compliances, m/N, or none of them.
    /// - `is_held_out`: whether a pose took no part in the fit.
    pub(super) fn plain(
        method: FitMethod,
        problem: &FitProblem<'_>,
        parameters: &FitParameters,
        factors: &FittingFactors,
        predicted: &[f64],
        is_held_out: impl Fn(&PoseId) -> bool,
    ) -> Self {
        let MeasuredStiffness { cells, across, .. } = problem.measured;
        let (of_cells, of_across) = predicted.split_at(cells.len());
        let fitted_cell = |(cell, &predicted_n_per_m): (&MeasuredCell, &f64)| FittedCell {
            cell: cell.cell.clone(),
            measured_n_per_m: cell.stiffness_n_per_m,
            ln_uncertainty: cell.ln_uncertainty.map(|u| u.combined()),
            predicted_n_per_m,
            held_out: is_held_out(&cell.cell.pose),
            predicted_without_its_pose_n_per_m: None,
        };
        let compliance = |(one, &predicted_m_per_n): (&MeasuredCompliance, &f64)| {
            let calibration = one.calibration_m_per_n.iter();
            FittedCompliance {
                cell: one.cell.clone(),
                measured_m_per_n: one.compliance_m_per_n,
                u_m_per_n: calibration.fold(one.u_m_per_n, |u, effect| u.hypot(*effect)),
                predicted_m_per_n,
            }
        };
        Self {
            physics: problem.effects(),
            cells: cells.iter().zip(of_cells).map(fitted_cell).collect(),
            across: across.iter().zip(of_across).map(compliance).collect(),
            ..Self::without_rows(method, problem.mechanism, parameters, factors)
        }
    }

    /// Parameters without intervals, and nothing that they were fitted to.
    pub(crate) fn without_rows(
        method: FitMethod,
        mechanism: &Mechanism,
        parameters: &FitParameters,
        factors: &FittingFactors,
    ) -> Self {
        Self {
            method,
            mechanism: mechanism.name.clone(),
            physics: Vec::new(),
            estimates: parameters.plain_estimates(factors),
            factors: factors.clone(),
            correlation: None,
            agreement: None,
            cells: Vec::new(),
            across: Vec::new(),
            components: Vec::new(),
            frames: None,
            scatter: None,
            information: None,
            termination: String::new(),
            bootstrap: None,
            warnings: Vec::new(),
        }
    }

    /// Measured less predicted of every component, m and rad.
    #[must_use]
    pub fn residuals(&self) -> Vec<f64> {
        let components = self.components.iter();
        components.map(|one| one.measured - one.predicted).collect()
    }

    /// Root mean square of the displacements that the start of the fit leaves, of those that the fit leaves, and of those that fits
    /// without their pose leave, m.
    ///
    /// The last is of held-out poses if there are any, else of all poses left out in turn; `None` if neither was done.
    #[must_use]
    pub fn rms_m(&self) -> [Option<f64>; 3] {
        let rms = |of: &dyn Fn(&FittedComponent) -> Option<f64>| {
            let displacements = self.components.iter().filter(|one| !one.is_rotation);
            root_mean_square(displacements.filter_map(of))
        };
        [
            rms(&|one| Some(one.before - one.measured)),
            rms(&|one| (!one.held_out).then_some(one.predicted - one.measured)),
            rms(&FittedComponent::unseen_error),
        ]
    }

    /// Root mean square of the displacements that the rigid robot leaves, m; `None` without displacements.
    #[must_use]
    pub fn rigid_rms_m(&self) -> Option<f64> {
        let own = self.components.iter().filter(|one| !one.is_rotation);
        root_mean_square(own.map(|one| one.rigid - one.measured))
    }

    /// The same of the rigid robot in the poses that [`FitOutcome::rms_m`] states last: nothing was fitted to them.
    #[must_use]
    pub fn rigid_unseen_m(&self) -> Option<f64> {
        match &self.frames {
            Some(frames) => frames.rigid_unseen_m,
            None if self.held_out_poses() > 0 => self.rigid_of(true),
            None => self.rigid_rms_m(),
        }
    }

    /// The same in the poses of the fit, or in those that were held out.
    #[must_use]
    pub fn rigid_of(&self, held_out: bool) -> Option<f64> {
        let own = self.components.iter();
        let own = own.filter(|one| one.held_out == held_out && !one.is_rotation);
        root_mean_square(own.map(|one| one.rigid - one.measured))
    }

    /// Number of poses that took no part in the fit.
    #[must_use]
    pub fn held_out_poses(&self) -> usize {
        let held_out = self.components.iter().filter(|one| one.held_out);
        let held_out: BTreeSet<&PoseId> = held_out.map(|one| &one.pose).collect();
        held_out.len()
    }

    /// Whether a pose took no part in the fit.
    #[must_use]
    pub fn is_held_out(&self, pose: &PoseId) -> bool {
        let mut own = self.components.iter();
        own.any(|one| one.held_out && one.pose == *pose)
    }

    /// Root mean square errors of displacements or positions, pose by pose, in the order of the table.
    #[must_use]
    pub fn pose_errors(&self) -> Vec<PoseError> {
        let mut poses: IndexMap<&PoseId, Vec<&FittedComponent>> = IndexMap::new();
        for one in self.components.iter().filter(|one| !one.is_rotation) {
            poses.entry(&one.pose).or_default().push(one);
        }
        let of_pose = |(pose, own): (&PoseId, Vec<&FittedComponent>)| {
            let rms = |error: &dyn Fn(&FittedComponent) -> Option<f64>| {
                root_mean_square(own.iter().filter_map(|one| error(one)))
            };
            Some(PoseError {
                pose: pose.clone(),
                rigid_m: rms(&|one| Some(one.rigid - one.measured))?,
                before_m: rms(&|one| Some(one.before - one.measured))?,
                fitted_m: rms(&|one| Some(one.predicted - one.measured))?,
                without_its_pose_m: rms(&FittedComponent::unseen_error),
            })
        };
        poses.into_iter().filter_map(of_pose).collect()
    }

    /// The cells the model is decided by: those it was not fitted to, if there are any, else all.
    pub fn judged_cells(&self) -> impl Iterator<Item = &FittedCell> {
        let unseen =
            |cell: &FittedCell| cell.held_out || cell.predicted_without_its_pose_n_per_m.is_some();
        let any = self.cells.iter().any(unseen);
        self.cells.iter().filter(move |cell| !any || unseen(cell))
    }

    /// Largest |predicted/measured - 1| over the assessed cells, percent; `None` without cells.
    #[must_use]
    pub fn max_error_percent(&self) -> Option<f64> {
        self.judged_cells()
            .map(FittedCell::error_percent)
            .max_by(f64::total_cmp)
    }

    /// The estimate of a factor by name.
    #[must_use]
    pub fn estimate(&self, name: &str) -> Option<&FactorEstimate> {
        self.estimates.iter().find(|estimate| estimate.name == name)
    }
}
