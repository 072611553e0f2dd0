//! How often the intervals of a fit, and of the stiffness it starts from, hold the truth: sessions of a virtual bench, few poses, few runs.
//!
//! The true factors are those of the robot file, each times or divided by 1, 1.4 or 2. The short form runs with the other tests; the whole
//! one is `cargo test --release -p stiffbench-diagnosis -- --ignored --nocapture a_thousand_sessions`.

#![expect(clippy::print_stdout, reason = "a study shows what it counted")]

use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::support::{acting, fit, hp_robot, table};
use stiffbench_beams::robot::{FittingFactors, ModelParameter, Robot};
use stiffbench_diagnosis::fit::{
    CellModel, FactorStatus, FitOptions, FitOutcome, MeasuredStiffness,
};
use stiffbench_diagnosis::parameters::{FitRole, ParameterChoice};
use stiffbench_measurement::procedure::Procedure;
use stiffbench_measurement::readings::Reading;
use stiffbench_measurement::stiffness::{Method, StiffnessTable};
use stiffbench_numeric::statistics::binomial_interval_95;
use stiffbench_simulation::{Jack, NoiseModel, VirtualBench};
use stiffbench_units_and_text::test_point::{Cell, PoseId};

/// One kind of session.
#[derive(Debug, Clone, Copy)]
struct Kind {
    /// Poses that are fitted.
    train: &'static [&'static str],
    /// Runs a cell.
    repeats: u32,
    /// Whether the slopes of runs scatter twice as much in half of the cells.
    uneven: bool,
}

impl Kind {
    fn poses(self) -> Vec<PoseId> {
        self.train.iter().map(|pose| PoseId::new(pose)).collect()
    }

    /// The three cells of one pose are too few for four factors: A is known there.
    fn choice(self) -> ParameterChoice {
        let mut choice = ParameterChoice::default();
        if self.train.len() == 1 {
            choice.set(&ModelParameter::CLASSES[0], FitRole::Fixed);
        }
        choice
    }
}

/// Poses of the training sets.
const TRAINING: [&[&str]; 4] = [
    &["P1"],
    &["P1", "P3"],
    &["P1", "P2", "P3"],
    &["P1", "P2", "P3", "P4"],
];

/// One session and its fit.
struct Trial {
    truth: FittingFactors,
    table: StiffnessTable,
    /// True stiffness of each cell of the table, N/m.
    stiffness: Vec<f64>,
    outcome: FitOutcome,
}

/// Factors of the beams, each free one times or divided by 1, 1.4 or 2.
fn truth(start: &FittingFactors, kind: Kind, seed: u64) -> FittingFactors {
    let mut random = ChaCha8Rng::seed_from_u64(2_000_000 + seed);
    let mut factors = start.clone();
    for (factor, chosen) in factors.beam.iter_mut().zip(kind.choice().members) {
        if chosen.role != FitRole::Free {
            continue;
        }
        let size: f64 = *[1.0, 1.4, 2.0].choose(&mut random).unwrap();
        *factor *= if random.random() { size } else { 1.0 / size };
    }
    factors
}

/// Readings of a session; the cells of an uneven one come from two benches.
fn readings(robot: &Robot, factors: &FittingFactors, kind: Kind, seed: u64) -> Vec<Reading> {
    let physics = acting(robot, Some("F"), &[]);
    let procedure = Procedure {
        repeats: kind.repeats,
        poses: Some(kind.poses()),
        ..Procedure::default()
    };
    let run = |noise: NoiseModel, seed: u64| {
        let bench = VirtualBench::new(robot, &physics, factors, noise, Jack::default()).unwrap();
        bench.run(&procedure, "s", seed).unwrap().readings
    };
    let even = NoiseModel::default();
    if !kind.uneven {
        return run(even, seed);
    }
    let with = |share: f64| NoiseModel {
        run_slope_sd: share * even.run_slope_sd,
        ..even
    };
    let [quiet, loud] = [run(with(1.0), seed), run(with(2.0), seed + 1_000_000)];
    let mut random = ChaCha8Rng::seed_from_u64(3_000_000 + seed);
    let mut from: Vec<(Cell, bool)> = Vec::new();
    let mut mixed = Vec::new();
    for (quiet, loud) in quiet.into_iter().zip(loud) {
        let cell = quiet.cell();
        let known = from.iter().find(|(known, _)| *known == cell);
        let is_loud = if let Some((_, loud)) = known {
            *loud
        } else {
            let loud = random.random();
            from.push((cell, loud));
            loud
        };
        mixed.push(if is_loud { loud } else { quiet });
    }
    mixed
}

