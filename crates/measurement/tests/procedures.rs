//! Procedure files: what is shipped, what is refused and where, and that plans survive the way to a file and back.

use std::collections::BTreeMap;

use miette::Diagnostic;
use proptest::prelude::*;
use stiffbench_measurement::procedure::{Procedure, ProcedureError, Settle, shuffled};
use stiffbench_measurement::readings::{
    JointColumn, JointUnit, LoadOrder, PoseJoints, ReadingLimits, RepeatOrder, SessionHeader,
    ZeroScope,
};
use stiffbench_test_files::{shipped_procedure, shipped_procedures};
use stiffbench_units_and_text::load_direction::LoadDirection;
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::test_point::{Branch, Direction, PoseId};

fn shipped(name: &str) -> Procedure {
    let (procedure, warnings) = Procedure::parse(&shipped_procedure(name).unwrap()).unwrap();
    assert!(warnings.is_empty(), "{name}: {warnings:?}");
    procedure
}

fn parse(keys: &str) -> Result<(Procedure, Vec<String>), ProcedureError> {
    let text = format!("schema = \"stiffbench/procedure/1\"\n{keys}");
    Procedure::parse(&SourceText::new("plans/mine.toml", text))
}

#[test]
fn shipped_procedures_stand_under_their_names() {
    for name in shipped_procedures() {
        assert_eq!(shipped(name).name, name);
    }
}

#[test]
fn the_papers_procedure_is_literal() {
    // Section IV-C: four poses, three directions, -10 to -70 N, each load five times, the dial gauge zeroed after a light press.
    let expected = Procedure {
        name: "paper".to_owned(),
        text: shipped("paper").text,
        poses: Some(["P1", "P2", "P3", "P4"].map(PoseId::new).to_vec()),
        repeat_order: RepeatOrder::AtLoad,
        zero: ZeroScope::Cell,
        ..Procedure::default()
    };
    assert_eq!(shipped("paper"), expected);
    assert_eq!(expected.steps(0).len(), 40);
}

#[test]
fn the_other_procedures_differ_from_the_sweeps_in_one_thing_each() {
    let sweeps = shipped("sweeps");
    let named = |name: &str, other: Procedure| Procedure {
        name: name.to_owned(),
        text: shipped(name).text,
        ..other
    };
    let back_to_zero = Procedure {
        loads_n: sweeps.loads_n.clone(),
        ..Procedure::default()
    };
    assert_eq!(sweeps, named("sweeps", back_to_zero));
    let (last_n, others_n) = sweeps.loads_n.split_last().unwrap();
    assert_eq!(
        (*last_n, others_n),
        (0.0, Procedure::default().loads_n.as_slice())
    );
    let load_unload = Procedure {
        unloading: true,
        ..Procedure::default()
    };
    assert_eq!(
        shipped("load-unload"),
        named("load-unload", load_unload.clone())
    );
    let held = Procedure {
        holds_s: vec![60.0, 120.0],
        ..load_unload
    };
    assert_eq!(shipped("load-hold-unload"), named("load-hold-unload", held));
    let shuffled = Procedure {
        load_order: LoadOrder::Shuffled,
        seed: 1,
        ..Procedure::default()
    };
    assert_eq!(shipped("shuffled"), named("shuffled", shuffled));
}

#[test]
fn readings_of_twelve_cells() {
    // Readings of four poses and three directions, as in the comparison of plans that the procedures come from.
    for (name, readings) in [
        ("paper", 480),
        ("sweeps", 540),
        ("load-unload", 900),
        ("load-hold-unload", 1020),
        ("shuffled", 480),
    ] {
        let procedure = shipped(name);
        let planned: usize = (0..12).map(|cell| procedure.steps(cell).len()).sum();
        assert_eq!(planned, readings, "{name}");
    }
}

