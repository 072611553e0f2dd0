//! The search for what the parameters of a fit leave out.

use std::collections::BTreeSet;

use stiffbench_beams::robot::ModelParameter;

use crate::fit::FactorStatus;
use crate::mismatch::{GradeBasis, Verdict};
use crate::search::constants::{
    LAW_LEVEL, LEAST_INDEPENDENT, NULL_SAMPLES, OMNIBUS_LEVEL, ROUNDING, SWAP_GAIN,
};
use crate::search::{
    CriticalValues, ForwardProblem, LinearCandidate, LinearModel, LinearProblem, NotIndependent,
    NullNoise, WhiteSpace, backward_elimination, dot, forward_selection, null_maxima,
    push_orthonormal,
};

use super::bad_values::bad_load_case_values;
use super::candidates::{CandidateKind, MissingCandidate, SolvedPoses, not_tested};
use super::findings::LoadCaseSearch;
use super::held_out_shares::{displacement_rms, explained_shares, helpful_terms};
use super::outcome::{ImplausibleSize, LoadCaseDiagnosis};
use super::possible::{ImpossibleTerm, negative_springs, parameters_after};
use super::scatter_model::LoadCaseScatter;
use super::table_mistake::table_mistake;
use super::undecided::{FEWEST_DOF, FEWEST_POSES, undecided};
use super::unexplained::unexplained;
use crate::elastostatics::compliances::ComplianceSolver;
use crate::elastostatics::error::LoadCaseFitError;
use crate::elastostatics::fit::{LoadCaseFitOptions, fit_load_cases};
use crate::elastostatics::outcome::LoadCaseFit;
use crate::elastostatics::problem::LoadCaseModel;

/// The problem of the search.
pub(super) type LoadCaseProblemOf<'a> = LinearProblem<'a, CandidateKind, LoadCaseScatter<'a>>;

/// Finds what the free parameters of a model leave out of its load cases; bad values are left out unless the options keep them.
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
    let table_mistake = table_mistake(model, options, &baseline)?;
    // Beside a mistake of the whole table good values look bad.
    let bad = if options.keep_bad_values || table_mistake.is_some() {
        Vec::new()
    } else {
        bad_load_case_values(model, options, &baseline)?
    };
    if !bad.is_empty() {
        let posed = model
            .posed
            .without_rows(&bad.iter().map(|one| one.row).collect::<Vec<_>>());
        let model = LoadCaseModel {
            posed: &posed,
            ..*model
        };
        let options = LoadCaseFitOptions {
            keep_bad_values: true,
            ..options.clone()
        };
        return Ok(LoadCaseDiagnosis {
            bad_values: bad,
            ..diagnose_load_cases(&model, &options, seed)?
        });
    }
    let (solved, basis) = Basis::of(model, &baseline)?;
    let is_free = |parameter: &ModelParameter| {
        let estimate = baseline
            .estimates
            .iter()
            .find(|one| one.parameter == *parameter);
        estimate.is_some_and(|one| !matches!(one.status, FactorStatus::Fixed))
    };
    let dof = basis.residuals.len().saturating_sub(basis.columns.len());
    if dof < FEWEST_DOF || model.posed.labels.len() < FEWEST_POSES {
        return Ok(LoadCaseDiagnosis {
            table_mistake,
            ..undecided(model, baseline, dof)
        });
    }
    let mut candidates = solved.candidates(&is_free);
    drop_invisible(&mut candidates, &basis.columns, basis.residuals.len());
    let mut implausible = Vec::new();
    loop {
        match judge(model, &basis, &candidates, seed)? {
            Ok(diagnosis) => {
                return Ok(LoadCaseDiagnosis {
                    implausible,
                    table_mistake,
                    ..*diagnosis
                });
            }
            Err(ImpossibleTerm { term, value }) => {
                let removed = candidates.remove(term);
                // An end of the range that is infinite or zero is no question of what is plausible.
                if removed.bounds.iter().all(|end| end.is_finite()) {
                    implausible.push(ImplausibleSize {
                        name: removed.name,
                        value,
                        bounds: removed.bounds,
                        unit: removed.unit,
                    });
                }
            }
        }
    }
}

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
    pub(super) fn of<'a>(
        model: &LoadCaseModel<'a>,
        fit: &LoadCaseFit,
    ) -> Result<(SolvedPoses<'a>, Self), LoadCaseFitError> {
        let solved = solve(model, fit)?;
        let (free, columns) = baseline_columns(&solved, fit);
        let basis = Self {
            residuals: fit.residuals(),
            baseline: fit.clone(),
            free,
            columns,
        };
        Ok((solved, basis))
    }
}

/// How a search among candidates ended; an error if a candidate was selected with a size that cannot be meant.
type JudgedSelection = Result<Box<LoadCaseDiagnosis>, ImpossibleTerm>;

