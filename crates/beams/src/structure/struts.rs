//! Springs between two points that already pull or push: what they resist as the structure moves.
//!
//! With V the energy of a spring of length L, force F = V' and stiffness k = V'', the freedoms i and j of its ends feel
//!
//! ```text
//!   K_ij = k g_i g_j + F/L (d_i · d_j - g_i g_j) + F s · ∂²(p₂ - p₁)/∂i∂j,        g_i = s · d_i
//! ```
//!
//! s the unit vector from the first point p₁ to the second p₂, d_i the motion of p₂ against p₁ per unit of i. In an arm the second
//! derivative is that of the joint nearer to the ground, its axis × the motion by the other, so that K is the derivative of the torques.
//!
//! # Source
//! Second derivative of the potential energy: Goldstein, Classical Mechanics (1980), section 6.1; of a bar under tension: Cook, Malkus, Plesha
//! and Witt, Concepts and Applications of Finite Element Analysis (2002), section 18.2.

use stiffbench_numeric::vector::{cross, dot, norm, scale, subtract};

use super::clusters::{Clusters, IndependentFreedom};
use super::element::Attachment;
use super::parts::{Structure, Strut};

/// How a freedom moves the ends of a strut.
struct StrutMotion {
    end: usize,
    /// Unit of turn; zero of a freedom that slides.
    axis: [f64; 3],
    /// Of the point.
    moved: [f64; 3],
}

fn add(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] + b[i])
}

/// Freedoms of a strut, by end and column; those that move both ends alike are left out.
pub(super) fn strut_columns(
    clusters: &Clusters,
    ends: &[Option<Attachment>; 2],
) -> Vec<(usize, usize)> {
    let vertex = |end: usize| clusters.vertex(ends[end].as_ref()?);
    let vertices = [vertex(0), vertex(1)];
    let shared = match vertices {
        [Some(first), Some(second)] => clusters.shared([first, second]),
        _ => 0,
    };
    let of_end = |end: usize| {
        let count = vertices[end].map_or(0, |vertex| clusters.freedoms(vertex).count());
        (shared..count).map(move |column| (end, column))
    };
    of_end(0).chain(of_end(1)).collect()
}

impl Strut {
    /// Its freedoms, by end.
    pub(super) fn freedoms(
        &self,
        clusters: &Clusters,
        columns: &[(usize, usize)],
    ) -> Vec<IndependentFreedom> {
        let freedom = |&(end, column): &(usize, usize)| {
            let vertex = clusters.vertex(self.ends[end].as_ref()?)?;
            clusters.freedoms(vertex).nth(column)
        };
        columns.iter().filter_map(freedom).collect()
    }

    /// Stiffness over its freedoms, row by row.
    pub(super) fn stiffness(
        &self,
        structure: &Structure,
        clusters: &Clusters,
        columns: &[(usize, usize)],
    ) -> Vec<f64> {
        let span_m = subtract(self.points_m[1], self.points_m[0]);
        let length_m = norm(span_m);
        let along = scale(span_m, 1.0 / length_m);
        let mut motions: Vec<StrutMotion> = Vec::with_capacity(columns.len());
        for end in 0..2 {
            let at = self.ends[end].as_ref();
            let Some(vertex) = at.and_then(|at| clusters.vertex(at)) else {
                continue;
            };
            let node = clusters.vertices[vertex].node;
            let arm = subtract(self.points_m[end], structure.nodes[node].position_m);
            let all: Vec<[f64; 6]> = clusters.columns(structure, vertex).collect();
            for &(_, column) in columns.iter().filter(|(own, _)| *own == end) {
                let [x, y, z, rx, ry, rz] = all[column];
                let axis = [rx, ry, rz];
                motions.push(StrutMotion {
                    end,
                    axis,
                    moved: add([x, y, z], cross(axis, arm)),
                });
            }
        }
        let sign = |motion: &StrutMotion| if motion.end == 0 { -1.0 } else { 1.0 };
        let entry = |first: usize, second: usize| {
            let (a, b) = (&motions[first], &motions[second]);
            let [g, h] = [a, b].map(|m| sign(m) * dot(along, m.moved));
            let across = sign(a) * sign(b) * dot(a.moved, b.moved) - g * h;
            let mut sum = self.stiffness_n_per_m * g * h + self.force_n / length_m * across;
            if a.end == b.end {
                let turned = |near: &StrutMotion, far: &StrutMotion| cross(near.axis, far.moved);
                // The three turns of a node have no order: the mean of both.
                let of_node = columns[second].1 < 6;
                let bent = if of_node {
                    scale(add(turned(a, b), turned(b, a)), 0.5)
                } else {
                    turned(a, b)
                };
                sum += self.force_n * sign(a) * dot(along, bent);
            }
            sum
        };
        let count = motions.len();
        let pairs = (0..count).flat_map(|i| (0..count).map(move |j| (i.min(j), i.max(j))));
        pairs.map(|(first, second)| entry(first, second)).collect()
    }
}