#[test]
fn the_documented_example_plans_as_documented() {
    let page = stiffbench_test_files::text("docs/procedure-file.md");
    let example = page.split("```toml\n").nth(1).unwrap();
    let example = example.split("```").next().unwrap();
    let (procedure, warnings) = Procedure::parse(&SourceText::new("example", example)).unwrap();
    assert!(warnings.is_empty());
    let targets: Vec<f64> = procedure.steps(0)[..11]
        .iter()
        .map(|r| r.target_n)
        .collect();
    let expected = [
        0.0, -20.0, -40.0, -40.0, -20.0, 0.0, 20.0, 40.0, 40.0, 20.0, 0.0,
    ];
    assert_eq!(targets, expected);
    assert_eq!(procedure.steps(0).len(), 33);
}

#[test]
fn what_a_file_leaves_out_takes_its_default() {
    let (procedure, warnings) = parse("").unwrap();
    let expected = Procedure {
        name: "mine".to_owned(),
        ..Procedure::default()
    };
    assert_eq!((procedure, warnings), (expected, Vec::new()));
    // The default of the zero follows the order, that of the preload the loads.
    let (at_load, _) = parse("repeat_order = \"at-load\"\nloads_N = [0, 20]").unwrap();
    assert_eq!((at_load.zero, at_load.preload_n), (ZeroScope::Cell, 1.0));
    // A byte order mark is not part of the text.
    let text = "\u{feff}schema = \"stiffbench/procedure/1\"\nname = \"bom\"";
    let (procedure, _) = Procedure::parse(&SourceText::new("f", text)).unwrap();
    assert_eq!(procedure.name, "bom");
}

#[test]
fn other_units_and_both_signs_are_taken() {
    let (procedure, _) = parse(
        "loads_kN = [0, -0.01, -0.02, 0.01, 0.02]\nholds_min = [1, 2]\n[settle]\nspread_mm = 0.003\nslope_um_per_s = 1",
    )
    .unwrap();
    assert_eq!(procedure.loads_n, [0.0, -10.0, -20.0, 10.0, 20.0]);
    assert_eq!(procedure.holds_s, [60.0, 120.0]);
    assert_eq!(procedure.settle.spread_m, 3e-6);
    assert_eq!(procedure.settle.slope_m_per_s, 1e-6);
}

#[test]
fn unknown_keys_warn_with_line_and_advice() {
    let (_, warnings) = parse("repeat = 3\n[settle]\ndwel_s = 1\ncolour = \"red\"").unwrap();
    assert_eq!(
        warnings,
        [
            "plans/mine.toml:2:1: key `repeat` is not known and was not used; is `repeats` meant?",
            "plans/mine.toml:4:1: key `settle.dwel_s` is not known and was not used; is `settle.dwell_s` meant?",
            "plans/mine.toml:5:1: key `settle.colour` is not known and was not used",
        ]
    );
}

#[test]
fn values_that_cannot_be_read_are_shown_in_place() {
    for (keys, words) in [
        ("loads_N = 10", ["`loads_N` is `10`", "an array"]),
        ("name = \"x\"\nrepeats = -1", ["`repeats`", "whole number"]),
        ("zero = \"sometimes\"", ["`zero`", "\"cell\" or \"run\""]),
        ("loads_N = [0, nan]", ["`loads_N`", "finite"]),
        ("loads_mm = [1]", ["`loads_mm`", "kN"]),
        ("poses = [1]", ["`poses`", "text in quotes"]),
        (
            "[settle]\ndwell_s = \"long\"",
            ["`settle.dwell_s`", "a number"],
        ),
        ("repeats = ", [":2:", ""]),
    ] {
        let error = parse(keys).unwrap_err();
        assert_eq!(error.file, "plans/mine.toml");
        assert_eq!(error.line, 1 + keys.lines().count(), "{keys}");
        let message = error.to_string();
        assert!(words.iter().all(|word| message.contains(word)), "{message}");
        assert_eq!(
            error.code().unwrap().to_string(),
            "stiffbench::procedure::file"
        );
        assert!(error.help().is_some() && error.source_code().is_some());
        assert_eq!(error.labels().unwrap().count(), 1);
    }
    for (text, word) in [
        ("name = \"x\"", "no `schema`"),
        ("schema = \"stiffbench/session/1\"", "stiffbench/session/1"),
        ("schema = \"stiffbench/procedure/9\"", "supports up to"),
        (
            "schema = \"stiffbench/procedure/0\"",
            "expected `stiffbench/procedure/",
        ),
    ] {
        let error = Procedure::parse(&SourceText::new("f", text)).unwrap_err();
        let code = error.code().unwrap().to_string();
        assert_eq!(code, "stiffbench::procedure::file", "{error}");
        assert!(error.to_string().contains(word), "{error}");
    }
}

