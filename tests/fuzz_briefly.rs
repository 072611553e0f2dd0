//! The bodies of the fuzz targets for a moment: files and packets of this repository, changed at random.
//!
//! `just fuzz TARGET` runs them for as long as one likes, led by coverage; here they run the same few thousand inputs every time, or as many as
//! `STIFFBENCH_FUZZ_INPUTS` says.

#![expect(
    clippy::unwrap_used,
    clippy::expect_used,
    reason = "a test stops at what is not as it must be"
)]

use std::fs;
use std::path::Path;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

#[path = "../fuzz/bodies/instrument_bytes.rs"]
mod instrument_bytes;
#[path = "../fuzz/bodies/instrument_description.rs"]
mod instrument_description;
#[path = "../fuzz/bodies/journal.rs"]
mod journal;
#[path = "../fuzz/bodies/readings_csv.rs"]
mod readings_csv;
#[path = "../fuzz/bodies/robot_file.rs"]
mod robot_file;
#[path = "../fuzz/bodies/robot_import.rs"]
mod robot_import;
#[path = "../fuzz/bodies/session_toml.rs"]
mod session_toml;
#[path = "../fuzz/bodies/table_import.rs"]
mod table_import;

/// Inputs of each target, where nothing else is said: some seconds in a release build.
const INPUTS: u64 = 3000;

/// Longest input, bytes.
const LONGEST: usize = 6000;

/// Changes an input somewhere: a byte, a piece left out, a piece twice, a cut end.
fn change(bytes: &mut Vec<u8>, random: &mut ChaCha8Rng) {
    if bytes.is_empty() {
        bytes.push(random.random());
        return;
    }
    let at = random.random_range(0..bytes.len());
    let end = (at + random.random_range(1..40)).min(bytes.len());
    match random.random_range(0..6) {
        0 => bytes[at] = random.random(),
        1 => bytes[at] ^= 1 << random.random_range(0..8),
        2 => drop(bytes.drain(at..end)),
        3 => {
            let piece = bytes[at..end].to_vec();
            bytes.splice(at..at, piece);
        }
        4 => bytes.truncate(at),
        _ => bytes.insert(at, random.random()),
    }
}

/// Runs a target on changed copies of files, all of it repeatable.
fn briefly(seed: u64, files: &[Vec<u8>], prefix: usize, run: fn(&[u8])) {
    assert!(!files.is_empty(), "there is nothing to begin with");
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let wanted = std::env::var("STIFFBENCH_FUZZ_INPUTS");
    let inputs = wanted.map_or(INPUTS, |inputs| inputs.parse().unwrap());
    for _ in 0..inputs {
        let mut bytes = files[random.random_range(0..files.len())].clone();
        bytes.truncate(LONGEST);
        for _ in 0..random.random_range(1..6) {
            change(&mut bytes, &mut random);
        }
        // What a target chooses by its first bytes is chosen freely.
        let mut input: Vec<u8> = (0..prefix).map(|_| random.random()).collect();
        input.extend(bytes);
        run(&input);
    }
}

/// Files below a folder of the repository whose names end so.
fn files(folder: &str, ending: &str) -> Vec<Vec<u8>> {
    fn collect(folder: &Path, ending: &str, found: &mut Vec<std::path::PathBuf>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                collect(&path, ending, found);
            } else if path.to_string_lossy().ends_with(ending) {
                found.push(path);
            }
        }
    }
    let mut found = Vec::new();
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    collect(&root.join(folder), ending, &mut found);
    // The order of a folder is the system's.
    found.sort();
    found.iter().map(|path| fs::read(path).unwrap()).collect()
}

#[test]
fn bytes_of_gauges() {
    briefly(
        1,
        &files("fixtures/instruments", ""),
        3,
        instrument_bytes::run,
    );
}

#[test]
fn descriptions_of_instruments() {
    let descriptions = files("protocols/instruments", ".toml");
    briefly(2, &descriptions, 0, instrument_description::run);
}

#[test]
fn journals() {
    // A body seals its lines itself; what it begins with are events as they are written.
    let events = fs::read(concat!(
        env!("CARGO_MANIFEST_DIR"),
        "/docs/session-folder.md"
    ))
    .unwrap();
    let journal = br#"{"seq":1,"utc":"1970-01-01T00:00:00Z","t_s":0.0,"kind":"note","data":{"cell":0,"text":"bolt tightened"}"#;
    briefly(3, &[events, journal.to_vec()], 0, journal::run);
}

#[test]
fn tables_of_readings() {
    briefly(4, &files("data/sessions", ".csv"), 0, readings_csv::run);
}

#[test]
fn tables_of_other_programs() {
    briefly(8, &files("fixtures/imports", ""), 1, table_import::run);
}

#[test]
fn headers_of_sessions() {
    briefly(
        5,
        &files("data/sessions", "session.toml"),
        0,
        session_toml::run,
    );
}

#[test]
fn robot_files() {
    let mut robots = files("data/robots", ".toml");
    robots.extend(files("data/templates", ".toml"));
    briefly(6, &robots, 0, robot_file::run);
}

#[test]
fn urdfs_and_tables_of_joints() {
    let mut sources = files("fixtures/urdf", ".urdf");
    sources.push(super::robot_new::TABLE.as_bytes().to_vec());
    briefly(7, &sources, 0, robot_import::run);
}
