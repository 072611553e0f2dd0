//! The figures of `diagnose` and `prove`, checked as in `figures.rs` and written to `target/figures-check/`, to be checked.
//!
//! All numbers are made up with seeded noise: a dead zone at one joint over a stiff bench, as large as a shop would meet it, and the
//! crowded cases that must stay readable.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use stiffbench_figures::{
    Bar, BeforeAfterPoint, CandidateDecision, CurveShape, DetectionLimitBar, DetectionLimits,
    DrivingQuantity, EvidenceBars, EvidenceCandidate, FactorShift, FactorValue, FoundLaw,
    HeldOutError, HeldOutPose, LawCurve, LawPanel, LawPoint, LawPower, MapLoadStep, MapValue,
    MismatchMap, PowerAtSize, PowerCurves, Quantities, Rate, ResidualMeasure, ResidualsAgainst,
    ResidualsBeforeAfter, RunSummary, ShiftedFactor, detection_limits, evidence_bars, factor_shift,
    found_law, held_out_error, mismatch_map, power_curves, residuals_before_after,
};
use stiffbench_units_and_text::test_point::{Branch, Cell, Direction};

use crate::support::{check, noise};

const PHYSICS: [&str; 14] = [
    "joint-compliance",
    "joint-backlash",
    "joint-friction",
    "joint-nonlinearity",
    "base-compliance",
    "gauge-stand-compliance",
    "load-misalignment",
    "loose-member",
    "force-gauge-nonlinearity",
    "creep",
    "thermal-drift",
    "setting-in",
    "slip",
    "gauge-periodic",
];
const POSES: [&str; 6] = ["P1", "P2", "P3", "P4", "P5", "P6"];
const FOUND: &str = "joint-backlash at A3";

/// Loads of a run: up to -70 N and back.
fn load_steps() -> Vec<MapLoadStep> {
    let step = |size: i32, branch| MapLoadStep {
        target_n: -10.0 * f64::from(size),
        branch,
    };
    let up = (0..8).map(|size| step(size, Branch::Loading));
    let down = (0..7).rev().map(|size| step(size, Branch::Unloading));
    up.chain(down).collect()
}

/// What play leaves after a linear fit, in units of itself: too little at small loads, too much at large ones.
fn left_by_play(target_n: f64) -> f64 {
    let share = target_n / -70.0;
    if share == 0.0 {
        0.0
    } else {
        -(1.0 - 1.4 * share)
    }
}

fn map(poses: usize, by_pose: bool, measure: ResidualMeasure) -> MismatchMap {
    let mut random = ChaCha8Rng::seed_from_u64(7);
    let unit = match measure {
        ResidualMeasure::Micrometres => 6e-6,
        ResidualMeasure::StandardUncertainties => 1.0,
    };
    let mut cells: Vec<Cell> = POSES[..poses]
        .iter()
        .flat_map(|pose| Direction::ALL.map(|direction| (*pose, direction)))
        .map(|(pose, direction)| Cell::new(pose.into(), direction))
        .collect();
    if !by_pose {
        cells.sort_by_key(|cell| cell.direction);
    }
    let size = |cell: &Cell| match (cell.direction, cell.pose.as_str()) {
        (Direction::Y, "P3") => 9.5,
        (Direction::Y, _) => 3.0,
        (Direction::Z, "P3") => 2.0,
        _ => 0.0,
    };
    let load_steps = load_steps();
    let mut value = |value: f64, n: usize| {
        Some(MapValue {
            value: unit * (value + noise(&mut random)),
            n,
        })
    };
    let mut by_load_step: Vec<Vec<Option<MapValue>>> = cells
        .iter()
        .map(|cell| {
            let entry = |step: &MapLoadStep| value(size(cell) * left_by_play(step.target_n), 5);
            load_steps.iter().map(entry).collect()
        })
        .collect();
    for (row, first) in [(1, 8), (4, 0), (7, 12)] {
        by_load_step[row][first..].fill(None);
    }
    let by_run = cells
        .iter()
        .map(|cell| (0..5).map(|_| value(0.3 * size(cell), 15)).collect())
        .collect();
    MismatchMap {
        prediction: "fitted beam structure".to_owned(),
        measure,
        cells,
        load_steps,
        by_load_step,
        repeats: (1..=5).collect(),
        run_summary: RunSummary::SlopeAtLargestLoad,
        by_run,
    }
}

