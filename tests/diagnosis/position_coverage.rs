//! How often the 95 % intervals of springs, base frame and tool point hold the truth, over simulated tables of absolute positions under own
//! weight. The long count is `cargo test --release --test stiffbench -- --ignored --nocapture a_thousand_tables_of_positions`.

use rayon::prelude::*;
use serde_json::Value;
use stiffbench_test_files::text;

use super::load_cases::interval;
use super::robots::RobotFile;
use crate::support::Json;
use crate::support::tables::Table;

/// Compliances of the six joints, rad/(N·m).
const TRUE: [f64; 6] = [1.2e-6, 0.8e-6, 1.1e-6, 3e-6, 3.5e-6, 6e-6];

/// A hundred positions; a coordinate scatters as that of a good tracker some metres away does. The truth is not where the fit begins.
const PLAN: &str = "--positions 100 --repeats 1 --reading-sd-um 20";

/// What is known of a quantity after a table: its error and the half width of its 95 % interval.
struct Known {
    name: String,
    error: f64,
    half_width: f64,
}

/// Errors of what a table determines, and root mean square errors of the rigid robot and of the fit in poses left out, µm.
struct Counted {
    known: Vec<Known>,
    rms_um: Option<[f64; 2]>,
}

/// Fits a simulated table.
///
/// # Arguments
/// - `leave_out`: whether each pose is to be left out in turn.
fn count(robot: &RobotFile, seed: u64, leave_out: bool) -> Counted {
    let springs = TRUE.iter().enumerate();
    let springs: Vec<String> = springs
        .map(|(joint, c)| format!("joint.J{}={c:e}", joint + 1))
        .collect();
    let options = format!(
        "{} {PLAN} --true-factor {} --seed {seed}",
        robot.option(),
        springs.join(",")
    );
    let (table, truth) = Table::simulated_with_truth(&options, &[]);
    let poses: Vec<&str> = (0..table.len())
        .map(|row| table.word(row, "pose"))
        .collect();
    let fit = if leave_out {
        robot.fit(&table, "")
    } else {
        robot.fit(&table, &format!("--train {}", poses.join(",")))
    };
    let unseen = |value: &Value| value.as_f64().filter(|_| leave_out);
    let own = unseen(&fit["rms"]["unseen_um"]);
    let rigid = unseen(&fit["frames"]["rigid_unseen_um"]);
    Counted {
        known: springs_of(&fit)
            .chain(frames_of(&fit, &truth["tracker"]))
            .collect(),
        rms_um: own.zip(rigid).map(|(own, rigid)| [rigid, own]),
    }
}

/// Springs with an interval: that of the first joint turns about the vertical, and weight does not load it.
fn springs_of(fit: &Value) -> impl Iterator<Item = Known> {
    let joints = TRUE.into_iter().enumerate();
    joints.filter_map(|(joint, truth)| {
        let name = format!("joint.J{}", joint + 1);
        let estimate = fit["parameters"].named(&name);
        let is_open = estimate["status"] == "not_identified";
        assert_eq!(is_open, joint == 0, "{estimate}");
        let [low, high] = interval(&estimate["ci95"]).filter(|_| !is_open)?;
        Some(Known {
            name,
            error: 0.5 * (low + high) - truth,
            half_width: 0.5 * (high - low),
        })
    })
}

/// Three numbers.
fn vector(value: &Value) -> [f64; 3] {
    [0, 1, 2].map(|axis| value[axis].number())
}

/// The rotation about a vector by its length, in degrees (Rodrigues).
fn rotation(degrees: [f64; 3]) -> [[f64; 3]; 3] {
    let vector = degrees.map(f64::to_radians);
    let angle = vector.iter().map(|one| one * one).sum::<f64>().sqrt();
    let [x, y, z] = vector.map(|one| one / angle);
    let (s, c) = angle.sin_cos();
    let t = 1.0 - c;
    [
        [c + t * x * x, t * x * y - s * z, t * x * z + s * y],
        [t * x * y + s * z, c + t * y * y, t * y * z - s * x],
        [t * x * z - s * y, t * y * z + s * x, c + t * z * z],
    ]
}

