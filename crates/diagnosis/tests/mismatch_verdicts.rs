//! Each law hidden in a session of a plain arm: found when it is there, not when it is not, and what cannot be decided is stated.
//!
//! The sessions are made by the toolkit's own laws on the forces of a plan; that the laws mean what they say is compared with OpenSees
//! elsewhere. Sizes are 12 standard errors, where no true verdict is a matter of luck.

use stiffbench_beams::physics::{ActingPhysics, Effect, Law, Place, TestObject, laws};
use stiffbench_beams::robot::{FittingFactors, ModelParameter, Pose, Robot};
use stiffbench_diagnosis::mismatch::{
    Baseline, Diagnosis, LawCriticalValues, Observations, ReadingNoise, RobotBaseline,
    SearchOptions, Stratum, TrialNoise, Truth, Verdict, diagnose, scale_to, simulate,
    standard_errors, standard_errors_between,
};
use stiffbench_diagnosis::parameters::{FitRole, ParameterChoice};
use stiffbench_measurement::procedure::Procedure;
use stiffbench_test_files::shipped_procedure;
use stiffbench_test_files::shipped_robot;

pub(crate) const NOISE: TrialNoise = TrialNoise {
    noise: ReadingNoise {
        reading_sd_m: 1.2e-6,
        zero_sd_m: 2e-6,
        run_slope_sd: 0.002,
        growth_sd: 0.0,
        correlation: 0.0,
    },
    displacement_step_m: 1e-6,
    force_step_n: 0.1,
    skewed: false,
};

/// An arm on a bench, and the limits of its plan.
pub(crate) struct Arm {
    pub(crate) baseline: RobotBaseline<'static>,
    pub(crate) plan: Observations,
    critical: LawCriticalValues,
}

impl Arm {
    pub(crate) fn new(procedure: &str) -> Self {
        Self::of("serial-arm", procedure)
    }

    fn of(robot: &str, procedure: &str) -> Self {
        Self::with_free(robot, procedure, |_| ParameterChoice::default())
    }

    fn with_free(robot: &str, procedure: &str, choice: impl Fn(&Robot) -> ParameterChoice) -> Self {
        let robot: &'static Robot = Box::leak(Box::new(
            Robot::parse(&shipped_robot(robot).unwrap()).unwrap(),
        ));
        let (procedure, _) = Procedure::parse(&shipped_procedure(procedure).unwrap()).unwrap();
        let mechanism = robot.mechanism(None).unwrap();
        let poses: Vec<_> = robot.poses.iter().take(4).collect();
        let plan = stiffbench_simulation::VirtualBench::new(
            robot,
            &ActingPhysics::new(robot, mechanism, Vec::new()).unwrap(),
            &FittingFactors::UNIT,
            stiffbench_simulation::NoiseModel::default(),
            stiffbench_simulation::Jack::default(),
        )
        .unwrap()
        .run(
            &Procedure {
                poses: Some(poses.iter().map(|named| named.id.clone()).collect()),
                ..procedure
            },
            "plan",
            1,
        )
        .unwrap();
        let plan = Observations::new(&plan, None);
        let poses: Vec<Pose> = poses.iter().map(|named| named.pose.clone()).collect();
        let mut baseline = RobotBaseline::new(
            robot,
            mechanism,
            FittingFactors::UNIT,
            poses,
            &choice(robot),
        )
        .unwrap();
        baseline.suspect_file();
        let null = simulate(&baseline, &plan, &truth_of(&baseline, Vec::new()), 77).unwrap();
        let (_, critical) = diagnose(&baseline, &null, &SearchOptions::default(), None).unwrap();
        Self {
            baseline,
            plan,
            critical,
        }
    }

    fn diagnose(&self, truth: &Truth, seed: u64, without: Vec<Law>) -> Diagnosis {
        let readings = simulate(&self.baseline, &self.plan, truth, seed).unwrap();
        let options = SearchOptions {
            without,
            ..SearchOptions::default()
        };
        diagnose(&self.baseline, &readings, &options, Some(&self.critical))
            .unwrap()
            .0
    }

    /// A truth whose last effect is 12 standard errors long.
    fn twelve(&self, effect: Effect) -> Truth {
        let truth = truth_of(&self.baseline, vec![effect]);
        scale_to(&self.baseline, &self.plan, &truth, 12.0)
            .unwrap()
            .unwrap()
    }
}

pub(crate) fn truth(effects: Vec<Effect>) -> Truth {
    Truth {
        // Factors between 0.6 and 1.6.
        parameters: vec![0.2, -0.3, 0.45, -0.4],
        effects,
        noise: NOISE,
    }
}

/// The same at the start of a baseline.
fn truth_of(baseline: &RobotBaseline<'_>, effects: Vec<Effect>) -> Truth {
    let starts = baseline.parameters().iter().map(|one| one.start);
    let parameters: Vec<f64> = starts.collect();
    let own = truth(effects);
    if parameters.len() == own.parameters.len() {
        own
    } else {
        Truth { parameters, ..own }
    }
}

