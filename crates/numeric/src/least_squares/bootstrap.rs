//! The spread of an estimate when whole groups of readings are resampled.
//!
//! Readings of one series share its zero, its seating and the operator's hand, so they are not independent; series are. The
//! cluster bootstrap draws series with replacement and fits again.

use std::convert::Infallible;

use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;

use crate::statistics::standard_deviation;

use super::error::LeastSquaresError;

/// How many replicates, from which seed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BootstrapSettings {
    /// Number of replicates.
    pub replicates: usize,
    /// Seed; the same seed gives the same replicates for any number of threads.
    pub seed: u64,
}

impl Default for BootstrapSettings {
    /// 1000 replicates put 25 of them beyond each end of a 95 % interval (Efron and Tibshirani, An Introduction to the Bootstrap
    /// (1993), section 13.3).
    fn default() -> Self {
        Self {
            replicates: 1000,
            seed: 0,
        }
    }
}

/// Why a replicate has no result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum ReplicateFailure<E = Infallible> {
    /// The refit reported it.
    Refit(E),
    /// The refit returned a value that is NaN or infinite.
    NotFinite {
        /// Which value, from 0.
        place: usize,
        /// What it was.
        value: f64,
    },
    /// The refit returned another number of values than the estimate has.
    WrongLength {
        /// How many there should be.
        expected: usize,
        /// How many there were.
        found: usize,
    },
}

/// A replicate without a result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FailedReplicate<E> {
    /// Number of the replicate, from 0.
    pub replicate: usize,
    /// Why.
    pub failure: ReplicateFailure<E>,
}

/// Estimates from resampled clusters.
#[derive(Debug, Clone, PartialEq)]
pub struct Bootstrap<E> {
    /// The estimate from all clusters, each once.
    pub estimate: Vec<f64>,
    /// One estimate for each replicate that has one, in the order of the replicates.
    pub replicates: Vec<Vec<f64>>,
    /// The others; an interval from the rest is optimistic if they are many.
    pub failed: Vec<FailedReplicate<E>>,
}

/// Draws clusters with replacement and refits, `settings.replicates` times, on all threads.
///
/// # Arguments
/// - `strata`: number of clusters in each stratum; a replicate draws within each as many as it has. One stratum is the plain bootstrap; with
///   fewer than about 10 clusters in all the intervals come out too short.
/// - `estimate`: the result of the same refit with every cluster once.
/// - `scratch`: makes what a thread may reuse between refits; results must not depend on what is left in it.
/// - `refit`: values (in the order of `estimate`) for the number of times each cluster was drawn, stratum after stratum.
///
/// # Errors
/// `TooFewClusters` for a stratum of fewer than two.
///
/// # Source
/// Davison and Hinkley, Bootstrap Methods and their Application (1997), section 3.8, resampling whole groups.
pub fn cluster_bootstrap<S, E: Send>(
    strata: &[usize],
    estimate: &[f64],
    settings: &BootstrapSettings,
    scratch: impl Fn() -> S + Sync + Send,
    refit: impl Fn(&[u32], &mut S) -> Result<Vec<f64>, E> + Sync + Send,
) -> Result<Bootstrap<E>, LeastSquaresError> {
    if let Some(&clusters) = strata.iter().find(|clusters| **clusters < 2) {
        return Err(LeastSquaresError::TooFewClusters { clusters });
    }
    let clusters: usize = strata.iter().sum();
    let results: Vec<Result<Vec<f64>, ReplicateFailure<E>>> = (0..settings.replicates)
        .into_par_iter()
        .map_init(
            || (scratch(), vec![0; clusters]),
            |(scratch, multiplicities), replicate| {
                draw(settings.seed, replicate, strata, multiplicities);
                let values = refit(multiplicities, scratch).map_err(ReplicateFailure::Refit)?;
                checked(values, estimate.len())
            },
        )
        .collect();
    let mut bootstrap = Bootstrap {
        estimate: estimate.to_vec(),
        replicates: Vec::with_capacity(results.len()),
        failed: Vec::new(),
    };
    for (replicate, result) in results.into_iter().enumerate() {
        match result {
            Ok(values) => bootstrap.replicates.push(values),
            Err(failure) => bootstrap
                .failed
                .push(FailedReplicate { replicate, failure }),
        }
    }
    Ok(bootstrap)
}