#[test]
fn where_residuals_sit() {
    let standardised = map(4, true, ResidualMeasure::StandardUncertainties);
    check("mismatch-map", &mismatch_map(&standardised));
    let six = map(6, false, ResidualMeasure::Micrometres);
    check("mismatch-map-six-poses", &mismatch_map(&six));
    let mut both_signs = map(6, true, ResidualMeasure::StandardUncertainties);
    let steps = load_steps();
    let pushed = steps.iter().map(|step| MapLoadStep {
        target_n: -step.target_n,
        ..*step
    });
    both_signs.load_steps = steps.iter().copied().chain(pushed).collect();
    for row in &mut both_signs.by_load_step {
        let again = row.clone();
        row.extend(again);
    }
    check("mismatch-map-both-signs", &mismatch_map(&both_signs));
    let mut small = map(4, true, ResidualMeasure::StandardUncertainties);
    small.cells.truncate(2);
    small.load_steps.truncate(3);
    small.repeats.truncate(1);
    small.run_summary = RunSummary::Mean;
    check("mismatch-map-small", &mismatch_map(&small));
}

fn readings(against: ResidualsAgainst) -> ResidualsBeforeAfter {
    let mut random = ChaCha8Rng::seed_from_u64(8);
    let mut points = Vec::new();
    for place in 0..4 {
        for direction in Direction::ALL {
            let scale = [30.0, 8.0, 1.0][direction.index()];
            for _ in 0..5 {
                for step in load_steps() {
                    let sequence = points.len();
                    let noise_sd_m = 1e-6 * scale * (1.0 + 0.01 * step.target_n.abs());
                    let after_m = noise_sd_m * noise(&mut random);
                    let size_m = if direction == Direction::Y {
                        40e-6
                    } else {
                        4e-6
                    };
                    let share = if place == 2 { 1.0 } else { 0.4 };
                    points.push(BeforeAfterPoint {
                        direction,
                        target_n: step.target_n,
                        force_n: step.target_n + 0.2 * noise(&mut random),
                        sequence,
                        before_m: after_m + share * size_m * left_by_play(step.target_n),
                        after_m,
                        noise_sd_m: Some(noise_sd_m),
                        flagged: sequence % 211 == 17,
                    });
                }
            }
        }
    }
    ResidualsBeforeAfter {
        quantities: Quantities::default(),
        found: FOUND.to_owned(),
        against,
        points,
    }
}

#[test]
fn residuals_before_and_after_the_found_effects() {
    let by_force = readings(ResidualsAgainst::Force);
    check("before-after", &residuals_before_after(&by_force));
    let by_order = readings(ResidualsAgainst::Order);
    check("before-after-order", &residuals_before_after(&by_order));
    let mut one = readings(ResidualsAgainst::Force);
    one.points.retain(|point| point.direction == Direction::Y);
    check("before-after-one", &residuals_before_after(&one));
}

fn point(at: f64, residual_m: f64, branch: Branch, random: &mut ChaCha8Rng) -> LawPoint {
    LawPoint {
        at,
        residual_m: residual_m + 1.5e-6 * noise(random),
        bar_m: Some(2.0e-6),
        n: 5,
        branch,
        flagged: false,
    }
}

/// A loop of half width `size_m` that opens on reversal.
fn friction_loop(size_m: f64, force_n: f64, branch: Branch) -> f64 {
    match branch {
        Branch::Loading => size_m * (force_n / -20.0).min(1.0),
        Branch::Unloading => size_m * (1.0 - (force_n + 70.0) / 20.0).max(-1.0),
    }
}

