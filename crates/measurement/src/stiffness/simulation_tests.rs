//! Stated properties of the uncertainties, compared with simulated benches whose truth is known.

use super::*;
use crate::readings::Reading;
use crate::stiffness::sample::SimulatedBench;
use rand::{RngExt as _, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution as _, StandardNormal};
use stiffbench_units_and_text::test_point::Branch;

const TRUE_STIFFNESS: f64 = 50e3;

fn table(bench: &SimulatedBench, gauges: &GaugePair) -> StiffnessTable {
    stiffness_table(&bench.readings(), gauges, StiffnessOptions::default())
}

/// Share of cells whose 95 % interval holds the truth.
fn coverage(table: &StiffnessTable, method: Method) -> f64 {
    let covered = table.cells.iter().filter(|row| {
        let [low, high] = row.by(method).unwrap().estimate.interval_95().unwrap();
        (low..=high).contains(&TRUE_STIFFNESS)
    });
    covered.count() as f64 / table.cells.len() as f64
}

#[test]
fn intervals_from_runs_hold_the_truth_in_95_of_100_cells() {
    let table = table(&SimulatedBench::paper(3000, 20), &GaugePair::default());
    for method in [Method::Regression, Method::PaperMean] {
        let share = coverage(&table, method);
        assert!((0.93..=0.97).contains(&share), "{method}: {share}");
    }
}

#[test]
fn intervals_of_two_runs_borrow_how_runs_differ_from_all_cells() {
    // Twelve cells of two runs each, a hundred sessions and more.
    let mut covered = [0.0; 2];
    let sessions = 200;
    for session in 0..sessions {
        let bench = SimulatedBench {
            repeats: 2,
            ..SimulatedBench::paper(12, 21 + session)
        };
        let table = table(&bench, &GaugePair::default());
        let methods = [Method::Regression, Method::PaperMean];
        for (covered, method) in covered.iter_mut().zip(methods) {
            *covered += coverage(&table, method) / f64::from(sessions as u32);
        }
        let basis = table.cells[0].by(Method::Regression).unwrap().basis;
        assert_eq!(basis, ScatterBasis::PooledRuns { n_runs: 2 });
    }
    // 2400 cells: 95 % to 0.45 % by chance; cells of a session share one pooled variance.
    for share in covered {
        assert!((0.93..=0.97).contains(&share), "{share}");
    }
}

#[test]
fn two_runs_at_loads_of_their_own_differ_as_they_are_seen_to() {
    // As of a recording that runs on: no two readings at one force.
    let sessions = 2000;
    let mut covered = 0.0;
    for seed in 0..sessions {
        let bench = SimulatedBench {
            repeats: 2,
            ..SimulatedBench::paper(1, seed)
        };
        let mut readings = bench.readings();
        for (place, reading) in readings.iter_mut().enumerate() {
            let beyond_n = 0.1 * (place + 1) as f64;
            reading.target_n -= beyond_n;
            reading.force_n -= beyond_n;
            reading.displacement_m -= beyond_n / TRUE_STIFFNESS;
        }
        let table = stiffness_table(
            &readings,
            &GaugePair::default(),
            StiffnessOptions::default(),
        );
        assert_eq!(table.pooled_scatter, None);
        covered += coverage(&table, Method::Regression) / f64::from(sessions as u32);
    }
    // 95 % to 0.5 % by chance.
    assert!((0.93..=0.97).contains(&covered), "{covered}");
}

#[test]
fn a_scatter_that_is_twice_as_large_in_half_of_the_cells_is_noticed() {
    let (mut noticed, mut falsely) = (0, 0);
    let sessions = 300;
    for seed in 0..sessions {
        let even = SimulatedBench::paper(12, seed).readings();
        let p = |readings: &[Reading]| {
            let table =
                stiffness_table(readings, &GaugePair::default(), StiffnessOptions::default());
            table.run_slope.unwrap().evenness_p.unwrap()
        };
        falsely += usize::from(p(&even) < 0.05);
        let wide = SimulatedBench {
            relative_slope_sd: 0.02,
            ..SimulatedBench::paper(12, seed)
        };
        let narrow = SimulatedBench {
            relative_slope_sd: 0.01,
            ..SimulatedBench::paper(12, seed + 1000)
        };
        let half = even.len() / 2;
        let mut uneven = wide.readings()[..half].to_vec();
        uneven.extend_from_slice(&narrow.readings()[half..]);
        noticed += usize::from(p(&uneven) < 0.05);
    }
    println!("noticed {noticed}, falsely {falsely} of {sessions}");
    // 5 % and three standard errors of it.
    assert!(falsely <= 26, "{falsely}");
    assert!(noticed >= 90, "{noticed}");
}