fn trial(robot: &Robot, kind: Kind, seed: u64) -> Trial {
    let mechanism = robot.mechanism(Some("F")).unwrap();
    let (_, start) = robot.default_factors();
    let truth = truth(&start, kind, seed);
    let table = table(&readings(robot, &truth, kind, seed));
    let measured = MeasuredStiffness::from_table(&table, Method::Regression);
    let options = FitOptions {
        train: Some(kind.poses()),
        choice: kind.choice(),
        ..FitOptions::default()
    };
    let outcome = fit(robot, (Some("F"), None), &measured, &options).unwrap();
    let cells: Vec<Cell> = table.cells.iter().map(|row| row.cell.clone()).collect();
    let mut model = CellModel::new(robot, mechanism, &[], &cells).unwrap();
    let stiffness = model.stiffness(&truth).unwrap();
    Trial {
        truth,
        table,
        stiffness,
        outcome,
    }
}

/// Hits among trials.
#[derive(Debug, Clone, Copy, Default)]
struct Count {
    hits: usize,
    trials: usize,
}

impl Count {
    fn add(&mut self, hit: bool) {
        self.hits += usize::from(hit);
        self.trials += 1;
    }

    fn share(self) -> f64 {
        self.hits as f64 / self.trials as f64
    }

    fn text(self) -> String {
        let [low, high] = binomial_interval_95(self.hits, self.trials).unwrap_or([0.0, 1.0]);
        format!(
            "{:5.1} % of {:5} ({:.1} to {:.1})",
            100.0 * self.share(),
            self.trials,
            100.0 * low,
            100.0 * high
        )
    }
}

/// What a study of one kind of session counts.
#[derive(Debug, Default)]
struct Study {
    /// Intervals without gaps, by factor.
    factors: [Count; 4],
    /// Intervals of several islands.
    islands: Count,
    /// Scatter between runs over its true size, root mean square, in sessions with islands and in others, and how many these are: islands
    /// part where the scatter is taken for too small.
    scatter: [(f64, usize); 2],
    /// Factors that have no interval.
    not_stated: Count,
    /// Stiffness of cells.
    cells: Count,
    /// Fits without degrees of freedom for an interval.
    without: usize,
}

impl Study {
    fn stated(&self) -> Count {
        let mut all = self.islands;
        for factor in self.factors {
            all.hits += factor.hits;
            all.trials += factor.trials;
        }
        all
    }
}

fn study(robot: &Robot, kind: Kind, sessions: u64) -> Study {
    let trials: Vec<Trial> = (0..sessions)
        .into_par_iter()
        .map(|seed| trial(robot, kind, seed))
        .collect();
    let mut study = Study::default();
    for trial in &trials {
        study.without += usize::from(trial.outcome.agreement.is_none());
        if let Some(run_slope) = &trial.table.run_slope {
            let has_islands = trial.outcome.estimates[..4]
                .iter()
                .any(|estimate| estimate.parts_95().len() > 1);
            let (sum, n) = &mut study.scatter[usize::from(!has_islands)];
            *sum += run_slope.variance / NoiseModel::default().run_slope_sd.powi(2);
            *n += 1;
        }
        for place in 0..4 {
            let estimate = &trial.outcome.estimates[place];
            let parts = estimate.parts_95();
            if estimate.status == FactorStatus::Fixed {
                continue;
            }
            study.not_stated.add(parts.is_empty());
            if parts.is_empty() {
                continue;
            }
            let truth = trial.truth.beam[place];
            let holds = parts
                .iter()
                .any(|[low, high]| (*low..=*high).contains(&truth));
            if parts.len() > 1 {
                study.islands.add(holds);
            } else {
                study.factors[place].add(holds);
            }
        }
        for (row, truth) in trial.table.cells.iter().zip(&trial.stiffness) {
            let estimate = row.by(Method::Regression).unwrap().estimate;
            if let Some([low, high]) = estimate.interval_95() {
                study.cells.add((low..=high).contains(truth));
            }
        }
    }
    println!(
        "{:14} {} runs{}: stated {}; islands {}; not stated {}; cells {}",
        kind.train.join(","),
        kind.repeats,
        if kind.uneven { ", uneven" } else { "" },
        study.stated().text(),
        study.islands.text(),
        study.not_stated.text(),
        study.cells.text()
    );
    let [with, without] = study.scatter.map(|(sum, n)| (sum / n as f64).sqrt());
    println!(
        "    scatter between runs over its true size: {with:.2} where islands are, {without:.2} elsewhere"
    );
    for (name, count) in ModelParameter::CLASSES.iter().zip(study.factors) {
        println!("    {name}: {}", count.text());
    }
    study
}

