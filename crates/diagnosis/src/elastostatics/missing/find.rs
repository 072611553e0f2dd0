//! The search for what the parameters of a fit leave out.

use std::collections::BTreeSet;

use stiffbench_beams::robot::ModelParameter;
use stiffbench_numeric::statistics::f_upper_tail;

use crate::fit::FactorStatus;
use crate::mismatch::{GradeBasis, Verdict, VerdictGrade};
use crate::search::constants::{
    LAW_LEVEL, LEAST_INDEPENDENT, NULL_SAMPLES, OMNIBUS_LEVEL, ROUNDING, SWAP_GAIN,
};
use crate::search::{
    CriticalValues, ForwardProblem, LinearCandidate, LinearModel, LinearProblem, NotIndependent,
    NullNoise, WhiteSpace, backward_elimination, dot, forward_selection, null_maxima,
    push_orthonormal,
};

use super::candidates::{CandidateKind, MissingCandidate, SolvedPoses};
use super::findings::LoadCaseSearch;
use super::held_out_shares::{displacement_rms, explained_shares};
use super::outcome::LoadCaseDiagnosis;
use super::scatter_model::LoadCaseScatter;
use super::unexplained::unexplained;
use crate::elastostatics::compliances::ComplianceSolver;
use crate::elastostatics::error::LoadCaseFitError;
use crate::elastostatics::fit::{LoadCaseFitOptions, fit_load_cases};
use crate::elastostatics::outcome::LoadCaseFit;
use crate::elastostatics::problem::LoadCaseModel;
use stiffbench_units_and_text::count::counted;

/// Degrees of freedom that load cases must leave beside the baseline: with fewer no candidate can be believed.
const FEWEST_DOF: usize = 6;

/// Poses without which nothing can be distinguished.
const FEWEST_POSES: usize = 3;

/// The problem of the search.
pub(super) type LoadCaseProblemOf<'a> = LinearProblem<'a, CandidateKind, LoadCaseScatter<'a>>;

/// Finds what the free parameters of a model leave out of its load cases.
///
/// # Arguments
/// - `seed`: of the simulated noise from which critical values come.
///
/// # Errors
/// [`LoadCaseFitError`]: those of the fit.
pub fn diagnose_load_cases(
    model: &LoadCaseModel<'_>,
    options: &LoadCaseFitOptions,
    seed: u64,
) -> Result<LoadCaseDiagnosis, LoadCaseFitError> {
    if model.posed.has_positions() {
        return Err(LoadCaseFitError::Positions { needs: "diagnose" });
    }
    let baseline = fit_load_cases(model, options)?;
    let residuals: Vec<f64> = baseline
        .components
        .iter()
        .map(|one| one.measured - one.predicted)
        .collect();
    let solved = solve(model, &baseline)?;
    let is_free = |parameter: &ModelParameter| {
        let estimate = baseline
            .estimates
            .iter()
            .find(|one| one.parameter == *parameter);
        estimate.is_some_and(|one| !matches!(one.status, FactorStatus::Fixed))
    };
    let (free, columns) = baseline_columns(&solved, &baseline);
    let dof = residuals.len().saturating_sub(columns.len());
    if dof < FEWEST_DOF || model.posed.labels.len() < FEWEST_POSES {
        return Ok(undecided(model, baseline, dof));
    }
    let mut candidates = solved.candidates(&is_free);
    drop_invisible(&mut candidates, &columns, residuals.len());
    let basis = Basis {
        baseline,
        residuals,
        free,
        columns,
    };
    loop {
        match judge(model, &basis, &candidates, seed)? {
            JudgedSelection::Diagnosis(diagnosis) => return Ok(*diagnosis),
            JudgedSelection::TakesTooMuch(place) => {
                candidates.remove(place);
            }
        }
    }
}

