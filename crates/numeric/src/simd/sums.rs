//! Sums over long slices.

/// Scalar product; eight sums side by side, which the compiler makes lanes of.
#[inline(always)]
#[must_use]
pub fn sums_side_by_side(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 8];
    let (a_chunks, b_chunks) = (a.chunks_exact(8), b.chunks_exact(8));
    let rest: f64 = a_chunks
        .remainder()
        .iter()
        .zip(b_chunks.remainder())
        .map(|(x, y)| x * y)
        .sum();
    for (x, y) in a_chunks.zip(b_chunks) {
        for lane in 0..8 {
            sums[lane] += x[lane] * y[lane];
        }
    }
    sums.iter().sum::<f64>() + rest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_length_is_summed_whole() {
        for count in 0..40 {
            let values: Vec<f64> = (1..=count).map(f64::from).collect();
            let ones = vec![1.0; values.len()];
            let all = f64::from(count * (count + 1) / 2);
            assert_eq!(sums_side_by_side(&values, &ones), all);
        }
    }
}