/// Holds that a file with these keys is refused for that reason, with the key marked on that line.
fn refused(keys: &str, line: usize, expected: &str) {
    let error = parse(keys).unwrap_err();
    let code = error.code().unwrap().to_string();
    assert!(code.starts_with("stiffbench::procedure::"), "{code}");
    assert!(error.help().is_some() && error.source_code().is_some());
    let message = error.to_string();
    assert_eq!(error.line, line, "{message}");
    assert!(message.contains(expected), "{keys}: {message}");
    let marked = error.labels().and_then(|mut labels| labels.next());
    assert!(
        marked.is_some_and(|label| !label.is_empty()),
        "{keys}: the key is marked"
    );
}

#[test]
fn lists_that_cannot_be_followed_are_shown_in_place() {
    for (keys, line, key) in [
        ("poses = []", 2, "poses"),
        ("directions = []", 2, "directions"),
        ("loads_kN = []", 2, "loads"),
        ("\nbranches = []", 3, "branches"),
    ] {
        refused(keys, line, &format!("`{key}` lists nothing"));
    }
    let twice = "`poses` lists P1 twice";
    refused("poses = [\"P1\", \"P2\", \"P1\"]", 2, twice);
    refused(
        "name = \"n\"\ndirections = [\"x\", \"x\"]",
        3,
        "`directions` lists x twice",
    );
    refused(
        "branches = [\"unloading\"]",
        2,
        "`branches` has no \"loading\"",
    );
    refused("loads_N = [0, -0.0]", 2, "`loads` are all zero");
    for (keys, hold_s, after_s) in [
        ("holds_s = [0]", 0.0, 0.0),
        ("holds_s = [60, 60]", 60.0, 60.0),
    ] {
        refused(
            keys,
            2,
            &format!("`holds` has {hold_s} s behind {after_s} s"),
        );
    }
}

#[test]
fn orders_that_contradict_each_other_are_shown_in_place() {
    for (keys, expected) in [
        (
            "repeat_order = \"at-load\"\nbranches = [\"loading\", \"unloading\"]",
            "each load is released before the next",
        ),
        (
            "load_order = \"shuffled\"\nbranches = [\"loading\", \"unloading\"]",
            "a shuffled order goes up and down anyway",
        ),
        (
            "repeat_order = \"at-load\"\nzero = \"run\"",
            "the runs take turns at every load",
        ),
    ] {
        refused(keys, 3, expected);
    }
}

#[test]
fn numbers_that_cannot_be_followed_are_shown_in_place() {
    refused("repeats = 0", 2, "`repeats` is 0");
    let too_long = "34359738360 readings in one pose and direction, more than 100000";
    refused("repeats = 4294967295", 2, too_long);
    let negative = "`settle.force_tolerance` is -0.5 (SI), below zero";
    refused("[settle]\n# here\nforce_tolerance_N = -0.5", 4, negative);
    refused("force_tolerance_N = -0.5", 2, negative);
    // A number that no file can hold, but a program can.
    let not_finite = Procedure {
        preload_n: f64::INFINITY,
        ..Procedure::default()
    };
    let problem = not_finite.check().unwrap_err();
    assert_eq!(
        problem.to_string(),
        "`preload` is inf: a finite number is needed"
    );
    assert!(problem.help().is_some());
}

