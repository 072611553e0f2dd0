//! Readings for the tests of this module: one by one, and from a small simulated bench.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use crate::readings::{Reading, ReadingStatus};
use stiffbench_units_and_text::test_point::{Branch, Cell, Direction, PoseId};

/// The cell of `reading`.
pub(super) fn cell() -> Cell {
    Cell::new(PoseId::new("P1"), Direction::Y)
}

/// A reading of P1 y whose run and zero are those of its repeat.
pub(super) fn reading(
    repeat: u32,
    step: u32,
    target_n: f64,
    force_n: f64,
    displacement_m: f64,
) -> Reading {
    Reading {
        line: 0,
        seq: repeat * 100 + step,
        pose: PoseId::new("P1"),
        direction: Direction::Y,
        load: None,
        branch: Branch::Loading,
        step,
        repeat,
        attempt: 1,
        run: repeat - 1,
        zero: repeat - 1,
        status: ReadingStatus::Accepted,
        target_n,
        force_n,
        displacement_m,
        time_s: None,
        hold_s: None,
        temperature_deg_c: None,
        text: None,
    }
}

/// A bench of many cells: straight lines with run zeros, run slopes, reading noise and a force gauge step.
#[derive(Debug, Clone)]
pub(super) struct SimulatedBench {
    pub(super) compliances_m_per_n: Vec<f64>,
    pub(super) targets_n: Vec<f64>,
    pub(super) repeats: u32,
    pub(super) unloading: bool,
    pub(super) reading_sd_m: f64,
    pub(super) zero_sd_m: f64,
    pub(super) relative_slope_sd: f64,
    pub(super) force_step_n: f64,
    pub(super) shared_zero: bool,
    pub(super) seed: u64,
}

impl SimulatedBench {
    /// Cells of 50 N/mm in the paper's plan: 0 to -70 N, five runs, zero per run; 6 µm noise, 5 µm zero, 0.5 % slope.
    pub(super) fn paper(n_cells: usize, seed: u64) -> Self {
        Self {
            compliances_m_per_n: vec![20e-6; n_cells],
            targets_n: (0..=7).map(|i| -10.0 * f64::from(i)).collect(),
            repeats: 5,
            unloading: false,
            reading_sd_m: 6e-6,
            zero_sd_m: 5e-6,
            relative_slope_sd: 0.005,
            force_step_n: 0.0,
            shared_zero: false,
            seed,
        }
    }

    /// The readings; times run on through the cells in the order of measurement.
    pub(super) fn readings(&self) -> Vec<Reading> {
        let mut random = ChaCha8Rng::seed_from_u64(self.seed);
        let mut normal = |sd: f64| -> f64 {
            let z: f64 = StandardNormal.sample(&mut random);
            sd * z
        };
        let mut readings = Vec::new();
        let last = self.targets_n.len() - 1;
        for (index, compliance) in self.compliances_m_per_n.iter().enumerate() {
            let pose = PoseId::new(&format!("P{}", index / 3 + 1));
            let cell_zero = normal(self.zero_sd_m);
            for repeat in 1..=self.repeats {
                let run_zero = normal(self.zero_sd_m);
                let zero_m = if self.shared_zero {
                    cell_zero
                } else {
                    run_zero
                };
                let slope = compliance * (1.0 + normal(self.relative_slope_sd));
                let steps = if self.unloading { 2 * last } else { last };
                for step in 0..=steps {
                    let target_n = self.targets_n[if step > last { 2 * last - step } else { step }];
                    let missed = if target_n == 0.0 { 0.0 } else { normal(0.2) };
                    let true_force = target_n + missed;
                    let force_n = if self.force_step_n > 0.0 {
                        (true_force / self.force_step_n).round() * self.force_step_n
                    } else {
                        true_force
                    };
                    let run = index as u32 * self.repeats + repeat - 1;
                    readings.push(Reading {
                        seq: readings.len() as u32 + 1,
                        pose: pose.clone(),
                        direction: Direction::ALL[index % 3],
                        load: None,
                        branch: if step > last {
                            Branch::Unloading
                        } else {
                            Branch::Loading
                        },
                        run,
                        zero: if self.shared_zero { index as u32 } else { run },
                        time_s: Some(readings.len() as f64 * 12.0),
                        ..reading(
                            repeat,
                            step as u32,
                            target_n,
                            force_n,
                            slope * true_force + zero_m + normal(self.reading_sd_m),
                        )
                    });
                }
            }
        }
        readings
    }
}
