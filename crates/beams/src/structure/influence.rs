//! What a twist imposed in a joint does to a structure whose joints are otherwise rigid.
//!
//! A law in a joint (compliance, play, friction) adds one freedom, its twist φ. With the twists imposed as distortions of the rigid
//! structure, everything the law needs to know is in three small arrays, exact and free of the law itself:
//!
//! ```text
//!   motion of the end  u = C F + Σ_j m_j φ_j
//!   joint moment     τ_j = m_jᵀ F - Σ_l k_jl φ_l
//! ```
//!
//! C is the compliance of the rigid structure, m_j the motion of the end per twist (by reciprocity also the joint's moment per end
//! force and moment), k the moments that the structure sets against imposed twists; k is zero where the joint lies in no closed loop.
//!
//! # Source
//! Przemieniecki, Theory of Matrix Structural Analysis (1968), chapter 8 (initial strains); the reduction to the released
//! freedoms is the force method's.

use faer::Mat;
use faer::linalg::solvers::Solve;

use super::clusters::{Clusters, IndependentFreedom, VertexColumn};
use super::element::{Attachment, Element, global_matrix};
use super::parts::{Hinge, Structure, StructureError};
use super::solve::Solver;
use super::topology::HELD;
use stiffbench_numeric::vector::along6;

/// Right sides that a solver takes at once.
const AT_ONCE: usize = 6;

/// Compliance of a structure with rigid joints, and what twists imposed in its joints do.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RotationInfluence {
    /// Of the end, as [`Compliance6`](super::Compliance6): row = displacement or rotation, column = force or moment.
    pub compliance: [[f64; 6]; 6],
    /// For each hinge: displacement, m/rad, and rotation of the end per twist, which are also its moment per end force, N·m/N, and moment.
    pub levers: Vec<[f64; 6]>,
    /// Moment in hinge j against a twist in hinge l, N·m/rad: row j of as many columns as there are hinges.
    pub stiffness_nm_per_rad: Vec<f64>,
    /// Displacements of all equations per twist, one column a hinge; kept so that nothing is allocated from pose to pose.
    displacements: Vec<f64>,
}

impl RotationInfluence {
    /// Of something that gives way alike in x, y, z and has one joint with the same lever for each, in no closed loop.
    #[must_use]
    pub fn of_one_joint(compliance_m_per_n: f64, lever_m: f64) -> Self {
        Self {
            compliance: std::array::from_fn(|i| {
                let is_own = |j| i == j && i < 3;
                std::array::from_fn(|j| if is_own(j) { compliance_m_per_n } else { 0.0 })
            }),
            levers: vec![along6([lever_m; 3])],
            stiffness_nm_per_rad: vec![0.0],
            displacements: Vec::new(),
        }
    }

    /// Puts a spring in series with each hinge: levers and stiffness become those of the structure that yields by the springs.
    ///
    /// With D the compliances of the springs, τ = m F - k φ and φ = D τ + a further twist ψ give τ = (1 + k D)⁻¹ (m F - k ψ). The compliance
    /// of the end is left as it is.
    ///
    /// # Arguments
    /// - `rad_per_nm`: compliance of the spring of each hinge, zero for none; hinges beyond its end have none.
    pub(crate) fn yield_by(&mut self, rad_per_nm: &[f64]) {
        let count = self.levers.len();
        let stiffness = Mat::from_fn(count, count, |j, l| self.stiffness(j, l));
        let levers = Mat::from_fn(count, 6, |hinge, axis| self.levers[hinge][axis]);
        // k is positive semidefinite, so the eigenvalues of 1 + k D are one and more.
        let eased = Mat::from_fn(count, count, |j, l| {
            let spring = rad_per_nm.get(l).copied().unwrap_or(0.0);
            f64::from(u8::from(j == l)) + stiffness[(j, l)] * spring
        });
        let eased = eased.partial_piv_lu();
        let (levers, stiffness) = (eased.solve(&levers), eased.solve(&stiffness));
        for hinge in 0..count {
            self.levers[hinge] = std::array::from_fn(|axis| levers[(hinge, axis)]);
            for other in 0..count {
                self.stiffness_nm_per_rad[hinge * count + other] = stiffness[(hinge, other)];
            }
        }
    }

    /// Moment in hinge `j` against a unit twist in hinge `l`, N·m/rad.
    #[must_use]
    pub fn stiffness(&self, j: usize, l: usize) -> f64 {
        self.stiffness_nm_per_rad[j * self.levers.len() + l]
    }
}