#[test]
fn intervals_of_two_poses_hold_the_truth_though_two_minima_compete() {
    let kind = Kind {
        train: TRAINING[1],
        repeats: 5,
        uneven: false,
    };
    let found = study(&hp_robot(), kind, 40);
    // Of 160 intervals 95 % to 1.7 % by chance, four to a session; from the lowest minimum alone 82 % did.
    assert!((0.89..=0.99).contains(&found.stated().share()), "{found:?}");
    assert!(found.islands.trials > 20, "{found:?}");
    assert!(found.not_stated.share() < 0.1, "{found:?}");
}

#[test]
fn one_run_a_cell_gives_no_uncertainty_and_two_a_true_one() {
    let kind = |repeats| Kind {
        train: TRAINING[3],
        repeats,
        uneven: false,
    };
    let single = study(&hp_robot(), kind(1), 40);
    assert_eq!(single.cells.trials, 0);
    // A, which the stiff cells decide, was held in 75 % of sessions while all cells weighed the same.
    assert!(single.factors[0].share() > 0.9, "{single:?}");
    assert!(single.stated().share() > 0.93, "{single:?}");
    let found = study(&hp_robot(), kind(2), 60);
    // 720 cells: 95 % to 0.8 % by chance.
    assert!((0.92..=0.98).contains(&found.cells.share()), "{found:?}");
    assert!((0.90..=0.99).contains(&found.stated().share()), "{found:?}");
}

/// The rise of chi-squared from the fit to a bound of a factor, all others free: by a grid over them that is narrowed around its best
/// points, without the fit's own search.
struct ByGrid<'a> {
    model: CellModel<'a>,
    start: [f64; 4],
    measured: &'a MeasuredStiffness,
}

/// Points of the grid along each factor, over the bounds of a fit, and around a point.
const GRID: usize = 9;
const ZOOMED: usize = 5;

impl ByGrid<'_> {
    /// At these logarithms of the ratios of the beam factors to their start.
    fn chi_squared(&mut self, logarithms: [f64; 4], factors: &FittingFactors) -> f64 {
        let mut at = factors.clone();
        for ((factor, start), logarithm) in at.beam.iter_mut().zip(self.start).zip(logarithms) {
            *factor = start * logarithm.exp();
        }
        let Ok(stiffness) = self.model.stiffness(&at) else {
            return f64::INFINITY;
        };
        let cells = self.measured.cells.iter().zip(stiffness);
        cells
            .map(|(cell, k)| {
                let u = cell.ln_uncertainty.as_ref().unwrap().own;
                ((k / cell.stiffness_n_per_m).ln() / u).powi(2)
            })
            .sum()
    }

    /// The least chi-squared with one factor kept, or none.
    fn least(&mut self, kept: Option<(usize, f64)>, factors: &FittingFactors) -> f64 {
        let bound = 10_f64.ln();
        let mut middle = [0.0; 4];
        if let Some((place, at)) = kept {
            middle[place] = at;
        }
        let mut found = self.on_grid(&middle, bound, GRID, kept, factors);
        found.truncate(3);
        let zoomed = found.into_iter().map(|(mut least, mut at)| {
            let mut half_width = bound / (GRID - 1) as f64;
            while half_width > 1e-3 {
                let around = self.on_grid(&at, half_width, ZOOMED, kept, factors);
                if around[0].0 < least {
                    (least, at) = around[0];
                } else {
                    half_width *= 0.6;
                }
            }
            least
        });
        zoomed.fold(f64::INFINITY, f64::min)
    }

    /// Chi-squared on a grid around a point, within the bounds, the least first.
    fn on_grid(
        &mut self,
        middle: &[f64; 4],
        half_width: f64,
        points: usize,
        kept: Option<(usize, f64)>,
        factors: &FittingFactors,
    ) -> Vec<(f64, [f64; 4])> {
        let bound = 10_f64.ln();
        let along = |place: usize| match kept {
            Some((factor, at)) if factor == place => vec![at],
            _ => (0..points)
                .map(|i| 2.0 * i as f64 / (points - 1) as f64 - 1.0)
                .map(|share| (middle[place] + share * half_width).clamp(-bound, bound))
                .collect(),
        };
        let mut found = Vec::new();
        for a in along(0) {
            for iy in along(1) {
                for iz in along(2) {
                    for j in along(3) {
                        let at = [a, iy, iz, j];
                        found.push((self.chi_squared(at, factors), at));
                    }
                }
            }
        }
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        found
    }
}

