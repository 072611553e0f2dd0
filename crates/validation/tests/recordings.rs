//! The recordings by others: all there, readable with the options that stand beside them, licensed, and with the figures that are stated.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use serde::Deserialize;
use stiffbench_measurement::specimen::{
    Scale, SpecimenAssumption, SpecimenOptions, SpecimenTable, read_specimen,
};
use stiffbench_units_and_text::test_point::Branch;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Index {
    schema: String,
    recording: Vec<Recording>,
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
struct Recording {
    name: String,
    file: String,
    licence: String,
    readings: Option<usize>,
    runs: Option<usize>,
    verdict: String,
    also_right: Vec<String>,
    physics: Vec<String>,
    not: Vec<String>,
    why: String,
    line_residual_sd: Option<f64>,
    specimen: Option<SpecimenOptions>,
    figures: BTreeMap<String, f64>,
}

fn folder() -> PathBuf {
    stiffbench_test_files::repository().join("data/recordings")
}

fn index() -> Index {
    let text = fs::read_to_string(folder().join("recordings.toml")).unwrap();
    toml::from_str(&text).unwrap()
}

fn read(recording: &Recording) -> Option<SpecimenTable> {
    let options = recording.specimen.as_ref()?;
    let file = fs::File::open(folder().join(&recording.file)).unwrap();
    Some(read_specimen(&recording.file, file, options).unwrap())
}

fn table(name: &str) -> SpecimenTable {
    let index = index();
    let recording = index.recording.iter().find(|r| r.name == name).unwrap();
    read(recording).unwrap()
}

/// Residual standard deviation of a line of the answer on the driver; of a constant if the driver never changes.
fn line_residual_sd(table: &SpecimenTable) -> f64 {
    let pairs: Vec<(f64, f64)> = table
        .readings
        .iter()
        .map(|reading| (table.driver(reading), table.answer(reading)))
        .collect();
    let n = pairs.len() as f64;
    let mean_x = pairs.iter().map(|(x, _)| x).sum::<f64>() / n;
    let mean_y = pairs.iter().map(|(_, y)| y).sum::<f64>() / n;
    let sxx: f64 = pairs.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
    let sxy: f64 = pairs.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum();
    let (slope, dof) = if sxx > 0.0 {
        (sxy / sxx, n - 2.0)
    } else {
        (0.0, n - 1.0)
    };
    let rss: f64 = pairs
        .iter()
        .map(|(x, y)| (y - mean_y - slope * (x - mean_x)).powi(2))
        .sum();
    (rss / dof).sqrt()
}

#[test]
fn every_recording_is_read_whole_and_gives_its_line() {
    let index = index();
    assert_eq!(index.schema, "stiffbench/recordings/1");
    for recording in &index.recording {
        let Some(table) = read(recording) else {
            continue;
        };
        let name = &recording.name;
        assert_eq!(Some(table.readings.len()), recording.readings, "{name}");
        assert_eq!(Some(table.runs.len()), recording.runs, "{name}");
        assert_eq!(table.excluded.to_string(), "nothing is left out", "{name}");
        let (stated, found) = (
            recording.line_residual_sd.unwrap(),
            line_residual_sd(&table),
        );
        // The stated figures have ten digits and come from another program.
        assert!(
            (found / stated - 1.0).abs() < 1e-8,
            "{name}: {found} instead of {stated}"
        );
    }
}

#[test]
fn what_is_said_about_a_recording_uses_known_words() {
    const VERDICTS: [&str; 5] = [
        "explained",
        "ambiguous",
        "unknown",
        "nothing-missing",
        "insufficient-data",
    ];
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
    for recording in index().recording {
        let name = &recording.name;
        let mut verdicts = std::iter::once(&recording.verdict).chain(&recording.also_right);
        assert!(verdicts.all(|v| VERDICTS.contains(&v.as_str())), "{name}");
        let mut physics = recording.physics.iter().chain(&recording.not);
        assert!(physics.all(|p| PHYSICS.contains(&p.as_str())), "{name}");
        let both = recording.physics.iter().find(|p| recording.not.contains(p));
        assert_eq!(both, None, "{name}");
        assert!(
            !recording.why.is_empty() && !recording.figures.is_empty(),
            "{name}"
        );
        assert!(
            recording.figures.values().all(|figure| figure.is_finite()),
            "{name}"
        );
    }
}

#[test]
fn every_folder_says_where_it_comes_from_and_under_which_licence() {
    let index = index();
    for entry in fs::read_dir(folder()).unwrap() {
        let path = entry.unwrap().path();
        if !path.is_dir() {
            continue;
        }
        let readme = fs::read_to_string(path.join("README.md")).unwrap();
        assert!(readme.contains("**Source**") && readme.contains("**Licence**"));
        let name = path.file_name().unwrap().to_str().unwrap();
        let mut of_folder = index
            .recording
            .iter()
            .filter(|r| r.file.starts_with(&format!("{name}/")))
            .peekable();
        assert!(of_folder.peek().is_some(), "{name} has no entry");
        let licence = fs::read_to_string(path.join("LICENSE"));
        for recording in of_folder {
            match recording.licence.as_str() {
                "public domain" => assert!(licence.is_err(), "{name}"),
                "MIT" => {
                    let text = licence.as_ref().unwrap();
                    assert!(text.contains("Copyright (c)"), "{name}");
                    assert!(text.contains("The above copyright notice"), "{name}");
                }
                other => panic!("{name}: {other} is not a licence that may be here"),
            }
        }
    }
}

#[test]
fn the_coupon_has_the_turns_that_are_stated() {
    let table = table("steel-coupon-cyclic");
    let turns = table.assumptions.iter().find_map(|a| match a {
        SpecimenAssumption::BranchesFromPath { turns, .. } => Some(*turns),
        _ => None,
    });
    assert_eq!(turns, Some(22));
    let unloading = table
        .readings
        .iter()
        .filter(|r| r.branch == Branch::Unloading);
    assert!(unloading.count() > 200);
}

#[test]
fn units_of_recordings_become_si() {
    let contact = table("afm-hard-contact");
    assert_eq!(contact.force_scale, Scale::Si);
    assert_eq!(contact.readings[0].displacement, 4129.0327e-9);
    assert_eq!(contact.readings[0].force, 0.0531e-9);
    assert_eq!(contact.unused_columns, ["retract_z_nm", "retract_force_nN"]);
    let bridge = table("test-bridge-load-temperature");
    assert_eq!(bridge.displacement_scale, Scale::AsInFile);
    assert_eq!(bridge.readings[0].force, 233_939.69);
    assert_eq!(bridge.readings[0].temperature_deg_c, Some(1.6));
    assert_eq!(bridge.runs[1].label, "load01");
}

#[test]
fn shuffled_concentrations_are_not_taken_for_unloading() {
    let ozone = table("nist-ozone");
    let shuffled = SpecimenAssumption::Shuffled { runs: 1, line: 2 };
    assert!(ozone.assumptions.contains(&shuffled));
    let pontius = table("nist-load-cell-pontius");
    assert!(pontius.readings.iter().all(|r| r.branch == Branch::Loading));
    assert!(!pontius.assumptions.contains(&shuffled));
}

/// Columns of a table of numbers by name; other columns are passed over.
fn numbers(path: &Path) -> BTreeMap<String, Vec<f64>> {
    let text = fs::read_to_string(path).unwrap();
    let mut lines = text.lines();
    let names: Vec<&str> = lines.next().unwrap().split(',').collect();
    let mut columns: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for line in lines {
        for (name, field) in names.iter().zip(line.split(',')) {
            if let Ok(number) = field.parse() {
                columns.entry((*name).to_owned()).or_default().push(number);
            }
        }
    }
    columns
}

#[test]
fn the_derived_columns_belong_to_the_recorded_errors() {
    let folder = folder().join("robot-pose-errors-laser-tracker");
    let grid = numbers(&folder.join("ur5_grid_1000.csv"));
    let derived = numbers(&folder.join("derived_ur5_regressors.csv"));
    let error = &derived["error_mm"];
    assert_eq!(error.len(), 3000);
    for (axis, name) in ["x_dif", "y_dif", "z_dif"].into_iter().enumerate() {
        for (pose, recorded) in grid[name].iter().enumerate() {
            assert_eq!(error[3 * pose + axis], *recorded);
        }
    }
    // The basis is orthogonal with a mean square of 1, so projecting on it needs no solver.
    let basis: Vec<&Vec<f64>> = (1..=25)
        .map(|i| &derived[&format!("rigid{i:02}")])
        .collect();
    let inner = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>() / 3000.0;
    for (i, a) in basis.iter().enumerate() {
        for (j, b) in basis.iter().enumerate() {
            let expected = f64::from(u8::from(i == j));
            assert!((inner(a, b) - expected).abs() < 1e-4, "{i} {j}");
        }
    }
    let mut left = error.clone();
    for column in basis {
        let share = inner(column, error);
        for (rest, value) in left.iter_mut().zip(column) {
            *rest -= share * value;
        }
    }
    let distances = left
        .chunks(3)
        .map(|p| p.iter().map(|v| v * v).sum::<f64>().sqrt());
    let mean = distances.sum::<f64>() / 1000.0;
    let stated = index()
        .recording
        .iter()
        .find_map(|r| r.figures.get("mean-mm-rigid").copied())
        .unwrap();
    assert!((mean / stated - 1.0).abs() < 1e-3, "{mean}");
}
