//! Which effects the power is counted on: each law at the places where these data could show it.

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use stiffbench::analysis::Failure;

use stiffbench_beams::physics::{Effect, Law, Place, PlaceScale};
use stiffbench_diagnosis::mismatch::{
    Baseline, Truth, scale_to, standard_errors, standard_errors_of_readings,
};
use stiffbench_units_and_text::test_point::Direction;

use super::trial_bench::TrialBench;

/// A joint whose release would add more than this many times the compliance of the structure lies in no closed loop.
const OPEN: f64 = 1e4;

/// Size, standard errors, that a place has to reach to be tried.
const LARGEST_SIZE: f64 = 12.0;

/// A loose member has the size it has: the smallest beyond this is taken, standard errors.
const LEAST_LOOSE: f64 = 6.0;

/// An effect of which the readings show less than this share is what a free parameter does, and stands out by the bounds of that alone.
const BY_READINGS: f64 = 0.01;

/// Steps of runs at which a law of one run is tried, of the thousand at which it can happen.
const IN_RUNS: usize = 12;

/// What is not known of a place: bounds that depend on it hold everything.
pub const UNKNOWN_SCALE: PlaceScale = PlaceScale {
    force_n: f64::NAN,
    force_range_n: [f64::NAN; 2],
    displacement_m: f64::NAN,
    time_s: f64::NAN,
    warming_k: f64::NAN,
    has_clock: true,
    has_holds: true,
    has_repeats: true,
    compliance: f64::NAN,
    moment_nm: f64::NAN,
    loop_nm_per_rad: f64::NAN,
};

/// What is known of a joint under the loads of a plan.
struct JointView {
    place: Place,
    largest_moment_nm: f64,
    is_open: bool,
}

/// Effects of a law that a bench can show, of a small size; the one in the middle by its smallest visible size first.
///
/// # Arguments
/// - `open`: for laws of a joint: whether the joint is to lie in no closed loop.
///
/// # Errors
/// [`ProveError`].
pub(super) fn testable(
    bench: &TrialBench<'_>,
    law: Law,
    open: bool,
) -> Result<Vec<Effect>, Failure> {
    if law.is_of_one_run() {
        return Ok(in_runs(bench, law));
    }
    if law.is_missing_element() {
        return Ok(bench.baseline.other_structures());
    }
    let joints = joints(bench)?;
    let mut places: Vec<(f64, Place)> = bench
        .first
        .1
        .detection_limits
        .iter()
        .filter(|limit| limit.law == law)
        .filter_map(|limit| Some((limit.size_80?, limit.place.clone())))
        .filter(|(_, place)| {
            let mut here = joints.iter().filter(|joint| joint.place == *place);
            place.joint().is_none() || here.any(|joint| joint.is_open == open)
        })
        .collect();
    places.sort_by(|a, b| a.0.total_cmp(&b.0));
    let middle = places.len() / 2;
    // The middle first, then outwards.
    let mut order: Vec<usize> = (0..places.len()).collect();
    order.sort_by_key(|place| place.abs_diff(middle));
    order
        .into_iter()
        .map(|place| {
            let place = places[place].1.clone();
            let moment_nm = joints
                .iter()
                .find(|joint| joint.place == place)
                .map_or(1.0, |joint| joint.largest_moment_nm);
            let since_zero = bench.plan.loads.iter().map(|load| load.since_zero_s);
            let scale = PlaceScale {
                moment_nm,
                time_s: since_zero.fold(0.0, f64::max),
                ..PlaceScale::default()
            };
            Ok(Effect::new(law, place, small_values(law, &scale))?)
        })
        .collect()
}

/// Whether no value of an effect lies outside what is plausible, as far as the scale of its place is known.
#[must_use]
pub fn may_be(effect: &Effect, scale: &PlaceScale) -> bool {
    let mut values = effect.law.parameters.iter().zip(&effect.values);
    values.all(|(parameter, &value)| {
        let [least, most] = (parameter.plausible.bounds)(scale, &effect.values);
        !(value < least || value > most)
    })
}

/// A truth with one effect more, scaled to a size; `None` if no multiple of it that may be reaches the size.
///
/// # Errors
/// [`ProveError`].
pub(super) fn scaled(
    bench: &TrialBench<'_>,
    effect: &Effect,
    beside: &Truth,
    size: f64,
) -> Result<Option<Truth>, Failure> {
    let mut truth = beside.clone();
    truth.effects.push(effect.clone());
    let truth = scale_to(&bench.baseline, &bench.plan, &truth, size)?;
    Ok(truth.filter(|truth| {
        let mut effects = truth.effects.iter();
        effects.all(|effect| may_be(effect, &UNKNOWN_SCALE))
    }))
}

/// Those of these effects that reach every size of a power curve, at the factors of the first trial, and that no free parameter imitates; no
/// more than `most`.
///
/// # Errors
/// [`ProveError`].
pub(super) fn reaching(
    bench: &TrialBench<'_>,
    effects: &[Effect],
    most: usize,
) -> Result<Vec<Effect>, Failure> {
    let mut reaching = Vec::new();
    for effect in effects {
        if reaching.len() == most {
            break;
        }
        let Some(truth) = scaled(bench, effect, &bench.first.0, LARGEST_SIZE)? else {
            continue;
        };
        let shown = standard_errors_of_readings(&bench.baseline, &bench.plan, &truth)?;
        if shown > BY_READINGS * LARGEST_SIZE {
            reaching.extend(truth.effects.into_iter().last());
        }
    }
    Ok(reaching)
}