/// Factors without an interval and with one, of sessions of two poses, compared with their chi-squared at the bounds.
fn intervals_against_a_grid(repeats: u32, sessions: &[u64]) -> [usize; 2] {
    let robot = hp_robot();
    let mechanism = robot.mechanism(Some("F")).unwrap();
    let kind = Kind {
        train: TRAINING[1],
        repeats,
        uneven: false,
    };
    let of_session = |seed: u64| {
        let trial = trial(&robot, kind, seed);
        let (_, start) = robot.default_factors();
        let measured = MeasuredStiffness::from_table(&trial.table, Method::Regression);
        let cells: Vec<Cell> = measured
            .cells
            .iter()
            .map(|cell| cell.cell.clone())
            .collect();
        let mut grid = ByGrid {
            model: CellModel::new(&robot, mechanism, &[], &cells).unwrap(),
            start: start.beam,
            measured: &measured,
        };
        // In a narrow curved valley a grid may end above the floor, where the fit's point certainly is.
        let fitted = |place: usize| (trial.outcome.estimates[place].value / start.beam[place]).ln();
        let at_fit = grid.chi_squared(std::array::from_fn(fitted), &start);
        let lowest = grid.least(None, &start).min(at_fit);
        let mut counts = [0, 0];
        for (place, estimate) in trial.outcome.estimates[..4].iter().enumerate() {
            let bound = 10_f64.ln();
            let rises = [-bound, bound].map(|at| grid.least(Some((place, at)), &start) - lowest);
            let parts = estimate.parts_95();
            counts[usize::from(!parts.is_empty())] += 1;
            if parts.is_empty() {
                // A limit for one parameter is 3.84, and up to three times that where it is drawn or the scatter rests on few runs.
                let least = rises[0].min(rises[1]);
                assert!(
                    least < 12.0,
                    "session {seed}, {}: not stated, and chi-squared rises by {rises:?}; {estimate:?}",
                    estimate.name
                );
            } else {
                let most = rises[0].min(rises[1]);
                assert!(
                    most > 3.0,
                    "session {seed}, {}: {parts:?}, and chi-squared rises by {rises:?}",
                    estimate.name
                );
            }
        }
        counts
    };
    let counts: Vec<[usize; 2]> = sessions.par_iter().map(|&seed| of_session(seed)).collect();
    let sum = |which: usize| counts.iter().map(|count| count[which]).sum();
    let [without, with] = [sum(0), sum(1)];
    println!(
        "{repeats} runs, {} sessions: {without} not stated, {with} stated, all as the grid has it",
        sessions.len()
    );
    [without, with]
}

#[test]
fn no_interval_is_withheld_whose_limit_is_crossed_within_the_bounds() {
    // In session 68 a refit stalls in the rounding of the model.
    let [without, with] = intervals_against_a_grid(2, &[0, 1, 2, 3, 4, 68]);
    assert_eq!(without + with, 24);
}

#[test]
#[ignore = "some minutes; `just nightly` runs it"]
fn no_interval_of_a_hundred_sessions_is_withheld_whose_limit_is_crossed() {
    let sessions: Vec<u64> = (0..100).collect();
    for repeats in [2, 5] {
        intervals_against_a_grid(repeats, &sessions);
    }
}

/// A thousand sessions of each number of repeats with these training poses.
fn a_thousand_sessions(train: &'static [&'static str]) {
    for (repeats, uneven) in [(5, false), (5, true), (3, false), (2, false), (1, false)] {
        let kind = Kind {
            train,
            repeats,
            uneven,
        };
        study(&hp_robot(), kind, 1000);
    }
}

#[test]
#[ignore = "half an hour on two cores; `just nightly` runs it"]
fn a_thousand_sessions_of_one_pose() {
    a_thousand_sessions(TRAINING[0]);
}

#[test]
#[ignore = "half an hour on two cores; `just nightly` runs it"]
fn a_thousand_sessions_of_two_poses() {
    a_thousand_sessions(TRAINING[1]);
}

#[test]
#[ignore = "half an hour on two cores; `just nightly` runs it"]
fn a_thousand_sessions_of_three_poses() {
    a_thousand_sessions(TRAINING[2]);
}

#[test]
#[ignore = "half an hour on two cores; `just nightly` runs it"]
fn a_thousand_sessions_of_four_poses() {
    a_thousand_sessions(TRAINING[3]);
}