#[test]
fn a_law_over_the_readings() {
    let mut random = ChaCha8Rng::seed_from_u64(9);
    let cells = [
        ("P3 y", 22.0),
        ("P1 y", 9.0),
        ("P2 y", 14.0),
        ("P4 y", 6.0),
        ("P3 z", 4.0),
        ("P1 z", 2.0),
        ("P1 x", 1.0),
    ];
    let panels = cells.map(|(heading, size_um)| {
        let size_m = 1e-6 * size_um;
        let at = |step: &MapLoadStep| {
            (
                step.target_n,
                friction_loop(size_m, step.target_n, step.branch),
            )
        };
        let steps = load_steps();
        LawPanel {
            heading: heading.to_owned(),
            points: steps
                .iter()
                .map(|step| {
                    let (force_n, law_m) = at(step);
                    point(force_n, law_m, step.branch, &mut random)
                })
                .collect(),
            curves: vec![LawCurve {
                name: "law as fitted".to_owned(),
                shape: CurveShape::Loop,
                points: steps.iter().map(at).map(|(x, y)| [x, y]).collect(),
            }],
        }
    });
    let mut law = FoundLaw {
        quantities: Quantities::default(),
        found: "joint-friction at A3".to_owned(),
        driving: DrivingQuantity::Force,
        bar: Bar::StandardUncertainty,
        panels: panels.to_vec(),
    };
    check("found-law-loops", &found_law(&law));
    law.panels.truncate(4);
    check("found-law-four", &found_law(&law));
}

/// Name of the figure, what was found, what drives it, where, and the law.
type Driven = (
    &'static str,
    &'static str,
    DrivingQuantity,
    Vec<f64>,
    CurveShape,
    fn(f64) -> f64,
);

#[test]
fn laws_of_every_driving_quantity() {
    let mut random = ChaCha8Rng::seed_from_u64(10);
    let mut pooled = |found: &str, driving, values: Vec<f64>, shape, law: &dyn Fn(f64) -> f64| {
        let points = values
            .iter()
            .map(|at| point(*at, law(*at), Branch::Loading, &mut random))
            .collect();
        let (first, last) = (values[0], values[values.len() - 1]);
        let curve = (0..=200).map(|i| first + (last - first) * f64::from(i) / 200.0);
        FoundLaw {
            quantities: Quantities::default(),
            found: found.to_owned(),
            driving,
            bar: Bar::StandardUncertainty,
            panels: vec![LawPanel {
                heading: "all cells".to_owned(),
                points,
                curves: vec![
                    LawCurve {
                        name: "law as fitted".to_owned(),
                        shape,
                        points: curve.clone().map(|x| [x, law(x)]).collect(),
                    },
                    LawCurve {
                        name: "straight rival".to_owned(),
                        shape: CurveShape::Line,
                        points: curve.map(|x| [x, 0.8 * law(last) * x / last]).collect(),
                    },
                ],
            }],
        }
    };
    let steps = |step: f64, count: i32| (0..count).map(|i| step * f64::from(i)).collect();
    let line = CurveShape::Line;
    let slip: fn(f64) -> f64 = |f| if f <= -40.0 { -18e-6 } else { 0.0 };
    let period: fn(f64) -> f64 = |d| 4e-6 * (std::f64::consts::TAU * d / 200e-6).sin();
    #[rustfmt::skip]
    let laws: [Driven; 5] = [
        ("clock", "thermal-drift", DrivingQuantity::Clock, steps(90.0, 40), line, |t| 5e-9 * t),
        ("hold", "creep", DrivingQuantity::Hold, vec![0.0, 5.0, 15.0, 30.0, 60.0, 120.0], line, |t| -12e-6 * (1.0 + t / 2.0).log10()),
        ("repeat", "setting-in", DrivingQuantity::Repeat, (1..=5).map(f64::from).collect(), line, |n| -15e-6 * (-(n - 1.0) / 1.2).exp()),
        ("displacement", "gauge-periodic", DrivingQuantity::Displacement, steps(-12e-6, 60), line, period),
        ("steps", "slip in P1 y, repeat 3", DrivingQuantity::Force, steps(-10.0, 8), CurveShape::Steps, slip),
    ];
    for (name, found, driving, values, shape, law) in laws {
        let figure = found_law(&pooled(found, driving, values, shape, &law));
        check(&format!("found-law-{name}"), &figure);
    }
}

