//! Forces spread over elements, as what they do at the nodes.

use stiffbench_numeric::vector::{cross, norm, scale, subtract};

use super::element::Attachment;
use super::parts::Structure;

/// A force and a moment where they act: (Fx, Fy, Fz, Mx, My, Mz), N and N·m.
pub type LoadAt = (Attachment, [f64; 6]);

impl Structure {
    /// The loads at the ends of an element that move all nodes as a force does that is spread evenly over its length.
    ///
    /// Half of the force at each end, and the moments L²/12 x × w and its opposite, x the unit vector along the element: with these
    /// consistent loads the displacements of the nodes are exact, however long the element; between the nodes and in the element
    /// forces the bulge of the loaded span is missing.
    ///
    /// # Arguments
    /// - `element`: index of the element.
    /// - `force_n_per_m`: force per length in global axes, N/m.
    ///
    /// # Source
    /// Przemieniecki, Theory of Matrix Structural Analysis (1968), section 5.6 (equivalent concentrated forces); the moments are those
    /// of a beam clamped at both ends, with shear deformation too.
    #[must_use]
    pub fn spread_force(&self, element: usize, force_n_per_m: [f64; 3]) -> [LoadAt; 2] {
        let ends = &self.elements[element].ends;
        let [first, second] = [0, 1].map(|end: usize| self.nodes[ends[end].node].position_m);
        let span_m = subtract(second, first);
        let [fx, fy, fz] = scale(force_n_per_m, 0.5 * norm(span_m));
        let moment = scale(cross(span_m, force_n_per_m), norm(span_m) / 12.0);
        [1.0, -1.0].map(|sign| {
            let end = usize::from(sign < 0.0);
            let [mx, my, mz] = scale(moment, sign);
            (ends[end].clone(), [fx, fy, fz, mx, my, mz])
        })
    }
}