fn effect(law: Law, place: Place, values: &[f64]) -> Effect {
    Effect::new(law, place, values.to_vec()).unwrap()
}

fn joint(name: &str) -> Place {
    Place::Joint(name.to_owned())
}

#[test]
fn each_law_is_named_with_its_place_when_it_is_there() {
    let arm = Arm::new("load-hold-unload");
    let all = [
        "joint-compliance@S2:c=0.1urad/(N*m)",
        "joint-backlash@S2:play=10urad,seat_moment=3N*m",
        "joint-friction@S2:c=0.1urad/(N*m),friction_moment=8N*m",
        "joint-nonlinearity@S2:c=0.1urad/(N*m),q=2e-9rad/(N*m)^2",
        "base-compliance@x:c=0.1urad/(N*m)",
        "gauge-stand-compliance@z:c=0.01um/N",
        "load-misalignment@y>z:angle=10mrad",
        "force-gauge-nonlinearity:q=5e-5 1/N",
        "creep:k=1e-3 1/decade,t0=1s",
        "thermal-drift:rate=1e-8m/s",
        "setting-in:k=1%,decay=1.2",
        "slip@P1.z.2.5:jump=20um",
        "gauge-periodic:amplitude=1um,period=150um,phase=0.7rad",
        "constant-force@y:w=-0.5N",
        "gauge-misalignment@z>y:angle=10mrad",
        "gauge-scale@force:scale=0.1%",
        "gauge-scale@displacement:scale=0.1%",
        "link-length@arm2.l2:length=1mm",
        "joint-offset@S3:angle=1mrad",
        "section-error@E56:share=1%",
        "factor-group@link:share=1%",
    ];
    // Every law but those that need another bench: a thermometer, a closed loop, several mechanisms.
    assert_eq!(all.len(), Law::searched_on(TestObject::Robot).count() - 3);
    for (seed, hidden) in all.into_iter().enumerate() {
        let hidden: Effect = hidden.parse().unwrap();
        let (law, place) = (hidden.law, hidden.place.clone());
        let truth = arm.twelve(hidden);
        let diagnosis = arm.diagnose(&truth, 1000 + seed as u64, Vec::new());
        let found: Vec<String> = diagnosis
            .findings
            .iter()
            .map(|f| f.effect.title())
            .collect();
        let right = diagnosis
            .findings
            .iter()
            .find(|finding| finding.effect.law == law && finding.effect.place == place);
        assert!(
            matches!(diagnosis.verdict, Verdict::Explained | Verdict::Ambiguous) && right.is_some(),
            "{law} at {place}: {:?} {found:?}",
            diagnosis.verdict
        );
        // The size lies within four standard uncertainties of the truth: one in ten thousand would not.
        let size = right.unwrap().values[0];
        let wanted = truth.effects[0].values[0];
        if let (Some(u), false) = (size.u, [laws::CREEP, laws::JOINT_FRICTION].contains(&law)) {
            assert!(
                (size.value - wanted).abs() < 4.5 * u + 0.05 * wanted.abs(),
                "{law}: {} ± {u}, true {wanted}",
                size.value
            );
        }
        let (before, after) = (diagnosis.before.reduced_chi2, diagnosis.after.reduced_chi2);
        assert!((0.85..1.15).contains(&after), "{law}: {before} {after}");
    }
}

#[test]
fn a_base_that_rocks_about_a_horizontal_axis_is_named_where_z_is_up() {
    let arm = Arm::with_free("fanuc-r2000ic", "load-hold-unload", |robot| {
        let mechanism = robot.mechanism(None).unwrap();
        let mut choice = ParameterChoice::default();
        for factor in ModelParameter::BEAMS {
            choice.set(&factor, FitRole::Fixed);
        }
        for joint in 1..=6 {
            let name = format!("joint.J{joint}");
            let parameter = ModelParameter::find(robot, mechanism, &name).unwrap();
            choice.set(&parameter, FitRole::Free);
        }
        choice
    });
    for (seed, axis) in ["x", "y"].into_iter().enumerate() {
        let hidden = format!("base-compliance@{axis}:c=0.1urad/(N*m)");
        let hidden: Effect = hidden.parse().unwrap();
        let diagnosis = arm.diagnose(&arm.twelve(hidden.clone()), 60 + seed as u64, Vec::new());
        let found: Vec<String> = diagnosis
            .findings
            .iter()
            .map(|finding| finding.effect.title())
            .collect();
        assert!(
            found.contains(&hidden.title()),
            "{axis}: {:?} {found:?}",
            diagnosis.verdict
        );
    }
}

#[test]
fn nothing_is_named_where_nothing_is_missing() {
    let arm = Arm::new("load-unload");
    // Four in a hundred may be false alarms; these seeds hold none, and a search that lost its calibration alarms on most.
    let alarms: Vec<String> = (0..12)
        .map(|seed| arm.diagnose(&truth(Vec::new()), seed, Vec::new()))
        .filter(|diagnosis| diagnosis.verdict != Verdict::NothingMissing)
        .map(|diagnosis| format!("{:?} {:?}", diagnosis.verdict, diagnosis.findings))
        .collect();
    assert!(alarms.len() <= 1, "{alarms:#?}");
}