#[test]
fn one_run_in_every_cell_has_no_uncertainty() {
    let bench = SimulatedBench {
        repeats: 1,
        ..SimulatedBench::paper(12, 23)
    };
    let table = table(&bench, &GaugePair::default());
    for row in &table.cells {
        let estimate = row.by(Method::Regression).unwrap();
        assert_eq!(estimate.type_a, None);
        assert_eq!(estimate.basis, ScatterBasis::Unavailable { n_runs: 1 });
    }
}

#[test]
fn a_shared_zero_is_allowed_for_in_the_mean_of_ratios() {
    // The zero is as good as one reading, which is what the budget takes it for.
    let bench = SimulatedBench {
        shared_zero: true,
        zero_sd_m: 6e-6,
        ..SimulatedBench::paper(3000, 22)
    };
    let table = table(&bench, &GaugePair::default());
    for method in [Method::Regression, Method::PaperMean] {
        let share = coverage(&table, method);
        assert!((0.93..=0.97).contains(&share), "{method}: {share}");
    }
    // Without its row the interval would be too short.
    let without = table.cells.iter().filter(|row| {
        let paper = row.by(Method::PaperMean).unwrap();
        let expanded = 2.776 * paper.type_a.unwrap().standard_uncertainty;
        (paper.estimate.value - TRUE_STIFFNESS).abs() <= expanded
    });
    assert!((without.count() as f64) < 0.9 * table.cells.len() as f64);
}

/// What a gauge shows too much, as a share of its largest error, for a share of its range.
type ErrorShape = fn(f64) -> f64;

/// Sessions for each kind of error: a share of 0.93 is then known to 0.8 %.
const SESSIONS: u64 = 1000;

/// Share of intervals that hold the truth if each gauge errs within its certificate, by one shape in each session: over all cells, and of the
/// worst of twelve from 27 to 200 N/mm.
fn coverage_with_calibration(
    shape: ErrorShape,
    draw: fn(&mut ChaCha8Rng) -> f64,
    method: Method,
) -> [f64; 2] {
    // U of 1 % of 70 N, and of up to 4 % of the displacement at 70 N.
    let (force_u, displacement_u) = (0.7, 14e-6);
    let gauges = GaugePair {
        force: GaugeTerms::new(Some(0.1), Some(force_u), Some(2.0)).unwrap(),
        displacement: GaugeTerms::new(Some(1e-6), Some(displacement_u), Some(2.0)).unwrap(),
    };
    let compliances_m_per_n: Vec<f64> = (0..12).map(|i| 5e-6 * 1.2_f64.powi(i)).collect();
    let mut held = [0.0; 12];
    for seed in 0..SESSIONS {
        let bench = SimulatedBench {
            compliances_m_per_n: compliances_m_per_n.clone(),
            ..SimulatedBench::paper(12, seed)
        };
        let mut readings = bench.readings();
        let mut random = ChaCha8Rng::seed_from_u64(1_000_000 + seed);
        let (force, displacement) = (draw(&mut random), draw(&mut random));
        for reading in &mut readings {
            let share = reading.target_n / -70.0;
            // A gauge errs by what it shows: of a stiff cell it uses a part of its range.
            let travel = reading.displacement_m.abs() / LONGEST_M;
            let to_step = |value: f64, step: f64| (value / step).round() * step;
            reading.force_n = to_step(reading.force_n + force * force_u * shape(share), 0.1);
            reading.displacement_m = to_step(
                reading.displacement_m + displacement * displacement_u * shape(travel),
                1e-6,
            );
        }
        let table = stiffness_table(&readings, &gauges, StiffnessOptions::default());
        for ((row, truth), held) in table.cells.iter().zip(&compliances_m_per_n).zip(&mut held) {
            let [low, high] = row.by(method).unwrap().estimate.interval_95().unwrap();
            *held += f64::from(u8::from((low..=high).contains(&truth.recip()))) / SESSIONS as f64;
        }
    }
    let all = held.iter().sum::<f64>() / held.len() as f64;
    [all, held.into_iter().fold(1.0, f64::min)]
}