/// Base frame, its rotation by the small rotation between the fitted and the true, and tool point; µm and µrad.
fn frames_of(fit: &Value, truth: &Value) -> impl Iterator<Item = Known> {
    let fitted = &fit["frames"];
    let rows = fitted["rotation"].list();
    let (a, b) = (
        [0, 1, 2].map(|i| vector(&rows[i])),
        rotation(vector(&truth["rotation_vector_deg"])),
    );
    // Of a small rotation the vector is the antisymmetric part of the matrix.
    let turned = |i: usize, j: usize| (0..3).map(|k| a[i][k] * b[j][k]).sum::<f64>();
    let turn = [(2, 1), (0, 2), (1, 0)].map(|(i, j)| 0.5e6 * (turned(i, j) - turned(j, i)));
    let less = |key: &str| {
        let (a, b) = (vector(&fitted[key]), vector(&truth[key]));
        [0, 1, 2].map(|i| 1e3 * (a[i] - b[i]))
    };
    let errors = [less("base_mm"), turn, less("tool_point_mm")];
    let known = fitted["parameters"].list().iter();
    let known: Vec<Known> = known
        .zip(errors.as_flattened())
        .filter_map(|(parameter, error)| {
            Some(Known {
                name: parameter["name"].as_str()?.to_owned(),
                error: *error,
                half_width: parameter["half_width_95"].as_f64()?,
            })
        })
        .collect();
    known.into_iter()
}

/// Shares of intervals that hold the truth, by name; and the share of all.
fn coverage(tables: &[Counted]) -> (Vec<(String, f64)>, f64) {
    let mut counts: Vec<(String, usize, usize)> = Vec::new();
    for one in tables.iter().flat_map(|table| &table.known) {
        let place = counts.iter().position(|(name, ..)| *name == one.name);
        let place = place.unwrap_or_else(|| {
            counts.push((one.name.clone(), 0, 0));
            counts.len() - 1
        });
        counts[place].1 += usize::from(one.error.abs() <= one.half_width);
        counts[place].2 += 1;
    }
    let share = |hits: usize, of: usize| hits as f64 / of as f64;
    let (hits, of) = counts
        .iter()
        .fold((0, 0), |(a, b), (_, hits, of)| (a + hits, b + of));
    let by_name = counts.iter();
    let by_name = by_name.map(|(name, hits, of)| (name.clone(), share(*hits, *of)));
    (by_name.collect(), share(hits, of))
}

fn arm() -> RobotFile {
    RobotFile::new(text("fixtures/elastic-calibration/arm.toml"))
}

fn study(tables: u64) -> Vec<Counted> {
    let robot = arm();
    let seeds = (0..tables).into_par_iter();
    seeds.map(|seed| count(&robot, seed, false)).collect()
}

#[test]
fn intervals_of_springs_and_frames_hold_the_truth() {
    let tables = study(40);
    let (by_name, all) = coverage(&tables);
    // Five springs and the nine coordinates of the frames; weight does not load the first joint.
    assert_eq!(by_name.len(), 14, "{by_name:?}");
    assert!((0.9..0.99).contains(&all), "{all} {by_name:?}");
    let [rigid, own] = count(&arm(), 1_000, true).rms_um.unwrap();
    assert!(own < 25.0 && rigid > 20.0 * own, "{rigid} {own}");
}

#[test]
#[ignore = "a minute or two; `just nightly` runs it"]
fn a_thousand_tables_of_positions() {
    let tables = study(1_000);
    let (by_name, all) = coverage(&tables);
    for (name, share) in &by_name {
        println!("{name:14} {:5.1} %", 100.0 * share);
    }
    println!("all            {:5.1} %", 100.0 * all);
    let robot = arm();
    let seeds = (1_000..1_020_u64).into_par_iter();
    let errors: Vec<[f64; 2]> = seeds
        .map(|seed| count(&robot, seed, true).rms_um.unwrap())
        .collect();
    let mean = |of: usize| errors.iter().map(|one| one[of]).sum::<f64>() / errors.len() as f64;
    println!(
        "in poses left out: rigid robot {:.0} um, fit {:.1} um",
        mean(0),
        mean(1)
    );
    assert!((0.93..0.97).contains(&all), "{all}");
    for (name, share) in by_name {
        assert!((0.93..0.97).contains(&share), "{name}: {share}");
    }
}
