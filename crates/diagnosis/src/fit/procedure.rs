//! The paper's nine steps to a multi-source model (its Fig. 4), each visible in the result.

use stiffbench_beams::physics::PlaceScale;
use stiffbench_beams::robot::{FittingFactors, Mechanism, ModelParameter, Robot};
use stiffbench_units_and_text::test_point::{Cell, Direction, PoseId};

use super::combine::combine;
use super::error::FitError;
use super::fixed_physics::FixedPhysics;
use super::measured::MeasuredStiffness;
use super::monte_carlo::{MonteCarloFit, MonteCarloSettings, MonteCarloStep, fit_in_sequence};
use super::outcome::{FitMethod, FitOutcome};
use super::parameters::FitParameters;
use super::problem::FitProblem;
use super::significance::{Scope, SectionSignificance, SequenceStep, significance};
use crate::parameters::ParameterChoice;

/// Factors that the paper gives the links for constants that hardly deform them: a hundredfold (step 6).
const LINK_STIFFENING: f64 = 100.0;

/// A displacement further from the wanted one than this share was not reached; the trials come within 1e-4 of what they can reach.
const MISS: f64 = 1e-3;

/// Where the single-source factors come from.
#[derive(Debug, Clone, PartialEq)]
pub enum PaperSource {
    /// Fitted to the stiffness that a reference simulation gives (steps 2 to 4).
    Reference(MeasuredStiffness),
    /// Taken as they are, under the name of their set.
    Given(String, FittingFactors),
}

/// What the procedure is asked to do.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperOptions {
    /// Poses that are fitted and combined, with their weights; the others are held out.
    pub poses: Vec<(PoseId, f64)>,
    /// Where the single-source factors come from.
    pub source: PaperSource,
    /// The random trials.
    pub trials: MonteCarloSettings,
}

/// The fit of one pose.
#[derive(Debug, Clone, PartialEq)]
pub struct PoseFit {
    /// The pose.
    pub pose: PoseId,
    /// Its weight in the combination.
    pub weight: f64,
    /// Significance around the start (step 3 or 6).
    pub significance: SectionSignificance,
    /// Sequence that follows from it.
    pub sequence: Vec<SequenceStep>,
    /// The trials (step 4 or 7).
    pub fit: MonteCarloFit,
}

/// The procedure from end to end.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperFit {
    /// Single-source fits by pose (steps 2 to 4); empty if the factors were given.
    pub single_source: Vec<PoseFit>,
    /// Single-source factors.
    pub single_source_factors: FittingFactors,
    /// The set they were taken from, if they were given.
    pub single_source_given: Option<String>,
    /// Factors the multi-source fits start from: those of the links are final (step 5).
    pub start: FittingFactors,
    /// Multi-source fits by pose (steps 6 and 7).
    pub multi_source: Vec<PoseFit>,
    /// Combined factors (step 8) and their judgement on every measured cell (step 9).
    pub outcome: FitOutcome,
}

/// Follows the paper's nine steps.
///
/// 1. The objective: a multi-source model of `mechanism` that agrees with `measured`.
/// 2. to 4. Single-source factors, beams and links alike: significance, sequence and random trials in each pose, combined.
/// 5. Beams and links part; links keep A and Iz of the single-source model and get 100 for Iy and J.
/// 6. and 7. The same for the beams alone, against the measured stiffness.
/// 8. The factors of the poses, weighted.
/// 9. Predicted over measured stiffness in every cell, held-out poses included.
///
/// # Errors
/// [`FitError::MissingDirection`] if a pose lacks a direction; [`FitError::Weights`]; those of [`CellModel::evaluate`](super::cell_model::CellModel::evaluate).
pub fn follow_paper(
    robot: &Robot,
    mechanism: &Mechanism,
    measured: &MeasuredStiffness,
    physics: Option<&FixedPhysics>,
    options: &PaperOptions,
) -> Result<PaperFit, FitError> {
    let trials = &options.trials;
    let (single_source, single_source_factors, single_source_given) = match &options.source {
        PaperSource::Given(name, factors) => (Vec::new(), factors.clone(), Some(name.clone())),
        PaperSource::Reference(reference) => {
            let fits = fit_single_source(robot, mechanism, reference, &options.poses, trials)?;
            let combined = combined(&fits)?;
            (fits, combined, None)
        }
    };
    let [link_area, _, link_iz, _] = single_source_factors.link;
    let start = FittingFactors::of_classes(
        single_source_factors.beam,
        [link_area, LINK_STIFFENING, link_iz, LINK_STIFFENING],
    );
    let problem = FitProblem {
        robot,
        mechanism,
        measured,
        start: &start,
        physics,
    };
    let multi_source = fit_poses(&problem, &options.poses, Scope::Beams, trials)?;
    let factors = combined(&multi_source)?;
    let mut outcome = validate(&problem, options, &factors)?;
    outcome.warnings.extend(
        single_source
            .iter()
            .chain(&multi_source)
            .flat_map(PoseFit::misses),
    );
    Ok(PaperFit {
        single_source,
        single_source_factors,
        single_source_given,
        start,
        multi_source,
        outcome,
    })
}

