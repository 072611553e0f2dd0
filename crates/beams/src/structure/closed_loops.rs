//! Loops of rigid members: freedoms that depend on others, and the factor of what is left.
//!
//! What closes a loop moves in two ways that must agree, six conditions C x = 0 a loop. They are solved for as many freedoms x_d as they
//! determine, x = N x_i; conditions that say what others say already (three in a plane) fall out. The independent freedoms have the
//! stiffness Nᵀ K N, whose softest entries come from the springs and beams of the whole loop by virtual work: of a four-bar linkage with
//! springs k_j about its joints, K = Σ k_j (∂q_j/∂q)². Of two freedoms the one that yields more becomes dependent, so that a rigid joint
//! stays exact.
//!
//! # Source
//! Transformation of constrained freedoms: Cook, Malkus, Plesha and Witt, Concepts and Applications of Finite Element Analysis (2002),
//! section 13.2, eqs. 13.2-1 to 13.2-4.

use faer::Mat;
use stiffbench_numeric::vector::{cross, norm, subtract};

use super::clusters::VertexColumn;
use super::parts::{Structure, StructureError};
use super::solve::LOST_PIVOT;
use super::topology::{HELD, Topology};

/// A condition that is left with less than this, of entries about one, says nothing: rounding of positions makes 1e-15.
const NOTHING_LEFT: f64 = 1e-11;

/// Singular values of a loop below this share of the largest count as zero: its joints lie in one line to a millionth of their distance.
const SINGULAR: f64 = 1e-6;

/// Displacements of all equations by independent motions of energy one: x = M Mᵀ f solves K x = f under the conditions.
#[derive(Debug, Clone, Default)]
pub(super) struct ConstrainedFactor {
    /// Row by row, as many columns as there are independent freedoms.
    motions: Vec<f64>,
    width: usize,
}

/// Motion of the sides of a loop against each other per unit of an equation, lengths in units of the structure's size.
type Condition = (usize, VertexColumn);

impl ConstrainedFactor {
    /// # Arguments
    /// - `stiffness`: of all equations, row by row, both triangles.
    ///
    /// # Returns
    /// The factor, and the least share that a pivot keeps of its diagonal entry.
    ///
    /// # Errors
    /// [`StructureError::SingularLoop`]; [`StructureError::Mechanism`].
    pub(super) fn of(
        topology: &Topology,
        structure: &Structure,
        stiffness: &[f64],
    ) -> Result<(Self, f64), StructureError> {
        let count = topology.equation_count;
        let size_m = size_m(structure);
        let closures = topology.clusters.closures.iter();
        let loops: Vec<Vec<Condition>> = closures
            .map(|&vertex| conditions(topology, structure, vertex, size_m))
            .collect();
        for conditions in &loops {
            refuse_singular(topology, structure, conditions)?;
        }
        let mut rows = vec![0.0; 6 * loops.len() * count];
        for (place, conditions) in loops.iter().enumerate() {
            for (equation, motion) in conditions {
                for (row, entry) in motion.iter().enumerate() {
                    rows[(6 * place + row) * count + equation] = *entry;
                }
            }
        }
        let softness: Vec<f64> = (0..count).map(|i| stiffness[i * count + i]).collect();
        let dependent = eliminate(&mut rows, count, &softness);
        let independent: Vec<usize> = (0..count)
            .filter(|equation| dependent.iter().all(|(own, _)| own != equation))
            .collect();
        let width = independent.len();
        let mut motions = vec![0.0; count * width];
        for (column, &equation) in independent.iter().enumerate() {
            motions[equation * width + column] = 1.0;
            for &(own, row) in &dependent {
                motions[own * width + column] = -rows[row * count + equation];
            }
        }
        let mut reduced = reduced(stiffness, &motions, count, width);
        let least = match factorise(&mut reduced, width) {
            Ok(least) => least,
            Err(loose) => {
                return Err(StructureError::Mechanism {
                    freedom: topology.freedom(independent[loose], structure),
                });
            }
        };
        for row in motions.chunks_exact_mut(width.max(1)) {
            forward(&reduced, row);
        }
        Ok((Self { motions, width }, least))
    }

