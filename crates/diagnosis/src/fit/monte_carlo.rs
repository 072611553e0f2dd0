//! The paper's way of fitting: one factor after the other, each by random trials (steps 4 and 7 of its Fig. 4).

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use stiffbench_beams::robot::{ElementClass, FittingFactors};
use stiffbench_beams::structure::Property;
use stiffbench_units_and_text::test_point::Direction;

use super::cell_model::CellModel;
use super::error::FitError;
use super::significance::{Scope, SequenceStep};

/// How the trials are drawn.
///
/// The paper gives neither the number of trials nor their range; these are ours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MonteCarloSettings {
    /// Trials a factor and pass.
    pub trials: usize,
    /// Passes through the sequence. One pass fits each factor with the later ones still at their start; the next take up what that left.
    pub passes: usize,
    /// How far a single-source factor may go, as a factor up and down from its start: it must hold the paper's results (0.0057 to 2.12
    /// from 1).
    pub single_source_range: f64,
    /// The same for a multi-source factor, which starts at the single-source one: the paper's moved by 0.17 to 0.49.
    pub multi_source_range: f64,
    /// Seed of the trials.
    pub seed: u64,
}

impl Default for MonteCarloSettings {
    /// Ten passes of 200 trials: A and Iy, which share the radial direction, approach each other over several passes, and the last range,
    /// a ten-thousandth of the first, leaves a factor known to better than 1e-3 of itself.
    fn default() -> Self {
        Self {
            trials: 200,
            passes: 10,
            single_source_range: 1000.0,
            multi_source_range: 10.0,
            seed: 0,
        }
    }
}

/// Range of the last pass as a share of that of the first, in the logarithm.
const LAST_RANGE: f64 = 1e-4;

/// One factor fitted in one pass.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize, schemars::JsonSchema)]
pub struct MonteCarloStep {
    /// Pass, from 1.
    pub pass: usize,
    /// The section constant.
    pub property: Property,
    /// The direction it was fitted to.
    pub direction: Direction,
    /// The value that came nearest.
    pub value: f64,
    /// What its displacement then is relative to the wanted one.
    pub displacement_ratio: f64,
}

/// What the random trials found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
#[schemars(rename = "TrialReport")]
pub struct MonteCarloFit {
    /// The fitted factors.
    #[serde(skip)]
    pub factors: FittingFactors,
    /// Every step on the way.
    pub steps: Vec<MonteCarloStep>,
    /// Structures solved.
    pub evaluations: usize,
}

/// Fits the factors of a sequence to the stiffness of one pose, one direction each.
///
/// A trial replaces one factor by a log-uniform draw; the draw whose displacement in the factor's direction is nearest to the wanted
/// one stays. With each pass the draws come from a narrower range around the best, never from outside the whole range: a factor that
/// cannot bring its direction to the wanted displacement ends at the edge, and its step states how near it came.
///
/// # Arguments
/// - `model`: cells x, y, z of the pose, in this order.
/// - `wanted_n_per_m`: the stiffness to reach, by direction.
/// - `scope`: whether links take the factor of the beams (S-FSD) or keep their own (M-FSD).
///
/// # Errors
/// Those of [`CellModel::evaluate`].
pub fn fit_in_sequence(
    model: &mut CellModel<'_>,
    wanted_n_per_m: [f64; 3],
    sequence: &[SequenceStep],
    start: &FittingFactors,
    scope: Scope,
    settings: &MonteCarloSettings,
) -> Result<MonteCarloFit, FitError> {
    let mut rng = ChaCha8Rng::seed_from_u64(settings.seed);
    let mut fit = MonteCarloFit {
        factors: start.clone(),
        steps: Vec::new(),
        evaluations: 0,
    };
    let whole_range = match scope {
        Scope::All => settings.single_source_range,
        Scope::Beams => settings.multi_source_range,
    }
    .ln();
    let mut half_range = whole_range;
    let shrink = LAST_RANGE.powf(1.0 / settings.passes.saturating_sub(1).max(1) as f64);
    for pass in 1..=settings.passes {
        for step in sequence {
            let Some(direction) = step.direction else {
                continue;
            };
            let wanted = wanted_n_per_m[direction.index()];
            let of = |factors: &FittingFactors| {
                factors.of(ElementClass::Beam)[step.property.index()].ln()
            };
            let (centre, origin) = (of(&fit.factors), of(start));
            let mut trial = |fit: &mut MonteCarloFit, value: f64| -> Result<f64, FitError> {
                let factors = with_factor(&fit.factors, step.property, value, scope);
                let mut stiffness = [0.0; 3];
                model.evaluate(&factors, &mut stiffness, None)?;
                fit.evaluations += 1;
                Ok(wanted / stiffness[direction.index()])
            };
            // The present value takes part: a pass never makes its direction worse.
            let mut best = (centre.exp(), trial(&mut fit, centre.exp())?);
            for _ in 0..settings.trials {
                let drawn = centre + half_range * (2.0 * rng.random::<f64>() - 1.0);
                let value = drawn
                    .clamp(origin - whole_range, origin + whole_range)
                    .exp();
                let ratio = trial(&mut fit, value)?;
                if ratio.ln().abs() < best.1.ln().abs() {
                    best = (value, ratio);
                }
            }
            fit.factors = with_factor(&fit.factors, step.property, best.0, scope);
            fit.steps.push(MonteCarloStep {
                pass,
                property: step.property,
                direction,
                value: best.0,
                displacement_ratio: best.1,
            });
        }
        half_range *= shrink;
    }
    Ok(fit)
}

/// Factors with one replaced, in beams or in all elements.
fn with_factor(
    factors: &FittingFactors,
    property: Property,
    value: f64,
    scope: Scope,
) -> FittingFactors {
    let mut changed = factors.clone();
    changed.beam[property.index()] = value;
    if scope == Scope::All {
        changed.link[property.index()] = value;
    }
    changed
}
