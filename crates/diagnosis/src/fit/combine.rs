//! From the factors of single poses to one set: the paper's weighted integration (step 8).

use stiffbench_beams::robot::FittingFactors;

/// Weighted mean of factor sets.
///
/// The paper calls it a weighted integration and states no weights; plain means reproduce its printed sets but for two entries
/// (a_Iz 2.035, printed 2.025; a_A of the beams 0.002907, printed 0.002997), so weights are an input. Weights are scaled to add up
/// to one. Returns `None` for no sets, or weights that are negative or add up to nothing.
#[must_use]
pub fn combine(sets: &[(FittingFactors, f64)]) -> Option<FittingFactors> {
    let total: f64 = sets.iter().map(|(_, weight)| weight).sum();
    let usable = total.is_finite() && total > 0.0 && sets.iter().all(|(_, weight)| *weight >= 0.0);
    if !usable {
        return None;
    }
    let mean = |of: &dyn Fn(&FittingFactors) -> f64| {
        sets.iter()
            .map(|(set, weight)| of(set) * weight / total)
            .sum()
    };
    Some(FittingFactors::of_classes(
        std::array::from_fn(|i| mean(&|set| set.beam[i])),
        std::array::from_fn(|i| mean(&|set| set.link[i])),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_weights_give_the_papers_single_source_factors_but_for_one_print() {
        // Section IV-B: P1 (0.00645, 0.0273, 2.12, 1) and P3 (0.00571, 0.0300, 1.95, 1); printed 0.00608, 0.0285, 2.025, 1.
        let [p1, p3] = [[0.00645, 0.0273, 2.12, 1.0], [0.00571, 0.0300, 1.95, 1.0]]
            .map(|factors| FittingFactors::of_classes(factors, factors));
        let combined = combine(&[(p1, 0.5), (p3, 0.5)]).unwrap().beam;
        for (found, expected) in combined.into_iter().zip([0.00608, 0.02865, 2.035, 1.0]) {
            assert!((found / expected - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn unusable_weights_give_nothing() {
        assert_eq!(combine(&[]), None);
        assert_eq!(combine(&[(FittingFactors::UNIT, 0.0)]), None);
        assert_eq!(
            combine(&[(FittingFactors::UNIT, -1.0), (FittingFactors::UNIT, 2.0)]),
            None
        );
    }
}
