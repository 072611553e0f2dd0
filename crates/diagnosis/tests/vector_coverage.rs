//! How often the intervals of a fit to the vector table hold the truth: sessions of a virtual bench with one gauge, value for value as loads
//! and displacements along the base axes. Beside them the intervals of the same readings as a session. The long count is `cargo test
//! --release -p stiffbench-diagnosis -- --ignored --nocapture a_thousand_vector_tables`.

#![expect(clippy::print_stdout, reason = "a study shows what it counted")]

use rayon::prelude::*;

use stiffbench_beams::physics::ActingPhysics;
use stiffbench_beams::robot::{FittingFactors, Robot};
use stiffbench_diagnosis::elastostatics::{
    LoadCaseFitOptions, LoadCaseModel, PosedLoadCases, fit_load_cases,
};
use stiffbench_diagnosis::fit::{
    FactorEstimate, FitOptions, FitProblem, MeasuredStiffness, fit_cells,
};
use stiffbench_measurement::load_cases::LoadCaseTable;
use stiffbench_measurement::procedure::Procedure;
use stiffbench_measurement::readings::{Reading, VectorReading, VectorTable};
use stiffbench_measurement::stiffness::{GaugePair, Method, StiffnessOptions, stiffness_table};
use stiffbench_simulation::{Jack, NoiseModel, VirtualBench};
use stiffbench_test_files::{shipped_robot, text};
use stiffbench_units_and_text::source_text::SourceText;
use stiffbench_units_and_text::test_point::Direction;

/// A reading along one axis as vectors.
fn as_vectors(reading: &Reading) -> VectorReading {
    let along = |axis: Direction| axis == reading.direction;
    let run = format!("{}.{}.{}", reading.pose, reading.direction, reading.repeat);
    VectorReading {
        line: reading.line,
        seq: reading.seq,
        pose: reading.pose.clone(),
        direction: reading.direction.to_string(),
        branch: reading.branch,
        step: reading.step,
        repeat: reading.repeat,
        attempt: 1,
        status: reading.status,
        target_n: reading.target_n,
        joints: Vec::new(),
        force_n: Direction::ALL.map(|axis| if along(axis) { reading.force_n } else { 0.0 }),
        displacement_m: Direction::ALL.map(|axis| along(axis).then_some(reading.displacement_m)),
        zero: run.clone(),
        run,
        time_s: reading.time_s,
        hold_s: reading.hold_s,
        temperature_deg_c: reading.temperature_deg_c,
        utc: String::new(),
        force_raw: String::new(),
        force_zero_n: None,
        displacement_raw: <[String; 3]>::default(),
        displacement_zero_m: [None; 3],
        flag: String::new(),
        note: String::new(),
    }
}

fn vector_table(readings: &[Reading]) -> VectorTable {
    VectorTable {
        source: "readings.csv".to_owned(),
        origin: None,
        names: Vec::new(),
        joints: Vec::new(),
        rows: Vec::new(),
        readings: readings.iter().map(as_vectors).collect(),
    }
}

/// The four beam factors of the vector table, and of the session.
fn estimates(robot: &Robot, procedure: &Procedure, seed: u64) -> [Vec<FactorEstimate>; 2] {
    let mechanism = robot.mechanism(Some("A")).unwrap();
    let (_, start) = robot.default_factors();
    let physics = ActingPhysics::new(robot, mechanism, Vec::new()).unwrap();
    let (noise, jack) = (NoiseModel::default(), Jack::default());
    let bench = VirtualBench::new(robot, &physics, &start, noise, jack).unwrap();
    let session = bench.run(procedure, "vectors", seed).unwrap();
    let preload_n = procedure.preload_n;
    let table = LoadCaseTable::of_runs(&vector_table(&session.readings), preload_n).unwrap();
    let posed = PosedLoadCases::new(robot, mechanism, &table).unwrap();
    let model = LoadCaseModel {
        robot,
        mechanism,
        start: &start,
        posed: &posed,
    };
    let vectors = fit_load_cases(&model, &LoadCaseFitOptions::default()).unwrap();
    let table = stiffness_table(
        &session.readings,
        &GaugePair::default(),
        StiffnessOptions::default(),
    );
    let measured = MeasuredStiffness::from_table(&table, Method::Regression);
    let problem = FitProblem {
        robot,
        mechanism,
        measured: &measured,
        start: &start,
        physics: None,
    };
    let cells = fit_cells(&problem, &FitOptions::default()).unwrap();
    [vectors.estimates, cells.estimates]
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
    fn add(&mut self, estimate: &FactorEstimate, truth: f64) {
        if let Some([low, high]) = estimate.interval_95 {
            let parts = estimate.parts_95();
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
        stiffbench_numeric::statistics::median(&mut widths).unwrap()
    }
}

/// Counts of each beam factor, of vector tables and of sessions.
fn study(sessions: u64) -> Vec<[Count; 2]> {
    let robot = Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap();
    let path = "protocols/procedures/load-unload.toml";
    let (procedure, _) = Procedure::parse(&SourceText::new(path, text(path))).unwrap();
    let (_, truth): (_, FittingFactors) = robot.default_factors();
    let all: Vec<_> = (0..sessions)
        .into_par_iter()
        .map(|seed| estimates(&robot, &procedure, seed))
        .collect();
    let counts = (0..4).map(|place| {
        let mut counts = [Count::default(), Count::default()];
        for session in &all {
            for (count, estimates) in counts.iter_mut().zip(session) {
                count.add(&estimates[place], truth.beam[place]);
            }
        }
        let [vectors, cells] = &counts;
        println!(
            "{}: vector table {} of {} hold the truth, median width {:.3}; session {} of {}, {:.3}",
            all[0][0][place].name,
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
