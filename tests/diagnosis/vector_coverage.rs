//! How often the intervals of a fit to the vector table hold the truth: sessions of a virtual bench with one gauge, value for value as loads
//! and displacements along the base axes. Beside them the intervals of the same readings as a session. The long count is `cargo test
//! --release --test stiffbench -- --ignored --nocapture a_thousand_vector_tables`.

#![expect(clippy::print_stdout, reason = "a study shows what it counted")]

use std::fmt::Write as _;

use rayon::prelude::*;
use serde_json::Value;
use tempfile::TempDir;

use crate::support::Json;
use crate::support::tables::{Table, json};

/// The robot and mechanism of the bench, with the factors of the file.
const MODEL: &str = "--robot hp-robot --mechanism A";

/// The factors that are counted, with their true values.
const TRUTH: [(&str, f64); 4] = [
    ("beam.A", 0.002_997),
    ("beam.Iy", 0.004_857),
    ("beam.Iz", 0.964_219),
    ("beam.J", 1.0),
];

/// Where a table of vectors states the force at which its gauges were zeroed.
const SESSION: &str = "schema = \"stiffbench/session/2\"\n[procedure]\npreload_N = -1.0\n";

/// The same readings, each along its axis as vectors.
fn as_vectors(table: &Table) -> String {
    let same = [
        "seq",
        "t_s",
        "pose",
        "direction",
        "branch",
        "step",
        "target_N",
        "repeat",
        "hold_s",
        "temp_degC",
    ];
    let axes = ["x", "y", "z"];
    let mut text = format!(
        "{},run,zero_id,axes,force_x_N,force_y_N,force_z_N,displacement_x_um,displacement_y_um,displacement_z_um\n",
        same.join(",")
    );
    for row in 0..table.len() {
        let word = |column: &str| table.word(row, column);
        let direction = word("direction");
        let run = format!("{}.{direction}.{}", word("pose"), word("repeat"));
        let along = |column: &'static str, otherwise: &'static str| {
            axes.map(|axis| {
                if axis == direction {
                    word(column)
                } else {
                    otherwise
                }
            })
        };
        let vectors = [along("force_N", "0"), along("displacement_um", "")].concat();
        let (same, vectors) = (same.map(word).join(","), vectors.join(","));
        let _ = writeln!(text, "{same},{run},{run},base,{vectors}");
    }
    text
}

/// The fitted parameters of the vector table, and of the session.
fn fits(seed: u64) -> [Value; 2] {
    let options = format!("{MODEL} --procedure load-unload --seed {seed}");
    let session = Table::simulated(&options, &[]);
    let desk = TempDir::new().unwrap();
    let write = |name: &str, text: &str| std::fs::write(desk.path().join(name), text).unwrap();
    write("readings.csv", &as_vectors(&session));
    write("session.toml", SESSION);
    write("session.csv", &session.text());
    ["readings.csv", "session.csv"].map(|name| {
        let file = desk.path().join(name);
        json(&format!("fit {} {MODEL}", file.display()), &[])["data"]["parameters"].take()
    })
}

/// What is counted of a parameter.
#[derive(Debug, Default)]
struct Count {
    held: usize,
    stated: usize,
    /// Widths as shares of the truth.
    widths: Vec<f64>,
}

impl Count {
    fn add(&mut self, parameters: &Value, name: &str, truth: f64) {
        let one = parameters.named(name);
        let ends = |interval: &Value| [0, 1].map(|end| interval[end].number());
        if one["ci95"].is_array() {
            let [low, high] = ends(&one["ci95"]);
            let islands = one["islands"].list().iter();
            let mut parts: Vec<[f64; 2]> = islands.map(ends).collect();
            if parts.is_empty() {
                parts.push([low, high]);
            }
            let holds = |[low, high]: &[f64; 2]| (*low..=*high).contains(&truth);
            self.held += usize::from(parts.iter().any(holds));
            self.stated += 1;
            self.widths.push((high - low) / truth);
        }
    }

    fn share(&self) -> f64 {
        self.held as f64 / self.stated as f64
    }

    fn width(&self) -> f64 {
        let mut widths = self.widths.clone();
        stiffbench::statistics::median(&mut widths).unwrap()
    }
}

/// Counts of each beam factor, of vector tables and of sessions.
fn study(sessions: u64) -> Vec<[Count; 2]> {
    let all: Vec<[Value; 2]> = (0..sessions).into_par_iter().map(fits).collect();
    let counts = TRUTH.into_iter().map(|(name, truth)| {
        let mut counts = [Count::default(), Count::default()];
        for session in &all {
            for (count, parameters) in counts.iter_mut().zip(session) {
                count.add(parameters, name, truth);
            }
        }
        let [vectors, cells] = &counts;
        println!(
            "{name}: vector table {} of {} hold the truth, median width {:.3}; session {} of {}, {:.3}",
            vectors.held,
            vectors.stated,
            vectors.width(),
            cells.held,
            cells.stated,
            cells.width()
        );
        counts
    });
    counts.collect()
}

#[test]
fn intervals_of_the_vector_table_are_those_of_the_session() {
    for [vectors, cells] in study(40) {
        // 95 % of 40 has a standard error of 3.4 %.
        assert!(vectors.share() > 0.85, "{vectors:?}");
        let ratio = vectors.width() / cells.width();
        assert!((0.8..1.25).contains(&ratio), "{ratio}");
    }
}

#[test]
#[ignore = "some minutes; `just nightly` runs it"]
fn a_thousand_vector_tables() {
    for [vectors, cells] in study(1000) {
        assert!((0.93..=0.97).contains(&vectors.share()), "{vectors:?}");
        let ratio = vectors.width() / cells.width();
        assert!((0.9..1.1).contains(&ratio), "{ratio}");
    }
}