/// Counts how often each cluster is drawn; every replicate has its own stream, so its draw does not depend on the others.
fn draw(seed: u64, replicate: usize, strata: &[usize], multiplicities: &mut [u32]) {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    random.set_stream(replicate as u64);
    multiplicities.fill(0);
    let mut rest = multiplicities;
    for &clusters in strata {
        let (stratum, after) = rest.split_at_mut(clusters);
        // u64 and not usize, so that 32-bit machines draw the same.
        let count = clusters as u64;
        for _ in 0..count {
            stratum[random.random_range(0..count) as usize] += 1;
        }
        rest = after;
    }
}

fn checked<E>(values: Vec<f64>, expected: usize) -> Result<Vec<f64>, ReplicateFailure<E>> {
    if values.len() != expected {
        return Err(ReplicateFailure::WrongLength {
            expected,
            found: values.len(),
        });
    }
    match values.iter().position(|value| !value.is_finite()) {
        Some(place) => Err(ReplicateFailure::NotFinite {
            place,
            value: values[place],
        }),
        None => Ok(values),
    }
}

impl<E> Bootstrap<E> {
    /// Standard deviation of value number `place` over the replicates; `None` with fewer than two or beyond the values.
    #[must_use]
    pub fn standard_error(&self, place: usize) -> Option<f64> {
        (place < self.estimate.len()).then(|| standard_deviation(&self.sorted(place)))?
    }

    /// Percentile interval of value number `place`: the quantiles of the replicates themselves.
    ///
    /// # Errors
    /// `UnknownParameter`, `CoverageNotAProbability`, or `TooFewReplicates` if the quantiles lie outside the sample.
    pub fn percentile_interval(
        &self,
        place: usize,
        coverage: f64,
    ) -> Result<[f64; 2], LeastSquaresError> {
        if place >= self.estimate.len() {
            return Err(LeastSquaresError::UnknownParameter {
                index: place,
                count: self.estimate.len(),
            });
        }
        if !(coverage > 0.0 && coverage < 1.0) {
            return Err(LeastSquaresError::CoverageNotAProbability { coverage });
        }
        let tail = 0.5 * (1.0 - coverage);
        let sorted = self.sorted(place);
        let enough = (sorted.len() as f64 + 1.0) * tail >= 1.0;
        if !enough {
            return Err(LeastSquaresError::TooFewReplicates {
                succeeded: sorted.len(),
                requested: sorted.len() + self.failed.len(),
                needed: (1.0 / tail - 1.0).ceil() as usize,
            });
        }
        Ok([quantile(&sorted, tail), quantile(&sorted, 1.0 - tail)])
    }

    fn sorted(&self, place: usize) -> Vec<f64> {
        let mut values: Vec<f64> = self.replicates.iter().map(|values| values[place]).collect();
        values.sort_by(f64::total_cmp);
        values
    }
}

/// Quantile at `p` (n + 1), between neighbours in proportion (type 6 of Hyndman and Fan, The American Statistician 50 (1996) 361).
fn quantile(sorted: &[f64], p: f64) -> f64 {
    let place = (p * (sorted.len() as f64 + 1.0) - 1.0).clamp(0.0, (sorted.len() - 1) as f64);
    let below = place.floor() as usize;
    let above = (below + 1).min(sorted.len() - 1);
    sorted[below] + (place - below as f64) * (sorted[above] - sorted[below])
}

#[cfg(test)]
mod tests {
    use super::*;

    const DATA: [f64; 12] = [3.1, 2.7, 4.4, 3.9, 2.2, 5.0, 3.3, 4.1, 2.9, 3.6, 4.8, 3.0];

    fn mean_of(multiplicities: &[u32]) -> Vec<f64> {
        let sum: f64 = multiplicities
            .iter()
            .zip(DATA)
            .map(|(&m, x)| f64::from(m) * x)
            .sum();
        vec![sum / DATA.len() as f64]
    }

    fn bootstrap_of_the_mean(replicates: usize) -> Bootstrap<Infallible> {
        let settings = BootstrapSettings {
            replicates,
            seed: 7,
        };
        cluster_bootstrap(
            &[12],
            &mean_of(&[1; 12]),
            &settings,
            || (),
            |m, ()| Ok(mean_of(m)),
        )
        .unwrap()
    }

