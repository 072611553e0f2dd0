//! What a twist imposed in a joint does to a structure whose joints are otherwise rigid.
//!
//! A law in a joint (compliance, play, friction) adds one freedom, its twist φ. With the twists imposed as distortions of the rigid
//! structure, everything the law needs to know is in three small arrays, exact and free of the law itself:
//!
//! ```text
//!   end displacement   u = C F + Σ_j m_j φ_j
//!   joint moment     τ_j = m_jᵀ F - Σ_l k_jl φ_l
//! ```
//!
//! C is the compliance of the rigid structure, m_j the end displacement per twist (by reciprocity also the joint's moment per end
//! force), k the moments that the structure sets against imposed twists; k is zero where the joint lies in no closed loop.
//!
//! # Source
//! Przemieniecki, Theory of Matrix Structural Analysis (1968), chapter 8 (initial strains); the reduction to the released
//! freedoms is the force method's.

use faer::Mat;
use faer::linalg::solvers::Solve;
use stiffbench_numeric::vector::dot;

use super::element::global_matrix;
use super::parts::Structure;
use super::solve::Solver;
use super::topology::HELD;

/// Right sides that a solver takes at once.
const AT_ONCE: usize = 6;

/// Compliance of a structure with rigid joints, and what twists imposed in its joints do.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct RotationInfluence {
    /// Displacement per force of the end, m/N: row = displacement, column = force.
    pub compliance_m_per_n: [[f64; 3]; 3],
    /// For each hinge: displacement of the end per twist, m/rad, which is also its moment per end force, N·m/N.
    pub levers_m: Vec<[f64; 3]>,
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
            compliance_m_per_n: std::array::from_fn(|i| {
                std::array::from_fn(|j| if i == j { compliance_m_per_n } else { 0.0 })
            }),
            levers_m: vec![[lever_m; 3]],
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
    /// - `rad_per_nm`: compliance of the spring of each hinge, zero for none.
    pub(crate) fn yield_by(&mut self, rad_per_nm: &[f64]) {
        let count = self.levers_m.len();
        let stiffness = Mat::from_fn(count, count, |j, l| self.stiffness(j, l));
        let levers = Mat::from_fn(count, 3, |hinge, axis| self.levers_m[hinge][axis]);
        // k is positive semidefinite, so the eigenvalues of 1 + k D are one and more.
        let eased = Mat::from_fn(count, count, |j, l| {
            f64::from(u8::from(j == l)) + stiffness[(j, l)] * rad_per_nm[l]
        });
        let eased = eased.partial_piv_lu();
        let (levers, stiffness) = (eased.solve(&levers), eased.solve(&stiffness));
        for hinge in 0..count {
            self.levers_m[hinge] = [0, 1, 2].map(|axis| levers[(hinge, axis)]);
            for other in 0..count {
                self.stiffness_nm_per_rad[hinge * count + other] = stiffness[(hinge, other)];
            }
        }
    }

    /// Moment in hinge `j` against a unit twist in hinge `l`, N·m/rad.
    #[must_use]
    pub fn stiffness(&self, j: usize, l: usize) -> f64 {
        self.stiffness_nm_per_rad[j * self.levers_m.len() + l]
    }
}

impl Solver {
    /// Works out the influence of a twist in each hinge of `hinged`; the compliance is left as it is.
    ///
    /// # Arguments
    /// - `rigid`: the structure given to [`Solver::update`], which has no hinges.
    /// - `hinged`: the same structure with the hinges of interest; only its hinge axes and attachments are read.
    /// - `out`: overwritten; its memory is used again.
    pub fn rotation_influence(
        &mut self,
        rigid: &Structure,
        hinged: &Structure,
        out: &mut RotationInfluence,
    ) {
        self.rotation_influence_of(rigid, hinged, |_| true, out);
    }