/// What the candidates are tried beside.
struct Basis {
    baseline: LoadCaseFit,
    residuals: Vec<f64>,
    /// Places of the free parameters among the estimates.
    free: Vec<usize>,
    /// One column for each of them.
    columns: Vec<Vec<f64>>,
}

/// How a search among candidates ended.
enum JudgedSelection {
    Diagnosis(Box<LoadCaseDiagnosis>),
    /// The candidate in this place was selected with a size that leaves a negative compliance: it cannot be meant.
    TakesTooMuch(usize),
}

/// Selects among the candidates and decides on the selection.
fn judge(
    model: &LoadCaseModel<'_>,
    basis: &Basis,
    candidates: &[MissingCandidate],
    seed: u64,
) -> Result<JudgedSelection, LoadCaseFitError> {
    let Basis {
        baseline,
        residuals,
        free,
        columns,
    } = basis;
    let problem_of = |scatter, critical_values, linear| LoadCaseProblemOf {
        rows: residuals,
        baseline: columns,
        candidates: linear,
        covariance: scatter,
        critical_values,
    };
    let linear: Vec<LinearCandidate<CandidateKind>> = candidates
        .iter()
        .map(|one| LinearCandidate {
            family: one.kind,
            columns: vec![one.column.clone()],
            multiples: one.bounds,
        })
        .collect();
    let scatter = LoadCaseScatter::new(model.posed, residuals);
    let from_repeats = scatter.is_from_repeats();
    let independent = |NotIndependent| LoadCaseFitError::Dependent;
    let problem = {
        let none = CriticalValues::calibrate(&[], &[], LAW_LEVEL);
        let start = problem_of(scatter, none, &linear)
            .start()
            .map_err(independent)?;
        let space = WhiteSpace::new(start.covariance, &[], columns);
        let noise = NullNoise::normal(NULL_SAMPLES, seed);
        let (families, maxima) = null_maxima(&space, &linear, &noise);
        let critical = CriticalValues::calibrate(&families, &maxima.families, LAW_LEVEL);
        problem_of(
            LoadCaseScatter::new(model.posed, residuals),
            critical,
            &linear,
        )
    };
    let start = problem.start().map_err(independent)?;
    let found = select(&problem, &start, candidates).map_err(independent)?;
    if let Some(place) = takes_too_much(candidates, &found.model, basis) {
        return Ok(JudgedSelection::TakesTooMuch(place));
    }
    let search = LoadCaseSearch {
        model,
        problem: &problem,
        candidates,
        residuals,
        columns,
    };
    let findings = search.findings(&found.model).map_err(independent)?;
    let space = search.space(&found.model);
    let lack = from_repeats
        .then(|| search.lack_of_fit(&found.model))
        .flatten();
    let left = &found.model.fit.residuals;
    let unexplained = unexplained(model.posed, &space, left, candidates, lack, seed);
    let shares = explained_shares(&search, &start, &found.model);
    let is_left = unexplained
        .as_ref()
        .is_some_and(|one| one.p <= OMNIBUS_LEVEL)
        || findings.is_empty() && is_held_by_bounds(model, basis, &start);
    let evidence = findings.iter().map(|one| one.log_bayes);
    let (verdict, grade) = GradeBasis {
        p_family: if findings.is_empty() { 1.0 } else { found.p },
        log_bayes: evidence.fold(f64::INFINITY, f64::min),
        is_a_set: findings.iter().any(|one| !one.alternatives.is_empty()),
        is_left,
        share_of_misfit: shares.of_misfit,
        share_unseen: shares.unseen,
    }
    .decide();
    let parameters_after = parameters_after(baseline, free, &found.model.fit.values);
    Ok(JudgedSelection::Diagnosis(Box::new(LoadCaseDiagnosis {
        verdict,
        grade,
        lacking: Vec::new(),
        findings,
        p_family: found.p,
        unexplained,
        share_of_misfit: shares.of_misfit,
        share_unseen: shares.unseen,
        before_unseen_m: shares.before_unseen_m,
        after_unseen_m: shares.after_unseen_m,
        after_m: displacement_rms(model.posed, left),
        parameters_after,
        candidates: candidates.len(),
        from_repeats,
        baseline: baseline.clone(),
    })))
}

