//! Chances of tests, and of families of them.

use stiffbench_numeric::statistics::{chi_squared_upper_tail, f_upper_tail};

/// Chance that F with these degrees of freedom is larger; χ² for a known variance.
pub(super) fn tail(statistic: f64, d1: f64, d2: f64) -> f64 {
    let p = if d2.is_infinite() {
        chi_squared_upper_tail(statistic * d1, d1)
    } else {
        f_upper_tail(statistic, d1, d2)
    };
    p.unwrap_or(1.0).clamp(0.0, 1.0)
}

/// Family-wise chances by Holm's step-down, in the order given.
pub(crate) fn holm(p: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..p.len()).collect();
    order.sort_by(|&a, &b| p[a].total_cmp(&p[b]));
    let mut out = vec![1.0; p.len()];
    let mut largest = 0.0_f64;
    for (rank, place) in order.into_iter().enumerate() {
        largest = largest.max(((p.len() - rank) as f64 * p[place]).min(1.0));
        out[place] = largest;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn holm_steps_down() {
        // Holm's own rule by hand: 4 · 0.01, 3 · 0.015, then never less.
        let family = holm(&[0.03, 0.01, 0.015, 0.9]);
        let expected = [0.06, 0.04, 0.045, 0.9];
        for (found, expected) in family.iter().zip(expected) {
            assert!((found - expected).abs() < 1e-12, "{family:?}");
        }
        assert_eq!(holm(&[0.4, 0.5]), [0.8, 0.8]);
    }
}
