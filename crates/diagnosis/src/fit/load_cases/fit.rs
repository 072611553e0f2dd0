//! The fit of parameters to load cases.

use stiffbench_beams::robot::ModelParameter;
use stiffbench_numeric::least_squares::{
    CovarianceSettings, LeastSquaresError, LeastSquaresFit, LikelihoodSetSettings,
    ParameterCovariance, ParameterSet, ParameterStatus, SigmaMode, minima, spread,
};
use stiffbench_numeric::statistics::f_upper_tail;
use stiffbench_units_and_text::test_point::PoseId;

use crate::fit::intervals::{Profiled, covariance_if_any};
use crate::fit::parameters::FitParameters;
use crate::fit::weighed_problem::{WeighedProblem, leave_poses_out};
use crate::fit::{
    FactorCorrelations, FactorEstimate, FactorStatus, FitAgreement, FitError, FitMethod,
    FitOptions, FitOutcome, FittedComponent, WeightBasis,
};
use crate::mismatch::{ForceReading, Observations, ReadingNoise, estimate_noise};
use crate::search::constants::ALTERNATIONS;

use super::frames::PositionFrames;
use super::positions::{RigidRobot, fitted_frames, why_open};
use super::problem::{LoadCaseModel, LoadCaseProblem, coordinates};
use super::scatter::{RowScatter, kinds, repeated_rows, sizes};

/// Starts beside the given one where factors are free: sections that carry the same load have two minima.
const STARTS: usize = 12;

/// Rows of a fit, and what is known of their scatter.
struct WeighedRows {
    /// Whether each row belongs to the poses of the fit.
    takes_part: Vec<bool>,
    found: KnownScatter,
}

/// What is known of the scatter of rows.
#[derive(Default)]
struct KnownScatter {
    /// Standard deviations of displacements, m, and of rotations, rad; none of what was not read.
    sd: [Option<f64>; 2],
    /// Standard deviation of what a load moves, as a share of it.
    load_sd: f64,
    /// Degrees of freedom.
    dof: f64,
    /// Those of the differences between repeats.
    repeat_dof: f64,
    of_rows: RowScatter,
    /// Whether it comes from repeats; else from what the fit leaves.
    is_of_repeats: bool,
}

