//! The fit of parameters to load cases.

use stiffbench_beams::robot::{ModelParameter, TrackedPoses};
use stiffbench_numeric::least_squares::{
    CovarianceSettings, LeastSquaresError, LeastSquaresFit, LikelihoodSetSettings,
    ParameterCovariance, ParameterSet, ParameterStatus, SigmaMode, minima, minimise, spread,
};
use stiffbench_numeric::statistics::{chi_squared_upper_tail, f_upper_tail};
use stiffbench_units_and_text::count::counted;
use stiffbench_units_and_text::test_point::PoseId;

use crate::fit::intervals::{Profiled, covariance_if_any};
use crate::fit::parameters::FitParameters;
use crate::fit::weighed_problem::{WeighedProblem, leave_poses_out};
use crate::fit::{
    FactorEstimate, FactorStatus, FitAgreement, FitError, FitMethod, FitOptions, FitOutcome,
    FittedComponent, WeightBasis,
};
use crate::mismatch::{ForceReading, NoiseBasis, ReadingNoise, StatedScatter, estimate_noise};
use crate::search::constants::ALTERNATIONS;

use super::posed::PosedLoadCases;
use super::positions::{RigidRobot, fitted_frames, why_open};
use super::problem::{LoadCaseModel, LoadCaseProblem, coordinates};
use super::scatter::{RowScatter, kinds, repeated_rows, sizes};

/// Starts beside the given one where factors are free: sections that carry the same load have two minima.
const STARTS: usize = 12;

/// What is known of the scatter of the rows that take part in a fit.
struct KnownScatter {
    /// Standard deviations of displacements, m, and of rotations, rad; none of what was not read.
    sd: [Option<f64>; 2],
    /// Standard deviation of what a load moves, as a share of it.
    load_sd: f64,
    /// Degrees of freedom.
    dof: f64,
    /// Those of the differences between repeats.
    repeat_dof: f64,
    /// Where it comes from.
    basis: NoiseBasis,
}

/// Fits parameters to load cases by least squares over all components.
///
/// Absolute positions are taken under own weight and the load of each case; base frame and tool point are fitted beside the parameters.
///
/// Displacements and rotations are weighed by their scatter: as it is stated, else from the differences between repeats of a load where there
/// are any, which soft cells have more of than stiff ones, else from what the fit leaves over the poses, parameters counted off. Springs are fitted by their compliance, from zero up.
///
/// # Errors
/// [`FitError`]; a search that did not converge is a result, not an error.
pub fn fit_load_cases(
    model: &LoadCaseModel<'_>,
    options: &FitOptions,
) -> Result<FitOutcome, FitError> {
    let tracker = model.tracker()?;
    let tracker = tracker.as_ref();
    let (parameters, unloaded) = model.parameters(&options.choice, tracker)?;
    let set = coordinates(&parameters, tracker)?;
    let takes_part = training(model, options.train.as_deref());
    let components = takes_part.iter().filter(|takes_part| **takes_part).count();
    let free = set.free_indices().len();
    if components < free {
        return Err(FitError::TooFew { components, free });
    }
    let (fit, mut problem, known) =
        weighed_fit(model, (&parameters, tracker), &set, &takes_part, options)?;
    let covariance_at = |fit: &LeastSquaresFit| covariance_of(&set, fit, &known, components);
    let scatter = problem.scatter().clone();
    let again = || LoadCaseProblem::new(*model, &parameters, scatter.clone(), tracker).ok();
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
    let rigid = match tracker {
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
        frames: tracker.zip(rigid.as_ref()).map(|(tracker, rigid)| {
            let own = parameters.parameters().len();
            fitted_frames(model, tracker, &fit.values, own, covariance, rigid)
        }),
        agreement: covariance.map(|covariance| agreement(fit, &known, covariance, components)),
        components: fitted_components(model, [&of_rigid, &before, &predicted], &takes_part),
        scatter: Some(scatter.clone()),
        ..FitOutcome::without_rows(
            FitMethod::LeastSquares,
            model.mechanism,
            &parameters,
            &factors,
        )
    };
    let counts = [
        counted(components, "component"),
        counted(free, "free parameter"),
    ];
    let names = ["poses", "others"];
    profiled.complete(&mut outcome, (&parameters, &set), names, &counts);
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
            .push(format!("the search did not converge: {words}"));
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
    (parameters, tracker): (&FitParameters, Option<&TrackedPoses>),
    set: &ParameterSet,
    takes_part: &[bool],
    options: &FitOptions,
) -> Result<(LeastSquaresFit, LoadCaseProblem<'a>, KnownScatter), FitError> {
    let posed = model.posed;
    // Displacements and rotations in units of their usual size.
    let plain = RowScatter::plain(posed, model.steps, sizes(posed));
    let plain = plain.of_some(|row| takes_part[row]);
    let has_repeats = plain.series.has_repeats();
    let from_residuals = options.sigma == Some(SigmaMode::Estimated);
    let stated = options.scatter.filter(|_| !from_residuals);
    let is_known = options.sigma == Some(SigmaMode::Known);
    if is_known && !has_repeats && stated.is_none() {
        return Err(FitError::NoRepeats);
    }
    let by_repeats = has_repeats && !from_residuals;
    let mut known = KnownScatter {
        sd: [None; 2],
        load_sd: 0.0,
        dof: 0.0,
        repeat_dof: 0.0,
        basis: NoiseBasis::Fit,
    };
    let mut problem = LoadCaseProblem::new(*model, parameters, plain.clone(), tracker)?;
    let mut fit = lowest(&mut problem, set)?;
    let mut warm_start = None;
    let free = set.free_indices().len();
    for _ in 0..ALTERNATIONS {
        // Nothing is left to show a scatter.
        if !has_repeats && stated.is_none() && plain.rows.len() <= free {
            break;
        }
        let predicted = problem.predictions(&fit.values)?;
        let columns = problem.linear_columns(&fit.values)?;
        let columns = set.free_indices().iter().map(|&place| &columns[place]);
        let columns = columns.map(|column| plain.of_readings(column)).collect();
        let by_force = problem.force_components(&fit.values)?;
        let columns = (!by_repeats).then_some(columns);
        let scatter;
        (known, scatter) = scatter_of(
            &plain,
            (posed, takes_part),
            &predicted,
            &by_force,
            (columns, stated),
            &mut warm_start,
        );
        problem.set_scatter(scatter);
        let settings = problem.settings();
        fit = minimise(&mut problem, &set.with_start(&fit.free_values)?, &settings)?;
    }
    Ok((fit, problem, known))
}

