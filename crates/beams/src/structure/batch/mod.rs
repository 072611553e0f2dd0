//! End compliance of one structure in many poses at once.
//!
//! The poses stand side by side as the lanes of every number, so that one vector instruction does the same step in up to eight of them.
//! What makes the rest of the speed is exact as well. Elimination works on blocks in order of least degree; the end, where all
//! loads act, comes last, so its compliance needs no back-substitution. A node has two blocks of three freedoms: its motion in the
//! plane that most elements share, and that across it. Elements in the plane couple like with like only, which leaves a
//! quarter of the work in a plane structure, and about half in a robot with a plane arm on a floor linkage.
//!
//! Decision: this solver serves only structures without hinges whose nodes are wholly free or wholly held, and does not say what
//! is wrong with a pose it cannot solve. [`Solver`](super::Solver) does both; whoever uses this one falls back on it.

#![expect(
    clippy::inline_always,
    reason = "what is not inlined into a kernel is compiled for another instruction set, and calls its instructions one by one"
)]

mod bundle;
mod elimination;
mod general;
mod in_plane;
mod plan;
mod poses;
mod rigidity;
mod solve;

use plan::serves;
use poses::{Batch, Lanes};
use stiffbench_numeric::lanes::InstructionSet;

use super::compliance::Compliance6;
use super::parts::{Structure, StructureError};
use super::topology::check_indices;

/// Solver of one structure in a fixed number of poses; allocates nothing after it was made.
///
/// Elements belong to groups, whose section constants are multiplied together: [`BatchSolver::solve`] takes the multipliers,
/// and [`BatchSolver::derivatives`] are sums over a group.
///
/// The results of a pose do not depend on the other poses or on their number. They depend on the instruction set of the machine, by
/// the rounding of fused products.
#[derive(Debug)]
pub struct BatchSolver {
    lanes: Box<dyn Lanes>,
    pose_count: usize,
}

/// What a batch is told of an element besides the structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct ElementRole {
    /// Its group, counted from zero without gaps.
    pub group: usize,
    /// A number that elements share if their local y is expected to be the normal of one plane in every pose. Where it turns out
    /// not to be, the pose is solved more slowly, not wrongly.
    pub plane: usize,
}

impl BatchSolver {
    /// Prepares for `pose_count` poses of a structure.
    ///
    /// # Arguments
    /// - `structure`: connections, sections, materials; its positions are not read.
    /// - `roles`: one an element.
    ///
    /// # Returns
    /// `None` if the structure needs [`Solver`](super::Solver): a hinge, a node held in part, a held end.
    ///
    /// # Errors
    /// [`StructureError::UnknownIndex`] for a reference that points nowhere.
    ///
    /// # Panics
    /// If there is not one role an element.
    pub fn new(
        structure: &Structure,
        roles: &[ElementRole],
        pose_count: usize,
    ) -> Result<Option<Self>, StructureError> {
        let instructions = InstructionSet::for_poses(pose_count);
        Self::with(structure, roles, pose_count, instructions)
    }

    fn with(
        structure: &Structure,
        roles: &[ElementRole],
        pose_count: usize,
        instructions: InstructionSet,
    ) -> Result<Option<Self>, StructureError> {
        assert_eq!(roles.len(), structure.elements.len(), "one role an element");
        check_indices(structure)?;
        if !serves(structure) {
            return Ok(None);
        }
        let lanes: Box<dyn Lanes> = match instructions {
            InstructionSet::Plain(set) => Box::new(Batch::new(set, structure, roles, pose_count)),
            #[cfg(target_arch = "aarch64")]
            InstructionSet::Neon(set) => Box::new(Batch::new(set, structure, roles, pose_count)),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx2(set) => Box::new(Batch::new(set, structure, roles, pose_count)),
            #[cfg(target_arch = "x86_64")]
            InstructionSet::Avx512(set) => Box::new(Batch::new(set, structure, roles, pose_count)),
        };
        Ok(Some(Self { lanes, pose_count }))
    }

    /// Number of poses it has room for.
    #[must_use]
    pub fn pose_count(&self) -> usize {
        self.pose_count
    }

    /// Takes the positions and axes of `structure` as pose number `pose`; sections and materials stay those of [`BatchSolver::new`].
    ///
    /// # Panics
    /// If `pose` is out of range, or the structure has other numbers of nodes or elements than the one this solver was made for.
    pub fn place(&mut self, pose: usize, structure: &Structure) {
        assert!(pose < self.pose_count, "pose {pose} of {}", self.pose_count);
        self.lanes.place(pose, structure);
    }

    /// Takes the derivatives in pose number `pose` along these unit vectors instead of x, y, z, from the next solution on.
    ///
    /// # Panics
    /// If `pose` is out of range.
    pub fn differentiate_along(&mut self, pose: usize, units: &[[f64; 3]; 3]) {
        assert!(pose < self.pose_count, "pose {pose} of {}", self.pose_count);
        self.lanes.differentiate_along(pose, units);
    }

    /// Solves every placed pose.
    ///
    /// # Arguments
    /// - `multipliers`: for each group those of A, Iy, Iz, J.
    /// - `derivatives`: whether [`BatchSolver::derivatives`] will be asked for; adds a third to the work.
    ///
    /// # Panics
    /// If a group has no multipliers.
    pub fn solve(&mut self, multipliers: &[[f64; 4]], derivatives: bool) {
        self.lanes.solve(multipliers, derivatives);
    }

    /// Whether the last solution of a pose is good.
    ///
    /// It is not if the pose was never placed, an element has no length or plane, a constant is negative or not finite, or a pivot
    /// keeps so little of its diagonal entry that the structure moves there. [`Solver::update`](super::Solver::update) says which.
    #[must_use]
    pub fn is_solved(&self, pose: usize) -> bool {
        self.lanes.is_solved(pose)
    }

    /// Compliance of the end in a pose that [`BatchSolver::is_solved`].
    #[must_use]
    pub fn end_compliance(&self, pose: usize) -> Compliance6 {
        self.lanes.compliance(pose)
    }

    /// Displacement along `axis` per force along it, m/N.
    #[must_use]
    pub fn direct_compliance(&self, pose: usize, axis: usize) -> f64 {
        self.lanes.direct_compliance(pose, axis)
    }

    /// Derivatives of the direct compliance along `axis` (0 to 2; another direction after [`BatchSolver::differentiate_along`]) to the logarithms of A, Iy, Iz, J of all elements of a group, m/N.
    ///
    /// Exact, -uᵀ ∂K/∂ln p u; over all groups and properties they add up to minus the compliance. Zero for a group without
    /// elements, and if the last solution was not asked for them.
    #[must_use]
    pub fn derivatives(&self, pose: usize, axis: usize, group: usize) -> [f64; 4] {
        self.lanes.derivatives(pose, axis, group)
    }
}

#[cfg(test)]
mod tests;
