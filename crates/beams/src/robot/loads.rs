//! Masses and balancers: what loads a robot besides the forces of a measurement.

/// Where a mass sits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum MassPlace {
    /// At a node.
    Node(usize),
    /// Its centre at a point of a body, which moves with the joints of its pose whether or not the body is part of the mechanism.
    Point(BodyPoint),
}

/// A point fixed on a body.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyPoint {
    /// The body.
    pub body: usize,
    /// Coordinates in its axes, m.
    pub at_m: [f64; 3],
}

/// A mass of the robot that is not that of a section.
#[derive(Debug, Clone, PartialEq)]
pub struct PointMass {
    /// Name for tables.
    pub name: String,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Where its centre is.
    pub place: MassPlace,
}

/// A spring or gas cylinder between two bodies that carries part of the weight.
#[derive(Debug, Clone, PartialEq)]
pub struct Balancer {
    /// Name for tables.
    pub name: String,
    /// Its two pivots.
    pub pivots: [BodyPoint; 2],
    /// How its force follows from the distance of the pivots.
    pub force: BalancerForce,
}

/// Force of a balancer against the distance L of its pivots; above zero it pulls them together, N.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum BalancerForce {
    /// preload + stiffness (L - length).
    Spring {
        /// Stiffness, N/m.
        stiffness_n_per_m: f64,
        /// Force at the length, N.
        preload_n: f64,
        /// The length, m.
        length_m: f64,
    },
    /// Force of an enclosed gas: preload (g / (g - (L - length)))^exponent if it pulls, with the opposite signs if it pushes.
    Gas {
        /// Force at the length, N; below zero for a cylinder that pushes.
        preload_n: f64,
        /// The length, m.
        length_m: f64,
        /// Gas volume at the length over the area of the piston, g, m.
        gas_column_m: f64,
        /// 1 for slow (isothermal) changes, 1.4 for fast ones of nitrogen.
        exponent: f64,
    },
}

impl BalancerForce {
    /// Force, N, and its derivative to the distance, N/m; no numbers where the gas would have no volume.
    #[must_use]
    pub fn at(self, distance_m: f64) -> (f64, f64) {
        match self {
            Self::Spring {
                stiffness_n_per_m,
                preload_n,
                length_m,
            } => (
                preload_n + stiffness_n_per_m * (distance_m - length_m),
                stiffness_n_per_m,
            ),
            Self::Gas {
                preload_n,
                length_m,
                gas_column_m,
                exponent,
            } => {
                let shortening = preload_n.signum();
                let column_m = gas_column_m - shortening * (distance_m - length_m);
                let force_n = preload_n * (gas_column_m / column_m).powf(exponent);
                (force_n, force_n * exponent * shortening / column_m)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stiffness_is_the_derivative_of_the_force() {
        let spring = BalancerForce::Spring {
            stiffness_n_per_m: 2e4,
            preload_n: 300.0,
            length_m: 0.5,
        };
        let gas = |preload_n| BalancerForce::Gas {
            preload_n,
            length_m: 0.5,
            gas_column_m: 0.4,
            exponent: 1.2,
        };
        for force in [spring, gas(900.0), gas(-900.0)] {
            let step = 1e-6;
            let slope = (force.at(0.6 + step).0 - force.at(0.6 - step).0) / (2.0 * step);
            let (_, stiffness) = force.at(0.6);
            assert!((slope / stiffness - 1.0).abs() < 1e-8, "{force:?}");
            assert!(stiffness > 0.0, "a longer one pulls more or pushes less");
        }
        assert_eq!(gas(900.0).at(0.5).0, 900.0);
        assert_eq!(gas(-900.0).at(0.5).0, -900.0);
        assert_eq!(spring.at(0.5).0, 300.0);
    }
}