/// The scatter by the noise of a session, as a diagnosis has it: stated, else from repeats, else what the fit leaves.
///
/// # Arguments
/// - `plain`: the rows that take part.
/// - `predicted`, `by_force`: all rows, and what each component of the force moves them by.
/// - `columns`: derivatives of the readings to what is free, where no repeats are to show the scatter.
/// - `stated`: what is stated of it.
fn scatter_of(
    plain: &RowScatter,
    (posed, takes_part): (&PosedLoadCases, &[bool]),
    predicted: &[f64],
    by_force: &[[f64; 3]],
    (columns, stated): (Option<Vec<Vec<f64>>>, Option<StatedScatter>),
    warm_start: &mut Option<ReadingNoise>,
) -> (KnownScatter, RowScatter) {
    // How large an absolute position is says nothing of its load.
    let positions = posed.has_positions();
    let moved_m = if positions {
        vec![0.0; predicted.len()]
    } else {
        predicted.to_vec()
    };
    let slope_m = plain.of_readings(&moved_m);
    let by_force: Vec<[f64; 3]> = plain.rows.iter().map(|row| by_force[*row]).collect();
    let read = plain.series.displacement_m.iter();
    let read = read.zip(plain.of_readings(predicted));
    let residual_m: Vec<f64> = read.map(|(read, predicted)| read - predicted).collect();
    let linear = (&slope_m[..], ForceReading::ByComponents(&by_force));
    let warm = warm_start.as_ref();
    let seen = estimate_noise(&plain.series, &residual_m, linear, warm, None, columns);
    *warm_start = Some(seen.noise);
    let has_series = plain.series.has_series();
    let found = stated.map_or(seen, |stated| seen.with_stated(stated, has_series));
    let noise = found.noise;
    let scatter = plain.with_noise(noise, slope_m, by_force);
    let common = scatter.common_share();
    let kinds = kinds(posed);
    let ratios = [1.0, noise.gauges.rotation_ratio];
    let sd = [0, 1].map(|kind| {
        let is_read = kinds.contains(&kind);
        is_read.then_some(ratios[kind] * noise.reading_sd_m)
    });
    let repeated = repeated_rows(posed).into_iter();
    let repeats = repeated.map(|rows| rows.iter().filter(|row| takes_part[**row]).count());
    let known = KnownScatter {
        sd,
        load_sd: if positions { 0.0 } else { noise.run_slope_sd },
        dof: found.degrees_of_freedom([1.0 - common, 0.0, common]),
        repeat_dof: repeats.map(|count| count.saturating_sub(1) as f64).sum(),
        basis: found.basis,
    };
    (known, scatter)
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
    known: &KnownScatter,
    components: usize,
) -> Result<Option<ParameterCovariance>, LeastSquaresError> {
    // Rows that take no part weigh nothing, and are no degrees of freedom: the scatter was estimated without them.
    if known.basis == NoiseBasis::Fit && components <= set.free_indices().len() {
        return Ok(None);
    }
    let settings = CovarianceSettings {
        known_dof: known.dof,
        ..CovarianceSettings::default()
    };
    let known = SigmaMode::Known;
    covariance_if_any(set, fit, known, &settings)
}

fn agreement(
    fit: &LeastSquaresFit,
    known: &KnownScatter,
    covariance: &ParameterCovariance,
    components: usize,
) -> FitAgreement {
    let dof = components.saturating_sub(covariance.rank);
    let reduced = (dof > 0).then(|| fit.sum_of_squares() / dof as f64);
    let (squares, repeat_dof) = (fit.sum_of_squares(), known.repeat_dof);
    // Pure error is part of the residuals: what is compared with it is the rest, the lack of fit (Draper & Smith, section 2.1).
    let more = dof as f64 - repeat_dof;
    let (run_slope_sd, scatter_dof) = (known.load_sd, known.dof);
    let (sigma, basis, p_value) = match known.basis {
        NoiseBasis::Stated => (
            SigmaMode::Known,
            WeightBasis::Stated,
            (dof > 0).then(|| chi_squared_upper_tail(squares, dof as f64)),
        ),
        NoiseBasis::Fit => (
            SigmaMode::Estimated,
            WeightBasis::FromResiduals {
                run_slope_sd,
                dof: scatter_dof,
            },
            None,
        ),
        NoiseBasis::Repeats | NoiseBasis::Neighbours => (
            SigmaMode::Known,
            WeightBasis::Pooled {
                run_slope_sd,
                dof: scatter_dof,
            },
            (more >= 1.0).then(|| {
                let lack = (squares - repeat_dof).max(0.0) / more;
                f_upper_tail(lack, more, repeat_dof)
            }),
        ),
    };
    FitAgreement {
        sigma,
        basis,
        component_sd: known.sd,
        dof,
        reduced_chi_squared: reduced,
        p_value: p_value.flatten(),
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
