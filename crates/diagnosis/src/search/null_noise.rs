//! White noise for null samples: resampled from smoothed residuals where there are enough of them, else normal.

use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

use stiffbench_numeric::statistics::{NORMAL_MEDIAN_DEVIATION, median};

use super::constants::SAMPLES_TOGETHER;

/// Residuals from which on they show their distribution (1); with fewer the noise is normal. By hand (d2ad58c).
const ENOUGH_FOR_A_DISTRIBUTION: usize = 200;

/// Residuals beyond this many standard deviations are resampled as if they were there: they may be the effect that is searched for. By hand
/// (d2ad58c).
const LARGEST_RESAMPLED: f64 = 4.5;

/// Standard deviation of the normal part added to each resampled residual, in those of the residuals, so that no sample is one of the few
/// hundred values seen. By hand (d2ad58c).
const SMOOTHING: f64 = 0.3;

/// Smoothed residuals that are drawn from (1): so many that each is rare. Numerics.
const POOL: usize = 1 << 16;

/// A source of white residuals of rows with nothing missing.
pub trait DrawResiduals: Sync + std::fmt::Debug {
    /// One white residual a row.
    fn draw(&self, rng: &mut ChaCha8Rng) -> Vec<f64>;
}

/// Noise for null samples; the same seed gives the same samples on any number of threads.
#[derive(Debug)]
pub struct NullNoise<'a> {
    /// What is drawn from; normal numbers if it is empty.
    pool: Vec<f32>,
    drawn: Option<&'a dyn DrawResiduals>,
    seed: u64,
    samples: usize,
}

impl<'a> NullNoise<'a> {
    /// Normal noise.
    ///
    /// # Arguments
    /// - `samples`: how many, a multiple of `SAMPLES_TOGETHER`; less than one such number of them are left out.
    #[must_use]
    pub fn normal(samples: usize, seed: u64) -> Self {
        Self {
            pool: Vec::new(),
            drawn: None,
            seed,
            samples,
        }
    }

    /// Noise with the distribution of white residuals, so that skewed or long-tailed ones raise the critical values of candidates that lean
    /// on few rows; normal noise where they are too few to show it.
    ///
    /// # Arguments
    /// - `drawn`: takes the place of the noise of the first rows, as many as it draws.
    #[must_use]
    pub fn like(
        residuals: &[f64],
        drawn: Option<&'a dyn DrawResiduals>,
        samples: usize,
        seed: u64,
    ) -> Self {
        Self {
            pool: smoothed(&standardised(residuals), seed),
            drawn,
            ..Self::normal(samples, seed)
        }
    }

    /// Blocks of [`SAMPLES_TOGETHER`] samples.
    pub(super) fn blocks(&self) -> usize {
        self.samples / SAMPLES_TOGETHER
    }

    /// White noise of a block: [`SAMPLES_TOGETHER`] numbers of each row, one row after the other.
    pub(super) fn block(&self, block: usize, rows: usize) -> Vec<f32> {
        // Each block has a stream of its own, the smoothed residuals have the first: no seed has blocks of another.
        let mut rng = ChaCha8Rng::seed_from_u64(self.seed);
        rng.set_stream(1 + block as u64);
        let mut noise = vec![0.0; rows * SAMPLES_TOGETHER];
        self.fill(&mut noise, &mut rng);
        if let Some(drawn) = self.drawn {
            put_drawn(&mut noise, drawn, &mut rng);
        }
        noise
    }

    fn fill(&self, noise: &mut [f32], rng: &mut ChaCha8Rng) {
        let pool = &self.pool;
        if pool.is_empty() {
            noise.fill_with(|| StandardNormal.sample(rng));
            return;
        }
        // The high half of 32 random bits times the count is a place in it: two from one random number.
        let taken = |bits: u64| pool[(((bits & 0xffff_ffff) * pool.len() as u64) >> 32) as usize];
        for pair in noise.chunks_mut(2) {
            let bits = rng.next_u64();
            for (value, bits) in pair.iter_mut().zip([bits, bits >> 32]) {
                *value = taken(bits);
            }
        }
    }
}

/// Puts drawn residuals in the place of the noise of the first rows.
pub(crate) fn put_drawn(noise: &mut [f32], drawn: &dyn DrawResiduals, rng: &mut ChaCha8Rng) {
    for sample in 0..SAMPLES_TOGETHER {
        let of_sample = noise.iter_mut().skip(sample).step_by(SAMPLES_TOGETHER);
        for (value, white) in of_sample.zip(drawn.draw(rng)) {
            *value = white as f32;
        }
    }
}

/// Residuals of mean 0 and standard deviation 1, the outermost drawn in, as seen by the median deviation; none where they are too few.
fn standardised(residuals: &[f64]) -> Vec<f64> {
    if residuals.len() < ENOUGH_FOR_A_DISTRIBUTION {
        return Vec::new();
    }
    let limited: Vec<f64> = {
        let mut sizes: Vec<f64> = residuals.iter().map(|r| r.abs()).collect();
        // The limit needs no more than a rough size.
        let sd = median(&mut sizes).unwrap_or(1.0) / NORMAL_MEDIAN_DEVIATION;
        let most = LARGEST_RESAMPLED * sd.max(f64::MIN_POSITIVE);
        residuals.iter().map(|r| r.clamp(-most, most)).collect()
    };
    let n = limited.len() as f64;
    let mean = limited.iter().sum::<f64>() / n;
    let variance = limited.iter().map(|r| (r - mean).powi(2)).sum::<f64>() / n;
    let sd = variance.sqrt().max(f64::MIN_POSITIVE);
    limited.iter().map(|r| (r - mean) / sd).collect()
}

/// Residuals, each as often as any other, with other normal parts each time.
fn smoothed(residuals: &[f64], seed: u64) -> Vec<f32> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let each = POOL / residuals.len().max(1);
    let all = (0..each).flat_map(|_| residuals);
    all.map(|residual| {
        let normal: f64 = StandardNormal.sample(&mut rng);
        ((residual + SMOOTHING * normal) / (1.0 + SMOOTHING * SMOOTHING).sqrt()) as f32
    })
    .collect()
}
