//! What a model leaves of load cases: tests against structure without a name, and the largest residual.

use rand::SeedableRng;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use stiffbench_numeric::statistics::f_upper_tail;

use crate::search::constants::ABSORBED;
use crate::search::{WhiteSpace, dot, norm, push_orthonormal};

use super::candidates::MissingCandidate;
use super::outcome::LoadCaseUnexplained;
use crate::elastostatics::outcome::micro_unit;
use crate::elastostatics::posed::PosedLoadCases;

/// Samples of noise from which the chance of the smallest p is counted (1): a standard error of a tenth at one percent.
const SAMPLES: usize = 10_000;

/// Unit vectors, white and projected, of one kind of structure.
struct StructureTest {
    name: &'static str,
    basis: Vec<Vec<f64>>,
}

impl StructureTest {
    /// The vectors that a model does not absorb and those before them do not contain.
    fn new(name: &'static str, space: &WhiteSpace, columns: &[&[f64]]) -> Self {
        let mut basis: Vec<Vec<f64>> = Vec::new();
        for column in columns {
            let vector = space.projected(column);
            if norm(&vector) > ABSORBED * norm(&space.white(column)) {
                push_orthonormal(&mut basis, vector, 1e-3, 0.0);
            }
        }
        Self { name, basis }
    }

    /// Share of the squares of a projected vector that lies in it.
    fn share(&self, residual: &[f64]) -> f64 {
        let inside: f64 = self
            .basis
            .iter()
            .map(|unit| dot(unit, residual).powi(2))
            .sum();
        inside / dot(residual, residual).max(f64::MIN_POSITIVE)
    }

    /// Chance that noise gives a share at least as large: an F statistic.
    fn p(&self, share: f64, dof: f64) -> f64 {
        let own = self.basis.len() as f64;
        let rest = dof - own;
        if own == 0.0 || rest < 1.0 {
            return 1.0;
        }
        let ratio = share / own / ((1.0 - share).max(f64::MIN_POSITIVE) / rest);
        f_upper_tail(ratio, own, rest).unwrap_or(1.0)
    }
}

/// Tests what a model leaves.
///
/// # Arguments
/// - `space`: white under the covariance of the model, its columns projected out.
/// - `residuals`: what the model leaves, m and rad.
/// - `standard_deviations`: of the rows.
/// - `lack_of_fit`: chance of the residuals beside the scatter of repeats, if there are any.
pub(super) fn unexplained(
    posed: &PosedLoadCases,
    space: &WhiteSpace,
    residuals: &[f64],
    candidates: &[MissingCandidate],
    lack_of_fit: Option<f64>,
    seed: u64,
) -> Option<LoadCaseUnexplained> {
    let white = space.projected(residuals);
    let dof = (residuals.len() - space.basis().len()) as f64;
    let of = |springs: bool| -> Vec<&[f64]> {
        let own = candidates
            .iter()
            .filter(|one| one.kind.is_spring() == springs);
        own.map(|one| one.column.as_slice()).collect()
    };
    let means: Vec<Vec<f64>> = (0..6)
        .map(|component| {
            let rows = posed.rows();
            rows.map(|(_, read)| f64::from(u8::from(read.component == component)))
                .collect()
        })
        .collect();
    let means: Vec<&[f64]> = means.iter().map(Vec::as_slice).collect();
    let tests = [
        StructureTest::new("springs of the robot together", space, &of(true)),
        StructureTest::new(
            "laws of joints, sections and set-up together",
            space,
            &of(false),
        ),
        StructureTest::new("the mean of each component", space, &means),
    ];
    let smallest = |residual: &[f64]| {
        let p = tests
            .iter()
            .map(|test| (test.p(test.share(residual), dof), test.name));
        p.min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let (p, test) = smallest(&white)?;
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut below = 0_usize;
    for _ in 0..SAMPLES {
        let mut sample: Vec<f64> = (0..residuals.len())
            .map(|_| StandardNormal.sample(&mut random))
            .collect();
        sample.resize(white.len(), 0.0);
        space.project(&mut sample);
        below += usize::from(smallest(&sample).is_some_and(|(q, _)| q <= p));
    }
    // Beyond the last sample the smallest p of three tests is at most three times as likely as one of them.
    let counted = if below < 10 {
        (3.0 * p).min(10.0 / SAMPLES as f64)
    } else {
        below as f64 / SAMPLES as f64
    };
    let (p, test) = match lack_of_fit {
        Some(lack) if lack < counted => ((2.0 * lack).min(1.0), "residuals beside the repeats"),
        Some(_) => ((2.0 * counted).min(1.0), test),
        None => (counted, test),
    };
    let scale = (dot(&white, &white) / dof.max(1.0)).sqrt();
    let rows = posed.rows().zip(residuals).zip(&white);
    let largest = rows.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()));
    let (((case, read), residual), white) = largest?;
    Some(LoadCaseUnexplained {
        p,
        test,
        pose: posed.labels[case.label].clone(),
        component: read.name(),
        size: *residual,
        unit: micro_unit(read.is_rotation()),
        standard_errors: (white / scale).abs(),
    })
}
