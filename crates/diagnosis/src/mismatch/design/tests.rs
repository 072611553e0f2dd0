//! What can never be distinguished, and how plans compare, on the shipped robots.

use super::separation::Effects;
use super::*;
use crate::mismatch::observed::{GaugeSteps, Observations, PlannedCell, PlannedLoad, ReadingNoise};
use crate::mismatch::{Finding, Rival, RobotBaseline};
use crate::search::Projected;
use crate::tests::robot;
use stiffbench_beams::physics::{Effect, Law, Place, TestObject, laws};
use stiffbench_beams::robot::Robot;
use stiffbench_measurement::procedure::{Pace, Procedure};
use stiffbench_test_files::shipped_procedure;
use stiffbench_units_and_text::test_point::{Branch, Direction, PoseId};

/// A shipped procedure, without the reading on the way back that the method's sweeps have not.
fn shipped(name: &str) -> Procedure {
    let text = shipped_procedure(name).unwrap();
    let mut procedure = Procedure::parse(&text).unwrap().0;
    if name == "sweeps" {
        assert_eq!(procedure.loads_n.pop(), Some(0.0));
    }
    procedure
}

fn poses() -> Vec<PoseId> {
    ["P1", "P2", "P3", "P4"].map(PoseId::from).to_vec()
}

fn baseline<'a>(robot: &'a Robot, mechanism: &str, poses: &[PoseId]) -> RobotBaseline<'a> {
    let (_, factors) = robot.default_factors();
    crate::tests::baseline(robot, mechanism, factors, poses)
}

/// A bench with gauges of 1 µm and 0.1 N, a tenth of the usual noise.
fn bench<'a>(baseline: &'a RobotBaseline<'_>, poses: &'a [PoseId]) -> DesignBench<'a> {
    DesignBench {
        baseline,
        poses,
        may_be_measured: poses,
        parameters: None,
        noise: ReadingNoise {
            reading_sd_m: 0.6e-6,
            zero_sd_m: 0.5e-6,
            run_slope_sd: 5e-4,
            ..ReadingNoise::default()
        },
        steps: GaugeSteps {
            force_n: Some(0.01),
            displacement_m: Some(1e-6),
        },
        pace: Pace::default(),
        object: TestObject::Robot,
    }
}

fn report(mechanism: &str, procedure: &str) -> DesignReport {
    let (robot, poses) = (robot("hp-robot"), poses());
    let baseline = baseline(&robot, mechanism, &poses);
    let bench = bench(&baseline, &poses);
    design_of_plan(&bench, &shipped(procedure), 0).unwrap()
}

fn of_joint(law: Law, joint: &str) -> LawAtPlace {
    LawAtPlace {
        law,
        place: Place::Joint(joint.to_owned()),
    }
}

fn loose(element: &str) -> LawAtPlace {
    LawAtPlace {
        law: laws::LOOSE_MEMBER,
        place: Place::Element(element.to_owned()),
    }
}

fn together(report: &DesignReport, members: &[LawAtPlace]) -> bool {
    report
        .inseparable
        .iter()
        .any(|group| members.iter().all(|member| group.contains(member)))
}

#[test]
fn in_mechanism_a_the_end_joint_is_the_stand_and_a_turned_lateral_force_shows_nothing() {
    let report = report("A", "sweeps");
    let stand = LawAtPlace {
        law: laws::GAUGE_STAND_COMPLIANCE,
        place: Place::Direction(Direction::Y),
    };
    let end = of_joint(laws::JOINT_COMPLIANCE, "A5B");
    assert!(together(&report, &[end.clone(), stand]));
    let of_end = report.laws.iter().find(|law| law.suspect == end).unwrap();
    assert!(of_end.nearest[0].never && of_end.nearest[0].size_3.is_none());
    for toward in [Direction::Y, Direction::Z] {
        let direction = Direction::X;
        let place = Place::Toward { direction, toward };
        let turned = |unseen: &Unseen| unseen.suspect.place == place;
        assert!(report.unseen.iter().any(turned), "{place}");
    }
    assert_eq!(report.readings, 480);
    // The next: a joint in the middle of the arm is told from everything, from a size that is given.
    let middle = of_joint(laws::JOINT_COMPLIANCE, "A3");
    let of_middle = report
        .laws
        .iter()
        .find(|law| law.suspect == middle)
        .unwrap();
    let rival = &of_middle.nearest[0];
    assert!(!rival.never && rival.size_3 < rival.size_5, "{rival:?}");
}