#[test]
fn the_preload_turns_with_the_loads() {
    let pulled = Procedure::default().with_loads(vec![0.0, 10.0, -10.0]);
    assert_eq!((pulled.preload_n, pulled.loads_n.len()), (1.0, 3));
}

/// Numbers that a file keeps: at most nine digits.
fn decimal(digits: std::ops::RangeInclusive<i64>, places: i32) -> impl Strategy<Value = f64> {
    digits.prop_map(move |digits| {
        // Through text, so that the number is the nearest to its digits.
        format!("{digits}e-{places}").parse().unwrap()
    })
}

prop_compose! {
    fn any_settle()(
        force_tolerance_n in decimal(0..=5000, 3),
        dwell_s in decimal(0..=60_000, 3),
        spread_m in decimal(0..=99_999, 8),
        slope_m_per_s in decimal(0..=99_999, 9),
    ) -> Settle {
        Settle { force_tolerance_n, dwell_s, spread_m, slope_m_per_s }
    }
}

/// Axes, a direction against one, a vector, and one with a name of the user's own.
fn some_directions() -> Vec<LoadDirection> {
    let mut directions = LoadDirection::axes();
    directions.push("-y".parse().unwrap());
    directions.push(LoadDirection::from_vector([0.36, -0.48, 0.8]).unwrap());
    let oblique = LoadDirection::from_vector([0.28, 0.0, 0.96]).unwrap();
    directions.push(oblique.named("the \"long\" way = 1"));
    directions
}

/// Joint values of up to two poses: a turning joint, and a sliding one.
fn any_joint_values() -> impl Strategy<Value = Vec<PoseJoints>> {
    let values = (decimal(-360_000..=360_000, 3), decimal(-99_999..=99_999, 5));
    proptest::collection::vec(values, 0..3).prop_map(|poses| {
        let joint = |variable: &str, unit| JointColumn {
            variable: variable.to_owned(),
            unit,
        };
        let poses = poses.into_iter().enumerate();
        poses
            .map(|(i, (angle_deg, length_m))| PoseJoints {
                pose: PoseId::new(&format!("pose \"{i}\"")),
                values: vec![
                    (joint("J1", JointUnit::Angle), angle_deg.to_radians()),
                    (joint("s", JointUnit::Length), length_m),
                ],
            })
            .collect()
    })
}

prop_compose! {
    /// Procedures that can be followed.
    fn any_procedure()(
        name in "[^\\x00]{0,12}",
        text in proptest::option::of("(?s).{0,30}"),
        joint_values in any_joint_values(),
        n_poses in proptest::option::of(1_usize..5),
        directions in proptest::sample::subsequence(some_directions(), 1..=6).prop_shuffle(),
        displacement_axes in proptest::sample::subsequence(Direction::ALL.to_vec(), 0..=3),
        loads_n in proptest::collection::vec(decimal(-99_999..=99_999, 3), 1..12),
        kind in 0..4,
        zero_of_cell: bool,
        seed: u64,
        repeats in 1_u32..6,
        preload_n in decimal(-5000..=5000, 3),
        mut holds_s in proptest::collection::btree_set(1_u32..3600, 0..4),
        settle in any_settle(),
        force_hard_n in proptest::option::of(1_u32..500),
    ) -> Procedure {
        let mut loads_n = loads_n;
        loads_n.push(-70.0);
        let (repeat_order, load_order) = match kind {
            0 | 1 => (RepeatOrder::Sweep, LoadOrder::Ascending),
            2 => (RepeatOrder::Sweep, LoadOrder::Shuffled),
            _ => (RepeatOrder::AtLoad, if seed % 2 == 0 { LoadOrder::Ascending } else { LoadOrder::Shuffled }),
        };
        let at_load = repeat_order == RepeatOrder::AtLoad;
        Procedure {
            name,
            text,
            joint_values,
            poses: n_poses.map(|n| (0..n).map(|i| PoseId::new(&format!("pose \"{i}\""))).collect()),
            directions,
            displacement_axes,
            loads_n,
            unloading: kind == 1,
            repeats,
            repeat_order,
            load_order,
            seed,
            zero: if zero_of_cell || at_load { ZeroScope::Cell } else { ZeroScope::Run },
            preload_n,
            holds_s: std::mem::take(&mut holds_s).into_iter().map(f64::from).collect(),
            settle,
            specimens: force_hard_n.map(|n| format!("A{n}")).into_iter().collect(),
            limits: ReadingLimits {
                force_hard_n: force_hard_n.map(f64::from),
                displacement_warn_m: Some(0.25e-3),
                ..ReadingLimits::default()
            },
            answer_within_s: force_hard_n
                .map(|time_s| ("sign-check".to_owned(), f64::from(time_s)))
                .into_iter()
                .collect(),
        }
    }
}

