//! What a procedure can and cannot distinguish, and from what size, before any session.

use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::borrow::Cow;

use crate::mismatch::candidates::{
    CANDIDATES_AT_A_TIME, CandidateMemo, CandidateScores, Candidates, LawCriticalValues,
    WhiteCandidate, WhiteCandidates, candidates, critical_values, see,
};
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::EstimatedNoise;
use crate::mismatch::observed::Observations;
use crate::mismatch::problem::{DiagnosisProblem, FittedModel, State};
use crate::search::NullNoise;
use crate::search::constants::NULL_SAMPLES;
use stiffbench_beams::physics::Law;
use stiffbench_measurement::procedure::Procedure;

use super::bench::{DesignBench, LawAtPlace};
use super::views::{EasiestShape, NearRival, groups, nearest, suspect};

/// Rivals that are listed for each law and place (1).
const NEAREST: usize = 3;

/// What a procedure would show, for programs.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "DesignSummary")]
pub struct DesignReport {
    /// Name of the procedure.
    pub procedure: String,
    /// Readings it plans.
    pub readings: usize,
    /// Minutes it takes, setting up included.
    pub minutes: f64,
    /// Each law at each place, in the order of the library.
    pub laws: Vec<LawDesign>,
    /// Laws and places of which none can be distinguished from the others whatever its size, up to the largest that is plausible.
    pub inseparable: Vec<Vec<LawAtPlace>>,
    /// Laws and places that the readings do not show at any plausible size.
    pub unseen: Vec<Unseen>,
}

/// A law that a procedure does not show at a place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "UnseenLaw")]
pub struct Unseen {
    /// The law and its place.
    #[serde(flatten)]
    pub suspect: LawAtPlace,
    /// Size that would be found in 80 % of sessions, SI, more than is plausible; `null` if no size would.
    pub size_needed: Option<f64>,
}

/// From which size on a law is found at a place.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "LawDetection")]
pub struct LawDesign {
    /// The law and its place.
    #[serde(flatten)]
    pub suspect: LawAtPlace,
    /// Size found in 80 % of sessions, SI, in `unit`; `null` for a law without size, as a loose member.
    pub size_80: Option<f64>,
    /// Unit of the sizes.
    pub unit: Option<Cow<'static, str>>,
    /// The same as the largest change of a reading, µm.
    pub end_effect_80_um: f64,
    /// Its standard error as the largest change of a reading, m.
    #[serde(skip)]
    pub standard_error_m: f64,
    /// The laws that are hardest to tell from it, the hardest first.
    pub nearest: Vec<NearRival>,
}

/// Says what a procedure can and cannot distinguish.
///
/// A slip is not in it: its places are the loads themselves, and it is told from everything by its one run.
///
/// # Arguments
/// - `seed`: of the draws behind the limits of laws.
///
/// # Errors
/// [`MismatchError::UnknownPose`]; [`MismatchError::Robot`] if a pose cannot be solved; [`MismatchError::Empty`] without readings.
pub fn design_of_plan(
    bench: &DesignBench<'_>,
    procedure: &Procedure,
    seed: u64,
) -> Result<DesignReport, MismatchError> {
    let observations = bench.observations(procedure)?;
    let (seen, critical) = bench.white_candidates(&observations, seed)?;
    let root = |law: Law| {
        let limit = critical.laws.values.get(&(law, false));
        limit.map_or(f64::INFINITY, |limit| limit.sqrt())
    };
    let narrow = seen.iter().filter(|one| !one.candidate.wide);
    let views = narrow.map(|one| (one, EasiestShape::new(one, root(one.candidate.law))));
    let (shown, hidden): (Vec<_>, Vec<_>) =
        views.partition(|(_, view)| view.as_ref().is_some_and(EasiestShape::is_shown));
    let shown = shown.into_iter().filter_map(|(_, view)| view);
    let shown: Vec<EasiestShape<'_>> = shown.collect();
    let rivals: Vec<Vec<NearRival>> = shown.par_iter().map(|view| nearest(view, &shown)).collect();
    let unseen = hidden.iter().map(|(candidate, view)| Unseen {
        suspect: suspect(candidate),
        size_needed: view.as_ref().and_then(EasiestShape::size_needed),
    });
    Ok(DesignReport {
        procedure: procedure.name.clone(),
        readings: observations.len(),
        minutes: procedure.minutes(&bench.pace, bench.poses_of(procedure).len()),
        inseparable: groups(&shown, &rivals),
        unseen: unseen.collect(),
        laws: shown
            .iter()
            .zip(rivals)
            .map(|(view, mut rivals)| {
                rivals.truncate(NEAREST);
                let suspect = suspect(view.candidate);
                let size = suspect.law.parameters_at(&suspect.place).next();
                LawDesign {
                    unit: size.map(|spec| spec.unit().into()),
                    suspect,
                    size_80: view.size(view.scale_80),
                    standard_error_m: view.shape.peak_m / view.shape.square.sqrt(),
                    end_effect_80_um: view.scale_80.min(view.largest) * view.shape.peak_m * 1e6,
                    nearest: rivals,
                }
            })
            .collect(),
    })
}