    #[test]
    fn the_standard_error_of_a_mean_is_the_known_one() {
        // The bootstrap distribution of a mean has variance (n - 1)/n s²/n exactly; 20000 replicates see it to about 0.5 %.
        let found = bootstrap_of_the_mean(20_000).standard_error(0).unwrap();
        let s = standard_deviation(&DATA).unwrap();
        let exact = s * (11.0_f64 / 12.0 / 12.0).sqrt();
        assert!((found / exact - 1.0).abs() < 0.02, "{found} {exact}");
    }

    #[test]
    fn any_number_of_threads_gives_the_same_replicates() {
        let pool = |threads| {
            rayon::ThreadPoolBuilder::new()
                .num_threads(threads)
                .build()
                .unwrap()
        };
        let one = pool(1).install(|| bootstrap_of_the_mean(500));
        let four = pool(4).install(|| bootstrap_of_the_mean(500));
        assert_eq!(one, four);
    }

    #[test]
    fn every_draw_has_as_many_clusters_as_there_are() {
        let mut multiplicities = [9; 5];
        for replicate in 0..50 {
            draw(1, replicate, &[2, 3], &mut multiplicities);
            assert_eq!(multiplicities[..2].iter().sum::<u32>(), 2);
            assert_eq!(multiplicities[2..].iter().sum::<u32>(), 3);
        }
        let mut other = [0; 5];
        draw(2, 49, &[2, 3], &mut other);
        assert_ne!(multiplicities, other);
    }

    #[test]
    fn failures_are_counted_with_their_reason_and_not_mixed_in() {
        let settings = BootstrapSettings {
            replicates: 300,
            seed: 0,
        };
        let refit = |m: &[u32], (): &mut ()| match m[0] {
            0 => Err("cluster 0 is missing"),
            1 => Ok(vec![f64::NAN]),
            2 => Ok(vec![]),
            _ => Ok(vec![f64::from(m[0])]),
        };
        let bootstrap = cluster_bootstrap(&[3], &[1.0], &settings, || (), refit).unwrap();
        assert_eq!(bootstrap.replicates.len() + bootstrap.failed.len(), 300);
        assert!(bootstrap.replicates.iter().all(|values| values == &[3.0]));
        for expected in [
            ReplicateFailure::Refit("cluster 0 is missing"),
            ReplicateFailure::WrongLength {
                expected: 1,
                found: 0,
            },
        ] {
            assert!(
                bootstrap
                    .failed
                    .iter()
                    .any(|failed| failed.failure == expected)
            );
        }
        assert!(
            bootstrap
                .failed
                .iter()
                .any(|f| matches!(f.failure, ReplicateFailure::NotFinite { place: 0, .. }))
        );
    }

    #[test]
    fn quantiles_and_intervals_worked_by_hand() {
        let bootstrap = Bootstrap::<Infallible> {
            estimate: vec![10.0],
            replicates: (1..=39).map(|i| vec![f64::from(i)]).collect(),
            failed: vec![],
        };
        // (39 + 1) 0.025 = 1: the smallest and the largest.
        let close = |found: [f64; 2], expected: [f64; 2]| {
            let near = |a: f64, b: f64| (a - b).abs() < 1e-13;
            assert!(
                near(found[0], expected[0]) && near(found[1], expected[1]),
                "{found:?}"
            );
        };
        close(bootstrap.percentile_interval(0, 0.95).unwrap(), [1.0, 39.0]);
        close(bootstrap.percentile_interval(0, 0.5).unwrap(), [10.0, 30.0]);
    }

    #[test]
    fn each_mistake_has_its_own_error() {
        let settings = BootstrapSettings::default();
        let refit = |m: &[u32], (): &mut ()| Ok::<_, Infallible>(mean_of(m));
        let one = cluster_bootstrap(&[5, 1], &[0.0], &settings, || (), refit);
        assert!(matches!(
            one,
            Err(LeastSquaresError::TooFewClusters { clusters: 1 })
        ));
        let few = bootstrap_of_the_mean(38);
        let refused = |place, coverage| few.percentile_interval(place, coverage).unwrap_err();
        let too_few = LeastSquaresError::TooFewReplicates {
            succeeded: 38,
            requested: 38,
            needed: 39,
        };
        assert_eq!(refused(0, 0.95).to_string(), too_few.to_string());
        let unknown = LeastSquaresError::UnknownParameter { index: 1, count: 1 };
        assert_eq!(refused(1, 0.95).to_string(), unknown.to_string());
        let error = refused(0, 1.0);
        assert!(matches!(
            error,
            LeastSquaresError::CoverageNotAProbability { .. }
        ));
        assert_eq!(few.standard_error(1), None);
    }
}