/// How often each number stands in a list, by its bits.
fn counts(numbers: impl Iterator<Item = f64>) -> BTreeMap<u64, usize> {
    let mut counts = BTreeMap::new();
    for number in numbers {
        *counts.entry(number.to_bits()).or_insert(0) += 1;
    }
    counts
}

proptest! {
    #[test]
    fn a_plan_survives_the_way_to_a_file_and_back(procedure in any_procedure()) {
        let text = procedure.to_toml();
        let (again, warnings) = Procedure::parse(&SourceText::new("f", text.as_str())).unwrap();
        prop_assert_eq!(&again, &procedure, "{}", text);
        prop_assert!(warnings.is_empty());
        for line in text.lines().filter(|line| line.contains("loads_N") || line.contains("spread_um")) {
            prop_assert!(line.contains('#'), "{}", line);
        }
    }

    #[test]
    fn a_plan_survives_the_header_of_a_session(procedure in any_procedure()) {
        let header = SessionHeader {
            procedure: Some(procedure.to_record()),
            ..SessionHeader::default()
        };
        let read = SessionHeader::from_toml("session.toml", &header.to_toml()).unwrap();
        prop_assert!(read.unknown_keys.is_empty());
        let again = Procedure::from_record(&read.header.procedure.unwrap()).unwrap();
        prop_assert_eq!(again, procedure);
    }

    #[test]
    fn every_load_is_set_as_often_as_it_should(procedure in any_procedure(), cell in 0_u32..50) {
        let steps = procedure.steps(cell);
        let largest_n = procedure.loads_n.iter().fold(0.0_f64, |largest, n| largest.max(n.abs()));
        for repeat in 1..=procedure.repeats {
            let run: Vec<_> = steps.iter().filter(|r| r.repeat == repeat).collect();
            let set: Vec<_> = run.iter().filter(|r| r.extra_hold_s.is_none()).collect();
            prop_assert!(run[0].starts_run && run.iter().filter(|r| r.starts_run).count() == 1);
            // Steps count on from 0, and extra holds stay on the step and load they follow.
            for (step, reading) in (0..).zip(&set) {
                prop_assert_eq!(reading.step, step);
            }
            for pair in run.windows(2).filter(|pair| pair[1].extra_hold_s.is_some()) {
                prop_assert_eq!((pair[0].step, pair[0].target_n), (pair[1].step, pair[1].target_n));
                prop_assert_eq!(pair[1].target_n.abs(), largest_n);
            }
            let held = set.iter().filter(|r| r.target_n.abs() == largest_n).count();
            prop_assert_eq!(run.len() - set.len(), held * procedure.holds_s.len());
            let listed = counts(procedure.loads_n.iter().copied());
            let targets = counts(set.iter().map(|r| r.target_n));
            if procedure.unloading {
                // What is listed is set at least as often, and nothing else but the 0 of the way back.
                prop_assert!(targets.keys().all(|n| listed.contains_key(n) || *n == 0.0_f64.to_bits()));
                prop_assert!(listed.keys().all(|n| targets.contains_key(n)));
            } else {
                prop_assert_eq!(targets, listed);
            }
            if procedure.repeat_order == RepeatOrder::AtLoad {
                prop_assert!(run.iter().all(|r| r.branch == Branch::Loading));
            }
        }
        let zeros = steps.iter().filter(|r| r.zero_before).count();
        let expected = if procedure.zero == ZeroScope::Cell { 1 } else { procedure.repeats as usize };
        prop_assert_eq!(zeros, expected);
        prop_assert!(steps[0].zero_before);
    }

    #[test]
    fn one_way_there_and_the_same_back(loads in proptest::collection::vec(1_u32..1000, 1..10), pushed: bool) {
        // Loads of one sign behind a 0: up through all, back through all but the last.
        let sign = if pushed { -1.0 } else { 1.0 };
        let mut loads_n = vec![0.0];
        loads_n.extend(loads.into_iter().map(|n| sign * f64::from(n)));
        let n = loads_n.len();
        let procedure = Procedure {
            loads_n: loads_n.clone(),
            unloading: true,
            repeats: 1,
            ..Procedure::default()
        };
        let targets: Vec<f64> = procedure.steps(0).iter().map(|r| r.target_n).collect();
        prop_assert_eq!(&targets[..n], &loads_n[..]);
        let back: Vec<f64> = targets[n - 1..].iter().rev().copied().collect();
        prop_assert_eq!(back, loads_n);
    }

    #[test]
    fn a_shuffled_order_is_a_permutation(n in 0_usize..40, seed: u64, cell: u32, run: u32) {
        let members: Vec<usize> = (0..n).collect();
        let mut order = shuffled(&members, seed, cell, run);
        order.sort_unstable();
        prop_assert_eq!(order, members);
    }

    #[test]
    fn no_text_makes_the_reader_panic(text in "(?s).{0,200}", keys in "[a-z_N]{1,12} = [\\[\\]\"a-z0-9,. -]{0,20}") {
        let _ = Procedure::parse(&SourceText::new("f", text));
        let _ = parse(&keys);
    }
}

