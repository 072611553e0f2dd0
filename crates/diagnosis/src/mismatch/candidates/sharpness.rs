//! Whether a jump in a run is one: a change that takes several readings is none.

use stiffbench_beams::physics::TestObject;
use stiffbench_units_and_text::test_point::Branch;

use crate::mismatch::observed::Observations;
use crate::search::WhiteSpace;
use crate::search::constants::FLAT;

/// Readings over which a gradual change in a run comes at least: a jump that is read while it happens takes two. Definition.
const GRADUAL_READINGS: usize = 3;

/// The same as a share of the readings of the run (1). Definition.
const GRADUAL_SHARE: f64 = 0.25;

/// Log-likelihood of a jump at one reading of a run relative to that of the likeliest change that comes gradually.
///
/// Where the run is not flat on both sides of the jump, it is no jump. The gradual change is a ramp over a fixed number of readings: like a jump it has a size and a place, and no value more.
///
/// # Arguments
/// - `jump`: the jump, white and projected.
/// - `residuals`: of the model without it, white.
pub(crate) fn against_gradual_change(
    observations: &Observations,
    space: &WhiteSpace,
    residuals: &[f64],
    jump: &[f64],
) -> f64 {
    let all = 0..observations.len();
    let Some(most) = all.max_by(|a, b| jump[*a].abs().total_cmp(&jump[*b].abs())) else {
        return f64::INFINITY;
    };
    let run = &observations.runs[observations.readings[most].run];
    let readings = run.readings.clone();
    let width = GRADUAL_READINGS.max((GRADUAL_SHARE * readings.len() as f64).round() as usize);
    let mut ramp = vec![0.0; observations.len()];
    let ramps = (0..readings.len().saturating_sub(width)).map(|from| {
        for (place, value) in ramp[readings.clone()].iter_mut().enumerate() {
            *value = (place.saturating_sub(from) as f64 / width as f64).min(1.0);
        }
        delta_chi2(&space.projected(&ramp), residuals)
    });
    let of_the_jump = delta_chi2(jump, residuals);
    let squares: f64 = residuals[readings.clone()].iter().map(|r| r * r).sum();
    if of_the_jump < FLAT * (squares - readings.len() as f64) {
        return f64::NEG_INFINITY;
    }
    let gradual = ramps.fold(0.0, f64::max);
    // In a recording without repeats a loop between loading and unloading is one too.
    let of_the_loop = if observations.object == TestObject::Robot {
        0.0
    } else {
        let mut branches = vec![0.0; observations.len()];
        for reading in readings {
            let unloads = observations.readings[reading].branch == Branch::Unloading;
            branches[reading] = f64::from(u8::from(unloads));
        }
        delta_chi2(&space.projected(&branches), residuals)
    };
    0.5 * (of_the_jump - gradual.max(of_the_loop))
}

/// Δχ² of a change of the readings, both white and projected.
pub(crate) fn delta_chi2(white: &[f64], residuals: &[f64]) -> f64 {
    let products = white.iter().zip(residuals);
    let (product, square) = products.fold((0.0, 0.0), |(product, square), (w, r)| {
        (product + w * r, square + w * w)
    });
    if square > 0.0 {
        product * product / square
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mismatch::observed::tests::observations;
    use crate::search::Covariance;

    /// Residuals of the first run, 1 standard deviation a unit, against the jump at reading 2.
    fn against(of_the_run: [f64; 5]) -> f64 {
        let observations = observations();
        let n = observations.len();
        let zeros: Vec<f64> = vec![1.0; n];
        let space = WhiteSpace::new(Covariance::equal(n, 1.0), &[], &[zeros]);
        let mut residuals = vec![0.0; n];
        residuals[..5].copy_from_slice(&of_the_run);
        space.project(&mut residuals);
        let mut jump = vec![0.0; n];
        jump[2..5].fill(1.0);
        against_gradual_change(&observations, &space, &residuals, &space.projected(&jump))
    }

    #[test]
    fn a_jump_is_told_from_a_ramp_by_the_likelihood() {
        let jump = against([0.0, 0.0, 9.0, 9.0, 9.0]);
        let ramp = against([0.0, 3.0, 6.0, 9.0, 9.0]);
        assert!(jump > 3.0, "{jump}");
        assert!(ramp < -3.0, "{ramp}");
        // The likelihood is a quadratic of the residuals.
        let twice = against([0.0, 0.0, 18.0, 18.0, 18.0]);
        assert!((twice / jump - 4.0).abs() < 1e-9, "{twice} {jump}");
    }
}