#[test]
fn members_in_series_vanish_together() {
    let with_b = report("B", "sweeps");
    assert!(together(&with_b, &[loose("B2B3"), loose("A5B3")]));
    assert!(together(&with_b, &[loose("A3B1"), loose("B1B2")]));
    assert!(!together(&with_b, &[loose("A3B1"), loose("A5B3")]));
    // Chains C and D hardly carry: a quiet bench is needed to see them at all.
    let (robot, poses) = (robot("hp-robot"), poses());
    let baseline = baseline(&robot, "F", &poses);
    let quiet = DesignBench {
        noise: ReadingNoise {
            reading_sd_m: 1e-8,
            zero_sd_m: 1e-8,
            run_slope_sd: 1e-5,
            ..ReadingNoise::default()
        },
        steps: GaugeSteps::default(),
        ..bench(&baseline, &poses)
    };
    let with_f = design_of_plan(&quiet, &shipped("sweeps"), 0).unwrap();
    assert!(together(&with_f, &["A3C1", "C1C2", "A4C2"].map(loose)));
    assert!(together(
        &with_f,
        &["A2D1", "D1D2", "D2D3", "A3D3"].map(loose)
    ));
    assert!(together(&with_f, &["A3F4", "F4F5"].map(loose)));
}

#[test]
fn a_joint_with_the_lever_of_the_base_is_the_base() {
    // The shoulder stands above the foot: under vertical loads both have the same lever, under radial ones they have not.
    let (robot, poses) = (robot("serial-arm"), poses());
    let baseline = baseline(&robot, "A", &poses);
    let bench = bench(&baseline, &poses);
    let base = LawAtPlace {
        law: laws::BASE_COMPLIANCE,
        place: Place::Axis(Direction::X),
    };
    let pair = [of_joint(laws::JOINT_COMPLIANCE, "S2"), base];
    let mut procedure = Procedure {
        directions: vec![Direction::Y.into()],
        poses: None,
        ..shipped("sweeps")
    };
    let vertical = design_of_plan(&bench, &procedure, 0).unwrap();
    assert!(together(&vertical, &pair), "{:?}", vertical.inseparable);
    procedure.directions.push(Direction::Z.into());
    let both = design_of_plan(&bench, &procedure, 0).unwrap();
    assert!(!together(&both, &pair));
}

/// Backlash, friction with the same seat, creep, force gauge and a quadratic of joint A3 of mechanism F, 10 µm each at most, and the
/// compliance of the joint among the factors.
fn pairs_of_the_method(bench: &DesignBench<'_>, observations: &Observations) -> Projected {
    let effect = |law, place, values: &[f64]| Effect::new(law, place, values.to_vec()).unwrap();
    let joint = || Place::Joint("A3".to_owned());
    // 10 µm at a lever of 0.7 m, 3 N·m of seat and friction, 49 N·m at full load.
    let play = 1e-5 / 0.7;
    let mut list = vec![
        effect(laws::JOINT_COMPLIANCE, joint(), &[1e-9]),
        effect(laws::JOINT_BACKLASH, joint(), &[play, 3.0]),
        effect(laws::JOINT_FRICTION, joint(), &[play / 3.0, 3.0]),
        effect(laws::CREEP, Place::Structure, &[1e-3, 1.0]),
        effect(laws::FORCE_GAUGE_NONLINEARITY, Place::ForceGauge, &[1e-6]),
        effect(
            laws::JOINT_NONLINEARITY,
            joint(),
            &[1e-12, play / 49.0_f64.powi(2)],
        ),
    ];
    to_ten_micrometres(bench, observations, &mut list[3..5]);
    let effects = Effects::plain(list);
    let cells = bench.cells(&effects, observations, true).unwrap();
    bench.projected(&effects, &cells).without(0)
}

/// Scales effects to a largest change of a reading of 10 µm.
fn to_ten_micrometres(
    bench: &DesignBench<'_>,
    observations: &Observations,
    effects: &mut [Effect],
) {
    let model = bench.model();
    let bench = bench.bench(observations);
    let predicted = |effects: Vec<Effect>| {
        let with = crate::mismatch::problem::Model {
            effects,
            ..model.clone()
        };
        bench.predicted(&with).unwrap()
    };
    let without = predicted(Vec::new());
    for effect in effects {
        let with = predicted(vec![effect.clone()]);
        let changes = with.iter().zip(&without).map(|(a, b)| (a - b).abs());
        effect.values[0] *= 1e-5 / changes.fold(0.0, f64::max);
    }
}