impl DesignBench<'_> {
    /// All laws at all places as the planned readings see them, projected, with their limits.
    fn white_candidates(
        &self,
        observations: &Observations,
        seed: u64,
    ) -> Result<(Vec<WhiteCandidate>, LawCriticalValues), MismatchError> {
        if observations.is_empty() {
            return Err(MismatchError::Empty);
        }
        let rough = DiagnosisProblem::new(self.baseline, observations);
        let model = self.model();
        let predicted = rough.predicted(&model)?;
        let observations = observations.with_displacements(predicted);
        let problem = DiagnosisProblem::new(self.baseline, &observations);
        let noise = EstimatedNoise::known(self.noise);
        let whitening = problem.whitening(&model, &noise)?;
        let linearised = (problem.predictor()).linearised(&model.parameters, &[])?;
        // What happens once is nothing to plan for.
        let happens_once = Law::ALL.iter().filter(|law| law.is_of_one_run());
        let happens_once: Vec<Law> = happens_once.copied().collect();
        let list = candidates(&observations, &linearised, &happens_once);
        let state = State {
            fitted: FittedModel {
                model,
                squares: 0.0,
            },
            noise,
            whitening,
        };
        let (space, residuals) = problem.space(&state)?;
        let mut scores = CandidateScores {
            seen: Vec::new(),
            linearised,
            space,
            residuals,
        };
        scores.seen = see(&observations, &state, &scores, list);
        let (space, noise) = (&scores.space, NullNoise::normal(NULL_SAMPLES, seed));
        let hidden = scores.seen.iter().filter(|one| one.shapes.is_empty());
        let hidden = hidden.map(|one| WhiteCandidate {
            candidate: one.candidate.clone(),
            shapes: Vec::new(),
        });
        let mut seen: Vec<WhiteCandidate> = hidden.collect();
        let unseen = seen.len();
        let memo = CandidateMemo::default();
        let planned = Candidates::new(&problem, &memo);
        seen.extend(planned.with_white_shapes(&scores, &state, |searched| {
            let places: Vec<usize> = (0..searched.candidates.len()).collect();
            let white = places
                .par_chunks(CANDIDATES_AT_A_TIME)
                .flat_map_iter(|places| (searched.white)(places));
            let projected = white.map(|white| white.projected(space));
            projected.collect::<Vec<WhiteCandidate>>()
        })?);
        let shown = &seen[unseen..];
        let searched = WhiteCandidates {
            candidates: shown.iter().map(|one| &one.candidate).collect(),
            white: &|places| places.iter().map(|&place| shown[place].clone()).collect(),
        };
        let critical = critical_values(&observations, space, &searched, None, &noise);
        Ok((seen, critical))
    }
}