fn candidate(name: &str, log_bayes_factor: f64, standing: CandidateDecision) -> EvidenceCandidate {
    EvidenceCandidate {
        name: name.to_owned(),
        log_bayes_factor,
        standing,
    }
}

#[test]
fn evidence_for_candidates() {
    let impossible = |reason: &str| CandidateDecision::Impossible {
        reason: reason.to_owned(),
    };
    let few = vec![
        candidate(FOUND, 41.3, CandidateDecision::Named),
        candidate("joint-friction at A3", 39.6, CandidateDecision::Rival),
        candidate(
            "joint-compliance at A5B",
            47.2,
            impossible("negative compliance"),
        ),
        candidate(
            "force-gauge-nonlinearity at gauge force",
            28.9,
            CandidateDecision::Rival,
        ),
        candidate("joint-nonlinearity at A3", 26.0, CandidateDecision::Rival),
        candidate(
            "load-misalignment of y toward z",
            3.1,
            CandidateDecision::Rival,
        ),
        candidate("creep", -1.8, CandidateDecision::Rival),
        candidate("thermal-drift", -3.9, CandidateDecision::Rival),
        candidate("slip", f64::NEG_INFINITY, CandidateDecision::Rival),
    ];
    check(
        "evidence",
        &evidence_bars(&EvidenceBars {
            candidates: few,
            alike_within: 5.0,
        }),
    );
    let strong = PHYSICS.iter().enumerate().flat_map(|(i, physics)| {
        ["A3", "B1B2"].map(|place| {
            let value = 9800.0 / (1.0 + i as f64) - if place == "A3" { 0.0 } else { 1.4 };
            let standing = match (i, place) {
                (0, "A3") => CandidateDecision::Named,
                (3, _) => impossible("softens and stiffens at once, q beyond its bound"),
                _ => CandidateDecision::Rival,
            };
            candidate(&format!("{physics} at {place}"), value, standing)
        })
    });
    let strong = EvidenceBars {
        candidates: strong.collect(),
        alike_within: 5.0,
    };
    check("evidence-strong", &evidence_bars(&strong));
    let nothing = PHYSICS
        .iter()
        .enumerate()
        .map(|(i, physics)| candidate(physics, 0.4 - 0.35 * i as f64, CandidateDecision::Rival));
    let nothing = EvidenceBars {
        candidates: nothing.collect(),
        alike_within: 5.0,
    };
    check("evidence-nothing-missing", &evidence_bars(&nothing));
}

#[test]
fn error_in_poses_left_out() {
    let pose = |place: usize, before: f64, after: f64| HeldOutPose {
        pose: POSES[place].into(),
        before,
        after,
        n: 225,
    };
    let mut input = HeldOutError {
        found: FOUND.to_owned(),
        poses: vec![
            pose(0, 5.6, 1.02),
            pose(1, 4.1, 1.1),
            pose(2, 12.0, 1.3),
            pose(3, 1.2, 1.25),
        ],
    };
    check("held-out", &held_out_error(&input));
    input.poses = vec![
        pose(0, 3100.0, 6.6),
        pose(1, 225.0, 9.0),
        pose(2, 18_000.0, 61.0),
        pose(3, 7.0, 7.0),
        pose(4, 950.0, 5.8),
        pose(5, 80.0, 6.0),
    ];
    check("held-out-wide", &held_out_error(&input));
}

