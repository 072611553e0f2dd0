//! The cheapest change that meets linear demands.
//!
//! minimise Σ φₖ(xₖ) with Σ gₚₖ xₖ ≥ bₚ for every demand p and |xₖ| at most a bound. The costs are convex and each of its own variable, so
//! that the dual problem separates: given prices λₚ ≥ 0 of the demands, each xₖ follows from its own worth Σ λₚ gₚₖ alone. Prices are
//! raised one after the other until every demand is met (coordinate ascent of the dual).
//!
//! # Source
//! C. Hildreth, A quadratic programming procedure, Naval Research Logistics Quarterly 4 (1957) 79, for squares; P. Tseng, Mathematical
//! Programming 48 (1990) 249, for any strictly convex separable cost.

/// What a change xₖ costs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Price {
    /// x²/2.
    Square,
    /// weight (exp(x) - 1), and nothing may shrink.
    Growth {
        /// Cost per relative growth; positive.
        weight: f64,
    },
}

impl Price {
    /// The change that is worth its cost when a unit of it is worth `worth`.
    fn answer(self, worth: f64, bound: f64) -> f64 {
        match self {
            Self::Square => worth.clamp(-bound, bound),
            Self::Growth { weight } if worth > weight => (worth / weight).ln().min(bound),
            Self::Growth { .. } => 0.0,
        }
    }
}

/// Σ gₖ xₖ ≥ b.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Demand {
    pub(super) gains: Vec<f64>,
    pub(super) at_least: f64,
}

/// Rounds over all prices before giving up: near a corner where many demands meet, prices settle slowly.
const MOST_ROUNDS: usize = 2_000;
/// A demand is met if no more than this is missing: a relative change of 1e-10.
const MET: f64 = 1e-10;

/// The changes; `None` if no changes within the bound meet the demands.
pub(super) fn cheapest(prices: &[Price], demands: &[Demand], bound: f64) -> Option<Vec<f64>> {
    let mut worth = vec![0.0; prices.len()];
    let mut multipliers = vec![0.0_f64; demands.len()];
    let answer = |worth: &[f64]| -> Vec<f64> {
        let pairs = prices.iter().zip(worth);
        pairs
            .map(|(price, worth)| price.answer(*worth, bound))
            .collect()
    };
    for _ in 0..MOST_ROUNDS {
        let mut largest_gap = 0.0_f64;
        for (demand, multiplier) in demands.iter().zip(&mut multipliers) {
            let surplus = |raised: f64| {
                let terms = prices.iter().zip(&worth).zip(&demand.gains);
                let sum: f64 = terms
                    .map(|((price, worth), gain)| gain * price.answer(worth + raised * gain, bound))
                    .sum();
                sum - demand.at_least
            };
            let gap = surplus(0.0);
            // Already met at no price, or met to the last digit.
            if gap.abs() <= MET || (gap > 0.0 && *multiplier == 0.0) {
                continue;
            }
            largest_gap = largest_gap.max(gap.abs());
            let raised = root(surplus, -*multiplier)?;
            *multiplier += raised;
            for (worth, gain) in worth.iter_mut().zip(&demand.gains) {
                *worth += raised * gain;
            }
        }
        if largest_gap <= MET {
            return Some(answer(&worth));
        }
    }
    let found = answer(&worth);
    // Prices may creep where demands nearly repeat one another; what is met well enough is met.
    let is_met = |demand: &Demand| {
        let sum: f64 = demand.gains.iter().zip(&found).map(|(g, x)| g * x).sum();
        sum >= demand.at_least - 1e-6
    };
    demands.iter().all(is_met).then_some(found)
}

