//! Products of blocks of numbers with many vectors, in single precision.

use std::ops::Range;

use pulp::{Simd, WithSimd};

/// Registers that stand side by side: with [`ABREAST`] vectors as many sums as hide how long one takes.
const REGISTERS: usize = 5;

/// Vectors that share the reading of the blocks.
const ABREAST: usize = 4;

/// Blocks that are summed before their sum is added: as many as stay in the cache.
const TOGETHER: usize = 512;

/// For each vector the sum of the blocks, each times its share.
///
/// # Arguments
/// - `vectors`: shares of all blocks, vector by vector.
/// - `each`: takes the sums, in the order of the vectors; its loops use the same instructions if it is `#[inline(always)]`.
///
/// # Panics
/// If there are no blocks, or if they do not fill whole registers.
pub fn sums_of_blocks<const N: usize>(
    blocks: &[[f32; N]],
    vectors: &[f32],
    each: impl FnMut(&[f32; N]),
) {
    pulp::Arch::new().dispatch(BlockSums {
        blocks,
        vectors,
        each,
    });
}

struct BlockSums<'a, const N: usize, F> {
    blocks: &'a [[f32; N]],
    vectors: &'a [f32],
    each: F,
}

impl<const N: usize, F: FnMut(&[f32; N])> WithSimd for BlockSums<'_, N, F> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(mut self, simd: S) {
        let count = self.blocks.len();
        // Blocks that do not stay in the cache are read once for all vectors.
        let at_once = if count > TOGETHER {
            self.vectors.len()
        } else {
            ABREAST * count
        };
        let mut sums = Vec::new();
        for vectors in self.vectors.chunks(at_once.max(1)) {
            sums.clear();
            sums.resize(vectors.len() / count, [0.0; N]);
            for start in (0..count).step_by(TOGETHER) {
                let rows = start..count.min(start + TOGETHER);
                for (vectors, sums) in vectors
                    .chunks(ABREAST * count)
                    .zip(sums.chunks_mut(ABREAST))
                {
                    match sums.len() {
                        1 => self.add::<S, 1>(simd, &rows, vectors, sums),
                        2 => self.add::<S, 2>(simd, &rows, vectors, sums),
                        3 => self.add::<S, 3>(simd, &rows, vectors, sums),
                        _ => self.add::<S, ABREAST>(simd, &rows, vectors, sums),
                    }
                }
            }
            sums.iter().for_each(&mut self.each);
        }
    }
}

impl<const N: usize, F> BlockSums<'_, N, F> {
    /// Adds the sums over some blocks for `V` vectors.
    #[inline(always)]
    fn add<S: Simd, const V: usize>(
        &self,
        simd: S,
        rows: &Range<usize>,
        vectors: &[f32],
        out: &mut [[f32; N]],
    ) {
        let strip = REGISTERS * S::F32_LANES;
        assert!(N.is_multiple_of(strip), "blocks fill whole registers");
        let count = self.blocks.len();
        let vectors: [&[f32]; V] =
            std::array::from_fn(|place| &vectors[place * count..][rows.clone()]);
        for first in (0..N).step_by(strip) {
            let mut sums = [[simd.splat_f32s(0.0); REGISTERS]; V];
            for (place, block) in self.blocks[rows.clone()].iter().enumerate() {
                let (part, _) = S::as_simd_f32s(&block[first..first + strip]);
                for (sums, vector) in sums.iter_mut().zip(&vectors) {
                    let share = simd.splat_f32s(vector[place]);
                    for (sum, part) in sums.iter_mut().zip(part) {
                        *sum = simd.mul_add_e_f32s(*part, share, *sum);
                    }
                }
            }
            for (out, sums) in out.iter_mut().zip(sums) {
                let (out, _) = S::as_mut_simd_f32s(&mut out[first..first + strip]);
                for (out, sum) in out.iter_mut().zip(sums) {
                    *out = simd.add_f32s(*out, sum);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_are_those_of_every_number() {
        const N: usize = 80;
        for (count, vectors) in [(1, 1), (3, 9), (TOGETHER + 7, 5)] {
            let wave = |i: usize| (0.37 * i as f64).sin() as f32;
            let blocks: Vec<[f32; N]> = (0..count)
                .map(|block| std::array::from_fn(|place| wave(block * N + place)))
                .collect();
            let shares: Vec<f32> = (0..vectors * count).map(|i| wave(3 * i + 1)).collect();
            let mut found: Vec<[f32; N]> = Vec::new();
            sums_of_blocks(&blocks, &shares, |sums| found.push(*sums));
            assert_eq!(found.len(), vectors);
            for (found, shares) in found.iter().zip(shares.chunks(count)) {
                for (place, found) in found.iter().enumerate() {
                    let terms = blocks.iter().zip(shares);
                    let expected: f32 = terms.map(|(block, share)| block[place] * share).sum();
                    assert!((found - expected).abs() < 1e-4 * count as f32);
                }
            }
        }
    }
}
