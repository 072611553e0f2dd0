//! What the fitted structure cannot explain, and which physics would.
//!
//! Works on readings, never on stiffnesses. The run is the unit that repeats: noise is made white run by run ([`ReadingNoise`]), what
//! the factors can absorb is projected out, every law is tried at every place, and the best is believed only beyond a limit that the
//! whole search was calibrated to.

mod bad_readings;
mod bad_runs;
mod baseline;
mod candidate;
mod candidate_scores;
mod cell_compliance;
mod cell_slopes;
mod changes;
mod configurations;
mod critical_values;
mod curve_residuals;
mod data_screen;
mod deleted_residuals;
mod design;
mod detection;
mod diagnosis;
mod earlier_noise;
mod error;
mod estimated_noise;
mod found_model;
mod free_means;
mod given_noise;
mod grade;
mod held_out;
mod joined_sessions;
mod known_effects;
mod known_noise;
mod lacking;
mod linearised;
mod memo;
mod misread;
mod missing_members;
mod model;
mod next_measurement;
mod noise;
mod observations;
mod omnibus;
mod opposite_slips;
mod options;
mod outlier;
mod part_evidence;
mod part_model;
mod part_noise;
mod part_units;
mod patterns;
mod place_scales;
mod plan;
mod predictor;
mod problem;
mod problem_candidates;
mod profiles;
mod ranked_candidate;
mod ranking;
mod reading_noise;
mod reading_screen;
mod recorded_history;
mod refit;
mod restricted_likelihood;
mod robot_baseline;
mod robot_solver;
mod rounded;
mod screened;
mod search;
mod set_displacement;
mod shares;
mod sharpness;
mod specimen;
mod stand_ins;
mod state;
mod stated;
mod stated_values;
mod strata;
mod stratum;
mod tails;
mod trace;
mod trial;
mod unexplained;
mod unloaded_zero;
mod unseen_parts;
mod usual_factor;
mod verdict;
mod white_laws;
mod wrong_cells;

pub use crate::search::MOST_READINGS_OF_A_PART;
pub use baseline::{Baseline, BaselineParameter, ElementCompliance, PoseSolver, StructureColumn};
pub use cell_slopes::{CellSlopes, SeriesSlopes};
pub use configurations::ConfigurationSizes;
pub use critical_values::{Family, LawCriticalValues};
pub use data_screen::screen_data;
pub use design::{
    CAN_TELL, CANNOT_TELL, DesignBench, DesignReport, LawAtPlace, LawDesign, NearRival,
    USUAL_NOISE, Unseen, design_of_plan, next_measurements, poses_at_hand,
};
pub use diagnosis::{
    DetectionLimit, Diagnosis, FactorChange, Finding, Impossible, KnownEffect, Rival,
};
pub use earlier_noise::EarlierNoise;
pub use error::MismatchError;
pub use estimated_noise::{EstimatedNoise, NoiseBasis};
pub use given_noise::{GivenNoise, given_noise, noise_alone};
pub use grade::{Verdict, VerdictGrade};
pub(crate) use held_out::folds_of;
pub use held_out::{HeldOut, Quality};
pub use known_noise::KnownNoise;
pub(crate) use misread::{
    Exchanged, FoundMistake, MisreadValues, NamedValue, ValueChange, ValueFit, ValueName,
    ValueScale, find_mistake,
};
pub use next_measurement::NextMeasurement;
pub(crate) use noise::{ForceReading, NoiseCovariance, ReadForces};
pub(crate) use observations::load_point;
pub use observations::{
    GaugeSteps, Observations, ObservedCell, ObservedReading, ObservedRun, ObservedSession, Recorded,
};
pub use omnibus::{Omnibus, OmnibusTest};
pub use opposite_slips::reading_between_slips;
pub use options::SearchOptions;
pub use part_model::{PartBand, PartConfiguration, PartModel};
pub use part_units::{PartUnit, PartUnits};
pub use plan::{PlannedCell, PlannedLoad};
pub use reading_noise::{GaugeNoise, ReadingNoise};
pub(crate) use reading_screen::kept;
pub(crate) use restricted_likelihood::estimate_noise;
pub use robot_baseline::RobotBaseline;
pub use screened::{BadReading, BadRun, OtherJointValue, ReadQuantity, ScreenedData};
pub use shares::{MisfitShares, MisfitSteps};
pub use specimen::{Line, SPECIMEN_JOINT, test_object};
pub use stated_values::{EstimatedValue, ValueInterval};
pub use strata::{
    Contrast, ExplainedShare, Located, MapEntry, STRATUM_LEVEL, Spot, StratumTest,
    SuspectComponent, Untested, locate,
};
pub use stratum::{Location, Stratum};
pub use trace::{DiagnosisTrace, EffectTrace, ReadingTrace, trace};
pub use trial::{
    TrialNoise, Truth, scale_to, simulate, standard_errors, standard_errors_between,
    standard_errors_of_readings,
};
pub(crate) use usual_factor::slip;
pub use white_laws::{WhiteLaw, WhiteLawShape, white_laws};

