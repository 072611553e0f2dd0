//! The four beam factors of mechanism F fitted to twelve stiffness values, once and a thousand times; one core.
//!
//! As in `peers/refit.py`: poses P1 to P4, directions x, y, z, values of the paper's factors times lognormal scatter of 2 %, start at
//! the paper's factors, bounds a tenth and ten times the start, equal weights.

#![expect(
    clippy::unwrap_used,
    reason = "a benchmark stops at the first thing that is not as it must be"
)]

use std::hint::black_box;

use criterion::{Criterion, criterion_group, criterion_main};
use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, Normal};

use stiffbench::fit::{
    CellModel, FitProblem, MeasuredCell, MeasuredStiffness, Refitter, WeightBasis,
};
use stiffbench::parameters::ParameterChoice;
use stiffbench::robot::{ModelParameter, Predictor, Robot};
use stiffbench::shipped::shipped_robot;
use stiffbench::test_point::{Cell, Direction};

const REFITS: usize = 1000;
const SCATTER: f64 = 0.02;

fn refit(criterion: &mut Criterion) {
    let robot = Robot::parse(&shipped_robot("hp-robot").unwrap()).unwrap();
    let mechanism = robot.mechanism(Some("F")).unwrap();
    let start = robot.factor_set("m_fsd").unwrap();
    let cells: Vec<Cell> = robot
        .poses
        .iter()
        .flat_map(|named| Direction::ALL.map(|direction| Cell::new(named.id.clone(), direction)))
        .collect();
    let mut model = CellModel::new(&robot, mechanism, &ModelParameter::CLASSES, &cells).unwrap();
    let truth = model.stiffness(&start).unwrap();
    let measured = MeasuredStiffness {
        cells: cells
            .iter()
            .zip(&truth)
            .map(|(cell, &stiffness_n_per_m)| MeasuredCell {
                line: 0,
                cell: cell.clone(),
                stiffness_n_per_m,
                ln_uncertainty: None,
                reading_noise: None,
            })
            .collect(),
        basis: WeightBasis::Equal,
        ..MeasuredStiffness::default()
    };
    let mut random = ChaCha8Rng::seed_from_u64(2);
    let scatter = Normal::new(0.0, SCATTER).unwrap();
    let replicates: Vec<Vec<f64>> = (0..REFITS)
        .map(|_| {
            let values = truth.iter().map(|k| k.ln() + scatter.sample(&mut random));
            values.collect()
        })
        .collect();
    let choice = ParameterChoice::default();
    let problem = FitProblem {
        robot: &robot,
        mechanism,
        measured: &measured,
        start: &start,
        physics: None,
    };
    let set_up = || Refitter::new(&problem, &choice).unwrap();

    let mut refitter = set_up();
    for values in &replicates {
        let refit = refitter.refit(values).unwrap();
        assert!(refit.termination.is_converged(), "{:?}", refit.termination);
    }

    let mut group = criterion.benchmark_group("refit");
    group.bench_function("one, set-up included", |bencher| {
        bencher.iter(|| black_box(set_up().refit(&replicates[0]).unwrap()));
    });
    let mut shares = vec![Vec::new(); cells.len()];
    let mut stiffness = truth.clone();
    group.bench_function("one evaluation", |bencher| {
        bencher.iter(|| {
            model
                .evaluate(&start, &mut stiffness, Some(&mut shares))
                .unwrap();
        });
    });
    // What the fits did before poses shared vectors: each factorised alone, with the derivatives of every element.
    let mut alone: Vec<Predictor> = robot
        .poses
        .iter()
        .map(|named| {
            let mut predictor = Predictor::new(&robot, mechanism, &start).unwrap();
            predictor.place(&named.pose).unwrap();
            predictor
        })
        .collect();
    let mut gradient = vec![[0.0; 4]; mechanism.members.len()];
    group.bench_function("one evaluation, pose by pose", |bencher| {
        bencher.iter(|| {
            for predictor in &mut alone {
                predictor.set_factors(&start).unwrap();
                black_box(predictor.translation_compliance());
                for axis in 0..3 {
                    predictor.compliance_gradient(axis, &mut gradient);
                    black_box(&gradient);
                }
            }
        });
    });
    group.sample_size(10);
    group.bench_function(format!("{REFITS} refits"), |bencher| {
        bencher.iter(|| {
            for values in &replicates {
                black_box(refitter.refit(values).unwrap());
            }
        });
    });
    group.finish();
}

criterion_group!(benches, refit);
criterion_main!(benches);
