//! Exactness on noise, and effects in their strata.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use super::decomposition::squares;
use super::*;
use crate::mismatch::noise::NoiseCovariance;
use crate::mismatch::{
    GaugeNoise, GaugeSteps, PlannedCell, PlannedLoad, ReadingNoise, RobotBaseline, Stratum,
};
use crate::mismatch::{KnownNoise, NoiseBasis};
use crate::tests::{hp_robot, normal};
use stiffbench_beams::physics::{Effect, Law, Place, laws};
use stiffbench_beams::robot::Robot;
use stiffbench_units_and_text::test_point::{Branch, Direction, PoseId};

/// A plan with its noise, in mechanism F or A of the shipped robot.
struct Fixture {
    observations: Observations,
    noise: ReadingNoise,
}

const NOISE: ReadingNoise = ReadingNoise {
    reading_sd_m: 2e-6,
    zero_sd_m: 3e-6,
    run_slope_sd: 0.003,
    growth_sd: 0.0,
    correlation: 0.0,
    gauges: GaugeNoise::ALIKE,
};

/// Loading and unloading with one hold of a minute at the top, five repeats; forces off their targets by up to half a newton.
pub(crate) fn cells(poses: &[&str], loads_n: &[f64], hold: bool) -> Vec<PlannedCell> {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut time_s = 0.0;
    let mut out = Vec::new();
    for pose in poses {
        for direction in Direction::ALL {
            let mut loads = Vec::new();
            for repeat in 1..=5 {
                let mut before_n = 0.0_f64;
                for (step, &target_n) in loads_n.iter().enumerate() {
                    let off: f64 = StandardNormal.sample(&mut rng);
                    let branch = if target_n.abs() < before_n.abs() {
                        Branch::Unloading
                    } else {
                        Branch::Loading
                    };
                    before_n = target_n;
                    time_s += 12.0 + off;
                    let load = PlannedLoad {
                        step: step as u32,
                        force_n: if target_n == 0.0 {
                            0.0
                        } else {
                            target_n + 0.2 * off
                        },
                        branch,
                        repeat,
                        hold_s: 5.0 + 0.5 * off,
                        time_s,
                        temperature_deg_c: None,
                        zero_before: step == 0,
                    };
                    loads.push(load);
                    if hold && target_n == -70.0 {
                        time_s += 60.0;
                        loads.push(PlannedLoad {
                            hold_s: 65.0,
                            time_s,
                            zero_before: false,
                            ..load
                        });
                    }
                }
            }
            out.push(PlannedCell {
                pose: (*pose).into(),
                load: direction.into(),
                direction,
                loads,
            });
        }
    }
    out
}

pub(crate) const UP_AND_DOWN: [f64; 15] = [
    0.0, -10.0, -20.0, -30.0, -40.0, -50.0, -60.0, -70.0, -60.0, -50.0, -40.0, -30.0, -20.0, -10.0,
    0.0,
];

fn fixture(loads_n: &[f64], hold: bool) -> Fixture {
    let steps = GaugeSteps {
        force_n: Some(0.1),
        displacement_m: Some(1e-6),
    };
    let cells = cells(&["P1", "P2", "P3", "P4"], loads_n, hold);
    Fixture {
        observations: Observations::planned(&cells, steps, None),
        noise: NOISE,
    }
}

fn known(noise: ReadingNoise) -> EstimatedNoise {
    EstimatedNoise {
        noise,
        covariance: [[0.0; 3]; 3],
        further_se: [0.0; 2],
        basis: NoiseBasis::Repeats,
    }
}

pub(crate) fn baseline<'a>(robot: &'a Robot, mechanism: &str) -> RobotBaseline<'a> {
    let factors = robot.factor_set("m_fsd").unwrap();
    let poses = ["P1", "P2", "P3", "P4"].map(PoseId::from);
    crate::tests::baseline(robot, mechanism, factors, &poses)
}

/// Everything that a test of white residuals needs.
struct Ready {
    whitening: NoiseCovariance,
    columns: Vec<Vec<f64>>,
    slope_m: Vec<f64>,
    predicted_m: Vec<f64>,
    prior_sd: Vec<f64>,
}

fn ready(problem: &DiagnosisProblem<'_>, noise: &ReadingNoise) -> Ready {
    let model = problem.start();
    Ready {
        whitening: problem.whitening(&model, &known(*noise)).unwrap(),
        columns: problem.columns(&model).unwrap(),
        slope_m: problem.slope(&model).unwrap().slope_m,
        predicted_m: problem.predicted(&model).unwrap(),
        prior_sd: prior_sd(problem.baseline),
    }
}