/// Single-source fits (steps 2 to 4): in each pose, the factors of all elements alike that give the stiffness of a reference.
///
/// # Errors
/// As [`follow_paper`].
pub fn fit_single_source(
    robot: &Robot,
    mechanism: &Mechanism,
    reference: &MeasuredStiffness,
    poses: &[(PoseId, f64)],
    trials: &MonteCarloSettings,
) -> Result<Vec<PoseFit>, FitError> {
    let problem = FitProblem {
        robot,
        mechanism,
        measured: reference,
        start: &FittingFactors::UNIT,
        // A reference simulation knows of beams alone.
        physics: None,
    };
    fit_poses(&problem, poses, Scope::All, trials)
}

/// The fits of poses, each with its weight.
fn fit_poses(
    problem: &FitProblem<'_>,
    poses: &[(PoseId, f64)],
    scope: Scope,
    trials: &MonteCarloSettings,
) -> Result<Vec<PoseFit>, FitError> {
    let fit = |(pose, weight): &(PoseId, f64)| fit_pose(problem, pose, *weight, scope, trials);
    poses.iter().map(fit).collect()
}

/// Steps 2 to 4, or 6 and 7, for one pose.
fn fit_pose(
    problem: &FitProblem<'_>,
    pose: &PoseId,
    weight: f64,
    scope: Scope,
    trials: &MonteCarloSettings,
) -> Result<PoseFit, FitError> {
    let mut wanted_n_per_m = [0.0; 3];
    for direction in Direction::ALL {
        let cell = Cell::new(pose.clone(), direction);
        let found = problem
            .measured
            .cells
            .iter()
            .find(|measured| measured.cell == cell);
        let Some(found) = found else {
            return Err(FitError::MissingDirection {
                pose: pose.clone(),
                missing: direction,
            });
        };
        wanted_n_per_m[direction.index()] = found.stiffness_n_per_m;
    }
    let FitProblem {
        robot,
        mechanism,
        start,
        physics,
        ..
    } = *problem;
    let significance = significance(robot, mechanism, pose, start, scope, physics, &[])?;
    let sequence = significance.sequence();
    let cells = Direction::ALL.map(|direction| Cell::new(pose.clone(), direction));
    let mut model = problem.cell_model(&ModelParameter::CLASSES, &cells)?;
    let fit = fit_in_sequence(&mut model, wanted_n_per_m, &sequence, start, scope, trials)?;
    Ok(PoseFit {
        pose: pose.clone(),
        weight,
        significance,
        sequence,
        fit,
    })
}

impl PoseFit {
    /// Directions that their factor could not bring to the wanted displacement, in words.
    #[must_use]
    pub fn misses(&self) -> Vec<String> {
        let last = self.fit.steps.iter().map(|step| step.pass).max();
        let missed = |step: &&MonteCarloStep| {
            Some(step.pass) == last && (step.displacement_ratio - 1.0).abs() > MISS
        };
        let words = |step: &MonteCarloStep| {
            format!(
                "pose {}: a_{} at the edge of its range leaves the displacement along {} at {:.1} % of the target",
                self.pose,
                step.property.name(),
                step.direction,
                100.0 * step.displacement_ratio
            )
        };
        self.fit.steps.iter().filter(missed).map(words).collect()
    }
}

fn combined(fits: &[PoseFit]) -> Result<FittingFactors, FitError> {
    let sets: Vec<(FittingFactors, f64)> = fits
        .iter()
        .map(|fit| (fit.fit.factors.clone(), fit.weight))
        .collect();
    combine(&sets).ok_or(FitError::Weights)
}

/// Step 9.
fn validate(
    problem: &FitProblem<'_>,
    options: &PaperOptions,
    factors: &FittingFactors,
) -> Result<FitOutcome, FitError> {
    let cells = problem.measured.cells.iter();
    let cells: Vec<Cell> = cells.map(|cell| cell.cell.clone()).collect();
    let predicted = problem
        .cell_model(&ModelParameter::CLASSES, &cells)?
        .stiffness(factors)?;
    let choice = ParameterChoice::default();
    let parameters =
        FitParameters::with_scales(problem.start, &choice, &|_| PlaceScale::default())?;
    let is_held_out = |pose: &PoseId| options.poses.iter().all(|(trained, _)| trained != pose);
    let method = FitMethod::Paper;
    Ok(FitOutcome {
        termination: "the trials of every pass were used up".to_owned(),
        warnings: vec![
            "the paper's procedure gives no uncertainty; --method least-squares gives intervals"
                .to_owned(),
        ],
        ..FitOutcome::plain(
            method,
            problem,
            &parameters,
            factors,
            &predicted,
            is_held_out,
        )
    })
}