#[test]
fn plans_compare_as_in_the_method() {
    const BACKLASH: usize = 1;
    const FRICTION: usize = 2;
    const CREEP: usize = 3;
    const GAUGE: usize = 4;
    const QUADRATIC: usize = 5;
    let (robot, poses) = (robot("hp-robot"), poses());
    let baseline = baseline(&robot, "F", &poses);
    let bench = DesignBench {
        noise: USUAL_NOISE,
        steps: GaugeSteps {
            force_n: Some(0.1),
            displacement_m: Some(1e-5),
        },
        ..bench(&baseline, &poses)
    };
    let mut both_signs = shipped("load-unload");
    both_signs
        .loads_n
        .extend((1..8).map(|step| 10.0 * f64::from(step)));
    let held = Procedure {
        holds_s: vec![60.0, 120.0],
        ..shipped("sweeps")
    };
    let plans = [
        shipped("sweeps"),
        shipped("shuffled"),
        held,
        shipped("load-unload"),
        shipped("load-hold-unload"),
        both_signs,
    ];
    let mut rows = Vec::new();
    for plan in &plans {
        let observations = bench.observations(plan).unwrap();
        let projected = pairs_of_the_method(&bench, &observations);
        let pairs = [
            (BACKLASH, FRICTION),
            (CREEP, GAUGE),
            (CREEP, FRICTION),
            (QUADRATIC, GAUGE),
        ];
        let row = pairs.map(|(a, b)| projected.expected_log_lr(a, b, true));
        let words = "J of backlash/friction, creep/gauge, creep/friction, quadratic/gauge";
        eprintln!(
            "{:17} {:4} readings, {words}: {row:.1?}",
            plan.name,
            observations.len()
        );
        // With its sign, friction is no play, even if only loaded.
        assert!(projected.expected_log_lr(BACKLASH, FRICTION, false) > 50.0);
        rows.push(row);
    }
    let [load, shuffled, held, unload, held_unload, both] = [0, 1, 2, 3, 4, 5].map(|i| rows[i]);
    // Loading alone does not distinguish play from friction, nor does a hold; shuffling does, unloading better, both signs best.
    assert!(load[0] < 0.5 && held[0] < 0.5, "{rows:?}");
    assert!(shuffled[0] > 20.0 && unload[0] > shuffled[0] && both[0] > 2.0 * unload[0]);
    // Creep needs a hold.
    for pair in [1, 2] {
        assert!(load[pair] < 0.5 && unload[pair] < 0.5, "{rows:?}");
        assert!(held[pair] > 10.0 * load[pair] && held_unload[pair] > held[pair]);
    }
}

#[test]
fn creep_under_holds_that_grow_with_the_load_is_the_force_gauge() {
    let (robot, poses) = (robot("hp-robot"), poses());
    let baseline = baseline(&robot, "A", &poses);
    let bench = bench(&baseline, &poses);
    let cosine = |hold_s: fn(f64) -> f64| {
        let loads = |_: &PoseId| -> Vec<PlannedLoad> {
            (0..40)
                .map(|place| {
                    let force_n = -10.0 * f64::from(place % 8);
                    PlannedLoad {
                        step: place % 8,
                        force_n,
                        branch: Branch::Loading,
                        repeat: place / 8 + 1,
                        hold_s: hold_s(force_n.abs()),
                        time_s: 60.0 * f64::from(place),
                        temperature_deg_c: None,
                        zero_before: place % 8 == 0,
                    }
                })
                .collect()
        };
        let cells: Vec<PlannedCell> = poses
            .iter()
            .flat_map(|pose| {
                Direction::ALL.map(|direction| PlannedCell {
                    pose: pose.clone(),
                    load: direction.into(),
                    direction,
                    loads: loads(pose),
                })
            })
            .collect();
        let observations = Observations::planned(&cells, bench.steps, None);
        let observations = bench.in_order(&observations).unwrap();
        let effects = Effects::plain(vec![
            Effect::new(laws::CREEP, Place::Structure, vec![1e-3, 1.0]).unwrap(),
            Effect::new(
                laws::FORCE_GAUGE_NONLINEARITY,
                Place::ForceGauge,
                vec![1e-6],
            )
            .unwrap(),
        ]);
        let cells = bench.cells(&effects, &observations, true).unwrap();
        bench.projected(&effects, &cells).cosine(0, 1)
    };
    // 1 + hold/t0 a power of ten in proportion to the load: exactly F |F|.
    let growing = cosine(|force_n| 10.0_f64.powf(force_n / 35.0) - 1.0);
    assert!(growing.abs() > 0.9999, "{growing}");
    let alternating = cosine(|force_n| if force_n % 20.0 == 0.0 { 60.0 } else { 5.0 });
    assert!(alternating.abs() < 0.9, "{alternating}");
}

fn pair(weight: f64) -> next::OpenPair {
    next::OpenPair {
        effects: [0, 1],
        weight,
        besides: Vec::new(),
    }
}