use problem::DiagnosisProblem;
use problem_candidates::{CandidateMemo, Candidates};
use stiffbench_beams::physics::TestObject;
use stiffbench_beams::physics::laws::SHORTEST_PERIOD_M;

/// Finds what a baseline cannot explain, and which physics would.
///
/// # Arguments
/// - `known`: limits computed before for the same robot and plan; computed here if `None`.
///
/// # Returns
/// The diagnosis, and the limits for the next session of the same robot and plan.
///
/// # Errors
/// [`MismatchError`].
pub fn diagnose(
    baseline: &dyn Baseline,
    observations: &Observations,
    options: &SearchOptions,
    known: Option<&LawCriticalValues>,
) -> Result<(Diagnosis, LawCriticalValues), MismatchError> {
    let (diagnosis, critical, ()) =
        diagnose_and(baseline, observations, options, known, |_| Ok(()))?;
    Ok((diagnosis, critical))
}

/// The same, and states where the baseline without effects fails, as [`locate`] does.
///
/// # Errors
/// [`MismatchError`].
pub fn diagnose_and_locate(
    baseline: &dyn Baseline,
    observations: &Observations,
    options: &SearchOptions,
) -> Result<(Diagnosis, LawCriticalValues, Located), MismatchError> {
    diagnose_and(baseline, observations, options, None, |bench| {
        bench.located_at_start(options)
    })
}

/// Diagnoses, and asks something else of the same bench, which keeps what it has computed.
fn diagnose_and<T>(
    baseline: &dyn Baseline,
    observations: &Observations,
    options: &SearchOptions,
    known: Option<&LawCriticalValues>,
    ask: impl FnOnce(&DiagnosisProblem<'_>) -> Result<T, MismatchError>,
) -> Result<(Diagnosis, LawCriticalValues, T), MismatchError> {
    if observations.is_empty() {
        return Err(MismatchError::Empty);
    }
    let changing = DiagnosisProblem::new(baseline, observations)
        .with_known_effects(&options.known_effects)
        .changing_sizes(options)?;
    let (sizes, observations) = match &changing {
        Some((sizes, scaled)) => (*sizes, scaled),
        None => (ConfigurationSizes::Common, observations),
    };
    let (at_start, moved_on);
    let rough =
        DiagnosisProblem::new(baseline, observations).with_known_effects(&options.known_effects);
    let positions = rough.positions_at_start(options)?;
    let asked = ask(&rough)?;
    at_start = observations.with_positions(&positions);
    let bench = rough.with_positions(&at_start);
    let memo = CandidateMemo::default();
    let candidates = |problem| Candidates {
        problem,
        memo: &memo,
    };
    let (found, critical) = candidates(&bench).search(options, known)?;
    if observations.bench != TestObject::Robot {
        let diagnosis = Diagnosis {
            sizes,
            ..bench.conclude(&memo, &found, &critical)?
        };
        return Ok((diagnosis, critical, asked));
    }
    // What was found moved the gauge too: where it stood is computed again, and with it what its period would explain.
    let moved = bench.positions(&found.after)?;
    if !shifts_a_period(&positions, &moved) {
        return Ok((bench.conclude(&memo, &found, &critical)?, critical, asked));
    }
    moved_on = observations.with_positions(&moved);
    let bench = bench.with_positions(&moved_on);
    let (found, critical) = candidates(&bench).search(options, Some(&critical))?;
    Ok((bench.conclude(&memo, &found, &critical)?, critical, asked))
}

/// Whether positions differ by so much, m, that the shortest period searched for is in another phase: by 0.3 rad.
fn shifts_a_period(before: &[f64], after: &[f64]) -> bool {
    let shifts = before.iter().zip(after).map(|(a, b)| (a - b).abs());
    shifts.fold(0.0, f64::max) > 0.05 * SHORTEST_PERIOD_M
}