impl Ready {
    fn decomposition<'a>(&'a self, observations: &'a Observations) -> Decomposition<'a> {
        Decomposition::new(&Setting {
            observations,
            whitening: &self.whitening,
            columns: &self.columns,
            prior_sd: &self.prior_sd,
            slope_m: &self.slope_m,
        })
    }
}

/// Kolmogorov and Smirnov's distance of values from the uniform distribution.
fn distance_from_uniform(values: &mut [f64]) -> f64 {
    values.sort_by(f64::total_cmp);
    let n = values.len() as f64;
    values
        .iter()
        .enumerate()
        .map(|(place, value)| {
            let below = value - place as f64 / n;
            below.max((place as f64 + 1.0) / n - value)
        })
        .fold(0.0, f64::max)
}

/// A mechanism under loading and unloading with holds.
fn up_and_down(mechanism: &str, check: impl FnOnce(&Fixture, &DiagnosisProblem<'_>, &Ready)) {
    let robot = hp_robot();
    let fixture = fixture(&UP_AND_DOWN, true);
    let baseline = baseline(&robot, mechanism);
    let problem = DiagnosisProblem::new(&baseline, &fixture.observations);
    let ready = ready(&problem, &fixture.noise);
    check(&fixture, &problem, &ready);
}

const NULL_SAMPLES: usize = 2000;

/// Distance that 2000 uniform values exceed once in ten thousand (Kolmogorov's limit law: 2 exp(-2 n d²)).
const FARTHEST: f64 = 0.0497;

#[test]
fn on_noise_every_chance_is_uniform() {
    up_and_down("F", |fixture, _, ready| {
        let decomposition = ready.decomposition(&fixture.observations);
        let periods = decomposition.periods(&ready.predicted_m);
        let known = known(fixture.noise);
        let mut chances: std::collections::BTreeMap<Contrast, Vec<f64>> =
            std::collections::BTreeMap::new();
        let mut families = 0;
        for seed in 0..NULL_SAMPLES as u64 {
            let white = normal(fixture.observations.len(), seed);
            let (tests, _) = decomposition.tests(&white, &periods, Some(&known), None);
            families += usize::from(tests.iter().any(|test| test.p_family <= 0.05));
            for test in tests {
                chances.entry(test.contrast).or_default().push(test.p);
            }
        }
        let tested: Vec<Contrast> = chances.keys().copied().collect();
        let expected = [
            Contrast::CellSlope,
            Contrast::Repeat,
            Contrast::CellOffset,
            Contrast::Clock,
            Contrast::Curve,
            Contrast::LoadStep,
            Contrast::Loop,
            Contrast::Branch,
            Contrast::Hold,
            Contrast::NoiseSize,
            Contrast::Outlier,
            Contrast::Period,
        ];
        assert_eq!(tested, expected);
        for (contrast, mut values) in chances {
            if matches!(contrast, Contrast::Outlier | Contrast::Period) {
                // Bonferroni's bound: not uniform, never too small.
                let small = values.iter().filter(|p| **p <= 0.05).count();
                assert!(small <= 130, "{contrast:?}: {small} of {NULL_SAMPLES}");
                assert!(small >= 20, "{contrast:?}: {small} of {NULL_SAMPLES}");
                continue;
            }
            let distance = distance_from_uniform(&mut values);
            assert!(distance < FARTHEST, "{contrast:?}: {distance}");
        }
        // Holm: at most 5 %; 130 of 2000 is three standard deviations above.
        assert!(
            (50..=130).contains(&families),
            "{families} of {NULL_SAMPLES}"
        );
    });
}

#[test]
fn within_runs_the_scatter_of_zeros_and_slopes_need_not_be_known() {
    up_and_down("F", |fixture, problem, assumed| {
        let truth = ReadingNoise {
            zero_sd_m: 9e-6,
            run_slope_sd: 0.02,
            ..fixture.noise
        };
        let real = ready(problem, &truth);
        let decomposition = assumed.decomposition(&fixture.observations);
        let mut chances = vec![Vec::new(); 4];
        for seed in 0..NULL_SAMPLES as u64 {
            let mut readings_m = normal(fixture.observations.len(), seed);
            real.whitening.covariance.unwhiten(&mut readings_m);
            let white = decomposition.white(&readings_m);
            let within = [
                Contrast::Clock,
                Contrast::LoadStep,
                Contrast::Loop,
                Contrast::Hold,
            ];
            for (values, contrast) in chances.iter_mut().zip(within) {
                let comparison = decomposition
                    .comparisons
                    .iter()
                    .find(|comparison| comparison.plan.contrast == contrast)
                    .unwrap();
                values.push(decomposition.test(comparison, &white).p);
            }
        }
        for values in &mut chances {
            let distance = distance_from_uniform(values);
            assert!(distance < FARTHEST, "{distance}");
        }
    });
}

#[test]
fn whitening_undone_gives_back_the_readings() {
    up_and_down("A", |fixture, _, ready| {
        let white = normal(fixture.observations.len(), 1);
        let mut there_and_back = white.clone();
        ready.whitening.covariance.unwhiten(&mut there_and_back);
        ready.whitening.covariance.whiten(&mut there_and_back);
        for (a, b) in white.iter().zip(&there_and_back) {
            assert!((a - b).abs() < 1e-9, "{a} {b}");
        }
    });
}

/// A session with an effect of `length` standard errors, as it is located.
fn located(fixture: &Fixture, mechanism: &str, mut effect: Effect, length: f64) -> Located {
    let robot = hp_robot();
    let baseline = baseline(&robot, mechanism);
    let problem = DiagnosisProblem::new(&baseline, &fixture.observations);
    let mut model = problem.start();
    let ready = ready(&problem, &fixture.noise);
    let decomposition = ready.decomposition(&fixture.observations);
    for _ in 0..3 {
        model.effects = vec![effect.clone()];
        let mut change = problem.predicted(&model).unwrap();
        for (with, without) in change.iter_mut().zip(&ready.predicted_m) {
            *with -= without;
        }
        let seen = decomposition.without_model(&decomposition.white(&change));
        effect.values[0] *= length / squares(&seen).sqrt();
    }
    model.effects = vec![effect];
    let mut readings_m = normal(fixture.observations.len(), 3);
    ready.whitening.covariance.unwhiten(&mut readings_m);
    for (reading, predicted) in readings_m
        .iter_mut()
        .zip(problem.predicted(&model).unwrap())
    {
        *reading += predicted;
    }
    let observations = fixture.observations.with_displacements(readings_m);
    locate(&baseline, &observations, &SearchOptions::default()).unwrap()
}

fn effect(law: Law, place: Place, values: &[f64]) -> Effect {
    Effect::new(law, place, values.to_vec()).unwrap()
}

fn joint(name: &str) -> Place {
    Place::Joint(name.to_owned())
}

/// The strata that pass, the least likely first.
fn strata(located: &Located) -> Vec<Stratum> {
    let locations = located.locations();
    locations.iter().map(|location| location.stratum).collect()
}

#[test]
fn each_effect_lands_in_its_stratum() {
    let up_and_down = fixture(&UP_AND_DOWN, true);
    let gauge = || Place::DisplacementGauge(None);
    let cases = [
        (
            effect(laws::JOINT_COMPLIANCE, joint("A3"), &[1e-7]),
            Stratum::CellSlope,
        ),
        (
            effect(laws::SETTING_IN, Place::Structure, &[1e-3, 1.0]),
            Stratum::RepeatTime,
        ),
        (
            effect(laws::DRIFT_PER_SECOND, Place::Clock(None), &[1e-9]),
            Stratum::RepeatTime,
        ),
        (
            effect(laws::CREEP, Place::Structure, &[1e-3, 1.0]),
            Stratum::RepeatTime,
        ),
        (
            effect(laws::JOINT_FRICTION, joint("A3"), &[1e-6, 3.0]),
            Stratum::Branch,
        ),
        (
            effect(laws::JOINT_BACKLASH, joint("A3"), &[1e-6, 3.0]),
            Stratum::LoadStep,
        ),
        (
            effect(laws::GAUGE_PERIODIC, gauge(), &[1e-6, 1e-4, 0.3]),
            Stratum::Rest,
        ),
    ];
    for (effect, expected) in cases {
        let title = effect.title();
        for mechanism in ["A", "F"] {
            let located = located(&up_and_down, mechanism, effect.clone(), 14.0);
            let found = strata(&located);
            assert_eq!(
                found.first(),
                Some(&expected),
                "{mechanism}, {title}: {found:?}"
            );
        }
    }
}

#[test]
fn noise_alone_is_located_nowhere() {
    let up_and_down = fixture(&UP_AND_DOWN, true);
    let nothing = effect(laws::JOINT_COMPLIANCE, joint("A3"), &[1e-12]);
    let located = located(&up_and_down, "F", nothing, 1e-3);
    assert_eq!(located.locations(), []);
    assert!(located.slope_components.is_empty() && located.shape_components.is_empty());
    assert!(located.tests.iter().all(|test| test.spots.is_empty()));
    // 12 cells, 5 repeats, 15 steps, of which the top has two readings.
    assert_eq!(located.map.len(), 900);
    let sum: f64 = located.map.iter().map(|e| e.standardised.powi(2)).sum();
    assert!((0.85..1.15).contains(&(sum / 900.0)), "{sum}");
    assert!(located.map.iter().filter(|e| e.readings == 2).count() == 60);
}

#[test]
fn a_compliant_joint_carries_the_misfit_of_slopes() {
    let up_and_down = fixture(&UP_AND_DOWN, true);
    let softer = effect(laws::JOINT_COMPLIANCE, joint("A3"), &[1e-7]);
    let located = located(&up_and_down, "A", softer, 20.0);
    let first = &located.slope_components[0];
    assert_eq!(first.component.place, joint("A3"));
    assert!(first.share > 0.95 && first.p_left > 0.01, "{first:?}");
    assert!(first.size.is_some_and(|size| size > 0.0));
    // In mechanism A the end link stays level: its joint moves the end as the gauge's stand does.
    let together = [joint("A5B"), Place::Direction(Direction::Y)];
    let has_both = |one: &ExplainedShare| {
        let alike = one.alike.iter().chain([&one.component]);
        let places: Vec<&Place> = alike.map(|component| &component.place).collect();
        together.iter().all(|place| places.contains(&place))
    };
    let components = &located.slope_components;
    assert!(components.iter().any(has_both), "{components:?}");
}

#[test]
fn missing_features_of_a_plan_are_listed() {
    // One load up, no hold, one sign: no curve, no branch, no hold, no sign.
    let two_loads = fixture(&[0.0, -70.0], false);
    let nothing = effect(laws::JOINT_COMPLIANCE, joint("A3"), &[1e-12]);
    let found = located(&two_loads, "A", nothing.clone(), 1e-3);
    let untested: Vec<Contrast> = found.untested.iter().map(|u| u.contrast).collect();
    for contrast in [
        Contrast::Sign,
        Contrast::Curve,
        Contrast::LoadStep,
        Contrast::Loop,
        Contrast::Branch,
        Contrast::Hold,
        Contrast::NoiseSize,
    ] {
        assert!(untested.contains(&contrast), "{contrast:?}: {untested:?}");
    }
    // No repeats: nothing to compare slopes with.
    let mut once = fixture(&UP_AND_DOWN, false);
    let mut cells = cells(&["P1", "P2"], &UP_AND_DOWN, false);
    for cell in &mut cells {
        cell.loads.retain(|load| load.repeat == 1);
    }
    once.observations = Observations::planned(&cells, GaugeSteps::default(), None);
    let robot = hp_robot();
    let baseline = baseline(&robot, "A");
    let options = SearchOptions {
        noise: KnownNoise::Given(known(NOISE)),
        ..SearchOptions::default()
    };
    let found = locate(&baseline, &once.observations, &options).unwrap();
    let slope = found
        .untested
        .iter()
        .find(|u| u.contrast == Contrast::CellSlope)
        .unwrap();
    assert!(slope.why.contains("repeated"), "{}", slope.why);
    assert!(matches!(
        locate(
            &baseline,
            &Observations::planned(&[], GaugeSteps::default(), None),
            &options
        ),
        Err(MismatchError::Empty)
    ));
}

#[test]
fn play_under_both_signs_is_a_step_and_odd() {
    let both = fixture(&[0.0, -20.0, -40.0, -70.0, 0.0, 20.0, 40.0, 70.0], false);
    let play = effect(laws::JOINT_BACKLASH, joint("A3"), &[1e-6, 3.0]);
    let found = located(&both, "A", play, 14.0);
    assert_eq!(strata(&found).first(), Some(&Stratum::LoadStep));
    let sign = found.tests.iter().find(|t| t.contrast == Contrast::Sign);
    assert!(sign.is_some_and(|test| test.p > 0.01), "{sign:?}");
}
