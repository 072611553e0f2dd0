//! Hinges that struts stand over: what a strut resists couples their twists.
//!
//! With T the motions of the point by the twists and K = diag(1/c) plus the stiffness of the struts over them, the compliance is T K⁻¹ Tᵀ.
//! K = L D Lᵀ makes it Σ w wᵀ/d over the columns w of T L⁻ᵀ.

use pulp::Simd;

use super::block::Block;
use super::graph::Segment;
use super::member::{add_dyad, hinge_motion};
use super::placed::{Placed, PlacedStrut};
use super::substructure::Reduction;
use crate::structure::clusters::{Clusters, IndependentFreedom};
use crate::structure::parts::Structure;
use crate::structure::solve::LOST_PIVOT;
use crate::structure::struts::strut_columns;
use crate::structure::topology::held_freedoms;
use stiffbench_numeric::simd::{
    Aligned, Lane, Number, cross, dot, multiply_add, multiply_subtract, scale, subtract,
};

/// Most hinges that struts may couple: a balancer stands over one or two joints.
const MOST: usize = 8;

/// Hinges that struts stand over.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Braced {
    pub(super) hinges: Vec<usize>,
    /// Of each end of each strut the hinges that move it and not the other end, from the ground outward, by place among `hinges`.
    struts: Vec<[Vec<usize>; 2]>,
}

impl Braced {
    /// `None` if a strut stands over anything but hinges, over hinges of a loop, or over too many.
    pub(super) fn of(structure: &Structure) -> Option<Self> {
        let mut braced = Self::default();
        if structure.struts.is_empty() {
            return Some(braced);
        }
        let clusters = Clusters::new(structure).ok()?;
        let held = held_freedoms(structure);
        for strut in &structure.struts {
            let vertices = strut.ends.iter().flatten();
            let mut vertices = vertices.map(|at| clusters.vertex(at));
            let outward = |vertex: Option<usize>| vertex.is_some_and(|v| clusters.is_outward(v));
            if !vertices.all(outward) {
                return None;
            }
            let columns = strut_columns(&clusters, &strut.ends);
            let mut own = [Vec::new(), Vec::new()];
            for (freedom, (end, _)) in strut.freedoms(&clusters, &columns).iter().zip(&columns) {
                match *freedom {
                    IndependentFreedom::OfNode(node, component) if held[node][component] => {}
                    IndependentFreedom::OfNode(..) => return None,
                    IndependentFreedom::OfHinge(hinge) => own[*end].push(braced.place_of(hinge)),
                }
            }
            braced.struts.push(own);
        }
        (clusters.closures.is_empty() && braced.hinges.len() <= MOST).then_some(braced)
    }

    /// Whether a segment is one of its hinges.
    pub(super) fn holds(&self, segment: &Segment) -> bool {
        let hinge = segment.hinge();
        hinge.is_some_and(|hinge| self.hinges.contains(&hinge))
    }

    /// Number of a hinge, which is added if it is new.
    fn place_of(&mut self, hinge: usize) -> usize {
        let known = self.hinges.iter().position(|known| *known == hinge);
        known.unwrap_or_else(|| {
            self.hinges.push(hinge);
            self.hinges.len() - 1
        })
    }

    /// Adds the compliance of all its hinges.
    ///
    /// # Arguments
    /// - `nodes`, `origin_m`: nodes seen from the point, m, and where that is.
    /// - `faults`: gains 1 in poses in which the hinges do not hold.
    #[inline(always)]
    pub(super) fn add<S: Simd>(
        &self,
        reduction: &Reduction,
        placed: &Placed<S>,
        nodes: &[Aligned<[Lane<S>; 3]>],
        origin_m: &[Lane<S>; 3],
        faults: &mut Lane<S>,
        sum: &mut Block<S, 6>,
    ) {
        let zero = faults.of(0.0);
        let mut motions = [[zero; 6]; MOST];
        let mut stiffness = [[zero; MOST]; MOST];
        for (place, &hinge) in self.hinges.iter().enumerate() {
            let own = &reduction.hinges[hinge];
            let axis = &placed.normals[own.plane].0;
            motions[place] = hinge_motion(&nodes[own.node].0, axis, own.slides);
            stiffness[place][place] = zero.of(1.0 / own.rad_per_nm);
        }
        for (strut, places) in placed.struts.iter().zip(&self.struts) {
            brace(strut, places, &motions, origin_m, &mut stiffness);
        }
        let count = self.hinges.len();
        let mut before = [zero; MOST];
        for k in 0..count {
            before[k] = stiffness[k][k];
        }
        for k in 0..count {
            let row = stiffness[k];
            *faults += (-row[k]).fault_unless_below(zero);
            *faults += (before[k] * zero.of(LOST_PIVOT)).fault_unless_below(row[k]);
            let inverse = row[k].inverse();
            let motion = motions[k];
            for i in k + 1..count {
                let factor = row[i] * inverse;
                for j in i..count {
                    stiffness[i][j] = multiply_subtract(factor, row[j], stiffness[i][j]);
                }
                for (entry, own) in motions[i].iter_mut().zip(motion) {
                    *entry = multiply_subtract(factor, own, *entry);
                }
            }
            add_dyad(inverse, &motion, sum);
        }
    }
}

/// Adds what a strut resists to the upper triangle of the stiffness of the hinges: see [`Strut`](crate::structure::Strut).
#[inline(always)]
fn brace<S: Simd>(
    strut: &PlacedStrut<S>,
    places: &[Vec<usize>; 2],
    motions: &[[Lane<S>; 6]; MOST],
    origin_m: &[Lane<S>; 3],
    stiffness: &mut [[Lane<S>; MOST]; MOST],
) {
    let [first, second] = &strut.points_m;
    let span = subtract(second, first);
    let inverse = dot(&span, &span).sqrt().inverse();
    let along = scale(&span, inverse);
    let tension = strut.force_n * inverse;
    let parts = |place: usize| {
        let [x, y, z, rx, ry, rz] = motions[place];
        ([x, y, z], [rx, ry, rz])
    };
    // Motion of the point of an end by a hinge.
    let moved = |end: usize, place: usize| {
        let (of_origin, axis) = parts(place);
        let mut moved = cross(&axis, &subtract(&strut.points_m[end], origin_m));
        for i in 0..3 {
            moved[i] += of_origin[i];
        }
        moved
    };
    for end in 0..2 {
        for (order, &a) in places[end].iter().enumerate() {
            let of_a = moved(end, a);
            let along_a = dot(&along, &of_a);
            // Both move the same end; `a` is nearer to the ground.
            for &b in &places[end][order..] {
                let of_b = moved(end, b);
                let along_b = dot(&along, &of_b);
                let straight = along_a * along_b;
                let mut entry = tension * (dot(&of_a, &of_b) - straight);
                entry = multiply_add(strut.stiffness_n_per_m, straight, entry);
                let bent = dot(&along, &cross(&parts(a).1, &of_b)) * strut.force_n;
                entry = if end == 0 { entry - bent } else { entry + bent };
                stiffness[a.min(b)][a.max(b)] += entry;
            }
            if end == 0 {
                for &b in &places[1] {
                    let of_b = moved(1, b);
                    let straight = along_a * dot(&along, &of_b);
                    let mut entry = tension * (straight - dot(&of_a, &of_b));
                    entry = multiply_subtract(strut.stiffness_n_per_m, straight, entry);
                    stiffness[a.min(b)][a.max(b)] += entry;
                }
            }
        }
    }
}