/// Fits parameters to load cases by least squares over all components.
///
/// Absolute positions are taken under own weight and the load of each case; base frame and tool point are fitted beside the parameters.
///
/// Displacements and rotations are weighed by their scatter: from the differences between repeats of a load where there are any, which soft
/// cells have more of than stiff ones, else from what the fit leaves over the poses, parameters counted off. Springs are fitted by their compliance, from zero up.
///
/// # Errors
/// [`FitError`]; a search that did not converge is a result, not an error.
pub fn fit_load_cases(
    model: &LoadCaseModel<'_>,
    options: &FitOptions,
) -> Result<FitOutcome, FitError> {
    let frames = PositionFrames::of(model.robot, model.mechanism, model.posed)?;
    let frames = frames.as_ref();
    let (parameters, unloaded) = model.parameters(&options.choice, frames)?;
    let set = coordinates(&parameters, frames)?;
    let takes_part = training(model, options.train.as_deref());
    let components = takes_part.iter().filter(|takes_part| **takes_part).count();
    let free = set.free_indices().len();
    if components < free {
        return Err(FitError::TooFew { components, free });
    }
    let (fit, mut problem, rows) =
        weighed_fit(model, (&parameters, frames), &set, takes_part, options)?;
    let covariance_at = |fit: &LeastSquaresFit| covariance_of(&set, fit, &rows, components);
    let scatter = problem.scatter().clone();
    let again = || LoadCaseProblem::new(*model, &parameters, scatter.clone(), frames).ok();
    let settings = LikelihoodSetSettings {
        fold_starts: 0,
        draws: 0,
        ..LikelihoodSetSettings::default()
    };
    let minima = (&set, vec![fit]);
    let profiled = Profiled::fit(&again, &mut problem, minima, &covariance_at, settings)?;
    let (fit, covariance) = (&profiled.fit, profiled.covariance.as_ref());
    let factors = parameters.values(&fit.values);
    let predicted = problem.predictions(&fit.values)?;
    let leave_out = options.train.is_none();
    let rigid = match frames {
        None => None,
        Some(_) => Some(RigidRobot::fit(model, &mut problem, leave_out)?),
    };
    let (before, of_rigid) = match &rigid {
        Some(rigid) => (rigid.predicted.clone(), rigid.predicted.clone()),
        None => (
            problem.predictions(&parameters.coordinates_of_start())?,
            problem.predictions(&parameters.coordinates_of_rigid())?,
        ),
    };
    let mut outcome = FitOutcome {
        physics: model
            .physics
            .map_or_else(Vec::new, |physics| physics.effects.clone()),
        correlation: covariance
            .map(|covariance| FactorCorrelations::of(&parameters, &set, covariance)),
        frames: frames.zip(rigid.as_ref()).map(|(frames, rigid)| {
            let own = parameters.parameters().len();
            fitted_frames(model, frames, &fit.values, own, covariance, rigid)
        }),
        agreement: covariance.map(|covariance| agreement(fit, &rows, covariance, components)),
        components: fitted_components(model, [&of_rigid, &before, &predicted], &rows.takes_part),
        scatter: rows.found.of_rows.clone(),
        termination: fit.termination.to_string(),
        ..FitOutcome::without_rows(
            FitMethod::LeastSquares,
            model.mechanism,
            &parameters,
            &factors,
        )
    };
    outcome.warnings = profiled.describe(&parameters, &mut outcome.estimates, ["poses", "others"]);
    if covariance.is_none() {
        outcome.warnings.push(format!(
            "{components} components and {free} free parameters leave no degrees of freedom: the values have no intervals"
        ));
    }
    if leave_out {
        let from_here = set.with_start(&fit.free_values)?;
        let unseen = leave_poses_out(&mut problem, &from_here, &model.posed.labels_of_rows())?;
        for (component, unseen) in outcome.components.iter_mut().zip(unseen) {
            component.without_its_pose = unseen;
        }
    }
    name_what_is_open(model, &unloaded, covariance, &mut outcome)?;
    let estimates = outcome.estimates.iter();
    let disagreements: Vec<_> = estimates.filter_map(FactorEstimate::disagreement).collect();
    outcome.warnings.extend(disagreements);
    if !fit.termination.is_converged() {
        let words = &outcome.termination;
        outcome
            .warnings
            .push(format!("the search did not arrive: {words}"));
    }
    Ok(outcome)
}

/// Says of springs on which no load acts, and of those that positions do not determine, why that is.
fn name_what_is_open(
    model: &LoadCaseModel<'_>,
    unloaded: &[ModelParameter],
    covariance: Option<&ParameterCovariance>,
    outcome: &mut FitOutcome,
) -> Result<(), FitError> {
    let positions = outcome.frames.is_some();
    for (place, estimate) in outcome.estimates.iter_mut().enumerate() {
        let status = covariance.map(|found| found.estimates[place].status);
        let words = if unloaded.contains(&estimate.parameter) {
            if positions {
                why_open(model, &estimate.parameter, false)?
            } else {
                estimate.parameter.unloaded_words().to_owned()
            }
        } else if let Some(ParameterStatus::NotIdentified { .. }) = status
            && positions
            && !estimate.parameter.is_factor()
        {
            why_open(model, &estimate.parameter, true)?
        } else {
            continue;
        };
        estimate.status = FactorStatus::NotIdentified { words };
    }
    Ok(())
}

/// Whether each row belongs to the poses of the fit.
fn training(model: &LoadCaseModel<'_>, train: Option<&[PoseId]>) -> Vec<bool> {
    let is_in = |label: usize| train.is_none_or(|train| train.contains(&model.posed.labels[label]));
    model
        .posed
        .rows()
        .map(|(case, _)| is_in(case.label))
        .collect()
}