#[test]
fn limits_and_times_for_answers_are_read_with_their_units() {
    let text = "schema = \"stiffbench/procedure/1\"\n[limits]\nforce_hard_kN = 0.08\ndisplacement_warn_mm = 0.5\n[answer_within]\nsetup_min = 10\nsign-check_s = 30\n";
    let source = SourceText::new("mine.toml", text);
    let (procedure, warnings) = Procedure::parse(&source).unwrap();
    assert_eq!(warnings, Vec::<String>::new());
    assert_eq!(procedure.limits.force_hard_n, Some(80.0));
    assert_eq!(procedure.limits.displacement_warn_m, Some(0.5e-3));
    let times = [("setup".to_owned(), 600.0), ("sign-check".to_owned(), 30.0)];
    assert_eq!(procedure.answer_within_s, times);
    for (changed, says) in [
        (
            text.replace("setup_min = 10", "setup_min = 0"),
            "answer_within",
        ),
        (
            text.replace("[answer_within]", "force_warn_N = 90\n[answer_within]"),
            "beyond the hard limit",
        ),
        (text.replace("setup_min = 10", "setup = 10"), "setup_s"),
    ] {
        let error = Procedure::parse(&SourceText::new("mine.toml", changed)).unwrap_err();
        let text = format!("{error:?} {error}");
        assert!(text.contains(says), "{says}: {text}");
    }
}

#[test]
fn a_mistyped_direction_of_a_procedure_has_the_one_that_was_meant() {
    let text = "schema = \"stiffbench/procedure/1\"\ndirections = [\"diagnal\"]\n[load_directions]\ndiagonal = [0.7071, 0, 0.7071]\n";
    let error = Procedure::parse(&SourceText::new("mine.toml", text)).unwrap_err();
    assert!(
        error.to_string().contains("did you mean `diagonal`?"),
        "{error}"
    );
    let axis = text.replace("diagnal", "vertcal");
    let error = Procedure::parse(&SourceText::new("mine.toml", axis)).unwrap_err();
    assert!(error.to_string().contains("did you mean `y`?"), "{error}");
}
