//! Mass, centre and moments of inertia of rigid bodies made of rods and points.

use crate::vector::{norm, subtract};

use super::xml::Xml;

/// What a body without mass weighs in a file, kg, and what is added to each moment of inertia, kg·m²: MuJoCo takes 1e-15, and 12 digits are
/// written.
pub(super) const PLACEHOLDER: f64 = 1e-12;

/// Ends of a rigid link nearer to one another than this, m, are one place, and it is not drawn.
const SAME_PLACE_M: f64 = 1e-9;

/// Radius of what stands for a rigid link in pictures, as a share of its length.
const SLENDER: f64 = 0.04;

/// Radius of the ball that stands for a mass at a point, m: without any size two of them would have no inertia about the line between them.
const BALL_M: f64 = 0.05;

/// A round rod, which stands for a beam or a rigid link.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rod {
    /// Its ends, m.
    pub ends_m: [[f64; 3]; 2],
    /// Its radius, m.
    pub radius_m: f64,
}

impl Rod {
    /// Of a beam: it has the area of the section, m².
    #[must_use]
    pub fn beam(ends_m: [[f64; 3]; 2], area_m2: f64) -> Self {
        let radius_m = (area_m2 / std::f64::consts::PI).sqrt();
        Self { ends_m, radius_m }
    }

    /// Of a rigid link, for pictures; `None` where its ends lie in one place.
    #[must_use]
    pub fn rigid([a, b]: [[f64; 3]; 2]) -> Option<Self> {
        let length_m = norm(subtract(b, a));
        (length_m > SAME_PLACE_M).then_some(Self {
            ends_m: [a, b],
            radius_m: SLENDER * length_m,
        })
    }
}

/// What a rigid body weighs, in the axes of the world.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Inertia {
    mass_kg: f64,
    /// Mass times centre, kg·m.
    first_kg_m: [f64; 3],
    /// Integral of x xᵀ over the mass about the origin of the world, kg·m².
    second_kg_m2: [[f64; 3]; 3],
}

impl Inertia {
    /// A mass at a point: a ball, of which ∫ x xᵀ dm = m r²/5 about its centre.
    #[must_use]
    pub fn point(mass_kg: f64, at_m: [f64; 3]) -> Self {
        let mut ball = Self::at(mass_kg, at_m);
        for i in 0..3 {
            ball.second_kg_m2[i][i] += mass_kg * BALL_M * BALL_M / 5.0;
        }
        ball
    }

    /// A mass without any size.
    fn at(mass_kg: f64, at_m: [f64; 3]) -> Self {
        Self {
            mass_kg,
            first_kg_m: at_m.map(|x| mass_kg * x),
            second_kg_m2: [0, 1, 2].map(|i| [0, 1, 2].map(|j| mass_kg * at_m[i] * at_m[j])),
        }
    }

    /// A round rod.
    ///
    /// About its centre ∫ x xᵀ dm = m (L² u uᵀ/12 + r² (1 - u uᵀ)/4) with u along it (Goldstein, Classical Mechanics, 3rd edition,
    /// section 5.3, for the inertia tensor).
    #[must_use]
    pub fn rod(kg_per_m: f64, rod: Rod) -> Self {
        let [a, b] = rod.ends_m;
        let span_m = subtract(b, a);
        let length_m = norm(span_m);
        if length_m == 0.0 {
            return Self::default();
        }
        let mass_kg = kg_per_m * length_m;
        let along = span_m.map(|x| x / length_m);
        let (lengthwise, across) = (length_m * length_m / 12.0, rod.radius_m.powi(2) / 4.0);
        let mut rod = Self::at(mass_kg, [0, 1, 2].map(|i| 0.5 * (a[i] + b[i])));
        for i in 0..3 {
            for j in 0..3 {
                let axial = along[i] * along[j];
                let unit = if i == j { 1.0 } else { 0.0 };
                rod.second_kg_m2[i][j] += mass_kg * (lengthwise * axial + across * (unit - axial));
            }
        }
        rod
    }

    /// Both together.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        let sum = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| a[i] + b[i]);
        Self {
            mass_kg: self.mass_kg + other.mass_kg,
            first_kg_m: sum(self.first_kg_m, other.first_kg_m),
            second_kg_m2: [0, 1, 2].map(|i| sum(self.second_kg_m2[i], other.second_kg_m2[i])),
        }
    }

    /// Mass, kg.
    #[must_use]
    pub fn mass_kg(&self) -> f64 {
        self.mass_kg
    }

    /// Centre of mass, m; `None` without mass.
    #[must_use]
    pub fn centre_m(&self) -> Option<[f64; 3]> {
        (self.mass_kg > 0.0).then(|| self.first_kg_m.map(|x| x / self.mass_kg))
    }

    /// Inertia tensor about the centre of mass, 3 × 3, kg·m²; zero without mass.
    #[must_use]
    pub fn about_centre_kg_m2(&self) -> [[f64; 3]; 3] {
        let Some(centre) = self.centre_m() else {
            return [[0.0; 3]; 3];
        };
        let spread =
            |i: usize, j: usize| self.second_kg_m2[i][j] - self.mass_kg * centre[i] * centre[j];
        let trace = spread(0, 0) + spread(1, 1) + spread(2, 2);
        [0, 1, 2].map(|i| [0, 1, 2].map(|j| if i == j { trace } else { 0.0 } - spread(i, j)))
    }
}