/// Displacement of the softest cell at 70 N, m.
const LONGEST_M: f64 = 2.6e-3;

#[test]
fn intervals_hold_the_truth_whatever_error_a_certificate_allows() {
    let shapes: [(&str, ErrorShape); 3] = [
        ("scale", |share| share),
        ("offset", |_| 1.0),
        ("bow", |share| 4.0 * share * (1.0 - share)),
    ];
    // An error is drawn normal with U/k, or anywhere within U.
    let normal: fn(&mut ChaCha8Rng) -> f64 = |random| {
        let z: f64 = StandardNormal.sample(random);
        0.5 * z
    };
    let even: fn(&mut ChaCha8Rng) -> f64 = |random| random.random_range(-1.0..=1.0);
    for method in [Method::Regression, Method::PaperMean] {
        for (name, shape) in shapes {
            for (drawn, draw) in [("normal", normal), ("within U", even)] {
                let [all, worst] = coverage_with_calibration(shape, draw, method);
                println!("{method}, {name}, {drawn}: {all:.3}, worst cell {worst:.3}");
                assert!(all >= 0.93, "{method}, {name}, {drawn}: {all}");
                assert!(worst >= 0.90, "{method}, {name}, {drawn}: {worst}");
            }
        }
    }
    // What the slope of the cell with the longest travel fears most is counted in full, not more.
    let [_, scale] = coverage_with_calibration(shapes[0].1, normal, Method::Regression);
    assert!(scale <= 0.97, "{scale}");
}

/// Sweeps up to the largest load and back to zero, as shipped, while the dial gauge drifts by so much in each sweep, m.
fn sweeps_with_drift(drift_m: f64, seed: u64) -> StiffnessTable {
    let bench = SimulatedBench {
        unloading: true,
        // The noise of `simulate`.
        reading_sd_m: 3e-6,
        zero_sd_m: 2.5e-6,
        relative_slope_sd: 0.004,
        ..SimulatedBench::paper(12, seed)
    };
    let last = bench.targets_n.len() as u32;
    let mut readings = bench.readings();
    readings.retain(|reading| reading.branch == Branch::Loading || reading.target_n == 0.0);
    for reading in &mut readings {
        // The last reading follows the largest load at once.
        let place = reading.step.min(last);
        reading.displacement_m -= drift_m * f64::from(place) / f64::from(last);
    }
    stiffness_table(
        &readings,
        &GaugePair::default(),
        StiffnessOptions::default(),
    )
}

#[test]
fn a_drift_of_ten_micrometres_a_sweep_is_flagged_and_in_the_budget() {
    let (mut flagged, mut falsely, mut covered) = (0, 0, 0.0);
    let sessions = 100;
    let flags = |table: &StiffnessTable| {
        let found =
            |row: &&CellStiffness| row.flags.iter().any(|flag| flag.rule == "return-to-zero");
        table.cells.iter().filter(found).count()
    };
    for seed in 0..sessions {
        let table = sweeps_with_drift(10e-6, 40 + seed);
        flagged += flags(&table);
        covered += coverage(&table, Method::Regression) / f64::from(sessions as u32);
        falsely += flags(&sweeps_with_drift(0.0, 40 + seed));
    }
    let of_all = |count: usize| count as f64 / (12.0 * sessions as f64);
    // 1200 cells: 95 % to 0.6 % by chance.
    assert!(of_all(flagged) >= 0.95, "{}", of_all(flagged));
    assert!(of_all(falsely) <= 0.02, "{}", of_all(falsely));
    // A drift that is in the budget as a limit, and in one cell of twenty not at all: without it 48 %, and fewer than 95 with it.
    assert!(covered >= 0.82, "{covered}");
}