    /// The same of some hinges only; levers and stiffness of the others are zero.
    ///
    /// Each result has the same bytes, whichever others are computed.
    pub fn rotation_influence_of(
        &mut self,
        rigid: &Structure,
        hinged: &Structure,
        is_asked_for: impl Fn(usize) -> bool,
        out: &mut RotationInfluence,
    ) {
        let equations = self.topology.equation_count;
        let hinges = hinged.hinges.len();
        out.displacements.clear();
        out.displacements.resize(equations * hinges, 0.0);
        out.levers_m.clear();
        out.levers_m.resize(hinges, [0.0; 3]);
        self.distortion_loads(hinged, &is_asked_for, &mut out.displacements);
        let asked_for: Vec<usize> = (0..hinges).filter(|hinge| is_asked_for(*hinge)).collect();
        for together in asked_for.chunks(AT_ONCE) {
            let place = |hinge: usize| hinge * equations..(hinge + 1) * equations;
            for (column, &hinge) in together.iter().enumerate() {
                self.solution[place(column)].copy_from_slice(&out.displacements[place(hinge)]);
            }
            self.solve_in_place(together.len());
            for (column, &hinge) in together.iter().enumerate() {
                out.displacements[place(hinge)].copy_from_slice(&self.solution[place(column)]);
                let end = &self.topology.end;
                out.levers_m[hinge] = std::array::from_fn(|i| self.read(rigid, end, i, column));
            }
        }
        self.rotational_stiffness(hinged, is_asked_for, out);
    }

    /// Loads that hold the nodes' freedoms against a unit twist in each hinge: -Σ Kₑ (axis at the ends behind it).
    fn distortion_loads(
        &self,
        hinged: &Structure,
        is_asked_for: impl Fn(usize) -> bool,
        loads: &mut [f64],
    ) {
        let equations = self.topology.equation_count;
        for (index, element) in hinged.elements.iter().enumerate() {
            let mut hinges = element.ends.iter().flat_map(|end| &end.hinges);
            if !hinges.any(|hinge| is_asked_for(*hinge)) {
                continue;
            }
            let matrix = global_matrix(
                &self.axes[index],
                self.lengths_m[index],
                &self.natural[index],
            );
            for (end, attachment) in element.ends.iter().enumerate() {
                for &hinge in attachment.hinges.iter().filter(|h| is_asked_for(**h)) {
                    let axis = hinged.hinges[hinge].axis;
                    for (row, &equation) in
                        matrix.iter().zip(&self.topology.elements[index].equations)
                    {
                        if equation != HELD {
                            let start = 6 * end + 3;
                            loads[hinge * equations + equation] -=
                                dot(axis, [row[start], row[start + 1], row[start + 2]]);
                        }
                    }
                }
            }
        }
    }

    /// Moments against the twists: ends behind each hinge, in the displaced structure.
    fn rotational_stiffness(
        &self,
        hinged: &Structure,
        is_asked_for: impl Fn(usize) -> bool,
        out: &mut RotationInfluence,
    ) {
        let equations = self.topology.equation_count;
        let hinges = hinged.hinges.len();
        out.stiffness_nm_per_rad.clear();
        out.stiffness_nm_per_rad.resize(hinges * hinges, 0.0);
        for (index, element) in hinged.elements.iter().enumerate() {
            let mut behind = element.ends.iter().flat_map(|end| &end.hinges);
            if !behind.any(|hinge| is_asked_for(*hinge)) {
                continue;
            }
            let matrix = global_matrix(
                &self.axes[index],
                self.lengths_m[index],
                &self.natural[index],
            );
            for imposed in (0..hinges).filter(|hinge| is_asked_for(*hinge)) {
                let column = &out.displacements[imposed * equations..(imposed + 1) * equations];
                let mut ends = [0.0; 12];
                for (value, &equation) in ends
                    .iter_mut()
                    .zip(&self.topology.elements[index].equations)
                {
                    if equation != HELD {
                        *value = column[equation];
                    }
                }
                for (end, attachment) in element.ends.iter().enumerate() {
                    if attachment.hinges.contains(&imposed) {
                        for (component, share) in hinged.hinges[imposed].axis.iter().enumerate() {
                            ends[6 * end + 3 + component] += share;
                        }
                    }
                }
                for (end, attachment) in element.ends.iter().enumerate() {
                    for &hinge in attachment.hinges.iter().filter(|h| is_asked_for(**h)) {
                        let axis = hinged.hinges[hinge].axis;
                        let moment: f64 = (0..3)
                            .map(|component| {
                                let row = &matrix[6 * end + 3 + component];
                                let sum: f64 = row.iter().zip(&ends).map(|(k, u)| k * u).sum();
                                axis[component] * sum
                            })
                            .sum();
                        out.stiffness_nm_per_rad[hinge * hinges + imposed] += moment;
                    }
                }
            }
        }
    }
}
