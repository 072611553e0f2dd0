//! Products of blocks of numbers with many vectors, in single precision.

use pulp::{Simd, WithSimd};

/// Registers that stand side by side: with four vectors at a time as many sums as hide how long one takes.
const REGISTERS: usize = 5;

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
        let mut fours = self.vectors.chunks_exact(4 * count);
        for four in fours.by_ref() {
            self.take::<S, 4>(simd, four);
        }
        let rest = fours.remainder();
        match rest.len() / count {
            3 => self.take::<S, 3>(simd, rest),
            2 => self.take::<S, 2>(simd, rest),
            1 => self.take::<S, 1>(simd, rest),
            _ => (),
        }
    }
}

impl<const N: usize, F: FnMut(&[f32; N])> BlockSums<'_, N, F> {
    /// Hands on the sums for `V` vectors.
    #[inline(always)]
    fn take<S: Simd, const V: usize>(&mut self, simd: S, vectors: &[f32]) {
        let count = self.blocks.len();
        let vectors = std::array::from_fn(|place| &vectors[place * count..][..count]);
        for sums in &sums::<S, N, V>(simd, self.blocks, vectors) {
            (self.each)(sums);
        }
    }
}

/// Sums for a few vectors, which share the reading of the blocks.
#[inline(always)]
fn sums<S: Simd, const N: usize, const V: usize>(
    simd: S,
    blocks: &[[f32; N]],
    vectors: [&[f32]; V],
) -> [[f32; N]; V] {
    let strip = REGISTERS * S::F32_LANES;
    assert!(N.is_multiple_of(strip), "blocks fill whole registers");
    let mut out = [[0.0; N]; V];
    for start in (0..blocks.len()).step_by(TOGETHER) {
        let end = blocks.len().min(start + TOGETHER);
        let vectors = vectors.map(|vector| &vector[start..end]);
        for first in (0..N).step_by(strip) {
            let mut sums = [[simd.splat_f32s(0.0); REGISTERS]; V];
            for (place, block) in blocks[start..end].iter().enumerate() {
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
                    *out = if start == 0 {
                        sum
                    } else {
                        simd.add_f32s(*out, sum)
                    };
                }
            }
        }
    }
    out
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