/// Where a rising function of the raise is zero, not below `lowest`; `lowest` where it is above zero already there. `None` if it never
/// reaches zero.
fn root(surplus: impl Fn(f64) -> f64, lowest: f64) -> Option<f64> {
    let here = surplus(0.0);
    let (mut low, mut high) = if here < 0.0 {
        let mut high = 1.0;
        while surplus(high) < 0.0 {
            high *= 4.0;
            if high > 1e30 {
                return None;
            }
        }
        (0.0, high)
    } else {
        if surplus(lowest) >= 0.0 {
            return Some(lowest);
        }
        (lowest, 0.0)
    };
    // Down to the last digit.
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if surplus(middle) < 0.0 {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(high)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn demand(gains: &[f64], at_least: f64) -> Demand {
        Demand {
            gains: gains.to_vec(),
            at_least,
        }
    }

    fn assert_near(found: &[f64], expected: &[f64]) {
        for (found_one, expected_one) in found.iter().zip(expected) {
            assert!(
                (found_one - expected_one).abs() < 1e-8,
                "{found:?} for {expected:?}"
            );
        }
    }

    #[test]
    fn one_demand_is_met_along_its_gains() {
        // min |x|²/2 with 3 x + 4 y ≥ 5: x = (3, 4) 5/25.
        let found = cheapest(&[Price::Square; 2], &[demand(&[3.0, 4.0], 5.0)], 10.0).unwrap();
        assert_near(&found, &[0.6, 0.8]);
    }

    #[test]
    fn two_demands_are_both_met_and_an_idle_one_costs_nothing() {
        // min |x|²/2 with x + y ≥ 2, x ≥ 1.5, y ≥ -9: the first two bind, so (1.5, 0.5).
        let demands = [
            demand(&[1.0, 1.0], 2.0),
            demand(&[1.0, 0.0], 1.5),
            demand(&[0.0, 1.0], -9.0),
        ];
        let found = cheapest(&[Price::Square; 2], &demands, 10.0).unwrap();
        assert_near(&found, &[1.5, 0.5]);
    }

    #[test]
    fn growth_goes_where_a_kilogram_helps_most() {
        // Gains per mass 2/1 and 1/1: only the first grows, until 2 x = 1.
        let prices = [Price::Growth { weight: 1.0 }, Price::Growth { weight: 1.0 }];
        let found = cheapest(&prices, &[demand(&[2.0, 1.0], 1.0)], 3.0).unwrap();
        assert_near(&found, &[0.5, 0.0]);
        // A large demand: e^x1 / 2 = e^x2 where both grow, x1 = x2 + ln 2, 3 x2 + 2 ln 2 = 3.
        let found = cheapest(&prices, &[demand(&[2.0, 1.0], 3.0)], 3.0).unwrap();
        let second = 1.0 - 2.0 / 3.0 * 2_f64.ln();
        assert_near(&found, &[second + 2_f64.ln(), second]);
    }

    #[test]
    fn what_no_change_meets_is_none() {
        assert_eq!(
            cheapest(&[Price::Square], &[demand(&[0.0], 1.0)], 3.0),
            None
        );
        assert_eq!(
            cheapest(&[Price::Square], &[demand(&[1.0], 4.0)], 3.0),
            None
        );
        let shrinking = [Price::Growth { weight: 1.0 }];
        assert_eq!(cheapest(&shrinking, &[demand(&[-1.0], 0.5)], 3.0), None);
    }

    /// Against the conditions of Karush, Kuhn and Tucker with demands that nearly repeat one another, as neighbouring poses do.
    #[test]
    fn neighbouring_demands_settle() {
        let demands: Vec<Demand> = (0..30)
            .map(|p| {
                let gains: Vec<f64> = (0..6)
                    .map(|k| 1.0 + 0.02 * (f64::from(p * (k + 1))).sin())
                    .collect();
                demand(&gains, 1.0 + 0.001 * f64::from(p))
            })
            .collect();
        let found = cheapest(&[Price::Square; 6], &demands, 3.0).unwrap();
        let slack =
            |d: &Demand| d.gains.iter().zip(&found).map(|(g, x)| g * x).sum::<f64>() - d.at_least;
        let tightest = demands.iter().map(slack).fold(f64::INFINITY, f64::min);
        assert!(tightest.abs() < 1e-6, "{tightest}");
        // No cheaper point: along the projection of -x on what keeps tight demands, nothing is left. With one or two tight demands of six
        // variables the cost of the first alone is a lower bound.
        let cost: f64 = found.iter().map(|x| x * x).sum();
        let bound = demands
            .iter()
            .map(|d| d.at_least.powi(2) / d.gains.iter().map(|g| g * g).sum::<f64>())
            .fold(0.0, f64::max);
        assert!(
            cost >= bound - 1e-9 && cost < 1.02 * bound,
            "{cost} {bound}"
        );
    }
}