#[test]
fn power_of_the_search() {
    // Wilson's interval, as a stand-in for the exact one.
    let rate = |share: f64, n: f64| {
        let z2 = 1.96_f64 * 1.96;
        let centre = (share + z2 / (2.0 * n)) / (1.0 + z2 / n);
        let half = 1.96 * (share * (1.0 - share) / n + z2 / (4.0 * n * n)).sqrt() / (1.0 + z2 / n);
        Rate {
            share,
            ci95: Some([centre - half, centre + half]),
        }
    };
    let law = |name: &str, slower: f64| LawPower {
        name: name.to_owned(),
        sizes: [0.0, 1.75, 3.5, 4.5, 6.0, 7.0, 14.0]
            .into_iter()
            .map(|size: f64| {
                let grows = |middle: f64| 1.0 / (1.0 + (-(size - middle) / 0.55).exp());
                let hits = |share: f64| (share * 200.0).round() / 200.0;
                PowerAtSize {
                    size_standard_errors: size,
                    trials: 200,
                    detected: rate(hits((0.04 + grows(2.8)).min(1.0)), 200.0),
                    named: (size > 0.0).then(|| rate(hits(grows(slower)), 200.0)),
                    ideal: (size > 2.0).then(|| grows(slower - 0.2)),
                    covered: (size > 2.0).then(|| rate(hits(0.95), 200.0)),
                }
            })
            .collect(),
    };
    let mut laws: Vec<LawPower> = PHYSICS
        .iter()
        .enumerate()
        .map(|(i, physics)| law(physics, 3.0 + 0.15 * i as f64))
        .collect();
    laws[8].name = "force-gauge-nonlinearity at gauge force".to_owned();
    check("power", &power_curves(&PowerCurves { laws: laws.clone() }));
    laws.truncate(1);
    check("power-one", &power_curves(&PowerCurves { laws }));
}

#[test]
fn factors_before_and_after_the_found_effects() {
    let value = |value: f64, half: Option<f64>| FactorValue {
        value,
        ci95: half.map(|half| [value / half, value * half]),
    };
    let factor = |name: &str, before: FactorValue, after: FactorValue| ShiftedFactor {
        name: name.to_owned(),
        before,
        after,
    };
    let figure = factor_shift(&FactorShift {
        found: FOUND.to_owned(),
        factors: vec![
            factor("beam A", value(0.0021, Some(1.25)), value(0.003, Some(1.1))),
            factor(
                "beam Iy",
                value(0.0045, Some(1.04)),
                value(0.0049, Some(1.02)),
            ),
            factor("beam Iz", value(0.93, Some(1.03)), value(0.964, Some(1.02))),
            factor("beam J", value(1.0, None), value(1.0, None)),
        ],
    });
    check("factor-shift", &figure);
}

#[test]
fn limits_of_detection() {
    let mut limits = Vec::new();
    for (i, physics) in PHYSICS.iter().enumerate() {
        let places: &[&str] = match *physics {
            "force-gauge-nonlinearity" => &["gauge force"],
            "creep" | "thermal-drift" | "setting-in" | "slip" => &[""],
            "gauge-stand-compliance" => &["x", "y", "z"],
            "load-misalignment" => &["x toward y", "y toward z", "z toward y"],
            _ => &["A1", "A3", "A5B", "B1B2", "C2", "D1"],
        };
        for (k, place) in places.iter().enumerate() {
            let lost = physics.starts_with("joint") && k == 5 || *physics == "loose-member";
            let end_effect_um = 2.3 * (1.0 + i as f64 / 5.0) * 2.2f64.powi(k as i32);
            limits.push(DetectionLimitBar {
                law: (*physics).to_owned(),
                place: (*place).to_owned(),
                end_effect_m: (!lost).then_some(1e-6 * end_effect_um),
            });
        }
    }
    let figure = detection_limits(&DetectionLimits {
        reading: Quantities::default().reading,
        limits,
        reading_sd_m: Some(6e-6),
    });
    check("detection-limits", &figure);
}