/// What is written of a body's mass.
#[derive(Debug, Clone, Copy)]
pub(super) struct Inertial {
    /// kg.
    pub(super) mass_kg: f64,
    /// From the origin of the body, in the axes of the world, m.
    pub(super) centre_m: [f64; 3],
    /// Inertia tensor about the centre, kg·m².
    pub(super) about_kg_m2: [[f64; 3]; 3],
}

impl Inertial {
    /// Of a body; where it has no mass a placeholder, which a comment states.
    pub(super) fn stated(xml: &mut Xml, inertia: &Inertia, origin_m: [f64; 3]) -> Self {
        if inertia.mass_kg == 0.0 {
            xml.comment("placeholder: the robot file gives this body no mass");
        }
        Self::of(inertia, origin_m)
    }

    fn of(inertia: &Inertia, origin_m: [f64; 3]) -> Self {
        let mut about_kg_m2 = inertia.about_centre_kg_m2();
        for (i, row) in about_kg_m2.iter_mut().enumerate() {
            row[i] += PLACEHOLDER;
        }
        Self {
            mass_kg: inertia.mass_kg.max(PLACEHOLDER),
            centre_m: subtract(inertia.centre_m().unwrap_or(origin_m), origin_m),
            about_kg_m2,
        }
    }

    /// The six moments of inertia by the names of URDF and SDF, kg·m².
    pub(super) fn moments(&self) -> [(&'static str, f64); 6] {
        let [[xx, xy, xz], [_, yy, yz], [_, _, zz]] = self.about_kg_m2;
        [
            ("ixx", xx),
            ("ixy", xy),
            ("ixz", xz),
            ("iyy", yy),
            ("iyz", yz),
            ("izz", zz),
        ]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::vector::{cross, dot};

    #[test]
    fn a_rod_made_of_two_halves_is_the_whole() {
        let ends = [[0.1, -0.2, 0.3], [0.4, 0.2, 0.3]];
        let middle = [0.25, 0.0, 0.3];
        let rod = |ends_m| {
            let radius_m = 0.01;
            Inertia::rod(3.0, Rod { ends_m, radius_m })
        };
        let whole = rod(ends);
        let halves = [[ends[0], middle], [middle, ends[1]]];
        let halves = halves.map(rod);
        let sum = halves[0].with(halves[1]);
        assert!((sum.mass_kg() - 1.5).abs() < 1e-15);
        // m L²/12 + m r²/4 across, m r²/2 along.
        let [a, b] = [whole, sum].map(|one| one.about_centre_kg_m2());
        for i in 0..3 {
            for j in 0..3 {
                assert!((a[i][j] - b[i][j]).abs() < 1e-15, "{a:?} {b:?}");
            }
        }
        assert!((a[2][2] - 1.5 * (0.25 / 12.0 + 1e-4 / 4.0)).abs() < 1e-15);
        let along = [0.6, 0.8, 0.0];
        let axial: f64 = (0..3)
            .map(|i| (0..3).map(|j| along[i] * a[i][j] * along[j]).sum::<f64>())
            .sum();
        assert!((axial - 1.5 * 1e-4 / 2.0).abs() < 1e-15);
    }

    #[test]
    fn what_is_written_is_the_inertia_of_a_body() {
        // Points near and far from one another and from the origin, small and large, and nothing.
        let mut bodies = vec![Inertia::default(), Inertia::point(1e-15, [0.1, 0.2, 0.3])];
        for apart_m in [1e-6, 0.1, 30.0] {
            for kg in [1e-9, 2.0, 4e3] {
                let first_m = [10.0, -20.0, 5.0];
                let second_m = [0.48, -0.6, 0.64].map(|x| x * apart_m);
                let second_m = [0, 1, 2].map(|i| first_m[i] + second_m[i]);
                let two = Inertia::point(3.0, first_m).with(Inertia::point(kg, second_m));
                assert!((two.mass_kg() / (3.0 + kg) - 1.0).abs() < 1e-15);
                bodies.push(two);
            }
        }
        // As many digits as a file has.
        let rounded = |value: f64| format!("{value:.11e}").parse::<f64>().unwrap();
        for body in bodies {
            let inertial = Inertial::of(&body, [0.0; 3]);
            assert!(inertial.mass_kg >= PLACEHOLDER);
            let written = inertial.about_kg_m2.map(|row| row.map(rounded));
            // All moments are positive and A + B > C where trace/2 - I is positive definite: leading minors.
            let mut m = written.map(|row| row.map(|x| -x));
            for i in 0..3 {
                m[i][i] += (written[0][0] + written[1][1] + written[2][2]) / 2.0;
            }
            let minor = m[0][0] * m[1][1] - m[0][1] * m[1][0];
            let whole = dot(m[0], cross(m[1], m[2]));
            assert!(m[0][0] > 0.0 && minor > 0.0 && whole > 0.0, "{written:?}");
        }
    }
}