impl Solver {
    /// Works out the influence of a twist in each hinge of `hinged`; the compliance is left as it is.
    ///
    /// # Errors
    /// [`StructureError::RigidLoop`] of `hinged`.
    ///
    /// # Arguments
    /// - `hinged`: the structure given to [`Solver::update`] with the hinges of interest before its own; only hinge axes and attachments are read.
    /// - `out`: overwritten; its memory is used again.
    pub fn rotation_influence(
        &mut self,
        hinged: &Structure,
        out: &mut RotationInfluence,
    ) -> Result<(), StructureError> {
        self.rotation_influence_of(hinged, |_| true, out)
    }

    /// The same of some hinges only; levers and stiffness of the others are zero.
    ///
    /// Each result has the same bytes, whichever others are computed.
    ///
    /// # Errors
    /// As [`Solver::rotation_influence`].
    pub fn rotation_influence_of(
        &mut self,
        hinged: &Structure,
        is_asked_for: impl Fn(usize) -> bool,
        out: &mut RotationInfluence,
    ) -> Result<(), StructureError> {
        let equations = self.topology.equation_count;
        let hinges = hinged.hinges.len();
        out.displacements.clear();
        out.displacements.resize(equations * hinges, 0.0);
        out.levers.clear();
        out.levers.resize(hinges, [0.0; 6]);
        let motions = Motions::of(hinged)?;
        self.distortion_loads(&motions, &is_asked_for, &mut out.displacements);
        let asked_for: Vec<usize> = (0..hinges).filter(|hinge| is_asked_for(*hinge)).collect();
        for together in asked_for.chunks(AT_ONCE) {
            let place = |hinge: usize| hinge * equations..(hinge + 1) * equations;
            for (column, &hinge) in together.iter().enumerate() {
                self.solution[place(column)].copy_from_slice(&out.displacements[place(hinge)]);
            }
            self.solve_in_place(together.len());
            for (column, &hinge) in together.iter().enumerate() {
                out.displacements[place(hinge)].copy_from_slice(&self.solution[place(column)]);
                let own = Motions::about(&motions.end, hinge);
                let end = self.topology.end;
                out.levers[hinge] = std::array::from_fn(|i| self.read(end, i, column) + own[i]);
            }
        }
        self.rotational_stiffness(&motions, is_asked_for, out);
        Ok(())
    }

    /// Loads that hold the freedoms against a unit twist in each hinge: -Σ Kₑ (motion of the ends behind it).
    fn distortion_loads(
        &self,
        motions: &Motions,
        is_asked_for: impl Fn(usize) -> bool,
        loads: &mut [f64],
    ) {
        let equations = self.topology.equation_count;
        for (index, ends) in motions.elements.iter().enumerate() {
            let mut hinges = ends.iter().flatten();
            if !hinges.any(|(hinge, _)| is_asked_for(*hinge)) {
                continue;
            }
            let matrix = global_matrix(
                &self.axes[index],
                self.lengths_m[index],
                &self.natural[index],
            );
            for (end, moved) in ends.iter().enumerate() {
                for (hinge, motion) in moved.iter().filter(|(hinge, _)| is_asked_for(*hinge)) {
                    let forces = matrix.map(|row| row_times(&row, end, motion));
                    let loads = &mut loads[hinge * equations..(hinge + 1) * equations];
                    self.subtract_forces(index, &forces, loads);
                }
            }
        }
    }

    /// Subtracts forces on the twelve end freedoms of an element from a right side.
    fn subtract_forces(&self, element: usize, forces: &[f64; 12], right_side: &mut [f64]) {
        let map = &self.topology.elements[element];
        if map.columns.is_empty() {
            for (force, &equation) in forces.iter().zip(&map.equations) {
                if equation != HELD {
                    right_side[equation] -= force;
                }
            }
        }
        for (&(end, column), &equation) in map.columns.iter().zip(&map.equations) {
            let moved = &self.columns[map.vertices[end]][column];
            let work = moved
                .iter()
                .zip(&forces[6 * end..])
                .map(|(share, force)| share * force);
            right_side[equation] -= work.sum::<f64>();
        }
    }