/// Parameters and scatter, each from the other.
fn weighed_fit<'a>(
    model: &LoadCaseModel<'a>,
    (parameters, frames): (&FitParameters, Option<&PositionFrames>),
    set: &ParameterSet,
    takes_part: Vec<bool>,
    options: &FitOptions,
) -> Result<(LeastSquaresFit, LoadCaseProblem<'a>, WeighedRows), FitError> {
    let posed = model.posed;
    let only = |scatter: &RowScatter| scatter.without(|row| !takes_part[row]);
    // Displacements and rotations in units of their usual size.
    let mut found = KnownScatter {
        of_rows: RowScatter::plain(posed, sizes(posed)),
        ..KnownScatter::default()
    };
    let mut problem = LoadCaseProblem::new(*model, parameters, only(&found.of_rows), frames)?;
    let mut set = set.clone();
    let mut fit = lowest(&mut problem, &set)?;
    let observed = TrainedSeries::of(model, &takes_part);
    let mut warm_start = None;
    let free = set.free_indices().len();
    for _ in 0..ALTERNATIONS {
        // Nothing is left to show a scatter.
        if !observed.has_repeats && observed.rows.len() <= free {
            if options.sigma == Some(SigmaMode::Known) {
                return Err(FitError::NoRepeats);
            }
            break;
        }
        let predicted = problem.predictions(&fit.values)?;
        let columns = problem.linear_columns(&fit.values)?;
        let free = set
            .free_indices()
            .iter()
            .map(|&place| columns[place].clone());
        let free: Vec<Vec<f64>> = free.collect();
        let moved = problem.force_components(&fit.values)?;
        let shown = (&predicted[..], &moved[..]);
        found = observed.scatter(model, shown, &free, options, &mut warm_start)?;
        problem.set_scatter(only(&found.of_rows));
        set = set.with_start(&fit.free_values)?;
        fit = lowest(&mut problem, &set)?;
    }
    let rows = WeighedRows { takes_part, found };
    Ok((fit, problem, rows))
}

/// The load cases of the fit as a session has them.
struct TrainedSeries {
    observations: Observations,
    /// Place of each reading among the rows.
    rows: Vec<usize>,
    /// Whether repeats show the noise.
    has_repeats: bool,
    /// Degrees of freedom of the differences between repeats.
    repeat_dof: f64,
}

impl TrainedSeries {
    fn of(model: &LoadCaseModel<'_>, takes_part: &[bool]) -> Self {
        let left_out: Vec<usize> = (0..takes_part.len())
            .filter(|row| !takes_part[*row])
            .collect();
        let kept: Vec<usize> = (0..takes_part.len())
            .filter(|row| takes_part[*row])
            .collect();
        let trained = model.posed.without_rows(&left_out);
        let (observations, places) = trained.series_and_rows(model.steps, None);
        let repeated = repeated_rows(&trained).into_iter();
        Self {
            has_repeats: observations.has_repeats(),
            observations,
            rows: places.into_iter().map(|place| kept[place]).collect(),
            repeat_dof: repeated.map(|rows| rows.len() as f64 - 1.0).sum(),
        }
    }

    /// The scatter by the noise of a session, as a diagnosis has it: from repeats, else what the fit leaves.
    ///
    /// # Arguments
    /// - `predicted`, `components`: all rows, and what each component of the force moves them by; `free`: derivatives of all rows to what is free.
    fn scatter(
        &self,
        model: &LoadCaseModel<'_>,
        (predicted, components): (&[f64], &[[f64; 3]]),
        free: &[Vec<f64>],
        options: &FitOptions,
        warm_start: &mut Option<ReadingNoise>,
    ) -> Result<KnownScatter, FitError> {
        if options.sigma == Some(SigmaMode::Known) && !self.has_repeats {
            return Err(FitError::NoRepeats);
        }
        let by_repeats = self.has_repeats && options.sigma != Some(SigmaMode::Estimated);
        let observations = &self.observations;
        let of_rows = |column: &[f64]| -> Vec<f64> {
            let rows = self.rows.iter();
            rows.map(|&row| column[row]).collect()
        };
        // How large an absolute position is says nothing of its load.
        let positions = model.posed.has_positions();
        let moved = if positions {
            vec![0.0; predicted.len()]
        } else {
            predicted.to_vec()
        };
        let slope_m = of_rows(&moved);
        let by_force: Vec<[f64; 3]> = self.rows.iter().map(|&row| components[row]).collect();
        let predicted = of_rows(predicted);
        let shown = observations.displacement_m.iter().zip(&predicted);
        let residual_m: Vec<f64> = shown.map(|(shown, line)| shown - line).collect();
        let columns = (!by_repeats).then(|| free.iter().map(|one| of_rows(one)).collect());
        let linear = (&slope_m[..], ForceReading::ByComponents(&by_force));
        let found = estimate_noise(
            observations,
            &residual_m,
            linear,
            warm_start.as_ref(),
            None,
            columns,
        );
        *warm_start = Some(found.noise);
        let noise = &found.noise;
        let of_rows = RowScatter::of_noise(model.posed, model.steps, noise, &moved, components);
        let common = of_rows.common_share();
        let kinds = kinds(model.posed);
        let ratios = [1.0, noise.gauges.rotation_ratio];
        let sd = [0, 1].map(|kind| {
            let is_read = kinds.contains(&kind);
            is_read.then_some(ratios[kind] * noise.reading_sd_m)
        });
        Ok(KnownScatter {
            sd,
            load_sd: if positions { 0.0 } else { noise.run_slope_sd },
            dof: found.degrees_of_freedom([1.0 - common, 0.0, common]),
            repeat_dof: self.repeat_dof,
            of_rows,
            is_of_repeats: by_repeats,
        })
    }
}