#[test]
fn two_effects_are_found_together() {
    let arm = Arm::new("load-hold-unload");
    let mut both = arm.twelve(effect(laws::JOINT_BACKLASH, joint("S2"), &[1e-5, 3.0]));
    let second = arm.twelve(effect(laws::DRIFT_PER_SECOND, Place::Clock(None), &[1e-8]));
    both.effects.extend(second.effects);
    let diagnosis = arm.diagnose(&both, 5, Vec::new());
    let names: Vec<&str> = diagnosis
        .findings
        .iter()
        .map(|finding| finding.effect.law.name)
        .collect();
    assert!(
        names.contains(&"joint-backlash") && names.contains(&"thermal-drift"),
        "{names:?}"
    );
}

#[test]
fn an_effect_whose_law_is_taken_out_is_called_unknown() {
    let arm = Arm::new("load-unload");
    let truth = arm.twelve(effect(
        laws::GAUGE_PERIODIC,
        Place::DisplacementGauge(None),
        &[1e-6, 1.5e-4, 0.7],
    ));
    let diagnosis = arm.diagnose(&truth, 3, vec![laws::GAUGE_PERIODIC]);
    assert_eq!(
        diagnosis.verdict,
        Verdict::Unknown,
        "{:?}",
        diagnosis.findings
    );
    assert_eq!(diagnosis.unexplained.stratum, Stratum::Rest);
}

#[test]
fn a_room_that_swings_is_unknown_and_its_period_is_named() {
    let arm = Arm::new("load-unload");
    let mut readings = simulate(&arm.baseline, &arm.plan, &truth(Vec::new()), 9).unwrap();
    let period_s = 420.0;
    let places = readings.readings.iter().zip(&mut readings.displacement_m);
    for (reading, displacement_m) in places {
        let turn = reading.time_s.unwrap() / period_s;
        *displacement_m += 1.5e-6 * (std::f64::consts::TAU * turn).sin();
    }
    let options = SearchOptions::default();
    let (diagnosis, _) = diagnose(&arm.baseline, &readings, &options, Some(&arm.critical)).unwrap();
    assert_eq!(diagnosis.verdict, Verdict::Unknown);
    let found_s = diagnosis.unexplained.period_s.unwrap();
    assert!((found_s / period_s - 1.0).abs() < 0.05, "{found_s}");
}

#[test]
fn one_repeat_is_too_little() {
    let arm = Arm::new("sweeps");
    let readings = simulate(&arm.baseline, &arm.plan, &truth(Vec::new()), 9).unwrap();
    let mut keep = vec![false; readings.len()];
    for cell in &readings.cells {
        keep[readings.runs[cell.runs.start].readings.clone()].fill(true);
    }
    let one = readings.filtered(&keep);
    let (diagnosis, _) = diagnose(
        &arm.baseline,
        &one,
        &SearchOptions::default(),
        Some(&arm.critical),
    )
    .unwrap();
    assert_eq!(diagnosis.verdict, Verdict::InsufficientData);
    assert!(diagnosis.lacking[0].contains("repeat"));
}

#[test]
fn the_same_session_gives_the_same_diagnosis() {
    let arm = Arm::new("sweeps");
    let truth = arm.twelve(effect(
        laws::FORCE_GAUGE_NONLINEARITY,
        Place::ForceGauge,
        &[5e-5],
    ));
    let [a, b] = [(); 2].map(|()| arm.diagnose(&truth, 4, Vec::new()));
    assert_eq!(a, b);
}

/// A member is loose or it is not: what it leaves of another effect is what they differ by, not what its best multiple would leave.
#[test]
fn a_missing_member_is_compared_with_an_effect_of_its_size() {
    let arm = Arm::of("hp-robot", "load-unload");
    let (baseline, plan) = (&arm.baseline, &arm.plan);
    let length = |truth: &Truth| standard_errors(baseline, plan, truth).unwrap();
    let between = |truth: &Truth, rival: &Effect| {
        standard_errors_between(baseline, plan, truth, rival).unwrap()
    };
    let loose = baseline.other_structures();
    assert!(!loose.is_empty());
    for member in &loose {
        let own = truth(vec![member.clone()]);
        let size = length(&own);
        assert!(between(&own, member) < 1e-6 * size.max(1.0));
        let other = arm.twelve(effect(
            laws::FORCE_GAUGE_NONLINEARITY,
            Place::ForceGauge,
            &[1e-10],
        ));
        let apart = between(&other, member);
        // Triangle inequality, both ways; both solve the same structure, so that rounding is all that separates them.
        assert!(
            ((12.0 - size).abs() - 1e-3..=12.0 + size + 1e-3).contains(&apart),
            "{}: {size} {apart}",
            member.title()
        );
    }
    assert!(
        loose
            .iter()
            .any(|member| length(&truth(vec![member.clone()])) > 30.0)
    );
}