#[test]
fn the_next_measurement_is_short_and_distinguishes_the_rivals() {
    let (robot, poses) = (robot("hp-robot"), poses());
    let baseline = baseline(&robot, "A", &poses);
    let bench = bench(&baseline, &poses);
    let sweeps = Procedure {
        poses: Some(poses[..2].to_vec()),
        ..shipped("sweeps")
    };
    let done = bench.observations(&sweeps).unwrap();
    let effect = |law, place, values: &[f64]| Effect::new(law, place, values.to_vec()).unwrap();
    let joint = |name: &str| Place::Joint(name.to_owned());
    // Creep and the force gauge after loading only: a hold.
    let open = vec![
        effect(laws::CREEP, Place::Structure, &[3e-4, 1.0]),
        effect(laws::FORCE_GAUGE_NONLINEARITY, Place::ForceGauge, &[1.2e-6]),
    ];
    let found = next::plan_for(&bench, &done, open, &[pair(1.0)], &sweeps).unwrap();
    let next = &found[0];
    assert!(next.expected_log_lr >= Some(CAN_TELL), "{next:?}");
    let procedure = next.procedure.as_ref().unwrap();
    let again = Procedure::from_record(&procedure.to_record()).unwrap();
    assert_eq!(again, *procedure);
    assert!(!procedure.holds_s.is_empty(), "{procedure:?}");
    // The end joint and the stand: no load plan, a second gauge.
    let open = vec![
        effect(laws::JOINT_COMPLIANCE, joint("A5B"), &[1e-5]),
        effect(
            laws::GAUGE_STAND_COMPLIANCE,
            Place::Direction(Direction::Y),
            &[1e-6],
        ),
    ];
    let found = next::plan_for(&bench, &done, open, &[pair(1.0)], &sweeps).unwrap();
    assert_eq!(found.len(), 1);
    assert!(found[0].procedure.is_none() && found[0].plan.contains("second dial gauge"));
}

#[test]
fn a_pose_that_is_not_at_hand_is_refused() {
    let (robot, poses) = (robot("hp-robot"), poses());
    let baseline = baseline(&robot, "A", &poses);
    let bench = bench(&baseline, &poses);
    let elsewhere = Procedure {
        poses: Some(vec!["Q7".into()]),
        ..Procedure::default()
    };
    let refused = design_of_plan(&bench, &elsewhere, 0).unwrap_err();
    assert!(refused.to_string().contains("Q7"));
    let mechanism = robot.mechanism(Some("A")).unwrap();
    let (_, factors) = robot.default_factors();
    let at_hand = poses_at_hand(&robot, mechanism, &factors, &poses[1..]);
    assert_eq!(at_hand[..3], poses[1..]);
    assert!(at_hand.contains(&poses[0]));
}

#[test]
fn alternatives_and_near_rivals_are_open_and_other_findings_count_as_factors() {
    let effect = |law, joint: &str, values: &[f64]| {
        Effect::new(law, Place::Joint(joint.to_owned()), values.to_vec()).unwrap()
    };
    let finding = |effect: Effect, group, log_bayes, rivals| Finding {
        log_bayes,
        rivals,
        ..crate::tests::finding(effect, group)
    };
    let rival = |joint: &str, behind| Rival {
        effect: effect(laws::JOINT_COMPLIANCE, joint, &[1e-6]),
        log_bayes_to_winner: behind,
        cosine: 0.9,
    };
    let play = effect(laws::JOINT_BACKLASH, "A3", &[1e-5, 2.0]);
    let stick = effect(laws::JOINT_FRICTION, "A3", &[1e-6, 2.0]);
    let soft = effect(laws::JOINT_COMPLIANCE, "A4", &[1e-6]);
    let findings = [
        finding(play.clone(), Some(1), 20.0, Vec::new()),
        finding(stick.clone(), Some(1), 19.0, Vec::new()),
        finding(
            soft.clone(),
            None,
            40.0,
            vec![rival("A2", 2.0), rival("A5B", 30.0)],
        ),
    ];
    let (effects, pairs) = next::open_pairs(&findings);
    let titles: Vec<[String; 2]> = pairs
        .iter()
        .map(|pair| pair.effects.map(|effect| effects[effect].title()))
        .collect();
    let second = effect(laws::JOINT_COMPLIANCE, "A2", &[1e-6]).title();
    assert_eq!(
        titles,
        [[play.title(), stick.title()], [soft.title(), second]]
    );
    // e^-1 and e^-2; of the alternatives the first stands besides the other pair.
    assert!((pairs[1].weight / pairs[0].weight - (-1.0_f64).exp()).abs() < 1e-12);
    let besides = |pair: &next::OpenPair| -> Vec<String> {
        pair.besides
            .iter()
            .map(|&effect| effects[effect].title())
            .collect()
    };
    assert_eq!(besides(&pairs[0]), [soft.title()]);
    assert_eq!(besides(&pairs[1]), [play.title()]);
    assert_eq!(next::open_pairs(&[]), (Vec::new(), Vec::new()));
}
