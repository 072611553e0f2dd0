//! What the models before and after a diagnosis say of every single reading, for figures and tables.

use stiffbench_beams::physics::Effect;
use stiffbench_units_and_text::test_point::{Branch, Cell};

use stiffbench_numeric::statistics::root_mean_square;

use super::diagnosis::Diagnosis;
use crate::mismatch::baselines::Baseline;
use crate::mismatch::error::MismatchError;
use crate::mismatch::noise::NoiseCovariance;
use crate::mismatch::observed::Observations;
use crate::mismatch::problem::{DiagnosisProblem, Model};

/// One reading as the models see it.
#[derive(Debug, Clone, PartialEq)]
pub struct ReadingTrace {
    /// Its pose and direction.
    pub cell: Cell,
    /// Its repeat.
    pub repeat: u32,
    /// Its branch.
    pub branch: Branch,
    /// Its place in the load sequence.
    pub step: u32,
    /// Place among the readings of its run that share the step: 0, then 1, 2 … for holds.
    pub hold_number: u32,
    /// Number of its gauge zero.
    pub zero: u32,
    /// Line in its file.
    pub line: u32,
    /// The load that was aimed at, N.
    pub target_n: f64,
    /// Whether it is flagged.
    pub flagged: bool,
    /// Signed force, N.
    pub force_n: f64,
    /// Signed displacement as read, m.
    pub displacement_m: f64,
    /// Seconds under the load; `None` if they were not recorded.
    pub hold_s: Option<f64>,
    /// Seconds since the gauge was zeroed; `None` if no clock was recorded.
    pub since_zero_s: Option<f64>,
    /// Measured minus predicted without effects, the mean of its gauge zero taken off, m.
    pub before_m: f64,
    /// Measured minus predicted by the final model, the mean of its gauge zero taken off, m.
    pub after_m: f64,
    /// What is left of the residual without effects when zero and slope of its run are taken off, m.
    pub before_within_run_m: f64,
    /// The same of the final model's residual, m.
    pub after_within_run_m: f64,
    /// Prediction of the final model minus prediction without effects, m.
    pub model_change_m: f64,
    /// Standard deviation of a single reading, the step of the force gauge included, m.
    pub reading_sd_m: f64,
    /// What the slope of its run, a relative error, multiplies: the linear prediction, its mean over the gauge zero taken off, m.
    pub slope_m: f64,
}

/// What one effect of the final model does to the readings.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectTrace {
    /// The effect.
    pub effect: Effect,
    /// For each reading: prediction of the final model minus the prediction without this effect, m.
    pub change_m: Vec<f64>,
}

/// All readings of a diagnosis, in the order of the observations.
#[derive(Debug, Clone, PartialEq)]
pub struct DiagnosisTrace {
    /// The readings.
    pub readings: Vec<ReadingTrace>,
    /// The effects of the final model; one without which the structure cannot be solved is left out.
    pub effects: Vec<EffectTrace>,
    /// Root mean square of the displacements about their gauge zeros, m: what errors in percent are percent of.
    pub displacement_rms_m: f64,
}

