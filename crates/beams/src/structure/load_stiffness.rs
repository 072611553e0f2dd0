//! What a load that is there already does to the stiffness of an arm whose joints yield.
//!
//! The torques τ = Jᵀ w of a load w in fixed axes change as the arm moves, at w as it is: K_C = ∂(Jᵀ w)/∂θ. A further load dw then moves the
//! end by dx = C_w dw with
//!
//! ```text
//!   C_w = J C_θ (1 - K_C C_θ)⁻¹ Jᵀ,        and where J has an inverse   K_w = C_w⁻¹ = J⁻ᵀ (K_θ - K_C) J⁻¹
//! ```
//!
//! # Source
//! Chen and Kao, Conservative congruence transformation for joint and Cartesian stiffness matrices of robotic hands and fingers, Int. J.
//! Robotics Research 19 (2000) 835, eq. (12); Alici and Shirinzadeh, Enhanced stiffness modeling, identification and characterization for
//! robot manipulators, IEEE Trans. Robotics 21 (2005) 554. With C_θ in place of K_θ rigid joints need no limit.

use faer::Mat;
use faer::linalg::solvers::Solve;
use stiffbench_numeric::vector::{cross, dot, subtract};

use super::clusters::{Clusters, IndependentFreedom};
use super::compliance::Compliance6;
use super::parts::{Structure, StructureError};
use super::struts::strut_columns;

/// A hinge on the way from the ground to the end.
#[derive(Debug, Clone, Copy)]
struct Step {
    hinge: usize,
    /// Unit vector of its axis, in the sense in which it moves the end.
    axis: [f64; 3],
    node_m: [f64; 3],
    slides: bool,
    compliance: f64,
}

impl Structure {
    /// Compliance of the end for loads added to one that acts there, of an arm of rigid members with hinges that yield; `None` for any
    /// other structure, and where the load makes the arm unstable.
    ///
    /// # Arguments
    /// - `load`: Fx, Fy, Fz (N), Mx, My, Mz (N·m) in axes that do not move with the arm.
    ///
    /// # Returns
    /// As [`Compliance6`]; with a moment in the load it is not symmetric, since a moment in fixed axes has no potential.
    ///
    /// # Errors
    /// [`StructureError::HeldRigidBody`].
    pub fn compliance_under_load(
        &self,
        load: [f64; 6],
    ) -> Result<Option<Compliance6>, StructureError> {
        let clusters = Clusters::new(self)?;
        let Some(end) = clusters.vertex(&self.end) else {
            return Ok(None);
        };
        let root = clusters.root(end);
        let is_held = |node: usize| {
            let mut supports = self.supports.iter();
            supports.any(|support| support.node == node && support.held == [true; 6])
        };
        if !self.elements.is_empty() || !clusters.closures.is_empty() || !is_held(root) {
            return Ok(None);
        }
        let steps = self.steps(&clusters, end);
        if steps.iter().any(|step| !step.compliance.is_finite()) {
            return Ok(None);
        }
        let end_m = self.nodes[self.end.node].position_m;
        let count = steps.len();
        let jacobian = Mat::from_fn(6, count, |row, place| steps[place].motion(end_m)[row]);
        let mut turned = Mat::from_fn(count, count, |i, j| change(&steps, i, j, end_m, load));
        for strut in &self.struts {
            let columns = strut_columns(&clusters, &strut.ends);
            let own = strut.stiffness(self, &clusters, &columns);
            let freedoms = strut.freedoms(&clusters, &columns);
            let place = |freedom: &IndependentFreedom| steps.iter().position(|s| s.is(*freedom));
            let places: Vec<Option<usize>> = freedoms.iter().map(place).collect();
            for (entry, stiffness) in own.into_iter().enumerate() {
                let (row, column) = (entry / columns.len(), entry % columns.len());
                match (freedoms[row], freedoms[column], places[row], places[column]) {
                    // What is held does not move.
                    (IndependentFreedom::OfNode(..), ..)
                    | (_, IndependentFreedom::OfNode(..), ..) => {}
                    (_, _, Some(row), Some(column)) => turned[(row, column)] -= stiffness,
                    // A hinge that is not on the way to the end moves with those that are.
                    _ => return Ok(None),
                }
            }
        }
        // 1 - K_C C_θ, whose determinant is one without a load: a load that turns its sign has passed where the arm gives way.
        let eased = Mat::from_fn(count, count, |i, j| {
            f64::from(u8::from(i == j)) - turned[(i, j)] * steps[j].compliance
        });
        if count > 0 && eased.determinant() <= 0.0 {
            return Ok(None);
        }
        let solved = eased.partial_piv_lu().solve(jacobian.transpose());
        let whole = Mat::from_fn(count, 6, |i, j| steps[i].compliance * solved[(i, j)]);
        let product = &jacobian * &whole;
        Ok(Some(Compliance6(std::array::from_fn(|i| {
            std::array::from_fn(|j| product[(i, j)])
        }))))
    }

    /// Whether it is an arm of rigid members with hinges: nothing but its hinges yields, and they are in series.
    #[must_use]
    pub fn is_serial(&self) -> bool {
        let loops = Clusters::new(self).map_or(true, |clusters| !clusters.closures.is_empty());
        self.elements.is_empty() && !loops
    }

    fn steps(&self, clusters: &Clusters, end: usize) -> Vec<Step> {
        let columns = clusters.columns(self, end);
        let hinges = clusters.freedoms(end).zip(columns);
        let step = |(freedom, column): (IndependentFreedom, [f64; 6])| {
            let IndependentFreedom::OfHinge(hinge) = freedom else {
                return None;
            };
            let own = &self.hinges[hinge];
            let [x, y, z, rx, ry, rz] = column;
            Some(Step {
                hinge,
                axis: if own.slides { [x, y, z] } else { [rx, ry, rz] },
                node_m: self.nodes[self.node_of_hinge(hinge)?].position_m,
                slides: own.slides,
                compliance: 1.0 / own.stiffness_nm_per_rad,
            })
        };
        hinges.filter_map(step).collect()
    }
}

impl Step {
    fn is(&self, freedom: IndependentFreedom) -> bool {
        freedom == IndependentFreedom::OfHinge(self.hinge)
    }

    /// Motion of the end per unit of the hinge.
    fn motion(&self, end_m: [f64; 3]) -> [f64; 6] {
        let [x, y, z] = self.axis;
        if self.slides {
            return [x, y, z, 0.0, 0.0, 0.0];
        }
        let moved = cross(self.axis, subtract(end_m, self.node_m));
        [moved[0], moved[1], moved[2], x, y, z]
    }
}

/// Change of the load on hinge `i` per unit of hinge `j`: hinges and end behind `j` move with it.
fn change(steps: &[Step], i: usize, j: usize, end_m: [f64; 3], load: [f64; 6]) -> f64 {
    let (own, moving) = (&steps[i], &steps[j]);
    let (force, moment) = ([load[0], load[1], load[2]], [load[3], load[4], load[5]]);
    let arm = subtract(end_m, own.node_m);
    // Without its own axis and arm, which turn only behind `j`.
    if i < j {
        if own.slides {
            return 0.0;
        }
        let [x, y, z, ..] = moving.motion(end_m);
        return dot(own.axis, cross([x, y, z], force));
    }
    if moving.slides {
        return 0.0;
    }
    let axis = cross(moving.axis, own.axis);
    if own.slides {
        return dot(axis, force);
    }
    let by_force =
        dot(axis, cross(arm, force)) + dot(own.axis, cross(cross(moving.axis, arm), force));
    by_force + dot(axis, moment)
}