/// Selects among the candidates and decides on the selection.
fn judge(
    model: &LoadCaseModel<'_>,
    basis: &Basis,
    candidates: &[MissingCandidate],
    seed: u64,
) -> Result<JudgedSelection, LoadCaseFitError> {
    let Basis {
        residuals, columns, ..
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
    let scatter = LoadCaseScatter::new(model.posed, &basis.baseline);
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
            LoadCaseScatter::new(model.posed, &basis.baseline),
            critical,
            &linear,
        )
    };
    let start = problem.start().map_err(independent)?;
    let found = select(&problem, &start, candidates).map_err(independent)?;
    let search = LoadCaseSearch {
        model,
        problem: &problem,
        candidates,
        basis,
        from_repeats,
        seed,
    };
    if let Some(impossible) = search.impossible_term(&found.model) {
        return Ok(Err(impossible));
    }
    let diagnosis = search.diagnosis(&start, &found, false)?;
    if diagnosis.verdict != Verdict::Unknown || found.model.terms.is_empty() {
        return Ok(Ok(Box::new(diagnosis)));
    }
    // Names that are not the whole must at least serve in poses that they were not fitted to.
    let helpful = helpful_terms(&search, &found.model.terms)?;
    let helpful = problem.with_terms(&helpful).map_err(independent)?;
    if let Some(impossible) = search.impossible_term(&helpful) {
        return Ok(Err(impossible));
    }
    let taken_back = found.model.terms.len() - helpful.terms.len();
    let selected = Selected {
        model: helpful,
        p: found.p,
    };
    let diagnosis = LoadCaseDiagnosis {
        taken_back,
        ..search.diagnosis(&start, &selected, true)?
    };
    Ok(Ok(Box::new(diagnosis)))
}

impl LoadCaseSearch<'_, '_> {
    /// The verdict on a selection.
    ///
    /// # Arguments
    /// - `is_left`: whether it is known that something is left.
    fn diagnosis(
        &self,
        start: &LinearModel,
        found: &Selected,
        is_left: bool,
    ) -> Result<LoadCaseDiagnosis, LoadCaseFitError> {
        let independent = |NotIndependent| LoadCaseFitError::Dependent;
        let (posed, baseline) = (self.model.posed, &self.basis.baseline);
        let findings = self.findings(&found.model).map_err(independent)?;
        let space = self.space_under(&found.model, &found.model);
        let lack = self
            .from_repeats
            .then(|| self.lack_of_fit(&found.model))
            .flatten();
        let mut left = &found.model.fit.residuals;
        let mut parameters_after = parameters_after(self.basis, &found.model.fit.values);
        let mut unexplained = unexplained(posed, &space, left, self.candidates, lack, self.seed);
        let negative = findings
            .is_empty()
            .then(|| negative_springs(posed, self.basis, start));
        if let Some(held) = negative.flatten() {
            left = &self.basis.residuals;
            let fitted = parameters_after.iter_mut();
            for ((_, value), place) in fitted.zip(&self.basis.free) {
                *value = baseline.estimates[*place].value;
            }
            unexplained = Some(held);
        }
        let shares = explained_shares(self, start, &found.model)?;
        let is_left = is_left
            || unexplained
                .as_ref()
                .is_some_and(|one| one.p <= OMNIBUS_LEVEL);
        let evidence = findings.iter().map(|one| one.log_bayes);
        let (verdict, grade) = GradeBasis {
            scatter_from_fit: !self.from_repeats,
            p_family: if findings.is_empty() { 1.0 } else { found.p },
            log_bayes: evidence.fold(f64::INFINITY, f64::min),
            is_a_set: findings.iter().any(|one| !one.alternatives.is_empty()),
            is_left,
            share_of_misfit: shares.of_misfit,
            share_unseen: shares.unseen,
        }
        .decide();
        Ok(LoadCaseDiagnosis {
            verdict,
            grade,
            lacking: lacking(verdict),
            not_tested: not_tested(self.candidates, baseline),
            findings,
            p_family: found.p,
            unexplained,
            share_of_misfit: shares.of_misfit,
            share_unseen: shares.unseen,
            before_unseen_m: shares.before_unseen_m,
            after_unseen_m: shares.after_unseen_m,
            after_m: displacement_rms(posed, left),
            parameters_after,
            candidates: self.candidates.len(),
            from_repeats: self.from_repeats,
            taken_back: 0,
            implausible: Vec::new(),
            bad_values: Vec::new(),
            table_mistake: None,
            baseline: baseline.clone(),
        })
    }
}

/// What would have to be measured where data cannot show that nothing is missing.
fn lacking(verdict: Verdict) -> Vec<String> {
    if verdict != Verdict::InsufficientData {
        return Vec::new();
    }
    vec![
        "repeats: read each load at least twice, so that the scatter is known apart from the fit"
            .to_owned(),
    ]
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
pub(super) struct Selected {
    pub(super) model: LinearModel,
    pub(super) p: f64,
}

/// Forward selection with swaps; and from all springs of each kind together, and of all kinds, backward. The larger evidence counts.
fn select(
    problem: &LoadCaseProblemOf<'_>,
    start: &LinearModel,
    candidates: &[MissingCandidate],
) -> Result<Selected, NotIndependent> {
    let scores = problem.score(start)?;
    let best = problem.rank(start, &scores, f64::NEG_INFINITY)?;
    let p_best = best
        .iter()
        .map(|one| problem.p(one, problem.evidence(one).judged(true)));
    let p_best = p_best.fold(1.0, f64::min);
    let none = || Selected {
        model: start.clone(),
        p: p_best,
    };
    // Where no candidate is the cause, so many join that they contain each other: none of them is an explanation.
    let Ok(forward) = forward_selection(problem, start, &scores) else {
        return Ok(none());
    };
    let Some(&p) = forward.p.first() else {
        return Ok(none());
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
        let together = problem.with_terms(&members);
        let kept = together.and_then(|together| backward_elimination(problem, &together));
        let Ok(kept) = kept else { continue };
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