    /// Solves for a right side in place.
    pub(super) fn solve(&self, right_side: &mut [f64]) {
        let mut shares = vec![0.0; self.width];
        let rows = || self.motions.chunks_exact(self.width.max(1));
        for (row, force) in rows().zip(right_side.iter()) {
            for (share, motion) in shares.iter_mut().zip(row) {
                *share += motion * force;
            }
        }
        right_side.fill(0.0);
        for (row, moved) in rows().zip(right_side) {
            *moved = row.iter().zip(&shares).map(|(m, share)| m * share).sum();
        }
    }
}

/// Largest extent of the nodes along an axis, m.
fn size_m(structure: &Structure) -> f64 {
    let first = structure.nodes.first().map_or([0.0; 3], |n| n.position_m);
    let extents = structure.nodes.iter();
    let extents = extents.map(|node| norm(subtract(node.position_m, first)));
    extents.fold(f64::MIN_POSITIVE, f64::max)
}

/// The conditions of a loop by equation; what moves both sides alike is left out.
fn conditions(
    topology: &Topology,
    structure: &Structure,
    vertex: usize,
    size_m: f64,
) -> Vec<Condition> {
    let mut found: Vec<Condition> = Vec::new();
    for (freedom, motion) in topology.clusters.conditions(structure, vertex) {
        let equation = topology.equation(freedom);
        let mut known = found.iter_mut();
        match known.find(|(own, _)| *own == equation) {
            _ if equation == HELD => {}
            Some((_, sum)) => {
                for (entry, more) in sum.iter_mut().zip(motion) {
                    *entry += more;
                }
            }
            None => found.push((equation, motion)),
        }
    }
    for (_, motion) in &mut found {
        for entry in &mut motion[..3] {
            *entry /= size_m;
        }
    }
    found.retain(|(_, motion)| motion.iter().any(|entry| entry.abs() > NOTHING_LEFT));
    found
}

/// Refuses a loop in a plane, or about a point, whose joints have fewer than three independent motions here.
///
/// Elsewhere such a loop has three: those of its joints and, as they turn, the brackets of each two.
fn refuse_singular(
    topology: &Topology,
    structure: &Structure,
    conditions: &[Condition],
) -> Result<(), StructureError> {
    let hinge = |equation: usize| {
        let mut all = topology.hinge_equations.iter();
        all.position(|known| *known == equation)
    };
    let hinges: Option<Vec<usize>> = conditions.iter().map(|(e, _)| hinge(*e)).collect();
    let (Some(hinges), true) = (hinges, conditions.len() > 2) else {
        return Ok(());
    };
    let mut motions: Vec<VertexColumn> = conditions.iter().map(|(_, motion)| *motion).collect();
    if rank(&motions) > 2 {
        return Ok(());
    }
    for i in 0..conditions.len() {
        for j in 0..i {
            motions.push(bracket(&conditions[i].1, &conditions[j].1));
        }
    }
    if rank(&motions) != 3 {
        return Ok(());
    }
    let mut joints: Vec<_> = hinges
        .iter()
        .map(|&hinge| structure.hinges[hinge].name.clone())
        .collect();
    joints.sort();
    joints.dedup();
    Err(StructureError::SingularLoop { joints })
}

/// Change of one motion as another moves it.
fn bracket(first: &VertexColumn, second: &VertexColumn) -> VertexColumn {
    let parts = |m: &VertexColumn| ([m[0], m[1], m[2]], [m[3], m[4], m[5]]);
    let ((v, w), (other_v, other_w)) = (parts(first), parts(second));
    let [x, y, z] = subtract(cross(w, other_v), cross(other_w, v));
    let [rx, ry, rz] = cross(w, other_w);
    [x, y, z, rx, ry, rz]
}