/// Works out what the models of a diagnosis say of every reading.
///
/// # Errors
/// [`MismatchError::Robot`] if a pose cannot be solved; [`MismatchError::Empty`] if the diagnosis holds a structure that this
/// baseline does not have.
pub fn trace(
    baseline: &dyn Baseline,
    observations: &Observations,
    diagnosis: &Diagnosis,
) -> Result<DiagnosisTrace, MismatchError> {
    let problem = DiagnosisProblem::new(baseline, observations);
    let first: Vec<f64> = diagnosis.factors.iter().map(|f| f.before.value).collect();
    let known = diagnosis.known_effects.iter().map(|known| Effect {
        values: known.before.iter().map(|value| value.value).collect(),
        ..known.given.clone()
    });
    let first = Model {
        parameters: first,
        effects: known.collect(),
    };
    let model = Model {
        parameters: diagnosis.parameters.clone(),
        effects: diagnosis.effects.clone(),
    };
    let prediction = |model: &Model| {
        let predicted = problem.predicted_if_any(model)?;
        predicted.ok_or(MismatchError::Empty)
    };
    let (before, after) = (prediction(&first)?, prediction(&model)?);
    let slopes = problem.slope(&model)?;
    let mut traced = Vec::new();
    for (place, effect) in model.effects.iter().enumerate() {
        if let Some(without) = problem.predicted_if_any(&model.without(place))? {
            let change = after.iter().zip(&without).map(|(with, rest)| with - rest);
            traced.push(EffectTrace {
                effect: effect.clone(),
                change_m: change.collect(),
            });
        }
    }
    let whitening = NoiseCovariance::new(
        observations,
        &diagnosis.noise,
        &slopes.slope_m,
        slopes.force(),
    );
    let change = after.iter().zip(&before).map(|(a, b)| a - b).collect();
    let displacements = observations.about_zeros(observations.displacement_m.clone());
    let readings_m = displacements.iter().enumerate();
    let readings_m = readings_m.filter(|(place, _)| !rotates(observations, *place));
    let displacement_rms_m = root_mean_square(readings_m.map(|(_, value)| *value));
    let forces = observations.loads.iter().map(|load| load.force_n).collect();
    let forces = observations.about_zeros(forces);
    let residuals = [before, after].map(|predicted| problem.less(predicted));
    let about_zeros_m = residuals.map(|r| observations.about_zeros(r));
    let models = ModelPair {
        within: (about_zeros_m.clone()).map(|r| within_runs(observations, r, &forces)),
        about_zeros: about_zeros_m,
        change,
        slope_m: observations.about_zeros(slopes.slope_m),
        weights: whitening.covariance.weights(),
    };
    Ok(DiagnosisTrace {
        readings: readings(observations, &models),
        effects: traced,
        displacement_rms_m: displacement_rms_m.unwrap_or_default(),
    })
}

/// What the two models say, before and after.
struct ModelPair<'a> {
    about_zeros: [Vec<f64>; 2],
    within: [Vec<f64>; 2],
    change: Vec<f64>,
    slope_m: Vec<f64>,
    /// One over the standard deviation of each reading, 1/m.
    weights: &'a [f64],
}

/// Residuals about their zeros, minus the slope of each run over the force by least squares.
///
/// # Arguments
/// - `residuals`, `forces`: about the means of their gauge zeros.
fn within_runs(observations: &Observations, mut residuals: Vec<f64>, forces: &[f64]) -> Vec<f64> {
    for run in &observations.runs {
        let forces = &forces[run.readings.clone()];
        let residuals = &mut residuals[run.readings.clone()];
        let squares: f64 = forces.iter().map(|force| force * force).sum();
        if squares > 0.0 {
            let products = forces.iter().zip(&*residuals).map(|(f, r)| f * r);
            let slope = products.sum::<f64>() / squares;
            for (residual, force) in residuals.iter_mut().zip(forces) {
                *residual -= slope * force;
            }
        }
    }
    residuals
}

/// Whether a reading is a rotation.
fn rotates(observations: &Observations, reading: usize) -> bool {
    let cell = observations.cell_of(reading);
    observations.cells[cell].read.is_rotation()
}

/// Displacements alone: rotations have no place beside them.
fn readings(observations: &Observations, models: &ModelPair<'_>) -> Vec<ReadingTrace> {
    let recorded = observations.recorded;
    (0..observations.len())
        .filter(|&place| !rotates(observations, place))
        .map(|place| {
            let (reading, load) = (&observations.readings[place], &observations.loads[place]);
            let cell = &observations.cells[observations.cell_of(place)];
            ReadingTrace {
                cell: observations.named(cell),
                repeat: observations.runs[reading.run].repeat,
                branch: reading.branch,
                step: load.step,
                hold_number: reading.hold_number,
                zero: reading.zero,
                line: reading.line,
                target_n: reading.target_n,
                flagged: reading.flagged,
                force_n: load.force_n,
                displacement_m: observations.displacement_m[place],
                hold_s: recorded.hold.then_some(load.hold_s),
                since_zero_s: reading.time_s.map(|_| load.since_zero_s),
                before_m: models.about_zeros[0][place],
                after_m: models.about_zeros[1][place],
                before_within_run_m: models.within[0][place],
                after_within_run_m: models.within[1][place],
                model_change_m: models.change[place],
                reading_sd_m: models.weights[place].recip(),
                slope_m: models.slope_m[place],
            }
        })
        .collect()
}