/// The first candidate that takes more from a parameter than there is of it.
fn takes_too_much(
    candidates: &[MissingCandidate],
    model: &LinearModel,
    basis: &Basis,
) -> Option<usize> {
    let values = parameters_after(&basis.baseline, &basis.free, &model.fit.values);
    let is_impossible = |place: usize, term: usize| {
        let (parameter, share) = candidates[term].takes_from.as_ref()?;
        let name = parameter.to_string();
        let after = values.iter().find(|(known, _)| *known == name);
        let value = after.map_or_else(
            || basis.baseline.factors.get(parameter),
            |(_, value)| *value,
        );
        let taken = share * model.fit.values[basis.columns.len() + place];
        (taken > value).then_some(term)
    };
    let mut terms = model.terms.iter().enumerate();
    terms.find_map(|(place, &term)| is_impossible(place, term))
}

/// Whether the free parameters explain the load cases only with negative springs: what the fit with its bounds leaves more is no noise (F test).
fn is_held_by_bounds(model: &LoadCaseModel<'_>, basis: &Basis, start: &LinearModel) -> bool {
    let values = parameters_after(&basis.baseline, &basis.free, &start.fit.values);
    let springs = basis.free.iter().zip(values).filter(|(place, (_, value))| {
        let parameter = &basis.baseline.estimates[**place].parameter;
        !parameter.is_factor() && *value < 0.0
    });
    let negative = springs.count() as f64;
    let dof = basis.residuals.len().saturating_sub(basis.columns.len()) as f64;
    let squares = |residuals: &[f64]| {
        displacement_rms(model.posed, residuals).powi(2) * residuals.len() as f64
    };
    let (bounded, free) = (squares(&basis.residuals), squares(&start.fit.residuals));
    let lack = (bounded - free) / negative / (free / dof);
    lack.is_finite()
        && lack > 0.0
        && f_upper_tail(lack, negative, dof).is_some_and(|p| p <= OMNIBUS_LEVEL)
}

/// Values of the free parameters beside what was found: springs by their change, factors by that of their logarithm.
fn parameters_after(baseline: &LoadCaseFit, free: &[usize], deltas: &[f64]) -> Vec<(String, f64)> {
    let free = free.iter().map(|&place| &baseline.estimates[place]);
    free.zip(deltas)
        .map(|(one, delta)| {
            let value = if one.parameter.is_factor() {
                one.value * delta.exp()
            } else {
                one.value + delta
            };
            (one.name.clone(), value)
        })
        .collect()
}