    /// Moments against the twists: ends behind each hinge, in the displaced structure.
    fn rotational_stiffness(
        &self,
        motions: &Motions,
        is_asked_for: impl Fn(usize) -> bool,
        out: &mut RotationInfluence,
    ) {
        let equations = self.topology.equation_count;
        let hinges = out.levers.len();
        out.stiffness_nm_per_rad.clear();
        out.stiffness_nm_per_rad.resize(hinges * hinges, 0.0);
        for (index, moved) in motions.elements.iter().enumerate() {
            let mut behind = moved.iter().flatten();
            if !behind.any(|(hinge, _)| is_asked_for(*hinge)) {
                continue;
            }
            let matrix = global_matrix(
                &self.axes[index],
                self.lengths_m[index],
                &self.natural[index],
            );
            for imposed in (0..hinges).filter(|hinge| is_asked_for(*hinge)) {
                let column = &out.displacements[imposed * equations..(imposed + 1) * equations];
                let mut ends = self.end_motions(index, column);
                for (end, moved) in moved.iter().enumerate() {
                    let own = Motions::about(moved, imposed);
                    for (value, share) in ends[6 * end..].iter_mut().zip(own) {
                        *value += share;
                    }
                }
                for (end, moved) in moved.iter().enumerate() {
                    for (hinge, motion) in moved.iter().filter(|(h, _)| is_asked_for(*h)) {
                        let moment: f64 = (0..6)
                            .filter(|&component| motion[component] != 0.0)
                            .map(|component| {
                                let row = &matrix[6 * end + component];
                                let sum: f64 = row.iter().zip(&ends).map(|(k, u)| k * u).sum();
                                motion[component] * sum
                            })
                            .sum();
                        out.stiffness_nm_per_rad[hinge * hinges + imposed] += moment;
                    }
                }
            }
        }
    }
}

/// The error for a twist in a structure with loops of rigid members.
fn rigid_loop(structure: &Structure, clusters: &Clusters) -> StructureError {
    let closing = clusters.closures.iter();
    let hinges = closing.flat_map(|&vertex| &clusters.vertices[vertex].hinges);
    let mut joints: Vec<_> = hinges
        .map(|&hinge| structure.hinges[hinge].name.clone())
        .collect();
    joints.dedup();
    StructureError::RigidLoop { joints }
}

/// Product of a row over twelve end freedoms with a motion of one end.
fn row_times(row: &[f64; 12], end: usize, motion: &VertexColumn) -> f64 {
    let products = row[6 * end..].iter().zip(motion);
    products.fold(0.0, |sum, (entry, share)| sum + entry * share)
}

/// How the ends of elements and the end of a structure move per unit of each hinge.
struct Motions {
    /// By element and end: hinge and motion.
    elements: Vec<[Vec<(usize, VertexColumn)>; 2]>,
    end: Vec<(usize, VertexColumn)>,
}

impl Motions {
    fn of(structure: &Structure) -> Result<Self, StructureError> {
        // Without rigid members nothing moves but what hangs behind the hinge itself.
        let direct = |at: &Attachment| {
            let hinges = at.hinges.iter();
            let moved = hinges.map(|&hinge| {
                let Hinge {
                    axis: [x, y, z],
                    slides,
                    ..
                } = structure.hinges[hinge];
                let motion = if slides {
                    [x, y, z, 0.0, 0.0, 0.0]
                } else {
                    [0.0, 0.0, 0.0, x, y, z]
                };
                (hinge, motion)
            });
            moved.collect()
        };
        if structure.rigid_members.is_empty() {
            let ends = structure.elements.iter().map(|element| &element.ends);
            return Ok(Self {
                elements: ends.map(|[a, b]| [direct(a), direct(b)]).collect(),
                end: direct(&structure.end),
            });
        }
        let clusters = Clusters::new(structure)?;
        if !clusters.closures.is_empty() {
            return Err(rigid_loop(structure, &clusters));
        }
        let vertex = |at: &Attachment| clusters.vertex(at).unwrap_or(at.node);
        let after = |vertex: usize, skipped: usize| {
            let columns = clusters.columns(structure, vertex);
            let all = clusters.freedoms(vertex).zip(columns).skip(skipped);
            let of_hinges = all.filter_map(|(freedom, column)| match freedom {
                IndependentFreedom::OfHinge(hinge) => Some((hinge, column)),
                IndependentFreedom::OfNode(..) => None,
            });
            of_hinges.collect()
        };
        let of_element = |element: &Element| {
            let ends = [vertex(&element.ends[0]), vertex(&element.ends[1])];
            let shared = clusters.shared(ends);
            ends.map(|vertex| after(vertex, shared))
        };
        Ok(Self {
            elements: structure.elements.iter().map(of_element).collect(),
            end: after(vertex(&structure.end), 0),
        })
    }

    /// The motion by one hinge.
    fn about(moved: &[(usize, VertexColumn)], hinge: usize) -> VertexColumn {
        let mut own = moved.iter();
        let own = own.find(|(known, _)| *known == hinge);
        own.map_or([0.0; 6], |(_, motion)| *motion)
    }
}