fn rank(motions: &[VertexColumn]) -> usize {
    let matrix = Mat::from_fn(6, motions.len(), |row, column| motions[column][row]);
    let Ok(values) = matrix.singular_values() else {
        return 0;
    };
    let largest = values.iter().copied().fold(0.0_f64, f64::max);
    let counted = values.iter().filter(|value| **value > SINGULAR * largest);
    counted.count()
}

/// Solves conditions for freedoms, the softest first; gives each dependent equation with the row that then holds it.
fn eliminate(rows: &mut [f64], count: usize, stiffness: &[f64]) -> Vec<(usize, usize)> {
    let row_count = rows.len().checked_div(count).unwrap_or(0);
    let mut dependent: Vec<(usize, usize)> = Vec::new();
    loop {
        let mut best: Option<(f64, usize, usize)> = None;
        for row in (0..row_count).filter(|row| dependent.iter().all(|(_, own)| own != row)) {
            for (equation, entry) in rows[row * count..(row + 1) * count].iter().enumerate() {
                if entry.abs() > NOTHING_LEFT {
                    // How much it yields under the same load; what nothing holds yields most.
                    let yields = entry * entry / stiffness[equation].max(f64::MIN_POSITIVE);
                    if best.is_none_or(|(most, ..)| yields > most) {
                        best = Some((yields, row, equation));
                    }
                }
            }
        }
        let Some((_, own, equation)) = best else {
            return dependent;
        };
        let pivot = rows[own * count + equation];
        let mut held = rows[own * count..(own + 1) * count].to_vec();
        for entry in &mut held {
            *entry /= pivot;
        }
        for (row, entries) in rows.chunks_exact_mut(count).enumerate() {
            let share = entries[equation];
            if row != own && share != 0.0 {
                for (entry, held) in entries.iter_mut().zip(&held) {
                    *entry -= share * held;
                }
                entries[equation] = 0.0;
            }
        }
        rows[own * count..(own + 1) * count].copy_from_slice(&held);
        dependent.push((equation, own));
    }
}

/// The stiffness of the independent freedoms, Nᵀ K N.
fn reduced(stiffness: &[f64], motions: &[f64], count: usize, width: usize) -> Vec<f64> {
    let mut products = vec![0.0; count * width];
    for i in 0..count {
        for j in (0..count).filter(|j| stiffness[i * count + j] != 0.0) {
            for column in 0..width {
                products[i * width + column] +=
                    stiffness[i * count + j] * motions[j * width + column];
            }
        }
    }
    let mut reduced = vec![0.0; width * width];
    for i in 0..count {
        for row in (0..width).filter(|row| motions[i * width + row] != 0.0) {
            for column in 0..width {
                reduced[row * width + column] +=
                    motions[i * width + row] * products[i * width + column];
            }
        }
    }
    reduced
}

/// Cholesky factor in the lower triangle, and the least share that a pivot keeps of its diagonal entry; the freedom that keeps none is an
/// error.
fn factorise(matrix: &mut [f64], width: usize) -> Result<f64, usize> {
    let mut least = 1.0_f64;
    for k in 0..width {
        let before = matrix[k * width + k];
        let square: f64 = (0..k).map(|j| matrix[k * width + j].powi(2)).sum();
        let pivot = before - square;
        let keeps = pivot > LOST_PIVOT * before && before > 0.0 && pivot.is_finite();
        if !keeps {
            return Err(k);
        }
        least = least.min(pivot / before);
        let root = pivot.sqrt();
        matrix[k * width + k] = root;
        for i in k + 1..width {
            let product: f64 = (0..k)
                .map(|j| matrix[i * width + j] * matrix[k * width + j])
                .sum();
            matrix[i * width + k] = (matrix[i * width + k] - product) / root;
        }
    }
    Ok(least)
}

/// Multiplies a row by L⁻ᵀ.
fn forward(factor: &[f64], row: &mut [f64]) {
    let width = row.len();
    for i in 0..width {
        let sum: f64 = (0..i).map(|j| factor[i * width + j] * row[j]).sum();
        row[i] = (row[i] - sum) / factor[i * width + i];
    }
}