/// The loose member with the smallest effect that is still to be found, and its size.
///
/// # Errors
/// [`ProveError`].
pub(super) fn missing_member(bench: &TrialBench<'_>) -> Result<Option<(Effect, f64)>, Failure> {
    let mut best: Option<(Effect, f64)> = None;
    for effect in bench.baseline.other_structures() {
        let mut truth = bench.first.0.clone();
        truth.effects.push(effect.clone());
        let size = standard_errors(&bench.baseline, &bench.plan, &truth)?;
        if size >= LEAST_LOOSE && best.as_ref().is_none_or(|(_, least)| size < *least) {
            best = Some((effect, size));
        }
    }
    Ok(best)
}

/// Effects of a law in one run, all over the plan: any first few of them lie far apart, in the order of runs and within a run.
fn in_runs(bench: &TrialBench<'_>, law: Law) -> Vec<Effect> {
    // Steps of the sequence that fills a square most evenly (Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018): one
    // over the plastic number, and one over its square.
    const STEPS: [f64; 2] = [0.754_877_666, 0.569_840_291];
    let observations = &bench.plan;
    let jump = |number: usize| {
        let [of_runs, of_run] = STEPS.map(|step| (0.5 + number as f64 * step).fract());
        let count = observations.runs.len() as f64;
        let run = observations.runs.get((of_runs * count) as usize)?;
        let cell = &observations.cells[run.cell];
        // A reading before it and two after it make a jump a slip.
        let possible = run.readings.len().checked_sub(3)? as f64;
        let first_after = run.readings.start + 1 + (of_run * possible) as usize;
        let place = Place::Run {
            pose: observations.poses[cell.pose].clone(),
            direction: cell.load.called(),
            repeat: run.repeat,
            step: observations.loads[first_after].step,
            gauge: None,
        };
        Effect::new(law, place, small_values(law, &PlaceScale::default())).ok()
    };
    (0..IN_RUNS).filter_map(jump).collect()
}

/// The same effect with another shape, drawn by a seed: no search has all shapes.
pub(super) fn reshaped(effect: &Effect, seed: u64) -> Effect {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    // Even in the logarithm.
    let mut effect = effect.clone();
    let shape = effect.law.parameters.iter().zip(&mut effect.values).skip(1);
    for (parameter, value) in shape {
        let spread = parameter.typical.spread;
        if spread.is_nan() {
            // A phase may be anything.
            *value = std::f64::consts::TAU * rng.random::<f64>();
        } else {
            *value *= spread.powf(2.0 * rng.random::<f64>() - 1.0);
        }
    }
    effect
}

/// Values small enough to be scaled up, with a shape in the middle of what is plausible.
pub(super) fn small_values(law: Law, scale: &PlaceScale) -> Vec<f64> {
    let parameters = law.parameters.iter();
    parameters
        .map(|parameter| (parameter.typical.value)(scale))
        .collect()
}

fn joints(bench: &TrialBench<'_>) -> Result<Vec<JointView>, Failure> {
    let mut solver = bench.baseline.solver(0)?;
    solver.solve(&bench.first.0.parameters)?;
    let largest_n = bench
        .plan
        .loads
        .iter()
        .map(|load| load.force_n.abs())
        .fold(0.0, f64::max);
    Ok(solver
        .joints()
        .into_iter()
        .enumerate()
        .map(|(joint, place)| {
            let (mut moment, mut share, mut is_open) = (0.0_f64, 0.0, false);
            for cell in &bench.plan.cells {
                let axis = Direction::index(cell.axis());
                let influence = &solver.pose(cell.pose).influence;
                let lever = influence.levers[joint][axis];
                let compliance = influence.compliance[axis][axis];
                moment = moment.max(lever.abs() * largest_n);
                if lever * lever / compliance > share {
                    share = lever * lever / compliance;
                    is_open = share > OPEN * influence.stiffness(joint, joint).abs();
                }
            }
            JointView {
                place,
                largest_moment_nm: moment,
                is_open,
            }
        })
        .collect())
}

#[cfg(test)]
mod tests {
    use stiffbench_beams::physics::laws;

    use super::*;

    #[test]
    fn a_size_beyond_what_is_plausible_is_none() {
        let scale = |scale| Effect {
            law: laws::FORCE_GAUGE_SCALE,
            place: Place::ForceGauge,
            values: vec![scale],
        };
        assert!(may_be(&scale(0.28), &UNKNOWN_SCALE));
        assert!(!may_be(&scale(0.37), &UNKNOWN_SCALE));
        // How long a gauge stands on its zero is known of a session alone.
        let mut drift = Effect {
            law: laws::DRIFT_SINCE_ZEROING,
            place: Place::Clock(None),
            values: small_values(laws::DRIFT_SINCE_ZEROING, &UNKNOWN_SCALE),
        };
        drift.values[1] = 1e6;
        assert!(may_be(&drift, &UNKNOWN_SCALE));
    }
}