#[test]
fn a_stiff_cell_on_one_gauge_step_gets_the_step_as_uncertainty() {
    // 1 µm at 70 N on a step of 1 µm without noise: every repeat shows the same.
    let bench = SimulatedBench {
        compliances_m_per_n: vec![0.5e-6; 1],
        reading_sd_m: 0.0,
        zero_sd_m: 0.0,
        relative_slope_sd: 0.0,
        ..SimulatedBench::paper(1, 3)
    };
    let mut readings = bench.readings();
    for reading in &mut readings {
        reading.displacement_m = (0.5 * reading.target_n / 5.0).round() * 5e-6;
        reading.force_n = reading.target_n;
    }
    let gauges = GaugePair {
        displacement: GaugeTerms::new(Some(5e-6), None, None).unwrap(),
        ..GaugePair::default()
    };
    let table = stiffness_table(&readings, &gauges, StiffnessOptions::default());
    let regression = table.cells[0].by(Method::Regression).unwrap();
    let row = regression
        .budget
        .row(UncertaintySource::DisplacementResolution)
        .unwrap();
    assert_eq!(row.standing, RowUse::Counted);
    // Load weights (F - F̄)/(5 Σ(F - F̄)²), five repeats wrong together: q/√12 / √4200 of the slope.
    let slope = table.cells[0].line.as_ref().unwrap().slope_m_per_n;
    let expected = 5e-6 / 12_f64.sqrt() / 4200_f64.sqrt() / slope / slope;
    assert!((row.contribution_n_per_m / expected - 1.0).abs() < 1e-9);
}

#[test]
fn an_unstated_display_step_is_estimated_and_in_the_budget() {
    let compliances_m_per_n: Vec<f64> = (0..12).map(|i| 0.8e-6 + 0.19e-6 * f64::from(i)).collect();
    // Displacements of up to 200 µm on a display of 10 µm, a noise of 0.2 µm: five repeats mostly show the same.
    let bench = SimulatedBench {
        compliances_m_per_n: compliances_m_per_n.clone(),
        reading_sd_m: 0.2e-6,
        zero_sd_m: 0.0,
        relative_slope_sd: 0.0,
        ..SimulatedBench::paper(12, 5)
    };
    let mut random = ChaCha8Rng::seed_from_u64(6);
    let (mut covered, mut without) = (0.0, 0.0);
    let sessions = 100;
    for seed in 0..sessions {
        let bench = SimulatedBench {
            seed,
            ..bench.clone()
        };
        let mut readings = bench.readings();
        for cell in readings.chunk_by_mut(|a, b| a.pose == b.pose && a.direction == b.direction) {
            // Where the steps of the display lie is chance, of cell after cell.
            let offset: f64 = random.random_range(0.0..10e-6);
            for reading in cell {
                let shown = (reading.displacement_m + offset) / 10e-6;
                reading.displacement_m = shown.round() * 10e-6;
            }
        }
        let gauges = GaugePair::default().with_steps_of(&readings);
        assert!((gauges.displacement.resolution().unwrap() - 10e-6).abs() < 1e-12);
        assert!(gauges.displacement.resolution_is_read_off());
        let table =
            |gauges: &GaugePair| stiffness_table(&readings, gauges, StiffnessOptions::default());
        let share = |gauges| {
            let table = table(gauges);
            let rows = table.cells.iter().zip(&compliances_m_per_n);
            let held = rows.filter(|(row, compliance)| {
                let estimate = row.by(Method::Regression).unwrap().estimate;
                let [low, high] = estimate.interval_95().unwrap();
                (low..=high).contains(&compliance.recip())
            });
            held.count() as f64 / (12.0 * sessions as f64)
        };
        covered += share(&gauges);
        without += share(&GaugePair::default());
    }
    println!("{covered} with the step, {without} without");
    assert!(covered >= 0.93, "{covered}");
    assert!(without < 0.9, "it does matter: {without}");
}