/// Whether a parameter is a column of the baseline: also one at a bound, which what is missing may have driven there.
fn moves(status: &FactorStatus) -> bool {
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

/// Places of the free parameters among the estimates, and their columns; those that the ones before contain are left out.
fn baseline_columns(
    solved: &SolvedPoses<'_>,
    baseline: &LoadCaseFit,
) -> (Vec<usize>, Vec<Vec<f64>>) {
    let (mut free, mut columns) = (Vec::new(), Vec::new());
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for (place, one) in baseline.estimates.iter().enumerate() {
        let mut known = solved.parameters.iter();
        let Some(parameter) = known.position(|known| *known == one.parameter) else {
            continue;
        };
        if !moves(&one.status) {
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

/// Leaves out candidates that the baseline absorbs.
fn drop_invisible(candidates: &mut Vec<MissingCandidate>, columns: &[Vec<f64>], rows: usize) {
    let mut basis: Vec<Vec<f64>> = Vec::new();
    for column in columns {
        push_orthonormal(&mut basis, column.clone(), ROUNDING, 0.0);
    }
    candidates.retain(|one| {
        debug_assert_eq!(one.column.len(), rows);
        let whole = dot(&one.column, &one.column);
        let inside: f64 = basis
            .iter()
            .map(|unit| dot(unit, &one.column).powi(2))
            .sum();
        whole - inside > 1e-8 * whole
    });
}

/// What was selected, with the chance that noise gives any candidate as much as the first.
struct Selected {
    model: LinearModel,
    p: f64,
}

/// Forward selection with swaps; and from all springs of each kind together, and of all kinds, backward. The larger evidence counts.
fn select(
    problem: &LoadCaseProblemOf<'_>,
    start: &LinearModel,
    candidates: &[MissingCandidate],
) -> Result<Selected, NotIndependent> {
    let scores = problem.score(start)?;
    let forward = forward_selection(problem, start, &scores)?;
    let best = problem.rank(start, &scores, f64::NEG_INFINITY)?;
    let p_best = best
        .iter()
        .map(|one| problem.p(one, problem.evidence(one).judged(true)));
    let p_best = p_best.fold(1.0, f64::min);
    let Some(&p) = forward.p.first() else {
        return Ok(Selected {
            model: start.clone(),
            p: p_best,
        });
    };
    let kinds: BTreeSet<CandidateKind> = candidates.iter().map(|one| one.kind).collect();
    let springs = |kind: CandidateKind| kind.is_spring();
    let groups = kinds.into_iter().filter(|kind| springs(*kind)).map(Some);
    let mut chosen = forward.model;
    for group in groups.chain([None]) {
        let members = candidates
            .iter()
            .enumerate()
            .filter(|(_, one)| group.map_or_else(|| springs(one.kind), |group| one.kind == group));
        let members: Vec<usize> = members.map(|(place, _)| place).collect();
        let together = problem.with_terms(&members)?;
        let kept = backward_elimination(problem, &together)?;
        if kept.terms.is_empty() {
            continue;
        }
        if evidence_for(problem, start, &kept)? > evidence_for(problem, start, &chosen)? + SWAP_GAIN
        {
            chosen = kept;
        }
    }
    Ok(Selected { model: chosen, p })
}

/// Log evidence of a model against the start: half the fall of the squares under its own covariance, less half the critical value of each term.
fn evidence_for(
    problem: &LoadCaseProblemOf<'_>,
    start: &LinearModel,
    model: &LinearModel,
) -> Result<f64, NotIndependent> {
    let Some(rest) = problem.under_covariance_of(start, model)? else {
        return Ok(f64::NEG_INFINITY);
    };
    let cost: f64 = model
        .terms
        .iter()
        .map(|&term| problem.critical_values.of(problem.candidates[term].family))
        .sum();
    Ok(0.5 * (rest.fit.squares - model.fit.squares - cost))
}

fn undecided(model: &LoadCaseModel<'_>, baseline: LoadCaseFit, dof: usize) -> LoadCaseDiagnosis {
    let mut lacking = Vec::new();
    if dof < FEWEST_DOF {
        lacking.push(format!(
            "the free parameters leave {}, and {FEWEST_DOF} are needed: read more components or poses",
            counted(dof, "degree of freedom")
        ));
    }
    let poses = model.posed.labels.len();
    if poses < FEWEST_POSES {
        lacking.push(format!(
            "the data have {}, and {FEWEST_POSES} are needed",
            counted(poses, "pose")
        ));
    }
    LoadCaseDiagnosis {
        verdict: Verdict::InsufficientData,
        grade: VerdictGrade::Undecided,
        lacking,
        findings: Vec::new(),
        p_family: 1.0,
        unexplained: None,
        share_of_misfit: None,
        share_unseen: None,
        before_unseen_m: None,
        after_unseen_m: None,
        after_m: baseline.rms_m()[1].unwrap_or_default(),
        parameters_after: Vec::new(),
        candidates: 0,
        from_repeats: false,
        baseline,
    }
}
