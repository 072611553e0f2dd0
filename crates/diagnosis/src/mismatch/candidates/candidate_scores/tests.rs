use nalgebra::DMatrix;
use stiffbench_measurement::readings::read_readings;
use stiffbench_test_files::text;

use super::*;
use crate::mismatch::baselines::{Baseline, prior_sd};
use crate::mismatch::candidates::candidate::candidates;
use crate::mismatch::noise::{KnownNoise, force_within_steps};
use crate::mismatch::observed::Observations;
use crate::mismatch::problem::{DiagnosisProblem, State};
use crate::search::{Batched, Plain};
use crate::tests::{baseline, hp_robot};

/// V of a noise as it is written: σ² + g² b² of a reading, ρ^|i - j| of it between readings of a run, (q²/12 + σ_F²) c² of a reading by its force,
/// σ₀² of readings with one zero, σₛ² bᵢ bⱼ of readings of one run.
fn dense(observations: &Observations, state: &State) -> DMatrix<f64> {
    let noise = &state.whitening.noise;
    let b = &state.whitening.slope_m;
    let step_n = observations.steps.force_n.unwrap_or(0.0);
    DMatrix::from_fn(b.len(), b.len(), |i, j| {
        let (one, other) = (&observations.readings[i], &observations.readings[j]);
        let own = |i: usize| noise.reading_sd_m.powi(2) + (noise.growth_sd * b[i]).powi(2);
        let mut covariance = 0.0;
        if one.run == other.run {
            covariance += (own(i) * own(j)).sqrt() * noise.correlation.powi(i.abs_diff(j) as i32);
        }
        let force_n = observations.loads[i].force_n;
        if i == j && force_n != 0.0 {
            let c = b[i] / force_n;
            covariance += (step_n * step_n / 12.0 + noise.gauges.force_sd_n.powi(2)) * c * c;
        }
        if one.zero == other.zero {
            covariance += noise.zero_sd_m.powi(2);
        }
        if one.run == other.run {
            covariance += noise.run_slope_sd.powi(2) * b[i] * b[j];
        }
        covariance
    })
}

#[test]
fn all_scores_of_a_session_are_those_of_the_plain_engine() {
    let session = text("data/sessions/demo/readings.csv");
    let table = read_readings("readings.csv", session.as_bytes()).unwrap();
    let observations = Observations::new(&table, None);
    let robot = hp_robot();
    let factors = robot.factor_set("m_fsd").unwrap();
    let baseline = baseline(&robot, "F", factors, &observations.poses);
    let problem = DiagnosisProblem::new(&baseline, &observations);
    let state = problem
        .alternate(problem.start(), KnownNoise::Nothing)
        .unwrap()
        .unwrap();
    let model = &state.fitted.model;
    let (space, residuals) = problem.space(&state).unwrap();
    let mut columns = problem.columns(model).unwrap();
    columns.extend(force_within_steps(&observations, &state.noise.noise));
    let mut y = problem.raw_residuals(model).unwrap();
    for (known, value) in baseline.parameters().iter().zip(&model.parameters) {
        y.push((known.start - value) / known.prior_sd);
    }
    // In micrometres, so that squares of rows are of the size of the ones behind them.
    let um = |values: &[f64]| values.iter().map(|x| 1e6 * x).collect::<Vec<f64>>();
    let n = observations.len();
    let y = [um(&y[..n]), y[n..].to_vec()].concat();
    let columns: Vec<Vec<f64>> = columns.iter().map(|column| um(column)).collect();
    let v = 1e12 * dense(&observations, &state);
    let plain = Plain::new(&v, &prior_sd(&baseline), &columns, space.basis(), &y);
    let fast = Batched::new(&space, &residuals);
    let linearised = (problem.predictor())
        .linearised(&model.parameters, &[])
        .unwrap();
    let changes = Changes::new(&observations, &linearised, &[]).unwrap();
    let list = candidates(&observations, &linearised, &[]);
    let scored = score_candidates(&changes, &fast, list);
    let whites = white_candidates(&changes, &space, &scored);
    let mut count = 0;
    for (scored, white) in scored.iter().zip(&whites) {
        for (scored, white) in scored.shapes.iter().zip(&white.shapes) {
            let vector = white.vectors[0].whole(n);
            let mut readings = vector.clone();
            space.covariance.unwhiten(&mut readings);
            let expected = plain.moments(&um(&readings), &(0..n), &mut Vec::new());
            let whole = dot(&vector, &vector);
            let found = scored.moments;
            let error = (found.square - expected.square).abs();
            assert!(error < 1e-9 * whole, "{found:?} {expected:?} {whole}");
            let error = (found.product - expected.product).abs();
            let scale = (whole * dot(&residuals, &residuals)).sqrt();
            assert!(error < 1e-9 * scale, "{found:?} {expected:?} {scale}");
            count += 1;
        }
    }
    assert!(count > 1000, "{count} shapes");
}