/// The lowest minimum.
fn lowest(
    problem: &mut LoadCaseProblem<'_>,
    set: &ParameterSet,
) -> Result<LeastSquaresFit, FitError> {
    let starts = if problem.is_linear() { 0 } else { STARTS };
    let settings = problem.settings();
    let mut found = minima(problem, set, spread(set).take(starts), &settings)?;
    Ok(found.swap_remove(0))
}

/// The covariance; `None` without degrees of freedom.
fn covariance_of(
    set: &ParameterSet,
    fit: &LeastSquaresFit,
    rows: &WeighedRows,
    components: usize,
) -> Result<Option<ParameterCovariance>, LeastSquaresError> {
    // Rows that take no part weigh nothing, and are no degrees of freedom: the scatter was estimated without them.
    if !rows.found.is_of_repeats && components <= set.free_indices().len() {
        return Ok(None);
    }
    let settings = CovarianceSettings {
        known_dof: rows.found.dof,
        ..CovarianceSettings::default()
    };
    let known = SigmaMode::Known;
    covariance_if_any(set, fit, known, &settings)
}

fn agreement(
    fit: &LeastSquaresFit,
    rows: &WeighedRows,
    covariance: &ParameterCovariance,
    components: usize,
) -> FitAgreement {
    let found = &rows.found;
    let dof = components.saturating_sub(covariance.rank);
    let reduced = (dof > 0).then(|| fit.sum_of_squares() / dof as f64);
    let repeat_dof = found.repeat_dof;
    // Pure error is part of the residuals: what is compared with it is the rest, the lack of fit (Draper & Smith, section 2.1).
    let more = dof as f64 - repeat_dof;
    let p_value = reduced
        .filter(|_| found.is_of_repeats && more >= 1.0)
        .and_then(|_| {
            let lack = (fit.sum_of_squares() - repeat_dof).max(0.0) / more;
            f_upper_tail(lack, more, repeat_dof)
        });
    let (run_slope_sd, scatter_dof) = (found.load_sd, found.dof);
    FitAgreement {
        sigma: if found.is_of_repeats {
            SigmaMode::Known
        } else {
            SigmaMode::Estimated
        },
        basis: if found.is_of_repeats {
            WeightBasis::Pooled {
                run_slope_sd,
                dof: scatter_dof,
            }
        } else {
            WeightBasis::FromResiduals {
                run_slope_sd,
                dof: scatter_dof,
            }
        },
        component_sd: found.sd,
        dof,
        reduced_chi_squared: reduced,
        p_value,
        rank: covariance.rank,
        free: covariance.estimated,
        condition: covariance.condition_number,
        not_determined: covariance
            .unidentified
            .iter()
            .map(ToString::to_string)
            .collect(),
    }
}

fn fitted_components(
    model: &LoadCaseModel<'_>,
    [rigid, before, predicted]: [&[f64]; 3],
    takes_part: &[bool],
) -> Vec<FittedComponent> {
    let rows = model.posed.rows().enumerate().zip(takes_part);
    rows.map(|((row, (case, read)), takes_part)| FittedComponent {
        line: case.line,
        pose: model.posed.labels[case.label].clone(),
        repeat: case.repeat,
        component: read.name(),
        is_rotation: read.is_rotation(),
        is_position: read.is_position(),
        axis: read.axis(),
        measured: read.value,
        rigid: rigid[row],
        before: before[row],
        predicted: predicted[row],
        without_its_pose: None,
        held_out: !takes_part,
    })
    .collect()
}
